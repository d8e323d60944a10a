//! Keys of `[motion]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The largest motor angle, degrees.
pub const MAX_ANGLE: f64 = 180.0;
/// The largest distance, mm.
pub const MAX_DISTANCE: f64 = 1000.0;
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
    /// Time at each place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "s", "x-default" = "no time passes", "x-computed" = []))]
    pub times_s: Option<Vec<f64>>,
    /// Speed of the motor, in place of `times_s`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "degrees/s", "x-default" = "no time passes", "x-computed" = []))]
    pub speed_deg_per_s: Option<f64>,
}
