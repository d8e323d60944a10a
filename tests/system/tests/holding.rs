//! A finger that holds something goes on holding it, whatever happens to the bus and to the microcontroller.

use dynamixel::xm430;
use fre_gripper::servo::{Config, Truth};
use messages::{
    Close, CloseTo, Event, For, Grip, GripTo, Mount, Phase, Reaction, SetFinger, SetObject, Settings, Which, Why,
};
use system_tests::{Bench, Flash, GEARED_MOUNT, Judge, OBJECT, finger, geared_servo, is_sound, set_up};

const SECOND: u64 = 1_000_000;
/// Losses of the servo, and restarts of the microcontroller, in one grip.
const LOSSES: u32 = 100;
const RESTARTS: u32 = 20;
/// A silence after which a servo counts as lost, µs.
const SILENT: u64 = 400_000;
/// What a grip may lose of its force.
const LOST: f64 = 0.05;
/// A way in which a servo ceases to hold, by its name.
type Loss = (&'static str, fn(&mut Bench));

fn force(truth: &Truth) -> f64 {
    truth.force[0].hypot(truth.force[1])
}

/// Grips with 5 N on a servo as it comes from the factory, which holds by its error.
fn gripping(flash: &Flash) -> Bench {
    grip(Bench::new(geared_servo(), flash))
}

fn grip(mut bench: Bench) -> Bench {
    set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
    bench.ask::<Grip>(&GripTo { fingers: Which::All, force: 5.0, speed: None, limit: None }).unwrap();
    bench.until("grip", 10 * SECOND, |report| report.phase == Phase::Gripped);
    bench.run(SECOND);
    assert!((force(&bench.servo.truth()) - 5.0).abs() < 0.5, "{:?}", bench.servo.truth());
    bench.keeps = false;
    bench
}

/// The servo is silent for longer than it may be: it counts as lost and is found again.
fn lose(bench: &mut Bench, judge: &mut Judge) {
    bench.servo.silence(bench.now_us() + SILENT);
    judge.run(bench, SILENT);
    judge.run(bench, SECOND / 2);
}

/// Whether the servo was lost.
fn is_lost(bench: &Bench) -> bool {
    bench.events.iter().any(|event| matches!(event, Event::ServoLost { .. }))
}

/// A quarter of a second is noise at every rate, and the grip goes on behind it.
#[test]
fn a_short_silence_does_not_lose_a_servo() {
    for rate_hz in [100, 500] {
        let mut bench = Bench::new(geared_servo(), &Flash::new());
        set_up(&mut bench, &Settings { rate_hz, ..Settings::of(GEARED_MOUNT) }, OBJECT);
        let to = GripTo { fingers: Which::All, force: 5.0, speed: Some(0.1), limit: None };
        bench.ask::<Grip>(&to).unwrap();
        bench.until("grip", 20 * SECOND, |report| report.phase == Phase::Gripped);
        bench.servo.silence(bench.now_us() + SECOND / 4);
        bench.run(SECOND);
        assert!(!is_lost(&bench), "{rate_hz} Hz: {:?}", bench.events);
        assert_eq!(bench.reports.last().unwrap().0.phase, Phase::Gripped, "{rate_hz} Hz");
        bench.servo.silence(bench.now_us() + SILENT);
        bench.run(SECOND);
        assert!(is_lost(&bench), "{rate_hz} Hz: {:?}", bench.events);
    }
}

#[test]
fn a_servo_that_is_lost_and_found_keeps_its_force() {
    let mut bench = gripping(&Flash::new());
    let before = force(&bench.servo.truth());
    let (mut judge, mut least) = (Judge::default(), f64::INFINITY);
    for _ in 0..LOSSES {
        lose(&mut bench, &mut judge);
        least = least.min(force(&bench.servo.truth()));
    }
    let losses = bench.events.iter().filter(|event| matches!(event, Event::ServoLost { .. })).count();
    eprintln!("{losses} losses: {before:.3} N, {least:.3} N least");
    assert!(losses >= LOSSES as usize, "{losses} losses");
    assert!(least > (1.0 - LOST) * before, "{least} N left of {before} N");
    judge.verdict("losses in a grip", &bench);
    let mut last = None;
    bench.run_with(SECOND / 10, |report, _| last = Some(*report));
    let last = last.unwrap();
    assert!(is_sound(&last) && last.phase == Phase::Held(Why::ServoLost), "{last:?}");
}

#[test]
fn a_microcontroller_that_restarts_keeps_the_force() {
    let flash = Flash::new();
    let mut bench = gripping(&flash);
    let before = force(&bench.servo.truth());
    let (mut judge, mut least) = (Judge::default(), f64::INFINITY);
    for _ in 0..RESTARTS {
        bench.restart(&flash);
        judge.run(&mut bench, SECOND);
        least = least.min(force(&bench.servo.truth()));
        assert_eq!(judge.bad, 0, "no sound estimate a second after a restart");
    }
    eprintln!("{RESTARTS} restarts: {before:.3} N, {least:.3} N least");
    assert!(least > (1.0 - LOST) * before, "{least} N left of {before} N");
    judge.verdict("restarts in a grip", &bench);
    // And it still opens and grips.
    bench.ask::<messages::Open>(&Which::All).unwrap();
    bench.until("open finger", 5 * SECOND, |report| report.estimate.force == [0.0; 2] && is_sound(report));
}

/// Another program has left its Bus Watchdog armed: it would stop the servo where it is, without the torque it holds with, as soon as the
/// gripper is silent for that long.
#[test]
fn an_armed_bus_watchdog_does_not_cost_the_force() {
    let flash = Flash::new();
    let mut bench = Bench::new(geared_servo(), &flash);
    // 20 ms; it waits for the torque.
    bench.servo.write(xm430::BUS_WATCHDOG, 1);
    let mut bench = grip(bench);
    let before = force(&bench.servo.truth());
    bench.restart(&flash);
    bench.run(SECOND);
    let after = force(&bench.servo.truth());
    assert!(after > (1.0 - LOST) * before, "{after} N left of {before} N");
    assert_eq!(bench.servo.read(xm430::BUS_WATCHDOG), 0);
}

/// A servo that answers and holds nothing: another program has switched its torque off, or it was without power for less than the time after
/// which it is lost. It is set up anew, and holds where it is then.
#[test]
fn torque_that_is_gone_is_noticed() {
    let gone: [Loss; 3] = [
        ("torque off", |bench| bench.servo.write(xm430::TORQUE_ENABLE, 0)),
        ("a tripped Bus Watchdog", |bench| {
            bench.servo.write(xm430::BUS_WATCHDOG, 1);
            let now = bench.now_us();
            bench.servo.silence(now + 100_000);
        }),
        ("a scan", |bench| {
            bench.ask::<messages::Hold>(&Which::All).unwrap();
            bench.ask::<messages::Scan>(&()).unwrap();
            bench.run(SECOND);
            bench.servo.write(xm430::TORQUE_ENABLE, 0);
            let end = bench.now_us() + 10 * SECOND;
            while !bench.events.iter().any(|event| matches!(event, Event::ScanDone { .. })) {
                assert!(bench.now_us() < end, "{:?}", bench.events);
                bench.run(1_000);
            }
        }),
    ];
    for (what, take) in gone {
        let mut bench = gripping(&Flash::new());
        bench.events.clear();
        take(&mut bench);
        let quick = what == "a scan";
        bench.run(if quick { SECOND / 20 } else { 3 * SECOND / 2 });
        assert!(is_lost(&bench), "{what}: {:?}", bench.events);
        bench.run(SECOND);
        let ready = bench.events.iter().filter(|event| matches!(event, Event::ServoReady { .. })).count();
        let registers = (bench.servo.read(xm430::TORQUE_ENABLE), bench.servo.read(xm430::BUS_WATCHDOG));
        assert_eq!((ready, registers), (1, (1, 0)), "{what}: {:?}", bench.events);
        let mut last = None;
        bench.run_with(SECOND / 10, |report, _| last = Some(*report));
        // Before the scan it was held as asked, and still is.
        let why = if quick { Why::Asked } else { Why::ServoLost };
        assert_eq!(last.unwrap().phase, Phase::Held(why), "{what}");
    }
}

/// A motor that does not follow may have no torque: that is looked at as soon as it counts as stalled.
#[test]
fn a_stall_without_torque_is_a_loss() {
    // Whenever it is between two of the looks that come once a second.
    for quarter in 0..4 {
        let mut bench = Bench::new(geared_servo(), &Flash::new());
        set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
        bench.run(quarter * SECOND / 4);
        bench.ask::<Close>(&CloseTo { fingers: Which::All, angle: 0.1, speed: Some(0.3) }).unwrap();
        bench.run(SECOND / 20);
        bench.servo.write(xm430::TORQUE_ENABLE, 0);
        bench.run(6 * SECOND / 10);
        assert!(is_lost(&bench), "{quarter}: {:?}", bench.events);
        bench.run(SECOND / 10);
        let phase = bench.reports.last().unwrap().0.phase;
        assert_eq!((bench.servo.read(xm430::TORQUE_ENABLE), phase), (1, Phase::Held(Why::ServoLost)));
    }
}

/// Without torque as it was asked for, or with a hardware error that is reported by itself, no servo is lost.
#[test]
fn torque_that_is_off_as_asked_is_no_loss() {
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
    bench.ask::<messages::Relax>(&Which::All).unwrap();
    bench.run(3 * SECOND);
    assert_eq!((is_lost(&bench), bench.servo.read(xm430::TORQUE_ENABLE)), (false, 0));
    bench.ask::<Close>(&CloseTo { fingers: Which::All, angle: 0.0, speed: Some(0.1) }).unwrap();
    bench.run(SECOND);
    assert_eq!((is_lost(&bench), bench.servo.read(xm430::TORQUE_ENABLE)), (false, 1));
    bench.servo.fail(0x20);
    bench.run(3 * SECOND);
    assert_eq!((is_lost(&bench), bench.servo.read(xm430::TORQUE_ENABLE)), (false, 0), "{:?}", bench.events);
}

/// With `release` on faults a finger opens when its own servo does not answer, and for nothing else: not for a servo that is looked for, nor
/// for one that falls silent beside it.
#[test]
fn a_servo_that_is_gone_opens_no_other_finger() {
    let servo = |id| Config { id, ..geared_servo() };
    let mount = |servo_id| Some(Mount { servo_id, ..GEARED_MOUNT });
    let mut bench = Bench::of(servo(1), vec![servo(2)], &Flash::new());
    let mut settings = Settings { on_fault: Reaction::Release, ..Settings::of(GEARED_MOUNT) };
    // The third one is not there.
    (settings.fingers[1], settings.fingers[2]) = (mount(2), mount(9));
    set_up(&mut bench, &settings, OBJECT);
    bench.run(3 * SECOND);
    bench.ask::<SetFinger>(&For { finger: 1, what: finger() }).unwrap();
    bench.ask::<SetObject>(&For { finger: 1, what: OBJECT.into() }).unwrap();
    for fingers in [Which::One(0), Which::One(1)] {
        bench.ask::<Grip>(&GripTo { fingers, force: 5.0, speed: Some(0.1), limit: None }).unwrap();
    }
    let mut phases = [Phase::Relaxed; 2];
    let mut look = |report: &messages::Report| {
        if let Some(phase) = phases.get_mut(usize::from(report.finger)) {
            *phase = report.phase;
        }
        phases == [Phase::Gripped; 2]
    };
    bench.until("both grips", 20 * SECOND, &mut look);
    let released = |bench: &Bench, finger| {
        let opens = |event: &Event| matches!(event, Event::PhaseChanged { finger: whose, phase: Phase::Released(_) } if *whose == finger);
        bench.events.iter().any(opens)
    };
    bench.events.clear();
    bench.run(10 * SECOND);
    assert!(!released(&bench, 0) && !released(&bench, 1), "searches: {:?}", bench.events);
    let end = bench.now_us() + 20 * SECOND;
    bench.servo.silence(end);
    bench.run(3 * SECOND);
    assert!(is_lost(&bench) && released(&bench, 0), "{:?}", bench.events);
    assert!(!released(&bench, 1), "the other one's silence: {:?}", bench.events);
    bench.run(3 * SECOND);
    assert!(!released(&bench, 1), "the search for the other one: {:?}", bench.events);
}

/// Settings of something else do not end a grip: not other limits, not what the servo was commissioned with, not another finger.
#[test]
fn a_grip_goes_on_with_other_settings() {
    let mut bench = gripping(&Flash::new());
    bench.keeps = true;
    let servo = bench.ask::<messages::GetServo>(&0);
    let mount = Mount { speed: 0.2, force_limit: 20.0, current_limit: 1900.0, range: [-0.04, 0.2], ..GEARED_MOUNT };
    let mut settings = Settings { untrusted_ms: 60, ..Settings::of(Mount { servo, ..mount }) };
    settings.fingers[1] = Some(Mount { servo_id: 9, ..GEARED_MOUNT });
    let (before, count) = (force(&bench.servo.truth()), bench.servo.truth().count);
    bench.ask::<messages::SetSettings>(&settings).unwrap();
    bench.run(2 * SECOND);
    let last = |bench: &Bench| bench.reports.iter().rev().find(|(report, _)| report.finger == 0).unwrap().0.phase;
    assert_eq!((last(&bench), bench.servo.truth().count), (Phase::Gripped, count), "{before} N");
    // What it grips by does.
    settings.fingers[0] = Some(Mount { zero: 2050.0, servo, ..mount });
    bench.ask::<messages::SetSettings>(&settings).unwrap();
    bench.run(SECOND / 10);
    assert_eq!(last(&bench), Phase::Held(Why::Asked));
}

/// What another master has under way is stopped where it is, not finished.
#[test]
fn a_servo_found_on_its_way_stops() {
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
    bench.ask::<Close>(&CloseTo { fingers: Which::All, angle: 0.15, speed: Some(0.1) }).unwrap();
    bench.run(SECOND / 2);
    bench.servo.silence(bench.now_us() + SILENT);
    bench.run(SECOND);
    let there = bench.servo.truth().count;
    bench.run(SECOND);
    assert_eq!(bench.servo.truth().count, there);
}
