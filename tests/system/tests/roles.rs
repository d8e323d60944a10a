//! The firmware in QEMU on a bus that another master leads: ROBOTIS' own SDK, on a pseudo-terminal.

mod sdk;

use std::path::Path;
use std::time::Duration;

use fre_gripper::link::{Link, LinkError};
use messages::{Event, Mount, Refusal, Role, Settings, Which};
use model_core::estimator::Estimator;
use model_core::size::Reduced;
use model_core::status::Status;
use system_tests::{Machine, OBJECT, Watch, finger};

use sdk::{GOAL, GRIPPER, SERVO, angle, ask, check, run};

const SECONDS: fn(u64) -> Duration = Duration::from_secs;

/// A gripper that listens.
fn listening(machine: &Machine, role: Role) -> (Link, Watch) {
    let link = machine.link();
    let mut watch = Watch::new(&link);
    link.set_finger(0, &finger()).unwrap();
    let mount = Mount { servo_id: SERVO, force_limit: 100.0, current_limit: 2000.0, ..Mount::DEFAULT };
    // No faster than a busy PC lets QEMU go.
    let settings = Settings { role, baud: Some(1_000_000), rate_hz: 100, shape_every: 0, ..Settings::of(mount) };
    link.set_settings(&settings).unwrap();
    // What is on its way when the role changes is over after a tick.
    watch.until_report("estimate without a master", SECONDS(20), |report| report.estimate.status == Status::Stale);
    (link, watch)
}

/// The SDK pings, reads and writes the gripper beside the servo, in every way it has; what it is told is what the gripper
/// tells on its link, and what it sets is set, and survives the restart it asks for.
#[test]
fn the_sdk_of_robotis_reads_the_force_from_the_firmware() {
    let (machine, bus) = Machine::boot_shared(Machine::servo());
    let (link, mut watch) = listening(&machine, Role::Device { id: GRIPPER, return_delay: 0 });
    let facts = ask(&bus.port);
    check(&facts);

    // A finger held firmly was told on the link too, as the SDK was told it: in whole mN.
    watch.until(
        "what was told meanwhile",
        SECONDS(20),
        |told| matches!(told, fre_gripper::link::Told::Event(notice) if matches!(notice.event, Event::Started { .. })),
    );
    let closed: Vec<i32> = facts["closed"][0].split(' ').map(|word| word.parse().unwrap()).collect();
    let milli = |value: f32| (value * 1e3).round() as i32;
    let told =
        watch.reports.iter().filter(|report| report.position == GOAL && report.estimate.age == 0).any(|report| {
            let estimate = &report.estimate;
            let numbers = [estimate.force[0], estimate.force[1], estimate.force_magnitude()].map(milli);
            numbers.iter().zip(&closed).all(|(here, there)| here.abs_diff(*there) <= 1)
        });
    assert!(told, "the link did not tell {closed:?}");

    let settings = link.settings().unwrap();
    assert_eq!(settings.role, Role::Device { id: GRIPPER + 1, return_delay: 200 });
    assert_eq!((settings.baud, settings.fingers[0].unwrap().zero), (Some(57_600), 2048.5));
    assert_eq!(link.object(0).unwrap(), Some(OBJECT.into()));
    assert_eq!(link.finger(0).unwrap(), Some(finger()));
}

/// A question that comes while an estimate is made is answered meanwhile, from the estimate before, whose position is older.
#[test]
fn an_answer_waits_for_no_estimate() {
    let (machine, bus) = Machine::boot_shared(Machine::servo());
    let (link, _watch) = listening(&machine, Role::Device { id: GRIPPER, return_delay: 0 });
    link.set_object(0, OBJECT).unwrap();
    let text = run("prompt_sdk.py", &bus.port);
    let told: Vec<[i64; 3]> = text
        .lines()
        .map(|line| {
            let mut numbers = line.split(' ').map(|word| word.parse().unwrap());
            std::array::from_fn(|_| numbers.next().unwrap())
        })
        .collect();
    // Of the steps with a new position, in how many it was not waited for.
    let moved: Vec<_> = told.windows(2).filter(|pair| pair[1][0] != pair[0][0]).map(|pair| pair[1]).collect();
    let prompt: Vec<_> = moved.iter().filter(|[position, of, _]| of != position).collect();
    assert!(moved.len() > 20, "{} steps", moved.len());
    // A busy PC may ask too late.
    assert!(prompt.len() >= 10, "{} of {} answers came meanwhile", prompt.len(), moved.len());
    // They say how old their position is: that of the step before, at least.
    assert!(prompt.iter().all(|[.., age]| *age > 10_000), "{prompt:?}");
}

