//! Fits the model's parameters to measurements: modulus, zero angle, where the objects are, the finger's dimensions.
//!
//! [`fit()`] returns values with standard deviations, their correlation, and what the data do not tell. Readings belong to
//! closing motions: backlash shifts those of an opening one, so [`Readings::closing`] leaves them out, and what remains of it, always
//! on the same side, is part of the zero angle.

mod fit;
mod gripper;
mod input;
mod noise;
mod parameter;
mod picture;
mod plan;
mod predictor;
mod readings;
mod report;
mod rests;
mod rows;
pub mod synthetic;
mod trial;

pub use fit::{Combination, Estimate, Fit, FitError, Inflation, Progress, Quantity, Residual, fit, fit_watched};
pub use gripper::{uncertainty, zero_counts};
pub use input::{Input, InputError};
pub use noise::{Loss, Noise};
pub use parameter::Parameter;
pub use picture::picture;
pub use plan::{Plan, PlanError, expect, plan_text};
pub use predictor::{Prediction, Predictor};
pub use readings::{Reading, Readings};
pub use report::{document, fitted_finger, text};
pub use trial::Trial;
