//! The listening side of the bus: learns from another master's traffic what the servos do, and never speaks.

mod indirect;
mod watched;

pub use watched::{Seen, Watched};

use crate::decode::DecodeError;
use crate::fast::{FastAnswer, Step};
use crate::line::{Line, Spoken};
use crate::models::Model;
use crate::packet::{ALERT, Id, Instruction, Packet, Status, StatusError, longest_packet_length, status_length};
use crate::request::Request;
use crate::timing::Timing;

/// Bytes of noise (a line that is turned around makes some) between a question and its answer that cannot have been part
/// of a further question: no packet has as few.
const NOISE: u32 = 2;

/// What was heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Heard<'a> {
    /// A servo has sent a part of its control table.
    Read {
        /// Who.
        id: Id,
        /// From where on.
        address: u16,
        /// What.
        bytes: &'a [u8],
        /// It has a hardware error.
        alert: bool,
    },
    /// A servo has taken a write; of a broadcast, every servo that heard it may have.
    Written {
        /// Who.
        id: Id,
        /// From where on.
        address: u16,
        /// What.
        bytes: &'a [u8],
    },
    /// A servo has sent its model.
    Found {
        /// Who.
        id: Id,
        /// Model number.
        model: u16,
        /// Version of its firmware.
        firmware: u8,
    },
    /// A servo has refused.
    Refused {
        /// Who.
        id: Id,
        /// Why.
        error: StatusError,
        /// It has a hardware error.
        alert: bool,
    },
    /// An answer to a question that was not heard, or that came too late to be one for certain. It teaches nothing.
    Stray {
        /// Who answered; of the answer to a fast read, the broadcast address.
        id: Id,
    },
    /// What came was damaged. Answers that come before the next question teach nothing.
    Damaged(DecodeError),
}

/// Follows another master's questions and the answers to them. `N` bounds packets in bytes, `S` the servos watched.
///
/// An answer has no address in the control table; its question has. So a value is taken from an answer only if it is the
/// answer to the last question heard, for certain: from a servo that was asked and has not answered, in the order in which
/// several were asked, of the length asked for, in time, and with nothing damaged in between. In the answer to a fast read
/// each block counts as soon as its CRC has come.
///
/// What remains is a master that asks the same servo for as many bytes from elsewhere in a question that leaves no trace
/// on the line, within the time of the answer to the one before, which did not come.
///
/// The registers are those of each servo's [`Model`]. Indirect data count as what they show once the tap has heard
/// the indirect addresses, written or read. Until then they count as nothing, and again when the servo may have been
/// restarted, or got an instruction that the tap has not understood; what leaves no trace on the line (a Sync Write that is
/// lost whole) it cannot know.
///
/// ```
/// use dynamixel::{Heard, Id, Tap, Timing};
/// let one = Id::new(1).unwrap();
/// let mut tap = Tap::<64, 4>::new(Timing::at(1_000_000));
/// assert!(tap.watch(one));
/// // A read of Present Position, and its answer 280 µs later.
/// let mut question: &[u8] = &[0xFF, 0xFF, 0xFD, 0, 1, 7, 0, 0x02, 0x84, 0, 4, 0, 0x1D, 0x15];
/// assert_eq!(tap.hear(1_000, &mut question), None);
/// let mut answer: &[u8] = &[0xFF, 0xFF, 0xFD, 0, 1, 8, 0, 0x55, 0, 0xA6, 0, 0, 0, 0x8C, 0xC0];
/// assert!(matches!(tap.hear(1_280, &mut answer), Some(Heard::Read { address: 132, .. })));
/// let position = tap.servo(one).unwrap().position.unwrap();
/// assert_eq!((position.value, position.age_us(1_500)), (166, 220));
/// ```
#[derive(Clone, Debug)]
pub struct Tap<const N: usize, const S: usize> {
    line: Line<N>,
    state: State<N, S>,
}

