//! Welds: what a rib that is of one piece with a beam does to both.
//!
//! Seven numbers per weld, from linear finite elements of the junction alone (`tests/reference/src/junction.rs`, which makes the tables
//! below): over how much of its length the beam does not bend and where that lies, how far inside the face the rib bends, how the beam's
//! shear turns the rib, how the rib's own does, and how much less the beam stretches and shears. They depend on the angle between rib and
//! beam and on the ratio of their thicknesses, and on Poisson's ratio by less than a tenth.

use super::junction::face_distances;
use super::{Beam, Design, LamellaKind, RibEnds, Ribs};

/// Angles between rib and beam, degrees, and thicknesses of the rib over the beam's, of the tables' rows and columns.
const ANGLES: [f64; 5] = [90.0, 75.0, 60.0, 45.0, 30.0];
const RATIOS: [f64; 5] = [0.2, 0.5, 1.0, 1.5, 2.0];
type Table = [[f64; 5]; 5];

/// Length over which the beam does not bend, over w²/t with w the root's length along the face and t the beam's thickness.
const STIFF: Table = [
    [0.216, 0.227, 0.238, 0.239, 0.230],
    [0.216, 0.227, 0.239, 0.238, 0.227],
    [0.215, 0.228, 0.238, 0.233, 0.219],
    [0.213, 0.227, 0.232, 0.218, 0.198],
    [0.205, 0.217, 0.205, 0.181, 0.157],
];
/// Distance of that length's middle from the crossing of the axes, towards the side to which the rib leans, over that of the root's
/// middle on the face.
const LEAN: Table = [
    [0.532, 0.607, 0.736, 0.845, 0.923],
    [0.539, 0.617, 0.749, 0.859, 0.936],
    [0.561, 0.648, 0.792, 0.904, 0.978],
    [0.607, 0.712, 0.871, 0.981, 1.047],
    [0.693, 0.826, 0.995, 1.092, 1.138],
];
/// Depth inside the beam's face from which the rib bends, over the rib's thickness.
const ROOT: Table = [
    [0.412, 0.398, 0.339, 0.245, 0.139],
    [0.382, 0.369, 0.312, 0.221, 0.122],
    [0.289, 0.277, 0.225, 0.147, 0.067],
    [0.109, 0.100, 0.059, 0.005, -0.046],
    [-0.247, -0.250, -0.271, -0.294, -0.323],
];
/// Angle by which a shear force in the beam turns the rib, over the beam's shear strain: the rib goes with the face, not with the section.
const COUPLING: Table = [
    [0.845, 0.806, 0.709, 0.591, 0.478],
    [0.852, 0.811, 0.708, 0.585, 0.470],
    [0.875, 0.825, 0.703, 0.567, 0.444],
    [0.922, 0.850, 0.690, 0.524, 0.377],
    [1.007, 0.886, 0.641, 0.379, 0.125],
];
/// Angle by which the rib's own shear force turns it at its root, over its shear strain.
const TURN: Table = [
    [0.282, 0.374, 0.479, 0.546, 0.612],
    [0.273, 0.367, 0.479, 0.553, 0.627],
    [0.250, 0.350, 0.479, 0.576, 0.674],
    [0.222, 0.333, 0.488, 0.623, 0.771],
    [0.199, 0.324, 0.515, 0.745, 1.045],
];
/// Length of the beam that does not stretch, over w²/t, negative.
const STRETCH: Table = [
    [-0.069, -0.067, -0.061, -0.054, -0.049],
    [-0.069, -0.066, -0.060, -0.053, -0.047],
    [-0.068, -0.065, -0.057, -0.049, -0.044],
    [-0.066, -0.062, -0.052, -0.043, -0.038],
    [-0.061, -0.055, -0.042, -0.033, -0.028],
];
/// Length of the beam that does not shear, over w²/t, negative.
const SHEAR: Table = [
    [-0.449, -0.384, -0.365, -0.330, -0.286],
    [-0.456, -0.395, -0.373, -0.332, -0.285],
    [-0.485, -0.434, -0.396, -0.337, -0.278],
    [-0.558, -0.507, -0.421, -0.323, -0.245],
    [-0.728, -0.611, -0.386, -0.227, -0.126],
];

