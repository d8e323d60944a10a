//! One libFuzzer binary for every target; `FRE_FUZZ_TARGET` names the one that it runs.

#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;

/// The variable that names the target.
const VARIABLE: &str = "FRE_FUZZ_TARGET";

static RUN: LazyLock<fn(&[u8])> = LazyLock::new(|| {
    let name = std::env::var(VARIABLE).unwrap_or_default();
    match fuzz_targets::target(&name) {
        Some(target) => target.run,
        None => {
            eprintln!("{VARIABLE} = {name:?} names no target");
            std::process::exit(2);
        }
    }
});

fuzz_target!(|bytes: &[u8]| RUN(bytes));
