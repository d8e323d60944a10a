//! What becomes of orders: each finger obeys as far as it can, and says so.

use dynamixel::xm430;
use fre_gripper::servo::Config;
use messages::{
    Carry, CarryTo, Close, CloseTo, Event, For, GetCounters, GetObject, Gravity, Grip, GripTo, Heed, Hold, Mount,
    Object, Open, Phase, PlaceObject, Refusal, Relax, Report, Role, Scan, SetFinger, SetObject, SetSettings, Settings,
    Side, Silence, Which, Why,
};
use model_core::object::ObjectDesign;
use system_tests::{Bench, Flash, GEARED_MOUNT, OBJECT, finger, geared_servo, set_up};

const SECOND: u64 = 1_000_000;

/// The last report of the first finger.
fn last(bench: &Bench) -> Report {
    bench.reports.iter().rev().map(|(report, _)| *report).find(|report| report.finger == 0).expect("a report")
}

/// A gripper with so many fingers, the second one on the right, whose first finger has a design and an object; and its settings.
fn hand_of(count: u8) -> (Bench, Settings) {
    let servo = |id| Config { id, ..geared_servo() };
    let mut bench = Bench::of(servo(1), (2..=count).map(servo).collect(), &Flash::new());
    let mut settings = Settings::of(GEARED_MOUNT);
    for number in 1..count {
        let side = if number == 1 { Side::Right } else { GEARED_MOUNT.side };
        settings.fingers[usize::from(number)] = Some(Mount { servo_id: number + 1, side, ..GEARED_MOUNT });
    }
    set_up(&mut bench, &settings, OBJECT);
    (bench, settings)
}

/// Gives so many fingers a design, and an object that is not slippery.
fn furnish(bench: &mut Bench, count: u8) {
    for number in 0..count {
        bench.ask::<SetFinger>(&For { finger: number, what: finger() }).unwrap();
        let what = Object { design: OBJECT, friction: 0.6 };
        bench.ask::<SetObject>(&For { finger: number, what }).unwrap();
    }
    bench.until("the last finger", 5 * SECOND, |report| report.finger == count - 1 && report.position != 0);
}

/// A gripper whose second servo is gone still opens and stops its first finger, and says which of them obeyed.
#[test]
fn a_servo_that_is_gone_does_not_keep_the_others_from_stopping() {
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    let mut settings = Settings::of(GEARED_MOUNT);
    settings.fingers[1] = Some(Mount { servo_id: 9, ..GEARED_MOUNT });
    set_up(&mut bench, &settings, OBJECT);
    let to = CloseTo { fingers: Which::One(0), angle: 0.1, speed: Some(0.05) };
    bench.ask::<Close>(&to).unwrap();
    bench.run(SECOND / 2);
    assert!(last(&bench).goal > 0.0, "it closes");
    let heeds = [Some(Heed::Done), Some(Heed::NoServo), None, None];
    assert_eq!(bench.ask::<Hold>(&Which::All), Ok(heeds));
    bench.run(SECOND / 10);
    let held = last(&bench);
    assert!(held.phase == Phase::Held(Why::Asked) && held.goal < 0.09, "{held:?}");
    bench.run(SECOND);
    assert_eq!(last(&bench).goal, held.goal);
    assert_eq!(bench.ask::<Open>(&Which::All), Ok(heeds));
    bench.until("an open finger", 5 * SECOND, |report| report.finger == 0 && report.goal == GEARED_MOUNT.open_angle);
    // Alone it is refused, and what needs every finger is too.
    assert_eq!(bench.ask::<Hold>(&Which::One(1)), Err(Refusal::NoServo));
    assert_eq!(bench.ask::<Close>(&CloseTo { fingers: Which::All, ..to }), Err(Refusal::NoServo));
}

