//! The control task: one report per finger and period, whatever the bus does.
//!
//! A tick leads the servos (Goal Position), reads where they are, and estimates the forces there. When no answer has come
//! by the period's end, the report says so (`stale`, with its age) and the wait goes on until the bus' own deadline.

use embassy_time::{Instant, Timer};
use heapless::Vec;
use messages::Role;

use crate::Model;
use crate::board::{Board, Watchdog};
use crate::leadership::{Leadership, count};
use crate::listening;
use crate::scan::scan;
use crate::servo::{Rates, Servos, Wanted};
use crate::shared::Shared;
use crate::ticks::Core;

/// Runs the gripper for ever, with a model for each finger. It waits until [`crate::answer`] has read what is kept in flash.
pub async fn control<'a, B: Board>(
    shared: &'a Shared,
    models: impl IntoIterator<Item = &'a mut Model>,
    bus: B::Bus,
    mut watchdog: B::Watchdog,
) -> ! {
    let mut servos = Servos::new(bus, B::BUS_LATENCY_US);
    let rates = servos.rates();
    let mut bauds = rates.iter().copied().cycle();
    let mut baud = None;
    let mut elsewhere = true;
    while !shared.is_restored() {
        feed::<B>(shared, &mut watchdog);
        Timer::after_millis(1).await;
    }
    let mut place = Vec::new();
    let Some(core) = Core::<B>::begun(&mut place, shared, models.into_iter()) else { B::restart("no room to begin") };
    let mut ears = None;
    loop {
        core.begin().await;
        feed::<B>(shared, &mut watchdog);
        if !matches!(core.hand.settings.role, Role::Master | Role::Idle) {
            listening::listen(core, servos.port_mut(), &mut ears).await;
            baud = None;
            continue;
        }
        ears = None;
        if core::mem::take(&mut core.orders.scan) {
            scan(core, &mut servos, &rates, baud, &mut watchdog).await;
            continue;
        }
        if core.hand.settings.role == Role::Idle {
            baud = None;
            core.finish();
            continue;
        }
        if let Some((finger, id)) = core.leadership.sought(&core.hand) {
            // While another servo is there, the bus keeps its rate, but for a moment if all are to have the one that is set.
            let wanted = core.hand.settings.baud;
            let other = bauds.next().unwrap_or(1_000_000);
            elsewhere = !elsewhere;
            let look = match baud.or(wanted) {
                Some(rate) if !elsewhere || (baud.is_some() && wanted.is_none()) || core.hand.is_any_gripping() => rate,
                _ => other,
            };
            let commissioned = core.hand.settings.finger(finger as u8).and_then(|mount| mount.servo);
            let rates = Rates { look, wanted, bus: baud };
            let unit = core.hand.units.get(finger);
            let holds = unit.is_none_or(|unit| unit.torque.is_on());
            let wanted = Wanted { commissioned, fence: unit.and_then(|unit| unit.fence()), holds };
            let found = core.patiently(servos.bring_up(finger, id, rates, wanted)).await;
            if !core.hand.is_any_present() {
                // Found once, the servos are looked for at their rate first, then at the others.
                baud = None;
            }
            match found {
                Ok(found) if found.difference.is_some() => Leadership::differs(&mut core.hand, finger, &found),
                Ok(found) => {
                    baud = Some(found.baud);
                    Leadership::found(&mut core.hand, finger, id, &found);
                    core.pace(servos.period_us(core.hand.settings.rate_hz, core.hand.settings.count()));
                }
                Err(error) => count::<B::Bus>(core.hand.shared, &error),
            }
        }
        if let Some((finger, id, to)) = Leadership::torque(&core.hand) {
            match core.patiently(servos.set_torque(finger, id, to)).await {
                Ok(()) => Leadership::has_torque(&mut core.hand, finger, to.is_some()),
                Err(error) => count::<B::Bus>(core.hand.shared, &error),
            }
        }
        if let Some((finger, id, goal_current)) =
            Leadership::unfenced(&core.hand, |finger, fence| servos.unfenced(finger, fence))
            && let Err(error) = core.patiently(servos.fence(finger, id, goal_current)).await
        {
            count::<B::Bus>(core.hand.shared, &error);
        }
        let mut turns = Leadership::turns::<B::Bus>(&mut core.hand, core.scheduler.seconds());
        if !turns.is_empty() {
            core.patiently(servos.tick(&mut turns)).await;
            for turn in &turns {
                match &turn.result {
                    Ok(reading) => core.fresh(turn.finger, reading),
                    Err(error) => core.leadership.failed::<B::Bus>(&mut core.hand, turn.finger, error),
                }
            }
        }
        core.leadership.overheard_others(&core.hand, servos.take_foreign());
        core.finish();
        if let Some((finger, id)) = Leadership::alerting(&core.hand) {
            let status = core.patiently(servos.hardware_error(finger, id)).await;
            Leadership::alerted::<B::Bus>(&mut core.hand, finger, &status);
        }
        if let Some((finger, id)) = core.leadership.strained(&core.hand) {
            let vitals = core.patiently(servos.vitals(finger, id)).await;
            Leadership::derate::<B::Bus>(&mut core.hand, finger, &vitals);
        }
        if !core.hand.is_any_present() {
            servos.forget();
        }
        if core.orders.settings_changed {
            core.orders.settings_changed = false;
            core.pace(servos.period_us(core.hand.settings.rate_hz, core.hand.settings.count()));
        }
    }
}

/// Feeds the watchdog, unless a task below is stuck.
fn feed<B: Board>(shared: &Shared, watchdog: &mut B::Watchdog) {
    if let Some(task) = shared.alive.stuck(Instant::now().as_millis()) {
        B::restart(task.last_words());
    }
    watchdog.feed();
}
