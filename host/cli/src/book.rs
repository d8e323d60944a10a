//! Every `fre` command that the book and its neighbours show is one that this program understands.

use book::block::blocks;
use book::page::{Page, all};
use book::shell::programs;
use clap::{CommandFactory, Parser};

use crate::Cli;

/// The `fre` commands in a page's console blocks: line, and words.
fn shown(page: &Page) -> Vec<(usize, Vec<String>)> {
    let console = blocks(page).into_iter().filter(|block| block.language == "console");
    console
        .flat_map(|block| block.steps())
        .flat_map(|step| programs(&step.command).into_iter().map(move |words| (step.line, words)))
        .filter(|(_, words)| words[0] == "fre")
        .collect()
}

/// `fre …` between backquotes in running text: line, and words.
fn mentioned(page: &Page) -> Vec<(usize, Vec<String>)> {
    let mut found = Vec::new();
    for (number, line) in page.text.lines().enumerate() {
        for code in line.split('`').skip(1).step_by(2).filter(|code| code.starts_with("fre ")) {
            found.extend(programs(code).into_iter().filter(|words| words[0] == "fre").map(|words| (number + 1, words)));
        }
    }
    found
}

/// What is wrong with a command in running text, which need not be complete: its commands and its options must exist.
fn fault(words: &[String]) -> Option<String> {
    let mut command = Cli::command();
    command.build();
    let mut options = Vec::new();
    let mut place = &command;
    for word in &words[1..] {
        if let Some(below) = place.find_subcommand(word) {
            place = below;
        } else if place.has_subcommands() && options.is_empty() && word.chars().all(|c| c.is_ascii_lowercase()) {
            return Some(format!("`{}` has no command `{word}`", place.get_name()));
        } else if word.starts_with("--") {
            options.push(word.trim_start_matches('-').split('=').next().unwrap_or_default());
        }
    }
    let known = |option: &&&str| place.get_arguments().any(|argument| argument.get_long() == Some(**option));
    let unknown = options.iter().find(|option| !known(option) && !["help", "version"].contains(*option))?;
    Some(format!("`{}` has no option `--{unknown}`", place.get_name()))
}

#[test]
fn commands_of_the_pages_are_understood() {
    let (mut faults, mut count) = (Vec::new(), 0);
    // The changelog tells of commands as they were.
    for page in all().iter().filter(|page| page.path != "CHANGELOG.md") {
        for (line, words) in shown(page) {
            count += 1;
            if let Err(error) = Cli::try_parse_from(&words)
                && error.use_stderr()
            {
                faults.push(format!("{}:{line}: {}\n{error}", page.path, words.join(" ")));
            }
        }
        for (line, words) in mentioned(page) {
            count += 1;
            faults.extend(fault(&words).map(|fault| format!("{}:{line}: {}: {fault}", page.path, words.join(" "))));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(count > 80, "only {count} commands were found");
}

#[test]
fn a_command_that_does_not_exist_is_found() {
    let words = |line: &str| line.split(' ').map(str::to_owned).collect::<Vec<_>>();
    assert!(fault(&words("fre solve --plot FILE")).is_none());
    assert!(fault(&words("fre gripper grip --force-n 5")).is_none());
    assert!(fault(&words("fre solv")).unwrap().contains("no command `solv`"));
    assert!(fault(&words("fre solve --draw")).unwrap().contains("no option `--draw`"));
}
