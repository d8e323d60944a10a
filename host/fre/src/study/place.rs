//! A place of a motion and what was found there.

use model_core::equilibrium::Buckling;
use model_core::status::Status;
use serde::{Deserialize, Serialize};

use crate::case::Coordinate;
use crate::shape::Shape;
use crate::study::friction::{ForceInterval, Friction};
use crate::study::number::short;
use crate::study::pressure::Pressure;
use crate::study::self_contact::SelfContact;
use crate::study::sensitivity::Sensitivity;
use crate::study::strains::{Beyond, Strains};

/// Where on its motion a finger is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum At {
    /// Motor angle, degrees.
    Angle(f64),
    /// Distance of a translated base, mm.
    Distance(f64),
    /// Time since the motion began, s.
    Time(f64),
}

impl At {
    /// A value in the unit of what it is counted by.
    pub fn new(along: Coordinate, value: f64) -> Self {
        match along {
            Coordinate::Angle => Self::Angle(value),
            Coordinate::Distance => Self::Distance(value),
            Coordinate::Time => Self::Time(value),
        }
    }

    /// Its number: degrees, mm or s.
    pub fn value(self) -> f64 {
        match self {
            Self::Angle(value) | Self::Distance(value) | Self::Time(value) => value,
        }
    }

    /// What it is counted by.
    pub fn along(self) -> Coordinate {
        match self {
            Self::Angle(_) => Coordinate::Angle,
            Self::Distance(_) => Coordinate::Distance,
            Self::Time(_) => Coordinate::Time,
        }
    }
}

impl std::fmt::Display for At {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}", short(self.value()), self.along().unit())
    }
}

/// Largest strains (bending plus stretch, at the outer fibre).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MaxStrain {
    /// In the front beam.
    pub front: f64,
    /// In the back beam.
    pub back: f64,
    /// In the hinges.
    pub hinge: f64,
    /// In the ribs.
    #[serde(default)]
    pub rib: f64,
}

impl MaxStrain {
    /// The largest of them.
    pub fn largest(&self) -> f64 {
        self.front.max(self.back).max(self.hinge).max(self.rib)
    }
}

/// What the solver spent since the place before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Newton iterations.
    pub iterations: u32,
    /// Steps of the coordinate.
    pub steps: u32,
    /// Time, µs.
    pub elapsed_us: f64,
}

/// An equilibrium of finger and object.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Force on the object, world frame, N.
    pub force_n: [f64; 2],
    /// Force on the object, finger frame, N.
    pub force_finger_frame_n: [f64; 2],
    /// Torque that the contact demands of the motor, N·mm, positive when it must push to close. For a translated base:
    /// the force against its motion, N.
    pub motor_torque_nmm: f64,
    /// Elastic energy, N·mm; `None` of a material with memory.
    pub energy_nmm: Option<f64>,
    /// Smallest gap between the finger and the object, mm: the distance before contact, and in contact what the contact's
    /// softness lets the samples sink in (negative).
    pub gap_mm: f64,
    /// Tip of the front beam, finger frame, mm.
    pub tip_mm: [f64; 2],
    /// The deformed finger and its contacts, finger frame, mm.
    pub shape: Shape,
    /// Contact pressure at the touching samples, base to tip.
    pub contact_pressure: Vec<Pressure>,
    /// Largest strains.
    pub max_strain: MaxStrain,
    /// Strains along the beams and in the hinges.
    pub strains: Strains,
    /// What is strained beyond the material's limit, or beyond 30 % if that is not known, the worst first.
    pub beyond_max_strain: Vec<Beyond>,
    /// The deepest overlap of two parts of the finger, which the model lets pass through each other; `None` where they stay clear.
    pub self_contact: Option<SelfContact>,
    /// The rib that is about to bow or has done so; `None` where none carries enough.
    pub buckling: Option<Buckling>,
    /// Friction; `None` without.
    pub friction: Option<Friction>,
    /// Between which values the forces lie if the path is unknown; `None` without friction, and where one of both has no trustworthy status.
    pub force_interval: Option<ForceInterval>,
    /// Derivatives; `None` if more samples touch than the solver has room for, and with friction or memory.
    pub sensitivity: Option<Sensitivity>,
}

impl State {
    /// Magnitude of the force, N.
    pub fn force_magnitude_n(&self) -> f64 {
        let [x, y] = self.force_n;
        x.hypot(y)
    }

    /// Derivative of the force's magnitude in the direction of a derivative of the force; `None` without a force.
    pub fn along_force(&self, [dx, dy]: [f64; 2]) -> Option<f64> {
        let ([x, y], size) = (self.force_n, self.force_magnitude_n());
        (size > 0.0).then(|| (x * dx + y * dy) / size)
    }

    /// Derivative of the force's magnitude, N per degree or per mm of the motion.
    pub fn force_slope(&self) -> Option<f64> {
        self.along_force(self.sensitivity.as_ref()?.force_along_motion()?)
    }

    /// The touching sample under the largest pressure.
    pub fn peak_pressure(&self) -> Option<&Pressure> {
        self.contact_pressure.iter().max_by(|a, b| a.pressure_n_per_mm2.total_cmp(&b.pressure_n_per_mm2))
    }
}

/// The result at one place of a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Where it is.
    pub at: At,
    /// Time since the motion began, s; `None` where no time passes, and where it is what places are counted by.
    pub time_s: Option<f64>,
    /// Whether a state was found, and how.
    pub status: Status,
    /// What was spent on it.
    pub effort: Effort,
    /// Branch, counted from 1: every snap-through begins another; `None` once a place had no trustworthy status.
    pub branch: Option<u32>,
    /// How far the object reaches into a part of the finger that knows no contact, mm; `None` where it stays clear.
    pub overlap_mm: Option<f64>,
    /// The equilibrium; `None` unless the status is trustworthy.
    pub state: Option<State>,
}

impl Place {
    /// Force on the object, world frame, N.
    pub fn force_n(&self) -> Option<[f64; 2]> {
        self.state.as_ref().map(|state| state.force_n)
    }

    /// Magnitude of the force, N.
    pub fn force_magnitude_n(&self) -> Option<f64> {
        self.state.as_ref().map(State::force_magnitude_n)
    }

    /// Front centreline, base to tip, finger frame, mm; empty without a state.
    pub fn front_mm(&self) -> &[[f64; 2]] {
        self.state.as_ref().map_or(&[], |state| &state.shape.front)
    }

    /// True if a part is strained beyond the material's limit, or beyond 30 % if that is not known.
    pub fn is_overstrained(&self) -> bool {
        self.state.as_ref().is_some_and(|state| !state.beyond_max_strain.is_empty())
    }
}
