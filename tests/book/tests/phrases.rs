//! No text that people read has a phrase of `phrases.toml`.

use std::collections::BTreeMap;

use book::prose::everything;
use regex::{Regex, RegexBuilder};

struct Phrase {
    pattern: Regex,
    unless: Option<Regex>,
    write: String,
}

fn phrases() -> Vec<Phrase> {
    let list: toml::Table = include_str!("../phrases.toml").parse().expect("TOML");
    let regex = |text: &str| RegexBuilder::new(text).case_insensitive(true).build().expect("a regular expression");
    let text = |phrase: &toml::Value, key: &str| phrase.get(key).and_then(|value| value.as_str()).map(str::to_owned);
    let phrase = |phrase: &toml::Value| Phrase {
        pattern: regex(&text(phrase, "pattern").expect("a pattern")),
        unless: text(phrase, "unless").map(|unless| regex(&unless)),
        write: text(phrase, "write").expect("what to write"),
    };
    list["phrase"].as_array().expect("a list").iter().map(phrase).collect()
}

/// Where a phrase is in a text; none where it is good English.
fn found(phrase: &Phrase, text: &str) -> Option<String> {
    let good = |at: std::ops::Range<usize>| {
        let around = phrase.unless.iter().flat_map(|unless| unless.find_iter(text));
        around.into_iter().any(|whole| whole.start() <= at.start && at.start < whole.end())
    };
    let at = phrase.pattern.find_iter(text).map(|one| one.range()).find(|at| !good(at.clone()))?;
    let start = text[..at.start].char_indices().rev().nth(40).map_or(0, |(start, _)| start);
    let end = text[at.end..].char_indices().nth(40).map_or(text.len(), |(end, _)| at.end + end);
    Some(text[start..end].to_owned())
}

#[test]
fn no_text_has_a_phrase_to_avoid() {
    let (phrases, prose) = (phrases(), everything());
    assert!(prose.len() > 5_000, "only {} pieces of text were found", prose.len());
    let mut hits: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for piece in &prose {
        for phrase in &phrases {
            if let Some(words) = found(phrase, &piece.text) {
                hits.entry(&phrase.write).or_default().push(format!("  {}:{}: …{words}…", piece.path, piece.line));
            }
        }
    }
    let count: usize = hits.values().map(Vec::len).sum();
    let list: Vec<String> = hits.iter().map(|(write, at)| format!("{write}\n{}", at.join("\n"))).collect();
    assert!(hits.is_empty(), "{count} phrases to avoid; write instead:\n\n{}", list.join("\n\n"));
}

#[test]
fn phrases_are_found_and_good_english_is_not() {
    let phrases = phrases();
    let any = |text: &str| phrases.iter().any(|phrase| found(phrase, text).is_some());
    for bad in [
        "What cannot be written is told.",
        "The status tells that it failed.",
        "no leave to open it",
        "this is no stop",
        "The finger stands open.",
        "the servo is led by",
        "a dear tick",
        "Does no servo answer, run it.",
    ] {
        assert!(any(bad), "{bad}");
    }
    for good in [
        "There is no force.",
        "It is no longer open.",
        "λ stands for the multiplier.",
        "The LED flashes.",
        "You cannot tell them apart.",
        "Leave it as it is.",
        "the standard deviation",
        "Do the same in Python.",
    ] {
        assert!(!any(good), "{good}");
    }
}
