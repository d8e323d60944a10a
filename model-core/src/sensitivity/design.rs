//! Derivatives with respect to the finger's dimensions.
//!
//! A dimension p changes the model's constants, and with them every residual at the equilibrium's angles and multipliers:
//! dz/dp = −KKT⁻¹ ∂r/∂p. The residuals' derivative is a central difference between the ladders of p ± δ, the contact forces
//! kept as vectors; no equilibrium is sought anew. It needs a second model and workspace, a [`Probe`], so it belongs to a
//! machine that has the room; the control loop does without.

use super::Derivative;
use super::border::{self, Cause, Layout};
use crate::access::Access;
use crate::design::{Design, HingeKind, Profile};
use crate::discretise::{Discretisation, discretise_in};
use crate::element::Tangents;
use crate::equilibrium::{Follower, Parts};
use crate::model::Model;
use crate::newton::Workspace;
use crate::newton::gaps::Sweep;
use crate::object::Object;
use crate::real::Real;
use crate::size::{Size, Storage};
use crate::state::State;
use crate::units::Units;

/// A dimension of the finger. (The lamellae are rigid: their thickness changes nothing.)
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DesignParameter {
    /// Thickness of the front beam, mm: of a taper, everywhere as much. A rigid wedge's height stays.
    FrontThickness,
    /// Thickness of the back beam, mm.
    BackThickness,
    /// Thickness of the hinges, mm.
    HingeThickness,
    /// Length of the hinges, mm, of all by as much.
    HingeLength,
}

impl DesignParameter {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::FrontThickness, Self::BackThickness, Self::HingeThickness, Self::HingeLength];

    /// The parameter's size in a design, mm; that of the first knot or hinge where there are several.
    pub fn size(self, design: &Design) -> f64 {
        match self {
            Self::FrontThickness => design.front.thickness.at(0.0),
            Self::BackThickness => design.back.thickness.at(0.0),
            Self::HingeThickness => design.hinge.thickness,
            Self::HingeLength => design.hinge.length_of(0),
        }
    }

    /// Makes the parameter greater by so much, mm.
    pub fn shift(self, design: &mut Design, by: f64) {
        let thicken = |profile: &mut Profile| {
            for knot in &mut profile.knots {
                knot[1] += by;
            }
        };
        match self {
            Self::FrontThickness => thicken(&mut design.front.thickness),
            Self::BackThickness => thicken(&mut design.back.thickness),
            Self::HingeThickness => design.hinge.thickness += by,
            Self::HingeLength => {
                for length in &mut design.hinge.length {
                    *length += by;
                }
            }
        }
    }

    /// Without hinges as rods, their dimensions mean nothing.
    fn applies(self, design: &Design) -> bool {
        let hinge = matches!(self, Self::HingeThickness | Self::HingeLength);
        !hinge || design.joint() == HingeKind::Flexible
    }
}

/// Room for a second model.
pub struct Probe<T: Real, S: Size> {
    model: Model<T, S>,
    work: Workspace<T, S>,
    /// Growth of the samples' half thickness. (A wedge's root goes with the thickness, and samples beside it along a taper.)
    thickening: S::Samples<T>,
}

impl<T: Real, S: Size> Probe<T, S> {
    /// Before its first use.
    pub const EMPTY: Self =
        Self { model: Model::EMPTY, work: Workspace::EMPTY, thickening: <S::Samples<T> as Storage<T>>::EMPTY };

    /// Growth of the half thickness at a place, which lies between two samples as [`Model::place`] has it.
    fn thickened(&self, place: u16) -> T {
        let fineness = self.model.fineness.max(1);
        let (at, step) = (usize::from(place) / fineness, usize::from(place) % fineness + 1);
        let own = self.thickening.as_ref().at(at);
        let below = at.checked_sub(1).map_or(own, |below| self.thickening.as_ref().at(below));
        below + T::of(step as f64 / fineness as f64) * (own - below)
    }
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Derivative with respect to a dimension of the finger, per mm, at the last accepted equilibrium; `design` and `how`
    /// are those that the follower was configured with. Within 1e-5 in `f64`, 1e-3 in `f32`.
    ///
    /// `None` if there is no equilibrium, friction or memory, no room (see [`Self::sensitivity`]), or no finger with the dimension a
    /// little greater or less; zero without contact.
    pub fn design_sensitivity(
        &mut self,
        probe: &mut Probe<T, S>,
        design: &Design,
        how: &Discretisation,
        parameter: DesignParameter,
    ) -> Option<Derivative<T>> {
        if self.has_equilibrium() && !parameter.applies(design) {
            return Some(Derivative::ZERO);
        }
        // Truncation against rounding, of a central difference.
        let step = libm::cbrt(T::EPSILON.to_f64()) * parameter.size(design);
        let shifted = |by: f64| {
            let mut other = design.clone();
            parameter.shift(&mut other, by);
            other
        };
        self.design_derivative(probe, [&shifted(-step), &shifted(step)], how, step)
    }

