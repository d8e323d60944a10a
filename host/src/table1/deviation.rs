//! How far two front beams lie apart.

/// Points at which two beams are compared, evenly along them.
const POINTS: usize = 161;

/// Distance between two centrelines at the same share of their length, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Mean along the beam.
    pub mean_mm: f64,
    /// Largest.
    pub max_mm: f64,
}

/// Mean and largest distance between two centrelines at equal shares of their length, from base to tip; none unless both
/// have a length.
pub fn deviation(one: &[[f64; 2]], other: &[[f64; 2]]) -> Option<Deviation> {
    let (one, other) = (evenly(one)?, evenly(other)?);
    let distances: Vec<f64> = one.iter().zip(&other).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).collect();
    let mean_mm = distances.iter().sum::<f64>() / distances.len() as f64;
    Some(Deviation { mean_mm, max_mm: distances.into_iter().fold(0.0, f64::max) })
}

/// Points at equal arc lengths of a polyline.
fn evenly(line: &[[f64; 2]]) -> Option<Vec<[f64; 2]>> {
    let mut arcs = vec![0.0];
    for pair in line.windows(2) {
        arcs.push(arcs.last()? + (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]));
    }
    let length = *arcs.last()?;
    if line.len() < 2 || !length.is_finite() || length <= 0.0 {
        return None;
    }
    let at = |i: usize| {
        let arc = length * i as f64 / (POINTS - 1) as f64;
        let next = arcs.partition_point(|&known| known < arc).clamp(1, line.len() - 1);
        let (low, high) = (arcs[next - 1], arcs[next]);
        let share = if high > low { ((arc - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
        [0, 1].map(|k| line[next - 1][k] + share * (line[next][k] - line[next - 1][k]))
    };
    Some((0..POINTS).map(at).collect())
}

#[cfg(test)]
mod tests {
    use super::deviation;

    #[test]
    fn a_shifted_line_is_its_shift_away_whatever_its_points() {
        let one = [[0.0, 0.0], [0.0, 80.0]];
        let other: Vec<[f64; 2]> = [0.0, 1.0, 17.5, 60.0, 80.0].map(|y| [0.5, y]).to_vec();
        let found = deviation(&one, &other).unwrap();
        assert!((found.mean_mm - 0.5).abs() < 1e-12 && (found.max_mm - 0.5).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn a_turned_line_is_farthest_at_its_tip() {
        let found = deviation(&[[0.0, 0.0], [0.0, 80.0]], &[[0.0, 0.0], [48.0, 64.0]]).unwrap();
        let tip = 48.0_f64.hypot(16.0);
        assert!((found.max_mm - tip).abs() < 1e-9 && (found.mean_mm - tip / 2.0).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn no_line_has_no_deviation() {
        assert_eq!(deviation(&[], &[[0.0, 0.0], [0.0, 1.0]]), None);
        assert_eq!(deviation(&[[1.0, 1.0], [1.0, 1.0]], &[[0.0, 0.0], [0.0, 1.0]]), None);
    }
}
