//! Text that people read: pages, doc comments, and what programs print.

use std::fs;
use std::path::{Path, PathBuf};

use crate::page::{all, root};

/// A piece of text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Prose {
    /// File, from the repository's root.
    pub path: String,
    /// Its first line, from 1.
    pub line: usize,
    /// The text. What is between backquotes is code and left out.
    pub text: String,
}

/// Folders of sources whose doc comments and texts are read by users.
const SOURCES: &[&str] = &["model-core/src", "firmware", "host", "xtask/src", "examples"];

/// All text that people read.
///
/// # Panics
///
/// If a file cannot be read.
pub fn everything() -> Vec<Prose> {
    let pages = all().into_iter().map(|page| Prose { path: page.path, line: 1, text: page.text });
    let mut found: Vec<Prose> = pages.flat_map(|whole| pieces(&whole)).collect();
    for source in SOURCES {
        for path in files(&root().join(source)) {
            let name = path.strip_prefix(root()).expect("below the root").to_str().expect("UTF-8").replace('\\', "/");
            let kind = path.extension().and_then(|kind| kind.to_str()).unwrap_or_default();
            if !["rs", "py", "pyi", "html", "js", "toml"].contains(&kind) || name.ends_with("Cargo.toml") {
                continue;
            }
            let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("cannot read {name}: {error}"));
            if kind == "rs" {
                found.extend(rust(&name, &text));
            } else if ["js", "py", "pyi"].contains(&kind) {
                found.extend(strings(&name, &text));
            } else {
                found.extend(pieces(&Prose { path: name, line: 1, text }));
            }
        }
    }
    found
}

/// Files below a folder, but for those of tests and what is built.
fn files(folder: &Path) -> Vec<PathBuf> {
    let (mut folders, mut files) = (vec![folder.to_path_buf()], Vec::new());
    while let Some(next) = folders.pop() {
        for entry in next.read_dir().unwrap_or_else(|error| panic!("{}: {error}", next.display())).flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.starts_with('.') || ["target", "tests", "tests.rs", "__pycache__"].contains(&name.as_str()) {
                continue;
            }
            if entry.path().is_dir() { folders.push(entry.path()) } else { files.push(entry.path()) }
        }
    }
    files.sort();
    files
}

/// A text's paragraphs, each on one line, so that phrases are found across line breaks.
fn pieces(whole: &Prose) -> Vec<Prose> {
    let (mut found, mut fence): (Vec<Prose>, bool) = (Vec::new(), false);
    let mut begun = false;
    for (number, line) in whole.text.lines().enumerate() {
        let line = line.trim();
        if line.starts_with("```") {
            fence = !fence;
            begun = false;
        } else if line.is_empty() || line.starts_with('|') {
            begun = false;
        }
        if line.is_empty() || fence || line.starts_with("```") {
            continue;
        }
        match found.last_mut().filter(|_| begun) {
            Some(piece) => {
                piece.text.push(' ');
                piece.text.push_str(line);
            }
            None => {
                found.push(Prose { path: whole.path.clone(), line: whole.line + number, text: line.to_owned() });
                begun = true;
            }
        }
    }
    for piece in &mut found {
        piece.text = without_code(&piece.text);
    }
    found
}

/// A text without what is between backquotes.
fn without_code(text: &str) -> String {
    text.split('`').step_by(2).collect::<Vec<_>>().join("`…`")
}

/// Doc comments and string literals of a Rust file, up to its tests.
pub fn rust(path: &str, text: &str) -> Vec<Prose> {
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    let mut found: Vec<Prose> = Vec::new();
    let mut add = |line: usize, text: String| found.push(Prose { path: path.to_owned(), line, text });
    let mut rest = text;
    let line_of = |rest: &str| 1 + text[..text.len() - rest.len()].matches('\n').count();
    let mut comment: Option<(usize, String)> = None;
    while let Some(c) = rest.chars().next() {
        if let Some(body) = rest.strip_prefix("///").or_else(|| rest.strip_prefix("//!")) {
            let (words, after) = body.split_once('\n').unwrap_or((body, ""));
            let (_, whole) = comment.get_or_insert_with(|| (line_of(rest), String::new()));
            whole.push_str(words);
            whole.push('\n');
            rest = after;
        } else if rest.starts_with("//") {
            if let Some((line, words)) = comment.take() {
                add(line, words);
            }
            rest = rest.split_once('\n').map_or("", |(_, after)| after);
        } else if let Some((words, after)) = literal(rest) {
            add(line_of(rest), words);
            rest = after;
        } else if let Some(after) = character(rest) {
            rest = after;
        } else {
            // A comment ends at a line without one.
            if (!c.is_whitespace() || c == '\n')
                && let Some((line, words)) = comment.take()
            {
                add(line, words);
            }
            rest = &rest[c.len_utf8()..];
        }
    }
    found.into_iter().flat_map(|whole| pieces(&whole)).collect()
}

