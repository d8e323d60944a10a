//! How a program ends: QEMU exits with the status given here, or, once [`crate::Board::arm`] was called, the program starts
//! again and reports why.

use core::panic::PanicInfo;

use crate::reset;

/// Why the program ends; the number is QEMU's exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Exit {
    /// All is well.
    Success = 0,
    /// The program itself says that it failed.
    Failure = 1,
    /// A panic, as on a PC.
    Panic = 101,
    /// A hard fault or an interrupt without a handler.
    Fault = 102,
}

/// Ends QEMU with this status.
pub fn exit(status: Exit) -> ! {
    semihosting::process::exit(status as i32)
}

#[panic_handler]
fn panicked(info: &PanicInfo<'_>) -> ! {
    if crate::log::is_busy() {
        semihosting::eprintln!("{info}");
    } else {
        defmt::error!("{}", defmt::Display2Format(info));
    }
    if reset::is_armed() {
        reset::end(info);
    }
    exit(Exit::Panic)
}

/// `defmt::panic!` and its assertions have logged already.
#[defmt::panic_handler]
fn defmt_panicked() -> ! {
    if reset::is_armed() {
        reset::end(&"panicked; the log says why");
    }
    exit(Exit::Panic)
}
