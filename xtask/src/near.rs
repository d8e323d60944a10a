//! What a board's image makes of its processor, by its symbols: the first finger's model in memory without wait states, and
//! double precision in the floating-point unit. No run in QEMU shows either.

use anyhow::{Context, Result, ensure};
use fre_boards::Board;
use object::{Object, ObjectSymbol};

/// Part of the mangled name of the models that lie in that memory.
const MODELS: &str = "NEAR_MODELS";
/// What adds, multiplies and divides in double precision where the floating-point unit does not.
const SOFT: [&str; 3] = ["__aeabi_dadd", "__aeabi_dmul", "__aeabi_ddiv"];

/// Checks a board's image.
pub fn check(board: &Board, image: &[u8]) -> Result<()> {
    let file = object::File::parse(image).context("the image is not an ELF file")?;
    let mut symbols = file.symbols();
    if let Some(memory) = board.near {
        let models = symbols.find(|symbol| symbol.name().is_ok_and(|name| name.contains(MODELS)));
        let models = models.with_context(|| format!("the image has no {MODELS}"))?;
        let (start, end) = (models.address(), models.address() + models.size());
        let [first, behind] = memory.map(u64::from);
        // What does not fit lies behind, where such memory is the beginning of the RAM.
        ensure!(
            start == first && start < end,
            "{MODELS} is at {start:#x} to {end:#x}; the memory without wait states is {first:#x} to {behind:#x}"
        );
        println!(
            "models         {:>8} bytes at {start:#010x}, {} of them without wait states",
            end - start,
            end.min(behind) - start
        );
    }
    let soft =
        file.symbols().find_map(|symbol| symbol.name().ok().filter(|name| SOFT.contains(name)).map(str::to_owned));
    // Every image computes a motion in double precision: where the unit does not, one of these is there.
    match soft {
        Some(soft) => ensure!(!board.has_double, "the image has {soft}, and the floating-point unit could do it"),
        None => ensure!(board.has_double, "the image has none of {}: the search is blind", SOFT.join(", ")),
    }
    Ok(())
}
