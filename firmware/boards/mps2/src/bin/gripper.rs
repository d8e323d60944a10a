//! The gripper's image for QEMU.

#![no_std]
#![no_main]

use core::convert::Infallible;

use embassy_executor::{SpawnError, SpawnToken, Spawner};
use embedded_io_async::{ErrorType, Read, Write};
use gripper::{Board, BusPort, Model, Shared};
use mps2::{Uart, UartRx, UartTx, cycles};
use static_cell::ConstStaticCell;

static SHARED: Shared = Shared::new();
static MODEL: ConstStaticCell<Model> = ConstStaticCell::new(Model::EMPTY);

/// QEMU's machine.
struct Mps2;

impl Board for Mps2 {
    type Bus = Bus;
    const NAME: &'static str = "mps2";
    // The UART divides 25 MHz by 16 at least.
    const BAUDS: &'static [u32] = &[1_000_000, 57_600, 115_200];
    // The servo is a program on the PC, which is given the processor when it suits the PC.
    const BUS_LATENCY_US: u32 = 30_000;
    const COST_HZ: u32 = cycles::HZ;

    fn cost_ticks() -> u32 {
        cycles::now()
    }
}

/// The Dynamixel bus.
struct Bus(Uart);

impl BusPort for Bus {
    fn set_baud(&mut self, baud: u32) -> u32 {
        self.0.tx.set_baud(baud)
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
    defmt::info!("gripper on mps2-an500, version {=str}", env!("CARGO_PKG_VERSION"));
    let (tx, rx) = board.link.split();
    start(spawner, control(MODEL.take(), Bus(board.bus)));
    start(spawner, send(tx));
    start(spawner, answer(rx));
}

fn start<S>(spawner: Spawner, task: Result<SpawnToken<S>, SpawnError>) {
    match task {
        Ok(task) => spawner.spawn(task),
        Err(_) => defmt::error!("no room for a task"),
    }
}

#[embassy_executor::task]
async fn control(model: &'static mut Model, bus: Bus) -> ! {
    gripper::control::<Mps2>(&SHARED, model, bus).await
}

#[embassy_executor::task]
async fn send(link: UartTx) -> ! {
    gripper::send(&SHARED, link).await
}

#[embassy_executor::task]
async fn answer(link: UartRx) -> ! {
    gripper::answer::<Mps2, _>(&SHARED, link).await
}
