//! What a gripper goes through at 500 Hz, tick by tick: it closes slowly and fast, holds, gets another object and the old one again,
//! opens, and closes beyond a snap-through.

use model_core::estimator::Estimator;
use model_core::object::ObjectDesign;
use model_core::real::Real;
use model_core::size::Size;

use crate::{COUNT, circle_80};

/// Period, s.
pub const PERIOD_S: f64 = 0.002;
/// Ticks of a finger that holds.
const HOLDS: u32 = 40;
/// Ticks in which it has approached an object that was set while it holds.
const APPROACHES: u32 = 90;

/// Angle beyond the snap-through at a height of 70 mm, degrees.
const SNAPPED: f64 = 18.5;

/// A tick: the motor's angle in counts, and an object that is set before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick {
    /// Counts of the servo.
    pub position: i32,
    /// Height of another 80 mm circle, mm.
    pub height: Option<f64>,
}

/// From one angle to another (degrees) at a speed, rad/s, a tick each.
fn motion(from: f64, to: f64, speed: f64) -> impl Iterator<Item = Tick> {
    let (from, to) = (from.to_radians() / COUNT, to.to_radians() / COUNT);
    let step = speed * PERIOD_S / COUNT;
    let ticks = (libm::fabs(to - from) / step) as u32;
    let way = if to > from { step } else { -step };
    (0..=ticks).map(move |tick| Tick { position: libm::round(from + way * f64::from(tick)) as i32, height: None })
}

fn stand(at: f64, ticks: u32, height: Option<f64>) -> impl Iterator<Item = Tick> {
    let position = libm::round(at.to_radians() / COUNT) as i32;
    (0..ticks).map(move |tick| Tick { position, height: height.filter(|_| tick == 0) })
}

/// The campaign.
pub fn ticks() -> impl Iterator<Item = Tick> {
    let round = |last: f64, speed: f64| {
        let others = stand(last, APPROACHES, Some(56.0)).chain(stand(last, APPROACHES, Some(45.0)));
        motion(-1.0, last, speed).chain(stand(last, HOLDS, None)).chain(others).chain(motion(last, -1.0, speed))
    };
    let there = motion(-1.0, SNAPPED, 0.35).chain(stand(SNAPPED, APPROACHES, None));
    let snap = stand(-1.0, HOLDS, Some(70.0)).chain(there).chain(motion(SNAPPED, -1.0, 0.35));
    stand(-1.0, HOLDS, Some(45.0)).chain(round(2.0, 0.05)).chain(round(11.0, 0.35)).chain(round(11.0, 1.0)).chain(snap)
}

impl Tick {
    /// The angle, rad.
    pub fn angle(&self) -> f64 {
        f64::from(self.position) * COUNT
    }

    /// Sets the object; false if it is refused.
    pub fn prepare<T: Real, S: Size>(&self, estimator: &mut Estimator<T, S>) -> bool {
        let circle: Option<ObjectDesign> = self.height.map(circle_80);
        circle.is_none_or(|circle| estimator.set_object(circle).is_ok())
    }
}
