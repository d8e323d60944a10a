//! A camera from pictures of a checkerboard (Zhang, "A Flexible New Technique for Camera Calibration", 2000): focal lengths
//! in closed form with the principal point in the picture's middle, then everything by least squares of the corners' distances.

use nalgebra::{DMatrix, DVector};

use super::camera::Camera;
use super::checkerboard::Corner;
use super::homography::Homography;
use super::least_squares::minimise;
use super::pose::Pose;

/// Parameters of the camera: focal lengths, principal point, k₁, k₂, p₁, p₂.
const CAMERA: usize = 8;
/// The least accurate focal length that is accepted, relative standard deviation.
const LEAST_ACCURACY: f64 = 0.02;

/// A calibrated camera.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// The camera.
    pub camera: Camera,
    /// Root mean square of the corners' distances (both coordinates), pixels.
    pub rms_px: f64,
    /// Largest distance of a corner in each picture, pixels.
    pub largest_px: Vec<f64>,
    /// Standard deviation of the focal length f_x, pixels.
    pub focal_deviation_px: f64,
}

/// Why pictures determine no camera.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoCamera {
    /// Too few.
    #[error("a camera needs at least 3 pictures of the checkerboard, {0} given")]
    TooFew(usize),
    /// The poses are too alike.
    #[error(
        "the pictures of the checkerboard do not determine the camera: tilt the board by 20 to 40° in different directions"
    )]
    Alike,
    /// They do, but badly.
    #[error(
        "the pictures of the checkerboard determine the focal length to ±{0:.0} % only, needed is 2 %: tilt the board by 20 to 40° in different directions and fill the picture"
    )]
    Inaccurate(f64),
}

/// Calibrates from corners (in squares) of several pictures of one size.
///
/// # Errors
/// There are fewer than three, or their poses are too alike.
pub fn calibrate(boards: &[Vec<Corner>], size_px: [u32; 2], square_mm: f64) -> Result<Calibration, NoCamera> {
    if boards.len() < 3 {
        return Err(NoCamera::TooFew(boards.len()));
    }
    let boards: Vec<Vec<Corner>> = boards
        .iter()
        .map(|board| board.iter().map(|&([i, j], pixel)| ([i * square_mm, j * square_mm], pixel)).collect())
        .collect();
    let centre = size_px.map(|length| 0.5 * (f64::from(length) - 1.0));
    let focal = focal_lengths(&boards, centre).ok_or(NoCamera::Alike)?;
    let start = Camera { size_px, focal_px: focal, centre_px: centre, radial: [0.0; 2], tangential: [0.0; 2] };
    let mut parameters = vec![focal[0], focal[1], centre[0], centre[1], 0.0, 0.0, 0.0, 0.0];
    for board in &boards {
        let pairs: Option<Vec<_>> = board.iter().map(|(mm, pixel)| Some((*mm, start.normalised(*pixel)?))).collect();
        let map = pairs.and_then(|pairs| Homography::fit(&pairs)).ok_or(NoCamera::Alike)?;
        parameters.extend(Pose::of(&map).ok_or(NoCamera::Alike)?.parameters().iter());
    }
    let corners: usize = boards.iter().map(Vec::len).sum();
    let camera = |p: &[f64]| Camera {
        size_px,
        focal_px: [p[0], p[1]],
        centre_px: [p[2], p[3]],
        radial: [p[4], p[5]],
        tangential: [p[6], p[7]],
    };
    let residuals = |p: &DVector<f64>| {
        let camera = camera(p.as_slice());
        let mut all = Vec::with_capacity(2 * corners);
        for (board, pose) in boards.iter().zip(p.as_slice()[CAMERA..].chunks(6)) {
            let pixels = Pose::from_parameters(pose).pixels(camera, board.iter().map(|corner| corner.0));
            all.extend(pixels.zip(board).flat_map(|(p, (_, pixel))| [p[0] - pixel[0], p[1] - pixel[1]]));
        }
        DVector::from_vec(all)
    };
    let minimum = minimise(DVector::from_vec(parameters), residuals).ok_or(NoCamera::Alike)?;
    let deviations = minimum.deviations.ok_or(NoCamera::Alike)?;
    let focal_deviation_px = deviations[0].max(deviations[1]);
    let camera = camera(minimum.parameters.as_slice());
    let relative = focal_deviation_px / camera.focal_px[0].abs();
    if relative.is_nan() || relative > LEAST_ACCURACY {
        return Err(NoCamera::Inaccurate(100.0 * relative));
    }
    let mut rest = minimum.residuals.as_slice();
    let largest_px = boards.iter().map(|board| {
        let (own, others) = rest.split_at(2 * board.len());
        rest = others;
        own.chunks(2).map(|d| d[0].hypot(d[1])).fold(0.0, f64::max)
    });
    let largest_px = largest_px.collect();
    let rms_px = (minimum.residuals.norm_squared() / corners as f64).sqrt();
    Ok(Calibration { camera, rms_px, largest_px, focal_deviation_px })
}

