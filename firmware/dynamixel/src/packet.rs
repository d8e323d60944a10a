//! What a packet says: who is addressed, what is asked, what came of it.

use core::fmt;

/// The four bytes every packet begins with (the fourth is the e-Manual's "reserved" byte).
pub const HEADER: [u8; 4] = [0xFF, 0xFF, 0xFD, 0x00];

/// Bytes before the instruction: header, id, length.
pub(crate) const PREFIX_LENGTH: usize = 7;

/// Bytes of the CRC behind a packet.
pub(crate) const CRC_LENGTH: usize = 2;
/// Bytes of a device's block in the answer to a fast read, beside its data: error, id, CRC.
pub(crate) const BLOCK_LENGTH: usize = 2 + CRC_LENGTH;

/// Bytes of a packet with `parameters` parameter bytes that need no stuffing.
pub const fn packet_length(parameters: usize) -> usize {
    PREFIX_LENGTH + 1 + parameters + CRC_LENGTH
}

/// Length field of the answer to a fast read of devices that give this many data bytes; nothing if no packet is as long.
pub(crate) fn fast_length(data: impl Iterator<Item = u16>) -> Option<u16> {
    data.into_iter().try_fold(1u16, |sum, length| sum.checked_add(length)?.checked_add(BLOCK_LENGTH as u16))
}

/// The most bytes a packet with `parameters` parameter bytes can take: every third one stuffed.
pub const fn longest_packet_length(parameters: usize) -> usize {
    packet_length(parameters) + (parameters + 1) / 3
}

/// Bytes of a status packet with `parameters` parameter bytes that need no stuffing.
pub const fn status_length(parameters: usize) -> usize {
    packet_length(parameters + 1)
}

/// A packet's address: a device (0 to 252) or every device at once (254).
///
/// 253 and 255 are not addresses, because they occur in the header.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Id(u8);

impl Id {
    /// Every device on the bus.
    pub const BROADCAST: Id = Id(254);
    /// The highest address a device can have.
    pub const MAX: Id = Id(252);

    /// The device `id`, or nothing if no device can have this number (253 to 255).
    pub const fn new(id: u8) -> Option<Id> {
        if id <= Id::MAX.0 { Some(Id(id)) } else { None }
    }

    /// The number as written in a packet.
    pub const fn get(self) -> u8 {
        self.0
    }

    /// Whether every device is addressed.
    pub const fn is_broadcast(self) -> bool {
        self.0 == Id::BROADCAST.0
    }

    /// A packet's address field: a device's number or the broadcast's.
    pub(crate) const fn from_field(byte: u8) -> Option<Id> {
        if byte == Id::BROADCAST.0 { Some(Id::BROADCAST) } else { Id::new(byte) }
    }
}

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_broadcast() { f.write_str("broadcast") } else { write!(f, "{}", self.0) }
    }
}

/// What a packet is: an instruction of the master, or a device's answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Instruction {
    /// Is the device there, and what is it?
    Ping = 0x01,
    /// Read from the control table.
    Read = 0x02,
    /// Write to the control table.
    Write = 0x03,
    /// Keep a write until [`Instruction::Action`].
    RegWrite = 0x04,
    /// Carry out the write that was kept.
    Action = 0x05,
    /// Return the control table to its factory values.
    FactoryReset = 0x06,
    /// Restart the device.
    Reboot = 0x08,
    /// Forget certain information, such as the number of turns.
    Clear = 0x10,
    /// Store the control table, or restore it.
    ControlTableBackup = 0x20,
    /// A device's answer.
    Status = 0x55,
    /// Read the same items of several devices; each answers in its turn.
    SyncRead = 0x82,
    /// Write the same items of several devices; nobody answers.
    SyncWrite = 0x83,
    /// As [`Instruction::SyncRead`], answered with one packet to which each device adds.
    FastSyncRead = 0x8A,
    /// Read different items of several devices; each answers in its turn.
    BulkRead = 0x92,
    /// Write different items of several devices; nobody answers.
    BulkWrite = 0x93,
    /// As [`Instruction::BulkRead`], answered with one packet to which each device adds.
    FastBulkRead = 0x9A,
}