/// Without torque a finger stays so, whatever stops or is lost meanwhile, until it is to move; then it starts where it is.
#[test]
fn a_relaxed_finger_stays_relaxed_until_it_is_to_move() {
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
    let to = CloseTo { fingers: Which::All, angle: 0.04, speed: Some(0.05) };
    bench.ask::<Close>(&to).unwrap();
    bench.run(SECOND / 2);
    assert_eq!(bench.ask::<Relax>(&Which::All), Ok([Some(Heed::Done), None, None, None]));
    bench.until("a relaxed finger", SECOND, |report| report.phase == Phase::Relaxed);
    bench.run(SECOND / 10);
    assert_eq!(bench.servo.read(xm430::TORQUE_ENABLE), 0);
    bench.ask::<Hold>(&Which::All).unwrap();
    bench.meddling = Box::new(|_, _| Vec::new());
    bench.run(SECOND / 2);
    bench.meddling = Box::new(|_, bytes| bytes);
    bench.run(5 * SECOND);
    assert!(bench.events.contains(&Event::ServoLost { finger: 0, other_master: false }), "{:?}", bench.events);
    let found = bench.events.iter().filter(|event| matches!(event, Event::ServoReady { .. })).count();
    assert_eq!(found, 2, "{:?}", bench.events);
    assert_eq!((bench.servo.read(xm430::TORQUE_ENABLE), last(&bench).phase), (0, Phase::Relaxed));

    let from = bench.servo.truth().motor_angle;
    bench.ask::<Close>(&to).unwrap();
    let mut jump = 0.0_f64;
    let mut before = from;
    bench.run_with(2 * SECOND, |_, truth| {
        jump = jump.max((truth.motor_angle - before).abs());
        before = truth.motor_angle;
    });
    assert_eq!(bench.servo.read(xm430::TORQUE_ENABLE), 1);
    let there = bench.servo.truth().motor_angle;
    // The gears' friction and the first touch leave it 10 counts short.
    assert!(there > 0.023 && jump < 0.002, "from {from} to {there} rad, {jump} rad at once");
}

/// A servo that refuses to hold where it is stays without torque, says so once, and keeps no other finger's order waiting.
#[test]
fn a_servo_that_refuses_torque_keeps_no_other_waiting() {
    let servo = |id| Config { id, ..geared_servo() };
    let mut bench = Bench::of(servo(1), vec![servo(2)], &Flash::new());
    let mut settings = Settings::of(Mount { servo_id: 1, ..GEARED_MOUNT });
    settings.fingers[1] = Some(Mount { servo_id: 2, ..GEARED_MOUNT });
    set_up(&mut bench, &settings, OBJECT);
    bench.until("a second finger", 5 * SECOND, |report| report.finger == 1 && report.position != 0);
    bench.ask::<Relax>(&Which::One(0)).unwrap();
    bench.until("a relaxed finger", SECOND, |report| report.finger == 0 && report.phase == Phase::Relaxed);
    bench.run(SECOND / 10);
    // Moved by hand, so to speak, to where its limits do not allow a goal.
    let position = bench.servo.read(xm430::PRESENT_POSITION);
    bench.servo.write(xm430::MIN_POSITION_LIMIT, position as u32 + 500);
    let to = CloseTo { fingers: Which::One(0), angle: 0.04, speed: Some(0.05) };
    bench.ask::<Close>(&to).unwrap();
    bench.ask::<Relax>(&Which::One(1)).unwrap();
    bench.run(SECOND / 10);
    let torques = [0, 1].map(|finger| bench.servo_of(finger).read(xm430::TORQUE_ENABLE));
    assert_eq!((torques, last(&bench).phase), ([0, 0], Phase::Relaxed));
    let refused = |event: &&Event| matches!(event, Event::GoalRefused { finger: 0, .. });
    assert_eq!(bench.events.iter().filter(refused).count(), 1, "{:?}", bench.events);
    bench.ask::<Close>(&CloseTo { fingers: Which::One(1), ..to }).unwrap();
    bench.run(SECOND / 10);
    assert_eq!(bench.servo_of(1).read(xm430::TORQUE_ENABLE), 1);
}

/// Another program has set a servo without torque to answer reads only: the gripper waits for no answer to its writes for ever, but sets it up
/// anew.
#[test]
fn a_servo_that_answers_no_writes_gets_its_torque() {
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
    bench.ask::<Relax>(&Which::All).unwrap();
    bench.run(SECOND / 10);
    bench.servo.write(xm430::STATUS_RETURN_LEVEL, 1);
    let to = CloseTo { fingers: Which::All, angle: 0.02, speed: Some(0.05) };
    bench.ask::<Close>(&to).unwrap();
    bench.run(SECOND);
    assert!(bench.events.contains(&Event::ServoLost { finger: 0, other_master: false }), "{:?}", bench.events);
    assert_eq!([bench.servo.read(xm430::STATUS_RETURN_LEVEL), bench.servo.read(xm430::TORQUE_ENABLE)], [2, 1]);
    bench.ask::<Close>(&to).unwrap();
    bench.run(2 * SECOND);
    assert_eq!(last(&bench).goal, 0.02);
}

