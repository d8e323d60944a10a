//! The answering side of the bus: listens, answers, keeps its turn.

mod table;
mod turn;

pub use table::ControlTable;

use turn::{Call, Turn};

use crate::decode::DecodeError;
use crate::encode::Encoder;
use crate::fast::{Block, FastAnswer};
use crate::line::{Line, Spoken};
use crate::packet::{Id, Instruction, Packet, StatusError, StatusReturn, status_length};
use crate::request::Entry;
use crate::timing::{BROADCAST_PING_SLOT_US, Timing};
use crate::upkeep::{BACKUP_KEY, Backup, CLEAR_KEY, ResetScope};

/// An answer to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reply<'a> {
    /// The status packet; of the answer to a fast read, this device's block.
    pub bytes: &'a [u8],
    /// Microseconds to wait before sending, from the end of what is answered.
    pub delay_us: u32,
}

/// A device on the bus. `N` bounds packets in both directions, in bytes.
///
/// It has no clock and no port: it is given every byte on the bus with the time at which it came, and hands out answers.
///
/// In a read of several devices it speaks when the one named before it has spoken. In a Sync Read or Bulk Read it also
/// speaks when that one has been silent for as long as its answer takes at [`Timing::baud_rate`] plus
/// [`Timing::latency_us`], and so on for each before it. The answer to a fast read is one packet: there whoever is silent,
/// or damages what was said so far, silences all behind it.
///
/// ```
/// # use dynamixel::{ControlTable, Id, StatusError};
/// # struct Lamp(u8);
/// # impl ControlTable for Lamp {
/// #     fn id(&self) -> Id { Id::new(1).unwrap() }
/// #     fn model_number(&self) -> u16 { 1030 }
/// #     fn firmware_version(&self) -> u8 { 38 }
/// #     fn read(&mut self, _: u16, bytes: &mut [u8]) -> Result<(), StatusError> { bytes.fill(self.0); Ok(()) }
/// #     fn write(&mut self, _: u16, bytes: &[u8]) -> Result<(), StatusError> { self.0 = bytes[0]; Ok(()) }
/// # }
/// # let (mut table, now_us) = (Lamp(0), 0);
/// let mut device = dynamixel::Device::<64>::new(dynamixel::Timing::at(1_000_000));
/// let mut heard: &[u8] = &[0xFF, 0xFF, 0xFD, 0x00, 1, 3, 0, 0x01, 0x19, 0x4E];
/// while let Some(reply) = device.hear(now_us, &mut heard, &mut table) {
///     assert_eq!(reply.bytes, [0xFF, 0xFF, 0xFD, 0x00, 1, 7, 0, 0x55, 0, 0x06, 0x04, 0x26, 0x65, 0x5D]);
/// }
/// ```
#[derive(Clone, Debug)]
pub struct Device<const N: usize> {
    line: Line<N>,
    timing: Timing,
    turn: Turn<N>,
    state: State<N>,
}

#[derive(Clone, Debug)]
struct State<const N: usize> {
    reply: [u8; N],
    /// Bytes read from the table, before stuffing.
    data: [u8; N],
    registered: Registered<N>,
}

/// A write kept for Action: its address and its first `length` bytes.
#[derive(Clone, Debug)]
struct Registered<const N: usize> {
    address: u16,
    length: usize,
    bytes: [u8; N],
}

/// How the device answers, as it was when the instruction arrived.
#[derive(Clone, Copy)]
struct Manner {
    me: Id,
    status_return: StatusReturn,
    return_delay_us: u32,
}

impl Manner {
    fn of(table: &impl ControlTable) -> Self {
        Manner { me: table.id(), status_return: table.status_return(), return_delay_us: table.return_delay_us() }
    }
}

/// What an instruction comes to.
enum Outcome {
    /// Nothing to say.
    Silent,
    /// An answer with this error or none, and this many bytes of data.
    Answer(Result<usize, StatusError>),
    /// An answer to a broadcast Ping, in the order of the addresses.
    Slot(usize),
    /// This device's part in a read of several.
    Turn(Call),
}

/// A reply that lies in the buffer: its delay and its length.
type Written = Option<(u32, usize)>;

impl<const N: usize> Device<N> {
    /// The most bytes one Read can ask for: an answer of N bytes, every third data byte stuffed.
    pub const LONGEST_READ: usize = (N - status_length(0)) / 4 * 3;

    /// A device that has heard nothing yet. Of the timing, the status return level is not used: the table has its own.
    pub const fn new(timing: Timing) -> Self {
        Device {
            line: Line::new(),
            timing,
            turn: Turn::new(),
            state: State {
                reply: [0; N],
                data: [0; N],
                registered: Registered { address: 0, length: 0, bytes: [0; N] },
            },
        }
    }