impl Instruction {
    /// Every instruction of Protocol 2.0, in the order of the codes.
    pub const ALL: [Instruction; 16] = [
        Instruction::Ping,
        Instruction::Read,
        Instruction::Write,
        Instruction::RegWrite,
        Instruction::Action,
        Instruction::FactoryReset,
        Instruction::Reboot,
        Instruction::Clear,
        Instruction::ControlTableBackup,
        Instruction::Status,
        Instruction::SyncRead,
        Instruction::SyncWrite,
        Instruction::FastSyncRead,
        Instruction::BulkRead,
        Instruction::BulkWrite,
        Instruction::FastBulkRead,
    ];

    /// The instruction's code in a packet.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The instruction with this code, or nothing if Protocol 2.0 has none.
    pub fn from_code(code: u8) -> Option<Instruction> {
        Instruction::ALL.into_iter().find(|instruction| instruction.code() == code)
    }
}

/// Why a device did not carry out an instruction (error number of a status packet).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StatusError {
    /// 1: the instruction could not be carried out.
    ResultFail,
    /// 2: no such instruction, or Action without a preceding Reg Write.
    Instruction,
    /// 3: the instruction arrived damaged.
    Crc,
    /// 4: a value outside the range of its item.
    DataRange,
    /// 5: the number of bytes does not fit the item.
    DataLength,
    /// 6: a value beyond a limit that another item sets.
    DataLimit,
    /// 7: no such item, or it cannot be read, or cannot be written (now).
    Access,
    /// A number that Protocol 2.0 does not define (8 to 127).
    Undefined(u8),
}

impl StatusError {
    /// The error number in a status packet (1 to 127).
    pub const fn code(self) -> u8 {
        match self {
            StatusError::ResultFail => 1,
            StatusError::Instruction => 2,
            StatusError::Crc => 3,
            StatusError::DataRange => 4,
            StatusError::DataLength => 5,
            StatusError::DataLimit => 6,
            StatusError::Access => 7,
            StatusError::Undefined(code) => code & !ALERT,
        }
    }

    /// The error with this number; nothing for 0. The alert bit is ignored.
    pub const fn from_code(code: u8) -> Option<StatusError> {
        Some(match code & !ALERT {
            0 => return None,
            1 => StatusError::ResultFail,
            2 => StatusError::Instruction,
            3 => StatusError::Crc,
            4 => StatusError::DataRange,
            5 => StatusError::DataLength,
            6 => StatusError::DataLimit,
            7 => StatusError::Access,
            code => StatusError::Undefined(code),
        })
    }
}

impl fmt::Display for StatusError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StatusError::ResultFail => f.write_str("the instruction could not be carried out"),
            StatusError::Instruction => f.write_str("undefined instruction"),
            StatusError::Crc => f.write_str("the instruction arrived damaged"),
            StatusError::DataRange => f.write_str("value outside the item's range"),
            StatusError::DataLength => f.write_str("number of bytes does not fit the item"),
            StatusError::DataLimit => f.write_str("value beyond the limit set"),
            StatusError::Access => f.write_str("no such item, or it cannot be accessed so"),
            StatusError::Undefined(code) => write!(f, "undefined error number {code}"),
        }
    }
}

impl core::error::Error for StatusError {}

/// Bit 7 of a status packet's error byte: a hardware error is present; its cause is in Hardware Error Status.
pub(crate) const ALERT: u8 = 0x80;

/// A packet received whole: CRC correct, stuffing removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Packet<'a> {
    /// Who is addressed; in a status packet, who answers.
    pub id: Id,
    /// The instruction's code, which may be one that Protocol 2.0 does not define.
    pub code: u8,
    /// What follows the instruction; in a status packet its first byte is the error byte.
    pub parameters: &'a [u8],
}

impl<'a> Packet<'a> {
    /// The instruction, or nothing if its code is not defined.
    pub fn instruction(&self) -> Option<Instruction> {
        Instruction::from_code(self.code)
    }

