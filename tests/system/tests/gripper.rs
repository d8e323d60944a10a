//! The firmware in QEMU, led by the host, on the simulated servo.

use std::collections::HashSet;
use std::io::Write;
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

use fre_gripper::link::{Address, Link, LinkError};
use fre_gripper::servo::{Config, Fault};
use messages::{Direction, Event, Mount, Reaction, Refusal, Report, Settings, Side, Which};
use model_core::estimator::Estimator;
use model_core::object::ObjectDesign;
use model_core::real::Real;
use model_core::size::Rubbing;
use model_core::status::Status;
use system_tests::{Machine, OBJECT, Tries, Watch, finger};

const SECONDS: fn(u64) -> Duration = Duration::from_secs;
/// Motor angle at which the finger holds the object firmly.
const CLOSED: f32 = 11.0 * std::f32::consts::PI / 180.0;
/// Ten instructions of 4 ns.
const NS_PER_COST_TICK: f32 = 4.0 * Machine::INSTRUCTIONS_PER_TICK as f32;
/// 20°/s.
const SPEED: f32 = 0.35;
/// The object touches the finger at 0 just so: open is at −1°.
const MOUNT: Mount =
    Mount { open_angle: -std::f32::consts::PI / 180.0, force_limit: 100.0, current_limit: 2000.0, ..Mount::DEFAULT };
const SETTINGS: Settings = Settings::of(MOUNT);

/// A gripper that knows finger and object and whose servo holds.
fn ready(machine: &Machine) -> (Link, Watch) {
    let link = machine.link();
    let mut watch = Watch::new(&link);
    link.set_settings(&SETTINGS).unwrap();
    link.set_finger(0, &finger()).unwrap();
    link.set_object(0, OBJECT).unwrap();
    // The event of a servo that was found before the link was there is lost: a fresh report says as much.
    watch.until_report("trustworthy estimate", SECONDS(20), |report| report.estimate.status.is_trustworthy());
    (link, watch)
}

fn close(link: &Link, watch: &mut Watch) {
    close_at(link, watch, SPEED);
}

/// Closes at a speed, rad/s.
fn close_at(link: &Link, watch: &mut Watch, speed: f32) {
    link.close(Which::All, CLOSED, Some(speed)).unwrap();
    watch.until_report("closed finger", SECONDS(60), |report| {
        report.goal == CLOSED && (report.estimate.motor_angle - CLOSED).abs() < 0.004 && report.estimate.age == 0
    });
}

fn is_fresh(report: &Report) -> bool {
    report.estimate.status != Status::Stale
}

/// The estimates of this precision at the reports' positions, on this PC.
fn replay<T: Real>(reports: &[Report], budget: Option<u32>) -> Vec<model_core::estimator::Estimate> {
    let mut estimator: Box<Estimator<T, Rubbing>> = Box::new(Estimator::EMPTY);
    let finger = finger();
    estimator.configure(&finger.design, &finger.how).unwrap();
    estimator.set_object(OBJECT).unwrap();
    if let Some(budget) = budget {
        estimator.set_budget(budget);
    }
    let angle = |report: &Report| f64::from(report.position - 2048) * std::f64::consts::TAU / 4096.0;
    reports.iter().map(|report| estimator.update(angle(report))).collect()
}

