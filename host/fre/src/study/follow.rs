//! A follower of a case, ready to start.

use model_core::design::Design;
use model_core::discretise::DiscretiseError;
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::real::Real;

use crate::heap::Host;
use crate::study::model::Options;

/// A follower of a finger against an object, before its start. There is time enough for every contact to be found where it begins.
///
/// # Errors
/// If the finger cannot be discretised as asked.
pub fn follower<T: Real>(
    design: &Design,
    object: ObjectDesign,
    motion: Motion,
    options: &Options,
) -> Result<Follower<T, Host>, DiscretiseError> {
    let mut follower = <Follower<T, Host>>::EMPTY;
    follower.configure(design, &options.discretisation)?;
    follower.set_hessian(options.hessian);
    follower.resolve_contact(true);
    follower.set_object(object, motion);
    Ok(follower)
}
