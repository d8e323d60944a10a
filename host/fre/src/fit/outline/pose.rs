//! Where a plane lies before the camera.

use nalgebra::{DVector, Matrix3, Rotation3, Vector3};

use super::camera::Camera;
use super::homography::Homography;

/// Rotation (axis times angle) and translation from a plane's frame (z = 0 on it) into the camera's (z ahead).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Axis times angle, rad.
    pub rotation: Vector3<f64>,
    /// The plane's origin in the camera's frame, mm.
    pub translation: Vector3<f64>,
}

impl Pose {
    /// The pose whose projection is nearest to a map from the plane (mm) to normalised places; none if the map is degenerate.
    pub fn of(map: &Homography) -> Option<Self> {
        let h = map.matrix;
        let scale = 2.0 / (h.column(0).norm() + h.column(1).norm());
        // The plane lies before the camera.
        let scale = if h[(2, 2)] < 0.0 { -scale } else { scale };
        let (a, b) = (h.column(0) * scale, h.column(1) * scale);
        let svd = Matrix3::from_columns(&[a, b, a.cross(&b)]).svd(true, true);
        let rotation = svd.u? * svd.v_t?;
        let rotation = Rotation3::from_matrix_unchecked(rotation).scaled_axis();
        let pose = Self { rotation, translation: h.column(2) * scale };
        (pose.rotation.iter().chain(pose.translation.iter()).all(|x| x.is_finite())).then_some(pose)
    }

    /// From six parameters: rotation, translation.
    pub fn from_parameters(p: &[f64]) -> Self {
        let vector = |from: usize| Vector3::from_iterator((from..from + 3).map(|i| p.get(i).copied().unwrap_or(0.0)));
        Self { rotation: vector(0), translation: vector(3) }
    }

    /// The six parameters.
    pub fn parameters(&self) -> DVector<f64> {
        DVector::from_iterator(6, self.rotation.iter().chain(self.translation.iter()).copied())
    }

    /// Pixels of points of the plane, mm.
    pub fn pixels(self, camera: Camera, points: impl IntoIterator<Item = [f64; 2]>) -> impl Iterator<Item = [f64; 2]> {
        let (rotation, translation) = (Rotation3::new(self.rotation), self.translation);
        points.into_iter().map(move |[x, y]| {
            let seen = rotation * Vector3::new(x, y, 0.0) + translation;
            camera.pixel([seen.x / seen.z, seen.y / seen.z])
        })
    }
}