/// Answers are ready before the return delay is over that the control table states.
#[test]
fn an_answer_keeps_its_return_delay() {
    let (machine, bus) = Machine::boot_shared(Machine::servo());
    // The shortest one of this board: 200 µs until the answer is ready, and a byte.
    let (link, _watch) = listening(&machine, Role::Device { id: GRIPPER, return_delay: 105 });
    link.set_object(0, OBJECT).unwrap();
    run("prompt_sdk.py", &bus.port);
    let counters = link.counters().unwrap();
    let [last, most] = [counters.answer, counters.answer_most].map(|ticks| ticks * Machine::INSTRUCTIONS_PER_TICK);
    println!("an answer is ready after {last} instructions, {most} at most");
    assert_eq!(counters.late_answers, 0);
    assert!(last > 1_000, "{last} instructions: is it still measured?");
    // A busy PC brings several packets at once.
    assert!(most <= fre_boards::ANSWER_INSTRUCTIONS, "{most} instructions");
    // A shorter one is refused.
    let role = Role::Device { id: GRIPPER, return_delay: 104 };
    let settings = link.settings().unwrap();
    let refused = link.set_settings(&Settings { role, ..settings }).unwrap_err().to_string();
    assert!(refused.contains("gripper's return delay (0: at once) in 2 µs is 104; allowed is 105 to 254"), "{refused}");
    assert_eq!(link.settings().unwrap(), settings);
}

/// A position that comes once the period has its estimate is estimated in the next one, though nothing is heard in that.
#[test]
fn a_late_position_is_estimated_in_the_next_period() {
    let (machine, bus) = Machine::boot_shared(Machine::servo());
    let (link, mut watch) = listening(&machine, Role::Tap);
    let settings = link.settings().unwrap();
    link.set_settings(&Settings { rate_hz: 20, ..settings }).unwrap();
    let second: Vec<i32> = run("late_sdk.py", &bus.port).lines().map(|line| line.parse().unwrap()).collect();
    assert!(second.len() > 4, "the servo has moved between two reads only {} times", second.len());
    // The one that asks has gone: nothing more is heard.
    let is_fresh = |report: &messages::Report| report.estimate.status != Status::Stale;
    let last = second.last().copied();
    watch.until_report("last position", SECONDS(20), |report| is_fresh(report) && Some(report.position) == last);
    let told: Vec<i32> = watch.reports.iter().filter(|report| is_fresh(report)).map(|report| report.position).collect();
    let missed: Vec<_> = second.iter().filter(|position| !told.contains(position)).collect();
    assert!(missed.is_empty(), "{missed:?} of {second:?} are missing from {told:?}");
}

/// A tap learns the position from every kind of read that another master has, estimates from it, ages when that master
/// stops, and says nothing at all.
#[test]
fn a_tap_hears_another_masters_reads_and_says_nothing() {
    let (machine, bus) = Machine::boot_shared(Machine::servo());
    let (link, mut watch) = listening(&machine, Role::Tap);
    link.set_object(0, OBJECT).unwrap();
    let before = bus.said();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tap_sdk.py");
    let mut led = sdk::spawn(&script, &bus.port, &[1_000_000, i32::from(SERVO), GOAL]);
    watch.until_event("a position heard", SECONDS(60), |event| *event == Event::ServoHeard { finger: 0 });
    watch.until_report("closed finger", SECONDS(120), |report| {
        report.position == GOAL && report.estimate.age == 0 && report.estimate.status.is_trustworthy()
    });
    let closed = watch.reports.last().unwrap().estimate;
    assert!(led.wait().unwrap().success());

    // In double precision, at the same position.
    let mut exact: Box<Estimator<f64, Reduced>> = Box::new(Estimator::EMPTY);
    let finger = finger();
    exact.configure(&finger.design, &finger.how).unwrap();
    exact.set_object(OBJECT).unwrap();
    let exact = (2048 - 12..=GOAL).map(|position| exact.update(angle(position))).last().unwrap();
    for (told, expected) in closed.force.iter().zip(exact.force) {
        assert!((told - expected).abs() < 5e-3, "{told} N instead of {expected}");
    }
    // The motor did not jump: positions in between were heard, too.
    let mut heard: Vec<i32> =
        watch.reports.iter().filter(|it| it.estimate.status != Status::Stale).map(|it| it.position).collect();
    heard.dedup();
    assert!(heard.len() > 20, "only {} positions heard: {heard:?}", heard.len());

    watch.until_report("stale estimate", SECONDS(20), |report| report.estimate.status == Status::Stale);
    watch.until_event("loss of the servo", SECONDS(20), |event| {
        *event == Event::ServoLost { finger: 0, other_master: false }
    });
    assert!(matches!(link.open_fingers(Which::All), Err(LinkError::Refused(Refusal::NotMaster))));
    assert_eq!(bus.said() - before, 0, "bytes were sent");
    // As a master again it finds its servo.
    link.set_settings(&Settings { baud: Some(1_000_000), ..Settings::of(Mount::DEFAULT) }).unwrap();
    watch.until_event("servo", SECONDS(20), |event| matches!(event, Event::ServoReady { .. }));
    assert!(bus.said() > before);
}
