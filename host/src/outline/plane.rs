//! The finger's plane in the picture.

use nalgebra::{DVector, Matrix3};

use super::OutlineError;
use super::camera::Camera;
use super::homography::Homography;
use super::least_squares::minimise;
use super::marks::Mark;
use super::photo::Photo;
use super::pose::Pose;

/// From millimetres of a plane to pixels.
#[derive(Clone, Debug)]
pub struct Plane {
    camera: Option<Camera>,
    /// To normalised places with a camera, to pixels without.
    map: Homography,
}

/// How well the marks agree with a plane seen by a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Root mean square of the marks' distances in the picture to where the plane has them, pixels; none if four marks
    /// without a camera leave nothing to check.
    pub rms_px: Option<f64>,
    /// The same in the plane, mm.
    pub rms_mm: Option<f64>,
}

impl Plane {
    /// The plane through marks, in the frame of their millimetres.
    ///
    /// # Errors
    /// There are fewer than four, one is outside the picture, they lie (almost) on a line, or no plane seen from the front
    /// has them in these places.
    pub fn through(marks: &[Mark], camera: Option<Camera>, photo: &Photo) -> Result<(Self, Agreement), OutlineError> {
        if marks.len() < 4 {
            return Err(OutlineError::TooFewMarks(marks.len()));
        }
        if let Some(outside) = marks.iter().find(|mark| !photo.contains(mark.pixel)) {
            let [width, height] = photo.size();
            return Err(OutlineError::MarkOutside { mark: *outside, width, height });
        }
        if let Some(camera) = camera
            && camera.size_px != photo.size()
        {
            return Err(OutlineError::OtherSize { camera: camera.size_px, photo: photo.size() });
        }
        let target = |mark: &Mark| match camera {
            Some(camera) => camera.normalised(mark.pixel).ok_or(OutlineError::NoInverse(mark.pixel)),
            None => Ok(mark.pixel),
        };
        let pairs = marks.iter().map(|mark| Ok((mark.mm, target(mark)?))).collect::<Result<Vec<_>, OutlineError>>()?;
        let map = Homography::fit(&pairs).ok_or(OutlineError::MarksOnLine)?;
        let sides = marks.iter().map(|mark| map.side(mark.mm));
        if sides.clone().any(|side| side <= 0.0) && sides.clone().any(|side| side >= 0.0) {
            return Err(OutlineError::MarksCrossed);
        }
        let plane = Self { camera, map };
        let agreement = plane.agreement(marks);
        Ok((plane, agreement))
    }

    fn agreement(&self, marks: &[Mark]) -> Agreement {
        let none = Agreement { rms_px: None, rms_mm: None };
        let rms = |squares: f64, spare: usize| (squares / spare as f64).sqrt();
        let measured = match self.camera {
            // A rigid plane before a known camera has six freedoms, a map eight: four marks leave two to check.
            Some(camera) => self.pose_residual(camera, marks).map(|squares| rms(squares, 2 * marks.len() - 6)),
            None if marks.len() > 4 => {
                let each = marks.iter().map(|mark| match self.pixel(mark.mm) {
                    Some(p) => (p[0] - mark.pixel[0]).powi(2) + (p[1] - mark.pixel[1]).powi(2),
                    None => f64::INFINITY,
                });
                Some(rms(each.sum(), 2 * marks.len() - 8))
            }
            None => None,
        };
        match measured {
            Some(rms_px) => {
                let count = marks.len() as f64;
                let sum = marks.iter().fold([0.0; 2], |sum, mark| [sum[0] + mark.mm[0], sum[1] + mark.mm[1]]);
                let scale = self.mm_per_pixel([sum[0] / count, sum[1] / count]);
                Agreement { rms_px: Some(rms_px), rms_mm: scale.map(|scale| scale * rms_px) }
            }
            None => none,
        }
    }

    /// Sum of the squared distances in the picture, pixels², of the best rigid pose.
    fn pose_residual(&self, camera: Camera, marks: &[Mark]) -> Option<f64> {
        let residuals = |p: &DVector<f64>| {
            let pose = Pose::from_parameters(p.as_slice());
            let pixels = pose.pixels(camera, marks.iter().map(|mark| mark.mm));
            let each = pixels.zip(marks).flat_map(|(p, mark)| [p[0] - mark.pixel[0], p[1] - mark.pixel[1]]);
            DVector::from_iterator(2 * marks.len(), each)
        };
        Some(minimise(Pose::of(&self.map)?.parameters(), residuals)?.residuals.norm_squared())
    }

    /// The same plane in another frame of it: `[x, y]` there is R(angle)·`[x, y]` + shift in this one's.
    pub fn in_frame(&self, angle: f64, shift: [f64; 2]) -> Self {
        let (sin, cos) = angle.sin_cos();
        let motion = Matrix3::new(cos, -sin, shift[0], sin, cos, shift[1], 0.0, 0.0, 1.0);
        Self { camera: self.camera, map: Homography { matrix: self.map.matrix * motion } }
    }

    /// Pixel of a point, mm; none for points that no camera can see.
    pub fn pixel(&self, mm: [f64; 2]) -> Option<[f64; 2]> {
        let place = self.map.apply(mm)?;
        Some(match self.camera {
            Some(camera) => camera.pixel(place),
            None => place,
        })
    }

    /// Millimetres per pixel at a point: the root of the ratio of areas.
    pub fn mm_per_pixel(&self, mm: [f64; 2]) -> Option<f64> {
        let [x, y] = mm;
        let d = 0.05;
        let (left, right) = (self.pixel([x - d, y])?, self.pixel([x + d, y])?);
        let (below, above) = (self.pixel([x, y - d])?, self.pixel([x, y + d])?);
        let area = (right[0] - left[0]) * (above[1] - below[1]) - (right[1] - left[1]) * (above[0] - below[0]);
        (area != 0.0).then(|| 2.0 * d / area.abs().sqrt())
    }
}
