//! What a page asks: one request to the target each, and the target's answer in words.

use messages::{CloseTo, GripTo, Which};
use serde::{Deserialize, Serialize};

use super::lead::Lead;
use super::object::ObjectFields;
use super::setup::Limits;
use crate::source::{Order, OrderError, Source};

/// What a page asks: `"stop"`, `{"grip": {"force_n": 3}}`. Not tagged inside: that would read numbers twice, and serde_json with
/// `arbitrary_precision`, which any crate of a build may ask for, then takes no fractions.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "kebab-case", rename_all_fields = "snake_case", deny_unknown_fields)]
pub enum Command {
    /// All fingers stay where they are, now.
    Stop,
    /// Close until the force is reached.
    Grip {
        /// Of each finger, N.
        force_n: f32,
        /// Which; none: all.
        finger: Option<u8>,
        /// Greatest speed; none: the settings'.
        speed_deg_s: Option<f32>,
    },
    /// Open.
    Release {
        /// Which; none: all.
        finger: Option<u8>,
    },
    /// Switch the torque off.
    Relax {
        /// Which; none: all.
        finger: Option<u8>,
    },
    /// Go to an angle.
    Close {
        /// Motor angle.
        angle_deg: f32,
        /// Which; none: all.
        finger: Option<u8>,
    },
    /// Another object.
    Object {
        /// For which finger.
        finger: u8,
        /// What.
        object: ObjectFields,
    },
    /// Other limits.
    Limits {
        /// For which finger.
        finger: u8,
        /// What.
        limits: Limits,
    },
    /// The demonstration goes on.
    Resume,
}

/// What came of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Answer {
    /// The target has taken it.
    pub ok: bool,
    /// For the person.
    pub words: String,
}

impl Answer {
    /// That it was not done, and why.
    pub fn refused(words: impl std::fmt::Display) -> Self {
        Self { ok: false, words: words.to_string() }
    }
}

impl Command {
    /// Asks the target and waits for its answer.
    pub fn ask(self, source: &dyn Source, lead: Option<&Lead>) -> Answer {
        let which = |finger: Option<u8>| finger.map_or(Which::All, Which::One);
        // Whoever moves the fingers leads from now on.
        let moves = !matches!(self, Self::Object { .. } | Self::Limits { .. } | Self::Resume);
        if let Some(lead) = lead.filter(|_| moves) {
            lead.pause();
        }
        let is_stop = matches!(self, Self::Stop);
        let hold = || source.order(&Order::Hold(Which::All)).map_err(|error| error.to_string());
        let outcome = match self {
            Self::Stop => hold().and_then(|()| {
                let Some(lead) = lead else { return Ok("stopped: the target holds its fingers".to_owned()) };
                // An order that was under way may have come behind the stop.
                lead.settle();
                hold()?;
                Ok("stopped: the target holds its fingers".to_owned())
            }),
            Self::Grip { force_n, finger, speed_deg_s } => {
                let speed = speed_deg_s.map(f32::to_radians);
                let to = GripTo { fingers: which(finger), force: force_n, speed, limit: None };
                asked(source.order(&Order::Grip(to)), format!("the target grips with {force_n} N"))
            }
            Self::Release { finger } => asked(source.order(&Order::Open(which(finger))), "the target opens".to_owned()),
            Self::Relax { finger } => {
                asked(source.order(&Order::Relax(which(finger))), "the target's motors are without torque".to_owned())
            }
            Self::Close { angle_deg, finger } => {
                let to = CloseTo { fingers: which(finger), angle: angle_deg.to_radians(), speed: None };
                asked(source.order(&Order::Close(to)), format!("the target goes to {angle_deg}°"))
            }
            Self::Object { finger, object } => object.object().and_then(|object| {
                asked(source.order(&Order::Object(finger, object)), "the target has the object".to_owned())
            }),
            Self::Limits { finger, limits } => source
                .setup()
                .map_err(|error| error.to_string())
                .and_then(|now| limits.change(&now.settings, finger))
                .and_then(|changed| {
                    asked(source.order(&Order::Settings(changed)), "the target has the limits".to_owned())
                }),
            Self::Resume => match lead {
                Some(lead) => {
                    lead.resume();
                    Ok("the demonstration goes on".to_owned())
                }
                None => Err("there is no demonstration".to_owned()),
            },
        };
        match outcome {
            Ok(words) => Answer { ok: true, words },
            Err(words) if is_stop => Answer::refused(format!("NOT STOPPED: {words}")),
            Err(words) => Answer::refused(words),
        }
    }
}

fn asked(answer: Result<(), OrderError>, words: String) -> Result<String, String> {
    answer.map(|()| words).map_err(|error| error.to_string())
}
