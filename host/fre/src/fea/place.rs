//! A place of the motion: finger frame and world, and the object there.

use super::region::{self, Point};
use super::surface::Surface;
use crate::case::Case;

/// The object is behind a face if its normal at the nearest point looks out of that face by more than this, as the model has it: 1
/// straight from behind, −1 straight from the front.
pub(super) const BEHIND: f64 = 0.3;

/// The object's contour at a place of the motion, finger frame, mm: of a wall the part within `reach` of a point of that frame.
pub fn object_line(case: &Case, place: f64, middle: Point, reach: f64) -> Vec<Point> {
    Surface::whole(&case.object, world_point(case, middle, place), reach, 1)
        .displaced(&case.path.motion.world_to_finger(case.path.coordinate(place)))
        .line()
        .collect()
}

/// A world point in the finger frame at a place of the motion (degrees or mm), mm.
pub fn in_finger(case: &Case, point: Point, place: f64) -> Point {
    let p = case.path.motion.world_to_finger(case.path.coordinate(place)).point(point.into());
    [p.x, p.y]
}

/// A point of the finger frame in the world, mm.
pub(super) fn world_point(case: &Case, point: Point, place: f64) -> Point {
    let displacement = case.path.motion.world_to_finger::<f64>(case.path.coordinate(place));
    let moved = region::minus(point, [displacement.translation.x, displacement.translation.y]);
    let p = displacement.vector_back(moved.into());
    [p.x, p.y]
}
