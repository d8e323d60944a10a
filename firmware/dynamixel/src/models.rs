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

/// A servo's motor with its gears, by ROBOTIS' specifications.
///
/// Of the XM430-W350 its performance graph is used: 1.79 N·m/A behind a dead zone of 0.23 N·m, which is the friction of its gears. Of the
/// others stall torque and current; that their friction is the same part of the stall torque is an assumption.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// Torque at the horn over current, N·mm/mA.
    pub torque_constant: f32,
    /// Friction, N·mm.
    pub friction: f32,
    /// Current at stall, mA.
    pub stall_current: f32,
}

impl Motor {
    /// Of the XM430-W350: its performance graph is a line through (600 mA, 840 N·mm) and (1500 mA, 2450 N·mm).
    const XM430: Self = {
        let torque_constant = (2450.0 - 840.0) / (1500.0 - 600.0);
        Self { torque_constant, friction: torque_constant * 600.0 - 840.0, stall_current: 2300.0 }
    };

    /// Stall torque, N·mm, and current, mA.
    const fn of_stall(torque: f32, current: f32) -> Self {
        // The XM430-W350's stall torque is 4100 N·mm.
        Self {
            torque_constant: torque / current,
            friction: torque * Self::XM430.friction / 4100.0,
            stall_current: current,
        }
    }
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
    /// Its motor.
    pub motor: Motor,
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
const fn x(number: u16, name: &'static str, effort: Effort, motor: Motor) -> Model {
    Model {
        number,
        name,
        layout: Layout::X,
        counts: 4096,
        effort,
        motor,
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
const fn x330(number: u16, name: &'static str, motor: Motor) -> Model {
    let like = x(number, name, Effort::Current(1.0), motor);
    Model { rates: &X330_RATES, indirect: &X330_INDIRECT, fast_since: 46, ..like }
}

/// Every model that is known.
pub static MODELS: [Model; 8] = [
    x(1020, "XM430-W350", Effort::Current(2.69), Motor::XM430),
    x(1030, "XM430-W210", Effort::Current(2.69), Motor::of_stall(3_000.0, 2_300.0)),
    x(1060, "XL430-W250", Effort::Load, Motor::of_stall(1_500.0, 1_400.0)),
    x(1120, "XM540-W270", Effort::Current(2.69), Motor::of_stall(10_600.0, 4_400.0)),
    x330(1200, "XL330-M288", Motor::of_stall(520.0, 1_470.0)),
    x330(1220, "XC330-T288", Motor::of_stall(1_000.0, 880.0)),
    x330(1240, "XC330-M288", Motor::of_stall(930.0, 1_800.0)),
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
        // No stall torque is given: that of its Current Limit, by the ratio of its continuous torque (1.7 N·m) and current (0.6 A).
        ..x(2100, "PM42-010-S260-R", Effort::Current(1.0), Motor::of_stall(1_461.0 * 1_700.0 / 600.0, 1_461.0))
    },
];

/// Other servos of Protocol 2.0, by name only.
static OTHERS: [(u16, &str); 27] = [
    (30, "MX-28"),
    (311, "MX-64"),
    (321, "MX-106"),
    (350, "XL-320"),
    (1000, "XH430-W350"),
    (1010, "XH430-W210"),
    (1040, "XH430-V350"),
    (1050, "XH430-V210"),
    (1070, "XC430-W150"),
    (1080, "XC430-W240"),
    (1090, "2XL430-W250"),
    (1100, "XH540-W270"),
    (1110, "XH540-W150"),
    (1130, "XM540-W150"),
    (1140, "XH540-V270"),
    (1150, "XH540-V150"),
    (1160, "2XC430-W250"),
    (1170, "XW540-T260"),
    (1180, "XW540-T140"),
    (1190, "XL330-M077"),
    (1210, "XC330-T181"),
    (1230, "XC330-M181"),
    (1270, "XW430-T333"),
    (1280, "XW430-T200"),
    (2000, "PH42-020-S300"),
    (2010, "PH54-100-S500"),
    (2020, "PH54-200-S500"),
];

/// What the servo of this model number is called, if that is known; it need not be one of [`MODELS`].
pub fn name_of(number: u16) -> Option<&'static str> {
    let known = Model::of(number).map(|model| model.name);
    known.or_else(|| OTHERS.iter().find(|other| other.0 == number).map(|other| other.1))
}

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

