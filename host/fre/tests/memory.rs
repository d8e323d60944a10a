//! Cases of a material with memory: time along the motion, what is refused, and every view of the results.

use std::ops::ControlFlow;
use std::path::Path;

use fre::case::{Case, Document, Memory};
use fre::draw::Item;
use fre::study::json::Row;
use fre::study::pictures::{self, Kind};
use fre::study::run::{Run, solve};
use fre::study::sweep::{self, Axis, Sweep};
use fre::study::{course, csv, text};

const TERMS: [[f64; 2]; 3] = [[0.15, 0.1], [0.15, 5.0], [0.1, 100.0]];

/// The preset ladder-80 of that material on a cylinder, with a motion.
fn words(motion: &str) -> String {
    let finger = include_str!("../src/case/presets/ladder-80.toml");
    let finger = finger.replace("\n[", "\n[finger.").replacen(
        "poissons_ratio",
        "prony = [[0.15, 0.1], [0.15, 5], [0.1, 100]]\npoissons_ratio",
        1,
    );
    format!(
        "[finger]\n{finger}\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 45]\n[motion]\n{motion}\n"
    )
}

fn case(motion: &str) -> Case {
    Case::parse("case.toml", &words(motion)).unwrap()
}

fn solved(motion: &str) -> Run {
    solve(&case(motion), &Default::default()).unwrap()
}

fn forces(run: &Run) -> Vec<f64> {
    run.places.iter().map(|place| place.force_magnitude_n().unwrap()).collect()
}

/// What is left of a sudden stress after a time.
fn left(seconds: f64) -> f64 {
    1.0 - TERMS.iter().map(|[part, time]| part * (1.0 - (-seconds / time).exp())).sum::<f64>()
}

#[test]
fn a_hold_relaxes_as_the_material_does() {
    let run = solved("motor_angles_deg = [6, 6, 6, 6, 6]\ntimes_s = [0, 0.05, 1, 10, 400]");
    let found = forces(&run);
    let elastic = words("motor_angles_deg = [6]").replace("prony", "# prony");
    let elastic = solve(&Case::parse("case.toml", &elastic).unwrap(), &Default::default()).unwrap();
    assert!((found[0] / forces(&elastic)[0] - 1.0).abs() < 1e-6, "a sudden closing is elastic: {found:?}");
    for (force, time) in found.iter().zip([0.0, 0.05, 1.0, 10.0, 400.0]) {
        // The contact's softness does not relax.
        assert!((force / found[0] / left(time) - 1.0).abs() < 1e-3, "{time} s: {force} N of {} N", found[0]);
    }
    let warnings: Vec<String> = run.warnings.iter().map(ToString::to_string).collect();
    snapbox::assert_data_eq!(
        warnings.join("\n"),
        snapbox::str![
            "finger.material.prony: the force depends on the path and its time, from an open hand through the places in their order; derivatives and energies are left out"
        ]
    );
    let row = Row::new(&run, &run.places[3]);
    assert_eq!((row.time_s, row.motor_angle_deg, row.energy_nmm, row.sensitivity), (Some(10.0), Some(6.0), None, None));
}

