//! Images of firmware, as far as tools on a PC look at them.

use fre_boards::{Label, SECTION};

/// An ELF file for a machine (40: Arm) with these segments (physical address, bytes), and with the label of a board and a version.
pub fn elf(machine: u16, segments: &[(u32, &[u8])], label: Option<(&str, &str)>) -> Vec<u8> {
    let label = label.map_or(Vec::new(), |(board, version)| Label::new(board, version).bytes().to_vec());
    let names = format!("\0{SECTION}\0");
    let segments_end = 52 + 32 * segments.len() as u32;
    let label_at = segments_end + segments.iter().map(|(_, bytes)| bytes.len() as u32).sum::<u32>();
    let names_at = label_at + label.len() as u32;
    // Tables begin at words.
    let sections_at = (names_at + names.len() as u32).next_multiple_of(4);
    let sections: u16 = if label.is_empty() { 0 } else { 3 };

    let mut file = vec![0x7f, b'E', b'L', b'F', 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    let halves = |file: &mut Vec<u8>, values: &[u16]| values.iter().for_each(|value| file.extend(value.to_le_bytes()));
    let words = |file: &mut Vec<u8>, values: &[u32]| values.iter().for_each(|value| file.extend(value.to_le_bytes()));
    // Executable; version, entry, tables of segments and sections, flags; sizes of the header and of a segment's row.
    halves(&mut file, &[2, machine]);
    words(&mut file, &[1, 0, 52, if sections == 0 { 0 } else { sections_at }, 0]);
    halves(&mut file, &[52, 32, segments.len() as u16, 40, sections, sections.saturating_sub(1)]);
    let mut offset = segments_end;
    for (address, bytes) in segments {
        let size = bytes.len() as u32;
        words(&mut file, &[1, offset, *address, *address, size, size, 5, 4]);
        offset += size;
    }
    segments.iter().for_each(|(_, bytes)| file.extend(*bytes));
    if sections > 0 {
        file.extend(&label);
        file.extend(names.bytes());
        file.resize(sections_at as usize, 0);
        words(&mut file, &[0; 10]);
        words(&mut file, &[1, 1, 0, 0, label_at, label.len() as u32, 0, 0, 1, 0]);
        words(&mut file, &[0, 3, 0, 0, names_at, names.len() as u32, 0, 0, 1, 0]);
    }
    file
}
