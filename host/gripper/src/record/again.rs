//! The estimator once more, on recorded positions: other settings, another finger or object, and what that changes.

use messages::{Calibration, FINGERS, Report, Shape};
use model_core::discretise::{Elements, Physics};
use model_core::estimator::Estimate;
use model_core::newton::Hessian;
use model_core::object::Motion;
use model_core::status::Status;

use crate::estimator::{AnyEstimator, estimator};
use crate::link::{KeyError, set};
use crate::source::{Modelled, Setup};
use fre::drive::fits_finger;
use fre::study::model::Precision;

/// What is changed of the recorded set-up.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// Settings as KEY=VALUE: zero, direction, gear ratio, play of a finger.
    pub settings: Vec<String>,
    /// Finger and object in place of the recorded ones; what is `None` stays. The last one stands for those behind it.
    pub models: Vec<Modelled>,
    /// How the bases of the cases move that `models` are of, in their order; they have to move as the drives do.
    pub motions: Vec<Motion>,
    /// Young's modulus, MPa.
    pub youngs_modulus: Option<f64>,
    /// Other elements.
    pub elements: Option<Elements>,
    /// Other physics.
    pub physics: Option<Physics>,
    /// Precision; the microcontroller's is single.
    pub precision: Precision,
}

/// Why the estimator cannot run on a recording.
#[derive(Debug, thiserror::Error)]
pub enum AgainError {
    /// A setting.
    #[error("{0}")]
    Key(#[from] KeyError),
    /// What the estimator refuses, or what is not allowed.
    #[error("finger {finger}: {why}")]
    Refused {
        /// Which finger.
        finger: usize,
        /// What is wrong.
        why: String,
    },
}

/// Estimators in the state in which the recording's were.
pub struct Again {
    changes: Changes,
    fingers: Vec<Finger>,
}

struct Finger {
    model: Modelled,
    calibration: Calibration,
    estimator: Box<dyn AnyEstimator>,
    last: Option<Estimate>,
    /// When the last position came, µs.
    seen_us: Option<u64>,
    /// Reports in a row without a position.
    unseen: u32,
}

/// As many in a row, and nobody knows which way the finger has come: as the gripper's firmware has it.
const UNSEEN: u32 = 5;

impl Again {
    /// With these changes; [`Again::set_up`] is to be called first.
    pub fn new(changes: Changes) -> Self {
        Self { changes, fingers: Vec::new() }
    }

    /// Takes the recorded set-up; gives it as it is now. Fingers whose design or object changes start anew.
    ///
    /// # Errors
    /// A change that makes no sense, or that the estimator refuses.
    pub fn set_up(&mut self, recorded: &Setup) -> Result<Setup, AgainError> {
        let mut setup = recorded.clone();
        for words in &self.changes.settings {
            set(&mut setup.settings, words)?;
        }
        setup
            .settings
            .validate(FINGERS)
            .map_err(|refusal| AgainError::Refused { finger: 0, why: refusal.to_string() })?;
        for (number, mount) in setup.settings.fingers.iter().flatten().enumerate() {
            let model = setup.models.get(number).cloned().unwrap_or_default();
            let model = self.changes.apply(number, model);
            let motions = &self.changes.motions;
            if let Some(motion) = motions.get(number).or(motions.last()) {
                fits_finger(motion, &mount.drive, number)
                    .map_err(|why| AgainError::Refused { finger: number, why: format!("the case's {why}") })?;
            }
            let calibration = Calibration::new(&mount.gear());
            // Another uncertainty is no other equilibrium.
            let is_same = |known: &Modelled| (&known.finger, known.grasped()) == (&model.finger, model.grasped());
            match self.fingers.get_mut(number).filter(|finger| is_same(&finger.model)) {
                Some(finger) => finger.calibration = calibration,
                None => {
                    let made = make(&model, self.changes.precision);
                    let estimator = made.map_err(|why| AgainError::Refused { finger: number, why })?;
                    let finger =
                        Finger { model: model.clone(), calibration, estimator, last: None, seen_us: None, unseen: 0 };
                    if number < self.fingers.len() { self.fingers[number] = finger } else { self.fingers.push(finger) }
                }
            }
            if let Some(finger) = self.fingers.get_mut(number) {
                let given = mount.uncertainty(model.uncertainty);
                let set = finger.estimator.set_uncertainty(given);
                set.map_err(|error| AgainError::Refused { finger: number, why: error.to_string() })?;
                let set = finger.estimator.set_drive(mount.drive);
                set.map_err(|error| AgainError::Refused { finger: number, why: error.to_string() })?;
            }
            if let Some(place) = setup.models.get_mut(number) {
                *place = model;
            }
        }
        Ok(setup)
    }

