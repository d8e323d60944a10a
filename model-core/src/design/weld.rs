//! Welds: what a rib that is of one piece with a beam does to both.
//!
//! Seven numbers per weld, from linear finite elements of the junction alone (`weld_tables.rs`): over how much of its length the beam does not bend and where that lies, how far inside the face the rib bends, how the beam's
//! shear turns the rib, how the rib's own does, and how much less the beam stretches and shears. They depend on the angle between rib and
//! beam, on the ratio of their thicknesses and on the radius of the fillets, and on Poisson's ratio by less than a tenth.

use super::junction::face_distances;
use super::weld_tables::{COUPLING, LEAN, ROOT, SHEAR, STIFF, STRETCH, TURN};
use super::{Beam, Design, LamellaKind, RibEnds, Ribs};

/// Angles between rib and beam, degrees, and thicknesses of the rib over the beam's, of the tables' rows and columns.
const ANGLES: [f64; 5] = [90.0, 75.0, 60.0, 45.0, 30.0];
const RATIOS: [f64; 5] = [0.2, 0.5, 1.0, 1.5, 2.0];
/// Radii of the fillets over the rib's thickness, of the tables' levels.
const FILLETS: [f64; 4] = [0.0, 0.5, 1.0, 2.0];
/// Largest radius of a fillet, over the rib's thickness.
pub(super) const LARGEST_FILLET: f64 = 2.0;
/// A fillet takes this part of its reach into the acute corner from the depth of the rib's root: derivation (74). What the table adds changes little with
/// the angle.
pub(super) const FILLET_ROOT: f64 = 0.8;

/// The seven numbers of a weld, dimensionless, from the ratio of the rib's thickness to the beam's, the angle between both, degrees, and the
/// fillets' radius over the rib's thickness: the stiffened length over w²/t (w the root's length along the beam's face without fillets, t
/// the beam's thickness), its middle's distance from the crossing of the axes over that of the root's middle, the root's depth over the
/// rib's thickness, the turn of the rib over the beam's shear strain and over its own, and the lengths by which the beam stretches and
/// shears more than to the crossing, over w²/t. Between the angles, ratios and radii that were computed (30 to 90°, 0.2 to 2, 0 to 2) they
/// are interpolated, beyond those they stay.
#[inline(never)]
pub fn weld_numbers(ratio: f64, degrees: f64, fillet: f64) -> [f64; 7] {
    let (row, down) = position(&ANGLES.map(|angle| -angle), -degrees);
    let (column, right) = position(&RATIOS, ratio);
    let fillet = fillet.clamp(0.0, LARGEST_FILLET);
    let weights = levels(fillet);
    let mut numbers = [&STIFF, &LEAN, &ROOT, &COUPLING, &TURN, &STRETCH, &SHEAR].map(|table| {
        let level = |(level, weight): (&[[i16; 5]; 5], f64)| {
            if weight == 0.0 {
                return 0.0;
            }
            let at =
                |i: usize, j: usize| f64::from(level.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0)) * 1e-3;
            let along = |i: usize| at(i, column) + right * (at(i, column + 1) - at(i, column));
            weight * (along(row) + down * (along(row + 1) - along(row)))
        };
        table.iter().zip(weights).map(level).sum::<f64>()
    });
    if fillet > 0.0 {
        let half = 0.5 * degrees.clamp(ANGLES[4], ANGLES[0]).to_radians();
        let [_, _, root, ..] = &mut numbers;
        *root -= FILLET_ROOT * fillet * libm::cos(half) / libm::sin(half);
    }
    numbers
}

/// Weights of the tables' levels: a parabola through the first three, beyond them a straight line.
fn levels(fillet: f64) -> [f64; 4] {
    let [_, half, whole, most] = FILLETS;
    if fillet <= whole {
        let (a, b) = (fillet / half, fillet / whole);
        return [
            (1.0 - a) * (1.0 - b),
            a * (whole - fillet) / (whole - half),
            b * (fillet - half) / (whole - half),
            0.0,
        ];
    }
    let part = (fillet - whole) / (most - whole);
    [0.0, 0.0, 1.0 - part, part]
}

/// The interval of ascending knots in which a value lies, and where in it, 0 … 1.
fn position(knots: &[f64; 5], value: f64) -> (usize, f64) {
    let mut interval = 0;
    for (at, pair) in knots.windows(2).enumerate() {
        if let &[low, high] = pair
            && (value >= low || at == 0)
        {
            interval = at;
            if value < high {
                return (at, ((value - low) / (high - low)).clamp(0.0, 1.0));
            }
        }
    }
    (interval, 1.0)
}

