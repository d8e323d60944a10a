//! The control task: one report per finger and period, whatever the bus does.
//!
//! A tick reads where the servos are, estimates the forces there, and finds where they go next (Goal Position). Before it estimates, it has the
//! [`bus`](crate::bus) task ask the next tick's question at the period's end: an estimate may go on until that is answered. The
//! goals go out with that question, if they are ready by then, or with the one after.
//!
//! When no answer has come by the period's end, the report says so (`stale`, with its age) and the wait goes on until the bus' own deadline.

use core::iter::{Copied, Cycle};
use core::slice;

use embassy_time::{Instant, Timer};
use heapless::Vec;
use messages::{FINGERS, Role};

use crate::Model;
use crate::board::{Board, Watchdog};
use crate::bus::{Bus, Job};
use crate::leadership::{Leadership, count};
use crate::listening;
use crate::scan::scan;
use crate::servo::{Rates, Servos, Turn, Wanted};
use crate::shared::Shared;
use crate::ticks::Core;

/// Runs the gripper for ever, with a model for each finger. It waits until [`crate::answer`] has read what is kept in flash.
pub async fn control<'a, B: Board>(
    shared: &'a Shared,
    models: impl IntoIterator<Item = &'a mut Model>,
    bus: &Bus<B::Bus>,
    mut watchdog: B::Watchdog,
) -> ! {
    let rates = bus.line().await.servos.rates();
    let mut search = Search { rates: rates.iter().copied().cycle(), baud: None, is_elsewhere: true };
    while !shared.is_restored() {
        feed::<B>(shared, &mut watchdog);
        Timer::after_millis(1).await;
    }
    let mut place = Vec::new();
    let Some(core) = Core::<B>::begun(&mut place, shared, models.into_iter()) else { B::restart("no room to begin") };
    loop {
        core.begin().await;
        feed::<B>(shared, &mut watchdog);
        // Also of a gripper that no longer listens.
        core.keep_next();
        if core.is_asking && core.scheduler.is_behind {
            // What was answered meanwhile is older than a period: it is asked anew.
            core.meanwhile(bus.answered()).await;
            core.is_asking = false;
            let mut line = bus.line().await;
            core.took = line.took;
            let turns = core::mem::take(&mut line.turns);
            drop(line);
            turns.iter().for_each(|turn| core.answered(turn, true));
        }
        if !core.is_asking {
            if !matches!(core.hand.settings.role, Role::Master | Role::Idle) {
                listening::listen(core, bus).await;
                search.baud = None;
                continue;
            }
            listening::stop(bus).await;
            let mut line = bus.line().await;
            if core::mem::take(&mut core.orders.scan) {
                scan(core, &mut line.servos, &rates, search.baud, &mut watchdog).await;
                continue;
            }
            if core.hand.settings.role == Role::Idle {
                search.baud = None;
                core.finish();
                continue;
            }
            take_over(core, &mut line.servos, &mut search).await;
            line.turns = Leadership::turns(&core.hand);
            core.is_asking = !line.turns.is_empty();
            bus.set_goals(core.goals());
            drop(line);
            if core.is_asking {
                bus.give(Job::Ask(Instant::now()));
            }
        }
        if core.is_asking {
            core.meanwhile(bus.answered()).await;
            core.is_busy = false;
            for turn in &answers(core, bus).await {
                core.answered(turn, false);
            }
            if core.is_asking {
                bus.set_goals(core.goals());
            }
        }
        core.finish();
        if !core.is_asking {
            look_after(core, &mut bus.line().await.servos).await;
        }
    }
}

/// Rates at which servos are looked for.
struct Search<'a> {
    rates: Cycle<Copied<slice::Iter<'a, u32>>>,
    /// The rate at which servos are controlled, once one was found.
    baud: Option<u32>,
    /// The last one was not the bus's rate.
    is_elsewhere: bool,
}

impl Search<'_> {
    /// The next one. While another servo is there, the bus keeps its rate, but for a moment if all are to have the one that is set.
    fn next(&mut self, wanted: Option<u32>, is_gripping: bool) -> u32 {
        let other = self.rates.next().unwrap_or(1_000_000);
        self.is_elsewhere = !self.is_elsewhere;
        match self.baud.or(wanted) {
            Some(rate) if !self.is_elsewhere || (self.baud.is_some() && wanted.is_none()) || is_gripping => rate,
            _ => other,
        }
    }
}