/// What is asked for right behind it does not keep a finger from yielding, nor does a search that is under way.
#[test]
fn a_finger_yields_whatever_comes_behind() {
    let settings = Settings::of(GEARED_MOUNT);
    let torque_after = |ask: fn(&mut Bench, &Settings)| {
        let mut bench = Bench::new(geared_servo(), &Flash::new());
        set_up(&mut bench, &settings, OBJECT);
        ask(&mut bench, &settings);
        bench.run(SECOND);
        bench.servo.read(xm430::TORQUE_ENABLE)
    };
    let torques = [
        torque_after(|bench, settings| {
            bench.ask::<Relax>(&Which::All).unwrap();
            bench.ask::<SetSettings>(&Settings { role: Role::Idle, ..*settings }).unwrap();
        }),
        torque_after(|bench, _| {
            bench.ask::<Relax>(&Which::All).unwrap();
            bench.ask::<Scan>(&()).unwrap();
        }),
        torque_after(|bench, _| {
            bench.ask::<Scan>(&()).unwrap();
            bench.run(SECOND / 10);
            bench.ask::<Relax>(&Which::All).unwrap();
        }),
    ];
    assert_eq!(torques, [0; 3]);
}

/// The bus can be searched for a servo that was lost while its finger gripped: nothing else tells where it is.
#[test]
fn a_servo_that_is_lost_in_a_grip_can_be_searched_for() {
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
    bench.ask::<Grip>(&GripTo { fingers: Which::All, force: 2.0, speed: Some(0.1), limit: None }).unwrap();
    bench.until("a grip", 20 * SECOND, |report| report.phase == Phase::Gripped);
    assert_eq!(bench.ask::<Scan>(&()), Err(Refusal::Gripping));
    bench.meddling = Box::new(|_, _| Vec::new());
    bench.run(SECOND);
    assert!(bench.events.contains(&Event::ServoLost { finger: 0, other_master: false }), "{:?}", bench.events);
    assert_eq!(bench.ask::<Scan>(&()), Ok(()));
}

/// A finger that was taken away while it pressed does not count for the others: they close for a weight as softly as ever.
#[test]
fn a_finger_that_is_gone_makes_the_others_press_no_harder() {
    let (mut bench, mut settings) = hand_of(3);
    furnish(&mut bench, 3);
    let to = GripTo { fingers: Which::One(2), force: 5.0, speed: Some(0.1), limit: None };
    bench.ask::<Grip>(&to).unwrap();
    bench.until("a grip", 20 * SECOND, |report| report.phase == Phase::Gripped);
    bench.run(SECOND);
    settings.fingers[2] = None;
    bench.ask::<SetSettings>(&settings).unwrap();
    let (gravity, speed) = (Gravity::Across, Some(0.1));
    let to = CarryTo { weight: 0.2, gravity, safety: 1.0, force: None, speed, limit: None };
    bench.ask::<Carry>(&to).unwrap();
    let mut most = 0.0_f64;
    bench.run_with(10 * SECOND, |_, truth| most = most.max(truth.force[0].hypot(truth.force[1])));
    assert!(last(&bench).phase == Phase::Gripped && most < 2.0, "{most} N, {:?}", last(&bench));
}

/// During a search a servo's Bus Watchdog trips that another program has armed. The look that shows it is repeated if its answer is lost.
#[test]
fn a_look_whose_answer_is_lost_is_repeated() {
    let (mut bench, _) = hand_of(2);
    bench.run(3 * SECOND);
    bench.servo_of(1).write(xm430::BUS_WATCHDOG, 5);
    bench.ask::<Scan>(&()).unwrap();
    while !bench.events.iter().any(|event| matches!(event, Event::ScanDone { .. })) {
        bench.run(SECOND / 1000);
    }
    assert_eq!(bench.servo_of(1).read(xm430::BUS_WATCHDOG), -1);
    let mut is_lost = false;
    bench.meddling = Box::new(move |to_servo, bytes| {
        // A read of the second one's voltage.
        let is_look = to_servo && bytes.get(4..9) == Some(&[2, 7, 0, 2, 144]);
        if is_look && !core::mem::replace(&mut is_lost, true) { Vec::new() } else { bytes }
    });
    bench.run(SECOND);
    let servo = bench.servo_of(1);
    assert_eq!((servo.read(xm430::BUS_WATCHDOG), servo.read(xm430::TORQUE_ENABLE)), (0, 1));
}

