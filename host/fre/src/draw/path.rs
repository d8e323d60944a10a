//! Areas and lines, of straight pieces and Bézier curves; rectangles.

use kurbo::{Arc, BezPath, Circle, ParamCurve as _, PathEl, PathSeg, Point, Shape as _};

/// How far a curve that stands for an arc may be off it, px: below what anybody sees.
const TOLERANCE: f64 = 1e-3;

/// An area's edge, or a line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path(pub BezPath);

impl Path {
    /// The path with every point moved.
    pub(super) fn mapped(&self, to: impl Fn([f64; 2]) -> [f64; 2]) -> Self {
        let to = |p: Point| point(to(array(p)));
        let element = |element: PathEl| match element {
            PathEl::MoveTo(p) => PathEl::MoveTo(to(p)),
            PathEl::LineTo(p) => PathEl::LineTo(to(p)),
            PathEl::QuadTo(a, p) => PathEl::QuadTo(to(a), to(p)),
            PathEl::CurveTo(a, b, p) => PathEl::CurveTo(to(a), to(b), to(p)),
            PathEl::ClosePath => PathEl::ClosePath,
        };
        Self(self.0.iter().map(element).collect())
    }

    /// A polyline.
    pub fn lines(points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let mut path = Self::default();
        for point in points {
            path.line_to(point);
        }
        path
    }

    /// Continues to a point; begins there if the path is empty.
    pub fn line_to(&mut self, to: [f64; 2]) {
        if self.0.elements().is_empty() { self.0.move_to(point(to)) } else { self.0.line_to(point(to)) }
    }

    /// A smooth curve through points (Catmull–Rom).
    pub fn smooth(points: &[[f64; 2]]) -> Self {
        let mut path = Self::lines(points.first().copied());
        path.extend_smooth(points);
        path
    }

    /// Continues from the first point, where the path is, through the others.
    pub fn extend_smooth(&mut self, points: &[[f64; 2]]) {
        let Some(last) = points.len().checked_sub(1) else { return };
        for i in 0..last {
            let (before, a, b, after) =
                (points[i.saturating_sub(1)], points[i], points[i + 1], points[(i + 2).min(last)]);
            let first = [a[0] + (b[0] - before[0]) / 6.0, a[1] + (b[1] - before[1]) / 6.0];
            let second = [b[0] - (after[0] - a[0]) / 6.0, b[1] - (after[1] - a[1]) / 6.0];
            self.0.curve_to(point(first), point(second), point(b));
        }
    }

    /// A curve that leaves a point and reaches another one in given directions.
    pub fn curve(from: [f64; 2], leaving: [f64; 2], reaching: [f64; 2], to: [f64; 2]) -> Self {
        let mut path = Self::lines([from]);
        path.0.curve_to(point(leaving), point(reaching), point(to));
        path
    }

    /// A closed polygon.
    pub fn polygon(points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Self::lines(points).closed()
    }

    /// The same, closed.
    pub fn closed(mut self) -> Self {
        // A path without a beginning cannot be closed.
        if !self.0.elements().is_empty() {
            self.0.close_path();
        }
        self
    }

    /// A circle.
    pub fn circle(centre: [f64; 2], radius: f64) -> Self {
        Self(Circle::new(point(centre), radius).to_path(TOLERANCE * radius.max(1.0)))
    }

    /// Continues from where the path is along an arc of a circle, angles in rad; the path is at its beginning.
    pub fn extend_arc(&mut self, centre: [f64; 2], radius: f64, from: f64, to: f64) {
        let arc = Arc::new(point(centre), (radius, radius), from, to - from, 0.0);
        self.0.extend(arc.append_iter(TOLERANCE * radius.max(1.0)));
    }

    /// An arc of a circle, angles in rad, clockwise on the screen for growing angles.
    pub fn arc(centre: [f64; 2], radius: f64, from: f64, to: f64) -> Self {
        let mut path = Self::lines([[centre[0] + radius * from.cos(), centre[1] + radius * from.sin()]]);
        path.extend_arc(centre, radius, from, to);
        path
    }

    /// A rectangle.
    pub fn rectangle(Rect { left, top, right, bottom }: Rect) -> Self {
        Self::polygon([[left, top], [right, top], [right, bottom], [left, bottom]])
    }

    /// Points of the path, its curves as so many straight pieces each.
    pub fn points(&self, pieces: u32) -> Vec<[f64; 2]> {
        let parts = || (1..=pieces).map(|k| f64::from(k) / f64::from(pieces));
        let mut points: Vec<[f64; 2]> = Vec::new();
        for segment in self.0.segments() {
            if points.is_empty() {
                points.push(array(segment.start()));
            }
            match segment {
                PathSeg::Line(line) => points.push(array(line.p1)),
                curve => points.extend(parts().map(|part| array(curve.eval(part)))),
            }
        }
        points
    }
}

/// A point as the library has it.
fn point([x, y]: [f64; 2]) -> Point {
    Point::new(x, y)
}

fn array(p: Point) -> [f64; 2] {
    [p.x, p.y]
}

/// A rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// Smallest x.
    pub left: f64,
    /// Smallest y.
    pub top: f64,
    /// Largest x.
    pub right: f64,
    /// Largest y.
    pub bottom: f64,
}

impl Rect {
    /// The rectangle at another place.
    pub fn moved(self, [right, down]: [f64; 2]) -> Self {
        Self { left: self.left + right, top: self.top + down, right: self.right + right, bottom: self.bottom + down }
    }

    /// The smallest rectangle that holds this one and another.
    pub fn with(self, other: Self) -> Self {
        Self {
            left: self.left.min(other.left),
            top: self.top.min(other.top),
            right: self.right.max(other.right),
            bottom: self.bottom.max(other.bottom),
        }
    }

    /// True if all of it lies in another one.
    pub fn within(self, other: Self) -> bool {
        self.left >= other.left && self.top >= other.top && self.right <= other.right && self.bottom <= other.bottom
    }

    /// The corners one after the other, the first again at the end.
    pub fn corners(self) -> Vec<[f64; 2]> {
        let Self { left, top, right, bottom } = self;
        vec![[left, top], [right, top], [right, bottom], [left, bottom], [left, top]]
    }

    /// True if a straight line between two points has a part in it.
    pub fn meets(self, [a, b]: [[f64; 2]; 2]) -> bool {
        // The part of the line, 0 at its beginning and 1 at its end, that lies between the sides, and between top and bottom.
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (axis, [low, high]) in [[self.left, self.right], [self.top, self.bottom]].into_iter().enumerate() {
            let step = b[axis] - a[axis];
            if step == 0.0 {
                if !(low..=high).contains(&a[axis]) {
                    return false;
                }
                continue;
            }
            let ends = [(low - a[axis]) / step, (high - a[axis]) / step];
            from = from.max(ends[0].min(ends[1]));
            to = to.min(ends[0].max(ends[1]));
        }
        from <= to
    }
}

#[cfg(test)]
mod tests {
    use super::Path;

    #[test]
    fn a_polyline_has_all_its_pieces_and_an_arc_its_curve() {
        assert_eq!(Path::lines([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]]).closed().0.to_svg(), "M0,0 L1,0 L1,2 Z");
        assert!(Path::default().closed().points(4).is_empty());
        for [x, y] in Path::arc([3.0, 4.0], 5.0, 0.2, 2.0).points(20) {
            assert!(((x - 3.0).hypot(y - 4.0) - 5.0).abs() < 0.01, "({x}, {y})");
        }
    }
}
