//! The code that the book, the README and their neighbours show, run.
#![cfg(unix)]

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use book::block::{Block, LANGUAGES, REASONS, blocks, printed};
use book::generated::hold;
use book::page::{Page, all, root};
use fre::case::Case;

/// `fre` in a folder, as on a terminal of a fixed width without colours.
fn shell(folder: &Path, line: &str) -> (i32, String) {
    let program = Path::new(env!("CARGO_BIN_EXE_fre"));
    let path = std::env::var("PATH").unwrap_or_default();
    let done = Command::new("sh")
        .args(["-c", &format!("{{ {line}\n}} 2>&1")])
        .current_dir(folder)
        .env("PATH", format!("{}:{path}", program.parent().unwrap().display()))
        .env("NO_COLOR", "1")
        .output()
        .unwrap();
    (done.status.code().unwrap_or(-1), String::from_utf8_lossy(&done.stdout).into_owned())
}

/// A folder in which a reader of the repository stands: with its examples.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let examples = folder.path().join("examples");
    fs::create_dir(&examples).unwrap();
    for entry in fs::read_dir(root().join("examples")).unwrap() {
        let file = entry.unwrap().path();
        if file.is_file() {
            fs::copy(&file, examples.join(file.file_name().unwrap())).unwrap();
        }
    }
    folder
}

fn run(folder: &Path, page: &Page, block: &Block, faults: &mut Vec<String>) {
    let steps = block.steps();
    for (number, step) in steps.iter().enumerate() {
        let (status, output) = shell(folder, &step.command);
        let last = number + 1 == steps.len();
        let wanted = block.value("exit").filter(|_| last).map_or(0, |exit| exit.parse().expect("an exit status"));
        let shown = step.output.is_empty() || printed(&step.output, &output);
        if status != wanted || !shown {
            let [path, line, command] = [&page.path, &step.line.to_string(), &step.command];
            faults.push(format!("{path}:{line}: $ {command}\nexit status {status}, not {wanted}; it prints\n{output}"));
        }
    }
}

