//! The same closing in single and in double precision.

extern crate std;

use std::boxed::Box;

use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::object::Motion;
use model_core::real::Real;
use model_core::size::Paper;
use model_core::status::Status;

use crate::wide::WideCase;

/// What a closing came to in one precision.
#[derive(Clone, Copy, Debug)]
pub struct Closing {
    /// Its status.
    pub status: Status,
    /// Force on the object, world frame, N.
    pub force: [f64; 2],
    /// Motor angle that was reached, rad.
    pub reached: f64,
    /// Newton iterations.
    pub iterations: u32,
}

impl Closing {
    /// Magnitude of the force, N.
    pub fn magnitude(&self) -> f64 {
        libm::hypot(self.force[0], self.force[1])
    }
}

/// A closing in both precisions.
#[derive(Clone, Copy, Debug)]
pub struct Twins {
    /// In `f32`.
    pub single: Closing,
    /// In `f64`.
    pub double: Closing,
}

impl Twins {
    /// Distance of the forces as a part of the one in double precision; 0 without either.
    pub fn difference(&self) -> f64 {
        let apart =
            libm::hypot(self.single.force[0] - self.double.force[0], self.single.force[1] - self.double.force[1]);
        if apart > 0.0 { apart / self.double.magnitude() } else { 0.0 }
    }
}

impl core::fmt::Display for Twins {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        for (word, closing) in [("f32", &self.single), ("; f64", &self.double)] {
            let Closing { status, reached, iterations, .. } = closing;
            let (degrees, force) = (reached.to_degrees(), closing.magnitude());
            write!(f, "{word} {status} {force:.6} N at {degrees:.3}°, {iterations} iterations")?;
        }
        Ok(())
    }
}

/// A solver of each precision.
pub struct Solvers {
    single: Box<Follower<f32, Paper>>,
    double: Box<Follower<f64, Paper>>,
}

impl Solvers {
    /// Before its first use.
    #[expect(clippy::new_without_default, reason = "a pair of large solvers is made on purpose")]
    pub fn new() -> Self {
        Self { single: Box::new(Follower::EMPTY), double: Box::new(Follower::EMPTY) }
    }

    /// Closes a finger on its circle at the microcontroller's resolution.
    ///
    /// # Panics
    /// If the finger is refused.
    pub fn close(&mut self, case: &WideCase, physics: Physics) -> Twins {
        Twins { single: close(&mut self.single, case, physics), double: close(&mut self.double, case, physics) }
    }
}

fn close<T: Real>(follower: &mut Follower<T, Paper>, case: &WideCase, physics: Physics) -> Closing {
    follower.configure(&case.design, &Discretisation::reduced(physics)).expect("a valid finger");
    follower.set_object(case.object(), Motion::Rotating { axis: case.design.motor_axis });
    if !follower.start(case.angle) {
        return Closing { status: Status::OutOfRange, force: [0.0; 2], reached: 0.0, iterations: 0 };
    }
    let outcome = follower.follow(case.angle);
    let force = follower.solution().force_world().map(Real::to_f64);
    Closing { status: outcome.status, force, reached: follower.solution().coordinate(), iterations: outcome.iterations }
}
