//! How a command ends: its exit status, and what it says on standard error. Every line there that is not a table begins with `fre: `.

use std::io::{ErrorKind, Write as _};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU8, Ordering};

/// Bad input: the message on standard error says what and where.
pub const BAD_INPUT: u8 = 1;
/// Some angle has no trustworthy solution.
pub const UNTRUSTWORTHY: u8 = 2;
/// What a shell sees of a program that was stopped from the keyboard.
pub const INTERRUPTED: u8 = 130;

/// How much a command says besides results and errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Volume {
    /// Nothing.
    Quiet,
    /// Notes, warnings and progress.
    Usual,
    /// Also files that are read and written, the model and its time.
    Verbose,
}

/// The volume of this process, set once at the beginning.
static VOLUME: AtomicU8 = AtomicU8::new(Volume::Usual as u8);

impl Volume {
    /// Sets it for the whole program.
    pub fn set(self) {
        VOLUME.store(self as u8, Ordering::Relaxed);
    }

    /// Whether this process says what belongs to this volume.
    pub fn is_on(self) -> bool {
        self as u8 <= VOLUME.load(Ordering::Relaxed)
    }
}

/// Writes a line to standard error, unless the program is to be quiet. Where nobody reads it any more the line is lost, and the work
/// goes on.
macro_rules! tell {
    ($($words:tt)*) => {{
        if $crate::exit::Volume::Usual.is_on() {
            use std::io::Write as _;
            let _ = writeln!(std::io::stderr(), $($words)*);
        }
    }};
}
pub(crate) use tell;

/// The same for what a command says on request (`--verbose`) only.
macro_rules! detail {
    ($($words:tt)*) => {{
        if $crate::exit::Volume::Verbose.is_on() {
            $crate::exit::tell!($($words)*);
        }
    }};
}
pub(crate) use detail;

/// What an error begins with, in red where the terminal has colours and nobody asked for none (`NO_COLOR`).
const PREFIX: &str = "\u{1b}[1;31mfre:\u{1b}[0m";

/// Says on standard error what was wrong with the input.
pub fn bad_input(error: &dyn std::fmt::Display) -> ExitCode {
    let _ = writeln!(anstream::stderr(), "{PREFIX} {error}");
    ExitCode::from(BAD_INPUT)
}

/// Says what was wrong with the arguments, or shows the help that was asked for.
pub fn arguments(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        let mut out = anstream::stdout();
        let shown = write!(out, "{}", error.render().ansi()).and_then(|()| out.flush());
        return match shown {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => bad_input(&format!("standard output: {error}")),
            _ => ExitCode::SUCCESS,
        };
    }
    let text = error.render().ansi().to_string();
    // The library begins with a word of its own, in its style.
    let text = match text.split_once("error:") {
        Some((style, rest)) if !style.contains('\n') => {
            format!("{PREFIX}{}", rest.strip_prefix("\u{1b}[0m").unwrap_or(rest))
        }
        _ => text,
    };
    let _ = write!(anstream::stderr(), "{text}");
    ExitCode::from(BAD_INPUT)
}

/// The status of a command whose results are all trustworthy, or not.
pub fn trusted(all: bool) -> ExitCode {
    if all { ExitCode::SUCCESS } else { ExitCode::from(UNTRUSTWORTHY) }
}
