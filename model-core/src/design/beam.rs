//! A beam of the finger at rest: straight, bowed like a circular arc, or through given points.

use super::course::{self, Arc};
use super::{MAX_POINTS, Profile};
use heapless::Vec;

/// One of the two flexible beams, from its base to the tip.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Beam {
    /// Centreline's start, on the base, mm.
    pub base: [f64; 2],
    /// Centreline's end, joined to the other beam, mm.
    pub tip: [f64; 2],
    /// Rise of the unloaded centreline's circular arc over its chord, mm: positive bows to the right of the way from base to tip,
    /// which is towards the object; 0 is straight. Without effect where there are points between base and tip.
    pub sagitta: f64,
    /// Points of the unloaded centreline between base and tip, mm: it goes through all of them in circular arcs without a kink, at each
    /// point in the direction of the circle through it and its neighbours.
    pub via: Vec<[f64; 2], MAX_POINTS>,
    /// Thickness in the plane against arc length from the base, mm.
    pub thickness: Profile,
    /// Multiplies EI and EA of this beam.
    pub stiffness_factor: f64,
    /// Multiplies EI alone.
    pub bending_factor: f64,
    /// Multiplies EA and, with it, the shear stiffness.
    pub stretch_factor: f64,
    /// Arc length from the base below which the beam is held, mm.
    pub clamp: f64,
}

/// Half the angle of an arc below which it is a straight line, rad.
const STRAIGHT: f64 = 1e-9;

impl Beam {
    /// A straight beam of a thickness, held at its base, as stiff as its material is.
    pub fn straight(base: [f64; 2], tip: [f64; 2], thickness: Profile) -> Self {
        let via = Vec::new();
        Self {
            base,
            tip,
            sagitta: 0.0,
            via,
            thickness,
            stiffness_factor: 1.0,
            bending_factor: 1.0,
            stretch_factor: 1.0,
            clamp: 0.0,
        }
    }

    /// Factors on EI and on EA.
    pub fn factors(&self) -> [f64; 2] {
        [self.stiffness_factor * self.bending_factor, self.stiffness_factor * self.stretch_factor]
    }

    /// The arc of the chain through [`Self::via`] in which an arc length from the base lies, and the arc length at which it begins. Beyond
    /// the ends it is the first or the last.
    #[inline(never)]
    fn piece(&self, arc: f64) -> Option<(Arc, f64)> {
        let (mut found, mut from, mut end) = (None, 0.0, 0.0);
        course::chain(self.base, &self.via, self.tip, &mut |piece| {
            (found, from) = (Some(*piece), end);
            end += piece.length;
            arc >= end
        });
        found.map(|piece| (piece, from))
    }

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

    /// Curvature of the circular arc of [`Self::sagitta`], 1/mm; positive for a positive sagitta.
    pub fn curvature(&self) -> f64 {
        2.0 * libm::sin(self.half_angle()) / self.chord()
    }

    /// Length of the centreline, mm.
    pub fn length(&self) -> f64 {
        if !self.via.is_empty() {
            let mut length = 0.0;
            course::chain(self.base, &self.via, self.tip, &mut |piece| {
                length += piece.length;
                true
            });
            return length;
        }
        let half = self.half_angle();
        if half.abs() < STRAIGHT { self.chord() } else { self.chord() * half / libm::sin(half) }
    }

