//! Ribs that end with a gap before the back beam: whether they touch it, and what follows for the closures (78)–(80).
//!
//! Such a rib's way through its gap, u, is whatever closes the cell below it. The force f through the rib vanishes where the gap is open; where
//! it is shut, u has no part across it and f none along it. Of a pair of what must vanish, the closure of the cell below thus keeps the
//! part across a shut gap, and has the force in place of the rest; the closure of the cell above gets both cells' errors.
//!
//! There the force has a compliance C, which is also the matrix's. After a step, f is as large as the motion of the members around divided
//! by C; it vanishes as the steps do.

use super::kinematics::Kinematics;
use crate::access::Access;
use crate::element::{Node, Strain};
use crate::model::Model;
use crate::real::Real;
use crate::size::Size;
use crate::topology::{Kind, Member};

/// By how much C is more than the flexibility of the members around: what is left of the force then falls to a hundredth or less with each
/// step, and single precision has digits to spare.
const LOOSE: f64 = 4096.0;
/// The same for a single step, over the root of the precision.
const SINGLE: f64 = 0.1;

/// The gaps, base to tip: a member and its index, and the closures below and above.
fn gaps<T: Real, S: Size>(model: &Model<T, S>) -> impl DoubleEndedIterator<Item = (usize, &Member<T>, [usize; 2])> {
    let members = if model.topology.gaps == 0 { &[] } else { model.members() };
    members.iter().enumerate().filter(|(_, member)| member.kind == Kind::Gap).map(|(index, member)| {
        let [below, above] = member.terms.map(|term| usize::from(term.closure));
        (index, member, [below, above])
    })
}

/// Whether a gap is shut, as its first node keeps it: a gap bends nothing.
fn is_shut<T: Real>(node: &Node<T>) -> bool {
    node.bent[0] != T::ZERO
}

/// The gaps' first nodes.
fn nodes<'a, T: Real, S: Size>(
    model: &'a Model<T, S>,
    kinematics: &'a Kinematics<T, S>,
) -> impl Iterator<Item = (usize, &'a Node<T>)> {
    let first = gaps(model).map(|(_, member, _)| usize::from(member.first));
    first.filter_map(|first| Some((first, kinematics.nodes.as_ref().get(first)?)))
}

/// Some gap is shut.
pub(super) fn any_shut<T: Real, S: Size>(model: &Model<T, S>, kinematics: &Kinematics<T, S>) -> bool {
    nodes(model, kinematics).any(|(_, node)| is_shut(node))
}

/// Notes which gaps are shut among the factors of the members' interiors, of which a gap has none.
pub(super) fn note<T: Real, S: Size>(model: &Model<T, S>, kinematics: &Kinematics<T, S>, interiors: &mut [[T; 3]]) {
    for (first, node) in nodes(model, kinematics) {
        interiors.put(first, [node.bent[0]; 3]);
    }
}

/// The gaps are shut that have been noted, and no others.
pub(super) fn are_as_noted<T: Real, S: Size>(
    model: &Model<T, S>,
    kinematics: &Kinematics<T, S>,
    interiors: &[[T; 3]],
) -> bool {
    nodes(model, kinematics).all(|(first, node)| interiors.at(first)[0] == node.bent[0])
}

fn dot<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[0] + a[1] * b[1]
}

