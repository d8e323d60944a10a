//! A case solved: progress, stopping, and the three views of its results.

use std::ops::ControlFlow;

use fre::case::{Case, Coordinate};
use fre::study::json::{Row, json};
use fre::study::model::Options;
use fre::study::place::{At, Effort, Place};
use fre::study::run::{Run, Unsolved, solve, solve_watched};
use fre::study::warnings::{Warning, warnings};
use fre::study::{course, csv, text};
use model_core::discretise::{Discretisation, Physics, Scheme, Softness};
use model_core::newton::Hessian;
use model_core::status::Status;

const CASE: &str = "finger = \"preset:ladder-80\"\nobject = { shape = \"circle\", radius_mm = 40, centre_mm = [41, 45] }\n\
                    motion.motor_angles_deg = [0, 4, 8]\n";

fn case(text: &str) -> Case {
    Case::parse("case.toml", text).unwrap()
}

fn solved(text: &str) -> Run {
    solve(&case(text), &Default::default()).unwrap()
}

#[test]
fn a_watcher_sees_every_place_and_may_stop() {
    let mut seen = Vec::new();
    let run = solve_watched(&case(CASE), &Default::default(), |progress| {
        seen.push((progress.done, progress.total, progress.latest.at));
        ControlFlow::<()>::Continue(())
    });
    assert_eq!(run.unwrap().places.len(), 3);
    assert_eq!(seen, [(1, 3, At::Angle(0.0)), (2, 3, At::Angle(4.0)), (3, 3, At::Angle(8.0))]);
    let stopped = solve_watched(&case(CASE), &Default::default(), |progress| match progress.done {
        2 => ControlFlow::Break("enough"),
        _ => ControlFlow::Continue(()),
    });
    assert_eq!(stopped, Err(Unsolved::Stopped("enough")));
}

/// The work of a loop is what friction dissipates, however few places there are and wherever the first one is.
#[test]
fn the_work_that_does_not_come_back_is_dissipated() {
    let text = CASE.replace("radius_mm", "friction = 0.6, radius_mm");
    for angles in ["0, 2, 4, 6, 8, 6, 4, 2, 0", "4, 8, 4, 0", "8, 0"] {
        let case = case(&text.replace("0, 4, 8", angles));
        let run = solve(&case, &Default::default()).unwrap();
        let [done, returned] = course::work(&case, &run).unwrap();
        let dissipated = run.places.last().unwrap().state.as_ref().unwrap().friction.unwrap().dissipated_nmm;
        assert!((done - returned - dissipated).abs() < 1e-3 * dissipated, "{angles}: {done} {returned} {dissipated}");
        assert!(done > 25.0 && dissipated > 3.0, "{angles}: {done} {dissipated}");
    }
}

/// With friction a contact without softness is as soft as the beam: without, a reversal at the paper's resolution was lost, or snapped.
#[test]
fn friction_softens_a_contact_at_nodes() {
    let text = CASE.replace("radius_mm", "friction = 0.6, radius_mm").replace("0, 4, 8", "0, 4, 8, 7.5, 4, 0");
    let mut options =
        Options { discretisation: Discretisation::full(Scheme::Paper, Physics::Paper), ..Default::default() };
    let found = solve(&case(&text), &options).unwrap();
    options.discretisation.softness = Softness::Local;
    let expected = solve(&case(&text), &options).unwrap();
    for (found, expected) in found.places.iter().zip(&expected.places) {
        assert!(matches!(found.status, Status::Converged | Status::NoContact), "{found:?}");
        assert_eq!(found.force_magnitude_n(), expected.force_magnitude_n());
    }
}

/// The case's own force is within its interval, whatever the object, and an interval is none between two branches.
#[test]
fn an_interval_holds_the_cases_own_forces() {
    let square =
        "shape = \"polygon\", corners_mm = [[6, 20], [50, 20], [50, 62], [6, 62]], rounding_mm = 2, friction = 0.5";
    let mut with = 0;
    for object in [square, "shape = \"circle\", radius_mm = 40, centre_mm = [41, 45], friction = 0.6"] {
        let text = CASE.replace("shape = \"circle\", radius_mm = 40, centre_mm = [41, 45]", object);
        let run = solved(
            &text.replace("0, 4, 8", "0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 12, 11, 10, 9, 8, 6, 4, 2, 0"),
        );
        for place in &run.places {
            let Some(state) = &place.state else { continue };
            let Some(interval) = state.force_interval else { continue };
            let friction = state.friction.unwrap();
            for (value, [low, high]) in [
                (place.force_magnitude_n().unwrap(), interval.magnitude),
                (friction.normal_n, interval.normal),
                (state.motor_torque_nmm, interval.torque_nmm),
            ] {
                assert!((low..=high).contains(&value), "{:?}: {value} is not in {low} to {high}", place.at);
            }
            with += u32::from(friction.normal_n > 0.0);
        }
    }
    assert!(with > 20, "{with}");
}

