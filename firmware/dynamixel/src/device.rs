//! The servo's side of the bus: listens, answers, keeps its turn.

use crate::decode::{DecodeError, Decoder};
use crate::encode::Encoder;
use crate::packet::{Id, Instruction, Packet, StatusError, StatusReturn, status_length};

/// Microseconds by which a device's answer to a broadcast Ping is delayed for each address below its own.
///
/// So the answers come in the order of the addresses. ROBOTIS' SDK waits 3 ms per address.
pub const BROADCAST_PING_SLOT_US: u32 = 3_000;

/// How much a Factory Reset returns to the factory's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ResetScope {
    /// Everything (0xFF). Never asked for by broadcast.
    All,
    /// Everything but the address (0x01).
    ExceptId,
    /// Everything but address and baud rate (0x02).
    ExceptIdAndBaudRate,
}

/// What a device holds, and what becomes of a write.
///
/// A write to address, return delay or status return level takes effect after the answer to that write.
pub trait ControlTable {
    /// The device's address.
    fn id(&self) -> Id;
    /// Model number, told by Ping.
    fn model_number(&self) -> u16;
    /// Version of the firmware, told by Ping.
    fn firmware_version(&self) -> u8;
    /// Whether a hardware error is present; sets the alert bit of every answer.
    fn alert(&self) -> bool {
        false
    }
    /// Which instructions are answered.
    fn status_return(&self) -> StatusReturn {
        StatusReturn::All
    }
    /// Microseconds between an instruction's end and the answer.
    fn return_delay_us(&self) -> u32 {
        0
    }
    /// Fills `bytes`, which is never empty, with the contents from `address` on.
    ///
    /// Errors: [`StatusError::Access`] where there is nothing to read.
    fn read(&mut self, address: u16, bytes: &mut [u8]) -> Result<(), StatusError>;
    /// Writes `bytes`, which is never empty, from `address` on: all of it or, on an error, nothing.
    ///
    /// Errors: [`StatusError::Access`], [`StatusError::DataLength`], [`StatusError::DataRange`],
    /// [`StatusError::DataLimit`]; [`crate::writes`] finds all but the last.
    fn write(&mut self, address: u16, bytes: &[u8]) -> Result<(), StatusError>;
    /// Whether a Reg Write waits for its Action (item Registered Instruction).
    fn registered(&mut self, waiting: bool) {
        let _ = waiting;
    }
    /// Restarts the device.
    fn reboot(&mut self) -> Result<(), StatusError> {
        Err(StatusError::Instruction)
    }
    /// Returns to the factory's values.
    fn factory_reset(&mut self, scope: ResetScope) -> Result<(), StatusError> {
        let _ = scope;
        Err(StatusError::Instruction)
    }
    /// Forgets the number of turns.
    fn clear_turns(&mut self) -> Result<(), StatusError> {
        Err(StatusError::Instruction)
    }
}

/// An answer to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reply<'a> {
    /// The status packet.
    pub bytes: &'a [u8],
    /// Microseconds to wait before sending, from the end of the packet that is answered.
    pub delay_us: u32,
}

/// A device on the bus. `N` bounds packets in both directions, in bytes.
///
/// It has no clock and no port: it is given every byte on the bus and hands out answers.
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
/// # let mut table = Lamp(0);
/// let mut device = dynamixel::Device::<64>::new();
/// let mut heard: &[u8] = &[0xFF, 0xFF, 0xFD, 0x00, 1, 3, 0, 0x01, 0x19, 0x4E];
/// while let Some(reply) = device.hear(&mut heard, &mut table) {
///     assert_eq!(reply.bytes, [0xFF, 0xFF, 0xFD, 0x00, 1, 7, 0, 0x55, 0, 0x06, 0x04, 0x26, 0x65, 0x5D]);
/// }
/// ```
#[derive(Clone, Debug)]
pub struct Device<const N: usize> {
    decoder: Decoder<N>,
    state: State<N>,
}

