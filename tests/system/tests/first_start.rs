//! What a gripper does that nobody has commissioned, and what it does when its servo is not the one it was commissioned with.

use std::cell::RefCell;
use std::rc::Rc;

use dynamixel::{Layout, MODELS, Model, xm430};
use fre_gripper::servo::Config;
use messages::{
    Close, CloseTo, Event, For, GetCounters, GetServo, GetSettings, Grip, GripTo, Hold, Mount, Phase, Refusal, Role,
    Scan, ServoField, ServoSetup, SetFinger, SetObject, SetSettings, Settings, Which, Why,
};
use model_core::object::ObjectDesign;
use model_core::status::Status;
use system_tests::{Bench, Flash, GEARED_MOUNT, Judge, OBJECT, finger, geared_servo, is_sound, set_up};

const SECOND: u64 = 1_000_000;
/// Instructions of Protocol 2.0 that change nothing: Ping and the reading ones.
const HARMLESS: [u8; 5] = [0x01, 0x02, 0x82, 0x92, 0x8A];

/// Remembers the instructions that the gripper sends.
fn overhear(bench: &mut Bench) -> Rc<RefCell<Vec<u8>>> {
    let heard: Rc<RefCell<Vec<u8>>> = Rc::default();
    let all = heard.clone();
    bench.meddling = Box::new(move |to_servo, bytes| {
        if let (true, Some(instruction)) = (to_servo, bytes.get(7)) {
            all.borrow_mut().push(*instruction);
        }
        bytes
    });
    heard
}

#[test]
fn a_fresh_gripper_writes_nothing_and_leads_nobody() {
    let mut bench = Bench::new(Config { baud_rate: 57_600, ..geared_servo() }, &Flash::new());
    let heard = overhear(&mut bench);
    bench.run(3 * SECOND);
    assert_eq!(bench.ask::<GetSettings>(&()).role, Role::Idle);
    assert!(heard.borrow().is_empty(), "{:?}", heard.borrow());
    assert_eq!(
        bench.ask::<Grip>(&GripTo { fingers: Which::All, force: 1.0, speed: None, limit: None }),
        Err(Refusal::Idle)
    );
    assert_eq!(bench.ask::<Hold>(&Which::All), Err(Refusal::Idle));
    // It can look who is there.
    bench.ask::<Scan>(&()).unwrap();
    bench.run(8 * SECOND);
    assert!(
        bench.events.iter().any(|event| matches!(event, Event::DeviceFound { id: 1, model: 1020, .. })),
        "{:?}",
        bench.events
    );
    assert!(
        !heard.borrow().is_empty() && heard.borrow().iter().all(|code| HARMLESS.contains(code)),
        "{:?}",
        heard.borrow()
    );
    assert_eq!(bench.servo.truth().count, 2037);
}

/// Whatever is damaged in the flash: the gripper is what it was, or idle. Never another role, and never with the finger of one
/// time on the mount of another.
#[test]
fn a_damaged_flash_leads_to_idle() {
    let settings = Settings { role: Role::DEVICE, ..Settings::of(GEARED_MOUNT) };
    let (mut idle, mut whole) = (0, 0);
    for round in 0..60_usize {
        let flash = Flash::new();
        let mut bench = Bench::new(geared_servo(), &flash);
        bench.run(SECOND / 10);
        // Two generations of each record.
        for zero in [2048.0, 2050.0] {
            let mount = Mount { zero, ..GEARED_MOUNT };
            bench.ask::<SetSettings>(&Settings { fingers: [Some(mount), None, None, None], ..settings }).unwrap();
            bench.ask::<SetFinger>(&For { finger: 0, what: finger() }).unwrap();
            bench.ask::<SetObject>(&For { finger: 0, what: OBJECT.into() }).unwrap();
        }
        let expected = bench.ask::<GetSettings>(&());
        drop(bench);
        flash.damage(round * 37 + 11, 0x5A);
        let mut bench = Bench::new(geared_servo(), &flash);
        let heard = overhear(&mut bench);
        bench.run(SECOND / 5);
        let found = bench.ask::<GetSettings>(&());
        // The last generation, or the one before it if the last record is the damaged one: finger, object and mount of one time.
        if found.role == expected.role {
            assert_eq!(bench.ask::<messages::GetFinger>(&0), Some(finger()), "round {round}");
            assert_eq!(bench.ask::<messages::GetObject>(&0), Some(OBJECT.into()), "round {round}");
            whole += 1;
        } else {
            idle += 1;
            assert_eq!(found, Settings::DEFAULT, "round {round}");
            assert_eq!(bench.ask::<messages::GetFinger>(&0), None, "round {round}");
            assert_eq!(bench.ask::<messages::GetObject>(&0), None, "round {round}");
            let told = |event: &Event| matches!(event, Event::Restored { damaged, .. } if *damaged > 0);
            assert!(bench.events.iter().any(told), "round {round}: {:?}", bench.events);
            assert!(heard.borrow().is_empty());
        }
    }
    eprintln!("{whole} whole, {idle} idle");
    assert!(whole > 10 && idle > 5, "{whole} whole, {idle} idle");
}