/// The force rises from no contact to firm contact and falls again; every estimate is trustworthy, in its order, equal to
/// what this PC makes of the same positions bit by bit, and close to double precision.
#[test]
fn the_force_rises_and_falls() {
    let machine = Machine::boot(Machine::servo());
    let (link, mut watch) = ready(&machine);
    assert_eq!(watch.reports.last().unwrap().estimate.status, Status::NoContact);
    // So slow that every estimate has the time it needs, also behind an answer that a busy PC has let wait.
    link.set_settings(&Settings { rate_hz: 50, shape_every: 5, ..SETTINGS }).unwrap();
    watch.until_report("a report at the new rate", SECONDS(20), is_fresh);
    let missed_before = link.statistics().missing_reports;
    let mut tries = Tries::of("a closing and opening");
    loop {
        watch.reports.clear();
        watch.shapes.clear();
        close_at(&link, &mut watch, 0.06);
        link.open_fingers(Which::All).unwrap();
        watch.until_report("open finger", SECONDS(60), |report| {
            report.goal == MOUNT.open_angle && report.estimate.status == Status::NoContact
        });
        // An answer that a PC lets wait for almost all of the period leaves the estimate no time: that says nothing of it.
        let is_short = |report: &&Report| matches!(report.estimate.status, Status::MaxIterations | Status::Tracking);
        let short = watch.reports.iter().filter(is_short).count();
        if short == 0 {
            break;
        }
        eprintln!("{short} of {} estimates had no time", watch.reports.len());
        tries.spoilt();
    }

    let reports = &watch.reports;
    for pair in reports.windows(2) {
        assert!(pair[1].sequence > pair[0].sequence && pair[1].time_us > pair[0].time_us, "{pair:?}");
    }
    let fresh: Vec<Report> = reports.iter().copied().filter(is_fresh).collect();
    let force = |report: &Report| report.estimate.force_magnitude();
    let firmest = fresh.iter().max_by(|a, b| force(a).total_cmp(&force(b))).unwrap();
    assert!((13.0..15.0).contains(&force(firmest)), "{firmest:?}");
    assert!(firmest.estimate.torque > 500.0 && firmest.current > 100.0, "{firmest:?}");
    assert_eq!(force(fresh.last().unwrap()), 0.0);
    for report in &fresh {
        assert!(report.estimate.status.is_trustworthy(), "{report:?}");
        assert_eq!(report.estimate.age, 0);
    }
    let counts: HashSet<i32> = fresh.iter().map(|report| report.position).collect();
    assert!(counts.len() > 100, "only {} positions between 0 and 11°", counts.len());

    // What the host missed is what the gripper says it dropped, and here that is nothing.
    let missed = link.statistics().missing_reports;
    assert_eq!(missed, u64::from(link.counters().unwrap().dropped_reports));
    assert_eq!(missed, missed_before, "reports were dropped: the replay below would have gaps");
    for (report, here) in fresh.iter().zip(replay::<f32>(&fresh, None)) {
        assert_eq!(report.estimate, here, "target and PC differ at {report:?}");
    }
    for (report, exact) in fresh.iter().zip(replay::<f64>(&fresh, Some(1000))) {
        let off = [0, 1].map(|i| (report.estimate.force[i] - exact.force[i]).abs());
        assert!(off[0].max(off[1]) <= 2e-3, "single precision is {off:?} N off at {report:?}");
    }

    // The shapes belong to the reports, and show the same force.
    let mut compared = 0;
    for shape in watch.shapes.iter().filter(|shape| shape.status == Status::Converged) {
        let Some(report) = reports.iter().find(|report| report.sequence == shape.sequence) else { continue };
        assert!(shape.front.len() > 20 && shape.back.len() > 20 && shape.lamella_front.len() == 7, "{shape:?}");
        let (mut x, mut y) = (0.0, 0.0);
        shape.contacts.iter().for_each(|contact| (x, y) = (x + contact.force[0], y + contact.force[1]));
        assert!((f32::hypot(x, y) - force(report)).abs() < 1e-3 * (1.0 + force(report)), "{shape:?}");
        compared += 1;
    }
    assert!(compared > 10, "only {compared} shapes in contact");
}

