//! One Newton step for a finger in contact, cost linear in elements and lamellae, and the loop over it.
//!
//! Each stage is a type with a file of its own, made from those before it: `kinematics` and `gaps` → `residual` → `factorisation`
//! (members are condensed onto their joints and force by `condense`, the banded KKT in joints and λ is assembled by `assembly`) →
//! `border` by the contact rows → `solution` of the contact law → `increment`. `step` puts them in a row. What a member's elements do
//! is asked of `element`.
//!
//! Here mm, N and N·mm stand for the finger's own units of length, force and moment ([`crate::units`]).

mod assembly;
pub(crate) mod attempt;
pub(crate) mod border;
pub(crate) mod condense;
pub(crate) mod condensed;
pub(crate) mod end_gaps;
mod evaluated;
pub(crate) mod factored;
pub(crate) mod factorisation;
pub(crate) mod gaps;
pub(crate) mod history;
pub(crate) mod increment;
pub(crate) mod inertia;
pub(crate) mod kinematics;
pub(crate) mod memory;
pub(crate) mod residual;
pub(crate) mod settings;
pub(crate) mod slip;
pub(crate) mod solution;
mod step;
#[cfg(test)]
pub(crate) mod tests;
mod thin;
mod through;
pub(crate) mod turning;
mod workspace;

pub(crate) use evaluated::Evaluated;
pub use workspace::Workspace;

/// Which second derivative the step uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Hessian {
    /// The energy's plus the exact geometric stiffness of links and contacts.
    ///
    /// The default: the geometric stiffness stays within an element, so it costs next to nothing, and without it a compressed beam
    /// looks as stiff as a stretched one. In double precision the iterations after a step's first keep its factorisation as long as the
    /// residuals shrink fast: as many iterations, at a third of the cost each.
    #[default]
    Newton,
    /// The energy's alone (Gauss–Newton): blind to compression, so no stability test is possible.
    ///
    /// A servo's count then takes many iterations without stretch and shear, and some ticks fail; with them it takes half as many again as
    /// with the default (`cargo xtask bench target`).
    GaussNewton,
}

/// What was computed since the program began, counted; every count wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Evaluations of residuals and gaps.
    pub evaluations: u32,
    /// Linear systems solved: Newton iterations, factorisations that judge a solution, derivatives.
    pub solves: u32,
}

impl Effort {
    pub(crate) const NONE: Self = Self { evaluations: 0, solves: 0 };

    /// What was computed since an earlier count.
    pub fn since(self, earlier: Self) -> Self {
        Self {
            evaluations: self.evaluations.wrapping_sub(earlier.evaluations),
            solves: self.solves.wrapping_sub(earlier.solves),
        }
    }

    /// Both together.
    pub fn with(self, other: Self) -> Self {
        Self {
            evaluations: self.evaluations.wrapping_add(other.evaluations),
            solves: self.solves.wrapping_add(other.solves),
        }
    }

    pub(crate) fn evaluates(&mut self) {
        self.evaluations = self.evaluations.wrapping_add(1);
    }

    pub(crate) fn solves(&mut self) {
        self.solves = self.solves.wrapping_add(1);
    }
}
