//! Which of many reports is on a screen: a view shows far fewer than come.

use messages::Report;

/// A trustworthy report this much older than the newest one still stands for it, µs: a single tick in which no position came
/// does not make the screen flicker, a silence shows at once.
const STANDS_US: u64 = 60_000;
/// Untrustworthy reports are counted over this time, µs.
const COUNTED_US: u64 = 1_000_000;

/// A finger's report to show.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shown {
    newest: Option<Report>,
    trustworthy: Option<Report>,
    /// When the time of counting began, and the counts in it: all reports, untrustworthy ones.
    since_us: u64,
    counting: [u32; 2],
    counted: [u32; 2],
}

impl Shown {
    /// Takes the next report; true if the gripper's time has begun anew.
    pub fn take(&mut self, report: Report) -> bool {
        let anew = self.newest.is_some_and(|newest| report.time_us < newest.time_us);
        if anew || self.newest.is_none() {
            *self = Self { since_us: report.time_us, ..Self::default() };
        }
        if report.time_us - self.since_us >= COUNTED_US {
            self.counted = std::mem::take(&mut self.counting);
            self.since_us = report.time_us;
        }
        let trustworthy = report.estimate.status.is_trustworthy();
        self.counting[0] += 1;
        self.counting[1] += u32::from(!trustworthy);
        self.newest = Some(report);
        if trustworthy {
            self.trustworthy = Some(report);
        }
        anew
    }

    /// The newest report that may be used if it is of just now, otherwise the newest one.
    pub fn report(&self) -> Option<Report> {
        let newest = self.newest?;
        self.trustworthy.filter(|report| newest.time_us - report.time_us <= STANDS_US).or(Some(newest))
    }

    /// Untrustworthy reports of the last second, percent.
    pub fn untrustworthy_percent(&self) -> f64 {
        let [all, bad] = if self.counted[0] > 0 { self.counted } else { self.counting };
        100.0 * f64::from(bad) / f64::from(all.max(1))
    }
}

#[cfg(test)]
mod tests {
    use messages::Phase;
    use model_core::estimator::Estimate;
    use model_core::status::Status;

    use super::*;

    fn report(tick: u64, status: Status) -> Report {
        Report {
            sequence: tick as u32,
            finger: 0,
            phase: Phase::Moving,
            time_us: 2000 * tick,
            estimate: Estimate::blank(status),
            goal: 0.0,
            position: 0,
            current: 0.0,
            cost: 0,
        }
    }

    #[test]
    fn a_silent_tick_does_not_show_and_a_silence_does() {
        let mut shown = Shown::default();
        assert!(shown.report().is_none());
        for tick in 0..1000 {
            shown.take(report(tick, if tick % 4 == 3 { Status::Stale } else { Status::Converged }));
        }
        assert_eq!(shown.report().unwrap().sequence, 998);
        assert!((shown.untrustworthy_percent() - 25.0).abs() < 1.0);
        for tick in 1000..1031 {
            shown.take(report(tick, Status::Stale));
        }
        let last = shown.report().unwrap();
        assert_eq!((last.sequence, last.estimate.status), (1030, Status::Stale));
        assert!(shown.take(report(5, Status::Converged)), "it has started anew");
        assert_eq!(shown.report().unwrap().sequence, 5);
    }
}
