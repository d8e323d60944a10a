//! A shape of one's own: two cylinders side by side, behind the solver's only view of an object, the trait `Object`.

use std::error::Error;

use model_core::design::ladder_80;
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::object::{Circle, Displacement, Gap, Motion, Object};
use model_core::real::Vec2;
use model_core::size::{Blank, Paper};

/// The union of two circles.
#[derive(Clone, Copy)]
pub struct Pair([Circle<f64>; 2]);

impl Blank for Pair {
    const BLANK: Self = Self([Circle::BLANK; 2]);
}

impl Object<f64> for Pair {
    fn displaced(&self, by: &Displacement<f64>) -> Self {
        Self(self.0.map(|circle| circle.displaced(by)))
    }

    fn gap(&self, point: Vec2<f64>) -> Gap<f64> {
        let [a, b] = self.0.map(|circle| circle.gap(point));
        if a.distance < b.distance { a } else { b }
    }
}

/// Force on each of the two, world frame, N: the lower and the upper one.
pub fn forces() -> Result<[f64; 2], Box<dyn Error>> {
    let design = ladder_80();
    let mut follower = Box::new(Follower::<f64, Paper, Pair>::EMPTY);
    follower.configure(&design, &Discretisation::fine(Physics::Paper))?;
    let pair = Pair([Circle::new([11.5, 28.0], 10.0), Circle::new([13.5, 55.0], 10.0)]);
    follower.set_object(pair, Motion::Rotating { axis: design.motor_axis });
    follower.start(0.0);
    let outcome = follower.follow(5.0_f64.to_radians());
    if !outcome.status.is_trustworthy() {
        return Err(outcome.status.word().into());
    }
    let mut forces = [0.0; 2];
    for contact in follower.solution().contacts() {
        forces[usize::from(contact.arc > 40.0)] += contact.force;
    }
    Ok(forces)
}

fn main() -> Result<(), Box<dyn Error>> {
    let [lower, upper] = forces()?;
    println!("{lower:.3} N on the lower cylinder, {upper:.3} N on the upper one");
    Ok(())
}
