//! Finite elements: mesh, deck and output files. (Runs of CalculiX: `calculix.rs`.)

#[cfg(unix)]
#[path = "../program/mod.rs"]
mod program;
mod running;
#[path = "../said/mod.rs"]
mod said;

use std::collections::HashMap;

use fre::case::Case;
use fre::fea::{FeaError, Layer, Mesh, Plan, Region, parse_dat, parse_frd};

/// Case of a series of the reference data: circle tangent to the undeformed finger at α = 0.
fn case(finger: &str, radius: f64, height: f64, angles: &[f64]) -> Case {
    let text = format!(
        "finger = \"preset:{finger}\"\n[object]\nshape = \"circle\"\nradius_mm = {radius:?}\ncentre_mm = [{:?}, {height:?}]\n\
         [motion]\nmotor_angles_deg = {angles:?}\n",
        radius + 1.0
    );
    Case::parse("case.toml", &text).unwrap()
}

fn mesh(finger: &str, refinement: usize) -> Mesh {
    Plan::of(&case(finger, 40.0, 30.0, &[2.0]), refinement).unwrap().mesh
}

/// How many elements have each side, by its middle node.
fn sides(mesh: &Mesh) -> HashMap<usize, usize> {
    let mut count = HashMap::new();
    for element in &mesh.elements {
        for &middle in &element[4..] {
            *count.entry(middle).or_insert(0) += 1;
        }
    }
    count
}

#[test]
fn meshes_fit_together_and_have_no_cracks() {
    for (finger, holes) in [("fea-80", 7), ("ladder-80", 8), ("dhas-80", 7)] {
        for refinement in [1, 2] {
            let mesh = mesh(finger, refinement);
            let sides = sides(&mesh);
            assert!(sides.values().all(|&count| count <= 2), "{finger}: a side belongs to more than two elements");
            // Euler's formula with corners and sides: one piece with a hole per cell has 1 − cells.
            let mut corners: Vec<usize> = mesh.elements.iter().flat_map(|e| e[..4].to_vec()).collect();
            corners.sort_unstable();
            corners.dedup();
            let euler = corners.len() as i64 - sides.len() as i64 + mesh.elements.len() as i64;
            // The base is open: the two clamped feet are not joined, so the lowest cell is no hole.
            assert_eq!(euler, 1 - (holes - 1), "{finger} at {refinement}: a crack or a wrong joint");
            assert_eq!(corners.len() + sides.len(), mesh.nodes.len(), "{finger}: nodes without an element");
        }
    }
}

#[test]
fn elements_are_counter_clockwise_and_their_mapping_is_sound() {
    for finger in ["fea-80", "ladder-80", "dhas-80"] {
        let mesh = mesh(finger, 1);
        for element in &mesh.elements {
            let p = element.map(|n| mesh.nodes[n]);
            for i in 0..4 {
                let (a, b, c) = (p[(i + 3) % 4], p[i], p[(i + 1) % 4]);
                let corner = (c[0] - b[0]) * (a[1] - b[1]) - (c[1] - b[1]) * (a[0] - b[0]);
                assert!(corner > 0.0, "{finger}: an element folds over at {b:?}");
                let middle = p[4 + i];
                let off = (0.5 * (b[0] + c[0]) - middle[0]).hypot(0.5 * (b[1] + c[1]) - middle[1]);
                assert!(off < 1e-6, "{finger}: a side's middle is {off} mm off at {middle:?}");
            }
        }
    }
}

#[test]
fn the_mesh_has_the_area_of_the_drawing_whatever_its_size() {
    let (coarse, fine) = (mesh("fea-80", 1), mesh("fea-80", 2));
    assert_eq!(4 * coarse.elements.len(), fine.elements.len());
    assert!((coarse.area() - fine.area()).abs() < 1e-8);
    // By hand: front beam 2 × 74.116; back beam 2 × its centreline to the notch; wedge; bars 3 × (W − 2.0595 − 2c);
    // necks 0.8 × c on either side.
    let slope = 80.0_f64.atan2(28.0);
    let notch = 74.1158;
    let back_arc = 80.0_f64.hypot(28.0) - {
        // Distance along the back centreline from the notch's foot to the tip.
        let (dx, dy) = (1.0, 80.0 - notch);
        dx * slope.cos() + dy * slope.sin()
    };
    let back_foot = [-1.0 - 2.0 * slope.sin(), notch + 2.0 * slope.cos()];
    let wedge = polygon(&[[-1.0, notch], [1.0, notch], [1.0, 80.0], [-1.0 / slope.sin(), 80.0], back_foot]);
    let bars: f64 = (1..=6)
        .map(|k| {
            let clear = if k == 6 { 1.97 } else { 2.5 };
            let width = 28.0 * (1.0 - f64::from(k) / 8.0);
            let bar = width - 1.0 - 1.0 / slope.sin() - 2.0 * clear;
            3.0 * bar + 0.8 * 2.0 * clear
        })
        .sum();
    let expected = 2.0 * notch + 2.0 * back_arc + wedge + bars;
    assert!((coarse.area() - expected).abs() < 0.01, "{} mm² meshed, {expected} drawn", coarse.area());
}

