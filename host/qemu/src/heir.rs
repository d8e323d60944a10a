//! What ends QEMU if this program is killed and cannot do it itself.

use std::io::{self, Write};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// A shell that waits for the end of its standard input, then ends QEMU and removes the folder.
#[derive(Debug)]
pub struct Heir(Child);

impl Heir {
    /// Starts the shell.
    ///
    /// # Errors
    /// There is no shell.
    pub fn new(folder: &Path) -> io::Result<Self> {
        let mut shell = Command::new("/bin/sh");
        shell.args(["-c", "read qemu; read _; kill -9 $qemu; /bin/rm -r \"$0\""]).arg(folder);
        shell.process_group(0).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
        shell.spawn().map(Self)
    }

    /// Hands over the process to end.
    ///
    /// # Errors
    /// The shell has gone.
    pub fn learn(&mut self, qemu: &Child) -> io::Result<()> {
        let input = self.0.stdin.as_mut().ok_or(io::ErrorKind::BrokenPipe)?;
        writeln!(input, "{}", qemu.id())
    }
}

impl Drop for Heir {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
