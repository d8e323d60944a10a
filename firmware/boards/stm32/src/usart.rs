//! A chip's USART under a [`Line`](crate::Line).

use embassy_stm32::Peri;
use embassy_stm32::gpio::{AfType, Flex, Level, OutputType, Pin, Pull, Speed};
use embassy_stm32::interrupt::typelevel::Interrupt;
use embassy_stm32::pac::gpio::Gpio;
use embassy_stm32::pac::usart::Usart as Registers;
use embassy_stm32::rcc;
#[cfg(not(feature = "one-data-register"))]
use embassy_stm32::usart::DePin;
use embassy_stm32::usart::{Instance, RxPin, TxPin};

use crate::critical::UNMASKED;
use crate::line::{Status, Until, Usart};

#[cfg_attr(feature = "one-data-register", path = "usart/one_data_register.rs")]
#[cfg_attr(not(feature = "one-data-register"), path = "usart/two_data_registers.rs")]
mod registers;

/// Who turns the direction round.
#[derive(Clone, Copy)]
pub enum Direction {
    /// Nobody: a wire for each direction.
    None,
    /// The USART: its driver-enable output frames what it sends, to a fraction of a bit. Older USARTs have none.
    #[cfg(not(feature = "one-data-register"))]
    DriverEnable,
    /// The line's interrupt, by a pin that is high while the line is driven.
    Pin(Gpio, usize),
}

/// A USART and its direction, for the line's interrupt.
#[derive(Clone, Copy)]
pub struct Wired {
    registers: Registers,
    direction: Direction,
}

/// A USART that runs: for the program, to change its rate.
pub struct Running {
    wired: Wired,
    kernel_hz: u32,
    mask: fn(),
    unmask: fn(),
    raise: fn(),
}

/// What the divider allows.
const DIVIDERS: core::ops::RangeInclusive<u32> = 16..=0xffff;

impl Wired {
    /// A USART whose direction is turned so.
    pub const fn new(registers: Registers, direction: Direction) -> Self {
        Self { registers, direction }
    }

    /// Connects pins and clock. That the pins are this USART's is checked by their types.
    ///
    /// The handler of its interrupt must call [`Line::service`](crate::Line::service) and take no lock.
    pub fn start<T: Instance>(
        self,
        _usart: Peri<'static, T>,
        tx: Peri<'static, impl TxPin<T>>,
        rx: Peri<'static, impl RxPin<T>>,
        baud: u32,
    ) -> Running {
        rcc::enable_and_reset::<T>();
        // While nobody drives a wire it has to look like an idle line.
        let (number, wire) = (tx.af_num(), AfType::output_pull(OutputType::PushPull, Speed::High, Pull::Up));
        connect(tx, number, wire);
        let (number, wire) = (rx.af_num(), AfType::input(Pull::Up));
        connect(rx, number, wire);
        let mut running = Running {
            wired: self,
            kernel_hz: rcc::frequency::<T>().0,
            mask: T::Interrupt::disable,
            unmask: enable::<T::Interrupt>,
            raise: T::Interrupt::pend,
        };
        T::Interrupt::set_priority(UNMASKED);
        running.set_baud(baud);
        running
    }

    /// As [`Self::start`], with the USART's driver-enable output.
    #[cfg(not(feature = "one-data-register"))]
    pub fn start_with_driver_enable<T: Instance>(
        self,
        usart: Peri<'static, T>,
        tx: Peri<'static, impl TxPin<T>>,
        rx: Peri<'static, impl RxPin<T>>,
        de: Peri<'static, impl DePin<T>>,
        baud: u32,
    ) -> Running {
        let (number, wire) = (de.af_num(), AfType::output_pull(OutputType::PushPull, Speed::High, Pull::Down));
        connect(de, number, wire);
        self.start(usart, tx, rx, baud)
    }
}

fn connect(pin: Peri<'static, impl Pin>, number: u8, wire: AfType) {
    let mut flex = Flex::new(pin);
    flex.set_as_af_unchecked(number, wire);
    // Dropped, it would be disconnected.
    core::mem::forget(flex);
}

/// Makes a pin an output for [`Direction::Pin`], low: the line is not driven.
pub fn direction(pin: Peri<'static, impl Pin>) {
    core::mem::forget(embassy_stm32::gpio::Output::new(pin, Level::Low, Speed::High));
}

fn enable<I: Interrupt>() {
    // SAFETY: its handler takes no lock (see `Wired::start`).
    unsafe { I::enable() };
}

impl Running {
    /// What raises the line's interrupt.
    pub fn raise(&self) -> fn() {
        self.raise
    }

    /// Sets the rate and returns the one reached: the nearest that dividing the USART's clock gives. Between
    /// transmissions only: it stops the USART for a moment.
    pub fn set_baud(&mut self, baud: u32) -> u32 {
        let divider = ((self.kernel_hz + baud / 2) / baud.max(1)).clamp(*DIVIDERS.start(), *DIVIDERS.end());
        (self.mask)();
        let Wired { registers: usart, direction } = self.wired;
        usart.cr1().write(|_| ());
        usart.brr().write(|w| w.set_brr(divider as u16));
        registers::frame(usart, direction);
        usart.cr1().modify(|w| {
            w.set_te(true);
            w.set_re(true);
            w.set_rxneie(true);
            w.set_idleie(true);
            w.set_ue(true);
        });
        (self.unmask)();
        // What was cut off is over: the line must not stay driven.
        (self.raise)();
        self.kernel_hz / divider
    }
}

impl Usart for Wired {
    #[inline(always)]
    fn status(&self) -> Status {
        registers::status(self.registers)
    }

    #[inline(always)]
    fn take(&self) -> u8 {
        registers::take(self.registers)
    }

    #[inline(always)]
    fn clear(&self) {
        registers::clear(self.registers);
    }

    #[inline(always)]
    fn give(&self, byte: u8) {
        registers::give(self.registers, byte);
    }

    #[inline(always)]
    fn interrupt(&self, until: Until) {
        self.registers.cr1().modify(|w| {
            w.set_txeie(until == Until::Ready);
            w.set_tcie(until == Until::Complete);
        });
    }

    #[inline(always)]
    fn drive(&self, on: bool) {
        if let Direction::Pin(port, pin) = self.direction {
            // One write that touches no other pin.
            port.bsrr().write(|w| if on { w.set_bs(pin, true) } else { w.set_br(pin, true) });
        }
    }

    #[inline(always)]
    fn is_half_duplex(&self) -> bool {
        !matches!(self.direction, Direction::None)
    }
}
