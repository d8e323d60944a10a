//! Reports that are missing between those that came.

/// A leap of the sequence number by this much is a new beginning, not a loss: half an hour at 500 Hz.
const RESTART: u32 = 1 << 20;

/// Reports that did not come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gap {
    /// The first number missing.
    pub first: u32,
    /// How many are.
    pub missing: u32,
}

impl Gap {
    /// The last number missing.
    fn last(&self) -> u32 {
        self.first.wrapping_add(self.missing).wrapping_sub(1)
    }
}

impl std::fmt::Display for Gap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { first, missing } = *self;
        match missing {
            1 => write!(f, "report {first} is missing"),
            _ => write!(f, "{missing} reports are missing, {first} to {}", self.last()),
        }
    }
}

/// Sequence numbers as they come.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sequence {
    last: Option<u32>,
}

impl Sequence {
    /// Takes what somebody else has found missing; returns what is missing before that.
    pub fn skip(&mut self, gap: &Gap) -> Option<Gap> {
        let before = self.take(gap.first);
        self.last = Some(gap.last());
        before
    }

    /// Takes a number; returns what is missing before it.
    pub fn take(&mut self, number: u32) -> Option<Gap> {
        let first = self.last.replace(number)?.wrapping_add(1);
        let missing = number.wrapping_sub(first);
        // A gripper that starts again counts anew.
        (1..RESTART).contains(&missing).then_some(Gap { first, missing })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_told_and_a_new_beginning_is_none() {
        let mut sequence = Sequence::default();
        let gaps: Vec<_> = [7, 8, 11, 12, 1, 2, 4].into_iter().map(|number| sequence.take(number)).collect();
        let [first, last] = [Gap { first: 9, missing: 2 }, Gap { first: 3, missing: 1 }];
        assert_eq!(gaps, [None, None, Some(first), None, None, None, Some(last)]);
        assert_eq!(first.to_string(), "2 reports are missing, 9 to 10");
        assert_eq!(last.to_string(), "report 3 is missing");
    }

    #[test]
    fn what_is_missing_before_a_known_gap_is_told() {
        let mut sequence = Sequence::default();
        let known = |first| Gap { first, missing: 3 };
        assert_eq!((sequence.skip(&known(5)), sequence.take(8)), (None, None));
        assert_eq!((sequence.skip(&known(9)), sequence.take(12)), (None, None), "right behind");
        assert_eq!(sequence.skip(&known(15)), Some(Gap { first: 13, missing: 2 }));
        assert_eq!(sequence.take(20), Some(Gap { first: 18, missing: 2 }));
    }

    #[test]
    fn numbers_wrap() {
        let mut sequence = Sequence::default();
        assert_eq!(sequence.take(u32::MAX - 1), None);
        assert_eq!(sequence.take(1), Some(Gap { first: u32::MAX, missing: 2 }));
    }
}
