//! How many ticks a second: what the bus allows, and what is reached.

use dynamixel::{packet_length, status_length};

/// Bytes on the bus in a tick of one servo: Goal Position written and answered, ten bytes read.
const ALONE: usize = packet_length(2 + 4) + status_length(0) + packet_length(4) + status_length(10);

/// Bytes on the bus in a tick, and answers, each after the servo's return delay. Several servos get their goals by one
/// Sync Write, which nobody answers, and are read by one Sync Read.
fn traffic(fingers: usize) -> (usize, usize) {
    match fingers {
        0 | 1 => (ALONE, 2),
        _ => (packet_length(4 + 5 * fingers) + packet_length(4 + fingers) + fingers * status_length(10), fingers),
    }
}

/// Periods are multiples of this.
const STEP_US: u64 = 100;
/// Length of the meter's window.
const SECOND_US: u64 = 1_000_000;
/// Part of the rate below which it counts as missed.
const MISSED: f32 = 0.95;
/// Part of the rate above which it counts as kept again.
const KEPT: f32 = 0.98;

/// Period of the control loop, µs: the one wanted, or what the bus needs for a tick of so many fingers and a tenth of that.
pub fn period_us(wanted_hz: u16, baud: u32, return_delay_us: u32, fingers: usize) -> u64 {
    let (bytes, answers) = traffic(fingers);
    let wire = (bytes as u64 * 10 * SECOND_US).div_ceil(u64::from(baud.max(1)));
    let needed = (wire + answers as u64 * u64::from(return_delay_us)) * 11 / 10;
    let wanted = SECOND_US / u64::from(wanted_hz.max(1));
    if needed <= wanted { wanted } else { needed.div_ceil(STEP_US) * STEP_US }
}

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
    fn a_fast_bus_gives_the_rate_wanted() {
        assert_eq!(traffic(1), (16 + 11 + 14 + 21, 2));
        assert_eq!(traffic(4), (34 + 18 + 4 * 21, 4));
        assert_eq!(period_us(500, 1_000_000, 0, 1), 2_000);
        assert_eq!(period_us(500, 4_500_000, 500, 1), 2_000);
    }

    #[test]
    fn a_slow_bus_gives_less() {
        // 62 bytes take 10.8 ms at the factory's rate.
        assert_eq!(period_us(500, 57_600, 0, 1), 11_900);
        assert_eq!(period_us(500, 115_200, 0, 1), 6_000);
        assert_eq!(period_us(50, 57_600, 0, 1), 20_000);
        // The factory's return delay alone takes half of the period.
        assert_eq!(period_us(1000, 1_000_000, 500, 1), 1_800);
    }

    #[test]
    fn four_fingers_fit_a_fast_bus() {
        // 136 bytes: 1.36 ms at 1 Mbaud.
        assert_eq!(period_us(500, 1_000_000, 0, 4), 2_000);
        assert_eq!(period_us(1000, 1_000_000, 0, 4), 1_500);
        assert_eq!(period_us(1000, 2_000_000, 0, 4), 1_000);
    }

    #[test]
    fn nothing_divides_by_zero() {
        assert!(period_us(0, 0, u32::MAX, 1) > 0);
    }

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
