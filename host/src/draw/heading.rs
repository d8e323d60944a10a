//! What stands above every picture: title, conditions, legend.

use super::font::Fonts;
use super::palette::Ink;
use super::scene::{Path, Scene, Stroke, Text};

pub(crate) const TEXT: f64 = 13.0;
pub(crate) const MARGIN: f64 = 14.0;
/// Length of a legend's sample, px.
const SAMPLE: f64 = 26.0;
/// A viewer's own font may be wider than the one measured here.
const OTHER_FONT: f64 = 1.1;

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
}

/// Draws title, conditions and legend; returns the height they take up.
pub(crate) fn draw(scene: &mut Scene, fonts: &Fonts, [title, subtitle]: [&str; 2], legend: &[(&str, Sample)]) -> f64 {
    let mut y = MARGIN + 12.0;
    scene.text(Text::new([MARGIN, y], 16.0, title).bold());
    if !subtitle.is_empty() {
        y += 19.0;
        scene.text(Text::new([MARGIN, y], TEXT, subtitle).ink(Ink::Muted));
    }
    let mut x = MARGIN;
    if !legend.is_empty() {
        y += 24.0;
    }
    for &(words, sample) in legend {
        let text = Text::new([0.0, 0.0], TEXT, words);
        let width = SAMPLE + 8.0 + OTHER_FONT * fonts.width(&text);
        if x > MARGIN && x + width > scene.width - MARGIN {
            (x, y) = (MARGIN, y + 19.0);
        }
        let middle = y - 0.34 * TEXT;
        let line = || Path::lines([[x, middle], [x + SAMPLE, middle]]);
        match sample {
            Sample::Line(stroke) => scene.line(line(), stroke),
            Sample::LineAndDots(stroke) => {
                scene.line(line(), stroke);
                scene.fill(Path::circle([x + 0.5 * SAMPLE, middle], 3.0), stroke.ink, 1.0);
            }
            Sample::Dot(ink) => scene.fill(Path::circle([x + 0.5 * SAMPLE, middle], 3.0), ink, 1.0),
            Sample::Arrow(ink, width) => scene.arrow([x, middle], [x + SAMPLE, middle], ink, width),
        }
        scene.text(Text { at: [x + SAMPLE + 8.0, y], ..text });
        x += width + 16.0;
    }
    y + 18.0
}