#[derive(Clone, Debug)]
struct State<const N: usize, const S: usize> {
    timing: Timing,
    request: Request<N>,
    /// The first entry of the request that has not answered.
    next: usize,
    /// When the question, or the last answer to it, was heard, µs.
    since_us: u64,
    /// [`Line::skipped`] then.
    skipped: u32,
    fast: FastAnswer,
    /// The last question has been answered by a fast answer.
    followed: bool,
    /// Something damaged came where a question was to come.
    lost: bool,
    /// Bytes of what was heard.
    data: [u8; N],
    servos: [Option<Watched>; S],
}

/// [`Heard`], with the bytes in [`State::data`].
#[derive(Clone, Copy)]
enum Event {
    Read { id: Id, address: u16, length: usize, alert: bool },
    Written { id: Id, address: u16, length: usize },
    Found { id: Id, model: u16, firmware: u8 },
    Refused { id: Id, error: StatusError, alert: bool },
    Stray { id: Id },
    Damaged(DecodeError),
}

impl<const N: usize, const S: usize> Tap<N, S> {
    /// A tap that has heard nothing. The timing says when an answer is late, and whether writes are answered.
    pub const fn new(timing: Timing) -> Self {
        Self {
            line: Line::new(),
            state: State {
                timing,
                request: Request::NONE,
                next: 0,
                since_us: 0,
                skipped: 0,
                fast: FastAnswer::new(0),
                followed: false,
                lost: false,
                data: [0; N],
                servos: [const { None }; S],
            },
        }
    }

    /// Changes when an answer counts as late, as after a change of the baud rate.
    pub fn set_timing(&mut self, timing: Timing) {
        self.state.timing = timing;
    }

    /// Learns from this servo from now on; false if there is no room for it. Its registers are read as those of [`Model::ASSUMED`], until
    /// it answers its master with the number of another known model.
    pub fn watch(&mut self, id: Id) -> bool {
        self.watch_model(id, Model::ASSUMED)
    }

    /// The same; its registers count as this model's from the start.
    pub fn watch_model(&mut self, id: Id, model: &'static Model) -> bool {
        if id.is_broadcast() || self.servo(id).is_some() {
            return !id.is_broadcast();
        }
        let free = self.state.servos.iter_mut().find(|servo| servo.is_none());
        free.map(|servo| *servo = Some(Watched::new(id, model))).is_some()
    }

    /// Watches no servo any more.
    pub fn forget(&mut self) {
        self.state.servos.fill(None);
    }

    /// What is known of a servo that is watched.
    pub fn servo(&self, id: Id) -> Option<&Watched> {
        self.servos().find(|servo| servo.id == id)
    }

    /// The servos watched.
    pub fn servos(&self) -> impl Iterator<Item = &Watched> {
        self.state.servos.iter().flatten()
    }

    /// Takes bytes heard at `now_us` from the front of `input` until they say something; nothing means that all are taken.
    pub fn hear(&mut self, now_us: u64, input: &mut &[u8]) -> Option<Heard<'_>> {
        let Tap { line, state } = self;
        line.at(state.timing.began_us(now_us, input.len()), state.timing.pause_us());
        let event = loop {
            let spoken = if state.request.is_fast() { line.settle() } else { Some(line.take(now_us, input)?) };
            if let Some(spoken) = spoken {
                match state.spoken(spoken, now_us) {
                    Some(event) => break event,
                    None => continue,
                }
            }
            // The blocks of a fast answer count one by one.
            let (&byte, rest) = input.split_first()?;
            *input = rest;
            let block = state.follow(byte, line.skipped(), now_us);
            let event = line.byte(now_us, byte).and_then(|spoken| state.spoken(spoken, now_us));
            if let Some(event) = block.or(event) {
                break event;
            }
        };
        let bytes = |length| self.state.data.get(..length).unwrap_or_default();
        Some(match event {
            Event::Read { id, address, length, alert } => Heard::Read { id, address, bytes: bytes(length), alert },
            Event::Written { id, address, length } => Heard::Written { id, address, bytes: bytes(length) },
            Event::Found { id, model, firmware } => Heard::Found { id, model, firmware },
            Event::Refused { id, error, alert } => Heard::Refused { id, error, alert },
            Event::Stray { id } => Heard::Stray { id },
            Event::Damaged(error) => Heard::Damaged(error),
        })
    }

    /// Forgets the question and an incomplete packet, as when the port was deaf for a while.
    pub fn reset(&mut self) {
        self.line.reset();
        self.state.request.drop();
    }
}

