//! No way to panic from the estimator, be it set, asked or on a free object: an image that holds nothing else is linked, and its
//! symbols are searched for what a panic needs. The linker keeps only what can be reached.

use crate::command;
use crate::cross::{Cross, TRIPLE};
use crate::paths;
use anyhow::{Context, Result, bail};
use object::{Object, ObjectSymbol};
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
        bail!("the estimator can panic; its image holds {}", found.join(", "));
    }
    println!("test no_panic_can_be_reached_from_the_estimator ... ok");
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

fn search(elf: &Path) -> Result<Vec<String>> {
    let bytes = std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let file = object::File::parse(&*bytes).context("the image is not an ELF file")?;
    let names: Vec<&str> = file.symbols().filter_map(|symbol| symbol.name().ok()).collect();
    if !names.iter().any(|name| name.contains("model_core")) {
        bail!("{} holds nothing of the model: its symbols say nothing", elf.display());
    }
    // `core::panicking`, and what an index out of range calls first.
    let tells = ["panicking", "slice_index_fail", "rust_begin_unwind"];
    Ok(names.into_iter().filter(|name| tells.iter().any(|tell| name.contains(tell))).map(str::to_owned).collect())
}