/// What is set can be read back; what is wrong is refused with the reason, and changes nothing but what is said.
#[test]
fn finger_object_and_settings_are_kept() {
    let machine = Machine::boot(Machine::servo());
    let link = machine.link();
    let version = link.version().unwrap();
    assert_eq!((version.protocol, version.board.as_str()), (messages::PROTOCOL_VERSION, "mps2"));
    assert_eq!(link.object(0).unwrap(), None);
    assert_eq!(link.finger(0).unwrap(), None);
    // The servo is read once somebody has said so, but nothing is claimed about a finger that nobody has described.
    assert_eq!(link.settings().unwrap(), Settings::DEFAULT);
    link.set_settings(&SETTINGS).unwrap();
    let mut watch = Watch::new(&link);
    watch.until_report("position without a finger", SECONDS(20), is_fresh);
    let report = watch.reports.last().unwrap();
    assert!(report.estimate.status == Status::OutOfRange && report.estimate.age > 0, "{report:?}");
    assert_eq!((report.estimate.force, report.estimate.torque), ([0.0; 2], 0.0));
    link.set_finger(0, &finger()).unwrap();
    assert_eq!(link.finger(0).unwrap(), Some(finger()));
    link.set_object(0, OBJECT).unwrap();
    assert_eq!(link.object(0).unwrap(), Some(OBJECT.into()));

    let refused = |result: Result<(), LinkError>| match result {
        Err(LinkError::Refused(refusal)) => refusal,
        other => panic!("not refused: {other:?}"),
    };
    for radius in [-1.0, f64::NAN, f64::INFINITY] {
        let why = refused(link.set_object(0, ObjectDesign::Circle { centre: [41.0, 45.0], radius })).to_string();
        assert!(why.contains("radius_mm"), "{why}");
    }
    assert_eq!(link.object(0).unwrap(), Some(OBJECT.into()));
    let mut crooked = finger();
    crooked.design.hinge.thickness = -0.8;
    let why = refused(link.set_finger(0, &crooked)).to_string();
    assert!(why.contains("hinge.thickness_mm") && why.contains("-0.8"), "{why}");
    assert_eq!(link.finger(0).unwrap(), None);
    link.set_finger(0, &finger()).unwrap();

    let settings = Settings {
        shape_every: 0,
        on_fault: Reaction::Release,
        ..Settings::of(Mount { zero: 1900.5, direction: Direction::Reversed, side: Side::Right, ..MOUNT })
    };
    link.set_settings(&settings).unwrap();
    assert_eq!(link.settings().unwrap(), settings);
    let wrong = Settings::of(Mount { speed: f32::NAN, ..MOUNT });
    assert!(matches!(refused(link.set_settings(&wrong)), Refusal::Setting { .. }));
    assert_eq!(link.settings().unwrap(), settings);
    assert!(matches!(refused(link.close(Which::All, 2.0, None)), Refusal::Setting { .. }));
    assert!(matches!(refused(link.close(Which::All, 0.1, Some(-1.0))), Refusal::Setting { .. }));
}

/// A servo that goes silent makes every report stale and older; when it speaks again, the estimate is as before.
#[test]
fn a_silent_servo_makes_stale_estimates() {
    let machine = Machine::boot(Machine::servo());
    let (link, mut watch) = ready(&machine);
    close(&link, &mut watch);
    let before = *watch.reports.last().unwrap();

    machine.servo.silence(SECONDS(3600));
    watch.until_event("loss of the servo", SECONDS(20), |event| {
        *event == Event::ServoLost { finger: 0, other_master: false }
    });
    watch.reports.clear();
    let mut count = 0;
    watch.until_report("reports all the same", SECONDS(30), |_| {
        count += 1;
        count > 100
    });
    let lost = watch.reports.clone();
    for pair in lost.windows(2) {
        assert_eq!(pair[1].estimate.status, Status::Stale);
        let (ages, numbers) = (pair[1].estimate.age - pair[0].estimate.age, pair[1].sequence - pair[0].sequence);
        assert_eq!(ages, numbers, "{pair:?}");
        assert_eq!(pair[1].estimate.force, before.estimate.force);
    }
    assert!(matches!(link.open_fingers(Which::All), Err(LinkError::Refused(Refusal::NoServo))));

    machine.servo.speak();
    watch.until_event("servo", SECONDS(20), |event| matches!(event, Event::ServoReady { .. }));
    watch.until_report("fresh estimate", SECONDS(20), |report| report.estimate.age == 0);
    let after = watch.reports.last().unwrap();
    assert!(after.estimate.status.is_trustworthy());
    let change = after.estimate.force_magnitude() / before.estimate.force_magnitude() - 1.0;
    assert!(change.abs() < 0.05, "{change} of the force after the loss");
    assert!(link.counters().unwrap().servo_losses >= 1);
    link.open_fingers(Which::All).unwrap();
    watch.until_report("open finger", SECONDS(60), |report| {
        report.estimate.status == Status::NoContact && report.goal == MOUNT.open_angle
    });
}

/// A hardware error is told with its bits, and the estimate goes on with the torque off; after a restart, which leaves the
/// torque off too, the servo is set up anew and obeys.
#[test]
fn a_hardware_error_is_told_and_survived() {
    let machine = Machine::boot(Machine::servo());
    let (link, mut watch) = ready(&machine);
    let overload = 0x20;
    machine.servo.fail(overload);
    watch
        .until_event("alert", SECONDS(10), |event| *event == Event::ServoAlert { finger: 0, hardware_error: overload });
    watch.until_report("estimate in spite of the error", SECONDS(10), |report| report.estimate.age == 0);
    // The same for a servo that is found in this state.
    machine.servo.silence(SECONDS(3600));
    watch.until_event("loss of the servo", SECONDS(20), |event| {
        *event == Event::ServoLost { finger: 0, other_master: false }
    });
    machine.servo.speak();
    watch.until_report("estimate of a servo found so", SECONDS(20), |report| report.estimate.age == 0);
    machine.servo.reset();
    watch.until_event("end of the alert", SECONDS(10), |event| {
        *event == Event::ServoAlert { finger: 0, hardware_error: 0 }
    });
    watch.until_event("servo set up anew", SECONDS(20), |event| matches!(event, Event::ServoReady { .. }));
    close(&link, &mut watch);
}

