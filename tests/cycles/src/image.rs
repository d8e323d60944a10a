//! An image's link map, and how an address of one image is carried over to another.

use std::collections::HashMap;

use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

/// A function or a variable.
#[derive(Clone, Debug)]
struct Symbol {
    start: u32,
    size: u32,
    /// Its name without the hash that the compiler puts behind it.
    name: String,
}

/// The addresses of an image.
#[derive(Clone, Debug)]
pub struct Image {
    symbols: Vec<Symbol>,
    /// First address and length of code, constants, and variables.
    pieces: [(u32, u32); 3],
    stack_start: u32,
}

/// What is wrong with an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotAnImage(pub String);

impl std::fmt::Display for NotAnImage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for NotAnImage {}

impl Image {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// It is none, or has no symbols.
    pub fn parse(elf: &[u8]) -> Result<Self, NotAnImage> {
        let file = object::File::parse(elf).map_err(|error| NotAnImage(format!("not an ELF file: {error}")))?;
        let mut symbols = Vec::new();
        let mut stack_start = 0;
        for symbol in file.symbols() {
            let (Ok(name), address) = (symbol.name(), symbol.address() as u32) else { continue };
            if name == "_stack_start" {
                stack_start = address;
            }
            if symbol.size() > 0 && matches!(symbol.kind(), SymbolKind::Text | SymbolKind::Data | SymbolKind::Unknown) {
                // The lowest bit of a function's address says Thumb.
                let start = if symbol.kind() == SymbolKind::Text { address & !1 } else { address };
                symbols.push(Symbol { start, size: symbol.size() as u32, name: without_hash(name).to_owned() });
            }
        }
        if symbols.is_empty() {
            return Err(NotAnImage("without symbols".to_owned()));
        }
        symbols.sort_by_key(|symbol| symbol.start);
        let extent = |wanted: &[SectionKind]| {
            let sections =
                || file.sections().filter(|section| section.address() > 0 || section.name() == Ok(".vector_table"));
            let sections = || sections().filter(|section| wanted.contains(&section.kind()));
            let first = sections().map(|section| section.address()).min().unwrap_or(0);
            let end = sections().map(|section| section.address() + section.size()).max().unwrap_or(0);
            (first as u32, (end - first) as u32)
        };
        let pieces = [
            extent(&[SectionKind::Text]),
            extent(&[SectionKind::ReadOnlyData, SectionKind::ReadOnlyString]),
            extent(&[SectionKind::Data, SectionKind::UninitializedData]),
        ];
        Ok(Self { symbols, pieces, stack_start })
    }

    /// The symbol at an address, and how far behind its start it lies.
    fn symbol(&self, address: u32) -> Option<(usize, u32)> {
        let index = self.symbols.partition_point(|symbol| symbol.start <= address).checked_sub(1)?;
        let symbol = self.symbols.get(index)?;
        let offset = address - symbol.start;
        (offset < symbol.size).then_some((index, offset))
    }

    /// What lies at an address, for a reader.
    pub fn name(&self, address: u32) -> String {
        let Some((index, offset)) = self.symbol(address) else { return format!("{address:#010x}") };
        let name = self.symbols.get(index).map_or("", |symbol| symbol.name.as_str());
        let name = rustc_demangle::demangle(name).to_string();
        format!("{name} + {offset:#x}")
    }
}

/// A legacy name ends with `17h` and sixteen digits, which differ from build to build.
fn without_hash(name: &str) -> &str {
    let hash = name.len().checked_sub(20).and_then(|at| name.get(at..));
    match hash {
        Some(hash) if hash.starts_with("17h") && hash.ends_with('E') => name.get(..name.len() - 20).unwrap_or(name),
        _ => name,
    }
}

/// Carries addresses of one image over to another.
#[derive(Clone, Debug)]
pub struct LinkMap {
    from: Image,
    to: Image,
    /// For each symbol of the one image its counterpart's start and size in the other.
    counterparts: Vec<Option<(u32, u32)>>,
}

/// Where an address lies in the other image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Carried {
    /// There.
    pub address: u32,
    /// That it is known by name: the same function or variable, of the same size. Else it lies as far into its section.
    pub by_name: bool,
}

