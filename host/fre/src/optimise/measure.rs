//! What a designer asks of a finger, as numbers of a [`Grasp`]: what goals and limits are made of.

use std::fmt;
use std::str::FromStr;

use super::grasp::{Grasp, Known};
use super::mass::mass;

/// Steps of a range that is given without one.
const STEPS: f64 = 12.0;
/// Most places of a range.
const MOST_PLACES: f64 = 1000.0;
/// Density of a thermoplastic polyurethane, kg/m³.
const DENSITY: f64 = 1200.0;

/// A number of a finger that holds an object. Places are motor angles in degrees, or distances in mm of a parallel gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// Magnitude of the contact force at a place, N.
    Force(f64),
    /// Its mean over a range, N.
    MeanForce(Range),
    /// How far it is from constant over a range: (max − min)/mean.
    ForceVariation(Range),
    /// Stiffness that the object meets along the contact force at a place, N/mm: what the force grows by per mm that the object is
    /// pushed against it.
    Stiffness(f64),
    /// Arc of the front beam between the outermost touching samples at a place, mm. It steps from sample to sample; its derivative is that
    /// between two steps.
    ContactLength(f64),
    /// How far the contact force is spread along the front beam at a place, mm: the length of an evenly loaded arc with the same
    /// standard deviation, √12 σ. It changes smoothly, so that a search can follow it.
    Conformity(f64),
    /// Largest strain of beams and hinges up to a place, a share: 0.1 is 10 %.
    Strain(f64),
    /// The place at which the finger snaps through; the place given if it does not before that.
    Snap(f64),
    /// Mass of beams and lamellae, g, for a density in kg/m³.
    Mass(f64),
}

/// Places from a first to a last one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The first.
    pub first: f64,
    /// The last.
    pub last: f64,
    /// Distance between neighbours.
    pub step: f64,
}

impl Range {
    fn places(self) -> Vec<f64> {
        let count = ((self.last - self.first) / self.step).round().max(1.0);
        (0..=count as usize).map(|i| self.first + (self.last - self.first) * i as f64 / count).collect()
    }
}

