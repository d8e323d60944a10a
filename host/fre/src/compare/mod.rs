//! A case against finite elements or measurements, with the metrics of *Geometrico-Static Modelling of a FRE
//! Finger*.

mod comparison;
mod elements;
mod error;
mod measurements;
mod notes;
mod order;
mod outlying;
mod pictures;
mod words;

pub use comparison::{Comparison, Elements, OutlyingPoint, Reading, Reference, Row};
pub use elements::{with_elements, with_elements_watched};
pub use error::CompareError;
pub use measurements::{with_measurements, with_measurements_watched};
pub use order::Order;
