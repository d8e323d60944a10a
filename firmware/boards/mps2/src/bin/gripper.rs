//! The gripper's image for QEMU.

#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embedded_io_async::{Read, Write};
use mps2::Uart;

#[embassy_executor::main(executor = "mps2::Executor", entry = "cortex_m_rt::entry")]
async fn main(spawner: Spawner) {
    let board = mps2::init();
    defmt::info!("gripper on mps2-an500, version {=str}", env!("CARGO_PKG_VERSION"));
    match echo(board.link, "link") {
        Ok(task) => spawner.spawn(task),
        Err(_) => defmt::error!("no room for the link's task"),
    }
    match echo(board.bus, "bus") {
        Ok(task) => spawner.spawn(task),
        Err(_) => defmt::error!("no room for the bus' task"),
    }
}

/// Sends back what arrives.
#[embassy_executor::task(pool_size = 2)]
async fn echo(mut uart: Uart, name: &'static str) {
    let mut buffer = [0; 256];
    loop {
        let Ok(count) = uart.read(&mut buffer).await;
        defmt::debug!("{=str}: {=usize} bytes", name, count);
        let Ok(()) = uart.write_all(&buffer[..count]).await;
    }
}
