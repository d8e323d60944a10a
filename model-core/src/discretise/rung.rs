//! Rungs: hinges and bar, pins, welds, ribs, each a chain of parts; and the rigid part at the tip.

use super::rod::{Rod, write_point, write_rod};
use super::section::{compliance, plate_factor};
use super::{Discretisation, DiscretiseError};
use crate::access::Access as _;
use crate::design::junction::{BAR_ROOT, BEAM_ROOT, face_distances};
use crate::design::{Design, HingeFrom, HingeKind};
use crate::model::Model;
use crate::real::Real;
use crate::size::Size;
use crate::topology::{Part, Role, Rung};

/// Rigid vector from the end of a beam's flexible part to the front beam's tip.
pub(super) fn rigid_tip(design: &Design, side: usize, ends: [f64; 2]) -> [f64; 2] {
    let beam = [&design.front, &design.back][side];
    let end = beam.point(ends[side]);
    let tip = design.front.tip;
    let offset = [tip[0] - end[0], tip[1] - end[1]];
    // The front beam without a wedge ends at the tip: no rounding residue.
    if design.rigid_above.is_none() && side == 0 { [0.0; 2] } else { offset }
}

/// Most joints of a rung: what the band of the factorisation has room for, a front, a back and one between.
pub(super) const MOST_JOINTS: usize = 3;

/// Where a rung is in the topology: its number, its joints front to back, its closure and the next one.
pub(super) struct Slot {
    pub lamella: usize,
    pub joints: [u16; MOST_JOINTS],
    pub closures: [u16; 2],
    /// The next free node.
    pub node: usize,
}

/// Hands the parts of a design's rung to `with`, front to back.
// Double precision is software on the microcontroller: one copy for all who ask.
#[inline(never)]
pub(super) fn with_parts(
    design: &Design,
    how: &Discretisation,
    lamella: usize,
    elements: u16,
    with: &mut dyn FnMut(&[Part<&Rod<'_>>]),
) {
    let arcs = design.attachment_arcs(lamella);
    let (p, q) = (design.front.point(arcs[0]), design.back.point(arcs[1]));
    let width = design.lamella_width(lamella);
    let along = [(q[0] - p[0]) / width, (q[1] - p[1]) / width];
    let link = |length: f64| Part::Link([length * along[0], length * along[1]]);
    match design.hinge.kind {
        HingeKind::Welded => return with(&[link(width)]),
        HingeKind::Pinned => return with(&[Part::Pin, link(width), Part::Pin]),
        HingeKind::Flexible => {}
    }
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
    let hinge = Rod {
        elements,
        length,
        direction: &|_: f64| along,
        bending: &|_: f64| stiffness,
        thickness: &|_: f64| t,
        compliance,
        stiffening: 3.0 * design.material.law.second_order() * compliance[0],
    };
    with(&[link(starts[0]), Part::Rod(&hinge), link(bar), Part::Rod(&hinge), link(starts[1])]);
}

/// Writes a rung's members; returns the next free node.
pub(super) fn write_rung<T: Real, S: Size>(
    model: &mut Model<T, S>,
    how: &Discretisation,
    slot: &Slot,
    parts: &[Part<&Rod<'_>>],
) -> Result<usize, DiscretiseError> {
    let (mut node, mut number, mut written) = (slot.node, 0, Ok(()));
    Rung::members(parts, |part| {
        if written.is_err() {
            return;
        }
        let made = match part.rod {
            Some(rod) => write_rod(model, how.scheme, node, rod),
            None => write_point(model, how.scheme, node),
        };
        written = made.and_then(|mut member| {
            let [start, end] = part.joints.map(|joint| slot.joints.as_slice().at(joint));
            (member.role, member.start, member.end) = (Role::Rung(slot.lamella as u8, number), start, end);
            (member.rigid_start, member.rigid_end) = (part.rigid_start.map(T::of), part.rigid_end.map(T::of));
            (node, number) = (member.nodes().end, number + 1);
            // It leads from front to back: with the cell below, against the one above.
            let entered = [(slot.closures[0], 1.0), (slot.closures[1], -1.0)];
            let index = model.topology.add_member(member, &entered).ok_or(DiscretiseError::Capacity)?;
            if let Some(rod) = part.rod {
                model.topology.add_scale(index, (rod.bending)(0.5) / rod.length, rod.length);
            }
            Ok(())
        });
    });
    written.map(|()| node)
}
