//! A force that falls steeply on a branch that goes on is flagged as a snap-through, whatever the steps.

use model_core::design::{Design, Profile};
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::{Follower, Outcome, Tracking};
use model_core::object::{Motion, ObjectDesign};
use model_core::size::Paper;
use model_core::status::Status;
use reference_tests::{COUNT, ladder_80};

type Solver = Follower<f64, Paper>;

/// Just before a fold appears: with hinges of 0.77 mm the finger snaps through at 15.27°, with these the force falls by 100 N/° at 15.09°.
fn finger() -> Design {
    let mut design = ladder_80();
    design.front.thickness = Profile::constant(2.6);
    design.back.thickness = Profile::constant(2.6);
    design.hinge.thickness = 0.76;
    design
}

fn start() -> Box<Solver> {
    let design = finger();
    let mut follower: Box<Solver> = Box::new(Follower::EMPTY);
    follower.configure(&design, &Discretisation::fine(Physics::Extended)).expect("a valid finger");
    let object = ObjectDesign::Circle { centre: [42.0, 70.0], radius: 40.0 };
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(0.0));
    follower
}

fn force(follower: &Solver) -> f64 {
    let [x, y] = follower.solution().force_world();
    x.hypot(y)
}

/// Follows to an angle in steps, degrees; how often it snapped or hopped, and the last outcome.
fn closed(follower: &mut Solver, from: f64, to: f64, step: f64) -> (u32, Outcome) {
    let count = ((to - from) / step).ceil() as u32;
    let mut snaps = 0;
    let mut last = follower.follow(from.to_radians());
    for k in 1..=count {
        last = follower.follow((from + step * f64::from(k)).min(to).to_radians());
        snaps += last.snaps + last.hops;
        assert!(last.status.is_trustworthy(), "{last:?}");
    }
    (snaps, last)
}

#[test]
fn the_branch_goes_on_where_the_force_falls() {
    let mut follower = start();
    assert_eq!(follower.follow(15.05_f64.to_radians()).status, Status::Converged);
    let (mut before, mut steepest) = (force(&follower), 0.0_f64);
    let mut up = vec![before];
    for k in 1..=400 {
        assert!(follower.follow((15.05 + 0.0002 * f64::from(k)).to_radians()).iterations < 20, "no branch ends");
        let now = force(&follower);
        steepest = steepest.max((before - now) / 0.0002);
        before = now;
        up.push(now);
    }
    println!("from {:.2} N to {before:.2} N, {steepest:.0} N/° at most", up[0]);
    assert!(steepest > 80.0 && before < 0.97 * up[0]);
    // And on the same path back.
    for (k, force_up) in up.iter().enumerate().rev() {
        follower.follow((15.05 + 0.0002 * k as f64).to_radians());
        assert!((force(&follower) - force_up).abs() < 1e-4, "{k}: {} {force_up}", force(&follower));
    }
}

#[test]
fn a_steep_fall_is_flagged_once_whatever_the_steps() {
    for step in [0.005, 0.02, COUNT.to_degrees(), 0.25, 1.0] {
        let mut follower = start();
        let (snaps, before) = closed(&mut follower, 0.0, 14.9, step);
        assert_eq!((snaps, before.status), (0, Status::Converged), "steps of {step}°");
        let (snaps, after) = closed(&mut follower, 14.9, 15.4, step);
        println!("steps of {step:.3}°: {after:?}");
        assert_eq!((snaps, after.status), (1, Status::Snapped), "steps of {step}°");
    }
}

#[test]
fn one_iteration_per_tick_flags_it_as_well() {
    let mut follower = start();
    closed(&mut follower, 0.0, 14.9, 0.05);
    let mut snaps = 0;
    for k in 1..=6 {
        let to = 14.9_f64.to_radians() + f64::from(k) * COUNT;
        // Where it falls, a tick may not be enough.
        let outcomes = (0..8).map(|_| follower.track(to, Tracking::DEFAULT, 8));
        let reached = outcomes
            .inspect(|outcome| snaps += outcome.snaps + outcome.hops)
            .find(|outcome| outcome.status.is_trustworthy());
        assert!(reached.is_some(), "tick {k}");
    }
    assert_eq!(snaps, 1);
}
