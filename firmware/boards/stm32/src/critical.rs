//! Critical sections by BASEPRI: they hold back every interrupt but those of the highest priority, which take no lock.
//!
//! So the bus' interrupt (see [`crate::Line`]) is never late: no byte is lost on a USART without a FIFO, and the line is
//! turned round within the time that an interrupt takes to be entered.
//!
//! The rule that this rests on: only interrupts whose handlers take no lock may have [`UNMASKED`]; [`prepare`] gives all
//! others [`DEVICES`] before any of them is let through.

use core::arch::asm;
use core::sync::atomic::{Ordering, compiler_fence};

use cortex_m::peripheral::{NVIC, SCB, scb::SystemHandler};
use critical_section::{Impl, RawRestoreState, set_impl};
use embassy_stm32::interrupt::Priority;

/// Priority of interrupts that no critical section holds back. Their handlers take no lock and wake nobody.
pub const UNMASKED: Priority = Priority::P0;
/// Priority of the devices' interrupts.
pub const DEVICES: Priority = Priority::P1;
/// Priority of the bus task's executor.
pub const SERVE: Priority = Priority::P4;
/// Priority of the control task's executor.
pub const CONTROL: Priority = Priority::P8;

/// BASEPRI at which [`UNMASKED`] alone goes through.
const MASK: u8 = DEVICES as u8;
// A mask of 0 masks nothing.
const _: () = assert!(MASK > UNMASKED as u8);

struct Masked;
set_impl!(Masked);

// SAFETY: while BASEPRI is `MASK` no code runs that takes a critical section but the one that took it: all handlers that
// do have a priority of `DEVICES` or lower (see `prepare`).
unsafe impl Impl for Masked {
    unsafe fn acquire() -> RawRestoreState {
        let before: u8;
        // PRIMASK around it: on a Cortex-M7 r0p1, which the STM32F746 is, raising BASEPRI does not take effect at once
        // (Arm erratum 837070). BASEPRI_MAX only ever raises.
        // SAFETY: changes only which interrupts are held back; PRIMASK is put back as it was.
        unsafe {
            asm!(
                "mrs {before}, BASEPRI",
                "mrs {primask}, PRIMASK",
                "cpsid i",
                "msr BASEPRI_MAX, {mask}",
                "isb",
                "msr PRIMASK, {primask}",
                before = lateout(reg) before,
                primask = out(reg) _,
                mask = in(reg) MASK,
                options(nostack, preserves_flags),
            );
        }
        compiler_fence(Ordering::SeqCst);
        before
    }

    unsafe fn release(before: RawRestoreState) {
        compiler_fence(Ordering::SeqCst);
        // SAFETY: puts BASEPRI back as `acquire` found it.
        unsafe { asm!("msr BASEPRI, {}", in(reg) before, options(nostack, preserves_flags)) };
    }
}

/// Gives every interrupt and system handler [`DEVICES`]. Call it first of all, before the chip's devices are set up.
///
/// It also lets interrupts through as such: a boot loader may have left them masked.
pub fn prepare(scb: &mut SCB, nvic: &mut NVIC) {
    // SAFETY: no interrupt is let through yet.
    unsafe {
        for priority in &nvic.ipr {
            priority.write(MASK);
        }
        for handler in [SystemHandler::SVCall, SystemHandler::PendSV, SystemHandler::SysTick] {
            scb.set_priority(handler, MASK);
        }
        cortex_m::register::basepri::write(0);
        cortex_m::interrupt::enable();
    }
}
