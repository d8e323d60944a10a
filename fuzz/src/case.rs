//! Case files: any text gives a case that can be built, or an error that names file, line and key.

use std::collections::BTreeSet;
use std::path::Path;

use fre::case::keys::schema;
use fre::case::{Case, CaseError};
use fre::heap::Host;
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use serde_json::Value;

use crate::{Target, is_shown};

pub(crate) const TARGET: Target = Target { name: "case", run, seeds, words };

const NAME: &str = "fuzz.toml";

fn run(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    match Case::parse(NAME, text) {
        Ok(case) => accepted(&case),
        Err(error) => refused(&error, text),
    }
}

/// What was accepted must be something the model can be built from.
fn accepted(case: &Case) {
    case.finger.design.validate().expect("an accepted finger is valid");
    case.object.validate().expect("an accepted object is valid");
    assert!(!case.path.places.is_empty() && case.path.places.iter().all(|place| place.is_finite()));
    for physics in [Physics::Paper, Physics::Extended] {
        let mut follower = Follower::<f64, Host>::EMPTY;
        // A design may ask for more than the model has room for, as long as it says so.
        if follower.configure(&case.finger.design, &Discretisation::reduced(physics)).is_ok() {
            follower.set_object(case.object, case.path.motion);
            follower.start(case.path.coordinate(case.path.places[0]));
        }
    }
}

/// An error says where in which file, in one line that can be shown as it is.
fn refused(error: &CaseError, text: &str) {
    let message = error.to_string();
    assert!(is_shown(&message), "{message:?}");
    if let Some(line) = error.line()
        && message.starts_with(NAME)
    {
        let lines = 1 + text.bytes().filter(|&byte| byte == b'\n').count();
        assert!((1..=lines).contains(&line), "line {line} of {lines}: {message}");
    }
}

/// The examples, the fingers that come with the program, and texts with the keys that those leave out.
fn seeds() -> Vec<Vec<u8>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let files = |folder: &str| {
        let folder = root.join(folder);
        let mut files: Vec<_> = std::fs::read_dir(&folder)
            .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
            .map(|entry| entry.expect("a folder's entry").path())
            .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
            .collect();
        files.sort();
        files.into_iter().map(|path| std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())))
    };
    let with_object = |finger: Vec<u8>| {
        // A finger's file has its keys at the top; a case has them under [finger].
        let finger = String::from_utf8(finger).expect("a finger's file is text").replace("\n[", "\n[finger.");
        format!("[finger]\n{finger}\n{OBJECT_AND_MOTION}").into_bytes()
    };
    files("examples")
        .chain(files("host/fre/src/case/presets").map(with_object))
        .chain(TEXTS.iter().map(|text| text.as_bytes().to_vec()))
        .collect()
}

const OBJECT_AND_MOTION: &str = r#"
[object]
shape = "circle"
radius_mm = 40.0
centre_mm = [41.0, 60.0]
[motion]
motor_angles_deg = [6.0, 8]
"#;

const TEXTS: &[&str] = &[
    r#"
[finger]
width_mm = [[0, 20.0], [0x50, 10.0]]
plane_strain = "strain"
material = { youngs_modulus_pa = 2.13e11, poissons_ratio = 0.3 }
front = { base_mm = [0, 0], tip_mm = [0, 80], thickness_mm = 0.2, stiffness_factor = 1.5 }
back = { base_mm = [-28, 0], tip_mm = [0, 80], thickness_mm = [[0, 1.0], [40.5, 0.5]] }
lamellae = { front_arc_mm = [20, 40], back_arc_mm = [21.0, 42.0], thickness_mm = 3 }
hinge = { kind = "pinned" }
[object]
shape = "circle"
radius_mm = 1_0
centre_mm = [-30, 66.5]
[motion]
direction = [-2.0, 0.0]
distances_mm = [5, 10]
"#,
    r#"
finger = "preset:fea-80"
object = { shape = "ellipse", semi_axes_mm = [30, 20], angle_deg = 15.0, centre_mm = [41.0, 45.0] }
motion.motor_angles_deg = [1e1, -2.5, +0.0]
"#,
    r#"
finger = "preset:ladder-80"
object = { shape = "polygon", corners_mm = [[20, 30], [60, 30], [40, 70]], rounding_mm = 2 }
motion.motor_angles_deg = [18.0, 90]
"#,
    r#"
finger = "preset:dhas-80"
object = { shape = "half-plane", point_mm = [20, 0], normal = [-1, 0] }
motion = { direction = [1.0, 0.0], distances_mm = [5] }
"#,
    r#"
finger = "absent.toml"
object = 1979-05-27T07:32:00Z
motion = { "quoted key" = 'literal', b = """
two lines \u00e9""", c = [[1, 2,], [], inf, -nan, 0b101, 0o17, true] }
"#,
];

/// What a case is written with besides its keys and words.
const MARKS: [&str; 8] =
    ["[finger]", "[object]", "[motion]", "finger = \"preset:ladder-80\"", "1e-300", "-inf", "nan", "[[0, 1], [1, 2]]"];

/// Every key and every word of the schema of case files.
fn words() -> Vec<String> {
    let mut found: BTreeSet<String> = MARKS.map(str::to_owned).into();
    collect(schema(), &mut found);
    found.into_iter().collect()
}

fn collect(schema: &Value, found: &mut BTreeSet<String>) {
    match schema {
        Value::Object(fields) => {
            for (key, value) in fields {
                match (key.as_str(), value) {
                    ("properties", Value::Object(keys)) => found.extend(keys.keys().map(|key| format!("{key} = "))),
                    ("const", Value::String(word)) => drop(found.insert(format!("\"{word}\""))),
                    ("enum", Value::Array(words)) => {
                        found.extend(words.iter().filter_map(Value::as_str).map(|word| format!("\"{word}\"")));
                    }
                    _ => {}
                }
                collect(value, found);
            }
        }
        Value::Array(entries) => entries.iter().for_each(|entry| collect(entry, found)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::words;

    #[test]
    fn words_are_those_of_the_schema() {
        let words = words();
        for expected in ["radius_mm = ", "friction = ", "angle_deg = ", "prony = ", "\"bore\"", "\"rib\"", "\"welded\""]
        {
            assert!(words.iter().any(|word| word == expected), "{expected}: {words:?}");
        }
    }
}
