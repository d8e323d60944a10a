//! Kinematics: directions of the links, the forces through them, and what those do to them.

use super::Workspace;
use crate::access::Access;
use crate::contact::{Row, Sample};
use crate::element::{Depth, Element, Link, Node, Pull, Quadratic};
use crate::model::{Model, turned};
use crate::real::Real;
use crate::size::Size;
use crate::state::State;
use crate::topology::{Kind, Member};

/// Increment of an angle up to which [`turn`] is exact, rad.
pub(crate) const SMALL: f64 = 1e-3;

/// Directions of all links and turned rigid parts.
pub(crate) fn directions<T: Real, S: Size>(model: &Model<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) {
    let (nodes, rest) = (work.shape.nodes.as_mut(), model.direction.as_ref());
    // Joint angles come once per member that meets there: that is cheaper than to look for them.
    let count = model.node_count;
    let (angles, nodes) = (state.angle.as_ref().run(0..count), nodes.run_mut(0..count));
    T::turn_each(angles, nodes, rest.run(0..count), |node, &rest, sin, cos| node.e = turned(rest, cos, sin));
    rigid_parts(model, work);
}

/// Directions after an increment of the angles (the nodes' `delta`, none larger than [`SMALL`]): turned by it, at half the cost
/// of [`directions`].
pub(crate) fn turn<T: Real, S: Size>(model: &Model<T, S>, work: &mut Workspace<T, S>) {
    let (half, third) = (T::of(0.5), T::of(1.0 / 3.0));
    for node in work.shape.nodes.as_mut().run_mut(0..model.node_count) {
        let [x, y] = node.e;
        let delta = node.delta;
        // 1 − cos δ to δ⁴ and sin δ to δ³, both within 1e-17 of the true ones.
        let z = half * (delta * delta);
        let (back, side) = (z - z * z * (half * third), delta - delta * (z * third));
        node.e = [x - (x * back + y * side), y + (x * side - y * back)];
    }
    rigid_parts(model, work);
}

/// Turned rigid parts of all members.
fn rigid_parts<T: Real, S: Size>(model: &Model<T, S>, work: &mut Workspace<T, S>) {
    let (nodes, rest) = (work.shape.nodes.as_ref(), model.direction.as_ref());
    // A rigid part turns as the node at its end.
    let like = |part: [T; 2], node: usize| match (rest.get(node), nodes.get(node)) {
        (Some(&[x, y]), Some(&Node { e: [u, v], .. })) if part != [T::ZERO; 2] => {
            turned(part, x * u + y * v, x * v - y * u)
        }
        _ => [T::ZERO; 2],
    };
    for (member, out) in model.members().iter().zip(work.shape.members.as_mut()) {
        out.rigid_start = like(member.rigid_start, usize::from(member.first));
        out.rigid_end = like(member.rigid_end, usize::from(member.first + member.interior) + 1);
    }
}

/// Starts of the front spans from their end-to-end vectors.
pub(crate) fn starts<T: Real, S: Size>(model: &Model<T, S>, work: &mut Workspace<T, S>) {
    let mut position = model.base;
    let fronts = work.shape.members.as_ref().iter();
    for (start, front) in work.shape.start.as_mut().iter_mut().zip(fronts).take(model.cells()) {
        *start = position;
        let d = front.end_to_end();
        position = [position[0] + d[0], position[1] + d[1]];
    }
}

/// Cell whose front span a row touches.
#[inline]
pub(crate) fn cell_of<T: Real>(row: &Row<T>) -> usize {
    usize::from(row.place.cell)
}

/// The rows that touch a member, in order: none but for the front spans; `from` is where to begin to look.
#[inline]
pub(crate) fn own_rows<T: Real>(rows: &[Row<T>], index: usize, from: usize) -> core::ops::Range<usize> {
    let above = rows.get(from..).unwrap_or(&[]);
    from..from + above.iter().take_while(|row| cell_of(row) == index).count()
}

/// Strains a member under its force, as deep as asked; `own` are its rows.
// Long and called once per member: a copy at every call would cost flash and spare nothing.
#[inline(never)]
pub(crate) fn strain<T: Real, S: Size, D: Depth>(
    model: &Model<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    own: core::ops::Range<usize>,
) {
    let Some(member) = model.member(index) else { return };
    let (Some(of), Some(angle), Some(nodes), Some(out)) = (
        model.constants(member),
        state.angle.as_ref().get(member.nodes()),
        work.shape.nodes.as_mut().get_mut(member.nodes()),
        work.shape.members.as_mut().get_mut(index),
    ) else {
        return;
    };
    let rows = work.contacts.rows.as_ref().get(own).unwrap_or(&[]);
    match member.kind {
        Kind::Quadratic => Quadratic::walk::<D>(of, angle, rows, nodes, out),
        Kind::Link => Link::walk::<D>(of, angle, rows, nodes, out),
    }
}

