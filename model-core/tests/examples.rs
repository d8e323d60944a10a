//! Every example does what it says.

// Each example has its own copy of the finger.
#![allow(clippy::duplicate_mod)]

use model_core::status::Status;

#[allow(dead_code)]
#[path = "../examples/design_study.rs"]
mod design_study;
#[allow(dead_code)]
#[path = "../examples/estimator_loop.rs"]
mod estimator_loop;
#[allow(dead_code)]
#[path = "../examples/one_case.rs"]
mod one_case;
#[allow(dead_code)]
#[path = "../examples/own_shape.rs"]
mod own_shape;

#[test]
fn one_case_is_the_reference_row() {
    let [x, y] = one_case::force().unwrap();
    // `paper-170-20-nodes`, R40-Mid, 11° in tests/reference/ladder-80.csv.
    assert!((x - 31.3421849103).abs() < 1e-6 && (y + 17.5093171489).abs() < 1e-6, "({x}, {y}) N");
}

#[test]
fn the_estimator_tracks_every_count() {
    let estimates = estimator_loop::estimates().unwrap();
    assert_eq!(estimates.len(), 120);
    assert_eq!(estimates[0].status, Status::NoContact);
    for estimate in &estimates[6..] {
        assert_eq!(estimate.status, Status::Converged, "{estimate:?}");
    }
    let rising = estimates[6..100].windows(2).filter(|pair| pair[1].force_magnitude() > pair[0].force_magnitude());
    assert!(rising.count() > 85, "the force rises with the angle");
}

#[test]
fn both_cylinders_of_the_pair_are_pushed() {
    let [lower, upper] = own_shape::forces().unwrap();
    assert!(lower > 0.1 && upper > 0.1, "{lower} N and {upper} N");
}

#[test]
fn the_study_agrees_with_differences_and_thicker_beams_push_harder() {
    let [force, exact, difference] = design_study::derivative().unwrap();
    assert!(force > 1.0 && (exact / difference - 1.0).abs() < 1e-4, "{exact} and {difference} N/mm");
    let forces = design_study::forces(&[1.8, 2.0, 2.2]).unwrap();
    assert!(forces[0] < forces[1] && forces[1] < forces[2], "{forces:?}");
    assert!((forces[1] - force).abs() < 1e-9);
}
