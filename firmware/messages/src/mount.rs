//! A finger's mount as its state machines and its model take it.

use grip::{Gear, Limits};
use model_core::grasp::Pull;
use model_core::uncertainty::Uncertainty;

use crate::{Calibration, CarryTo, Direction, Gravity, GripTo, Mount, Settings};

/// Counts of a servo of the X series per revolution.
const COUNTS_PER_REVOLUTION: f32 = 4096.0;

impl Mount {
    /// How the servo moves the finger.
    pub fn gear(&self) -> Gear {
        Gear {
            resolution: COUNTS_PER_REVOLUTION,
            zero: self.zero,
            reversed: self.direction == Direction::Reversed,
            ratio: self.gear_ratio,
            backlash: self.backlash,
        }
    }

    /// Whether a finger moves, and is estimated, with this mount as with another one: they differ in limits only, or in what its servo was
    /// commissioned with.
    // Its code is in the image once.
    #[inline(never)]
    pub fn moves_like(&self, other: &Self) -> bool {
        let Self { range, open_angle, speed, force_limit, current_limit, servo, calibration, .. } = *other;
        Self { range, open_angle, speed, force_limit, current_limit, servo, calibration, ..*self } == *other
    }

    /// The motor angles of the servo's first and last count within its revolution, the smaller one first, rad.
    pub(crate) fn revolution(&self) -> [f32; 2] {
        let gear = Calibration::new(&self.gear());
        let [one, other] = [0, COUNTS_PER_REVOLUTION as i32 - 1].map(|position| gear.angle(position) as f32);
        [one.min(other), one.max(other)]
    }

    /// What no motion of the finger exceeds.
    pub fn limits(&self) -> Limits {
        Limits {
            range: self.range,
            open_angle: self.open_angle,
            speed: self.speed,
            force: self.force_limit,
            current: self.current_limit,
        }
    }

    /// How uncertain the finger's angle and parameters are, from what a calibration has left uncertain, or by default. A count of the
    /// servo is what it is through this finger's gear.
    pub fn uncertainty(&self, left: Option<Uncertainty>) -> Uncertainty {
        let count = Calibration::new(&self.gear()).count().abs();
        Uncertainty { quantisation: count as f32, ..left.unwrap_or(Uncertainty::DEFAULT) }
    }
}

impl Settings {
    /// What a finger does when its force cannot be trusted.
    pub fn faults(&self) -> grip::Faults {
        grip::Faults {
            reaction: self.on_fault,
            untrusted_s: 1e-3 * f64::from(self.untrusted_ms),
            strain: self.on_strain,
        }
    }

    /// How far from where its servo shuts down a finger is warned.
    pub fn margins(&self) -> grip::Margins {
        grip::Margins { heat: f64::from(self.heat_margin), supply: f64::from(self.supply_margin) }
    }
}

impl CarryTo {
    /// What each finger is asked for first, at this force, N.
    pub fn target(&self, force: f64) -> grip::Target {
        grip::Target { force: force as f32, speed: self.speed, limit: self.limit }
    }

    /// The load of 1 N in the weight's direction.
    pub fn pull(&self) -> Pull {
        match self.gravity {
            Gravity::Along(angle) => {
                let (sin, cos) = libm::sincos(f64::from(angle));
                Pull { force: [cos, sin], ..Pull::default() }
            }
            Gravity::Across => Pull { across: 1.0, ..Pull::default() },
        }
    }
}

impl GripTo {
    /// What each of its fingers is asked for.
    pub fn target(&self) -> grip::Target {
        grip::Target { force: self.force, speed: self.speed, limit: self.limit }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gear_makes_counts_finer() {
        let through = |gear_ratio| Mount { gear_ratio, direction: Direction::Reversed, ..Mount::DEFAULT };
        assert_eq!(through(1.0).uncertainty(None), Uncertainty::DEFAULT);
        let given = Uncertainty { youngs_modulus: 0.01, ..Uncertainty::NONE };
        let found = through(4.0).uncertainty(Some(given));
        assert_eq!(found, Uncertainty { quantisation: Uncertainty::DEFAULT.quantisation / 4.0, ..given });
    }

    #[test]
    fn the_default_mount_is_on_the_servos_shaft() {
        assert_eq!(Mount::DEFAULT.gear(), Gear::DIRECT);
    }
}
