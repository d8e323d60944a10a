//! What is above every picture: title, conditions, legend.

use super::font::Fonts;
use super::palette::Ink;
use super::path::{Path, Rect};
use super::scene::{Scene, Stroke, Text, literal, sentences};

pub(crate) const TEXT: f64 = 13.0;
pub(crate) const MARGIN: f64 = 14.0;
/// Length of a legend's sample, px.
const SAMPLE: f64 = 22.0;
/// Between two entries of a legend, px; room as well for a viewer's own font that is wider than the one measured here.
const GAP: f64 = 12.0;

/// The sample of a legend's entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Sample {
    /// A line.
    Line(Stroke),
    /// A line with dots.
    LineAndDots(Stroke),
    /// A dot.
    Dot(Ink),
    /// An arrow of a width.
    Arrow(Ink, f64),
    /// A light area.
    Area(Ink),
}

/// Title and conditions for readers who cannot see the picture: without marks.
pub(super) fn described(title: &str, subtitle: &str) -> String {
    let subtitle: String = Text::new([0.0; 2], TEXT, subtitle).pieces().into_iter().map(|piece| piece.words).collect();
    sentences([title, &subtitle])
}

/// Draws title (no letter of it a mark), conditions and legend; returns the height they take up.
pub(crate) fn draw(scene: &mut Scene, fonts: &Fonts, [title, subtitle]: [&str; 2], legend: &[(&str, Sample)]) -> f64 {
    let mut y = MARGIN - 8.0;
    let width = scene.width - 2.0 * MARGIN;
    // Titles hold users' names: a star in them is a star.
    let title = Text::new([MARGIN, 0.0], 16.0, literal(title)).bold();
    for line in wrapped(fonts, &title, width) {
        y += 20.0;
        scene.text(Text { at: [MARGIN, y], words: line, ..title.clone() });
    }
    let subtitle = Text::new([MARGIN, 0.0], TEXT, subtitle).ink(Ink::Muted);
    for (index, line) in wrapped(fonts, &subtitle, width).into_iter().enumerate() {
        y += if index == 0 { 19.0 } else { 17.0 };
        scene.text(Text { at: [MARGIN, y], words: line, ..subtitle.clone() });
    }
    let mut x = MARGIN;
    if !legend.is_empty() {
        y += 24.0;
    }
    for &(words, sample) in legend {
        let text = Text::new([0.0, 0.0], TEXT, words);
        let width = SAMPLE + 8.0 + fonts.width(&text);
        if x > MARGIN && x + width > scene.width - MARGIN {
            (x, y) = (MARGIN, y + 19.0);
        }
        let middle = y - 0.34 * TEXT;
        let line = || Path::lines([[x, middle], [x + SAMPLE, middle]]);
        match sample {
            Sample::Line(stroke) => scene.line(line(), stroke),
            Sample::LineAndDots(stroke) => {
                scene.line(line(), stroke);
                scene.fill(Path::circle([x + 0.5 * SAMPLE, middle], (1.4 * stroke.width).max(3.0)), stroke.ink, 1.0);
            }
            Sample::Dot(ink) => scene.fill(Path::circle([x + 0.5 * SAMPLE, middle], 3.0), ink, 1.0),
            Sample::Area(ink) => {
                let area = Rect { left: x, right: x + SAMPLE, top: middle - 4.0, bottom: middle + 4.0 };
                scene.fill(Path::rectangle(area), ink, 0.25);
            }
            Sample::Arrow(ink, width) => scene.arrow([x, middle], [x + SAMPLE, middle], ink, width),
        }
        scene.text(Text { at: [x + SAMPLE + 8.0, y], ..text });
        x += width + GAP;
    }
    y + 18.0
}

/// The lines into which a text is broken at its blanks to fit a width (px); none of an empty text. A word that is wider than
/// a line is broken between letters; a marked passage stays whole.
fn wrapped(fonts: &Fonts, text: &Text, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.words.split_whitespace() {
        let parts = broken(fonts, text, word, width);
        if parts.len() > 1 && !lines.last().is_some_and(|line| within_mark(line)) {
            lines.extend(parts);
            continue;
        }
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match (lines.last_mut(), longer) {
            (Some(line), Some(longer))
                if within_mark(&longer) || fonts.width(&Text { words: longer.clone(), ..text.clone() }) <= width =>
            {
                *line = longer;
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// The parts of a word that fit a width (px), broken between letters; a word with marks is one part.
fn broken(fonts: &Fonts, text: &Text, word: &str, width: f64) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut letters = word.chars();
    while let Some(letter) = letters.next() {
        let mut one = String::from(letter);
        match letter {
            // With the letter that it makes literal.
            '\\' => one.extend(letters.next()),
            '*' => return vec![word.to_owned()],
            '_' if letters.as_str().starts_with('{') => return vec![word.to_owned()],
            _ => {}
        }
        let Some(part) = parts.last_mut() else { break };
        let longer = format!("{part}{one}");
        if part.is_empty() || fonts.width(&Text { words: longer.clone(), ..text.clone() }) <= width {
            *part = longer;
        } else {
            parts.push(one);
        }
    }
    parts
}

/// True if a passage in italics is begun and not ended.
fn within_mark(words: &str) -> bool {
    let mut letters = words.chars();
    let mut within = false;
    while let Some(letter) = letters.next() {
        match letter {
            // The next letter is itself.
            '\\' => drop(letters.next()),
            '*' => within = !within,
            _ => {}
        }
    }
    within
}

#[cfg(test)]
mod tests {
    use super::{Fonts, Text, literal, wrapped};

    #[test]
    fn lines_fit_their_width_and_lose_no_word() {
        let fonts = Fonts::new();
        let words = "*α* = 11°: bending and stretch, positive where drawn out; the material's limit is not known";
        let text = Text::new([0.0, 0.0], 13.0, words);
        let lines = wrapped(&fonts, &text, 200.0);
        assert!(lines.len() > 2, "{lines:?}");
        for line in &lines {
            assert!(fonts.width(&Text { words: line.clone(), ..text.clone() }) <= 200.0, "{line}");
        }
        assert_eq!(lines.join(" "), words);
        assert_eq!(wrapped(&fonts, &text, 1e4), [words]);
        assert!(wrapped(&fonts, &Text::new([0.0, 0.0], 13.0, ""), 200.0).is_empty());
    }

    #[test]
    fn a_word_wider_than_a_line_is_broken_between_letters() {
        let fonts = Fonts::new();
        let word = literal(&"x*_".repeat(60));
        let text = Text::new([0.0, 0.0], 13.0, format!("a {word} *α* b"));
        let lines = wrapped(&fonts, &text, 200.0);
        assert!(lines.len() > 3, "{lines:?}");
        for line in &lines {
            assert!(fonts.width(&Text { words: line.clone(), ..text.clone() }) <= 200.0, "{line}");
        }
        let letters = |lines: &[String]| lines.concat().replace(' ', "");
        assert_eq!(letters(&lines), letters(&[text.words]));
    }
}
