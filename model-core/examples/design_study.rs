//! Which way to change a finger: derivatives of the force, checked against the finger changed and solved again.

use std::error::Error;

use model_core::design::{Design, Profile, ladder_80};
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::size::Paper;

const CYLINDER: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };

/// The finger closed to 6°.
fn closed(design: &Design) -> Result<Box<Follower<f64, Paper>>, Box<dyn Error>> {
    let mut follower = Box::new(Follower::<f64, Paper>::EMPTY);
    follower.configure(design, &Discretisation::fine(Physics::Paper))?;
    follower.set_object(CYLINDER, Motion::Rotating { axis: design.motor_axis });
    follower.start(0.0);
    let outcome = follower.follow(6.0_f64.to_radians());
    if outcome.status.is_trustworthy() { Ok(follower) } else { Err(outcome.status.word().into()) }
}

/// Force in x (N) at beams of these thicknesses, mm.
pub fn forces(thicknesses: &[f64]) -> Result<Vec<f64>, Box<dyn Error>> {
    thicknesses
        .iter()
        .map(|&thickness| {
            let mut design = ladder_80();
            design.front.thickness = Profile::constant(thickness);
            design.back.thickness = Profile::constant(thickness);
            Ok(closed(&design)?.solution().force_world()[0])
        })
        .collect()
}

/// Force in x, N, its derivative with the object's place in x, N/mm, from the factorised system and from a difference.
pub fn derivative() -> Result<[f64; 3], Box<dyn Error>> {
    let design = ladder_80();
    let mut follower = closed(&design)?;
    let force = follower.solution().force_world()[0];
    let sensitivity = follower.sensitivity().ok_or("no room for the derivative's rows")?;
    let angle = follower.solution().coordinate();
    let mut moved = |by: f64| {
        let cylinder = ObjectDesign::Circle { centre: [41.0 + by, 45.0], radius: 40.0 };
        follower.set_object(cylinder, Motion::Rotating { axis: design.motor_axis });
        follower.start(0.0);
        follower.follow(angle);
        follower.solution().force_world()[0]
    };
    let h = 1e-4;
    Ok([force, sensitivity.centre[0].force[0], (moved(h) - moved(-h)) / (2.0 * h)])
}

fn main() -> Result<(), Box<dyn Error>> {
    let [force, exact, difference] = derivative()?;
    println!("{force:.4} N; {exact:.5} N per mm of the object's place (a difference says {difference:.5})");
    let thicknesses = [1.6, 1.8, 2.0, 2.2, 2.4];
    for (thickness, force) in thicknesses.iter().zip(forces(&thicknesses)?) {
        println!("beams {thickness} mm thick: {force:.3} N");
    }
    Ok(())
}
