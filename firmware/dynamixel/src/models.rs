//! Servos of Protocol 2.0 as data: what distinguishes them for whoever controls them, listens to them or simulates them.
//!
//! Numbers, units and addresses are those of ROBOTIS' [e-Manual](https://emanual.robotis.com/docs/en/dxl/). The X series shares its
//! addresses, so that [`crate::xm430`]'s registers are those of all of them; what address 126 shows differs. The P series has what the
//! X series keeps in RAM 448 bytes further on.

use crate::item::{IndirectArea, Register, Value};
use crate::xm430;

/// What a servo shows of the effort of its motor, at the address after Present PWM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effort {
    /// Present Current, so many mA per unit.
    Current(f32),
    /// Present Load: an estimate from the control's output, 0.1 % per unit. There is no Goal Current either.
    Load,
}

/// Which control table a servo has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// That of the X series: [`crate::xm430`].
    X,
    /// That of the P series: torque and goals from 512 on.
    P,
}

/// The registers by which a listener follows a servo.
#[derive(Clone, Copy, Debug)]
pub struct Followed {
    /// Torque Enable.
    pub torque: Register<u8>,
    /// Status Return Level.
    pub status_return: Register<u8>,
    /// Hardware Error Status.
    pub hardware_error: Register<u8>,
    /// Goal Position.
    pub goal: Register<i32>,
    /// Present Current or Present Load: [`Model::effort`].
    pub effort: Register<i16>,
    /// Present Velocity.
    pub velocity: Register<i32>,
    /// Present Position.
    pub position: Register<i32>,
}

impl Layout {
    /// Where the X series' RAM begins.
    const RAM: u16 = 64;
    /// By how much the P series' is further on.
    const FURTHER: u16 = 448;

    /// A register of [`crate::xm430`] where this table has it.
    pub const fn at<T: Value>(self, register: Register<T>) -> Register<T> {
        let address = register.address();
        match self {
            Self::P if address >= Self::RAM => register.moved(address + Self::FURTHER),
            Self::X | Self::P => register,
        }
    }

    /// Where this table has what a listener follows.
    pub const fn followed(self) -> Followed {
        Followed {
            torque: self.at(xm430::TORQUE_ENABLE),
            status_return: self.at(xm430::STATUS_RETURN_LEVEL),
            hardware_error: self.at(xm430::HARDWARE_ERROR_STATUS),
            goal: self.at(xm430::GOAL_POSITION),
            effort: self.at(xm430::PRESENT_CURRENT),
            velocity: self.at(xm430::PRESENT_VELOCITY),
            position: self.at(xm430::PRESENT_POSITION),
        }
    }

    /// The address that [`crate::xm430`] has for what this table has here; nothing if it has nothing like it.
    pub const fn canonical(self, address: u16) -> Option<u16> {
        match self {
            Self::X => Some(address),
            Self::P if address < Self::RAM => Some(address),
            Self::P if address >= Self::RAM + Self::FURTHER => Some(address - Self::FURTHER),
            Self::P => None,
        }
    }
}

/// A servo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// What Model Number reads.
    pub number: u16,
    /// What it is called.
    pub name: &'static str,
    /// Its control table.
    pub layout: Layout,
    /// Position counts of one revolution.
    pub counts: u32,
    /// Its motor's effort.
    pub effort: Effort,
    /// Revolutions per minute of one unit of velocity.
    pub velocity: f32,
    /// Revolutions per minute squared of one unit of acceleration.
    pub acceleration: f32,
    /// PWM that is the whole voltage.
    pub full_pwm: u16,
    /// Bits per second by the value of Baud Rate.
    pub rates: &'static [u32],
    /// Values of Operating Mode.
    pub modes: &'static [u8],
    /// Its registers that show others.
    pub indirect: &'static [IndirectArea],
    /// First version of its firmware with Fast Sync Read, Fast Bulk Read and Control Table Backup.
    pub fast_since: u8,
}

/// The X330 series has fewer indirect registers, and begins its data where the others still have addresses.
static X330_INDIRECT: [IndirectArea; 1] = [IndirectArea { addresses: 168, data: 208, length: 20 }];
static P_INDIRECT: [IndirectArea; 1] = [IndirectArea { addresses: 168, data: 634, length: 128 }];
static X_RATES: [u32; 8] = xm430::BAUD_RATES;
static X330_RATES: [u32; 7] = [9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000];
static P_RATES: [u32; 10] =
    [9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000, 6_000_000, 10_500_000];

/// Of the X430 and X540 series.
const fn x(number: u16, name: &'static str, effort: Effort) -> Model {
    Model {
        number,
        name,
        layout: Layout::X,
        counts: 4096,
        effort,
        velocity: xm430::REVOLUTIONS_PER_MINUTE_PER_UNIT,
        acceleration: xm430::REVOLUTIONS_PER_MINUTE_SQUARED_PER_UNIT,
        full_pwm: 885,
        rates: &X_RATES,
        modes: match effort {
            Effort::Current(_) => &[0, 1, 3, 4, 5, 16],
            Effort::Load => &[1, 3, 4, 16],
        },
        indirect: &xm430::INDIRECT,
        fast_since: xm430::FAST_READ_FIRMWARE,
    }
}

/// Of the X330 series.
const fn x330(number: u16, name: &'static str) -> Model {
    Model { rates: &X330_RATES, indirect: &X330_INDIRECT, fast_since: 46, ..x(number, name, Effort::Current(1.0)) }
}

