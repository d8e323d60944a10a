//! What the host asks for.

use heapless::Vec;
use model_core::design::Design;
use model_core::discretise::Discretisation;
use model_core::equilibrium::PRONY_TERMS;
use model_core::size::Lists;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// A way to go wrong on purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Provocation {
    /// A start anew that the program asks for.
    Restart,
    /// A panic.
    Panic,
    /// A control loop that stops.
    Hang,
    /// A link that stops.
    HangLink,
    /// A stack that overflows.
    StackOverflow,
}

/// A finger and how it is modelled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Finger {
    /// The finger.
    pub design: Design,
    /// Scheme, elements, samples and physics; what fits is limited by the gripper's memory.
    pub how: Discretisation,
    /// A material that relaxes: of a sudden force the share g (0 to 0.99, so their sum) fades in the time τ (1e-4 to 1e9 s); pairs [g, τ]. None
    /// of an elastic material. The gripper fades the force of the elastic finger, and no free object goes with it.
    #[serde(default)]
    pub prony: Vec<[f32; 2], PRONY_TERMS>,
}

impl Finger {
    /// Its encoding at most, bytes, if no list of the design is longer than these.
    pub const fn bytes(lists: Lists) -> usize {
        // Of the width and the beams' thicknesses, the beams' centrelines, the ribs' thicknesses, their places and their hinges' lengths.
        let pairs = 3 * lists.knots as usize + 2 * lists.points as usize + lists.thicknesses as usize;
        let numbers = 2 * pairs + 3 * lists.lamellae as usize;
        numbers * size_of::<f64>() + Self::REST
    }

    /// What is not in a list, and the lists' lengths, bytes.
    const REST: usize = 320;

    /// Of an elastic material.
    pub const fn elastic(design: Design, how: Discretisation) -> Self {
        Self { design, how, prony: Vec::new() }
    }

    /// Of a material with these terms [g, τ in s]; those beyond the room for them are left out.
    pub fn relaxing(self, terms: &[[f64; 2]]) -> Self {
        let terms = terms.iter().take(PRONY_TERMS);
        Self { prony: terms.map(|term| term.map(|value| value as f32)).collect(), ..self }
    }

    /// The material's terms. Shares are taken for the decimal numbers that they were before they were single: a sum stays what it is.
    pub fn terms(&self) -> Vec<[f64; 2], PRONY_TERMS> {
        let decimal = |share: f32| libm::round(f64::from(share) * 1e6) / 1e6;
        self.prony.iter().map(|&[share, time]| [decimal(share), f64::from(time)]).collect()
    }
}

/// Close (or open) to an angle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct CloseTo {
    /// Which fingers.
    pub fingers: Which,
    /// Motor angle, rad, within [`crate::Mount::range`].
    pub angle: f32,
    /// Speed, rad/s, positive; `None`: the settings' own.
    pub speed: Option<f32>,
}

/// Something for one finger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct For<T> {
    /// Which, from 0.
    pub finger: u8,
    /// What.
    pub what: T,
}

/// A request for all fingers or one of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Which {
    /// All.
    All,
    /// One, from 0.
    One(u8),
}

impl Which {
    /// Whether this finger is meant.
    pub fn is(self, finger: usize) -> bool {
        match self {
            Self::All => true,
            Self::One(one) => usize::from(one) == finger,
        }
    }
}

/// Where a weight pulls at the object that is held.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Gravity {
    /// In the fingers' plane: this way in the gripper frame, rad from x, counter-clockwise.
    Along(f32),
    /// Across the plane: the hand lies flat, and friction holds the weight next to what it holds in the plane.
    Across,
}

/// Close all fingers until together they bear a weight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct CarryTo {
    /// Weight, N, positive.
    pub weight: f32,
    /// Where it pulls.
    pub gravity: Gravity,
    /// How many times the weight the grip is to bear before the object slips; 1 or more.
    pub safety: f32,
    /// Greatest force of each finger (magnitude), N, positive, at most its [`crate::Mount::force_limit`]; `None`: the least of those.
    pub force: Option<f32>,
    /// Greatest speed of closing, rad/s; `None`: the settings' own.
    pub speed: Option<f32>,
    /// Motor angle beyond which no finger closes, rad, within its [`crate::Mount::range`]; `None`: the range's end.
    pub limit: Option<f32>,
}

/// Close until the force is reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct GripTo {
    /// Which fingers.
    pub fingers: Which,
    /// Force of each (magnitude), N, positive, at most its [`crate::Mount::force_limit`].
    pub force: f32,
    /// Greatest speed of closing, rad/s; `None`: the settings' own.
    pub speed: Option<f32>,
    /// Motor angle beyond which no finger closes, rad, within its [`crate::Mount::range`]; `None`: the range's end.
    pub limit: Option<f32>,
}