#[test]
fn commands_print_what_their_page_shows() {
    let (mut faults, mut count) = (Vec::new(), 0);
    for page in all() {
        let folder = folder();
        for block in blocks(&page) {
            if let Some(file) = block.file() {
                fs::write(folder.path().join(file), &block.text).unwrap();
            }
            if block.language == "console" && block.not_run().is_none() {
                count += block.steps().len();
                run(folder.path(), &page, &block, &mut faults);
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(count > 10, "only {count} commands were run");
}

#[test]
fn cases_that_pages_show_are_cases() {
    let example = fs::read_to_string(root().join("examples/own-finger.toml")).unwrap();
    let mut count = 0;
    for page in all() {
        for block in blocks(&page).into_iter().filter(|block| block.language == "toml") {
            let name = format!("{}:{}", page.path, block.line);
            let text = if block.words.iter().any(|word| word == "part") {
                let mut whole: toml::Table = example.parse().unwrap();
                let part: toml::Table = block.text.parse().unwrap_or_else(|error| panic!("{name}: {error}"));
                lay_over(&mut whole, part);
                toml::to_string(&whole).unwrap()
            } else {
                block.text.clone()
            };
            Case::parse(&name, &text).unwrap_or_else(|error| panic!("{error}"));
            count += 1;
        }
    }
    assert!(count > 0, "no case was found");
}

/// Puts the keys of a part over those of a whole; an object replaces the object, because its shape says which keys it has.
fn lay_over(whole: &mut toml::Table, part: toml::Table) {
    for (key, value) in part {
        match (whole.get_mut(&key), value) {
            (Some(toml::Value::Table(below)), toml::Value::Table(part))
                if !["object", "motion"].contains(&key.as_str()) =>
            {
                lay_over(below, part);
            }
            (_, value) => drop(whole.insert(key, value)),
        }
    }
}

#[test]
fn every_block_says_what_it_is_and_why_it_is_not_run() {
    for page in all() {
        for block in blocks(&page) {
            let at = format!("{}:{}", page.path, block.line);
            assert!(
                LANGUAGES.contains(&block.language.as_str()),
                "{at}: a block of code begins with ``` and one of {LANGUAGES:?}, not with `{}`",
                block.language
            );
            if let Some(reason) = block.not_run() {
                assert!(REASONS.iter().any(|(name, _)| *name == reason), "{at}: `{reason}` is not one of {REASONS:?}");
            }
        }
    }
}

/// Pictures of the book and the commands that draw them, in the repository's root.
const PICTURES: &[(&str, &str)] = &[
    ("docs/closing.svg", "fre solve examples/closing.toml --animate OUT"),
    ("docs/tutorial/solved.svg", "fre solve examples/own-finger.toml --plot OUT"),
];

#[test]
fn pictures_are_what_their_commands_draw() {
    let folder = folder();
    for (file, command) in PICTURES {
        let (status, output) = shell(folder.path(), &command.replace("OUT", "picture.svg --force"));
        assert_eq!(status, 0, "{command}: {output}");
        hold(file, &fs::read(folder.path().join("picture.svg")).unwrap());
    }
    // Those of the keys are held by a test of the library, the browser's picture of the page by the system's tests.
    let known: BTreeSet<&str> = PICTURES.iter().map(|(file, _)| *file).chain(["docs/live-page.png"]).collect();
    for entry in ["docs", "docs/tutorial"].iter().flat_map(|folder| fs::read_dir(root().join(folder)).unwrap()) {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|kind| kind == "svg" || kind == "png") {
            let name = path.strip_prefix(root()).unwrap().to_str().unwrap().to_owned();
            assert!(known.contains(name.as_str()), "{name} has no command: add it to this test");
        }
    }
}

#[test]
fn the_page_of_keys_is_what_the_schema_says() {
    let folder = folder();
    let (status, output) = shell(folder.path(), "fre schema --page page");
    assert_eq!(status, 0, "{output}");
    let page = folder.path().join("page");
    hold("docs/case.md", &fs::read(page.join("case.md")).unwrap());
    for picture in fs::read_dir(page.join("case")).unwrap() {
        let file = picture.unwrap().path();
        hold(&format!("docs/case/{}", file.file_name().unwrap().to_str().unwrap()), &fs::read(&file).unwrap());
    }
}

/// The commands below one, from its help.
fn below(help: &str) -> Vec<String> {
    let Some((_, list)) = help.split_once("\nCommands:\n") else { return vec![] };
    let names = list.lines().take_while(|line| !line.is_empty()).filter_map(|line| {
        let rest = line.strip_prefix("  ")?;
        (!rest.starts_with(' ')).then(|| rest.split([' ', ',']).next().unwrap_or_default().to_owned())
    });
    names.filter(|name| name != "help").collect()
}

fn describe(out: &mut String, folder: &Path, path: &str, depth: usize) {
    let (status, help) = shell(folder, &format!("{path} --help"));
    assert_eq!(status, 0, "{path} --help: {help}");
    let help: Vec<&str> = help.trim_end().lines().map(str::trim_end).collect();
    let _ = write!(out, "\n{} `{path}`\n\n```text\n{}\n```\n", "#".repeat(depth), help.join("\n"));
    for name in below(&help.join("\n")) {
        describe(out, folder, &format!("{path} {name}"), depth + 1);
    }
}

#[test]
fn the_page_of_the_command_is_its_help() {
    let folder = folder();
    let mut page = String::from(
        "<!-- Made by `cargo xtask docs` from the program; a test keeps it current. -->\n\n# The command `fre`\n\nWhat `--help` prints, \
         of a build with all features.\n",
    );
    describe(&mut page, folder.path(), "fre", 2);
    hold("docs/cli.md", page.as_bytes());
}
