//! A source's clock in this PC's: sources count µs since their start, files and other programs want the time of day.

use std::time::{SystemTime, UNIX_EPOCH};

/// A source's time that is farther than this behind its newest one is a new beginning, and one that far from this PC's clock an error of
/// the clock's place, µs.
const LEAP_US: u64 = 2_000_000;
/// The same, ns.
const LEAP_NS: i128 = LEAP_US as i128 * 1000;
/// How long times have to stay behind this PC's clock to be an error, ns: a message that comes late is behind, too.
const LATE_NS: i128 = 5_000_000_000;
/// Half of the time over which the least delay is sought, µs.
const HALF_US: u64 = 30_000_000;
/// The source's clock is moved by at most one part in this many.
const SLEW: i128 = 100;

/// Converts the times of one source. They stay as evenly spaced as the source says (within 1 %), even if its messages come in bursts, and
/// follow this PC's clock, which may be set meanwhile.
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
    /// The least that such a zero has seemed to be, by the messages of this half minute and of the one before: they came with the least delay.
    least_ns: [i128; 2],
    /// The source's time at which this half minute began.
    half_us: u64,
    late: Option<Late>,
}

/// Messages whose times are far behind this PC's clock.
#[derive(Clone, Copy, Debug)]
struct Late {
    /// When the first one came, ns since 1970.
    since_ns: i128,
    /// The least that the zero has seemed to be since.
    least_ns: i128,
}

impl Anchor {
    fn new(zero_ns: i128, last_us: u64) -> Self {
        Self { zero_ns, last_us, least_ns: [zero_ns; 2], half_us: last_us, late: None }
    }

    fn at(&self, time_us: u64) -> i128 {
        self.zero_ns + i128::from(time_us) * 1000
    }

    /// The same after a message of this time, which has come now.
    fn after(mut self, time_us: u64, now_ns: i128) -> Self {
        let seems_ns = now_ns - i128::from(time_us) * 1000;
        let behind_ns = seems_ns - self.zero_ns;
        // Well behind the newest time: the source has started anew. Far ahead: a clock was set.
        if time_us.saturating_add(LEAP_US) < self.last_us || behind_ns < -LEAP_NS {
            return Self::new(seems_ns, time_us);
        }
        self.late = (behind_ns > LEAP_NS).then(|| {
            let Late { since_ns, least_ns } = self.late.unwrap_or(Late { since_ns: now_ns, least_ns: seems_ns });
            Late { since_ns, least_ns: least_ns.min(seems_ns) }
        });
        if let Some(late) = self.late.filter(|late| now_ns - late.since_ns >= LATE_NS) {
            return Self::new(late.least_ns, self.last_us.max(time_us));
        }
        if time_us.saturating_sub(self.half_us) >= HALF_US {
            let [this, _] = self.least_ns;
            (self.least_ns, self.half_us) = ([seems_ns, this], time_us);
        }
        let [this, before] = self.least_ns;
        self.least_ns = [this.min(seems_ns), before];
        let passed_ns = i128::from(time_us.saturating_sub(self.last_us)) * 1000;
        let wanted_ns = this.min(seems_ns).min(before);
        self.zero_ns += (wanted_ns - self.zero_ns).clamp(-passed_ns / SLEW, passed_ns / SLEW);
        self.last_us = self.last_us.max(time_us);
        self
    }
}

impl Clock {
    /// A time of the source whose message comes now, as ns since 1970.
    pub fn ns(&mut self, time_us: u64) -> u64 {
        self.ns_at(time_us, now_ns())
    }

