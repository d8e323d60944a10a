//! A board behind a debug probe, through probe-rs.

use std::io::Write;
use std::thread;
use std::time::{Duration, Instant};

use probe_rs::flashing::{DownloadOptions, FlashProgress, ProgressEvent, ProgressOperation};
use probe_rs::probe::DebugProbeSelector;
use probe_rs::probe::list::Lister;
use probe_rs::rtt::Rtt;
use probe_rs::{Permissions, Session};

use super::{Board, Image, ProbeError};

/// How often the log is fetched. The target's buffer holds a kilobyte.
const GLANCE: Duration = Duration::from_millis(10);
/// How long a program may take to set up its log.
const BOOT: Duration = Duration::from_secs(3);

fn failed<E: std::error::Error>(doing: &'static str, hint: &'static str) -> impl FnOnce(E) -> ProbeError {
    move |error| {
        // probe-rs' errors tell the cause in their sources.
        let mut why = error.to_string();
        let mut cause = error.source();
        while let Some(error) = cause {
            why += &format!(": {error}");
            cause = error.source();
        }
        ProbeError::Probe { doing, why, hint }
    }
}

/// Connects to a board's chip, by the one probe there is or the one that is selected (`VID:PID[:SERIAL]`).
fn attach(board: &Board, selector: Option<&DebugProbeSelector>) -> Result<Session, ProbeError> {
    let lister = Lister::new();
    let found = lister.list(selector);
    let probe = match found.as_slice() {
        [] => return Err(ProbeError::NoProbe { devices: usb_devices(), needed: board.probe }),
        [probe] => probe,
        several => {
            return Err(ProbeError::SeveralProbes { found: several.iter().map(ToString::to_string).collect() });
        }
    };
    let hint = "; does another debugger have it, and may this user open it?";
    let probe = probe.open().map_err(failed("the probe cannot be opened", hint))?;
    let hint =
        "; is the board powered, is it this board, and are SWDIO, SWCLK, GND and the reference voltage connected?";
    probe.attach(board.chip, Permissions::default()).map_err(failed("the chip does not answer", hint))
}

/// How many USB devices the system shows: whether there is USB at all.
fn usb_devices() -> String {
    match std::fs::read_dir("/sys/bus/usb/devices") {
        Ok(entries) => entries.flatten().filter(|entry| entry.path().join("idVendor").exists()).count().to_string(),
        Err(_) => "no visible".to_owned(),
    }
}

/// Writes an image into a board's flash, reads it back, and starts it; `out` gets a line per step and percent in between.
///
/// # Errors
/// No probe, no chip, or flash that does not take or keep the image.
pub fn flash(
    board: &Board,
    image: &Image,
    selector: Option<&DebugProbeSelector>,
    out: &mut dyn Write,
) -> Result<(), ProbeError> {
    image.fits(board)?;
    let mut session = attach(board, selector)?;
    let mut loader = session.target().flash_loader();
    for piece in image.pieces() {
        loader.add_data(piece.address, &piece.bytes).map_err(failed("the image does not fit", ""))?;
    }
    let mut steps = Steps { out, now: None, done: 0, total: 0, shown: 0 };
    let mut options = DownloadOptions::new();
    options.verify = true;
    options.progress = FlashProgress::new(|event| steps.take(event));
    let hint = "; the board's program is incomplete now: flash it again";
    loader.commit(&mut session, options).map_err(failed("flashing failed", hint))?;
    let reset = |session: &mut Session| session.core(0)?.reset();
    reset(&mut session).map_err(failed("the program cannot be started", ""))
}

/// Shows progress.
struct Steps<'a> {
    out: &'a mut dyn Write,
    now: Option<ProgressOperation>,
    done: u64,
    total: u64,
    shown: u64,
}