/// 1/f_x² and 1/f_y² are linear in the conditions that the plane's axes are at right angles and as long as each other.
fn focal_lengths(boards: &[Vec<Corner>], centre: [f64; 2]) -> Option<[f64; 2]> {
    let mut system = DMatrix::zeros(2 * boards.len(), 2);
    let mut right = DVector::zeros(2 * boards.len());
    for (row, board) in boards.iter().enumerate() {
        let pairs: Vec<_> =
            board.iter().map(|(mm, pixel)| (*mm, [pixel[0] - centre[0], pixel[1] - centre[1]])).collect();
        let h = Homography::fit(&pairs)?.matrix;
        // Both conditions in the same scale, whatever the scale of the map.
        let norm = h.column(0).norm() * h.column(1).norm();
        for axis in 0..2 {
            system[(2 * row, axis)] = h[(axis, 0)] * h[(axis, 1)] / norm;
            system[(2 * row + 1, axis)] = (h[(axis, 0)].powi(2) - h[(axis, 1)].powi(2)) / norm;
        }
        right[2 * row] = -h[(2, 0)] * h[(2, 1)] / norm;
        right[2 * row + 1] = -(h[(2, 0)].powi(2) - h[(2, 1)].powi(2)) / norm;
    }
    let found = system.svd(true, true).solve(&right, 1e-12).ok()?;
    let focal = [found[0].powf(-0.5), found[1].powf(-0.5)];
    focal.iter().all(|f| f.is_finite() && *f > 1.0).then_some(focal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    const CAMERA: Camera = Camera {
        size_px: [1600, 1200],
        focal_px: [1810.0, 1795.0],
        centre_px: [812.0, 588.0],
        radial: [-0.25, 0.1],
        tangential: [0.0015, -0.001],
    };

    fn board(tilt: [f64; 3]) -> Vec<Corner> {
        let pose = Pose { rotation: Vector3::from(tilt), translation: Vector3::new(-80.0, -50.0, 330.0) };
        let places: Vec<[f64; 2]> = (0..54).map(|k| [f64::from(k % 9), f64::from(k / 9)]).collect();
        let pixels = pose.pixels(CAMERA, places.iter().map(|p| p.map(|x| 20.0 * x)));
        let pixels: Vec<_> = pixels.collect();
        places.into_iter().zip(pixels).collect()
    }

    #[test]
    fn exact_corners_give_the_camera_back() {
        let tilts = [[0.5, 0.1, 0.0], [-0.4, 0.3, 0.1], [0.1, -0.5, 0.3], [0.3, 0.4, -0.2]];
        let boards: Vec<_> = tilts.into_iter().map(board).collect();
        let found = calibrate(&boards, CAMERA.size_px, 20.0).unwrap();
        assert!(found.rms_px < 1e-6, "{found:?}");
        assert!((found.camera.focal_px[0] - 1810.0).abs() < 1e-3, "{found:?}");
        assert!((found.camera.radial[0] + 0.25).abs() < 1e-5 && (found.camera.tangential[0] - 0.0015).abs() < 1e-6);
    }

    #[test]
    fn boards_that_face_the_camera_determine_nothing() {
        let boards: Vec<_> = [0.0, 0.2, 0.4].into_iter().map(|turn| board([0.0, 0.0, turn])).collect();
        assert!(calibrate(&boards, CAMERA.size_px, 20.0).is_err());
        assert_eq!(calibrate(&boards[..2], CAMERA.size_px, 20.0).unwrap_err(), NoCamera::TooFew(2));
    }
}