    /// Whether several devices have answered together, each with a block, to a fast read. Such a packet is not stuffed.
    pub fn is_fast_answer(&self) -> bool {
        self.code == Instruction::Status.code() && self.id.is_broadcast()
    }

    /// The packet as a device's answer; nothing if it is an instruction, comes from no device or lacks the error byte.
    pub fn status(&self) -> Option<Status<'a>> {
        if self.code != Instruction::Status.code() || self.id.is_broadcast() {
            return None;
        }
        let (&error, parameters) = self.parameters.split_first()?;
        Some(Status { id: self.id, alert: error & ALERT != 0, error: StatusError::from_code(error), parameters })
    }
}

/// A device's answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status<'a> {
    /// Who answers.
    pub id: Id,
    /// A hardware error is present in the device; Hardware Error Status says which.
    pub alert: bool,
    /// Why the instruction was not carried out, if it was not.
    pub error: Option<StatusError>,
    /// What was asked for.
    pub parameters: &'a [u8],
}

/// Which instructions a device answers (item Status Return Level).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StatusReturn {
    /// 0: Ping only.
    Ping,
    /// 1: Ping and the reading instructions.
    Read,
    /// 2: all (the factory's value).
    #[default]
    All,
}

impl StatusReturn {
    /// The level with this value of Status Return Level, or nothing above 2.
    pub const fn from_value(value: u8) -> Option<StatusReturn> {
        match value {
            0 => Some(StatusReturn::Ping),
            1 => Some(StatusReturn::Read),
            2 => Some(StatusReturn::All),
            _ => None,
        }
    }

    /// Whether an instruction with this code is answered at this level.
    pub fn answers(self, code: u8) -> bool {
        let reading = matches!(
            Instruction::from_code(code),
            Some(
                Instruction::Read
                    | Instruction::SyncRead
                    | Instruction::BulkRead
                    | Instruction::FastSyncRead
                    | Instruction::FastBulkRead
            )
        );
        match self {
            StatusReturn::All => true,
            StatusReturn::Read => reading || code == Instruction::Ping.code(),
            StatusReturn::Ping => code == Instruction::Ping.code(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_end_where_the_header_begins() {
        assert_eq!(Id::new(0).map(Id::get), Some(0));
        assert_eq!(Id::new(252), Some(Id::MAX));
        for refused in 253..=255 {
            assert_eq!(Id::new(refused), None);
        }
        assert_eq!(Id::from_field(254), Some(Id::BROADCAST));
        assert_eq!(Id::from_field(253), None);
        assert_eq!(Id::from_field(255), None);
    }

    #[test]
    fn every_code_has_at_most_one_instruction() {
        let known = (0..=255).filter_map(Instruction::from_code).count();
        assert_eq!(known, Instruction::ALL.len());
        for instruction in Instruction::ALL {
            assert_eq!(Instruction::from_code(instruction.code()), Some(instruction));
        }
    }

    #[test]
    fn every_error_number_survives() {
        assert_eq!(StatusError::from_code(0), None);
        assert_eq!(StatusError::from_code(ALERT), None);
        for code in 1..=127 {
            assert_eq!(StatusError::from_code(code).map(StatusError::code), Some(code));
            assert_eq!(StatusError::from_code(code | ALERT).map(StatusError::code), Some(code));
        }
    }

    #[test]
    fn an_instruction_is_no_status() {
        let id = Id::new(1).unwrap();
        assert_eq!(Packet { id, code: 0x01, parameters: &[0] }.status(), None);
        assert_eq!(Packet { id, code: 0x55, parameters: &[] }.status(), None);
        assert_eq!(Packet { id: Id::BROADCAST, code: 0x55, parameters: &[0] }.status(), None);
        let status = Packet { id, code: 0x55, parameters: &[0x87, 3] }.status().unwrap();
        assert!(status.alert);
        assert_eq!(status.error, Some(StatusError::Access));
        assert_eq!(status.parameters, [3]);
    }
}
