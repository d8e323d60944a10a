//! The simulated servo as its master sees it, in memory.

#[path = "servo_registers/modes.rs"]
mod modes;
mod servo_bus;
mod servo_case;

use std::f64::consts::TAU;

use dynamixel::{Answer, Error, StatusError, SyncAnswer, xm430};
use fre_gripper::datasheet::{FREE_SPEED, FRICTION, STALL_TORQUE, TORQUE_CONSTANT};
use fre_gripper::servo::{ACCELERATION_UNIT, BOOT_US, Clock, Config, ConfigError, Fault, Gains, SPEED_UNIT, Servo};
use model_core::status::Status;
use servo_bus::{Bus, id, run};
use servo_case::load;

/// A servo that holds twenty times as firmly as it does from the factory: within a count without load.
fn firm() -> Config {
    Config { gains: Gains { p: 16_383, i: 0, d: 0 }, ..Config::default() }
}

fn requests() -> Config {
    Config { clock: Clock::Requests { period_us: 2000 }, ..firm() }
}

/// Counts within so many of others.
fn near(count: i32, expected: i32, within: i32) {
    assert!((count - expected).abs() <= within, "{count} is not {expected} ± {within}");
}

/// Turns the torque on and sets out; about 16 counts per 2 ms.
fn set_out(bus: &mut Bus, goal: i32) {
    bus.set(xm430::TORQUE_ENABLE, 1);
    bus.set(xm430::PROFILE_VELOCITY, 500);
    bus.set(xm430::GOAL_POSITION, goal);
}

/// Reads until the goal is reached.
fn arrive(bus: &mut Bus) -> i32 {
    for _ in 0..10_000 {
        let position = bus.get(xm430::PRESENT_POSITION);
        if bus.get(xm430::MOVING) == 0 {
            return position;
        }
    }
    panic!("the servo never arrives");
}

#[test]
fn it_says_what_it_is() {
    let mut bus = Bus::new([Config { baud_rate: 1_000_000, return_delay_us: 20, ..Config::default() }]);
    let identity = run(bus.master().ping(id(1))).unwrap();
    assert_eq!((identity.value.model, identity.alert), (1020, false));
    assert_eq!(bus.get(xm430::MODEL_NUMBER), 1020);
    assert_eq!(bus.get(xm430::BAUD_RATE), 3);
    assert_eq!(bus.get(xm430::RETURN_DELAY_TIME), 10);
    assert_eq!(bus.get(xm430::OPERATING_MODE), 3);
    assert_eq!(bus.get(xm430::PRESENT_POSITION), 2048);
    assert_eq!(bus.get(xm430::GOAL_POSITION), 2048);
    assert_eq!(bus.get(xm430::PRESENT_INPUT_VOLTAGE), 120);
    bus.set(xm430::LED, 1);
    assert_eq!(bus.get(xm430::LED), 1);
}

#[test]
fn a_profile_takes_the_analytic_time() {
    let mut bus = Bus::new([firm()]);
    bus.set(xm430::PROFILE_VELOCITY, 100);
    bus.set(xm430::PROFILE_ACCELERATION, 20);
    bus.set(xm430::TORQUE_ENABLE, 1);
    bus.set(xm430::GOAL_POSITION, 2848);
    let (speed, acceleration) = (100.0 * SPEED_UNIT, 20.0 * ACCELERATION_UNIT);
    let duration = 800.0 / speed + speed / acceleration;
    // On the way: in the middle of the time in the middle of the way, at full speed.
    bus.pass((duration * 0.5e6) as u64);
    // Led by its error, it is 4 counts behind.
    near(bus.get(xm430::PRESENT_POSITION), 2444, 1);
    assert_eq!(bus.get(xm430::POSITION_TRAJECTORY), 2448);
    assert_eq!(bus.get(xm430::PRESENT_VELOCITY), 100);
    assert_eq!(bus.get(xm430::MOVING_STATUS), 0x32);
    assert_eq!(bus.get(xm430::VELOCITY_TRAJECTORY), 100);
    bus.pass((duration * 0.5e6) as u64 - 1000);
    assert_eq!(bus.get(xm430::MOVING), 1);
    bus.pass(10_000);
    assert_eq!(bus.get(xm430::MOVING), 0);
    assert_eq!(bus.get(xm430::MOVING_STATUS), 0x01);
    assert_eq!(bus.get(xm430::PRESENT_POSITION), 2848);
    assert_eq!(bus.get(xm430::PRESENT_VELOCITY), 0);
}

