//! Every cargo command that a page or the CI file names can be run.

use book::cargo::Repository;
use book::page::{all, root};
use book::shell::programs;
use yaml_rust2::{Yaml, YamlLoader};

#[test]
fn cargo_commands_of_the_pages_exist() {
    let repository = Repository::read();
    let (mut faults, mut count) = (Vec::new(), 0);
    for page in all() {
        // In a block a command is behind a prompt, in running text between backquotes.
        for (number, line) in page.text.lines().enumerate() {
            let shown = line.trim_start().strip_prefix("$ ").into_iter();
            for code in shown.chain(line.split('`').skip(1).step_by(2)) {
                for words in programs(code).iter().filter(|words| words[0] == "cargo") {
                    count += 1;
                    let fault = repository.fault(words);
                    faults.extend(
                        fault.map(|fault| format!("{}:{}: {}: {fault}", page.path, number + 1, words.join(" "))),
                    );
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(count > 50, "only {count} commands were found");
}

#[test]
fn the_ci_file_is_valid_and_its_commands_exist() {
    let text = std::fs::read_to_string(root().join(".github/workflows/ci.yml")).expect("the CI file");
    let document = YamlLoader::load_from_str(&text).expect("YAML");
    let [document] = &document[..] else { panic!("the CI file is one document") };
    for key in ["name", "on", "permissions", "jobs"] {
        assert!(!document[key].is_badvalue(), "the CI file has no `{key}`");
    }
    let repository = Repository::read();
    let (mut faults, mut count) = (Vec::new(), 0);
    for (name, job) in document["jobs"].as_hash().expect("jobs") {
        let name = name.as_str().expect("a name");
        assert!(job["runs-on"].as_str().is_some(), "{name} does not say where it runs");
        let steps = job["steps"].as_vec().unwrap_or_else(|| panic!("{name} has no steps"));
        assert!(steps[0]["uses"].as_str().is_some_and(|uses| uses.starts_with("actions/checkout@")), "{name}");
        for step in steps {
            match (&step["uses"], &step["run"]) {
                (Yaml::String(uses), Yaml::BadValue) => {
                    let (action, version) = uses.split_once('@').unwrap_or_else(|| panic!("{name}: {uses}"));
                    assert!(action.contains('/') && version.starts_with('v'), "{name}: {uses}");
                }
                (Yaml::BadValue, Yaml::String(run)) => {
                    for words in run.lines().flat_map(programs) {
                        count += 1;
                        faults.extend(fault(&repository, &words).map(|fault| format!("{name}: {run}: {fault}")));
                    }
                }
                _ => panic!("{name}: a step has either `uses` or `run`: {step:?}"),
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(count > 10, "only {count} commands were found");
}

/// The command's features that are no tests' are checked one by one.
#[test]
fn the_ci_file_checks_each_feature() {
    let text = std::fs::read_to_string(root().join(".github/workflows/ci.yml")).expect("the CI file");
    let document = YamlLoader::load_from_str(&text).expect("YAML");
    let mut checked: Vec<&str> = document[0]["jobs"]["features"]["strategy"]["matrix"]["features"]
        .as_vec()
        .expect("a list of features")
        .iter()
        .map(|feature| feature.as_str().expect("a name"))
        .filter(|feature| !feature.is_empty())
        .collect();
    let manifest = std::fs::read_to_string(root().join("host/cli/Cargo.toml")).expect("the command's manifest");
    let manifest: toml::Table = toml::from_str(&manifest).expect("TOML");
    let features = manifest["features"].as_table().expect("features").keys();
    let mut features: Vec<&str> = features.map(String::as_str).collect();
    features.retain(|feature| !["default", "qemu", "python", "fea"].contains(feature));
    checked.sort_unstable();
    features.sort_unstable();
    assert_eq!(checked, features);
}

/// What is wrong with a command of the CI file.
fn fault(repository: &Repository, words: &[String]) -> Option<String> {
    // What is before a program: `sudo` and `env`, with options and variables.
    let start = words.iter().position(|word| !["sudo", "env"].contains(&word.as_str()) && !word.starts_with('-'))?;
    match words[start].as_str() {
        "cargo" => repository.fault(&words[start..]),
        "rustup" | "apt-get" | "chown" => None,
        other => Some(format!("`{other}` is not a program that a runner has")),
    }
}
