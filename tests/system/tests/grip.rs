//! The firmware in QEMU grips with a force, judged by what the simulated servo's finger really does.

use std::sync::Arc;
use std::time::{Duration, Instant};

use dynamixel::xm430;
use fre_gripper::link::{Link, LinkError};
use fre_gripper::servo::{Clock, Config, Gains, Handle, Load, OnBranch};
use messages::{Event, GripTo, Mount, Phase, Reaction, Refusal, Report, Settings, SettingsField, Side, Which, Why};
use model_core::object::ObjectDesign;
use model_core::status::Status;
use system_tests::{Machine, OBJECT, Tries, Watch, finger, load_of};

const SECONDS: fn(u64) -> Duration = Duration::from_secs;
const DEGREE: f32 = std::f32::consts::PI / 180.0;
/// One count of the servo, rad.
const COUNT: f64 = std::f64::consts::TAU / 4096.0;
/// ROBOTIS' figure for this family.
const BACKLASH_DEG: f64 = 0.25;
const MOUNT: Mount = Mount {
    open_angle: -DEGREE,
    backlash: BACKLASH_DEG as f32 * DEGREE,
    range: [-0.05, 0.3],
    force_limit: 100.0,
    current_limit: 2000.0,
    ..Mount::DEFAULT
};

fn circle(radius: f64, x: f64, y: f64) -> ObjectDesign {
    ObjectDesign::Circle { centre: [x, y], radius }
}

/// A servo with play and the gains of the factory on an object: it holds by its error, and comes late. Its time is that of a gripper
/// which reads it so often.
fn servo(load: &Arc<Load>, rate_hz: u16) -> Config {
    let clock = Clock::Requests { period_us: 1_000_000 / u32::from(rate_hz) };
    Config { clock, backlash_deg: BACKLASH_DEG, gains: Gains::FACTORY, load: load.clone(), ..Machine::servo() }
}

fn ready(machine: &Machine, settings: &Settings, objects: &[ObjectDesign]) -> (Link, Watch) {
    let link = machine.link();
    let mut watch = Watch::new(&link);
    link.set_settings(settings).unwrap();
    for (number, object) in objects.iter().enumerate() {
        link.set_finger(number as u8, &finger()).unwrap();
        link.set_object(number as u8, *object).unwrap();
    }
    let mut sound = vec![false; objects.len()];
    watch.until_report("trustworthy estimates", SECONDS(30), |report| {
        sound[usize::from(report.finger)] |= report.estimate.status.is_trustworthy() && report.estimate.age == 0;
        sound.iter().all(|sound| *sound)
    });
    (link, watch)
}

/// Slow enough that a busy PC makes few ticks stale.
const RATE_HZ: u16 = 100;

/// 0.65 counts a tick.
fn grip(force: f32) -> GripTo {
    GripTo { fingers: Which::All, force, speed: Some(0.001 * f32::from(RATE_HZ)), limit: None }
}

fn settings() -> Settings {
    Settings { rate_hz: RATE_HZ, ..Settings::of(MOUNT) }
}

/// A busy PC may keep the servo's answers until it counts as lost, which ends a grip, or for a tick, which ends one that
/// releases on a fault, or all of QEMU until its watchdog bites: asks again, once a second, by the rule of [`Tries`].
struct Again(Instant, Tries);

impl Again {
    fn new() -> Self {
        Self(Instant::now(), Tries::of("a grip"))
    }

    fn look(&mut self, link: &Link, report: &Report, force: f32) {
        self.ask(link, report, &grip(force));
    }

    fn ask(&mut self, link: &Link, report: &Report, to: &GripTo) {
        let is_ended =
            [Phase::Held(Why::ServoLost), Phase::Released(Why::Bus), Phase::Held(Why::Asked)].contains(&report.phase);
        if is_ended && self.0.elapsed() > SECONDS(1) {
            // Refused as long as the servo is not found.
            if link.grip(&GripTo { fingers: Which::One(report.finger), ..*to }).is_ok() {
                self.1.spoilt();
            }
            self.0 = Instant::now();
        }
    }
}

