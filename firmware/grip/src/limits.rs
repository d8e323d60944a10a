//! What a finger's motor is asked for, and what it must not exceed.

use crate::Reaction;

/// What no motion of a finger exceeds, and how it opens. Angles are of the motor, positive when it closes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Motor angles that may be asked for, rad.
    pub range: [f32; 2],
    /// Motor angle of the open finger, rad, within the range.
    pub open_angle: f32,
    /// Speed of opening, and of closing where none is asked for, rad/s.
    pub speed: f32,
    /// Force (magnitude) that no motion exceeds by the estimate, N.
    pub force: f32,
    /// Current above which the motor is not moved on, mA.
    pub current: f32,
}

/// What a finger does when its force cannot be trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Faults {
    /// What a gripping finger does.
    pub reaction: Reaction,
    /// How long a finger closes on to an angle while its estimate is untrustworthy, s. (A gripping one waits at once.)
    pub untrusted_s: f64,
    /// What a gripping finger does when its servo is about to shut down.
    pub strain: Reaction,
}

/// A grip that is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Force (magnitude), N, positive, at most [`Limits::force`].
    pub force: f32,
    /// Greatest speed of closing, rad/s; `None`: [`Limits::speed`].
    pub speed: Option<f32>,
    /// Motor angle beyond which the finger does not close, rad, within [`Limits::range`]; `None`: the range's end.
    pub limit: Option<f32>,
}

impl Target {
    /// This force, with the finger's own speed, as far as its range goes.
    pub const fn of(force: f32) -> Self {
        Self { force, speed: None, limit: None }
    }
}