    /// Changes how long the device waits for others, as after a change of the baud rate.
    pub fn set_timing(&mut self, timing: Timing) {
        self.timing = timing;
    }

    /// Takes bytes heard on the bus at `now_us` from the front of `input` until there is something to answer.
    ///
    /// Nothing means that all bytes are taken. Other devices' answers must be heard too: they tell a device its turn. The
    /// own answers may be heard. Bytes that arrive before the answer's delay has passed cancel nothing.
    pub fn hear(&mut self, now_us: u64, input: &mut &[u8], table: &mut impl ControlTable) -> Option<Reply<'_>> {
        self.line.at(self.timing.began_us(now_us, input.len()), self.timing.pause_us());
        let (delay_us, length) = loop {
            let spoken = if self.turn.follows() { self.line.settle() } else { Some(self.line.take(now_us, input)?) };
            if let Some(spoken) = spoken {
                match Self::event(&mut self.turn, &mut self.state, spoken, now_us, &self.timing, table) {
                    Some(written) => break written,
                    None => continue,
                }
            }
            // The blocks of a fast answer end one by one.
            let (&byte, rest) = input.split_first()?;
            *input = rest;
            let call = self.turn.follow(byte);
            let block = self.state.take_turn(call, self.turn.fast(), Manner::of(table), table);
            let answer = self
                .line
                .byte(now_us, byte)
                .and_then(|spoken| Self::event(&mut self.turn, &mut self.state, spoken, now_us, &self.timing, table));
            if let Some(written) = block.or(answer) {
                break written;
            }
        };
        Some(Reply { bytes: self.state.reply.get(..length).unwrap_or_default(), delay_us })
    }

    /// Lets time pass without bytes. To be called at [`Device::deadline`]; earlier and later calls do no harm.
    pub fn poll(&mut self, now_us: u64, table: &mut impl ControlTable) -> Option<Reply<'_>> {
        self.line.at(now_us, self.timing.pause_us());
        let (delay_us, length) = loop {
            let Some(spoken) = self.line.settle() else {
                let call = self.turn.poll(now_us);
                // Whoever was waited for has had the time of the return delay.
                let manner = Manner { return_delay_us: 0, ..Manner::of(table) };
                break self.state.take_turn(call, self.turn.fast(), manner, table)?;
            };
            if let Some(written) = Self::event(&mut self.turn, &mut self.state, spoken, now_us, &self.timing, table) {
                break written;
            }
        };
        Some(Reply { bytes: self.state.reply.get(..length).unwrap_or_default(), delay_us })
    }

    /// When there may be something to answer although nothing has come, µs.
    pub fn deadline(&self) -> Option<u64> {
        let (pause, turn) = (self.line.deadline(self.timing.pause_us()), self.turn.deadline());
        pause.into_iter().chain(turn).min()
    }

    /// Forgets what it has heard, as when the port was deaf for a while.
    pub fn reset(&mut self) {
        self.line.reset();
        self.turn.end();
    }

    fn event(
        turn: &mut Turn<N>,
        state: &mut State<N>,
        spoken: Spoken<'_>,
        now_us: u64,
        timing: &Timing,
        table: &mut impl ControlTable,
    ) -> Written {
        let manner = Manner::of(table);
        let status = Instruction::Status.code();
        let (code, outcome) = match spoken.packet {
            Ok(packet) if packet.is_fast_answer() => return None,
            Ok(packet) if packet.code == status => (status, Outcome::Turn(turn.heard(packet.id, now_us, timing))),
            Ok(packet) => {
                turn.end();
                (packet.code, state.packet(packet, turn, now_us, timing, table))
            }
            // Whoever it was has had its turn.
            Err(DecodeError::Crc { id, code, .. }) if code == status => {
                let call = Id::new(id).map_or(Call::Wait, |id| turn.heard(id, now_us, timing));
                (status, Outcome::Turn(call))
            }
            Err(DecodeError::Crc { id, code, .. }) if id == manner.me.get() => {
                (code, Outcome::Answer(Err(StatusError::Crc)))
            }
            Err(_) => return None,
        };
        match outcome {
            Outcome::Silent => None,
            Outcome::Turn(call) => state.take_turn(call, turn.fast(), manner, table),
            Outcome::Answer(result) => state.answer(code, result, 0, manner, table.alert()),
            Outcome::Slot(length) => {
                let slot = u32::from(manner.me.get()) * BROADCAST_PING_SLOT_US;
                state.answer(code, Ok(length), slot, manner, table.alert())
            }
        }
    }
}