/// Takes the ways through the gaps from the closures' errors without them, says which gaps are shut, and adds to the joints' gradients. The error
/// of the closure below becomes what must vanish there, as a length: the force by the members' flexibility.
pub(super) fn close<T: Real, S: Size>(
    model: &Model<T, S>,
    kinematics: &mut Kinematics<T, S>,
    errors: &mut [[T; 2]],
    joints: &mut [T],
) {
    for (index, member, [below, above]) in gaps(model) {
        let (nodes, members) = (kinematics.nodes.as_mut(), kinematics.members.as_mut());
        let (Some(node), Some(out)) = (nodes.get_mut(usize::from(member.first)), members.get_mut(index)) else {
            continue;
        };
        let flexibility = model.topology.scale.as_ref().at(member.force_unknown());
        let across = node.e;
        let along = [-across[1], across[0]];
        let way = errors.at(below).map(|error| -error);
        let (width, aside) = (dot(way, across), dot(way, along));
        let (pressed, slid) = (dot(out.force, across), dot(out.force, along));
        let is_shut = flexibility * pressed > width;
        node.bent = [if is_shut { T::one() } else { T::ZERO }, T::ZERO];
        let left = if is_shut {
            node.gradient = -(pressed * aside);
            out.chord = along.map(|part| aside * part);
            [-width, flexibility * slid]
        } else {
            out.chord = way;
            [flexibility * pressed, flexibility * slid]
        };
        soften(node, out, T::of(LOOSE) * flexibility);
        errors.put(below, [0, 1].map(|i| left[0] * across[i] + left[1] * along[i]));
        let [x, y] = errors.at(above);
        errors.put(above, [x - out.chord[0], y - out.chord[1]]);
        let ([fx, fy], [x, y]) = (out.force, out.rigid_start);
        joints.add(usize::from(member.start), node.gradient + fy * x - fx * y);
    }
}

/// Gives a gap its compliance C in the matrix, and what C does to the angle that the gap turns with.
fn soften<T: Real>(node: &mut Node<T>, out: &mut Strain<T>, compliance: T) {
    if !is_shut(node) {
        out.compliance = [-compliance, T::ZERO, -compliance];
        return;
    }
    let across = node.e;
    let along @ [x, y] = [-across[1], across[0]];
    out.compliance = [-(compliance * x * x), -(compliance * x * y), -(compliance * y * y)];
    // The way along the face turns with the back beam, and so does the direction in which the force has no part.
    let (pressed, slid) = (dot(out.force, across), dot(out.force, along));
    let (pull, tangent) = (compliance * pressed, dot(out.chord, along) - compliance * slid);
    node.lever = [0, 1].map(|i| pull * along[i] - tangent * across[i]);
    node.curvature = slid * tangent + pull * pressed;
}

/// Makes C what a single step needs that no other follows: all that the precision has digits for.
pub(crate) fn soften_all<T: Real, S: Size>(model: &Model<T, S>, kinematics: &mut Kinematics<T, S>) {
    let loose = (T::of(SINGLE) / T::EPSILON.sqrt()).max(T::of(LOOSE));
    for (index, member, _) in gaps(model) {
        let (nodes, members) = (kinematics.nodes.as_mut(), kinematics.members.as_mut());
        let (Some(node), Some(out)) = (nodes.get_mut(usize::from(member.first)), members.get_mut(index)) else {
            continue;
        };
        soften(node, out, loose * model.topology.scale.as_ref().at(member.force_unknown()));
    }
}

/// Puts the forces with the compliance that the matrix has in the place of those by the members' flexibility, and takes from the ways through
/// the gaps what it gives to them: both closures' errors together stay as they are.
pub(super) fn loosen<T: Real, S: Size>(
    model: &Model<T, S>,
    kinematics: &Kinematics<T, S>,
    errors: &mut [[T; 2]],
    joints: &mut [T],
) {
    // From the tip, so that what a closure gets from below comes after what it has itself.
    for (index, member, [below, above]) in gaps(model).rev() {
        let node = kinematics.nodes.as_ref().at(usize::from(member.first));
        let (across, is_shut) = (node.e, is_shut(&node));
        let error = errors.at(below);
        let mut kept = [T::ZERO; 2];
        if is_shut {
            let part = dot(error, across);
            kept = across.map(|direction| part * direction);
        }
        let given = [0, 1].map(|i| T::of(LOOSE) * (error[i] - kept[i]));
        errors.put(below, [0, 1].map(|i| kept[i] - given[i]));
        let [x, y] = errors.at(above);
        errors.put(above, [x + given[0], y + given[1]]);
        if is_shut {
            let force = kinematics.members.as_ref().get(index).map_or([T::ZERO; 2], |out| out.force);
            let slid = given[1] * across[0] - given[0] * across[1];
            joints.add(usize::from(member.start), dot(force, across) * slid);
        }
    }
}
