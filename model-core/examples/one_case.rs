//! One equilibrium: a finger closed to 11° on a cylinder of 80 mm diameter, with the model of
//! *Geometrico-Static Modelling of a FRE Finger* at its full resolution.

use std::error::Error;

use model_core::design::ladder_80;
use model_core::discretise::{Discretisation, Physics, Scheme};
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::size::Paper;

/// Force of the finger on the cylinder, world frame, N.
pub fn force() -> Result<[f64; 2], Box<dyn Error>> {
    let design = ladder_80();
    let mut follower = Box::new(Follower::<f64, Paper>::EMPTY);
    follower.configure(&design, &Discretisation::full(Scheme::Paper, Physics::Paper))?;
    let cylinder = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    follower.set_object(cylinder, Motion::Rotating { axis: design.motor_axis });

    // The answer depends on the path: it begins where nothing touches.
    follower.start(0.0);
    let outcome = follower.follow(11.0_f64.to_radians());
    if !outcome.status.is_trustworthy() {
        return Err(outcome.status.word().into());
    }
    for contact in follower.solution().contacts() {
        println!("{:6.3} N at {:5.2} mm along the front beam", contact.force, contact.arc);
    }
    Ok(follower.solution().force_world())
}

fn main() -> Result<(), Box<dyn Error>> {
    let [x, y] = force()?;
    println!("the finger pushes with ({x:.3}, {y:.3}) N");
    Ok(())
}