#[test]
fn csv_and_json_have_the_same_numbers() {
    let run = solved(CASE);
    let rows: Vec<Row> = serde_json::from_str(&json(&run).unwrap()).unwrap();
    assert_eq!(rows, run.places.iter().map(|place| Row::new(&run, place)).collect::<Vec<_>>());
    let head = csv::head(Coordinate::Angle);
    for (record, row) in csv::records(&run).zip(&rows) {
        let cell = |name: &str| record[head.iter().position(|column| column == name).unwrap()].as_str();
        let number = |name: &str| cell(name).parse::<f64>().ok();
        assert_eq!((cell("status"), number("motor_angle_deg")), (row.status.word(), row.motor_angle_deg));
        assert_eq!((number("force_n"), number("energy_nmm")), (row.force_magnitude_n, row.energy_nmm));
        assert_eq!(number("force_x_per_deg_n"), row.sensitivity.and_then(|s| s.force_per_deg_n).map(|[x, _]| x));
        assert_eq!(cell("scheme"), row.model.scheme);
    }
}

/// Places of a motion over time are written with their unit in every view, although no case has such a motion yet.
#[test]
fn a_place_in_time_has_its_own_columns() {
    let mut run = solved(CASE);
    for (seconds, place) in (0..).map(f64::from).zip(&mut run.places) {
        place.at = At::Time(0.5 * seconds);
    }
    let lines = csv::csv(&run);
    assert!(
        lines.starts_with("status,time_s,") && lines.contains(",force_x_per_s_n,") && !lines.contains("_deg"),
        "{lines}"
    );
    assert!(lines.lines().nth(2).is_some_and(|line| line.starts_with("converged,0.5,")), "{lines}");
    let row = Row::new(&run, &run.places[1]);
    assert_eq!((row.time_s, row.motor_angle_deg, row.distance_mm), (Some(0.5), None, None));
}

#[test]
fn a_warning_belongs_to_its_place() {
    let run = solved(&CASE.replace("centre_mm = [41, 45]", "centre_mm = [-14, -20]").replace("40", "200"));
    assert!(matches!(run.warnings[0], Warning::Lost { at: At::Angle(0.0), .. }), "{:?}", run.warnings);
    let rows: Vec<Row> = run.places.iter().map(|place| Row::new(&run, place)).collect();
    assert!(!rows[0].warnings.is_empty() && rows[1].warnings.is_empty(), "{rows:?}");
    assert!(rows.iter().all(|row| row.force_n.is_none() && row.front_mm.is_empty() && row.strains.is_none()));
    let words = text::text(&case(CASE), &run);
    assert!(words.contains("warning: at 0°: out-of-range: "), "{words}");
    assert!(!run.is_trustworthy() && run.last_known().is_none());
}

/// A printed finger with ribs close to each other, pushed far into a cylinder.
const NARROW: &str = "[finger]\nname = \"narrow\"\nwidth_mm = 20\n[finger.material]\nyoungs_modulus_pa = 1e7\npoissons_ratio = 0.48\n\
    [finger.front]\nbase_mm = [0, 0]\ntip_mm = [0, 80]\nthickness_mm = 1.6\n[finger.back]\nbase_mm = [-28, 0]\ntip_mm = [0, 80]\n\
    thickness_mm = 1.6\n[finger.lamellae]\nkind = \"rib\"\nheights_mm = [10, 14, 18, 22, 26, 30, 34, 38, 42, 46, 50, 54, 58, 62]\n\
    thickness_mm = 0.8\n[finger.motor]\naxis_mm = [-14, -20]\n[object]\nshape = \"circle\"\nradius_mm = 20\ncentre_mm = [21, 40]\n\
    [motion]\nmotor_angles_deg = [2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22]\n";