/// A preset's design with welded ribs and fillets.
fn filleted(finger: &str, ribs: Option<f64>, fillet: f64) -> Case {
    use model_core::design::{LamellaKind, Lamellae, Ribs};
    let text = format!(
        "finger = \"preset:{finger}\"\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 45]\n\
         [motion]\ndirection = [1, 0]\ndistances_mm = [2]\n"
    );
    let mut case = Case::parse("case.toml", &text).unwrap();
    let lamellae = &mut case.finger.design.lamellae;
    if let Some(thickness) = ribs {
        lamellae.thickness = Lamellae::uniform(thickness);
    }
    lamellae.kind = LamellaKind::Rib(Ribs { fillet, ..Ribs::WELDED });
    case.finger.design.validate().unwrap();
    case
}

#[test]
fn fillets_are_in_the_mesh_as_they_are_drawn() {
    for (finger, thickness, fillet) in [
        ("ladder-80", Some(1.2), 0.6),
        ("ladder-80", Some(1.2), 1.5),
        // Inclined by up to 58°, five of them on the held back.
        ("umi", None, 0.5),
        ("umi", None, 0.9),
    ] {
        let [sharp, round] =
            [0.0, fillet].map(|fillet| Plan::of(&filleted(finger, thickness, fillet), 1).unwrap().mesh);
        let sides = sides(&round);
        assert!(sides.values().all(|&count| count <= 2), "{finger}: a side belongs to more than two elements");
        let euler = |mesh: &Mesh| {
            let mut corners: Vec<usize> = mesh.elements.iter().flat_map(|e| e[..4].to_vec()).collect();
            corners.sort_unstable();
            corners.dedup();
            corners.len() as i64 - self::sides(mesh).len() as i64 + mesh.elements.len() as i64
        };
        assert_eq!(euler(&round), euler(&sharp), "{finger} {fillet}: a crack or a wrong joint");
        for element in &round.elements {
            let p = element.map(|n| round.nodes[n]);
            for i in 0..4 {
                // By the middles of the sides beside it, as they bend along an arc.
                let (a, b, c) = (p[4 + (i + 3) % 4], p[i], p[4 + i]);
                let corner = (c[0] - b[0]) * (a[1] - b[1]) - (c[1] - b[1]) * (a[0] - b[0]);
                assert!(corner > 0.0, "{finger} {fillet}: an element folds over at {b:?}");
            }
        }
        assert!(round.clamped.len() >= 10 && round.contact_face.len() > 10);
        if finger == "umi" {
            continue;
        }
        // A corner of ψ gains r² (cot ψ/2 − (π − ψ)/2). The back beam leans by 19.29°.
        let gained = |degrees: f64| {
            let open = degrees.to_radians();
            fillet * fillet * (1.0 / (0.5 * open).tan() - 0.5 * (std::f64::consts::PI - open))
        };
        let expected = 7.0 * (2.0 * gained(90.0) + gained(90.0 - 19.29) + gained(90.0 + 19.29));
        let found = Plan::of(&filleted(finger, thickness, fillet), 4).unwrap().mesh.area() - sharp.area();
        assert!((found / expected - 1.0).abs() < 0.02, "{finger} {fillet}: {found} mm² for {expected}");
    }
}

fn polygon(corners: &[[f64; 2]]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    0.5 * corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>().abs()
}

