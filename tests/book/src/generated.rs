//! Pages, and parts of pages, that the program makes.

use std::fs;

use crate::page::root;

/// With the value `write` in this variable, tests write what they make; otherwise they compare. `cargo xtask docs` sets it.
pub const WRITE: &str = "FRE_DOCS";

/// Compares a file of the repository with what the program makes of it, or writes it (see [`WRITE`]).
///
/// # Panics
///
/// If they differ, or the file cannot be written.
pub fn hold(path: &str, made: &[u8]) {
    let file = root().join(path);
    if std::env::var_os(WRITE).is_some_and(|value| value == "write") {
        if fs::read(&file).ok().as_deref() != Some(made) {
            fs::write(&file, made).unwrap_or_else(|error| panic!("cannot write {path}: {error}"));
        }
        return;
    }
    let kept = fs::read(&file).unwrap_or_else(|error| panic!("cannot read {path}: {error}"));
    if kept == made {
        return;
    }
    let lines = |bytes: &[u8]| String::from_utf8_lossy(bytes).lines().map(str::to_owned).collect::<Vec<_>>();
    let (kept, made) = (lines(&kept), lines(made));
    let at = kept.iter().zip(&made).take_while(|(a, b)| a == b).count();
    let show = |lines: &[String]| lines.get(at).map_or("(end)", String::as_str).chars().take(300).collect::<String>();
    panic!(
        "{path} is not what the program makes: run `cargo xtask docs`. They differ from line {}:\n  {path}: {}\n  program: {}",
        at + 1,
        show(&kept),
        show(&made)
    );
}