/// Where the solver has failed and other options are known to help, that is said, once.
#[test]
fn a_failure_of_the_solver_has_its_remedy() {
    let text = "finger = \"preset:umi\"\nobject = { shape = \"circle\", radius_mm = 20, centre_mm = [25, 50] }\n\
                motion = { direction = [1, 0], distances_mm = [7, 8, 9] }\n";
    let case = Case::parse("case.toml", text).unwrap();
    let said = |options: &Options, status: Status| -> Vec<String> {
        let place = |at: f64| Place {
            at: At::Distance(at),
            time_s: None,
            status: if at > 7.0 { status } else { Status::NoContact },
            effort: Effort::default(),
            branch: None,
            overlap_mm: None,
            state: None,
        };
        warnings(&case, options, &[7.0, 8.0, 9.0].map(place)).iter().map(ToString::to_string).collect()
    };
    let fine = Options::default();
    let hard = Discretisation { softness: Softness::Fixed(0.0), ..fine.discretisation };
    let hard = Options { discretisation: hard, ..fine };
    let gauss_newton = Options { hessian: Hessian::GaussNewton, ..fine };
    for (options, status) in [(fine, Status::Unsettled), (fine, Status::Stagnated), (hard, Status::Folded)] {
        assert_eq!(said(&options, status), Vec::<String>::new(), "{status}");
    }
    let texts = [said(&hard, Status::Unsettled), said(&gauss_newton, Status::Stagnated)].concat();
    snapbox::assert_data_eq!(
        texts.join("\n"),
        snapbox::str![[r#"
at 8 mm: unsettled: the contact has no softness, which is the default with contact at nodes; --softness-mm-per-n 1e-3 usually settles it, and changes the force by less than 1 %
at 8 mm: stagnated: gauss-newton has failed, not the finger; --hessian newton usually solves the place
"#]]
    );
}

#[test]
fn ribs_that_meet_are_warned_of_from_there_on() {
    let run = solved(NARROW);
    let touching = |place: &Place| place.state.as_ref().and_then(|state| state.self_contact);
    let first = run.places.iter().position(|place| touching(place).is_some()).unwrap();
    assert!(
        run.places[first].at.value() > 10.0 && run.places.iter().skip(first).all(|place| touching(place).is_some())
    );
    let deepest = run.places.iter().filter_map(touching).map(|contact| contact.depth).fold(0.0, f64::max);
    let warned = run.warnings.iter().find_map(|warning| match warning {
        Warning::Touching { contact, from, .. } => Some((contact.depth, *from)),
        _ => None,
    });
    assert_eq!(warned, Some((deepest, run.places[first].at)));

    // As JSON has it: neighbours, the one nearer to the base first.
    let rows: Vec<Row> = serde_json::from_str(&json(&run).unwrap()).unwrap();
    assert!(rows[..first].iter().all(|row| row.self_contact.is_none()));
    let written = rows[first].self_contact.as_ref().unwrap();
    let rib = |name: &String| name.strip_prefix("rib ").unwrap().parse::<u32>().unwrap();
    assert_eq!(rib(&written.between[0]) + 1, rib(&written.between[1]), "{written:?}");
    assert!(written.depth_mm > 0.0 && written.depth_mm <= deepest, "{written:?}");
}

/// Forces of CalculiX on the meshes that `fre compare CASE --fea` makes, N, for a cylinder (radius, height of the axis, mm) that touches
/// the undeformed finger and distances of the base, mm.
type Pressed = (&'static str, f64, f64, f64, &'static [f64], &'static [f64]);
const PRESSED: [Pressed; 7] = [
    ("umi", 0.9, 20.0, 65.0, &[1.0, 2.0, 4.0, 7.0, 10.0], &[0.6831, 1.3881, 2.8270, 5.0373, 7.1247]),
    ("umi", 0.9, 20.0, 90.0, &[1.0, 2.0, 4.0, 7.0, 10.0], &[0.3036, 0.6085, 1.2246, 2.1931, 3.3757]),
    ("umi", 0.9, 40.0, 65.0, &[1.0, 2.0, 4.0, 7.0, 10.0], &[0.7083, 1.4848, 3.2688, 6.1953, 9.4468]),
    ("vekkax", 0.6, 20.0, 45.0, &[1.0, 2.0, 3.0, 4.0, 5.0], &[0.1695, 0.3440, 0.5248, 0.7136, 0.9108]),
    ("umi", 0.9, 20.0, 40.0, &[1.0, 2.0, 4.0, 7.0], &[7.3562, 13.2356, 18.4265, 21.3520]),
    ("umi", 0.9, 40.0, 40.0, &[1.0, 2.0, 4.0, 7.0], &[9.2213, 17.7772, 26.5296, 33.6969]),
    ("umi", 0.9, 40.0, 90.0, &[1.0, 2.0, 4.0, 7.0], &[0.3039, 0.6091, 1.2258, 2.2058]),
];

#[test]
fn printed_fingers_agree_with_finite_elements() {
    for (finger, half, radius, height, distances, elements) in PRESSED {
        let text = format!(
            "finger = \"preset:{finger}\"\n[object]\nshape = \"circle\"\nradius_mm = {radius:?}\ncentre_mm = [{:?}, {height:?}]\n\
             [motion]\ndirection = [1.0, 0.0]\ndistances_mm = {distances:?}\n",
            radius + half
        );
        let run = solved(&text);
        for ((place, distance), elements) in run.places.iter().zip(distances).zip(elements) {
            let state = place.state.as_ref().unwrap_or_else(|| panic!("{finger}: {:?} at {distance} mm", place.status));
            let error = state.force_magnitude_n() / elements - 1.0;
            println!("{finger} on {radius} mm at {height} mm, moved by {distance} mm: {:+.2} %", 100.0 * error);
            assert!(error.abs() < 0.02, "{finger} on {radius} mm at {height} mm, moved by {distance} mm: {error}");
        }
    }
}

/// Forces of CalculiX, N, on level or inclined ribs between the beams of `fea-80` with fillets, Ø80 at Mid, at 2, 4, 6 and 8°
/// (`fre compare --fea` makes them): thickness, mm, angle, degrees, radius of the fillets, mm.
const FILLETED: [(f64, f64, f64, [f64; 4]); 5] = [
    (1.2, 0.0, 0.0, [2.1542, 4.4560, 7.4070, 11.3496]),
    (1.2, 0.0, 1.2, [2.7412, 5.7553, 9.7120, 14.6548]),
    (0.8, 0.0, 1.0, [1.3431, 2.8424, 4.9659, 8.7900]),
    (2.0, 0.0, 1.0, [6.4476, 12.9719, 20.1347, 27.6831]),
    (1.2, 20.0, 1.2, [2.8869, 6.2795, 10.6244, 15.8037]),
];

/// The same on ribs that end with a gap: thickness, mm, angle, degrees, gap and height of the circle, mm.
const GAPPED: [(f64, f64, f64, f64, [f64; 4]); 4] = [
    (2.0, 0.0, 0.1, 30.0, [0.5953, 1.2060, 1.8058, 2.3628]),
    (2.0, -20.0, 0.05, 30.0, [0.6245, 1.2569, 1.8851, 2.4903]),
    (1.2, 20.0, 0.2, 38.0, [0.4989, 1.0263, 1.5669, 2.0289]),
    (3.0, 0.0, 0.02, 45.0, [0.5707, 1.1789, 1.6525, 1.9536]),
];

/// The beams of `fea-80` with seven ribs on Ø80: thickness, mm, angle, degrees, more keys of the ribs and height of the circle, mm.
fn ribbed(thickness: f64, degrees: f64, more: &str, height: f64, angles: &[f64]) -> String {
    format!(
        "[finger]\nname = \"ribs\"\nwidth_mm = 20\nplane_strain = \"stress\"\n\
             material = {{ youngs_modulus_pa = 4.95e7, poissons_ratio = 0.48 }}\n\
             front = {{ base_mm = [0, 0], tip_mm = [0, 80], thickness_mm = 2 }}\n\
             back = {{ base_mm = [-28, 0], tip_mm = [0, 80], thickness_mm = 2 }}\n\
             tip = {{ rigid_above_mm = 74.1158 }}\nmotor = {{ axis_mm = [-14, -20] }}\n\
             lamellae = {{ kind = \"rib\", heights_mm = [9, 18, 27, 36, 45, 54, 63], thickness_mm = {thickness:?}, \
             angle_deg = {degrees:?}, {more} }}\n\
             [object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, {height:?}]\n\
             [motion]\nmotor_angles_deg = {angles:?}\n"
    )
}

#[test]
fn fillets_stiffen_a_finger_as_finite_elements_say() {
    for (thickness, degrees, fillet, elements) in FILLETED {
        let text = ribbed(thickness, degrees, &format!("fillet_mm = {fillet:?}"), 45.0, &[2.0, 4.0, 6.0, 8.0]);
        for (place, elements) in solved(&text).places.iter().zip(elements) {
            let error = place.force_magnitude_n().expect("a force") / elements - 1.0;
            println!("ribs {thickness} mm, {degrees}°, fillets {fillet} mm, at {}°: {:+.2} %", place.at, 100.0 * error);
            let most = if degrees == 0.0 { 0.02 } else { 0.03 };
            assert!(error.abs() < most, "{thickness} mm, {degrees}°, {fillet} mm: {error}");
        }
    }
}

#[test]
fn ribs_with_a_gap_bear_what_finite_elements_say() {
    for (thickness, degrees, gap, height, elements) in GAPPED {
        let text =
            ribbed(thickness, degrees, &format!("ends = \"gap\", gap_mm = {gap:?}"), height, &[2.0, 4.0, 6.0, 8.0]);
        for (place, elements) in solved(&text).places.iter().zip(elements) {
            let error = place.force_magnitude_n().expect("a force") / elements - 1.0;
            println!("ribs {thickness} mm, {degrees}°, gap {gap} mm, at {}°: {:+.2} %", place.at, 100.0 * error);
            assert!(error.abs() < 0.02, "{thickness} mm, {degrees}°, {gap} mm: {error}");
        }
    }
}

/// Finite elements of `umi` lose force where a rib bows, which the model follows within 10 % only. Healthy ribs are not warned of.
#[test]
fn ribs_that_bow_are_warned_of() {
    let bowing = |run: &Run| -> Vec<Option<(usize, f64)>> {
        let states = run.places.iter().map(|place| place.state.as_ref().expect("a state"));
        states.map(|state| state.buckling.map(|buckling| (buckling.rib, buckling.share))).collect()
    };
    let umi = solved(
        "finger = \"preset:umi\"\n[object]\nshape = \"circle\"\nradius_mm = 20\ncentre_mm = [20.9, 40]\n\
         [motion]\ndirection = [1, 0]\ndistances_mm = [1, 2, 5, 7, 10]\n",
    );
    let found = bowing(&umi);
    println!("umi on 20 mm at 40 mm: {found:.3?}");
    assert_eq!(found[0], None);
    assert!(found[1..].iter().all(|found| found.is_some_and(|(rib, share)| rib == 6 && (0.85..0.95).contains(&share))));
    let warned =
        umi.warnings.iter().map(ToString::to_string).find(|warning| warning.starts_with("rib 7 carries")).unwrap();
    assert!(warned.contains("0.8 or more from 2 mm on"), "{warned}");
    let rows: Vec<Row> = serde_json::from_str(&json(&umi).unwrap()).unwrap();
    assert!(rows[0].buckling.is_none() && rows[1].buckling.as_ref().is_some_and(|written| written.rib == "rib 7"));

    // On the objects of `ribs.csv`: at High the finger snaps at 9.15°.
    for (thickness, height, angles, expected) in [
        (0.8, 45.0, &[4.0, 8.0, 9.0, 9.5], 4),
        (1.2, 45.0, &[4.0, 8.0, 9.0, 10.0], 4),
        (2.0, 45.0, &[4.0, 8.0, 9.0, 10.0], 4),
        (1.2, 60.0, &[8.0, 8.5, 9.0, 9.1], 3),
    ] {
        let found = bowing(&solved(&ribbed(thickness, 0.0, "fillet_mm = 0.0", height, angles)));
        println!("ribs of {thickness} mm at {height} mm: {found:.3?}");
        let first = found.iter().position(Option::is_some).unwrap_or(found.len());
        assert_eq!(first, expected, "{thickness} mm at {height} mm: {found:?}");
    }
}

/// A bore gives way where its radius grows: derivatives against differences, of a cylinder as well.
#[test]
fn derivatives_with_the_radius_are_those_of_the_key() {
    for (shape, radius, centre, degrees) in [("circle", 40.0, [41, 45], 6.0), ("bore", 200.0, [-180, -2], 2.5)] {
        let state = |radius: f64| {
            let text = format!(
                "finger = \"preset:ladder-80\"\nmotion.motor_angles_deg = [{degrees}]\n\
                 object = {{ shape = \"{shape}\", radius_mm = {radius}, centre_mm = {centre:?} }}\n"
            );
            let run = solve(&Case::parse("case.toml", &text).unwrap(), &Options::default()).unwrap();
            assert!(run.is_trustworthy(), "{shape} {radius}");
            run.places[0].state.clone().unwrap()
        };
        let step = 0.002;
        let [less, more] = [-step, step].map(|change| state(radius + change));
        let found = state(radius).sensitivity.unwrap();
        for axis in 0..2 {
            let expected = (more.force_n[axis] - less.force_n[axis]) / (2.0 * step);
            let off = found.force_per_radius_mm_n[axis] - expected;
            assert!(off.abs() < 0.02 * expected.abs() + 1e-3, "{shape}: {found:?}, by differences {expected}");
        }
        let expected = (more.motor_torque_nmm - less.motor_torque_nmm) / (2.0 * step);
        assert!((found.torque_per_radius_mm_nmm / expected - 1.0).abs() < 0.02, "{shape}: {found:?} {expected}");
    }
}
