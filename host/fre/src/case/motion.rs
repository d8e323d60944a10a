//! The motion: how the base moves and where along it results are wanted.

use model_core::object::Motion;

use super::error::CaseError;
use super::finger::Finger;
use super::keys::MotionTable;
use super::source::Table;

/// What the places of a motion are counted by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Coordinate {
    /// The motor angle, degrees.
    Angle,
    /// The distance of a translated base, mm.
    Distance,
    /// The time since the motion began, s.
    Time,
}

impl Coordinate {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Angle, Self::Distance, Self::Time];

    /// Name of its column and key in files, with the unit.
    pub fn column(self) -> &'static str {
        match self {
            Self::Angle => "motor_angle_deg",
            Self::Distance => "distance_mm",
            Self::Time => "time_s",
        }
    }

    /// What follows the number of a place: "°", " mm" or " s".
    pub fn unit(self) -> &'static str {
        match self {
            Self::Angle => "°",
            Self::Distance => " mm",
            Self::Time => " s",
        }
    }

    /// The unit in names of derivatives, as in `force_x_per_deg_n`.
    pub fn per(self) -> &'static str {
        match self {
            Self::Angle => "deg",
            Self::Distance => "mm",
            Self::Time => "s",
        }
    }

    /// The word for it in tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Angle => "angle",
            Self::Distance => "distance",
            Self::Time => "time",
        }
    }
}

/// A motion and the places along it that are asked for, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// How the base moves.
    pub motion: Motion,
    /// Coordinates in the file's unit: motor angles in degrees, or distances in mm.
    pub places: Vec<f64>,
}

impl Path {
    /// What its places are counted by.
    pub fn along(&self) -> Coordinate {
        match self.motion {
            Motion::Rotating { .. } => Coordinate::Angle,
            Motion::Translating { .. } => Coordinate::Distance,
        }
    }

    /// What follows the number of a place: "°" or " mm".
    pub fn unit(&self) -> &'static str {
        self.along().unit()
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

/// The motion of a table that the schema's check has passed.
pub(super) fn build(keys: &MotionTable, table: &Table<'_>, finger: &Finger) -> Result<Path, CaseError> {
    if let Some(angles) = &keys.motor_angles_deg {
        for key in ["direction", "distances_mm"] {
            if table.has(key) {
                return Err(table.refuse(
                    key,
                    "cannot be given together with motor_angles_deg; allowed is one motion or the other",
                ));
            }
        }
        if !finger.has_motor {
            return Err(
                table.refuse("motor_angles_deg", "the finger has no motor; needed is motor.axis_mm in the finger")
            );
        }
        return Ok(Path::rotating(finger, angles.clone()));
    }
    let (Some([x, y]), Some(places)) = (keys.direction, &keys.distances_mm) else {
        return Err(match (keys.direction, &keys.distances_mm) {
            (None, Some(_)) => table.missing("direction", "[x, y], the direction in which the base moves"),
            (Some(_), None) => table.missing("distances_mm", "an array of mm"),
            _ => table.missing("motor_angles_deg", "an array of degrees; or direction and distances_mm"),
        });
    };
    let length = x.hypot(y);
    if !(1e-6..=1e6).contains(&length) {
        let reason = "has no length to speak of; allowed is a length of 1e-6 to 1e6 (it is scaled to 1)";
        return Err(table.refuse("direction", reason));
    }
    Ok(Path { motion: Motion::Translating { direction: [x / length, y / length] }, places: places.clone() })
}
