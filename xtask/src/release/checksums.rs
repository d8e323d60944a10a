//! Checksums of a release, as `sha256sum --check` reads them.

use anyhow::{Context, Result, ensure};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// The file with the checksums.
pub const FILE: &str = "SHA256SUMS";

/// Writes the checksums of a folder's files; gives their names, sorted.
pub fn write(folder: &Path) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in folder.read_dir().with_context(|| format!("cannot list {}", folder.display()))? {
        names.push(entry?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    let mut text = String::new();
    for name in &names {
        let _ = writeln!(text, "{}  {name}", sum(&folder.join(name))?);
    }
    fs::write(folder.join(FILE), text).with_context(|| format!("cannot write {FILE}"))?;
    Ok(names)
}

/// That every file is there and has its checksum.
pub fn check(folder: &Path) -> Result<()> {
    let text = fs::read_to_string(folder.join(FILE)).with_context(|| format!("cannot read {FILE}"))?;
    for line in text.lines() {
        let (wanted, name) = line.split_once("  ").with_context(|| format!("{FILE}: `{line}`"))?;
        ensure!(sum(&folder.join(name))? == wanted, "{name} is not the file that {FILE} names");
    }
    Ok(())
}

/// A file's SHA-256 in hexadecimal digits.
fn sum(file: &Path) -> Result<String> {
    let bytes = fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
    Ok(Sha256::digest(&bytes).iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_file_is_found() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("a"), "abc").expect("a file");
        assert_eq!(write(folder.path()).expect("sums"), ["a"]);
        let text = fs::read_to_string(folder.path().join(FILE)).expect("the file");
        assert_eq!(text, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad  a\n");
        check(folder.path()).expect("unchanged");
        fs::write(folder.path().join("a"), "abd").expect("a file");
        assert!(check(folder.path()).expect_err("changed").to_string().contains("a is not the file"));
        fs::remove_file(folder.path().join("a")).expect("a file");
        assert!(check(folder.path()).is_err());
    }
}
