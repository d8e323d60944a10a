//! What shows the scales of lengths and forces, below the finger.

use super::picture::{NetForce, View};
use super::view::FOOT;
use crate::draw::heading::TEXT;
use crate::draw::number::short;
use crate::draw::palette::Ink;
use crate::draw::path::Path;
use crate::draw::scene::{Anchor, Scene, Stroke, Text};

impl View {
    /// Draws the bar below the finger, with its length.
    pub(super) fn scale_bar(&self, scene: &mut Scene) {
        let round = round_below(110.0 / self.scale);
        let (left, y) = (self.area.left + 20.0, self.area.bottom + 0.5 * FOOT);
        let right = left + self.scale * round;
        scene.line(Path::lines([[left, y], [right, y]]), Stroke::new(Ink::Main, 2.0));
        for x in [left, right] {
            scene.line(Path::lines([[x, y - 4.0], [x, y + 4.0]]), Stroke::new(Ink::Main, 2.0));
        }
        let words = format!("{} mm", round_words(round));
        scene.text(Text::new([0.5 * (left + right), y + 1.4 * TEXT], TEXT, words).anchor(Anchor::Middle));
    }

    /// Draws an arrow of a round force, with that force.
    pub(super) fn force_scale(&self, scene: &mut Scene, net: NetForce) {
        let scale = net.scale;
        let round = round_below(80.0 / scale);
        let length = scale * round;
        let right = self.area.right - 20.0;
        let y = self.area.bottom + 0.5 * FOOT;
        scene.arrow([right - length, y], [right, y], Ink::Force, 2.6);
        let words = format!("{} N", round_words(round));
        scene.text(Text::new([right - 0.5 * length, y + 1.4 * TEXT], TEXT, words).anchor(Anchor::Middle));
    }
}

/// The largest of 1, 2, 5 times a power of ten that is not more.
fn round_below(most: f64) -> f64 {
    let power = 10_f64.powf(most.max(f64::MIN_POSITIVE).log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|factor| factor * power).find(|&value| value <= most).unwrap_or(power)
}

/// A value of [`round_below`] in words.
fn round_words(round: f64) -> String {
    // Beyond four decimals a power of ten reads better.
    if round >= 1e-4 { short(round, 4) } else { format!("{round:.0e}").replace('-', "−") }
}

#[cfg(test)]
mod tests {
    use super::{round_below, round_words};

    #[test]
    fn lengths_are_round() {
        let scales = [70.0, 3.0, 0.012, 4e-4, 1.1e-5, 6e-12].map(|most| round_words(round_below(most)));
        assert_eq!(scales, ["50", "2", "0.01", "0.0002", "1e−5", "5e−12"]);
    }
}