impl<const N: usize> State<N> {
    fn packet(
        &mut self,
        packet: Packet<'_>,
        turn: &mut Turn<N>,
        now_us: u64,
        timing: &Timing,
        table: &mut impl ControlTable,
    ) -> Outcome {
        let me = table.id();
        if packet.id == me {
            return Outcome::Answer(self.own(packet, table));
        }
        if !packet.id.is_broadcast() {
            if table.secondary_id() == Some(packet.id) {
                self.shared(packet, table);
            }
            return Outcome::Silent;
        }
        match packet.instruction() {
            Some(Instruction::SyncRead | Instruction::BulkRead) => {
                Outcome::Turn(turn.begin(&packet, me, now_us, timing))
            }
            Some(Instruction::FastSyncRead | Instruction::FastBulkRead) if table.fast_reads() => {
                Outcome::Turn(turn.begin(&packet, me, now_us, timing))
            }
            _ => self.broadcast(packet, me, table),
        }
    }

    /// An instruction to this device alone.
    fn own(&mut self, packet: Packet<'_>, table: &mut impl ControlTable) -> Result<usize, StatusError> {
        let parameters = packet.parameters;
        match packet.instruction().ok_or(StatusError::Instruction)? {
            Instruction::Ping => Ok(self.identity(table)),
            Instruction::Read => {
                let &[a, b, c, d] = parameters else {
                    return Err(StatusError::DataLength);
                };
                self.read(u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]), table)
            }
            Instruction::Write => {
                let (address, bytes) = addressed(parameters)?;
                table.write(address, bytes).map(|()| 0)
            }
            Instruction::RegWrite => self.register(parameters, table).map(|()| 0),
            Instruction::Action => self.action(table).map(|()| 0),
            Instruction::Reboot => table.reboot().map(|()| 0),
            Instruction::FactoryReset => table.factory_reset(scope(parameters)?).map(|()| 0),
            Instruction::Clear => match keyed(parameters, CLEAR_KEY)? {
                1 => table.clear_turns().map(|()| 0),
                _ => Err(StatusError::DataRange),
            },
            Instruction::ControlTableBackup => {
                let what = keyed(parameters, BACKUP_KEY)?;
                let what = [Backup::Store, Backup::Restore].into_iter().find(|known| known.code() == what);
                table.backup(what.ok_or(StatusError::DataRange)?).map(|()| 0)
            }
            _ => Err(StatusError::Instruction),
        }
    }

    /// An instruction under the second address, which several devices may share: writes to RAM are carried out in silence.
    fn shared(&mut self, packet: Packet<'_>, table: &mut impl ControlTable) {
        match packet.instruction() {
            Some(Instruction::Write) => {
                if let Ok((address, bytes)) = addressed(packet.parameters)
                    && table.is_shared(address, bytes)
                {
                    let _ = table.write(address, bytes);
                }
            }
            Some(Instruction::RegWrite) => {
                if let Ok((address, bytes)) = addressed(packet.parameters)
                    && table.is_shared(address, bytes)
                {
                    let _ = self.register(packet.parameters, table);
                }
            }
            Some(Instruction::Action) => {
                let _ = self.action(table);
            }
            _ => {}
        }
    }

    /// An instruction to every device: carried out in silence, but for Ping and the reads that name this device.
    fn broadcast(&mut self, packet: Packet<'_>, me: Id, table: &mut impl ControlTable) -> Outcome {
        let parameters = packet.parameters;
        match packet.instruction() {
            Some(Instruction::Ping) => return Outcome::Slot(self.identity(table)),
            Some(Instruction::Write) => {
                if let Ok((address, bytes)) = addressed(parameters) {
                    let _ = table.write(address, bytes);
                }
            }
            Some(Instruction::Action) => {
                let _ = self.action(table);
            }
            Some(Instruction::Reboot) => {
                let _ = table.reboot();
            }
            Some(Instruction::RegWrite) => {
                let _ = self.register(parameters, table);
            }
            // Everything of every device at once would leave all of them with one address.
            Some(Instruction::FactoryReset) => {
                if let Ok(scope @ (ResetScope::ExceptId | ResetScope::ExceptIdAndBaudRate)) = scope(parameters) {
                    let _ = table.factory_reset(scope);
                }
            }
            Some(Instruction::SyncWrite) => {
                let &[a, b, c, d, ref entries @ ..] = parameters else {
                    return Outcome::Silent;
                };
                let (address, length) = (u16::from_le_bytes([a, b]), usize::from(u16::from_le_bytes([c, d])));
                if length > 0 {
                    let entries = entries.chunks_exact(length + 1).filter_map(|entry| entry.split_first());
                    for (_, bytes) in entries.filter(|&(&id, _)| id == me.get()) {
                        let _ = table.write(address, bytes);
                    }
                }
            }
            Some(Instruction::BulkWrite) => {
                let mut rest = parameters;
                while let &[id, a, b, c, d, ref behind @ ..] = rest {
                    let length = usize::from(u16::from_le_bytes([c, d]));
                    let Some((bytes, next)) = behind.split_at_checked(length) else {
                        break;
                    };
                    if id == me.get() && !bytes.is_empty() {
                        let _ = table.write(u16::from_le_bytes([a, b]), bytes);
                    }
                    rest = next;
                }
            }
            _ => {}
        }
        Outcome::Silent
    }

    /// Does what a read of several devices asks for now.
    fn take_turn(&mut self, call: Call, fast: &FastAnswer, manner: Manner, table: &mut impl ControlTable) -> Written {
        match call {
            Call::Wait => None,
            Call::Answer(Entry { address, length, .. }) => {
                let result = self.read(address, length, table);
                self.answer(Instruction::SyncRead.code(), result, 0, manner, table.alert())
            }
            Call::Block(Entry { address, length, .. }) => {
                if !manner.status_return.answers(Instruction::FastSyncRead.code()) {
                    return None;
                }
                let result = self.read(address, length, table);
                // The place of the blocks behind it depends on the length, which an error does not change.
                let data = self.data.get_mut(..usize::from(length))?;
                if result.is_err() {
                    data.fill(0);
                }
                let block = Block { id: manner.me, alert: table.alert(), error: result.err(), data };
                let written = fast.write(&block, &mut self.reply)?;
                // Only the first waits: the others' answer is the continuation of a packet.
                Some((if fast.awaits().is_some() { 0 } else { manner.return_delay_us }, written))
            }
        }
    }

    fn identity(&mut self, table: &impl ControlTable) -> usize {
        let [low, high] = table.model_number().to_le_bytes();
        let identity = [low, high, table.firmware_version()];
        for (place, byte) in self.data.iter_mut().zip(identity) {
            *place = byte;
        }
        identity.len()
    }

    fn read(&mut self, address: u16, length: u16, table: &mut impl ControlTable) -> Result<usize, StatusError> {
        let length = usize::from(length);
        if length == 0 || length > Device::<N>::LONGEST_READ {
            return Err(StatusError::DataLength);
        }
        let data = self.data.get_mut(..length).ok_or(StatusError::DataLength)?;
        table.read(address, data).map(|()| length)
    }

    fn register(&mut self, parameters: &[u8], table: &mut impl ControlTable) -> Result<(), StatusError> {
        let (address, bytes) = addressed(parameters)?;
        table.check(address, bytes)?;
        let place = self.registered.bytes.get_mut(..bytes.len()).ok_or(StatusError::DataLength)?;
        place.copy_from_slice(bytes);
        self.registered.address = address;
        self.registered.length = bytes.len();
        table.registered(true);
        Ok(())
    }

    fn action(&mut self, table: &mut impl ControlTable) -> Result<(), StatusError> {
        let length = core::mem::take(&mut self.registered.length);
        let bytes = self.registered.bytes.get(..length).unwrap_or_default();
        if bytes.is_empty() {
            return Err(StatusError::Instruction);
        }
        table.registered(false);
        table.write(self.registered.address, bytes)
    }

    /// Writes the status packet, to be sent `slot_us` after the return delay; nothing where the device stays silent.
    fn answer(
        &mut self,
        code: u8,
        result: Result<usize, StatusError>,
        slot_us: u32,
        manner: Manner,
        alert: bool,
    ) -> Written {
        let Manner { me, status_return, return_delay_us } = manner;
        if !status_return.answers(code) {
            return None;
        }
        let data = self.data.get(..result.unwrap_or(0)).unwrap_or_default();
        let bytes = Encoder::status(&mut self.reply, me, alert, result.err()).bytes(data).finish().ok()?;
        Some((return_delay_us.saturating_add(slot_us), bytes.len()))
    }
}

/// What a Factory Reset is to return.
fn scope(parameters: &[u8]) -> Result<ResetScope, StatusError> {
    let &[code] = parameters else { return Err(StatusError::DataLength) };
    let scopes = [ResetScope::All, ResetScope::ExceptId, ResetScope::ExceptIdAndBaudRate];
    scopes.into_iter().find(|scope| scope.code() == code).ok_or(StatusError::DataRange)
}

/// What is asked for by an instruction that is valid with a key only.
fn keyed(parameters: &[u8], key: [u8; 4]) -> Result<u8, StatusError> {
    match parameters {
        [what, rest @ ..] if *rest == key => Ok(*what),
        [_, _, _, _, _] => Err(StatusError::DataRange),
        _ => Err(StatusError::DataLength),
    }
}

/// Address and bytes of a write.
fn addressed(parameters: &[u8]) -> Result<(u16, &[u8]), StatusError> {
    match parameters {
        [low, high, bytes @ ..] if !bytes.is_empty() => Ok((u16::from_le_bytes([*low, *high]), bytes)),
        _ => Err(StatusError::DataLength),
    }
}
