//! The peripherals' registers: the only place that knows an address.
//!
//! Sources: Arm "Cortex-M System Design Kit" (CMSDK) for UART, timer and dual timer; Arm AN500 for the FPGA's own registers.

use core::ptr::{read_volatile, write_volatile};

/// A 32-bit register. Only this module makes one, from the constants below.
#[derive(Clone, Copy)]
pub(crate) struct Register(usize);

impl Register {
    pub(crate) fn read(self) -> u32 {
        // SAFETY: every `Register` is the address of an aligned 32-bit register of this board (constants below); reading one
        // has no effect on memory.
        unsafe { read_volatile(self.0 as *const u32) }
    }

    pub(crate) fn write(self, value: u32) {
        // SAFETY: as above; these peripherals have no DMA, so a write changes no memory either.
        unsafe { write_volatile(self.0 as *mut u32, value) }
    }
}

/// One CMSDK UART.
#[derive(Clone, Copy)]
pub(crate) struct UartRegisters {
    pub(crate) data: Register,
    /// Bit 0: transmit buffer full; bit 1: receive buffer full.
    pub(crate) state: Register,
    /// Bits 0 and 1: transmitter and receiver on; bits 2 and 3: their interrupts on.
    pub(crate) control: Register,
    /// Write 1 to clear. Bit 0: transmit; bit 1: receive.
    pub(crate) interrupt_clear: Register,
    /// Clock cycles per bit, at least 16.
    pub(crate) baud_divider: Register,
}

impl UartRegisters {
    const fn at(base: usize) -> Self {
        Self {
            data: Register(base),
            state: Register(base + 0x4),
            control: Register(base + 0x8),
            interrupt_clear: Register(base + 0xc),
            baud_divider: Register(base + 0x10),
        }
    }
}

pub(crate) const UART0: UartRegisters = UartRegisters::at(0x4000_4000);
pub(crate) const UART1: UartRegisters = UartRegisters::at(0x4000_5000);

/// CMSDK timer 0: counts down at [`CLOCK_HZ`].
pub(crate) mod timer0 {
    use super::Register;
    /// Bit 0: run; bit 3: interrupt at zero.
    pub(crate) const CONTROL: Register = Register(0x4000_0000);
    pub(crate) const VALUE: Register = Register(0x4000_0004);
    pub(crate) const RELOAD: Register = Register(0x4000_0008);
    pub(crate) const INTERRUPT_CLEAR: Register = Register(0x4000_000c);
}

/// CMSDK dual timer, first half: counts down at [`CLOCK_HZ`], 32 bits.
pub(crate) mod dual_timer {
    use super::Register;
    pub(crate) const LOAD: Register = Register(0x4000_2000);
    pub(crate) const VALUE: Register = Register(0x4000_2004);
    /// Bit 1: 32 bits; bit 7: run. Others zero: free-running, no prescaler, no interrupt.
    pub(crate) const CONTROL: Register = Register(0x4000_2008);
}

/// CMSDK watchdog: counts down at [`CLOCK_HZ`].
pub(crate) mod watchdog {
    use super::Register;
    /// Writing starts the count anew.
    pub(crate) const LOAD: Register = Register(0x4000_8000);
    /// Bit 0: interrupt (NMI) at zero; bit 1: reset at zero while the interrupt is raised.
    pub(crate) const CONTROL: Register = Register(0x4000_8008);
    pub(crate) const INTERRUPT_CLEAR: Register = Register(0x4000_800c);
    pub(crate) const INTERRUPT_AND_RESET: u32 = 0b11;
}

/// The FPGA's counter.
pub(crate) mod fpga {
    use super::Register;
    /// Counts up each time the prescaler reaches zero; can be set.
    pub(crate) const COUNTER: Register = Register(0x4002_8018);
    /// Clock cycles per count, less one.
    pub(crate) const PRESCALE: Register = Register(0x4002_801c);
}

/// The clock of processor and peripherals.
pub(crate) const CLOCK_HZ: u32 = fre_boards::MPS2.clock_hz;

/// Interrupt numbers.
pub(crate) mod interrupt {
    use cortex_m::interrupt::InterruptNumber;

    /// One of the numbers below, as the interrupt controller takes it.
    #[derive(Clone, Copy)]
    pub(crate) struct Number(pub(crate) u16);

    // SAFETY: the numbers are the board's and below the NVIC's number of lines.
    unsafe impl InterruptNumber for Number {
        fn number(self) -> u16 {
            self.0
        }
    }

    pub(crate) const UART0_RX: u16 = 0;
    pub(crate) const UART0_TX: u16 = 1;
    pub(crate) const UART1_RX: u16 = 2;
    pub(crate) const UART1_TX: u16 = 3;
    pub(crate) const TIMER0: u16 = 8;
    /// No device raises these: the bus task's and the control task's.
    pub(crate) const SERVE: u16 = 30;
    pub(crate) const CONTROL: u16 = 31;
}
