//! Rungs: hinges and bar, pins, welds, ribs, each a chain of parts; and the rigid part at the tip.

use super::plate::{Plate, plate_factor};
use super::rod::{Piece, Rod, write_gap, write_point, write_rod};
use super::section::compliance;
use super::welded::Welded;
use super::{Discretisation, DiscretiseError, Elements, Physics, Scheme};
use crate::access::Access as _;
use crate::design::junction::{BAR_ROOT, BEAM_ROOT, face_distances};
use crate::design::weld::Weld;
use crate::design::{Beam, Design, HingeFrom, HingeKind, Ribs};
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
    /// Its back end lies on the part of the back beam that is held.
    pub held: bool,
    /// The next free node.
    pub node: usize,
}

/// How far lamella k's welds stiffen the beams: not in the physics `paper`, which has no cross-sections.
#[inline(never)]
pub(super) fn weld(design: &Design, how: &Discretisation, lamella: usize) -> Weld {
    if how.physics == Physics::Paper {
        Weld { held: design.is_held(lamella), ..Weld::default() }
    } else {
        Weld::of(design, lamella)
    }
}

/// Length of a rib in thicknesses from which it has an element more: it buckles before it is compressed much.
const SLENDER: f64 = 14.0;

/// Elements of a rib of a length and a thickness: about half those of a span and one, or as long as those of the front beam.
#[inline(never)]
fn rib_elements(design: &Design, how: &Discretisation, length: f64, thickness: f64) -> u16 {
    let least = match how.elements {
        Elements::PerSpan { span, .. } => span / 2 + 1,
        Elements::PerBeam { beam, .. } => {
            let longest = design.front.length() / f64::from(beam);
            (libm::ceil(length / longest) as u16).max(3)
        }
    };
    least + u16::from(length > SLENDER * thickness)
}

/// What a rung is made along: its axis, and the sections that its ends have.
struct Axis<'a> {
    design: &'a Design,
    how: &'a Discretisation,
    /// From the front beam's centreline to the back beam's.
    along: [f64; 2],
    /// Perpendicular to the plane, mm.
    width: f64,
}

impl Axis<'_> {
    /// Bending stiffness of a section of this thickness in a part that is held as a plate is, N·mm².
    #[inline(never)]
    fn bending(&self, t: f64, plate: &Plate) -> f64 {
        let (design, w) = (self.design, self.width);
        let plate = Plate { width: w, thickness: t, ..*plate };
        design.material.youngs_modulus * w * t * t * t / 12.0 * plate_factor(design, &plate)
    }

    /// A straight rod of pieces whose sections have this area, on the mean.
    #[inline(never)]
    fn rod<'r>(&self, pieces: &'r [Piece<'r>], direction: &'r dyn Fn(f64) -> [f64; 2], area: f64) -> Rod<'r> {
        let compliance = compliance(self.design, self.how.physics, area);
        let stiffening = 3.0 * self.design.material.law.second_order() * compliance[0];
        Rod { pieces, direction, compliance, stiffening, backwards: false }
    }
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
    let axis = Axis { design, how, along, width: design.width.at(0.5 * (p[1] + q[1])) };
    let link = |length: f64| Part::Link([length * along[0], length * along[1]]);
    let ribs = design.lamellae.ribs();
    match (design.joint(), ribs) {
        (HingeKind::Welded, Some(ribs)) => return with_weld(&axis, ribs, lamella, width, with),
        (HingeKind::Welded, None) => return with(&[link(width)]),
        (HingeKind::Pinned, _) => return with(&[Part::Pin, link(width), Part::Pin]),
        (HingeKind::Flexible, _) => {}
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
    let plate = Plate::of_rung(design, lamella);
    let stiffness = axis.bending(t, &plate);
    let neck = Piece { elements, length, bending: &|_: f64| stiffness, thickness: &|_: f64| t };
    let direction = |_: f64| along;
    let Some(ribs) = ribs else {
        let pieces = [neck];
        let hinge = axis.rod(&pieces, &direction, axis.width * t);
        return with(&[link(starts[0]), Part::Rod(&hinge), link(bar), Part::Rod(&hinge), link(starts[1])]);
    };
    // A rib with necks is one rod: were its ends joints, a rung would have more of them than the band has room for.
    let [front, back] = design.lamella_thickness(lamella);
    let thickness = |at: f64| front + at * (back - front);
    let bending = |at: f64| ribs.bending_factor * axis.bending(thickness(at), &plate);
    let rib_elements = rib_elements(design, how, bar, 0.5 * (front + back));
    let rib = Piece { elements: rib_elements, length: bar, bending: &bending, thickness: &thickness };
    // The necks' area at their length, the rib's at its own: it is their sum that gives way.
    let rib_area = ribs.stretch_factor * mean_area(&axis, &thickness);
    let whole = 2.0 * length + bar;
    let area = whole / (2.0 * length / (axis.width * t) + bar / rib_area);
    let mut with_rod = |pieces: &[Piece<'_>]| {
        let rod = axis.rod(pieces, &direction, area);
        with(&[link(starts[0]), Part::Rod(&rod), link(starts[1])]);
    };
    let pieces = [neck, rib, neck];
    if how.scheme == Scheme::Simpson {
        return with_rod(&pieces);
    }
    // Links are of one length, a neck's: a spring gives way as what lies about it does.
    let links = libm::ceil(whole * f64::from(elements) / length);
    let about = |at: f64, sum: &dyn Fn(&Piece<'_>, f64, f64) -> f64| {
        let (low, high) = ((at - 0.5 / links).max(0.0) * whole, (at + 0.5 / links).min(1.0) * whole);
        let (mut from, mut total) = (0.0, 0.0);
        for piece in &pieces {
            let (begin, end) = (low.max(from), high.min(from + piece.length));
            if end > begin {
                total += sum(piece, (0.5 * (begin + end) - from) / piece.length, (end - begin) / (high - low));
            }
            from += piece.length;
        }
        total
    };
    let bending = |at: f64| 1.0 / about(at, &|piece, within, share| share / (piece.bending)(within));
    let thickness = |at: f64| about(at, &|piece, within, share| share * (piece.thickness)(within));
    with_rod(&[Piece { elements: links as u16, length: whole, bending: &bending, thickness: &thickness }]);
}