/// The seven numbers of a weld, dimensionless, from the ratio of the rib's thickness to the beam's and the angle between both, degrees:
/// the stiffened length over w²/t (w the root's length along the beam's face, t the beam's thickness), its middle's distance from the
/// crossing of the axes over that of the root's middle, the root's depth over the rib's thickness, the turn of the rib over the beam's
/// shear strain and over its own, and the lengths by which the beam stretches and shears more than to the crossing, over w²/t. Between
/// the angles and ratios that were computed (30 to 90°, 0.2 to 2) they are interpolated, beyond those they stay.
#[inline(never)]
pub fn weld_numbers(ratio: f64, degrees: f64) -> [f64; 7] {
    let (row, down) = position(&ANGLES.map(|angle| -angle), -degrees);
    let (column, right) = position(&RATIOS, ratio);
    [&STIFF, &LEAN, &ROOT, &COUPLING, &TURN, &STRETCH, &SHEAR].map(|table| {
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

/// What a weld does to one of the rods that end there, an arm of the beam or the rib.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Arm {
    /// Lengths by which it stretches and shears more than what bends of it, mm.
    pub give: [f64; 2],
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
    pub give: [[f64; 2]; 2],
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
            (weld.turn[side], weld.give[side]) = (end.turn, end.give);
            weld.start[side] = (faces[side] - end.root).max(0.0);
        }
        weld.held = arcs[1] - weld.reach[1][0] <= design.back.clamp;
        if weld.held {
            // What is held gives no way: the rib bends from the face on.
            (weld.start[1], weld.coupling[1], weld.turn[1]) = (faces[1], 0.0, 0.0);
        }
        weld
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
        Arm { give: self.give[side].map(|give| self.reach[side][end] + give), turn: self.coupling[side] }
    }

    /// The rib's two ends.
    pub fn rib(&self) -> [Arm; 2] {
        self.turn.map(|turn| Arm { turn, ..Arm::default() })
    }

    /// One end: `along` leads from the beam into the rib.
    #[inline(never)]
    fn end(beam: &Beam, arc: f64, along: [f64; 2], rib: f64) -> End {
        let (e, thickness) = (beam.direction(arc), beam.thickness.at(arc));
        let cosine = e[0] * along[0] + e[1] * along[1];
        let sine = (e[0] * along[1] - e[1] * along[0]).abs().max(0.1);
        let [stiff, lean, root, coupling, turn, stretch, shear] =
            weld_numbers(rib / thickness, libm::asin(sine.min(1.0)).to_degrees());
        let half = 0.5 * rib * rib / (sine * sine * thickness);
        // On the side to which the rib leans.
        let middle = 0.5 * lean * thickness * cosine / sine;
        let reach = [half * stiff - middle, half * stiff + middle];
        End { reach, root: root * rib, coupling, turn, give: [half * stretch, half * shear] }
    }
}

struct End {
    reach: [f64; 2],
    root: f64,
    coupling: f64,
    turn: f64,
    give: [f64; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_met_at_its_knots_and_in_between() {
        for (i, angle) in ANGLES.into_iter().enumerate() {
            for (j, ratio) in RATIOS.into_iter().enumerate() {
                let found = weld_numbers(ratio, angle);
                for (found, table) in found.into_iter().zip([STIFF, LEAN, ROOT, COUPLING, TURN, STRETCH, SHEAR]) {
                    assert!((found - table[i][j]).abs() < 1e-12, "{angle}° {ratio}");
                }
            }
        }
        let middle = weld_numbers(0.75, 82.5)[2];
        assert!((middle - 0.25 * (0.398 + 0.339 + 0.369 + 0.312)).abs() < 1e-12);
        assert_eq!(weld_numbers(0.05, 90.0), weld_numbers(0.2, 90.0));
        assert_eq!(weld_numbers(7.0, 10.0), weld_numbers(2.0, 30.0));
    }
}
