//! Keys of `[motion]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The largest motor angle, degrees.
pub const MAX_ANGLE: f64 = 180.0;
/// The largest distance, mm.
pub const MAX_DISTANCE: f64 = 1000.0;
/// The latest time, s.
pub const MAX_TIME: f64 = 1e9;
/// The least and the greatest speed of a motor, degrees per second.
const SPEEDS: [f64; 2] = [1e-6, 1e6];
/// The most places along a motion.
const MAX_PLACES: usize = 10_000;

/// The motion: a motor turns the finger, or a parallel gripper moves its base along a line.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionTable {
    /// Motor angles, in the order in which they are passed; positive closes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-unit" = "degrees", "x-range" = [-MAX_ANGLE, MAX_ANGLE], "x-needed" = "an array of degrees", "maxItems" = MAX_PLACES,
        "minItems" = 1, "x-default" = "needed, unless the base moves along a line", "x-picture" = "finger"
    ))]
    pub motor_angles_deg: Option<Vec<f64>>,
    /// Direction in which a parallel gripper moves the base; its length does not matter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-limits" = "a length of 1e-6 to 1e6", "x-default" = "needed without a motor",
        "x-needed" = "[x, y], the direction in which the base moves"
    ))]
    pub direction: Option<[f64; 2]>,
    /// Distances along `direction`, in the order in which they are passed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-unit" = "mm", "x-range" = [-MAX_DISTANCE, MAX_DISTANCE], "x-needed" = "an array of mm", "maxItems" = MAX_PLACES, "minItems" = 1,
        "x-default" = "needed without a motor"
    ))]
    pub distances_mm: Option<Vec<f64>>,
    /// Time at each place since the motion began with an open hand, increasing: one per place. The same place at a later time is a hold.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-unit" = "s", "x-range" = [0.0, MAX_TIME], "x-default" = "no time passes", "maxItems" = MAX_PLACES, "minItems" = 1,
        "x-needed" = "an array of s, one per place"
    ))]
    pub times_s: Option<Vec<f64>>,
    /// Speed of the motor, in place of `times_s`: from the open hand to the first place, whose time is 0, and from place to place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "degrees/s", "x-range" = SPEEDS, "x-default" = "no time passes"))]
    pub speed_deg_per_s: Option<f64>,
}
