//! How many ticks a second are reached.

/// Length of the meter's window.
const SECOND_US: u64 = 1_000_000;
/// Part of the rate below which it counts as missed.
const MISSED: f32 = 0.95;
/// Part of the rate above which it counts as kept again.
const KEPT: f32 = 0.98;

/// Measures the rate that is reached, second by second.
#[derive(Clone, Copy, Debug)]
pub struct Meter {
    since_us: u64,
    ticks: u32,
    missed: bool,
}

/// A full second's result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Second {
    /// Ticks per second.
    pub hz: f32,
    /// Whether the loop began to miss its rate, or to keep it again.
    pub turned: bool,
}

impl Meter {
    /// A meter that starts now.
    pub const fn new(now_us: u64) -> Self {
        Self { since_us: now_us, ticks: 0, missed: false }
    }

    /// A tick; gives the rate when a second is over.
    pub fn tick(&mut self, now_us: u64, chosen_hz: f32) -> Option<Second> {
        self.ticks = self.ticks.wrapping_add(1);
        let elapsed = now_us.saturating_sub(self.since_us);
        if elapsed < SECOND_US {
            return None;
        }
        let hz = self.ticks as f32 * (SECOND_US as f32 / elapsed as f32);
        let missed = hz < chosen_hz * if self.missed { KEPT } else { MISSED };
        let turned = missed != self.missed;
        *self = Self { since_us: now_us, ticks: 0, missed };
        Some(Second { hz, turned })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_meter_tells_when_the_rate_is_missed() {
        let mut meter = Meter::new(0);
        let mut now = 0;
        let mut seconds = Vec::new();
        for period in [2_000, 2_000, 2_500, 2_500, 2_000] {
            loop {
                now += period;
                if let Some(second) = meter.tick(now, 500.0) {
                    seconds.push(second);
                    break;
                }
            }
        }
        let turned: Vec<_> = seconds.iter().map(|second| second.turned).collect();
        assert_eq!(turned, [false, false, true, false, true]);
        assert!((seconds[0].hz - 500.0).abs() < 0.1 && (seconds[2].hz - 400.0).abs() < 0.1);
    }
}
