//! Control table of the XM430-W350 (T and R), from ROBOTIS'
//! [e-Manual](https://emanual.robotis.com/docs/en/dxl/x/xm430-w350/).
//!
//! Indirect addresses and data (168 and up) are not among the items; [`INDIRECT`] says where they are.

use crate::item::{Area, IndirectArea, Item, Register};

use Area::{Eeprom, Ram};

/// What [`MODEL_NUMBER`] reads on this servo.
pub const MODEL: u16 = 1020;
/// Position counts of one revolution.
pub const COUNTS_PER_REVOLUTION: u16 = 4096;
/// Milliamperes of one unit of current.
pub const MILLIAMPERES_PER_UNIT: f32 = 2.69;
/// Revolutions per minute of one unit of velocity.
pub const REVOLUTIONS_PER_MINUTE_PER_UNIT: f32 = 0.229;
/// Revolutions per minute squared of one unit of acceleration.
pub const REVOLUTIONS_PER_MINUTE_SQUARED_PER_UNIT: f32 = 214.577;
/// Volts of one unit of voltage.
pub const VOLTS_PER_UNIT: f32 = 0.1;
/// Microseconds of one unit of [`RETURN_DELAY_TIME`].
pub const RETURN_DELAY_US_PER_UNIT: u32 = 2;
/// Value of [`OPERATING_MODE`] for position control within one revolution.
pub const POSITION_CONTROL: u8 = 3;
/// Value of [`OPERATING_MODE`] for position control with no more than [`GOAL_CURRENT`]; positions may be of several revolutions.
pub const CURRENT_BASED_POSITION_CONTROL: u8 = 5;

/// First version of the firmware of the X430 and X540 servos that knows Fast Sync Read and Fast Bulk Read.
pub const FAST_READ_FIRMWARE: u8 = 45;

/// Bits per second by the value of [`BAUD_RATE`].
pub const BAUD_RATES: [u32; 8] = [9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000];

/// Bits per second of a value of [`BAUD_RATE`], or nothing above 7.
pub fn bits_per_second(code: u8) -> Option<u32> {
    BAUD_RATES.get(usize::from(code)).copied()
}

/// The value of [`BAUD_RATE`] for this many bits per second, or nothing if the servo cannot run at it.
pub fn baud_code(bits_per_second: u32) -> Option<u8> {
    BAUD_RATES.iter().position(|&rate| rate == bits_per_second).map(|code| code as u8)
}

/// Which model: 1020.
pub const MODEL_NUMBER: Register<u16> = Register::read(0, false, Eeprom, MODEL as i64);
/// More about the model; the manual gives no meaning.
pub const MODEL_INFORMATION: Register<u32> = Register::read(2, false, Eeprom, 0);
/// Version of the servo's firmware.
pub const FIRMWARE_VERSION: Register<u8> = Register::read(6, false, Eeprom, 0);
/// Address on the bus.
pub const ID: Register<u8> = Register::write(7, false, Eeprom, 1, 0, 252);
/// Speed of the bus, as a code: [`bits_per_second`].
pub const BAUD_RATE: Register<u8> = Register::write(8, false, Eeprom, 1, 0, 7);
/// Time between an instruction's end and the answer, 2 µs.
pub const RETURN_DELAY_TIME: Register<u8> = Register::write(9, false, Eeprom, 250, 0, 254);
/// Bit 0 reverses the direction, bit 2 makes profiles time-based, bit 3 turns the torque on with a goal.
pub const DRIVE_MODE: Register<u8> = Register::write(10, false, Eeprom, 0, 0, 13);
/// 0 current, 1 velocity, 3 position, 4 extended position, 5 current-based position, 16 PWM.
pub const OPERATING_MODE: Register<u8> = Register::write(11, false, Eeprom, 3, 0, 16);
/// A second address, to which the servo listens without answering; 253 and up: none.
pub const SECONDARY_ID: Register<u8> = Register::write(12, false, Eeprom, 255, 0, 255);
/// Protocol of the bus.
pub const PROTOCOL_TYPE: Register<u8> = Register::write(13, false, Eeprom, 2, 1, 22);
/// Added to the measured position, counts.
pub const HOMING_OFFSET: Register<i32> = Register::write(20, true, Eeprom, 0, -1_044_479, 1_044_479);
/// Speed above which [`MOVING`] is 1, 0.229 rev/min.
pub const MOVING_THRESHOLD: Register<u32> = Register::write(24, false, Eeprom, 10, 0, 1023);
/// Temperature at which the servo shuts down, °C.
pub const TEMPERATURE_LIMIT: Register<u8> = Register::write(31, false, Eeprom, 80, 0, 100);
/// Greatest input voltage, 0.1 V.
pub const MAX_VOLTAGE_LIMIT: Register<u16> = Register::write(32, false, Eeprom, 160, 95, 160);
/// Least input voltage, 0.1 V.
pub const MIN_VOLTAGE_LIMIT: Register<u16> = Register::write(34, false, Eeprom, 95, 95, 160);
/// Greatest PWM, 0.113 %.
pub const PWM_LIMIT: Register<u16> = Register::write(36, false, Eeprom, 885, 0, 885);
/// Greatest current, 2.69 mA.
pub const CURRENT_LIMIT: Register<u16> = Register::write(38, false, Eeprom, 1193, 0, 1193);
/// Greatest speed, 0.229 rev/min. The default is the present manual's; earlier editions say 350.
pub const VELOCITY_LIMIT: Register<u32> = Register::write(44, false, Eeprom, 200, 0, 1023);
/// Greatest goal position, counts.
pub const MAX_POSITION_LIMIT: Register<u32> = Register::write(48, false, Eeprom, 4095, 0, 4095);
/// Least goal position, counts.
pub const MIN_POSITION_LIMIT: Register<u32> = Register::write(52, false, Eeprom, 0, 0, 4095);
/// Bit 0: the torque is on after power-on; bit 1: the RAM is restored from its backup.
pub const STARTUP_CONFIGURATION: Register<u8> = Register::write(60, false, Eeprom, 0, 0, 3);
/// Which hardware errors turn the torque off, one bit each as in [`HARDWARE_ERROR_STATUS`].
pub const SHUTDOWN: Register<u8> = Register::write(63, false, Eeprom, 52, 0, 63);