    /// mA of one unit of what is at Present Current's address. A load counts as that part of the current at stall: an estimate, which the
    /// servo makes from its output.
    pub const fn effort_milliamperes(&self) -> f32 {
        match self.effort {
            Effort::Current(milliamperes) => milliamperes,
            Effort::Load => self.motor.stall_current / 1000.0,
        }
    }

    /// Whether it has current-based position control: positions with no more than Goal Current.
    pub fn limits_current(&self) -> bool {
        self.modes.contains(&xm430::CURRENT_BASED_POSITION_CONTROL)
    }

    /// A position in counts of the X series, 4096 per revolution; the nearest one.
    pub fn to_4096ths(&self, position: i32) -> i32 {
        scaled(position, u32::from(xm430::COUNTS_PER_REVOLUTION), self.counts)
    }

    /// The position of counts of the X series.
    pub fn from_4096ths(&self, counts: i32) -> i32 {
        scaled(counts, self.counts, u32::from(xm430::COUNTS_PER_REVOLUTION))
    }
}

/// A number times a ratio, rounded to the nearest one, half away from zero.
fn scaled(number: i32, times: u32, over: u32) -> i32 {
    if times == over {
        return number;
    }
    // A model's revolution has more counts than none.
    let (product, over) = (i64::from(number) * i64::from(times), i64::from(over.max(1)));
    let half = if product < 0 { -over / 2 } else { over / 2 };
    let nearest = (product + half).checked_div(over).unwrap_or(0);
    i32::try_from(nearest).unwrap_or(if nearest < 0 { i32::MIN } else { i32::MAX })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_in_order_and_the_registers_are_this_crates() {
        assert!(MODELS.windows(2).all(|pair| pair[0].number < pair[1].number));
        let ours = Model::of(xm430::MODEL).unwrap();
        assert_eq!((ours, Model::named("xm430-w350")), (Model::XM430, Some(Model::XM430)));
        assert_eq!(ours.effort_milliamperes(), xm430::MILLIAMPERES_PER_UNIT);
        assert_eq!(ours.counts, u32::from(xm430::COUNTS_PER_REVOLUTION));
        assert_eq!(Model::of(1060).map(Model::effort_milliamperes), Some(1.4), "a thousandth of its current at stall");
        assert_eq!(Model::of(12), None);
        assert!(OTHERS.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert!(OTHERS.iter().all(|(number, _)| Model::of(*number).is_none()));
        assert_eq!([1060, 1130, 12].map(name_of), [Some("XL430-W250"), Some("XM540-W150"), None]);
        let fenced: std::vec::Vec<_> =
            MODELS.iter().filter(|model| model.limits_current()).map(|model| model.number).collect();
        assert_eq!(fenced, [1020, 1030, 1120, 1200, 1220, 1240]);
    }

    #[test]
    fn positions_of_every_model_are_4096ths() {
        for model in &MODELS {
            let quarter = (model.counts / 4) as i32;
            assert!((model.to_4096ths(quarter) - 1024).abs() <= 1, "{}", model.name);
            for counts in [-1_048_575, -2048, -1, 0, 1, 7, 2047, 4095, 1_048_575] {
                assert_eq!(model.to_4096ths(model.from_4096ths(counts)), counts, "{}", model.name);
            }
        }
        let p = Model::of(2100).unwrap();
        assert_eq!([-65, -64, 0, 64, 65].map(|position| p.to_4096ths(position)), [-1, 0, 0, 0, 1]);
        assert_eq!((p.from_4096ths(i32::MAX), p.from_4096ths(1)), (i32::MAX, 129));
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
