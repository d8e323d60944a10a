//! Blocks of code in a page, and the commands in them.
//!
//! The word after the fence says what a block is and so how it is tested:
//!
//! | language | is |
//! |---|---|
//! | `console` | lines `$ command`, each with what it prints; `…` stands for any text of a line, alone on a line for any lines |
//! | `toml` | a case; its first line may be a comment with the file's name |
//! | `toml part` | some keys of a case, put into the example with a whole finger |
//! | `rust` | a doctest |
//! | `python` | run in order, one program per page |
//! | `text`, `math` | something to look at |
//!
//! `not-run=REASON` after the language: the block's syntax is checked, and it is not run ([`REASONS`]). `exit=N`: the exit status of a console
//! block's last command, if that is not 0.

use pulldown_cmark::{CodeBlockKind, Event, Parser, Tag, TagEnd};

use crate::link::SYNTAX;
use crate::page::Page;

/// Why a block may not be run, and what each reason means.
pub const REASONS: &[(&str, &str)] = &[
    ("hardware", "it needs a gripper, a servo or a debug probe"),
    ("install", "it changes the machine, or fetches from the network"),
    ("cluster", "it needs several machines"),
    ("suite", "it takes minutes: another part of the suite runs it"),
    ("calculix", "it needs CalculiX"),
    ("server", "it runs until it is stopped"),
    ("sketch", "it shows code that is to come"),
];

/// Languages that a block may have.
pub const LANGUAGES: &[&str] = &["console", "toml", "rust", "python", "text", "math"];

/// A block of code.
#[derive(Clone, Debug)]
pub struct Block {
    /// Line of its first line of code, from 1.
    pub line: usize,
    /// The word after the fence; empty if there is none, or no fence.
    pub language: String,
    /// The words behind that.
    pub words: Vec<String>,
    /// The code.
    pub text: String,
}

/// A command of a console block.
#[derive(Clone, Debug)]
pub struct Step {
    /// Line of the page, from 1.
    pub line: usize,
    /// The command, in one line.
    pub command: String,
    /// What it prints, as the page shows it; empty if the page does not.
    pub output: String,
}

impl Block {
    /// The value behind `KEY=`.
    pub fn value(&self, key: &str) -> Option<&str> {
        self.words.iter().find_map(|word| word.strip_prefix(key)?.strip_prefix('='))
    }

    /// Why it is not run; none if it is.
    pub fn not_run(&self) -> Option<&str> {
        self.value("not-run")
    }

    /// The name of the file that it is, if its first line says so.
    pub fn file(&self) -> Option<&str> {
        let name = self.text.lines().next()?.strip_prefix("# ")?;
        (name.ends_with(".toml") && !name.contains([' ', '/'])).then_some(name)
    }

    /// The commands of a console block.
    ///
    /// # Panics
    ///
    /// If the block does not begin with a command.
    pub fn steps(&self) -> Vec<Step> {
        let mut steps: Vec<Step> = Vec::new();
        let mut continued = false;
        for (number, text) in self.text.lines().enumerate() {
            let line = self.line + number;
            let part = text.strip_suffix('\\').unwrap_or(text);
            if continued {
                let step = steps.last_mut().expect("what is continued has begun");
                step.command.push_str(part.trim_start());
            } else if let Some(command) = part.strip_prefix("$ ") {
                steps.push(Step { line, command: command.to_owned(), output: String::new() });
            } else {
                let step = steps.last_mut().unwrap_or_else(|| panic!("line {line}: a console block begins with `$ `"));
                step.output.push_str(text);
                step.output.push('\n');
                continue;
            }
            continued = text.ends_with('\\');
        }
        steps
    }
}

