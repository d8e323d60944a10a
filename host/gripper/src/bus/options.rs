//! What is on a bus, and how it is estimated.

use messages::Settings;
use model_core::newton::Hessian;

use crate::source::Modelled;
use fre::study::model::Precision;

/// What is on the bus, and how it is estimated.
#[derive(Clone, Debug, PartialEq)]
pub struct BusOptions {
    /// Rate, shapes and mounts.
    pub settings: Settings,
    /// Whether the mounts name the servos; otherwise those that answer are the fingers, in the order of their addresses.
    pub names_servos: bool,
    /// One model per finger; the last one stands for those behind it.
    pub models: Vec<Modelled>,
    /// Precision.
    pub precision: Precision,
    /// Second derivative of the Newton step.
    pub hessian: Hessian,
}
