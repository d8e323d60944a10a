//! The virtual machine: QEMU's mps2-an500 with semihosting.

use crate::command::{headline, line};
use crate::logging::Log;
use crate::paths;
use anyhow::{Context, Result, bail};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// QEMU with this image; the log (defmt frames) comes out on standard output. Serial ports are the caller's.
pub fn machine(elf: &Path, program_arguments: &[&str]) -> Command {
    let mut semihosting = "enable=on,target=native".to_owned();
    for argument in program_arguments {
        semihosting += &format!(",arg={argument}");
    }
    let mut command = Command::new("qemu-system-arm");
    command
        .args(["-machine", "mps2-an500", "-display", "none", "-monitor", "none"])
        .args(["-semihosting-config", &semihosting])
        .arg("-kernel")
        .arg(elf);
    command
}

/// Runs a program with its log on the terminal and its two UARTs on Unix sockets, until it ends.
pub fn run_with_log(elf: &Path) -> Result<()> {
    let bytes = fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let log = Log::of(&bytes)?;
    let folder = paths::target().join("qemu");
    fs::create_dir_all(&folder)?;
    let mut command = machine(elf, &[]);
    headline("QEMU; UART 0 (bus) and UART 1 (link) are Unix sockets:");
    for name in ["bus", "link"] {
        let socket = folder.join(name);
        println!("{}", socket.display());
        let description = format!("socket,id={name},path={},server=on,wait=off", socket.display());
        command.args(["-chardev", &description, "-serial", &format!("chardev:{name}")]);
    }
    let mut qemu =
        command.stdout(Stdio::piped()).spawn().with_context(|| format!("cannot start `{}`", line(&command)))?;
    if let Some(output) = qemu.stdout.take() {
        log.print(output)?;
    }
    let status = qemu.wait()?;
    if !status.success() {
        bail!("`{}` ended with {status}", line(&command));
    }
    Ok(())
}
