//! What Factory Reset, Clear and Control Table Backup say beside their code.
//!
//! Source: ROBOTIS e-Manual, [Protocol 2.0](https://emanual.robotis.com/docs/en/dxl/protocol2/).

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

/// What Control Table Backup does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Backup {
    /// Keeps a copy of the control table.
    Store,
    /// Returns the control table to that copy, and restarts the device.
    Restore,
}

/// What makes Clear valid, after what is to be cleared: "DXL" and a quotation mark.
pub(crate) const CLEAR_KEY: [u8; 4] = [0x44, 0x58, 0x4C, 0x22];
/// What makes Control Table Backup valid, after what is to be done: "CTRL".
pub(crate) const BACKUP_KEY: [u8; 4] = *b"CTRL";

impl Backup {
    /// As written in the packet.
    pub(crate) const fn code(self) -> u8 {
        match self {
            Backup::Store => 1,
            Backup::Restore => 2,
        }
    }
}

impl ResetScope {
    /// As written in the packet.
    pub(crate) const fn code(self) -> u8 {
        match self {
            ResetScope::All => 0xFF,
            ResetScope::ExceptId => 1,
            ResetScope::ExceptIdAndBaudRate => 2,
        }
    }
}
