//! Outlines of objects as lines and arcs: what pictures, pages and finite elements are made from.

use super::ObjectDesign;
use core::f64::consts::{PI, TAU};

/// A piece of an outline, mm. The object lies on its left: outlines of bodies run counter-clockwise, a bore's wall runs clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// A straight piece.
    Line {
        /// Where it begins.
        from: [f64; 2],
        /// Where it ends.
        to: [f64; 2],
    },
    /// An arc of a circle or an ellipse: centre + R(angle) (a cos t, b sin t).
    Arc {
        /// Centre.
        centre: [f64; 2],
        /// Semi-axes a and b.
        semi_axes: [f64; 2],
        /// Angle of the first one from x, rad, counter-clockwise.
        angle: f64,
        /// Parameter t where it begins, rad.
        from: f64,
        /// How far t goes, rad; negative for a wall that is hollow.
        turn: f64,
    },
}

impl Piece {
    /// A point at a part 0 … 1 of the piece.
    pub fn at(&self, part: f64) -> [f64; 2] {
        match *self {
            Self::Line { from, to } => [0, 1].map(|i| from[i] + part * (to[i] - from[i])),
            Self::Arc { centre, semi_axes, angle, from, turn } => {
                let (s, c) = libm::sincos(from + part * turn);
                let (sin, cos) = libm::sincos(angle);
                let [x, y] = [semi_axes[0] * c, semi_axes[1] * s];
                [centre[0] + cos * x - sin * y, centre[1] + sin * x + cos * y]
            }
        }
    }

    /// The same piece inside the object, at a depth, run backwards. Of a convex arc, no deeper than its centre.
    pub fn behind(&self, depth: f64) -> Self {
        match *self {
            Self::Line { from, to } => {
                let along = [to[0] - from[0], to[1] - from[1]];
                let size = libm::hypot(along[0], along[1]).max(f64::MIN_POSITIVE);
                let inwards = [-along[1] * depth / size, along[0] * depth / size];
                let deep = |p: [f64; 2]| [p[0] + inwards[0], p[1] + inwards[1]];
                Self::Line { from: deep(to), to: deep(from) }
            }
            Self::Arc { centre, semi_axes, angle, from, turn } => {
                let shift = if turn < 0.0 { depth } else { -depth };
                let semi_axes = semi_axes.map(|axis| (axis + shift).max(0.0));
                Self::Arc { centre, semi_axes, angle, from: from + turn, turn: -turn }
            }
        }
    }

    /// Smallest radius of curvature of an arc that bulges out, mm.
    pub fn sharpest(&self) -> Option<f64> {
        match *self {
            Self::Arc { semi_axes: [a, b], turn, .. } if turn > 0.0 => Some((b * b / a).min(a * a / b)),
            _ => None,
        }
    }
}

impl ObjectDesign {
    /// The outline, piece by piece, world frame; of a wall, also a bore's, which have no end, the part within `reach` of the point of the
    /// wall next to `middle`, along it.
    pub fn outline(&self, middle: [f64; 2], reach: f64) -> impl Iterator<Item = Piece> {
        let whole = |centre: [f64; 2], semi_axes: [f64; 2], angle: f64| Piece::Arc {
            centre,
            semi_axes,
            angle,
            from: 0.0,
            turn: TAU,
        };
        let one = match *self {
            Self::Circle { centre, radius } => Some(whole(centre, [radius; 2], 0.0)),
            Self::Ellipse { centre, semi_axes, angle } => Some(whole(centre, semi_axes, angle)),
            Self::Polygon { corners, rounding } => match *corners {
                [corner] => Some(whole(corner, [rounding; 2], 0.0)),
                _ => None,
            },
            Self::HalfPlane { point, normal } => {
                let size = libm::hypot(normal[0], normal[1]).max(f64::MIN_POSITIVE);
                let n = normal.map(|x| x / size);
                let above = (middle[0] - point[0]) * n[0] + (middle[1] - point[1]) * n[1];
                let foot = [middle[0] - above * n[0], middle[1] - above * n[1]];
                let at = |along: f64| [foot[0] - along * n[1], foot[1] + along * n[0]];
                Some(Piece::Line { from: at(-reach), to: at(reach) })
            }
            Self::Bore { centre, radius } => {
                let ahead = libm::atan2(middle[1] - centre[1], middle[0] - centre[0]);
                let half = (reach / radius).min(PI);
                Some(Piece::Arc { centre, semi_axes: [radius; 2], angle: 0.0, from: ahead + half, turn: -2.0 * half })
            }
        };
        let pieces = match self {
            Self::Polygon { corners, .. } if corners.len() > 1 => 2 * corners.len(),
            _ => 1,
        };
        let object = *self;
        (0..pieces).filter_map(move |piece| one.or_else(|| object.rounded(piece)))
    }

    /// A piece of a rounded polygon: arc and line by turns.
    fn rounded(&self, piece: usize) -> Option<Piece> {
        let Self::Polygon { corners, rounding } = self else { return None };
        let count = corners.len();
        let edges = corners.iter().zip(corners.iter().cycle().skip(1));
        let is_clockwise = edges.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() < 0.0;
        let corner = |k: usize| {
            let k = k.checked_rem(count)?;
            corners.get(if is_clockwise { count - 1 - k } else { k }).copied()
        };
        // Direction of the outward normal of the side between two corners.
        let normal = |from: [f64; 2], to: [f64; 2]| libm::atan2(from[0] - to[0], to[1] - from[1]);
        let k = piece / 2;
        let (before, here, after) = (corner(k + count - 1)?, corner(k)?, corner(k + 1)?);
        let (from, to) = (normal(before, here), normal(here, after));
        if piece.is_multiple_of(2) {
            let turn = (to - from) - TAU * libm::floor((to - from) / TAU);
            return Some(Piece::Arc { centre: here, semi_axes: [*rounding; 2], angle: 0.0, from, turn });
        }
        let (sin, cos) = libm::sincos(to);
        let out = |p: [f64; 2]| [p[0] + rounding * cos, p[1] + rounding * sin];
        Some(Piece::Line { from: out(here), to: out(after) })
    }

