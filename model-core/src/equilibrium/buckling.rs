//! How near a rib is to buckling.

use super::Follower;
use crate::newton::Hessian;
use crate::newton::condense::Diagonal;
use crate::object::Object;
use crate::real::Real;
use crate::size::Size;
use crate::topology::Role;

/// Halvings of the interval in which a rib's share lies.
const HALVINGS: usize = 10;
/// Negative pivots of a rib's interior, its force fixed and its ends held against turning, from the buckling load on between ends that cannot
/// move sidewise either: the first one comes at a quarter of that.
const BUCKLED: usize = 2;

/// The rib that is nearest to buckling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Buckling {
    /// The rib, from 0 at the base.
    pub rib: usize,
    /// Its force over its buckling load between clamped ends, 4π²EI/L² of an even one; over a sixteenth of that if its end is free before the
    /// back beam.
    pub share: f64,
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// The rib that is nearest to buckling between clamped ends, if one carries a share of that load or more. The next step factorises anew.
    pub fn buckling(&mut self, share: f64) -> Option<Buckling> {
        if !self.has_equilibrium() || self.solution().ribs().next().is_none() {
            return None;
        }
        self.show_accepted();
        let mut nearest: Option<Buckling> = None;
        for index in 0..self.model.members().len() {
            let Some(Role::Rung(rib, 0)) = self.model.member(index).map(|member| member.role) else { continue };
            let from = nearest.map_or(share, |found| found.share);
            let eased = self.model.topology.eased(rib);
            if !self.buckles_at(index, eased / from) {
                continue;
            }
            // No equilibrium carries more than twice the buckling load.
            let (mut low, mut high) = (0.5, 1.0 / from);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if self.buckles_at(index, eased * middle) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            nearest = Some(Buckling { rib: usize::from(rib), share: 1.0 / high });
        }
        self.show_accepted();
        nearest
    }

    /// A member's interior has buckled with a factor on what its force takes from its stiffness.
    fn buckles_at(&mut self, index: usize, factor: f64) -> bool {
        let diagonal = Diagonal { curvature: T::of(factor), ..Diagonal::of(Hessian::Newton, T::ZERO) };
        self.factored.kkt.curved = true;
        let (_, negative) = self.factored.kkt.condense(&self.model, &self.work.kinematics, index, diagonal);
        negative >= BUCKLED
    }
}
