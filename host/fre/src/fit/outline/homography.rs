//! Maps between planes: the direct linear transformation with normalised coordinates (Hartley and Zisserman, "Multiple View
//! Geometry in Computer Vision", 2nd edition, algorithm 4.2), refined on the distances in the picture.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::least_squares::minimise;

/// Least ratio of the eighth to the largest singular value: below it points lie almost on a line.
const LEAST_RANK: f64 = 1e-3;

/// A map from one plane to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homography {
    /// In homogeneous coordinates.
    pub matrix: Matrix3<f64>,
}

impl Homography {
    /// The map that takes every first point of a pair to the second; none with fewer than four pairs, or if they lie so
    /// that they do not determine it (three of four on a line).
    pub fn fit(pairs: &[([f64; 2], [f64; 2])]) -> Option<Self> {
        if pairs.len() < 4 {
            return None;
        }
        let from = normalisation(pairs.iter().map(|pair| pair.0))?;
        let to = normalisation(pairs.iter().map(|pair| pair.1))?;
        let mut system = DMatrix::zeros(2 * pairs.len().max(5), 9);
        for (row, pair) in pairs.iter().enumerate() {
            let p = from * Vector3::new(pair.0[0], pair.0[1], 1.0);
            let q = to * Vector3::new(pair.1[0], pair.1[1], 1.0);
            for column in 0..3 {
                system[(2 * row, column)] = p[column];
                system[(2 * row, 6 + column)] = -q.x * p[column];
                system[(2 * row + 1, 3 + column)] = p[column];
                system[(2 * row + 1, 6 + column)] = -q.y * p[column];
            }
        }
        let svd = system.svd(false, true);
        let rows = svd.v_t?;
        let mut order: Vec<usize> = (0..9).collect();
        order.sort_by(|&a, &b| svd.singular_values[b].total_cmp(&svd.singular_values[a]));
        if svd.singular_values[order[7]] < LEAST_RANK * svd.singular_values[order[0]] {
            return None;
        }
        let null = rows.row(order[8]);
        let normalised = Matrix3::from_row_iterator(null.iter().copied());
        let matrix = to.try_inverse()? * normalised * from;
        Self::scaled(matrix)?.refined(pairs)
    }

    fn scaled(matrix: Matrix3<f64>) -> Option<Self> {
        let norm = matrix.norm();
        let matrix = matrix / if matrix[(2, 2)] < 0.0 { -norm } else { norm };
        (matrix.iter().all(|entry| entry.is_finite()) && matrix.determinant() != 0.0).then_some(Self { matrix })
    }

    /// Least squares of the distances between mapped and given points; four pairs leave nothing to do.
    fn refined(self, pairs: &[([f64; 2], [f64; 2])]) -> Option<Self> {
        if pairs.len() == 4 {
            return Some(self);
        }
        let of = |p: &DVector<f64>| Self { matrix: Matrix3::from_row_iterator(p.iter().copied().chain([1.0])) };
        let start = self.matrix / self.matrix[(2, 2)];
        if !start.iter().all(|entry| entry.is_finite()) {
            return Some(self);
        }
        let start = DVector::from_iterator(8, (0..8).map(|i| start[(i / 3, i % 3)]));
        let residuals = |p: &DVector<f64>| {
            let map = of(p);
            let each = pairs.iter().flat_map(|(from, to)| {
                let found = map.apply(*from).unwrap_or([f64::INFINITY; 2]);
                [found[0] - to[0], found[1] - to[1]]
            });
            DVector::from_iterator(2 * pairs.len(), each)
        };
        match minimise(start, residuals) {
            Some(minimum) => Self::scaled(of(&minimum.parameters).matrix),
            None => Some(self),
        }
    }

    /// Where a point is mapped to; none for a point on the line that is mapped to infinity.
    pub fn apply(&self, point: [f64; 2]) -> Option<[f64; 2]> {
        let mapped = self.matrix * Vector3::new(point[0], point[1], 1.0);
        (mapped.z.abs() > 1e-12).then(|| [mapped.x / mapped.z, mapped.y / mapped.z])
    }

    /// On which side of the line that is mapped to infinity a point lies: what a camera sees lies on one side.
    pub fn side(&self, point: [f64; 2]) -> f64 {
        (self.matrix * Vector3::new(point[0], point[1], 1.0)).z
    }
}

/// The similarity that moves points to the origin, √2 away on average; none if they lie in one place.
fn normalisation(points: impl Iterator<Item = [f64; 2]> + Clone) -> Option<Matrix3<f64>> {
    let count = points.clone().count() as f64;
    let sum = points.clone().fold([0.0, 0.0], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
    let centre = [sum[0] / count, sum[1] / count];
    let distance = points.map(|p| (p[0] - centre[0]).hypot(p[1] - centre[1])).sum::<f64>() / count;
    (distance > 1e-9).then(|| {
        let scale = std::f64::consts::SQRT_2 / distance;
        Matrix3::new(scale, 0.0, -scale * centre[0], 0.0, scale, -scale * centre[1], 0.0, 0.0, 1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_points_determine_a_perspective_and_more_average_it() {
        let truth = Homography { matrix: Matrix3::new(9.0, 0.8, 300.0, -0.5, -8.5, 900.0, 4e-4, 7e-4, 1.0) };
        let points = [[-40.0, -10.0], [35.0, -12.0], [38.0, 95.0], [-42.0, 90.0], [3.0, 41.0], [-20.0, 70.0]];
        for count in [4, 6] {
            let pairs: Vec<_> = points[..count].iter().map(|&p| (p, truth.apply(p).unwrap())).collect();
            let found = Homography::fit(&pairs).unwrap();
            let (p, q) = (found.apply([10.0, 20.0]).unwrap(), truth.apply([10.0, 20.0]).unwrap());
            assert!((p[0] - q[0]).hypot(p[1] - q[1]) < 1e-8);
        }
    }

    #[test]
    fn three_of_four_on_a_line_determine_nothing() {
        let on_line = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [5.0, 9.0]].map(|p| (p, p));
        assert_eq!(Homography::fit(&on_line), None);
        assert_eq!(Homography::fit(&on_line[..3]), None);
        assert_eq!(Homography::fit(&[([1.0, 1.0], [1.0, 1.0]); 4]), None);
    }
}