impl LinkMap {
    /// Pairs the symbols by name; those of one name by their order, if there are as many of them.
    pub fn new(from: Image, to: Image) -> Self {
        let mut named: HashMap<&str, Vec<(u32, u32)>> = HashMap::new();
        for symbol in &to.symbols {
            named.entry(&symbol.name).or_default().push((symbol.start, symbol.size));
        }
        let mut seen: HashMap<&str, usize> = HashMap::new();
        let mut counterparts = Vec::with_capacity(from.symbols.len());
        for symbol in &from.symbols {
            let place = seen.entry(&symbol.name).or_default();
            let same = named.get(symbol.name.as_str());
            // Instances of one generic function are told apart by their size first.
            let exact = same.and_then(|same| same.iter().find(|(_, size)| *size == symbol.size && same.len() > 1));
            counterparts.push(exact.or_else(|| same.and_then(|same| same.get(*place))).copied());
            *place += 1;
        }
        Self { from, to, counterparts }
    }

    /// Carries an address over.
    pub fn carry(&self, address: u32) -> Carried {
        if let Some((index, offset)) = self.from.symbol(address) {
            let size = self.from.symbols.get(index).map_or(0, |symbol| symbol.size);
            if let Some((start, other)) = self.counterparts.get(index).copied().flatten() {
                return Carried { address: start + offset.min(other.saturating_sub(1)), by_name: other == size };
            }
        }
        for ((first, length), (other, _)) in self.from.pieces.iter().zip(&self.to.pieces) {
            if address >= *first && address - first < *length {
                return Carried { address: other + (address - first), by_name: false };
            }
        }
        // The stack grows down from its start, in both images by the same amounts.
        let depth = self.from.stack_start.wrapping_sub(address);
        if depth <= STACK_BYTES {
            return Carried { address: self.to.stack_start.wrapping_sub(depth), by_name: true };
        }
        Carried { address, by_name: false }
    }

    /// The image that addresses are carried over to.
    pub fn target(&self) -> &Image {
        &self.to
    }
}

/// No board has more stack.
const STACK_BYTES: u32 = 32 * 1024;

#[cfg(test)]
mod tests {
    use super::*;

    fn image(symbols: &[(u32, u32, &str)], text: u32) -> Image {
        let symbols = symbols.iter().map(|&(start, size, name)| Symbol { start, size, name: name.to_owned() });
        Image {
            symbols: symbols.collect(),
            pieces: [(text, 0x1000), (text + 0x1000, 0x100), (0x2000_0000, 0x100)],
            stack_start: text,
        }
    }

    #[test]
    fn an_address_is_carried_by_name_then_by_section() {
        let from = image(
            &[(0x100, 0x20, "solve"), (0x120, 0x10, "only_here"), (0x130, 0x40, "twice"), (0x170, 0x8, "twice")],
            0,
        );
        let to = image(&[(0x8100, 0x20, "solve"), (0x8200, 0x8, "twice"), (0x8300, 0x40, "twice")], 0x8000);
        let map = LinkMap::new(from, to);
        assert_eq!(map.carry(0x104), Carried { address: 0x8104, by_name: true });
        assert_eq!(map.carry(0x124), Carried { address: 0x8124, by_name: false });
        assert_eq!(map.carry(0x134), Carried { address: 0x8304, by_name: true }, "the one of the same size");
        assert_eq!(map.carry(0x172), Carried { address: 0x8202, by_name: true });
        assert_eq!(map.carry(0x4000_0000), Carried { address: 0x4000_0000, by_name: false }, "a device stays");
        assert_eq!(map.target().name(0x8104), "solve + 0x4");
    }

    #[test]
    fn the_stack_is_carried_by_its_depth() {
        let from = Image { stack_start: 0x2008_0000, ..image(&[(0x100, 4, "a")], 0) };
        let to = Image { stack_start: 0x2000_8000, ..image(&[(0x8100, 4, "a")], 0x8000) };
        let map = LinkMap::new(from, to);
        assert_eq!(map.carry(0x2007_fff0), Carried { address: 0x2000_7ff0, by_name: true });
    }

    #[test]
    fn a_hash_is_not_part_of_a_name() {
        assert_eq!(without_hash("_ZN4core3fmt5write17h0042db6166957f81E"), "_ZN4core3fmt5write");
        assert_eq!(without_hash("main"), "main");
    }

    #[test]
    fn what_is_no_image_is_said() {
        assert!(Image::parse(b"no").unwrap_err().to_string().contains("not an ELF file"));
    }
}
