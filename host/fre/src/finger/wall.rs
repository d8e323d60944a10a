//! A wall of the finger: one of the two beams, with its faces.

use super::{Point, along, cross, distance, dot, minus};
use crate::case::keys::{Along, BeamTable};
use model_core::design::{Beam, Profile};

/// Half the angle of an arc below which it is a straight line, rad.
const STRAIGHT: f64 = 1e-9;
/// Chords into which a bowed centreline is divided: they are within 1e-3 mm of the arc for a bow of 10 mm on 100 mm.
const CHORDS: usize = 256;

/// A wall: centreline from base to tip, and thickness against its arc, mm. The centreline goes straight on beyond its ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Wall {
    /// Centreline, at least two points.
    points: Vec<Point>,
    /// Arc of each point.
    arcs: Vec<f64>,
    /// Pairs (arc, thickness), linear between them.
    thickness: Vec<[f64; 2]>,
    /// 1 if the other wall lies to the left of the way from base to tip, −1 if to the right.
    side: f64,
}

impl Wall {
    /// The wall of a beam's keys; none without a centreline of some length or a thickness.
    pub(super) fn of(keys: &BeamTable, side: f64) -> Option<Self> {
        let points = match (&keys.centreline_mm, keys.base_mm, keys.tip_mm) {
            (Some(points), _, _) => chain(points)?,
            (None, Some(base), Some(tip)) => arc(base, tip, keys.sagitta_mm),
            _ => return None,
        };
        let thickness = match &keys.thickness_mm {
            Along::Everywhere(thickness) => vec![[0.0, *thickness]],
            Along::Taper(pairs) => pairs.iter().map(|&(arc, thickness)| [arc, thickness]).collect(),
        };
        Self::new(points, thickness, side)
    }

    /// A wall from a centreline and a thickness table; none without some length, or without a thickness.
    pub fn new(mut points: Vec<Point>, thickness: Vec<[f64; 2]>, side: f64) -> Option<Self> {
        points.dedup_by(|b, a| distance(*a, *b) < 1e-9);
        let finite = points.iter().chain(&thickness).flatten().all(|x| x.is_finite());
        if points.len() < 2 || thickness.is_empty() || !finite {
            return None;
        }
        let mut arcs = vec![0.0];
        for pair in points.windows(2) {
            arcs.push(arcs[arcs.len() - 1] + distance(pair[0], pair[1]));
        }
        Some(Self { points, arcs, thickness, side })
    }

    /// Length of the centreline.
    pub fn length(&self) -> f64 {
        self.arcs[self.arcs.len() - 1]
    }

    /// The centreline's points.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Arcs of the centreline's points and of the thickness table's knots between two arcs, ascending, the two included.
    pub fn knots(&self, from: f64, to: f64) -> Vec<f64> {
        let inside = |arc: &f64| *arc > from + 1e-9 && *arc < to - 1e-9;
        let mut knots: Vec<f64> = self.arcs.iter().copied().chain(self.thickness.iter().map(|knot| knot[0])).collect();
        knots.retain(inside);
        knots.extend([from, to]);
        knots.sort_by(f64::total_cmp);
        knots.dedup_by(|b, a| (*b - *a).abs() < 1e-9);
        knots
    }

    fn segment(&self, arc: f64) -> usize {
        self.arcs.partition_point(|&at| at <= arc).clamp(1, self.arcs.len() - 1) - 1
    }

    /// Point of the centreline at an arc.
    pub fn centre(&self, arc: f64) -> Point {
        let i = self.segment(arc);
        along(self.points[i], self.chord(i), arc - self.arcs[i])
    }

    fn chord(&self, i: usize) -> Point {
        let length = self.arcs[i + 1] - self.arcs[i];
        minus(self.points[i + 1], self.points[i]).map(|x| x / length)
    }