    /// The report with the force that the estimator says now. A report without a position stays without.
    pub fn report(&mut self, report: &Report) -> Report {
        let Some(finger) = self.fingers.get_mut(usize::from(report.finger)) else { return *report };
        let before = finger.last.unwrap_or(Estimate::blank(Status::Stale));
        let estimate = if report.estimate.status == Status::Stale {
            finger.unseen += 1;
            Estimate { status: Status::Stale, age: before.age.saturating_add(1), iterations: 0, ..before }
        } else {
            if std::mem::take(&mut finger.unseen) >= UNSEEN {
                finger.estimator.forget_path();
            }
            let since = finger.seen_us.replace(report.time_us).unwrap_or(report.time_us);
            let seconds = 1e-6 * report.time_us.saturating_sub(since) as f64;
            let estimate = finger.estimator.update_after(finger.calibration.finger_angle(report.position), seconds);
            let age = if estimate.age == 0 { 0 } else { before.age.saturating_add(1) };
            Estimate { age, ..estimate }
        };
        finger.last = Some(estimate);
        Report { estimate, ..*report }
    }

    /// The shape behind a report that was made last.
    pub fn shape(&self, report: &Report) -> Option<Shape> {
        self.fingers.get(usize::from(report.finger)).map(|finger| finger.estimator.shape(report))
    }
}

impl Changes {
    fn apply(&self, number: usize, recorded: Modelled) -> Modelled {
        let other = self.models.get(number).or(self.models.last()).cloned().unwrap_or_default();
        let grasped = other.grasped().or(recorded.grasped());
        let mut model = Modelled {
            finger: other.finger.or(recorded.finger),
            uncertainty: other.uncertainty.or(recorded.uncertainty),
            ..Modelled::default()
        };
        model.grasp(grasped);
        if let Some(finger) = &mut model.finger {
            let material = &mut finger.design.material;
            material.youngs_modulus = self.youngs_modulus.unwrap_or(material.youngs_modulus);
            finger.how.elements = self.elements.unwrap_or(finger.how.elements);
            finger.how.physics = self.physics.unwrap_or(finger.how.physics);
        }
        model
    }
}

fn make(model: &Modelled, precision: Precision) -> Result<Box<dyn AnyEstimator>, String> {
    let mut made = estimator(precision, Hessian::default());
    if let Some(finger) = &model.finger {
        finger.design.validate().map_err(|error| error.to_string())?;
        made.configure(&finger.design, &finger.how).map_err(|error| error.to_string())?;
        made.set_prony(&finger.terms()).map_err(|error| error.to_string())?;
    }
    if let Some(object) = model.object {
        made.set_friction(model.friction).map_err(|error| error.to_string())?;
        made.set_object(object).map_err(|error| error.to_string())?;
    }
    Ok(made)
}

/// How the forces of two estimates of one finger differ, over the reports that are trustworthy in both.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Difference {
    /// Reports.
    pub reports: u64,
    /// Those with a trustworthy estimate before, and now.
    pub trustworthy: [u64; 2],
    /// Those that are compared: trustworthy both times, with contact at least once.
    pub compared: u64,
    /// Sum of the magnitudes before and now, N.
    sums: [f64; 2],
    /// Sum of the squared differences of the force vectors, N².
    squares: f64,
    /// The largest difference, N, and when, µs of the source's time.
    pub largest: (f64, u64),
}

impl Difference {
    /// Takes a report before and now.
    pub fn take(&mut self, before: &Report, now: &Report) {
        self.reports += 1;
        let good = [before, now].map(|report| report.estimate.status.is_trustworthy() && report.estimate.age == 0);
        (0..2).for_each(|which| self.trustworthy[which] += u64::from(good[which]));
        let [a, b] = [before, now].map(|report| report.estimate.force.map(f64::from));
        let sizes = [a[0].hypot(a[1]), b[0].hypot(b[1])];
        if good != [true, true] || sizes == [0.0; 2] {
            return;
        }
        self.compared += 1;
        (0..2).for_each(|which| self.sums[which] += sizes[which]);
        let apart = (a[0] - b[0]).hypot(a[1] - b[1]);
        self.squares += apart * apart;
        if apart > self.largest.0 {
            self.largest = (apart, now.time_us);
        }
    }

    /// Mean magnitudes before and now, and the root mean square of the difference, N; none without contact.
    pub fn means(&self) -> Option<([f64; 2], f64)> {
        let count = self.compared as f64;
        (self.compared > 0).then(|| (self.sums.map(|sum| sum / count), (self.squares / count).sqrt()))
    }
}
