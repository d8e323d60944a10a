//! What a calibration means for a gripper.

use model_core::design::Design;
use model_core::equilibrium::PRONY_TERMS;
use model_core::uncertainty::{ALL, MemoryUncertainty, PARAMETERS, Uncertainty};

use super::{Fit, Parameter};

/// Counts of the servo per degree.
const COUNTS_PER_DEG: f64 = 4096.0 / 360.0;

/// What is added to the servo's zero position, counts: the fitted zero angle's, for a servo without a gear whose counts grow
/// as the finger closes.
pub fn zero_counts(fit: &Fit, design: &Design) -> f64 {
    // Adding zero turns −0 into 0.
    -fit.trial.change(Parameter::Zero, design) * COUNTS_PER_DEG + 0.0
}

/// How uncertain the fit leaves zero angle, modulus, the object's place and the terms `prony` [gᵢ, τᵢ in s] that it began with: what was
/// not fitted counts as known. The play of the gears is part of the zero angle, which was fitted in contact and from one side.
pub fn uncertainty(fit: &Fit, design: &Design, prony: &[[f64; 2]]) -> Uncertainty {
    let order = [Parameter::Zero, Parameter::YoungsModulus, Parameter::ObjectX, Parameter::ObjectY, Parameter::Radius];
    let place = |parameter| fit.estimates.iter().position(|estimate| estimate.parameter == parameter);
    let places = order.map(place);
    let deviation = |at: Option<usize>| at.map_or(0.0, |at| fit.estimates[at].standard_deviation);
    let modulus = Parameter::YoungsModulus.start(design, &[]) + fit.trial.change(Parameter::YoungsModulus, design);
    let mut correlations = [0.0; PARAMETERS * (PARAMETERS - 1) / 2];
    let mut entries = correlations.iter_mut();
    for (i, &row) in places.iter().enumerate() {
        for &column in &places[..i] {
            if let (Some(entry), Some(row), Some(column)) = (entries.next(), row, column) {
                *entry = fit.correlation[row][column].clamp(-1.0, 1.0) as f32;
            }
        }
    }
    let backlash = if places[0].is_some() { 0.0 } else { Uncertainty::DEFAULT.backlash };
    Uncertainty {
        quantisation: Uncertainty::DEFAULT.quantisation,
        backlash,
        zero_angle: deviation(places[0]).to_radians() as f32,
        youngs_modulus: (deviation(places[1]) / modulus) as f32,
        centre: [deviation(places[2]) as f32, deviation(places[3]) as f32],
        radius: deviation(places[4]) as f32,
        correlations,
        memory: memory(fit, places, &fit.trial.prony(prony)),
    }
}

/// The same of the fitted terms: `others` are the fit's numbers of finger and object.
fn memory(fit: &Fit, others: [Option<usize>; PARAMETERS], fitted: &[[f64; 2]]) -> MemoryUncertainty {
    let place = |parameter| fit.estimates.iter().position(|estimate| estimate.parameter == parameter);
    let (mut parts, mut times) = ([0.0; PRONY_TERMS], [0.0; PRONY_TERMS]);
    let mut places = [None; ALL];
    places[..PARAMETERS].copy_from_slice(&others);
    for (k, (term, [_, time])) in (0..).zip(fitted).enumerate() {
        let [part, fading] = [place(Parameter::Share(term)), place(Parameter::Fading(term))];
        let deviation = |at: Option<usize>| at.map_or(0.0, |at| fit.estimates[at].standard_deviation);
        parts[k] = deviation(part) as f32;
        times[k] = (deviation(fading) / time) as f32;
        places[PARAMETERS + 2 * k..][..2].copy_from_slice(&[part, fading]);
    }
    let correlations = std::array::from_fn(|i| {
        std::array::from_fn(|j| match (places[i], places[j]) {
            (Some(row), Some(column)) => fit.correlation[row][column],
            _ => f64::from(u8::from(i == j)),
        })
    });
    MemoryUncertainty::of(parts, times, &correlations)
}
