//! A boot loader that waits at a port: name, version, erasing, writing, comparing, starting.

use std::io;
use std::time::{Duration, Instant};

use super::frame::{Decoder, FLUSH};
use super::message::{Acknowledgement, Kind, checksum};
use super::{LoaderError, Patience};
use crate::link::Port;

/// Bytes of a piece, which is one message.
const PIECE: usize = 128;
/// Bytes that are written at once.
const BLOCK: usize = 8 * 1024;
/// How often a block is sent before it counts as impossible.
const TRIES: usize = 3;
/// The flash differs from what was to be written.
const DIFFERS: u16 = 0x0019;
/// Asks for an answer.
const ANSWER: u8 = 1;

/// What a loader says of itself.
pub(super) struct Identity {
    /// The board.
    pub(super) name: String,
    /// The loader's version.
    pub(super) version: u32,
}

/// A boot loader at a port.
pub(super) struct Session {
    port: Port,
    decoder: Decoder,
    sequence: u8,
    patience: Patience,
}

impl Session {
    /// Asks who is there. Whatever came before does not count as a begun message.
    pub(super) fn identify(port: Port, patience: Patience) -> io::Result<Option<(Self, Identity)>> {
        let mut session = Self { port, decoder: Decoder::default(), sequence: 0, patience };
        session.port.send(&FLUSH)?;
        let Some(name) = session.ask(Kind::Name, &[&[ANSWER]], patience.answer)? else { return Ok(None) };
        let Some(version) = session.ask(Kind::Version, &[&[ANSWER]], patience.answer)? else { return Ok(None) };
        let version = version.data.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
        let name = String::from_utf8_lossy(&name.data).into_owned();
        Ok(Some((session, Identity { name, version })))
    }

    /// Sends a message.
    fn say(&mut self, kind: Kind, fields: &[&[u8]]) -> io::Result<()> {
        let bytes = kind.frame(fields).bytes(self.sequence);
        self.sequence = self.sequence.wrapping_add(1);
        self.port.send(&bytes)
    }

    /// Sends a message and waits for its answer.
    fn ask(&mut self, kind: Kind, fields: &[&[u8]], longest: Duration) -> io::Result<Option<Acknowledgement>> {
        self.say(kind, fields)?;
        let end = Instant::now() + longest;
        let mut chunk = [0; 256];
        loop {
            while let Some(frame) = self.decoder.frame() {
                if let Some(answer) = Acknowledgement::read(&frame).filter(|answer| answer.of == kind.number()) {
                    return Ok(Some(answer));
                }
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            match self.port.receive(&mut chunk, left)? {
                Some(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
                count => self.decoder.feed(&chunk[..count.unwrap_or(0)]),
            }
        }
    }

    /// The same; an error of the loader or none at all is one here.
    fn order(
        &mut self,
        kind: Kind,
        fields: &[&[u8]],
        longest: Duration,
        doing: &'static str,
    ) -> Result<Acknowledgement, LoaderError> {
        match self.ask(kind, fields, longest) {
            Ok(Some(answer)) if answer.error == 0 => Ok(answer),
            Ok(Some(answer)) => {
                let hint =
                    if answer.error == DIFFERS { ": the flash differs from the image; flash it again" } else { "" };
                Err(LoaderError::Refused { doing, error: answer.error, hint })
            }
            Ok(None) | Err(_) => Err(LoaderError::Lost { doing }),
        }
    }

    /// Erases the flash that a program of this length takes.
    pub(super) fn erase(&mut self, bytes: usize) -> Result<(), LoaderError> {
        let length = (bytes as u32).to_le_bytes();
        self.order(Kind::Erase, &[&length, &[ANSWER]], self.patience.erase, "erasing").map(drop)
    }

    /// Writes a program; `at` gets how many bytes are written.
    pub(super) fn write(
        &mut self,
        program: &[u8],
        mut at: impl FnMut(usize) -> io::Result<()>,
    ) -> Result<(), LoaderError> {
        for (number, block) in program.chunks(BLOCK).enumerate() {
            let place = number * BLOCK;
            let mut tries = 1;
            while let Err(error) = self.block(place as u32, block) {
                if tries == TRIES {
                    return Err(error);
                }
                tries += 1;
            }
            at(place + block.len())?;
        }
        Ok(())
    }

    /// Sends a block and has it written once all of it is there: flash takes each word once.
    fn block(&mut self, place: u32, block: &[u8]) -> Result<(), LoaderError> {
        const DOING: &str = "writing";
        let longest = self.patience.answer;
        self.order(Kind::Begin, &[&[ANSWER]], longest, DOING)?;
        for (number, piece) in block.chunks(PIECE).enumerate() {
            let place = ((number * PIECE) as u16).to_le_bytes();
            let head = [place[0], place[1], 0, piece.len() as u8];
            self.say(Kind::Piece, &[&head, piece]).map_err(|_| LoaderError::Lost { doing: DOING })?;
        }
        let counted = self.order(Kind::End, &[&[ANSWER]], longest, DOING)?;
        let arrived = counted.data.get(2..6).and_then(|bytes| bytes.try_into().ok()).map(u32::from_le_bytes);
        if arrived != Some(block.len() as u32) {
            return Err(LoaderError::Lost { doing: "pieces of a block are sent" });
        }
        let length = (block.len() as u16).to_le_bytes();
        self.order(Kind::Block, &[&place.to_le_bytes(), &length, &[ANSWER]], longest, DOING).map(drop)
    }

    /// The loader compares its flash with this program.
    pub(super) fn verify(&mut self, program: &[u8]) -> Result<(), LoaderError> {
        let (length, sum) = ((program.len() as u32).to_le_bytes(), checksum(program).to_le_bytes());
        self.order(Kind::Verify, &[&length, &sum, &[ANSWER]], self.patience.answer, "comparing").map(drop)
    }

    /// Starts the program. The loader is gone then and does not answer.
    pub(super) fn start(mut self) -> Result<(), LoaderError> {
        self.say(Kind::Start, &[&[0]]).map_err(|_| LoaderError::Lost { doing: "the program is started" })
    }
}