impl Measure {
    /// Its unit; empty for a share.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Force(_) | Self::MeanForce(_) => "N",
            Self::Stiffness(_) => "N/mm",
            Self::ContactLength(_) | Self::Conformity(_) => "mm",
            Self::ForceVariation(_) | Self::Strain(_) | Self::Snap(_) => "",
            Self::Mass(_) => "g",
        }
    }

    /// It in words for people, with a place's unit: "stiffness at 8°".
    pub fn phrase(self, unit: &str) -> String {
        let over = |range: Range| format!("over {} to {}{unit}", range.first, range.last);
        match self {
            Self::Force(at) => format!("force at {at}{unit}"),
            Self::MeanForce(range) => format!("mean force {}", over(range)),
            Self::ForceVariation(range) => format!("variation of the force {}", over(range)),
            Self::Stiffness(at) => format!("stiffness at {at}{unit}"),
            Self::ContactLength(at) => format!("contact length at {at}{unit}"),
            Self::Conformity(at) => format!("conformity at {at}{unit}"),
            Self::Strain(at) => format!("strain up to {at}{unit}"),
            Self::Snap(at) => format!("place of a snap-through up to {at}{unit}"),
            Self::Mass(density) => format!("mass at {density} kg/m³"),
        }
    }

    /// True if more of it is better by default.
    pub(super) fn is_better_large(self) -> bool {
        !matches!(self, Self::ForceVariation(_) | Self::Strain(_) | Self::Mass(_))
    }

    /// Places at which a finger must be solved for it.
    pub fn places(self) -> Vec<f64> {
        match self {
            Self::MeanForce(range) | Self::ForceVariation(range) => range.places(),
            Self::Mass(_) => Vec::new(),
            Self::Force(at)
            | Self::Stiffness(at)
            | Self::ContactLength(at)
            | Self::Conformity(at)
            | Self::Strain(at)
            | Self::Snap(at) => vec![at],
        }
    }

    /// Its derivatives are the solver's, but for that of a snap-through.
    pub(super) fn needs_slopes(self) -> bool {
        !matches!(self, Self::Snap(_) | Self::Mass(_))
    }

    /// It counts what has been before its place.
    pub(super) fn counts_before(self) -> bool {
        matches!(self, Self::Strain(_))
    }

    /// The number; `None` if a place that it needs has no trustworthy solution, or no contact where there must be one.
    pub fn value(self, grasp: &Grasp) -> Option<f64> {
        let at = |place: f64| Some(grasp.at(place)?.numbers);
        match self {
            Self::Force(place) => Some(at(place)?.force),
            Self::MeanForce(range) => Some(mean(&forces(grasp, range)?)),
            Self::ForceVariation(range) => {
                let forces = forces(grasp, range)?;
                let mean = mean(&forces);
                let (least, most) = extremes(&forces)?;
                (mean > 0.0).then(|| (forces[most] - forces[least]) / mean)
            }
            Self::Stiffness(place) => at(place).filter(|found| found.force > 0.0).map(|found| found.stiffness),
            Self::ContactLength(place) => Some(at(place)?.length),
            Self::Conformity(place) => Some(at(place)?.spread),
            Self::Strain(up_to) => Some(most_strained(grasp, up_to)?.numbers.strain),
            Self::Snap(up_to) => Some(grasp.snap.map_or(up_to, |at| at.min(up_to))),
            Self::Mass(density) => Some(mass(&grasp.design, density)),
        }
    }

    /// Its derivative with a variable, from those of the places; `None` where there is none.
    pub(super) fn slope(self, grasp: &Grasp, variable: usize) -> Option<f64> {
        let of = |known: &Known| *known.slopes.get(variable)?;
        let at = |place: f64| of(grasp.at(place)?);
        let over =
            |range: Range| range.places().into_iter().map(|place| Some(at(place)?.force)).collect::<Option<Vec<_>>>();
        match self {
            Self::Force(place) => Some(at(place)?.force),
            Self::MeanForce(range) => Some(mean(&over(range)?)),
            Self::ForceVariation(range) => {
                let (forces, slopes) = (forces(grasp, range)?, over(range)?);
                let (least, most) = extremes(&forces)?;
                let (size, spread) = (mean(&forces), forces[most] - forces[least]);
                Some((slopes[most] - slopes[least]) / size - spread * mean(&slopes) / (size * size))
            }
            Self::Stiffness(place) => Some(at(place)?.stiffness),
            Self::ContactLength(place) => Some(at(place)?.length),
            Self::Conformity(place) => Some(at(place)?.spread),
            Self::Strain(up_to) => Some(of(most_strained(grasp, up_to)?)?.strain),
            // Without a snap-through it is the place given.
            Self::Snap(up_to) => grasp.snap.is_none_or(|at| at > up_to).then_some(0.0),
            Self::Mass(_) => None,
        }
    }
}

/// Where the finger is strained most, of the places up to one; `None` if there is no solution there.
fn most_strained(grasp: &Grasp, up_to: f64) -> Option<&Known> {
    let last = grasp.at(up_to)?;
    let before = grasp.places.iter().filter(|(at, _)| *at <= up_to).filter_map(|(_, known)| known.as_ref());
    Some(before.fold(last, |most, known| if known.numbers.strain > most.numbers.strain { known } else { most }))
}

