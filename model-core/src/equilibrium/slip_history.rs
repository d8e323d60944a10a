//! What friction remembers and what it dissipates, where a finger goes back, lets go and comes again.

use std::boxed::Box;
use std::vec::Vec;

use super::{Follower, Settings};
use crate::design::ladder_80;
use crate::discretise::{Discretisation, Physics};
use crate::object::{Corners, Motion, ObjectDesign};
use crate::real::Real;
use crate::size::Rubbing;
use crate::status::Status;

type Solver<T> = Follower<T, Rubbing>;

const CIRCLE: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };

fn start<T: Real>(object: ObjectDesign, friction: f64) -> Box<Solver<T>> {
    let design = ladder_80();
    let mut follower: Box<Solver<T>> = Box::new(Follower::EMPTY);
    follower.configure(&design, &Discretisation::estimator(Physics::Extended)).expect("a valid finger");
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    follower.set_friction(friction).expect("a coefficient in range");
    assert!(follower.start(0.0));
    follower
}

fn to<T: Real>(follower: &mut Solver<T>, degrees: f64) {
    let outcome = follower.follow(degrees.to_radians());
    assert!(outcome.status.is_trustworthy(), "{degrees}°: {outcome:?}");
}

/// Forces along the object, and what is dissipated.
fn rubbed<T: Real>(follower: &Solver<T>) -> (Vec<f64>, f64) {
    let solution = follower.solution();
    (solution.contacts().map(|contact| contact.tangential.to_f64()).collect(), solution.dissipated().to_f64())
}

/// Where an object cannot be moved, friction's past is as before as well: forces, what is dissipated, and all that follows.
#[test]
fn a_move_that_fails_leaves_no_trace() {
    for turns in [false, true] {
        let [mut follower, mut untouched] = [0, 1].map(|_| start::<f64>(CIRCLE, 0.6));
        for follower in [&mut follower, &mut untouched] {
            for degrees in [2.0, 4.0, 6.0, 7.0, 8.0, 7.9] {
                to(follower, degrees);
            }
        }
        let before = rubbed(&follower);
        let outcome = if turns {
            follower.turn_object([41.0, 145.0], -1.5, CIRCLE)
        } else {
            follower.shift_object([-70.0, 0.0], CIRCLE)
        };
        assert!(!outcome.status.is_trustworthy() && outcome.steps > 0, "{outcome:?}");
        assert_eq!(rubbed(&follower), before);
        for degrees in [7.8, 7.5, 8.5] {
            for follower in [&mut follower, &mut untouched] {
                to(follower, degrees);
            }
            let ((forces, lost), (expected, as_well)) = (rubbed(&follower), rubbed(&untouched));
            let apart = forces.iter().zip(&expected).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
            assert!(apart < 1e-7 && (lost - as_well).abs() < 1e-7, "{degrees}°: {apart:e} N, {lost} {as_well} N·mm");
        }
    }
}

/// Work of closing to an angle and opening, N·mm, less what is stored and dissipated at the end.
fn missing(object: ObjectDesign, friction: f64, degrees: f64, steps: u32) -> [f64; 2] {
    let mut follower = start::<f64>(object, friction);
    let (mut work, mut torque, mut at) = (0.0, 0.0, follower.solution().coordinate());
    for step in (0..=steps).chain((0..steps).rev()) {
        let outcome = follower.follow((degrees * f64::from(step) / f64::from(steps)).to_radians());
        assert!(matches!(outcome.status, Status::Converged | Status::NoContact), "{step}: {outcome:?}");
        let solution = follower.solution();
        work += 0.5 * (solution.motor_torque() + torque) * (solution.coordinate() - at);
        (torque, at) = (solution.motor_torque(), solution.coordinate());
    }
    let solution = follower.solution();
    [work, work - solution.potential() - solution.dissipated()]
}

/// What lets go in a step has rubbed until then: the work of a loop is what is dissipated, also where a contact goes from place to place.
#[test]
fn what_lets_go_has_dissipated() {
    let corners = Corners::new(&[[4.0, 30.0], [4.0, 50.0], [30.0, 40.0]]).expect("room");
    let polygon = ObjectDesign::Polygon { corners, rounding: 2.0 };
    for (name, object, degrees) in [("polygon", polygon, 7.0), ("circle", CIRCLE, 8.0)] {
        for friction in [0.3, 1.0] {
            for steps in [40, 400, 4000] {
                let [work, missing] = missing(object, friction, degrees, steps);
                std::println!("{name}, m {friction}, {steps} steps: {work:.5} N·mm, missing {missing:.6}");
                assert!(missing.abs() < if steps < 400 { 2e-3 } else { 1e-4 } * work, "{missing} of {work} N·mm");
            }
        }
    }
}

