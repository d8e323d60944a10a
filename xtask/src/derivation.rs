//! What rustdoc shows of the derivation: `docs/derivation.md` with its formulas as MathML.
//!
//! A browser shows MathML by itself, so that the page fetches nothing. The source keeps its LaTeX, which GitHub shows: inline formulas
//! between dollar signs, numbered ones in fences of the language `math`.

use crate::paths;
use anyhow::{Context, Result, bail};
use math_core::{LatexToMathML, MathCoreConfig, MathDisplay};
use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};
use std::collections::BTreeSet;
use std::ops::Range;

/// The page as it is written.
const SOURCE: &str = "docs/derivation.md";
/// The page as `model_core::derivation` includes it.
const SHOWN: &str = "model-core/src/derivation.md";
/// Before an equation's number, at the end of a numbered formula.
const NUMBER: &str = "\\tag{";

/// Makes the page that rustdoc shows.
pub fn write() -> Result<()> {
    let shown = paths::root().join(SHOWN);
    std::fs::write(&shown, current()?).with_context(|| format!("cannot write {}", shown.display()))
}

/// That the page that rustdoc shows is the one that would be made.
pub fn check() -> Result<()> {
    let shown = paths::root().join(SHOWN);
    let text = std::fs::read_to_string(&shown).with_context(|| format!("cannot read {}", shown.display()))?;
    if text != current()? {
        bail!("{SHOWN} is not what {SOURCE} makes: run `cargo xtask docs`");
    }
    Ok(())
}

/// The page that rustdoc should show.
fn current() -> Result<String> {
    let source = paths::root().join(SOURCE);
    let text = std::fs::read_to_string(&source).with_context(|| format!("cannot read {}", source.display()))?;
    let page = rendered(&text).with_context(|| format!("in {SOURCE}"))?;
    Ok(format!("<!-- Made from {SOURCE} by `cargo xtask docs`: change that. -->\n\n{page}"))
}

/// The same Markdown with every formula replaced by its MathML.
fn rendered(text: &str) -> Result<String> {
    let converter = LatexToMathML::new(MathCoreConfig::default()).expect("no macros of our own that could be wrong");
    let mathml = |latex: &str, display, at: usize| -> Result<String> {
        match converter.convert_with_local_state(latex, display) {
            Ok(found) => Ok(found.mathml),
            Err(error) => bail!("line {}: `{latex}`: {error:?}", line(text, at)),
        }
    };
    let (mut page, mut end) = (String::new(), 0);
    for formula in formulas(text)? {
        page.push_str(&text[end..formula.range.start]);
        end = formula.range.end;
        let at = formula.range.start;
        match formula.number {
            Some(number) => page.push_str(&format!(
                "<div id=\"eq-{number}\" style=\"display: flex; align-items: center\">\
                 <div style=\"flex: 1; overflow: auto hidden; padding: 0.6em 0\">{}</div><div>({number})</div></div>",
                mathml(&formula.latex, MathDisplay::Block, at)?
            )),
            None => page.push_str(&no_markdown(&mathml(&formula.latex, MathDisplay::Inline, at)?)),
        }
    }
    page.push_str(&text[end..]);
    Ok(page)
}

/// A formula of the page.
struct Formula {
    /// Where it is, with its delimiters.
    range: Range<usize>,
    latex: String,
    /// Number of a displayed formula.
    number: Option<u32>,
}

/// All formulas, in order of the page. The displayed ones are numbered from 1 on, in any order: code cites the numbers, so a formula
/// keeps its own for good, and a new one takes the next.
fn formulas(text: &str) -> Result<Vec<Formula>> {
    let mut found = Vec::new();
    let mut displayed: Option<String> = None;
    let mut numbers = BTreeSet::new();
    for (event, range) in Parser::new_ext(text, Options::ENABLE_MATH | Options::ENABLE_TABLES).into_offset_iter() {
        match event {
            Event::InlineMath(latex) => {
                if let Some(escaped) =
                    latex.as_bytes().windows(2).find(|w| w[0] == b'\\' && w[1].is_ascii_punctuation())
                {
                    bail!(
                        "line {}: `{latex}`: GitHub takes `{}` for an escaped character; put the formula in a fence",
                        line(text, range.start),
                        String::from_utf8_lossy(escaped)
                    );
                }
                found.push(Formula { range, latex: latex.into_string(), number: None });
            }
            Event::DisplayMath(latex) => {
                bail!(
                    "line {}: `{latex}`: displayed formulas are fences of the language `math`",
                    line(text, range.start)
                );
            }
            Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(language))) if &*language == "math" => {
                displayed = Some(String::new());
            }
            Event::Text(part) => {
                if let Some(latex) = &mut displayed {
                    latex.push_str(&part);
                }
            }
            Event::End(TagEnd::CodeBlock) => {
                let Some(latex) = displayed.take() else { continue };
                let number = latex.rsplit_once(NUMBER).and_then(|(formula, rest)| {
                    let number: u32 = rest.trim_end().strip_suffix('}')?.parse().ok()?;
                    Some((formula.trim_end().to_owned(), number))
                });
                match number {
                    Some((latex, number)) if numbers.insert(number) => {
                        found.push(Formula { range, latex, number: Some(number) });
                    }
                    Some((_, number)) => bail!("line {}: there are two formulas ({number})", line(text, range.start)),
                    None => bail!("line {}: the formula must end with \\tag{{NUMBER}}", line(text, range.start)),
                }
            }
            _ => {}
        }
    }
    let free = (1..).find(|number| !numbers.contains(number)).unwrap_or_default();
    if numbers.last().is_some_and(|&last| last > free) {
        bail!("there is no formula ({free}), but there are higher numbers");
    }
    Ok(found)
}

