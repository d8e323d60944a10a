//! Contours and names of objects.

use model_core::object::{Object as _, ObjectDesign, Shape};

use super::number::short;
use super::path::Path;
use super::scene::unit;

/// The contour in the world frame, mm. Of a half-plane and of a bore's wall, which have no end, the part within `reach` of a point.
pub(super) fn contour(object: &ObjectDesign, middle: [f64; 2], reach: f64) -> Path {
    match object {
        ObjectDesign::Circle { centre, radius } => Path::circle(*centre, *radius),
        ObjectDesign::Ellipse { centre, semi_axes: [a, b], angle } => {
            let (sin, cos) = angle.sin_cos();
            Path::circle([0.0, 0.0], 1.0)
                .mapped(|[x, y]| [centre[0] + a * x * cos - b * y * sin, centre[1] + a * x * sin + b * y * cos])
        }
        ObjectDesign::Polygon { corners, rounding } => rounded(corners, *rounding),
        ObjectDesign::HalfPlane { normal, .. } => {
            let [x, y] = onto(object, middle);
            let [nx, ny] = unit(*normal);
            let at = |along: f64, deep: f64| [x - along * ny - deep * nx, y + along * nx - deep * ny];
            Path::polygon([at(-reach, 0.0), at(reach, 0.0), at(reach, 2.0 * reach), at(-reach, 2.0 * reach)])
        }
        ObjectDesign::Bore { centre: [x, y], radius } => {
            let [ahead_x, ahead_y] = onto(object, middle);
            let ahead = (ahead_y - y).atan2(ahead_x - x);
            let half = (2.0 * reach / radius).min(std::f64::consts::PI);
            let on = |r: f64, angle: f64| [x + r * angle.cos(), y + r * angle.sin()];
            let outer = radius + 2.0 * reach;
            let mut path = Path::lines([on(*radius, ahead - half)]);
            path.extend_arc([*x, *y], *radius, ahead - half, ahead + half);
            path.line_to(on(outer, ahead + half));
            path.extend_arc([*x, *y], outer, ahead + half, ahead - half);
            path.closed()
        }
    }
}

/// The contour as points, for programs that know no curves.
pub fn object_contour(object: &ObjectDesign, middle: [f64; 2], reach: f64) -> Vec<[f64; 2]> {
    const PIECES: u32 = 12;
    contour(object, middle, reach).points(PIECES)
}

/// The contour at a distance from a convex polygon.
fn rounded(corners: &[[f64; 2]], rounding: f64) -> Path {
    if let [corner] = corners {
        return Path::circle(*corner, rounding);
    }
    let twice_area: f64 = (0..corners.len())
        .map(|k| {
            let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
            a[0] * b[1] - a[1] * b[0]
        })
        .sum();
    let mut corners = corners.to_vec();
    if twice_area < 0.0 {
        corners.reverse();
    }
    let count = corners.len();
    let mut path = Path::default();
    for (k, &corner) in corners.iter().enumerate() {
        let (before, after) = (corners[(k + count - 1) % count], corners[(k + 1) % count]);
        // Outward normals of the edges that meet here; the object lies on their left.
        let angle = |from: [f64; 2], to: [f64; 2]| (from[0] - to[0]).atan2(to[1] - from[1]);
        let from = angle(before, corner);
        let turn = (angle(corner, after) - from).rem_euclid(std::f64::consts::TAU);
        let (sin, cos) = from.sin_cos();
        let start = [corner[0] + rounding * cos, corner[1] + rounding * sin];
        path.line_to(start);
        path.extend_arc(corner, rounding, from, from + turn);
    }
    path.closed()
}

/// Middle and radius of a circle around the object, world frame, mm; none for a half-plane or a bore.
pub(super) fn bounds(object: &ObjectDesign) -> Option<([f64; 2], f64)> {
    match object {
        ObjectDesign::Circle { centre, radius } => Some((*centre, *radius)),
        ObjectDesign::Ellipse { centre, semi_axes, .. } => Some((*centre, semi_axes[0].max(semi_axes[1]))),
        ObjectDesign::Polygon { corners, rounding } => {
            let count = corners.len() as f64;
            let sum = corners.iter().fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
            let middle = [sum[0] / count, sum[1] / count];
            let far = corners.iter().map(|p| (p[0] - middle[0]).hypot(p[1] - middle[1])).fold(0.0, f64::max);
            Some((middle, far + rounding))
        }
        ObjectDesign::HalfPlane { .. } | ObjectDesign::Bore { .. } => None,
    }
}

/// A lowest point of the contour.
pub(super) fn lowest(object: &ObjectDesign) -> [f64; 2] {
    match object {
        ObjectDesign::Circle { centre, radius } | ObjectDesign::Bore { centre, radius } => {
            [centre[0], centre[1] - radius]
        }
        ObjectDesign::Ellipse { centre, semi_axes: [a, b], angle } => {
            let (sin, cos) = angle.sin_cos();
            // The support point against y.
            let reach = (a * sin).hypot(b * cos);
            let aside = (a * a - b * b) * sin * cos / reach;
            [centre[0] - aside, centre[1] - reach]
        }
        ObjectDesign::Polygon { corners, rounding } => {
            let low = corners.iter().copied().min_by(|p, q| p[1].total_cmp(&q[1])).unwrap_or_default();
            [low[0], low[1] - rounding]
        }
        ObjectDesign::HalfPlane { point, .. } => *point,
    }
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

/// What the object is called in a picture.
pub(super) fn words(object: &ObjectDesign) -> String {
    match object {
        ObjectDesign::Circle { radius, .. } => format!("object Ø{} mm", short(2.0 * radius, 3)),
        ObjectDesign::Ellipse { semi_axes: [a, b], .. } => {
            format!("object {} × {} mm", short(2.0 * a, 3), short(2.0 * b, 3))
        }
        ObjectDesign::Polygon { rounding, .. } => format!("object, rounding {} mm", short(*rounding, 3)),
        ObjectDesign::HalfPlane { .. } => "object".to_owned(),
        ObjectDesign::Bore { radius, .. } => format!("object, bore Ø{} mm", short(2.0 * radius, 3)),
    }
}
