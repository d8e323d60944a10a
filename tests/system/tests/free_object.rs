//! A free object between two fingers, found on the target, against the same balance in double precision on this PC.

use std::time::Duration;

use fre_gripper::servo::{Clock, Config, Gains};
use messages::{Grasp, Mount, Object, Report, Settings, Side, Support, Which};
use model_core::equilibrium::Follower;
use model_core::grasp::{Balance, Finger, Grasp as Model, Load, Placement};
use model_core::object::{Motion, ObjectDesign};
use model_core::size::{Paper, Rubbing};
use model_core::status::Status;
use system_tests::{Machine, Watch, finger};

const SECONDS: fn(u64) -> Duration = Duration::from_secs;
const DEGREE: f32 = std::f32::consts::PI / 180.0;
const RADIUS: f64 = 25.0;
/// Between the bases of the fingers, mm; the object stands off the middle.
const APART: f64 = 56.0;
const CENTRE: [f64; 2] = [28.3, 44.0];
/// Its weight, and something that pulls to the right, N.
const LOAD: [f32; 2] = [0.1, -0.2];

fn placements() -> [Placement; 2] {
    [Placement::HERE, Placement { mirrored: true, angle: 0.0, translation: [APART, 0.0] }]
}

fn circle(radius: f64) -> [ObjectDesign; 2] {
    let object = ObjectDesign::Circle { centre: CENTRE, radius };
    placements().map(|placement| placement.object_back(&object))
}

fn settings(support: Support) -> Settings {
    let mount = Mount { open_angle: -DEGREE, force_limit: 100.0, current_limit: 2000.0, ..Mount::DEFAULT };
    let right = Mount { servo_id: 2, side: Side::Right, ..mount };
    let fingers = [Some(mount), Some(right), None, None];
    Settings { rate_hz: 50, shape_every: 0, support, fingers, ..Settings::of(mount) }
}

/// The same fingers in f64, closed on the object where it is held, and the object let go.
fn core(angles: [f64; 2], centre: [f64; 2]) -> Balance {
    let given = finger();
    let mut models = [0, 1].map(|_| Box::new(Follower::<f64, Paper>::EMPTY));
    for model in &mut models {
        model.configure(&given.design, &given.how).unwrap();
    }
    let motion = Motion::Rotating { axis: given.design.motor_axis };
    let fingers = models.iter_mut().zip(placements());
    let fingers = fingers.map(|(follower, placement)| Finger { follower, placement, motion });
    let load = Load { force: LOAD.map(f64::from), moment: 0.0 };
    let object = ObjectDesign::Circle { centre, radius: RADIUS };
    let mut grasp = Model::new(fingers.collect(), object, load).unwrap();
    assert_eq!(grasp.close(&angles), Ok(Status::Converged));
    grasp.release()
}

/// The last report of each finger.
fn last(watch: &Watch) -> [Report; 2] {
    [0, 1].map(|finger| *watch.reports.iter().rev().find(|report| report.finger == finger).expect("a report"))
}

/// The fingers' last angles, rad.
fn last_angles(watch: &Watch) -> [f64; 2] {
    last(watch).map(|report| f64::from(report.estimate.motor_angle))
}

/// Waits until both fingers are at their goals with a good estimate.
fn settled(watch: &mut Watch, goals: [f32; 2]) {
    let mut there = [false; 2];
    watch.until_report("fingers at their goals", SECONDS(120), |report| {
        let finger = usize::from(report.finger);
        let is_near = (report.estimate.motor_angle - goals[finger]).abs() < 0.3 * DEGREE;
        there[finger] = is_near && report.estimate.age == 0 && report.estimate.status.is_trustworthy();
        there == [true; 2]
    });
}

/// Waits for a grasp with a balance that is so.
fn until_free(watch: &mut Watch, what: &str, mut so: impl FnMut(&Grasp) -> bool) {
    watch.until(what, SECONDS(60), |told| matches!(told, fre_gripper::link::Told::Grasp(grasp) if so(grasp)));
}

