//! What is known of the servo XM430-W350-T.
//!
//! Figures are those of ROBOTIS' [e-Manual](https://emanual.robotis.com/docs/en/dxl/x/xm430-w350/) at 12 V: stall torque
//! 4.1 N·m (2.3 A), 46 rev/min without load. Torque over current is a straight line in its performance graph, read at
//! (0.60 A, 0.84 N·m) and (1.50 A, 2.45 N·m) on ROBOTIS'
//! [forum](https://forum.robotis.com/t/calculation-of-torque-value-of-xm430-w350-t/5827): 1.79 N·m/A behind a dead zone of
//! 0.23 N·m. (The ratio of the two stall figures, 4.1 N·m / 2.3 A = 1.78 N·m/A, agrees.) The dead zone is the friction of
//! the gears: it adds to the load while the motor drives against it and helps to hold it afterwards.

/// Torque over current, N·mm/A.
pub const TORQUE_CONSTANT: f64 = (2.45 - 0.84) / (1.50 - 0.60) * 1000.0;
/// Friction, seen as a dead zone of the current, N·mm.
pub const FRICTION: f64 = TORQUE_CONSTANT * 0.60 - 840.0;
/// Stall torque at 12 V, N·mm.
pub const STALL_TORQUE: f64 = 4_100.0;
/// Speed without load at 12 V, counts/s.
pub const FREE_SPEED: f64 = 46.0 * 4096.0 / 60.0;
/// What both of them are given for, V.
pub const NOMINAL_VOLTAGE: f64 = 12.0;