impl<const N: usize, const S: usize> State<N, S> {
    fn servo(&mut self, id: u8) -> Option<&mut Watched> {
        self.servos.iter_mut().flatten().find(|servo| servo.id.get() == id)
    }

    /// Those that an instruction is addressed to.
    fn addressed(&mut self, id: Id) -> impl Iterator<Item = &mut Watched> {
        self.servos.iter_mut().flatten().filter(move |servo| id.is_broadcast() || servo.id == id)
    }

    fn spoken(&mut self, spoken: Spoken<'_>, now_us: u64) -> Option<Event> {
        let Spoken { packet, skipped } = spoken;
        let packet = match packet {
            Ok(packet) => packet,
            Err(error) => {
                // It may have been the next question. A fast answer has CRCs of its own to tell.
                if !(self.request.is_fast() && self.fast.has_begun()) {
                    self.lost |= self.request.instruction.is_none() && !self.followed;
                    self.request.drop();
                }
                return Some(Event::Damaged(error));
            }
        };
        if packet.is_fast_answer() {
            self.request.drop();
            return (!core::mem::take(&mut self.followed)).then_some(Event::Stray { id: packet.id });
        }
        if packet.code != Instruction::Status.code() {
            self.unanswered(skipped);
            // What was lost was not answered: it may have been a write to anybody, to any place.
            if core::mem::take(&mut self.lost) {
                self.servos.iter_mut().flatten().for_each(Watched::doubt_all);
            }
            return self.ask(&packet, skipped, now_us);
        }
        let Some(status) = packet.status() else {
            return self.stray(packet.id);
        };
        self.answer(&status, skipped, now_us)
    }

    /// An answer that nobody who was asked owes: what was asked last was not heard.
    fn stray(&mut self, id: Id) -> Option<Event> {
        self.request.drop();
        // By far most lost questions are reads, and their answers have data.
        self.lost = false;
        Some(Event::Stray { id })
    }

    /// A further question comes: whose turn it was has kept silent, if the line has.
    fn unanswered(&mut self, skipped: u32) {
        if self.request.instruction.is_none() || skipped != self.skipped {
            return;
        }
        let silent = match self.request.entry(self.next) {
            Some(_) if self.request.is_fast() && self.fast.has_begun() => None,
            Some(entry) => Some(entry.id),
            None => Some(self.request.id.get()),
        };
        if let Some(servo) = silent.and_then(|id| self.servo(id)) {
            servo.was_silent();
        }
    }