/// Sets the bench up as commissioned; gives what it found.
fn commissioned(bench: &mut Bench) -> ServoSetup {
    set_up(bench, &Settings::of(GEARED_MOUNT), OBJECT);
    let setup = bench.ask::<GetServo>(&0).expect("a servo that was found");
    let mount = Mount { servo: Some(setup), ..GEARED_MOUNT };
    bench.ask::<SetSettings>(&Settings::of(mount)).unwrap();
    bench.until("sound estimate", 5 * SECOND, is_sound);
    setup
}

#[test]
fn a_servo_that_is_set_otherwise_is_not_led() {
    let flash = Flash::new();
    let mut bench = Bench::new(geared_servo(), &flash);
    let setup = commissioned(&mut bench);
    assert_eq!((setup.model, setup.operating_mode, setup.position_limits), (1020, 3, [0, 4095]));
    drop(bench);
    // Somebody changes it while the gripper is away; torque is on, as it would turn on and on.
    type Change<'c> = &'c dyn Fn(&mut Bench);
    let cases: [(ServoField, Change<'_>); 5] = [
        (ServoField::OperatingMode, &|bench| bench.servo.write(xm430::OPERATING_MODE, 1)),
        (ServoField::DriveMode, &|bench| bench.servo.write(xm430::DRIVE_MODE, 1)),
        (ServoField::HomingOffset, &|bench| bench.servo.write(xm430::HOMING_OFFSET, 100)),
        (ServoField::GreatestPosition, &|bench| bench.servo.write(xm430::MAX_POSITION_LIMIT, 2100)),
        (ServoField::StartupConfiguration, &|bench| bench.servo.write(xm430::STARTUP_CONFIGURATION, 1)),
    ];
    for (field, change) in cases {
        let mut bench = Bench::new(geared_servo(), &flash);
        change(&mut bench);
        bench.servo.write(xm430::TORQUE_ENABLE, 1);
        let heard = overhear(&mut bench);
        bench.run(3 * SECOND);
        let told: Vec<_> = bench.events.iter().filter(|event| matches!(event, Event::ServoDiffers { .. })).collect();
        assert!(
            matches!(told[..], [Event::ServoDiffers { finger: 0, difference }] if difference.field == field),
            "{field:?}: {:?}",
            bench.events
        );
        assert!(heard.borrow().iter().all(|code| HARMLESS.contains(code)), "{field:?}: {:?}", heard.borrow());
        assert!(bench.reports.iter().all(|(report, _)| !is_sound(report)), "{field:?}");
        assert_eq!(bench.ask::<Hold>(&Which::All), Err(Refusal::NoServo), "{field:?}");
    }
}

/// A servo that turns on and on in velocity control is not one that holds, commissioned or not.
#[test]
fn a_servo_in_velocity_control_is_never_held() {
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    bench.servo.write(xm430::OPERATING_MODE, 1);
    bench.servo.write(xm430::TORQUE_ENABLE, 1);
    bench.ask::<SetSettings>(&Settings::of(GEARED_MOUNT)).unwrap();
    bench.run(2 * SECOND);
    let differs = |event: &Event| matches!(event, Event::ServoDiffers { difference, .. } if difference.field == ServoField::OperatingMode);
    assert!(bench.events.iter().any(differs), "{:?}", bench.events);
    assert!(!bench.events.iter().any(|event| matches!(event, Event::ServoReady { .. })), "{:?}", bench.events);
}

#[test]
fn an_unknown_model_is_not_led() {
    let cases = [
        (1130, "its servo is an XM540-W150 (model 1130), which the gripper cannot control"),
        (4242, "its servo is of the unknown model 4242, which the gripper cannot control"),
    ];
    for (number, words) in cases {
        let mut bench = Bench::new(Config { model_number: Some(number), ..geared_servo() }, &Flash::new());
        let heard = overhear(&mut bench);
        assert_eq!(refused(&mut bench), (ServoField::Model, format!("finger 0 is not controlled: {words}")));
        assert!(heard.borrow().iter().all(|code| HARMLESS.contains(code)), "{:?}", heard.borrow());
    }
}

/// Servos that are simulated, each with a finger on it.
fn models() -> impl Iterator<Item = (&'static Model, Config, Mount)> {
    let known = MODELS.iter().filter(|model| Config::of(model).is_simulated());
    known.map(|model| {
        let Config { baud_rate, backlash_deg, start_deg, load, .. } = geared_servo();
        let config = Config { baud_rate, backlash_deg, start_deg, load, ..Config::of(model) };
        // The P series counts from the middle of its revolution.
        let zero = if model.layout == Layout::P { 0.0 } else { 2048.0 };
        (model, config, Mount { zero, ..GEARED_MOUNT })
    })
}

/// Each is commissioned, moves a finger, keeps its force over a restart of the microcontroller, and is not controlled once it is set
/// otherwise. Their currents are compared with the torques by their own motors.
#[test]
fn every_model_leads_a_finger() {
    let mut seen = Vec::new();
    for (model, config, mount) in models() {
        let name = model.name;
        let flash = Flash::new();
        let mut bench = Bench::new(config.clone(), &flash);
        set_up(&mut bench, &Settings::of(mount), OBJECT);
        let setup = bench.ask::<GetServo>(&0).expect("a servo that was found");
        assert_eq!((setup.model, setup.operating_mode), (model.number, 3), "{name}");
        let mount = Mount { servo: Some(setup), ..mount };
        bench.ask::<SetSettings>(&Settings::of(mount)).unwrap();
        bench.until("sound estimate", 5 * SECOND, is_sound);
        bench.events.clear();
        // As strong as the small ones can, and so that the friction of the strong ones does not hide the contact.
        let asked = if model.motor.friction > 200.0 { 6.0 } else { 2.0 };
        let to = GripTo { fingers: Which::All, force: asked, speed: Some(0.1), limit: None };
        bench.ask::<Grip>(&to).unwrap();
        let mut judge = Judge::default();
        // Great friction makes the last counts slow.
        bench.until("grip", 30 * SECOND, |report| report.phase == Phase::Gripped);
        judge.run(&mut bench, SECOND);
        let force = |bench: &Bench| {
            let [x, y] = bench.servo.truth().force;
            x.hypot(y)
        };
        let gripped = force(&bench);
        let last = bench.reports.last().unwrap().0;
        // Where friction holds a motor between two counts, the grip goes on trying.
        assert!(matches!(last.phase, Phase::Gripped | Phase::Gripping), "{name}: {gripped} N, {last:?}");
        assert!((gripped / f64::from(asked) - 1.0).abs() < 0.05, "{name}: {gripped} N");
        let told = |event: &Event| matches!(event, Event::TorquesDisagree { .. } | Event::ServoAlert { .. });
        assert!(!bench.events.iter().any(told), "{name}: {:?}", bench.events);
        assert!(bench.events.iter().any(|event| matches!(event, Event::Touched { .. })), "{name}: {:?}", bench.events);
        // What it holds with is a current, or the part of the stall torque that it is.
        let held = f64::from(last.current) * f64::from(model.motor.torque_constant);
        let torque = f64::from(last.estimate.torque);
        assert!((held - torque).abs() < 1.1 * f64::from(model.motor.friction), "{name}: {held} N·mm for {torque}");
        bench.restart(&flash);
        judge.run(&mut bench, SECOND);
        let after = force(&bench);
        assert!(after > 0.95 * gripped, "{name}: {after} N of {gripped} N after a restart");
        judge.verdict(name, &bench);
        drop(bench);
        let mut bench = Bench::new(config, &flash);
        bench.servo.write(xm430::DRIVE_MODE, 1);
        let heard = overhear(&mut bench);
        bench.run(2 * SECOND);
        let differs = |event: &Event| matches!(event, Event::ServoDiffers { difference, .. } if difference.field == ServoField::DriveMode);
        assert!(bench.events.iter().any(differs), "{name}: {:?}", bench.events);
        assert!(heard.borrow().iter().all(|code| HARMLESS.contains(code)), "{name}: {:?}", heard.borrow());
        seen.push(name);
    }
    assert_eq!(seen, ["XM430-W350", "XL430-W250", "XM540-W270", "XL330-M288", "XC330-T288", "PM42-010-S260-R"]);
}

/// Servos of two control tables are asked one by one: the loop is as much slower as that takes, and in time.
#[test]
fn servos_of_two_tables_lower_the_rate() {
    let [mut x, mut p] = ["XM430-W350", "PM42-010-S260-R"]
        .map(|name| models().find(|(model, ..)| model.name == name).map(|(_, config, mount)| (config, mount)).unwrap());
    (x.0.baud_rate, p.0.baud_rate, p.0.id, p.1.servo_id) = (1_000_000, 1_000_000, 2, 2);
    let mut bench = Bench::of(x.0, vec![p.0], &Flash::new());
    let mut settings = Settings { rate_hz: 1000, shape_every: 0, ..Settings::of(x.1) };
    settings.fingers[1] = Some(p.1);
    bench.ask::<SetSettings>(&settings).unwrap();
    for finger in 0..2 {
        bench.until("a position", 5 * SECOND, |report| report.finger == finger && report.estimate.age > 0);
    }
    bench.run(SECOND);
    let before = bench.ask::<GetCounters>(&());
    // Twice 62 bytes, and a tenth of that, in steps of 0.1 ms.
    assert!((before.chosen_hz - 1e6 / 1400.0).abs() < 0.1, "{before:?}");
    bench.run(SECOND);
    let after = bench.ask::<GetCounters>(&());
    let ticks = after.ticks - before.ticks;
    assert!((707..=722).contains(&ticks) && after.late_ticks == before.late_ticks, "{before:?} {after:?}");
    assert!(after.estimates - before.estimates >= 2 * ticks - 2, "{before:?} {after:?}");
}

/// A second fence needs a model that limits its current: another is named and not written to. One that was commissioned with it and is in
/// position control is not controlled either.
#[test]
fn a_fence_that_a_servo_does_not_have_is_named() {
    for (model, config, mount) in models().filter(|(model, ..)| !model.limits_current()) {
        let mut bench = Bench::new(config, &Flash::new());
        let heard = overhear(&mut bench);
        let (field, words) = refused_with(&mut bench, Mount { current_fence: true, zero: 2048.0, ..mount });
        assert_eq!(field, ServoField::GoalCurrent, "{}", model.name);
        assert!(
            words.ends_with("no current-based position control (Operating Mode 5), which current_fence needs"),
            "{words}"
        );
        assert!(heard.borrow().iter().all(|code| HARMLESS.contains(code)), "{}: {:?}", model.name, heard.borrow());
    }
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    bench.servo.write(xm430::TORQUE_ENABLE, 1);
    let (field, words) = refused_with(&mut bench, Mount { current_fence: true, ..GEARED_MOUNT });
    assert_eq!(field, ServoField::OperatingMode);
    assert!(words.ends_with("its servo's Operating Mode is 3, and 5 was commissioned"), "{words}");
}

/// The current limit stops every model: one that shows a load by what that is of its current at stall.
#[test]
fn the_current_limit_stops_every_model() {
    for (model, config, mount) in models() {
        let name = model.name;
        // Its friction, and a tenth of its torque at stall, but no more than the finger can be asked for.
        let motor = model.motor;
        let most = (0.1 * motor.torque_constant * motor.stall_current).min(300.0);
        let current_limit = (motor.friction + most) / motor.torque_constant;
        let mut bench = Bench::new(config, &Flash::new());
        bench.ask::<SetSettings>(&Settings::of(Mount { current_limit, ..mount })).unwrap();
        bench.until("answer of the servo", 5 * SECOND, |report| report.estimate.status == Status::OutOfRange);
        bench.ask::<Close>(&CloseTo { fingers: Which::All, angle: 0.25, speed: Some(0.1) }).unwrap();
        let (mut over, mut most) = (0, 0.0_f32);
        bench.until("a stop", 5 * SECOND, |report| {
            over += u32::from(report.current > current_limit);
            most = most.max(report.current);
            report.phase == Phase::Held(Why::Current)
        });
        eprintln!("{name}: {most:.0} mA, limit {current_limit:.0} mA");
        assert_eq!(over, 1, "{name}: the first tick above it is the last one that moves the motor on");
        bench.run_with(SECOND, |report, _| most = most.max(report.current));
        assert!(most < 1.1 * current_limit, "{name}: {most} mA, limit {current_limit}");
    }
}

/// A servo that answers pings only, or reads too, and one whose Bus Watchdog has tripped, are named and put right.
#[test]
fn ways_out_of_dead_ends() {
    for level in [0, 1] {
        let mut bench = Bench::new(geared_servo(), &Flash::new());
        bench.servo.write(xm430::STATUS_RETURN_LEVEL, level);
        set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
        assert_eq!(bench.servo.read(xm430::STATUS_RETURN_LEVEL), 2);
        let told = bench.events.iter().find(|event| matches!(event, Event::ServoDiffers { .. })).map(Event::to_string);
        let words = format!(
            "its servo's Status Return Level was {level}, so that it did not answer everything; it is set to 2"
        );
        assert_eq!(told, Some(format!("finger 0 is not controlled: {words}")));
    }
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    bench.servo.write(xm430::TORQUE_ENABLE, 1);
    bench.servo.write(xm430::BUS_WATCHDOG, 1);
    bench.run(SECOND);
    assert_eq!(bench.servo.read(xm430::BUS_WATCHDOG), -1);
    set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
    let tripped = |event: &Event| matches!(event, Event::ServoDiffers { difference, .. } if difference.field == ServoField::BusWatchdog);
    assert!(bench.events.iter().any(tripped), "{:?}", bench.events);
    bench.ask::<Close>(&CloseTo { fingers: Which::All, angle: 0.05, speed: None }).unwrap();
    bench.run(SECOND);
    assert!(bench.servo.truth().count > 2060, "{:?}", bench.servo.truth());
}

/// The difference with which the first servo is refused, and its words.
fn refused(bench: &mut Bench) -> (ServoField, String) {
    refused_with(bench, GEARED_MOUNT)
}

/// The same with another mount.
fn refused_with(bench: &mut Bench, mount: Mount) -> (ServoField, String) {
    bench.ask::<SetSettings>(&Settings::of(mount)).unwrap();
    bench.run(3 * SECOND);
    let differs = |event: &Event| match event {
        Event::ServoDiffers { difference, .. } => Some((difference.field, event.to_string())),
        _ => None,
    };
    assert!(!bench.events.iter().any(|event| matches!(event, Event::ServoReady { .. })), "{:?}", bench.events);
    bench.events.iter().find_map(differs).unwrap_or_else(|| panic!("{:?}", bench.events))
}

/// It refuses the goal at which it is: before, it was looked for again and again without a word.
#[test]
fn a_servo_outside_its_limits_is_named() {
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    bench.servo.write(xm430::MIN_POSITION_LIMIT, 3000);
    let position = bench.servo.truth().count;
    let words =
        format!("its servo is at {position}, outside its position limits: turn it to 3000, or change the limits");
    assert_eq!(refused(&mut bench), (ServoField::PresentPosition, format!("finger 0 is not controlled: {words}")));
    // Where that is put right, it is found.
    bench.servo.write(xm430::MIN_POSITION_LIMIT, 0);
    set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
}

/// Its torque is on before anything can be set.
#[test]
fn a_servo_with_torque_at_start_up_is_named() {
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    bench.servo.write(xm430::STARTUP_CONFIGURATION, 1);
    bench.servo.reset();
    assert_eq!(bench.servo.read(xm430::TORQUE_ENABLE), 1);
    let (field, words) = refused(&mut bench);
    assert_eq!(field, ServoField::StartupConfiguration);
    assert!(
        words.ends_with("its servo's Startup Configuration switches the torque on with the power: set it to 0"),
        "{words}"
    );
}

/// They answer pings as one, and everything else at the same time.
#[test]
fn two_servos_of_one_id_are_named() {
    let other = Config { start_deg: Some(4.0), ..geared_servo() };
    let mut bench = Bench::of(geared_servo(), vec![other], &Flash::new());
    let (field, words) = refused(&mut bench);
    assert_eq!(field, ServoField::Id);
    assert!(words.ends_with("two servos seem to have this id"), "{words}");
}

/// A goal that another limit of the servo forbids.
#[test]
fn a_goal_outside_the_servos_limits_is_named() {
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    bench.servo.write(xm430::MAX_POSITION_LIMIT, 2060);
    set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
    bench.ask::<Close>(&CloseTo { fingers: Which::All, angle: 0.05, speed: None }).unwrap();
    bench.run(SECOND);
    let refused = bench.events.iter().find(|event| matches!(event, Event::GoalRefused { .. }));
    let words = refused.unwrap_or_else(|| panic!("{:?}", bench.events)).to_string();
    assert!(words.ends_with(": it is outside its Min and Max Position Limit"), "{words}");
}

/// Closing goes on for 50 ms at most while the estimate is not to be trusted: here, an object around the finger's base.
#[test]
fn closing_stops_when_the_estimate_is_lost() {
    for ms in [50_u16, 500] {
        let mut bench = Bench::new(geared_servo(), &Flash::new());
        let settings = Settings { untrusted_ms: ms, ..Settings::of(GEARED_MOUNT) };
        set_up(&mut bench, &settings, OBJECT);
        bench.ask::<Close>(&CloseTo { fingers: Which::All, angle: 0.15, speed: Some(0.1) }).unwrap();
        bench.run(SECOND / 4);
        let ObjectDesign::Circle { radius, .. } = OBJECT else { panic!("a circle") };
        let inside = ObjectDesign::Circle { centre: [0.0, 30.0], radius };
        bench.ask::<SetObject>(&For { finger: 0, what: inside.into() }).unwrap();
        let began = bench.now_us();
        bench.until("a stop", 2 * SECOND, |report| report.phase == Phase::Held(Why::Estimate));
        let took_ms = (bench.now_us() - began) / 1000;
        assert!((u64::from(ms) - 5..u64::from(ms) + 15).contains(&took_ms), "{took_ms} ms instead of {ms}");
        let last = bench.reports.last().unwrap().0;
        assert!(last.estimate.status != Status::Converged && last.goal < 0.1, "{last:?}");
    }
}

/// The default limits: 15 N and half an ampere.
#[test]
fn the_default_limits_limit() {
    let Mount { force_limit, current_limit, .. } = Mount::DEFAULT;
    assert_eq!((force_limit, current_limit), (15.0, 500.0));
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    // No finger, no object: the current's limit is all there is, in both directions.
    let mount = Mount { force_limit, current_limit, ..GEARED_MOUNT };
    bench.ask::<SetSettings>(&Settings::of(mount)).unwrap();
    bench.until("answer of the servo", 5 * SECOND, |report| report.estimate.status == Status::OutOfRange);
    bench.ask::<Close>(&CloseTo { fingers: Which::All, angle: 0.25, speed: Some(0.2) }).unwrap();
    bench.until("a stop", 5 * SECOND, |report| report.phase == Phase::Held(Why::Current));
    bench.run(SECOND);
    let [x, y] = bench.servo.truth().force;
    assert!(x.hypot(y) < 20.0, "{x} {y}");
    bench.ask::<messages::Open>(&Which::All).unwrap();
    bench.until("an open finger", 5 * SECOND, |report| report.goal == GEARED_MOUNT.open_angle);
}
