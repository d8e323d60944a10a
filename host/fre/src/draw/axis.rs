//! Ranges and round tick values of a chart's axes.

/// A range of values with the ticks in it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scale {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) ticks: Vec<f64>,
    decimals: usize,
}

impl Scale {
    /// Covers the values; about `count` ticks. With `round` the range is widened to the next ticks.
    pub(super) fn covering(low: f64, high: f64, count: f64, round: bool) -> Self {
        let (mut low, mut high) = if low.is_finite() && high.is_finite() { (low, high) } else { (0.0, 1.0) };
        // A range below the resolution of its own values has no ticks.
        let least = 1e-9 * low.abs().max(high.abs()).max(1e-3);
        if high - low < least {
            let half = (0.05 * high.abs()).max(0.5 * least).max(1e-6);
            (low, high) = (low - half, high + half);
        }
        let step = round_step((high - low) / count.max(1.0));
        if round {
            // Values a hair beyond a tick do not cost a whole step.
            low = (low / step + 0.03).floor() * step;
            high = (high / step - 0.03).ceil() * step;
        }
        let (first, last) = ((low / step - 1e-6).ceil() as i64, (high / step + 1e-6).floor() as i64);
        // Zero is written as 0, not as −0.
        let ticks = (first..=last).map(|i| if i == 0 { 0.0 } else { i as f64 * step }).collect();
        let decimals = (-(step.log10() + 1e-9).floor()).clamp(0.0, 12.0) as usize;
        Self { low, high, ticks, decimals }
    }

    /// A tick's words, with a true minus sign.
    pub(super) fn words(&self, tick: f64) -> String {
        // Beyond seven digits a power of ten reads better.
        let most = self.low.abs().max(self.high.abs());
        let words = if most >= 1e7 || self.decimals > 6 {
            let text = format!("{tick:.3e}");
            match text.split_once('e') {
                Some((digits, "0")) => digits.trim_end_matches('0').trim_end_matches('.').to_owned(),
                Some((digits, power)) => format!("{}e{power}", digits.trim_end_matches('0').trim_end_matches('.')),
                None => text,
            }
        } else {
            format!("{tick:.*}", self.decimals)
        };
        words.replace('-', "−")
    }

    /// Where a value lies, 0 at the low end and 1 at the high end.
    pub(super) fn part(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }
}

/// The smallest of 1, 2, 5 times a power of ten that is not less.
fn round_step(least: f64) -> f64 {
    let power = 10_f64.powf(least.log10().floor());
    let factor = [1.0, 2.0, 5.0, 10.0].into_iter().find(|factor| factor * power >= least * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

#[cfg(test)]
mod tests {
    use super::Scale;

    #[test]
    fn ticks_are_round_and_inside() {
        let scale = Scale::covering(0.0, 11.0, 6.0, false);
        assert_eq!(scale.ticks, [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        let scale = Scale::covering(-0.031, 0.052, 5.0, true);
        assert_eq!(
            scale.ticks.iter().map(|&t| scale.words(t)).collect::<Vec<_>>(),
            ["−0.04", "−0.02", "0.00", "0.02", "0.04", "0.06"]
        );
        assert_eq!((scale.part(-0.04), scale.part(0.06)), (0.0, 1.0));
    }

    #[test]
    fn very_large_and_small_ticks_are_short() {
        let words = |low, high| {
            let scale = Scale::covering(low, high, 2.0, true);
            scale.ticks.iter().map(|&tick| scale.words(tick)).collect::<Vec<_>>()
        };
        assert_eq!(words(-1e300, 1e300), ["−1e300", "0", "1e300"]);
        assert_eq!(words(0.0, 4e-8), ["0", "2e−8", "4e−8"]);
    }

    #[test]
    fn ranges_without_extent_still_have_one() {
        for value in [0.0, 3.0, -1e9, 1e-12] {
            let scale = Scale::covering(value, value, 5.0, true);
            assert!(scale.low < value && value < scale.high && scale.ticks.len() >= 2, "{scale:?}");
        }
        assert!(Scale::covering(f64::NAN, f64::INFINITY, 5.0, true).high.is_finite());
    }
}