    /// Derivative along a line of designs, per unit of its coordinate p, at the last accepted equilibrium: `designs` are those at
    /// p − `step` and p + `step`, where p is the design that the follower was configured with, by `how`. Positions of lamellae, ends of
    /// beams, hinges one by one, knots of tapers: whatever changes the model's constants, but for the motor axis, which belongs to the
    /// motion ([`Self::sensitivity`]).
    ///
    /// The central difference is one of residuals and no equilibrium is sought anew: with a step of 6e-6 of the parameter's size within
    /// 1e-5 in `f64`.
    ///
    /// `None` if there is no equilibrium, friction or memory, no room (see [`Self::sensitivity`]), or no model of the same size for one of
    /// the designs; zero without contact.
    pub fn design_derivative(
        &mut self,
        probe: &mut Probe<T, S>,
        designs: [&Design; 2],
        how: &Discretisation,
        step: f64,
    ) -> Option<Derivative<T>> {
        if !self.has_equilibrium() || self.rubs() || self.remembers() {
            return None;
        }
        if self.solution().touching() == 0 {
            return Some(Derivative::ZERO);
        }
        self.complete_tangent();
        let frame = self.frame();
        let layout = {
            let Parts { model, work, .. } = self.parts();
            border::widen(model, work, usize::MAX)?
        };
        let differed = self.differ(probe, layout, designs, how, step);
        let answer = differed.map(|softening| {
            let mut parts = self.parts();
            border::factorise(&mut parts, layout);
            let Parts { model, work, .. } = parts;
            let cause = Cause { residuals: true, softening, ..Cause::NONE };
            frame.derivative(&border::respond(model, work, layout, &cause, |place| probe.thickened(place), frame.axis))
        });
        let Parts { work, .. } = self.parts();
        border::narrow(work, layout);
        self.show_accepted();
        answer
    }

    /// Puts the derivative of the residuals into the workspace in place of the residuals; gives that of the contact softness, mm/N,
    /// or `None` if a model was refused.
    fn differ(
        &mut self,
        probe: &mut Probe<T, S>,
        layout: Layout,
        [below, above]: [&Design; 2],
        how: &Discretisation,
        step: f64,
    ) -> Option<T> {
        // Those of the design: a factor of Young's modulus makes no difference to its line.
        let Parts { model, .. } = self.parts();
        let (length, (force, _)) = (model.units.length, model.sudden);
        let units = Units { length: length.to_f64(), force: force.to_f64() };
        let mut softening = T::ZERO;
        for (sign, part, other) in [(1.0, 0.5 / step, above), (-1.0, -0.5 / step, below)] {
            // Not its own units, which may be others.
            let same = discretise_in(other, how, Some(units), &mut probe.model).is_ok()
                && self.is_like(&probe.model)
                && probe.work.fit(&probe.model)
                && probe.thickening.fit(probe.model.sample_count);
            if !same {
                return None;
            }
            let (state, Parts { model, work, .. }) = self.state_and_parts();
            probe.model.fineness = model.fineness;
            probe.model.sudden = (probe.model.units.force, probe.model.softness);
            probe.model.stiffen(T::one(), model.units.force / model.sudden.0);
            let rows = work.contacts.count;
            take_rows(&probe.model, &mut probe.work, work, layout);
            residuals(&probe.model, &mut probe.work, state);
            let part = T::of(part);
            softening += part * probe.model.contact_softness() * model.units.length / model.units.force;
            let is_first = sign > 0.0;
            gather(model, work, &probe.work, part, is_first);
            for (into, sample) in probe.thickening.as_mut().iter_mut().zip(probe.model.samples.as_ref()) {
                put(into, sample.half_thickness, part, is_first);
            }
            for j in 0..rows {
                let row = work.contacts.rows.as_ref()[j];
                let position = probe.work.kinematics.position(&probe.model, &probe.model.place(row.sample));
                let along = part * (row.normal[0] * position.x + row.normal[1] * position.y);
                // A row's right-hand side is −gap − softness · multiplier.
                let gap = if is_first { along - row.softness * row.multiplier } else { row.gap + along };
                work.contacts.rows.as_mut()[j].gap = gap;
            }
        }
        Some(softening)
    }
}

/// Gives another model's workspace the gap rows of a widened border, with their normals and multipliers as they are.
pub(super) fn take_rows<T: Real, S: Size>(
    other: &Model<T, S>,
    into: &mut Workspace<T, S>,
    from: &Workspace<T, S>,
    layout: Layout,
) {
    into.contacts.count = layout.touching;
    for (into, j) in into.contacts.rows.as_mut().iter_mut().zip(layout.all_gaps()) {
        *into = from.contacts.rows.as_ref().at(j);
        into.place = other.place(into.sample);
    }
}

/// Finds a model's residuals at a state, the forces of its workspace's rows kept as vectors.
pub(super) fn residuals<T: Real, S: Size>(model: &Model<T, S>, work: &mut Workspace<T, S>, state: &State<T, S>) {
    let Workspace { kinematics, contacts, residual, history, .. } = work;
    kinematics.direct(model, state);
    kinematics.place_front::<Tangents>(model, &history.memory, state, contacts.rows());
    kinematics.complete::<Tangents>(model, &history.memory, state);
    residual.gather(model, kinematics, contacts, &Sweep::NONE);
}

/// Adds `part` of another workspace's residuals to a workspace's, or puts it in their place: all but those of the gap rows.
pub(super) fn gather<T: Real, S: Size>(
    model: &Model<T, S>,
    into: &mut Workspace<T, S>,
    from: &Workspace<T, S>,
    part: T,
    is_first: bool,
) {
    let nodes = into.kinematics.nodes.as_mut().run_mut(0..model.node_count);
    for (into, from) in nodes.iter_mut().zip(from.kinematics.nodes.as_ref()) {
        put(&mut into.gradient, from.gradient, part, is_first);
    }
    let joints = into.residual.joints.as_mut().run_mut(0..model.unknowns());
    for (into, &from) in joints.iter_mut().zip(from.residual.joints.as_ref()) {
        put(into, from, part, is_first);
    }
    let closures = into.residual.closure.as_mut().run_mut(0..model.cells());
    for (into, from) in closures.iter_mut().zip(from.residual.closure.as_ref()) {
        put(&mut into[0], from[0], part, is_first);
        put(&mut into[1], from[1], part, is_first);
    }
}

fn put<T: Real>(into: &mut T, from: T, part: T, is_first: bool) {
    *into = if is_first { part * from } else { *into + part * from };
}
