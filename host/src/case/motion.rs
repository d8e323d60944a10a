//! The `[motion]` table: how the base moves and where along it results are wanted.

use model_core::object::Motion;

use super::document::Table;
use super::error::CaseError;
use super::finger::Finger;

/// The most places along a motion.
const MAX_PLACES: usize = 10_000;
/// The largest motor angle, degrees.
pub(crate) const MAX_ANGLE: f64 = 180.0;
/// The largest distance, mm.
pub(crate) const MAX_DISTANCE: f64 = 1000.0;

/// A motion and the places along it that are asked for, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// How the base moves.
    pub motion: Motion,
    /// Coordinates in the file's unit: motor angles in degrees, or distances in mm.
    pub places: Vec<f64>,
}

impl Path {
    /// What follows the number of a place: "°" or " mm".
    pub fn unit(&self) -> &'static str {
        match self.motion {
            Motion::Rotating { .. } => "°",
            Motion::Translating { .. } => " mm",
        }
    }

    /// A rotation about the finger's motor axis by angles in degrees.
    pub fn rotating(finger: &Finger, angles_deg: Vec<f64>) -> Self {
        Self { motion: Motion::Rotating { axis: finger.design.motor_axis }, places: angles_deg }
    }

    /// The solver's coordinate (rad or mm) of a place in the file's unit (degrees or mm).
    pub fn coordinate(&self, place: f64) -> f64 {
        match self.motion {
            Motion::Rotating { .. } => place.to_radians(),
            Motion::Translating { .. } => place,
        }
    }

    /// The place in the file's unit (degrees or mm) of a coordinate of the solver (rad or mm).
    pub fn place(&self, coordinate: f64) -> f64 {
        match self.motion {
            Motion::Rotating { .. } => coordinate.to_degrees(),
            Motion::Translating { .. } => coordinate,
        }
    }
}

/// Reads and validates the motion.
pub(super) fn read(root: &Table<'_>, finger: &Finger) -> Result<Path, CaseError> {
    let table = root.need("motion", "a table with motor_angles_deg, or with direction and distances_mm")?.table()?;
    let table = table.only(&["motor_angles_deg", "direction", "distances_mm"])?;
    let list = |key, unit: &str, limit: f64| {
        let value = table.need(key, &format!("an array of {unit}"))?;
        let entries = value.entries(&format!("an array of {unit}"), MAX_PLACES)?;
        if entries.is_empty() {
            return Err(value.refuse(format!("is empty; needed is at least one number of {unit}")));
        }
        let mut places = Vec::with_capacity(entries.len());
        for entry in entries {
            let place = entry.number()?;
            if place.abs() > limit {
                return Err(entry.refuse(format!("allowed is {} to {limit} {unit}", -limit)));
            }
            places.push(place);
        }
        Ok(places)
    };
    if table.has("motor_angles_deg") {
        for key in ["direction", "distances_mm"] {
            if table.has(key) {
                return Err(
                    table.refuse(key, "cannot stand beside motor_angles_deg; allowed is one motion or the other")
                );
            }
        }
        if !finger.has_motor {
            return Err(
                table.refuse("motor_angles_deg", "the finger has no motor; needed is motor.axis_mm in the finger")
            );
        }
        return Ok(Path::rotating(finger, list("motor_angles_deg", "degrees", MAX_ANGLE)?));
    }
    if !table.has("direction") && !table.has("distances_mm") {
        return Err(table.missing("motor_angles_deg", "an array of degrees; or direction and distances_mm"));
    }
    let value = table.need("direction", "[x, y], the direction in which the base moves")?;
    let [x, y] = value.pair("[x, y], the direction in which the base moves")?;
    let length = x.hypot(y);
    if !(1e-6..=1e6).contains(&length) {
        return Err(value.refuse("has no length to speak of; allowed is a length of 1e-6 to 1e6 (it is scaled to 1)"));
    }
    let places = list("distances_mm", "mm", MAX_DISTANCE)?;
    Ok(Path { motion: Motion::Translating { direction: [x / length, y / length] }, places })
}