    /// A circle around the object: middle and radius, mm; none for what has no end.
    pub fn bounds(&self) -> Option<([f64; 2], f64)> {
        match self {
            Self::Circle { centre, radius } => Some((*centre, *radius)),
            Self::Ellipse { centre, semi_axes, .. } => Some((*centre, semi_axes[0].max(semi_axes[1]))),
            Self::Polygon { corners, rounding } => {
                let count = corners.len() as f64;
                let sum = corners.iter().fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
                let middle = sum.map(|sum| sum / count);
                let far = |p: &[f64; 2]| libm::hypot(p[0] - middle[0], p[1] - middle[1]);
                Some((middle, corners.iter().map(far).fold(0.0, f64::max) + rounding))
            }
            Self::HalfPlane { .. } | Self::Bore { .. } => None,
        }
    }

    /// A lowest point of the outline, mm; of a wall, a point of it.
    pub fn lowest(&self) -> [f64; 2] {
        match self {
            Self::Circle { centre, radius } | Self::Bore { centre, radius } => [centre[0], centre[1] - radius],
            Self::Ellipse { centre, semi_axes: [a, b], angle } => {
                let (sin, cos) = libm::sincos(*angle);
                // The support point against y.
                let reach = libm::hypot(a * sin, b * cos);
                let aside = (a * a - b * b) * sin * cos / reach;
                [centre[0] - aside, centre[1] - reach]
            }
            Self::Polygon { corners, rounding } => {
                let low = corners.iter().copied().min_by(|p, q| p[1].total_cmp(&q[1])).unwrap_or_default();
                [low[0], low[1] - rounding]
            }
            Self::HalfPlane { point, .. } => *point,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Corners, Object as _, Shape};
    use super::*;
    use std::vec::Vec;

    fn objects() -> [ObjectDesign; 7] {
        let polygon = |corners: &[[f64; 2]]| ObjectDesign::Polygon {
            corners: Corners::new(corners).expect("few corners"),
            rounding: 3.0,
        };
        [
            ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 },
            ObjectDesign::Ellipse { centre: [31.0, 45.0], semi_axes: [20.0, 45.0], angle: 0.4 },
            polygon(&[[20.0, 30.0]]),
            polygon(&[[20.0, 30.0], [60.0, 35.0]]),
            // Clockwise.
            polygon(&[[20.0, 30.0], [20.0, 70.0], [60.0, 70.0], [60.0, 30.0]]),
            ObjectDesign::HalfPlane { point: [5.0, 0.0], normal: [-3.0, 0.5] },
            ObjectDesign::Bore { centre: [-60.0, 45.0], radius: 70.0 },
        ]
    }

    /// Every piece lies on the surface that the solver sees, has the object on its left, and begins where the one before ends.
    #[test]
    fn pieces_follow_the_surface_with_the_object_on_their_left() {
        for object in objects() {
            let shape = Shape::<f64>::from(object);
            let gap = |[x, y]: [f64; 2]| shape.gap([x, y].into()).distance;
            let pieces: Vec<Piece> = object.outline([1.0, 40.0], 30.0).collect();
            for (piece, next) in pieces.iter().zip(pieces.iter().cycle().skip(1)) {
                for part in [0.0, 0.3, 0.5, 1.0] {
                    assert!(gap(piece.at(part)).abs() < 1e-9, "{object:?} {piece:?}");
                }
                let (p, q) = (piece.at(0.5), piece.at(0.500_01));
                let along = [q[0] - p[0], q[1] - p[1]];
                let size = libm::hypot(along[0], along[1]);
                let left = [p[0] - 0.1 * along[1] / size, p[1] + 0.1 * along[0] / size];
                assert!(gap(left) < -0.09, "{object:?} {piece:?}");
                assert!((gap(piece.behind(0.5).at(0.5)) + 0.5).abs() < 0.1, "{object:?} {piece:?}");
                let (end, start) = (piece.at(1.0), next.at(0.0));
                let joins = libm::hypot(end[0] - start[0], end[1] - start[1]) < 1e-9;
                assert!(joins || object.bounds().is_none(), "{object:?} {piece:?}");
            }
            let sharpest = pieces.iter().filter_map(Piece::sharpest).fold(f64::INFINITY, f64::min);
            assert!(sharpest.min(1e3) >= shape.sharpest().min(1e3) - 1e-9, "{object:?} {sharpest}");
        }
    }

    #[test]
    fn all_of_a_body_is_within_its_bounds_and_not_below_its_lowest_point() {
        for object in objects() {
            let low = object.lowest();
            let Some((middle, radius)) = object.bounds() else { continue };
            for piece in object.outline(middle, 1.0) {
                for part in 0..20 {
                    let p = piece.at(f64::from(part) / 20.0);
                    assert!(libm::hypot(p[0] - middle[0], p[1] - middle[1]) < radius + 1e-9, "{object:?}");
                    assert!(p[1] > low[1] - 1e-9, "{object:?}");
                }
            }
        }
    }
}
