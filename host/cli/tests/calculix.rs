//! CalculiX on meshes of cases: it agrees with the model, and reproduces the reference's rows. `cargo xtask setup --fea` installs it.

use std::ops::ControlFlow;

use fre::case::Case;
use fre::fea::{Plan, Progress};
use reference_tests::plates::{Span, spans};

/// A watcher that lets CalculiX end.
fn on(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Case of a series of the reference data: circle tangent to the undeformed finger at α = 0.
fn case(finger: &str, radius: f64, height: f64, angles: &[f64]) -> Case {
    let text = format!(
        "finger = \"preset:{finger}\"\n[object]\nshape = \"circle\"\nradius_mm = {radius:?}\ncentre_mm = [{:?}, {height:?}]\n\
         [motion]\nmotor_angles_deg = {angles:?}\n",
        radius + 1.0
    );
    Case::parse("case.toml", &text).unwrap()
}

/// A case of `fea-80` with lines added to (or put in place of) the finger's, and an object.
fn other_case(change: impl FnOnce(&mut model_core::design::Design), object: &str, motion: &str) -> Case {
    let text = format!("finger = \"preset:fea-80\"\n[object]\n{object}\n[motion]\n{motion}\n");
    let mut case = Case::parse("case.toml", &text).unwrap();
    change(&mut case.finger.design);
    case.finger.design.validate().unwrap();
    case
}

/// Runs CalculiX on a case and compares force (%) and shape (mm) with the model.
fn agrees(name: &str, case: &Case, force: f64, shape: f64) {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let analysis = Plan::of(case, 1).unwrap().run(case, &folder, on).unwrap_or_else(|error| panic!("{name}: {error}"));
    let run = fre::study::run::solve(case, &Default::default()).unwrap();
    for (place, pose) in run.places.iter().zip(&analysis.poses) {
        let pose = pose.as_ref().unwrap_or_else(|| panic!("{name}: CalculiX did not reach {}", place.at));
        let state = place.state.as_ref().unwrap();
        let model = state.force_magnitude_n();
        let error = fre::metrics::force_error(model, pose.magnitude()).percent.unwrap();
        let off = fre::metrics::deviation(&state.shape.front, &pose.front).unwrap();
        // The same direction: the object's turn is in the deck.
        let [x, y] = state.force_finger_frame_n;
        let angle = (x * pose.force[1] - y * pose.force[0]).atan2(x * pose.force[0] + y * pose.force[1]).to_degrees();
        println!(
            "{name} at {}: model {model:.4} N, CalculiX {:.4} N, {error:+.2} %, {angle:+.2}°, shape {:.3} mm, {:.0} s",
            place.at,
            pose.magnitude(),
            off.max,
            analysis.seconds
        );
        assert!(
            error.abs() < force && off.max < shape && angle.abs() < 1.0,
            "{name}: {error:+.2} %, {angle:+.2}°, {off:?}"
        );
    }
}

/// The circle of the reference data's R40_Mid.
const CIRCLE: &str = "shape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 45.0]";

#[test]
fn calculix_agrees_on_an_ellipse() {
    let ellipse = "shape = \"ellipse\"\ncentre_mm = [26.0, 45.0]\nsemi_axes_mm = [24.0, 40.0]\nangle_deg = 10.0";
    agrees("ellipse", &other_case(|_| (), ellipse, "motor_angles_deg = [4.0]"), 3.0, 0.3);
}

#[test]
fn calculix_agrees_on_a_rounded_block_that_a_parallel_gripper_closes_on() {
    let block =
        "shape = \"polygon\"\ncorners_mm = [[9.0, 28.0], [9.0, 52.0], [40.0, 52.0], [40.0, 28.0]]\nrounding_mm = 8.0";
    agrees("block", &other_case(|_| (), block, "direction = [1.0, 0.0]\ndistances_mm = [3.0]"), 3.0, 0.3);
}

/// Friction raises the force at 6° by a fifth, and turns it by 12°.
#[test]
fn calculix_agrees_on_a_finger_that_rubs_while_it_closes() {
    let rough = format!("{CIRCLE}\nfriction = 0.6");
    agrees("rough", &other_case(|_| (), &rough, "motor_angles_deg = [3.0, 6.0]"), 3.0, 0.3);
}

#[test]
fn calculix_agrees_on_a_wall() {
    // It meets the tip, where the model's wedge is rigid and the mesh's yields: more apart than on a beam's face.
    let wall = "shape = \"half-plane\"\npoint_mm = [8.0, 40.0]\nnormal = [-1.0, -0.15]";
    agrees("wall", &other_case(|_| (), wall, "motor_angles_deg = [3.0]"), 5.0, 0.3);
}

#[test]
fn calculix_agrees_on_an_object_that_the_finger_had_passed() {
    let small = "shape = \"circle\"\nradius_mm = 5.0\ncentre_mm = [6.0, 45.0]";
    let case = other_case(|_| (), small, "motor_angles_deg = [6.0]");
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("passed");
    let analysis = Plan::of(&case, 1).unwrap().run(&case, &folder, on).unwrap();
    let force = analysis.poses[0].as_ref().expect("a force").magnitude();
    let model = fre::study::run::solve(&case, &Default::default()).unwrap().places[0].force_magnitude_n().unwrap();
    // Not the direction: the model's contact is at fixed samples, and on so small a circle their spacing turns it by a degree.
    println!("passed: model {model:.4} N, CalculiX {force:.4} N");
    assert!((model / force - 1.0).abs() < 0.03, "model {model} N, CalculiX {force} N");
}

#[test]
fn calculix_finds_contact_on_the_tip_s_end() {
    // The model's tip is round and 1 mm longer, so that only the order of the forces is the same.
    let wall = "shape = \"half-plane\"\npoint_mm = [0.0, 80.5]\nnormal = [0.0, -1.0]";
    let case = other_case(|_| (), wall, "direction = [0.0, 1.0]\ndistances_mm = [3.0]");
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("end");
    let analysis = Plan::of(&case, 1).unwrap().run(&case, &folder, on).unwrap();
    let force = analysis.poses[0].as_ref().expect("a force").force;
    println!("a wall over the tip: {force:?} N");
    // Frictionless: straight up.
    assert!(force[1] > 5.0 && force[0].abs() < 0.01 * force[1], "{force:?}");
}

#[test]
fn calculix_agrees_on_a_finger_that_bends_as_a_plate() {
    use model_core::design::PlaneStrain;
    agrees(
        "plate",
        &other_case(|design| design.plane_strain = PlaneStrain::Auto, CIRCLE, "motor_angles_deg = [4.0]"),
        3.0,
        0.3,
    );
}

/// Fillets as large as the ribs are thick raise the force by 30 %.
#[test]
fn calculix_agrees_on_ribs_with_fillets() {
    use model_core::design::{LamellaKind, Lamellae, Ribs};
    let ribs = |design: &mut model_core::design::Design| {
        design.lamellae.thickness = Lamellae::uniform(1.2);
        design.lamellae.kind = LamellaKind::Rib(Ribs { fillet: 1.2, ..Ribs::WELDED });
    };
    agrees("fillets", &other_case(ribs, CIRCLE, "motor_angles_deg = [4.0]"), 2.0, 0.1);
}

/// Gaps of 0.05 mm, some of which shut.
#[test]
fn calculix_agrees_on_ribs_that_end_with_a_gap() {
    use model_core::design::{LamellaKind, Lamellae, RibEnds, Ribs};
    let ribs = |design: &mut model_core::design::Design| {
        design.lamellae.thickness = Lamellae::uniform(2.0);
        design.lamellae.kind = LamellaKind::Rib(Ribs { ends: RibEnds::Gap(0.05), ..Ribs::WELDED });
    };
    agrees("gap", &other_case(ribs, &CIRCLE.replace("45.0", "30.0"), "motor_angles_deg = [1.0]"), 3.0, 0.1);
}

#[test]
fn calculix_agrees_on_a_tapered_finger() {
    use model_core::design::Profile;
    let taper = |design: &mut model_core::design::Design| {
        let profile = |knots: &[[f64; 2]]| Profile { knots: heapless::Vec::from_slice(knots).unwrap() };
        design.front.thickness = profile(&[[0.0, 2.4], [80.0, 1.6]]);
        design.back.thickness = profile(&[[0.0, 2.6], [84.0, 1.8]]);
        design.width = profile(&[[0.0, 24.0], [80.0, 14.0]]);
    };
    agrees("taper", &other_case(taper, CIRCLE, "motor_angles_deg = [4.0]"), 3.0, 0.3);
}

#[test]
fn calculix_agrees_on_bowed_beams() {
    let bow = |design: &mut model_core::design::Design| {
        design.front.sagitta = -2.0;
        design.back.sagitta = -3.0;
    };
    agrees("bow", &other_case(bow, CIRCLE, "motor_angles_deg = [5.0]"), 3.0, 0.3);
}

/// Solid from 56 mm on, 18 mm below the notch, with contact on the beam just below: a finger that is open up to the notch has half the force.
#[test]
fn calculix_agrees_on_a_tip_that_is_solid_from_further_down() {
    use model_core::design::Attachments;
    let solid = |design: &mut model_core::design::Design| {
        design.lamellae.attachments =
            Attachments::Heights(heapless::Vec::from_slice(&[10.0, 20.0, 30.0, 40.0]).unwrap());
        design.hinge.length.truncate(4);
        design.rigid_above = Some(56.0);
    };
    agrees("solid", &other_case(solid, &CIRCLE.replace("45.0", "54.0"), "motor_angles_deg = [4.0]"), 3.0, 0.3);
}

#[test]
fn calculix_agrees_on_pinned_lamellae() {
    let pin = |design: &mut model_core::design::Design| design.hinge.kind = model_core::design::HingeKind::Pinned;
    agrees("pin", &other_case(pin, CIRCLE, "motor_angles_deg = [4.0]"), 3.0, 0.3);
}

/// Runs CalculiX on a series of `fea-80.csv` up to an angle and compares with the row.
fn reproduce(series: &str, radius: f64, height: f64, angle: f64) {
    let rows = include_str!("../../../tests/reference/fea-80.csv");
    let row = rows
        .lines()
        .map(|line| line.split(',').collect::<Vec<_>>())
        .find(|row| row[0] == "calculix-cpe8r" && row[1] == series && row[4].parse() == Ok(angle))
        .unwrap();
    let reference: f64 = row[9].parse().unwrap();
    let list = |column: usize| row[column].split(' ').map(|x: &str| x.parse::<f64>().unwrap());
    let front: Vec<[f64; 2]> = list(13).zip(list(14)).map(|(x, y)| [x, y]).collect();

    let case = case("fea-80", radius, height, &[angle]);
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{series}-{angle}"));
    let analysis = Plan::of(&case, 1).unwrap().run(&case, &folder, on).unwrap_or_else(|error| panic!("{error}"));
    let pose = analysis.poses[0].as_ref().expect("CalculiX reached the angle");
    let error = fre::metrics::force_error(pose.magnitude(), reference).percent.unwrap();
    let shape = fre::metrics::deviation(&pose.front, &front).unwrap();
    println!(
        "{series} {angle}°: {:.5} N, reference {reference} N, {error:+.2} %, shape {:.4} mm, {:.0} s",
        pose.magnitude(),
        shape.max,
        analysis.seconds
    );
    assert!(error.abs() < 0.5, "{series} {angle}°: force {error:+.3} % off");
    assert!(shape.max < 0.05, "{series} {angle}°: shape {shape:?} off");
    // The outer face lies half a thickness before the centreline.
    let count = pose.front.len();
    for on in &pose.front[count / 10..count * 9 / 10] {
        let distance = |p: &[f64; 2]| (p[0] - on[0]).hypot(p[1] - on[1]);
        let nearest = pose.mesh_edge.iter().map(distance).fold(f64::INFINITY, f64::min);
        assert!((0.9..1.1).contains(&nearest), "{series} {angle}°: the outline is {nearest} mm from {on:?}");
    }
}

#[test]
fn calculix_reproduces_a_low_pose() {
    reproduce("R40_Low", 40.0, 30.0, 6.0);
}

#[test]
fn calculix_reproduces_a_mid_pose() {
    reproduce("R30_Mid", 30.0, 45.0, 4.0);
}

#[test]
fn calculix_reproduces_a_high_pose() {
    reproduce("R40_High", 40.0, 60.0, 4.0);
}

/// Two short rows of the series in three dimensions behind `plane_strain = "auto"`; `cargo xtask bench plates` solves all.
#[test]
fn wide_walls_bend_as_the_table_has_it() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("plates");
    std::fs::create_dir_all(&folder).unwrap();
    for (width, nu) in [(5.0, 0.45), (8.0, 0.3)] {
        let is_it =
            |span: &Span| (span.width, span.clear, span.rib, span.nu, span.curvature) == (width, 2.0, 0.5, nu, 0.0);
        let (span, table, _) = spans().find(|row| is_it(&row.0)).unwrap();
        let found = span.elements(&folder).unwrap();
        println!("{span:?}: {found:.5} by elements, {table} in the table, {:.5} by the formula", span.formula());
        assert!((found / table - 1.0).abs() < 2e-4, "{span:?}: {found} and {table}");
        assert!((span.formula() / found - 1.0).abs() < 0.01, "{span:?}: {found} and {}", span.formula());
    }
}
