//! What a servo's registers hold: its control table as bytes, with factory values, indirect registers and a backup.

use dynamixel::{Area, Item, Model, Register, StatusError, Value, find, xm430};

use super::indirect::{Indirect, Stretch};

/// A control table. Registers are named as the XM430's ([`xm430`]), wherever the model has them.
#[derive(Clone, Debug)]
pub struct Registers {
    /// Of which model.
    pub model: &'static Model,
    /// In the order of their addresses.
    items: Vec<Item>,
    memory: Vec<u8>,
    indirect: Indirect,
    /// What Control Table Backup has stored.
    backup: Option<Vec<u8>>,
}

/// Gains and profile, by the XM430's addresses: what Control Table Backup keeps of the RAM.
const CONTROL: [[u16; 2]; 2] = [[76, 92], [108, 116]];

impl Registers {
    /// As a model comes from the factory; empty if its table is not known.
    pub fn new(model: &'static Model) -> Self {
        let mut items: Vec<Item> = model.items().into_iter().flatten().collect();
        items.sort_by_key(|item| item.address);
        let indirect = Indirect::of(model);
        let last = model.at(xm430::BACKUP_READY).item.end();
        let mut registers =
            Self { model, items, memory: vec![0; usize::from(last.max(indirect.end()))], indirect, backup: None };
        registers.restore(Area::Eeprom);
        registers.restore(Area::Ram);
        registers.indirect.restore(&mut registers.memory);
        registers
    }

    /// The value of a register; 0 of one that the model does not have.
    pub fn get<T: Value>(&self, register: Register<T>) -> T {
        let from = usize::from(self.model.at(register).address());
        let mut bytes = [0; 4];
        for (to, byte) in bytes.iter_mut().zip(&self.memory[from..from + usize::from(T::LENGTH)]) {
            *to = *byte;
        }
        T::from_bytes(bytes)
    }

    /// Sets a register, if the model has it.
    pub fn put<T: Value>(&mut self, register: Register<T>, value: T) {
        let from = usize::from(self.model.at(register).address());
        let length = usize::from(T::LENGTH);
        if self.item(register).is_some() {
            self.memory[from..from + length].copy_from_slice(&value.to_bytes()[..length]);
        }
    }

    /// The model's own item for a register.
    pub fn item<T: Value>(&self, register: Register<T>) -> Option<&Item> {
        find(&self.items, self.model.at(register).address())
    }

    /// The value of a register, with the sign that it has on this model; 0 of one that the model does not have.
    pub fn number<T: Value>(&self, register: Register<T>) -> i64 {
        let bytes = |item: &Item| self.memory.get(usize::from(item.address)..usize::from(item.end()));
        self.item(register).and_then(|item| item.decode(bytes(item)?)).unwrap_or(0)
    }

    /// The items.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// The bytes of an area are the factory's again. (The identity is the caller's.)
    pub fn restore(&mut self, area: Area) {
        for item in self.items.iter().filter(|item| item.area == area) {
            let (from, length) = (usize::from(item.address), usize::from(item.length));
            self.memory[from..from + length].copy_from_slice(&item.default.to_le_bytes()[..length]);
        }
        if self.indirect.outlives == (area == Area::Eeprom) {
            self.indirect.restore(&mut self.memory);
        }
    }

    /// Keeps a copy.
    pub fn store(&mut self) {
        self.backup = Some(self.memory.clone());
    }

    /// Whether there is a copy.
    pub fn is_stored(&self) -> bool {
        self.backup.is_some()
    }

    /// What the copy has of the EEPROM; false if there is none.
    pub fn restore_eeprom(&mut self) -> bool {
        let Some(backup) = &self.backup else { return false };
        for item in self.items.iter().filter(|item| item.area == Area::Eeprom) {
            let range = usize::from(item.address)..usize::from(item.end());
            self.memory[range.clone()].copy_from_slice(&backup[range]);
        }
        true
    }

    /// Gains and profile.
    fn control(&self) -> impl Iterator<Item = &Item> {
        self.items.iter().filter(|item| {
            let place = self.model.layout.canonical(item.address);
            item.area == Area::Ram
                && place.is_some_and(|place| CONTROL.iter().any(|[from, to]| (*from..*to).contains(&place)))
        })
    }

    /// Gains and profile are the factory's again.
    pub fn restore_control(&mut self) {
        let control: Vec<Item> = self.control().copied().collect();
        for item in control {
            let (from, length) = (usize::from(item.address), usize::from(item.length));
            self.memory[from..from + length].copy_from_slice(&item.default.to_le_bytes()[..length]);
        }
    }

    /// What the copy has of the RAM, if there is one: gains, profile, indirect addresses.
    pub fn restore_ram(&mut self) {
        let control: Vec<Item> = self.control().copied().collect();
        let Some(backup) = &self.backup else { return };
        for item in control {
            let range = usize::from(item.address)..usize::from(item.end());
            self.memory[range.clone()].copy_from_slice(&backup[range]);
        }
        for area in self.model.indirect {
            let range = usize::from(area.addresses)..usize::from(area.addresses + 2 * area.length);
            self.memory[range.clone()].copy_from_slice(&backup[range]);
        }
    }

    /// Whether so many bytes can be read from an address on: they begin and end where something is.
    ///
    /// # Errors
    /// They do not.
    pub fn check_read(&self, address: u16, length: usize) -> Result<(), StatusError> {
        let last = length.checked_sub(1).ok_or(StatusError::DataLength)?;
        let last = u16::try_from(last).ok().and_then(|more| address.checked_add(more)).ok_or(StatusError::Access)?;
        let is = |address| find(&self.items, address).is_some() || self.indirect.is_at(address);
        if is(address) && is(last) { Ok(()) } else { Err(StatusError::Access) }
    }

    /// Whether a read shows a byte of a register, directly or by an indirect one.
    pub fn shows<T: Value>(&self, register: Register<T>, address: u16, length: usize) -> bool {
        let item = self.model.at(register).item;
        (address..).take(length).any(|at| (item.address..item.end()).contains(&self.indirect.behind(&self.memory, at)))
    }

    /// Reads what [`Self::check_read`] has allowed.
    pub fn read(&self, address: u16, bytes: &mut [u8]) {
        for (byte, at) in bytes.iter_mut().zip(address..) {
            *byte = self.memory.get(usize::from(self.indirect.behind(&self.memory, at))).copied().unwrap_or(0);
        }
    }

    /// What a write comes to.
    ///
    /// # Errors
    /// Half an Indirect Address; one that shows what cannot be shown.
    pub fn stretches(&self, address: u16, bytes: &[u8]) -> Result<Vec<Stretch>, StatusError> {
        self.indirect.stretches(&self.memory, address, bytes)
    }

    /// Whether Indirect Addresses are kept with the EEPROM.
    pub fn keeps_indirect(&self) -> bool {
        self.indirect.outlives
    }

    /// Writes a stretch that was checked.
    pub fn write(&mut self, stretch: &Stretch) {
        let (address, bytes) = match stretch {
            Stretch::Items(address, bytes) => (*address, bytes.clone()),
            Stretch::Address(address, shown) => (*address, shown.to_le_bytes().to_vec()),
            Stretch::Plain(address, byte) => (*address, vec![*byte]),
        };
        let from = usize::from(address);
        if let Some(place) = self.memory.get_mut(from..from + bytes.len()) {
            place.copy_from_slice(&bytes);
        }
    }
}
