//! `fre solve --animate`: the motion as a moving picture.

use std::fs;
use std::process::{Command, Output};

const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/closing.toml");

fn animate(folder: &std::path::Path, file: &str) -> Output {
    let mut fre = Command::new(env!("CARGO_BIN_EXE_fre"));
    fre.args(["solve", EXAMPLE, "--format", "csv", "--animate", file]).current_dir(folder).output().unwrap()
}

#[test]
fn every_place_is_a_frame_and_the_readmes_picture_is_current() {
    let folder = tempfile::tempdir().unwrap();
    let done = animate(folder.path(), "closing.svg");
    assert!(done.status.success(), "{done:?}");
    let picture = fs::read_to_string(folder.path().join("closing.svg")).unwrap();
    // Thirteen places, each for 0.4 s, and the last one longer by three times that.
    let table = String::from_utf8(done.stdout).unwrap();
    assert_eq!(table.lines().count(), 14, "{table}");
    for tenths in (0..13).map(|place| 4 * (16 - place)) {
        let delay = format!("animation-delay:-{}.{}s", tenths / 10, tenths % 10).replace(".0s", "s");
        assert!(picture.contains(&delay), "no frame with {delay}");
    }
    // What does not change is drawn once.
    assert_eq!(picture.matches(">cylinder Ø60 mm</text>").count(), 1);
    let readme = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/closing.svg");
    assert!(
        fs::read_to_string(readme).unwrap() == picture,
        "docs/closing.svg is not what `fre solve examples/closing.toml --animate docs/closing.svg --force` draws"
    );
}

#[test]
fn a_moving_picture_is_an_svg() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["closing.png", "closing"] {
        let refused = animate(folder.path(), file);
        assert_eq!(refused.status.code(), Some(1), "{refused:?}");
        let words = String::from_utf8(refused.stderr).unwrap();
        assert_eq!(words, format!("fre: --animate {file}: a moving picture's file ends in .svg\n"));
        assert!(!folder.path().join(file).exists());
    }
}
