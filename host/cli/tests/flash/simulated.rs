//! A simulated OpenCR on a pseudo-terminal: a gripper's program, which restarts into a boot loader when it is called.

use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use fre_gripper::loader::{Acknowledgement, Decoder, Frame, Kind, checksum};
use messages::{GetVersion, Version, frame};
use model_core::size::Lists;
use postcard_rpc::Endpoint;
use postcard_rpc::header::{VarHeader, VarKey};
use rustix::fs::{Mode, OFlags, fcntl_getfl, fcntl_setfl, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// Bytes of the flash for programs, of one of its sectors, and of the loader's memory.
const FLASH: usize = 768 * 1024;
pub const SECTOR: usize = 256 * 1024;
const ROOM: usize = 16 * 1024;
/// Where a test's program has its version.
pub const PLACE: usize = 64;

/// What goes wrong with a board.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faults {
    /// Pieces that get lost, the first ones.
    pub lost_pieces: usize,
    /// A bit of flash is stuck.
    pub stuck: bool,
    /// The program does not answer when it is started.
    pub mute: bool,
    /// The program takes no call.
    pub deaf: bool,
}

/// A board: what its program is, its flash, and what came to its loader.
pub struct Simulated {
    program: Option<(&'static str, String)>,
    pub name: &'static str,
    pub flash: Vec<u8>,
    pub faults: Faults,
    /// The pieces of a block, and how many bytes came since writing began.
    block: Vec<u8>,
    arrived: usize,
}

impl Simulated {
    /// A board whose program is another board's or this one's, of a version; without one its loader waits.
    pub fn new(program: Option<(&'static str, &str)>) -> Self {
        Self {
            program: program.map(|(board, version)| (board, version.to_owned())),
            name: "OpenCR R1.0",
            flash: vec![0; FLASH],
            faults: Faults::default(),
            block: Vec::new(),
            arrived: 0,
        }
    }

    /// The program hears: its answers, and whether it restarts into the loader.
    fn run(&mut self, heard: &mut frame::Decoder, bytes: &[u8], rate: u32) -> (Vec<u8>, bool) {
        if rate == 1200 {
            return (Vec::new(), !self.faults.deaf && bytes.ends_with(b"OpenCR 5555AAAA"));
        }
        let (mut rest, mut answers) = (bytes, Vec::new());
        while let Some(event) = heard.feed(&mut rest) {
            let Some((header, _)) = event.ok().and_then(|bytes| VarHeader::take_from_slice(bytes)) else { continue };
            if let Some((board, firmware)) = self.program.as_ref().filter(|_| !self.faults.mute) {
                let short = |words: &str| heapless::String::try_from(words).unwrap();
                let (firmware, board) = (short(firmware), short(board));
                let version = Version { protocol: 1, firmware, fingers: 2, board, cost_hz: 1, lists: Lists::RIBS };
                let header = VarHeader { key: VarKey::Key8(GetVersion::RESP_KEY), seq_no: header.seq_no };
                let (mut scratch, mut line) = ([0; frame::MESSAGE], [0; frame::FRAME]);
                let message = frame::message(&header, &version, &mut scratch).unwrap();
                answers.extend(frame::encode(message, &mut line).unwrap());
            }
        }
        (answers, false)
    }

    /// The loader hears a message: its answer, if it gives one, and whether it starts the program.
    fn load(&mut self, message: &Frame) -> (Option<Acknowledgement>, bool) {
        let payload = &message.payload;
        let word = |at: usize| u32::from_le_bytes(payload[at..at + 4].try_into().unwrap()) as usize;
        let (mut error, mut data, mut wants_answer) = (0, Vec::new(), payload[0] == 1);
        match message.kind {
            Kind::Name => data = self.name.as_bytes().to_vec(),
            Kind::Version => data = [0x1702_0800_u32.to_le_bytes(), [0; 4]].concat(),
            Kind::Begin => (self.block, self.arrived) = (Vec::new(), 0),
            Kind::End => {
                let pieces = (self.arrived.div_ceil(128) as u16).to_le_bytes();
                data = [&pieces[..], &(self.arrived as u32).to_le_bytes()].concat();
            }
            Kind::Piece => {
                wants_answer = payload[2] == 1;
                if self.faults.lost_pieces > 0 {
                    self.faults.lost_pieces -= 1;
                } else {
                    self.block.extend(&payload[4..4 + usize::from(payload[3])]);
                    self.arrived += usize::from(payload[3]);
                    assert!(self.block.len() <= ROOM, "more than the loader has room for");
                }
            }
            Kind::Block => {
                wants_answer = payload[6] == 1;
                let (place, length) = (word(0), usize::from(u16::from_le_bytes([payload[4], payload[5]])));
                assert_eq!(length, self.block.len(), "the loader writes what lies in its memory");
                for (flash, byte) in self.flash[place..place + length].iter_mut().zip(&self.block) {
                    assert_eq!(*flash, 0xff, "flash is written once after it is erased");
                    *flash = *byte;
                }
                self.block.clear();
            }
            Kind::Erase => {
                wants_answer = payload[4] == 1;
                let end = word(0).next_multiple_of(SECTOR);
                self.flash[..end].fill(0xff);
                if end < FLASH {
                    assert_eq!(self.flash[end], 0, "only what is needed is erased");
                }
            }
            Kind::Verify => {
                wants_answer = payload[8] == 1;
                self.flash[200] ^= u8::from(self.faults.stuck);
                error = if checksum(&self.flash[..word(0)]) as usize == word(4) { 0 } else { 0x19 };
            }
            Kind::Start => {
                let version = self.flash[PLACE..].split(|byte| *byte == 0).next().unwrap();
                self.program = Some(("opencr", String::from_utf8(version.to_vec()).unwrap()));
                return (None, true);
            }
            Kind::Acknowledgement => panic!("nobody asks for that"),
        }
        (wants_answer.then(|| Acknowledgement { of: message.kind.number(), error, data }), false)
    }
}

/// The board at work, and the port it is at.
pub struct Plugged {
    pub port: String,
    pub board: Arc<Mutex<Simulated>>,
    pulled: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Plugged {
    fn drop(&mut self) {
        self.pulled.store(true, Ordering::Release);
        // A panic in there is the test's.
        let ended = self.thread.take().unwrap().join();
        assert!(ended.is_ok() || thread::panicking(), "the simulated board was not content");
    }
}

/// Plugs it in.
pub fn plug(board: Simulated) -> Plugged {
    let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&controller).unwrap();
    unlockpt(&controller).unwrap();
    let port = ptsname(&controller, Vec::new()).unwrap().to_str().unwrap().to_owned();
    let peer = open(&port, OFlags::RDWR | OFlags::NOCTTY, Mode::empty()).unwrap();
    let mut raw = tcgetattr(&peer).unwrap();
    raw.make_raw();
    tcsetattr(&peer, OptionalActions::Now, &raw).unwrap();
    fcntl_setfl(&controller, fcntl_getfl(&controller).unwrap() | OFlags::NONBLOCK).unwrap();
    let (board, pulled) = (Arc::new(Mutex::new(board)), Arc::<AtomicBool>::default());
    let (inside, stop) = (board.clone(), pulled.clone());
    let thread = thread::spawn(move || work(&inside, &stop, File::from(controller), &peer));
    Plugged { port, board, pulled, thread: Some(thread) }
}

fn work(board: &Mutex<Simulated>, stop: &AtomicBool, mut wire: File, peer: &OwnedFd) {
    let mut loads = board.lock().unwrap().program.is_none();
    let (mut messages, mut heard, mut chunk) = (Decoder::default(), frame::Decoder::new(), [0; 4096]);
    while !stop.load(Ordering::Acquire) {
        let Ok(count @ 1..) = wire.read(&mut chunk) else {
            thread::sleep(Duration::from_millis(1));
            continue;
        };
        let mut board = board.lock().unwrap();
        if loads {
            messages.feed(&chunk[..count]);
            while let Some(message) = messages.frame() {
                let (answer, starts) = board.load(&message);
                if let Some(answer) = answer {
                    wire.write_all(&answer.frame().bytes(0)).unwrap();
                }
                loads &= !starts;
            }
        } else {
            let rate = tcgetattr(peer).unwrap().output_speed();
            let (answers, restarts) = board.run(&mut heard, &chunk[..count], rate);
            wire.write_all(&answers).unwrap();
            loads = restarts;
        }
    }
}
