//! Between the servo's counts and the motor angle.

use core::f64::consts::TAU;

/// How a servo moves a finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gear {
    /// The servo's counts per revolution of its own, positive: 4096 of the Dynamixel X series.
    pub resolution: f32,
    /// The servo's position at motor angle 0, counts.
    pub zero: f32,
    /// Counts fall as the finger closes.
    pub reversed: bool,
    /// Revolutions of the servo per revolution of the finger, positive.
    pub ratio: f32,
    /// Play between the servo's position sensor and the finger, rad of the motor angle.
    pub backlash: f32,
}

impl Gear {
    /// A finger on the shaft of a servo of the X series, angle 0 in the middle of its revolution, without play.
    pub const DIRECT: Self = Self { resolution: 4096.0, zero: 2048.0, reversed: false, ratio: 1.0, backlash: 0.0 };
}

/// Linear relation of counts and angle: angle = (counts − zero) · 2π / resolution / gear ratio, reversed if so mounted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    zero: f64,
    counts_per_radian: f64,
    /// The same the other way round: to multiply is a third of a division where double precision is made of instructions.
    radians_per_count: f64,
    play: f64,
}

impl Calibration {
    /// The relation of a gear with positive resolution and ratio.
    pub fn new(gear: &Gear) -> Self {
        let sign = if gear.reversed { -1.0 } else { 1.0 };
        let counts_per_radian = sign * f64::from(gear.ratio) * f64::from(gear.resolution) / TAU;
        Self {
            zero: f64::from(gear.zero),
            counts_per_radian,
            radians_per_count: 1.0 / counts_per_radian,
            play: f64::from(gear.backlash),
        }
    }

    /// One count as a motor angle, rad.
    pub fn count(&self) -> f64 {
        self.radians_per_count.abs()
    }

    /// Motor angle at a position of the servo, rad.
    pub fn angle(&self, position: i32) -> f64 {
        (f64::from(position) - self.zero) * self.radians_per_count
    }

    /// Angle of the finger itself, rad, which an estimate is for: a finger that touches is pushed to the open side of its play.
    pub fn finger_angle(&self, position: i32) -> f64 {
        self.angle(position) - 0.5 * self.play
    }

    /// The servo's position nearest to a motor angle (rad), counts.
    pub fn position(&self, angle: f64) -> i32 {
        let counts = self.zero + angle * self.counts_per_radian;
        // Half away from zero; casts saturate.
        (if counts < 0.0 { counts - 0.5 } else { counts + 0.5 }) as i32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MIDDLE: Gear = Gear::DIRECT;

    #[test]
    fn a_quarter_turn_is_1024_counts() {
        let calibration = Calibration::new(&MIDDLE);
        assert_eq!(calibration.position(0.0), 2048);
        assert_eq!(calibration.position(TAU / 4.0), 3072);
        assert!((calibration.angle(1024) + TAU / 4.0).abs() < 1e-15);
    }

    #[test]
    fn direction_and_gear_ratio_count() {
        let gear = Gear { reversed: true, ratio: 2.5, zero: 100.5, ..MIDDLE };
        let calibration = Calibration::new(&gear);
        // A tenth of the finger's turn is a quarter of the servo's.
        assert_eq!(calibration.position(TAU / 10.0), 100 - 1024);
        assert!((calibration.angle(100) - 0.5 / (2.5 * 4096.0) * TAU).abs() < 1e-15);
    }

    #[test]
    fn counts_come_back() {
        for reversed in [false, true] {
            for ratio in [0.01, 1.0, 3.7, 100.0] {
                let calibration = Calibration::new(&Gear { reversed, ratio, zero: -17.25, ..MIDDLE });
                for position in [-1_044_479, -4096, -1, 0, 1, 2048, 4095, 1_044_479] {
                    assert_eq!(calibration.position(calibration.angle(position)), position);
                }
            }
        }
    }

    #[test]
    fn absurd_angles_do_not_wrap() {
        let calibration = Calibration::new(&MIDDLE);
        assert_eq!(calibration.position(1e30), i32::MAX);
        assert_eq!(calibration.position(-1e30), i32::MIN);
    }
}