/// Every model that is known.
pub static MODELS: [Model; 8] = [
    x(1020, "XM430-W350", Effort::Current(2.69)),
    x(1030, "XM430-W210", Effort::Current(2.69)),
    x(1060, "XL430-W250", Effort::Load),
    x(1120, "XM540-W270", Effort::Current(2.69)),
    x330(1200, "XL330-M288"),
    x330(1220, "XC330-T288"),
    x330(1240, "XC330-M288"),
    Model {
        layout: Layout::P,
        counts: 526_374,
        velocity: 0.01,
        acceleration: 1.0,
        full_pwm: 2009,
        rates: &P_RATES,
        modes: &[0, 1, 3, 4, 16],
        indirect: &P_INDIRECT,
        fast_since: 12,
        ..x(2100, "PM42-010-S260-R", Effort::Current(1.0))
    },
];

impl crate::master::Identity {
    /// Whether this servo is known to understand Fast Sync Read, Fast Bulk Read and Control Table Backup: the X430 and X540 series
    /// from firmware 45 on, the X330 series from 46 on, the P series from 12 on (ROBOTIS e-Manual, Protocol 2.0).
    pub const fn reads_fast(&self) -> bool {
        match self.model {
            // XH430, XM430, XL430, XC430 and XH540, XM540, XW540; the double servos 2XL430 (1090) and 2XC430 (1160) do not.
            1000 | 1010 | 1020 | 1030 | 1040 | 1050 | 1060 | 1070 | 1080 => self.firmware >= xm430::FAST_READ_FIRMWARE,
            1100 | 1110 | 1120 | 1130 | 1140 | 1150 | 1170 | 1180 => self.firmware >= xm430::FAST_READ_FIRMWARE,
            1270 | 1280 => self.firmware >= xm430::FAST_READ_FIRMWARE,
            // XL330 and XC330.
            1190 | 1200 | 1210 | 1220 | 1230 | 1240 => self.firmware >= 46,
            // PM42, PH42, PM54, PH54.
            2000 | 2010 | 2020 | 2100 | 2110 | 2120 => self.firmware >= 12,
            _ => false,
        }
    }
}

impl Model {
    /// The XM430-W350.
    pub const XM430: &'static Self = &MODELS[0];

    /// What a servo counts as that has not sent its model number.
    pub const ASSUMED: &'static Self = Self::XM430;

    /// The model of this number, if it is known.
    pub fn of(number: u16) -> Option<&'static Self> {
        MODELS.iter().find(|model| model.number == number)
    }

    /// The model of this name, if it is known; capitals do not matter.
    pub fn named(name: &str) -> Option<&'static Self> {
        MODELS.iter().find(|model| model.name.eq_ignore_ascii_case(name))
    }

    /// A register of [`crate::xm430`] where this model has it.
    pub const fn at<T: Value>(&self, register: Register<T>) -> Register<T> {
        self.layout.at(register)
    }

    /// Bits per second of a value of Baud Rate.
    pub fn bits_per_second(&self, code: u8) -> Option<u32> {
        self.rates.get(usize::from(code)).copied()
    }

    /// The value of Baud Rate for this many bits per second, or nothing if the servo cannot run at it.
    pub fn baud_code(&self, bits_per_second: u32) -> Option<u8> {
        let code = self.rates.iter().position(|&rate| rate == bits_per_second)?;
        u8::try_from(code).ok()
    }

    /// mA of one unit of current, if this servo shows one.
    pub const fn milliamperes(&self) -> Option<f32> {
        match self.effort {
            Effort::Current(milliamperes) => Some(milliamperes),
            Effort::Load => None,
        }
    }

    /// mA of one unit of current, if this servo can move a finger: positions of the X series, and a current that shows its effort.
    pub fn leads(&self) -> Option<f32> {
        match *self {
            Self { layout: Layout::X, counts: 4096, effort: Effort::Current(milliamperes), .. } => Some(milliamperes),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_in_order_and_the_registers_are_this_crates() {
        assert!(MODELS.windows(2).all(|pair| pair[0].number < pair[1].number));
        let ours = Model::of(xm430::MODEL).unwrap();
        assert_eq!((ours, Model::named("xm430-w350")), (Model::XM430, Some(Model::XM430)));
        assert_eq!(ours.leads(), Some(xm430::MILLIAMPERES_PER_UNIT));
        assert_eq!(ours.counts, u32::from(xm430::COUNTS_PER_REVOLUTION));
        assert_eq!(Model::of(1060).and_then(Model::leads), None, "it shows no current");
        assert_eq!(Model::of(2100).and_then(Model::leads), None, "other addresses");
        assert_eq!(Model::of(12), None);
    }

    #[test]
    fn registers_are_where_the_model_has_them() {
        let p = Model::of(2100).unwrap();
        let addresses = [
            p.at(xm430::TORQUE_ENABLE).address(),
            p.at(xm430::GOAL_POSITION).address(),
            p.at(xm430::PRESENT_CURRENT).address(),
            p.at(xm430::PRESENT_POSITION).address(),
            p.at(xm430::OPERATING_MODE).address(),
        ];
        assert_eq!(addresses, [512, 564, 574, 580, 11]);
        assert_eq!(p.at(xm430::GOAL_POSITION).item.length, 4);
        assert_eq!([580, 11, 300].map(|address| p.layout.canonical(address)), [Some(132), Some(11), None]);
        for model in &MODELS {
            for code in 0..model.rates.len() as u8 {
                assert_eq!(model.bits_per_second(code).and_then(|rate| model.baud_code(rate)), Some(code));
            }
        }
        assert_eq!(Model::of(1200).unwrap().baud_code(4_500_000), None);
    }
}