#[test]
fn the_deck_has_plane_stress_contact_and_holds_still_at_the_places() {
    let case = case("fea-80", 40.0, 60.0, &[2.0, 3.0]);
    let plan = Plan::of(&case, 1).unwrap();
    // Half a degree an increment and two increments of holding at each place.
    assert_eq!(plan.stops, [6, 10]);
    assert_eq!(plan.path[3], plan.path[5]);
    // Reference data: centre at 2° is (38.17454, 61.87074).
    assert!((plan.path[5][0] - (38.17454 - 41.0)).abs() < 1e-5 && (plan.path[5][1] - 1.87074).abs() < 1e-5);
    let deck = plan.deck(&case);
    let nu: f64 = 0.48;
    let (e, n) = (49.5 * (1.0 + 2.0 * nu) / (1.0 + nu).powi(2), nu / (1.0 + nu));
    for needed in ["TYPE=CPE8R", "TYPE=SURFACE TO SURFACE", &format!("*ELASTIC\n{e:.9},{n:.9}"), "LINEAR\n99.000000"] {
        assert!(deck.contains(needed), "the deck lacks {needed:?}");
    }
    assert_eq!(deck.matches("*STEP").count(), 2);
    assert!(deck.lines().all(|line| line.len() <= 132));
}

/// A rough object turns in the finger frame, also a round one; and the finger may not open on it.
#[test]
fn friction_is_in_the_deck_while_the_finger_closes_and_refused_by_name_where_it_opens() {
    let circle = "shape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 60.0]";
    let rough = format!("{circle}\nfriction = 0.6");
    let closing = on(&rough, "motor_angles_deg = [2.0, 3.0]");
    let plan = Plan::of(&closing, 1).unwrap();
    assert!((plan.turns[9].to_degrees() - 3.0).abs() < 1e-9, "{:?}", plan.turns);
    assert!(plan.deck(&closing).contains("LINEAR\n99.000000\n*FRICTION\n0.6,99.000000\n"));
    let smooth = on(circle, "motor_angles_deg = [2.0, 3.0]");
    assert!(!Plan::of(&smooth, 1).unwrap().deck(&smooth).contains("FRICTION"));
    let error = Plan::of(&on(&rough, "motor_angles_deg = [2.0, 3.0, 2.5]"), 1).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("motion.motor_angles_deg[2] = 2.5: the finger opens from 3, and object.friction is 0.6;"),
        "{error}"
    );
    let jaw = on(&rough, "direction = [1.0, 0.0]\ndistances_mm = [3.0, 1.0]");
    assert!(Plan::of(&jaw, 1).unwrap_err().to_string().starts_with("motion.distances_mm[1] = 1: "));
    assert!(Plan::of(&on(circle, "motor_angles_deg = [2.0, 3.0, 2.5]"), 1).is_ok());
}

#[test]
fn a_motion_that_begins_inside_the_finger_is_opened_to_the_touch() {
    let text = "finger = \"preset:fea-80\"\n[object]\nshape = \"circle\"\nradius_mm = 30.0\ncentre_mm = [29.0, 45.0]\n\
                [motion]\ndirection = [1.0, 0.0]\ndistances_mm = [1.0]\n";
    let plan = Plan::of(&Case::parse("case.toml", text).unwrap(), 1).unwrap();
    assert!((plan.pivot[0] - 31.0).abs() < 1e-6, "{:?}", plan.pivot);
    // From −2 mm to 1 mm by half millimetres.
    assert_eq!(plan.stops, [8]);
}

/// A case of `fea-80`, by its object and motion.
fn on(object: &str, motion: &str) -> Case {
    let text = format!("finger = \"preset:fea-80\"\n[object]\n{object}\n[motion]\n{motion}\n");
    Case::parse("case.toml", &text).unwrap()
}

#[test]
fn a_finger_that_has_passed_a_small_object_is_opened_past_it() {
    for (radius, x) in [(5.0, 6.0), (1.0, 2.0)] {
        let object = format!("shape = \"circle\"\nradius_mm = {radius:?}\ncentre_mm = [{x:?}, 45.0]");
        for angle in [2.0, 6.0, 10.0, 30.0] {
            let plan = Plan::of(&on(&object, &format!("motor_angles_deg = [{angle:?}]")), 1).unwrap();
            // Both circles touch the undeformed front face at 0°, from the front.
            assert!(
                (plan.pivot[0] - x).abs() < 1e-3 && (plan.pivot[1] - 45.0).abs() < 1e-2,
                "{angle}°: {:?}",
                plan.pivot
            );
        }
    }
}

