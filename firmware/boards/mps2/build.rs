//! Puts the memory map where the linker finds it, and links the images.

use std::{env, fs, path::PathBuf};

/// In the file only: the board and the version that the image is for.
const LABEL: &str = "SECTIONS { .fre_image 0 (INFO) : { KEEP(*(.fre_image)) } } INSERT AFTER .uninit;\n";

fn main() {
    let folder = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::copy("memory.x", folder.join("memory.x")).expect("memory.x can be copied");
    fs::write(folder.join("label.x"), LABEL).expect("the build folder can be written");
    println!("cargo::rustc-link-search={}", folder.display());
    println!("cargo::rerun-if-changed=memory.x");
    for script in ["link.x", "label.x", "defmt.x"] {
        println!("cargo::rustc-link-arg-bins=-T{script}");
    }
}
