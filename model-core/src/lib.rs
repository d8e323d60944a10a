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
//! let beam = |base| Beam { base, tip: [0.0, 80.0], sagitta: 0.0, thickness: Profile::constant(2.0), stiffness_factor: 1.0 };
//! let design = Design {
//!     width: Profile::constant(20.0),
//!     plane_strain: PlaneStrain::Stress,
//!     material: Material { youngs_modulus: 49.5, poissons_ratio: 0.48, law: MaterialLaw::default() },
//!     front: beam([0.0, 0.0]),
//!     back: beam([-28.0, 0.0]),
//!     lamellae: Lamellae {
//!         attachments: Attachments::Heights((1..=7).map(|k| 9.0 * f64::from(k)).collect()),
//!         thickness: 3.0,
//!     },
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
//! estimator.configure(&design, &Discretisation::estimator(Physics::Paper))?;
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
//! assert!((estimate.force_magnitude() - 4.26).abs() < 0.01, "{estimate:?}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Data flow, each module knowing only those above it: [`design`] → [`discretise`] → [`ladder`] (kinematics, energy) →
//! [`contact`] and [`object`] → [`newton`] (one step) → [`equilibrium`] (continuation, stability, folds; what can be read off) → [`sensitivity`],
//! [`uncertainty`], [`estimator`], [`grasp`]. Units are mm, N, N·mm, rad, MPa; frames and signs are defined at [`object::Motion`] and
//! [`equilibrium::Follower`].

#![no_std]
#[cfg(test)]
#[macro_use]
extern crate std;
#[cfg(all(feature = "random", not(test)))]
extern crate std;

pub mod contact;
pub mod design;
pub mod discretise;
#[cfg(test)]
mod elastica;
pub mod equilibrium;
pub mod estimator;
pub mod grasp;
pub mod ladder;
pub mod newton;
pub mod object;
#[cfg(any(test, feature = "random"))]
pub mod random_designs;
pub mod real;
pub mod sensitivity;
pub mod size;
pub mod status;
pub mod uncertainty;
