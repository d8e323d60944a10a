//! What a step says of the stability of the state it was made at (37)–(39).

use super::gaps::Contacts;
use crate::contact::frictionless::Settled;
use crate::real::Real;
use crate::size::Size;

/// What a factorisation, and the active set settled on it, say about the state it was made at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Inertia {
    /// Negative pivots of the condensation and of the banded KKT, less the 2(K+1) that the closures give.
    pub excess: isize,
    /// Negative eigenvalues of D on the active set, less those that the turning of the contact force has by itself.
    pub border: isize,
    /// The active set settled.
    pub settled: bool,
}

impl Inertia {
    /// From the pivots in excess and the settled border.
    pub fn of<T: Real, S: Size>(excess: isize, settled: Settled, contacts: &Contacts<T, S>) -> Self {
        let border = settled.negative as isize - contacts.turning_negative();
        Self { excess, border, settled: settled.settled }
    }

    /// The energy's Hessian is positive definite on the closures' and contacts' tangent space: a stable equilibrium.
    pub fn is_stable(&self) -> bool {
        self.settled && self.excess == self.border
    }

    /// There is a direction in which the energy falls. (Fewer than none there cannot be: a border with more negative eigenvalues than the
    /// rest has in excess is an effect of rounding.)
    pub fn is_unstable(&self) -> bool {
        self.settled && self.excess > self.border
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_border_takes_back_what_the_rest_has_in_excess() {
        let of = |excess, border, settled| Inertia { excess, border, settled };
        let words = |inertia: Inertia| (inertia.is_stable(), inertia.is_unstable());
        assert_eq!(words(of(0, 0, true)), (true, false));
        assert_eq!(words(of(2, 2, true)), (true, false), "contacts hold what buckles without them");
        assert_eq!(words(of(1, 0, true)), (false, true));
        assert_eq!(words(of(0, 1, true)), (false, false), "an effect of rounding");
        assert_eq!(words(of(1, 0, false)), (false, false), "nothing is known without settled contacts");
    }
}
