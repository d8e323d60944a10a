//! Time that embassy's clock misses while no interrupt is let through, and how it gets it back.
//!
//! embassy-stm32 counts the half turns of a 16-bit timer by two flags, that of the overflow and that of the middle, and a flag holds one
//! event. Behind a time without interrupts that is longer than a turn (65.5 ms at 1 MHz) the clock is late by whole turns. Whatever was heard
//! before then counts as younger than it is, and every deadline comes later.
//!
//! [`Held`] has the driver's interrupt count what its flags could not hold.

/// Counts of half a turn.
const HALF: u64 = 0x8000;
/// What catching up takes at most, counts: in so many none of the timer's own events may come.
const CATCHING_UP: u16 = 1024;
/// Looks at the counter until so many counts have passed, at most: far more than it takes.
const LOOKS: u32 = 1_000_000;

/// The timer behind embassy's clock, with the driver's interrupt. While interrupts are held back only.
pub trait Turns {
    /// Where the counter is.
    fn count(&self) -> u16;
    /// Half turns that are flagged and not counted yet.
    fn flagged(&self) -> u32;
    /// Flags a half turn.
    fn flag_half(&self);
    /// Flags the alarm: the driver looks which ones have passed.
    fn flag_alarm(&self);
    /// The driver's interrupt: it counts what is flagged.
    fn serve(&self);
}

/// A time in which no interrupt is let through.
pub struct Held {
    /// Where the counter was at its beginning, when all half turns were counted.
    from: u16,
}

impl Held {
    /// It begins: interrupts are held back already.
    pub fn begin(turns: &impl Turns) -> Self {
        between_events(turns);
        turns.serve();
        Self { from: turns.count() }
    }

    /// It ends after so many ticks of the clock, by a clock that has gone on; at most a quarter of a turn off. Interrupts are held back still.
    pub fn end(self, turns: &impl Turns, ticks: u64) {
        between_events(turns);
        let about = u64::from(self.from) + ticks;
        // The nearest time at which the counter is where it is.
        let off = turns.count().wrapping_sub(about as u16).cast_signed();
        let passed = about.saturating_add_signed(i64::from(off)) / HALF - u64::from(self.from) / HALF;
        let flagged = u64::from(turns.flagged());
        turns.serve();
        for _ in flagged..passed {
            turns.flag_half();
            turns.serve();
        }
        // Alarms that have passed meanwhile were compared with a clock that was late.
        turns.flag_alarm();
        turns.serve();
    }
}

/// Waits until the timer's next event is far enough away.
fn between_events(turns: &impl Turns) {
    for _ in 0..LOOKS {
        if turns.count() % HALF as u16 <= HALF as u16 - CATCHING_UP {
            return;
        }
    }
}
