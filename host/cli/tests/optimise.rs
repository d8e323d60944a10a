//! `fre optimise`: words in, a design out; killed and continued.

mod said;

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

const CASE: &str = r#"
finger = "preset:ladder-80"
[object]
shape = "circle"
radius_mm = 40.0
centre_mm = [41.0, 45.0]
[motion]
motor_angles_deg = [6.0]
"#;

/// The lightest finger that still holds 2.7 N, by its two thicknesses.
const WORDS: [&str; 12] = [
    "optimise",
    "case.toml",
    "--goal",
    "mass",
    "--subject-to",
    "force at 6 >= 2.7",
    "--vary",
    "finger.front.thickness_mm=1.5:2.6",
    "--vary",
    "finger.back.thickness_mm=1.5:2.6",
    "--elements",
    "reduced",
];

fn command(folder: &Path, words: &[&str]) -> Command {
    fs::write(folder.join("case.toml"), CASE).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
    command.args(WORDS).args(words).current_dir(folder);
    command
}

fn fre(folder: &Path, words: &[&str]) -> Output {
    command(folder, words).output().unwrap()
}

/// `fre optimise` on the folder's case with these words alone.
fn bare(folder: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
    command.args(["optimise", "case.toml"]).args(words).current_dir(folder).output().unwrap()
}

