//! How a model is chosen: words for resolutions, and what samples and softness are where they are not given.

use model_core::discretise::{Discretisation, Elements, Physics, Sampling, Scheme, Softness};
use model_core::newton::Hessian;

use crate::study::model::{Options, Precision};

/// The most elements per beam or hinge.
const MOST_ELEMENTS: u16 = 2000;

/// What a person chooses of a model; the rest follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Scheme of beams and hinges.
    pub scheme: Scheme,
    /// Resolution.
    pub elements: Elements,
    /// Contact samples per element. Default: 4 with `simpson`; the other schemes sample at their nodes.
    pub samples: Option<u8>,
    /// Contact softness, mm/N. Default: with samples the front beam's own, with nodes 0.
    pub softness: Option<f64>,
    /// Physics.
    pub physics: Physics,
    /// Second derivative of the Newton step.
    pub hessian: Hessian,
    /// Precision.
    pub precision: Precision,
}

impl Choice {
    /// The options that it comes to.
    pub fn options(self) -> Options {
        let sampling = match (self.samples, self.scheme) {
            (Some(samples), _) => Sampling::PerElement(samples),
            (None, Scheme::Simpson) => Sampling::PerElement(4),
            (None, _) => Sampling::Nodes,
        };
        let softness = match (self.softness, sampling) {
            (Some(softness), _) => Softness::Fixed(softness),
            (None, Sampling::PerElement(_)) => Softness::Local,
            (None, Sampling::Nodes) => Softness::Fixed(0.0),
        };
        let Self { scheme, elements, physics, hessian, precision, .. } = self;
        Options { discretisation: Discretisation { scheme, elements, sampling, softness, physics }, hessian, precision }
    }
}

/// Reads a resolution: `paper`, `reduced`, `fine`, or elements per beam and per hinge as `B/H`.
///
/// # Errors
/// What is allowed.
pub fn elements(text: &str) -> Result<Elements, String> {
    match text {
        "paper" => return Ok(Elements::PAPER),
        "reduced" => return Ok(Elements::REDUCED),
        "fine" => return Ok(Elements::FINE),
        _ => {}
    }
    let allowed = || format!("allowed is B/H with 1 to {MOST_ELEMENTS} elements each, paper, reduced or fine");
    let count = |text: &str| text.parse::<u16>().ok().filter(|count| (1..=MOST_ELEMENTS).contains(count));
    let (beam, hinge) = text.split_once('/').ok_or_else(allowed)?;
    match (count(beam), count(hinge)) {
        (Some(beam), Some(hinge)) => Ok(Elements::PerBeam { beam, hinge }),
        _ => Err(allowed()),
    }
}