/// Before a tick's question: looks for a servo that is not there, and sets what is to be set in one that is.
async fn take_over<B: Board>(core: &mut Core<'_, B>, servos: &mut Servos<B::Bus>, search: &mut Search<'_>) {
    if let Some((finger, id)) = core.leadership.sought(&core.hand) {
        let wanted = core.hand.settings.baud;
        let look = search.next(wanted, core.hand.is_any_gripping());
        let commissioned = core.hand.settings.finger(finger as u8).and_then(|mount| mount.servo);
        let rates = Rates { look, wanted, bus: search.baud };
        let unit = core.hand.units.get(finger);
        let holds = unit.is_none_or(|unit| unit.torque.is_on());
        let wanted = Wanted { commissioned, fence: unit.and_then(|unit| unit.fence()), holds };
        let found = core.patiently(servos.bring_up(finger, id, rates, wanted)).await;
        if !core.hand.is_any_present() {
            // Found once, the servos are looked for at their rate first, then at the others.
            search.baud = None;
        }
        match found {
            Ok(found) if found.difference.is_some() => Leadership::differs(&mut core.hand, finger, &found),
            Ok(found) => {
                search.baud = Some(found.baud);
                Leadership::found(&mut core.hand, finger, id, &found);
                core.pace(servos.period_us(core.hand.settings.rate_hz, core.hand.settings.count()));
            }
            Err(error) => count::<B::Bus>(core.hand.shared, &error),
        }
    }
    if let Some((finger, id, to)) = core.leadership.torque(&core.hand) {
        match core.patiently(servos.set_torque(finger, id, to)).await {
            Ok(()) => Leadership::has_torque(&mut core.hand, finger, to.is_some()),
            Err(error) => {
                count::<B::Bus>(core.hand.shared, &error);
                if let Some(unit) = core.hand.units.get_mut(finger) {
                    // It may have obeyed, and not answer.
                    unit.doubted = true;
                }
                if let (dynamixel::Error::Refused { error, .. }, Some(goal)) = (error, to) {
                    Leadership::stays_relaxed(&mut core.hand, finger, goal, error);
                }
            }
        }
    }
    if let Some((finger, id, goal_current)) =
        Leadership::unfenced(&core.hand, |finger, fence| servos.unfenced(finger, fence))
        && let Err(error) = core.patiently(servos.fence(finger, id, goal_current)).await
    {
        count::<B::Bus>(core.hand.shared, &error);
    }
}

/// The answers to a tick's question. Where nothing else is to be done on the bus, the next one is asked at the period's end.
async fn answers<B: Board>(core: &mut Core<'_, B>, bus: &Bus<B::Bus>) -> Vec<Turn<B::Bus>, FINGERS> {
    let mut line = bus.line().await;
    let turns = core::mem::take(&mut line.turns);
    core.took = line.took;
    core.leadership.overheard_others(&core.hand, line.servos.take_foreign());
    core.is_asking = core.may_ask_ahead(&turns) && !core.leadership.has_more_to_do(&core.hand, &line.servos);
    if core.is_asking {
        line.turns = Leadership::turns(&core.hand);
        core.scheduler.asks_ahead(line.took);
        bus.give(Job::Ask(core.scheduler.end));
    }
    turns
}

/// After a tick, where the next question waits for it: asks what only now and then matters.
async fn look_after<B: Board>(core: &mut Core<'_, B>, servos: &mut Servos<B::Bus>) {
    if let Some((finger, id)) = Leadership::alerting(&core.hand) {
        let status = core.patiently(servos.hardware_error(finger, id)).await;
        Leadership::alerted::<B::Bus>(&mut core.hand, finger, &status);
    }
    if let Some((finger, id)) = core.leadership.looks_at(&core.hand) {
        let is_doubted = core.hand.units.get(finger).is_some_and(|unit| unit.doubted);
        let look = core.patiently(servos.look(finger, id, is_doubted)).await;
        core.leadership.looked::<B::Bus>(&mut core.hand, finger, &look);
    }
    if !core.hand.is_any_present() {
        servos.forget();
    }
    if core::mem::take(&mut core.orders.settings_changed) {
        core.pace(servos.period_us(core.hand.settings.rate_hz, core.hand.settings.count()));
    }
}

/// Feeds the watchdog, unless a task below is stuck.
fn feed<B: Board>(shared: &Shared, watchdog: &mut B::Watchdog) {
    if let Some(task) = shared.alive.stuck(Instant::now().as_millis()) {
        B::restart(task.last_words());
    }
    watchdog.feed();
}
