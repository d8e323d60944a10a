//! The figures of agreement that *Geometrico-Static Modelling of a FRE Finger* uses between two results: deviation of the
//! front beam's shape and error of the net force.
//!
//! The deviation at a point of the reference line is its distance to the nearest point of the compared line. Its mean is
//! taken along the finger (x_f, base to tip): every point counts with the length of the reference line it stands for, so
//! that unevenly spaced points do not weigh more where they are dense. Measured points may lie in any order and be of several
//! outlines: there it is the length of the compared line beside them, as the way from one to the next need not follow the finger.

/// A point, mm.
pub type Point = [f64; 2];

/// Deviation of a line from a reference line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Mean along the reference line, mm.
    pub mean: f64,
    /// Largest, mm.
    pub max: f64,
    /// Point of the reference line where it is largest, mm.
    pub at: Point,
}

/// Distance of a point to the nearest point of a polyline, mm; none for an empty line.
pub fn distance(point: Point, line: &[Point]) -> Option<f64> {
    nearest(point, line).map(|nearest| nearest.distance)
}

/// Distance of a point from a polyline, mm, positive on its right-hand side (from base to tip: towards the object); none
/// without a line. Beyond an end it is the distance from the line that goes straight on: that to the end would change its sign at once where
/// the point crosses that line.
pub fn signed_distance(point: Point, line: &[Point]) -> Option<f64> {
    let Nearest { distance, aside, along, length } = nearest(point, line)?;
    let is_beyond = along <= 0.0 || along >= length;
    aside.map(|aside| if is_beyond { aside } else { distance.copysign(aside) })
}

/// Length of a polyline up to its point nearest to another one, mm; none for an empty line.
pub fn along(point: Point, line: &[Point]) -> Option<f64> {
    nearest(point, line).map(|nearest| nearest.along)
}

/// The point of a line nearest to another one.
struct Nearest {
    /// How far it is, mm.
    distance: f64,
    /// How far the other one is on the right-hand side of the segment that goes straight on, mm; none if the line has no length.
    aside: Option<f64>,
    /// Length of the line up to it, mm.
    along: f64,
    /// Length of the line, mm.
    length: f64,
}

fn nearest(point: Point, line: &[Point]) -> Option<Nearest> {
    let first = line.first()?;
    let distance = (point[0] - first[0]).hypot(point[1] - first[1]);
    let mut nearest = Nearest { distance, aside: None, along: 0.0, length: 0.0 };
    let mut before = 0.0;
    for pair in line.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let d = [b[0] - a[0], b[1] - a[1]];
        let square = d[0] * d[0] + d[1] * d[1];
        if square > 0.0 {
            let p = [point[0] - a[0], point[1] - a[1]];
            let t = ((p[0] * d[0] + p[1] * d[1]) / square).clamp(0.0, 1.0);
            let distance = (p[0] - t * d[0]).hypot(p[1] - t * d[1]);
            let length = square.sqrt();
            if nearest.aside.is_none() || distance < nearest.distance {
                let aside = Some((p[0] * d[1] - p[1] * d[0]) / length);
                nearest = Nearest { distance, aside, along: before + t * length, length: 0.0 };
            }
            before += length;
        }
    }
    Some(Nearest { length: before, ..nearest })
}

/// Deviation of `line` from `reference`, both base to tip in the same frame, mm; none if either is empty.
pub fn deviation(line: &[Point], reference: &[Point]) -> Option<Deviation> {
    let (mut sum, mut weights) = (0.0, 0.0);
    let mut worst = Deviation { mean: 0.0, max: -1.0, at: [0.0; 2] };
    let gap = |i: usize, j: usize| (reference[i][0] - reference[j][0]).hypot(reference[i][1] - reference[j][1]);
    for (i, &point) in reference.iter().enumerate() {
        let here = distance(point, line)?;
        let before = if i > 0 { gap(i, i - 1) } else { 0.0 };
        let after = if i + 1 < reference.len() { gap(i + 1, i) } else { 0.0 };
        let weight = 0.5 * (before + after);
        sum += weight * here;
        weights += weight;
        if here > worst.max {
            worst.max = here;
            worst.at = point;
        }
    }
    if worst.max < 0.0 {
        return None;
    }
    // A single point, or points in one place, have no length to weigh with.
    worst.mean = if weights > 0.0 { sum / weights } else { worst.max };
    Some(worst)
}

