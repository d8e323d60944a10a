//! What a calibration can fit.

use model_core::design::{Design, HingeKind};
use model_core::drive::Drive;
use model_core::equilibrium::PRONY_TERMS;
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
    /// What is added to every object's coefficient of friction.
    Friction,
    /// What the distances of a drive that moves the base along a line are multiplied by.
    Travel,
    /// A dimension of the finger, mm.
    Design(DesignParameter),
    /// Share g of a term of a material with memory, counted from 0.
    Share(u8),
    /// Time τ in which it fades, s.
    Fading(u8),
}

/// Words of the terms' shares and times.
const SHARES: [&str; PRONY_TERMS] = ["prony-g1", "prony-g2", "prony-g3", "prony-g4"];
/// See [`SHARES`].
const FADINGS: [&str; PRONY_TERMS] = ["prony-tau1", "prony-tau2", "prony-tau3", "prony-tau4"];

impl Parameter {
    /// All of them.
    pub const ALL: [Self; 19] = [
        Self::YoungsModulus,
        Self::Zero,
        Self::ObjectX,
        Self::ObjectY,
        Self::Radius,
        Self::Friction,
        Self::Travel,
        Self::Design(DesignParameter::FrontThickness),
        Self::Design(DesignParameter::BackThickness),
        Self::Design(DesignParameter::HingeThickness),
        Self::Design(DesignParameter::HingeLength),
        Self::Share(0),
        Self::Fading(0),
        Self::Share(1),
        Self::Fading(1),
        Self::Share(2),
        Self::Fading(2),
        Self::Share(3),
        Self::Fading(3),
    ];

    /// The word on the command line and in outputs.
    pub fn word(self) -> &'static str {
        match self {
            Self::YoungsModulus => "youngs-modulus",
            Self::Zero => "zero",
            Self::ObjectX => "object-x",
            Self::ObjectY => "object-y",
            Self::Radius => "radius",
            Self::Friction => "friction",
            Self::Travel => "travel",
            Self::Design(DesignParameter::FrontThickness) => "front-thickness",
            Self::Design(DesignParameter::BackThickness) => "back-thickness",
            Self::Design(DesignParameter::HingeThickness) => "hinge-thickness",
            Self::Design(DesignParameter::HingeLength) => "hinge-length",
            Self::Share(term) => SHARES.get(usize::from(term)).copied().unwrap_or_default(),
            Self::Fading(term) => FADINGS.get(usize::from(term)).copied().unwrap_or_default(),
        }
    }

    /// The term that it belongs to, if it is one of a material with memory.
    pub fn term(self) -> Option<usize> {
        match self {
            Self::Share(term) | Self::Fading(term) => Some(usize::from(term)),
            _ => None,
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
            Self::Friction | Self::Share(_) => "1",
            Self::Fading(_) => "s",
            _ => "mm",
        }
    }

    /// Where a fit begins: the design's own value, or no correction. `prony` are the material's terms [gᵢ, τᵢ in s].
    pub fn start(self, design: &Design, prony: &[[f64; 2]]) -> f64 {
        let term = |of: u8, part: usize| prony.get(usize::from(of)).map_or(0.0, |term| term[part]);
        match self {
            Self::Share(of) => term(of, 0),
            Self::Fading(of) => term(of, 1),
            Self::YoungsModulus => design.material.youngs_modulus,
            Self::Travel => 1.0,
            Self::Design(dimension) => dimension.size(design),
            _ => 0.0,
        }
    }

    /// How uncertain it is before anything was measured: a direction in which the data leave more than that open is one
    /// that they do not tell. 20 % of the modulus, 1°, 2 mm of a place, 1 mm of a radius, 0.3 of a coefficient of friction, 5 % of the
    /// travel, 0.2 mm of a thickness, 0.5 mm of a length, 0.1 of a share, half of a time.
    pub fn doubt(self, design: &Design, prony: &[[f64; 2]]) -> f64 {
        match self {
            Self::Share(_) => 0.1,
            Self::Fading(_) => 0.5 * self.start(design, prony),
            Self::YoungsModulus => 0.2 * design.material.youngs_modulus,
            Self::Zero | Self::Radius => 1.0,
            Self::ObjectX | Self::ObjectY => 2.0,
            Self::Friction => 0.3,
            Self::Travel => 0.05,
            Self::Design(DesignParameter::HingeLength) => 0.5,
            Self::Design(_) => 0.2,
        }
    }

    /// Whether it is a size that is never 0, rather than a correction that may be.
    pub(super) fn is_positive(self) -> bool {
        matches!(self, Self::YoungsModulus | Self::Travel | Self::Design(_) | Self::Fading(_))
    }

    /// Why it cannot be fitted here.
    pub fn obstacle(
        self,
        design: &Design,
        prony: &[[f64; 2]],
        objects: &[ObjectDesign],
        drive: &Drive,
    ) -> Option<&'static str> {
        match self {
            Self::Share(term) | Self::Fading(term) if usize::from(term) >= prony.len() => {
                Some("finger.material.prony of the case has no such term to begin with")
            }
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