fn forces(grasp: &Grasp, range: Range) -> Option<Vec<f64>> {
    range.places().into_iter().map(|at| Some(grasp.at(at)?.numbers.force)).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Indices of the smallest and the largest value.
fn extremes(values: &[f64]) -> Option<(usize, usize)> {
    let order = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
    Some(((0..values.len()).min_by(order)?, (0..values.len()).max_by(order)?))
}

/// What may be written for a measure.
pub const MEASURES: &str = "force at A, mean-force over A:B[:STEP], force-variation over A:B[:STEP], stiffness at A, contact-length at A, \
                            conformity at A, strain up to A, snap up to A, mass [of DENSITY]";

impl FromStr for Measure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let refused = || format!("\"{text}\" is not a measure; allowed is {MEASURES}");
        let number = |word: &str| finite(word).ok_or_else(refused);
        match words.as_slice() {
            ["force", "at", at] => Ok(Self::Force(number(at)?)),
            ["mean-force", "over", range] => Ok(Self::MeanForce(self::range(range).ok_or_else(refused)?)),
            ["force-variation", "over", range] => Ok(Self::ForceVariation(self::range(range).ok_or_else(refused)?)),
            ["stiffness", "at", at] => Ok(Self::Stiffness(number(at)?)),
            ["contact-length", "at", at] => Ok(Self::ContactLength(number(at)?)),
            ["conformity", "at", at] => Ok(Self::Conformity(number(at)?)),
            ["strain", "up", "to", at] => Ok(Self::Strain(number(at)?)),
            ["snap", "up", "to", at] => Ok(Self::Snap(number(at)?)),
            ["mass"] => Ok(Self::Mass(DENSITY)),
            ["mass", "of", density] => {
                let density = number(density)?;
                let allowed = density > 0.0;
                if allowed {
                    Ok(Self::Mass(density))
                } else {
                    Err(format!("mass of {density}: allowed is more than 0 kg/m³"))
                }
            }
            _ => Err(refused()),
        }
    }
}

/// Reads a number that is finite.
pub(super) fn finite(word: &str) -> Option<f64> {
    word.parse::<f64>().ok().filter(|number| number.is_finite())
}

/// Reads `A:B` or `A:B:STEP`.
fn range(word: &str) -> Option<Range> {
    let numbers = word.split(':').map(finite).collect::<Option<Vec<f64>>>()?;
    let (first, last, step) = match numbers.as_slice() {
        [first, last] => (*first, *last, (last - first) / STEPS),
        [first, last, step] => (*first, *last, *step),
        _ => return None,
    };
    (first < last && step > 0.0 && (last - first) / step < MOST_PLACES).then_some(Range { first, last, step })
}

impl fmt::Display for Measure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let over = |range: &Range| format!("over {}:{}:{}", range.first, range.last, range.step);
        match self {
            Self::Force(at) => write!(f, "force at {at}"),
            Self::MeanForce(range) => write!(f, "mean-force {}", over(range)),
            Self::ForceVariation(range) => write!(f, "force-variation {}", over(range)),
            Self::Stiffness(at) => write!(f, "stiffness at {at}"),
            Self::ContactLength(at) => write!(f, "contact-length at {at}"),
            Self::Conformity(at) => write!(f, "conformity at {at}"),
            Self::Strain(at) => write!(f, "strain up to {at}"),
            Self::Snap(at) => write!(f, "snap up to {at}"),
            Self::Mass(density) => write!(f, "mass of {density}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_as_they_are_written() {
        for words in [
            "force at 8",
            "mean-force over 4:10:0.5",
            "force-variation over 4:10:1",
            "stiffness at 8",
            "contact-length at 10",
            "conformity at 10",
            "strain up to 8.5",
            "snap up to 12",
            "mass of 1150",
        ] {
            let measure: Measure = words.parse().expect("a measure");
            assert_eq!(measure.to_string(), words);
        }
        assert_eq!("mass".parse(), Ok(Measure::Mass(1200.0)));
        let Ok(Measure::MeanForce(range)) = "mean-force over 4:10".parse::<Measure>() else { panic!("a range") };
        assert_eq!((range.places().len(), range.places()[0], range.places()[12]), (13, 4.0, 10.0));
        for wrong in [
            "force",
            "force at x",
            "force over 4:10",
            "mean-force over 10:4",
            "mass of 0",
            "colour at 8",
            "force at inf",
        ] {
            assert!(wrong.parse::<Measure>().is_err(), "{wrong}");
        }
    }
}
