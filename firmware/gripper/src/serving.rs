//! The bus task: asks the servos while the control task computes, and hears and answers another master.

use embassy_futures::select::{Either3, select3};
use embassy_time::{Instant, Timer};
use embedded_io_async::{Read, Write};

use crate::board::{Board, BusPort};
use crate::bus::{Bus, Job, Line};
use crate::ears::{Ears, Said};
use crate::shared::{Shared, now_us};
use crate::write::write_all;

/// Bytes that are taken at once.
const CHUNK: usize = 64;
/// So many full chunks in a row are more than a packet: the bus says more than the processor can follow.
const LOUD: u32 = 8;
/// What the tasks below the bus task then get, µs; what is lost meanwhile counts as damaged.
const BREATH_US: u64 = 200;

/// Does on the bus what the control task wants, for ever.
pub async fn serve<B: Board>(shared: &Shared, bus: &Bus<B::Bus>) -> ! {
    let mut job = Job::Rest;
    loop {
        job = match job {
            Job::Rest => bus.job().await,
            Job::Ask(due) => {
                Timer::at(due).await;
                ask(shared, bus).await;
                bus.job().await
            }
            Job::Listen => {
                let mut line = bus.line().await;
                hear::<B>(shared, bus, line.servos.port_mut()).await
            }
        };
    }
}

/// Asks the servos.
async fn ask<U: BusPort>(shared: &Shared, bus: &Bus<U>) {
    let mut line = bus.line().await;
    let Line { servos, turns, took } = &mut *line;
    let goals = bus.goals();
    for turn in turns.iter_mut() {
        turn.goal = goals.get(turn.finger).copied().flatten();
    }
    let asking = shared.quiet.ask();
    let begun = Instant::now();
    servos.tick(turns).await;
    *took = begun.elapsed();
    drop((asking, line));
    bus.has_answered();
}

/// Hears another master, and answers it, until there is another job.
async fn hear<B: Board>(shared: &Shared, bus: &Bus<B::Bus>, port: &mut B::Bus) -> Job {
    let mut chunk = [0; CHUNK];
    let mut full = 0;
    loop {
        let deadline_us = bus.ears().await.as_ref().and_then(Ears::deadline);
        let deadline = deadline_us.map_or(Instant::MAX, Instant::from_micros);
        let count = match select3(port.read(&mut chunk), Timer::at(deadline), bus.job()).await {
            Either3::First(Ok(count)) => count,
            Either3::First(Err(_)) => {
                shared.add(|counters| &mut counters.bus_other);
                // A port that fails at once must not take all of the processor.
                Timer::after_micros(100).await;
                0
            }
            Either3::Second(()) => 0,
            Either3::Third(job) => return job,
        };
        full = if count == CHUNK { full + 1 } else { 0 };
        if full > LOUD {
            full = 0;
            Timer::after_micros(BREATH_US).await;
        }
        let (now, heard_ticks) = (now_us(), port.heard_ticks());
        let mut rest = chunk.get(..count).unwrap_or_default();
        if let Some(ears) = &mut *bus.ears().await {
            ears.overhear(shared, now, rest, heard_ticks);
        }
        while let Some(said) = answer(bus, now, &mut rest).await {
            // After a pause it is another device that has been waited for.
            if count > 0 {
                note::<B>(shared, &said, port.heard_ticks());
            }
            say::<B>(shared, bus, port, &said).await;
        }
        bus.has_heard();
    }
}

async fn answer<U: BusPort>(bus: &Bus<U>, now: u64, rest: &mut &[u8]) -> Option<Said> {
    bus.ears().await.as_mut()?.voice.as_mut()?.answer(now, rest)
}

/// Notes how long an answer has taken.
fn note<B: Board>(shared: &Shared, said: &Said, heard_ticks: Option<u32>) {
    let Some(heard) = heard_ticks else { return };
    let ticks = B::cost_ticks().wrapping_sub(heard);
    let is_late = said.delay_us > 0 && microseconds::<B>(ticks) > u64::from(said.delay_us);
    shared.count(|counters| {
        counters.answer = ticks;
        counters.answer_most = counters.answer_most.max(ticks);
        counters.late_answers = counters.late_answers.wrapping_add(u32::from(is_late));
    });
}

fn microseconds<B: Board>(ticks: u32) -> u64 {
    u64::from(ticks) * 1_000_000 / u64::from(B::COST_HZ.max(1))
}

/// Sends an answer, and has the tap hear it like everybody else: a port does not hear itself.
async fn say<B: Board>(shared: &Shared, bus: &Bus<B::Bus>, port: &mut B::Bus, said: &Said) {
    let asking = shared.quiet.ask();
    if said.delay_us > 0 {
        // From the end of the question on.
        let ticks = port.heard_ticks().map_or(0, |heard| B::cost_ticks().wrapping_sub(heard));
        Timer::after_micros(u64::from(said.delay_us).saturating_sub(microseconds::<B>(ticks))).await;
    }
    if !(write_all(port, &said.bytes).await && port.flush().await.is_ok()) {
        shared.add(|counters| &mut counters.bus_other);
    }
    drop(asking);
    if let Some(ears) = &mut *bus.ears().await {
        ears.hear_own(&said.bytes);
    }
}
