//! What is known of the servos' motors.
//!
//! Figures of the XM430-W350-T are those of ROBOTIS' [e-Manual](https://emanual.robotis.com/docs/en/dxl/x/xm430-w350/) at 12 V: stall
//! torque 4.1 N·m (2.3 A), 46 rev/min without load. Torque over current is a straight line in its performance graph, read at
//! (0.60 A, 0.84 N·m) and (1.50 A, 2.45 N·m) on ROBOTIS'
//! [forum](https://forum.robotis.com/t/calculation-of-torque-value-of-xm430-w350-t/5827): 1.79 N·m/A behind a dead zone of
//! 0.23 N·m. (The ratio of the two stall figures, 4.1 N·m / 2.3 A = 1.78 N·m/A, agrees.) The dead zone is the friction of
//! the gears: it adds to the load while the motor drives against it and helps to hold it afterwards.
//!
//! Of the others the e-Manual's specifications are used: stall torque and current, and the speed without load. That their friction is the
//! same part of the stall torque is an assumption. What a gripper needs of all this is in [`dynamixel::Motor`].

use dynamixel::Model;

/// Torque over current of the XM430-W350, N·mm/A.
pub const TORQUE_CONSTANT: f64 = (2.45 - 0.84) / (1.50 - 0.60) * 1000.0;
/// Its friction, seen as a dead zone of the current, N·mm.
pub const FRICTION: f64 = TORQUE_CONSTANT * 0.60 - 840.0;
/// Its stall torque at 12 V, N·mm.
pub const STALL_TORQUE: f64 = 4_100.0;
/// Its speed without load at 12 V, counts/s.
pub const FREE_SPEED: f64 = 46.0 * 4096.0 / 60.0;
/// What both of them are given for, V.
pub const NOMINAL_VOLTAGE: f64 = 12.0;

/// A servo's motor with its gears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Datasheet {
    /// Torque over current, N·mm/A.
    pub torque_constant: f64,
    /// Friction, N·mm.
    pub friction: f64,
    /// Stall torque, N·mm.
    pub stall_torque: f64,
    /// Speed without load, rev/min.
    pub free_speed: f64,
    /// What both of them are given for, V.
    pub volts: f64,
}

impl Datasheet {
    /// Of the XM430-W350.
    pub const XM430: Self = Self {
        torque_constant: TORQUE_CONSTANT,
        friction: FRICTION,
        stall_torque: STALL_TORQUE,
        free_speed: 46.0,
        volts: NOMINAL_VOLTAGE,
    };

    /// Stall torque, N·mm, and current, A; speed without load, rev/min; voltage.
    const fn of_stall(stall_torque: f64, amperes: f64, free_speed: f64, volts: f64) -> Self {
        Self {
            torque_constant: stall_torque / amperes,
            friction: stall_torque * (FRICTION / STALL_TORQUE),
            stall_torque,
            free_speed,
            volts,
        }
    }

    /// Of a model; nothing if it is not known here.
    pub fn of(model: &Model) -> Option<Self> {
        Some(match model.number {
            1020 => Self::XM430,
            1060 => Self::of_stall(1_500.0, 1.4, 61.0, 12.0),
            1120 => Self::of_stall(10_600.0, 4.4, 30.0, 12.0),
            1200 => Self::of_stall(520.0, 1.47, 103.0, 5.0),
            1220 => Self::of_stall(1_000.0, 0.88, 71.0, 12.0),
            // No stall torque is given: that of its Current Limit, 1461 mA, by the ratio of its continuous torque (1.7 N·m) and current
            // (0.6 A).
            2100 => Self::of_stall(1.461 * 1_700.0 / 0.6, 1.461, 28.0, 24.0),
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gripper_has_the_same_motors() {
        for model in &dynamixel::MODELS {
            let Some(Datasheet { torque_constant, friction, .. }) = Datasheet::of(model) else { continue };
            let near = |found: f32, expected: f64| (f64::from(found) / expected - 1.0).abs() < 1e-6;
            assert!(near(model.motor.torque_constant * 1000.0, torque_constant), "{}", model.name);
            assert!(near(model.motor.friction, friction), "{}", model.name);
        }
    }
}
