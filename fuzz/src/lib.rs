//! What is fuzzed: one file per target, each a function that takes any bytes and panics if something is wrong.
//!
//! The functions know nothing of the fuzzer: `fuzz/driver` feeds them from libFuzzer (`cargo xtask fuzz`), the normal test
//! suite feeds them their seeds, whole, cut short and damaged, and `cargo run -p fuzz-targets -- NAME FILE` runs one input.

mod bus;
mod case;
mod codec;
mod frame;
mod measured;
mod recording;

/// Something that is fuzzed.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name on the command line.
    pub name: &'static str,
    /// Takes one input; panics if the code under test does, or if a property does not hold.
    pub run: fn(&[u8]),
    /// Inputs to start from: well-formed ones that reach as much of the code as possible.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Words that the fuzzer may put in; none for binary formats.
    pub words: fn() -> Vec<String>,
}

/// Every target.
pub const TARGETS: &[Target] =
    &[bus::TARGET, case::TARGET, codec::TARGET, frame::TARGET, measured::TARGET, recording::TARGET];

/// Whether a message can be shown as it is: on one line, without codes for the terminal, and not without end.
fn is_shown(message: &str) -> bool {
    !message.contains(['\n', '\u{1b}']) && message.chars().count() < 2000
}

/// The target of this name.
pub fn target(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|target| target.name == name)
}
