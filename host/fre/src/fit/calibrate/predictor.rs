//! What the model says of readings.

use model_core::design::Design;
use model_core::discretise::{Discretisation, DiscretiseError};
use model_core::drive::Drive;
use model_core::equilibrium::Target;
use model_core::sensitivity::{Derivative, Probe};
use model_core::status::Status;

use super::parameter::Parameter;
use super::readings::{Reading, Readings};
use super::trial::Trial;
use crate::metrics::Point;
use crate::study::follow::follower;
use crate::study::model::Options;

/// Step of differences, in a parameter's doubts.
const STEP: f64 = 1e-3;
/// The same with friction, where samples begin to slip one by one.
const ROUGH_STEP: f64 = 0.02;
/// The same of the angle, degrees.
const ANGLE_STEP_DEG: f64 = 0.02;
/// The same of a drive's ratio, degrees.
const RATIO_DEG: f64 = 1e-3;

/// What the model says of one reading.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// Status; nothing below holds without a trustworthy one.
    pub status: Status,
    /// Magnitude of the force, N.
    pub force: Predicted,
    /// Torque of the motor, N·mm.
    pub torque: Predicted,
    /// Front centreline, finger frame, mm; empty where none was measured.
    pub front_mm: Vec<Point>,
}

/// A quantity that the model predicts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Predicted {
    /// Its value.
    pub value: f64,
    /// Its derivative with respect to the motor angle, per degree; with friction on the way there, what was before staying the same.
    pub per_deg: f64,
    /// With friction its derivative with respect to the angle at which the motion has turned last, its own angle staying the same, per degree;
    /// else 0.
    pub per_turn_deg: f64,
    /// Its derivatives with respect to the parameters, in their units; empty if they were not asked for.
    pub gradient: Vec<f64>,
}

