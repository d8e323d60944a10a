//! Objects of every shape from case file to result, picture, sweep, servo and comparison.

use std::path::Path;

use fre::case::{Case, Document, ObjectWords};
use fre::draw;
use fre::fea::Plan;
use fre::study::model::{Options, Precision};
use fre::study::run::{self, Run};
use fre::study::sweep::{Axis, Sweep};
use fre::study::{csv, json, pictures, text};
use fre_gripper::servo::{Load, OnBranch};
use model_core::discretise::{Discretisation, Physics};
use model_core::drive::Drive;
use model_core::status::Status;

const ELLIPSE: &str = include_str!("../../../examples/ellipse.toml");
const BLOCK: &str = include_str!("../../../examples/block-parallel.toml");
const WALL: &str = include_str!("../../../examples/wall.toml");
const BORE: &str = include_str!("../../../examples/bore.toml");
const EXAMPLES: [(&str, &str); 4] = [("ellipse", ELLIPSE), ("block", BLOCK), ("wall", WALL), ("bore", BORE)];

fn options() -> Options {
    Options { discretisation: Discretisation::reduced(Physics::Extended), ..Options::default() }
}

fn solve(text: &str) -> (Case, Run) {
    let case = Case::parse("case.toml", text).unwrap();
    let run = run::solve(&case, &options()).unwrap();
    (case, run)
}

#[test]
fn every_example_is_solved_from_the_gap_to_the_grip() {
    for (name, text) in EXAMPLES {
        let (case, run) = solve(text);
        assert!(run.places.iter().all(|s| matches!(s.status, Status::NoContact | Status::Converged)), "{name}");
        let gaps: Vec<f64> = run.places.iter().map(|place| place.state.as_ref().unwrap().gap_mm).collect();
        let free = run.places.iter().take_while(|s| s.status == Status::NoContact).count();
        assert!(free >= 1 && free < run.places.len(), "{name}: {gaps:?}");
        // The gap closes, and then stays closed but for the contact's softness.
        assert!(gaps[..free].windows(2).all(|pair| pair[1] < pair[0]) && gaps[free - 1] > 0.0, "{name}: {gaps:?}");
        assert!(gaps[free..].iter().all(|&gap| gap < 0.0 && gap > -0.02), "{name}: {gaps:?}");
        let forces: Vec<f64> = run.places.iter().map(|s| s.force_magnitude_n().unwrap()).collect();
        assert!(forces[free..].windows(2).all(|pair| pair[1] > pair[0]), "{name}: {forces:?}");
        // Single precision is the same.
        let single = run::solve(&case, &Options { precision: Precision::F32, ..options() }).unwrap();
        for (one, two) in run.places.iter().zip(&single.places) {
            let (one, two) = (one.force_magnitude_n().unwrap(), two.force_magnitude_n().unwrap());
            assert!((one - two).abs() < 5e-3 * (1.0 + one), "{name}: {one} {two}");
        }
        // The reports carry the gap.
        let csv = csv::csv(&run);
        assert!(csv.lines().next().unwrap().split(',').any(|column| column == "gap_mm"), "{csv}");
        let json: serde_json::Value = serde_json::from_str(&json::json(&run).unwrap()).unwrap();
        assert_eq!(json[0]["gap_mm"].as_f64(), Some(gaps[0]));
        assert!(text::text(&case, &run).contains("gap"));
    }
}

/// A translated base: what it feels is the force along its way, for each shape.
#[test]
fn a_translated_base_meets_every_shape() {
    let objects = [
        "shape = \"circle\"\nradius_mm = 20\ncentre_mm = [30, 50]",
        "shape = \"ellipse\"\nsemi_axes_mm = [15, 30]\nangle_deg = 10\ncentre_mm = [25, 48]",
        "shape = \"polygon\"\ncorners_mm = [[12, 40], [40, 30], [40, 60]]\nrounding_mm = 3",
        "shape = \"half-plane\"\npoint_mm = [6, 70]\nnormal = [-1, -0.3]",
        "shape = \"bore\"\nradius_mm = 150\ncentre_mm = [-122, 0]",
    ];
    for object in objects {
        let text = format!(
            "finger = \"preset:ladder-80\"\n[object]\n{object}\n[motion]\ndirection = [4, 1]\ndistances_mm = [0, 5, 10, 13]\n"
        );
        let (_, run) = solve(&text);
        assert_eq!(run.places[0].status, Status::NoContact, "{object}");
        let last = run.places.last().unwrap();
        assert!(last.status.is_trustworthy() && last.force_magnitude_n().unwrap() > 0.2, "{object}: {:?}", last.status);
        let [x, y] = last.force_n().unwrap();
        let along = (4.0 * x + y) / 17_f64.sqrt();
        assert!((along - last.state.as_ref().unwrap().motor_torque_nmm).abs() < 1e-9 * (1.0 + along), "{object}");
        assert!(last.state.as_ref().unwrap().sensitivity.unwrap().force_per_mm_n.is_some(), "{object}");
    }
}

