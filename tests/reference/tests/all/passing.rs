//! Places at which the model knows of no equilibrium: an object that the finger has slipped past, and one that has come against
//! the clamped base. No number may stand there as if it were one, at the PC's resolution and at the microcontroller's.

use model_core::design::{Attachments, Design};
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::{Follower, Settings, Tracking};
use model_core::estimator::{Estimator, EstimatorSettings};
use model_core::object::{Motion, ObjectDesign};
use model_core::size::{Paper, Reduced};
use model_core::status::Status;
use reference_tests::{COUNT, fea_80, ladder_80};

model_core::fixed_size!(
    /// A stiff finger sinks many samples into the soft contact.
    Crowded, cells 8, nodes 256, samples 160, contacts 100
);

/// What a follower and two estimators say at the same angles; forces in N, world frame.
fn course(design: &Design, object: ObjectDesign, degrees: &[f64]) -> Vec<[(Status, [f64; 2]); 3]> {
    let mut fine: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
    fine.configure(design, &Discretisation::fine(Physics::Extended)).unwrap();
    fine.set_object(object, Motion::Rotating { axis: design.motor_axis });
    fine.start(degrees[0].to_radians());
    let mut targets = [None, Some(Tracking::DEFAULT)].map(|one_iteration| {
        let mut target: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
        let settings = EstimatorSettings { one_iteration, budget: 60, ..EstimatorSettings::DEFAULT };
        target.set_settings(settings, Settings::DEFAULT).unwrap();
        target.configure(design, &Discretisation::estimator(Physics::Extended)).unwrap();
        target.set_object(object).unwrap();
        target
    });
    let mut at = degrees[0].to_radians();
    let mut seen = Vec::new();
    for &goal in degrees {
        let goal = goal.to_radians();
        // The motor goes count by count, and stays until the estimate has come along.
        let ticks = ((goal - at).abs() / COUNT) as usize;
        let way = (1..=ticks).map(|tick| at + (goal - at) * tick as f64 / ticks as f64).chain([goal; 200]);
        let mut last = [(Status::Stale, [0.0; 2]); 2];
        for angle in way {
            for (target, last) in targets.iter_mut().zip(&mut last) {
                let estimate = target.update(angle);
                *last = (estimate.status, estimate.force.map(f64::from));
            }
        }
        let status = fine.follow(goal).status;
        seen.push([(status, fine.solution().force_world()), last[0], last[1]]);
        at = goal;
    }
    seen
}

/// A small cylinder slips off over the tip. The finger springs back and has it behind the front beam, where nothing is modelled;
/// an open hand is a new beginning.
#[test]
fn what_has_slipped_past_gives_no_force() {
    let cases = [(ladder_80(), 8.0, [9.0, 75.0], 13.5, 15.0), (fea_80(), 8.0, [9.0, 70.0], 10.0, 18.0)];
    for (design, radius, centre, before, beyond) in cases {
        let degrees = [-5.0, before, beyond, 12.0, 10.0, 8.0, 5.0, 2.0, -5.0, 5.0];
        let seen = course(&design, ObjectDesign::Circle { centre, radius }, &degrees);
        for (place, (seen, degrees)) in seen.iter().zip(degrees).enumerate() {
            for (who, &(status, force)) in seen.iter().enumerate() {
                let words = format!("R{radius} at {centre:?}, {degrees}°, {who}: {status}, {force:?} N");
                match place {
                    0 | 8 => assert_eq!((status, force), (Status::NoContact, [0.0; 2]), "{words}"),
                    // It pushes the object away from itself.
                    1 | 9 => assert!(status.is_trustworthy() && force[0] > 5.0, "{words}"),
                    _ => assert_eq!(status, Status::OutOfRange, "{words}"),
                }
            }
        }
    }
}

/// The tip's end is round: a finger that is pushed against a wall across it leans over and still carries its force.
#[test]
fn a_wall_across_the_tip_is_not_behind_it() {
    for design in [ladder_80(), fea_80()] {
        let mut follower: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
        follower.configure(&design, &Discretisation::fine(Physics::Extended)).unwrap();
        let wall = ObjectDesign::HalfPlane { point: [0.0, 82.0], normal: [0.0, -1.0] };
        follower.set_object(wall, Motion::Translating { direction: [0.0, 1.0] });
        assert!(follower.start(0.0));
        for distance in [1.5, 2.0, 3.0, 4.0] {
            let outcome = follower.follow(distance);
            let [x, y] = follower.solution().force_world();
            assert!(outcome.status.is_trustworthy(), "{distance} mm: {outcome:?}");
            assert!(x.abs() < 1e-9 && y > 5.0, "{distance} mm: {x}, {y} N");
        }
    }
}