/// Greatest difference of friction's pull and of the force, N, to those after the first of 20 cycles of a part that sticks.
fn creep<T: Real>() -> f64 {
    let bore = ObjectDesign::Bore { centre: [-110.057, 33.752], radius: 126.81 };
    let mut follower = start::<T>(bore, 1.5);
    let (low, count) = (6.0, 60);
    for degrees in [low + 1.2, low, low + 0.6] {
        to(&mut follower, degrees);
    }
    let mut first = None;
    (0..=20).fold(0.0, |most, _| {
        for k in (0..count).chain((0..count).rev()) {
            to(&mut follower, low + 0.02 * f64::from(k));
        }
        let [x, y] = follower.solution().force_world().map(Real::to_f64);
        let now = [rubbed(&follower).0.iter().sum(), x.hypot(y)];
        let first: [f64; 2] = *first.get_or_insert(now);
        now.iter().zip(first).fold(most, |most: f64, (now, first)| most.max((now - first).abs()))
    })
}

/// What sticks keeps its force however often the motor goes to and fro, in single precision as well: what rounding leaves of a step's slip
/// does not add up.
#[test]
fn what_sticks_does_not_creep() {
    let [double, single] = [creep::<f64>(), creep::<f32>()];
    std::println!("{double:.1e} N in double, {single:.1e} N in single precision");
    assert!(double < 1e-4 && single < 0.02, "{double} {single}");
}

/// Force at the end of a way in even steps.
fn closed<T: Real>(object: ObjectDesign, friction: f64, degrees: f64, steps: u32) -> [f64; 2] {
    closed_by::<T>(Settings::DEFAULT, object, friction, degrees, steps)
}

fn closed_by<T: Real>(settings: Settings, object: ObjectDesign, friction: f64, degrees: f64, steps: u32) -> [f64; 2] {
    let mut follower = start::<T>(object, friction);
    follower.set_settings(settings).expect("settings in range");
    for step in 0..=steps {
        to(&mut follower, degrees * f64::from(step) / f64::from(steps));
    }
    follower.solution().force_world().map(Real::to_f64)
}

/// What touches for the first time has not slipped before: the force does not depend on where the steps of the way end.
#[test]
fn a_first_contact_does_not_depend_on_the_steps() {
    let wall = ObjectDesign::HalfPlane { point: [4.0, 70.0], normal: [-1.0, -0.25] };
    let bore = ObjectDesign::Bore { centre: [-195.0, 33.752], radius: 200.0 };
    for (name, object) in [("wall", wall), ("bore", bore), ("circle", CIRCLE)] {
        for friction in [0.5, 1.5] {
            let fine = closed::<f64>(object, friction, 1.0, 4000);
            let size = fine[0].hypot(fine[1]);
            for steps in [1, 2, 7, 40] {
                for found in [closed::<f64>(object, friction, 1.0, steps), closed::<f32>(object, friction, 1.0, steps)]
                {
                    let apart = (found[0] - fine[0]).hypot(found[1] - fine[1]);
                    assert!(apart < 1e-3 * size, "{name}, m {friction}, {steps} steps: {found:?}, not {fine:?}");
                }
            }
        }
    }
}

/// A flat side that lands on a second place and sticks, in lists of one step and of many: the steps that matter are found, whatever is asked for.
#[test]
fn a_later_contact_does_not_depend_on_the_steps() {
    let mut random = crate::random_designs::Random::new(5);
    let resolving = Settings { resolves_contact: true, ..Settings::DEFAULT };
    let (mut worst, mut sum, mut as_it_comes, mut count) = (0.0_f64, 0.0, 0.0_f64, 0);
    for case in 0..20 {
        let centre = [40.0 + 40.0 * random.unit(), 20.0 + 50.0 * random.unit()];
        let turn = core::f64::consts::TAU * random.unit();
        let (radius, corners) = (10.0 + 20.0 * random.unit(), 3 + (3.0 * random.unit()) as u32);
        let corner = |k: u32| {
            let (sin, cos) = (turn + core::f64::consts::TAU * f64::from(k) / f64::from(corners)).sin_cos();
            [centre[0] + radius * cos, centre[1] + radius * sin]
        };
        let corners = Corners::new(&(0..corners).map(corner).collect::<Vec<_>>()).expect("room");
        let object = ObjectDesign::Polygon { corners, rounding: 1.0 + 3.0 * random.unit() };
        let mut open = start::<f64>(object, 0.0);
        let meets = |degrees: &f64| open.follow(degrees.to_radians()).status != Status::NoContact;
        let Some(first) = (0..400).map(|k| 0.1 * f64::from(k)).find(meets) else { continue };
        for friction in [0.4, 1.2] {
            let fine = closed::<f64>(object, friction, first + 6.0, 2000);
            let apart = |found: [f64; 2]| (found[0] - fine[0]).hypot(found[1] - fine[1]) / fine[0].hypot(fine[1]);
            as_it_comes = as_it_comes.max(apart(closed::<f64>(object, friction, first + 6.0, 1)));
            for steps in [1, 100] {
                let found = apart(closed_by::<f64>(resolving, object, friction, first + 6.0, steps));
                std::println!("{case}, m {friction}, {steps} steps: {found:.5}");
                (worst, sum, count) = (worst.max(found), sum + found, count + 1);
            }
        }
    }
    let mean = sum / f64::from(count);
    std::println!("worst {worst:.5}, mean {mean:.5} of {count}; in one step as it comes {as_it_comes:.5}");
    assert!(worst < 0.01 && mean < 1e-3 && as_it_comes > 0.02 && count > 60, "{worst} {mean} {as_it_comes} {count}");
}
