//! When ticks begin and end, and what is left of one.

use embassy_time::{Duration, Instant, Timer};
use grip::Meter;
use messages::Event;

use crate::board::Board;
use crate::shared::Shared;

/// A tick that goes on beyond its period leaves one part in so many of the next one to what comes behind the control task.
pub const LINK_SHARE: u32 = 16;
/// Part of what questions of late took longer than the quickest by which that is forgotten.
const PACE: u32 = 16;

/// The control task's clock.
pub(crate) struct Scheduler {
    period: Duration,
    /// When the present period ends.
    pub(crate) end: Instant,
    /// How much later than that the present tick may end: until then the next one's question is not answered.
    ahead: Option<Duration>,
    /// What a question takes at least.
    quickest: Duration,
    /// The period before has ended so long ago that the present one was begun anew.
    pub(crate) is_behind: bool,
    meter: Meter,
    /// Ticks begun.
    pub(crate) ticks: u32,
}

impl Scheduler {
    /// So many ticks per second, from now on.
    pub(crate) fn new(rate_hz: u16) -> Self {
        let now = Instant::now();
        let period = Duration::from_micros(1_000_000 / u64::from(rate_hz.max(1)));
        let (ahead, quickest, is_behind) = (None, Duration::MAX, false);
        Self { period, end: now, ahead, quickest, is_behind, meter: Meter::new(now.as_micros()), ticks: 0 }
    }

    /// A period, s.
    pub(crate) fn seconds(&self) -> f64 {
        self.period.as_micros() as f64 * 1e-6
    }

    /// The next question is asked at the period's end, whatever this tick does; the last one took so long.
    pub(crate) fn asks_ahead(&mut self, took: Duration) {
        let longer = took.checked_sub(self.quickest);
        self.quickest = longer.map_or(took, |longer| self.quickest + longer / PACE);
        self.ahead = self.quickest.min(self.period).checked_sub(self.period / LINK_SHARE);
    }

    /// When the present tick should be over.
    fn due(&self) -> Instant {
        self.ahead.and_then(|ahead| self.end.checked_add(ahead)).unwrap_or(self.end)
    }

    /// What is left of the tick, ticks of the cost clock.
    pub(crate) fn left<B: Board>(&self) -> u64 {
        let us = self.due().saturating_duration_since(Instant::now()).as_micros();
        us.saturating_mul(u64::from(B::COST_HZ)) / 1_000_000
    }

    fn chosen_hz(&self) -> f32 {
        1e6 / self.period.as_micros() as f32
    }

    /// Takes another period, and reports it next to the rate that is wanted.
    pub(crate) fn pace(&mut self, period_us: u64, wanted_hz: u16, shared: &Shared) {
        self.period = Duration::from_micros(period_us.max(1));
        let hz = self.chosen_hz();
        shared.count(|counters| counters.chosen_hz = hz);
        shared.tell(Event::Rate { hz, wanted_hz: f32::from(wanted_hz) });
    }

    /// Waits for the next period.
    pub(crate) async fn wait(&self) {
        let now = Instant::now();
        if now < self.end {
            Timer::at(self.end).await;
        } else {
            // Never all of the processor: the link, which comes behind this task, has to live too.
            Timer::after(self.period / LINK_SHARE).await;
        }
    }

    /// Begins a period where the last one ended, or now if that is more than a period ago. It is late by more than half a period after the
    /// last tick should have been over.
    pub(crate) fn advance(&mut self, shared: &Shared) {
        let now = Instant::now();
        if now.saturating_duration_since(self.due()) > self.period / 2 {
            shared.add(|counters| &mut counters.late_ticks);
        }
        self.ahead = None;
        self.is_behind = now.saturating_duration_since(self.end) > self.period;
        let begin = if self.is_behind { now } else { self.end };
        self.end = begin.checked_add(self.period).unwrap_or(Instant::MAX);
        self.ticks = self.ticks.wrapping_add(1);
        shared.add(|counters| &mut counters.ticks);
        let chosen = self.chosen_hz();
        if let Some(second) = self.meter.tick(now.as_micros(), chosen) {
            shared.count(|counters| counters.rate_hz = second.hz);
            if second.turned {
                shared.tell(Event::RateReached { hz: second.hz, chosen_hz: chosen });
            }
        }
    }
}
