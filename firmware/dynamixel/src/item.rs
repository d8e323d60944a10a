//! Items of a control table: where they are, what they hold, who may change them.

use core::marker::PhantomData;

use crate::packet::StatusError;

/// A number that an item can hold.
pub trait Value: Copy {
    /// Bytes in the control table.
    const LENGTH: u16;
    /// The little-endian bytes, as many as [`Value::LENGTH`]; the rest is 0.
    fn to_bytes(self) -> [u8; 4];
    /// From little-endian bytes, of which the first [`Value::LENGTH`] count.
    fn from_bytes(bytes: [u8; 4]) -> Self;
}

macro_rules! value {
    ($($number:ty, $wide:ty);+) => {$(
        impl Value for $number {
            const LENGTH: u16 = (<$number>::BITS / 8) as u16;
            fn to_bytes(self) -> [u8; 4] {
                // Zero-extended: the cast goes through the unsigned number of the same width.
                (self as $wide as u32).to_le_bytes()
            }
            fn from_bytes(bytes: [u8; 4]) -> Self {
                u32::from_le_bytes(bytes) as $number
            }
        }
    )+};
}
value!(u8, u8; i8, u8; u16, u16; i16, u16; u32, u32; i32, u32);

/// Who may change an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Access {
    /// Only the device itself.
    Read,
    /// The master as well.
    ReadWrite,
}

/// Where an item is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Area {
    /// Survives power-off; cannot be written while Torque Enable is 1.
    Eeprom,
    /// Starts from its default.
    Ram,
}

/// One item of a control table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Item {
    /// First address.
    pub address: u16,
    /// Bytes: 1, 2 or 4.
    pub length: u16,
    /// Whether the number is in two's complement.
    pub signed: bool,
    /// Who may change it.
    pub access: Access,
    /// Where it is kept.
    pub area: Area,
    /// The factory's value (0 where the manual gives none).
    pub default: i64,
    /// The least value that may be written.
    pub min: i64,
    /// The greatest value that may be written.
    pub max: i64,
}

impl Item {
    /// The address behind the item.
    pub const fn end(&self) -> u16 {
        self.address + self.length
    }

    /// The number in the item's little-endian bytes; nothing if their count differs from the item's length.
    pub fn decode(&self, bytes: &[u8]) -> Option<i64> {
        if bytes.len() != usize::from(self.length) {
            return None;
        }
        let mut wide = [0; 4];
        for (to, from) in wide.iter_mut().zip(bytes) {
            *to = *from;
        }
        let number = u32::from_le_bytes(wide);
        Some(match (self.signed, self.length) {
            (true, 1) => i64::from(number as u8 as i8),
            (true, 2) => i64::from(number as u16 as i16),
            (true, _) => i64::from(number as i32),
            (false, _) => i64::from(number),
        })
    }
}

/// An item together with the Rust type of its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Register<T> {
    /// Address, length, access and range.
    pub item: Item,
    value: PhantomData<T>,
}

impl<T: Value> Register<T> {
    /// A register that the master may read only.
    pub const fn read(address: u16, signed: bool, area: Area, default: i64) -> Self {
        let access = Access::Read;
        let item = Item { address, length: T::LENGTH, signed, access, area, default, min: i64::MIN, max: i64::MAX };
        Register { item, value: PhantomData }
    }

    /// A register that the master may write, with the values it takes.
    pub const fn write(address: u16, signed: bool, area: Area, default: i64, min: i64, max: i64) -> Self {
        let access = Access::ReadWrite;
        Register {
            item: Item { address, length: T::LENGTH, signed, access, area, default, min, max },
            value: PhantomData,
        }
    }

    /// First address.
    pub const fn address(&self) -> u16 {
        self.item.address
    }

    /// The same register at another address.
    pub(crate) const fn moved(self, address: u16) -> Self {
        Register { item: Item { address, ..self.item }, value: PhantomData }
    }
}

/// The item that holds `address`. `items` are in the order of their addresses.
pub fn find(items: &[Item], address: u16) -> Option<&Item> {
    let after = items.partition_point(|item| item.address <= address);
    let item = items.get(after.checked_sub(1)?)?;
    (address < item.end()).then_some(item)
}

/// Whether `length` bytes from `address` may be read: they begin and end in items, gaps between items are allowed.
///
/// Gaps read as 0 on the servo, so that one read can cover several items.
pub fn check_read(items: &[Item], address: u16, length: usize) -> Result<(), StatusError> {
    if length == 0 {
        return Err(StatusError::DataLength);
    }
    let last = u16::try_from(length - 1).ok().and_then(|more| address.checked_add(more)).ok_or(StatusError::Access)?;
    find(items, address).and(find(items, last)).map(|_| ()).ok_or(StatusError::Access)
}

/// One item's part of a write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part<'a> {
    /// The item to be written.
    pub item: Item,
    /// Its new bytes, as many as its length.
    pub bytes: &'a [u8],
    /// Its new value.
    pub value: i64,
}