/// The target's place is one where the object rests in f64 as well, with the same forces; let go where it was set it comes to rest
/// nearby (where the contact goes from sample to sample there is more than one such place). And every report of a tick
/// without a balance says that it is of no use.
fn judge(watch: &Watch, since: usize) {
    let reports = last(watch);
    let grasp = watch.grasps.last().unwrap();
    let free = grasp.free.expect("a free object");
    assert_eq!((free.status, grasp.is_trustworthy), (Status::Converged, true), "{grasp:?}");
    let angles = last_angles(watch);
    let place = [0, 1].map(|i| CENTRE[i] + f64::from(free.shift[i]));
    for (centre, near, alike) in [(place, 0.05, 0.02), (CENTRE, 0.5, 0.15)] {
        let balance = core(angles, centre);
        println!("target: {place:?} {:?}, f64: {balance:?}", reports.map(|report| report.estimate.force));
        assert_eq!(balance.status, Status::Converged);
        let off = (balance.centre[0] - place[0]).hypot(balance.centre[1] - place[1]);
        assert!(off < near, "{off} mm");
        for (k, (report, placement)) in reports.iter().zip(placements()).enumerate() {
            let force = placement.vector(report.estimate.force.map(f64::from));
            for (found, exact) in force.iter().zip(balance.forces[k]) {
                assert!((found - exact).abs() < alike, "finger {k}: {found} N, {exact} N");
            }
        }
    }
    for grasp in &watch.grasps[since..] {
        let status = grasp.free.expect("a free object").status;
        let left = [grasp.sum[0] + LOAD[0], grasp.sum[1] + LOAD[1]];
        assert!(!grasp.is_trustworthy || left[0].hypot(left[1]) < 5e-3, "balanced, and {left:?} N are left: {grasp:?}");
        if status.is_trustworthy() {
            continue;
        }
        assert!(!grasp.is_trustworthy, "{grasp:?}");
        for report in watch.reports.iter().filter(|report| grasp.sequence.wrapping_sub(report.sequence) < 2) {
            assert!(!report.estimate.status.is_trustworthy() && report.estimate.age > 0, "{report:?}");
        }
    }
}

fn servo(id: u8) -> Config {
    Config {
        id,
        baud_rate: 1_000_000,
        clock: Clock::Requests { period_us: 5_000 },
        start_deg: Some(-1.0),
        gains: Gains::GREATEST,
        ..Config::default()
    }
}

#[test]
fn an_object_that_is_let_go_rests_where_the_core_says() {
    let machine = Machine::boot_all(vec![servo(1), servo(2)]);
    let link = machine.link();
    let mut watch = Watch::new(&link);
    link.set_settings(&settings(Support::Fixed)).unwrap();
    for (number, object) in (0..).zip(circle(RADIUS)) {
        link.set_finger(number, &finger()).unwrap();
        link.set_object(number, object).unwrap();
    }
    settled(&mut watch, [-DEGREE; 2]);

    let goals = [9.0 * DEGREE, 7.0 * DEGREE];
    for (finger, goal) in (0..).zip(goals) {
        link.close(Which::One(finger), goal, Some(0.35)).unwrap();
    }
    settled(&mut watch, goals);
    assert!(watch.grasps.iter().all(|grasp| grasp.free.is_none()), "nothing is free yet");

    // It is let go, and comes to rest over some ticks.
    let support = Support::Free { load: LOAD, moment: 0.0 };
    let since = watch.grasps.len();
    link.set_settings(&settings(support)).unwrap();
    until_free(&mut watch, "balance", |grasp| grasp.free.is_some_and(|free| free.status == Status::Converged));
    let on_the_way = |grasp: &&Grasp| grasp.free.is_some_and(|free| free.status == Status::MaxIterations);
    let ticks = watch.grasps.iter().filter(on_the_way).count();
    println!("at rest after {ticks} ticks");
    assert!(ticks > 0, "no tick is long enough for the whole way");
    let since = since + watch.grasps[since..].iter().position(|grasp| grasp.free.is_some()).unwrap();
    judge(&watch, since);

    // It is pressed harder, and follows.
    let goals = goals.map(|goal| goal + 1.5 * DEGREE);
    for (finger, goal) in (0..).zip(goals) {
        link.close(Which::One(finger), goal, Some(0.1)).unwrap();
    }
    settled(&mut watch, goals);
    until_free(&mut watch, "balance", |grasp| grasp.is_trustworthy);
    judge(&watch, since);

    let found = watch.grasps.iter().filter_map(|grasp| grasp.free).filter(|free| free.status == Status::Converged);
    let costs: Vec<u32> = found.map(|free| free.cost * Machine::INSTRUCTIONS_PER_TICK).collect();
    let mean = costs.iter().map(|cost| u64::from(*cost)).sum::<u64>() / costs.len() as u64;
    println!("{} balances: {mean} instructions each, {} at most", costs.len(), costs.iter().max().unwrap());

    // Fixed again, it counts as standing where it was set.
    link.set_settings(&settings(Support::Fixed)).unwrap();
    until_free(&mut watch, "fixed object", |grasp| grasp.free.is_none() && grasp.is_trustworthy);
    let [left, _] = last(&watch);
    let mut fixed = Box::new(Follower::<f64, Paper>::EMPTY);
    let given = finger();
    fixed.configure(&given.design, &given.how).unwrap();
    fixed.set_object(circle(RADIUS)[0], Motion::Rotating { axis: given.design.motor_axis });
    let angle = f64::from(left.estimate.motor_angle);
    assert!(fixed.start(angle) && fixed.follow(angle).status == Status::Converged);
    let off = f64::from(left.estimate.force[0]) - fixed.solution().force_world()[0];
    assert!(off.abs() < 0.02, "{off} N");

    // Two fingers that are told of different objects hold none, and say so.
    link.set_object(1, circle(RADIUS - 1.0)[1]).unwrap();
    link.set_settings(&settings(support)).unwrap();
    until_free(&mut watch, "refusal", |grasp| grasp.free.is_some_and(|free| free.status == Status::OutOfRange));
    assert!(!watch.grasps.last().unwrap().is_trustworthy);
    assert!(last(&watch).iter().all(|report| !report.estimate.status.is_trustworthy()));

    // Fingers that open let go of it altogether.
    link.set_object(1, circle(RADIUS)[1]).unwrap();
    link.open_fingers(Which::All).unwrap();
    until_free(&mut watch, "open fingers", |grasp| {
        grasp.is_trustworthy
            && grasp.free.is_some_and(|free| free.status == Status::NoContact && free.shift == [0.0; 2])
    });
}

