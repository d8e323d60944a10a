//! Between the servo's counts and the motor angle.

use core::f64::consts::TAU;

use model_core::uncertainty::Uncertainty;

use crate::{Direction, Mount};

/// Counts of a servo of the X series per revolution.
const COUNTS_PER_REVOLUTION: f64 = 4096.0;

/// Linear relation of counts and angle: angle = (counts − zero) · 2π / 4096 / gear ratio, reversed if so mounted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    zero: f64,
    counts_per_radian: f64,
    play: f64,
}

impl Calibration {
    /// The relation that a valid mount describes.
    pub fn new(mount: &Mount) -> Self {
        let sign = match mount.direction {
            Direction::Same => 1.0,
            Direction::Reversed => -1.0,
        };
        Self {
            zero: f64::from(mount.zero),
            counts_per_radian: sign * f64::from(mount.gear_ratio) * COUNTS_PER_REVOLUTION / TAU,
            play: f64::from(mount.backlash),
        }
    }

    /// One count as a motor angle, rad.
    pub fn count(&self) -> f64 {
        (if self.counts_per_radian < 0.0 { -1.0 } else { 1.0 }) / self.counts_per_radian
    }

    /// Motor angle at a position of the servo, rad.
    pub fn angle(&self, position: i32) -> f64 {
        (f64::from(position) - self.zero) / self.counts_per_radian
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

    /// How uncertain the finger's angle and parameters are, from what a calibration has left uncertain, or by default. A count of the
    /// servo is what it is through this finger's gear.
    pub fn uncertainty(&self, left: Option<Uncertainty>) -> Uncertainty {
        Uncertainty { quantisation: self.count().abs() as f32, ..left.unwrap_or(Uncertainty::DEFAULT) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MIDDLE: Mount = Mount::DEFAULT;

    #[test]
    fn a_quarter_turn_is_1024_counts() {
        let calibration = Calibration::new(&MIDDLE);
        assert_eq!(calibration.position(0.0), 2048);
        assert_eq!(calibration.position(TAU / 4.0), 3072);
        assert!((calibration.angle(1024) + TAU / 4.0).abs() < 1e-15);
    }

    #[test]
    fn direction_and_gear_ratio_count() {
        let mount = Mount { direction: Direction::Reversed, gear_ratio: 2.5, zero: 100.5, ..MIDDLE };
        let calibration = Calibration::new(&mount);
        // A tenth of the finger's turn is a quarter of the servo's.
        assert_eq!(calibration.position(TAU / 10.0), 100 - 1024);
        assert!((calibration.angle(100) - 0.5 / (2.5 * 4096.0) * TAU).abs() < 1e-15);
    }

    #[test]
    fn counts_come_back() {
        for direction in [Direction::Same, Direction::Reversed] {
            for gear_ratio in [0.01, 1.0, 3.7, 100.0] {
                let calibration = Calibration::new(&Mount { direction, gear_ratio, zero: -17.25, ..MIDDLE });
                for position in [-1_044_479, -4096, -1, 0, 1, 2048, 4095, 1_044_479] {
                    assert_eq!(calibration.position(calibration.angle(position)), position);
                }
            }
        }
    }

    #[test]
    fn a_gear_makes_counts_finer() {
        let through = |gear_ratio| Calibration::new(&Mount { gear_ratio, direction: Direction::Reversed, ..MIDDLE });
        assert_eq!(through(1.0).uncertainty(None), Uncertainty::DEFAULT);
        let given = Uncertainty { youngs_modulus: 0.01, ..Uncertainty::NONE };
        let found = through(4.0).uncertainty(Some(given));
        assert_eq!(found, Uncertainty { quantisation: Uncertainty::DEFAULT.quantisation / 4.0, ..given });
    }

    #[test]
    fn absurd_angles_do_not_wrap() {
        let calibration = Calibration::new(&MIDDLE);
        assert_eq!(calibration.position(1e30), i32::MAX);
        assert_eq!(calibration.position(-1e30), i32::MIN);
    }
}
