//! The crates as a registry takes them.

use crate::command::output;
use crate::paths;
use crate::pc::cargo;
use anyhow::{Result, ensure};
use std::path::PathBuf;

/// The packages of a release, each after those that it uses.
const PACKAGES: [&str; 11] = [
    "model-core",
    "fre-boards",
    "dynamixel",
    "grip",
    "messages",
    "fre",
    "fre-log",
    "fre-qemu",
    "fre-gripper",
    "fre-ros2",
    "fre-cli",
];

/// Makes the packages; gives their files. They are not compiled: the suite has compiled the same sources.
pub fn make() -> Result<Vec<PathBuf>> {
    let target = paths::target().join("packages");
    let mut command = cargo("package");
    command.args(["--quiet", "--no-verify", "--allow-dirty", "--offline", "--target-dir"]).arg(&target);
    command.args(PACKAGES.iter().flat_map(|package| ["--package", package]));
    output(&mut command)?;
    let mut files = Vec::new();
    for package in PACKAGES {
        let file = target.join("package").join(format!("{package}-{}.crate", env!("CARGO_PKG_VERSION")));
        ensure!(file.exists(), "cargo has made no {}", file.display());
        files.push(file);
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::output;
    use serde_json::Value;
    use std::collections::BTreeSet;
    use std::fs;
    use std::path::Path;

    fn metadata() -> Vec<Value> {
        let text =
            output(cargo("metadata").args(["--format-version", "1", "--no-deps", "--offline"])).expect("metadata");
        let all: Value = serde_json::from_str(&text).expect("JSON");
        all["packages"].as_array().expect("packages").clone()
    }

    #[test]
    fn the_packages_can_be_made() {
        for file in make().expect("packages") {
            assert!(fs::metadata(&file).expect("a file").len() > 2_000, "{}", file.display());
        }
    }

    #[test]
    fn every_package_that_may_be_published_is_one_of_them_and_says_what_a_registry_asks_for() {
        let mut published = BTreeSet::new();
        for package in metadata().iter().filter(|package| package["publish"] != serde_json::json!([])) {
            let name = package["name"].as_str().expect("a name");
            published.insert(name.to_owned());
            for key in ["description", "license", "readme", "rust_version"] {
                assert!(package[key].is_string(), "{name} has no {key}");
            }
            for (key, most) in [("keywords", 5), ("categories", 5), ("authors", usize::MAX)] {
                let count = package[key].as_array().expect("a list").len();
                assert!((1..=most).contains(&count), "{name} has {count} {key}");
            }
            for keyword in package["keywords"].as_array().into_iter().flatten().filter_map(Value::as_str) {
                assert!(
                    keyword.len() <= 20 && keyword.starts_with(|c: char| c.is_ascii_alphabetic()),
                    "{name}: {keyword}"
                );
            }
        }
        assert_eq!(published, PACKAGES.iter().map(|name| (*name).to_owned()).collect());
    }

    /// A package has only the files below its own folder.
    #[test]
    fn no_source_of_a_package_includes_a_file_from_outside_of_it() {
        for package in metadata().iter().filter(|package| PACKAGES.iter().any(|name| package["name"] == *name)) {
            let folder = Path::new(package["manifest_path"].as_str().expect("a path")).parent().expect("a folder");
            let mut folders = vec![folder.join("src")];
            let mut texts: Vec<(PathBuf, String)> = Vec::new();
            while let Some(next) = folders.pop() {
                for entry in next.read_dir().expect("a folder").flatten().map(|entry| entry.path()) {
                    if entry.is_dir() {
                        folders.push(entry);
                    } else if entry.extension().is_some_and(|kind| kind == "rs") {
                        let text = fs::read_to_string(&entry).expect("text");
                        texts.push((entry, text));
                    }
                }
            }
            // What is compiled for tests only may include anything.
            let for_tests = |file: &Path| {
                let name = file.file_stem().unwrap_or_default().to_string_lossy();
                texts.iter().any(|(_, text)| text.contains(&format!("#[cfg(test)]\nmod {name};")))
            };
            texts.iter().filter(|(file, _)| !for_tests(file)).for_each(|(file, text)| check(folder, file, text));
        }
    }

    fn check(package: &Path, file: &Path, text: &str) {
        let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        for rest in text.split("include_str!(\"").skip(1).chain(text.split("include_bytes!(\"").skip(1)) {
            let included = rest.split('"').next().unwrap_or_default();
            let depth = file.parent().expect("a folder").strip_prefix(package).expect("in it").components().count();
            let up = included.split('/').take_while(|part| *part == "..").count();
            assert!(up <= depth, "{} includes {included}", file.display());
        }
    }
}