/// What is between quotation marks in a file of another language, doc strings included; lines of comment are left out.
fn strings(path: &str, text: &str) -> Vec<Prose> {
    let is_comment = |line: &str| line.trim_start().starts_with('#') || line.trim_start().starts_with("//");
    let code = |line: &str| if is_comment(line) { "\n".to_owned() } else { format!("{line}\n") };
    let text: String = text.lines().map(code).collect();
    let (mut found, mut rest) = (Vec::new(), text.as_str());
    while let Some(at) = rest.find('"') {
        let line = 1 + text[..text.len() - rest.len() + at].matches('\n').count();
        let Some((words, after)) = literal(&rest[at..]) else { break };
        found.extend(pieces(&Prose { path: path.to_owned(), line, text: words }));
        rest = after;
    }
    found
}

/// A string literal at the beginning of a text: its words, and what is behind it.
fn literal(text: &str) -> Option<(String, &str)> {
    if let Some(raw) = text.strip_prefix('r') {
        let hashes = raw.len() - raw.trim_start_matches('#').len();
        let body = raw[hashes..].strip_prefix('"')?;
        let (words, after) = body.split_once(&format!("\"{}", "#".repeat(hashes)))?;
        return Some((words.to_owned(), after));
    }
    let body = text.strip_prefix('"')?;
    let (mut words, mut escaped, mut broken) = (String::new(), false, false);
    for (at, c) in body.char_indices() {
        if broken && c.is_whitespace() {
            continue;
        }
        broken = false;
        match c {
            '"' if !escaped => return Some((words, &body[at + 1..])),
            '\\' if !escaped => escaped = true,
            // An escaped line break goes with the spaces behind it.
            '\n' if escaped => (escaped, broken) = (false, true),
            'n' if escaped => {
                words.push('\n');
                escaped = false;
            }
            _ => {
                words.push(c);
                escaped = false;
            }
        }
    }
    None
}

/// What is behind a character literal; none for a lifetime or anything else.
fn character(text: &str) -> Option<&str> {
    let body = text.strip_prefix('\'')?;
    let mut chars = body.char_indices();
    let (_, first) = chars.next()?;
    if first == '\\' {
        let (at, _) = chars.skip(1).find(|(_, c)| *c == '\'')?;
        return Some(&body[at + 1..]);
    }
    let (at, second) = chars.next()?;
    (second == '\'').then(|| &body[at + 1..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doc_comments_and_texts_are_found_and_code_is_not() {
        let text = "//! One\n//! two.\n\n// not this\n/// Three `not this`.\nfn f<'a>(x: char) {\n    \
                    let told = '\"'; say(\"four \\\n        five\"); r#\"six \"seven\"\"#;\n}\n#[cfg(test)]\nmod tests {\n    \"no\"\n}\n";
        let found: Vec<_> = rust("a.rs", text).into_iter().map(|prose| (prose.line, prose.text)).collect();
        let wanted = [(1, "One two."), (5, "Three `…`."), (7, "four five"), (8, "six \"seven\"")];
        assert_eq!(found, wanted.map(|(line, text)| (line, text.to_owned())));
    }

    #[test]
    fn a_phrase_is_found_across_lines_but_not_across_paragraphs() {
        let page = Prose { path: String::new(), line: 1, text: "a\nb\n\n```text\nno\n```\n| c |\n| d |\n".to_owned() };
        let found: Vec<_> = pieces(&page).into_iter().map(|prose| (prose.line, prose.text)).collect();
        let wanted = [(1, "a b"), (7, "| c |"), (8, "| d |")];
        assert_eq!(found, wanted.map(|(line, text)| (line, text.to_owned())));
    }
}
