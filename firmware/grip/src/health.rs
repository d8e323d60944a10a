//! Whether the servo is there: an answer that is lost is noise, none for a while is a servo that is gone.

/// Time without an answer after which the servo counts as gone, s.
const LOST_AFTER: f32 = 0.3;
/// ... and answers in a row that are missing, for slow loops.
const FAILURES: u8 = 3;

/// The bus as the last transactions showed it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Health {
    /// No servo: it has to be looked for and set up.
    Absent,
    /// The servo answers, but for what was missing just now.
    Present {
        /// Failures since the last answer; 255 stands for more.
        failures: u8,
        /// Time that they have taken, s.
        silent: f32,
    },
}

impl Health {
    /// The servo was found and set up.
    pub const READY: Self = Self::Present { failures: 0, silent: 0.0 };

    /// Whether there is a servo to talk to.
    pub fn is_present(self) -> bool {
        matches!(self, Self::Present { .. })
    }

    /// A whole answer came.
    pub fn answered(&mut self) {
        if self.is_present() {
            *self = Self::READY;
        }
    }

    /// No whole answer came in a tick of so many seconds; returns whether this lost the servo.
    pub fn failed(&mut self, seconds: f32) -> bool {
        let Self::Present { failures, silent } = self else { return false };
        *failures = failures.saturating_add(1);
        *silent += seconds;
        let is_lost = *failures >= FAILURES && *silent >= LOST_AFTER;
        if is_lost {
            *self = Self::Absent;
        }
        is_lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ticks without an answer that lose the servo, at so many a second.
    fn ticks(rate_hz: f32) -> u32 {
        let mut health = Health::READY;
        let lost = (1..=2_000).find(|_| health.failed(1.0 / rate_hz)).expect("lost at last");
        assert_eq!(health, Health::Absent);
        assert!(!health.failed(1.0), "once");
        health.answered();
        assert!(!health.is_present(), "an answer alone does not set the servo up");
        lost
    }

    #[test]
    fn a_servo_is_lost_by_time_at_every_rate() {
        for rate_hz in [20.0, 84.0, 500.0, 1000.0] {
            let seconds = ticks(rate_hz) as f32 / rate_hz;
            assert!((0.3..0.36).contains(&seconds), "{seconds} s at {rate_hz} Hz");
        }
        // A slow loop has lost an answer, not yet the servo.
        assert_eq!((ticks(1.0), ticks(5.0)), (3, 3));
    }

    #[test]
    fn failures_with_answers_between_them_do_not_lose_it() {
        let mut health = Health::READY;
        for _ in 0..1000 {
            for _ in 0..100 {
                assert!(!health.failed(0.002));
            }
            health.answered();
        }
        assert_eq!(health, Health::READY);
    }
}
