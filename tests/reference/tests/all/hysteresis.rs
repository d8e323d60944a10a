//! Every branch of `fea-80` at R40_High: closing beyond the snap and opening again, one count of the servo's sensor at a time.
//!
//! The finite elements drop from 22.2 N at 10.5° to 9.5 N at 12°, the coarse mesh by a jump; so do we, at 11 to 12°. On opening
//! the finger stays on the branch it fell to well below that angle, then comes back to the first one.

use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::estimator::Estimator;
use model_core::object::{Motion, ObjectDesign};
use model_core::size::{Paper, Reduced};
use model_core::status::Status;
use reference_tests::{COUNT, circle_80, fea_80};

const HIGH: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 60.0], radius: 40.0 };
/// 13°, beyond the snap.
const LAST: i32 = 148;

/// Force in N and status at every count from 0 to [`LAST`] and back, then an open hand.
struct Course {
    closing: Vec<(f64, Status)>,
    opening: Vec<(f64, Status)>,
}

impl Course {
    fn of(mut tick: impl FnMut(f64) -> (f64, Status)) -> Self {
        let mut at = |count: i32| tick(f64::from(count) * COUNT);
        let closing: Vec<_> = (0..=LAST).map(&mut at).collect();
        let mut opening: Vec<_> = (0..=LAST).rev().map(&mut at).collect();
        opening.reverse();
        // At 0 the beam and the circle still meet, at no force; one count further the hand is open and the flag gone.
        assert_eq!(at(-1).1, Status::NoContact);
        Self { closing, opening }
    }

    /// The count at which closing met the snap, and the lowest at which opening is still on the other branch.
    fn check(&self, name: &str) -> (usize, usize) {
        let snap = self.closing.iter().position(|&(_, status)| status == Status::Snapped).expect("a snap on closing");
        let degrees = |count: usize| (count as f64 * COUNT).to_degrees();
        for (count, &(force, status)) in self.closing.iter().enumerate() {
            let expected = if count < snap { [Status::Converged, Status::NoContact] } else { [Status::Snapped; 2] };
            assert!(expected.contains(&status), "{name}, closing, {:.2}°: {status} with {force} N", degrees(count));
        }
        // On opening every equilibrium carries the flag until the hand is open.
        for (count, &(force, status)) in self.opening.iter().enumerate() {
            assert!(
                status == Status::Snapped || (count == 0 && status == Status::NoContact),
                "{name}, opening, {:.2}°: {status} with {force} N",
                degrees(count)
            );
        }
        let differs = |count: &usize| (self.opening[*count].0 - self.closing[*count].0).abs() > 1e-2;
        let back = (0..snap).find(differs).expect("hysteresis: opening must differ from closing below the snap");
        assert!((back..snap).all(|count| differs(&count)), "{name}: the branches must meet once");
        println!(
            "{name}: snaps at {:.2}°, {:.2} N to {:.2} N; comes back at {:.2}°, {:.2} N to {:.2} N",
            degrees(snap),
            self.closing[snap - 1].0,
            self.closing[snap].0,
            degrees(back),
            self.opening[back].0,
            self.opening[back - 1].0,
        );
        (snap, back)
    }
}

fn follower() -> Box<Follower<f64, Paper>> {
    let mut follower: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
    let design = fea_80();
    follower.configure(&design, &Discretisation::fine(Physics::Extended)).expect("a valid design");
    follower.set_object(HIGH, Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(0.0));
    follower
}

#[test]
fn closing_beyond_the_snap_and_opening_again_comes_back_to_the_first_branch() {
    let mut finger = follower();
    let course = Course::of(|angle| {
        let status = finger.follow(angle).status;
        let [x, y] = finger.solution().force_world();
        (x.hypot(y), status)
    });
    let (snap, back) = course.check("fine, f64");
    assert!((125..=137).contains(&snap), "the snap is at 11 to 12°, not at count {snap}");
    assert!(back < snap, "hysteresis");
    // Below the way back opening is closing, to the last digit that the tolerance leaves.
    for (count, (closing, opening)) in course.closing.iter().zip(&course.opening).take(back).enumerate() {
        assert!(
            (closing.0 - opening.0).abs() < 1e-6,
            "count {count}: {} N closing, {} N opening",
            closing.0,
            opening.0
        );
    }
    // Closing again after the hand was open begins without a flag, on the first branch.
    let angle = 6.0_f64.to_radians();
    assert_eq!(finger.follow(angle).status, Status::Converged);
    let [x, y] = finger.solution().force_world();
    let count = (angle / COUNT).round() as usize;
    assert!((x.hypot(y) - course.closing[count].0).abs() < 0.1, "{} N at 6°", x.hypot(y));
}

#[test]
fn the_estimator_shows_the_same_hysteresis_with_the_same_flags() {
    let mut estimator: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
    estimator.configure(&fea_80(), &Discretisation::estimator(Physics::Extended)).expect("a valid design");
    estimator.set_object(circle_80(60.0)).expect("a valid object");
    let course = Course::of(|angle| {
        // The snap itself takes more iterations than one tick has: stale ticks say so, the servo waits here.
        let mut estimate = estimator.update(angle);
        for _ in 0..200 {
            if estimate.status.is_trustworthy() {
                break;
            }
            estimate = estimator.update(angle);
        }
        (f64::from(estimate.force_magnitude()), estimate.status)
    });
    let (snap, back) = course.check("estimator, f32");
    assert!((125..=137).contains(&snap), "the snap is at 11 to 12°, not at count {snap}");
    for (count, (closing, opening)) in course.closing.iter().zip(&course.opening).take(back).enumerate() {
        assert!(
            (closing.0 - opening.0).abs() < 1e-2,
            "count {count}: {} N closing, {} N opening",
            closing.0,
            opening.0
        );
    }
}
