//! Keys without an effect: every number and word of a case is changed, and what changes nothing must be named by a warning.

use std::collections::BTreeSet;

use fre::case::{Case, PRESETS};
use fre::study::model::Options;
use fre::study::run;
use fre::study::warnings::{Warning, warnings};
use model_core::discretise::{Discretisation, Physics};
use toml_edit::{DocumentMut, Item, Table, Value};

const LADDER: &str = r#"
[finger]
width_mm = 20.0
plane_strain = "auto"
[finger.material]
youngs_modulus_pa = 4.95e7
poissons_ratio = 0.48
law = "st-venant-kirchhoff"
[finger.front]
base_mm = [0.0, 0.0]
tip_mm = [0.0, 80.0]
thickness_mm = 2.0
stiffness_factor = 1.1
bending_factor = 1.1
stretch_factor = 1.1
clamp_mm = 2.0
sagitta_mm = 0.2
[finger.back]
base_mm = [-28.0, 0.0]
tip_mm = [0.0, 80.0]
thickness_mm = 2.0
[finger.lamellae]
heights_mm = [9, 18, 27, 36, 45, 54, 62]
angle_deg = 2.0
thickness_mm = 2.0
[finger.hinge]
kind = "flexible"
length_mm = 1.5
thickness_mm = 0.8
from = "face"
[finger.tip]
rigid_above_mm = 74.0
[finger.motor]
axis_mm = [-14.0, -20.0]
[object]
shape = "circle"
radius_mm = 40.0
centre_mm = [41.0, 45.0]
[motion]
motor_angles_deg = [6.0]
"#;

/// Words that a key may have.
const WORDS: &[(&str, &[&str])] = &[
    ("finger.plane_strain", &["stress", "strain", "auto"]),
    ("finger.material.law", &["st-venant-kirchhoff", "neo-hookean", "linear"]),
    ("finger.material.memory", &["nodes", "force"]),
    ("finger.lamellae.kind", &["rigid", "rib"]),
    ("finger.lamellae.ends", &["welded", "hinged", "gap"]),
    ("finger.hinge.kind", &["flexible", "pinned", "welded"]),
    ("finger.hinge.from", &["centreline", "face"]),
];

/// What the page of keys says of rigid lamellae: their thickness matters for pictures, finite elements and room alone.
const RIGID: &str = "finger.lamellae.thickness_mm";

fn case(text: &str) -> Case {
    Case::parse("case.toml", text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// What is computed of a case.
fn computed(case: &Case) -> String {
    let options = Options { discretisation: Discretisation::reduced(Physics::Extended), ..Options::default() };
    let run = run::solve(case, &options).unwrap();
    let places = run.places.iter().map(|place| {
        let state = place.state.as_ref().unwrap_or_else(|| panic!("{:?}", place.status));
        assert!(state.force_n[0] > 0.5, "a finger that presses");
        format!("{:?}{:?}{:?}{:?}", state.force_n, state.motor_torque_nmm, state.tip_mm, state.max_strain)
    });
    places.collect()
}

fn notes(case: &Case) -> Vec<String> {
    let all = warnings(case, &Options::default(), &[]);
    all.iter().filter(|warning| matches!(warning, Warning::Idle(_))).map(ToString::to_string).collect()
}

/// Keys of numbers and words below a table.
fn leaves(table: &Table, path: &str, found: &mut BTreeSet<String>) {
    for (key, item) in table {
        let path = format!("{path}.{key}");
        match item {
            Item::Table(table) => leaves(table, &path, found),
            Item::Value(Value::String(_)) if words(&path).is_empty() => {}
            _ => drop(found.insert(path)),
        }
    }
}

fn words(key: &str) -> &'static [&'static str] {
    WORDS.iter().find(|(found, _)| *found == key).map_or(&[], |(_, words)| words)
}

fn at<'d>(document: &'d mut DocumentMut, key: &str) -> &'d mut Item {
    key.split('.').fold(document.as_item_mut(), |item, key| &mut item[key])
}

/// Other values for a key's.
fn others(key: &str, value: &Value) -> Vec<Value> {
    let greater = |value: &Value| {
        let number = value.as_float().or(value.as_integer().map(|whole| whole as f64)).unwrap();
        if number == 0.0 { 0.01 } else { 1.01 * number }
    };
    match value {
        Value::String(own) => {
            words(key).iter().filter(|word| *word != own.value()).map(|word| (*word).into()).collect()
        }
        Value::Array(list) => vec![Value::Array(list.iter().map(greater).collect())],
        _ => vec![greater(value).into()],
    }
}

