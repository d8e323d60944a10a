//! The finger and the object that the costs are quoted for: `ladder-80`, a cylinder of 80 mm at Mid height.

use anyhow::{Context, Result};
use model_core::design::Design;
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::object::Motion;
use model_core::real::Real;
use model_core::size::Size;
use reference_tests::{circle_80, ladder_80};

/// Both physics and their words in tables and documents.
pub const PHYSICS: [Physics; 2] = [Physics::Paper, Physics::Extended];
/// Height of the object's centre, mm.
const HEIGHT: f64 = 45.0;

/// A physics' word in tables and documents.
pub fn word(physics: Physics) -> &'static str {
    match physics {
        Physics::Paper => "paper",
        Physics::Extended => "extended",
    }
}

/// A follower of the finger on the object.
pub fn follower<T: Real, S: Size>(how: &Discretisation) -> Result<Box<Follower<T, S>>> {
    follower_of(&ladder_80(), how)
}

/// A follower of another finger on the same object.
pub fn follower_of<T: Real, S: Size>(design: &Design, how: &Discretisation) -> Result<Box<Follower<T, S>>> {
    let mut follower = Box::new(Follower::EMPTY);
    follower.configure(design, how).with_context(|| format!("{how:?}"))?;
    follower.set_object(circle_80(HEIGHT), Motion::Rotating { axis: design.motor_axis });
    Ok(follower)
}

/// Counts of closing to the last one and opening again.
pub fn counts(last: i32) -> impl Iterator<Item = i32> {
    (0..=last).chain((0..last).rev())
}
