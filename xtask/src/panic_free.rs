//! No way to panic from the estimator, be it set, asked or on a free object, from a finger's grip and what is around it, nor from the codec,
//! the master, a device or a tap of the bus:
//! an image that holds nothing else is linked, and its symbols are searched for what a panic needs. The linker keeps only what can be
//! reached.

use crate::command;
use crate::cross::{Cross, TRIPLE};
use crate::paths;
use anyhow::{Context, Result, bail};
use object::{Object, ObjectSection, ObjectSymbol};
use std::path::Path;

const IMAGE: &str = "panic-free";

/// Builds the image and checks it; a second one that can panic shows that the search would find it.
pub fn check(cross: &Cross) -> Result<()> {
    let found = panics(cross, true)?;
    if found.is_empty() {
        bail!("the image that can panic shows no symbol of a panic: the search is blind");
    }
    let found = panics(cross, false)?;
    if !found.is_empty() {
        bail!("the estimator, the grip or the bus can panic; their image holds {}", found.join(", "));
    }
    println!("test no_panic_can_be_reached_from_the_estimator_the_grip_and_the_bus ... ok");
    println!("\ntest result: ok. 1 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out");
    Ok(())
}

/// Symbols of panics in the image.
fn panics(cross: &Cross, can_panic: bool) -> Result<Vec<String>> {
    let mut build = cross.cargo("build");
    build.args(["--quiet", "--release", "--package", IMAGE]);
    if can_panic {
        build.args(["--features", "can-panic"]);
    }
    command::run(&mut build)?;
    let elf = paths::boards_target().join(TRIPLE).join("release").join(IMAGE);
    search(&elf)
}

/// What every asynchronous function has for the case that it is polled after its end. `await` never does that, nor does whoever runs a
/// future until it is ready, but the compiler cannot know.
const RESUMED: &str = "panic_const_async_fn_resumed";

fn search(elf: &Path) -> Result<Vec<String>> {
    let bytes = std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let file = object::File::parse(&*bytes).context("the image is not an ELF file")?;
    let symbols: Vec<_> = file.symbols().filter_map(|symbol| Some((symbol.name().ok()?, symbol))).collect();
    for part in ["model_core", "dynamixel", "panic_free6finger"] {
        if !symbols.iter().any(|(name, _)| name.contains(part)) {
            bail!("{} holds nothing of {part}: its symbols say nothing", elf.display());
        }
    }
    // `core::panicking`, and what an index out of range calls first.
    let tells = ["panicking", "slice_index_fail", "rust_begin_unwind"];
    let panics: Vec<_> = symbols.iter().filter(|(name, _)| tells.iter().any(|tell| name.contains(tell))).collect();
    let resumed = panics.iter().find(|(name, _)| name.contains(RESUMED)).map(|(_, symbol)| symbol);
    let text = file.section_by_name(".text").context("the image has no code")?;
    let calls = calls(text.data().context("the code cannot be read")?, text.address());
    let is_known = |(name, symbol): &&&(&str, object::Symbol<'_, '_>)| {
        // Thumb functions have odd addresses.
        let extent = |symbol: &object::Symbol<'_, '_>| (symbol.address() & !1)..(symbol.address() & !1) + symbol.size();
        let (start, within) = (symbol.address() & !1, resumed.map(extent));
        let ways = || calls.iter().filter(|call| call.to == start);
        name.contains(RESUMED)
            || within.is_some_and(|within| ways().count() > 0 && ways().all(|call| within.contains(&call.from)))
    };
    Ok(panics.iter().filter(|panic| !is_known(panic)).map(|(name, _)| (*name).to_owned()).collect())
}

/// A branch to another place of the code.
pub struct Call {
    /// Where it is.
    pub from: u64,
    /// Where it leads.
    pub to: u64,
}

/// Every pair of halfwords that reads as a branch of 32 bits, with or without link (Armv7-M, encodings T1 of BL and T4 of B). Data
/// among the code may read so as well: that can only make the search find more.
pub fn calls(code: &[u8], base: u64) -> Vec<Call> {
    let halfwords: Vec<u32> =
        code.chunks_exact(2).map(|pair| u32::from(u16::from_le_bytes([pair[0], pair[1]]))).collect();
    let mut calls = Vec::new();
    for (place, pair) in halfwords.windows(2).enumerate() {
        let (high, low) = (pair[0], pair[1]);
        if high & 0xF800 != 0xF000 || low & 0x9000 != 0x9000 {
            continue;
        }
        let sign = high >> 10 & 1;
        let (one, two) = (!(low >> 13 ^ sign) & 1, !(low >> 11 ^ sign) & 1);
        let offset = sign << 24 | one << 23 | two << 22 | (high & 0x3FF) << 12 | (low & 0x7FF) << 1;
        // 25 bits with their sign.
        let offset = i64::from((offset << 7) as i32 >> 7);
        let from = base + 2 * place as u64;
        calls.push(Call { from, to: (from + 4).wrapping_add_signed(offset) });
    }
    calls
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_lead_where_the_assembler_says() {
        // bl .+4+0x10, b.w .+4-0x104, and a load that is not a branch.
        let code = [0x00, 0xF0, 0x08, 0xF8, 0xFF, 0xF7, 0x7E, 0xBF, 0x01, 0x68];
        let found: Vec<_> = calls(&code, 0x1000).iter().map(|call| (call.from, call.to)).collect();
        assert_eq!(found, [(0x1000, 0x1014), (0x1004, 0x0F04)]);
    }
}
