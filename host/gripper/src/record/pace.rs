//! How fast a recording is gone through.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How often one who waits looks whether he is still wanted.
const GLANCE: Duration = Duration::from_millis(20);
/// The longest pause of a recording that is kept: the recorder's clock may have been set, by months.
const LONGEST: Duration = Duration::from_secs(10);
/// The longest pause of a recording that is played: [`LONGEST`] at the lowest speed.
const SLOWEST: Duration = Duration::from_secs(10_000_000);

/// How fast a recording is played.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// So many times as fast as it was recorded.
    Times(f64),
    /// As fast as whoever listens takes it.
    AtOnce,
}

impl Speed {
    /// Which factors [`Self::times`] takes, in words.
    pub const ALLOWED: &str = "1e-6 to 1e6";

    /// So many times as fast as it was recorded, 1e-6 to 1e6; `None` outside.
    pub fn times(times: f64) -> Option<Self> {
        (1e-6..=1e6).contains(&times).then_some(Self::Times(times))
    }
}

/// When a recording's messages are due; the first one is at once.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    speed: Speed,
    /// Time of the last message, ns, and when it was due.
    last: Option<(u64, Instant)>,
}

impl Pace {
    /// Before the first message.
    pub fn new(speed: Speed) -> Self {
        Self { speed, last: None }
    }

    /// Waits until a message of this time (ns) is due, or `stop`. A pause of more than 10 s is one of 10 s.
    pub fn wait(&mut self, ns: u64, stop: &AtomicBool) {
        let Speed::Times(times) = self.speed else { return };
        let (before, due) = self.last.unwrap_or_else(|| (ns, Instant::now()));
        let pause = Duration::from_nanos(ns.saturating_sub(before)).min(LONGEST);
        // Outside of `Speed::times` the quotient may be no duration, and the sum no instant.
        let pause =
            Duration::try_from_secs_f64(pause.as_secs_f64() / times).map_or(SLOWEST, |pause| pause.min(SLOWEST));
        let due = due.checked_add(pause).unwrap_or(due);
        self.last = Some((ns, due));
        while !stop.load(Ordering::Acquire) {
            match due.checked_duration_since(Instant::now()) {
                Some(early) if !early.is_zero() => std::thread::sleep(early.min(GLANCE)),
                _ => return,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_speed_has_a_pause() {
        let stop = AtomicBool::new(true);
        for times in [1e-300, 1e-21, 1e-6, -1.0, 0.0, f64::NAN, f64::INFINITY] {
            let mut pace = Pace::new(Speed::Times(times));
            (0..100).for_each(|pause| pace.wait(pause * 10_000_000_000, &stop));
        }
    }

    #[test]
    fn speeds_have_bounds() {
        assert_eq!([1e-6, 1.0, 1e6].map(Speed::times), [1e-6, 1.0, 1e6].map(|times| Some(Speed::Times(times))));
        assert_eq!([1e-21, 0.0, -1.0, 1e7, f64::NAN].map(Speed::times), [None; 5]);
    }

    #[test]
    fn a_clock_that_was_set_stops_no_recording() {
        const S: u64 = 1_000_000_000;
        let (mut pace, stop) = (Pace::new(Speed::Times(100.0)), AtomicBool::new(false));
        let start = Instant::now();
        // A second, half a year on, a second, half a year back, a second.
        let times = [0, 1, 16_000_000, 16_000_001, 2, 3];
        times.into_iter().for_each(|seconds| pace.wait(seconds * S, &stop));
        let took = start.elapsed();
        assert!(took >= Duration::from_millis(130), "{took:?}");
        assert!(took < Duration::from_secs(20), "{took:?}");
    }
}