/// What a weld does to one of the rods that end there, an arm of the beam or the rib.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Arm {
    /// Lengths by which it stretches and shears more than what bends of it, mm.
    pub extra_length: [f64; 2],
    /// Angle by which its shear force turns the rib against it, over its shear strain.
    pub turn: f64,
}

/// A rib's two welds, front and back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Weld {
    /// Along the beams' centrelines from the rib's axis, mm: the beam does not bend from so far below it to so far above it. An inclined
    /// rib's root does not lie about its axis, so that one of them may be negative.
    pub reach: [[f64; 2]; 2],
    /// Distance from the beams' centrelines along the rib to where it begins to bend, mm.
    pub start: [f64; 2],
    /// Turn of the rib over each beam's shear strain.
    pub coupling: [f64; 2],
    /// Turn of the rib's two ends over its own shear strain.
    pub turn: [f64; 2],
    /// Lengths by which each beam stretches and shears more than to the crossing with the rib's axis, below and above it alike, mm.
    pub extra_length: [[f64; 2]; 2],
    /// The back end lies on the part of the back beam that is held, or reaches it: it does not turn.
    pub held: bool,
}

impl Weld {
    /// Those of rib k; lamellae that are not welded ribs stiffen nothing, nor does the end of one that is free.
    // Double precision is software on the microcontroller: one copy for all who ask.
    #[inline(never)]
    pub fn of(design: &Design, lamella: usize) -> Self {
        let LamellaKind::Rib(Ribs { ends: RibEnds::Welded | RibEnds::Gap(_), fillet, .. }) = design.lamellae.kind
        else {
            return Self { held: design.is_held(lamella), ..Self::default() };
        };
        let arcs = design.attachment_arcs(lamella);
        let (p, q) = (design.front.point(arcs[0]), design.back.point(arcs[1]));
        let width = libm::hypot(q[0] - p[0], q[1] - p[1]);
        let along = [(q[0] - p[0]) / width, (q[1] - p[1]) / width];
        let ribs = design.lamella_thickness(lamella);
        let faces = face_distances(design, lamella);
        let mut weld = Self::default();
        for (side, (beam, outwards)) in [(&design.front, 1.0), (&design.back, -1.0)].into_iter().enumerate() {
            if side == 1 && design.lamellae.gap().is_some() {
                weld.start[1] = clear_of_back(design, lamella, faces[1]);
                return weld;
            }
            let (rib, arc) = (ribs[side], arcs[side]);
            let end = Self::end(beam, arc, along.map(|part| outwards * part), rib, fillet);
            (weld.reach[side], weld.coupling[side]) = (end.reach, end.coupling);
            (weld.turn[side], weld.extra_length[side]) = (end.turn, end.extra_length);
            weld.start[side] = end.start(faces[side]);
        }
        weld.held = arcs[1] - weld.reach[1][0] <= design.back.clamp;
        if weld.held {
            // What is held gives no way: the rib bends from the face on, or from where its fillets let it.
            let sharp = Self::end(&design.back, arcs[1], along.map(|part| -part), ribs[1], 0.0).start(faces[1]);
            (weld.start[1], weld.coupling[1], weld.turn[1]) = (faces[1] + weld.start[1] - sharp, 0.0, 0.0);
        }
        weld
    }

    /// Where rib k's two ends, front and back, lie on the beams' inner faces.
    pub(super) fn roots(design: &Design, lamella: usize) -> [Root; 2] {
        let arcs = design.attachment_arcs(lamella);
        let (p, q) = (design.front.point(arcs[0]), design.back.point(arcs[1]));
        let width = libm::hypot(q[0] - p[0], q[1] - p[1]);
        let (ribs, faces) = (design.lamella_thickness(lamella), face_distances(design, lamella));
        let gap = design.lamellae.gap().is_some();
        let root = |beam: &Beam, arc: f64, outwards: f64, rib: f64, face: f64| {
            let along = [(q[0] - p[0]) / width, (q[1] - p[1]) / width].map(|part| outwards * part);
            let e = beam.direction(arc);
            let cosine = e[0] * along[0] + e[1] * along[1];
            let sine = (e[0] * along[1] - e[1] * along[0]).abs().max(0.1);
            let lean = cosine / sine;
            let middle = arc + 0.5 * lean * beam.thickness.at(arc);
            let half = 0.5 * rib / sine;
            // A free end has none.
            let part = if gap && outwards < 0.0 { 0.0 } else { 1.0 };
            let fillet = [part * (1.0 - cosine) / sine, part * (1.0 + cosine) / sine];
            Root { edges: [middle - half, middle + half], fillet, lean, face }
        };
        let back = clear_of_back(design, lamella, faces[1]);
        [root(&design.front, arcs[0], 1.0, ribs[0], faces[0]), root(&design.back, arcs[1], -1.0, ribs[1], back)]
    }

