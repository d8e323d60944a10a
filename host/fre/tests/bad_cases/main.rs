//! Every bad case file is refused with its file, line, key, value and what is allowed.

mod changes;
mod slips;

use changes::CHANGES;
use fre::case::{Case, CaseError, Document, read_finger};
use slips::SLIPS;

/// A good case; the bad ones change one piece of it.
const GOOD: &str = r#"[finger]
name = "test"
width_mm = 20.0
plane_strain = "stress"

[finger.material]
youngs_modulus_pa = 4.95e7
poissons_ratio = 0.48

[finger.front]
base_mm = [0.0, 0.0]
tip_mm = [0.0, 80.0]
thickness_mm = 2.0

[finger.back]
base_mm = [-28.0, 0.0]
tip_mm = [0.0, 80.0]
thickness_mm = 2.0
stiffness_factor = 1.0

[finger.lamellae]
heights_mm = [
  9,
  18,
  27,
]
thickness_mm = 3.0

[finger.hinge]
kind = "flexible"
length_mm = 2.5
thickness_mm = 0.8
from = "centreline"

[finger.tip]
rigid_above_mm = 74.0

[finger.motor]
axis_mm = [-14.0, -20.0]

[object]
shape = "circle"
radius_mm = 40.0
centre_mm = [41.0, 60.0]

[motion]
motor_angles_deg = [6.0, 8]
"#;

#[test]
fn the_good_case_is_good() {
    Case::parse("good.toml", GOOD).unwrap();
}

