//! embassy's clock behind a time without interrupts, on a simulated timer: nothing of it is missed, whatever its length.

use core::cell::Cell;

use stm32::missed::{Held, Turns};

/// Counts of half a turn.
const HALF: u64 = 0x8000;

/// embassy-stm32's driver of a 16-bit timer, as far as it counts half turns.
struct Driver {
    /// Counts since the start.
    now: Cell<u64>,
    overflow: Cell<bool>,
    middle: Cell<bool>,
    alarm: Cell<bool>,
    /// Half turns counted.
    period: Cell<u64>,
    /// What the clock was when alarms were last looked at.
    looked: Cell<u64>,
}

impl Driver {
    /// A timer that has run for so long, with all half turns counted.
    fn at(now: u64) -> Self {
        let no = || Cell::new(false);
        Self {
            now: Cell::new(now),
            overflow: no(),
            middle: no(),
            alarm: no(),
            period: Cell::new(now / HALF),
            looked: Cell::new(0),
        }
    }

    fn pass(&self, counts: u64) {
        let (from, to) = (self.now.get() / HALF, (self.now.get() + counts) / HALF);
        for half in from + 1..=to {
            if half % 2 == 0 { self.overflow.set(true) } else { self.middle.set(true) }
        }
        self.now.set(self.now.get() + counts);
    }

    /// `calc_now` of embassy-stm32.
    fn clock(&self) -> u64 {
        let (period, counter) = (self.period.get(), self.now.get() % (2 * HALF));
        (period << 15) + (counter ^ ((period & 1) << 15))
    }
}

impl Turns for Driver {
    fn count(&self) -> u16 {
        // Looking takes a while.
        self.pass(1);
        self.now.get() as u16
    }

    fn flagged(&self) -> u32 {
        u32::from(self.overflow.get()) + u32::from(self.middle.get())
    }

    fn flag_half(&self) {
        self.middle.set(true);
    }

    fn flag_alarm(&self) {
        self.alarm.set(true);
    }

    fn serve(&self) {
        let flags = [&self.overflow, &self.middle].map(|flag| u64::from(flag.take()));
        self.period.set(self.period.get() + flags[0] + flags[1]);
        if self.alarm.take() {
            self.looked.set(self.clock());
        }
        // The interrupt takes a few counts.
        self.pass(3);
    }
}

#[embedded_test::tests(executor = mps2::Executor::new())]
mod tests {
    use super::*;
    use mps2::Board;

    #[init]
    fn init() -> Board {
        mps2::init()
    }

    /// By the flags alone the clock is late by whole turns; measured by a clock that is a little off, it is right.
    #[test]
    fn no_time_is_missed_while_interrupts_are_held_back(_board: Board) {
        let mut late = 0;
        for begin in [0, 100, 31_000, 32_767, 32_768, 50_000, 65_535, 1_000_000_007] {
            for held in [0, 20, 5_000, 32_767, 32_768, 65_000, 65_536, 98_304, 250_000, 500_000, 2_999_000] {
                let flags = Driver::at(begin);
                flags.pass(held);
                flags.serve();
                late += u32::from(flags.clock() != flags.now.get());
                for off in [-8_000, -1, 0, 1, 8_000_i64] {
                    let driver = Driver::at(begin);
                    let pause = Held::begin(&driver);
                    driver.pass(held);
                    pause.end(&driver, held.saturating_add_signed(off));
                    assert_eq!(driver.period.get(), driver.now.get() / HALF, "{} from {}", held, begin);
                    assert_eq!(driver.clock(), driver.now.get());
                    assert!(driver.now.get() - driver.looked.get() < 10, "alarms were looked at with the right clock");
                }
            }
        }
        assert!(late > 20, "{} without", late);
    }
}
