//! Outlines beside the model's front centreline.

use crate::metrics::Point;

/// Distance of a point from a polyline, mm, positive on its right-hand side (from base to tip, towards the object); none
/// without a line.
pub fn signed_distance(point: Point, line: &[Point]) -> Option<f64> {
    let mut nearest: Option<f64> = None;
    for pair in line.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let d = [b[0] - a[0], b[1] - a[1]];
        let square = d[0] * d[0] + d[1] * d[1];
        if square == 0.0 {
            continue;
        }
        let p = [point[0] - a[0], point[1] - a[1]];
        let t = ((p[0] * d[0] + p[1] * d[1]) / square).clamp(0.0, 1.0);
        let size = (p[0] - t * d[0]).hypot(p[1] - t * d[1]);
        if nearest.is_none_or(|other| size < other.abs()) {
            let right = p[0] * d[1] - p[1] * d[0] >= 0.0;
            nearest = Some(if right { size } else { -size });
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::signed_distance;

    #[test]
    fn the_sign_tells_the_side() {
        let line = [[0.0, 0.0], [0.0, 10.0], [3.0, 14.0]];
        assert_eq!(signed_distance([2.0, 5.0], &line), Some(2.0));
        assert_eq!(signed_distance([-2.0, 5.0], &line), Some(-2.0));
        assert_eq!(signed_distance([2.0, 5.0], &line[..1]), None);
    }
}