/// Of two fingers that close for a weight one is taken away: the other one keeps what it has, and says so.
#[test]
fn a_finger_that_is_left_of_two_keeps_its_force() {
    let (mut bench, mut settings) = hand_of(2);
    furnish(&mut bench, 2);
    let (gravity, speed) = (Gravity::Across, Some(0.1));
    let to = CarryTo { weight: 0.2, gravity, safety: 1.0, force: None, speed, limit: None };
    bench.ask::<Carry>(&to).unwrap();
    bench.run(SECOND / 10);
    settings.fingers[1] = None;
    bench.ask::<SetSettings>(&settings).unwrap();
    bench.run(10 * SECOND);
    assert_eq!(last(&bench).phase, Phase::Gripped);
}

/// Single answers that are lost while a finger holds are no events: the reports have them.
#[test]
fn a_short_wait_is_no_event() {
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
    let to = GripTo { fingers: Which::All, force: 2.0, speed: Some(0.1), limit: None };
    bench.ask::<Grip>(&to).unwrap();
    bench.until("a grip", 20 * SECOND, |report| report.phase == Phase::Gripped);
    bench.run(SECOND);
    let (events, reports) = (bench.events.len(), bench.reports.len());
    let mut answers = 0;
    bench.meddling = Box::new(move |to_servo, bytes| {
        answers += u32::from(!to_servo);
        if !to_servo && answers.is_multiple_of(9) { Vec::new() } else { bytes }
    });
    bench.run(2 * SECOND);
    let waits = bench.reports[reports..].iter().filter(|(report, _)| report.phase == Phase::Waiting(Why::Bus)).count();
    // Of a thousand.
    assert!((100..=122).contains(&waits), "{waits} waits");
    assert_eq!(bench.events[events..], []);
    // One that lasts is.
    bench.meddling = Box::new(|_, _| Vec::new());
    bench.run(SECOND);
    let waiting = Event::PhaseChanged { finger: 0, phase: Phase::Waiting(Why::Bus) };
    assert!(bench.events[events..].contains(&waiting), "{:?}", &bench.events[events..]);
}

/// The host goes away in a motion: the gripper goes on, stops or opens, as set; what it has gripped it keeps.
#[test]
fn a_host_that_goes_away_stops_a_motion_if_that_is_set() {
    for (on_silence, phase) in [
        (Silence::GoOn, Phase::Moving),
        (Silence::Hold, Phase::Held(Why::Host)),
        (Silence::Release, Phase::Released(Why::Host)),
    ] {
        let mut bench = Bench::new(geared_servo(), &Flash::new());
        set_up(&mut bench, &Settings { on_silence, silence_ms: 500, ..Settings::of(GEARED_MOUNT) }, OBJECT);
        // A host that is there.
        let to = CloseTo { fingers: Which::All, angle: 0.02, speed: Some(0.02) };
        bench.ask::<Close>(&to).unwrap();
        for _ in 0..6 {
            bench.run(SECOND / 4);
            bench.ask::<GetCounters>(&());
            assert_eq!(last(&bench).phase, Phase::Moving);
        }
        bench.ask::<Close>(&CloseTo { angle: -0.01, ..to }).unwrap();
        bench.run(SECOND / 3);
        assert_eq!(last(&bench).phase, Phase::Moving, "not yet");
        bench.run(SECOND / 3);
        assert_eq!(last(&bench).phase, phase, "{on_silence:?}");
    }
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    let settings = Settings { on_silence: Silence::Release, silence_ms: 500, ..Settings::of(GEARED_MOUNT) };
    set_up(&mut bench, &settings, OBJECT);
    bench.ask::<Grip>(&GripTo { fingers: Which::All, force: 2.0, speed: Some(0.1), limit: None }).unwrap();
    let mut waited = 0;
    while last(&bench).phase != Phase::Gripped {
        bench.run(SECOND / 10);
        bench.ask::<GetCounters>(&());
        waited += 1;
        assert!(waited < 200, "{:?}", last(&bench));
    }
    bench.run(3 * SECOND);
    assert_eq!(last(&bench).phase, Phase::Gripped);
    let short = Settings { silence_ms: 499, ..settings };
    assert!(matches!(bench.ask::<SetSettings>(&short), Err(Refusal::Setting { .. })));
}

