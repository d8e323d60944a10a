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
//! **Discretisation** ([`discretise`]). Beams and hinges are chains of rigid links between joints. The unknowns are absolute changes of
//! orientation θ, so the end of a chain is a sum, D = Σ lᵢ e(βᵢ + θᵢ) with e(a) = (cos a, sin a), and the bending energy
//! ½ Σ EI/ℓ (θᵢ − θᵢ₋₁)² is a quadratic form ½ θᵀKθ with a constant, banded K. The members of a lamella share its three angles, so
//! only positions are left to close: per cell k, h_k = Dᶠ_k + R_k − Dᵇ_k − R_{k−1} − const = 0, with the front and back spans D
//! and the rungs R (front hinge, lamella, back hinge). `paper` is of first order, `trapezoid` of second, `simpson` (quadratic
//! elements, weights h/6, 4h/6, h/6) of fourth.
//!
//! **Equilibrium** is a stationary point of the Lagrangian, L = ½ θᵀKθ + Σ λ_k·h_k − Σ μ_j g_j − ½ ε_c Σ μ_j², with
//! μ_j ≥ 0, g_j + ε_c μ_j ≥ 0 and one of them zero at every contact sample. λ_k is the internal force of a cell, μ_j the contact force.
//! Stretch and shear are eliminated link by link: under a force f the direction e becomes e + (f·e)/EA e + (f·e′)/κGA e′ ([`ladder`]).
//!
//! **One step** ([`newton`]). With f the force through link i, the Hessian is K − diag(lᵢ f·eᵢ): the geometric stiffness is diagonal.
//! The linear system in (θ, λ, μ) is taken apart in an order whose cost is linear in elements and lamellae:
//!
//! 1. *Condensation.* A member's interior angles z are coupled to its two joints and its force only: H z = −r − B (a, b, f)ᵀ.
//!    Eliminating them element by element leaves the Schur complement C − Bᵀ H⁻¹ B on (a, b, f).
//! 2. *Banded KKT.* What is left are, per cell, λ_k and three joint angles, a symmetric matrix A of half-bandwidth 6, factorised as L D Lᵀ.
//! 3. *Border.* Each contact row is a column q_j against A; all of them give the dense, small D = ε_c I − Z + Qᵀ A⁻¹ Q.
//! 4. *Active set.* The complementarity problem μ ≥ 0, D Δμ − b ≥ 0 is solved by adding and dropping rows, D factorised with
//!    1×1 and 2×2 pivots, as it may be indefinite where the contacts stabilise the finger.
//! 5. *Back-substitution* of Δμ, Δλ and Δθ.
//!
//! **Stability** ([`equilibrium`]). By Sylvester's law and Haynsworth's additivity of inertia, the negative pivots met in 1 and 2, less
//! the 2(K + 1) that the closures give, less the negative eigenvalues of D on the active set, count the directions in which the energy
//! falls along closures and contacts. Zero: the equilibrium is stable. Only such ones are accepted.
//!
//! **Branches.** dα is walked in steps that are halved when a step fails, is unstable or wanders (its iterates may end on another
//! branch). Where the smallest step fails the branch has folded: one pivot has passed through zero. The finger then moves by itself;
//! the fold handler follows (H + s K₀) Δθ = −g, an implicit step 1/s long of a finger in a viscous bath, until it rests, and flags
//! what it finds as snapped. The flag stays until the hand is open.
//!
//! **Derivatives** ([`sensitivity`]). At an equilibrium r(z, p) = 0 the implicit function theorem gives dz/dp = −(∂r/∂z)⁻¹ ∂r/∂p with the
//! matrix that is factorised already, now with the turning of every contact normal. An independent check of all of it is the motor's
//! work: τ = d(V + ½ ε_c Σ μ²)/dα.
//!
//! # The modules
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

mod access;
pub mod contact;
pub mod design;
pub mod discretise;
#[cfg(test)]
mod elastica;
pub mod equilibrium;
pub mod estimator;
pub mod grasp;
pub mod identify;
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
