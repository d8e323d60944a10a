//! What a calibration can fit.

use model_core::design::{Design, HingeKind};
use model_core::drive::Drive;
use model_core::object::ObjectDesign;
use model_core::sensitivity::DesignParameter;

/// A parameter, in the unit that people use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// Young's modulus, MPa.
    YoungsModulus,
    /// What is added to a measured motor angle to make it the true one, degrees.
    Zero,
    /// What is added to every object's x, world frame, mm.
    ObjectX,
    /// What is added to every object's y, world frame, mm.
    ObjectY,
    /// What is added to every circle's radius, mm.
    Radius,
    /// What the distances of a drive that moves the base along a line are multiplied by.
    Travel,
    /// A dimension of the finger, mm.
    Design(DesignParameter),
}

impl Parameter {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::YoungsModulus,
        Self::Zero,
        Self::ObjectX,
        Self::ObjectY,
        Self::Radius,
        Self::Travel,
        Self::Design(DesignParameter::FrontThickness),
        Self::Design(DesignParameter::BackThickness),
        Self::Design(DesignParameter::HingeThickness),
        Self::Design(DesignParameter::HingeLength),
    ];

    /// The word on the command line and in outputs.
    pub fn word(self) -> &'static str {
        match self {
            Self::YoungsModulus => "youngs-modulus",
            Self::Zero => "zero",
            Self::ObjectX => "object-x",
            Self::ObjectY => "object-y",
            Self::Radius => "radius",
            Self::Travel => "travel",
            Self::Design(DesignParameter::FrontThickness) => "front-thickness",
            Self::Design(DesignParameter::BackThickness) => "back-thickness",
            Self::Design(DesignParameter::HingeThickness) => "hinge-thickness",
            Self::Design(DesignParameter::HingeLength) => "hinge-length",
        }
    }

    /// The parameter of a word.
    pub fn of(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|parameter| parameter.word() == word)
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::YoungsModulus => "MPa",
            Self::Zero => "°",
            Self::Travel => "×",
            _ => "mm",
        }
    }

    /// Where a fit begins: the design's own value, or no correction.
    pub fn start(self, design: &Design) -> f64 {
        match self {
            Self::YoungsModulus => design.material.youngs_modulus,
            Self::Travel => 1.0,
            Self::Design(dimension) => dimension.size(design),
            _ => 0.0,
        }
    }

    /// How uncertain it is before anything was measured: a direction in which the data leave more than that open is one
    /// that they do not tell. 20 % of the modulus, 1°, 2 mm of a place, 1 mm of a radius, 5 % of the
    /// travel, 0.2 mm of a thickness, 0.5 mm of a length.
    pub fn doubt(self, design: &Design) -> f64 {
        match self {
            Self::YoungsModulus => 0.2 * design.material.youngs_modulus,
            Self::Zero | Self::Radius => 1.0,
            Self::ObjectX | Self::ObjectY => 2.0,
            Self::Travel => 0.05,
            Self::Design(DesignParameter::HingeLength) => 0.5,
            Self::Design(_) => 0.2,
        }
    }

    /// Why it cannot be fitted here.
    pub fn obstacle(self, design: &Design, objects: &[ObjectDesign], drive: &Drive) -> Option<&'static str> {
        match self {
            Self::Design(DesignParameter::HingeThickness | DesignParameter::HingeLength)
                if design.joint() != HingeKind::Flexible =>
            {
                Some("the finger has no flexible hinges")
            }
            Self::Radius if !objects.iter().all(|object| matches!(object, ObjectDesign::Circle { .. })) => {
                Some("not every object is a circle")
            }
            Self::Travel if *drive == Drive::Rotating => Some("the motor turns the finger: it has no travel"),
            _ => None,
        }
    }
}
