//! An hour of gripping and releasing on a bus in trouble, and ten thousand faults of every kind on four fingers, in a time of their own.

use std::fmt;

use anyhow::{Result, bail};
use system_tests::{Campaign, Hour, an_hour, campaign};

/// Faults of the campaign, and the seed with which they are drawn.
const EVENTS: u32 = 10_000;
const SEED: u64 = 1;

/// Hour and campaign, judged.
#[derive(Debug)]
pub struct Soak {
    hour: Hour,
    campaign: Campaign,
}

/// Runs both; an error if one was not sound.
pub fn measure() -> Result<Soak> {
    let hour = an_hour();
    if let faults @ [_, ..] = hour.faults().as_slice() {
        bail!("{}: {hour:?}", faults.join("; "));
    }
    let campaign = campaign(SEED, EVENTS);
    if let faults @ [_, ..] = campaign.faults().as_slice() {
        bail!("{}\n{campaign}", faults.join("; "));
    }
    Ok(Soak { hour, campaign })
}

impl fmt::Display for Soak {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Hour { judge, reached, rounds, servo_losses, fast_us, .. } = &self.hour;
        writeln!(f, "an hour: {judge}; longest fast {fast_us} µs")?;
        writeln!(f, "{reached} of {rounds} grips reached their force; the servo was lost {servo_losses} times")?;
        write!(f, "\nfaults of every kind on four fingers, seed {SEED}:\n\n{}", self.campaign)
    }
}