    /// Unit vector along the undeformed centreline at an arc length from the base, mm.
    #[inline(never)]
    pub fn direction(&self, arc: f64) -> [f64; 2] {
        if !self.via.is_empty() {
            return self.piece(arc).map_or([0.0, 1.0], |(piece, from)| piece.direction(arc - from));
        }
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
        if !self.via.is_empty() {
            return self.piece(arc).map_or(self.base, |(piece, from)| piece.point(arc - from));
        }
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
    #[inline(never)]
    pub fn arc_at_height(&self, height: f64) -> f64 {
        if !self.via.is_empty() {
            return self.chain_at_height(height);
        }
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
        halved([0.0, length], |arc| self.point(arc)[1] < height)
    }

    /// As [`Self::arc_at_height`], of a chain of arcs: those below are added up, and the one that reaches the height is halved.
    fn chain_at_height(&self, height: f64) -> f64 {
        let (mut found, mut from) = (None, 0.0);
        course::chain(self.base, &self.via, self.tip, &mut |piece| {
            let goes_on = piece.point(piece.length)[1] < height;
            let before = found.replace(*piece).map_or(0.0, |below: Arc| below.length);
            from += before;
            goes_on
        });
        let Some(piece) = found else { return 0.0 };
        // Beyond the ends it goes straight on.
        for (at, is_beyond) in [(0.0, height < self.base[1]), (piece.length, height > self.tip[1])] {
            if is_beyond {
                return from + at + (height - piece.point(at)[1]) / piece.direction(at)[1];
            }
        }
        from + halved([0.0, piece.length], |arc| piece.point(arc)[1] < height)
    }
}

/// Where on an interval a condition ceases to hold.
fn halved([mut low, mut high]: [f64; 2], holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The way along a beam agrees with itself, and passes no kink.
    fn check(beam: &Beam) {
        let near = |a: [f64; 2], b: [f64; 2], within: f64| {
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < within, "{a:?} {b:?} of {beam:?}");
        };
        let length = beam.length();
        near(beam.point(0.0), beam.base, 1e-9);
        near(beam.point(length), beam.tip, 1e-9);
        for k in 0..=400 {
            let arc = length * f64::from(k) / 400.0;
            let (p, q) = (beam.point(arc - 1e-5), beam.point(arc + 1e-5));
            near([(q[0] - p[0]) / 2e-5, (q[1] - p[1]) / 2e-5], beam.direction(arc), 1e-5);
            near(beam.direction(arc - 1e-6), beam.direction(arc + 1e-6), 1e-5);
            assert!((beam.arc_at_height(beam.point(arc)[1]) - arc).abs() < 1e-6, "{arc} of {beam:?}");
        }
        for via in &beam.via {
            near(beam.point(beam.arc_at_height(via[1])), *via, 1e-6);
        }
        // Beyond the ends it goes straight on.
        for (arc, end, by) in [(0.0, beam.base, -3.0), (length, beam.tip, 3.0)] {
            let found = beam.arc_at_height(end[1] + by);
            assert!((found - arc - by / beam.direction(arc)[1]).abs() < 1e-9);
        }
    }

    #[test]
    fn a_beam_goes_through_its_points_without_a_kink() {
        let straight = || Beam::straight([-28.0, 1.0], [3.0, 80.0], Profile::constant(2.0));
        check(&straight());
        let through = |points: &[[f64; 2]]| Beam { via: points.iter().copied().collect(), ..straight() };
        check(&through(&[[-22.0, 20.0]]));
        check(&through(&[[-26.0, 11.0], [-22.0, 14.0], [-12.0, 60.0]]));
        check(&through(&[[-20.0, 20.0], [-14.0, 40.0], [-12.0, 41.0], [-4.0, 70.0]]));
    }

    #[test]
    fn points_of_a_line_or_of_an_arc_make_that_line_or_arc() {
        for sagitta in [-6.0, 0.0, 0.5, 9.0] {
            let bowed = Beam { sagitta, ..Beam::straight([-28.0, 1.0], [3.0, 80.0], Profile::constant(2.0)) };
            let length = bowed.length();
            for parts in [&[0.4][..], &[0.03, 0.05, 0.5, 0.9, 0.99]] {
                let via = parts.iter().map(|part| bowed.point(part * length)).collect();
                let through = Beam { via, sagitta: 0.0, ..bowed.clone() };
                assert!((through.length() - length).abs() < 1e-9);
                for k in 0..=20 {
                    let arc = length * f64::from(k) / 20.0;
                    let (p, q) = (through.point(arc), bowed.point(arc));
                    let (d, e) = (through.direction(arc), bowed.direction(arc));
                    let off = [p[0] - q[0], p[1] - q[1], d[0] - e[0], d[1] - e[1]];
                    assert!(off.iter().all(|x| x.abs() < 1e-9), "{sagitta}, {parts:?}, {arc}: {off:?}");
                }
            }
        }
    }

    #[test]
    fn a_bowed_beam_goes_from_base_to_tip_over_its_sagitta() {
        for sagitta in [-6.0, -1e-7, 0.0, 1e-7, 0.5, 9.0] {
            let thickness = Profile::constant(2.0);
            let beam = Beam { sagitta, ..Beam::straight([-28.0, 1.0], [3.0, 80.0], thickness) };
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