/// The keys that may be changed without changing anything.
fn without_effect(text: &str) -> BTreeSet<String> {
    let document: DocumentMut = text.parse().unwrap();
    let before = computed(&case(text));
    let mut keys = BTreeSet::new();
    for part in ["finger", "object"] {
        leaves(document[part].as_table().unwrap(), part, &mut keys);
    }
    keys.retain(|key| {
        let value = at(&mut document.clone(), key).as_value().unwrap().clone();
        let mut changed = others(key, &value).into_iter().filter_map(|other| {
            let mut document = document.clone();
            *at(&mut document, key) = Item::Value(other);
            // A word that needs other keys is refused.
            Case::parse("case.toml", &document.to_string()).ok()
        });
        let first = changed.next();
        first.is_some_and(|first| [first].into_iter().chain(changed).all(|case| computed(&case) == before))
    });
    keys
}

/// The case with pieces of it replaced, the notes on it, and that these name all that is without effect.
fn noted(replaced: &[(&str, &str)], also: &[&str]) -> String {
    let text = replaced.iter().fold(LADDER.to_owned(), |text, (piece, other)| {
        assert!(text.contains(piece), "{piece}");
        text.replacen(piece, other, 1)
    });
    let notes = notes(&case(&text)).join("\n");
    for key in without_effect(&text) {
        let named = key.starts_with("finger.hinge.") && notes.starts_with("finger.hinge has");
        assert!(
            named || notes.contains(&key) || also.contains(&key.as_str()),
            "{key} has no effect: {notes:?}\n{text}"
        );
    }
    notes
}

#[test]
fn a_key_without_effect_is_named() {
    assert_eq!(noted(&[], &[RIGID]), "");
    let kind = |kind: &'static str| ("kind = \"flexible\"", kind);
    assert_eq!(
        noted(&[kind("kind = \"pinned\"")], &[RIGID]),
        "finger.hinge.length_mm, finger.hinge.thickness_mm, finger.hinge.from have no effect: hinges with finger.hinge.kind = \
         \"pinned\" have no necks"
    );
    assert_eq!(
        noted(&[kind("kind = \"welded\""), ("thickness_mm = 0.8\nfrom = \"face\"\n", "")], &[RIGID]),
        "finger.hinge.length_mm has no effect: hinges with finger.hinge.kind = \"welded\" have no necks"
    );
    let ribs = |ends: &'static str| ("thickness_mm = 2.0\n[finger.hinge]", ends);
    assert_eq!(
        noted(
            &[ribs(
                "thickness_mm = 1.2\nkind = \"rib\"\nfillet_mm = 0.2\nbending_factor = 1.1\nstretch_factor = 1.1\n[finger.hinge]"
            )],
            &[]
        ),
        "finger.hinge has no effect: ribs with finger.lamellae.ends = \"welded\" have no necks (ends = \"hinged\" gives them)"
    );
    let gap = "thickness_mm = 1.2\nkind = \"rib\"\nends = \"gap\"\ngap_mm = 0.1\n[finger.hinge]";
    assert_eq!(
        noted(&[ribs(gap)], &[]),
        "finger.hinge has no effect: ribs with finger.lamellae.ends = \"gap\" have no necks (ends = \"hinged\" gives them)"
    );
    assert_eq!(noted(&[ribs("thickness_mm = 1.2\nkind = \"rib\"\nends = \"hinged\"\n[finger.hinge]")], &[]), "");
    assert_eq!(
        noted(&[("law =", "memory = \"force\"\nlaw =")], &[RIGID]),
        "finger.material.memory has no effect: without finger.material.prony nothing is remembered"
    );
    let other = (
        "shape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 45.0]",
        "shape = \"ellipse\"\ncentre_mm = [41, 45]\n\
        semi_axes_mm = [40, 30]\nangle_deg = 5\nfriction = 0.2",
    );
    assert_eq!(noted(&[other], &[RIGID]), "");
}

#[test]
fn what_is_given_with_the_program_has_no_idle_keys() {
    for name in PRESETS {
        let text = format!(
            "finger = \"preset:{name}\"\nobject = {{ shape = \"circle\", radius_mm = 40, centre_mm = [60, 45] }}\n\
            motion = {{ direction = [1, 0], distances_mm = [1] }}\n"
        );
        assert_eq!(notes(&case(&text)), [""; 0], "{name}");
    }
    let examples = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let files = examples.read_dir().unwrap().map(|entry| entry.unwrap().path());
    let mut count = 0;
    for file in files.filter(|file| file.extension().is_some_and(|kind| kind == "toml")) {
        assert_eq!(notes(&Case::read(&file).unwrap()), [""; 0], "{}", file.display());
        count += 1;
    }
    assert!(count > 3);
    assert_eq!(notes(&case(fre::case::NEW)), [""; 0]);
}
