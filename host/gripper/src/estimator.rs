//! The estimator of the microcontroller on this PC, at any resolution and in either precision.

use messages::{Report, Shape};
use model_core::bounds::OutOfBounds;
use model_core::design::Design;
use model_core::discretise::{Discretisation, DiscretiseError};
use model_core::drive::{Drive, DriveError};
use model_core::estimator::{Estimate, Estimator};
use model_core::newton::Hessian;
use model_core::object::{ObjectDesign, ObjectError};
use model_core::real::Real;
use model_core::size::Size;
use model_core::uncertainty::{Uncertainty, UncertaintyError};

use fre::heap::Host;
use fre::study::model::Precision;

/// An estimator of one finger, as `model_core`'s [`Estimator`].
pub trait AnyEstimator: Send {
    /// Takes a finger; the state starts anew.
    ///
    /// # Errors
    /// What the discretisation refuses.
    fn configure(&mut self, design: &Design, how: &Discretisation) -> Result<(), DiscretiseError>;

    /// Takes an object, world frame; the state starts anew.
    ///
    /// # Errors
    /// What is wrong with it.
    fn set_object(&mut self, object: ObjectDesign) -> Result<(), ObjectError>;

    /// Says how uncertain angle and parameters are.
    ///
    /// # Errors
    /// The first value that is not allowed.
    fn set_uncertainty(&mut self, uncertainty: Uncertainty) -> Result<(), UncertaintyError>;

    /// Says how the motor moves the base.
    ///
    /// # Errors
    /// What is wrong with it.
    fn set_drive(&mut self, drive: Drive) -> Result<(), DriveError>;

    /// Takes a coefficient of friction between finger and object, 0 for none; the state starts anew, if it is another one.
    ///
    /// # Errors
    /// A coefficient out of range.
    fn set_friction(&mut self, coefficient: f64) -> Result<(), OutOfBounds>;

    /// Takes the terms [gᵢ, τᵢ in s] of a material with memory, none for an elastic one; the state starts anew, if they are others.
    ///
    /// # Errors
    /// Terms out of range.
    fn set_prony(&mut self, terms: &[[f64; 2]]) -> Result<(), OutOfBounds>;

    /// Ticks were lost, or the finger was moved unseen: with friction the force is unknown within an interval until a motion makes it certain.
    fn forget_path(&mut self);

    /// Estimates at a motor angle, rad, so many seconds after the estimate before.
    fn update_after(&mut self, motor_angle: f64, seconds: f64) -> Estimate;

    /// Estimates at a motor angle, rad; no time passes.
    fn update(&mut self, motor_angle: f64) -> Estimate {
        self.update_after(motor_angle, 0.0)
    }

    /// The deformed finger behind a report.
    fn shape(&self, report: &Report) -> Shape;
}

impl<T: Real + Send, S: Size> AnyEstimator for Estimator<T, S>
where
    Self: Send,
{
    fn configure(&mut self, design: &Design, how: &Discretisation) -> Result<(), DiscretiseError> {
        self.configure(design, how)
    }

    fn set_object(&mut self, object: ObjectDesign) -> Result<(), ObjectError> {
        self.set_object(object)
    }

    fn set_uncertainty(&mut self, uncertainty: Uncertainty) -> Result<(), UncertaintyError> {
        self.set_uncertainty(uncertainty)
    }

    fn set_drive(&mut self, drive: Drive) -> Result<(), DriveError> {
        self.set_drive(drive)
    }

    fn set_friction(&mut self, coefficient: f64) -> Result<(), OutOfBounds> {
        self.set_friction(coefficient)
    }

    fn set_prony(&mut self, terms: &[[f64; 2]]) -> Result<(), OutOfBounds> {
        self.set_prony(terms)
    }

    fn forget_path(&mut self) {
        self.forget_path();
    }

    fn update_after(&mut self, motor_angle: f64, seconds: f64) -> Estimate {
        self.update_after(motor_angle, seconds)
    }

    fn shape(&self, report: &Report) -> Shape {
        Shape::of(self.follower(), report)
    }
}

/// An estimator without finger and object; every estimate is `out-of-range` until it has both.
pub fn estimator(precision: Precision, hessian: Hessian) -> Box<dyn AnyEstimator> {
    fn with<T: Real + Send>(hessian: Hessian) -> Box<dyn AnyEstimator>
    where
        Estimator<T, Host>: Send,
    {
        let mut estimator: Estimator<T, Host> = Estimator::EMPTY;
        estimator.follower_mut().set_hessian(hessian);
        Box::new(estimator)
    }
    match precision {
        Precision::F32 => with::<f32>(hessian),
        Precision::F64 => with::<f64>(hessian),
    }
}
