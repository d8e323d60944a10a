//! Indirect registers: bytes of the control table that show, and write, others.
//!
//! From the e-Manual ("Indirect Address, Indirect Data"): each byte of the data takes the properties of the byte whose address is at the
//! same place; only RAM can be shown. An address that was never written is that of its own data, which is a byte of memory then.

use dynamixel::{IndirectArea, Layout, Model, StatusError};

/// A piece of a write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stretch {
    /// Items from an address on.
    Items(u16, Vec<u8>),
    /// An Indirect Address, and what it becomes.
    Address(u16, u16),
    /// A byte that means nothing.
    Plain(u16, u8),
}

/// The indirect registers of a model.
#[derive(Clone, Copy, Debug)]
pub struct Indirect {
    areas: &'static [IndirectArea],
    /// What can be shown.
    shown: [u16; 2],
    /// Whether the addresses outlive the power, and are locked by the torque.
    pub outlives: bool,
}

/// What lies at an address.
enum Place {
    /// Byte of an Indirect Address: of the low one if `first`.
    Address { first: bool },
    /// Indirect Data, and where its address is.
    Data { address: u16 },
}

impl Indirect {
    /// Of a model.
    pub fn of(model: &Model) -> Self {
        let last = model.indirect.iter().map(|area| area.data + area.length - 1).max().unwrap_or(0);
        let (shown, outlives) = match model.layout {
            Layout::X => ([64, last], false),
            Layout::P => ([512, 1023], true),
        };
        Self { areas: model.indirect, shown, outlives }
    }

    /// The address behind all of them.
    pub fn end(&self) -> u16 {
        self.areas.iter().map(|area| (area.data + area.length).max(area.addresses + 2 * area.length)).max().unwrap_or(0)
    }

    fn place(&self, address: u16) -> Option<Place> {
        self.areas.iter().find_map(|area| {
            let data = address.checked_sub(area.data).filter(|&place| place < area.length);
            let half = address.checked_sub(area.addresses).filter(|&half| half < 2 * area.length);
            data.map(|place| Place::Data { address: area.addresses + 2 * place })
                .or(half.map(|half| Place::Address { first: half % 2 == 0 }))
        })
    }

    /// Whether there is one at an address.
    pub fn is_at(&self, address: u16) -> bool {
        self.place(address).is_some()
    }

    /// Puts the factory's addresses into the table.
    pub fn restore(&self, memory: &mut [u8]) {
        for area in self.areas {
            for place in 0..area.length {
                let at = usize::from(area.addresses + 2 * place);
                memory[at..at + 2].copy_from_slice(&(area.data + place).to_le_bytes());
                memory[usize::from(area.data + place)] = 0;
            }
        }
    }

    /// The byte that is shown at an address.
    pub fn behind(&self, memory: &[u8], address: u16) -> u16 {
        match self.place(address) {
            Some(Place::Data { address }) => {
                let at = usize::from(address);
                u16::from_le_bytes([memory[at], memory[at + 1]])
            }
            _ => address,
        }
    }

    /// What a write comes to.
    ///
    /// # Errors
    /// Half an Indirect Address; one that shows what cannot be shown.
    pub fn stretches(&self, memory: &[u8], from: u16, bytes: &[u8]) -> Result<Vec<Stretch>, StatusError> {
        let mut stretches: Vec<Stretch> = Vec::new();
        let mut rest = bytes.iter().copied().zip(from..).peekable();
        while let Some((byte, address)) = rest.next() {
            match self.place(address) {
                Some(Place::Address { first: false }) => return Err(StatusError::Access),
                Some(Place::Address { first: true }) => {
                    let (high, _) = rest.next().ok_or(StatusError::DataLength)?;
                    let shown = u16::from_le_bytes([byte, high]);
                    if !(self.shown[0]..=self.shown[1]).contains(&shown) {
                        return Err(StatusError::DataRange);
                    }
                    stretches.push(Stretch::Address(address, shown));
                }
                _ => {
                    let behind = self.behind(memory, address);
                    if self.is_at(behind) {
                        stretches.push(Stretch::Plain(behind, byte));
                        continue;
                    }
                    match stretches.last_mut() {
                        Some(Stretch::Items(start, items))
                            if usize::from(behind) == usize::from(*start) + items.len() =>
                        {
                            items.push(byte);
                        }
                        _ => stretches.push(Stretch::Items(behind, vec![byte])),
                    }
                }
            }
        }
        Ok(stretches)
    }
}