/// A large cylinder low down comes against the clamped base on the way. What it would have done from there on nobody knows: the
/// way back to before that is open, the way on is not.
#[test]
fn what_came_against_the_base_gives_no_force_beyond() {
    let object = ObjectDesign::Circle { centre: [14.0, 38.0], radius: 40.0 };
    let degrees = [-40.0, -24.0, -10.0, 6.0, -10.0, -24.0, -40.0];
    let seen = course(&ladder_80(), object, &degrees);
    let status = |place: usize| seen[place].map(|(status, _)| status);
    assert_eq!([status(0), status(6)], [[Status::NoContact; 3]; 2]);
    for place in 2..5 {
        let status = status(place);
        assert!(status.iter().all(|status| !status.is_trustworthy()), "at {}°: {status:?}", degrees[place]);
    }
    for who in 0..3 {
        let [closing, opening] = [1, 5].map(|place: usize| seen[place][who]);
        assert!(closing.0.is_trustworthy() && opening.0.is_trustworthy(), "{who}: {closing:?}, {opening:?}");
        assert!((closing.1[0] - opening.1[0]).abs() < 2e-2, "{who}: {closing:?}, {opening:?}");
    }
}

/// The same finger, stiffer or larger: the same branch, in every precision. (With tolerances of their own size for all fingers,
/// single precision found the end of a branch where there is none.)
#[test]
fn stiff_and_large_fingers_have_no_other_branches() {
    let force = |stiffer: f64, larger: f64| {
        let mut design = ladder_80();
        design.material.youngs_modulus *= stiffer;
        let grow = |lengths: &mut [f64]| lengths.iter_mut().for_each(|length| *length *= larger);
        for beam in [&mut design.front, &mut design.back] {
            grow(&mut beam.base);
            grow(&mut beam.tip);
            beam.thickness.knots.iter_mut().for_each(|knot| grow(knot));
        }
        design.width.knots.iter_mut().for_each(|knot| grow(knot));
        match &mut design.lamellae.attachments {
            Attachments::Heights(heights) => grow(heights),
            Attachments::Arcs { front, back } => [front, back].into_iter().for_each(|arcs| grow(arcs)),
        }
        design.lamellae.thickness.iter_mut().flatten().for_each(|thickness| *thickness *= larger);
        design.hinge.thickness *= larger;
        grow(&mut design.hinge.length);
        grow(&mut design.motor_axis);
        let mut follower: Box<Follower<f32, Crowded>> = Box::new(Follower::EMPTY);
        follower.configure(&design, &Discretisation::fine(Physics::Extended)).unwrap();
        let object = ObjectDesign::Circle { centre: [41.0 * larger, 45.0 * larger], radius: 40.0 * larger };
        follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
        assert!(follower.start(0.0));
        let outcome = follower.follow(11_f64.to_radians());
        assert_eq!(outcome.status, Status::Converged, "{stiffer} times stiffer, {larger} times larger: {outcome:?}");
        let [x, y] = follower.solution().force_world().map(f64::from);
        x.hypot(y) / (stiffer * larger * larger)
    };
    let one = force(1.0, 1.0);
    for (stiffer, larger) in [(20.0, 1.0), (200.0, 1.0), (1.0, 5.0), (70.0, 3.0)] {
        let found = force(stiffer, larger);
        // The contact's softness is not scaled.
        assert!((found / one - 1.0).abs() < 0.02, "{stiffer}, {larger}: {found} N, {one} N");
    }
}

/// A wall across the clamped base that the flexible finger lies clear of: every tick of a motor that stands says the same, of the estimator and of the
/// solver.
#[test]
fn a_wall_at_the_base_is_out_of_range_in_every_tick() {
    let design = ladder_80();
    // Beside the base, and away from it towards the tip.
    let (sin, cos) = libm::sincos(0.2);
    let object = ObjectDesign::HalfPlane { point: [0.5, 0.0], normal: [-cos, sin] };
    let mut target: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
    target.configure(&design, &Discretisation::estimator(Physics::Extended)).unwrap();
    target.set_object(object).unwrap();
    let mut fine: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
    fine.configure(&design, &Discretisation::fine(Physics::Extended)).unwrap();
    fine.set_object(object, Motion::Rotating { axis: design.motor_axis });
    fine.start(-0.5);
    let mut seen = [0; 2];
    for count in -325..20 {
        let angle = f64::from(count) * COUNT;
        let [first, other] = [target.update(angle).status, fine.follow(angle).status];
        for _ in 0..4 {
            assert_eq!((target.update(angle).status, fine.follow(angle).status), (first, other), "count {count}");
        }
        assert_eq!(first, other, "count {count}");
        seen = [seen[0] + u32::from(first == Status::NoContact), seen[1] + u32::from(first == Status::OutOfRange)];
    }
    assert!(seen.iter().all(|&ticks| ticks > 10), "{seen:?}");
}
