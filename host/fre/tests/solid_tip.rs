//! Derivatives with respect to thicknesses of a finger whose rigid tip begins where the beams' inner faces meet.

use std::path::Path;

use fre::case::Document;
use fre::study::model::Options;
use fre::study::place::Place;
use fre::study::run;

const STEP: f64 = 1e-3;

fn solved(document: &Document) -> Vec<Place> {
    let run = run::solve(&document.case().unwrap(), &Options::default()).unwrap();
    assert!(run.is_trustworthy());
    run.places
}

/// Differences of the force at each place between a case with a number greater and less, N per mm.
fn differences(document: &Document, key: &str, value: f64) -> Vec<[f64; 2]> {
    let [below, above] = [-STEP, STEP].map(|by| {
        let mut other = document.clone();
        other.set(key, value + by).unwrap();
        solved(&other)
    });
    let force = |place: &Place| place.force_n().unwrap();
    let slope =
        |(below, above): (&Place, &Place)| [0, 1].map(|axis| (force(above)[axis] - force(below)[axis]) / (2.0 * STEP));
    below.iter().zip(&above).map(slope).collect()
}

#[test]
fn the_tip_moves_with_the_thicknesses() {
    for (name, height) in [("low", 30.0), ("mid", 45.0), ("high", 60.0)] {
        let text = format!(
            "finger = \"preset:fea-80\"\nobject = {{ shape = \"circle\", radius_mm = 40, centre_mm = [41, {height}] }}\n\
             motion.motor_angles_deg = [4, 8]\n"
        );
        let document = Document::resolve("case.toml", &text, Path::new("")).unwrap();
        let design = document.case().unwrap().finger.design;
        let number = format!("rigid_above_mm = {:?}", design.rigid_above.unwrap());
        let fixed = document.text().replace("rigid_above_mm = \"auto\"", &number);
        assert!(fixed.contains(&number), "{fixed}");
        let fixed = Document::resolve("case.toml", &fixed, Path::new("")).unwrap();
        let here = solved(&document);
        for key in ["finger.front.thickness_mm", "finger.back.thickness_mm"] {
            let whole = differences(&document, key, 2.0);
            let held = differences(&fixed, key, 2.0);
            for (place, (whole, held)) in here.iter().zip(whole.iter().zip(&held)) {
                let found = place.state.as_ref().unwrap().sensitivity.unwrap();
                let front = key.contains("front");
                let found =
                    if front { found.force_per_front_thickness_mm_n } else { found.force_per_back_thickness_mm_n };
                let found = found.unwrap();
                let size = whole[0].hypot(whole[1]);
                let off = |of: &[f64; 2]| (of[0] - whole[0]).hypot(of[1] - whole[1]) / size;
                println!(
                    "{name} {:?} {key}: {whole:?} N/mm; off by {:.5}, with the tip held {:.5}",
                    place.at,
                    off(&found),
                    off(held)
                );
                assert!(off(&found) < 1e-4, "{name} {key}: {found:?}, {whole:?}");
            }
        }
    }
}