/// All blocks of a page.
pub fn blocks(page: &Page) -> Vec<Block> {
    let mut found: Vec<Block> = Vec::new();
    let mut inside = false;
    for (event, range) in Parser::new_ext(&page.text, SYNTAX).into_offset_iter() {
        match event {
            Event::Start(Tag::CodeBlock(kind)) => {
                let (info, fence) = match kind {
                    CodeBlockKind::Fenced(info) => (info.into_string(), 1),
                    CodeBlockKind::Indented => (String::new(), 0),
                };
                let mut words = info.split([' ', ',']).filter(|word| !word.is_empty()).map(str::to_owned);
                let language = words.next().unwrap_or_default();
                let line = page.line(range.start) + fence;
                found.push(Block { line, language, words: words.collect(), text: String::new() });
                inside = true;
            }
            Event::End(TagEnd::CodeBlock) => inside = false,
            Event::Text(part) if inside => found.last_mut().expect("a block has begun").text.push_str(&part),
            _ => {}
        }
    }
    found
}

/// Whether a command printed what the page shows: `…` in a line is any text, alone in a line any number of lines. Spaces at a line's end
/// do not count, and one that does not break is a space.
pub fn printed(shown: &str, output: &str) -> bool {
    // Tables have spaces that do not break.
    let line = |line: &str| line.replace('\u{a0}', " ").trim_end().to_owned();
    let lines = |text: &str| text.trim_end().lines().map(line).collect::<Vec<_>>();
    fits(
        &lines(shown),
        &lines(output),
        |shown| shown.trim() == "…",
        |shown, line| {
            let (shown, line) = (Vec::from_iter(shown.chars()), Vec::from_iter(line.chars()));
            fits(&shown, &line, |c| *c == '…', |a, b| a == b)
        },
    )
}

/// Whether a pattern fits a whole sequence; an item for which `any` holds fits any number of items.
fn fits<T>(pattern: &[T], items: &[T], any: impl Fn(&T) -> bool, same: impl Fn(&T, &T) -> bool) -> bool {
    let (mut p, mut i, mut back) = (0, 0, None);
    while i < items.len() {
        if p < pattern.len() && any(&pattern[p]) {
            back = Some((p, i));
            p += 1;
        } else if p < pattern.len() && same(&pattern[p], &items[i]) {
            (p, i) = (p + 1, i + 1);
        } else if let Some((star, from)) = back {
            back = Some((star, from + 1));
            (p, i) = (star + 1, from + 1);
        } else {
            return false;
        }
    }
    pattern[p..].iter().all(any)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_and_their_commands_are_read() {
        let text =
            "a\n\n```console not-run=hardware exit=2\n$ fre one \\\n      two\n1\n2\n$ fre three\n```\n\n    old\n";
        let found = blocks(&Page { path: "docs/it.md".to_owned(), text: text.to_owned() });
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].language.as_str(), found[0].line), ("console", 4));
        assert_eq!((found[0].not_run(), found[0].value("exit")), (Some("hardware"), Some("2")));
        let steps = found[0].steps();
        assert_eq!((steps[0].command.as_str(), steps[0].output.as_str(), steps[0].line), ("fre one two", "1\n2\n", 4));
        assert_eq!((steps[1].command.as_str(), steps[1].output.as_str(), steps[1].line), ("fre three", "", 8));
        assert_eq!((found[1].language.as_str(), found[1].line), ("", 11));
    }

    #[test]
    fn a_file_is_named_by_its_first_line() {
        let block = |text: &str| Block { line: 1, language: String::new(), words: vec![], text: text.to_owned() };
        assert_eq!(block("# my-finger.toml\n[a]\n").file(), Some("my-finger.toml"));
        assert_eq!(block("# a finger\n[a]\n").file(), None);
        assert_eq!(block("# ../a.toml\n[a]\n").file(), None);
    }

    #[test]
    fn an_output_fits_what_the_page_shows_of_it() {
        for (shown, output, fit) in [
            ("a\nb", "a\nb\n", true),
            ("a \nb", "a\nb  ", true),
            ("a\n…", "a\nb\nc", true),
            ("a\n…", "a", true),
            ("…\nc", "a\nb\nc", true),
            ("took … s", "took 1.5 s", true),
            ("took … s", "took 1.5 ms", false),
            ("a\n…\nd", "a\nb\nc", false),
            ("a", "a\nb", false),
            ("a\nb", "a", false),
            ("", "a", false),
        ] {
            assert_eq!(printed(shown, output), fit, "{shown:?} and {output:?}");
        }
    }
}
