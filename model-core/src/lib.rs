//! The contact force of a Fin-Ray finger from its motor angle: a discrete Cosserat-rod model with a Newton solver.
//!
//! A finger of two flexible beams, rigid lamellae and flexible hinges is turned into an object. Its equilibrium minimises
//! the elastic energy
//!
//! > V(θ) = ½ Σ EI/ℓ (θᵢ − θᵢ₋₁)²  subject to loop closures h(θ) = 0 and gaps g(θ) ≥ 0,
//!
//! and the contact force is the multiplier of the gap. `no_std`, no allocation, no `unsafe`; in `f32` or `f64`.
//!
//! ```
//! use model_core::design::{Attachments, Beam, Design, Hinge, HingeFrom, HingeKind, Lamellae, Material, MaterialLaw, PlaneStrain, Profile};
//! use model_core::discretise::{Discretisation, Physics};
//! use model_core::estimator::Estimator;
//! use model_core::object::ObjectDesign;
//! use model_core::size::Reduced;
//! use model_core::status::Status;
//!
//! let beam = |base| Beam::straight(base, [0.0, 80.0], Profile::constant(2.0));
//! let design = Design {
//!     width: Profile::constant(20.0),
//!     plane_strain: PlaneStrain::Stress,
//!     material: Material { youngs_modulus: 49.5, poissons_ratio: 0.48, law: MaterialLaw::default() },
//!     front: beam([0.0, 0.0]),
//!     back: beam([-28.0, 0.0]),
//!     lamellae: Lamellae::rigid(Attachments::Heights((1..=7).map(|k| 9.0 * f64::from(k)).collect()), 3.0),
//!     hinge: Hinge {
//!         kind: HingeKind::Flexible,
//!         length: [2.5].into_iter().collect(),
//!         thickness: 0.8,
//!         from: HingeFrom::Centreline,
//!     },
//!     rigid_above: None,
//!     motor_axis: [-14.0, -20.0],
//! };
//! let mut estimator: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
//! estimator.configure(&design, &Discretisation::estimator(Physics::Extended))?;
//! estimator.set_object(ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 })?;
//!
//! // One count of the servo's position sensor per tick, from an open finger to 6°.
//! let count = std::f64::consts::TAU / 4096.0;
//! assert_eq!(estimator.update(-count).status, Status::NoContact);
//! for tick in 0..=68 {
//!     estimator.update(f64::from(tick) * count);
//! }
//! let estimate = estimator.update(68.0 * count);
//! assert_eq!(estimate.status, Status::Converged);
//! assert!((estimate.force_magnitude() - 3.78).abs() < 0.01, "{estimate:?}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The mathematics
//!
//! [`derivation`] has all of it, with numbered equations, the table of symbols, and frames and signs. In short:
//!
//! - Unknowns are absolute changes of orientation θ of links or quadratic elements. Members share the angles at their joints, so
//!   only positions are left to close: h_k = 0 per cell, with multipliers λ_k.
//! - An equilibrium is a stationary point of L = V + Σ λ_k·h_k − Σ μ_j g_j − ½ ε_c Σ μ_j² with μ_j ≥ 0, g_j + ε_c μ_j ≥ 0 and one of
//!   them zero at every contact sample. Stretch and shear are eliminated node by node.
//! - A Newton step condenses each member onto its joints and force, factorises the banded KKT matrix as L D Lᵀ, borders it by the
//!   contact rows and settles their active set. Its cost is linear in elements and lamellae.
//! - The pivots' signs say whether the equilibrium is stable. Only converged and stable ones are accepted.
//! - A motion is followed in steps. Where a branch folds, an overdamped motion leads to the next one, flagged as snapped.
//!
//! # The modules
//!
//! Each uses those above it in this list only:
//!
//! 1. [`size`], [`real`], `access`, [`bounds`], [`status`]: capacities, scalars, access that cannot panic, ranges of settings, how a solve can
//!    end; and `linear`: dense and banded algebra, which knows no finger.
//! 2. [`design`]: what a person describes, validated.
//! 3. [`object`], [`units`]: shapes to grasp and their motion; the finger's own units.
//! 4. [`contact`]: samples, rows of the contact border and the law that decides on them.
//! 5. `topology`: members, joints and closures as data. `element`: what a force does to a member, in two implementations.
//! 6. [`model`]: all that does not change while a motion is followed. `places`: where gaps are checked. `state`: what does change.
//! 7. [`discretise`]: from the design to the model.
//! 8. [`newton`]: one step, stage by stage.
//! 9. [`solution`]: what can be read off an equilibrium.
//! 10. [`equilibrium`]: continuation, stability, folds.
//! 11. [`sensitivity`], [`uncertainty`], [`fading`], [`drive`], [`estimator`], [`grasp`], [`identify`]: users of the follower.
//!
//! Between [`discretise`] and what is read off an equilibrium the solver computes in the finger's own [`units`]. Outside, units are mm, N,
//! N·mm, rad, MPa; frames and signs are defined in [`derivation`].

#![no_std]
#[cfg(test)]
#[macro_use]
extern crate std;
#[cfg(all(feature = "random", not(test)))]
extern crate std;

mod access;
pub mod bounds;
pub mod contact;
#[doc = include_str!("derivation.md")]
pub mod derivation {}
pub mod design;
pub mod discretise;
pub mod drive;
#[cfg(test)]
mod elastica;
mod element;
pub mod equilibrium;
pub mod estimator;
pub mod fading;
pub mod grasp;
pub mod identify;
mod linear;
pub mod model;
pub mod newton;
pub mod object;
mod places;
#[cfg(any(test, feature = "random"))]
pub mod random_designs;
pub mod real;
pub mod sensitivity;
pub mod size;
pub mod solution;
mod state;
pub mod status;
mod topology;
pub mod uncertainty;
pub mod units;
