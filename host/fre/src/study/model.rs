//! How a case is solved, and the model that follows from it.

use model_core::discretise::{Discretisation, Elements, Physics, Scheme};
use model_core::newton::Hessian;
use serde::{Deserialize, Serialize};

use crate::case::Case;

/// Floating-point precision of the solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// Single, as on the microcontroller.
    F32,
    /// Double.
    #[default]
    F64,
}

impl Precision {
    /// The word in files and options.
    pub fn word(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}

/// How a case is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Scheme, elements, samples, softness and physics.
    pub discretisation: Discretisation,
    /// Second derivative of the Newton step.
    pub hessian: Hessian,
    /// Precision.
    pub precision: Precision,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            discretisation: Discretisation::fine(Physics::Extended),
            hessian: Hessian::default(),
            precision: Precision::default(),
        }
    }
}

/// The model that made a result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Scheme of beams and hinges.
    pub scheme: Scheme,
    /// Elements of each beam.
    pub elements_per_beam: u32,
    /// Elements of each hinge.
    pub elements_per_hinge: u32,
    /// Angles and stretches.
    pub unknowns: usize,
    /// Physics.
    pub physics: Physics,
    /// Precision.
    pub precision: Precision,
    /// Version of this library and of the program around it.
    pub version: &'static str,
}

impl Model {
    /// The model of a case with so many unknowns.
    pub(super) fn of(case: &Case, options: &Options, unknowns: usize) -> Self {
        let how = &options.discretisation;
        let (Elements::PerBeam { hinge, .. } | Elements::PerSpan { hinge, .. }) = how.elements;
        Self {
            scheme: how.scheme,
            elements_per_beam: how.elements.of_beam(case.finger.design.lamella_count()) as u32,
            elements_per_hinge: u32::from(hinge),
            unknowns,
            physics: how.physics,
            precision: options.precision,
            version: env!("CARGO_PKG_VERSION"),
        }
    }

    /// The model in words: "scheme simpson 32/2, physics extended, f64".
    pub fn words(&self) -> String {
        format!(
            "scheme {} {}/{}, physics {}, {}",
            scheme_word(self.scheme),
            self.elements_per_beam,
            self.elements_per_hinge,
            physics_word(self.physics),
            self.precision.word()
        )
    }
}

/// The word for a scheme in files and options.
pub fn scheme_word(scheme: Scheme) -> &'static str {
    match scheme {
        Scheme::Paper => "paper",
        Scheme::Trapezoid => "trapezoid",
        Scheme::Simpson => "simpson",
    }
}

/// The word for a physics in files and options.
pub fn physics_word(physics: Physics) -> &'static str {
    match physics {
        Physics::Paper => "paper",
        Physics::Extended => "extended",
    }
}
