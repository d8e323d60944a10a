//! The STM32 boards' build script: puts the memory map where the linker finds it, and links the image.

use std::{env, fs, path::PathBuf};

fn main() {
    let folder = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::copy("memory.x", folder.join("memory.x")).expect("memory.x can be copied");
    println!("cargo::rustc-link-search={}", folder.display());
    println!("cargo::rerun-if-changed=memory.x");
    let map = fs::read_to_string("memory.x").expect("memory.x can be read");
    if map.lines().any(|line| line.trim().starts_with("NEAR ")) {
        println!("cargo::rustc-link-arg-bins=-Tnear.x");
    }
    // `near.x`, `survivor.x`, `fast.x` and `label.x` are the crate stm32's.
    for script in ["link.x", "survivor.x", "fast.x", "label.x", "defmt.x"] {
        println!("cargo::rustc-link-arg-bins=-T{script}");
    }
}
