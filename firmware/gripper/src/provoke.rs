//! Ways to go wrong on purpose, for tests of what catches them. Only programs built for tests (feature `provoke`) obey.

use core::hint::black_box;

use messages::{Outcome, Provocation, Refusal};

use crate::shared::Command;

/// Does it, if this program may be provoked.
pub(crate) fn provoke(restart: fn(&'static str) -> !, what: Provocation) -> Result<Option<Command>, Refusal> {
    match what {
        _ if !cfg!(feature = "provoke") => Err(Refusal::NotProvokable),
        Provocation::Restart => restart(""),
        Provocation::Hang => Ok(Some(Command::Hang)),
        Provocation::HangLink => hang().map(|()| None),
        Provocation::Panic => fail(),
        Provocation::StackOverflow => {
            black_box(dive(1));
            Ok(None)
        }
    }
}

#[allow(clippy::panic)]
fn fail() -> ! {
    panic!("provoked");
}

#[allow(unconditional_recursion)]
#[inline(never)]
fn dive(depth: u32) -> u32 {
    let block = black_box([depth; 256]);
    dive(depth.wrapping_add(1)).wrapping_add(block.iter().sum())
}

/// Never ends, and never feeds the watchdog.
pub(crate) fn hang() -> Outcome {
    while cfg!(feature = "provoke") {
        // Not `spin_loop`: an emulator takes that for a reason to do something else, at every turn.
        black_box(());
    }
    Ok(())
}
