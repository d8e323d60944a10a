//! The watchdog: timer 7, whose interrupt no critical section holds back.
//!
//! Not the chip's own watchdog alone: after that one bites, OpenCR's boot loader waits for an upload and does not start
//! the program. It runs behind the timer, with twice the time, for a processor that takes no interrupts any more.

use embassy_stm32::interrupt::typelevel::{self, Handler, Interrupt};
use embassy_stm32::pac::iwdg::vals::{Key, Pr};
use embassy_stm32::pac::{IWDG, RCC, TIM7, timer::vals::Urs};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Peri, peripherals};
use stm32::{critical, reset};

/// After how long it bites, ms: longer than a sector of 32 KB takes to erase, which holds the processor.
pub const MS: u32 = 3_000;
/// Ticks of the timer per ms.
const PER_MS: u32 = 10;
/// Timers of APB1 run at twice its clock.
const TIMER_HZ: u32 = fre_boards::OPENCR.clock_hz / 2;

/// The watchdog.
pub struct Timer(IndependentWatchdog<'static, peripherals::IWDG>);

impl Timer {
    /// Starts it.
    pub fn start(behind: Peri<'static, peripherals::IWDG>) -> Self {
        const { assert!(MS * PER_MS <= u16::MAX as u32) };
        RCC.apb1enr().modify(|w| w.set_tim7en(true));
        // The clock needs two cycles to reach the timer; reading the register back takes longer.
        let _ = RCC.apb1enr().read();
        TIM7.psc().write_value((TIMER_HZ / (1000 * PER_MS) - 1) as u16);
        TIM7.arr().write(|w| w.set_arr((MS * PER_MS) as u16));
        // Only running out raises the interrupt, not feeding.
        TIM7.cr1().write(|w| w.set_urs(Urs::COUNTER_ONLY));
        TIM7.egr().write(|w| w.set_ug(true));
        TIM7.sr().write(|_| ());
        TIM7.dier().write(|w| w.set_uie(true));
        TIM7.cr1().modify(|w| w.set_cen(true));
        typelevel::TIM7::set_priority(critical::UNMASKED);
        // SAFETY: its handler takes no lock.
        unsafe { typelevel::TIM7::enable() };
        let mut behind = IndependentWatchdog::new(behind, 2 * MS * 1000);
        behind.unleash();
        Self(behind)
    }
}

/// Restarts into the boot loader, which waits for an upload after the chip's own watchdog has bitten.
pub fn to_boot_loader() -> ! {
    cortex_m::interrupt::disable();
    // The shortest time there is. The registers take a new value once the one before has arrived.
    IWDG.kr().write(|w| w.set_key(Key::ENABLE));
    IWDG.pr().write(|w| w.set_pr(Pr::DIVIDE_BY4));
    IWDG.rlr().write(|w| w.set_rl(1));
    loop {
        if IWDG.sr().read().0 == 0 {
            IWDG.kr().write(|w| w.set_key(Key::RESET));
            break;
        }
    }
    loop {
        cortex_m::asm::nop();
    }
}

impl gripper::Watchdog for Timer {
    fn feed(&mut self) {
        TIM7.egr().write(|w| w.set_ug(true));
        self.0.pet();
    }
}

/// Its interrupt.
pub struct Biting;

impl Handler<typelevel::TIM7> for Biting {
    unsafe fn on_interrupt() {
        reset::bite()
    }
}
