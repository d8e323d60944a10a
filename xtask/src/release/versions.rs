//! That everything which names the version names the same one.

use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::Path;

/// Files with the version: the text before it, up to the end of the line or a quotation mark.
const PLACES: [(&str, &str); 5] = [
    ("Cargo.toml", "\n[workspace.package]\nversion = \""),
    ("firmware/boards/Cargo.toml", "\nversion = \""),
    ("fuzz/driver/Cargo.toml", "\nversion = \""),
    ("CITATION.cff", "\nversion: "),
    ("CHANGELOG.md", "\n## "),
];

/// The version of the repository at `root`.
///
/// # Errors
/// If two places name different ones, or a path between packages asks for another.
pub fn check(root: &Path) -> Result<String> {
    let read = |file: &str| fs::read_to_string(root.join(file)).with_context(|| format!("cannot read {file}"));
    let mut version: Option<String> = None;
    for (file, before) in PLACES {
        let text = read(file)?;
        let found = after(&text, before).with_context(|| format!("{file} has no version after `{}`", before.trim()))?;
        let version = version.get_or_insert_with(|| found.to_owned());
        ensure!(found == version, "{file} has version {found}, {} has {version}", PLACES[0].0);
    }
    let version = version.expect("there is a first place");
    for line in read("Cargo.toml")?.lines().filter(|line| line.contains("path = \"") && line.contains("version = \"")) {
        let wanted = after(line, "version = \"").unwrap_or_default();
        ensure!(wanted == version, "Cargo.toml: `{line}` asks for {wanted}, the packages are {version}");
    }
    Ok(version)
}

/// The word after a text.
fn after<'t>(text: &'t str, before: &str) -> Option<&'t str> {
    let (_, rest) = text.split_once(before)?;
    rest.split(|c: char| c == '"' || c.is_whitespace()).next().filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_repository_has_one_version() {
        check(&crate::paths::root()).expect("one version");
    }

    #[test]
    fn another_version_is_named_with_its_file() {
        let root = tempfile::tempdir().expect("a folder");
        let write = |version: &str| {
            for (file, before) in PLACES {
                let path = root.path().join(file);
                fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
                let version = if file == "CITATION.cff" { version } else { "1.2.3" };
                let end = if before.ends_with('"') { "\"\n" } else { "\n" };
                fs::write(path, format!("x{before}{version}{end}")).expect("a file");
            }
        };
        write("1.2.3");
        assert_eq!(check(root.path()).expect("one version"), "1.2.3");
        write("1.2.2");
        let error = check(root.path()).expect_err("two versions").to_string();
        assert!(error.contains("CITATION.cff has version 1.2.2, Cargo.toml has 1.2.3"), "{error}");
    }
}
