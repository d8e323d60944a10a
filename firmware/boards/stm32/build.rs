//! Puts the sections of the linker that are the boards' own where it finds them: what survives a reset, what runs from RAM, and the
//! label of the image's file.

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
    . = ALIGN(8);
    __efast_vectors = .;
  } > CODE
  .fast : ALIGN(8)
  {
    __sfast = .;
    KEEP(*(.fast .fast.*));
    . = ALIGN(8);
    __efast = .;
  } > CODE AT> FLASH
  __sifast = LOADADDR(.fast);
} INSERT AFTER .rodata;
";

/// Variables in memory of their own, for boards that have a region NEAR, or before all others of the RAM, where that begins with memory
/// without wait states; `near::clear` sets them to zero. Before the linker's own script, which would take them for variables like all others.
const NEAR: &str = "SECTIONS
{
  .near (NOLOAD) : ALIGN(8)
  {
    __snear = .;
    *(.bss.near);
    . = ALIGN(8);
    __enear = .;
  } > NEAR
} INSERT BEFORE .data;
";

/// In the file only: the board and the version that the image is for.
const LABEL: &str = "SECTIONS { .fre_image 0 (INFO) : { KEEP(*(.fre_image)) } } INSERT AFTER .uninit;\n";

fn main() {
    let folder = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    for (name, script) in [("survivor.x", SURVIVOR), ("fast.x", FAST), ("label.x", LABEL), ("near.x", NEAR)] {
        fs::write(folder.join(name), script).expect("the build folder can be written");
    }
    println!("cargo::rustc-link-search={}", folder.display());
    println!("cargo::rerun-if-changed=build.rs");
}