#[test]
fn every_bad_case_names_line_and_key() {
    let mut wrong = Vec::new();
    for &(old, new, line, key, words) in CHANGES.iter().chain(SLIPS) {
        assert_eq!(
            GOOD.matches(old).count(),
            if old == "thickness_mm = 2.0" { 2 } else { 1 },
            "change {old:?} is not unique"
        );
        let text = GOOD.replacen(old, new, 1);
        match Case::parse("bad.toml", &text) {
            Ok(_) => wrong.push(format!("{new:?} was accepted")),
            Err(error) => {
                let message = error.to_string();
                let right = error.line() == Some(line)
                    && error.key().unwrap_or("") == key
                    && message.contains(words)
                    && message.starts_with(&format!("bad.toml:{line}: "));
                if !right {
                    wrong.push(format!("{new:?} (line {line}, key {key}, {words:?}) gave: {message}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), CHANGES.len() + SLIPS.len(), wrong.join("\n"));
}

#[test]
fn messages_read_well() {
    let message = |old: &str, new: &str| Case::parse("case.toml", &GOOD.replacen(old, new, 1)).unwrap_err().to_string();
    assert_eq!(
        message("kind = \"flexible\"", "kind = \"bendy\""),
        "case.toml:30: finger.hinge.kind = \"bendy\": allowed is \"flexible\", \"pinned\", \"welded\""
    );
    assert_eq!(
        message("radius_mm = 40.0", "radius = 40.0"),
        "case.toml:43: object.radius = 40.0: unknown key (did you mean radius_mm?); allowed here: shape, radius_mm, centre_mm, friction"
    );
    assert_eq!(
        message("  27,", "  81,"),
        "case.toml:25: finger.lamellae.heights_mm[2] = 81: lies outside the flexible beam; \
         allowed is more than 0 and less than 74 mm"
    );
}

#[test]
fn messages_are_one_line_whatever_the_file_holds() {
    for text in ["\"a\\nb\\u001b[2J\" = 1", "finger = \"\\u0007\"", "finger = 1\n\"fin\\u0067er\" = 2\n\u{1b}"] {
        let message = Case::parse("case.toml", text).unwrap_err().to_string();
        assert!(!message.chars().any(char::is_control), "{message:?}");
    }
    let message = Case::parse("case.toml", "\"a\\nb\" = 1").unwrap_err().to_string();
    assert!(message.starts_with("case.toml:1: a\\nb = 1: unknown key"), "{message}");
}

/// It is printed: a terminal would obey an escape sequence in it.
#[test]
fn a_name_has_no_control_characters() {
    for name in ["\\u001b[31mred", "two\\nlines", "bell\\u0007"] {
        let text = GOOD.replace("\"test\"", &format!("\"{name}\""));
        let error = Case::parse("case.toml", &text).unwrap_err();
        let reason = "has control characters; allowed is a text without them, in one line";
        assert_eq!(error.to_string(), format!("case.toml:2: finger.name = \"{name}\": {reason}"));
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a\u{1b}[31m.toml");
    std::fs::write(&file, GOOD.replace("name = \"test\"\n", "")).unwrap();
    assert_eq!(read_finger(&file).unwrap().name, "a\\u{1b}[31m");
}

#[test]
fn an_empty_text_and_other_formats_are_refused() {
    let error = Case::parse("empty.toml", "").unwrap_err();
    assert_eq!((error.line(), error.key()), (Some(1), Some("finger")));
    assert!(matches!(Case::parse("x.json", "{\"finger\": 1}").unwrap_err(), CaseError::Syntax { line: 1, .. }));
    let error = Case::parse("x.toml", "finger = 3").unwrap_err();
    assert!(matches!(&error, CaseError::WrongType { .. }), "{error}");
    let deep = format!("finger = {}{}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(Case::parse("deep.toml", &deep).is_err());
}

#[test]
fn unknown_presets_and_absent_finger_files_are_refused() {
    let tail = &GOOD[GOOD.find("[object]").unwrap()..];
    let case = |finger: &str| Case::parse("case.toml", &format!("{finger}\n{tail}"));
    assert_eq!(case("finger = \"preset:ladder-80\"").unwrap().finger.name, "ladder-80");
    let message = case("finger = \"preset:ladder\"").unwrap_err().to_string();
    snapbox::assert_data_eq!(
        message,
        snapbox::str![[
            r#"case.toml:1: finger = "preset:ladder": there is no such preset; allowed are "preset:ladder-80", "preset:fea-80", "preset:dhas-80", "preset:umi", "preset:vekkax", "preset:hamburg-80""#
        ]]
    );
    let message = case("finger = \"absent.toml\"").unwrap_err().to_string();
    snapbox::assert_data_eq!(
        message,
        snapbox::str![[
            r#"case.toml:1: finger = "absent.toml": the finger file absent.toml cannot be read: No such file or directory (os error 2)"#
        ]]
    );
}

#[test]
fn a_finger_that_is_named_and_is_not_there_is_refused_alike_by_case_and_document() {
    let folder = tempfile::tempdir().unwrap();
    let tail = &GOOD[GOOD.find("[object]").unwrap()..];
    for (word, reason) in [
        ("preset:zz", "there is no such preset; allowed are \"preset:ladder-80\", "),
        ("zz.toml", "zz.toml cannot be read: "),
    ] {
        let text = format!("# A finger.\nfinger = \"{word}\"\n{tail}");
        let path = folder.path().join("case.toml");
        std::fs::write(&path, &text).unwrap();
        let error = Case::read(&path).unwrap_err();
        assert_eq!((error.line(), error.key()), (Some(2), Some("finger")));
        assert!(error.to_string().contains(reason), "{error}");
        assert_eq!(Document::resolve(&path.display().to_string(), &text, folder.path()).unwrap_err(), error);
    }
}

#[test]
fn files_that_are_no_cases_are_refused() {
    let own = tempfile::tempdir().unwrap();
    let folder = own.path();
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        Case::read(&path).unwrap_err()
    };
    assert!(matches!(file("empty.toml", b""), CaseError::Missing { .. }));
    assert!(matches!(file("binary.toml", b"a = 1\n\xff\xfe\x00"), CaseError::NotText { line: 2, .. }));
    let utf_16: Vec<u8> = format!("\u{feff}{GOOD}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    let error = file("utf-16.toml", &utf_16);
    assert!(matches!(error, CaseError::NotText { line: 1, .. }) && error.to_string().contains("is UTF-16"), "{error}");
    std::os::unix::fs::symlink(folder.join("loop.toml"), folder.join("loop.toml")).unwrap();
    assert!(matches!(Case::read(&folder.join("loop.toml")).unwrap_err(), CaseError::Unreadable { .. }));
    // A mark at the beginning and other ends of lines are no faults.
    std::fs::write(folder.join("marked.toml"), format!("\u{feff}{}", GOOD.replace('\n', "\r\n"))).unwrap();
    assert_eq!(Case::read(&folder.join("marked.toml")).unwrap(), Case::parse("case.toml", GOOD).unwrap());
    assert!(matches!(file("nul.toml", b"a = \0\n"), CaseError::Syntax { line: 1, .. }));
    assert!(matches!(file("huge.toml", &vec![b'#'; 2 << 20]), CaseError::TooLarge { bytes: 2_097_152, .. }));
    assert!(matches!(Case::read(&folder.join("absent.toml")).unwrap_err(), CaseError::Unreadable { .. }));
    assert!(matches!(Case::read(folder).unwrap_err(), CaseError::Unreadable { .. }));
    let finger = folder.join("finger.toml");
    std::fs::write(&finger, GOOD.replace("width_mm = 20.0", "width_mm = -1")).unwrap();
    let error = read_finger(&finger).unwrap_err();
    assert_eq!((error.line(), error.key()), (Some(3), Some("finger.width_mm")));
    // A fault in a finger file is named by that file, not by the case that mentions it.
    let tail = &GOOD[GOOD.find("[object]").unwrap()..];
    let error = file("case.toml", format!("finger = \"finger.toml\"\n{tail}").as_bytes());
    assert!(error.to_string().contains("finger.toml:3: finger.width_mm = -1"), "{error}");
}