    /// Unit vector along the centreline, towards the tip: turning evenly from the middle of each chord to that of the next.
    pub fn direction(&self, arc: f64) -> Point {
        let i = self.segment(arc);
        let middle = |i: usize| 0.5 * (self.arcs[i] + self.arcs[i + 1]);
        let last = self.points.len() - 2;
        let (a, b) = if arc < middle(i) { (i.saturating_sub(1), i) } else { (i, (i + 1).min(last)) };
        if a == b {
            return self.chord(a);
        }
        let t = ((arc - middle(a)) / (middle(b) - middle(a))).clamp(0.0, 1.0);
        let (p, q) = (self.chord(a), self.chord(b));
        let mixed = [p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])];
        let size = mixed[0].hypot(mixed[1]);
        mixed.map(|x| x / size)
    }

    /// Unit normal towards the other wall.
    pub fn inward(&self, arc: f64) -> Point {
        let e = self.direction(arc);
        [-self.side * e[1], self.side * e[0]]
    }

    /// Thickness at an arc.
    pub fn thickness(&self, arc: f64) -> f64 {
        let after = self.thickness.partition_point(|knot| knot[0] <= arc);
        match (after.checked_sub(1).map(|i| self.thickness[i]), self.thickness.get(after)) {
            (Some(a), Some(b)) => a[1] + (b[1] - a[1]) * (arc - a[0]) / (b[0] - a[0]),
            (Some(only), None) | (None, Some(&only)) => only[1],
            (None, None) => 0.0,
        }
    }

    /// Point of the face towards the other wall, across from an arc.
    pub fn inner(&self, arc: f64) -> Point {
        along(self.centre(arc), self.inward(arc), 0.5 * self.thickness(arc))
    }

    /// Point of the face away from the other wall.
    pub fn outer(&self, arc: f64) -> Point {
        along(self.centre(arc), self.inward(arc), -0.5 * self.thickness(arc))
    }

    /// Arc of the centreline's point next to a point.
    pub fn arc_beside(&self, p: Point) -> f64 {
        let last = self.points.len() - 2;
        let mut best = (f64::INFINITY, 0.0);
        for i in 0..=last {
            let length = self.arcs[i + 1] - self.arcs[i];
            let low = if i == 0 { f64::NEG_INFINITY } else { 0.0 };
            let high = if i == last { f64::INFINITY } else { length };
            let by = dot(minus(p, self.points[i]), self.chord(i)).clamp(low, high);
            let off = distance(p, along(self.points[i], self.chord(i), by));
            if off < best.0 {
                best = (off, self.arcs[i] + by);
            }
        }
        best.1
    }

    /// Height of a point over the inner face, towards the other wall, and its arc.
    pub fn height_over_inner(&self, p: Point) -> (f64, f64) {
        let arc = self.arc_beside(p);
        (dot(minus(p, self.centre(arc)), self.inward(arc)) - 0.5 * self.thickness(arc), arc)
    }

    /// Arc at which one of the wall's lines (`face`: centreline or a face) crosses the line through `p` along `d`; `near` is a first
    /// guess.
    pub fn crossing(&self, face: impl Fn(&Self, f64) -> Point, p: Point, d: Point, near: f64) -> f64 {
        let off = |arc: f64| cross(d, minus(face(self, arc), p));
        let step = 0.01 * self.length();
        // Outwards from the guess to the first change of sign, then by halves.
        for i in 0..400 {
            let reach = step * f64::from(i);
            for from in [near - reach - step, near + reach] {
                let (mut a, mut b) = (from, from + step);
                let at_a = off(a);
                if at_a == 0.0 {
                    return a;
                }
                if at_a * off(b) > 0.0 {
                    continue;
                }
                for _ in 0..80 {
                    let middle = 0.5 * (a + b);
                    if off(middle) * at_a > 0.0 { a = middle } else { b = middle }
                }
                return 0.5 * (a + b);
            }
        }
        near
    }

    /// Arc at which the centreline reaches a height; it rises all the way.
    pub fn arc_at_height(&self, height: f64) -> f64 {
        self.crossing(Self::centre, [0.0, height], [1.0, 0.0], 0.5 * self.length())
    }
}

/// The solver's chain of arcs through points, in chords: as many between each two points as keep near the arcs, and the points themselves.
fn chain(points: &[Point]) -> Option<Vec<Point>> {
    let [base, via @ .., tip] = points else { return None };
    let beam = Beam { via: via.iter().copied().collect(), ..Beam::straight(*base, *tip, Profile::constant(1.0)) };
    if via.is_empty() || !beam.length().is_finite() {
        return Some(points.to_vec());
    }
    let (length, mut arc, mut found) = (beam.length(), 0.0, Vec::new());
    while arc < length {
        found.push(beam.point(arc));
        arc += length / CHORDS as f64;
    }
    found.push(*tip);
    Some(found)
}

/// A straight line, or a circular arc in chords: the rise over the chord is positive to the right of the way.
fn arc(base: Point, tip: Point, sagitta: f64) -> Vec<Point> {
    let chord = distance(base, tip);
    let half = 2.0 * (2.0 * sagitta).atan2(chord);
    if chord == 0.0 || half.abs() < STRAIGHT {
        return vec![base, tip];
    }
    let t = minus(tip, base).map(|x| x / chord);
    let n = [t[1], -t[0]];
    let radius = 0.5 * chord / half.sin();
    let point = |i: usize| {
        let turn = half - 2.0 * half * i as f64 / CHORDS as f64;
        let (x, y) = (radius * (half.sin() - turn.sin()), radius * (turn.cos() - half.cos()));
        [base[0] + x * t[0] + y * n[0], base[1] + x * t[1] + y * n[1]]
    };
    (0..=CHORDS).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_is_where_its_points_and_thicknesses_put_it() {
        let wall = Wall::new(arc([0.0, 0.0], [0.0, 80.0], 4.0), vec![[0.0, 2.0], [80.0, 1.0]], 1.0).unwrap();
        // The bow's middle lies its sagitta to the right.
        let middle = wall.centre(0.5 * wall.length());
        assert!((middle[0] - 4.0).abs() < 1e-9 && (middle[1] - 40.0).abs() < 1e-9, "{middle:?}");
        let thickness = model_core::design::Profile::constant(2.0);
        let straight = model_core::design::Beam::straight([0.0, 0.0], [0.0, 80.0], thickness);
        let beam = model_core::design::Beam { sagitta: 4.0, ..straight };
        assert!((wall.length() - beam.length()).abs() < 1e-3);
        for i in 0..=20 {
            let arc = wall.length() * f64::from(i) / 20.0;
            assert!(distance(wall.centre(arc), beam.point(arc)) < 2e-3);
            assert!(distance(wall.direction(arc), beam.direction(arc)) < 2e-3, "{arc}");
            assert!((distance(wall.inner(arc), wall.outer(arc)) - wall.thickness(arc)).abs() < 1e-9);
            assert!(
                (wall.arc_beside(wall.inner(arc)) - arc).abs() < 2e-2,
                "{arc} {}",
                wall.arc_beside(wall.inner(arc))
            );
            assert!((wall.arc_at_height(wall.centre(arc)[1]) - arc).abs() < 1e-6);
        }
        assert_eq!([-1.0, 40.0, 200.0].map(|arc| wall.thickness(arc)), [2.0, 1.5, 1.0]);
        assert!(Wall::new(vec![[0.0, 0.0]], vec![[0.0, 1.0]], 1.0).is_none());
    }
}