    fn ns_at(&mut self, time_us: u64, now_ns: u64) -> u64 {
        let now_ns = i128::from(now_ns);
        let anchor = match self.anchor {
            Some(anchor) => anchor.after(time_us, now_ns),
            None => Anchor::new(now_ns - i128::from(time_us) * 1000, time_us),
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

    const MS: u64 = 1_000_000;
    const S: u64 = 1000 * MS;
    /// Some time of day, ns since 1970.
    const DAY: u64 = 1_700_000_000 * S;
    const TICK_US: u64 = 2000;

    /// A source at 500 Hz beside this PC's clock.
    struct Bench {
        clock: Clock,
        time_us: u64,
        now_ns: u64,
        /// ns that this PC's clock goes on in a tick.
        tick_ns: u64,
        last_ns: u64,
    }

    impl Bench {
        fn new() -> Self {
            Self { clock: Clock::default(), time_us: 5_000_000, now_ns: DAY, tick_ns: 1000 * TICK_US, last_ns: 0 }
        }

        /// Ticks whose messages have these delays in turn (ns): how far the last stamp is behind this PC's clock, ns. Every stamp is later than
        /// the one before, by a tick within 1 %, unless the clock may `leap`.
        fn run(&mut self, seconds: u64, delays: &[u64], leap: bool) -> i64 {
            for tick in 0..seconds * 500 {
                self.time_us += TICK_US;
                self.now_ns += self.tick_ns;
                let delay = delays[tick as usize % delays.len()];
                let ns = self.clock.ns_at(self.time_us, self.now_ns + delay);
                let step = ns.saturating_sub(self.last_ns);
                assert!(leap || self.last_ns == 0 || (1_980_000..=2_020_000).contains(&step), "{step} ns at {tick}");
                assert_eq!(self.clock.last_ns(), ns);
                self.last_ns = ns;
            }
            self.behind()
        }

        fn behind(&self) -> i64 {
            self.now_ns as i64 - self.last_ns as i64
        }
    }

    #[test]
    fn times_stay_evenly_spaced_and_a_new_start_is_now() {
        let mut clock = Clock::default();
        let first = clock.ns_at(5_000_000, DAY);
        assert_eq!(first, DAY);
        assert_eq!(clock.ns_at(5_002_000, DAY + 2 * MS), first + 2 * MS);
        // A report that was overtaken by a later one.
        assert_eq!(clock.ns_at(5_001_000, DAY + 2 * MS), first + MS);
        assert_eq!(clock.last_ns(), first + 2 * MS);
        // It has started anew: not 5 s before the first one.
        assert_eq!(clock.ns_at(1000, DAY + S), DAY + S);
        // An hour ahead cannot be; nor does any number that is reported do harm.
        assert_eq!(clock.ns_at(3_600_000_000, DAY + S), DAY + S);
        assert_eq!(clock.ns_at(u64::MAX, DAY + S), DAY + S);
        assert_eq!(clock.ns_at(1000, DAY + 2 * S), DAY + 2 * S);
        assert!(Clock::default().ns(7).abs_diff(now_ns()) < S);
    }

    #[test]
    fn bursts_and_late_messages_move_no_stamp() {
        let mut bench = Bench::new();
        // As USB delivers: eight reports at once, and the first one of all late.
        let bursts: Vec<u64> = (0..8).map(|tick| (7 - tick) * 2 * MS).collect();
        assert!(bench.run(120, &bursts, false).abs() < MS as i64, "{} ns behind", bench.behind());
        // A reader that was held up for 4 s.
        let steady = bench.behind();
        assert!((bench.run(4, &[4 * S], false) - steady).abs() < MS as i64);
        assert!((bench.run(60, &bursts, false) - steady).abs() < MS as i64);
    }

    /// A crystal that goes wrong by 1 in 2000, either way, for an hour.
    #[test]
    fn a_clock_that_goes_wrong_is_followed() {
        for tick_ns in [1_999_000, 2_001_000] {
            let mut bench = Bench { tick_ns, ..Bench::new() };
            let behind = bench.run(3600, &[0, MS], false);
            // What the clock loses in a minute.
            assert!(behind.abs() < 60 * MS as i64 / 2 + MS as i64, "{behind} ns");
        }
    }

    #[test]
    fn a_clock_that_is_set_is_followed() {
        let mut bench = Bench::new();
        bench.run(10, &[0], false);
        // A little: without a leap, and no stamp before the one before.
        bench.now_ns += S;
        bench.run(200, &[0], false);
        assert!(bench.behind().abs() < MS as i64, "{} ns behind", bench.behind());
        bench.now_ns -= S;
        assert!(bench.run(120, &[0], false).abs() < MS as i64, "{} ns behind", bench.behind());
        // A PC without a clock of its own gets the time half a year later from the network.
        bench.now_ns += 180 * 86_400 * S;
        bench.run(4, &[0], false);
        assert!(bench.behind() as u64 > 179 * 86_400 * S, "not before it is sure");
        assert!(bench.run(2, &[0], true).abs() < MS as i64, "{} ns behind", bench.behind());
        assert!(bench.run(60, &[0, MS], false).abs() < MS as i64, "{} ns behind", bench.behind());
        // Ahead of its time no message can come.
        bench.now_ns -= 180 * 86_400 * S;
        assert!(bench.run(1, &[0], true).abs() < MS as i64, "{} ns behind", bench.behind());
    }
}