#[test]
fn a_lighter_finger_is_found_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    let found =
        fre(folder.path(), &["--starts", "2", "--out", "found", "--front", "least strain up to 6", "--points", "3"]);
    assert_eq!(found.status.code(), Some(0), "{found:?}");
    let text = String::from_utf8(found.stdout).unwrap();
    snapbox::assert_data_eq!(
        said::words(&text),
        snapbox::str![[r#"
before after
least mass at # kg/m³ # g # g # % better
force at #° ≥ # N # N # N kept
finger.front.thickness_mm # # # to #
finger.back.thickness_mm # # # to #
# starts, # cases solved in # s

least mass at # kg/m³ least strain up to #° finger.front.thickness_mm finger.back.thickness_mm
# g # # #
before: # g, #
"#]]
    );
    let asked = ["least mass at 1200 kg/m³ ", "force at 6° ≥ 2.7 N ", "2 starts, "];
    for words in asked {
        assert!(text.lines().any(|line| line.starts_with(words)), "{words}: {text}");
    }
    let read = |name: &str| fs::read_to_string(folder.path().join("found").join(name)).unwrap();
    let page = read("report.html");
    assert!(page.matches("<svg").count() >= 3 && page.contains("All limits are kept."), "{}", page.len());
    for name in ["before.svg", "after.svg", "front.svg"] {
        assert!(read(name).starts_with("<svg"), "{name}");
    }
    // The force is drawn over the whole motion, not only at the places of goal and limits: three lines with a dot per place.
    let dots = read("after.svg").matches("<use").count();
    assert!(dots >= 3 * 24, "{dots}");
    // The design is a case as any other, and it does what was asked.
    let solve = ["solve", "found/design.toml", "--elements", "reduced", "--format", "json"];
    let solved = Command::new(env!("CARGO_BIN_EXE_fre")).args(solve).current_dir(folder.path()).output().unwrap();
    let places: serde_json::Value = serde_json::from_slice(&solved.stdout).unwrap();
    let force = places[0]["force_magnitude_n"].as_f64().unwrap();
    assert!((2.7 - 1e-5..2.71).contains(&force), "{force}");
    // Without its search the folder is somebody's.
    fs::remove_file(folder.path().join("found/search.json")).unwrap();
    let refused = fre(folder.path(), &["--out", "found"]);
    assert_eq!(refused.status.code(), Some(1));
    snapbox::assert_data_eq!(
        refused.stderr,
        snapbox::str![[r#"
fre: --out: found/report.html exists; --force overwrites it

"#]]
    );
}

#[test]
fn a_killed_search_goes_on_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("found/search.json");
    let words = ["--starts", "40", "--out", "found", "--format", "json"];
    let mut child = command(folder.path(), &words).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let tries = || -> usize {
        let text = fs::read_to_string(&log).unwrap_or_default();
        let kept: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
        kept["searches"][""].as_array().map_or(0, Vec::len)
    };
    while tries() == 0 && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let kept = tries();
    assert!((1..40).contains(&kept), "killed too late to say anything: {kept}");
    let first = fs::read_to_string(&log).unwrap();
    let best = |output: &Output| -> serde_json::Value { serde_json::from_slice(&output.stdout).unwrap() };
    let on = fre(folder.path(), &words);
    assert_eq!((on.status.code(), tries()), (Some(0), 40), "{on:?}");
    let known: serde_json::Value = serde_json::from_str(&first).unwrap();
    let all: serde_json::Value = serde_json::from_str(&fs::read_to_string(&log).unwrap()).unwrap();
    assert_eq!(all["searches"][""].as_array().unwrap()[..kept], known["searches"][""].as_array().unwrap()[..]);
    // The same as in one go, and nothing is searched twice.
    let whole = fre(folder.path(), &["--starts", "40", "--format", "json"]);
    assert_eq!(best(&on)["report"]["x"], best(&whole)["report"]["x"]);
    let again = best(&fre(folder.path(), &words));
    assert!(again["report"]["cases_solved"].as_u64().unwrap() < 5, "{again}");
    let other = fre(folder.path(), &["--seed", "1", "--out", "found"]);
    snapbox::assert_data_eq!(
        other.stderr,
        snapbox::str![[r#"
fre: found/search.json: it is of another problem; remove it, or give another name

"#]]
    );
}

#[test]
fn a_limit_that_no_design_keeps_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("case.toml"), CASE).unwrap();
    let vary = "finger.width_mm=15:25";
    // A force that no finger within the bounds has.
    let impossible =
        ["case.toml", "--goal", "mass", "--vary", vary, "--subject-to", "force at 6 >= 500", "--starts", "1"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
    let output = command.arg("optimise").args(impossible).current_dir(folder.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    snapbox::assert_data_eq!(
        said::words(&String::from_utf8_lossy(&output.stdout)),
        snapbox::str![[r#"
before after
least mass at # kg/m³ # g # g # % worse
force at #° ≥ # N # N # N not kept
finger.width_mm # # # to #
# start, # cases solved in # s
"#]]
    );
}

/// Every message names the option that it is about.
#[test]
fn what_is_no_problem_is_refused_by_its_option() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("case.toml"), CASE).unwrap();
    let vary = "finger.width_mm=15:25";
    for (words, refused) in [
        (&["--goal", "mass", "--vary", vary][..], "--vary: finger.width_mm is varied twice; allowed is once"),
        (&["--goal", "force at 200"], "--goal \"force at 200\": 200° is beyond the motion; allowed is -180 to 180°"),
        (
            &["--goal", "mass", "--subject-to", "no-snap before 400"],
            "--subject-to \"snap up to 400\": 400° is beyond the motion; allowed is -180 to 180°",
        ),
        (
            &["--goal", "mass", "--front", "force at 200"],
            "--front \"force at 200\": 200° is beyond the motion; allowed is -180 to 180°",
        ),
        (&["--goal", "mass", "--also", "object.radius_mm=-3"], "--also object.radius_mm=-3: "),
        (&["--goal", "mass", "--also", "object.size=3"], "--also object.size=3: \"object.size\" is not a number"),
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
        let command = command.args(["optimise", "case.toml", "--vary", vary]).args(words);
        let output = command.current_dir(folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(1) && said.starts_with(&format!("fre: {refused}")), "{words:?}: {said}");
    }
}

/// What a search does not compute has its place in the file, if it is there.
#[test]
fn friction_and_memory_are_refused_by_their_line() {
    let folder = tempfile::tempdir().unwrap();
    let soft = "material = { youngs_modulus_pa = 4.95e7, poissons_ratio = 0.48, prony = [[0.1, 5]] }\n";
    let finger = "width_mm = 20.0\nplane_strain = \"stress\"\nmotor = { axis_mm = [-14.0, -20.0] }\n\
        front = { base_mm = [0.0, 0.0], tip_mm = [0.0, 80.0], thickness_mm = 2.0 }\n\
        back = { base_mm = [-28.0, 0.0], tip_mm = [0.0, 80.0], thickness_mm = 2.0 }\n";
    fs::write(folder.path().join("soft.toml"), format!("{soft}{finger}")).unwrap();
    let object = "[object]\nshape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 45.0]\n";
    let motion = "[motion]\nmotor_angles_deg = [6]\n";
    let vary = ["--goal", "force at 6", "--vary", "object.radius_mm=30:40"];
    let named = format!("finger = \"preset:ladder-80\"\n{object}{motion}");
    for (case, words, refused) in [
        (
            format!("finger = \"preset:ladder-80\"\n{object}friction = 0.4\n{motion}"),
            &vary[..],
            "case.toml:6: object.friction = 0.4: a search computes without friction; allowed is 0",
        ),
        (
            format!("finger = \"soft.toml\"\n{object}{motion}"),
            &vary,
            "case.toml:1: finger = \"soft.toml\": a search computes without memory; allowed is an elastic material",
        ),
        (
            format!("{object}{motion}[finger]\n{soft}{finger}"),
            &vary,
            "case.toml:8: finger.material.prony = [[0.1, 5]]: a search computes without memory; allowed is an elastic material",
        ),
        (
            named.clone(),
            &["--goal", "force at 6", "--vary", "object.friction=0:1"],
            "--vary object.friction: a search computes without friction",
        ),
        (
            named.clone(),
            &[&vary[..], &["--also", "object.friction=0.5"]].concat(),
            "--also object.friction=0.5: object.friction = 0.5: a search computes without friction; allowed is 0",
        ),
    ] {
        fs::write(folder.path().join("case.toml"), case).unwrap();
        let output = bare(folder.path(), words);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), said.as_ref()), (Some(1), format!("fre: {refused}\n").as_str()), "{words:?}");
    }
}

#[test]
fn another_object_has_each_number_once() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("case.toml"), CASE).unwrap();
    for (also, refused) in [
        ("object.radius_mm=30,object.radius_mm=40", "object.radius_mm is given twice; allowed is once"),
        ("object.centre_mm.1=30,object.centre_mm[1]=40", "object.centre_mm[1] is given twice; allowed is once"),
        ("finger.width_mm=18", "finger.width_mm is varied as well; allowed is a key that is not"),
    ] {
        let words = ["--goal", "mass", "--vary", "finger.width_mm=15:25", "--also", also];
        let output = bare(folder.path(), &words);
        let said = String::from_utf8_lossy(&output.stderr);
        let refused = format!("fre: --also {also}: {refused}\n");
        assert_eq!((output.status.code(), said.as_ref()), (Some(1), refused.as_str()));
    }
}

/// The force was 0 before, so that no percentage of it can be given.
#[test]
fn what_was_zero_gets_better_by_no_share() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("case.toml"), CASE.replace("[41.0, 45.0]", "[60.0, 45.0]")).unwrap();
    let words = ["case.toml", "--goal", "force at 6", "--vary", "finger.width_mm=15:25", "--starts", "1"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
    let output = command.arg("optimise").args(words).current_dir(folder.path()).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    let goal = text.lines().find(|line| line.starts_with("largest force at 6°"));
    assert!(goal.is_some_and(|line| !line.contains('%')), "{output:?}");
}
