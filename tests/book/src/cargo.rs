//! Whether a cargo command that a page or the CI file names can be run: its packages, tests, examples and repository commands exist.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use crate::page::root;

/// The repository's packages: name, and folder with its manifest.
#[derive(Clone, Debug)]
pub struct Repository {
    packages: BTreeMap<String, (PathBuf, String)>,
    repository_commands: String,
    parts: String,
}

impl Repository {
    /// Reads what there is.
    ///
    /// # Panics
    ///
    /// If the repository cannot be read.
    pub fn read() -> Self {
        let (mut folders, mut packages) = (vec![root()], BTreeMap::new());
        while let Some(folder) = folders.pop() {
            for entry in folder.read_dir().expect("a folder").flatten() {
                let name = entry.file_name().to_string_lossy().into_owned();
                if entry.path().is_dir() && !name.starts_with('.') && name != "target" {
                    folders.push(entry.path());
                } else if name == "Cargo.toml" {
                    let manifest = fs::read_to_string(entry.path()).expect("a manifest");
                    if let Some(name) = manifest.split("\nname = \"").nth(1).and_then(|rest| rest.split('"').next())
                        && manifest.contains("[package]")
                    {
                        packages.insert(name.to_owned(), (folder.clone(), manifest));
                    }
                }
            }
        }
        let source =
            |file: &str| fs::read_to_string(root().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
        let parts =
            ["xtask/src/suite.rs", "firmware/board-list/src/lib.rs", "xtask/src/bench.rs", "tests/bench/src/main.rs"];
        let parts = parts.map(source).concat();
        Self { packages, repository_commands: source("xtask/src/main.rs"), parts }
    }

    /// What is wrong with a command; nothing if it can be run.
    pub fn fault(&self, words: &[String]) -> Option<String> {
        let mut words = words.iter().map(String::as_str).skip(1).filter(|word| !word.starts_with('+'));
        let subcommand = words.next()?;
        if subcommand == "xtask" {
            return self.repository_fault(&words.collect::<Vec<_>>());
        }
        let known = ["build", "check", "clippy", "doc", "fmt", "install", "package", "run", "test"];
        if !known.contains(&subcommand) {
            return Some(format!("`cargo {subcommand}` is not one of {known:?}"));
        }
        let words: Vec<&str> = words.take_while(|word| *word != "--").collect();
        let after = |names: &[&str]| -> Vec<&str> {
            let pairs = words.windows(2).filter(|pair| names.contains(&pair[0]));
            pairs.map(|pair| pair[1]).collect()
        };
        let mut packages = Vec::new();
        for name in after(&["-p", "--package"]) {
            match self.packages.get(name) {
                Some(package) => packages.push(package),
                None => return Some(format!("there is no package `{name}`")),
            }
        }
        for path in after(&["--path"]) {
            let folder = root().join(path);
            match self.packages.values().find(|(at, _)| at.canonicalize().ok() == folder.canonicalize().ok()) {
                Some(package) => packages.push(package),
                None => return Some(format!("there is no package in `{path}`")),
            }
        }
        if packages.is_empty() {
            packages = self.packages.values().collect();
        }
        let declared = |kind: &str, name: &str| {
            packages.iter().any(|(folder, manifest)| {
                folder.join(kind).join(format!("{name}.rs")).exists()
                    || folder.join(kind).join(name).join("main.rs").exists()
                    || manifest.contains(&format!("\nname = \"{name}\"\n"))
            })
        };
        for (option, kind) in
            [("--test", "tests"), ("--example", "examples"), ("--bin", "src/bin"), ("--bench", "benches")]
        {
            if let Some(name) = after(&[option]).into_iter().find(|name| !declared(kind, name)) {
                return Some(format!("there is no {option} {name}"));
            }
        }
        // Tests of one file of a program: `NAME::`.
        let has_file = |program: &&str, file: &str| {
            packages.iter().any(|(folder, _)| folder.join("tests").join(program).join(format!("{file}.rs")).exists())
        };
        let files = words.iter().filter_map(|word| word.strip_suffix("::"));
        for file in files {
            if !after(&["--test"]).iter().any(|program| has_file(program, file)) {
                return Some(format!("there are no tests of `{file}`"));
            }
        }
        for feature in
            after(&["--features", "-F"]).iter().flat_map(|list| list.split([',', ' '])).filter(|f| !f.is_empty())
        {
            let (package, feature) = feature.split_once('/').map_or((None, feature), |(p, f)| (Some(p), f));
            // A word of a CI file's matrix.
            if feature.starts_with("${{") || feature.ends_with("}}") || feature.starts_with("matrix.") {
                continue;
            }
            let has = |manifest: &str| manifest.contains(&format!("\n{feature} = ["));
            let found = match package {
                Some(name) => self.packages.get(name).is_some_and(|(_, manifest)| has(manifest)),
                None => packages.iter().any(|(_, manifest)| has(manifest)),
            };
            if !found {
                return Some(format!("there is no feature `{feature}`"));
            }
        }
        None
    }

    fn repository_fault(&self, words: &[&str]) -> Option<String> {
        let command = words.first().filter(|word| word.starts_with(|c: char| c.is_ascii_lowercase()))?;
        if !self.repository_commands.contains(&format!("[\"{command}\"")) {
            return Some(format!("there is no `cargo xtask {command}`"));
        }
        if !["test", "bench", "firmware"].contains(command) {
            return None;
        }
        let is_part = |word: &&&str| word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-');
        let options = words[1..].iter().take_while(|word| !word.starts_with('-'));
        // Parts of the bench are variants of an enum, the others texts.
        let variant = |part: &str| format!("\n    {}{},\n", part[..1].to_uppercase(), &part[1..]);
        let known = |part: &str| self.parts.contains(&format!("\"{part}\"")) || self.parts.contains(&variant(part));
        let unknown = options.filter(is_part).find(|part| !known(part))?;
        Some(format!("`cargo xtask {command}` has no `{unknown}`"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shell::programs;

    #[test]
    fn what_does_not_exist_is_named() {
        let repository = Repository::read();
        let fault = |line: &str| repository.fault(&programs(line)[0]);
        for good in [
            "cargo test -p reference-tests --test all fea_80:: -- --nocapture",
            "cargo +1.95 check --workspace --all-targets",
            "cargo run -p model-core --example free_object",
            "cargo install --path host/cli --features probe",
            "cargo xtask test pc",
            "cargo xtask firmware opencr",
            "cargo xtask firmware BOARD",
            "cargo xtask bench soak",
        ] {
            assert_eq!(fault(good), None, "{good}");
        }
        for (bad, why) in [
            ("cargo test -p nothing", "no package `nothing`"),
            ("cargo test -p fre --test nothing", "no --test nothing"),
            ("cargo test -p reference-tests --test all nothing:: -- --nocapture", "no tests of `nothing`"),
            ("cargo run -p model-core --example nothing", "no --example nothing"),
            ("cargo build -p fre-cli --features nothing", "no feature `nothing`"),
            ("cargo install --path host/nothing", "no package in `host/nothing`"),
            ("cargo xtask nothing", "no `cargo xtask nothing`"),
            ("cargo xtask bench nothing", "has no `nothing`"),
            ("cargo nothing", "`cargo nothing` is not one of"),
        ] {
            assert!(fault(bad).is_some_and(|fault| fault.contains(why)), "{bad}: {:?}", fault(bad));
        }
    }
}