/// Opens the finger; a busy PC may lose the servo meanwhile.
fn opened(link: &Link, watch: &mut Watch) {
    let mut asked = Instant::now() - SECONDS(2);
    let (mut tries, mut opens) = (Tries::of("an opening"), false);
    watch.until_report("open finger", SECONDS(120), |report| {
        if asked.elapsed() > SECONDS(1) && report.goal != MOUNT.open_angle {
            // Refused as long as the servo is not found.
            if link.open_fingers(Which::All).is_ok() && core::mem::replace(&mut opens, true) {
                tries.spoilt();
            }
            asked = Instant::now();
        }
        report.estimate.status == Status::NoContact && report.goal == MOUNT.open_angle
    });
}

/// For how many reports a finger has kept its force. A tick that a busy PC makes stale moves nothing and counts for nothing.
fn keeps(reports: u32, report: &Report) -> u32 {
    match report.phase {
        Phase::Gripped => reports + 1,
        Phase::Waiting(Why::Bus) => reports,
        _ => 0,
    }
}

/// True force of a servo's finger, N.
fn truth(servo: &Handle) -> f64 {
    let [x, y] = servo.truth().force;
    x.hypot(y)
}

/// What may be off: 5 %, or what one count makes.
fn allowed(load: &Load, servo: &Handle, force: f64) -> f64 {
    let angle = servo.truth().finger_angle;
    let magnitude = |angle: f64| {
        let [x, y] = load.at(angle, &mut OnBranch::default()).force;
        x.hypot(y)
    };
    f64::max(0.05 * force, magnitude(angle + 0.5 * COUNT) - magnitude(angle - 0.5 * COUNT))
}

/// Three objects, three forces: what was asked for is what the finger does, and never a tenth more on the way.
#[test]
fn the_force_asked_for_is_the_force_there_is() {
    for object in [OBJECT, circle(40.0, 41.0, 60.0), circle(30.0, 31.0, 38.0)] {
        let load = load_of(object, 17.0);
        let machine = Machine::boot(servo(&load, RATE_HZ));
        let (link, mut watch) = ready(&machine, &settings(), &[object]);
        for force in [2.0_f64, 5.0, 10.0] {
            link.grip(&grip(force as f32)).unwrap();
            let (mut most, mut kept, mut again) = (0.0, 0, Again::new());
            watch.until_report("grip", SECONDS(120), |report| {
                again.look(&link, report, force as f32);
                most = f64::max(most, truth(&machine.servo));
                kept = keeps(kept, report);
                kept > 50
            });
            let (reached, allowed) = (truth(&machine.servo), allowed(&load, &machine.servo, force));
            let told = f64::from(watch.reports.last().unwrap().estimate.force_magnitude());
            eprintln!(
                "{object:?}: {force} N asked, {reached:.3} N reached (±{allowed:.3}), {most:.3} N most, {told:.3} N told"
            );
            assert!((reached - force).abs() <= allowed, "{reached} N instead of {force} N ± {allowed} on {object:?}");
            assert!(most <= 1.1 * force, "{most} N on the way to {force} N on {object:?}");
            link.open_fingers(Which::All).unwrap();
            watch.until_report("open finger", SECONDS(60), |report| {
                report.phase == Phase::Released(Why::Asked)
                    && report.estimate.status == Status::NoContact
                    && report.goal == MOUNT.open_angle
            });
        }
    }
}

