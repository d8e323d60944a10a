//! The finger's plane in the picture.

use nalgebra::{DMatrix, DVector, Matrix3};

use super::camera::Camera;
use super::error::OutlineError;
use super::homography::Homography;
use super::least_squares::{Minimum, minimise};
use super::mark::Mark;
use super::photo::Photo;
use super::pose::Pose;

/// A mark is checked if at least so much of an error of it, in whatever direction, is left in the residuals. Below it the map bends
/// to the error: 1 mm would be reported as less than 0.1 mm.
const CHECKED: f64 = 0.1;
/// Singular values of less than this part of the largest are zero: freedoms that the parameters only seem to have.
const NO_FREEDOM: f64 = 1e-8;

/// From millimetres of a plane to pixels.
#[derive(Clone, Debug)]
pub struct Plane {
    camera: Option<Camera>,
    /// To normalised places with a camera, to pixels without.
    map: Homography,
}

/// How well the marks agree with a plane seen by a camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Agreement {
    /// Root mean square of the marks' distances in the picture to where the plane has them, pixels; none if four marks
    /// without a camera leave nothing to check.
    pub rms_px: Option<f64>,
    /// The same in the plane, mm.
    pub rms_mm: Option<f64>,
    /// Marks whose error in some direction would not show in these figures, as the plane would follow it.
    pub unchecked: Vec<Mark>,
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
        let rms = |squares: f64, spare: usize| (squares / spare as f64).sqrt();
        let pose = self.camera.and_then(|camera| Some((camera, pose(&self.map, camera, marks)?)));
        let measured = match self.camera {
            // A rigid plane before a known camera has six freedoms, a map eight: four marks leave two to check.
            Some(_) => pose.as_ref().map(|(_, pose)| rms(pose.residuals.norm_squared(), 2 * marks.len() - 6)),
            None if marks.len() > 4 => {
                let each = marks.iter().map(|mark| match self.pixel(mark.mm) {
                    Some(p) => (p[0] - mark.pixel[0]).powi(2) + (p[1] - mark.pixel[1]).powi(2),
                    None => f64::INFINITY,
                });
                Some(rms(each.sum(), 2 * marks.len() - 8))
            }
            None => None,
        };
        let middle = mean(marks.iter().map(|mark| mark.mm));
        let rms_mm = measured.zip(self.mm_per_pixel(middle)).map(|(rms_px, scale)| scale * rms_px);
        let moves = match &pose {
            Some((camera, pose)) => pose_moves(*camera, &pose.parameters, marks),
            None => self.moves(marks),
        };
        let hidden = moves.map_or_else(Vec::new, |moves| hidden(moves, marks.len()));
        Agreement { rms_px: measured, rms_mm, unchecked: hidden.into_iter().map(|index| marks[index]).collect() }
    }

    /// How the marks' pixels move with the map, a column per entry of its matrix.
    fn moves(&self, marks: &[Mark]) -> Option<DMatrix<f64>> {
        let pixels: Vec<[f64; 2]> = marks.iter().map(|mark| self.pixel(mark.mm)).collect::<Option<_>>()?;
        let (from, to) = (mean(marks.iter().map(|mark| mark.mm)), mean(pixels.iter().copied()));
        let spread = |points: &mut dyn Iterator<Item = [f64; 2]>, middle: [f64; 2]| {
            points.map(|p| (p[0] - middle[0]).hypot(p[1] - middle[1])).fold(0.0, f64::max)
        };
        // What the columns span does not depend on origin and unit, how well it is computed does.
        let units = [spread(&mut marks.iter().map(|mark| mark.mm), from), spread(&mut pixels.iter().copied(), to)];
        let mut moves = DMatrix::zeros(2 * marks.len(), 9);
        for (i, (mark, pixel)) in marks.iter().zip(&pixels).enumerate() {
            let depth = self.map.side(mark.mm) / self.map.side(from);
            let point = [(mark.mm[0] - from[0]) / units[0], (mark.mm[1] - from[1]) / units[0], 1.0];
            for axis in 0..2 {
                let place = (pixel[axis] - to[axis]) / units[1];
                for (column, entry) in point.into_iter().enumerate() {
                    moves[(2 * i + axis, 3 * axis + column)] = entry / depth;
                    moves[(2 * i + axis, 6 + column)] = -place * entry / depth;
                }
            }
        }
        Some(moves)
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

fn mean(points: impl Iterator<Item = [f64; 2]> + Clone) -> [f64; 2] {
    let count = points.clone().count().max(1) as f64;
    let sum = points.fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
    [sum[0] / count, sum[1] / count]
}

/// The rigid pose that has the marks nearest to their pixels.
fn pose(map: &Homography, camera: Camera, marks: &[Mark]) -> Option<Minimum> {
    let residuals = |p: &DVector<f64>| {
        let each = posed(camera, p, marks).zip(marks);
        let each = each.flat_map(|(p, mark)| [p[0] - mark.pixel[0], p[1] - mark.pixel[1]]);
        DVector::from_iterator(2 * marks.len(), each)
    };
    minimise(Pose::of(map)?.parameters(), residuals)
}

/// Where a pose has the marks, pixels.
fn posed<'a>(camera: Camera, parameters: &DVector<f64>, marks: &'a [Mark]) -> impl Iterator<Item = [f64; 2]> + use<'a> {
    Pose::from_parameters(parameters.as_slice()).pixels(camera, marks.iter().map(|mark| mark.mm))
}

