//! Puts the sections of the linker that are the boards' own where it finds them: what survives a reset, and what runs from RAM.

use std::{env, fs, path::PathBuf};

/// Not loaded and not cleared; the boards' memory maps say where.
const SURVIVOR: &str =
    "SECTIONS { .survivor (NOLOAD) : ALIGN(8) { KEEP(*(.survivor)) } > SURVIVOR } INSERT AFTER .uninit;\n";

/// Behind the room for the vectors comes the code that `fast::load` copies to RAM. (A table of vectors begins at a multiple of its size,
/// rounded up to a power of two.)
const FAST: &str = "SECTIONS
{
  .fast_vectors (NOLOAD) : ALIGN(1 << LOG2CEIL(SIZEOF(.vector_table)))
  {
    __sfast_vectors = .;
    . += SIZEOF(.vector_table);
    . = ALIGN(4);
    __efast_vectors = .;
  } > CODE
  .fast : ALIGN(4)
  {
    __sfast = .;
    KEEP(*(.fast .fast.*));
    . = ALIGN(4);
    __efast = .;
  } > CODE AT> FLASH
  __sifast = LOADADDR(.fast);
} INSERT AFTER .rodata;
";

fn main() {
    let folder = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    for (name, script) in [("survivor.x", SURVIVOR), ("fast.x", FAST)] {
        fs::write(folder.join(name), script).expect("the build folder can be written");
    }
    println!("cargo::rustc-link-search={}", folder.display());
    println!("cargo::rerun-if-changed=build.rs");
}
