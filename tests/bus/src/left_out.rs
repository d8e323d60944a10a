//! What `cargo test` alone leaves out: test programs behind features, because they need what a laptop may not have.

use std::collections::BTreeMap;
use std::process::ExitCode;

use toml::de::{DeTable, DeValue};

/// Set by `cargo xtask test` to the features that may be off, with commas between them: to leave anything else out is a failure.
pub const ALLOWED: &str = "FRE_LEFT_OUT";

/// A feature of a package that test programs require.
#[derive(Clone, Copy, Debug)]
pub struct Feature {
    /// Its name in the manifest.
    pub name: &'static str,
    /// Whether it is on.
    pub on: bool,
    /// What it needs of the machine.
    pub needs: &'static str,
}

/// The `main` of a test program without a harness: prints a line for every feature that is off and has test programs behind it,
/// according to the package's manifest. It fails if the manifest requires a feature that is not listed, or if a feature is off that
/// must not be ([`ALLOWED`]).
pub fn left_out(manifest: &str, features: &[Feature]) -> ExitCode {
    // Programs that run tests one by one ask for their names first: there are none here.
    if std::env::args().any(|argument| argument == "--list") {
        return ExitCode::SUCCESS;
    }
    match lines(manifest, features) {
        Err(fault) => {
            eprintln!("{fault}");
            ExitCode::FAILURE
        }
        Ok(lines) => {
            lines.iter().for_each(|(_, line)| println!("{line}"));
            let allowed = std::env::var(ALLOWED).ok();
            match lines.iter().find(|(feature, _)| !may_be_off(feature, allowed.as_deref())) {
                None => ExitCode::SUCCESS,
                Some((feature, _)) => {
                    eprintln!("tests behind the feature `{feature}` must not be left out here ({ALLOWED} is set)");
                    ExitCode::FAILURE
                }
            }
        }
    }
}

fn may_be_off(feature: &str, allowed: Option<&str>) -> bool {
    allowed.is_none_or(|allowed| allowed.split(',').any(|allowed| allowed == feature))
}

/// Every feature that is off and has programs behind it, with its line.
fn lines(manifest: &str, features: &[Feature]) -> Result<Vec<(&'static str, String)>, String> {
    let manifest = DeTable::parse(manifest).map_err(|error| format!("the manifest: {error}"))?;
    let manifest = manifest.get_ref();
    let package = text(manifest.get("package").and_then(|package| package.get_ref().get("name")));
    let mut left_out: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for test in manifest.get("test").and_then(|tests| tests.get_ref().as_array()).into_iter().flatten() {
        let name = text(test.get_ref().get("name"));
        let required = test.get_ref().get("required-features").and_then(|list| list.get_ref().as_array());
        for feature in required.into_iter().flatten() {
            let feature = feature.get_ref().as_str().unwrap_or_default();
            let known = features.iter().find(|known| known.name == feature);
            let known =
                known.ok_or_else(|| format!("{package}: test `{name}` requires `{feature}`, which is not listed"))?;
            if !known.on {
                left_out.entry(known.name).or_default().push(name);
            }
        }
    }
    let line = |feature: &Feature| {
        let programs = left_out.get(feature.name)?;
        let (count, names) = (programs.len(), programs.join(", "));
        let plural = if count == 1 { "" } else { "s" };
        let words = format!(
            "left out: {count} test program{plural} of {package} ({names}), feature `{}`: {}; `cargo xtask test` runs them",
            feature.name, feature.needs
        );
        Some((feature.name, words))
    };
    Ok(features.iter().filter_map(line).collect())
}

fn text<'a>(value: Option<&'a toml::Spanned<DeValue<'_>>>) -> &'a str {
    value.and_then(|value| value.get_ref().as_str()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MANIFEST: &str = "[package]\nname = \"p\"\n[[test]]\nname = \"a\"\nrequired-features = [\"qemu\"]\n\
        [[test]]\nname = \"b\"\nrequired-features = [\"qemu\", \"web\"]\n[[test]]\nname = \"c\"\n";

    fn features(qemu: bool, web: bool) -> [Feature; 2] {
        [Feature { name: "qemu", on: qemu, needs: "QEMU" }, Feature { name: "web", on: web, needs: "a browser" }]
    }

    #[test]
    fn every_feature_that_is_off_has_a_line_with_its_programs() {
        let lines = |qemu, web| lines(MANIFEST, &features(qemu, web)).unwrap();
        assert!(lines(true, true).is_empty());
        let left = lines(false, false);
        assert_eq!(left.len(), 2);
        assert!(left[0].1.starts_with("left out: 2 test programs of p (a, b), feature `qemu`: QEMU;"), "{left:?}");
        assert!(left[1].1.starts_with("left out: 1 test program of p (b), feature `web`: a browser;"), "{left:?}");
    }

    #[test]
    fn the_suite_leaves_out_what_it_names_only() {
        assert!(may_be_off("qemu", None), "by hand");
        assert!(!may_be_off("qemu", Some("")) && !may_be_off("qemu", Some("fea")));
        assert!(may_be_off("fea", Some("web,fea")));
    }

    #[test]
    fn a_feature_that_nobody_listed_is_an_error() {
        let fault = lines(MANIFEST, &features(true, true)[..1]).unwrap_err();
        assert!(fault.contains("`b`") && fault.contains("`web`"), "{fault}");
    }
}
