//! The gradient of the Lagrangian
//! L = V(θ) + Σ λ_k·h_k(θ, λ, μ) − Σ μ_j g_j − ½ ε_c Σ μ_j², stretch and shear eliminated (see [`crate::model`]).

use super::Workspace;
use super::gaps::Sweep;
use super::kinematics::{bend, directions, energy, forces, own_rows, starts, strain};
use crate::access::Access;
use crate::element::{Depth, Tangents};
use crate::model::Model;
use crate::real::Real;
use crate::size::Size;
use crate::state::State;
use crate::topology::CLAMPED;

/// Largest components of what must vanish at an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Residual<T> {
    /// Gradient with respect to angles and stretches, N·mm, less what rounding of the angles may leave of it.
    pub gradient: T,
    /// Closure errors, errors g + ε_c μ of touching samples, penetration of the others, mm.
    pub length: T,
}

/// Strains the members but the front spans, which are strained already, and returns the largest residuals of gradient, closures
/// and gaps.
pub(crate) fn gradient<T: Real, S: Size, D: Depth>(
    model: &Model<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    sweep: &Sweep<T>,
) -> Residual<T> {
    let mut worst = Residual { gradient: T::ZERO, length: T::ZERO };
    work.rhs.as_mut().run_mut(0..model.unknowns()).fill(T::ZERO);
    work.shape.closure.as_mut().run_mut(0..model.cells()).fill([T::ZERO; 2]);
    for (index, member) in model.members().iter().enumerate() {
        if index >= model.cells() {
            strain::<T, S, D>(model, state, work, index, 0..0);
        }
        bend(model, state, work, index, member);
        let (Some([first, .., last]), Some(out)) =
            (work.shape.nodes.as_ref().get(member.nodes()), work.shape.members.as_ref().get(index))
        else {
            continue;
        };
        worst.gradient = worst.gradient.max(out.steepest - member.rounding);
        let joints = work.rhs.as_mut();
        model.topology.enter(work.shape.closure.as_mut(), member, out.end_to_end());
        let turn = |f: [T; 2], rigid: [T; 2]| f[1] * rigid[0] - f[0] * rigid[1];
        if member.start != CLAMPED {
            joints.add(usize::from(member.start), first.gradient + turn(out.force, out.rigid_start));
        }
        joints.add(usize::from(member.end), last.gradient + turn(out.end_force, out.rigid_end));
    }
    model.topology.finish_closures(work.shape.closure.as_mut());
    // NaN anywhere reaches a closure or a joint; the comparisons alone would drop it.
    let mut total = T::ZERO;
    for error in work.shape.closure.as_ref().run(0..model.cells()).iter().flatten() {
        total += *error;
        worst.length = worst.length.max(error.abs());
    }
    // The closures' places are still zero.
    let joints = work.rhs.as_ref().run(0..model.unknowns()).iter().zip(model.topology.rounding.as_ref());
    for (slope, &rounding) in joints {
        total += *slope;
        worst.gradient = worst.gradient.max(slope.abs() - rounding);
    }
    let rows = work.contacts.rows.as_ref().run(0..work.contacts.row_count);
    for row in rows {
        if row.touches() {
            worst.length = worst.length.max((row.gap + model.contact_softness() * row.multiplier).abs());
        }
    }
    let misdirected = misdirected(model, work);
    worst.gradient = worst.gradient.max(misdirected);
    total += misdirected;
    if !total.is_finite() {
        worst.gradient = T::of(1e30);
    }
    worst.length = worst.length.max(-sweep.nearest_free);
    worst
}

/// By how much the gradient is off for normals that are not the object's where the samples are, N·mm. A node's gradient takes the forces
/// above it times its weight, so what counts is the largest sum of misdirected force from the tip down: opposite tilts further apart do
/// not make up for each other. NaN stays NaN.
pub(crate) fn misdirected<T: Real, S: Size>(model: &Model<T, S>, work: &Workspace<T, S>) -> T {
    let (mut most, mut arm, mut above) = (T::ZERO, T::ZERO, [T::ZERO; 2]);
    for row in work.contacts.rows.as_ref().run(0..work.contacts.row_count).iter().rev() {
        if row.touches() {
            arm = model.weight.as_ref().get(usize::from(row.place.node) + 1).map_or(arm, |&weight| arm.max(weight));
            let across = row.multiplier * row.tilt;
            above = [above[0] - across * row.normal[1], above[1] + across * row.normal[0]];
            let size = above[0] * above[0] + above[1] * above[1];
            most = if size <= most { most } else { size };
        }
    }
    most.sqrt() * arm
}

/// Elastic energy at a state whose rows are those of the last evaluation, N·mm; leaves positions behind.
pub(crate) fn potential<T: Real, S: Size>(model: &Model<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) -> T {
    directions(model, state, work);
    forces(model, state, work);
    let mut from = 0;
    for index in 0..model.topology.member_count() {
        let own = own_rows(work.contacts.rows.as_ref().run(0..work.contacts.row_count), index, from);
        from = own.end;
        strain::<T, S, Tangents>(model, state, work, index, own);
    }
    starts(model, work);
    state.bending_energy(model) + energy(model, work)
}
