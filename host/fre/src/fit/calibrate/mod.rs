//! Fits the model's parameters to measurements: modulus, zero angle, where the objects stand, the finger's dimensions.
//!
//! [`fit()`] returns values with standard deviations, their correlation, and what the data do not tell. Readings belong to
//! closing motions: backlash shifts those of an opening one, so [`Run::closing`] leaves them out, and what remains of it, always
//! on the same side, is part of the zero angle.

mod fit;
mod gripper;
mod input;
mod parameter;
mod picture;
mod report;
mod run;
pub mod synthetic;

pub use fit::{Combination, Estimate, Fit, Loss, Noise, Residual, fit};
pub use gripper::{uncertainty, zero_counts};
pub use input::{Input, InputError};
pub use parameter::Parameter;
pub use picture::picture;
pub use report::{document, fitted_finger, text};
pub use run::{Model, Prediction, Reading, Run, Trial};