/// The goal is never far ahead of the servo: one whose gripper is gone in a motion stops there, without a Bus Watchdog, which would take
/// the torque from a grip.
#[test]
fn a_servo_whose_gripper_is_gone_stops() {
    for speed in [0.1_f32, 0.35, 1.0] {
        let mut bench = Bench::new(geared_servo(), &Flash::new());
        set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
        bench.ask::<Close>(&CloseTo { fingers: Which::All, angle: -0.045, speed: Some(0.2) }).unwrap();
        bench.run(SECOND);
        bench.ask::<Close>(&CloseTo { fingers: Which::All, angle: 0.2, speed: Some(speed) }).unwrap();
        // Before the first contact at 0.
        bench.run((40_000.0 / speed) as u64);
        assert_eq!((last(&bench).phase, bench.servo.read(xm430::BUS_WATCHDOG)), (Phase::Moving, 0));
        bench.meddling = Box::new(|_, _| Vec::new());
        let (from, goal) = (bench.servo.truth().count, bench.servo.read(xm430::GOAL_POSITION));
        bench.run(2 * SECOND);
        let count = bench.servo.truth().count;
        eprintln!("{speed} rad/s: gone at {from} with its goal at {goal}, stopped at {count}");
        assert!(goal - from <= 20 && count <= goal + 1, "{speed} rad/s: at {from}, goal {goal}, stopped at {count}");
    }
}

/// Another master on the bus of which this gripper is the master: an event, not one per packet, and the reason for a servo that is lost.
#[test]
fn another_master_is_reported() {
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
    let mut buffer = [0; 64];
    let id = dynamixel::Id::new(1).unwrap();
    let words = dynamixel::encode(&mut buffer, id, dynamixel::Instruction::Write, &[65, 0, 1]).unwrap().to_vec();
    let mut answers = 0;
    bench.meddling = Box::new(move |to_servo, bytes| {
        answers += u32::from(!to_servo);
        if !to_servo && answers.is_multiple_of(20) { [bytes, words.clone()].concat() } else { bytes }
    });
    bench.run(4 * SECOND);
    let others = |bench: &Bench| bench.events.iter().filter(|event| matches!(event, Event::OtherMaster { .. })).count();
    assert_eq!(others(&bench), 1, "{:?}", bench.events);
    let heard = bench.ask::<GetCounters>(&()).bus_foreign;
    assert!((90..=110).contains(&heard), "{heard} of 100");
    let words = dynamixel::encode(&mut buffer, id, dynamixel::Instruction::Write, &[65, 0, 1]).unwrap().to_vec();
    bench.meddling = Box::new(move |to_servo, bytes| {
        // The answers are lost in what the other one says.
        if to_servo { bytes } else { words.clone() }
    });
    bench.run(SECOND / 2);
    assert!(bench.events.contains(&Event::ServoLost { finger: 0, other_master: true }), "{:?}", bench.events);
    bench.meddling = Box::new(|_, bytes| bytes);
    bench.run(9 * SECOND);
    assert_eq!(others(&bench), 1);
}

/// An object that is placed counts at once and is not stored; one that is set is. What is stored is counted for good.
#[test]
fn a_placed_object_does_not_wear_the_flash() {
    let flash = Flash::new();
    let mut bench = Bench::new(geared_servo(), &flash);
    set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
    let stored = bench.ask::<GetCounters>(&()).flash_writes;
    assert_eq!(stored, 3, "settings, finger, object");
    let at = |y: f64| ObjectDesign::Circle { centre: [41.0, y], radius: 40.0 };
    for step in 0..20 {
        let what = at(50.0 + 0.1 * f64::from(step)).into();
        bench.ask::<PlaceObject>(&For { finger: 0, what }).unwrap();
        assert_eq!(bench.ask::<GetObject>(&0), Some(what));
    }
    assert_eq!(bench.ask::<GetCounters>(&()).flash_writes, stored);
    bench.restart(&flash);
    bench.run(SECOND / 10);
    assert_eq!((bench.ask::<GetObject>(&0), bench.ask::<GetCounters>(&()).flash_writes), (Some(OBJECT.into()), stored));
    bench.ask::<SetObject>(&For { finger: 0, what: at(50.0).into() }).unwrap();
    bench.restart(&flash);
    bench.run(SECOND / 10);
    assert_eq!(
        (bench.ask::<GetObject>(&0), bench.ask::<GetCounters>(&()).flash_writes),
        (Some(at(50.0).into()), stored + 1)
    );
}
