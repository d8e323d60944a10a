//! Welds: what a rib that is of one piece with a beam does to both.
//!
//! Three numbers per weld, from linear finite elements of the junction alone (`tests/reference/src/junction.rs`, which makes the tables
//! below): over how much of its length the beam does not bend, how far inside the face the rib bends, and how the beam's shear turns the
//! rib. They depend on the angle between rib and beam and on the ratio of their thicknesses, and on Poisson's ratio by less than a tenth.

use super::junction::face_distances;
use super::{Beam, Design, LamellaKind, RibEnds, Ribs};

/// Angles between rib and beam, degrees, and thicknesses of the rib over the beam's, of the tables' rows and columns.
const ANGLES: [f64; 5] = [90.0, 75.0, 60.0, 45.0, 30.0];
const RATIOS: [f64; 5] = [0.2, 0.5, 1.0, 1.5, 2.0];
type Table = [[f64; 5]; 5];

/// Length over which the beam does not bend, over w²/t with w the root's length along the face and t the beam's thickness.
const STIFF: Table = [
    [0.217, 0.227, 0.239, 0.239, 0.230],
    [0.216, 0.227, 0.239, 0.238, 0.227],
    [0.215, 0.228, 0.238, 0.233, 0.219],
    [0.213, 0.228, 0.232, 0.218, 0.198],
    [0.205, 0.217, 0.206, 0.181, 0.158],
];
/// Depth inside the beam's face from which the rib bends, over the rib's thickness.
const ROOT: Table = [
    [0.411, 0.398, 0.339, 0.245, 0.139],
    [0.379, 0.356, 0.276, 0.177, 0.086],
    [0.283, 0.251, 0.162, 0.078, 0.027],
    [0.100, 0.062, -0.014, -0.045, -0.023],
    [-0.259, -0.293, -0.309, -0.236, -0.098],
];
/// Angle by which a shear force in the beam turns the rib, over the beam's shear strain: the rib goes with the face, not with the section.
const COUPLING: Table = [
    [0.845, 0.806, 0.709, 0.591, 0.478],
    [0.874, 0.831, 0.722, 0.594, 0.474],
    [0.976, 0.912, 0.760, 0.596, 0.453],
    [1.200, 1.073, 0.808, 0.562, 0.366],
    [1.700, 1.341, 0.751, 0.292, -0.055],
];

/// The three numbers of a weld, dimensionless, from the ratio of the rib's thickness to the beam's and the angle between both, degrees:
/// the stiffened length over w²/t (w the root's length along the beam's face, t the beam's thickness), the root's depth over the rib's
/// thickness, and the turn of the rib over the beam's shear strain. Between the angles and ratios that were computed (30 to 90°, 0.2 to
/// 2) they are interpolated, beyond those they stay.
#[inline(never)]
pub fn weld_numbers(ratio: f64, degrees: f64) -> [f64; 3] {
    let (row, down) = position(&ANGLES.map(|angle| -angle), -degrees);
    let (column, right) = position(&RATIOS, ratio);
    [&STIFF, &ROOT, &COUPLING].map(|table| {
        let at = |i: usize, j: usize| table.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0);
        let along = |i: usize| at(i, column) + right * (at(i, column + 1) - at(i, column));
        along(row) + down * (along(row + 1) - along(row))
    })
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
    /// The back end lies on the part of the back beam that is held, or reaches it: it does not turn.
    pub held: bool,
}

impl Weld {
    /// Those of rib k; lamellae that are not welded ribs stiffen nothing.
    // Double precision is software on the microcontroller: one copy for all who ask.
    #[inline(never)]
    pub fn of(design: &Design, lamella: usize) -> Self {
        let LamellaKind::Rib(Ribs { ends: RibEnds::Welded, .. }) = design.lamellae.kind else {
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
            let (rib, arc) = (ribs[side], arcs[side]);
            let end = Self::end(beam, arc, along.map(|part| outwards * part), rib);
            (weld.reach[side], weld.coupling[side]) = (end.reach, end.coupling);
            weld.start[side] = (faces[side] - end.root).max(0.0);
        }
        weld.held = arcs[1] - weld.reach[1][0] <= design.back.clamp;
        if weld.held {
            // What is held gives no way: the rib bends from the face on.
            (weld.start[1], weld.coupling[1]) = (faces[1], 0.0);
        }
        weld
    }

    /// One end: `along` leads from the beam into the rib.
    #[inline(never)]
    fn end(beam: &Beam, arc: f64, along: [f64; 2], rib: f64) -> End {
        let (e, thickness) = (beam.direction(arc), beam.thickness.at(arc));
        let cosine = e[0] * along[0] + e[1] * along[1];
        let sine = (e[0] * along[1] - e[1] * along[0]).abs().max(0.1);
        let [stiff, root, coupling] = weld_numbers(rib / thickness, libm::asin(sine.min(1.0)).to_degrees());
        let half = 0.5 * stiff * rib * rib / (sine * sine * thickness);
        // The root's middle on the face, on the side to which the rib leans.
        let middle = 0.5 * thickness * cosine / sine;
        End { reach: [half - middle, half + middle], root: root * rib, coupling }
    }
}

struct End {
    reach: [f64; 2],
    root: f64,
    coupling: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_met_at_its_knots_and_in_between() {
        for (i, angle) in ANGLES.into_iter().enumerate() {
            for (j, ratio) in RATIOS.into_iter().enumerate() {
                let found = weld_numbers(ratio, angle);
                for (found, table) in found.into_iter().zip([STIFF, ROOT, COUPLING]) {
                    assert!((found - table[i][j]).abs() < 1e-12, "{angle}° {ratio}");
                }
            }
        }
        let middle = weld_numbers(0.75, 82.5)[1];
        assert!((middle - 0.25 * (0.398 + 0.339 + 0.356 + 0.276)).abs() < 1e-12);
        assert_eq!(weld_numbers(0.05, 90.0), weld_numbers(0.2, 90.0));
        assert_eq!(weld_numbers(7.0, 10.0), weld_numbers(2.0, 30.0));
    }
}
