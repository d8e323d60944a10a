//! The gripper's image for QEMU.

#![no_std]
#![no_main]

use core::convert::Infallible;

use embassy_executor::Spawner;
use embedded_io_async::{ErrorType, Read, Write};
use fre_boards::MPS2;
use gripper::{Board, BusPort};
use mps2::{Flash, Uart, UartRx, UartTx, Watchdog, cycles};

gripper::tasks!(Mps2, sends: UartTx, hears: UartRx);

/// QEMU's machine.
struct Mps2;

impl Board for Mps2 {
    type Bus = Bus;
    type Flash = Flash;
    type Watchdog = Watchdog;
    const NAME: &'static str = MPS2.name;
    const FINGERS: usize = MPS2.fingers;
    // The servo is a program on the PC, which is given the processor when it suits the PC.
    const BUS_LATENCY_US: u32 = 100_000;
    const ANSWER_US: u32 = MPS2.answer_us;
    const COST_HZ: u32 = MPS2.clock_hz;
    const WATCHDOG_MS: u32 = mps2::WATCHDOG_MS;
    const FLASH_STALLS: bool = MPS2.flash_stalls;

    fn cost_ticks() -> u32 {
        cycles::now()
    }

    fn restart(last_words: &'static str) -> ! {
        mps2::restart(last_words)
    }
}

/// The Dynamixel bus.
struct Bus(Uart);

impl BusPort for Bus {
    fn set_baud(&mut self, baud: u32) -> u32 {
        self.0.tx.set_baud(baud)
    }

    fn heard_ticks(&self) -> Option<u32> {
        Some(self.0.rx.heard_ticks())
    }
}

impl ErrorType for Bus {
    type Error = Infallible;
}

impl Read for Bus {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        self.0.read(buffer).await
    }
}

impl Write for Bus {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        self.0.write(bytes).await
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        self.0.flush().await
    }
}

#[embassy_executor::main(executor = "mps2::Executor", entry = "cortex_m_rt::entry")]
async fn main(spawner: Spawner) {
    let board = mps2::init();
    let watchdog = mps2::Board::arm();
    defmt::info!("gripper on mps2-an500, version {=str}", env!("CARGO_PKG_VERSION"));
    let above = Above { serve: mps2::for_serving(), control: mps2::for_control() };
    run(above, spawner, (Bus(board.bus), watchdog), board.link.split(), (board.flash, board.boot));
}
