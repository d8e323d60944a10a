//! Measured runs and what the model says of them.

use model_core::design::Design;
use model_core::discretise::{Discretisation, DiscretiseError};
use model_core::drive::{Drive, Knots, Travel};
use model_core::object::ObjectDesign;
use model_core::sensitivity::{DesignParameter, Probe};
use model_core::status::Status;

use super::Parameter;
use crate::fit::measured::Measured;
use crate::heap::Host;
use crate::metrics::Point;
use crate::study::follow::follower;
use crate::study::model::Options;

/// One reading.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Line of the file, from 1.
    pub line: usize,
    /// Measured motor angle, degrees.
    pub angle_deg: f64,
    /// Measured magnitude of the force, N, if it was.
    pub force_n: Option<f64>,
    /// Points of the front centreline, finger frame, mm, if there are any.
    pub front_mm: Vec<Point>,
}

/// Readings on one object, in the order of a closing motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// What it is called in messages: its file.
    pub name: String,
    /// The object as the case describes it, world frame.
    pub object: ObjectDesign,
    /// By increasing angle.
    pub readings: Vec<Reading>,
}

/// A design with values of parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// The parameters.
    pub parameters: Vec<Parameter>,
    /// Their values, in [`Parameter::unit`].
    pub values: Vec<f64>,
}

impl Trial {
    /// Where a fit begins.
    pub fn start(parameters: &[Parameter], design: &Design) -> Self {
        Self {
            parameters: parameters.to_vec(),
            values: parameters.iter().map(|parameter| parameter.start(design)).collect(),
        }
    }

    /// A parameter's value less the design's own.
    pub fn change(&self, parameter: Parameter, design: &Design) -> f64 {
        let own = parameter.start(design);
        let found = self.parameters.iter().zip(&self.values).find(|(other, _)| **other == parameter);
        found.map_or(0.0, |(_, value)| value - own)
    }

    /// The design with these values.
    pub fn design(&self, design: &Design) -> Design {
        let mut changed = design.clone();
        changed.material.youngs_modulus += self.change(Parameter::YoungsModulus, design);
        for dimension in DesignParameter::ALL {
            dimension.shift(&mut changed, self.change(Parameter::Design(dimension), design));
        }
        changed
    }

    /// How the motor moves the base, with these values.
    pub fn drive(&self, drive: &Drive, design: &Design) -> Drive {
        let factor = self.travel(design);
        let scaled = |distance: f32| (f64::from(distance) * factor) as f32;
        let travel = match drive {
            Drive::Rotating => return Drive::Rotating,
            Drive::Translating { travel: Travel::Linear { mm_per_rad }, .. } => {
                Travel::Linear { mm_per_rad: scaled(*mm_per_rad) }
            }
            Drive::Translating { travel: Travel::Table(knots), .. } => {
                let scaled: Vec<_> = knots.iter().map(|&[angle, distance]| [angle, scaled(distance)]).collect();
                // As many as there were.
                Travel::Table(Knots::new(&scaled).unwrap_or(*knots))
            }
        };
        match *drive {
            Drive::Translating { direction, .. } => Drive::Translating { direction, travel },
            Drive::Rotating => Drive::Rotating,
        }
    }

    /// What distances are multiplied by.
    fn travel(&self, design: &Design) -> f64 {
        1.0 + self.change(Parameter::Travel, design)
    }

    /// An object with these values.
    pub fn object(&self, object: ObjectDesign, design: &Design) -> ObjectDesign {
        let shift = [self.change(Parameter::ObjectX, design), self.change(Parameter::ObjectY, design)];
        let go = |p: [f64; 2]| [p[0] + shift[0], p[1] + shift[1]];
        match object {
            ObjectDesign::Circle { centre, radius } => {
                ObjectDesign::Circle { centre: go(centre), radius: radius + self.change(Parameter::Radius, design) }
            }
            ObjectDesign::Ellipse { centre, semi_axes, angle } => {
                ObjectDesign::Ellipse { centre: go(centre), semi_axes, angle }
            }
            ObjectDesign::Polygon { corners, rounding } => ObjectDesign::Polygon { corners: corners.map(go), rounding },
            ObjectDesign::HalfPlane { point, normal } => ObjectDesign::HalfPlane { point: go(point), normal },
            ObjectDesign::Bore { centre, radius } => ObjectDesign::Bore { centre: go(centre), radius },
        }
    }
}

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
pub struct Model<'a> {
    /// The design that the parameters change.
    pub design: &'a Design,
    /// Scheme, elements, samples and physics.
    pub discretisation: Discretisation,
    /// How the motor moves the base. Readings are of the motor's angle either way.
    pub drive: Drive,
}

impl Model<'_> {
    /// What the model says of a run's readings, with derivatives if asked for.
    ///
    /// # Errors
    /// If a design with these values is refused.
    pub fn predict(&self, run: &Run, trial: &Trial, derivatives: bool) -> Result<Vec<Prediction>, DiscretiseError> {
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

impl Run {
    /// A run of the measurements that belong to a closing motion, and the lines of those left out: rows of the file in which the
    /// angle is less than the greatest before by more than `tolerance_deg` belong to an opening.
    pub fn closing(name: &str, object: ObjectDesign, measured: &Measured, tolerance_deg: f64) -> (Self, Vec<usize>) {
        let mut rows: Vec<(usize, f64, Option<f64>, &[Point])> = Vec::new();
        for measurement in &measured.measurements {
            if measurement.forces.is_empty() {
                rows.push((measurement.line, measurement.place, None, &measurement.front));
            }
            for (index, &(line, force)) in measurement.forces.iter().enumerate() {
                // The outline belongs to the place; it counts once.
                let front = if index == 0 { measurement.front.as_slice() } else { &[] };
                rows.push((line, measurement.place, Some(force), front));
            }
        }
        rows.sort_by_key(|row| row.0);
        let mut greatest = f64::NEG_INFINITY;
        let (mut readings, mut left_out) = (Vec::new(), Vec::new());
        for (line, angle_deg, force_n, front) in rows {
            if angle_deg < greatest - tolerance_deg {
                left_out.push(line);
                continue;
            }
            greatest = greatest.max(angle_deg);
            readings.push(Reading { line, angle_deg, force_n, front_mm: front.to_vec() });
        }
        readings.sort_by(|a, b| a.angle_deg.total_cmp(&b.angle_deg));
        (Self { name: name.to_owned(), object, readings }, left_out)
    }

    /// A run of all measurements, whatever the motion.
    pub fn all(name: &str, object: ObjectDesign, measured: &Measured) -> Self {
        Self::closing(name, object, measured, f64::INFINITY).0
    }
}