    /// The arm below, towards the base, of the front beam (0) or the back beam (1).
    pub fn below(&self, side: usize) -> Arm {
        self.arm(side, 0)
    }

    /// The arm above.
    pub fn above(&self, side: usize) -> Arm {
        self.arm(side, 1)
    }

    fn arm(&self, side: usize, end: usize) -> Arm {
        if self.held && side == 1 {
            return Arm::default();
        }
        Arm {
            extra_length: self.extra_length[side].map(|length| self.reach[side][end] + length),
            turn: self.coupling[side],
        }
    }

    /// The rib's two ends.
    pub fn rib(&self) -> [Arm; 2] {
        self.turn.map(|turn| Arm { turn, ..Arm::default() })
    }

    /// One end: `along` leads from the beam into the rib.
    #[inline(never)]
    fn end(beam: &Beam, arc: f64, along: [f64; 2], rib: f64, fillet: f64) -> End {
        let (e, thickness) = (beam.direction(arc), beam.thickness.at(arc));
        let cosine = e[0] * along[0] + e[1] * along[1];
        let sine = (e[0] * along[1] - e[1] * along[0]).abs().max(0.1);
        let [stiff, lean, root, coupling, turn, stretch, shear] =
            weld_numbers(rib / thickness, libm::asin(sine.min(1.0)).to_degrees(), fillet / rib);
        let half = 0.5 * rib * rib / (sine * sine * thickness);
        // On the side to which the rib leans.
        let middle = 0.5 * lean * thickness * cosine / sine;
        let reach = [half * stiff - middle, half * stiff + middle];
        End { reach, root: root * rib, coupling, turn, extra_length: [half * stretch, half * shear] }
    }
}

/// Where a rib's end lies on a beam's inner face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Root {
    /// Arcs along the centreline across from its lower and upper edge, mm; on a curved beam those of a straight one that touches it there.
    pub edges: [f64; 2],
    /// Lengths of the face that the lower and the upper fillet take, over their radius.
    pub fillet: [f64; 2],
    /// Cotangent of the angle between beam and rib, positive where the rib leans towards the tip.
    pub lean: f64,
    /// Distance from the centreline to the face along the rib, or to its free end, mm.
    pub face: f64,
}

/// Distance along rib k from the back beam's centreline to where the rib ends: that to the face, mm, or so much more as there is a gap.
pub(super) fn clear_of_back(design: &Design, lamella: usize, face: f64) -> f64 {
    let half = 0.5 * design.back.thickness.at(design.attachment_arcs(lamella)[1]);
    face * (1.0 + design.lamellae.gap().unwrap_or(0.0) / half)
}

struct End {
    reach: [f64; 2],
    root: f64,
    coupling: f64,
    turn: f64,
    extra_length: [f64; 2],
}

impl End {
    /// Distance from the beam's centreline to where the rib begins to bend; the face is so far away along the rib.
    fn start(&self, face: f64) -> f64 {
        (face - self.root).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_met_at_its_knots_and_in_between() {
        for (level, fillet) in FILLETS.into_iter().enumerate() {
            for (i, angle) in ANGLES.into_iter().enumerate() {
                for (j, ratio) in RATIOS.into_iter().enumerate() {
                    let mut found = weld_numbers(ratio, angle, fillet);
                    found[2] += FILLET_ROOT * fillet / libm::tan(0.5 * angle.to_radians());
                    for (found, table) in found.into_iter().zip([STIFF, LEAN, ROOT, COUPLING, TURN, STRETCH, SHEAR]) {
                        let table = 1e-3 * f64::from(table[level][i][j]);
                        assert!((found - table).abs() < 1e-12, "{angle}° {ratio} {fillet}");
                    }
                }
            }
        }
        let middle = weld_numbers(0.75, 82.5, 0.0)[2];
        assert!((middle - 0.25 * (0.399 + 0.339 + 0.369 + 0.312)).abs() < 1e-12);
        assert_eq!(weld_numbers(0.05, 90.0, 0.0), weld_numbers(0.2, 90.0, 0.0));
        assert_eq!(weld_numbers(7.0, 10.0, 3.0), weld_numbers(2.0, 30.0, 2.0));
    }
}
