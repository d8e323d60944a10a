//! The registers of newer USARTs: a data register for each way, and flags that are cleared by name.

use embassy_stm32::pac::usart::Usart;

use super::Direction;
use crate::line::Status;

/// Sixteenths of a bit by which the driver is enabled before the first start bit.
const ENABLE_AHEAD: u8 = 8;
/// Sixteenths of a bit by which it stays enabled after the last stop bit.
const ENABLE_AFTER: u8 = 1;

/// Switches the driver-enable output on for [`Direction::DriverEnable`], and off otherwise. The USART must not run meanwhile.
pub(super) fn frame(usart: Usart, direction: Direction) {
    usart.cr3().write(|w| w.set_dem(matches!(direction, Direction::DriverEnable)));
    usart.cr1().modify(|w| {
        w.set_deat(ENABLE_AHEAD);
        w.set_dedt(ENABLE_AFTER);
    });
}

#[inline(always)]
pub(super) fn status(usart: Usart) -> Status {
    let flags = usart.isr().read();
    Status {
        received: flags.rxne(),
        idle: flags.idle(),
        damaged: flags.ore() || flags.fe() || flags.ne(),
        ready: flags.txe(),
        complete: flags.tc(),
    }
}

#[inline(always)]
pub(super) fn take(usart: Usart) -> u8 {
    usart.rdr().read().dr() as u8
}

#[inline(always)]
pub(super) fn clear(usart: Usart) {
    usart.icr().write(|w| {
        w.set_idle(true);
        w.set_ore(true);
        w.set_fe(true);
        w.set_ne(true);
    });
}

#[inline(always)]
pub(super) fn give(usart: Usart, byte: u8) {
    usart.icr().write(|w| w.set_tc(true));
    usart.tdr().write(|w| w.set_dr(u16::from(byte)));
}