#[derive(Clone, Debug)]
struct State<const N: usize> {
    reply: [u8; N],
    /// Bytes read from the table, before stuffing.
    data: [u8; N],
    turn: Option<Turn>,
    registered: Registered<N>,
}

/// A read of several devices at once in which others answer before this one.
#[derive(Clone, Copy, Debug)]
struct Turn {
    after: Id,
    address: u16,
    length: u16,
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

/// What an instruction comes to.
enum Outcome {
    /// Nothing to say.
    Silent,
    /// An answer with this error or none, and this many bytes of data.
    Answer(Result<usize, StatusError>),
    /// An answer to a broadcast Ping, in the order of the addresses.
    Slot(usize),
}

impl<const N: usize> Device<N> {
    /// The most bytes one Read can ask for: an answer of N bytes, every third data byte stuffed.
    pub const LONGEST_READ: usize = (N - status_length(0)) / 4 * 3;

    /// A device that has heard nothing yet.
    pub const fn new() -> Self {
        Device {
            decoder: Decoder::new(),
            state: State {
                reply: [0; N],
                data: [0; N],
                turn: None,
                registered: Registered { address: 0, length: 0, bytes: [0; N] },
            },
        }
    }

    /// Takes bytes heard on the bus from the front of `input` until there is something to answer.
    ///
    /// Nothing means that all bytes are taken. Other devices' answers must be heard too: they tell a device its turn. The
    /// own answers may be heard. Bytes that arrive before the answer's delay has passed cancel nothing.
    pub fn hear(&mut self, input: &mut &[u8], table: &mut impl ControlTable) -> Option<Reply<'_>> {
        let (delay_us, length) = loop {
            let manner = Manner {
                me: table.id(),
                status_return: table.status_return(),
                return_delay_us: table.return_delay_us(),
            };
            let (code, outcome) = match self.decoder.feed(input)? {
                Ok(packet) => (packet.code, self.state.packet(packet, table)),
                Err(DecodeError::Crc { id, code, .. })
                    if id == manner.me.get() && code != Instruction::Status.code() =>
                {
                    (code, Outcome::Answer(Err(StatusError::Crc)))
                }
                Err(_) => continue,
            };
            if let Some(answer) = self.state.answer(code, outcome, manner, table.alert()) {
                break answer;
            }
        };
        Some(Reply { bytes: self.state.reply.get(..length).unwrap_or_default(), delay_us })
    }

    /// Forgets an incomplete packet. To be called after a pause on the line, if the port can tell: otherwise a byte lost
    /// from one packet can be taken from the next, which is then lost too.
    pub fn reset(&mut self) {
        self.decoder.reset();
    }
}

impl<const N: usize> Default for Device<N> {
    fn default() -> Self {
        Device::new()
    }
}

