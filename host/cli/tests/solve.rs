//! `fre solve` from the outside: outputs, exit statuses, messages.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use fre::shape::{Contact, Slip};
use fre::study::json::Row;
use serde_json::Value;
use tempfile::TempDir;

/// A folder of its own for each test, removed when dropped.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn case(&self, height: f64, angles: &str) -> PathBuf {
        self.file(&format!(
            "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, {height}]\n\
             [motion]\nmotor_angles_deg = {angles}\n"
        ))
    }

    fn file(&self, text: &str) -> PathBuf {
        let path = self.0.path().join("case.toml");
        std::fs::write(&path, text).unwrap();
        path
    }
}

fn fre(case: &Path, options: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fre")).arg("solve").arg(case).args(options.split_whitespace()).output().unwrap()
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn solutions(case: &Path, options: &str) -> Vec<Row> {
    let output = fre(case, &format!("{options} --format json"));
    assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn the_full_resolution_agrees_with_the_reference_row() {
    let folder = Folder::new();
    let case = folder.case(60.0, "[6.0, 12.0]");
    let solved = solutions(&case, "--physics paper --scheme paper --elements paper");
    let [first, second] = &solved[..] else { panic!("two angles were asked for") };
    let near = |found: Option<f64>, expected: f64, tolerance: f64| {
        let found = found.unwrap();
        assert!((found - expected).abs() < tolerance, "{found} is not {expected}");
    };
    // ladder-80.csv, paper-170-20-nodes, R40-High.
    near(first.force_magnitude_n, 25.838158, 1e-6);
    near(first.force_n.map(|f| f[1]), -8.9419252699, 1e-6);
    near(first.force_finger_frame_n.map(|f| f[0]), 25.0434300995, 1e-6);
    near(first.energy_nmm, 123.3038302839, 1e-5);
    near(first.motor_torque_nmm, 2431.129258, 1e-4);
    near(second.tip_mm.map(|p| p[0]), -17.1049345295, 1e-6);
    near(second.force_magnitude_n, 32.275953, 1e-6);
    assert_eq!((first.contacts.len(), second.contacts.len()), (3, 3));
    assert_eq!(first.model.unknowns, 612);
}

#[test]
fn json_has_the_contract_s_keys_in_its_order() {
    let folder = Folder::new();
    let output = fre(&folder.case(45.0, "[0, 4.0]"), "--format json --elements reduced");
    let text = words(&output.stdout);
    let order = [
        "status",
        "motor_angle_deg",
        "force_n",
        "force_magnitude_n",
        "force_finger_frame_n",
        "motor_torque_nmm",
        "energy_nmm",
        "gap_mm",
        "tip_mm",
        "front_mm",
        "back_mm",
        "lamellae_mm",
        "contacts",
        "max_strain",
        "sensitivity",
        "iterations",
        "steps",
        "elapsed_us",
        "model",
        "branch",
        "first_branch",
        "contact_pressure",
        "strains",
        "beyond_max_strain",
        "overlap_mm",
        "self_contact",
        "buckling",
        "warnings",
    ];
    let places: Vec<usize> = order.iter().map(|key| text.find(&format!("\"{key}\"")).unwrap()).collect();
    assert!(places.is_sorted(), "{places:?}");
    let value: Value = serde_json::from_str(&text).unwrap();
    let results = value.as_array().unwrap();
    assert_eq!(results[0]["status"], "no-contact");
    assert_eq!(results[0]["force_n"], serde_json::json!([0.0, 0.0]));
    let touching = &results[1];
    assert_eq!(touching.as_object().unwrap().len(), order.len());
    assert_eq!((&touching["status"], &touching["motor_angle_deg"]), (&"converged".into(), &4.0.into()));
    assert_eq!(
        touching["model"],
        serde_json::json!({ "scheme": "simpson", "elements_per_beam": 17, "elements_per_hinge": 1,
            "unknowns": touching["model"]["unknowns"], "physics": "extended", "precision": "f64",
            "version": env!("CARGO_PKG_VERSION") })
    );
    assert_eq!(touching["lamellae_mm"].as_array().unwrap().len(), 7);
    assert_eq!(touching["front_mm"][0], serde_json::json!([0.0, 0.0]));
    // The contacts add up to the force, and the force points into the object.
    let contacts = touching["contacts"].as_array().unwrap();
    let sum: f64 = contacts.iter().map(|c| -c["force_n"].as_f64().unwrap() * c["normal"][0].as_f64().unwrap()).sum();
    assert!((sum - touching["force_finger_frame_n"][0].as_f64().unwrap()).abs() < 1e-9 && sum > 1.0);
    for key in ["arc_mm", "position_mm", "normal", "force_n"] {
        assert!(!contacts[0][key].is_null(), "{key}");
    }
}

/// Friction closes with more force than it opens with, is noted once, and leaves the case without it as it is.
#[test]
fn friction_makes_the_force_depend_on_the_path() {
    let folder = Folder::new();
    let case = |friction: &str| {
        folder.file(&format!(
            "finger = \"preset:fea-80\"\nobject = {{ shape = \"circle\", radius_mm = 40, centre_mm = [41, 45]{friction} }}\n\
             motion.motor_angles_deg = [2, 6, 8, 7, 6, 0]\n"
        ))
    };
    let smooth = solutions(&case(""), "");
    assert_eq!(
        smooth,
        solutions(&case(", friction = 0"), "")
            .iter()
            .zip(&smooth)
            .map(|(a, b)| Row { elapsed_us: b.elapsed_us, ..a.clone() })
            .collect::<Vec<_>>()
    );
    assert!(
        smooth.iter().all(|row| row.friction.is_none() && row.contacts.iter().all(|contact| contact.state.is_none()))
    );
    let rough = solutions(&case(", friction = 0.6"), "");
    for (row, frictionless) in rough.iter().zip(&smooth) {
        let of_friction: Vec<&str> =
            row.warnings.iter().map(String::as_str).filter(|warning| warning.contains("friction")).collect();
        snapbox::assert_data_eq!(
            of_friction.join("\n"),
            snapbox::str![
                "object.friction: the force depends on the path, which is from an open hand through the places in their order; derivatives are left out"
            ]
        );
        assert!(row.sensitivity.is_none() || row.contacts.is_empty());
        let found = row.friction.unwrap();
        let sum = |of: &dyn Fn(&Contact) -> f64| row.contacts.iter().map(of).sum::<f64>();
        assert!((sum(&|contact| contact.force) - found.normal_n).abs() < 1e-9);
        assert!((sum(&|contact| contact.tangential.unwrap()) - found.tangential_n).abs() < 1e-9);
        for contact in &row.contacts {
            let [along, cone] = [contact.tangential.unwrap(), 0.6 * contact.force];
            match contact.state.unwrap() {
                Slip::Stick => assert!(along.abs() <= cone + 1e-7),
                Slip::Up => assert!((along - cone).abs() < 1e-7),
                Slip::Down => assert!((along + cone).abs() < 1e-7),
            }
        }
        assert_eq!(row.motor_angle_deg, frictionless.motor_angle_deg);
        let interval = row.force_interval_n.unwrap();
        let within = |[low, high]: [f64; 2], value: f64| (low - 0.01 * high..=1.01 * high + 1e-9).contains(&value);
        assert!(within(interval.normal, found.normal_n) && within(interval.torque_nmm, row.motor_torque_nmm.unwrap()));
        assert!(within(interval.magnitude, row.force_magnitude_n.unwrap()), "{row:?}");
    }
    let force = |rows: &[Row], place: usize| rows[place].force_magnitude_n.unwrap();
    // The same angle, closing and opening.
    assert!(force(&rough, 1) > 1.2 * force(&smooth, 1) && force(&rough, 1) > 1.2 * force(&rough, 4));
    assert!((force(&smooth, 1) - force(&smooth, 4)).abs() < 1e-6);
    let dissipated: Vec<f64> = rough.iter().map(|row| row.friction.unwrap().dissipated_nmm).collect();
    assert!(dissipated.windows(2).all(|pair| pair[1] >= pair[0] - 1e-9) && dissipated[4] > 1.0, "{dissipated:?}");

    let path = case(", friction = 0.6");
    let text = words(&fre(&path, "").stdout);
    let line = text.lines().find(|line| line.contains("friction 0.6")).unwrap_or(&text);
    snapbox::assert_data_eq!(
        line,
        snapbox::str![
            "friction 0.6: sums over the contacts, + where the object pulls the finger towards its tip; the mobilised share is 1 where"
        ]
    );
    let refused = Command::new(env!("CARGO_BIN_EXE_fre")).args(["compare", "--fea"]).arg(&path).output().unwrap();
    assert_eq!(refused.status.code(), Some(1));
    let refused = words(&refused.stderr).replace(path.parent().unwrap().to_str().unwrap(), "FOLDER");
    snapbox::assert_data_eq!(
        refused,
        snapbox::str![[r#"
fre: FOLDER/case.toml: motion.motor_angles_deg[3] = 7: the finger opens from 8, and object.friction is 0.6; CalculiX takes friction for what it is only while a finger closes: allowed are places that grow, or object.friction = 0

"#]]
    );
}

#[test]
fn csv_and_text_say_the_same() {
    let folder = Folder::new();
    let case = folder.case(45.0, "[2, 6]");
    let csv = words(&fre(&case, "--format csv").stdout);
    let mut lines = csv.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let expected = "status,motor_angle_deg,force_x_n,force_y_n,force_n,force_finger_frame_x_n,force_finger_frame_y_n,\
        motor_torque_nmm,energy_nmm,tip_x_mm,tip_y_mm,contacts,iterations,steps,elapsed_us,scheme,elements_per_beam,\
        elements_per_hinge,unknowns,physics,precision,max_strain_front,max_strain_back,max_strain_hinge,\
        force_x_per_deg_n,force_y_per_deg_n,gap_mm,force_x_per_centre_x_mm_n,force_y_per_centre_x_mm_n,\
        force_x_per_centre_y_mm_n,force_y_per_centre_y_mm_n,max_pressure_n_per_mm2,beyond_max_strain,branch,\
        first_branch_max_force_n,first_branch_max_force_at_deg,snap_after_deg,snap_before_deg,overlap_mm,force_magnitude_n,\
        friction_normal_n,friction_tangential_n,friction_mobilised,friction_dissipated_nmm,time_s";
    assert_eq!(header, expected.split(',').collect::<Vec<_>>(), "the header is stable: add at its end only");
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert!(rows.len() == 2 && rows.iter().all(|row| row.len() == header.len()), "{csv}");
    let text = words(&fre(&case, "").stdout);
    let force: f64 = rows[1][4].parse().unwrap();
    let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split_whitespace().collect()).collect();
    let place = lines.iter().find(|line| line.first() == Some(&"6.000")).expect("the place's line");
    assert_eq!(place[1..3], ["converged", &format!("{force:.4}")], "{text}");
}

#[test]
fn every_option_reaches_the_model() {
    let folder = Folder::new();
    let case = folder.case(60.0, "[8.0]");
    let force = |options: &str| {
        let solution = solutions(&case, options).remove(0);
        (solution.force_magnitude_n.unwrap(), solution.model)
    };
    let (fine, model) = force("");
    assert_eq!((model.scheme.as_str(), model.elements_per_beam, model.elements_per_hinge), ("simpson", 32, 2));
    assert_eq!(model.physics, "extended");
    let near = |value: f64, share: f64| assert!((value / fine - 1.0).abs() < share && value != fine, "{value} {fine}");
    near(force("--precision f32").0, 1e-4);
    near(force("--elements reduced").0, 0.05);
    near(force("--elements 60/5").0, 0.02);
    near(force("--samples 8").0, 0.02);
    near(force("--softness-mm-per-n 0.01").0, 0.05);
    let (paper, model) = force("--physics paper --scheme trapezoid --elements 48/4");
    assert!(paper > 1.2 * fine, "inextensible beams are stiffer at High: {paper} {fine}");
    assert_eq!((model.scheme.as_str(), model.elements_per_beam, model.physics.as_str()), ("trapezoid", 48, "paper"));
}

#[test]
fn the_sensitivity_is_the_slope_of_the_force() {
    let folder = Folder::new();
    let solved = solutions(&folder.case(60.0, "[7.999, 8.0, 8.001]"), "");
    let [before, here, after] = &solved[..] else { panic!("three angles were asked for") };
    let slope = here.sensitivity.unwrap().force_per_deg_n.unwrap();
    for i in 0..2 {
        let difference = (after.force_n.unwrap()[i] - before.force_n.unwrap()[i]) / 0.002;
        assert!((slope[i] - difference).abs() < 1e-3 * difference.abs(), "{slope:?} {difference}");
    }
    // A finger pushed by a larger object, or by one nearer, pushes back harder.
    let sensitivity = here.sensitivity.unwrap();
    assert!(sensitivity.force_per_radius_mm_n[0] > 0.0 && sensitivity.force_per_centre_mm_n[0][0] < 0.0);
    assert_eq!(sensitivity.stiffness_n_per_mm[0][1], sensitivity.force_per_centre_mm_n[1][0]);
    let strain = here.max_strain.unwrap();
    assert!(strain.front > 0.001 && strain.back > 0.001 && strain.hinge < 0.5, "{strain:?}");
}

#[test]
fn sensitivities_to_dimensions_are_slopes_of_the_force() {
    let folder = Folder::new();
    let case = |key: &str, value: f64| {
        let mut values =
            [("youngs_modulus_pa", 4.95e7), ("front", 2.0), ("back", 2.0), ("hinge", 0.8), ("length", 2.5)];
        for (name, entry) in &mut values {
            if *name == key {
                *entry += value;
            }
        }
        let [e, front, back, hinge, length] = values.map(|(_, value)| value);
        folder.file(&format!(
            "object = {{ shape = \"circle\", radius_mm = 40, centre_mm = [41, 45] }}\n\
             motion = {{ motor_angles_deg = [8] }}\n\
             [finger]\nname = \"f\"\nwidth_mm = 20\nplane_strain = \"stress\"\n\
             [finger.material]\nyoungs_modulus_pa = {e:?}\npoissons_ratio = 0.48\n\
             [finger.front]\nbase_mm = [0, 0]\ntip_mm = [0, 80]\nthickness_mm = {front:?}\n\
             [finger.back]\nbase_mm = [-28, 0]\ntip_mm = [0, 80]\nthickness_mm = {back:?}\n\
             [finger.lamellae]\nheights_mm = [9, 18, 27, 36, 45, 54, 63]\nthickness_mm = 3\n\
             [finger.hinge]\nkind = \"flexible\"\nlength_mm = {length:?}\nthickness_mm = {hinge:?}\nfrom = \"centreline\"\n\
             [finger.motor]\naxis_mm = [-14, -20]\n"
        ))
    };
    let exact = solutions(&case("", 0.0), "")[0].sensitivity.unwrap();
    for (key, step, unit, slope) in [
        ("youngs_modulus_pa", 1e4, 1e6, exact.force_per_youngs_modulus_mpa_n),
        ("front", 1e-3, 1.0, exact.force_per_front_thickness_mm_n.unwrap()),
        ("back", 1e-3, 1.0, exact.force_per_back_thickness_mm_n.unwrap()),
        ("hinge", 1e-3, 1.0, exact.force_per_hinge_thickness_mm_n.unwrap()),
        ("length", 1e-3, 1.0, exact.force_per_hinge_length_mm_n.unwrap()),
    ] {
        let force = |by| solutions(&case(key, by), "")[0].force_n.unwrap();
        let (more, less) = (force(step), force(-step));
        for i in 0..2 {
            let difference = (more[i] - less[i]) / (2.0 * step) * unit;
            let size = slope[0].hypot(slope[1]);
            assert!((slope[i] - difference).abs() < 1e-4 * size, "{key}: {slope:?} {difference}");
        }
    }
}

#[test]
fn gauss_newton_finds_the_same_solution_in_more_iterations() {
    let folder = Folder::new();
    let case = folder.case(25.0, "[2.0, 4.0]");
    let newton = solutions(&case, "--physics paper --elements reduced");
    let gauss = solutions(&case, "--physics paper --elements reduced --hessian gauss-newton");
    let count = |of: &[Row]| of.iter().map(|s| s.iterations).sum::<u32>();
    // Double precision's Newton takes more steps, cheap ones, since they keep the stiffness of the first.
    assert!(count(&gauss) > count(&newton), "{} {}", count(&gauss), count(&newton));
    for (a, b) in newton.iter().zip(&gauss) {
        assert!((a.force_magnitude_n.unwrap() - b.force_magnitude_n.unwrap()).abs() < 1e-6);
    }
}

#[test]
fn a_translated_base_reports_distances() {
    let folder = Folder::new();
    let case = folder.file(
        "finger = \"preset:ladder-80\"\nobject = { shape = \"circle\", radius_mm = 20, centre_mm = [30, 50] }\n\
         motion = { direction = [1, 0], distances_mm = [5, 10, 12] }\n",
    );
    let output = fre(&case, "--format json");
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(value[1]["distance_mm"], 10.0);
    assert!(value[2]["sensitivity"]["force_per_mm_n"][0].as_f64().unwrap() > 0.0, "{value}");
    assert!(value[2]["sensitivity"].get("force_per_deg_n").is_none());
    assert!(value[1].get("motor_angle_deg").is_none());
    assert_eq!(value[0]["status"], "no-contact");
    assert!(value[2]["force_n"][0].as_f64().unwrap() > 0.1, "{value}");
    assert!(words(&fre(&case, "--format csv").stdout).starts_with("status,distance_mm,"));
}

#[test]
fn an_angle_without_a_solution_is_status_2_and_has_no_numbers() {
    let folder = Folder::new();
    // The cylinder surrounds the motor axis and the finger: no angle is free of contact.
    let case = folder.file(
        "finger = \"preset:ladder-80\"\nobject = { shape = \"circle\", radius_mm = 200, centre_mm = [-14, -20] }\n\
         motion.motor_angles_deg = [0, 5]\n",
    );
    let output = fre(&case, "--format json");
    assert_eq!(output.status.code(), Some(2));
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(value.as_array().unwrap().len(), 2);
    assert_eq!(value[0]["status"], "out-of-range");
    assert!(value[0]["force_n"].is_null() && value[0]["contacts"].as_array().unwrap().is_empty());
    let csv = words(&fre(&case, "--format csv").stdout);
    assert!(csv.lines().nth(1).unwrap().starts_with("out-of-range,0,,,,"), "{csv}");
    assert!(words(&fre(&case, "").stdout).contains('–'));
}

#[test]
fn numbers_come_with_a_trustworthy_status_only() {
    let folder = Folder::new();
    // Far beyond contact: snap-throughs, the finger slips past the cylinder, and must come back through it.
    let case = folder.case(45.0, "[5, 30, 60, 90, 5]");
    let output = fre(&case, "--format json");
    let solved: Vec<Row> = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(solved.iter().filter_map(|row| row.motor_angle_deg).collect::<Vec<_>>(), [5.0, 30.0, 60.0, 90.0, 5.0]);
    let trusted = solved.iter().filter(|solution| solution.status.is_trustworthy()).count();
    assert_eq!(output.status.code(), Some(if trusted == solved.len() { 0 } else { 2 }));
    assert!(trusted >= 1 && solved[0].force_magnitude_n.unwrap() > 1.0);
    for solution in &solved {
        assert_eq!(solution.force_n.is_some(), solution.status.is_trustworthy(), "{solution:?}");
        assert_eq!(solution.front_mm.is_empty(), !solution.status.is_trustworthy());
    }
}

#[test]
fn plots_are_written_and_bad_endings_refused_before_solving() {
    let folder = Folder::new();
    let case = folder.case(45.0, "[2, 6, 10]");
    for (name, start) in [("a.svg", &b"<svg"[..]), ("a.png", b"\x89PNG")] {
        let file = folder.0.path().join(name);
        let output = fre(&case, &format!("--plot {}", file.display()));
        assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
        assert!(std::fs::read(&file).unwrap().starts_with(start));
    }
    let output = fre(&case, "--plot a.jpg");
    assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0));
    assert_eq!(words(&output.stderr), "fre: a.jpg: a picture's file ends in .svg or .png\n");
}

#[test]
fn bad_input_is_status_1_with_a_message() {
    let folder = Folder::new();
    let case = folder.case(45.0, "[2]");
    let mut said = String::new();
    let mut refused = |what: &str, case: &Path, options: &str| {
        let output = fre(case, options);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0), "{what}");
        let folder = case.parent().unwrap().to_str().unwrap();
        said += &format!("{what}\n{}\n", words(&output.stderr).replace(&format!("{folder}/"), ""));
    };
    for options in [
        "--elements 3",
        "--elements 3/0",
        "--elements 3/1",
        "--elements many",
        "--scheme euler",
        "--samples 0",
        "--samples 4 --scheme paper",
        "--samples 1000",
        "--samples few",
        "--softness-mm-per-n nan",
        "--softness-mm-per-n -1",
        "--precision f16",
        "--format xml",
        "--loud",
    ] {
        refused(options, &case, options);
    }
    refused("a file that is not there", &folder.0.path().join("absent.toml"), "");
    let object = "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\n";
    for (what, keys) in
        [("no centre", "radius_mm = 40\n"), ("a negative radius", "radius_mm = -1\ncentre_mm = [41, 45]\n")]
    {
        refused(what, &folder.file(&format!("{object}{keys}")), "");
    }
    snapbox::assert_data_eq!(said, snapbox::file!["words/solve.txt"].raw());
    let no_command = Command::new(env!("CARGO_BIN_EXE_fre")).output().unwrap();
    assert_eq!(no_command.status.code(), Some(1));
    let help = Command::new(env!("CARGO_BIN_EXE_fre")).args(["solve", "--help"]).output().unwrap();
    assert_eq!(help.status.code(), Some(0));
}

