//! Whether the servo is there: one lost answer is noise, several in a row are a servo that is gone.

/// Failures in a row after which the servo counts as gone.
const LOST_AFTER: u8 = 3;

/// The bus as the last transactions showed it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Health {
    /// No servo: it has to be looked for and set up.
    Absent,
    /// The servo answers, but for so many failures just now.
    Present {
        /// Failures since the last answer.
        failures: u8,
    },
}

impl Health {
    /// The servo was found and set up.
    pub const READY: Self = Self::Present { failures: 0 };

    /// Whether there is a servo to talk to.
    pub fn is_present(self) -> bool {
        matches!(self, Self::Present { .. })
    }

    /// A whole answer came.
    pub fn answered(&mut self) {
        if let Self::Present { failures } = self {
            *failures = 0;
        }
    }

    /// No whole answer came; returns whether this lost the servo.
    pub fn failed(&mut self) -> bool {
        match self {
            Self::Present { failures } if *failures + 1 < LOST_AFTER => {
                *failures += 1;
                false
            }
            Self::Present { .. } => {
                *self = Self::Absent;
                true
            }
            Self::Absent => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_in_a_row_lose_the_servo_once() {
        let mut health = Health::READY;
        assert!(!health.failed());
        assert!(!health.failed());
        assert!(health.failed());
        assert_eq!(health, Health::Absent);
        assert!(!health.failed());
        health.answered();
        assert!(!health.is_present(), "an answer alone does not set the servo up");
    }

    #[test]
    fn single_failures_do_not() {
        let mut health = Health::READY;
        for _ in 0..1000 {
            assert!(!health.failed());
            assert!(!health.failed());
            health.answered();
        }
        assert_eq!(health, Health::READY);
    }
}
