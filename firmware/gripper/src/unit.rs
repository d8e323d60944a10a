//! One finger within the control task: its mount, its model, its grip, its last report.

use dynamixel::Id;
use messages::{Calibration, Difference, Direction, Mount, Report, Settings};
use model_core::estimator::Estimate;
use model_core::uncertainty::{Uncertainty, UncertaintyError};

use crate::Model;
use crate::budget::Budget;
use crate::contact::{Contact, Told};
use crate::free::Pending;
use crate::grip::{Grip, Touch};
use crate::health::Health;
use crate::servo::Reading;
use crate::shared::Shared;

/// A finger.
pub(crate) struct Unit<'a> {
    pub(crate) model: &'a mut Model,
    /// Nothing: the gripper has no such finger.
    pub(crate) mount: Option<Mount>,
    pub(crate) calibration: Calibration,
    pub(crate) grip: Grip,
    pub(crate) contact: Contact,
    pub(crate) budget: Budget,
    pub(crate) health: Health,
    pub(crate) last: Report,
    /// What waits for the other fingers on a free object.
    pub(crate) pending: Option<Pending>,
    pub(crate) alert: bool,
    pub(crate) alert_changed: bool,
    /// Whether the model has a design and an object: without, no force can be asked for.
    pub(crate) has_design: bool,
    pub(crate) has_object: bool,
    /// What a calibration has left uncertain, if there was one.
    uncertainty: Option<Uncertainty>,
    /// When the position behind the last estimate was heard, µs; nothing while the gripper leads the servo itself.
    pub(crate) heard_us: Option<u64>,
    /// The hardware errors last heard of.
    pub(crate) hardware_error: u8,
    /// How its servo is not what it should be, as it was last reported.
    pub(crate) difference: Option<Difference>,
    /// Whether this tick's report is made.
    pub(crate) is_reported: bool,
}

impl<'a> Unit<'a> {
    pub(crate) fn new(finger: u8, model: &'a mut Model, mount: Option<Mount>) -> Self {
        let of = mount.unwrap_or(Mount::DEFAULT);
        // A mount's drive was checked with the settings.
        let _ = model.set_drive(of.drive);
        Self {
            model,
            mount,
            calibration: Calibration::new(&of),
            grip: Grip::REST,
            contact: Contact::NONE,
            budget: Budget::NEW,
            health: Health::Absent,
            last: Report::blank(finger),
            pending: None,
            alert: false,
            alert_changed: false,
            has_design: false,
            has_object: false,
            uncertainty: None,
            heard_us: None,
            hardware_error: 0,
            difference: None,
            is_reported: false,
        }
    }

    /// Nothing more is to be done for it in this tick but to wait for the others.
    pub(crate) fn is_done(&self) -> bool {
        self.is_reported || self.pending.is_some()
    }

    /// Says how uncertain its parameters are.
    pub(crate) fn set_uncertainty(&mut self, given: Option<Uncertainty>) -> Result<(), UncertaintyError> {
        self.model.set_uncertainty(self.calibration.uncertainty(given))?;
        self.uncertainty = given;
        Ok(())
    }

    /// Takes design, object and uncertainty that were kept in flash.
    pub(crate) fn restore(&mut self, shared: &Shared) {
        let finger = self.last.finger;
        let number = usize::from(finger);
        let (design, object, uncertainty) = shared.setup(|setup| {
            (
                setup.fingers.get(number).cloned().flatten(),
                setup.objects.get(number).copied().flatten(),
                setup.uncertainties.get(number).copied().flatten(),
            )
        });
        if self.set_uncertainty(uncertainty).is_err() {
            shared.set_uncertainty(finger, None);
        }
        if let Some(design) = design {
            self.has_design = self.model.configure(&design.design, &design.how).is_ok();
            if !self.has_design {
                shared.set_design(finger, None);
            }
        }
        self.has_object = object.is_some_and(|object| self.model.set_object(object).is_ok());
    }

    /// Its servo's address, if the gripper has this finger.
    pub(crate) fn id(&self) -> Option<Id> {
        self.mount.and_then(|mount| Id::new(mount.servo_id))
    }

    /// Takes a mount, or none.
    pub(crate) fn set_mount(&mut self, mount: Option<Mount>) {
        if mount == self.mount {
            return;
        }
        let id = self.id();
        let at = self.calibration.position(self.grip.goal());
        self.mount = mount;
        let of = mount.unwrap_or(Mount::DEFAULT);
        self.calibration = Calibration::new(&of);
        // Checked with the settings.
        let _ = self.model.set_drive(of.drive);
        // Of another gear: a value that was taken before is taken again.
        let _ = self.set_uncertainty(self.uncertainty);
        // The motor stays where it is, at the angle it now is called.
        self.grip.renamed(self.calibration.angle(at));
        if self.id() != id {
            self.health = Health::Absent;
        }
        self.difference = None;
    }

    /// Somebody else leads the servo from now on, or does so no more.
    pub(crate) fn forget_servo(&mut self) {
        self.health = Health::Absent;
        self.heard_us = None;
        self.hardware_error = 0;
        self.difference = None;
        self.grip.renamed(self.grip.goal());
    }

    /// The next goal, counts.
    pub(crate) fn advance(&mut self, seconds: f64) -> i32 {
        let goal = match &self.mount {
            Some(mount) => self.grip.advance(seconds, mount),
            None => self.grip.goal(),
        };
        self.calibration.position(goal)
    }

    /// What the current shows.
    pub(crate) fn witness(&mut self, reading: &Reading, seconds: f64) -> Told {
        let estimate = &self.last.estimate;
        let trust = estimate.status.is_trustworthy() && estimate.age == 0;
        // Through the gears, and in the finger's direction.
        let ratio = self.mount.map_or(1.0, |mount| match mount.direction {
            Direction::Same => mount.gear_ratio,
            Direction::Reversed => -mount.gear_ratio,
        });
        let demanded = trust.then_some(estimate.torque);
        let angle = self.calibration.angle(reading.position);
        self.contact.feel(angle, reading.current * ratio, self.calibration.count(), demanded, seconds as f32)
    }

    /// Leads by what the servo and the model say.
    pub(crate) fn feel(&mut self, reading: &Reading, seconds: f64, settings: &Settings) {
        let Some(mount) = &self.mount else {
            return;
        };
        let estimate = &self.last.estimate;
        let trust = estimate.status.is_trustworthy() && estimate.age == 0;
        let touch = Touch {
            angle: self.calibration.angle(reading.position),
            force: trust.then(|| f64::from(estimate.force_magnitude())),
            slope: force_slope(estimate),
            has_model: self.has_design && self.has_object,
            current: match mount.direction {
                Direction::Same => reading.current,
                Direction::Reversed => -reading.current,
            },
            alert: reading.alert,
        };
        self.grip.feel(&touch, self.calibration.count(), seconds, mount, settings);
    }
}

/// Slope of the force's magnitude over the motor angle, N/rad, if the estimate knows it.
fn force_slope(estimate: &Estimate) -> Option<f64> {
    let ([x, y], [u, v], force) = (estimate.force, estimate.force_per_angle, estimate.force_magnitude());
    let slope = f64::from((x * u + y * v) / force);
    slope.is_finite().then_some(slope)
}