    fn ask(&mut self, packet: &Packet<'_>, skipped: u32, now_us: u64) -> Option<Event> {
        self.request.keep(packet);
        (self.next, self.since_us, self.skipped, self.followed) = (0, now_us, skipped, false);
        let (id, parameters) = (packet.id, packet.parameters);
        match packet.instruction()? {
            Instruction::FastSyncRead | Instruction::FastBulkRead => {
                match self.request.fast_length() {
                    Some(length) => self.fast = FastAnswer::new(length),
                    None => self.request.drop(),
                }
                None
            }
            Instruction::Write => {
                let (address, bytes) = addressed(parameters)?;
                let expected = self.timing.status_return.answers(packet.code);
                let mut answers = expected && !id.is_broadcast();
                for servo in self.addressed(id) {
                    answers &= servo.answers(packet.code).unwrap_or(true);
                    if answers {
                        servo.doubt(address, bytes.len());
                    } else {
                        servo.written(address, bytes, now_us);
                    }
                }
                if answers {
                    return None;
                }
                self.request.drop();
                self.keep(bytes).map(|length| Event::Written { id, address, length })
            }
            Instruction::RegWrite => {
                let (address, bytes) = addressed(parameters)?;
                self.addressed(id).for_each(|servo| servo.doubt(address, bytes.len()));
                None
            }
            Instruction::SyncWrite => {
                self.request.drop();
                let (&[a, b, c, d], entries) = parameters.split_first_chunk()?;
                let (address, length) = (u16::from_le_bytes([a, b]), usize::from(u16::from_le_bytes([c, d])));
                for (&id, bytes) in entries.chunks_exact(length + 1).filter_map(|entry| entry.split_first()) {
                    if let Some(servo) = self.servo(id) {
                        servo.written(address, bytes, now_us);
                    }
                }
                None
            }
            Instruction::BulkWrite => {
                self.request.drop();
                let mut rest = parameters;
                while let Some((&[id, a, b, c, d], behind)) = rest.split_first_chunk() {
                    let (bytes, next) = behind.split_at_checked(usize::from(u16::from_le_bytes([c, d])))?;
                    if let Some(servo) = self.servo(id) {
                        servo.written(u16::from_le_bytes([a, b]), bytes, now_us);
                    }
                    rest = next;
                }
                None
            }
            Instruction::Reboot | Instruction::FactoryReset => {
                self.addressed(id).for_each(Watched::restarted);
                None
            }
            _ => None,
        }
    }

    fn answer(&mut self, status: &Status<'_>, skipped: u32, now_us: u64) -> Option<Event> {
        let (id, alert) = (status.id, status.alert);
        if self.request.instruction.is_none()
            && status.parameters.is_empty()
            && let Some(servo) = self.servo(id.get())
        {
            // It was a write or a restart that was not heard.
            servo.doubt_all();
        }
        if skipped.wrapping_sub(self.skipped) > NOISE {
            return self.stray(id);
        }
        let late = now_us.saturating_sub(self.since_us);
        let asked = self.request.id;
        match self.request.instruction {
            Some(Instruction::Read | Instruction::SyncRead | Instruction::BulkRead) => {
                let before = self.request.entries(self.next).position(|entry| entry.id == id.get());
                let Some(entry) = before.and_then(|before| self.request.entry(self.next + before)) else {
                    return self.stray(id);
                };
                let place = self.next + before.unwrap_or(0);
                let patience = self.request.entries(self.next).take(place + 1 - self.next);
                let patience =
                    patience.map(|entry| self.patience_us(longest_packet_length(usize::from(entry.length) + 1)));
                if late > patience.fold(0, u64::saturating_add) {
                    return self.stray(id);
                }
                for passed in self.next..place {
                    if let Some(servo) = self.request.entry(passed).and_then(|entry| self.servo(entry.id)) {
                        servo.was_silent();
                    }
                }
                (self.next, self.since_us, self.skipped) = (place + 1, now_us, skipped);
                if status.error.is_none() && status.parameters.len() != usize::from(entry.length) {
                    return self.stray(id);
                }
                if self.request.entry(self.next).is_none() {
                    self.request.drop();
                }
                self.told(id, entry.address, status, now_us)
            }
            Some(Instruction::Ping) if asked.is_broadcast() || asked == id => {
                if !asked.is_broadcast() {
                    self.request.drop();
                }
                let &[low, high, firmware] = status.parameters else {
                    return self.stray(id);
                };
                let model = u16::from_le_bytes([low, high]);
                if let Some(servo) = self.servo(id.get()) {
                    servo.answered(alert);
                    servo.is(model);
                }
                Some(Event::Found { id, model, firmware })
            }
            Some(instruction) if asked == id && !self.request.is_fast() => {
                if late > self.patience_us(status_length(0)) || !status.parameters.is_empty() {
                    return self.stray(id);
                }
                if let Some(servo) = self.servo(id.get()) {
                    servo.answered(alert);
                }
                let written =
                    if instruction == Instruction::Write { addressed(self.request.parameters()) } else { None };
                let written = written.and_then(|(address, bytes)| {
                    let place = self.data.get_mut(..bytes.len())?;
                    place.copy_from_slice(bytes);
                    Some((address, bytes.len()))
                });
                self.request.drop();
                if let Some(error) = status.error {
                    return Some(Event::Refused { id, error, alert });
                }
                let (address, length) = written?;
                let servo = self.servos.iter_mut().flatten().find(|servo| servo.id == id);
                if let (Some(servo), Some(bytes)) = (servo, self.data.get(..length)) {
                    servo.written(address, bytes, now_us);
                }
                Some(Event::Written { id, address, length })
            }
            _ => self.stray(id),
        }
    }

