//! The live view in a terminal. A program that was built without it prints lines there.

use std::io::IsTerminal;
#[cfg(feature = "terminal")]
use std::sync::{Arc, atomic::AtomicBool};
#[cfg(feature = "terminal")]
use std::time::Duration;

#[cfg(feature = "terminal")]
use super::{lines, stop::Stop};
#[cfg(not(feature = "terminal"))]
use crate::exit::tell;
#[cfg(feature = "terminal")]
use fre_gripper::source::Source;

/// Whether a person sees the output and has the keys.
fn is_here() -> bool {
    std::io::stdout().is_terminal() && std::io::stdin().is_terminal()
}

/// Whether a live view can be shown here.
pub fn is_possible() -> bool {
    cfg!(feature = "terminal") && is_here()
}

/// Shows it until the time is over, somebody stops it, or nothing more comes.
#[cfg(feature = "terminal")]
pub fn show(source: &Arc<dyn Source>, length: Option<Duration>, stop: &AtomicBool) -> Result<(), Stop> {
    let origin = source.setup()?.origin;
    let ended = fre_gripper::terminal::show(source, length, stop)?;
    let ending = lines::ending(&ended, origin, &source.statistics());
    crate::output::put_out(&format!("{ending}\n")).map_err(Stop::Input)
}

/// Says to a person who gets lines what there is instead.
#[cfg(not(feature = "terminal"))]
pub fn hint() {
    if is_here() {
        tell!(
            "fre: lines only: --web shows a live page; for a live view in the terminal, build with `--features terminal`"
        );
    }
}