/// Adds a strained member's bending moments to its gradient.
#[inline(always)]
pub(crate) fn bend<T: Real, S: Size>(
    model: &Model<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    member: &Member<T>,
) {
    let (Some(of), Some(angle), Some(nodes), Some(out)) = (
        model.constants(member),
        state.angle.as_ref().get(member.nodes()),
        work.shape.nodes.as_mut().get_mut(member.nodes()),
        work.shape.members.as_mut().get_mut(index),
    ) else {
        return;
    };
    match member.kind {
        Kind::Quadratic => Quadratic::bend(of, angle, nodes, out),
        Kind::Link => Link::bend(of, angle, nodes, out),
    }
}

/// Derivatives of a sample's position with respect to the angles of three nodes, from the sample's own on, mm.
pub(crate) fn sample_lever<T: Real, S: Size>(
    model: &Model<T, S>,
    work: &Workspace<T, S>,
    index: usize,
    sample: &Sample<T>,
) -> [[T; 2]; 3] {
    let none = [[T::ZERO; 2]; 3];
    let Some(member) = model.member(index) else { return none };
    let nodes = member.nodes();
    // The wedge's samples lie beyond the last node.
    let Some(first) = usize::from(sample.node).checked_sub(nodes.start).filter(|&node| node < nodes.len()) else {
        return none;
    };
    let (Some(of), Some(list)) = (model.constants(member), work.shape.nodes.as_ref().get(nodes)) else { return none };
    match member.kind {
        Kind::Quadratic => Quadratic::lever(of, first, sample, list),
        Kind::Link => Link::lever(of, first, sample, list),
    }
}

/// Energy of stretch and shear of a strained model, N·mm.
pub(crate) fn energy<T: Real, S: Size>(model: &Model<T, S>, work: &Workspace<T, S>) -> T {
    let rows = work.contacts.rows.as_ref().run(0..work.contacts.row_count);
    let (mut from, mut twice) = (0, T::ZERO);
    for (index, (member, out)) in model.members().iter().zip(work.shape.members.as_ref()).enumerate() {
        let own = own_rows(rows, index, from);
        from = own.end;
        let mut pull = Pull::new(rows.get(own).unwrap_or(&[]), out.force);
        let [stretch, shear] = member.compliance;
        for node in member.nodes().rev() {
            let (Some(&w), Some(&[x, y])) =
                (model.weight.as_ref().get(node), work.shape.nodes.as_ref().get(node).map(|node| &node.e))
            else {
                continue;
            };
            let force = pull.force(node, w);
            let (a, b) = (force[0] * x + force[1] * y, force[1] * x - force[0] * y);
            twice += w * (stretch * a * a + shear * b * b);
        }
    }
    T::of(0.5) * twice
}

/// Forces, and the front spans strained and placed, so that gaps can be measured.
pub(crate) fn place_front<T: Real, S: Size, D: Depth>(
    model: &Model<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
) {
    forces(model, state, work);
    let mut from = 0;
    for cell in 0..model.cells() {
        let own = own_rows(work.contacts.rows.as_ref().run(0..work.contacts.row_count), cell, from);
        from = own.end;
        strain::<T, S, D>(model, state, work, cell, own);
    }
    starts(model, work);
}

/// Forces through the members (15): the multipliers of the closures that a member's vector enters, and in a front span less the load and
/// Σ μ n of the contacts above.
pub(crate) fn forces<T: Real, S: Size>(model: &Model<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) {
    let lambda = state.lambda.as_ref();
    let members = work.shape.members.as_mut();
    for (member, out) in model.members().iter().zip(&mut *members) {
        let mut force = [T::ZERO; 2];
        for term in member.terms() {
            let [x, y] = lambda.at(usize::from(term.closure));
            force = [force[0] + term.sign * x, force[1] + term.sign * y];
        }
        (out.force, out.end_force) = (force, force);
    }
    let mut sum = [T::ZERO; 2];
    let mut rows = work.contacts.rows.as_ref().run(0..work.contacts.row_count);
    let fronts = members.iter_mut().zip(work.shape.above.as_mut()).take(model.cells()).enumerate();
    for (cell, (front, above)) in fronts.rev() {
        if cell == state.load_cell {
            // A dead load acts like a contact just above this span.
            sum = [sum[0] + state.load[0], sum[1] + state.load[1]];
        }
        *above = sum;
        front.force = [front.force[0] - sum[0], front.force[1] - sum[1]];
        front.end_force = front.force;
        while let Some((touching, below)) = rows.split_last()
            && cell_of(touching) == cell
        {
            rows = below;
            let part = touching.place.rigid;
            for i in 0..2 {
                let f = touching.multiplier * touching.normal[i];
                sum[i] += f;
                front.end_force[i] -= part * f;
            }
        }
    }
}