    /// How long an answer of so many bytes is waited for, µs.
    fn patience_us(&self, bytes: usize) -> u64 {
        u64::from(self.timing.wire_us(bytes)) + u64::from(self.timing.latency_us)
    }

    /// A servo has answered a read.
    fn told(&mut self, id: Id, address: u16, status: &Status<'_>, now_us: u64) -> Option<Event> {
        let &Status { alert, error, parameters, .. } = status;
        if let Some(servo) = self.servo(id.get()) {
            servo.answered(alert);
            if error.is_none() {
                servo.read(address, parameters, now_us);
            }
        }
        match error {
            Some(error) => Some(Event::Refused { id, error, alert }),
            None => self.keep(parameters).map(|length| Event::Read { id, address, length, alert }),
        }
    }

    fn keep(&mut self, bytes: &[u8]) -> Option<usize> {
        self.data.get_mut(..bytes.len())?.copy_from_slice(bytes);
        Some(bytes.len())
    }

    /// A byte of what may be the answer to a fast read.
    fn follow(&mut self, byte: u8, skipped: u32, now_us: u64) -> Option<Event> {
        if !self.request.is_fast() {
            return None;
        }
        let request = &self.request;
        let begun = self.fast.has_begun();
        let step = self.fast.push(byte, |place| request.entry(place), &mut self.data);
        if !begun && self.fast.has_begun() {
            let late = now_us.saturating_sub(self.since_us);
            let first = request.entry(0).map_or(0, |entry| longest_packet_length(usize::from(entry.length) + 1));
            if late > self.patience_us(first) || skipped.wrapping_sub(self.skipped) > NOISE {
                self.request.drop();
                return None;
            }
        }
        let (place, error, length) = match step {
            Step::More => return None,
            Step::Broken => {
                self.request.drop();
                return None;
            }
            Step::Block { place, error, length } => (place, error, length),
        };
        let entry = self.request.entry(place)?;
        self.next = place + 1;
        if self.request.entry(self.next).is_none() {
            self.request.drop();
            self.followed = true;
        }
        let (id, address) = (Id::new(entry.id)?, entry.address);
        let (alert, error) = (error & ALERT != 0, StatusError::from_code(error));
        let servo = self.servos.iter_mut().flatten().find(|servo| servo.id == id);
        let bytes = self.data.get(..length)?;
        if let Some(servo) = servo {
            servo.answered(alert);
            if error.is_none() {
                servo.read(address, bytes, now_us);
            }
        }
        Some(match error {
            Some(error) => Event::Refused { id, error, alert },
            None => Event::Read { id, address, length, alert },
        })
    }
}

/// Address and bytes of a write.
fn addressed(parameters: &[u8]) -> Option<(u16, &[u8])> {
    let (&[low, high], bytes) = parameters.split_first_chunk()?;
    Some((u16::from_le_bytes([low, high]), bytes))
}
