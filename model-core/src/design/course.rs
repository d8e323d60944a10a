//! A centreline at rest: a circular arc, or a chain of arcs through given points.
//!
//! At a point of the chain the tangent is that of the circle through it and both its neighbours; between two points lie two arcs that meet
//! with one tangent (a biarc). Points on a line or on a circle thus give that line or circle, whatever their distances, and every other
//! chain turns without a kink.

/// Half the angle of an arc below which it is a straight line, rad.
const STRAIGHT: f64 = 1e-9;

type Point = [f64; 2];

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn along(p: Point, direction: Point, by: f64) -> Point {
    [p[0] + by * direction[0], p[1] + by * direction[1]]
}

/// A vector over its length.
fn unit(v: Point) -> Point {
    let length = libm::hypot(v[0], v[1]);
    v.map(|x| x / length)
}

/// A circular arc of a centreline, or a straight piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arc {
    start: Point,
    /// Unit vector along it at its start.
    tangent: Point,
    pub length: f64,
    /// Positive where it turns to the right of the way.
    curvature: f64,
}

impl Arc {
    /// The arc from a point with a tangent to another point.
    fn to(start: Point, tangent: Point, end: Point) -> Self {
        let chord = minus(end, start);
        let length = libm::hypot(chord[0], chord[1]);
        let half = libm::atan2(-cross(tangent, chord), dot(tangent, chord));
        if half.abs() < STRAIGHT {
            return Self { start, tangent, length, curvature: 0.0 };
        }
        let sine = libm::sin(half);
        Self { start, tangent, length: length * half / sine, curvature: 2.0 * sine / length }
    }

    /// Unit vector along it, so far from its start.
    pub fn direction(&self, at: f64) -> Point {
        let [x, y] = self.tangent;
        if self.curvature == 0.0 {
            return self.tangent;
        }
        let (s, c) = libm::sincos(self.curvature * at);
        [c * x + s * y, c * y - s * x]
    }

    /// Its point so far from its start; beyond its ends it goes on.
    pub fn point(&self, at: f64) -> Point {
        if self.curvature == 0.0 {
            return along(self.start, self.tangent, at);
        }
        // The chord to the point: half as much turned as the arc.
        let half = 0.5 * self.curvature * at;
        let (s, c) = libm::sincos(half);
        let chord = at * if half.abs() < STRAIGHT { 1.0 } else { s / half };
        let [x, y] = self.tangent;
        along(self.start, [c * x + s * y, c * y - s * x], chord)
    }
}

/// Tangent at the middle of three points of the circle through them: inversion about that point makes the circle a line along it.
fn tangent(before: Point, at: Point, after: Point) -> Point {
    let (a, b) = (minus(at, before), minus(after, at));
    let (aa, bb) = (dot(a, a), dot(b, b));
    unit([a[0] / aa + b[0] / bb, a[1] / aa + b[1] / bb])
}

/// Tangent at the other end of the arc that leaves a point with a tangent, from the chord between both.
fn mirrored(tangent: Point, chord: Point) -> Point {
    let u = unit(chord);
    let twice = 2.0 * dot(tangent, u);
    [twice * u[0] - tangent[0], twice * u[1] - tangent[1]]
}

/// Hands on the arcs through `base`, `via` and `tip`, base to tip, until `visit` returns false.
#[inline(never)]
pub(super) fn chain(base: Point, via: &[Point], tip: Point, visit: &mut dyn FnMut(&Arc) -> bool) {
    let at = |index: usize| match index.checked_sub(1) {
        None => base,
        Some(index) => via.get(index).copied().unwrap_or(tip),
    };
    let last = via.len() + 1;
    let inner = |index: usize| tangent(at(index - 1), at(index), at(index + 1));
    let mut from = match last {
        1 => unit(minus(tip, base)),
        _ => mirrored(inner(1), minus(at(1), base)),
    };
    for index in 0..last {
        let (p, q) = (at(index), at(index + 1));
        let chord = minus(q, p);
        let to = if index + 1 == last { mirrored(from, chord) } else { inner(index + 1) };
        // The biarc whose two end tangents reach equally far: its arcs meet in the middle of the tangents' ends.
        let (v, sum) = (dot(chord, chord), [from[0] + to[0], from[1] + to[1]]);
        let b = dot(chord, sum);
        let reach = v / (b + libm::sqrt(b * b + 2.0 * (1.0 - dot(from, to)).max(0.0) * v));
        let middle = [0, 1].map(|i| 0.5 * (p[i] + q[i] + reach * (from[i] - to[i])));
        let first = Arc::to(p, from, middle);
        if !visit(&first) || !visit(&Arc::to(middle, first.direction(first.length), q)) {
            return;
        }
        from = to;
    }
}
