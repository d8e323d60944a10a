//! CRC-16 of Protocol 2.0: polynomial 0x8005, start value 0, most significant bit first, nothing inverted.
//!
//! Half a byte at a time through 16 entries: 32 bytes of flash instead of 512, at two look-ups per byte.

const POLYNOMIAL: u16 = 0x8005;

// Computed by the compiler: an index outside would be its error.
#[allow(clippy::indexing_slicing)]
const TABLE: [u16; 16] = {
    let mut table = [0; 16];
    let mut index = 0;
    while index < 16 {
        let mut value = (index as u16) << 12;
        let mut bit = 0;
        while bit < 4 {
            value = if value & 0x8000 != 0 { (value << 1) ^ POLYNOMIAL } else { value << 1 };
            bit += 1;
        }
        table[index] = value;
        index += 1;
    }
    table
};

/// CRC of `bytes`, continuing from `crc` (0 at a packet's first header byte).
///
/// A packet's CRC covers everything from the header to the last stuffed parameter.
pub fn update(crc: u16, bytes: &[u8]) -> u16 {
    bytes.iter().fold(crc, |crc, &byte| nibble(nibble(crc, byte >> 4), byte & 0x0F))
}

fn nibble(crc: u16, nibble: u8) -> u16 {
    let index = (crc >> 12) as u8 ^ nibble;
    // The mask keeps the index inside the table.
    #[allow(clippy::indexing_slicing)]
    let entry = TABLE[usize::from(index & 0x0F)];
    (crc << 4) ^ entry
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bit by bit, as the polynomial is defined.
    fn by_bits(bytes: &[u8]) -> u16 {
        let mut crc = 0u16;
        for &byte in bytes {
            crc ^= u16::from(byte) << 8;
            for _ in 0..8 {
                crc = if crc & 0x8000 != 0 { (crc << 1) ^ POLYNOMIAL } else { crc << 1 };
            }
        }
        crc
    }

    #[test]
    fn table_agrees_with_the_polynomial_for_every_byte_and_position() {
        for first in 0..=255 {
            for second in 0..=255 {
                assert_eq!(update(0, &[first, second]), by_bits(&[first, second]));
            }
        }
    }

    #[test]
    fn published_check_value() {
        // CRC-16/UMTS (alias BUYPASS): the catalogue's check value of "123456789".
        assert_eq!(update(0, b"123456789"), 0xFEE8);
    }

    #[test]
    fn parts_add_up() {
        let whole = update(0, b"continued");
        assert_eq!(update(update(0, b"conti"), b"nued"), whole);
    }
}