/// Line of a place in a text, from 1.
fn line(text: &str, at: usize) -> usize {
    1 + text[..at].matches('\n').count()
}

/// The same HTML without anything that Markdown would read as its own between the tags.
fn no_markdown(html: &str) -> String {
    let mut out = String::with_capacity(html.len());
    let mut in_tag = false;
    for c in html.chars() {
        match c {
            '<' => in_tag = true,
            '>' => in_tag = false,
            '*' | '_' | '[' | ']' | '|' | '`' | '\\' | '~' | '$' if !in_tag => {
                out.push_str(&format!("&#{};", u32::from(c)));
                continue;
            }
            _ => {}
        }
        out.push(c);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    #[test]
    fn the_page_that_rustdoc_shows_is_current() {
        check().expect("current");
    }

    #[test]
    fn nothing_is_left_of_the_latex_and_nothing_is_fetched() {
        let page = current().expect("the source");
        for word in ["$", "```math", "\\tag", "\\frac", "http:", "https:", "<script", "<link", "<img", "url("] {
            assert!(!page.contains(word), "{word} in the page");
        }
        assert_eq!(page.matches("<math").count(), page.matches("</math>").count());
    }

    /// Every Rust and Markdown file of the repository, with its text.
    fn texts() -> Vec<(PathBuf, String)> {
        let (mut folders, mut texts) = (vec![paths::root()], Vec::new());
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(&folder).expect("a folder") {
                let path = entry.expect("an entry").path();
                let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
                if path.is_dir() && !name.starts_with('.') && name != "target" {
                    folders.push(path);
                } else if name.ends_with(".rs") || name.ends_with(".md") {
                    let text = std::fs::read_to_string(&path).expect("text");
                    texts.push((path, text));
                }
            }
        }
        texts
    }

    /// Code and documents cite an equation as `derivation (n)`.
    #[test]
    fn every_equation_that_is_cited_exists() {
        let source = std::fs::read_to_string(paths::root().join(SOURCE)).expect("the source");
        let numbers: BTreeSet<u32> =
            formulas(&source).expect("good formulas").iter().filter_map(|formula| formula.number).collect();
        let mut cited = 0;
        for (path, text) in texts() {
            for after in text.to_lowercase().split("derivation (").skip(1) {
                let Some(Ok(number)) = after.split_once(')').map(|(number, _)| number.parse()) else { continue };
                assert!(numbers.contains(&number), "{} cites derivation ({number})", path.display());
                cited += 1;
            }
        }
        assert!(cited >= 10, "only {cited} equations are cited");
    }

    /// The table at the page's end: equations, files under `model-core/src`, tests.
    #[test]
    fn the_files_and_tests_that_the_page_names_exist() {
        let source = std::fs::read_to_string(paths::root().join(SOURCE)).expect("the source");
        let (_, table) = source.split_once("## What holds what").expect("the table");
        let (core, texts) = (paths::root().join("model-core/src"), texts());
        let mut tests = 0;
        for row in table.lines().filter(|line| line.starts_with("| (")) {
            let [_, _, files, held, _] = row.split('|').collect::<Vec<_>>()[..] else { panic!("{row}") };
            let named = |cell: &str| cell.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
            for file in named(files) {
                assert!(core.join(&file).exists(), "{file} is not in model-core/src: {row}");
            }
            for test in named(held).iter().filter(|name| name.chars().all(|c| c == '_' || c.is_alphanumeric())) {
                let definition = format!("fn {test}(");
                assert!(texts.iter().any(|(_, text)| text.contains(&definition)), "there is no test {test}: {row}");
                tests += 1;
            }
        }
        assert!(tests >= 15, "only {tests} tests are named");
    }

    #[test]
    fn a_formula_becomes_mathml_and_keeps_its_number() {
        let page = rendered("Let $a_i$ be\n\n```math\n\\frac{a}{b} \\tag{1}\n```\n\n| $b*c$ |\n").expect("good LaTeX");
        assert!(page.contains("<msub><mi>a</mi><mi>i</mi></msub>"), "{page}");
        assert!(page.contains("id=\"eq-1\"") && page.contains("<mfrac>") && page.contains("(1)</div>"), "{page}");
    }

    #[test]
    fn what_cannot_be_shown_is_refused_with_its_line() {
        for (text, what) in [
            ("\n$\\nonsense$\n", "line 2"),
            ("$a\\,b$\n", "escaped"),
            ("$$a$$\n", "fences"),
            ("```math\na \\tag{2}\n```\n", "no formula (1)"),
            ("```math\na\n```\n", "\\tag{NUMBER}"),
            ("```math\na \\tag{1}\n```\n\n```math\nb \\tag{1}\n```\n", "line 5: there are two formulas (1)"),
        ] {
            let error = format!("{:#}", rendered(text).expect_err("must be refused"));
            assert!(error.contains(what), "{text}: {error}");
        }
    }
}