const FRICTION: f64 = 0.5;
/// Speed of the motor, rad/s.
const SLOWLY: f32 = 0.1;

/// The angles of both fingers, rad, tick by tick from a report on.
fn way_since(watch: &Watch, from: usize) -> Vec<[f64; 2]> {
    let mut at = [f64::NAN; 2];
    let reports = watch.reports.iter().skip(from);
    let places = reports.filter_map(|report| {
        at[usize::from(report.finger)] = f64::from(report.estimate.motor_angle);
        (report.finger == 1 && !at[0].is_nan()).then_some(at)
    });
    let mut way: Vec<_> = places.collect();
    way.dedup();
    way
}

/// The same fingers in f64 with friction: closed on the object where it is held, which is let go, and then moved with it along these ways.
fn core_with_friction(first: [f64; 2], ways: &[Vec<[f64; 2]>]) -> Vec<Balance> {
    let given = finger();
    let mut models = [0, 1].map(|_| Box::new(Follower::<f64, Rubbing>::EMPTY));
    for model in &mut models {
        model.configure(&given.design, &given.how).unwrap();
        model.set_friction(FRICTION).unwrap();
    }
    let motion = Motion::Rotating { axis: given.design.motor_axis };
    let fingers = models.iter_mut().zip(placements());
    let fingers = fingers.map(|(follower, placement)| Finger { follower, placement, motion });
    let load = Load { force: LOAD.map(f64::from), moment: 0.0 };
    let object = ObjectDesign::Circle { centre: CENTRE, radius: RADIUS };
    let mut grasp = Model::new(fingers.collect(), object, load).unwrap();
    assert_eq!(grasp.close(&first), Ok(Status::Converged));
    let mut found = vec![grasp.release()];
    for way in ways {
        let balances = way.iter().map(|angles| grasp.advance_within(angles, u32::MAX).unwrap());
        found.extend(balances.last());
    }
    found
}