/// How the marks' pixels move with a pose, a column per parameter: by central differences.
fn pose_moves(camera: Camera, parameters: &DVector<f64>, marks: &[Mark]) -> Option<DMatrix<f64>> {
    let at = |column: usize, step: f64| {
        let mut moved = parameters.clone();
        moved[column] += step;
        DVector::from_iterator(2 * marks.len(), posed(camera, &moved, marks).flatten())
    };
    let columns: Vec<DVector<f64>> = (0..parameters.len())
        .map(|column| {
            let step = 1e-5 * parameters[column].abs().max(1.0);
            (at(column, step) - at(column, -step)) / (2.0 * step)
        })
        .collect();
    let moves = DMatrix::from_columns(&columns);
    moves.iter().all(|entry| entry.is_finite()).then_some(moves)
}

/// Indices of the marks whose error the residuals hide, given how pixels move with the parameters. The residuals are what of the
/// errors lies across all these moves (Baarda, "A Testing Procedure for Use in Geodetic Networks", 1968): of an error of one mark
/// the part that its own block of the projection leaves, in the worst direction.
fn hidden(mut moves: DMatrix<f64>, marks: usize) -> Vec<usize> {
    for mut column in moves.column_iter_mut() {
        let size = column.norm();
        if size > 0.0 {
            column /= size;
        }
    }
    let svd = moves.svd(true, false);
    let Some(directions) = svd.u else { return Vec::new() };
    let least = NO_FREEDOM * svd.singular_values.max();
    let left = |a: usize, b: usize| {
        let freedoms = (0..svd.singular_values.len()).filter(|&k| svd.singular_values[k] > least);
        let taken: f64 = freedoms.map(|k| directions[(a, k)] * directions[(b, k)]).sum();
        if a == b { 1.0 - taken } else { -taken }
    };
    let is_hidden = |mark: &usize| {
        let (x, y) = (2 * mark, 2 * mark + 1);
        let (xx, xy, yy) = (left(x, x), left(x, y), left(y, y));
        // The smaller eigenvalue of a symmetric two by two.
        let least = 0.5 * (xx + yy) - (0.5 * (xx - yy)).hypot(xy);
        least < CHECKED * CHECKED
    };
    (0..marks).filter(is_hidden).collect()
}

#[cfg(test)]
mod tests {
    use image::DynamicImage;

    use super::*;

    const CORNERS: [[f64; 2]; 4] = [[-38.0, -14.0], [18.0, -14.0], [18.0, 88.0], [-38.0, 88.0]];

    /// About 0.1 mm per pixel, a little from the side.
    const MAP: Homography = Homography { matrix: Matrix3::new(10.0, 0.1, 600.0, 0.2, -10.0, 1100.0, 1e-4, 2e-4, 1.0) };

    /// What corners and more marks say of the plane, one of them moved in the picture.
    fn agreement(more: &[[f64; 2]], moved: usize, by: [f64; 2], camera: Option<Camera>) -> Agreement {
        let photo = Photo::new("p".to_owned(), &DynamicImage::new_luma8(1400, 1400));
        let mut marks: Vec<Mark> = CORNERS
            .iter()
            .chain(more)
            .map(|&mm| {
                let flat = MAP.apply(mm).unwrap();
                // A camera must see a rigid plane: straight on.
                Mark { pixel: if camera.is_some() { [600.0 + 10.0 * mm[0], 1100.0 - 10.0 * mm[1]] } else { flat }, mm }
            })
            .collect();
        marks[moved].pixel = [marks[moved].pixel[0] + by[0], marks[moved].pixel[1] + by[1]];
        Plane::through(&marks, camera, &photo).unwrap().1
    }

    fn unchecked(agreement: &Agreement) -> Vec<usize> {
        let all = [&CORNERS[..], &[[-10.0, -14.0]]].concat();
        agreement.unchecked.iter().map(|mark| all.iter().position(|&mm| mm == mark.mm).unwrap_or(99)).collect()
    }

    #[test]
    fn a_mark_that_nothing_checks_is_named() {
        // Four fit any perspective.
        assert_eq!(agreement(&[], 0, [0.0; 2], None).unchecked.len(), 4);
        // A fifth between two corners: one of the other two may lie anywhere on the line through both, and no residual tells.
        let on_side = agreement(&[[-10.0, -14.0]], 0, [0.0; 2], None);
        assert_eq!(unchecked(&on_side), [2, 3]);
        let [from, to] = [2, 3].map(|corner: usize| MAP.apply(CORNERS[corner]).unwrap());
        let along = [0, 1].map(|axis| 40.0 * (to[axis] - from[axis]) / (to[0] - from[0]).hypot(to[1] - from[1]));
        let off = agreement(&[[-10.0, -14.0]], 2, along, None);
        assert!(off.rms_px.unwrap() < 1e-3, "{off:?}");
        // The same error with others beside the lines.
        let more = [[-30.0, 10.0], [12.0, 60.0], [-28.0, 70.0], [10.0, 0.0]];
        let off = agreement(&more, 2, along, None);
        assert!(off.rms_px.unwrap() > 5.0 && off.unchecked.is_empty(), "{off:?}");
        // The fourth once more checks itself only.
        assert_eq!(agreement(&[CORNERS[3]], 0, [0.0; 2], None).unchecked.len(), 3);
    }

    #[test]
    fn a_camera_checks_four_marks() {
        let camera = Camera {
            size_px: [1400, 1400],
            focal_px: [1700.0; 2],
            centre_px: [699.5; 2],
            radial: [0.0; 2],
            tangential: [0.0; 2],
        };
        assert_eq!(agreement(&[], 0, [0.0; 2], Some(camera)).unchecked, []);
        let off = agreement(&[], 2, [40.0, 0.0], Some(camera));
        assert!(off.rms_px.unwrap() > 5.0, "{off:?}");
    }
}
