//! How the program ends, and what the next start knows of it.
//!
//! Panics and faults write their last words where a reset leaves them (the linker's section `.survivor`: RAM that is
//! neither cleared nor cached) and restart the processor.

use core::fmt::Display;
use core::panic::PanicInfo;
use core::ptr::{addr_of_mut, read_volatile, write_volatile};

use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};
use gripper::{Boot, LastWords, ResetCause};

/// What survives a reset.
#[repr(C)]
struct Survivor {
    state: u32,
    words: LastWords,
}

/// The program asked for the reset.
const RESTARTING: u32 = 0x5245_5331;
/// [`bite`] did.
const BITTEN: u32 = 0x4249_5445;

#[unsafe(link_section = ".survivor")]
static mut SURVIVOR: Survivor = Survivor { state: 0, words: LastWords::EMPTY };

/// Reads how this start came about, once; `cause` is what the processor's reset flags say.
pub fn boot(cause: ResetCause) -> Boot {
    let fresh = matches!(cause, ResetCause::PowerOn | ResetCause::Brownout);
    let mut survivor = if fresh {
        // RAM with error correction must not be read before it was written.
        Survivor { state: 0, words: LastWords::EMPTY }
    } else {
        // SAFETY: aligned; all bit patterns are valid; nobody else uses it before the first `end`.
        unsafe { read_volatile(addr_of_mut!(SURVIVOR)) }
    };
    let cause = match (cause, survivor.state) {
        (ResetCause::Software, BITTEN) => ResetCause::Watchdog,
        _ => cause,
    };
    let boot = Boot::new(cause, &mut survivor.words);
    write(0, survivor.words);
    boot
}

fn write(state: u32, words: LastWords) {
    // SAFETY: aligned; `boot` is over when anything else writes, and what writes does not return.
    unsafe { write_volatile(addr_of_mut!(SURVIVOR), Survivor { state, words }) };
    cortex_m::asm::dsb();
}

/// Starts anew with these last words; empty ones are none.
pub fn end(words: &impl Display) -> ! {
    let mut kept = LastWords::EMPTY;
    kept.keep(words);
    write(RESTARTING, kept);
    SCB::sys_reset()
}

/// Starts anew because the watchdog was not fed, where the watchdog is a timer's interrupt.
pub fn bite() -> ! {
    write(BITTEN, LastWords::EMPTY);
    SCB::sys_reset()
}

#[panic_handler]
fn panicked(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    end(info)
}

/// `defmt::panic!` and its assertions have logged already.
#[defmt::panic_handler]
fn defmt_panicked() -> ! {
    cortex_m::interrupt::disable();
    end(&"panicked; the log says why")
}

// SAFETY: ends the program.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    end(&format_args!("hard fault at {:#010x}, called from {:#010x}", frame.pc(), frame.lr()))
}

// SAFETY: ends the program.
#[exception]
unsafe fn DefaultHandler(number: i16) {
    end(&format_args!("exception or interrupt {number} has no handler"))
}