/// What cannot be written is told; that nobody reads what is told besides is no failure.
#[test]
fn a_full_disk_is_told_and_a_deaf_terminal_is_not() {
    let folder = Folder::new();
    let file = folder.case(45.0, "[2.0, 4.0]");
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
        command.arg("solve").args(arguments);
        command
    };
    let told = run(&[file.to_str().unwrap(), "--format", "json"]).stdout(full()).output().unwrap();
    assert_eq!(told.status.code(), Some(1));
    assert!(words(&told.stderr).starts_with("fre: standard output: "), "{}", words(&told.stderr));
    // A message that finds no room.
    assert_eq!(run(&["no.toml"]).stderr(full()).status().unwrap().code(), Some(1));
    let deaf = run(&[file.to_str().unwrap(), "--format", "csv"]).stderr(full()).output().unwrap();
    assert_eq!(deaf.status.code(), Some(0));
    assert!(words(&deaf.stdout).lines().count() > 1);
}

/// A pipe is gone once it is read.
#[cfg(unix)]
#[test]
fn a_case_is_read_from_a_pipe() {
    let folder = Folder::new();
    let file = folder.case(45.0, "[2.0]");
    let mut command = Command::new("sh");
    command
        .args(["-c", "cat \"$2\" | \"$1\" solve /dev/stdin --format csv", "sh", env!("CARGO_BIN_EXE_fre")])
        .arg(&file);
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
    assert_eq!(words(&output.stdout).lines().count(), 2);
}

/// The message is about the number, not about an option that nobody gave.
#[test]
fn a_negative_number_is_a_value() {
    for (arguments, message) in [
        ("solve case.toml --samples -3", "fre: invalid value '-3' for '--samples <N>': allowed is 1 to 16"),
        (
            "calibrate x.csv --case case.toml --force-sd-n -3",
            "fre: invalid value '-3' for '--force-sd-n <N>': allowed is a number above 0, up to 1000",
        ),
        ("sweep case.toml --jobs -3", "fre: invalid value '-3' for '--jobs <N>': -3 is not in 0..=1024"),
        ("monitor --bus nowhere --seconds -3", "fre: --seconds is -3; allowed is 0 and more"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_fre")).args(arguments.split(' ')).output().unwrap();
        let said = words(&output.stderr);
        assert!(output.status.code() == Some(1) && said.starts_with(message), "{arguments}: {said}");
    }
}
