//! Contours of objects.

use std::f64::consts::TAU;

use model_core::object::{Object as _, ObjectDesign, Piece, Shape};

use super::path::Path;

/// The contour in the world frame, mm. Of a half-plane and of a bore's wall, which have no end, the part within `reach` of a point.
pub(super) fn contour(object: &ObjectDesign, middle: [f64; 2], reach: f64) -> Path {
    // Along a hollow wall it is farther.
    let far = 2.0 * reach;
    let pieces: Vec<Piece> = object.outline(middle, far).collect();
    if let [Piece::Arc { centre: [x, y], semi_axes: [a, b], angle, turn, .. }] = pieces[..]
        && object.bounds().is_some()
        && turn == TAU
    {
        let (sin, cos) = angle.sin_cos();
        return match a == b {
            true => Path::circle([x, y], a),
            false => Path::circle([0.0, 0.0], 1.0)
                .mapped(|[u, v]| [x + a * u * cos - b * v * sin, y + a * u * sin + b * v * cos]),
        };
    }
    let is_closed = object.bounds().is_some();
    // What has no end is shown as deep as it is long.
    let behind = pieces.iter().rev().filter(|_| !is_closed).map(|piece| piece.behind(far));
    let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9;
    let begin = pieces.first().map(|piece| piece.at(0.0));
    let mut path = Path::default();
    let mut end = None;
    for piece in pieces.iter().copied().chain(behind) {
        let start = piece.at(0.0);
        if end.is_none_or(|end| !near(end, start)) {
            path.line_to(start);
        }
        match piece {
            // The last one is drawn by closing the path.
            Piece::Line { to, .. } if begin.is_some_and(|begin| near(begin, to)) => {}
            Piece::Line { to, .. } => path.line_to(to),
            Piece::Arc { centre, semi_axes: [radius, _], from, turn, .. } => {
                path.extend_arc(centre, radius, from, from + turn);
            }
        }
        end = Some(piece.at(1.0));
    }
    path.closed()
}

/// The contour as points, for programs that know no curves.
pub fn object_contour(object: &ObjectDesign, middle: [f64; 2], reach: f64) -> Vec<[f64; 2]> {
    const PIECES: u32 = 12;
    contour(object, middle, reach).points(PIECES)
}

/// Signed distance of a point, mm.
pub(super) fn distance(object: &ObjectDesign, [x, y]: [f64; 2]) -> f64 {
    Shape::<f64>::from(*object).gap([x, y].into()).distance
}

/// The point of the contour next to a point.
pub(super) fn onto(object: &ObjectDesign, [x, y]: [f64; 2]) -> [f64; 2] {
    let gap = Shape::<f64>::from(*object).gap([x, y].into());
    [x - gap.distance * gap.normal.x, y - gap.distance * gap.normal.y]
}

/// Unit vector from a point towards the object.
pub(super) fn towards(object: &ObjectDesign, [x, y]: [f64; 2]) -> [f64; 2] {
    let gap = Shape::<f64>::from(*object).gap([x, y].into());
    [-gap.normal.x, -gap.normal.y]
}