#[test]
fn a_step_is_as_fast_as_the_motor() {
    let mut bus = Bus::new([firm()]);
    bus.set(xm430::TORQUE_ENABLE, 1);
    bus.set(xm430::GOAL_POSITION, 3048);
    let duration = 1000.0 / (FREE_SPEED * (1.0 - FRICTION / 4100.0));
    bus.pass((duration * 1e6) as u64 - 2000);
    assert!(bus.get(xm430::PRESENT_POSITION) < 3047);
    assert_eq!(bus.get(xm430::MOVING_STATUS) & 0x08, 0, "close to its goal it follows again");
    bus.pass(20_000);
    assert_eq!(bus.get(xm430::PRESENT_POSITION), 3048);
}

#[test]
fn the_position_is_rounded_to_counts() {
    let mut bus = Bus::new([requests()]);
    set_out(&mut bus, 2400);
    let mut between = 0;
    for _ in 0..30 {
        let shown = bus.get(xm430::PRESENT_POSITION);
        let truth = bus.servo(|servo| servo.truth());
        let exact = 2048.0 + truth.motor_angle / TAU * 4096.0;
        assert_eq!((shown, truth.count), (exact.round() as i32, shown));
        between += usize::from((exact - exact.round()).abs() > 0.1);
    }
    assert!(between > 10, "the truth is not rounded");
}

#[test]
fn the_servo_never_moves_by_itself() {
    let mut bus = Bus::new([firm()]);
    bus.set(xm430::GOAL_POSITION, 3000);
    bus.pass(1_000_000);
    assert_eq!(bus.get(xm430::PRESENT_POSITION), 2048, "the torque is off");
    bus.set(xm430::TORQUE_ENABLE, 1);
    bus.pass(1_000_000);
    assert_eq!(bus.get(xm430::PRESENT_POSITION), 2048, "torque on is no reason to move");
    assert_eq!(bus.get(xm430::GOAL_POSITION), 2048);
    // Unless the drive mode says that a goal turns the torque on.
    bus.set(xm430::TORQUE_ENABLE, 0);
    bus.set(xm430::DRIVE_MODE, 0x08);
    bus.set(xm430::GOAL_POSITION, 2100);
    assert_eq!(bus.get(xm430::TORQUE_ENABLE), 1);
    bus.pass(1_000_000);
    assert_eq!(bus.get(xm430::PRESENT_POSITION), 2100);
}

#[test]
fn what_the_manual_refuses_is_refused() {
    let mut bus = Bus::new([Config::default()]);
    assert_eq!(bus.refusal(xm430::MAX_POSITION_LIMIT, 3000), None);
    assert_eq!(bus.refusal(xm430::MIN_POSITION_LIMIT, 1000), None);
    assert_eq!(bus.refusal(xm430::TORQUE_ENABLE, 1), None);
    for refused in [
        bus.refusal(xm430::MAX_POSITION_LIMIT, 3500),
        bus.refusal(xm430::RETURN_DELAY_TIME, 0),
        bus.refusal(xm430::PRESENT_POSITION, 0),
    ] {
        assert_eq!(refused, Some(StatusError::Access));
    }
    assert_eq!(bus.get(xm430::MAX_POSITION_LIMIT), 3000);
    assert_eq!(bus.refusal(xm430::GOAL_POSITION, 3001), Some(StatusError::DataLimit));
    assert_eq!(bus.refusal(xm430::GOAL_POSITION, 999), Some(StatusError::DataLimit));
    assert_eq!(bus.refusal(xm430::GOAL_POSITION, 2_000_000), Some(StatusError::DataRange));
    assert_eq!(bus.refusal(xm430::TORQUE_ENABLE, 2), Some(StatusError::DataRange));
    assert_eq!(bus.get(xm430::GOAL_POSITION), 2048, "a refused goal changes nothing");
    bus.set(xm430::TORQUE_ENABLE, 0);
    assert_eq!(bus.refusal(xm430::CURRENT_LIMIT, 500), None);
    assert_eq!(bus.refusal(xm430::GOAL_CURRENT, 501), Some(StatusError::DataLimit));
    assert_eq!(bus.refusal(xm430::OPERATING_MODE, 2), Some(StatusError::DataRange), "there is no mode 2");
    // What is not simulated takes its default only.
    assert_eq!(bus.refusal(xm430::FEEDFORWARD_1ST_GAIN, 100), Some(StatusError::DataRange));
    assert_eq!(bus.refusal(xm430::PROTOCOL_TYPE, 1), Some(StatusError::DataRange));
    assert_eq!(bus.refusal(xm430::STARTUP_CONFIGURATION, 4), Some(StatusError::DataRange));
}

