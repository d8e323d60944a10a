//! Standard deviations of a coefficient of friction, where most readings are taken while contacts stick after a turn.

use fre::case::preset;
use fre::fit::calibrate::synthetic::{Errors, Protocol, draw};
use fre::fit::calibrate::{Fit, Noise, Parameter, Predictor, Trial, fit};
use model_core::discretise::{Discretisation, Physics};
use model_core::drive::Drive;
use model_core::object::ObjectDesign;
use rayon::prelude::*;

/// A count of the servo, degrees.
const COUNT: f64 = 360.0 / 4096.0;
const RUNS: u64 = 32;
/// What the case has, and what the fit adds to it.
const FRICTION: [f64; 2] = [0.5, 0.1];

/// Four readings of a closing to 8.4°, and eight on the first 0.7° of the opening: a force there changes with its own angle and with that of
/// the turn several times as much as it does where all contacts slip.
#[test]
fn readings_that_stick_leave_the_deviation_that_is_stated() {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let discretisation = Discretisation::reduced(Physics::Extended);
    let model = Predictor { design: &design, discretisation, drive: Drive::Rotating, prony: &[] };
    let closing = [12, 40, 68, 96].into_iter();
    let angles_deg = closing.chain((88..96).rev()).map(|count| f64::from(count) * COUNT).collect();
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    let protocol = Protocol { objects: vec![object], angles_deg, times_s: Vec::new(), friction: FRICTION[0] };
    let parameters = [Parameter::Friction];
    let truth = Trial { parameters: parameters.to_vec(), values: vec![FRICTION[1]] };
    let fits: Vec<Fit> = (0..RUNS)
        .into_par_iter()
        .map(|seed| {
            let drawn = draw(&model, &truth, &protocol, Errors::USUAL, seed).unwrap();
            fit(&model, &drawn, &parameters, &Noise::default()).unwrap()
        })
        .collect();
    let mean = |of: &dyn Fn(&Fit) -> f64| fits.iter().map(of).sum::<f64>() / RUNS as f64;
    let inflation = mean(&|fit| fit.inflation.force);
    let true_one = mean(&|fit| (fit.estimates[0].value - FRICTION[1]).powi(2)).sqrt();
    let stated = mean(&|fit| fit.estimates[0].standard_deviation.powi(2)).sqrt();
    println!("true {true_one:.5}, stated {stated:.5}, inflation {inflation:.2}");
    assert!(fits.iter().all(|fit| fit.converged));
    assert!(inflation < 1.25, "the residuals are {inflation:.2} times what their noise explains");
    // The root mean square of 32 normal errors is within 0.75 … 1.3 of their deviation (3 in 100 on either side, about).
    assert!((0.75..1.3).contains(&(true_one / stated)), "true {true_one}, stated {stated}");
}
