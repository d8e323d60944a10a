//! The contact of a finger with friction, or of a material with memory, every strain of which remembers. Its forces depend on the way and on
//! time, so that no table has them: the model follows the motor.

use std::f64::consts::PI;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use model_core::design::Design;
use model_core::drive::Drive;
use model_core::equilibrium::{Follower, Target};
use model_core::object::ObjectDesign;
use model_core::real::Real;
use model_core::status::Status;

use super::contact::{Contact, LoadError};
use fre::heap::Host;
use fre::study::follow::follower;
use fre::study::model::{Options, Precision};

/// The model follows steps of a quarter of a count, rad; between them the contact stays as it is.
const STEP: f64 = PI / 8192.0;
/// A finger of a material with memory that rests is looked at after this time, s, and then again after this part of the time that has passed
/// since it moved: what relaxes, does so ever more slowly.
const LOOK: (f64, f64) = (2e-3, 0.02);

/// What is followed.
#[derive(Clone, Debug)]
pub(super) struct Rough {
    pub design: Design,
    pub object: ObjectDesign,
    /// Coefficient of friction.
    pub friction: f64,
    /// Terms [gᵢ, τᵢ in s] of a material with memory.
    pub prony: Vec<[f64; 2]>,
    pub drive: Drive,
    pub options: Options,
}

/// The contact of a finger that has come some way. Copies are the same finger.
#[derive(Clone)]
pub(super) struct Rub(Arc<Mutex<Way>>);

/// The contact at a motor angle, rad, to which the finger goes within a time, s; none where the model cannot be followed.
type Follow = Box<dyn FnMut(f64, f64) -> Option<Contact> + Send>;

struct Way {
    follow: Follow,
    /// The motor angle that was followed last, rad.
    at: f64,
    contact: Contact,
    /// Whether time matters.
    relaxes: bool,
    /// Time since it was followed, and since it moved, s.
    waits: f64,
    rests: f64,
}

impl fmt::Debug for Rub {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Rub")
    }
}

impl Rough {
    /// A finger that has been open.
    pub fn open(&self) -> Result<Rub, LoadError> {
        let follow = match self.options.precision {
            Precision::F64 => self.followed::<f64>()?,
            Precision::F32 => self.followed::<f32>()?,
        };
        let relaxes = !self.prony.is_empty();
        let way = Way { follow, at: f64::NEG_INFINITY, contact: Contact::NONE, relaxes, waits: 0.0, rests: 0.0 };
        Ok(Rub(Arc::new(Mutex::new(way))))
    }

    fn followed<T: Real + Send>(&self) -> Result<Follow, LoadError>
    where
        Follower<T, Host>: Send,
    {
        let motion = self.drive.motion(self.design.motor_axis);
        let made = follower::<T>(&self.design, self.object, motion, &self.options);
        let mut finger = Box::new(made.map_err(LoadError::Discretise)?);
        finger.set_friction(self.friction).map_err(LoadError::Friction)?;
        finger.set_prony(&self.prony).map_err(LoadError::Memory)?;
        let [zero, _] = self.drive.coordinate(0.0).ok_or(LoadError::NoZero)?;
        if !finger.start(zero) {
            return Err(LoadError::NoRoom);
        }
        let drive = self.drive;
        Ok(Box::new(move |angle, seconds| {
            let [coordinate, slope] = drive.coordinate(angle)?;
            let status = finger.follow(Target { coordinate, time_step_s: seconds }).status;
            status.is_trustworthy().then(|| Contact {
                // Of the motor: a force times the way per angle.
                torque: finger.solution().motor_torque().to_f64() * slope,
                force: finger.solution().force_world().map(Real::to_f64),
                status,
            })
        }))
    }
}

impl Rub {
    /// The contact at a motor angle without play, rad, to which the finger goes straight from where it was, so many seconds after it was asked
    /// before.
    pub fn at(&self, angle: f64, seconds: f64) -> Contact {
        let mut way = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        way.waits += seconds;
        way.rests += seconds;
        let moves = (angle - way.at).abs() >= STEP;
        if moves {
            way.rests = 0.0;
        }
        if moves || way.relaxes && way.waits >= LOOK.0 + LOOK.1 * way.rests {
            let waited = std::mem::take(&mut way.waits);
            match (way.follow)(angle, waited) {
                Some(contact) => (way.at, way.contact) = (angle, contact),
                None => way.contact.status = Status::OutOfRange,
            }
        }
        way.contact
    }
}