#[test]
fn several_servos_are_read_and_written_at_once() {
    let second = Config { id: 2, zero_count: 1000, ..requests() };
    let mut bus = Bus::new([requests(), second]);
    for servo in [1, 2] {
        run(bus.master().write(id(servo), xm430::TORQUE_ENABLE.address(), &[1])).unwrap();
        run(bus.master().write(id(servo), xm430::PROFILE_VELOCITY.address(), &500u32.to_le_bytes())).unwrap();
    }
    let goals = [(id(1), 2100i32.to_le_bytes()), (id(2), 1100i32.to_le_bytes())];
    run(bus.master().sync_write(xm430::GOAL_POSITION.address(), &goals)).unwrap();
    let mut answers = [SyncAnswer::<_, 4>::new(id(2)), SyncAnswer::new(id(1))];
    for _ in 0..50 {
        run(bus.master().sync_read(xm430::PRESENT_POSITION.address(), &mut answers)).unwrap();
    }
    let positions = answers.map(|answer| i32::from_le_bytes(answer.result.unwrap().unwrap().value));
    assert_eq!(positions, [1100, 2100]);
}

#[test]
fn with_the_requests_clock_the_same_questions_get_the_same_bytes() {
    let load = load([41.0, 45.0], 13.0);
    let stream = |seed| {
        let mut bus = Bus::new([Config { load: load.clone(), noise_ma: 5.0, backlash_deg: 0.25, seed, ..requests() }]);
        set_out(&mut bus, 2170);
        for wait in 0..200 {
            // The wall's time does not matter.
            bus.pass(wait * seed);
            run(bus.master().read(id(1), xm430::PRESENT_CURRENT.address(), &mut [0; 10])).unwrap();
        }
        let time_us = bus.servo(|servo| servo.truth().time_us);
        assert_eq!(time_us, 200 * 2000, "one period per read");
        bus.wire.0.borrow().said.clone()
    };
    let first = stream(7);
    assert!(first.len() > 200 * 21);
    assert_eq!(first, stream(7));
    assert_ne!(first, stream(8), "another seed, other noise");
}

#[test]
fn the_current_is_that_of_contact_and_friction() {
    let mut bus = Bus::new([Config { load: load([41.0, 45.0], 13.0), ..requests() }]);
    let units = |torque: f64| (torque / TORQUE_CONSTANT * 1000.0 / 2.69).round() as i16;
    assert_eq!(bus.get(xm430::PRESENT_CURRENT), 0);
    // Without contact: friction only.
    set_out(&mut bus, 2040);
    arrive(&mut bus);
    assert_eq!(bus.get(xm430::PRESENT_CURRENT), units(FRICTION));
    assert_eq!(bus.servo(|servo| servo.truth()).status, Status::NoContact);
    // To 11°, but for what the load holds back; the reference has 3.00 N·m at 11°.
    bus.set(xm430::GOAL_POSITION, 2048 + 130);
    near(arrive(&mut bus), 2173, 1);
    let truth = bus.servo(|servo| servo.truth());
    assert_eq!(truth.status, Status::Converged);
    assert!((truth.torque - 3000.0).abs() < 60.0, "{truth:?}");
    assert!((truth.force[0] - 31.3).abs() < 1.0 && (truth.force[1] + 17.5).abs() < 1.0, "{truth:?}");
    let current = |bus: &mut Bus| i32::from(bus.get(xm430::PRESENT_CURRENT));
    near(current(&mut bus), i32::from(units(truth.torque + FRICTION)), 4);
    // On by a degree and back again: the friction now holds with the motor.
    bus.set(xm430::GOAL_POSITION, 2048 + 141);
    arrive(&mut bus);
    bus.set(xm430::GOAL_POSITION, 2048 + 130);
    arrive(&mut bus);
    let truth = bus.servo(|servo| servo.truth());
    near(current(&mut bus), i32::from(units(truth.torque - FRICTION)), 4);
    // Without torque there is no current, and the finger springs back to where friction holds it.
    bus.set(xm430::TORQUE_ENABLE, 0);
    assert_eq!(bus.get(xm430::PRESENT_CURRENT), 0);
    for _ in 0..2000 {
        bus.get(xm430::PRESENT_POSITION);
    }
    let left = bus.servo(|servo| servo.truth());
    assert!((left.torque - FRICTION).abs() < 15.0, "{left:?}");
}