/// Two fingers on one bus, one mirrored: each grips by itself, and together they squeeze without a side force.
#[test]
fn two_fingers_squeeze() {
    let load = load_of(OBJECT, 12.0);
    let second = Config { id: 7, closing_up: false, zero_count: 1000, ..servo(&load, RATE_HZ) };
    let machine = Machine::boot_all(vec![servo(&load, RATE_HZ), second]);
    let other =
        Mount { servo_id: 7, zero: 1000.0, direction: messages::Direction::Reversed, side: Side::Right, ..MOUNT };
    let mut settings = settings();
    settings.fingers[1] = Some(other);
    let (link, mut watch) = ready(&machine, &settings, &[OBJECT, OBJECT]);
    link.grip(&grip(6.0)).unwrap();
    let (mut kept, mut again) = ([0; 2], Again::new());
    watch.until_report("grip of both", SECONDS(120), |report| {
        again.look(&link, report, 6.0);
        let kept_one = &mut kept[usize::from(report.finger)];
        *kept_one = keeps(*kept_one, report);
        kept.iter().all(|kept| *kept > 50)
    });
    for servo in &machine.servos {
        let (reached, allowed) = (truth(servo), allowed(&load, servo, 6.0));
        assert!((reached - 6.0).abs() <= allowed, "{reached} N instead of 6 N ± {allowed}");
    }
    let grasp = *watch.grasps.iter().rev().find(|grasp| grasp.is_trustworthy).expect("a sound grasp");
    let [x, y] = machine.servo.truth().force;
    assert!((f64::from(grasp.squeeze) - x).abs() < 0.6, "{grasp:?}, {x} N");
    assert!(f64::from(grasp.sum[0]).abs() < 0.6 && (f64::from(grasp.sum[1]) - 2.0 * y).abs() < 1.0, "{grasp:?}");

    // One that falls silent does not take the other one with it.
    machine.servos[1].silence(SECONDS(3600));
    watch.until_event("loss of the second", SECONDS(20), |event| {
        *event == Event::ServoLost { finger: 1, other_master: false }
    });
    link.grip(&GripTo { fingers: Which::One(0), ..grip(3.0) }).unwrap();
    watch.until_report("grip of the first", SECONDS(60), |report| {
        report.finger == 0 && report.phase == Phase::Gripped && (report.estimate.force_magnitude() - 3.0).abs() < 0.3
    });
    assert!(matches!(link.grip(&grip(3.0)), Err(LinkError::Refused(Refusal::NoServo))));
    machine.servos[1].speak();
    link.hold(Which::One(0)).unwrap();
    watch.until_event("second servo", SECONDS(20), |event| matches!(event, Event::ServoReady { finger: 1, .. }));
    watch.until_report("what it does then", SECONDS(20), |report| {
        report.finger == 1 && report.phase == Phase::Held(Why::ServoLost) && report.estimate.age == 0
    });
}

/// Angle, force and current: each ends a motion where it is, and says so.
#[test]
fn no_limit_is_passed() {
    let load = load_of(OBJECT, 17.0);
    let machine = Machine::boot(servo(&load, RATE_HZ));
    let (link, mut watch) = ready(&machine, &settings(), &[OBJECT]);
    let limit = 6.0 * DEGREE;
    link.grip(&GripTo { limit: Some(limit), ..grip(50.0) }).unwrap();
    // The motor's limit: its goal is ahead of it by what the load keeps back.
    let mut furthest = f64::MIN;
    watch.until_report("angle's limit", SECONDS(60), |report| {
        furthest = furthest.max(machine.servo.truth().motor_angle);
        report.phase == Phase::Held(Why::Angle)
    });
    let limit = f64::from(limit);
    assert!((limit - 2.0 * COUNT..=limit + COUNT).contains(&furthest), "{furthest} rad, {limit} allowed");
    opened(&link, &mut watch);

    // Whatever leads the motor on: here an angle.
    let most = 4.0;
    link.set_settings(&Settings {
        fingers: [Some(Mount { force_limit: most, ..MOUNT }), None, None, None],
        ..settings()
    })
    .unwrap();
    link.close(Which::All, 15.0 * DEGREE, Some(0.1)).unwrap();
    let mut greatest = 0.0;
    watch.until_report("force's limit", SECONDS(60), |report| {
        greatest = f64::max(greatest, truth(&machine.servo));
        report.phase == Phase::Held(Why::Force)
    });
    assert!(greatest <= 1.05 * f64::from(most), "{greatest} N");
    assert!(matches!(link.grip(&grip(most + 1.0)), Err(LinkError::Refused(Refusal::Setting { .. }))));
    opened(&link, &mut watch);

    let most = 350.0;
    link.set_settings(&Settings {
        fingers: [Some(Mount { current_limit: most, ..MOUNT }), None, None, None],
        ..settings()
    })
    .unwrap();
    link.grip(&grip(50.0)).unwrap();
    let mut over = 0;
    watch.until_report("current's limit", SECONDS(60), |report| {
        over += u32::from(report.current > most);
        report.phase == Phase::Held(Why::Current)
    });
    assert_eq!(over, 1, "the first tick above it is the last one that leads the motor on");
}