impl<const N: usize> State<N> {
    fn packet(&mut self, packet: Packet<'_>, table: &mut impl ControlTable) -> Outcome {
        let me = table.id();
        if let Some(status) = packet.status() {
            return match self.turn {
                Some(turn) if turn.after == status.id => {
                    self.turn = None;
                    Outcome::Answer(self.read(turn.address, turn.length, table))
                }
                _ => Outcome::Silent,
            };
        }
        // A new instruction ends every read that is still waiting for its turn.
        self.turn = None;
        if packet.id.is_broadcast() {
            self.broadcast(packet, me, table)
        } else if packet.id == me {
            Outcome::Answer(self.own(packet, table))
        } else {
            Outcome::Silent
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
            Instruction::RegWrite => {
                let (address, bytes) = addressed(parameters)?;
                let place = self.registered.bytes.get_mut(..bytes.len()).ok_or(StatusError::DataLength)?;
                place.copy_from_slice(bytes);
                self.registered.address = address;
                self.registered.length = bytes.len();
                table.registered(true);
                Ok(0)
            }
            Instruction::Action => self.action(table).map(|()| 0),
            Instruction::Reboot => table.reboot().map(|()| 0),
            Instruction::FactoryReset => {
                let scope = match parameters {
                    [0xFF] => ResetScope::All,
                    [0x01] => ResetScope::ExceptId,
                    [0x02] => ResetScope::ExceptIdAndBaudRate,
                    [_] => return Err(StatusError::DataRange),
                    _ => return Err(StatusError::DataLength),
                };
                table.factory_reset(scope).map(|()| 0)
            }
            Instruction::Clear => match parameters {
                // The constant spells "DXL" and a quotation mark.
                [0x01, 0x44, 0x58, 0x4C, 0x22] => table.clear_turns().map(|()| 0),
                [_, _, _, _, _] => Err(StatusError::DataRange),
                _ => Err(StatusError::DataLength),
            },
            _ => Err(StatusError::Instruction),
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
            Some(Instruction::SyncRead) => {
                let &[a, b, c, d, ref ids @ ..] = parameters else {
                    return Outcome::Silent;
                };
                let (address, length) = (u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]));
                let entries = ids.iter().map(|&id| (id, address, length));
                return self.take_turn(entries, me, table);
            }
            Some(Instruction::BulkRead) => {
                let entries = parameters.chunks_exact(5).filter_map(|entry| match *entry {
                    [id, a, b, c, d] => Some((id, u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]))),
                    _ => None,
                });
                return self.take_turn(entries, me, table);
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

    /// Answers at once if this device is named first; otherwise waits to hear the one before.
    fn take_turn(
        &mut self,
        entries: impl Iterator<Item = (u8, u16, u16)>,
        me: Id,
        table: &mut impl ControlTable,
    ) -> Outcome {
        let mut before = None;
        for (id, address, length) in entries {
            if id == me.get() {
                return match before {
                    None => Outcome::Answer(self.read(address, length, table)),
                    Some(after) => {
                        self.turn = Some(Turn { after, address, length });
                        Outcome::Silent
                    }
                };
            }
            before = Id::new(id).or(before);
        }
        Outcome::Silent
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

    fn action(&mut self, table: &mut impl ControlTable) -> Result<(), StatusError> {
        let length = core::mem::take(&mut self.registered.length);
        let bytes = self.registered.bytes.get(..length).unwrap_or_default();
        if bytes.is_empty() {
            return Err(StatusError::Instruction);
        }
        table.registered(false);
        table.write(self.registered.address, bytes)
    }

    /// Writes the status packet; gives its delay and length, or nothing where the device stays silent.
    fn answer(&mut self, code: u8, outcome: Outcome, manner: Manner, alert: bool) -> Option<(u32, usize)> {
        let Manner { me, status_return, return_delay_us } = manner;
        // An answer in turn follows a status packet; what is answered is the read it belongs to.
        let code = if code == Instruction::Status.code() { Instruction::SyncRead.code() } else { code };
        let (result, slot) = match outcome {
            Outcome::Silent => return None,
            Outcome::Answer(result) => (result, 0),
            Outcome::Slot(length) => (Ok(length), u32::from(me.get())),
        };
        if !status_return.answers(code) {
            return None;
        }
        let length = result.unwrap_or(0);
        let data = self.data.get(..length).unwrap_or_default();
        let bytes = Encoder::status(&mut self.reply, me, alert, result.err()).bytes(data).finish().ok()?;
        Some((return_delay_us.saturating_add(slot * BROADCAST_PING_SLOT_US), bytes.len()))
    }
}

/// Address and bytes of a write.
fn addressed(parameters: &[u8]) -> Result<(u16, &[u8]), StatusError> {
    match parameters {
        [low, high, bytes @ ..] if !bytes.is_empty() => Ok((u16::from_le_bytes([*low, *high]), bytes)),
        _ => Err(StatusError::DataLength),
    }
}
