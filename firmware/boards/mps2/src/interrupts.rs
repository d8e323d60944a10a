//! Which interrupt calls what.

use crate::registers::interrupt;
use crate::{time_driver, uart};
use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::NVIC;
use cortex_m_rt::exception;

#[derive(Clone, Copy)]
struct Number(u16);

// SAFETY: the numbers are the board's (see `registers::interrupt`) and below the NVIC's number of lines.
unsafe impl InterruptNumber for Number {
    fn number(self) -> u16 {
        self.0
    }
}

/// Lets the board's interrupts through.
pub(crate) fn enable() {
    for number in
        [interrupt::UART0_RX, interrupt::UART0_TX, interrupt::UART1_RX, interrupt::UART1_TX, interrupt::TIMER0]
    {
        // SAFETY: the handlers below use critical sections; no critical section of ours works by masking single interrupts.
        unsafe { NVIC::unmask(Number(number)) };
    }
}

/// Every interrupt comes here: cortex-m-rt's vector table points unnamed ones to the default handler.
// SAFETY: the handler touches registers and statics behind critical sections only, so it may run at any time.
#[exception]
unsafe fn DefaultHandler(number: i16) {
    match u16::try_from(number) {
        Ok(interrupt::UART0_RX | interrupt::UART0_TX) => uart::BUS.on_interrupt(),
        Ok(interrupt::UART1_RX | interrupt::UART1_TX) => uart::LINK.on_interrupt(),
        Ok(interrupt::TIMER0) => time_driver::on_interrupt(),
        _ => {
            defmt::error!("exception or interrupt {} has no handler", number);
            crate::exit(crate::Exit::Fault)
        }
    }
}

// SAFETY: ends the program.
#[exception]
unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
    defmt::error!("hard fault at {=u32:#010x}, called from {=u32:#010x}", frame.pc(), frame.lr());
    crate::exit(crate::Exit::Fault)
}
