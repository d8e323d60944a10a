//! The roles tap and device: another master leads the servos. The gripper listens to what that master reads of them and
//! estimates from it; as a device it answers too, under an address of its own, what its control table says.
//!
//! The bus task hears and answers ([`serve`](crate::serve)), so that an answer waits for no estimate: the control table has the numbers of the
//! last one, and the age of their position. The control task estimates as soon as a position is heard, once per period at most
//! ([`listen`]). In a period without a new position the last estimate is reported again, with the time of its position and its age in
//! ticks, as long as that is a tenth of a second old at most; after that it is `stale`.
//!
//! A tap has nothing that writes to the bus.

use dynamixel::{Model, Seen};
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Timer};
use grip::Health;
use messages::{Event, For, Object, Role};

use crate::board::{Board, BusPort};
use crate::bus::{Bus, HeldEars, Job};
use crate::device_table::{Change, FingerSettings, FingerState, put_circle};
use crate::ears::{Ears, Sight, Voice, age_us};
use crate::servo::Reading;
use crate::setup::Key;
use crate::shared::{Command, now_us};
use crate::ticks::Core;

/// How long an object that the master has set rests before it is written to flash.
const REST: Duration = Duration::from_secs(5);

/// One period of a gripper that listens.
pub(crate) async fn listen<B: Board>(core: &mut Core<'_, B>, bus: &Bus<B::Bus>) {
    // The table says anew what is set only where everything that the master has written is set.
    drop(do_changes(core, bus).await);
    let (role, baud) = (core.hand.settings.role, core.hand.settings.baud_heard());
    let is_open = bus.ears().await.as_ref().is_some_and(|ears| ears.are(role, baud));
    if !is_open || core.orders.settings_changed {
        core.orders.settings_changed = false;
        core.pace(1_000_000 / u64::from(core.hand.settings.rate_hz.max(1)));
    }
    if !is_open {
        bus.give(Job::Rest);
        bus.line().await.servos.port_mut().set_baud(baud);
        Ears::open::<B>(&mut *do_changes(core, bus).await, &core.hand.settings, baud);
        core.orders.setup_is_new = true;
        bus.give(Job::Listen);
    }
    if core.orders.setup_is_new
        && let Some(ears) = &mut *do_changes(core, bus).await
    {
        core.orders.setup_is_new = false;
        core.set_ears(ears);
    }
    // What came once the last period had its estimate.
    take_in(core, bus).await;
    while Instant::now() < core.scheduler.end {
        // What the grip bears is looked for meanwhile, a step at a time.
        let has_searched = core.estimation.margins.search::<B>(&core.scheduler);
        let next = if has_searched { Instant::MIN } else { core.scheduler.end };
        if let Either::First(()) = select(bus.heard(), Timer::at(next)).await {
            take_in(core, bus).await;
        }
    }
    core.finish();
    show(core, bus).await;
}

/// Another role than those that listen.
pub(crate) async fn stop<U: BusPort>(bus: &Bus<U>) {
    let mut ears = bus.ears().await;
    if ears.is_some() {
        *ears = None;
        bus.give(Job::Rest);
    }
}

/// Does what the master wants, and estimates from what it has read.
async fn take_in<B: Board>(core: &mut Core<'_, B>, bus: &Bus<B::Bus>) {
    drop(do_changes(core, bus).await);
    for finger in 0..core.hand.units.len() {
        if let Some(sight) = sight(core, bus, finger).await
            && core.listen_to(finger, &sight)
        {
            show(core, bus).await;
        }
    }
}

/// Does what the master has changed, one thing at a time: an answer does not wait for it. Nothing is left to do while the ears are held that
/// this returns.
async fn do_changes<'b, B: Board>(core: &mut Core<'_, B>, bus: &'b Bus<B::Bus>) -> HeldEars<'b> {
    loop {
        let mut ears = bus.ears().await;
        let Some(change) = ears.as_mut().and_then(Ears::take_change) else { return ears };
        drop(ears);
        core.change(change);
    }
}

/// What is known of a finger's servo.
async fn sight<B: Board>(core: &Core<'_, B>, bus: &Bus<B::Bus>, finger: usize) -> Option<Sight> {
    let id = core.hand.units.get(finger)?.id()?;
    bus.ears().await.as_ref()?.sight(id)
}

/// Shows in the control table what the fingers feel.
async fn show<B: Board>(core: &Core<'_, B>, bus: &Bus<B::Bus>) {
    if let Some(Ears { voice: Some(voice), .. }) = &mut *bus.ears().await {
        core.show(voice);
    }
}

