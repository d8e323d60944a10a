//! A control loop on a processor that hardly has time for an estimate in a tick: at 500 Hz none takes so long that the next tick is late, and
//! at 1 kHz the servo is asked while an estimate is made.

use std::time::Duration;

use fre_gripper::link::Link;
use fre_gripper::servo::{Config, Fault};
use messages::{GripTo, Mount, Report, Settings, Which};
use model_core::discretise::Sampling;
use model_core::object::ObjectDesign;
use model_core::status::Status;
use system_tests::{Machine, OBJECT, Watch, finger};

const DEGREE: f32 = std::f32::consts::PI / 180.0;
const MOUNT: Mount =
    Mount { open_angle: -DEGREE, range: [-0.05, 0.3], force_limit: 100.0, current_limit: 2000.0, ..Mount::DEFAULT };
/// The other object, which is set and taken away while the finger is on it.
const OTHER: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 56.0], radius: 40.0 };
const PATIENCE: Duration = Duration::from_secs(120);
const RATE_HZ: u16 = 500;
const FAST_HZ: u16 = 1000;
/// An instruction takes 8 ns: at 216 MHz (OpenCR) 1.7 cycles, between the bounds of docs/real-time.md.
const SHIFT: u8 = 3;
/// Instructions in a period, and in a tick of the cost clock.
const PERIOD: u32 = (1_000_000_000 / RATE_HZ as u32) >> SHIFT;
const PER_TICK: u32 = Machine::instructions_per_tick(SHIFT);
/// Answers of the servo between two that are lost.
const FAULT_EVERY: usize = 300;
/// Estimates of more than half a period that are looked at, and motions within which they are seen.
const ENOUGH: u32 = 100;
const MOTIONS: usize = 5;

/// A machine whose finger has five samples per element, an object, and its first trustworthy estimate.
fn ready(servo: Config, rate_hz: u16) -> (Machine, Link, Watch) {
    let machine = Machine::boot_paced(servo, SHIFT);
    let link = machine.link();
    let mut watch = Watch::new(&link);
    link.set_settings(&Settings { rate_hz, shape_every: 0, ..Settings::of(MOUNT) }).expect("settings");
    let mut finger = finger();
    finger.how.sampling = Sampling::PerElement(5);
    link.set_finger(0, &finger).expect("a finger");
    link.set_object(0, OBJECT).expect("an object");
    watch.until_report("trustworthy estimate", PATIENCE, |report| report.estimate.age == 0);
    (machine, link, watch)
}

#[test]
fn no_estimate_makes_the_next_tick_late() {
    let (machine, link, mut watch) = ready(Config { noise_ma: 5.0, ..Machine::servo() }, RATE_HZ);

    let late = link.counters().expect("counters").late_ticks;
    let mut estimates: Vec<Report> = Vec::new();
    let mut pass = |watch: &mut Watch, count: usize| {
        let end = estimates.len() + count;
        watch.until_report("estimates", PATIENCE, |report| {
            // A report without an answer of the servo has no estimate.
            if report.estimate.status != Status::Stale {
                estimates.push(*report);
                if estimates.len().is_multiple_of(FAULT_EVERY) {
                    machine.servo.inject([Fault::Drop]);
                }
            }
            estimates.len() >= end
        });
        watch.reports.clear();
    };
    for (speed, ticks) in [(0.35, 350), (1.0, 150)] {
        let all = Which::All;
        // A servo that was lost refuses; it is found again.
        let _ = link.close(all, 11.0 * DEGREE, Some(speed));
        pass(&mut watch, ticks);
        for object in [OTHER, OBJECT] {
            link.set_object(0, object).expect("an object");
            pass(&mut watch, 150);
        }
        let _ = link.grip(&GripTo { fingers: all, force: 5.0, speed: Some(speed), limit: None });
        pass(&mut watch, 150);
        let _ = link.open_fingers(all);
        pass(&mut watch, ticks);
    }

    let late = link.counters().expect("counters").late_ticks - late;
    let costs = || estimates.iter().map(|report| report.cost * PER_TICK);
    let touching = estimates.iter().filter(|report| report.estimate.force != [0.0; 2]).count();
    let sound = estimates.iter().filter(|report| report.estimate.age == 0).count();
    let (most, long) = (costs().max().unwrap_or(0), costs().filter(|&cost| cost > PERIOD).count());
    eprintln!(
        "{} estimates, {touching} in contact, {sound} good: {long} over {PERIOD}, at most {most}; {late} late ticks",
        estimates.len()
    );
    assert!(touching > estimates.len() / 2 && sound > estimates.len() / 2, "{touching} and {sound}");
    // A tick is late that begins more than half a period behind its time.
    assert!(most <= PERIOD + PERIOD / 2, "{most} instructions in a tick of {PERIOD}");
    assert!(long * 100 <= estimates.len() * 3, "{long} of {} estimates took longer than a tick", estimates.len());
}

/// Where an estimate takes longer than what the bus leaves of a period, the next question does not wait for it.
#[test]
fn the_servo_is_asked_while_an_estimate_is_made() {
    let (_machine, link, mut watch) = ready(Machine::servo(), FAST_HZ);
    let (mut long, mut ahead, mut last): (u32, u32, Option<Report>) = (0, 0, None);
    // How many positions come in a motion, and so how far apart they lie, is up to the PC's load.
    for _ in 0..MOTIONS {
        link.close(Which::All, 11.0 * DEGREE, Some(0.35)).expect("a motion");
        watch.until_report("closed finger", PATIENCE, |report| {
            if let Some(last) =
                last.filter(|last| report.sequence == last.sequence + 1 && report.estimate.status != Status::Stale)
            {
                // From one position to the next; a tick of the cost clock is 40 ns.
                let (took_us, apart_us) = (u64::from(last.cost) / 25, report.time_us - last.time_us);
                long += u32::from(took_us > 500);
                ahead += u32::from(took_us > 500 && apart_us < took_us);
            }
            last = Some(*report);
            report.estimate.motor_angle > 10.5 * DEGREE
        });
        if long > ENOUGH {
            break;
        }
        link.open_fingers(Which::All).expect("a motion");
        watch.until_report("open finger", PATIENCE, |report| report.estimate.motor_angle < DEGREE);
        last = None;
    }
    let counters = link.counters().expect("counters");
    eprintln!("{ahead} of {long} long estimates had the next position before their end; {counters:?}");
    assert!(long > ENOUGH, "{long} estimates took more than half a period");
    assert!(ahead > 0);
}