/// 1 while the motor holds and follows its goal; locks the EEPROM area.
pub const TORQUE_ENABLE: Register<u8> = Register::write(64, false, Ram, 0, 0, 1);
/// The servo's light.
pub const LED: Register<u8> = Register::write(65, false, Ram, 0, 0, 1);
/// Which instructions are answered: 0 Ping, 1 and reading ones, 2 all ([`crate::StatusReturn`]).
pub const STATUS_RETURN_LEVEL: Register<u8> = Register::write(68, false, Ram, 2, 0, 2);
/// 1 while a Reg Write waits for its Action.
pub const REGISTERED_INSTRUCTION: Register<u8> = Register::read(69, false, Ram, 0);
/// Bit 0 input voltage, 2 overheating, 3 encoder, 4 electrical shock, 5 overload.
pub const HARDWARE_ERROR_STATUS: Register<u8> = Register::read(70, false, Ram, 0);
/// Integral gain of the velocity loop.
pub const VELOCITY_I_GAIN: Register<u16> = Register::write(76, false, Ram, 1920, 0, 16_383);
/// Proportional gain of the velocity loop.
pub const VELOCITY_P_GAIN: Register<u16> = Register::write(78, false, Ram, 100, 0, 16_383);
/// Derivative gain of the position loop.
pub const POSITION_D_GAIN: Register<u16> = Register::write(80, false, Ram, 0, 0, 16_383);
/// Integral gain of the position loop.
pub const POSITION_I_GAIN: Register<u16> = Register::write(82, false, Ram, 0, 0, 16_383);
/// Proportional gain of the position loop.
pub const POSITION_P_GAIN: Register<u16> = Register::write(84, false, Ram, 800, 0, 16_383);
/// Gain of the acceleration feed-forward.
pub const FEEDFORWARD_2ND_GAIN: Register<u16> = Register::write(88, false, Ram, 0, 0, 16_383);
/// Gain of the velocity feed-forward.
pub const FEEDFORWARD_1ST_GAIN: Register<u16> = Register::write(90, false, Ram, 0, 0, 16_383);
/// Silence after which the servo stops, 20 ms; 0 off. Reads -1 once it has stopped so.
pub const BUS_WATCHDOG: Register<i8> = Register::write(98, true, Ram, 0, 0, 127);
/// Goal PWM, 0.113 %; limited by [`PWM_LIMIT`].
pub const GOAL_PWM: Register<i16> = Register::write(100, true, Ram, 0, -885, 885);
/// Goal current, 2.69 mA; limited by [`CURRENT_LIMIT`].
pub const GOAL_CURRENT: Register<i16> = Register::write(102, true, Ram, 0, -1193, 1193);
/// Goal velocity, 0.229 rev/min; limited by [`VELOCITY_LIMIT`].
pub const GOAL_VELOCITY: Register<i32> = Register::write(104, true, Ram, 0, -1023, 1023);
/// Acceleration of the position profile, 214.577 rev/min²; 0: unlimited.
pub const PROFILE_ACCELERATION: Register<u32> = Register::write(108, false, Ram, 0, 0, 32_767);
/// Greatest speed of the position profile, 0.229 rev/min; 0: unlimited.
pub const PROFILE_VELOCITY: Register<u32> = Register::write(112, false, Ram, 0, 0, 32_767);
/// Goal position, counts; in position control between the two position limits.
pub const GOAL_POSITION: Register<i32> = Register::write(116, true, Ram, 0, -1_048_575, 1_048_575);
/// The servo's clock, ms; wraps after 32767.
pub const REALTIME_TICK: Register<u16> = Register::read(120, false, Ram, 0);
/// 1 while the servo moves faster than [`MOVING_THRESHOLD`].
pub const MOVING: Register<u8> = Register::read(122, false, Ram, 0);
/// Bit 0 goal reached, 1 profile running, 3 following error; bits 4 and 5 the kind of profile.
pub const MOVING_STATUS: Register<u8> = Register::read(123, false, Ram, 0);
/// PWM at present, 0.113 %.
pub const PRESENT_PWM: Register<i16> = Register::read(124, true, Ram, 0);
/// Current at present, 2.69 mA; positive drives towards greater positions.
pub const PRESENT_CURRENT: Register<i16> = Register::read(126, true, Ram, 0);
/// Speed at present, 0.229 rev/min; positive towards greater positions.
pub const PRESENT_VELOCITY: Register<i32> = Register::read(128, true, Ram, 0);
/// Position at present, 4096 counts per revolution; counter-clockwise increases it, seen from the horn.
pub const PRESENT_POSITION: Register<i32> = Register::read(132, true, Ram, 0);
/// Speed that the profile asks for at present, 0.229 rev/min.
pub const VELOCITY_TRAJECTORY: Register<i32> = Register::read(136, true, Ram, 0);
/// Position that the profile asks for at present, counts.
pub const POSITION_TRAJECTORY: Register<i32> = Register::read(140, true, Ram, 0);
/// Input voltage at present, 0.1 V.
pub const PRESENT_INPUT_VOLTAGE: Register<u16> = Register::read(144, false, Ram, 0);
/// Temperature inside at present, °C.
pub const PRESENT_TEMPERATURE: Register<u8> = Register::read(146, false, Ram, 0);
/// 1 once Control Table Backup has stored a copy.
pub const BACKUP_READY: Register<u8> = Register::read(147, false, Ram, 0);