/// Damage on the bus costs the answer it hits (and the silence that the master then waits for), not the servo.
#[test]
fn damage_on_the_bus_costs_one_answer() {
    let machine = Machine::boot(Machine::servo());
    let (link, mut watch) = ready(&machine);
    let before = link.counters().unwrap();
    let damages = [
        Fault::Corrupt { index: 9, mask: 0x10 },
        Fault::Truncate { bytes: 6 },
        Fault::Drop,
        Fault::Corrupt { index: 2, mask: 0xFF },
    ];
    for damage in damages {
        let mut tries = Tries::of("a damaged answer");
        loop {
            let losses = link.counters().unwrap().servo_losses;
            let done = machine.servo.statistics().faults;
            machine.servo.inject([damage.clone()]);
            // A busy PC makes ticks stale as well: what counts is the one after the damage was done.
            let patience = Instant::now() + SECONDS(10);
            while machine.servo.statistics().faults == done {
                assert!(Instant::now() < patience, "{damage:?} was not done");
                std::thread::sleep(Duration::from_micros(200));
            }
            watch.until_report("stale estimate", SECONDS(10), |report| report.estimate.status == Status::Stale);
            watch.until_report("recovery", SECONDS(20), |report| report.estimate.age == 0);
            if link.counters().unwrap().servo_losses == losses {
                break;
            }
            eprintln!("{damage:?}: the servo was lost");
            tries.spoilt();
        }
    }
    // Noise before an answer does not even cost that.
    let noise = [0x55, 0xFF, 0xFF, 0xFD, 0x00, 0x01];
    machine.servo.inject([Fault::Noise(noise.to_vec()), Fault::Noise(vec![0xFF; 20])]);
    watch.pass(Duration::from_millis(300));
    let after = link.counters().unwrap();
    let faults = (after.bus_timeouts + after.bus_damaged) - (before.bus_timeouts + before.bus_damaged);
    assert!(faults >= 4, "{faults} of 4 faults were counted: {after:?}");
    watch.until_report("fresh estimate", SECONDS(10), |report| report.estimate.status.is_trustworthy());
}