/// Points nearer together along a line than this lie in one place of it, mm.
const SAME_PLACE: f64 = 1e-9;

/// Deviation of `line` from measured outlines of it, in the same frame, mm; none if there is no point or no line. Every point
/// counts with half the length of the line to its neighbours of the same outline.
pub fn deviation_of_outlines<'a>(line: &[Point], outlines: impl IntoIterator<Item = &'a [Point]>) -> Option<Deviation> {
    let (mut sum, mut weights, mut plain, mut count) = (0.0, 0.0, 0.0, 0);
    let mut worst = Deviation { mean: 0.0, max: -1.0, at: [0.0; 2] };
    for outline in outlines {
        let mut places = Vec::with_capacity(outline.len());
        for &point in outline {
            let nearest = nearest(point, line)?;
            if nearest.distance > worst.max {
                worst.max = nearest.distance;
                worst.at = point;
            }
            plain += nearest.distance;
            count += 1;
            places.push(nearest);
        }
        places.sort_by(|a, b| a.along.total_cmp(&b.along));
        // Points beyond an end all lie beside that end: they share what it weighs.
        let groups: Vec<&[Nearest]> = places.chunk_by(|a, b| b.along - a.along < SAME_PLACE).collect();
        let gap = |i: usize, j: usize| groups[i][0].along - groups[j][0].along;
        for (i, group) in groups.iter().enumerate() {
            let before = if i > 0 { gap(i, i - 1) } else { 0.0 };
            let after = if i + 1 < groups.len() { gap(i + 1, i) } else { 0.0 };
            let weight = 0.5 * (before + after);
            let mean = group.iter().map(|nearest| nearest.distance).sum::<f64>() / group.len() as f64;
            sum += weight * mean;
            weights += weight;
        }
    }
    if count == 0 {
        return None;
    }
    // A single point, or points beside one place, have no length to weigh with.
    worst.mean = if weights > 0.0 { sum / weights } else { plain / f64::from(count) };
    Some(worst)
}

/// Error of a net force against its reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceError {
    /// Force less reference (magnitudes), N.
    pub difference: f64,
    /// The same over the reference, percent; none for a reference of less than 1e-9 N.
    pub percent: Option<f64>,
}

/// Error of a force's magnitude against a reference's, N.
pub fn force_error(force: f64, reference: f64) -> ForceError {
    let difference = force - reference;
    ForceError { difference, percent: (reference.abs() > 1e-9).then(|| 100.0 * difference / reference) }
}

