//! `fre new` writes a case that can be solved as it is, and never over a file.

use std::fs;
use std::process::{Command, Output};

fn fre(folder: &std::path::Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fre")).args(words).current_dir(folder).output().unwrap()
}

#[test]
fn a_new_case_is_the_example_and_can_be_solved() {
    let folder = tempfile::tempdir().unwrap();
    let made = fre(folder.path(), &["new", "own.toml"]);
    assert!(made.status.success(), "{made:?}");
    let text = fs::read_to_string(folder.path().join("own.toml")).unwrap();
    assert_eq!(fre(folder.path(), &["new"]).stdout, text.as_bytes());
    // The example is what the command writes: `fre new --force examples/own-finger.toml`.
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/own-finger.toml");
    assert_eq!(fs::read_to_string(example).unwrap(), text);

    let solved = fre(folder.path(), &["solve", "own.toml", "--format", "csv"]);
    assert!(solved.status.success(), "{solved:?}");
    let table = String::from_utf8(solved.stdout).unwrap();
    assert_eq!(table.matches("converged").count(), 4, "{table}");
    assert!(solved.stderr.is_empty(), "{}", String::from_utf8_lossy(&solved.stderr));
}

#[test]
fn a_file_that_exists_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("own.toml"), "mine").unwrap();
    let refused = fre(folder.path(), &["new", "own.toml"]);
    assert_eq!(refused.status.code(), Some(1));
    let words = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(words, "fre: the case: own.toml exists; --force overwrites it\n");
    assert_eq!(fs::read_to_string(folder.path().join("own.toml")).unwrap(), "mine");
    assert!(fre(folder.path(), &["new", "own.toml", "--force"]).status.success());
    assert_ne!(fs::read_to_string(folder.path().join("own.toml")).unwrap(), "mine");
}
