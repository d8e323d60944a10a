//! The asking side on a bus in memory: what works, and every way in which it can go wrong; and what noise does to each side.

mod blocking;
mod bulk;
mod master;
mod noise;
#[path = "../servo/mod.rs"]
mod servo;
#[path = "../traffic/mod.rs"]
mod traffic;
mod upkeep;
mod world;

use dynamixel::{Answer, Id, Master, Timing};
use world::{Bus, Clock};

const TIMING: Timing = Timing { latency_us: 1_000, ..Timing::at(1_000_000) };

fn id(id: u8) -> Id {
    Id::new(id).unwrap()
}

fn master(bus: &Bus) -> Master<Bus, Clock> {
    Master::new(bus.clone(), Clock(bus.clone()), TIMING)
}

fn plain<T>(value: T) -> Answer<T> {
    Answer { value, alert: false }
}
