//! The registers of older USARTs (STM32F4): one data register for both ways. Its reading, after that of the flags, clears those of an
//! idle line and of damage, and takes the byte that is there.

use embassy_stm32::pac::usart::Usart;

use super::Direction;
use crate::line::Status;

/// These USARTs turn no direction.
pub(super) fn frame(usart: Usart, _direction: Direction) {
    usart.cr3().write(|_| ());
}

#[inline(always)]
pub(super) fn status(usart: Usart) -> Status {
    let flags = usart.sr().read();
    Status {
        received: flags.rxne(),
        idle: flags.idle(),
        damaged: flags.ore() || flags.fe() || flags.ne(),
        ready: flags.txe(),
        complete: flags.tc(),
    }
}

/// Takes the byte; the flags that [`status`] has read are cleared with it.
#[inline(always)]
pub(super) fn take(usart: Usart) -> u8 {
    usart.dr().read().dr() as u8
}

/// Clears what taking a byte has not cleared already. A byte that has come meanwhile stays: its own interrupt waits, takes it and
/// clears the rest. A byte that ends in the few cycles between the two reads is lost: after an idle line that takes an interrupt which
/// comes a byte's time late.
#[inline(always)]
pub(super) fn clear(usart: Usart) {
    let flags = usart.sr().read();
    if !flags.rxne() && (flags.idle() || flags.ore() || flags.fe() || flags.ne()) {
        let _ = usart.dr().read();
    }
}

#[inline(always)]
pub(super) fn give(usart: Usart, byte: u8) {
    // Ones leave the other flags as they are.
    usart.sr().write(|w| {
        w.0 = u32::MAX;
        w.set_tc(false);
    });
    usart.dr().write(|w| w.set_dr(u16::from(byte)));
}
