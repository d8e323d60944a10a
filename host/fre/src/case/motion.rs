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

/// How time passes along a motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Clock {
    /// It does not: what remembers sees sudden changes.
    #[default]
    Stopped,
    /// Time at each place, s, since the motion began with an open hand.
    Times(Vec<f64>),
    /// The motor's speed, degrees per second, from the open hand on; the first place has time 0.
    Speed(f64),
}

/// A motion and the places along it that are asked for, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// How the base moves.
    pub motion: Motion,
    /// Coordinates in the file's unit: motor angles in degrees, or distances in mm.
    pub places: Vec<f64>,
    /// How time passes.
    pub clock: Clock,
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
        Self { motion: Motion::Rotating { axis: finger.design.motor_axis }, places: angles_deg, clock: Clock::Stopped }
    }

    /// Asks for other places, at which no time is known: only a speed stays.
    pub fn set_places(&mut self, places: Vec<f64>) {
        self.places = places;
        if let Clock::Times(_) = self.clock {
            self.clock = Clock::Stopped;
        }
    }

    /// True if time passes.
    pub fn has_time(&self) -> bool {
        self.clock != Clock::Stopped
    }

    /// Time on the way to each place from the one before, s; `begin` is where the motion begins, in the unit of the places.
    pub fn time_steps(&self, begin: f64) -> Vec<f64> {
        let before =
            |first: f64, values: &[f64]| core::iter::once(first).chain(values.iter().copied()).collect::<Vec<_>>();
        match &self.clock {
            Clock::Stopped => vec![0.0; self.places.len()],
            Clock::Times(times) => times.iter().zip(before(0.0, times)).map(|(time, earlier)| time - earlier).collect(),
            Clock::Speed(speed) => {
                let from = before(begin, &self.places);
                self.places.iter().zip(from).map(|(place, from)| (place - from).abs() / speed).collect()
            }
        }
    }

    /// Time at each place, s; none where no time passes.
    pub fn times(&self) -> Option<Vec<f64>> {
        match &self.clock {
            Clock::Stopped => None,
            Clock::Times(times) => Some(times.clone()),
            Clock::Speed(_) => {
                let mut time = 0.0;
                let steps = self.time_steps(self.places.first().copied().unwrap_or_default());
                Some(steps.into_iter().map(|step| (time += step, time).1).collect())
            }
        }
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
        return Ok(Path {
            clock: clock(keys, table, angles.len(), "angle")?,
            ..Path::rotating(finger, angles.clone())
        });
    }
    if table.has("speed_deg_per_s") {
        return Err(table.refuse("speed_deg_per_s", "the base moves along a line; allowed is times_s"));
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
    Ok(Path {
        motion: Motion::Translating { direction: [x / length, y / length] },
        clock: clock(keys, table, places.len(), "distance")?,
        places: places.clone(),
    })
}

/// How time passes along so many places; `place` names one of them.
fn clock(keys: &MotionTable, table: &Table<'_>, count: usize, place: &str) -> Result<Clock, CaseError> {
    let Some(times) = &keys.times_s else {
        return Ok(keys.speed_deg_per_s.map_or(Clock::Stopped, Clock::Speed));
    };
    if table.has("speed_deg_per_s") {
        let reason = "cannot be given together with times_s; allowed is one or the other";
        return Err(table.refuse("speed_deg_per_s", reason));
    }
    if times.len() != count {
        let found = times.len();
        return Err(table.refuse("times_s", format!("has {found} entries; allowed is one per {place} ({count})")));
    }
    let Some(late) = times.windows(2).position(|pair| pair[0] >= pair[1]) else {
        return Ok(Clock::Times(times.clone()));
    };
    let reason = format!("is not after the time before, {} s; allowed are times that increase", times[late]);
    let entries = table.find("times_s").and_then(|list| list.entries(String::new, usize::MAX).ok());
    Err(match entries.as_ref().and_then(|entries| entries.get(late + 1)) {
        Some(entry) => entry.refuse(reason),
        None => table.refuse("times_s", reason),
    })
}