/// Splits a write of `data` from `address` into items, checking each as the e-Manual says.
///
/// `locked` is true while Torque Enable is 1. A write that begins where no item begins, or at one that cannot be written
/// (now), gives [`StatusError::Access`]; one that ends inside an item [`StatusError::DataLength`]; a value outside the
/// item's range [`StatusError::DataRange`]. Go through all parts before carrying out the first.
pub fn writes<'a>(
    items: &'a [Item],
    locked: bool,
    address: u16,
    data: &'a [u8],
) -> impl Iterator<Item = Result<Part<'a>, StatusError>> {
    let mut next = Some((address, data));
    core::iter::from_fn(move || {
        let (address, data) = next.take()?;
        let part = part(items, locked, address, data);
        if let Ok(part) = &part {
            let rest = data.get(part.bytes.len()..).unwrap_or_default();
            next = (!rest.is_empty()).then_some((part.item.end(), rest));
        }
        Some(part)
    })
}

fn part<'a>(items: &[Item], locked: bool, address: u16, data: &'a [u8]) -> Result<Part<'a>, StatusError> {
    let item = *find(items, address).ok_or(StatusError::Access)?;
    if item.address != address || item.access == Access::Read || (locked && item.area == Area::Eeprom) {
        return Err(StatusError::Access);
    }
    let bytes = data.get(..usize::from(item.length)).ok_or(StatusError::DataLength)?;
    let value = item.decode(bytes).ok_or(StatusError::DataLength)?;
    if value < item.min || value > item.max {
        return Err(StatusError::DataRange);
    }
    Ok(Part { item, bytes, value })
}

/// Registers that show others: each byte of the data shows the byte whose address is at the same place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IndirectArea {
    /// The first Indirect Address, two bytes each.
    pub addresses: u16,
    /// The first Indirect Data, one byte each.
    pub data: u16,
    /// Bytes of data.
    pub length: u16,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::xm430;

    #[test]
    fn values_keep_their_sign_and_width() {
        assert_eq!(i16::from_bytes((-2i16).to_bytes()), -2);
        assert_eq!((-2i16).to_bytes(), [0xFE, 0xFF, 0, 0]);
        assert_eq!((-2i32).to_bytes(), [0xFE, 0xFF, 0xFF, 0xFF]);
        assert_eq!(i32::from_bytes(i32::MIN.to_bytes()), i32::MIN);
        assert_eq!(u8::from_bytes([200, 1, 1, 1]), 200);
        assert_eq!(xm430::PRESENT_CURRENT.item.decode(&[0xFF, 0xFF]), Some(-1));
        assert_eq!(xm430::PRESENT_POSITION.item.decode(&[0xFF, 0xFF]), None);
    }

    #[test]
    fn a_write_is_split_into_items() {
        let data = [1, 0, 0, 0, 2, 0, 0, 0, 0x00, 0x08, 0, 0];
        let parts: Result<[Option<i64>; 4], _> = {
            let mut values = [None; 4];
            let mut error = None;
            for (slot, part) in values.iter_mut().zip(writes(&xm430::ITEMS, false, 108, &data)) {
                match part {
                    Ok(part) => *slot = Some(part.value),
                    Err(e) => error = Some(e),
                }
            }
            error.map_or(Ok(values), Err)
        };
        assert_eq!(parts, Ok([Some(1), Some(2), Some(2048), None]));
    }

    fn first_error(locked: bool, address: u16, data: &[u8]) -> Option<StatusError> {
        writes(&xm430::ITEMS, locked, address, data).find_map(Result::err)
    }

    #[test]
    fn refusals_are_those_of_the_manual() {
        assert_eq!(first_error(false, 64, &[1]), None);
        assert_eq!(first_error(false, 64, &[2]), Some(StatusError::DataRange));
        assert_eq!(first_error(false, 116, &[0, 8]), Some(StatusError::DataLength));
        assert_eq!(first_error(false, 117, &[0, 8, 0, 0]), Some(StatusError::Access));
        assert_eq!(first_error(false, 132, &[0, 8, 0, 0]), Some(StatusError::Access));
        assert_eq!(first_error(false, 700, &[0]), Some(StatusError::Access));
        assert_eq!(first_error(false, 9, &[10]), None);
        assert_eq!(first_error(true, 9, &[10]), Some(StatusError::Access));
        assert_eq!(first_error(false, 65_535, &[0, 0]), Some(StatusError::Access));
    }

    #[test]
    fn reads_may_cover_gaps_but_not_leave_the_table() {
        assert_eq!(check_read(&xm430::ITEMS, 126, 10), Ok(()));
        assert_eq!(check_read(&xm430::ITEMS, 132, 0), Err(StatusError::DataLength));
        assert_eq!(check_read(&xm430::ITEMS, 147, 2), Err(StatusError::Access));
        assert_eq!(check_read(&xm430::ITEMS, 65_535, 4), Err(StatusError::Access));
    }
}
