//! Why the program started, and how it starts again: kept in PSRAM, which QEMU's resets leave alone.

use core::fmt::Display;
use core::ptr::{read_volatile, write_volatile};
use core::sync::atomic::{AtomicBool, Ordering};

use gripper::{Boot, LastWords, ResetCause};

use crate::registers::watchdog;

/// What survives a reset.
#[repr(C)]
struct Survivor {
    state: u32,
    words: LastWords,
}

/// Behind what [`crate::flash`] uses of the PSRAM (Arm AN500).
const SURVIVOR: *mut Survivor = 0x6010_0000 as *mut Survivor;
/// The program runs; found at a start, it was stopped from outside: by the watchdog.
const RUNNING: u32 = 0x5255_4e31;
/// The program asked for the reset.
const RESTARTING: u32 = 0x5245_5331;

/// Whether panics and faults restart the program rather than end QEMU.
static RESTARTS: AtomicBool = AtomicBool::new(false);

/// Reads how this start came about, once.
pub(crate) fn boot() -> Boot {
    // SAFETY: aligned PSRAM used by this module only; all bit patterns are valid.
    let mut survivor = unsafe { read_volatile(SURVIVOR) };
    let cause = match survivor.state {
        RUNNING => ResetCause::Watchdog,
        RESTARTING => ResetCause::Software,
        _ => ResetCause::PowerOn,
    };
    let boot = Boot::new(cause, &mut survivor.words);
    survivor.state = RUNNING;
    // SAFETY: as above.
    unsafe { write_volatile(SURVIVOR, survivor) };
    boot
}

/// From now on panics and faults are recorded and restart the program, and the watchdog runs.
pub(crate) fn arm() -> Watchdog {
    RESTARTS.store(true, Ordering::Relaxed);
    let mut dog = Watchdog(());
    gripper::Watchdog::feed(&mut dog);
    watchdog::CONTROL.write(watchdog::INTERRUPT_AND_RESET);
    dog
}

/// Whether [`arm`] was called.
pub(crate) fn is_armed() -> bool {
    RESTARTS.load(Ordering::Relaxed)
}

/// Starts anew with these last words.
pub(crate) fn end(words: &impl Display) -> ! {
    let mut kept = LastWords::EMPTY;
    kept.keep(words);
    // SAFETY: as in `boot`.
    unsafe { write_volatile(SURVIVOR, Survivor { state: RESTARTING, words: kept }) };
    cortex_m::peripheral::SCB::sys_reset()
}

/// Starts anew; without words there are no last ones.
pub fn restart(last_words: &'static str) -> ! {
    end(&last_words)
}

/// After how long without food the watchdog restarts the program, ms.
pub const WATCHDOG_MS: u32 = 2_000;

/// The CMSDK's watchdog. It resets when it counts to zero twice without being fed.
pub struct Watchdog(());

impl gripper::Watchdog for Watchdog {
    fn feed(&mut self) {
        watchdog::LOAD.write(WATCHDOG_MS / 2 * (crate::registers::CLOCK_HZ / 1000));
        watchdog::INTERRUPT_CLEAR.write(1);
    }
}
