//! What helps where the solver itself has failed, as far as that is known.

use std::fmt;

use model_core::discretise::Softness;
use model_core::newton::Hessian;
use model_core::status::Status;

use crate::case::Case;
use crate::study::model::Options;

/// Other options, with which such a place is usually solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remedy {
    /// The whole second derivative.
    Newton,
    /// A contact that is a little soft.
    Softness,
}

impl Remedy {
    /// What helps against a status; `None` where nothing is known to.
    pub fn of(case: &Case, options: &Options, status: Status) -> Option<Self> {
        // With friction no contact is without softness.
        let is_hard = options.discretisation.softness == Softness::Fixed(0.0) && case.friction == 0.0;
        match status {
            Status::Stagnated if options.hessian == Hessian::GaussNewton => Some(Self::Newton),
            Status::Unsettled if is_hard => Some(Self::Softness),
            _ => None,
        }
    }
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Newton => "gauss-newton has failed, not the finger; --hessian newton usually solves the place",
            Self::Softness => {
                "the contact has no softness, which is the default with contact at nodes; --softness-mm-per-n 1e-3 usually \
                 settles it, and changes the force by less than 1 %"
            }
        })
    }
}
