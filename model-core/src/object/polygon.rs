//! A convex polygon with rounded corners.

use super::{Displacement, Gap, MAX_CORNERS, Object};
use crate::real::{Real, Vec2, norm, vec2};
use crate::size::Blank;

/// An edge, with the object on its left.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Edge<T: Real> {
    /// Corner at which it begins, mm.
    start: Vec2<T>,
    /// Unit vector along it.
    along: Vec2<T>,
    /// Length, mm.
    length: T,
}

impl<T: Real> Blank for Edge<T> {
    const BLANK: Self =
        Self { start: Vec2::new(T::ZERO, T::ZERO), along: Vec2::new(T::ZERO, T::ZERO), length: T::ZERO };
}

/// All points within a distance, the rounding, of a convex polygon (of a segment with two corners, of a point with one).
///
/// The rounding makes the normal continuous: along the outline it turns at the corners with curvature 1/rounding and
/// stands still on the edges. Further in than the rounding the distance is that to the nearest edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polygon<T: Real> {
    edges: [Edge<T>; MAX_CORNERS],
    count: usize,
    rounding: T,
}

impl<T: Real> Polygon<T> {
    /// A polygon of the centres of its corners' roundings, in order either way round, and their radius, mm.
    ///
    /// Corners beyond [`MAX_CORNERS`] are left out; [`super::ObjectDesign::validate`] says what makes a good polygon.
    pub fn new(corners: &[[f64; 2]], rounding: f64) -> Self {
        let corners = corners.get(..MAX_CORNERS).unwrap_or(corners);
        let count = corners.len();
        let mut edges = [Edge::BLANK; MAX_CORNERS];
        let twice_area = corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| a[0] * b[1] - a[1] * b[0]);
        let clockwise = twice_area.sum::<f64>() < 0.0;
        for (k, edge) in edges.iter_mut().take(count).enumerate() {
            let at = |k: usize| {
                let k = k % count;
                corners.get(if clockwise { count - 1 - k } else { k }).copied().unwrap_or_default()
            };
            let (from, to) = (at(k), at(k + 1));
            let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
            let length = libm::hypot(dx, dy);
            let along = if length > 0.0 { [dx / length, dy / length] } else { [0.0; 2] };
            *edge = Edge { start: vec2(from), along: vec2(along), length: T::of(length) };
        }
        Self { edges, count, rounding: T::of(rounding) }
    }
}

impl<T: Real> Object<T> for Polygon<T> {
    fn displaced(&self, by: &Displacement<T>) -> Self {
        let mut moved = *self;
        for edge in moved.edges.iter_mut().take(self.count) {
            edge.start = by.point(edge.start);
            edge.along = by.vector(edge.along);
        }
        moved
    }

    #[inline(never)]
    fn gap(&self, point: Vec2<T>) -> Gap<T> {
        let face = |edge: &Edge<T>, height: T| Gap {
            distance: height - self.rounding,
            normal: Vec2::new(edge.along.y, -edge.along.x),
            curvature: T::ZERO,
        };
        let far = T::of(1e30);
        let mut highest: Option<(&Edge<T>, T)> = None;
        let (mut corner, mut nearest) = (Vec2::new(T::ZERO, T::ZERO), far);
        for edge in self.edges.iter().take(self.count) {
            let offset = point - edge.start;
            let height = offset.x * edge.along.y - offset.y * edge.along.x;
            let along = offset.x * edge.along.x + offset.y * edge.along.y;
            if edge.length > T::ZERO {
                if height >= T::ZERO && along >= T::ZERO && along <= edge.length {
                    // Outside of one edge of a convex polygon and beside it: no other part is nearer.
                    return face(edge, height);
                }
                if highest.is_none_or(|(_, most)| height > most) {
                    highest = Some((edge, height));
                }
            }
            let square = offset.x * offset.x + offset.y * offset.y;
            if square < nearest {
                (corner, nearest) = (offset, square);
            }
        }
        if let Some((edge, height)) = highest
            && height < T::ZERO
        {
            return face(edge, height);
        }
        let distance = norm(corner);
        if distance <= T::EPSILON {
            // Only a single corner is met from no side: as good a normal as any.
            return Gap { distance: -self.rounding, normal: Vec2::new(-T::one(), T::ZERO), curvature: T::ZERO };
        }
        let inverse = T::one() / distance;
        Gap { distance: distance - self.rounding, normal: corner * inverse, curvature: inverse }
    }

    fn sharpest(&self) -> T {
        self.rounding
    }

    #[inline]
    fn clears(&self, point: Vec2<T>, least: T) -> bool {
        let reach = (self.rounding + least) * T::of(1.001);
        let outside = |edge: &Edge<T>| {
            let offset = point - edge.start;
            edge.length > T::ZERO && offset.x * edge.along.y - offset.y * edge.along.x > reach
        };
        self.edges.iter().take(self.count).any(outside)
    }
}

impl<T: Real> Blank for Polygon<T> {
    const BLANK: Self = Self { edges: [Edge::BLANK; MAX_CORNERS], count: 0, rounding: T::ZERO };
}
