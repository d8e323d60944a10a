//! What the stages after the evaluation begin with.

use super::gaps::Contacts;
use super::kinematics::Kinematics;
use crate::model::Model;
use crate::real::Real;
use crate::size::Size;

/// A model at an evaluated state: what the later stages begin with.
pub(crate) struct Evaluated<'a, T: Real, S: Size> {
    pub model: &'a Model<T, S>,
    pub kinematics: &'a Kinematics<T, S>,
    pub contacts: &'a Contacts<T, S>,
}

impl<T: Real, S: Size> Clone for Evaluated<'_, T, S> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: Real, S: Size> Copy for Evaluated<'_, T, S> {}
