//! Where the motion begins: the object clear in front of the undeformed finger.

use model_core::object::{Object as _, Shape};

use super::error::FeaError;
use super::place::BEHIND;
use super::region::{self, Point, Region};
use crate::case::Case;

/// The undeformed finger and the object at a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closest {
    /// Distance of the object to the faces that may touch, mm; negative inside of it.
    distance: f64,
    /// The object's nearest point, finger frame, mm.
    pub(super) object: Point,
    /// How far the object's normal there looks out of the front face; see [`BEHIND`].
    from_behind: f64,
}

impl Closest {
    /// The object neither touches the finger nor has passed it. A rounding error of a tangent beginning is not a penetration.
    fn is_clear(&self) -> bool {
        self.distance >= -1e-9 && self.from_behind <= BEHIND
    }
}

/// Where the object is nearest to the faces of the undeformed finger that may touch: the front beam's outer face and the tip's end
/// face.
pub(super) fn closest(case: &Case, region: &Region<'_>, place: f64) -> Closest {
    const SAMPLES: usize = 200;
    let by = case.path.motion.world_to_finger(case.path.coordinate(place));
    let object = Shape::<f64>::from(case.object).displaced(&by);
    let (faces, [corner, _, last]) = (region.front, region.top);
    let (length, across) = (faces.length(), region::minus(last, corner));
    let end = across[0].hypot(across[1]);
    // Along the outer face, then on across the end face.
    let point = |arc: f64| match arc - length {
        on if on > 0.0 => [0, 1].map(|axis| corner[axis] + on / end * across[axis]),
        _ => faces.outer(arc),
    };
    let gap = |arc: f64| object.gap(point(arc).into());
    let step = (length + end) / SAMPLES as f64;
    // The corner between the faces is often the nearest and lies between two samples.
    let arcs = (0..=SAMPLES).map(|i| step * i as f64).chain([length]);
    let distances = arcs.map(|arc| (arc, gap(arc).distance));
    let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.0, |found| found.0);
    // To the neighbours of the nearest sample, by thirds.
    let (mut low, mut high) = ((nearest - step).max(0.0), (nearest + step).min(length + end));
    for _ in 0..100 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if gap(a).distance < gap(b).distance { high = b } else { low = a }
    }
    let arc = [0.5 * (low + high), nearest].into_iter().min_by(|&a, &b| gap(a).distance.total_cmp(&gap(b).distance));
    let arc = arc.unwrap_or(nearest);
    let (point, gap) = (point(arc), gap(arc));
    let inward = faces.inward(0.0);
    Closest {
        distance: gap.distance,
        object: [point[0] - gap.distance * gap.normal.x, point[1] - gap.distance * gap.normal.y],
        from_behind: -(gap.normal.x * inward[0] + gap.normal.y * inward[1]),
    }
}

/// The place where the motion begins: the first place if the object lies clear in front of the undeformed finger there, else where
/// it just touches the finger that is opened from there (or, failing that, closed). A finger that has passed the object, be it as
/// small as a window between lamellae, is opened past it again: as in the model, contact comes from the front.
pub(super) fn start(case: &Case, region: &Region<'_>) -> Result<f64, FeaError> {
    let is_clear = |place: f64| closest(case, region, place).is_clear();
    let first = case.path.places.first().copied().unwrap_or(0.0);
    if is_clear(first) {
        return Ok(first);
    }
    for sign in [-1.0, 1.0] {
        let mut touching = first;
        for i in 1..=1800 {
            let place = first + sign * 0.05 * f64::from(i);
            if is_clear(place) {
                let mut free = place;
                for _ in 0..60 {
                    let middle = 0.5 * (free + touching);
                    if is_clear(middle) {
                        free = middle;
                    } else {
                        touching = middle;
                    }
                }
                return Ok(free);
            }
            touching = place;
        }
    }
    Err(FeaError::NoStart)
}