impl<B: Board> Core<'_, B> {
    /// Sets the ears to what is set.
    #[inline(never)]
    fn set_ears(&mut self, ears: &mut Ears) {
        ears.forget();
        for unit in &mut self.hand.units {
            unit.heard_us = None;
            if let Some(id) = unit.id() {
                let commissioned = unit.mount.and_then(|mount| mount.servo).and_then(|servo| Model::of(servo.model));
                ears.watch(id, commissioned.unwrap_or(Model::ASSUMED));
            }
        }
        let Some(voice) = &mut ears.voice else {
            return;
        };
        voice.settle(&self.hand.settings);
        let objects = self.hand.shared.setup(|setup| setup.objects);
        for (finger, (mount, object)) in self.hand.settings.fingers.iter().zip(&objects).enumerate() {
            if let Some(mount) = mount {
                voice.table.set_finger(finger, &FingerSettings::of(mount));
            }
            voice.table.set_object(finger, object.as_ref().map(|object| &object.design));
        }
        self.show(voice);
    }

    /// Shows the master what the fingers feel.
    fn show(&self, voice: &mut Voice) {
        let now = now_us();
        for (finger, unit) in self.hand.units.iter().enumerate().filter(|(_, unit)| unit.mount.is_some()) {
            let (estimate, position, current) = (unit.last.estimate, unit.last.position, unit.last.current);
            // The numbers may still be those of the position before: a finger on a free object waits for the others.
            let at_us = unit.heard_us.map(|at_us| at_us.min(unit.last.time_us));
            let age_us = at_us.map(|at_us| age_us(at_us, now));
            voice.table.show(finger, &FingerState { estimate, position, current, age_us, alert: unit.alert });
            if let Some(heard_us) = voice.heard_us.get_mut(finger) {
                *heard_us = at_us;
            }
        }
        voice.table.show_margin(self.estimation.margins.report(self.scheduler.ticks).as_ref());
    }

    /// Estimates from a position that was not there before, once per period. Returns whether there was one.
    #[inline(never)]
    fn listen_to(&mut self, finger: usize, servo: &Sight) -> bool {
        let Some(unit) = self.hand.units.get_mut(finger) else {
            return false;
        };
        if let Some(Seen { value, .. }) = servo.hardware_error
            && core::mem::replace(&mut unit.hardware_error, value) != value
        {
            self.hand.shared.tell(Event::ServoAlert { finger: finger as u8, hardware_error: value });
        }
        unit.servo = servo.model;
        if let Some(goal) = servo.goal {
            let goal = unit.calibration.angle(servo.model.to_4096ths(goal.value));
            if goal != unit.grip.goal() {
                unit.grip.renamed(goal);
            }
        }
        let Some(seen) = servo.position else {
            return false;
        };
        if unit.is_done() || unit.heard_us == Some(seen.at_us) {
            return false;
        }
        (unit.heard_us, unit.repeats) = (Some(seen.at_us), 0);
        if !unit.health.is_present() {
            unit.health = Health::READY;
            self.hand.shared.tell(Event::ServoHeard { finger: finger as u8 });
        }
        // A current that the master does not read, or the servo does not show, is 0.
        let current = servo.effort.map_or(0.0, |effort| f32::from(effort.value) * servo.model.effort_milliamperes());
        let reading = Reading {
            at_us: seen.at_us,
            heard_ticks: servo.heard_ticks,
            position: servo.model.to_4096ths(seen.value),
            current,
            alert: servo.alert,
            refused: None,
        };
        self.fresh(finger, &reading);
        true
    }

    /// Does what the master wants.
    #[inline(never)]
    fn change(&mut self, change: Change) {
        let mut settings = self.hand.settings;
        let (command, key) = match change {
            Change::Reboot => {
                self.restart = true;
                return;
            }
            // The host has made it a tap meanwhile.
            Change::Bus(_) if settings.role == Role::Tap => return,
            Change::Bus(bus) => {
                bus.put_into(&mut settings);
                (Command::Settings(settings), Key::Settings)
            }
            Change::Finger(finger, changed) => {
                if let Some(Some(mount)) = settings.fingers.get_mut(finger) {
                    changed.put_into(mount);
                }
                (Command::Settings(settings), Key::Settings)
            }
            Change::Object(finger, design) => {
                let object = self.hand.shared.setup(|setup| setup.objects.get(finger).copied().flatten());
                let design = put_circle(design, object.as_ref().map(|object| &object.design));
                // The table has no register for friction: it stays.
                let what = Object { design, friction: object.map_or(0.0, |object| object.friction) };
                self.placed = Instant::now();
                (Command::Object(For { finger: finger as u8, what }), Key::Object(finger as u8))
            }
        };
        match self.execute(&command) {
            Ok(()) if !self.unkept.contains(&key) => {
                // There is room for every key.
                let _ = self.unkept.push(key);
            }
            Ok(()) => {}
            // The table says again what holds.
            Err(_) => self.orders.setup_is_new = true,
        }
    }

    /// Has one thing that the master has set written to flash; restarts, if it wants that, when all of them are. An object is written once it
    /// rests: a master may set one number after the other, or follow an object that moves.
    #[inline(never)]
    pub(crate) fn keep_next(&mut self) {
        let rests = self.restart || Instant::now().saturating_duration_since(self.placed) >= REST;
        let is_due = |key: &Key| rests || !matches!(key, Key::Object(_));
        if let Some(place) = self.unkept.iter().position(is_due) {
            if self.unkept.get(place).is_some_and(|key| self.hand.shared.keep_soon(*key)) {
                self.unkept.remove(place);
            }
        } else if self.restart && self.hand.shared.is_all_kept() {
            B::restart("");
        }
    }
}
