//! Board support for QEMU's `mps2-an500`: a Cortex-M7 at 25 MHz with two UARTs in use.
//!
//! ```ignore
//! #[embassy_executor::main(executor = "mps2::Executor", entry = "cortex_m_rt::entry")]
//! async fn main(spawner: embassy_executor::Spawner) {
//!     let board = mps2::init();
//!     // board.bus: the Dynamixel bus (UART 0, QEMU's first -serial); board.link: the host (UART 1, the second)
//! }
//! ```
//!
//! It brings embassy's clock (microseconds), its executor, a defmt logger and the panic handler, both over semihosting.
//! All `unsafe` code of the image is here.

#![no_std]

pub mod cycles;
mod end;
mod executor;
mod flash;
mod interrupts;
mod log;
mod registers;
mod reset;
pub mod stack;
mod time_driver;
mod uart;

pub use end::{Exit, exit};
pub use executor::{Executor, for_control, for_serving};
pub use flash::Flash;
pub use reset::{WATCHDOG_MS, Watchdog, restart};
pub use time_driver::skip_to_wraparound;
pub use uart::{TRANSMIT_RING, Uart, UartRx, UartTx};

/// Rate of both UARTs after [`init`].
pub const DEFAULT_BAUD: u32 = 1_000_000;

/// The board's devices.
pub struct Board {
    /// UART 0, the Dynamixel bus.
    pub bus: Uart,
    /// UART 1, the link to the host.
    pub link: Uart,
    /// Where settings live.
    pub flash: Flash,
    /// How this start came about.
    pub boot: gripper::Boot,
}

impl Board {
    /// From now on panics and faults are recorded and restart the program, and the watchdog wants its food.
    pub fn arm() -> Watchdog {
        reset::arm()
    }
}

/// Starts clocks, interrupts and UARTs. Call it once, first.
pub fn init() -> Board {
    // Nothing else takes them: this is called once, first.
    let nvic = cortex_m::Peripherals::take().map(|peripherals| peripherals.NVIC);
    cycles::start();
    time_driver::start();
    let board = Board {
        bus: uart::BUS.start(DEFAULT_BAUD),
        link: uart::LINK.start(DEFAULT_BAUD),
        flash: Flash::start(),
        boot: reset::boot(),
    };
    if let Some(nvic) = nvic {
        interrupts::enable(nvic);
    }
    board
}
