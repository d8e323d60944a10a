//! embassy's clock while a sector is erased, which holds every interrupt back for half a second.

use embassy_stm32::pac::TIM12;
use fre_boards::OPENCR;
use stm32::cycles;
use stm32::missed::{Held, Turns};

/// Cycles of the processor in one tick of the clock.
const CYCLES: u32 = OPENCR.clock_hz / embassy_time::TICK_HZ as u32;
const _: () = assert!(embassy_time::TICK_HZ == 1_000_000);

/// The timer that the clock counts by, as the features of embassy-stm32 choose it.
struct Timer;

unsafe extern "C" {
    /// The clock's interrupt.
    fn TIM8_BRK_TIM12();
}

impl Turns for Timer {
    fn count(&self) -> u16 {
        TIM12.cnt().read().cnt()
    }

    fn flagged(&self) -> u32 {
        let status = TIM12.sr().read();
        u32::from(status.uif()) + u32::from(status.ccif(0))
    }

    fn flag_half(&self) {
        TIM12.egr().write(|w| w.set_ccg(0, true));
    }

    fn flag_alarm(&self) {
        TIM12.egr().write(|w| w.set_ccg(1, true));
    }

    fn serve(&self) {
        // SAFETY: only called while a critical section holds it back, so that it cannot meet itself; whatever it shares it locks.
        unsafe { TIM8_BRK_TIM12() };
    }
}

/// Does something that takes less than 19 s, the turn of the cycle counter, with interrupts held back, and has the clock know how long
/// that took.
pub fn kept<R>(act: impl FnOnce() -> R) -> R {
    critical_section::with(|_| {
        let held = Held::begin(&Timer);
        let begun = cycles::now();
        let outcome = act();
        held.end(&Timer, u64::from(cycles::now().wrapping_sub(begun) / CYCLES));
        outcome
    })
}
