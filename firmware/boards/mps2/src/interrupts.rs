//! Which interrupt calls what.

use crate::registers::interrupt::{self, Number};
use crate::{executor, reset, time_driver, uart};
use cortex_m::peripheral::NVIC;
use cortex_m_rt::exception;

/// What the vector table calls the non-maskable interrupt.
const NMI: i16 = -14;
/// Priorities of the tasks' interrupts: below the devices', which stay at 0.
const SERVE: u8 = 0x40;
const CONTROL: u8 = 0x80;

/// Lets the board's interrupts through.
pub(crate) fn enable(mut nvic: NVIC) {
    // SAFETY: priorities are set before any interrupt is let through, and critical sections mask all of them.
    unsafe {
        nvic.set_priority(Number(interrupt::SERVE), SERVE);
        nvic.set_priority(Number(interrupt::CONTROL), CONTROL);
    }
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
        Ok(interrupt::SERVE) => executor::SERVE.on_interrupt(),
        Ok(interrupt::CONTROL) => executor::CONTROL.on_interrupt(),
        // The watchdog's warning: what can still be saved is how it came about.
        Err(_) if number == NMI => (),
        _ => {
            defmt::error!("exception or interrupt {} has no handler", number);
            end(&format_args!("exception or interrupt {number} has no handler"))
        }
    }
}

// A fault may come of a stack that has left the RAM: the handler gets a fresh one. r0: where the processor has put (or
// wanted to put) pc and the like; r1: that pc, 0 if it could not be put there.
core::arch::global_asm!(
    ".section .HardFault.user, \"ax\"",
    ".global HardFault",
    ".type HardFault, %function",
    ".thumb_func",
    "HardFault:",
    "mrs r0, msp",
    "ldr r2, =_stack_end",
    "movs r1, #0",
    "cmp r0, r2",
    "blo 1f",
    "ldr r1, [r0, #24]",
    "1:",
    "ldr r2, =_stack_start",
    "msr msp, r2",
    "b mps2_hard_fault",
    ".ltorg",
);

// SAFETY: called by the code above only, as C would.
#[unsafe(no_mangle)]
extern "C" fn mps2_hard_fault(frame: usize, pc: usize) -> ! {
    let bottom = (&raw const _stack_end) as usize;
    // An overflow is noticed up to a frame above the bottom.
    if frame < bottom + 256 {
        defmt::error!("the stack has overflowed");
        end(&"the stack has overflowed");
    }
    defmt::error!("hard fault at {=usize:#010x}", pc);
    end(&format_args!("hard fault at {pc:#010x}"))
}

unsafe extern "C" {
    static _stack_end: u32;
}

fn end(words: &impl core::fmt::Display) -> ! {
    if reset::is_armed() {
        reset::end(words);
    }
    crate::exit(crate::Exit::Fault)
}
