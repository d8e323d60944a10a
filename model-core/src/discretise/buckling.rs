//! The force at which a rib buckles.

use crate::access::Access as _;
use crate::linear::pivot::{bounded, pivot_bound};
use crate::model::Model;
use crate::real::Real;
use crate::size::Size;
use crate::topology::{Member, Role};

/// Halvings of the interval in which the load lies, at most, and its width at which they end, relative.
const HALVINGS: usize = 40;
const WIDTH: f64 = 1e-3;
/// Negative pivots from the load on at which a rib buckles between clamped ends: the first comes at a quarter of it, where an end moves sidewise.
const BUCKLED: usize = 2;

impl<T: Real, S: Size> Model<T, S> {
    /// Finds each rib's buckling load: between clamped ends, or with one that slides and turns freely.
    pub(super) fn find_buckling_loads(&mut self) {
        for index in 0..self.members().len() {
            let Some(&member) = self.member(index) else { continue };
            if let Role::Rung(rib, 0) = member.role
                && self.is_rib(&member)
            {
                let load = self.buckling_load(&member) / T::of(self.topology.eased(rib));
                self.buckling_loads.as_mut().put(usize::from(rib), load);
            }
        }
    }

    /// A member that bends and is the whole of its rung.
    fn is_rib(&self, member: &Member<T>) -> bool {
        member.start != member.end && self.topology.find(Role::Rung(member.role.cell(), 1)).is_none()
    }

    /// Load at which a straight member buckles between clamped ends.
    fn buckling_load(&self, member: &Member<T>) -> T {
        let nodes = member.nodes();
        let (diagonal, weight) = (self.diagonal.as_ref().run(nodes.clone()), self.weight.as_ref().run(nodes));
        let own = |(&k, &w): (&T, &T)| if w > T::ZERO { k / w } else { T::ZERO };
        // Two nodes bear no more than both their diagonals.
        let stiffest = diagonal.iter().zip(weight).map(own).fold(T::ZERO, T::max);
        let (mut low, mut high) = (T::ZERO, T::of(2.0) * stiffest);
        for _ in 0..HALVINGS {
            if high - low < T::of(WIDTH) * high {
                break;
            }
            let middle = T::of(0.5) * (low + high);
            if self.negative_pivots(member, middle) < BUCKLED {
                low = middle;
            } else {
                high = middle;
            }
        }
        T::of(0.5) * (low + high)
    }

    /// Negative pivots of a straight member's interior under a load.
    fn negative_pivots(&self, member: &Member<T>, load: T) -> usize {
        let nodes = member.nodes();
        let bound = pivot_bound::<T>();
        let mut negative = 0;
        // What the nodes before take: of this diagonal, of the next one, and of the entry between both.
        let (mut taken, mut taken_next, mut taken_between) = (T::ZERO, T::ZERO, T::ZERO);
        for node in nodes.start + 1..nodes.end - 1 {
            let rest = self.diagonal.as_ref().at(node);
            let own = rest - load * self.weight.as_ref().at(node);
            let (pivot, is_negative) = bounded(own - taken, bound * rest);
            negative += usize::from(is_negative);
            let [next, after] = self.coupling.as_ref().at(node);
            let between = next - taken_between;
            let (near, far) = (between / pivot, after / pivot);
            (taken, taken_next, taken_between) = (taken_next + near * between, far * after, near * after);
        }
        negative
    }
}
