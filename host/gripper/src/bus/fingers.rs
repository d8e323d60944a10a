//! One finger on the bus: its servo, its estimator, its last report.

use dynamixel::{Id, Model, xm430};
use messages::{Calibration, Mount, Phase, Refusal, Report};
use model_core::estimator::Estimate;
use model_core::status::Status;
use model_core::uncertainty::Uncertainty;
use std::time::Instant;

use crate::estimator::AnyEstimator;

/// First of the registers read in every tick: Goal Position to Present Position.
pub(super) const FIRST: u16 = xm430::GOAL_POSITION.address();
/// Bytes of those registers.
pub(super) const BYTES: usize = 20;
/// Ticks without an answer after which a servo counts as lost.
const PATIENCE: u8 = 5;

/// What a servo says of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reading {
    goal: i32,
    current: f32,
    position: i32,
    pub(super) alert: bool,
}

impl Reading {
    /// Of these registers; a servo shows its current, or its load, in a unit of its own.
    pub(super) fn new(bytes: &[u8; BYTES], alert: bool, model: &Model) -> Self {
        let [g0, g1, g2, g3, _, _, _, _, _, _, c0, c1, _, _, _, _, p0, p1, p2, p3] = *bytes;
        Self {
            goal: i32::from_le_bytes([g0, g1, g2, g3]),
            current: f32::from(i16::from_le_bytes([c0, c1])) * model.effort_milliamperes(),
            position: i32::from_le_bytes([p0, p1, p2, p3]),
            alert,
        }
    }
}

/// A finger.
pub(super) struct Finger {
    pub(super) mount: Mount,
    calibration: Calibration,
    /// What a calibration has left uncertain.
    uncertainty: Option<Uncertainty>,
    pub(super) estimator: Box<dyn AnyEstimator>,
    /// What its servo is.
    pub(super) model: &'static Model,
    pub(super) last: Report,
    /// When the last position came, µs.
    heard_us: Option<u64>,
    /// Ticks without an answer, up to a few.
    failures: u8,
    pub(super) alert: bool,
}

impl Finger {
    /// With an estimator that has its design and object.
    pub(super) fn new(
        number: u8,
        mount: Mount,
        estimator: Box<dyn AnyEstimator>,
        uncertainty: Option<Uncertainty>,
    ) -> Result<Self, Refusal> {
        let last = Report { phase: Phase::Moving, ..Report::blank(number) };
        let calibration = Calibration::new(&mount.gear());
        let mut made = Self {
            mount,
            calibration,
            uncertainty,
            estimator,
            model: Model::ASSUMED,
            last,
            heard_us: None,
            failures: 0,
            alert: false,
        };
        made.set_mount(mount)?;
        Ok(made)
    }

    /// Another servo, zero, direction, gear or drive.
    pub(super) fn set_mount(&mut self, mount: Mount) -> Result<(), Refusal> {
        let calibration = Calibration::new(&mount.gear());
        let uncertainty = mount.uncertainty(self.uncertainty);
        self.estimator.set_uncertainty(uncertainty).map_err(|error| Refusal::Uncertainty(Refusal::text(&error)))?;
        self.estimator.set_drive(mount.drive).map_err(|error| Refusal::Drive(Refusal::text(&error)))?;
        (self.mount, self.calibration) = (mount, calibration);
        Ok(())
    }

    /// Its servo's address; settings that were validated have one.
    pub(super) fn id(&self) -> Id {
        Id::new(self.mount.servo_id).unwrap_or(Id::BROADCAST)
    }

    pub(super) fn is_present(&self) -> bool {
        self.failures < PATIENCE
    }

    /// A position came; whether the servo had been lost.
    pub(super) fn fresh(&mut self, reading: &Reading, start: Instant) -> bool {
        let was_lost = !self.is_present();
        self.failures = 0;
        if was_lost {
            // Which way it has come meanwhile, nobody knows.
            self.estimator.forget_path();
        }
        let time_us = start.elapsed().as_micros() as u64;
        let seconds = 1e-6 * (time_us - self.heard_us.replace(time_us).unwrap_or(time_us)) as f64;
        let began = Instant::now();
        let estimate = self.estimator.update_after(self.calibration.finger_angle(reading.position), seconds);
        let cost = u32::try_from(began.elapsed().as_micros()).unwrap_or(u32::MAX);
        // The age counts every tick since the last trustworthy estimate, those without a position too.
        let age = if estimate.age == 0 { 0 } else { self.last.estimate.age.saturating_add(1) };
        self.last = Report {
            time_us,
            estimate: Estimate { age, ..estimate },
            goal: self.calibration.angle(reading.goal) as f32,
            position: reading.position,
            current: reading.current,
            cost,
            ..self.last
        };
        was_lost
    }

    /// No position came: the old numbers, marked as such. Whether the servo is lost from now on.
    pub(super) fn stale(&mut self, start: Instant) -> bool {
        let was_present = self.is_present();
        self.failures = (self.failures + 1).min(PATIENCE);
        let estimate = &mut self.last.estimate;
        estimate.status = Status::Stale;
        estimate.age = estimate.age.saturating_add(1);
        estimate.iterations = 0;
        (self.last.time_us, self.last.cost) = (start.elapsed().as_micros() as u64, 0);
        was_present && !self.is_present()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_are_where_they_are_read() {
        let mut bytes = [0; BYTES];
        let mut put = |address: u16, value: &[u8]| {
            let at = usize::from(address - FIRST);
            bytes[at..at + value.len()].copy_from_slice(value);
        };
        put(xm430::GOAL_POSITION.address(), &2100_i32.to_le_bytes());
        put(xm430::PRESENT_CURRENT.address(), &(-10_i16).to_le_bytes());
        put(xm430::PRESENT_POSITION.address(), &(-3_i32).to_le_bytes());
        // 2.69 mA; 1 mA; a thousandth of 1.4 A at stall.
        for (name, current) in [("XM430-W350", -26.9), ("XL330-M288", -10.0), ("XL430-W250", -14.0)] {
            let reading = Reading::new(&bytes, true, Model::named(name).unwrap());
            assert_eq!((reading.goal, reading.position, reading.alert), (2100, -3, true));
            assert!((reading.current - current).abs() < 1e-4, "{name}: {reading:?}");
        }
    }
}
