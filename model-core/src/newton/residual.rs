//! The gradient of the Lagrangian
//! L = V(θ) + Σ λ_k·h_k(θ, λ, μ) − Σ μ_j g_j − ½ ε_c Σ μ_j², stretch and shear eliminated (see [`crate::model`]).

use super::end_gaps;
use super::gaps::{Contacts, Sweep};
use super::kinematics::Kinematics;
use crate::access::Access;
use crate::model::Model;
use crate::real::{Real, Tolerance};
use crate::size::{Size, Storage};
use crate::topology::{CLAMPED, Kind};

/// What must vanish at an equilibrium, but for the interiors' gradients, which the nodes have, and the gaps, which the rows have.
pub(crate) struct Residual<T: Real, S: Size> {
    /// Gradient at the joints, N·mm; zero at the closures' unknowns.
    pub joints: S::Unknowns<T>,
    /// Closure errors, mm.
    pub closure: S::Cells<[T; 2]>,
}

/// Largest components of what must vanish at an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Largest<T> {
    /// Gradient with respect to angles and stretches, N·mm, less what rounding of the angles may leave of it.
    pub gradient: T,
    /// Closure errors, errors g + ε_c μ of touching samples, penetration of the others, mm.
    pub length: T,
}

impl<T: Real> Largest<T> {
    /// More than any state has.
    pub const UNKNOWN: f64 = 1e30;

    /// All of it is within a tolerance.
    pub fn is_within(&self, tolerance: &Tolerance<T>) -> bool {
        self.gradient <= tolerance.gradient && self.length <= tolerance.length
    }

    /// The larger of both, in tolerances.
    pub fn size(&self, tolerance: &Tolerance<T>) -> T {
        (self.gradient / tolerance.gradient).max(self.length / tolerance.length)
    }
}

impl<T: Real, S: Size> Residual<T, S> {
    pub const EMPTY: Self =
        Self { joints: <S::Unknowns<T> as Storage<T>>::EMPTY, closure: <S::Cells<[T; 2]> as Storage<[T; 2]>>::EMPTY };

    /// Makes room for a model; false if there is none.
    pub fn fit(&mut self, model: &Model<T, S>) -> bool {
        self.joints.fit(model.unknowns()) && self.closure.fit(model.cells())
    }

    /// Gathers what the members find at joints and closures (6), (23); returns the largest residuals of gradient, closures and gaps.
    pub fn gather(
        &mut self,
        model: &Model<T, S>,
        kinematics: &mut Kinematics<T, S>,
        contacts: &Contacts<T, S>,
        sweep: &Sweep<T>,
    ) -> Largest<T> {
        let mut worst = Largest { gradient: T::ZERO, length: T::ZERO };
        let joints = self.joints.as_mut().run_mut(0..model.unknowns());
        joints.fill(T::ZERO);
        self.closure.as_mut().run_mut(0..model.cells()).fill([T::ZERO; 2]);
        for (member, out) in model.members().iter().zip(kinematics.members.as_ref()) {
            let Some([first, .., last]) = kinematics.nodes.as_ref().get(member.nodes()) else { continue };
            worst.gradient = worst.gradient.max(out.steepest - member.rounding);
            model.topology.enter(self.closure.as_mut(), member, out.end_to_end());
            if member.kind == Kind::Gap {
                continue;
            }
            let turn = |f: [T; 2], rigid: [T; 2]| f[1] * rigid[0] - f[0] * rigid[1];
            if member.start != CLAMPED {
                joints.add(usize::from(member.start), first.gradient + turn(out.force, out.rigid_start));
            }
            joints.add(usize::from(member.end), last.gradient + turn(out.end_force, out.rigid_end));
        }
        model.topology.finish_closures(self.closure.as_mut());
        end_gaps::close(model, kinematics, self.closure.as_mut(), joints);
        // NaN anywhere reaches a closure or a joint; the comparisons alone would drop it.
        let mut total = T::ZERO;
        for error in self.closure.as_ref().run(0..model.cells()).iter().flatten() {
            total += *error;
            worst.length = worst.length.max(error.abs());
        }
        for (slope, &rounding) in joints.iter().zip(model.topology.rounding.as_ref()) {
            total += *slope;
            worst.gradient = worst.gradient.max(slope.abs() - rounding);
        }
        end_gaps::loosen(model, kinematics, self.closure.as_mut(), joints);
        for row in contacts.rows() {
            if row.touches() {
                worst.length = worst.length.max((row.gap + model.contact_softness() * row.multiplier).abs());
            }
        }
        let misdirected = contacts.misdirected(model);
        worst.gradient = worst.gradient.max(misdirected);
        total += misdirected;
        if !total.is_finite() {
            worst.gradient = T::of(Largest::<T>::UNKNOWN);
        }
        worst.length = worst.length.max(-sweep.nearest_free);
        worst
    }
}