/// Mean and largest of absolute values; none without values.
pub fn mean_and_max(values: impl IntoIterator<Item = f64>) -> Option<[f64; 2]> {
    let (mut sum, mut max, mut count) = (0.0, 0.0_f64, 0);
    for value in values {
        sum += value.abs();
        max = max.max(value.abs());
        count += 1;
    }
    (count > 0).then(|| [sum / f64::from(count), max])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_is_that_of_the_side() {
        let line = [[0.0, 0.0], [0.0, 10.0], [3.0, 14.0]];
        assert_eq!(signed_distance([2.0, 5.0], &line), Some(2.0));
        assert_eq!(signed_distance([-2.0, 5.0], &line), Some(-2.0));
        assert_eq!(signed_distance([2.0, 11.0], &line).map(|d| d > 0.0), Some(true));
        // Beyond its ends, on either side of where it would go on.
        for aside in [-1.0, -0.01, 0.01, 1.0] {
            assert_eq!(signed_distance([aside, -1.0], &line), Some(aside));
            let beyond = signed_distance([6.0 + 0.8 * aside, 18.0 - 0.6 * aside], &line).unwrap();
            assert!((beyond - aside).abs() < 1e-12, "{beyond} {aside}");
        }
        assert_eq!(signed_distance([2.0, 5.0], &line[..1]), None);
    }

    #[test]
    fn distance_is_to_segments_not_to_points() {
        let line = [[0.0, 0.0], [0.0, 10.0]];
        assert_eq!(distance([3.0, 5.0], &line), Some(3.0));
        assert_eq!(distance([3.0, 14.0], &line), Some(5.0));
        assert_eq!(distance([3.0, 4.0], &[[0.0, 0.0]]), Some(5.0));
        assert_eq!(distance([3.0, 4.0], &[]), None);
    }

    #[test]
    fn deviation_of_a_shifted_line_is_the_shift() {
        let reference: Vec<Point> = (0..=8).map(|i| [0.0, 10.0 * f64::from(i)]).collect();
        let line: Vec<Point> = reference.iter().map(|p| [p[0] - 0.3, p[1]]).collect();
        let found = deviation(&line, &reference).unwrap();
        assert!((found.mean - 0.3).abs() < 1e-12 && (found.max - 0.3).abs() < 1e-12);
    }

    #[test]
    fn sliding_along_itself_is_no_deviation_and_the_worst_place_is_named() {
        let reference = [[0.0, 0.0], [0.0, 10.0], [0.5, 20.0]];
        let line = [[0.0, -5.0], [0.0, 30.0]];
        let found = deviation(&line, &reference).unwrap();
        assert_eq!((found.max, found.at), (0.5, [0.5, 20.0]));
        assert!(found.mean > 0.1 && found.mean < 0.15, "{found:?}");
        assert_eq!(deviation(&[], &reference), None);
        assert_eq!(deviation(&line, &[]), None);
    }

    #[test]
    fn dense_points_do_not_weigh_more() {
        // Deviation 1 on the first half, 0 on the second, which has many points.
        let mut reference = vec![[1.0, 0.0], [1.0, 50.0], [0.0, 50.0]];
        reference.extend((1..=500).map(|i| [0.0, 50.0 + 0.1 * f64::from(i)]));
        let found = deviation(&[[0.0, 0.0], [0.0, 100.0]], &reference).unwrap();
        assert!((found.mean - 50.5 / 101.0).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn outlines_count_alike_however_often_and_in_whatever_order_they_come() {
        let line = [[0.0, 0.0], [0.0, 80.0]];
        let mut outline: Vec<Point> = (0..=80).map(|i| [0.0, f64::from(i)]).collect();
        outline[0][0] = 1.0;
        outline[80][0] = -1.0;
        let once = deviation_of_outlines(&line, [&outline[..]]).unwrap();
        // Half a millimetre at either end of eighty.
        assert!((once.mean - 1.0 / 80.0).abs() < 1e-12 && once.max == 1.0, "{once:?}");
        let ten = deviation_of_outlines(&line, [&outline[..]; 10]).unwrap();
        // Joined where nothing tells them apart.
        let joined = deviation_of_outlines(&line, [&outline.repeat(10)[..]]).unwrap();
        outline.reverse();
        let turned = deviation_of_outlines(&line, [&outline[..]]).unwrap();
        for other in [ten, joined, turned] {
            assert!((other.mean - once.mean).abs() < 1e-12 && other.max == once.max, "{other:?}");
        }
        assert_eq!(deviation_of_outlines(&line, []), None);
        assert_eq!(deviation_of_outlines(&[], [&outline[..]]), None);
        let one = deviation_of_outlines(&line, [&[[2.0, 5.0]][..], &[[4.0, 5.0]][..]]).unwrap();
        assert_eq!((one.mean, one.max, one.at), (3.0, 4.0, [4.0, 5.0]));
        // Where one outline ends early the other one goes on: 1 mm over 40, 3 mm over 80.
        let short = [[1.0, 0.0], [1.0, 40.0]];
        let whole = [[3.0, 0.0], [3.0, 80.0]];
        let both = deviation_of_outlines(&line, [&short[..], &whole[..]]).unwrap();
        assert!((both.mean - (40.0 + 240.0) / 120.0).abs() < 1e-12, "{both:?}");
    }

    #[test]
    fn force_error_keeps_its_sign_and_has_no_percent_without_a_reference() {
        let error = force_error(9.0, 10.0);
        assert_eq!((error.difference, error.percent), (-1.0, Some(-10.0)));
        assert_eq!(force_error(1.0, 0.0).percent, None);
        assert_eq!(mean_and_max([-3.0, 1.0]), Some([2.0, 3.0]));
        assert_eq!(mean_and_max([]), None);
    }
}