#[test]
fn the_noise_has_the_spread_asked_for() {
    let mut bus = Bus::new([Config { noise_ma: 40.0, ..requests() }]);
    bus.set(xm430::TORQUE_ENABLE, 1);
    let values: Vec<f64> = (0..4000).map(|_| f64::from(bus.get(xm430::PRESENT_CURRENT)) * 2.69).collect();
    let mean = values.iter().sum::<f64>() / 4000.0;
    let spread = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 4000.0).sqrt();
    assert!(mean.abs() < 2.5 && (spread - 40.0).abs() < 2.0, "{mean} {spread}");
}

#[test]
fn the_finger_lags_by_half_the_play() {
    let half = 0.25f64.to_radians() / 2.0;
    let mut bus = Bus::new([Config { load: load([41.0, 45.0], 13.0), backlash_deg: 0.25, ..requests() }]);
    let lag = |bus: &Bus| {
        let truth = bus.servo(|servo| servo.truth());
        (truth.motor_angle - truth.finger_angle, truth)
    };
    let is = |(lag, _), expected: f64| {
        let lag: f64 = lag;
        assert!((lag - expected).abs() < 1e-9, "{lag} is not {expected}");
    };
    is(lag(&bus), 0.0);
    set_out(&mut bus, 2040);
    arrive(&mut bus);
    is(lag(&bus), half);
    bus.set(xm430::GOAL_POSITION, 2030);
    arrive(&mut bus);
    is(lag(&bus), -half);
    // In contact the object keeps it on the open side, whichever way the motor came.
    bus.set(xm430::GOAL_POSITION, 2140);
    arrive(&mut bus);
    is(lag(&bus), half);
    bus.set(xm430::GOAL_POSITION, 2100);
    arrive(&mut bus);
    is(lag(&bus), half);
    let (_, truth) = lag(&bus);
    let load = bus.servo(|servo| servo.load().clone());
    let there = load.at(truth.finger_angle, &mut Default::default());
    assert_eq!((truth.torque, truth.force), (there.torque, there.force), "the force is the finger's, not the motor's");
}

#[test]
fn counts_can_fall_as_the_finger_closes() {
    let mut bus =
        Bus::new([Config { load: load([41.0, 45.0], 13.0), closing_up: false, backlash_deg: 0.25, ..requests() }]);
    set_out(&mut bus, 2048 - 100);
    let there = arrive(&mut bus);
    near(there, 1948, 5);
    let truth = bus.servo(|servo| servo.truth());
    assert!((truth.motor_angle - f64::from(2048 - there) / 4096.0 * TAU).abs() < 0.5 / 4096.0 * TAU);
    assert!((truth.motor_angle - truth.finger_angle - 0.125f64.to_radians()).abs() < 1e-9);
    assert!(truth.torque > 500.0 && bus.get(xm430::PRESENT_CURRENT) < -100);
}

