//! What every accepted state must satisfy, looked at from inside.

use std::boxed::Box;

use super::{Follower, NEAR_ENOUGH, Settings, Target};
use crate::design::Profile;
use crate::design::ladder_80;
use crate::discretise::{Discretisation, Physics};
use crate::newton::Hessian;
use crate::object::{Motion, ObjectDesign};
use crate::random_designs::{Random, Round, first_contact, random_case};
use crate::real::Real;
use crate::size::Paper;
use crate::status::Status;

type Solver<T> = Follower<T, Paper>;

/// The inertia of the accepted state itself has nothing against it; the workspace shows it again afterwards.
fn is_stable<T: Real>(follower: &mut Solver<T>) -> bool {
    follower.show_accepted();
    let inertia = follower.work.solve(&follower.model, &mut follower.factored, Hessian::Newton, T::ZERO);
    follower.show_accepted();
    inertia.settled && !inertia.is_unstable()
}

fn start<T: Real>(object: ObjectDesign, from: f64) -> Box<Solver<T>> {
    let mut follower: Box<Solver<T>> = Box::new(Follower::EMPTY);
    let design = ladder_80();
    follower.configure(&design, &Discretisation::reduced(Physics::Extended)).expect("a valid finger");
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(from));
    follower
}

/// Small steps need no iteration: how far the state comes from the last one that a factorisation has judged.
#[test]
fn no_state_is_accepted_far_from_one_that_was_judged() {
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    let mut follower = start::<f32>(object, 0.0);
    let mut judged: std::vec::Vec<f32> = follower.timeline.accepted.angle.as_ref().to_vec();
    let (mut without, mut farthest) = (0, 0.0_f32);
    for step in 0..=1100 {
        let outcome = follower.follow((f64::from(step) * 0.01).to_radians());
        assert!(outcome.status.is_trustworthy(), "{}", outcome.status);
        let now = follower.timeline.accepted.angle.as_ref();
        let apart = now.iter().zip(&judged).fold(0.0_f32, |most, (a, b)| most.max((a - b).abs()));
        farthest = farthest.max(apart);
        if outcome.iterations > 0 {
            judged = now.to_vec();
        } else {
            without += 1;
        }
        assert!(is_stable(&mut follower), "step {step}");
    }
    std::println!("{without} of 1100 steps without an iteration, at most {farthest:.1e} rad from a judged state");
    // The judged state lies one step before the one compared with here.
    assert!(f64::from(farthest) <= 1.5 * NEAR_ENOUGH, "{farthest:e}");
}

/// The inertia that was taken for an accepted state's is its own, also where branches end.
#[test]
fn accepted_states_are_stable_by_their_own_inertia() {
    let mut follower: Box<Solver<f32>> = Box::new(Follower::EMPTY);
    let mut random = Random::new(5);
    let (mut states, mut snaps) = (0, 0);
    let mut wrong = std::vec::Vec::new();
    for case in 0..60 {
        let (design, Round { centre, radius }, indentation) = random_case(&mut random);
        let touch = first_contact(&design, centre, radius);
        for (physics, step) in [(Physics::Paper, 1.0), (Physics::Extended, 1.0), (Physics::Paper, 0.05)] {
            follower.configure(&design, &Discretisation::reduced(physics)).expect("a valid finger");
            follower.set_settings(Settings::DEFAULT).expect("the defaults");
            follower.set_object(ObjectDesign::Circle { centre, radius }, Motion::Rotating { axis: design.motor_axis });
            if !follower.start(touch) {
                continue;
            }
            let count = (indentation.to_degrees() / step) as u32;
            for k in 0..=count {
                let outcome = follower.follow(touch + (f64::from(k) * step).to_radians());
                snaps += outcome.snaps;
                if !outcome.status.is_trustworthy() {
                    break;
                }
                states += 1;
                let drift = follower.drift.to_f64();
                assert!(drift <= NEAR_ENOUGH, "{drift:e}");
                if !is_stable(&mut follower) {
                    wrong.push((case, physics, step, k, drift));
                }
            }
        }
    }
    // A finger that snaps through several times as it closes.
    let mut design = ladder_80();
    (design.front.thickness, design.back.thickness) = (Profile::constant(2.6), Profile::constant(2.6));
    design.hinge.thickness = 0.4;
    for (physics, height) in [(Physics::Paper, 70.0), (Physics::Extended, 70.0), (Physics::Extended, 55.0)] {
        follower.configure(&design, &Discretisation::reduced(physics)).expect("a valid finger");
        let object = ObjectDesign::Circle { centre: [42.0, height], radius: 40.0 };
        follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
        assert!(follower.start(0.0));
        for k in 0..=800 {
            let outcome = follower.follow((0.02 * f64::from(k)).to_radians());
            snaps += outcome.snaps;
            assert!(outcome.status.is_trustworthy(), "{outcome:?}");
            states += 1;
            if !is_stable(&mut follower) {
                wrong.push((1000, physics, height, k, follower.drift.to_f64()));
            }
        }
    }
    std::println!("{states} states, {snaps} snap-throughs, unstable: {wrong:?}");
    assert!(wrong.is_empty(), "{wrong:?}");
    assert!(states > 10_000 && snaps > 3, "{states} {snaps}");
}