/// An estimate that is none, and a motor that is too weak: the finger holds, or releases, as the settings say, and says why.
#[test]
fn a_bad_estimate_or_a_stall_holds_or_releases() {
    let load = load_of(OBJECT, 17.0);
    let machine = Machine::boot(servo(&load, 20));
    // At this rate a busy PC seldom loses an answer, which would be the reason then.
    let settings = Settings { rate_hz: 20, ..settings() };
    let (link, mut watch) = ready(&machine, &settings, &[OBJECT]);
    for reaction in [Reaction::Hold, Reaction::Release] {
        link.set_settings(&Settings { on_fault: reaction, ..settings }).unwrap();
        let phase = match reaction {
            Reaction::Hold => Phase::Waiting(Why::Estimate),
            Reaction::Release => Phase::Released(Why::Estimate),
        };
        let mut tries = Tries::of("a reaction");
        loop {
            link.grip(&grip(8.0)).unwrap();
            let mut again = Again::new();
            watch.until_report("contact", SECONDS(120), |report| {
                again.look(&link, report, 8.0);
                report.estimate.force_magnitude() > 1.0 && report.phase == Phase::Gripping
            });
            // It touches the finger at every angle: there is nowhere to begin.
            let (from, before) = (watch.reports.len(), truth(&machine.servo));
            link.set_object(0, circle(300.0, -14.0, -20.0)).unwrap();
            let mut ended = false;
            watch.until_report("reaction", SECONDS(60), |report| {
                // The bus of a busy PC may be quicker.
                ended |= [Phase::Held(Why::ServoLost), Phase::Released(Why::Bus)].contains(&report.phase);
                report.phase == phase || ended
            });
            if !ended {
                let mut since = watch.reports[from..].iter().filter(|report| report.estimate.status != Status::Stale);
                let first = *since.find(|report| !report.estimate.status.is_trustworthy()).unwrap();
                assert_eq!(first.phase, phase, "{first:?}");
                if reaction == Reaction::Hold {
                    let some_time = |report: &Report| report.sequence > first.sequence + 50;
                    watch.until_report("some time", SECONDS(60), some_time);
                    let after = truth(&machine.servo);
                    assert!(after - before < 1.0, "{before} N before, {after} N after");
                }
            }
            link.set_object(0, OBJECT).unwrap();
            opened(&link, &mut watch);
            if !ended {
                break;
            }
            tries.spoilt();
        }
    }
    for reaction in [Reaction::Hold, Reaction::Release] {
        link.set_settings(&Settings { on_fault: reaction, ..settings }).unwrap();
        set_pwm(&machine.servo, 120);
        link.grip(&grip(20.0)).unwrap();
        let phase = match reaction {
            Reaction::Hold => Phase::Held(Why::Stall),
            Reaction::Release => Phase::Released(Why::Stall),
        };
        let mut again = Again::new();
        watch.until_report("stall", SECONDS(60), |report| {
            again.look(&link, report, 20.0);
            report.phase == phase
        });
        set_pwm(&machine.servo, 885);
        opened(&link, &mut watch);
    }
}

/// How strong the motor may be, of 885: a register that the gripper leaves alone.
fn set_pwm(servo: &Handle, most: i16) {
    let mut buffer = [0; 64];
    let body = [xm430::GOAL_PWM.address().to_le_bytes(), most.to_le_bytes()].concat();
    let id = dynamixel::Id::new(1).unwrap();
    let packet = dynamixel::encode(&mut buffer, id, dynamixel::Instruction::Write, &body).unwrap();
    let answers = servo.with(|servo| servo.hear(0, packet));
    assert_eq!(answers.len(), 1, "the servo takes it");
}

/// A bus that falls silent in the middle of a grip: the finger holds, or releases, as the settings say, and says why.
#[test]
fn a_silent_bus_holds_or_releases() {
    let load = load_of(OBJECT, 13.0);
    for reaction in [Reaction::Hold, Reaction::Release] {
        let machine = Machine::boot(servo(&load, 10));
        // At this rate even a busy PC answers in time, as long as it answers.
        let settings = Settings { on_fault: reaction, rate_hz: 10, ..settings() };
        let (link, mut watch) = ready(&machine, &settings, &[OBJECT]);
        let grip = GripTo { speed: Some(0.02), ..grip(5.0) };
        link.grip(&grip).unwrap();
        let mut again = Again::new();
        watch.until_report("contact", SECONDS(120), |report| {
            again.ask(&link, report, &grip);
            report.estimate.force_magnitude() > 1.0 && report.phase == Phase::Gripping
        });
        let why = Phase::Waiting(Why::Bus);
        let phase = if reaction == Reaction::Hold { why } else { Phase::Released(Why::Bus) };
        machine.servo.silence(SECONDS(3600));
        let from = watch.reports.len();
        watch.until_event("reaction", SECONDS(20), |event| *event == Event::PhaseChanged { finger: 0, phase });
        watch.until_event("loss", SECONDS(20), |event| *event == Event::ServoLost { finger: 0, other_master: false });
        // The first tick without an answer says so and moves nothing on.
        let first = watch.reports[from..].iter().find(|report| report.estimate.status == Status::Stale).unwrap();
        assert_eq!(first.phase, phase, "{first:?}");
        let before = truth(&machine.servo);
        machine.servo.speak();
        watch.until_event("servo", SECONDS(20), |event| matches!(event, Event::ServoReady { .. }));
        // Nobody knows what has happened meanwhile: it holds, whatever was asked for before.
        watch.until_report("hold", SECONDS(20), |report| {
            report.phase == Phase::Held(Why::ServoLost) && report.estimate.age == 0
        });
        let after = truth(&machine.servo);
        assert!((after - before).abs() < 0.2, "{before} N before, {after} N after");
        if reaction == Reaction::Hold {
            link.grip(&grip).unwrap();
            watch.until_report("grip", SECONDS(60), |report| report.phase == Phase::Gripped);
        }
    }
}

