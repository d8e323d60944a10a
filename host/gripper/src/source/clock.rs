//! A source's clock in this PC's: sources count µs since their start, files and other programs want the time of day.

use std::time::{SystemTime, UNIX_EPOCH};

/// Times farther ahead of this PC's clock than this are a new beginning, µs.
const LEAP_US: u64 = 2_000_000;

/// Converts the times of one source. They stay as evenly spaced as the source says, even if its messages come in bursts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock {
    anchor: Option<Anchor>,
}

/// Where the source's clock is in this PC's.
#[derive(Clone, Copy, Debug)]
struct Anchor {
    /// ns since 1970 at the source's time 0.
    zero_ns: i128,
    last_us: u64,
}

impl Anchor {
    fn at(&self, time_us: u64) -> i128 {
        self.zero_ns + i128::from(time_us) * 1000
    }
}

impl Clock {
    /// A time of the source, as ns since 1970.
    pub fn ns(&mut self, time_us: u64) -> u64 {
        let now = i128::from(now_ns());
        let anchor = match self.anchor {
            // Well behind the newest time: the source has started anew. Far ahead: its clock was set.
            Some(anchor)
                if time_us + LEAP_US >= anchor.last_us && anchor.at(time_us) <= now + i128::from(LEAP_US) * 1000 =>
            {
                Anchor { last_us: anchor.last_us.max(time_us), ..anchor }
            }
            _ => Anchor { zero_ns: now - i128::from(time_us) * 1000, last_us: time_us },
        };
        self.anchor = Some(anchor);
        u64::try_from(anchor.at(time_us)).unwrap_or(0)
    }

    /// The newest time of the source, as ns since 1970; now, if it has reported none.
    pub fn last_ns(&self) -> u64 {
        let at = |anchor: &Anchor| u64::try_from(anchor.at(anchor.last_us)).ok();
        self.anchor.as_ref().and_then(at).unwrap_or_else(now_ns)
    }
}

/// Now, ns since 1970.
pub fn now_ns() -> u64 {
    // A clock before 1970 or after 2554 is not set.
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| u64::try_from(since.as_nanos()).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_stay_evenly_spaced_and_a_new_start_is_now() {
        let mut clock = Clock::default();
        let first = clock.ns(5_000_000);
        assert!(now_ns().abs_diff(first) < 1_000_000_000);
        assert_eq!(clock.ns(5_002_000), first + 2_000_000);
        // A report that was overtaken by a later one.
        assert_eq!(clock.ns(5_001_000), first + 1_000_000);
        assert_eq!(clock.last_ns(), first + 2_000_000);
        // It has started anew: not 5 s before the first one.
        let anew = clock.ns(1000);
        assert!(anew >= first && now_ns().abs_diff(anew) < 1_000_000_000);
        // An hour ahead cannot be.
        assert!(clock.ns(3_600_000_000).abs_diff(now_ns()) < 1_000_000_000);
    }
}