/// Indirect 1 to 28 and 29 to 56. Addresses return to the factory's at power-on.
pub const INDIRECT: [IndirectArea; 2] =
    [IndirectArea { addresses: 168, data: 224, length: 28 }, IndirectArea { addresses: 578, data: 634, length: 28 }];

/// Every item above, in the order of the addresses.
pub static ITEMS: [Item; 53] = [
    MODEL_NUMBER.item,
    MODEL_INFORMATION.item,
    FIRMWARE_VERSION.item,
    ID.item,
    BAUD_RATE.item,
    RETURN_DELAY_TIME.item,
    DRIVE_MODE.item,
    OPERATING_MODE.item,
    SECONDARY_ID.item,
    PROTOCOL_TYPE.item,
    HOMING_OFFSET.item,
    MOVING_THRESHOLD.item,
    TEMPERATURE_LIMIT.item,
    MAX_VOLTAGE_LIMIT.item,
    MIN_VOLTAGE_LIMIT.item,
    PWM_LIMIT.item,
    CURRENT_LIMIT.item,
    VELOCITY_LIMIT.item,
    MAX_POSITION_LIMIT.item,
    MIN_POSITION_LIMIT.item,
    STARTUP_CONFIGURATION.item,
    SHUTDOWN.item,
    TORQUE_ENABLE.item,
    LED.item,
    STATUS_RETURN_LEVEL.item,
    REGISTERED_INSTRUCTION.item,
    HARDWARE_ERROR_STATUS.item,
    VELOCITY_I_GAIN.item,
    VELOCITY_P_GAIN.item,
    POSITION_D_GAIN.item,
    POSITION_I_GAIN.item,
    POSITION_P_GAIN.item,
    FEEDFORWARD_2ND_GAIN.item,
    FEEDFORWARD_1ST_GAIN.item,
    BUS_WATCHDOG.item,
    GOAL_PWM.item,
    GOAL_CURRENT.item,
    GOAL_VELOCITY.item,
    PROFILE_ACCELERATION.item,
    PROFILE_VELOCITY.item,
    GOAL_POSITION.item,
    REALTIME_TICK.item,
    MOVING.item,
    MOVING_STATUS.item,
    PRESENT_PWM.item,
    PRESENT_CURRENT.item,
    PRESENT_VELOCITY.item,
    PRESENT_POSITION.item,
    VELOCITY_TRAJECTORY.item,
    POSITION_TRAJECTORY.item,
    PRESENT_INPUT_VOLTAGE.item,
    PRESENT_TEMPERATURE.item,
    BACKUP_READY.item,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_in_order_and_do_not_overlap() {
        for pair in ITEMS.windows(2) {
            assert!(pair[0].end() <= pair[1].address, "{pair:?}");
        }
    }

    #[test]
    fn defaults_lie_in_their_ranges() {
        for item in ITEMS {
            assert!(item.min <= item.default && item.default <= item.max, "{item:?}");
            assert!(matches!(item.length, 1 | 2 | 4), "{item:?}");
        }
    }

    #[test]
    fn baud_codes_go_both_ways() {
        for code in 0..8 {
            assert_eq!(bits_per_second(code).and_then(baud_code), Some(code));
        }
        assert_eq!(bits_per_second(8), None);
        assert_eq!(baud_code(500_000), None);
    }
}
