//! Servos of Protocol 2.0 as data: what distinguishes them for whoever controls them.
//!
//! Numbers, units and addresses are those of ROBOTIS' [e-Manual](https://emanual.robotis.com/docs/en/dxl/). The X series shares its
//! addresses, so that [`crate::xm430`]'s registers are those of all of them; what address 126 shows differs.

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
}

const fn x(number: u16, name: &'static str, effort: Effort) -> Model {
    Model { number, name, layout: Layout::X, counts: 4096, effort }
}

/// Every model that is known.
pub static MODELS: [Model; 8] = [
    x(1020, "XM430-W350", Effort::Current(2.69)),
    x(1030, "XM430-W210", Effort::Current(2.69)),
    x(1060, "XL430-W250", Effort::Load),
    x(1120, "XM540-W270", Effort::Current(2.69)),
    x(1200, "XL330-M288", Effort::Current(1.0)),
    x(1220, "XC330-T288", Effort::Current(1.0)),
    x(1240, "XC330-M288", Effort::Current(1.0)),
    Model { number: 2100, name: "PM42-010-S260-R", layout: Layout::P, counts: 526_374, effort: Effort::Current(1.0) },
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
    /// The model of this number, if it is known.
    pub fn of(number: u16) -> Option<&'static Self> {
        MODELS.iter().find(|model| model.number == number)
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
        assert_eq!(ours.leads(), Some(xm430::MILLIAMPERES_PER_UNIT));
        assert_eq!(ours.counts, u32::from(xm430::COUNTS_PER_REVOLUTION));
        assert_eq!(Model::of(1060).and_then(Model::leads), None, "it shows no current");
        assert_eq!(Model::of(2100).and_then(Model::leads), None, "other addresses");
        assert_eq!(Model::of(12), None);
    }
}