/// The model that readings are compared with.
pub struct Predictor<'a> {
    /// The design that the parameters change.
    pub design: &'a Design,
    /// Scheme, elements, samples and physics.
    pub discretisation: Discretisation,
    /// How the motor moves the base. Readings are of the motor's angle either way.
    pub drive: Drive,
    /// Terms [gᵢ, τᵢ in s] of a material with memory, which the parameters change; none of an elastic one.
    pub prony: &'a [[f64; 2]],
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
        let rough = run.friction != 0.0 || trial.parameters.contains(&Parameter::Friction);
        if self.prony.is_empty() && !rough {
            let wanted = if derivatives { Wanted::Derivatives } else { Wanted::Force };
            return self.follow(run, trial, wanted);
        }
        // The derivative by a sudden angle is known with memory, and with friction none is.
        let wanted = if rough { Wanted::Force } else { Wanted::Slope };
        let mut here = self.follow(run, trial, wanted)?;
        if derivatives {
            self.differences(run, trial, rough, &mut here)?;
        }
        Ok(here)
    }

    /// With friction or with memory a force depends on the whole way there: derivatives are differences of whole runs.
    fn differences(
        &self,
        run: &Readings,
        trial: &Trial,
        rough: bool,
        here: &mut [Prediction],
    ) -> Result<(), DiscretiseError> {
        let known =
            |here: &Prediction, there: &Prediction| here.status.is_trustworthy() && there.status.is_trustworthy();
        if rough {
            self.slopes(run, trial, here)?;
        }
        let step = if rough { ROUGH_STEP } else { STEP };
        for (index, parameter) in trial.parameters.iter().enumerate() {
            let step = step * parameter.doubt(self.design, self.prony);
            let mut other = trial.clone();
            other.values[index] += step;
            for (here, there) in here.iter_mut().zip(self.follow(run, &other, Wanted::Force)?) {
                let known = known(here, &there);
                for (here, there) in here.quantities_mut().into_iter().zip([&there.force, &there.torque]) {
                    here.gradient.push(if known { (there.value - here.value) / step } else { 0.0 });
                }
            }
        }
        Ok(())
    }

    /// What errors of the angles make of readings with friction: the model has no derivative with respect to the angle either. Where contacts
    /// stick after a turn, a force changes much more with its own angle than it does where all of them slip, and it changes with the angle of
    /// the turn, which all readings after it share.
    fn slopes(&self, run: &Readings, trial: &Trial, here: &mut [Prediction]) -> Result<(), DiscretiseError> {
        let (way, steps) = run.by_steps(ANGLE_STEP_DEG);
        let by_steps = self.follow(&way, trial, Wanted::Force)?;
        let mut slopes = [0.0; 2];
        for ((here, pair), step) in here.iter_mut().zip(by_steps.chunks_exact(2)).zip(steps) {
            let [before, now] = pair else { continue };
            // A motor that rests is where it came to.
            if step != 0.0 {
                let is_known = [&*here, before, now].iter().all(|of| of.status.is_trustworthy());
                let slope = |before: &Predicted, now: &Predicted| (now.value - before.value) / step;
                let [force, torque] = [slope(&before.force, &now.force), slope(&before.torque, &now.torque)];
                slopes = if is_known { [force, torque] } else { [0.0; 2] };
            }
            for (here, slope) in here.quantities_mut().into_iter().zip(slopes) {
                here.per_deg = slope;
            }
        }
        let turns = run.turns();
        if turns.is_empty() {
            return Ok(());
        }
        let mut other = run.clone();
        for &turn in &turns {
            other.readings[turn].angle_deg += ANGLE_STEP_DEG;
        }
        for (index, (here, there)) in here.iter_mut().zip(self.follow(&other, trial, Wanted::Force)?).enumerate() {
            let is_known = here.status.is_trustworthy() && there.status.is_trustworthy();
            if !is_known || index <= turns[0] || turns.contains(&index) {
                continue;
            }
            for (here, there) in here.quantities_mut().into_iter().zip([&there.force, &there.torque]) {
                here.per_turn_deg = (there.value - here.value) / ANGLE_STEP_DEG;
            }
        }
        Ok(())
    }

    /// Follows a run, along the readings' times if the material has memory.
    fn follow(&self, run: &Readings, trial: &Trial, wanted: Wanted) -> Result<Vec<Prediction>, DiscretiseError> {
        // What cannot be is something that nothing is known about.
        let unknown = || run.readings.iter().map(|_| Prediction::unknown(Status::OutOfRange)).collect();
        let design = trial.design(self.design);
        let object = trial.object(run.object, self.design);
        if object.validate().is_err() {
            return Ok(unknown());
        }
        let options = Options { discretisation: self.discretisation, ..Options::default() };
        let motion = self.drive.motion(design.motor_axis);
        let mut follower = follower::<f64>(&design, object, motion, &options)?;
        let remembers = !self.prony.is_empty();
        if remembers && follower.set_prony(&trial.prony(self.prony)).is_err() {
            return Ok(unknown());
        }
        if follower.set_friction(trial.friction(run.friction, self.design)).is_err() {
            return Ok(unknown());
        }
        let zero = trial.change(Parameter::Zero, self.design);
        let travel = trial.travel(self.design);
        let scale = if self.drive == Drive::Rotating { 1.0 } else { travel };
        // The motion's coordinate, rad or mm, and its derivative by the motor's angle; none outside a drive's table.
        let at_angle = |angle_deg: f64| {
            let [coordinate, slope] = self.drive.coordinate((angle_deg + zero).to_radians())?;
            Some([scale * coordinate, scale * slope])
        };
        let at = |reading: &Reading| at_angle(reading.angle_deg);
        if let Some([first, _]) = run.readings.iter().find_map(at) {
            follower.start(first);
        }
        let mut before = 0.0;
        let mut probe = Probe::EMPTY;
        let predictions = run.readings.iter().map(|reading| {
            let time = reading.time_s.filter(|_| remembers).unwrap_or(before);
            let time_step_s = time - before;
            before = time;
            let Some([coordinate, slope]) = at(reading) else { return Prediction::unknown(Status::OutOfRange) };
            let status = follower.follow(Target { coordinate, time_step_s }).status;
            if !status.is_trustworthy() {
                return Prediction::unknown(status);
            }
            let force = follower.solution().force_world();
            let size = force[0].hypot(force[1]);
            // Of a base that is moved along a line it is a force times what the drive moves it by.
            let moment = follower.solution().motor_torque();
            let mut prediction = Prediction::unknown(status);
            (prediction.force.value, prediction.torque.value) = (size, moment * slope);
            if !reading.front_mm.is_empty() {
                prediction.front_mm = follower.solution().front().collect();
            }
            if size == 0.0 || wanted == Wanted::Force {
                let count = if wanted == Wanted::Derivatives { trial.parameters.len() } else { 0 };
                prediction.quantities_mut().into_iter().for_each(|quantity| quantity.gradient = vec![0.0; count]);
                return prediction;
            }
            let along = |v: [f64; 2]| (v[0] * force[0] + v[1] * force[1]) / size;
            // More samples touch than there is room for: no derivative, and the status says so.
            let Some(found) = follower.sensitivity() else { return Prediction::unknown(Status::ContactCapacity) };
            prediction.force.per_deg = (along(found.coordinate.force) * slope).to_radians();
            // A crank's ratio changes, too.
            let ratios =
                [RATIO_DEG, -RATIO_DEG].map(|by| at_angle(reading.angle_deg + by).map_or(slope, |[_, slope]| slope));
            let bend = (ratios[0] - ratios[1]) / (2.0 * RATIO_DEG.to_radians());
            prediction.torque.per_deg = (found.coordinate.torque * slope * slope + moment * bend).to_radians();
            if wanted == Wanted::Slope {
                return prediction;
            }
            for &parameter in &trial.parameters {
                // Of the force, and of the moment that the drive moves the base against.
                let of = |found: Derivative<f64>| Some([along(found.force), found.torque * slope]);
                let derivative = match parameter {
                    Parameter::YoungsModulus => of(found.youngs_modulus),
                    Parameter::Zero => Some([prediction.force.per_deg, prediction.torque.per_deg]),
                    Parameter::ObjectX => of(found.centre[0]),
                    Parameter::ObjectY => of(found.centre[1]),
                    Parameter::Radius => of(found.radius),
                    // Of runs with friction: [`Predictor::differences`].
                    Parameter::Friction => None,
                    Parameter::Travel => of(found.coordinate).map(|[force, torque]| {
                        [force * coordinate / travel, (torque * coordinate + moment * slope) / travel]
                    }),
                    // Without memory nothing depends on its terms.
                    Parameter::Share(_) | Parameter::Fading(_) => None,
                    Parameter::Design(dimension) => {
                        follower.design_sensitivity(&mut probe, &design, &self.discretisation, dimension).and_then(of)
                    }
                };
                let [force, torque] = derivative.unwrap_or_default();
                prediction.force.gradient.push(force);
                prediction.torque.gradient.push(torque);
            }
            prediction
        });
        Ok(predictions.collect())
    }
}

/// What is wanted of a run besides its forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wanted {
    Force,
    /// Also the derivative with respect to the motor angle, if that is sudden.
    Slope,
    /// Also the derivatives with respect to the parameters, of a finger without memory and friction.
    Derivatives,
}

impl Prediction {
    fn quantities_mut(&mut self) -> [&mut Predicted; 2] {
        [&mut self.force, &mut self.torque]
    }

    fn unknown(status: Status) -> Self {
        let [force, torque] = <[Predicted; 2]>::default();
        Self { status, force, torque, front_mm: Vec::new() }
    }
}
