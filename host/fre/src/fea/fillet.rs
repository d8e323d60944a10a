//! A fillet: the arc that rounds the corner between a beam's inner face and a rib's edge.

/// The arc, from the face to the edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fillet {
    centre: [f64; 2],
    /// From the centre to where the arc begins on the face.
    spoke: [f64; 2],
    /// Angle from there to where it ends on the rib's edge, rad.
    turn: f64,
    /// Distance of either end from the sharp corner, mm.
    pub reach: f64,
}

impl Fillet {
    /// That of a corner from which unit vectors lead along the face and along the edge.
    pub fn of(corner: [f64; 2], face: [f64; 2], edge: [f64; 2], radius: f64) -> Self {
        let half = 0.5 * (face[0] * edge[0] + face[1] * edge[1]).clamp(-1.0, 1.0).acos();
        let reach = radius / half.tan();
        let middle = [face[0] + edge[0], face[1] + edge[1]];
        let by = radius / half.sin() / middle[0].hypot(middle[1]);
        let centre = [0, 1].map(|i| corner[i] + by * middle[i]);
        let spoke = [0, 1].map(|i| corner[i] + reach * face[i] - centre[i]);
        let side = face[0] * edge[1] - face[1] * edge[0];
        Self { centre, spoke, turn: (2.0 * half - std::f64::consts::PI) * side.signum(), reach }
    }

    /// A point of the arc, from 0 on the face to 1 on the edge.
    pub fn at(&self, part: f64) -> [f64; 2] {
        let (sin, cos) = (part * self.turn).sin_cos();
        let [x, y] = self.spoke;
        [self.centre[0] + cos * x - sin * y, self.centre[1] + sin * x + cos * y]
    }

    /// Length of the arc, mm.
    pub fn length(&self) -> f64 {
        self.turn.abs() * self.spoke[0].hypot(self.spoke[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_touches_both_lines_and_keeps_its_radius() {
        for degrees in [30.0_f64, 90.0, 140.0, -70.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let fillet = Fillet::of([3.0, -1.0], [1.0, 0.0], [cos, sin], 2.0);
            let (begin, end) = (fillet.at(0.0), fillet.at(1.0));
            let reach = 2.0 / (0.5 * degrees.abs().to_radians()).tan();
            assert!((fillet.reach - reach).abs() < 1e-12);
            for (found, true_one) in [(begin, [3.0 + reach, -1.0]), (end, [3.0 + reach * cos, -1.0 + reach * sin])] {
                assert!((found[0] - true_one[0]).hypot(found[1] - true_one[1]) < 1e-12, "{degrees}: {found:?}");
            }
            for part in [0.0, 0.3, 0.5, 1.0] {
                let p = fillet.at(part);
                // Never beyond the lines, and so far from the centre.
                let height = (p[1] + 1.0) * sin.signum();
                assert!(height > -1e-12 && (p[0] - fillet.centre[0]).hypot(p[1] - fillet.centre[1]) - 2.0 < 1e-12);
            }
            assert!((fillet.length() - 2.0 * (180.0 - degrees.abs()).to_radians()).abs() < 1e-12);
        }
    }
}