#[test]
fn a_current_limit_stops_the_finger() {
    let mut bus = Bus::new([Config { load: load([41.0, 45.0], 13.0), ..requests() }]);
    bus.set(xm430::OPERATING_MODE, 5);
    bus.set(xm430::GOAL_CURRENT, 372);
    set_out(&mut bus, 2048 + 125);
    for _ in 0..400 {
        bus.get(xm430::PRESENT_POSITION);
    }
    // 372 units are 1.0 A.
    let truth = bus.servo(|servo| servo.truth());
    assert!((truth.torque + FRICTION - TORQUE_CONSTANT).abs() < 120.0, "{truth:?}");
    assert_eq!(bus.get(xm430::MOVING_STATUS) & 0x09, 0x08, "it neither arrives nor follows");
    // A motor whose current is limited holds so for ever. One whose voltage does not suffice for more than a second is overloaded, which
    // turns the torque off.
    for _ in 0..1000 {
        bus.get(xm430::PRESENT_POSITION);
    }
    assert_eq!(bus.get(xm430::HARDWARE_ERROR_STATUS), 0);
    bus.set(xm430::GOAL_PWM, 150);
    for _ in 0..1000 {
        bus.get(xm430::PRESENT_POSITION);
    }
    let errors = bus.try_get(xm430::HARDWARE_ERROR_STATUS).unwrap();
    assert_eq!(errors, Answer { value: 0x20, alert: true });
    assert_eq!(bus.get(xm430::TORQUE_ENABLE), 0);
    assert_eq!(bus.refusal(xm430::TORQUE_ENABLE, 1), Some(StatusError::ResultFail));
    bus.reboot();
    assert_eq!(bus.refusal(xm430::TORQUE_ENABLE, 1), None);
    assert_eq!(bus.get(xm430::OPERATING_MODE), 5, "the EEPROM survives");
    assert_eq!(bus.get(xm430::PROFILE_VELOCITY), 0, "the RAM does not");
}

#[test]
fn the_watchdog_stops_a_servo_that_nobody_talks_to() {
    let mut bus = Bus::new([firm()]);
    bus.set(xm430::BUS_WATCHDOG, 5);
    bus.set(xm430::TORQUE_ENABLE, 1);
    bus.set(xm430::PROFILE_VELOCITY, 20);
    bus.set(xm430::GOAL_POSITION, 3000);
    bus.pass(99_000);
    assert_eq!(bus.get(xm430::MOVING), 1);
    bus.pass(500_000);
    // 99 ms and 100 ms more at 20 units.
    near(bus.get(xm430::PRESENT_POSITION), 2048 + (0.199 * 20.0 * SPEED_UNIT).round() as i32, 2);
    assert_eq!((bus.get(xm430::BUS_WATCHDOG), bus.get(xm430::MOVING)), (-1, 0));
    assert_eq!(bus.refusal(xm430::GOAL_POSITION, 3000), Some(StatusError::DataRange));
    bus.set(xm430::BUS_WATCHDOG, 0);
    assert_eq!(bus.refusal(xm430::GOAL_POSITION, 3000), None);
}

#[test]
fn a_finger_that_snaps_does_not_come_back_the_same_way() {
    let load = load([41.0, 60.0], 19.0);
    assert_eq!(load.branch_count(), 2);
    let mut bus = Bus::new([Config { load, ..requests() }]);
    set_out(&mut bus, 2048 + 114);
    arrive(&mut bus);
    let closing = bus.servo(|servo| servo.truth());
    assert_eq!(closing.status, Status::Converged);
    bus.set(xm430::GOAL_POSITION, 2048 + 212);
    arrive(&mut bus);
    assert_eq!(bus.servo(|servo| servo.truth()).status, Status::Snapped);
    bus.set(xm430::GOAL_POSITION, 2048 + 114);
    arrive(&mut bus);
    let opening = bus.servo(|servo| servo.truth());
    assert_eq!(opening.status, Status::Snapped);
    assert!(closing.torque - opening.torque > 500.0, "{closing:?} {opening:?}");
    bus.set(xm430::GOAL_POSITION, 2048);
    arrive(&mut bus);
    bus.set(xm430::GOAL_POSITION, 2048 + 114);
    arrive(&mut bus);
    let again = bus.servo(|servo| servo.truth()).torque;
    assert!((again - closing.torque).abs() < 20.0, "an open hand is a new beginning: {again} {closing:?}");
}

