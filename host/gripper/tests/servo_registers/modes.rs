//! The simulated servo's Operating Modes: what each does, and what a change of them resets.

use dynamixel::xm430;
use fre_gripper::datasheet::{FREE_SPEED, FRICTION, STALL_TORQUE};
use fre_gripper::servo::SPEED_UNIT;

use super::servo_bus::Bus;
use super::{firm, near};

#[test]
fn every_mode_does_what_it_says() {
    let mode = |bus: &mut Bus, mode: u8| {
        bus.set(xm430::TORQUE_ENABLE, 0);
        bus.set(xm430::OPERATING_MODE, mode);
        bus.set(xm430::TORQUE_ENABLE, 1);
        bus.pass(100_000);
    };
    let mut bus = Bus::new([firm()]);
    // Velocity: it turns on and on.
    mode(&mut bus, 1);
    assert_eq!(bus.get(xm430::PRESENT_VELOCITY), 0);
    bus.set(xm430::GOAL_VELOCITY, 100);
    bus.pass(3_000_000);
    near(bus.get(xm430::PRESENT_VELOCITY), 100, 1);
    assert!(bus.get(xm430::PRESENT_POSITION) > 4096, "more than a revolution");
    // PWM: half of the voltage, less what the friction takes.
    mode(&mut bus, 16);
    bus.set(xm430::GOAL_PWM, -442);
    bus.pass(500_000);
    let speed = FREE_SPEED * (442.0 / 885.0 - FRICTION / STALL_TORQUE) / SPEED_UNIT;
    near(bus.get(xm430::PRESENT_VELOCITY), -speed.round() as i32, 1);
    // Current: less than the friction does nothing, more turns it as fast as the voltage allows.
    mode(&mut bus, 0);
    bus.set(xm430::GOAL_CURRENT, 40);
    bus.pass(500_000);
    assert_eq!(bus.get(xm430::PRESENT_VELOCITY), 0);
    assert_eq!(bus.get(xm430::PRESENT_CURRENT), 40);
    bus.set(xm430::GOAL_CURRENT, 60);
    bus.pass(500_000);
    assert!(bus.get(xm430::PRESENT_VELOCITY) > 150);
    // Several turns.
    mode(&mut bus, 4);
    bus.set(xm430::GOAL_POSITION, 9000);
    bus.pass(5_000_000);
    near(bus.get(xm430::PRESENT_POSITION), 9000, 1);
}

/// The e-Manual's notes on Operating Mode and Present Position: what a change of the mode resets, and when turns are dropped.
#[test]
fn a_change_of_mode_resets_control_and_turns() {
    let mut bus = Bus::new([firm()]);
    bus.set(xm430::OPERATING_MODE, 4);
    bus.set(xm430::TORQUE_ENABLE, 1);
    bus.set(xm430::GOAL_POSITION, 9000);
    bus.pass(5_000_000);
    let gone = |bus: &mut Bus| {
        bus.set(xm430::TORQUE_ENABLE, 0);
        bus.set(xm430::POSITION_P_GAIN, 300);
        bus.set(xm430::VELOCITY_I_GAIN, 5);
        bus.set(xm430::PROFILE_VELOCITY, 70);
        bus.set(xm430::PROFILE_ACCELERATION, 7);
        bus.set(xm430::GOAL_PWM, 100);
        bus.set(xm430::GOAL_CURRENT, 10);
    };
    let control = |bus: &mut Bus| {
        let gains = [bus.get(xm430::POSITION_P_GAIN), bus.get(xm430::VELOCITY_I_GAIN)];
        let profile = [bus.get(xm430::PROFILE_VELOCITY), bus.get(xm430::PROFILE_ACCELERATION)];
        (gains, profile, [bus.get(xm430::GOAL_PWM), bus.get(xm430::GOAL_CURRENT)])
    };
    gone(&mut bus);
    // Setting the mode that it has changes nothing.
    bus.set(xm430::OPERATING_MODE, 4);
    assert_eq!(control(&mut bus), ([300, 5], [70, 7], [100, 10]));
    bus.set(xm430::OPERATING_MODE, 5);
    let reset = ([16_383, 1920], [0, 0], [885, 1193]);
    assert_eq!(control(&mut bus), reset);
    near(bus.get(xm430::PRESENT_POSITION), 9000, 1);
    gone(&mut bus);
    bus.set(xm430::OPERATING_MODE, 3);
    assert_eq!(control(&mut bus), reset);
    near(bus.get(xm430::PRESENT_POSITION), 9000 - 8192, 1);
    assert_eq!(bus.get(xm430::GOAL_POSITION), bus.get(xm430::PRESENT_POSITION));
}

/// Reboot, power, and torque in position control drop the turns, whichever way the servo counts.
#[test]
fn turns_are_dropped_at_power_on_and_with_torque() {
    for (drive, to) in [(0, 9000), (1, -5000)] {
        let mut bus = Bus::new([firm()]);
        bus.set(xm430::DRIVE_MODE, drive);
        bus.set(xm430::HOMING_OFFSET, 100);
        bus.set(xm430::OPERATING_MODE, 4);
        bus.set(xm430::TORQUE_ENABLE, 1);
        bus.set(xm430::GOAL_POSITION, to);
        bus.pass(8_000_000);
        near(bus.get(xm430::PRESENT_POSITION), to, 1);
        bus.reboot();
        let within = (to - 100).rem_euclid(4096) + 100;
        near(bus.get(xm430::PRESENT_POSITION), within, 1);
        let goal = bus.get(xm430::GOAL_POSITION);
        near(goal, within, 1);
        // It goes on from there, and stays where it is when the torque comes.
        bus.set(xm430::TORQUE_ENABLE, 1);
        bus.set(xm430::GOAL_POSITION, goal + 10);
        bus.pass(1_000_000);
        near(bus.get(xm430::PRESENT_POSITION), goal + 10, 1);
    }
    let mut bus = Bus::new([firm()]);
    bus.set(xm430::OPERATING_MODE, 16);
    bus.set(xm430::TORQUE_ENABLE, 1);
    bus.set(xm430::GOAL_PWM, 400);
    bus.pass(3_000_000);
    assert!(bus.get(xm430::PRESENT_POSITION) > 4096);
    bus.set(xm430::TORQUE_ENABLE, 0);
    bus.set(xm430::OPERATING_MODE, 3);
    let position = bus.get(xm430::PRESENT_POSITION);
    assert!((0..4096).contains(&position), "{position}");
    bus.set(xm430::TORQUE_ENABLE, 1);
    bus.pass(1_000_000);
    near(bus.get(xm430::PRESENT_POSITION), position, 1);
}