#[test]
fn the_tip_s_end_face_knows_contact() {
    let wall = "shape = \"half-plane\"\npoint_mm = [0.0, 78.5]\nnormal = [0.0, -1.0]";
    let plan = Plan::of(&on(wall, "direction = [0.0, 1.0]\ndistances_mm = [1.0]"), 1).unwrap();
    let mesh = &plan.mesh;
    let side =
        |s: &fre::fea::Side| [s.side, (s.side + 1) % 4].map(|corner| mesh.nodes[mesh.elements[s.element][corner]]);
    let sides: Vec<_> = mesh.contact_face.iter().map(side).collect();
    // From the base along the front face, then across the whole of the end, in one line.
    let length: f64 = sides.iter().map(|[a, b]| (b[0] - a[0]).hypot(b[1] - a[1])).sum();
    let slope = 80.0_f64.atan2(28.0).sin();
    assert!((length - (80.0 + 1.0 + 1.0 / slope)).abs() < 1e-9, "{length} mm may touch");
    for pair in sides.windows(2) {
        assert!(pair[0].iter().any(|p| pair[1].contains(p)), "a gap in the contact surface: {pair:?}");
    }
    // The wall reaches 1.5 mm over the end at 0 mm: the finger is drawn back to the touch.
    assert!((plan.path[plan.stops[0] - 1][1] + 2.5).abs() < 1e-6, "{:?}", plan.path);
}

#[test]
fn layers_bend_as_a_plate_and_stretch_as_a_bar() {
    for plate in [1.0, 1.228, 4.0 / 3.0] {
        let [skin, inner] = [Layer::Skin, Layer::Core].map(|layer| layer.factor(plate));
        // What yields to shear is nearly as stiff as before.
        assert!(inner > 0.7 && skin >= inner, "{skin} about {inner}");
        // By sums over many slices of the thickness, an eighth of which is skin on either side.
        let slices = 40_000;
        let (mut stretch, mut bending) = (0.0, 0.0);
        for i in 0..slices {
            let y = (f64::from(i) + 0.5) / f64::from(slices) - 0.5;
            let factor = if y.abs() < 0.375 { inner } else { skin };
            stretch += factor / f64::from(slices);
            bending += 12.0 * factor * y * y / f64::from(slices);
        }
        assert!((stretch - 1.0).abs() < 1e-4 && (bending - plate).abs() < 1e-4, "{stretch}, {bending}");
    }
}

#[test]
fn only_what_bends_lies_in_layers_and_only_with_a_plate_s_factor() {
    assert!(mesh("fea-80", 2).layers.iter().all(|&layer| layer == Layer::Whole));
    let case = case("dhas-80", 40.0, 30.0, &[2.0]);
    let joints = Region::of(&case.finger.design).unwrap().joints;
    // A neck's junction reaches half a neck's thickness along the beam.
    let is_junction = |y: f64| {
        joints.iter().any(|joint| {
            let [low, high] = joint.front;
            let near = 0.5 * (high - low);
            (low - near..=high + near).contains(&y)
        })
    };
    for refinement in [1, 2] {
        let mesh = mesh("dhas-80", refinement);
        assert_eq!(mesh.layers.len(), mesh.elements.len());
        // The front beam's layers lie symmetrically about its centreline, x = 0: the core from −0.75 to 0.75 mm.
        let mut seen = [0, 0, 0];
        for (element, &layer) in mesh.layers.iter().enumerate() {
            let [x, y] = mesh.middle(element);
            if mesh.parts[element] == fre::fea::Part::Front && y < 70.0 {
                let core = x.abs() < 0.75;
                let (expected, kind) = match (is_junction(y), core) {
                    (true, _) => (Layer::Whole, 2),
                    (false, true) => (Layer::Core, 1),
                    (false, false) => (Layer::Skin, 0),
                };
                assert_eq!(layer, expected, "at ({x}, {y}) mm");
                seen[kind] += 1;
            }
            // The wedge.
            assert!(y < 77.0 || layer == Layer::Whole, "at ({x}, {y}) mm");
        }
        assert!(seen[0] == seen[1] && seen[0] > 100 && seen[2] > 50, "{seen:?}");
    }
}