/// As it comes from the factory: 6.25 units of PWM per count, 29 N·mm. It holds by its error, and lets go what its goal loses.
#[test]
fn the_factorys_control_holds_by_its_error() {
    let per_count = STALL_TORQUE * 800.0 / 128.0 / 885.0;
    let mut bus = Bus::new([Config { load: load([41.0, 45.0], 13.0), gains: Config::default().gains, ..requests() }]);
    set_out(&mut bus, 2048 + 100);
    for _ in 0..2000 {
        bus.get(xm430::PRESENT_POSITION);
    }
    let held = bus.servo(|servo| servo.truth());
    let error = f64::from(2048 + 100) - (2048.0 + held.motor_angle / TAU * 4096.0);
    let carried = error * per_count;
    assert!(held.torque > 300.0 && error > 20.0, "{held:?}");
    assert!((carried - held.torque).abs() <= FRICTION + 1.0, "{carried} N·mm for {} N·mm", held.torque);
    near(i32::from(bus.get(xm430::PRESENT_PWM)), (error * 6.25) as i32, 2);
    // A goal where the servo is takes the torque away, and with it the object.
    let position = bus.get(xm430::PRESENT_POSITION);
    bus.set(xm430::GOAL_POSITION, position);
    for _ in 0..2000 {
        bus.get(xm430::PRESENT_POSITION);
    }
    let left = bus.servo(|servo| servo.truth());
    assert!(left.torque < 0.9 * held.torque, "{} N·mm left of {}", left.torque, held.torque);
    // An integral gain takes the error away.
    bus.set(xm430::POSITION_I_GAIN, 200);
    bus.set(xm430::GOAL_POSITION, 2048 + 100);
    for _ in 0..5000 {
        bus.get(xm430::PRESENT_POSITION);
    }
    near(bus.get(xm430::PRESENT_POSITION), 2148, 3);
}

#[test]
fn a_reversed_servo_counts_the_other_way_round() {
    let mut bus = Bus::new([Config { start_deg: Some(10.0), ..firm() }]);
    let before = bus.get(xm430::PRESENT_POSITION);
    bus.set(xm430::DRIVE_MODE, 1);
    assert_eq!(bus.get(xm430::PRESENT_POSITION), 4096 - before);
    bus.set(xm430::TORQUE_ENABLE, 1);
    bus.set(xm430::GOAL_POSITION, 4096 - before + 50);
    bus.pass(500_000);
    near(bus.get(xm430::PRESENT_POSITION), 4096 - before + 50, 1);
    assert!(bus.servo(|servo| servo.truth()).motor_angle < 10f64.to_radians(), "it opened");
}

/// It answers the instruction, and then nothing until it has booted; the same when its power comes back.
#[test]
fn it_boots_for_a_while() {
    let mut bus = Bus::new([firm()]);
    bus.pass(1_000);
    run(bus.master().reboot(id(1))).unwrap();
    for _ in 0..2 {
        assert!(matches!(bus.try_get(xm430::ID), Err(Error::Timeout { .. })));
        bus.pass(BOOT_US - 1);
        assert!(matches!(bus.try_get(xm430::ID), Err(Error::Timeout { .. })));
        bus.pass(1);
        assert_eq!(bus.get(xm430::ID), 1);
        bus.servo(Servo::reset);
    }
}

#[test]
fn torque_may_come_with_the_power() {
    let mut bus = Bus::new([firm()]);
    bus.set(xm430::STARTUP_CONFIGURATION, 1);
    assert_eq!(bus.get(xm430::TORQUE_ENABLE), 0);
    bus.reboot();
    assert_eq!(bus.get(xm430::TORQUE_ENABLE), 1);
}

#[test]
fn heat_and_a_poor_supply_show_and_shut_down() {
    let mut bus = Bus::new([Config { load: load([41.0, 45.0], 13.0), ..firm() }]);
    assert_eq!((bus.get(xm430::PRESENT_TEMPERATURE), bus.get(xm430::PRESENT_INPUT_VOLTAGE)), (32, 120));
    set_out(&mut bus, 2048 + 130);
    bus.pass(10_000_000);
    let warm = bus.get(xm430::PRESENT_TEMPERATURE);
    bus.pass(60_000_000);
    assert!(warm > 32 && bus.get(xm430::PRESENT_TEMPERATURE) > warm + 5, "{warm}");
    bus.servo(|servo| servo.surround(Some(9.0), None));
    bus.pass(1000);
    assert_eq!(bus.try_get(xm430::HARDWARE_ERROR_STATUS).unwrap(), Answer { value: 1, alert: true });
    assert_eq!(bus.get(xm430::TORQUE_ENABLE), 1, "Shutdown leaves the voltage out from the factory");
    bus.servo(|servo| servo.surround(Some(12.0), Some(81.0)));
    bus.pass(1000);
    assert_eq!(bus.try_get(xm430::HARDWARE_ERROR_STATUS).unwrap(), Answer { value: 5, alert: true });
    assert_eq!(bus.get(xm430::TORQUE_ENABLE), 0);
}

