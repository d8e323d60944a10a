//! The first branch of a motion: how far it reaches, and the largest force on it.

use model_core::equilibrium::{Follower, Target};
use model_core::object::Motion;
use model_core::real::Real;
use model_core::status::Status;
use serde::{Deserialize, Serialize};

use crate::case::MotionPath;
use crate::heap::Host;

/// Least number of steps into which a stretch with a peak or a snap-through is divided to find it, and their greatest length in the
/// case's unit, as long as they are not too many.
const STEPS: usize = 25;
const LONGEST: f64 = 0.25;
const MOST_STEPS: usize = 1000;

/// What a finger can hold before it snaps through.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FirstBranch {
    /// Largest force, N, on the way through the places asked for; where it falls again or the finger snaps through, peaks
    /// between the places count.
    pub max_force_n: f64,
    /// Motor angle of that force, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_force_at_deg: Option<f64>,
    /// Distance of that force, mm, of a translated base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_force_at_mm: Option<f64>,
    /// Angles between which it snaps through, degrees; absent if the motion meets no snap-through.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub snap_between_deg: Option<[f64; 2]>,
    /// Distances between which it snaps through, mm, of a translated base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub snap_between_mm: Option<[f64; 2]>,
}

impl FirstBranch {
    /// Place of the largest force, in the case's unit.
    pub fn max_force_at(&self) -> Option<f64> {
        self.max_force_at_deg.or(self.max_force_at_mm)
    }

    /// Places between which it snaps through, in the case's unit.
    pub fn snap_between(&self) -> Option<[f64; 2]> {
        self.snap_between_deg.or(self.snap_between_mm)
    }
}

/// What was found at a place: its status and the magnitude of the force.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Place in the case's unit.
    pub place: f64,
    /// Time since the place before, s.
    pub seconds: f64,
    /// Its status.
    pub status: Status,
    /// Snap-throughs since the place before.
    pub snaps: u32,
    /// Force, N; none without a trustworthy status.
    pub force: Option<f64>,
    /// Its derivative with respect to the place, N per unit of the case.
    pub slope: Option<f64>,
}

/// The branch after a place, from that before it. Counted from 1: every snap-through begins another, an open hand is on the first
/// again. None from the first place on that has no trustworthy solution: nobody knows where the path went from there.
pub fn next_branch(before: Option<u32>, status: Status, snaps: u32) -> Option<u32> {
    match status {
        Status::NoContact => before.map(|_| 1),
        status if status.is_trustworthy() => before.map(|branch| branch + snaps),
        _ => None,
    }
}

/// The branch of each place.
pub fn branches(found: &[Found]) -> Vec<Option<u32>> {
    let mut branch = Some(1);
    let of = |one: &Found| {
        branch = next_branch(branch, one.status, one.snaps);
        branch
    };
    found.iter().map(of).collect()
}

/// The first branch of a path that was followed; `again` makes a follower at its beginning. None if not even
/// the first place has a trustworthy solution.
pub fn first_branch<T: Real>(
    path: &MotionPath,
    found: &[Found],
    again: impl FnOnce() -> Option<Follower<T, Host>>,
    budget: u32,
) -> Option<FirstBranch> {
    let on_first = found.iter().take_while(|one| one.status.is_trustworthy() && one.snaps == 0).count();
    let first = &found[..on_first];
    let force = |one: &Found| one.force.unwrap_or(0.0);
    let top = (0..on_first).max_by(|&a, &b| force(&first[a]).total_cmp(&force(&first[b])));
    let snapped = found.get(on_first).filter(|one| one.snaps > 0);
    let mut best = top.map(|top| [force(&first[top]), first[top].place]);
    let (mut snap, mut ended) = (None, false);
    // A force that falls again, at the next place or already at the last one, has its peak between the places beside the largest
    // one; both stretches are gone through in small steps, and so is the one with the snap-through.
    let falls = |top: usize| {
        let before = top.checked_sub(1).map_or(f64::NEG_INFINITY, |before| first[before].place);
        first[top].slope.is_some_and(|slope| slope * (first[top].place - before).signum() < 0.0)
    };
    let peak = top.filter(|&top| top + 1 < on_first || falls(top));
    if peak.is_some() || snapped.is_some() {
        let mut follower = again()?;
        let mut before = path.place(follower.solution().coordinate());
        for (index, one) in first.iter().chain(snapped).enumerate() {
            let fine = index == on_first || top.is_some_and(|top| index == top || index == top + 1);
            let start = before;
            let steps = (((one.place - start).abs() / LONGEST) as usize).clamp(STEPS, MOST_STEPS);
            let steps = if fine { steps } else { 1 };
            for step in 1..=steps {
                let place =
                    if step == steps { one.place } else { start + (one.place - start) * step as f64 / steps as f64 };
                let time_step_s = one.seconds / steps as f64;
                let outcome =
                    follower.follow_within(Target { coordinate: path.coordinate(place), time_step_s }, budget);
                if outcome.snaps > 0 || !outcome.status.is_trustworthy() {
                    snap = (outcome.snaps > 0).then_some([before, place]);
                    ended = true;
                    break;
                }
                let [x, y] = follower.solution().force_world().map(T::to_f64);
                let force = x.hypot(y);
                if best.is_none_or(|[most, _]| force > most) {
                    best = Some([force, place]);
                }
                before = place;
            }
            if ended {
                break;
            }
        }
        // Smaller steps may just so stay on the branch where larger ones did not.
        snap = snap.or(snapped.filter(|_| !ended).map(|snapped| [before, snapped.place]));
    }
    let [max_force_n, place] = best?;
    let rotating = matches!(path.motion, Motion::Rotating { .. });
    Some(FirstBranch {
        max_force_n,
        max_force_at_deg: rotating.then_some(place),
        max_force_at_mm: (!rotating).then_some(place),
        snap_between_deg: snap.filter(|_| rotating),
        snap_between_mm: snap.filter(|_| !rotating),
    })
}

#[cfg(test)]
mod tests {
    use model_core::status::Status;

    use super::{Found, branches};

    #[test]
    fn a_snap_begins_a_branch_and_an_open_hand_the_first() {
        let found = |status, snaps| Found { place: 0.0, seconds: 0.0, status, snaps, force: None, slope: None };
        let path = [
            found(Status::NoContact, 0),
            found(Status::Converged, 0),
            found(Status::Snapped, 1),
            found(Status::Snapped, 0),
            found(Status::Snapped, 2),
            found(Status::NoContact, 1),
            found(Status::Converged, 0),
            found(Status::Folded, 0),
            found(Status::Converged, 0),
        ];
        let expected = [Some(1), Some(1), Some(2), Some(2), Some(4), Some(1), Some(1), None, None];
        assert_eq!(branches(&path), expected);
    }
}
