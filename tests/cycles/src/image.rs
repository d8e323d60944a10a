//! An image's link map, and how an address of one image is carried over to another.

use std::collections::HashMap;

use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

/// A function or a variable.
#[derive(Clone, Debug)]
struct Symbol {
    start: u32,
    size: u32,
    /// Its name as [`name_of`] makes it.
    name: String,
}

/// A piece of memory that the linker filled.
#[derive(Clone, Debug)]
struct Section {
    name: String,
    first: u32,
    bytes: u32,
}

/// The addresses of an image.
#[derive(Clone, Debug)]
pub struct Image {
    symbols: Vec<Symbol>,
    /// Those that are loaded, or cleared at the start.
    sections: Vec<Section>,
    stack_start: u32,
    /// Where a function starts, and where the linker's own code starts by which far branches reach it.
    detours: Vec<(u32, u32)>,
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
        let (mut starts, mut detours) = (HashMap::new(), Vec::new());
        let mut stack_start = 0;
        for symbol in file.symbols() {
            let (Ok(name), address) = (symbol.name(), symbol.address() as u32) else { continue };
            if name == "_stack_start" {
                stack_start = address;
            }
            if symbol.size() > 0 && matches!(symbol.kind(), SymbolKind::Text | SymbolKind::Data | SymbolKind::Unknown) {
                // The lowest bit of a function's address says Thumb.
                let start = if symbol.kind() == SymbolKind::Text { address & !1 } else { address };
                match name.split_once(DETOUR) {
                    Some((_, goal)) => detours.push((goal, start)),
                    None => drop(starts.insert(name, start)),
                }
                symbols.push(Symbol { start, size: symbol.size() as u32, name: name_of(name) });
            }
        }
        if symbols.is_empty() {
            return Err(NotAnImage("without symbols".to_owned()));
        }
        symbols.sort_by_key(|symbol| symbol.start);
        let in_memory = |kind| {
            use SectionKind::{Data, ReadOnlyData, ReadOnlyString, Text, UninitializedData};
            matches!(kind, Text | ReadOnlyData | ReadOnlyString | Data | UninitializedData)
        };
        let sections = file.sections().filter(|section| in_memory(section.kind()) && section.size() > 0);
        let sections = sections
            .filter_map(|section| {
                let name = section.name().ok()?.to_owned();
                Some(Section { name, first: section.address() as u32, bytes: section.size() as u32 })
            })
            .collect();
        let detours = detours.into_iter().filter_map(|(goal, start)| Some((*starts.get(goal)?, start))).collect();
        Ok(Self { symbols, sections, stack_start, detours })
    }

    /// Where the linker's own code is by which a branch reaches a function that is too far away for it.
    pub fn detour(&self, from: u32, to: u32) -> Option<u32> {
        let to_it = self.detours.iter().filter(|(goal, _)| from.abs_diff(to) > FARTHEST && *goal == to);
        to_it.map(|&(_, start)| start).min_by_key(|start| start.abs_diff(from))
    }

    /// The symbol at an address, and how far behind its start it lies.
    fn symbol(&self, address: u32) -> Option<(usize, u32)> {
        let index = self.symbols.partition_point(|symbol| symbol.start <= address).checked_sub(1)?;
        let symbol = self.symbols.get(index)?;
        let offset = address - symbol.start;
        (offset < symbol.size).then_some((index, offset))
    }

    /// The function at an address.
    pub fn function(&self, address: u32) -> Option<&str> {
        let (index, _) = self.symbol(address)?;
        Some(self.symbols.get(index)?.name.as_str())
    }

    /// What lies at an address, for a reader.
    pub fn name(&self, address: u32) -> String {
        let Some((index, offset)) = self.symbol(address) else { return format!("{address:#010x}") };
        let name = self.symbols.get(index).map_or("", |symbol| symbol.name.as_str());
        format!("{name} + {offset:#x}")
    }
}

/// What stands before a function's name in the name of the code by which far branches reach it.
const DETOUR: &str = "LongThunk_";
/// How far a branch reaches (Armv7-M, `B` and `BL`, encodings T4 and T1).
const FARTHEST: u32 = 16 << 20;

/// What the crates of the boards' images are named by, each followed by its board's own name.
const IMAGE: &str = "gripper_";

