//! An update: which program runs, the way to the loader, the new image, which program runs then.

use std::io::{self, Write};
use std::thread;
use std::time::{Duration, Instant};

use super::LoaderError;
use super::session::{Identity, Session};
use crate::link::{Address, Link, LinkError, Port};
use crate::probe::{Board, Image};

/// How long is waited.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// For an answer of program or loader.
    pub answer: Duration,
    /// Until all of the flash is erased.
    pub erase: Duration,
    /// Until a port is there again after the board has started anew.
    pub start: Duration,
}

impl Default for Patience {
    fn default() -> Self {
        Self {
            answer: Duration::from_secs(2),
            // Three sectors of 256 KB, four seconds each at most.
            erase: Duration::from_secs(20),
            start: Duration::from_secs(15),
        }
    }
}

/// The rate that calls the loader, and the words that go with it.
const CALL: (u32, &[u8]) = (1200, b"OpenCR 5555AAAA");
/// Between two attempts.
const PAUSE: Duration = Duration::from_millis(200);
/// Programs are written in units of so many bytes.
const UNIT: usize = 128;
/// What erased flash holds.
const ERASED: u8 = 0xFF;

/// Writes an image into a board's flash by its boot loader and starts it; `out` gets a line per step and percent in between.
///
/// # Errors
/// An image or a board that is not the one meant, before anything is written; a loader that does not do what is asked; a program that
/// does not answer afterwards.
pub fn update(
    board: &Board,
    image: &Image,
    port: &str,
    patience: Patience,
    out: &mut dyn Write,
) -> Result<(), LoaderError> {
    image.fits(board)?;
    let name = board.loader.ok_or(LoaderError::NoLoader { board: board.name })?;
    let wanted = image.version().unwrap_or_default();
    let program = flat(board, image);
    writeln!(out, "image: {}, version {wanted}, {} bytes", board.name, program.len())?;

    let before = version(port, patience.answer, Duration::ZERO);
    let other = |found: String| LoaderError::OtherBoard { port: port.to_owned(), found, board: board.name };
    match &before {
        Ok(before) if before.board != board.name => return Err(other(before.board.to_string())),
        Ok(before) => writeln!(out, "before: gripper on {}, version {}", before.board, before.firmware)?,
        Err(_) => writeln!(out, "before: no gripper's program answers")?,
    }
    let (mut session, found) = reach(port, before.is_ok(), patience)?;
    if found.name != name {
        return Err(other(format!("the boot loader of `{}`", found.name)));
    }
    writeln!(out, "boot loader: {}, version {:08x}", found.name, found.version)?;
    writeln!(out, "erasing")?;
    session.erase(program.len())?;
    writeln!(out, "writing")?;
    let mut shown = 0;
    session.write(&program, |bytes| {
        let percent = bytes * 100 / program.len();
        if percent < shown + 10 {
            return Ok(());
        }
        shown = percent;
        writeln!(out, "  {percent:>3} %")
    })?;
    session.verify(&program)?;
    writeln!(out, "the flash holds the image")?;
    session.start()?;
    // Whoever opens a port throws away what its program has not read yet.
    thread::sleep(PAUSE);
    let after = version(port, patience.answer, patience.start).map_err(|source| LoaderError::NotStarted {
        board: board.name,
        port: port.to_owned(),
        source: Box::new(source),
    })?;
    if after.firmware != wanted {
        let found = after.firmware.to_string();
        return Err(LoaderError::OtherVersion { port: port.to_owned(), found, wanted: wanted.to_owned() });
    }
    writeln!(out, "after: gripper on {}, version {}", after.board, after.firmware)?;
    Ok(())
}

/// The image as the loader writes it: from the start of the flash for programs on, in whole units.
fn flat(board: &Board, image: &Image) -> Vec<u8> {
    let mut program = Vec::new();
    for piece in image.pieces() {
        // All pieces lie in that flash.
        let place = (piece.address - board.flash.0) as usize;
        let end = place + piece.bytes.len();
        program.resize(program.len().max(end), ERASED);
        program[place..end].copy_from_slice(&piece.bytes);
    }
    program.resize(program.len().next_multiple_of(UNIT), ERASED);
    program
}

/// Which gripper answers at a port; asked again until so much time has passed.
fn version(port: &str, answer: Duration, longest: Duration) -> Result<messages::Version, LinkError> {
    let address = port.parse::<Address>()?;
    let end = Instant::now() + longest;
    loop {
        let asked = Link::open(&address).and_then(|mut link| {
            link.set_patience(answer);
            link.version()
        });
        match asked {
            Err(_) if Instant::now() < end => thread::sleep(PAUSE),
            asked => return asked,
        }
    }
}

/// Finds the loader. A program that answered, or any other one if no loader waits, is called to restart into it.
fn reach(port: &str, is_running: bool, patience: Patience) -> Result<(Session, Identity), LoaderError> {
    let failed = |source| LoaderError::Port { port: port.to_owned(), source };
    if !is_running
        && let Some(found) = Session::identify(open(port, None).map_err(failed)?, patience).map_err(failed)?
    {
        return Ok(found);
    }
    let mut caller = open(port, Some(CALL.0)).map_err(failed)?;
    caller.send(CALL.1).map_err(failed)?;
    drop(caller);
    let end = Instant::now() + patience.start;
    // A port that goes away and comes again is what is waited for.
    while Instant::now() < end {
        thread::sleep(PAUSE);
        if let Ok(port) = open(port, None)
            && let Ok(Some(found)) = Session::identify(port, patience)
        {
            return Ok(found);
        }
    }
    Err(LoaderError::Silent { port: port.to_owned(), waited: patience.start })
}

fn open(port: &str, baud: Option<u32>) -> io::Result<Port> {
    let address = match port.parse::<Address>().map_err(|error| io::Error::other(error.to_string()))? {
        Address::Serial { path, baud: own } => Address::Serial { path, baud: baud.unwrap_or(own) },
        other => return Err(io::Error::other(format!("{other} is not a serial port"))),
    };
    Port::connect(&address)
}
