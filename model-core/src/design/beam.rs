//! A beam of the finger at rest: straight, or bowed like a circular arc.

use super::Profile;

/// One of the two flexible beams, from its base to the tip.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Beam {
    /// Centreline's start, clamped to the base lamella, mm.
    pub base: [f64; 2],
    /// Centreline's end, joined to the other beam, mm.
    pub tip: [f64; 2],
    /// Rise of the unloaded centreline's circular arc over its chord, mm: positive bows to the right of the way from base to tip,
    /// which is towards the object; 0 is straight.
    pub sagitta: f64,
    /// Thickness in the plane against arc length from the base, mm.
    pub thickness: Profile,
    /// Multiplies EI and EA of this beam.
    pub stiffness_factor: f64,
}

/// Half the angle of an arc below which it is a straight line, rad.
const STRAIGHT: f64 = 1e-9;

impl Beam {
    /// Distance of base and tip, mm.
    pub fn chord(&self) -> f64 {
        libm::hypot(self.tip[0] - self.base[0], self.tip[1] - self.base[1])
    }

    /// Unit vectors along the chord, from base to tip, and to the right of it.
    fn axes(&self) -> [[f64; 2]; 2] {
        let chord = self.chord();
        let t = [(self.tip[0] - self.base[0]) / chord, (self.tip[1] - self.base[1]) / chord];
        [t, [t[1], -t[0]]]
    }

    /// Half the angle of the arc: by so much the centreline leans to the right at the base, and to the left at the tip, rad.
    fn half_angle(&self) -> f64 {
        2.0 * libm::atan2(2.0 * self.sagitta, self.chord())
    }

    /// Curvature of the unloaded centreline, 1/mm; positive for a positive sagitta.
    pub fn curvature(&self) -> f64 {
        2.0 * libm::sin(self.half_angle()) / self.chord()
    }

    /// Length of the centreline, mm.
    pub fn length(&self) -> f64 {
        let half = self.half_angle();
        if half.abs() < STRAIGHT { self.chord() } else { self.chord() * half / libm::sin(half) }
    }

    /// Unit vector along the undeformed centreline at an arc length from the base, mm.
    #[inline(never)]
    pub fn direction(&self, arc: f64) -> [f64; 2] {
        let [t, n] = self.axes();
        let half = self.half_angle();
        if half.abs() < STRAIGHT {
            return t;
        }
        let (s, c) = libm::sincos(half - self.curvature() * arc);
        [c * t[0] + s * n[0], c * t[1] + s * n[1]]
    }

    /// Point of the undeformed centreline at an arc length from the base, mm.
    #[inline(never)]
    pub fn point(&self, arc: f64) -> [f64; 2] {
        let [t, n] = self.axes();
        let half = self.half_angle();
        let (along, across) = if half.abs() < STRAIGHT {
            (arc, 0.0)
        } else {
            let curvature = self.curvature();
            let ((s0, c0), (s, c)) = (libm::sincos(half), libm::sincos(half - curvature * arc));
            ((s0 - s) / curvature, (c - c0) / curvature)
        };
        [self.base[0] + along * t[0] + across * n[0], self.base[1] + along * t[1] + across * n[1]]
    }

    /// Arc length at which the undeformed centreline reaches a height (finger-frame y), mm; the centreline rises all the way.
    pub fn arc_at_height(&self, height: f64) -> f64 {
        if self.half_angle().abs() < STRAIGHT {
            return (height - self.base[1]) / self.axes()[0][1];
        }
        // Beyond the ends it goes straight on.
        let length = self.length();
        for (end, arc) in [(self.base, 0.0), (self.tip, length)] {
            if (height - end[1]) * (arc - 0.5 * length) >= 0.0 {
                return arc + (height - end[1]) / self.direction(arc)[1];
            }
        }
        let (mut low, mut high) = (0.0, length);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.point(middle)[1] < height { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bowed_beam_goes_from_base_to_tip_over_its_sagitta() {
        for sagitta in [-6.0, -1e-7, 0.0, 1e-7, 0.5, 9.0] {
            let thickness = Profile::constant(2.0);
            let beam = Beam { base: [-28.0, 1.0], tip: [3.0, 80.0], sagitta, thickness, stiffness_factor: 1.0 };
            let near =
                |a: [f64; 2], b: [f64; 2]| assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-6, "{a:?} {b:?} at {sagitta}");
            let length = beam.length();
            near(beam.point(0.0), beam.base);
            near(beam.point(length), beam.tip);
            let chord = beam.chord();
            let right = [(beam.tip[1] - beam.base[1]) / chord, -(beam.tip[0] - beam.base[0]) / chord];
            let middle = [0.5 * (beam.base[0] + beam.tip[0]), 0.5 * (beam.base[1] + beam.tip[1])];
            near(beam.point(0.5 * length), [middle[0] + sagitta * right[0], middle[1] + sagitta * right[1]]);
            for k in 0..=10 {
                let arc = length * f64::from(k) / 10.0;
                // The direction is the point's derivative, and heights lead back to their arcs.
                let (p, q) = (beam.point(arc - 1e-5), beam.point(arc + 1e-5));
                near([(q[0] - p[0]) / 2e-5, (q[1] - p[1]) / 2e-5], beam.direction(arc));
                assert!((beam.arc_at_height(beam.point(arc)[1]) - arc).abs() < 1e-6);
            }
        }
    }
}
