//! Rungs: front hinge, lamella and back hinge; and the rigid part at the tip.

use super::rod::{Rod, write_point, write_rod};
use super::section::{compliance, plate_factor};
use super::{Discretisation, DiscretiseError};
use crate::access::Access as _;
use crate::design::junction::{BAR_ROOT, BEAM_ROOT, face_distances};
use crate::design::{Design, HingeFrom, HingeKind};
use crate::ladder::Ladder;
use crate::real::Real;
use crate::size::Size;

/// Rigid vector from the end of a beam's flexible part to the front beam's tip.
pub(super) fn rigid_tip(design: &Design, side: usize, ends: [f64; 2]) -> [f64; 2] {
    let beam = [&design.front, &design.back][side];
    let end = beam.point(ends[side]);
    let tip = design.front.tip;
    let offset = [tip[0] - end[0], tip[1] - end[1]];
    // The front beam without a wedge ends at the tip: no rounding residue.
    if design.rigid_above.is_none() && side == 0 { [0.0; 2] } else { offset }
}

pub(super) fn write_hinges<T: Real, S: Size>(
    ladder: &mut Ladder<T, S>,
    design: &Design,
    how: &Discretisation,
    lamella: usize,
    elements: u16,
    node: usize,
) -> Result<usize, DiscretiseError> {
    let arcs = design.attachment_arcs(lamella);
    let (p, q) = (design.front.point(arcs[0]), design.back.point(arcs[1]));
    let width = design.lamella_width(lamella);
    let along = [(q[0] - p[0]) / width, (q[1] - p[1]) / width];
    let scaled = |length: f64| [length * along[0], length * along[1]];
    let (mut front, mut back, stiffness, length) = if design.hinge.kind == HingeKind::Flexible {
        let t = design.hinge.thickness;
        let clear = design.hinge.length_of(lamella);
        let (length, starts, bar) = match design.hinge.from {
            HingeFrom::Centreline => (clear, [0.0; 2], width - 2.0 * clear),
            HingeFrom::Face => {
                let faces = face_distances(design, lamella);
                let bar = width - faces[0] - faces[1] - 2.0 * clear - 2.0 * BAR_ROOT * t;
                (clear + (BEAM_ROOT + BAR_ROOT) * t, faces.map(|face| face - BEAM_ROOT * t), bar)
            }
        };
        let w = design.width.at(0.5 * (p[1] + q[1]));
        let stiffness = design.material.youngs_modulus * w * t * t * t / 12.0 * plate_factor(design, w, t);
        let compliance = compliance(design, how.physics, w * t);
        let bending = |_: f64| stiffness;
        let thickness = |_: f64| t;
        let direction = |_: f64| along;
        let rod = |rigid_start, rigid_end| Rod {
            elements,
            length,
            direction: &direction,
            bending: &bending,
            thickness: &thickness,
            compliance,
            stiffening: 3.0 * design.material.law.second_order() * compliance[0],
            rigid_start,
            rigid_end,
        };
        let front = write_rod(ladder, how.scheme, node, &rod(scaled(starts[0]), [0.0; 2]))?;
        let back = write_rod(ladder, how.scheme, front.nodes().end, &rod(scaled(bar), scaled(starts[1])))?;
        (front, back, stiffness / length, length)
    } else {
        let front = write_point(ladder, node, [0.0; 2])?;
        let back = write_point(ladder, front.nodes().end, scaled(width))?;
        (front, back, 0.0, 0.0)
    };
    (front.start, front.end) = (ladder.joint(lamella, 2), ladder.joint(lamella, 3));
    (back.start, back.end) = (ladder.joint(lamella, 3), ladder.joint(lamella, 4));
    for (side, member) in [front, back].into_iter().enumerate() {
        ladder.members.as_mut().put(4 * lamella + 2 + side, member);
        ladder.add_scale(4 * lamella + 2 + side, stiffness, length);
    }
    Ok(back.nodes().end)
}
