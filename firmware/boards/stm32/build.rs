//! Puts the section that survives a reset where the linker finds it.

use std::{env, fs, path::PathBuf};

/// Not loaded and not cleared; the boards' memory maps say where.
const SCRIPT: &str =
    "SECTIONS { .survivor (NOLOAD) : ALIGN(8) { KEEP(*(.survivor)) } > SURVIVOR } INSERT AFTER .uninit;\n";

fn main() {
    let folder = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::write(folder.join("survivor.x"), SCRIPT).expect("the build folder can be written");
    println!("cargo::rustc-link-search={}", folder.display());
    println!("cargo::rerun-if-changed=build.rs");
}
