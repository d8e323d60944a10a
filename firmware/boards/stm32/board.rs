//! The STM32 boards' build script: puts the memory map and the list of hot functions where the linker finds them, and links the image.

use std::{env, fs, path::PathBuf};

/// Functions that the linker takes from the program's other code into memory without wait states; `fast::load` copies them there.
fn hot(functions: &str) -> String {
    let patterns: String = functions
        .lines()
        .filter(|line| !line.trim().is_empty() && !line.starts_with('#'))
        .map(|path| format!("    *(.text.{});\n", mangled(path.trim())))
        .collect();
    format!(
        "SECTIONS
{{
  .hot : ALIGN(8)
  {{
    __shot = .;
{patterns}    . = ALIGN(8);
    __ehot = .;
  }} > CODE AT> FLASH
  __sihot = LOADADDR(.hot);
}} INSERT AFTER .rodata;
"
    )
}

/// The model's code, and of the compiler's library what lies in sections of its own, in flash that is reached by another interface than all
/// other code: it is loaded to its place of the flash, and runs from where that interface shows it.
const ACCELERATED: &str = "SECTIONS
{
  .accelerated : ALIGN(32)
  {
    *(.text.*model_core*);
    *(.text.*compiler_builtins* .text.__aeabi_mem* .text.memcpy .text.memset .text.memmove);
  } > ACCELERATED AT> ACCELERATED_LOAD
} INSERT AFTER .hot;
";

/// What the compiler's names of a function match: the last word of its path with its length before it and the hash behind it, the words
/// before it in their order.
fn mangled(path: &str) -> String {
    let (modules, name) = path.rsplit_once("::").unwrap_or(("", path));
    let modules: String = modules.split("::").map(|word| format!("*{word}")).collect();
    format!("_ZN{modules}*{}{name}17h*", name.len())
}

fn main() {
    let folder = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::copy("memory.x", folder.join("memory.x")).expect("memory.x can be copied");
    println!("cargo::rustc-link-search={}", folder.display());
    println!("cargo::rerun-if-changed=memory.x");
    let map = fs::read_to_string("memory.x").expect("memory.x can be read");
    let has = |start: &str| map.lines().any(|line| line.trim().starts_with(start));
    if has("NEAR ") || has("REGION_ALIAS(\"NEAR\"") {
        println!("cargo::rustc-link-arg-bins=-Tnear.x");
    }
    let accelerates = has("ACCELERATED ");
    let functions = fs::read_to_string("hot.txt").ok();
    // A board without a list has its folder watched instead: Cargo treats a missing file as changed and would relink the image every time.
    println!("cargo::rerun-if-changed={}", if functions.is_some() { "hot.txt" } else { "." });
    let scripts = hot(&functions.unwrap_or_default()) + if accelerates { ACCELERATED } else { "" };
    fs::write(folder.join("hot.x"), scripts).expect("the build folder can be written");
    // Without pages: the linker would take the file's headers for something to load, to the address 0 of memory for code.
    println!("cargo::rustc-link-arg-bins=--nmagic");
    // `hot.x` comes before the linker's own script, which would otherwise place these functions with all other code.
    // `near.x`, `survivor.x`, `fast.x` and `label.x` are the crate stm32's.
    for script in ["hot.x", "link.x", "survivor.x", "fast.x", "label.x", "defmt.x"] {
        println!("cargo::rustc-link-arg-bins=-T{script}");
    }
}