/// A symbol's name as it is the same in every image: without the hash that the compiler puts behind it, which differs from build to build,
/// and with `image` in place of the image's own crate.
fn name_of(symbol: &str) -> String {
    let name = format!("{:#}", rustc_demangle::demangle(symbol));
    let mut pieces = name.split(IMAGE);
    let mut same = pieces.next().unwrap_or("").to_owned();
    for piece in pieces {
        same += "image";
        same += piece.trim_start_matches(|c: char| c.is_ascii_alphanumeric() || c == '_');
    }
    same
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
    /// That it is known by name: the same function or variable, of the same size. Else it lies as far into the section of the same name.
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
        let within = |section: &&Section| section.first <= address && address - section.first < section.bytes;
        if let Some(section) = self.from.sections.iter().find(within)
            && let Some(other) = self.to.sections.iter().find(|other| other.name == section.name)
        {
            let offset = (address - section.first).min(other.bytes - 1);
            return Carried { address: other.first + offset, by_name: false };
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

    fn image(symbols: &[(u32, u32, &str)], sections: &[(u32, u32, &str)]) -> Image {
        let symbols = symbols.iter().map(|&(start, size, name)| Symbol { start, size, name: name_of(name) });
        let sections = sections.iter().map(|&(first, bytes, name)| Section { name: name.to_owned(), first, bytes });
        Image { symbols: symbols.collect(), sections: sections.collect(), stack_start: 0, detours: Vec::new() }
    }

    #[test]
    fn an_address_is_carried_by_name_then_by_section() {
        let from = image(
            &[(0x100, 0x20, "solve"), (0x120, 0x10, "only_here"), (0x130, 0x40, "twice"), (0x170, 0x8, "twice")],
            &[(0x100, 0x1000, ".text"), (0x2000_0000, 0x100, ".bss")],
        );
        let to = image(
            &[(0x8100, 0x20, "solve"), (0x8200, 0x8, "twice"), (0x8300, 0x40, "twice")],
            &[
                (0x40, 0x20, ".fast"),
                (0x8100, 0x1000, ".text"),
                (0x100, 0x20, ".fast_data"),
                (0x2400_0000, 0x80, ".bss"),
            ],
        );
        let map = LinkMap::new(from, to);
        assert_eq!(map.carry(0x104), Carried { address: 0x8104, by_name: true });
        assert_eq!(map.carry(0x124), Carried { address: 0x8124, by_name: false });
        assert_eq!(map.carry(0x134), Carried { address: 0x8304, by_name: true }, "the one of the same size");
        assert_eq!(map.carry(0x172), Carried { address: 0x8202, by_name: true });
        assert_eq!(map.carry(0x2000_0010), Carried { address: 0x2400_0010, by_name: false }, "whatever lies below it");
        assert_eq!(map.carry(0x2000_00f0), Carried { address: 0x2400_007f, by_name: false }, "a shorter section");
        assert_eq!(map.carry(0x4000_0000), Carried { address: 0x4000_0000, by_name: false }, "a device stays");
        assert_eq!(map.target().name(0x8104), "solve + 0x4");
    }

    #[test]
    fn what_is_too_far_away_is_reached_by_the_nearest_detour() {
        let far = image(&[(0x400, 0x20, "solve")], &[]);
        let far = Image { detours: vec![(0x400, 0x0810_0000), (0x400, 0x0900_0000), (0x500, 0x0800_0100)], ..far };
        assert_eq!(far.detour(0x0800_0000, 0x400), Some(0x0810_0000));
        assert_eq!(far.detour(0x0800_0000, 0x600), None, "nothing leads there");
        assert_eq!(far.detour(0x480, 0x400), None, "near enough");
    }

    #[test]
    fn what_belongs_to_an_images_own_crate_is_the_same_in_every_image() {
        let from = image(&[(0x100, 0x20, "_ZN12gripper_mps26MODELS17h6c390203a3e9b6ffE")], &[]);
        let to = image(&[(0x900, 0x10, "_ZN14gripper_opencr6MODELS17hd68b956599663fd6E")], &[]);
        let map = LinkMap::new(from, to);
        assert_eq!(map.carry(0x104), Carried { address: 0x904, by_name: false }, "of another size");
        assert_eq!(name_of("_ZN12gripper_mps24main17h6c390203a3e9b6ffE"), "image::main");
        assert_eq!(name_of("_ZN7gripper4core17h6c390203a3e9b6ffE"), "gripper::core");
    }

    #[test]
    fn the_stack_is_carried_by_its_depth() {
        let from = Image { stack_start: 0x2008_0000, ..image(&[(0x100, 4, "a")], &[]) };
        let to = Image { stack_start: 0x2000_8000, ..image(&[(0x8100, 4, "a")], &[]) };
        let map = LinkMap::new(from, to);
        assert_eq!(map.carry(0x2007_fff0), Carried { address: 0x2000_7ff0, by_name: true });
    }

    #[test]
    fn a_hash_is_not_part_of_a_name() {
        assert_eq!(name_of("_ZN4core3fmt5write17h0042db6166957f81E"), "core::fmt::write");
        assert_eq!(name_of("main"), "main");
    }

    #[test]
    fn what_is_no_image_is_said() {
        assert!(Image::parse(b"no").unwrap_err().to_string().contains("not an ELF file"));
    }
}
