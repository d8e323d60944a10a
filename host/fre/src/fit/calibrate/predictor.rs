//! What the model says of readings.

use model_core::design::Design;
use model_core::discretise::{Discretisation, DiscretiseError};
use model_core::drive::Drive;
use model_core::sensitivity::Probe;
use model_core::status::Status;

use super::parameter::Parameter;
use super::readings::{Reading, Readings};
use super::trial::Trial;
use crate::heap::Host;
use crate::metrics::Point;
use crate::study::follow::follower;
use crate::study::model::Options;

/// What the model says of one reading.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// Status; nothing below holds without a trustworthy one.
    pub status: Status,
    /// Magnitude of the force, N.
    pub force_n: f64,
    /// Its derivative with respect to the motor angle, N per degree.
    pub force_per_deg_n: f64,
    /// Its derivatives with respect to the parameters, in their units; empty if they were not asked for.
    pub gradient: Vec<f64>,
    /// Front centreline, finger frame, mm; empty where none was measured.
    pub front_mm: Vec<Point>,
}

/// The model that readings are compared with.
pub struct Predictor<'a> {
    /// The design that the parameters change.
    pub design: &'a Design,
    /// Scheme, elements, samples and physics.
    pub discretisation: Discretisation,
    /// How the motor moves the base. Readings are of the motor's angle either way.
    pub drive: Drive,
}

impl Predictor<'_> {
    /// What the model says of a run's readings, with derivatives if asked for.
    ///
    /// # Errors
    /// If a design with these values is refused.
    pub fn predict(
        &self,
        run: &Readings,
        trial: &Trial,
        derivatives: bool,
    ) -> Result<Vec<Prediction>, DiscretiseError> {
        let design = trial.design(self.design);
        let mut probe = Probe::EMPTY;
        let object = trial.object(run.object, self.design);
        if object.validate().is_err() {
            // An object that cannot be is one that nothing is known about.
            return Ok(run.readings.iter().map(|_| Prediction::unknown(Status::OutOfRange)).collect());
        }
        let options = Options { discretisation: self.discretisation, ..Options::default() };
        let motion = self.drive.motion(design.motor_axis);
        let mut follower = follower::<f64, Host>(&design, object, motion, &options)?;
        let zero = trial.change(Parameter::Zero, self.design);
        let travel = trial.travel(self.design);
        // The motion's coordinate, rad or mm, and its derivative by the motor's angle; none outside a drive's table.
        let at = |reading: &Reading| {
            let [coordinate, slope] = self.drive.coordinate((reading.angle_deg + zero).to_radians())?;
            Some(if self.drive == Drive::Rotating {
                [coordinate, slope]
            } else {
                [travel * coordinate, travel * slope]
            })
        };
        if let Some([first, _]) = run.readings.iter().find_map(at) {
            follower.start(first);
        }
        let predictions = run.readings.iter().map(|reading| {
            let Some([coordinate, slope]) = at(reading) else { return Prediction::unknown(Status::OutOfRange) };
            let status = follower.follow(coordinate).status;
            if !status.is_trustworthy() {
                return Prediction::unknown(status);
            }
            let force = follower.force_world();
            let size = force[0].hypot(force[1]);
            let mut prediction = Prediction { force_n: size, ..Prediction::unknown(status) };
            if !reading.front_mm.is_empty() {
                prediction.front_mm = follower.front().collect();
            }
            if size == 0.0 || !derivatives {
                prediction.gradient = vec![0.0; if derivatives { trial.parameters.len() } else { 0 }];
                return prediction;
            }
            let along = |v: [f64; 2]| (v[0] * force[0] + v[1] * force[1]) / size;
            // More samples touch than there is room for: no derivative, and the status says so.
            let Some(found) = follower.sensitivity() else { return Prediction::unknown(Status::ContactCapacity) };
            prediction.force_per_deg_n = (along(found.coordinate.force) * slope).to_radians();
            for &parameter in &trial.parameters {
                let derivative = match parameter {
                    Parameter::YoungsModulus => Some(along(found.youngs_modulus.force)),
                    Parameter::Zero => Some(prediction.force_per_deg_n),
                    Parameter::ObjectX => Some(along(found.centre[0].force)),
                    Parameter::ObjectY => Some(along(found.centre[1].force)),
                    Parameter::Radius => Some(along(found.radius.force)),
                    Parameter::Travel => Some(along(found.coordinate.force) * coordinate / travel),
                    Parameter::Design(dimension) => follower
                        .design_sensitivity(&mut probe, &design, &self.discretisation, dimension)
                        .map(|derivative| along(derivative.force)),
                };
                prediction.gradient.push(derivative.unwrap_or(0.0));
            }
            prediction
        });
        Ok(predictions.collect())
    }
}

impl Prediction {
    fn unknown(status: Status) -> Self {
        Self { status, force_n: 0.0, force_per_deg_n: 0.0, gradient: Vec::new(), front_mm: Vec::new() }
    }
}
