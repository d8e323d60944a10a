//! What of a board's image runs from RAM, by its symbols, its vectors and its instructions: the interrupts of the serial lines, their
//! vectors, and, where the settings lie in the program's own bank of flash, what writes them. QEMU has no flash that stalls, so that no
//! run shows it. And the functions that a board's `hot.txt` names: if one were renamed, the board would become slower, and nothing else would
//! show it.

use crate::panic_free::calls;
use crate::paths;
use anyhow::{Context, Result, bail, ensure};
use fre_boards::Board;
use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use std::ops::Range;

/// Where STM32 chips have RAM from which they run: tightly or core-coupled memory, SRAM.
const RAM: [Range<u64>; 3] = [0..0x1_0000, 0x1000_0000..0x1001_0000, 0x2000_0000..0x2008_0000];
/// Their flash, and where the F7 shows it by another interface.
const FLASH: [Range<u64>; 2] = [0x0800_0000..0x0820_0000, 0x0020_0000..0x0040_0000];
/// Part of the names of the linker's own code, by which code in flash and in RAM call one another.
const DETOUR: &str = "LongThunk";
/// Parts of the mangled names of what waits for a flash that stalls.
const FLASH_CODE: [&str; 2] = ["8stalling5start", "8stalling3put"];

/// Checks an STM32 board's image.
pub fn check(board: &Board, image: &[u8]) -> Result<()> {
    let file = object::File::parse(image).context("the image is not an ELF file")?;
    let symbol = |name: &str| {
        let found = file.symbols().find(|symbol| symbol.name() == Ok(name));
        found.map(|symbol| symbol.address()).with_context(|| format!("the image has no symbol {name}"))
    };
    let (vectors, code) =
        (symbol("__sfast_vectors")?..symbol("__efast_vectors")?, symbol("__sfast")?..symbol("__efast")?);
    for range in [&vectors, &code] {
        let is_ram = RAM.iter().any(|ram| ram.start <= range.start && range.end <= ram.end);
        ensure!(
            is_ram && !range.is_empty(),
            "{:#x} to {:#x} is not RAM that instructions are fetched from",
            range.start,
            range.end
        );
    }
    let section = |name: &str| file.section_by_name(name).with_context(|| format!("the image has no section {name}"));
    let table = section(".vector_table")?;
    ensure!(vectors.end - vectors.start >= table.size(), "there is no room for all vectors");
    let words = words(table.data()?);
    let (unused, mut lines) = (symbol("DefaultHandler")?, 0);
    for function in file.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text) {
        let name = function.name()?;
        // Neither the linker's own code nor the vectors of lines that nobody uses.
        if name.contains(DETOUR) || function.address() == unused {
            continue;
        }
        let is_line = name.strip_prefix("USART").is_some_and(|number| number.parse::<u8>().is_ok());
        if is_line || FLASH_CODE.iter().any(|part| name.contains(part)) {
            let start = function.address() & !1;
            let is_inside = code.start <= start && start + function.size() <= code.end;
            ensure!(is_inside, "{name} is at {start:#x}, not in RAM");
            ensure!(!is_line || words.contains(&(start | 1)), "no vector leads to {name}");
            lines += usize::from(is_line);
        }
    }
    ensure!(lines > 0, "no serial line has an interrupt");
    let has = |part: &&str| file.symbols().any(|symbol| symbol.name().is_ok_and(|name| name.contains(*part)));
    if let Some(missing) = FLASH_CODE.iter().find(|part| board.flash_stalls && !has(part)) {
        bail!("nothing in the image is called …{missing}…");
    }
    leads_out(section(".fast")?.data()?, code.start, &Mapping::of(&file))?;
    println!(
        "in RAM         {:>8} bytes at {:#010x}, the interrupts of {lines} lines among them",
        code.end - code.start,
        code.start
    );
    let list = std::fs::read_to_string(paths::boards().join(board.name).join("hot.txt")).unwrap_or_default();
    hot(&file, symbol("__shot")?..symbol("__ehot")?, &list)
}

/// That what a board's list names is in its memory for hot functions, and nowhere else.
fn hot<'data>(file: &impl Object<'data>, memory: Range<u64>, list: &str) -> Result<()> {
    let functions: Vec<(String, u64)> = file
        .symbols()
        .filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0)
        .filter_map(|symbol| Some((symbol.name().ok()?, symbol.address() & !1)))
        .filter(|(name, _)| !name.contains(DETOUR))
        .map(|(name, at)| (format!("{:#}", rustc_demangle::demangle(name)), at))
        .collect();
    for path in list.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#')) {
        let mut found = functions.iter().filter(|(name, _)| is_called(name, path)).peekable();
        ensure!(found.peek().is_some(), "hot.txt names {path}, but no function of the image is called so");
        if let Some((name, at)) = found.find(|(_, at)| !memory.contains(at)) {
            bail!("{name} is at {at:#x}, not with the hot functions");
        }
    }
    let count = functions.iter().filter(|(_, at)| memory.contains(at)).count();
    if !memory.is_empty() {
        println!("hot            {:>8} bytes at {:#010x}, {count} functions", memory.end - memory.start, memory.start);
    }
    Ok(())
}