/// A single answer that is lost or damaged costs a tick of the grip, no more.
#[test]
fn a_lost_answer_is_waited_out() {
    let load = load_of(OBJECT, 13.0);
    let machine = Machine::boot(servo(&load, 10));
    // Slower than the other grips: on a busy PC further answers are lost by themselves, and several in a row end a grip.
    let settings = Settings { rate_hz: 10, ..settings() };
    let (link, mut watch) = ready(&machine, &settings, &[OBJECT]);
    let to = GripTo { speed: Some(0.02), ..grip(5.0) };
    link.grip(&to).unwrap();
    let mut again = Again::new();
    for _ in 0..5 {
        watch.until_report("grip on its way", SECONDS(60), |report| {
            again.ask(&link, report, &to);
            matches!(report.phase, Phase::Gripping | Phase::Gripped) && report.estimate.age == 0
        });
        machine.servo.inject([fre_gripper::servo::Fault::Drop]);
        watch.until_report("wait", SECONDS(60), |report| {
            matches!(report.phase, Phase::Waiting(Why::Bus) | Phase::Held(Why::ServoLost))
        });
        watch.until_report("fresh estimate", SECONDS(60), |report| report.estimate.age == 0);
    }
    watch.until_report("grip", SECONDS(120), |report| {
        again.ask(&link, report, &to);
        report.phase == Phase::Gripped
    });
    assert!((truth(&machine.servo) - 5.0).abs() <= allowed(&load, &machine.servo, 5.0));
}

/// What cannot be is refused: no model, no such finger, numbers out of range.
#[test]
fn a_grip_that_cannot_be_is_refused() {
    let machine = Machine::boot(Machine::servo());
    let link = machine.link();
    let mut watch = Watch::new(&link);
    link.set_settings(&settings()).unwrap();
    watch.until_report("position", SECONDS(20), |report| report.estimate.status != Status::Stale);
    let refused = |result: Result<(), LinkError>| match result {
        Err(LinkError::Refused(refusal)) => refusal,
        other => panic!("not refused: {other:?}"),
    };
    assert_eq!(refused(link.grip(&grip(5.0))), Refusal::NoModel);
    let field = |refusal| match refusal {
        Refusal::Setting { field, .. } => field,
        other => panic!("{other:?}"),
    };
    assert_eq!(field(refused(link.grip(&grip(f32::NAN)))), SettingsField::Force);
    assert_eq!(field(refused(link.grip(&grip(101.0)))), SettingsField::Force);
    assert_eq!(field(refused(link.grip(&GripTo { limit: Some(2.0), ..grip(5.0) }))), SettingsField::Limit);
    assert_eq!(field(refused(link.grip(&GripTo { speed: Some(0.0), ..grip(5.0) }))), SettingsField::Speed);
    assert_eq!(field(refused(link.hold(Which::One(1)).map(|_| ()))), SettingsField::Finger);
    assert_eq!(field(refused(link.set_object(9, OBJECT))), SettingsField::Finger);
    let mut twins = Settings::of(Mount::DEFAULT);
    twins.fingers[1] = twins.fingers[0];
    assert_eq!(refused(link.set_settings(&twins)), Refusal::SameServo { servo_id: 1 });
    let mut gap = Settings::of(Mount::DEFAULT);
    (gap.fingers[1], gap.fingers[0]) = (gap.fingers[0], None);
    assert_eq!(field(refused(link.set_settings(&gap))), SettingsField::Fingers);
}
