//! What a calibration means for a gripper.

use model_core::design::Design;
use model_core::uncertainty::{PARAMETERS, Uncertainty};

use super::{Fit, Parameter};

/// Counts of the servo per degree.
const COUNTS_PER_DEG: f64 = 4096.0 / 360.0;

/// What is added to the servo's zero position, counts: the fitted zero angle's, for a servo without a gear whose counts grow
/// as the finger closes.
pub fn zero_counts(fit: &Fit, design: &Design) -> f64 {
    // Adding zero turns −0 into 0.
    -fit.trial.change(Parameter::Zero, design) * COUNTS_PER_DEG + 0.0
}

/// How uncertain the fit leaves zero angle, modulus and the object's place: what was not fitted counts as known. The play of the gears
/// is part of the zero angle, which was fitted in contact and from one side.
pub fn uncertainty(fit: &Fit, design: &Design) -> Uncertainty {
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
    }
}