/// Whether a function's name has the words of a path in their order, and ends with the last one.
fn is_called(name: &str, path: &str) -> bool {
    let (modules, last) = path.rsplit_once("::").unwrap_or(("", path));
    let Some(rest) = name.strip_suffix(last).and_then(|rest| rest.strip_suffix("::")) else { return false };
    modules.split("::").try_fold(rest, |rest, word| Some(rest.split_once(word)?.1)).is_some()
}

/// An address of flash.
fn is_flash(address: u64) -> bool {
    FLASH.iter().any(|flash| flash.contains(&address))
}

/// Words of memory.
fn words(bytes: &[u8]) -> Vec<u64> {
    bytes.chunks_exact(4).map(|word| u64::from(u32::from_le_bytes([word[0], word[1], word[2], word[3]]))).collect()
}

/// Where instructions begin and where words between them do, by the mapping symbols of the Arm ELF format (`$t`, `$d`), in the order of
/// the addresses.
struct Mapping(Vec<(u64, bool)>);

impl Mapping {
    fn of<'data>(file: &impl Object<'data>) -> Self {
        let mark = |symbol: &_| {
            let name = ObjectSymbol::name(symbol).ok()?;
            let is_words = name == "$d" || name.starts_with("$d.");
            (is_words || name == "$t" || name.starts_with("$t.")).then_some((ObjectSymbol::address(symbol), is_words))
        };
        let mut marks: Vec<(u64, bool)> = file.symbols().filter_map(|symbol| mark(&symbol)).collect();
        marks.sort_unstable();
        Self(marks)
    }

    /// What is here is a word, not an instruction. Without a mark below, it may be either.
    fn is_word(&self, address: u64) -> bool {
        let below = self.0.partition_point(|(from, _)| *from <= address);
        below.checked_sub(1).and_then(|last| self.0.get(last)).is_none_or(|(_, is_words)| *is_words)
    }
}

/// That code in RAM neither branches out of its section nor holds an address of flash, in a word or in a MOVT (Armv7-M, encoding T1).
fn leads_out(code: &[u8], base: u64, mapping: &Mapping) -> Result<()> {
    let all = base..base + code.len() as u64;
    if let Some(call) = calls(code, base).iter().find(|call| !all.contains(&call.to)) {
        bail!("the code in RAM calls {:#x}, which is not there, from {:#x}", call.to, call.from);
    }
    for (place, word) in words(code).into_iter().enumerate() {
        let at = base + 4 * place as u64;
        ensure!(
            !is_flash(word) || !mapping.is_word(at),
            "the code in RAM holds {word:#x}, an address of flash, at {at:#x}"
        );
    }
    let halfwords: Vec<u32> =
        code.chunks_exact(2).map(|pair| u32::from(u16::from_le_bytes([pair[0], pair[1]]))).collect();
    for (place, pair) in halfwords.windows(2).enumerate() {
        let (high, low) = (pair[0], pair[1]);
        if high & 0xFBF0 == 0xF2C0 && low & 0x8000 == 0 {
            let upper = (high & 0xF) << 12 | (high >> 10 & 1) << 11 | (low >> 12 & 7) << 8 | low & 0xFF;
            let address = u64::from(upper) << 16;
            ensure!(!is_flash(address), "the code in RAM makes an address of flash at {:#x}", base + 2 * place as u64);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_function_is_found_by_the_words_of_its_path() {
        let name = "model_core::newton::border::Border<T,S>::make";
        assert!(is_called(name, "newton::border::make") && is_called(name, "make"));
        for other in ["newton::condense::make", "border::newton::make", "newton::border::load", "newton::border::mak"] {
            assert!(!is_called(name, other), "{other}");
        }
        let method = "<model_core::element::quadratic::Quadratic as model_core::element::Element<T>>::bend";
        assert!(is_called(method, "quadratic::bend"));
    }

    #[test]
    fn code_that_needs_flash_is_found() {
        // nop; movt r0, #0x4001; b.w to itself's start: all of it stays.
        let stays = [0x00, 0xBF, 0xC4, 0xF2, 0x01, 0x00, 0xFF, 0xF7, 0xFB, 0xBF, 0x00, 0xBF];
        let unmarked = Mapping(Vec::new());
        assert!(leads_out(&stays, 0x400, &unmarked).is_ok());
        for (what, code) in [
            ("makes an address of flash at 0x402", [0x00, 0xBF, 0xC0, 0xF6, 0x04, 0x00, 0x00, 0xBF]),
            ("holds 0x8041235, an address of flash, at 0x404", [0x00, 0xBF, 0x00, 0xBF, 0x35, 0x12, 0x04, 0x08]),
            ("calls 0x414, which is not there, from 0x400", [0x00, 0xF0, 0x08, 0xF8, 0x00, 0xBF, 0x00, 0xBF]),
        ] {
            let error = leads_out(&code, 0x400, &unmarked).unwrap_err().to_string();
            assert!(error.contains(what), "{error}");
        }
    }

    #[test]
    fn an_instruction_that_looks_like_an_address_is_none() {
        // ldr.w r0, [r9, #2048], twice: an instruction, then a word.
        let code = [0xD9, 0xF8, 0x00, 0x08, 0xD9, 0xF8, 0x00, 0x08];
        assert!(leads_out(&code, 0x400, &Mapping(vec![(0x400, false)])).is_ok());
        let error = leads_out(&code, 0x400, &Mapping(vec![(0x400, false), (0x404, true)])).unwrap_err().to_string();
        assert!(error.contains("an address of flash, at 0x404"), "{error}");
    }
}
