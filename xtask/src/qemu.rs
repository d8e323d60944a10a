//! `cargo xtask qemu-run`: an image in QEMU with its log on the terminal.

use crate::command::headline;
use crate::paths;
use anyhow::{Context, Result, bail};
use fre_log::Log;
use fre_qemu::{Machine, Uart};
use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::Stdio;

/// Runs a program with its log on the terminal and its two UARTs on Unix sockets, until it ends.
pub fn run_with_log(elf: &Path) -> Result<()> {
    let log = Log::of(&fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?)
        .with_context(|| elf.display().to_string())?;
    let folder = paths::target().join("qemu");
    fs::create_dir_all(&folder)?;
    let [bus, link] = ["bus", "link"].map(|name| folder.join(name));
    headline("QEMU; UART 0 (bus) and UART 1 (link) are Unix sockets:");
    println!("{}\n{}", bus.display(), link.display());
    let mut machine = Machine::new(elf).uarts(Uart::Opened(bus), Uart::Opened(link)).boot(Stdio::piped())?;
    if let Some(output) = machine.output() {
        print(&log, output)?;
    }
    match machine.end(None, || Ok(()))? {
        Some(status) if status.success() => Ok(()),
        status => bail!("QEMU ended with {}; it said: {}", status.unwrap_or_default(), machine.words()),
    }
}

/// Prints the lines of a log as its frames come, until the source ends.
pub fn print(log: &Log, mut frames: impl Read) -> Result<()> {
    let mut decoder = log.decoder();
    let mut buffer = [0; 4096];
    loop {
        match frames.read(&mut buffer).context("cannot read the log")? {
            0 => return Ok(()),
            count => decoder.feed(&buffer[..count]).iter().for_each(|line| println!("{line}")),
        }
    }
}
