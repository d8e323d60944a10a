//! How many ticks a second the bus allows.

use dynamixel::{packet_length, status_length};

/// Bytes on the bus in a tick of one servo: Goal Position written and answered, ten bytes read.
const ALONE: usize = packet_length(2 + 4) + status_length(0) + packet_length(4) + status_length(10);

/// Bytes on the bus in a tick, and answers, each after the servo's return delay. Several servos of one control table get their goals by
/// one Sync Write, which nobody answers, and are read by one Sync Read; those of several tables are asked one by one.
fn traffic(fingers: usize, is_alike: bool) -> (usize, usize) {
    match fingers.max(1) {
        fingers if fingers == 1 || !is_alike => (fingers * ALONE, 2 * fingers),
        fingers => (packet_length(4 + 5 * fingers) + packet_length(4 + fingers) + fingers * status_length(10), fingers),
    }
}

/// Periods are multiples of this.
const STEP_US: u64 = 100;
const SECOND_US: u64 = 1_000_000;

/// Period of the control loop, µs: the one wanted, or what the bus needs for a tick of so many fingers, whose servos have one control table,
/// and a tenth of that.
pub fn period_us(wanted_hz: u16, baud: u32, return_delay_us: u32, fingers: usize) -> u64 {
    period_of(wanted_hz, baud, return_delay_us, traffic(fingers, true))
}

/// The same where they do not have one.
pub(crate) fn period_apart_us(wanted_hz: u16, baud: u32, return_delay_us: u32, fingers: usize) -> u64 {
    period_of(wanted_hz, baud, return_delay_us, traffic(fingers, false))
}

fn period_of(wanted_hz: u16, baud: u32, return_delay_us: u32, (bytes, answers): (usize, usize)) -> u64 {
    let wire = (bytes as u64 * 10 * SECOND_US).div_ceil(u64::from(baud.max(1)));
    let needed = (wire + answers as u64 * u64::from(return_delay_us)) * 11 / 10;
    let wanted = SECOND_US / u64::from(wanted_hz.max(1));
    if needed <= wanted { wanted } else { needed.div_ceil(STEP_US) * STEP_US }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fast_bus_gives_the_rate_wanted() {
        assert_eq!(traffic(1, true), (16 + 11 + 14 + 21, 2));
        assert_eq!(traffic(4, true), (34 + 18 + 4 * 21, 4));
        assert_eq!(traffic(4, false), (4 * (16 + 11 + 14 + 21), 8));
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
}