/// With friction fingers and object move as one: let go, pressed harder and released by a part, the forces are those of the same way in f64,
/// and what the object is held by grows with friction.
#[test]
fn fingers_that_rub_move_with_the_object_between_them() {
    let machine = Machine::boot_all(vec![servo(1), servo(2)]);
    let link = machine.link();
    let mut watch = Watch::new(&link);
    link.set_settings(&settings(Support::Fixed)).unwrap();
    for (number, design) in (0..).zip(circle(RADIUS)) {
        link.set_finger(number, &finger()).unwrap();
        link.set_object(number, Object { design, friction: FRICTION }).unwrap();
    }
    settled(&mut watch, [-DEGREE; 2]);
    let go = |watch: &mut Watch, goals: [f32; 2]| {
        let from = watch.reports.len();
        let goals = goals.map(|goal| goal * DEGREE);
        for (finger, goal) in (0..).zip(goals) {
            link.close(Which::One(finger), goal, Some(SLOWLY)).unwrap();
        }
        settled(watch, goals);
        // Until both servos stand, and what they hold.
        let (mut still, mut last) = (0, [f32::NAN; 2]);
        until_free(watch, "a hand that stands", |grasp| {
            let near = last.iter().zip(grasp.sum).all(|(a, b)| (a - b).abs() < 2e-3);
            (still, last) = (if near && grasp.is_trustworthy { still + 1 } else { 0 }, grasp.sum);
            still > 25
        });
        way_since(watch, from)
    };
    go(&mut watch, [9.0, 7.0]);
    let first = last_angles(&watch);
    let since = watch.grasps.len();
    link.set_settings(&settings(Support::Free { load: LOAD, moment: 0.0 })).unwrap();
    until_free(&mut watch, "balance", |grasp| grasp.free.is_some_and(|free| free.status == Status::Converged));
    let mut found = vec![(last(&watch), *watch.grasps.last().unwrap())];
    let mut ways = Vec::new();
    for goals in [[10.5, 8.5], [9.5, 7.5]] {
        ways.push(go(&mut watch, goals));
        found.push((last(&watch), *watch.grasps.last().unwrap()));
    }
    let core = core_with_friction(first, &ways);
    for ((reports, grasp), balance) in found.iter().zip(&core) {
        let free = grasp.free.expect("a free object");
        println!("target: {free:?} {:?}, f64: {balance:?}", reports.map(|report| report.estimate.force));
        assert!(free.status.is_trustworthy() && balance.status.is_trustworthy());
        let place = [0, 1].map(|i| CENTRE[i] + f64::from(free.shift[i]));
        let off = (balance.centre[0] - place[0]).hypot(balance.centre[1] - place[1]);
        assert!(off < 0.05, "{off} mm");
        for (k, (report, placement)) in reports.iter().zip(placements()).enumerate() {
            let force = placement.vector(report.estimate.force.map(f64::from));
            for (found, exact) in force.iter().zip(balance.forces[k]) {
                assert!((found - exact).abs() < 0.05, "finger {k}: {found} N, {exact} N");
            }
        }
    }
    // A grasp that is reported as balanced is balanced, and few ticks are without a balance.
    let ticks: Vec<_> = watch.grasps[since..].iter().filter(|grasp| grasp.free.is_some()).collect();
    let lost = ticks.iter().filter(|grasp| !grasp.is_trustworthy).count();
    println!("{lost} of {} ticks without a balance", ticks.len());
    assert!(lost * 6 < ticks.len(), "{lost} of {}", ticks.len());
    for grasp in ticks.iter().filter(|grasp| grasp.is_trustworthy) {
        let left = [grasp.sum[0] + LOAD[0], grasp.sum[1] + LOAD[1]];
        assert!(left[0].hypot(left[1]) < 0.012, "balanced, and {left:?} N are left: {grasp:?}");
    }
    let costs: Vec<u32> =
        ticks.iter().filter_map(|grasp| grasp.free).map(|free| free.cost * Machine::INSTRUCTIONS_PER_TICK).collect();
    let mean = costs.iter().map(|cost| u64::from(*cost)).sum::<u64>() / costs.len() as u64;
    println!("{} motions: {mean} instructions each, {} at most", costs.len(), costs.iter().max().unwrap());

    // Opened, the hand lets go of it, and it counts as standing where it was set.
    link.open_fingers(Which::All).unwrap();
    until_free(&mut watch, "open fingers", |grasp| {
        let is_gone = |free: messages::FreeObject| free.status == Status::NoContact && free.shift == [0.0; 2];
        grasp.is_trustworthy && grasp.free.is_some_and(is_gone)
    });
}
