//! A board that runs: waiting for it, its words, its end.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::PathBuf;
use std::process::{Child, ChildStdout, ExitStatus};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::error::QemuError;
use crate::heir::Heir;
use crate::memory;

/// Time between two looks at whether something has happened.
const GLANCE: Duration = Duration::from_millis(5);
/// QEMU closes its sockets a little before its end can be seen.
const CLOSING: Duration = Duration::from_millis(100);
/// Lines of QEMU's words at the start and at the end that an error shows, if there are more (registers, mostly).
const SHOWN: usize = 8;
/// Bytes of QEMU's words that are read.
const WORDS: usize = 64 * 1024;

/// A board that runs; ended when dropped.
#[derive(Debug)]
pub struct Running {
    qemu: Child,
    words: File,
    heir: Option<Heir>,
    monitor: Option<PathBuf>,
}

impl Running {
    pub(crate) fn new(qemu: Child, words: File, heir: Option<Heir>, monitor: Option<PathBuf>) -> Self {
        Self { qemu, words, heir, monitor }
    }

    /// So many bytes of its memory from an address on, as they are at this moment.
    ///
    /// # Errors
    /// It was not booted with [`crate::Machine::monitored`]; the monitor does not answer, or refuses.
    pub fn memory(&self, first: u32, bytes: u32) -> io::Result<Vec<u8>> {
        let monitor = self.monitor.as_ref().ok_or_else(|| io::Error::other("the board has no monitor"))?;
        memory::read(monitor, first, bytes)
    }

    /// The program's output, if it was asked for as a pipe; once.
    pub fn output(&mut self) -> Option<ChildStdout> {
        self.qemu.stdout.take()
    }

    /// Number of QEMU's process.
    pub fn id(&self) -> u32 {
        self.qemu.id()
    }

    /// That QEMU still runs.
    ///
    /// # Errors
    /// It does not; with its words.
    pub fn check(&mut self) -> Result<(), QemuError> {
        match self.qemu.try_wait()? {
            None => Ok(()),
            Some(status) => Err(QemuError::Ended { status: status.to_string(), words: self.words() }),
        }
    }

    /// That QEMU still runs, asked after something broke off: its end shows a little later than that of its sockets.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn check_after_close(&mut self) -> Result<(), QemuError> {
        sleep(CLOSING);
        self.check()
    }

    /// Tries until it succeeds, QEMU ends, or the time is up.
    ///
    /// # Errors
    /// QEMU has ended; the time is up, with the last refusal.
    pub fn until<T, E: std::fmt::Display>(
        &mut self,
        what: &'static str,
        patience: Duration,
        mut attempt: impl FnMut() -> Result<T, E>,
    ) -> Result<T, QemuError> {
        let end = Instant::now() + patience;
        loop {
            let refusal = match attempt() {
                Ok(done) => return Ok(done),
                Err(refusal) => refusal,
            };
            self.check()?;
            if Instant::now() > end {
                return Err(self.timeout(what, patience, &format!(": {refusal}")));
            }
            sleep(GLANCE);
        }
    }

    /// Waits for QEMU's end, doing something meanwhile; `None` after the time is up, and QEMU has ended either way.
    ///
    /// # Errors
    /// What is done meanwhile fails; the system gives no exit status.
    pub fn end(
        &mut self,
        patience: Option<Duration>,
        mut meanwhile: impl FnMut() -> io::Result<()>,
    ) -> Result<Option<ExitStatus>, QemuError> {
        let end = patience.map(|patience| Instant::now() + patience);
        loop {
            meanwhile()?;
            if let Some(status) = self.qemu.try_wait()? {
                return Ok(Some(status));
            }
            if end.is_some_and(|end| Instant::now() > end) {
                self.kill();
                return Ok(None);
            }
            sleep(GLANCE);
        }
    }

    /// An error for something that did not happen: that QEMU has ended, if so, else that the time is up.
    pub fn blame(&mut self, what: &'static str, waited: Duration) -> QemuError {
        self.check().err().unwrap_or_else(|| self.timeout(what, waited, ""))
    }

    fn timeout(&self, what: &'static str, waited: Duration, refusal: &str) -> QemuError {
        let said = match self.words().as_str() {
            "nothing" => String::new(),
            words => format!("; QEMU said:\n{words}"),
        };
        QemuError::Timeout { what, waited, hint: format!("{refusal}{said}") }
    }

    /// What QEMU wrote to standard error, shortened; `nothing` if it wrote nothing.
    pub fn words(&self) -> String {
        let mut bytes = vec![0; WORDS];
        // At a place, not by seeking: QEMU writes at the file's own place.
        let count = self.words.read_at(&mut bytes, 0).unwrap_or(0);
        let text = String::from_utf8_lossy(bytes.get(..count).unwrap_or_default());
        let lines: Vec<&str> = text.trim().lines().collect();
        match lines.as_slice() {
            [] => "nothing".to_owned(),
            [first @ .., last] if first.len() > 2 * SHOWN => {
                let (head, tail) = (first.get(..SHOWN), first.get(first.len() - SHOWN + 1..));
                format!("{}\n…\n{}\n{last}", head.unwrap_or_default().join("\n"), tail.unwrap_or_default().join("\n"))
            }
            all => all.join("\n"),
        }
    }

    fn kill(&mut self) {
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // The heir first: it must not end another process that has got QEMU's number.
        drop(self.heir.take());
        self.kill();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::{Command, Stdio};

    /// Any program in QEMU's place.
    fn running(script: &str) -> Running {
        let words = tempfile::tempfile().unwrap();
        let mut shell = Command::new("/bin/sh");
        shell.args(["-c", script]).stdin(Stdio::null()).stderr(words.try_clone().unwrap());
        Running::new(shell.spawn().unwrap(), words, None, None)
    }

    const SOON: Duration = Duration::from_millis(50);
    const LATE: Duration = Duration::from_secs(30);

    #[test]
    fn an_end_is_quoted() {
        let mut machine = running("echo 'rom: no room' >&2; exit 3");
        let error = machine.until("socket", LATE, || Err::<(), _>("refused")).unwrap_err().to_string();
        assert!(error.contains("exit status: 3") && error.contains("rom: no room"), "{error}");
    }

    #[test]
    fn what_does_not_happen_is_named_with_the_refusal() {
        let mut machine = running("exec sleep 100");
        let error = machine.until("socket", SOON, || Err::<(), _>("refused")).unwrap_err().to_string();
        assert!(error.starts_with("no socket within 50ms: refused"), "{error}");
        assert!(machine.check().is_ok());
        assert!(machine.end(Some(SOON), || Ok(())).unwrap().is_none());
        assert!(machine.check().is_err(), "ended when the time was up");
    }

    #[test]
    fn many_words_are_shortened_and_do_not_disturb_those_that_follow() {
        let mut machine = running("seq 1 30 >&2; sleep 0.3; echo end >&2");
        let before = machine.words();
        assert!(!before.contains("end"), "{before}");
        assert!(machine.end(Some(LATE), || Ok(())).unwrap().unwrap().success());
        let words = machine.words();
        assert!(words.starts_with("1\n2\n") && words.contains("8\n…\n") && words.ends_with("30\nend"), "{words}");
        assert_eq!(words.lines().count(), 17, "{words}");
    }
}