#[test]
fn faster_is_stiffer_and_a_speed_counts_its_times() {
    let at = |speed: &str| solved(&format!("motor_angles_deg = [4, 8]\nspeed_deg_per_s = {speed}"));
    let [slow, middle, fast, sudden] = ["1", "10", "100", "1e6"].map(|speed| forces(&at(speed))[1]);
    assert!(slow < middle && middle < fast && fast < sudden, "{slow} {middle} {fast} {sudden}");
    let without = solved("motor_angles_deg = [4, 8]");
    assert!((sudden / forces(&without)[1] - 1.0).abs() < 1e-4, "{sudden} {without:?}");
    let warnings: Vec<String> = without.warnings.iter().map(ToString::to_string).collect();
    snapbox::assert_data_eq!(
        warnings.join("\n"),
        snapbox::str![[r#"
finger.material.prony: the force depends on the path and its time, from an open hand through the places in their order; derivatives and energies are left out
finger.material.prony: no time passes, so that forces are those of a sudden motion; motion.times_s or motion.speed_deg_per_s says how time passes
"#]]
    );
    assert!(without.places.iter().all(|place| place.time_s.is_none()));
    let times: Vec<_> = at("10").places.iter().map(|place| place.time_s.unwrap()).collect();
    assert_eq!(times, [0.0, 0.4]);
    // From the open hand to 4° takes time, too: as much as from where contact begins.
    let held = solved("motor_angles_deg = [-2, 4, 8]\ntimes_s = [0, 0.6, 1]");
    assert!((forces(&held)[2] / middle - 1.0).abs() < 1e-3, "{held:?} {middle}");
}

#[test]
fn every_view_has_the_time() {
    let run = solved("motor_angles_deg = [2, 8, 8, 2]\ntimes_s = [0.5, 1, 60, 61]");
    let case = case("motor_angles_deg = [2, 8, 8, 2]\ntimes_s = [0.5, 1, 60, 61]");
    let table = csv::csv(&run);
    let mut lines = table.lines();
    let column = lines.next().unwrap().split(',').position(|name| name == "time_s").unwrap();
    assert_eq!(lines.map(|line| line.split(',').nth(column).unwrap()).collect::<Vec<_>>(), ["0.5", "1", "60", "61"]);
    let shown = text::text(&case, &run);
    assert!(shown.contains("of a sudden stress fades 0.15 in 0.1 s, 0.15 in 5 s, 0.1 in 100 s; 0.6 stays"), "{shown}");
    assert!(shown.contains("at time") && shown.contains("60.000"), "{shown}");
    // Closing takes more work than opening gives back.
    let [done, returned] = course::work(&case, &run).unwrap();
    assert!(0.0 < returned && returned < 0.9 * done, "{done} {returned}");
    let words = |kind| {
        let scene = pictures::stacked(&case, &run, 2, &[kind]).unwrap();
        let said = scene
            .items
            .into_iter()
            .filter_map(|item| if let Item::Text(text) = item { Some(text.words) } else { None });
        said.collect::<Vec<_>>().join(" ")
    };
    assert!(words(Kind::Force).contains("Contact force over time"), "{}", words(Kind::Force));
    assert!(words(Kind::Loop).contains("come back") && words(Kind::Loop).contains("holding"), "{}", words(Kind::Loop));
    assert_eq!(pictures::film(&case, &run).len(), 4);
}

#[test]
fn speeds_and_terms_are_swept() {
    let rows = |motion: &str, key: &str, values: &[f64]| {
        let document = Document::resolve("case.toml", &words(motion), Path::new("")).unwrap();
        let axis = Axis::Key { key: key.to_owned(), values: values.to_vec() };
        let sweep = Sweep::new(document, None, vec![axis], Default::default()).unwrap();
        let mut out = Vec::new();
        sweep::run(&sweep, None, &mut out, 1, |_| ControlFlow::Continue(())).unwrap();
        let text = String::from_utf8(out).unwrap();
        let force = text.lines().next().unwrap().split(',').position(|name| name == "force_n").unwrap();
        text.lines().skip(1).map(|line| line.split(',').nth(force).unwrap().parse().unwrap()).collect::<Vec<f64>>()
    };
    let speeds = rows("motor_angles_deg = [8]\nspeed_deg_per_s = 1", "motion.speed_deg_per_s", &[1.0, 10.0, 100.0]);
    assert!(speeds.is_sorted() && speeds[2] > 1.1 * speeds[0], "{speeds:?}");
    let held = "motor_angles_deg = [8, 8]\ntimes_s = [0, 1000]";
    let shares = rows(held, "finger.material.prony.2.0", &[0.0, 0.1, 0.3]);
    for (pair, left) in shares.chunks(2).zip([0.7, 0.6, 0.4]) {
        assert!((pair[1] / pair[0] - left).abs() < 1e-3, "{shares:?}");
    }
}

#[test]
fn what_is_no_material_or_no_time_is_refused_where_it_is() {
    let message = |motion: &str, prony: &str| {
        let text = words(motion).replace("[[0.15, 0.1], [0.15, 5], [0.1, 100]]", prony);
        let error = Case::parse("case.toml", &text).unwrap_err();
        (error.key().unwrap().to_owned(), error.to_string())
    };
    let angles = "motor_angles_deg = [2, 4, 4]";
    let mut said = String::new();
    for (prony, key) in [
        ("[[0.6, 1], [0.5, 10]]", "finger.material.prony"),
        ("[[1.0, 1]]", "finger.material.prony[0][0]"),
        ("[[0.1, 1], [-0.1, 1]]", "finger.material.prony[1][0]"),
        ("[[0.1, 0]]", "finger.material.prony[0][1]"),
        ("[[0.1, 1], [0.1, 2], [0.1, 3], [0.1, 4], [0.1, 5]]", "finger.material.prony"),
        ("[[0.1]]", "finger.material.prony[0]"),
        ("0.1", "finger.material.prony"),
    ] {
        let (found, words) = message(angles, prony);
        assert_eq!(found, key, "{prony}: {words}");
        said += &format!("{words}\n");
    }
    let jaw = "direction = [1, 0]\ndistances_mm = [1, 2]\nspeed_deg_per_s = 3".to_owned();
    for (motion, key) in [
        (format!("{angles}\ntimes_s = [0, 1]"), "motion.times_s"),
        (format!("{angles}\ntimes_s = [0, 1, 1]"), "motion.times_s[2]"),
        (format!("{angles}\ntimes_s = [-1, 1, 2]"), "motion.times_s[0]"),
        (format!("{angles}\ntimes_s = [0, 1, 2]\nspeed_deg_per_s = 3"), "motion.speed_deg_per_s"),
        (format!("{angles}\nspeed_deg_per_s = 0"), "motion.speed_deg_per_s"),
        (jaw, "motion.speed_deg_per_s"),
    ] {
        let (found, words) = message(&motion, "[[0.1, 1]]");
        assert_eq!(found, key, "{motion}: {words}");
        said += &format!("{words}\n");
    }
    snapbox::assert_data_eq!(
        said,
        snapbox::str![[r#"
case.toml:9: finger.material.prony = [[0.6, 1], [0.5, 10]]: Σ gᵢ is 1.1; allowed is up to 0.99
case.toml:9: finger.material.prony[0][0] = 1.0: gᵢ: allowed is 0 to 0.99
case.toml:9: finger.material.prony[1][0] = -0.1: gᵢ: allowed is 0 to 0.99
case.toml:9: finger.material.prony[0][1] = 0: τᵢ: allowed is 0.0001 to 1e9 s
case.toml:9: finger.material.prony = [[0.1, 1], [0.1, 2], [0.1, 3], [0.1, 4], [0.1, 5]]: has 5 entries; at most 4 are allowed
case.toml:9: finger.material.prony[0] = [0.1]: has 1 entries; needed is a pair [gᵢ, τᵢ in s]
case.toml:9: finger.material.prony = 0.1: is a number; needed is an array of pairs [gᵢ, τᵢ in s]
case.toml:45: motion.times_s = [0, 1]: has 2 entries; allowed is one per angle (3)
case.toml:45: motion.times_s[2] = 1: is not after the time before, 1 s; allowed are times that increase
case.toml:45: motion.times_s[0] = -1: allowed is 0 to 1e9 s
case.toml:46: motion.speed_deg_per_s = 3: cannot be given together with times_s; allowed is one or the other
case.toml:45: motion.speed_deg_per_s = 0: allowed is 0.000001 to 1e6 degrees/s
case.toml:46: motion.speed_deg_per_s = 3: the base moves along a line; allowed is times_s

"#]]
    );
    let refused = case(angles).elastic("a gripper").unwrap_err();
    let expected = "case.toml:9: finger.material.prony = [[0.15, 0.1], [0.15, 5], [0.1, 100]]: a gripper computes without memory; allowed is an elastic material";
    assert_eq!((refused.to_string().as_str(), refused.key()), (expected, Some("finger.material.prony")));
}

/// The force alone fades nearly as all strains do while the finger closes and is held; it lets go early.
#[test]
fn the_force_alone_is_for_closing_and_holding() {
    for friction in [0.0, 0.5] {
        let motion = "motor_angles_deg = [2, 4, 6, 6, 6, 6, 3, 2.5, 2, 1]\ntimes_s = [0.2, 0.4, 0.6, 1, 10, 400, 400.3, 400.35, 400.4, 400.5]";
        let nodes = words(motion).replace("centre_mm", &format!("friction = {friction}\ncentre_mm"));
        let force = nodes.replace("poissons_ratio", "memory = \"force\"\npoissons_ratio");
        let [nodes, force] = [nodes, force].map(|words| Case::parse("case.toml", &words).unwrap());
        let found = solve(&force, &Default::default()).unwrap();
        let [all, alone] = [&solve(&nodes, &Default::default()).unwrap(), &found].map(forces);
        for place in 0..6 {
            assert!((alone[place] / all[place] - 1.0).abs() < 3.5e-3, "{place}: {all:?} {alone:?}");
        }
        assert_eq!((alone[9], found.places[9].status.word()), (0.0, "no-contact"), "{alone:?}");
        for place in &found.places {
            let state = place.state.as_ref().unwrap();
            // The contacts are the force's, in either frame.
            let mut sum = [0.0; 2];
            for contact in &state.shape.contacts {
                let ([x, y], along) = (contact.normal, contact.tangential.unwrap_or(0.0));
                sum = [sum[0] - contact.force * x + along * y, sum[1] - contact.force * y - along * x];
            }
            let [x, y] = state.force_finger_frame_n;
            let size = x.hypot(y);
            assert!((size - place.force_magnitude_n().unwrap()).abs() < 1e-9, "{size}");
            assert!((sum[0].hypot(sum[1]) - size).abs() < 1e-3 * (1.0 + size), "{sum:?} {x} {y}");
        }
        assert!(text::text(&force, &found).contains("material with memory (of its force alone)"));
    }
    let wrong = words("motor_angles_deg = [2]").replace("poissons_ratio", "memory = \"all\"\npoissons_ratio");
    let error = Case::parse("case.toml", &wrong).unwrap_err();
    assert_eq!(error.key(), Some("finger.material.memory"), "{error}");
}

/// A force that fades by itself has gone through what lies between two places, however few are listed.
#[test]
fn places_between_are_gone_through() {
    let last = |places: &str| {
        let motion = format!("motor_angles_deg = [{places}]\nspeed_deg_per_s = 10");
        let mut case = case(&motion);
        case.finger.memory = Memory::Force;
        let found = solve(&case, &Default::default()).unwrap();
        assert!(found.is_trustworthy());
        let place = found.places.last().unwrap();
        [place.force_magnitude_n().unwrap(), place.state.as_ref().unwrap().motor_torque_nmm]
    };
    let many = (0..=40).map(|step| (0.25 * f64::from(step)).to_string()).collect::<Vec<_>>().join(", ");
    for ((one, other), what) in last("0, 10").into_iter().zip(last(&many)).zip(["force", "torque"]) {
        let off = one / other - 1.0;
        assert!(off.abs() < 2e-4, "{what}: {one} {other}");
    }
}

/// What is read is written again, terms included.
#[test]
fn a_finger_keeps_its_terms() {
    let mut document = Document::resolve("case.toml", &words("motor_angles_deg = [2]"), Path::new("")).unwrap();
    let mut finger = document.case().unwrap().finger;
    assert_eq!(finger.prony, TERMS);
    finger.prony[1] = [0.2, 7.0];
    finger.memory = Memory::Force;
    document.set_finger(&finger);
    assert_eq!(document.case().unwrap().finger, finger);
    assert!(document.need("finger.material.prony.1.0").is_ok());
}