#[test]
fn pictures_show_every_shape() {
    for (name, text) in EXAMPLES {
        let (case, run) = solve(text);
        let scene = pictures::overview(&case, &run).unwrap();
        let svg = draw::svg(&scene);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
        let tree = roxmltree::Document::parse(&svg).unwrap();
        let texts: Vec<_> = tree.descendants().filter(|node| node.has_tag_name("text")).collect();
        for node in &texts {
            let at = |key| node.attribute(key).unwrap().parse::<f64>().unwrap();
            assert!(
                (0.0..=scene.width).contains(&at("x")) && (0.0..=scene.height).contains(&at("y")),
                "{name}: {node:?}"
            );
        }
        let word = |node: &roxmltree::Node| {
            node.descendants().filter(roxmltree::Node::is_text).filter_map(|n| n.text()).collect::<String>()
        };
        let object = ObjectWords::of(&case.object).name();
        assert!(texts.iter().any(|node| word(node) == object), "{name}: no text says {object}");
        if let Some(folder) = std::env::var_os("FRE_PICTURES") {
            draw::write(&scene, &Path::new(&folder).join(format!("{name}.png"))).unwrap();
        }
    }
}

#[test]
fn numbers_of_every_shape_can_be_swept() {
    let sweep = |text: &str, key: &str, values: &[f64]| {
        let axis = Axis::Key { key: key.to_owned(), values: values.to_vec() };
        let document = Document::resolve("case.toml", text, Path::new("")).unwrap();
        Sweep::new(document, None, vec![axis], options()).map_err(|error| error.to_string())
    };
    let no_angle = ELLIPSE.replace("angle_deg = 60.0", "#");
    for (text, key, values) in [
        (ELLIPSE, "object.semi_axes_mm.1", [18.0, 20.0]),
        (ELLIPSE, "object.centre_mm.1", [40.0, 50.0]),
        (ELLIPSE, "object.angle_deg", [50.0, 70.0]),
        (&no_angle, "object.angle_deg", [50.0, 70.0]),
        (BLOCK, "object.rounding_mm", [4.0, 6.0]),
        (BLOCK, "object.corners_mm.3.0", [17.0, 20.0]),
        (WALL, "object.point_mm.0", [3.0, 6.0]),
        (WALL, "object.normal.1", [-0.2, -0.3]),
    ] {
        let sweep = sweep(text, key, &values).unwrap();
        let [one, two] = [0, 1].map(|point| sweep.point(point).unwrap().0);
        assert_ne!(one.object, two.object, "{key}");
    }
    // A value that makes no good object is refused at its point.
    let bad = sweep(BLOCK, "object.corners_mm.3.0", &[20.0, 60.0]).unwrap();
    assert!(bad.point(0).is_ok());
    let message = bad.point(1).unwrap_err().to_string();
    snapbox::assert_data_eq!(
        message,
        snapbox::str![
            "at object.corners_mm.3.0=60: object.corners_mm[2] = [50.0, 55.0]: makes the polygon not convex; allowed are corners that all turn the same way, in order around the object"
        ]
    );
    let message = sweep(WALL, "object.radius_mm", &[1.0]).err().unwrap_or_default();
    snapbox::assert_data_eq!(
        message,
        snapbox::str![[
            r#"--vary: "object.radius_mm" is not a number of this case; the nearest are finger.motor.axis_mm.0, finger.motor.axis_mm.1, finger.back.base_mm.0, finger.back.base_mm.1, elements"#
        ]]
    );
}

#[test]
fn the_simulated_servo_feels_every_shape() {
    for (name, text) in [("ellipse", ELLIPSE), ("wall", WALL)] {
        let (case, run) = solve(text);
        let options = Options { discretisation: Discretisation::reduced(Physics::Extended), ..Load::REFERENCE };
        let load = Load::of(&case.finger.design, case.object, &Drive::Rotating, &options, 8.0).unwrap();
        let mut on = OnBranch::default();
        for place in &run.places {
            let there = load.at(place.at.value().to_radians(), &mut on);
            let torque = place.state.as_ref().unwrap().motor_torque_nmm;
            assert!((there.torque - torque).abs() < 1.0 + 0.01 * torque, "{name}: {} {torque}", there.torque);
        }
    }
}

#[test]
fn finite_elements_take_every_shape() {
    for (name, text) in [("ellipse", ELLIPSE), ("block", BLOCK), ("wall", WALL)] {
        let plan = Plan::of(&Case::parse("case.toml", text).unwrap(), 1);
        assert!(plan.is_ok(), "{name}: {}", plan.err().map(|error| error.to_string()).unwrap_or_default());
    }
}

/// `fre compare --measured` takes any shape: a file made of the model's own results has no error.
#[test]
fn measurements_on_any_shape_are_compared() {
    let own = tempfile::tempdir().unwrap();
    let folder = own.path();
    for (name, text, column) in
        [("ellipse", ELLIPSE, "motor_angle_deg"), ("block", BLOCK, "distance_mm"), ("wall", WALL, "motor_angle_deg")]
    {
        let (_, run) = solve(text);
        let rows = run.places.iter().filter(|s| s.force_magnitude_n().unwrap() > 0.1);
        let rows: String = rows.map(|s| format!("{},{}\n", s.at.value(), s.force_magnitude_n().unwrap())).collect();
        let (case, measured) = (folder.join(format!("{name}.toml")), folder.join(format!("{name}.csv")));
        std::fs::write(&case, text).unwrap();
        std::fs::write(&measured, format!("{column},force_n\n{rows}")).unwrap();
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_fre"))
            .arg("compare")
            .arg(&case)
            .arg("--measured")
            .arg(&measured)
            .args(["--elements", "reduced"])
            .output()
            .unwrap();
        let words = String::from_utf8(output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(0), "{name}: {words}{}", String::from_utf8_lossy(&output.stderr));
        let error = words.lines().find(|line| line.starts_with("force error: ")).unwrap_or(&words);
        assert_eq!(error.split(" (at ").next(), Some("force error: mean 0.00 %, max 0.00 %"), "{name}: {words}");
    }
}
