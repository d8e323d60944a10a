//! What a control loop does: a motor angle in every 2 ms, a force with its status out; single precision, bounded time.

use std::error::Error;

use model_core::design::ladder_80;
use model_core::discretise::{Discretisation, Physics};
use model_core::estimator::{Estimate, Estimator};
use model_core::object::ObjectDesign;
use model_core::size::Reduced;

/// Estimates at every count of the servo's sensor (360°/4096) from an open finger to 10°.
pub fn estimates() -> Result<Vec<Estimate>, Box<dyn Error>> {
    // On a microcontroller in a static: everything is in it, nothing is allocated.
    let mut estimator = Box::new(Estimator::<f32, Reduced>::EMPTY);
    estimator.configure(&ladder_80(), &Discretisation::estimator(Physics::Extended))?;
    estimator.set_object(ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 })?;
    let count = std::f64::consts::TAU / 4096.0;
    Ok((-5..=114).map(|position| estimator.update(f64::from(position) * count)).collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    for estimate in estimates()?.iter().step_by(10) {
        // No number without its status.
        println!(
            "{:6.2}° {:7.3} N {:6.1} N·mm at {:4.1} mm, {} iterations: {}",
            estimate.motor_angle.to_degrees(),
            estimate.force_magnitude(),
            estimate.torque,
            estimate.contact_centre[1],
            estimate.iterations,
            estimate.status
        );
    }
    Ok(())
}
