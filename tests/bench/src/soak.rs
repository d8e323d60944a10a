//! An hour of gripping and releasing on a bus in trouble, in a time of its own.

use std::fmt;

use anyhow::{Result, bail};
use system_tests::{Hour, an_hour};

/// The hour, judged.
#[derive(Debug)]
pub struct Soak(Hour);

/// Runs the hour; an error if it was not sound.
pub fn measure() -> Result<Soak> {
    let hour = an_hour();
    match hour.faults().as_slice() {
        [] => Ok(Soak(hour)),
        faults => bail!("{}: {hour:?}", faults.join("; ")),
    }
}

impl fmt::Display for Soak {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Hour { judge, reached, rounds, servo_losses, fast_us, .. } = &self.0;
        writeln!(f, "an hour: {judge}; longest fast {fast_us} µs")?;
        writeln!(f, "{reached} of {rounds} grips reached their force; the servo was lost {servo_losses} times")
    }
}