/// Harmonic mean of a tapered rib's area: a force stretches it as much.
#[inline(never)]
fn mean_area(axis: &Axis<'_>, thickness: &dyn Fn(f64) -> f64) -> f64 {
    let inverse = |at: f64| 1.0 / thickness(at);
    6.0 * axis.width / (inverse(0.0) + 4.0 * inverse(0.5) + inverse(1.0))
}

/// Hands the parts of a welded rib to `with`, or of one that is welded to the front beam and free before the back beam. The joints lie at the
/// welds' upper ends, from where links lead to the rib's axis.
#[inline(never)]
fn with_weld(axis: &Axis<'_>, ribs: &Ribs, lamella: usize, width: f64, with: &mut dyn FnMut(&[Part<&Rod<'_>>])) {
    let Axis { design, how, along, .. } = *axis;
    let weld = weld(design, how, lamella);
    let arcs = design.attachment_arcs(lamella);
    // From the axis to the weld's upper end.
    let up = [(&design.front, 0), (&design.back, 1)].map(|(beam, side): (&Beam, usize)| {
        let (on, top) = (beam.point(arcs[side]), beam.point(arcs[side] + weld.reach[side][1]));
        [top[0] - on[0], top[1] - on[1]]
    });
    let [front, back] = weld.start;
    let before = [0, 1].map(|i| front * along[i] - up[0][i]);
    let behind = [0, 1].map(|i| back * along[i] + up[1][i]);
    let length = width - front - back;
    // The taper is that between the beams' faces, or to the free end; beyond them the thickness stays.
    let [front_face, back_face] = face_distances(design, lamella);
    let gap = design.lamellae.gap();
    let faces = [front_face, if gap.is_some() { back } else { back_face }];
    let [thin, other] = design.lamella_thickness(lamella);
    let thickness = |at: f64| {
        let part = (front + at * length - faces[0]) / (width - faces[0] - faces[1]);
        thin + part.clamp(0.0, 1.0) * (other - thin)
    };
    let plate = Plate::of_rung(design, lamella);
    let plain = |at: f64| ribs.bending_factor * axis.bending(thickness(at), &plate);
    let area = ribs.stretch_factor * mean_area(axis, &thickness);
    let welded = Welded::new(compliance(design, how.physics, area), weld.rib(), length, plain(0.5));
    let bending = |at: f64| plain(at) * welded.bending(at);
    let elements = rib_elements(design, how, length, 0.5 * (thin + other));
    let pieces = [Piece { elements, length, bending: &bending, thickness: &thickness }];
    let direction = |_: f64| along;
    let rib = Rod { compliance: welded.compliance, ..axis.rod(&pieces, &direction, area) };
    let Some(gap) = gap else { return with(&[Part::Link(before), Part::Rod(&rib), Part::Link(behind)]) };
    // Across the gap, from the rib's end to the foot of the perpendicular on the face.
    let [x, y] = design.back.direction(arcs[1]);
    let across = if along[0] * y - along[1] * x > 0.0 { [y, -x] } else { [-y, x] };
    let behind = [0, 1].map(|i| back * along[i] - gap * across[i]);
    with(&[Part::Link(before), Part::Rod(&rib), Part::Gap(gap, across), Part::Link(behind)]);
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
        let [mut start, mut end] = part.joints.map(|joint| slot.joints.as_slice().at(joint));
        let (mut rigid_start, mut rigid_end) = (part.rigid_start, part.rigid_end);
        let mut sign = 1.0;
        let backwards = slot.held && part.rod.is_some();
        if backwards {
            // It leads from the held beam to the front one.
            let back = |vector: [f64; 2]| vector.map(|part| -part);
            (start, end, sign) = (end, start, -1.0);
            (rigid_start, rigid_end) = (back(rigid_end), back(rigid_start));
        }
        let made = match (part.rod, part.gap) {
            (Some(rod), _) => write_rod(model, how.scheme, node, &Rod { backwards, ..*rod }),
            (None, Some(gap)) => write_gap(model, how.scheme, node, gap),
            (None, None) => write_point(model, how.scheme, node),
        };
        written = made.and_then(|mut member| {
            let lamella = slot.lamella as u8;
            member.role = if part.gap.is_some() { Role::Gap(lamella) } else { Role::Rung(lamella, number) };
            (member.start, member.end) = (start, end);
            (member.rigid_start, member.rigid_end) = (rigid_start.map(T::of), rigid_end.map(T::of));
            (node, number) = (member.nodes().end, number + 1);
            // From front to back: with the cell below, against the one above.
            let entered = [(slot.closures[0], sign), (slot.closures[1], -sign)];
            let index = model.topology.add_member(member, &entered).ok_or(DiscretiseError::Capacity)?;
            if let Some(rod) = part.rod {
                let (length, stiffness) = rod.size();
                model.topology.add_scale(index, stiffness, length);
            }
            Ok(())
        });
    });
    written.map(|()| node)
}