/// Noise on the link costs the frame it hits, no more.
#[test]
fn noise_on_the_link_costs_one_frame() {
    let machine = Machine::boot(Machine::servo());
    let link = machine.link();
    let before = link.counters().unwrap();
    let noise: Vec<u8> = (0..5000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    for round in 0..5 {
        // Without zeros: one frame, longer than any; then with: many.
        let without: Vec<u8> = noise.iter().map(|byte| byte | 1).collect();
        link.send_raw(if round % 2 == 0 { &noise } else { &without }).unwrap();
        // The request right behind it gets its answer.
        assert_eq!(link.settings().unwrap(), Settings::DEFAULT);
    }
    let after = link.counters().unwrap();
    assert!(after.link_damaged > before.link_damaged + 5, "{after:?}");
    assert_eq!(after.link_frames - before.link_frames, 6);
    assert_eq!(link.statistics().damaged, 0, "what the gripper sends is sound");
}

/// A host that does not read holds nothing but itself: the control loop goes on, what finds no room is counted.
#[test]
fn a_host_that_does_not_read_holds_nothing() {
    let machine = Machine::boot(Machine::servo());
    let (link, mut watch) = ready(&machine);
    // Slow enough that a busy PC's servo answers in time.
    let hz = 50.0;
    link.set_settings(&Settings { rate_hz: 50, ..SETTINGS }).unwrap();
    watch.until_event("rate", SECONDS(10), |event| *event == Event::Rate { hz, wanted_hz: hz });
    let (mut link, mut watch, mut tries) = (link, watch, Tries::of("a host that does not read"));
    loop {
        let before = link.counters().unwrap();
        drop((link, watch));
        let Address::Unix(path) = machine.address() else { panic!("not a unix socket") };
        // QEMU takes the next party once it has noticed that the last one is gone.
        let deaf = UnixStream::connect(&path).unwrap();
        (&deaf).write_all(&[0]).unwrap();
        std::thread::sleep(SECONDS(6));

        link = Link::over_stream(deaf).unwrap();
        watch = Watch::new(&link);
        let after = link.counters().unwrap();
        let seconds = (after.uptime_us - before.uptime_us) as f32 * 1e-6;
        let ticks = after.ticks - before.ticks;
        let found = ticks as f32 / seconds;
        let made = (after.estimates - before.estimates) as f32 / ticks as f32;
        let dropped = after.dropped_reports - before.dropped_reports;
        eprintln!("{seconds} s, {found} Hz, {made} of the ticks had an estimate, {dropped} of {ticks} reports dropped");
        // The first ones fill the sockets and queues.
        assert!(dropped > ticks / 3, "{dropped} reports dropped in {ticks} ticks");
        if (found / hz - 1.0).abs() < 0.1 && made > 0.9 {
            break;
        }
        tries.spoilt();
    }
    // It goes on as if nothing had been.
    watch.until_report("fresh estimate", SECONDS(10), |report| report.estimate.age == 0);
    watch.until_report("fresh estimate", SECONDS(10), |report| report.estimate.age == 0);
}

/// A rate that two fingers' estimates do not fit: the loop is late, and says so, but never takes the link's time as well.
#[test]
fn a_loop_that_is_late_leaves_the_link_its_time() {
    let machine = Machine::boot_all(vec![Machine::servo(), Config { id: 7, ..Machine::servo() }]);
    let link = machine.link();
    let mut watch = Watch::new(&link);
    let mut settings = Settings { rate_hz: 1_000, shape_every: 0, ..SETTINGS };
    settings.fingers[1] = Some(Mount { servo_id: 7, ..MOUNT });
    link.set_settings(&settings).unwrap();
    for number in 0..2 {
        link.set_finger(number, &finger()).unwrap();
        link.set_object(number, OBJECT).unwrap();
        watch.until_report("position", SECONDS(20), |report| report.finger == number && is_fresh(report));
    }
    watch.reports.clear();
    let before = link.counters().unwrap();
    for round in 0..6 {
        if round % 2 == 0 {
            link.close(Which::All, CLOSED, Some(1.0)).unwrap();
        } else {
            link.open_fingers(Which::All).unwrap();
        }
        for _ in 0..20 {
            assert_eq!(link.settings().unwrap(), settings);
            watch.pass(Duration::from_millis(5));
        }
    }
    let after = link.counters().unwrap();
    let late = after.late_ticks - before.late_ticks;
    // Ticks whose two estimates took more than a period and a half: the next one begins half a period late.
    let most = 1.5e9 / after.chosen_hz / NS_PER_COST_TICK;
    let is_long = |pair: &&[Report]| {
        let [first, second] = [pair[0], pair[1]];
        (first.finger, second.finger, second.sequence - first.sequence) == (0, 1, 1)
            && (first.cost + second.cost) as f32 > most
    };
    let long = watch.reports.windows(2).filter(is_long).count() as u32;
    eprintln!("{} ticks, {long} of them long, {late} late", after.ticks - before.ticks);
    // On a quick PC a period is passed by less than that, tick by tick, until one begins late.
    assert!(late > 20 && 10 * late >= 9 * long, "{long} ticks were long, {late} late: {after:?}");
}

/// At the factory's 57,600 baud the loop is slower, and says so.
#[test]
fn a_slow_bus_lowers_the_rate() {
    let machine = Machine::boot(Config { baud_rate: 57_600, ..Machine::servo() });
    let (link, mut watch) = ready(&machine);
    // Asked for anew, so that the event comes while somebody listens.
    link.set_settings(&Settings { rate_hz: 400, ..SETTINGS }).unwrap();
    watch.until_event(
        "rate",
        SECONDS(10),
        |event| matches!(event, Event::Rate { hz, wanted_hz } if *wanted_hz == 400.0 && (*hz - 84.0).abs() < 1.0),
    );
    let settings = Settings { rate_hz: 50, ..SETTINGS };
    link.set_settings(&settings).unwrap();
    watch.until_event("rate", SECONDS(10), |event| *event == Event::Rate { hz: 50.0, wanted_hz: 50.0 });
}