#[test]
fn faults_do_what_they_say() {
    let mut bus = Bus::new([Config::default()]);
    let position = bus.get(xm430::PRESENT_POSITION);
    bus.servo(|servo| {
        servo.inject([
            Fault::Drop,
            Fault::Corrupt { index: 9, mask: 0x10 },
            Fault::None,
            Fault::Truncate { bytes: 8 },
            Fault::Noise(vec![0xFF, 0xFF, 0xFD, 0x12]),
        ]);
    });
    assert!(matches!(bus.try_get(xm430::PRESENT_POSITION), Err(Error::Timeout { .. })));
    assert!(matches!(bus.try_get(xm430::PRESENT_POSITION), Err(Error::Damaged(_))));
    assert_eq!(bus.get(xm430::PRESENT_POSITION), position);
    assert!(matches!(bus.try_get(xm430::PRESENT_POSITION), Err(Error::Truncated { received: 8, .. })));
    assert_eq!(bus.get(xm430::PRESENT_POSITION), position, "noise before an answer does no harm");
    assert_eq!(bus.servo(|servo| servo.statistics().faults), 4);
    // Silence.
    bus.servo(|servo| servo.silence(u64::MAX));
    assert!(matches!(bus.try_get(xm430::PRESENT_POSITION), Err(Error::Timeout { .. })));
    bus.servo(|servo| servo.silence(0));
    assert_eq!(bus.get(xm430::PRESENT_POSITION), position);
    // A hardware error that shuts down, and power that goes and comes.
    bus.set(xm430::TORQUE_ENABLE, 1);
    bus.servo(|servo| servo.fail(0x04));
    assert_eq!(bus.try_get(xm430::TORQUE_ENABLE).unwrap(), Answer { value: 0, alert: true });
    bus.servo(Servo::reset);
    bus.pass(BOOT_US);
    assert_eq!(bus.try_get(xm430::HARDWARE_ERROR_STATUS).unwrap(), Answer { value: 0, alert: false });
}

#[test]
fn answers_take_the_time_of_delay_and_wire() {
    let delay = |config: Config| {
        let mut servo = Servo::new(config).unwrap();
        let mut buffer = [0; 32];
        let ping = dynamixel::encode(&mut buffer, id(1), dynamixel::Instruction::Ping, &[]).unwrap();
        servo.hear(0, ping)[0].delay_us
    };
    assert_eq!(delay(Config::default()), 500);
    assert_eq!(delay(Config { return_delay_us: 0, ..Config::default() }), 0);
    // 10 bytes there and 14 back, 10 bits each.
    let wire = Config { wire_time: true, baud_rate: 57_600, ..Config::default() };
    assert_eq!(delay(wire), 500 + (24.0 * 10.0 / 57_600.0 * 1e6) as u32);
    assert_eq!(delay(requests()), 0);
}

#[test]
fn no_servo_is_made_from_nonsense() {
    let refused = |config: Config| Servo::new(config).err().map(|error| error.to_string()).unwrap_or_default();
    let said = [
        Config { id: 253, ..Config::default() },
        Config { baud_rate: 9601, ..Config::default() },
        Config { return_delay_us: 7, ..Config::default() },
        Config { clock: Clock::Requests { period_us: 0 }, ..Config::default() },
        Config { backlash_deg: f64::NAN, ..Config::default() },
        Config { noise_ma: -1.0, ..Config::default() },
        Config { start_deg: Some(181.0), ..Config::default() },
    ]
    .map(refused);
    snapbox::assert_data_eq!(
        said.join("\n"),
        snapbox::str![[r#"
the address is 253; allowed is 0 to 252
the baud rate is 9601; the XM430-W350 knows 9600, 57600, 115200, 1000000, 2000000, 3000000, 4000000, 4500000
the return delay is 7 µs; allowed are even numbers from 0 to 508
the period of the requests is 0 µs; allowed is 1 to 1000000
the backlash is NaN °; allowed is 0 to 5
the noise is -1 mA; allowed is 0 to 1000
the angle at power-on is 181 °; allowed is -180 to 180
"#]]
    );
    assert_eq!(
        Servo::new(Config { zero_count: 4096, ..Config::default() }).err(),
        Some(ConfigError::Zero { count: 4096, most: 4095 })
    );
}
