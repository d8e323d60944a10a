//! `fre sweep`: rows equal to direct solutions, a stopped sweep goes on, failures and mistakes are told.

#[path = "../said/mod.rs"]
mod said;

mod shards;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use fre::case::{Case, Document};
use fre::study::model::Options;
use fre::study::run;
use fre::study::sweep::{self, Axis, Ledger, Sweep, Tally};
use model_core::discretise::Elements;
use tempfile::TempDir;

/// A folder of its own for each test, removed when dropped.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("case.toml"), case_text(40.0, 45.0)).unwrap();
        Self(folder)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn fre(&self, options: &str) -> Output {
        self.command(options).output().unwrap()
    }

    fn command(&self, options: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
        command.args(["sweep", "case.toml"]).args(options.split_whitespace()).current_dir(self.0.path());
        command
    }
}

fn case_text(radius: f64, height: f64) -> String {
    format!(
        "finger = \"preset:fea-80\"\n[object]\nshape = \"circle\"\nradius_mm = {radius:?}\ncentre_mm = [41.0, {height:?}]\n\
         [motion]\nmotor_angles_deg = [2.0, 4.0]\n"
    )
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Two radii and two resolutions: four points, eight rows.
fn small() -> Sweep {
    let document = Document::resolve("case.toml", &case_text(40.0, 45.0), Path::new("")).unwrap();
    let axes = vec![
        Axis::Key { key: "object.radius_mm".into(), values: vec![38.0, 40.0] },
        Axis::Elements(vec![
            ("reduced".into(), Elements::REDUCED),
            ("24/3".into(), Elements::PerBeam { beam: 24, hinge: 3 }),
        ]),
    ];
    Sweep::new(document, None, axes, Options::default()).unwrap()
}

fn go_on(sweep: &Sweep, file: &Path) -> Tally {
    let mut ledger = Ledger::open(file, sweep).unwrap();
    sweep::run(sweep, Some(&mut ledger), &mut Vec::new(), 1, |_| ControlFlow::Continue(())).unwrap()
}

/// The lines without the time, which no two runs share.
fn timeless(text: &str) -> Vec<String> {
    let time = text.lines().next().unwrap().split(',').position(|name| name == "elapsed_us").unwrap();
    let keep = |line: &str| {
        let cells = line.split(',').enumerate().filter(|&(index, _)| index != time).map(|(_, cell)| cell);
        cells.collect::<Vec<_>>().join(",")
    };
    text.lines().map(keep).collect()
}

#[test]
fn rows_are_those_of_a_direct_solution() {
    let folder = Folder::new();
    let output = folder.fre("--angles 1:5:2 --vary object.centre_mm.1=40:50:5 --vary elements=reduced,60/4");
    assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
    let text = words(&output.stdout);
    let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(lines[0][..5], ["row", "object.centre_mm.1", "elements", "status", "motor_angle_deg"]);
    assert_eq!(lines.len(), 1 + 3 * 2 * 3);
    let column = |name: &str| lines[0].iter().position(|head| *head == name).unwrap();
    let mut row = 0;
    for height in [40.0, 45.0, 50.0] {
        for (word, elements) in [("reduced", Elements::REDUCED), ("60/4", Elements::PerBeam { beam: 60, hinge: 4 })] {
            let mut case = Case::parse("case.toml", &case_text(40.0, height)).unwrap();
            case.path.places = vec![1.0, 3.0, 5.0];
            let mut options = Options::default();
            options.discretisation.elements = elements;
            let run = run::solve(&case, &options).unwrap();
            for place in &run.places {
                let state = place.state.as_ref().unwrap();
                row += 1;
                let cell = |name: &str| lines[row][column(name)];
                let number = |name: &str| cell(name).parse::<f64>().unwrap();
                assert_eq!((cell("object.centre_mm.1"), cell("elements")), (height.to_string().as_str(), word));
                assert_eq!((number("row"), cell("status")), ((row - 1) as f64, place.status.word()));
                let strain = state.max_strain;
                for (name, value) in [
                    ("motor_angle_deg", place.at.value()),
                    ("force_x_n", state.force_n[0]),
                    ("force_y_n", state.force_n[1]),
                    ("force_n", state.force_magnitude_n()),
                    ("motor_torque_nmm", state.motor_torque_nmm),
                    ("energy_nmm", state.energy_nmm.unwrap()),
                    ("tip_x_mm", state.tip_mm[0]),
                    ("tip_y_mm", state.tip_mm[1]),
                    ("max_strain_front", strain.front),
                    ("max_strain_back", strain.back),
                    ("max_strain_hinge", strain.hinge),
                    ("contacts", state.shape.contacts.len() as f64),
                    ("iterations", f64::from(place.effort.iterations)),
                    ("elements_per_beam", f64::from(run.model.elements_per_beam)),
                ] {
                    assert_eq!(number(name), value, "{name} in row {row}");
                }
                assert!(number("elapsed_us") > 0.0);
            }
        }
    }
    assert_eq!(row, 18);
    assert_eq!(words(&output.stderr).lines().next(), Some("fre: 18 rows (18 computed): 18 converged"));
    snapbox::assert_data_eq!(
        said::words(&words(&output.stderr)),
        snapbox::str![[r#"
fre: # rows (# computed): # converged
fre: error of the force against the resolution with the most unknowns, and time
elements unknowns time ms mean error % max error % rows compared
reduced # # # # #
#/# # # # # #
"#]]
    );
}

#[test]
fn a_file_torn_anywhere_is_completed() {
    let folder = Folder::new();
    let (sweep, file) = (small(), folder.file("out.csv"));
    let tally = go_on(&sweep, &file);
    assert_eq!((tally.computed, tally.resumed, tally.failures.len()), (8, 0, 0));
    let whole = std::fs::read_to_string(&file).unwrap();
    let header = whole.find('\n').unwrap() + 1;
    let last = whole.trim_end().rfind('\n').unwrap() + 1;
    let middle = whole.match_indices('\n').nth(3).unwrap().0 + 1;
    // Every byte of the last line, some bytes in the middle, the whole header.
    for length in (last..whole.len()).chain(middle..middle + 30).chain(0..=header) {
        std::fs::write(&file, &whole[..length]).unwrap();
        let left = whole[..length].matches('\n').count().saturating_sub(1);
        let tally = go_on(&sweep, &file);
        assert_eq!((tally.resumed, tally.computed), (left, 8 - left), "cut to {length} bytes");
        let again = std::fs::read_to_string(&file).unwrap();
        assert_eq!(timeless(&again), timeless(&whole), "cut to {length} bytes");
        // What was there is not touched.
        if length >= header {
            let kept = whole[..length].rfind('\n').unwrap() + 1;
            assert!(again.starts_with(&whole[..kept]));
        }
    }
}

#[test]
fn a_complete_file_is_left_alone() {
    let folder = Folder::new();
    let (sweep, file) = (small(), folder.file("out.csv"));
    go_on(&sweep, &file);
    let before = std::fs::read(&file).unwrap();
    let tally = go_on(&sweep, &file);
    assert_eq!((tally.computed, tally.resumed), (0, 8));
    assert_eq!(std::fs::read(&file).unwrap(), before);
}

#[test]
fn rows_in_any_order_are_read_and_sorted_at_the_end() {
    let folder = Folder::new();
    let (sweep, file) = (small(), folder.file("out.csv"));
    go_on(&sweep, &file);
    let whole = std::fs::read_to_string(&file).unwrap();
    let lines: Vec<&str> = whole.split_inclusive('\n').collect();
    let torn = format!("{}{}{}{}", lines[0], lines[7], lines[2], &lines[4][..9]);
    std::fs::write(&file, torn).unwrap();
    let tally = go_on(&sweep, &file);
    assert_eq!((tally.computed, tally.resumed), (6, 2));
    assert_eq!(timeless(&std::fs::read_to_string(&file).unwrap()), timeless(&whole));
}

#[test]
fn a_killed_sweep_goes_on_where_it_was() {
    let folder = Folder::new();
    let options = "--angles 0:10:0.05 --vary object.centre_mm.1=30:50:5 --vary elements=60/4,170/20 --jobs 2";
    let file = folder.file("out.csv");
    let with_file = format!("{options} --out out.csv");
    let rows = 201 * 5 * 2;
    // A line that the end has torn is none.
    let lines = || std::fs::read_to_string(&file).unwrap_or_default().matches('\n').count().saturating_sub(1);
    let mut child = folder.command(&with_file).stderr(Stdio::null()).spawn().unwrap();
    let begin = Instant::now();
    while lines() == 0 {
        assert!(begin.elapsed() < Duration::from_secs(120) && child.try_wait().unwrap().is_none(), "no rows appear");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let kept = lines();
    assert!((1..rows).contains(&kept), "killed too late to tell anything: {kept}");
    let output = folder.fre(&with_file);
    let said = words(&output.stderr);
    let known = said.lines().next().unwrap_or_default();
    assert_eq!(known, format!("fre: {kept} of {rows} rows are known already"));
    let direct = folder.fre(options);
    assert_eq!(output.status.code(), direct.status.code());
    assert_eq!(timeless(&std::fs::read_to_string(&file).unwrap()), timeless(&words(&direct.stdout)));
}

#[test]
fn an_interrupted_sweep_says_what_is_there_and_goes_on() {
    let folder = Folder::new();
    let options = "--angles 0:10:0.05 --vary object.centre_mm.1=30:50:1 --vary elements=170/20 --jobs 1";
    let with_file = format!("{options} --out out.csv");
    let rows = 201 * 21;
    let lines =
        || std::fs::read_to_string(folder.file("out.csv")).unwrap_or_default().lines().count().saturating_sub(1);
    let mut child = folder.command(&with_file).stderr(Stdio::piped()).spawn().unwrap();
    let begin = Instant::now();
    while lines() == 0 {
        assert!(begin.elapsed() < Duration::from_secs(120) && child.try_wait().unwrap().is_none(), "no rows appear");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let kept = lines();
    let said = words(&output.stderr);
    assert!((1..rows).contains(&kept), "stopped too late to tell anything: {kept}");
    assert_eq!(output.status.code(), Some(130), "{said}");
    let stopped =
        format!("fre: stopped; {kept} of {rows} rows are in out.csv; run the same command again to continue\n");
    assert_eq!(said, stopped);
    // A few more points are enough to see that it goes on: what is there is known.
    let mut child = folder.command(&with_file).stderr(Stdio::piped()).spawn().unwrap();
    while lines() <= kept {
        assert!(begin.elapsed() < Duration::from_secs(240) && child.try_wait().unwrap().is_none(), "it does not go on");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    let said = words(&child.wait_with_output().unwrap().stderr);
    assert_eq!(said, format!("fre: {kept} of {rows} rows are known already\n"));
}

#[test]
fn a_file_of_something_else_is_not_touched() {
    let folder = Folder::new();
    let file = folder.file("out.csv");
    go_on(&small(), &file);
    let mine = std::fs::read_to_string(&file).unwrap();
    let beside = folder.file("out.csv.sweep");
    let name = std::fs::read_to_string(&beside).unwrap();
    let row = mine.lines().nth(1).unwrap().to_owned();
    let other = |from: &str, to: &str| {
        assert!(name.contains(from), "{name}");
        name.replace(from, to)
    };
    let mut said = String::new();
    let mut refused = |what: &str| {
        let message = Ledger::open(&file, &small()).unwrap_err().to_string();
        let message =
            message.replace(folder.file("").to_str().unwrap(), "").replace(env!("CARGO_PKG_VERSION"), "VERSION");
        said += &format!("{what}\n{message}\n\n");
    };
    for (what, text) in [
        ("another version", other("\"fre\": \"0", "\"fre\": \"9")),
        ("other keys", other("object.radius_mm", "subject.radius_mm")),
        ("fewer rows", other("\"rows\": 8", "\"rows\": 6")),
        ("another identity", other("identity\": \"", "identity\": \"0")),
        ("a shard", other("\n}", ",\n\"shard\": \"1/2\"}")),
        ("no identity", "{}".to_owned()),
    ] {
        std::fs::write(&beside, &text).unwrap();
        refused(what);
        assert_eq!(std::fs::read_to_string(&beside).unwrap(), text);
        assert_eq!(std::fs::read_to_string(&file).unwrap(), mine);
    }
    std::fs::remove_file(&beside).unwrap();
    std::fs::write(&file, "a,b\n1,2\n").unwrap();
    refused("another table");
    std::fs::write(&beside, &name).unwrap();
    for (what, text) in [
        ("another column", mine.replace("status", "state")),
        ("a row twice", format!("{mine}{row}\n")),
        ("another value", mine.replace("\n3,38", "\n3,39")),
        ("another row", mine.replace("\n3,", "\n333,")),
        ("an unknown status", mine.replace("converged", "done")),
        ("a row too many", format!("{mine}0\n")),
    ] {
        assert_ne!(text, mine);
        std::fs::write(&file, &text).unwrap();
        refused(what);
        assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
    }
    std::fs::write(&file, &mine).unwrap();
    let first = Ledger::open(&file, &small()).unwrap();
    refused("two at a time");
    drop(first);
    snapbox::assert_data_eq!(said, snapbox::file!["../words/ledger.txt"].raw());
    let output = folder.fre("--vary object.radius_mm=30 --out out.csv");
    assert_eq!(output.status.code(), Some(1));
    let said = words(&output.stderr);
    assert_eq!(
        said,
        "fre: out.csv: holds another sweep: it varies object.radius_mm, elements, asked for is object.radius_mm; give another --out, or remove the file to begin anew\n"
    );
    assert_eq!(std::fs::read_to_string(&file).unwrap(), mine);
}

/// The file beside the rows is an output as they are.
#[test]
fn the_file_beside_the_rows_takes_the_place_of_nothing() {
    let folder = Folder::new();
    std::fs::copy(folder.file("case.toml"), folder.file("out.csv.sweep")).unwrap();
    let run = |command: &str| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_fre")).args(command.split(' ')).current_dir(folder.0.path()).output();
        let output = output.unwrap();
        (output.status.code(), words(&output.stderr))
    };
    let vary = "--vary object.radius_mm=38,40 --elements reduced --out out.csv";
    let same = |what: &str, other: &str| {
        (
            Some(1),
            format!(
                "fre: {what}: out.csv.sweep is the same file as {other} (out.csv.sweep); an output needs a file of its own\n"
            ),
        )
    };
    assert_eq!(run(&format!("sweep out.csv.sweep {vary}")), same("the file beside --out", "the case"));
    let (code, said) = run(&format!("sweep case.toml {vary}"));
    assert_eq!(code, Some(1));
    let expected = "fre: out.csv: out.csv.sweep beside it does not belong to a sweep; give another --out, or remove the file to begin \
                    anew\n";
    assert_eq!(said, expected);
    assert!(!folder.file("out.csv").exists());
    assert_eq!(std::fs::read(folder.file("out.csv.sweep")).unwrap(), std::fs::read(folder.file("case.toml")).unwrap());
    std::fs::remove_file(folder.file("out.csv.sweep")).unwrap();
    if cfg!(feature = "parquet") {
        let parquet = format!("sweep case.toml {vary} --parquet out.csv.sweep");
        assert_eq!(run(&parquet), same("--parquet", "the file beside --out"));
    }
}

#[test]
fn a_changed_case_is_not_mixed_with_what_is_there() {
    let folder = Folder::new();
    let file = folder.file("out.csv");
    let options = "--vary object.radius_mm=38,40 --out out.csv";
    assert_eq!(folder.fre(options).status.code(), Some(0));
    let before = std::fs::read_to_string(&file).unwrap();
    std::fs::write(folder.file("case.toml"), case_text(40.0, 45.5)).unwrap();
    for options in [options, &format!("{options} --elements reduced")] {
        let output = folder.fre(options);
        let said = words(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert_eq!(
            said,
            "fre: out.csv: holds another sweep: it has another case, other values or other model options; give another --out, or remove the file to begin anew\n"
        );
    }
    assert_eq!(std::fs::read_to_string(&file).unwrap(), before);
}

#[test]
fn a_refused_sweep_leaves_no_file_behind() {
    let folder = Folder::new();
    let output = folder.fre("--vary object.radius_mm=40,-5 --out out.csv");
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(
        words(&output.stderr),
        "fre: at object.radius_mm=-5: object.radius_mm = -5.0: allowed is 0.1 to 1000 mm\n"
    );
    assert!(!folder.file("out.csv").exists());
    // An empty file that was there is left, and used by the next one.
    std::fs::write(folder.file("out.csv"), "").unwrap();
    assert_eq!(folder.fre("--vary object.radius_mm=40,-5 --out out.csv").status.code(), Some(1));
    assert!(std::fs::read(folder.file("out.csv")).unwrap().is_empty());
    assert_eq!(folder.fre("--vary object.radius_mm=40,45 --out out.csv").status.code(), Some(0));
}

#[test]
fn failures_are_rows_with_their_status() {
    let folder = Folder::new();
    // The larger cylinder surrounds the finger and the motor axis: no angle is free of contact.
    let text = "finger = \"preset:fea-80\"\n[object]\nshape = \"circle\"\nradius_mm = 200\ncentre_mm = [41, 45]\n\
        [motion]\nmotor_angles_deg = [0, 5]\n";
    std::fs::write(folder.file("case.toml"), text).unwrap();
    let output = folder.fre("--vary object.radius_mm=5,200 --progress");
    assert_eq!(output.status.code(), Some(2));
    let rows = words(&output.stdout);
    assert_eq!(rows.lines().count(), 1 + 4);
    assert!(rows.lines().nth(3).unwrap().starts_with("2,200,out-of-range,0,,,"), "{rows}");
    let said = words(&output.stderr);
    // The line of the progress ends with a speed.
    let (progress, said) = said.split_once('\n').unwrap();
    assert!(progress.contains("100 %  4/4 rows"), "{progress}");
    snapbox::assert_data_eq!(
        said,
        snapbox::str![[r#"
fre: 4 rows (4 computed): 2 no-contact, 2 out-of-range
fre: row 2: out-of-range: object.radius_mm=200 at 0°
fre: row 3: out-of-range: object.radius_mm=200 at 5°
fre: warning: 2 of 4 rows have the object inside a part of the finger that the model lets it pass through (column overlap_mm); the first is row 2: object.radius_mm=200 at 0°

"#]]
    );
}

#[test]
fn a_finger_file_is_found_beside_its_case() {
    let folder = Folder::new();
    let finger = "[finger]\nwidth_mm = 20\n[finger.material]\nyoungs_modulus_pa = 4.95e7\npoissons_ratio = 0.48\n\
        [finger.front]\nbase_mm = [0, 0]\ntip_mm = [0, 80]\nthickness_mm = [[0, 2], [80, 1.5]]\n\
        [finger.back]\nbase_mm = [-28, 0]\ntip_mm = [0, 80]\nthickness_mm = 2\n[finger.motor]\naxis_mm = [-14, -20]\n";
    std::fs::create_dir_all(folder.file("sub")).unwrap();
    std::fs::write(folder.file("sub/my.toml"), finger).unwrap();
    std::fs::write(folder.file("case.toml"), case_text(40.0, 45.0).replace("preset:fea-80", "sub/my.toml")).unwrap();
    let output = folder.fre("--vary finger.front.thickness_mm.1.1=1.5,1.8 --vary finger.width_mm=20,22");
    let text = words(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
    let force = |row: usize| text.lines().nth(1 + row).unwrap().split(',').nth(7).unwrap().parse::<f64>().unwrap();
    // Thicker and wider fingers push harder.
    assert!(force(1) > 0.0 && force(3) > force(1) && force(5) > force(1), "{text}");
}

/// A file as versions before the file beside it wrote it.
fn of_an_earlier_version(folder: &Folder) -> String {
    let name = std::fs::read_to_string(folder.file("out.csv.sweep")).unwrap();
    let word = |key: &str| {
        let rest = name.split_once(&format!("\"{key}\": \"")).unwrap().1;
        rest.split('"').next().unwrap().to_owned()
    };
    let first = format!(
        "# fre sweep {} {}: 4 points, 8 rows; to be read from the next line on\n",
        word("fre"),
        word("identity")
    );
    first + &std::fs::read_to_string(folder.file("out.csv")).unwrap()
}

#[test]
fn a_sweep_of_an_earlier_version_goes_on() {
    let folder = Folder::new();
    let (sweep, file) = (small(), folder.file("out.csv"));
    go_on(&sweep, &file);
    let whole = of_an_earlier_version(&folder);
    std::fs::remove_file(folder.file("out.csv.sweep")).unwrap();
    let cut = whole.match_indices('\n').nth(4).unwrap().0 + 5;
    std::fs::write(&file, &whole[..cut]).unwrap();
    let tally = go_on(&sweep, &file);
    assert_eq!((tally.resumed, tally.computed), (3, 5));
    let again = std::fs::read_to_string(&file).unwrap();
    let (first, rows) = again.split_once('\n').unwrap();
    assert_eq!(first, whole.lines().next().unwrap());
    assert_eq!(timeless(rows), timeless(whole.split_once('\n').unwrap().1));
    std::fs::write(&file, whole.replace("sweep 0", "sweep 9")).unwrap();
    let message = Ledger::open(&file, &sweep).unwrap_err().to_string();
    let message = message.replace(folder.file("").to_str().unwrap(), "").replace(env!("CARGO_PKG_VERSION"), "VERSION");
    snapbox::assert_data_eq!(
        message,
        snapbox::str![
            "out.csv: holds another sweep: it was written by fre 9.2.0, this is fre VERSION; give another --out, or remove the file to begin anew"
        ]
    );
}

#[test]
fn shapes_are_those_of_a_direct_solution() {
    let folder = Folder::new();
    let text = words(&folder.fre("--shapes").stdout);
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let case = Case::parse("case.toml", &case_text(40.0, 45.0)).unwrap();
    let run = run::solve(&case, &Options::default()).unwrap();
    for (line, place) in lines.zip(&run.places) {
        let cells: Vec<&str> = line.split(',').collect();
        let shape = &place.state.as_ref().unwrap().shape;
        for (name, points, axis) in [
            ("front_x_mm", &shape.front, 0),
            ("front_y_mm", &shape.front, 1),
            ("back_x_mm", &shape.back, 0),
            ("back_y_mm", &shape.back, 1),
        ] {
            let column = names.iter().position(|head| *head == name).unwrap();
            let found: Vec<f64> = cells[column].split(' ').map(|word| word.parse().unwrap()).collect();
            let expected: Vec<f64> = points.iter().map(|point| point[axis]).collect();
            assert_eq!(found, expected, "{name}");
        }
    }
}
