//! The faces of a design's beams, and where they meet.

use model_core::design::{Beam, Design};

/// A point or vector of the finger frame, mm.
pub type Point = [f64; 2];

/// A beam with its two faces; arcs are those of its centreline, mm.
#[derive(Clone, Copy, Debug)]
pub struct Faces<'d> {
    beam: &'d Beam,
    /// 1 if the other beam lies to the left of the way from base to tip, −1 if to the right.
    side: f64,
}

impl<'d> Faces<'d> {
    /// The front beam's.
    pub fn front(design: &'d Design) -> Self {
        Self { beam: &design.front, side: 1.0 }
    }

    /// The back beam's.
    pub fn back(design: &'d Design) -> Self {
        Self { beam: &design.back, side: -1.0 }
    }

    /// Arc below which the beam is held.
    pub fn clamp(&self) -> f64 {
        self.beam.clamp
    }

    /// Length of the centreline.
    pub fn length(&self) -> f64 {
        self.beam.length()
    }

    /// Unit normal towards the other beam at an arc.
    pub fn inward(&self, arc: f64) -> Point {
        let e = self.beam.direction(arc);
        [-self.side * e[1], self.side * e[0]]
    }

    /// The point of the centreline at an arc.
    pub fn centre(&self, arc: f64) -> Point {
        self.beam.point(arc)
    }

    /// Thickness at an arc, mm.
    pub fn thickness(&self, arc: f64) -> f64 {
        self.beam.thickness.at(arc)
    }

    /// The point of the face towards the other beam, across from an arc.
    pub fn inner(&self, arc: f64) -> Point {
        self.off_centre(arc, 0.5)
    }

    /// The point of the face away from the other beam.
    pub fn outer(&self, arc: f64) -> Point {
        self.off_centre(arc, -0.5)
    }

    fn off_centre(&self, arc: f64, part: f64) -> Point {
        let by = part * self.beam.thickness.at(arc);
        let (p, inward) = (self.beam.point(arc), self.inward(arc));
        [p[0] + by * inward[0], p[1] + by * inward[1]]
    }

    /// Arc of the centreline's point next to a point.
    pub fn arc_beside(&self, p: Point) -> f64 {
        let mut arc = dot(minus(p, self.beam.base), self.beam.direction(0.0));
        // Exact at once for a straight beam; a bowed one turns slowly.
        for _ in 0..30 {
            let step = dot(minus(p, self.beam.point(arc)), self.beam.direction(arc));
            arc += step;
            if step.abs() < 1e-12 {
                break;
            }
        }
        arc
    }

    /// Distance of a point from the inner face, towards the other beam, and its arc.
    pub fn height_over_inner(&self, p: Point) -> (f64, f64) {
        let arc = self.arc_beside(p);
        (dot(minus(p, self.beam.point(arc)), self.inward(arc)) - 0.5 * self.thickness(arc), arc)
    }

    /// Arc at which a face crosses the line through `p` along `d`; `near` is a first guess.
    pub fn crossing(face: impl Fn(f64) -> Point, p: Point, d: Point, near: f64) -> f64 {
        let off = |arc: f64| cross(d, minus(face(arc), p));
        let (mut a, mut b) = (near - 0.5, near + 0.5);
        let (mut at_a, mut at_b) = (off(a), off(b));
        // The secant method: exact at once for a straight face, a few rounds for a tapered one.
        for _ in 0..30 {
            if at_b == at_a || at_b.abs() < 1e-12 {
                break;
            }
            let next = b - at_b * (b - a) / (at_b - at_a);
            (a, at_a) = (b, at_b);
            (b, at_b) = (next, off(next));
        }
        b
    }

    /// Arcs (front, back) at which the inner faces meet. None if they are not apart where the front beam's clamp ends, or still are at
    /// its tip.
    pub fn meeting(front: &Self, back: &Self) -> Option<[f64; 2]> {
        let (mut below, mut above) = (front.clamp(), front.length());
        let open = |arc: f64| back.height_over_inner(front.inner(arc)).0;
        if !(open(below) > 0.0 && open(above) < 0.0) {
            return None;
        }
        for _ in 0..100 {
            let middle = 0.5 * (below + above);
            if open(middle) > 0.0 {
                below = middle;
            } else {
                above = middle;
            }
        }
        let arc = 0.5 * (below + above);
        Some([arc, back.height_over_inner(front.inner(arc)).1])
    }
}

/// Height (finger-frame y, mm) at which the beams' inner faces meet, so that the tip is solid above it. None if they do not meet below
/// the tip.
pub fn solid_above(front: &Beam, back: &Beam) -> Option<f64> {
    let (front, back) = (Faces { beam: front, side: 1.0 }, Faces { beam: back, side: -1.0 });
    Faces::meeting(&front, &back).map(|[arc, _]| front.inner(arc)[1])
}

pub(crate) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(crate) fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