impl Steps<'_> {
    fn take(&mut self, event: ProgressEvent) {
        // Whoever reads the progress may stop reading; flashing goes on.
        let _ = match event {
            ProgressEvent::AddProgressBar { operation, total } => {
                if matches!(operation, ProgressOperation::Program) {
                    self.total = total.unwrap_or(0);
                }
                Ok(())
            }
            ProgressEvent::Started(operation) => {
                (self.now, self.done, self.shown) = (Some(operation), 0, 0);
                writeln!(self.out, "{}", name(operation))
            }
            ProgressEvent::Progress { operation, size, .. } => {
                self.done += size;
                let percent = (self.done * 100).checked_div(self.total).unwrap_or(0).min(100);
                if matches!(operation, ProgressOperation::Program) && percent >= self.shown + 10 {
                    self.shown = percent;
                    writeln!(self.out, "  {percent:>3} %")
                } else {
                    Ok(())
                }
            }
            ProgressEvent::Failed(operation) => writeln!(self.out, "{}: failed", name(operation)),
            ProgressEvent::Finished(ProgressOperation::Verify) => writeln!(self.out, "the flash holds the image"),
            ProgressEvent::DiagnosticMessage { message } => writeln!(self.out, "  {}", message.trim_end()),
            ProgressEvent::FlashLayoutReady { .. } | ProgressEvent::Finished(_) => Ok(()),
        };
    }
}

fn name(operation: ProgressOperation) -> &'static str {
    match operation {
        ProgressOperation::Fill => "reading what is kept",
        ProgressOperation::Erase => "erasing",
        ProgressOperation::Program => "writing",
        ProgressOperation::Verify => "reading back",
    }
}

/// Writes a running board's log line by line, for so long or for ever. The program is not stopped.
///
/// # Errors
/// No probe or chip; a program on it that is not this image; nothing to write to.
pub fn log(
    board: &Board,
    image: &Image,
    selector: Option<&DebugProbeSelector>,
    longest: Option<Duration>,
    out: &mut dyn Write,
) -> Result<(), ProbeError> {
    let log = image.log()?;
    let Some(address) = image.rtt() else {
        return Err(ProbeError::BadImage { path: image.path().to_owned(), why: "it does not log over RTT".to_owned() });
    };
    let mut session = attach(board, selector)?;
    let mut core = session.core(0).map_err(failed("the processor does not answer", ""))?;
    let start = Instant::now();
    let mut rtt = loop {
        match Rtt::attach_at(&mut core, address) {
            Ok(rtt) => break rtt,
            Err(_) if start.elapsed() < BOOT => thread::sleep(GLANCE),
            Err(error) => {
                let hint = "; does this image run on the board? `fre flash` puts it there";
                return Err(failed("the log is not there", hint)(error));
            }
        }
    };
    let mut lines = log.decoder();
    let mut buffer = [0; 1024];
    while longest.is_none_or(|longest| start.elapsed() < longest) {
        let channel = rtt.up_channel(0);
        let count = match channel {
            Some(channel) => channel.read(&mut core, &mut buffer).map_err(failed("the log cannot be fetched", ""))?,
            None => 0,
        };
        for line in lines.feed(&buffer[..count]) {
            writeln!(out, "{line}").map_err(|source| ProbeError::Log { doing: "written", source })?;
        }
        if count == 0 {
            out.flush().map_err(|source| ProbeError::Log { doing: "written", source })?;
            thread::sleep(GLANCE);
        }
    }
    Ok(())
}

/// Reads `VID:PID[:SERIAL]`, which selects one of several probes; none selects the only one.
///
/// # Errors
/// Words that name no probe.
pub fn selector(words: Option<&str>) -> Result<Option<DebugProbeSelector>, ProbeError> {
    let parsed = words.map(str::parse::<DebugProbeSelector>).transpose();
    parsed.map_err(|error| ProbeError::Probe {
        doing: "--probe",
        why: error.to_string(),
        hint: "; allowed is VID:PID or VID:PID:SERIAL, the numbers hexadecimal",
    })
}