#[test]
fn what_cannot_be_meshed_is_refused_with_its_reason() {
    let mut narrow = case("fea-80", 40.0, 60.0, &[2.0]);
    narrow.finger.design.hinge.length = heapless::Vec::from_slice(&[2.5; 6]).unwrap();
    let error = Region::of(&narrow.finger.design).unwrap_err();
    assert!(matches!(error, FeaError::NoRoom { lamella: 5, .. }), "{error}");

    let error = Plan::of(&case("fea-80", 40.0, 60.0, &[2.0]), 0).unwrap_err().to_string();
    snapbox::assert_data_eq!(error, snapbox::str!["--mesh is 0; allowed is 1 to 16"]);
}

#[test]
fn printed_results_are_read_at_whole_times_only() {
    let text = "\n displacements (vx,vy,vz) for set NLINES and time  0.5000000E+00\n\n         3  9.0  9.0  0.0\n\
        \n displacements (vx,vy,vz) for set NLINES and time  0.1000000E+01\n\n         3  0.000000E+00  0.000000E+00  0.000000E+00\n        \
        7  4.310842E-05 -2.832554E-05  0.000000E+00\n\
        \n total force (fx,fy,fz) for set NRING and time  0.1000000E+01\n\n       -3.016658E-01  3.883367E-03  5.731480E-19\n";
    let printed = parse_dat(text).unwrap();
    assert_eq!(printed.displacements.len(), 1);
    assert_eq!(printed.displacements[&1], [[0.0, 0.0], [4.310842e-05, -2.832554e-05]]);
    assert_eq!(printed.forces[&1], [-0.3016658, 0.003883367]);
    // Stopped in the middle of a line: what stands before holds.
    let cut = parse_dat(text.split_once("3.883367").unwrap().0).unwrap();
    assert_eq!((cut.displacements, cut.forces.len()), (printed.displacements, 0));
    // What is no number is read as such: its place has no force, the others keep theirs.
    let overflown = parse_dat(&text.replace("-3.016658E-01", "*************").replace("4.310842E-05", "NaN")).unwrap();
    assert!(overflown.forces[&1][0].is_nan() && overflown.displacements[&1][1][0].is_nan());
    let error = parse_dat(&text.replace("4.310842E-05", "NaN(oops)")).unwrap_err().to_string();
    snapbox::assert_data_eq!(
        error,
        snapbox::str![[r#"CalculiX's .dat, line 9: unexpected "7  NaN(oops) -2.832554E-05  0.000000E+00""#]]
    );
}

#[test]
fn displacements_of_the_whole_mesh_are_read_by_columns() {
    // Twelve columns each: two numbers with a sign run into each other.
    let block = |time: &str| {
        format!(
            "  100CL  101 {time}           2                     0    1           1\n -4  DISP        4    1\n -5  D1          1    2    1    0\n \
             -1         1 1.00000E-01-2.50000E-01 0.00000E+00\n -1        12-1.00000E+00 3.00000E+00 0.00000E+00\n -3\n"
        )
    };
    let mesh = "    1C\n    2C                             2                                     1\n -1         1 9.00000E+00 9.00000E+00 0.00000E+00\n -3\n";
    let text = format!("{mesh}{}{}{}", block("1.000000000"), block("1.500000000"), block("4.000000000"));
    let found = parse_frd(&text).unwrap();
    assert_eq!(found.keys().collect::<Vec<_>>(), [&1, &4]);
    assert_eq!((found[&4].len(), found[&4][&1], found[&4][&12]), (2, [0.1, -0.25], [-1.0, 3.0]));
    // A block that the file breaks off in is none.
    let cut = parse_frd(&text[..text.len() - 60]).unwrap();
    assert_eq!(cut.keys().collect::<Vec<_>>(), [&1]);
    let error = parse_frd(&text.replace("-2.50000E-01", "oops 2500000")).unwrap_err().to_string();
    snapbox::assert_data_eq!(
        error,
        snapbox::str![[r#"CalculiX's .frd, line 8: unexpected "-1         1 1.00000E-01oops 2500000 0.00000E+00""#]]
    );
}

#[test]
fn the_outer_edges_go_round_the_finger_and_its_windows() {
    let plan = Plan::of(&case("fea-80", 40.0, 45.0, &[2.0]), 1).unwrap();
    let edges = plan.mesh.outer_edges();
    // Every corner of a closed line has two edges.
    let mut ends = std::collections::HashMap::new();
    for &[a, _, b] in &edges {
        for end in [a, b] {
            *ends.entry(end).or_insert(0) += 1;
        }
    }
    assert!(edges.len() > 300 && ends.values().all(|&times| times == 2), "{} edges", edges.len());
}
