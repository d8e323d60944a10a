//! The one rule by which a test may try again.

/// How often a try may be spoilt.
const MOST: u32 = 10;

/// A busy PC may stand still for tenths of a second: the servo is lost, or an estimate has no time, which says nothing of the gripper. A
/// test that finds its try spoilt so tries again, ten times at most; it prints how often.
#[derive(Debug)]
pub struct Tries {
    what: &'static str,
    spoilt: u32,
}

impl Tries {
    /// None spoilt yet.
    pub fn of(what: &'static str) -> Self {
        Self { what, spoilt: 0 }
    }

    /// One was spoilt.
    ///
    /// # Panics
    /// It is one too many.
    pub fn spoilt(&mut self) {
        self.spoilt += 1;
        assert!(self.spoilt <= MOST, "{}: spoilt {} times", self.what, self.spoilt);
    }
}

impl Drop for Tries {
    fn drop(&mut self) {
        if self.spoilt > 0 {
            eprintln!("{}: spoilt {} times of {MOST} by a busy PC", self.what, self.spoilt);
        }
    }
}