/// A motion in steps far below a count goes on with a factorisation from tick to tick, and comes to what new ones come to; one that others
/// have bordered is not used.
#[test]
fn a_factorisation_outlives_the_tick() {
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    let (mut carrying, mut anew) = (start::<f64>(object, 0.0), start::<f64>(object, 0.0));
    let (mut carried, mut iterated) = (0, 0);
    for tick in 0..=300 {
        let angle = (8.0 + 1e-3 * f64::from(tick)).to_radians();
        let differs = tick % 50 == 49;
        if differs {
            assert!(carrying.sensitivity().is_some());
        }
        let before = carrying.factored.kkt.band;
        let outcome = carrying.follow(angle);
        anew.factored.is_near = false;
        assert!(outcome.status.is_trustworthy() && anew.follow(angle).status.is_trustworthy());
        if tick > 0 && outcome.iterations > 0 {
            let is_same = before == carrying.factored.kkt.band;
            assert!(!(differs && is_same), "tick {tick}");
            (carried, iterated) = (carried + u32::from(is_same), iterated + 1);
        }
        for (one, other) in carrying.solution().force_world().iter().zip(anew.solution().force_world()) {
            assert!((one - other).abs() < 1e-7, "tick {tick}: {one} {other}");
        }
        assert!(is_stable(&mut anew), "tick {tick}");
    }
    std::println!("{carried} of {iterated} ticks with an iteration have used an earlier factorisation alone");
    assert!(2 * carried > iterated && iterated > 200, "{carried} of {iterated}");
}

/// Steps on the way take their part of the time, what a call does not get to stays for the next one, and time alone changes nothing.
#[test]
fn time_is_shared_out_along_the_way() {
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    let mut follower = start::<f64>(object, 0.0);
    let mut timeless = start::<f64>(object, 0.0);
    let target = Target { coordinate: 4.5_f64.to_radians(), time_step_s: 9.0 };
    let from = follower.solution().coordinate();
    let first = follower.follow_within(target, 3);
    assert_eq!(first.status, Status::MaxIterations);
    let part = (follower.solution().coordinate() - from) / (target.coordinate - from);
    assert!(part > 0.0 && part < 1.0, "{part}");
    assert!((follower.timeline.elapsed() - 9.0 * (1.0 - part)).abs() < 1e-12, "{}", follower.timeline.elapsed());
    let last = follower.follow(Target { time_step_s: 0.5, ..target });
    assert_eq!((last.status, follower.timeline.elapsed()), (Status::Converged, 0.0));
    timeless.follow_within(target.coordinate, 3);
    timeless.follow(target.coordinate);
    assert_eq!(follower.solution().force_world(), timeless.solution().force_world());
    for wrong in [f64::NAN, -1.0, f64::INFINITY] {
        let refused = follower.follow(Target { time_step_s: wrong, ..target });
        assert_eq!(refused.status, Status::OutOfRange, "{wrong}");
    }
    assert_eq!(follower.solution().coordinate(), target.coordinate);
}
