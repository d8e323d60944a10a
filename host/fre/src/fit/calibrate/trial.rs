//! A design with values of parameters.

use model_core::design::Design;
use model_core::drive::{Drive, Knots, Travel};
use model_core::object::{ObjectDesign, Placement};
use model_core::sensitivity::DesignParameter;

use super::parameter::Parameter;

/// A design with values of parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// The parameters.
    pub parameters: Vec<Parameter>,
    /// Their values, in [`Parameter::unit`].
    pub values: Vec<f64>,
}

impl Trial {
    /// Where a fit begins; `prony` are the material's terms.
    pub fn start(parameters: &[Parameter], design: &Design, prony: &[[f64; 2]]) -> Self {
        Self {
            parameters: parameters.to_vec(),
            values: parameters.iter().map(|parameter| parameter.start(design, prony)).collect(),
        }
    }

    /// The terms of a material with memory, with these values.
    pub fn prony(&self, own: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut terms = own.to_vec();
        for (parameter, &value) in self.parameters.iter().zip(&self.values) {
            let part = usize::from(matches!(parameter, Parameter::Fading(_)));
            if let Some(term) = parameter.term().and_then(|term| terms.get_mut(term)) {
                term[part] = value;
            }
        }
        terms
    }

    /// A parameter's value less the design's own.
    pub fn change(&self, parameter: Parameter, design: &Design) -> f64 {
        let own = parameter.start(design, &[]);
        let found = self.parameters.iter().zip(&self.values).find(|(other, _)| **other == parameter);
        found.map_or(0.0, |(_, value)| value - own)
    }

    /// The design with these values.
    pub fn design(&self, design: &Design) -> Design {
        let mut changed = design.clone();
        changed.material.youngs_modulus += self.change(Parameter::YoungsModulus, design);
        for dimension in DesignParameter::ALL {
            dimension.shift(&mut changed, self.change(Parameter::Design(dimension), design));
        }
        changed
    }

    /// How the motor moves the base, with these values.
    pub fn drive(&self, drive: &Drive, design: &Design) -> Drive {
        let factor = self.travel(design);
        let scaled = |distance: f32| (f64::from(distance) * factor) as f32;
        let travel = match drive {
            Drive::Rotating => return Drive::Rotating,
            Drive::Translating { travel: Travel::Linear { mm_per_rad }, .. } => {
                Travel::Linear { mm_per_rad: scaled(*mm_per_rad) }
            }
            Drive::Translating { travel: Travel::Table(knots), .. } => {
                let scaled: Vec<_> = knots.iter().map(|&[angle, distance]| [angle, scaled(distance)]).collect();
                // As many as there were.
                Travel::Table(Knots::new(&scaled).unwrap_or(*knots))
            }
        };
        match *drive {
            Drive::Translating { direction, .. } => Drive::Translating { direction, travel },
            Drive::Rotating => Drive::Rotating,
        }
    }

    /// What distances are multiplied by.
    pub(super) fn travel(&self, design: &Design) -> f64 {
        1.0 + self.change(Parameter::Travel, design)
    }

    /// A coefficient of friction with these values; never below 0.
    pub fn friction(&self, friction: f64, design: &Design) -> f64 {
        (friction + self.change(Parameter::Friction, design)).max(0.0)
    }

    /// An object with these values.
    pub fn object(&self, object: ObjectDesign, design: &Design) -> ObjectDesign {
        let shift = [self.change(Parameter::ObjectX, design), self.change(Parameter::ObjectY, design)];
        let moved = Placement { translation: shift.map(|by| -by), ..Placement::HERE }.object_back(&object);
        match moved {
            ObjectDesign::Circle { centre, radius } => {
                ObjectDesign::Circle { centre, radius: radius + self.change(Parameter::Radius, design) }
            }
            // No other shape has a radius that is fitted.
            other => other,
        }
    }
}
