//! The control task: one report per finger and period, whatever the bus does.
//!
//! A tick leads the servos (Goal Position), reads where they are, and estimates the forces there. When no answer has come
//! by the period's end, the report says so (`stale`, with its age) and the wait goes on until the bus' own deadline.

mod obey;

use core::future::Future;
use core::pin::pin;

use dynamixel::{Id, xm430};
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Timer};
use grip::{Faults, Health, Meter, StrainWatch, Vitals};
use heapless::Vec;
use messages::{Event, FINGERS, Grasp, Reaction, Report, Role, Settings, Shape, Silence};
use model_core::estimator::Estimate;
use model_core::status::Status;

use crate::Model;
use crate::board::{Board, BusPort, Watchdog};
use crate::free::{Free, Pending};
use crate::listening;
use crate::scan::scan;
use crate::servo::{BusError, Found, Rates, Reading, Servos, Turn};
use crate::shared::{Order, Shared, now_us};
use crate::store::Key;
use crate::unit::{Torque, Unit};

/// How often a servo that is gone is looked for while others are there: the search takes ticks from them.
const SEARCH: Duration = Duration::from_millis(250);

/// How often while a finger grips: at the others' rate only, so that it costs a gripping finger a tick or two.
const SEARCH_GRIPPING: Duration = Duration::from_secs(1);

/// How often another master on the bus is reported.
const OTHER_AGAIN: Duration = Duration::from_secs(10);
/// How long another master's last word counts as a reason for what goes wrong.
const OTHER_ABOUT: Duration = Duration::from_secs(1);

/// How often each servo is asked how warm it is and what supplies it.
const LOOK: Duration = Duration::from_secs(1);

/// A tick that is late leaves one part in so many of its period to what comes behind the control task.
const LINK_SHARE: u32 = 16;

/// The records that there are: settings, and each finger's design and object.
const UNKEPT: usize = 1 + 2 * FINGERS;

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
    let mut core = Core::<B>::new(shared, models.into_iter());
    let mut ears = None;
    loop {
        core.begin().await;
        feed::<B>(shared, &mut watchdog);
        if !matches!(core.settings.role, Role::Master | Role::Idle) {
            listening::listen(&mut core, servos.port_mut(), &mut ears).await;
            baud = None;
            continue;
        }
        ears = None;
        if core::mem::take(&mut core.scan) {
            scan(&mut core, &mut servos, &rates, baud, &mut watchdog).await;
            continue;
        }
        if core.settings.role == Role::Idle {
            baud = None;
            core.finish();
            continue;
        }
        if let Some((finger, id)) = core.sought() {
            // While another servo is there, the bus keeps its rate, but for a moment if all are to have the one that is set.
            let wanted = core.settings.baud;
            let other = bauds.next().unwrap_or(1_000_000);
            elsewhere = !elsewhere;
            let look = match baud.or(wanted) {
                Some(rate) if !elsewhere || (baud.is_some() && wanted.is_none()) || core.is_any_gripping() => rate,
                _ => other,
            };
            let commissioned = core.settings.finger(finger as u8).and_then(|mount| mount.servo);
            let rates = Rates { look, wanted, bus: baud };
            let holds = core.units.get(finger).is_none_or(|unit| unit.torque.is_on());
            let found = core.patiently(servos.bring_up(finger, id, rates, commissioned, holds)).await;
            if !core.is_any_present() {
                // Found once, the servos are looked for at their rate first, then at the others.
                baud = None;
            }
            match found {
                Ok(found) if found.difference.is_some() => core.differs(finger, &found),
                Ok(found) => {
                    baud = Some(found.baud);
                    core.found(finger, id, &found);
                    core.pace(servos.period_us(core.settings.rate_hz, core.settings.count()));
                }
                Err(error) => core.count::<B::Bus>(&error),
            }
        }
        if let Some((finger, id, to)) = core.torque() {
            match core.patiently(servos.set_torque(finger, id, to)).await {
                Ok(()) => core.has_torque(finger, to.is_some()),
                Err(error) => core.count::<B::Bus>(&error),
            }
        }
        let mut turns = core.turns::<B::Bus>();
        if !turns.is_empty() {
            core.patiently(servos.tick(&mut turns)).await;
            for turn in &turns {
                match &turn.result {
                    Ok(reading) => core.fresh(turn.finger, reading),
                    Err(error) => core.failed(turn.finger, error),
                }
            }
        }
        core.overheard_others(servos.take_foreign());
        core.finish();
        if let Some((finger, id)) = core.alerting() {
            let status = core.patiently(servos.hardware_error(id)).await;
            core.alerted(finger, &status);
        }
        if let Some((finger, id)) = core.strained() {
            let vitals = core.patiently(servos.vitals(id)).await;
            core.derate(finger, &vitals);
        }
        if !core.is_any_present() {
            servos.forget();
        }
        if core.settings_changed {
            core.settings_changed = false;
            core.pace(servos.period_us(core.settings.rate_hz, core.settings.count()));
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

/// Everything but the bus.
pub(crate) struct Core<'a, B> {
    pub(crate) shared: &'a Shared,
    pub(crate) units: Vec<Unit<'a>, FINGERS>,
    pub(crate) settings: Settings,
    period: Duration,
    /// When the present period ends.
    pub(crate) end: Instant,
    meter: Meter,
    /// Reports made.
    sequence: u32,
    /// Ticks begun.
    ticks: u32,
    /// When a servo is looked for next, and where the search goes on.
    search: Instant,
    next_sought: usize,
    /// When a servo is asked for its temperature next, and which comes after that.
    look: Instant,
    next_looked: usize,
    pub(crate) settings_changed: bool,
    /// Something was set that the control table has to show.
    pub(crate) setup_is_new: bool,
    /// What the bus's master has set and the flash has not got yet.
    pub(crate) unkept: Vec<Key, UNKEPT>,
    /// The bus's master wants a restart.
    pub(crate) restart: bool,
    /// An order that waits for a transaction's end.
    pub(crate) waiting: Option<Order>,
    /// The bus is to be searched, or is just being searched.
    scan: bool,
    pub(crate) is_scanning: bool,
    /// The object, if it is free.
    pub(crate) free: Option<Free>,
    /// When another master was last heard, and last reported.
    heard_other: Option<Instant>,
    told_other: Option<Instant>,
    board: core::marker::PhantomData<B>,
}

impl<'a, B: Board> Core<'a, B> {
    fn new(shared: &'a Shared, models: impl Iterator<Item = &'a mut Model>) -> Self {
        // What was kept may be of a board with more room.
        let settings = shared.setup(|setup| setup.settings);
        let settings = if settings.validate(B::FINGERS).is_ok() { settings } else { Settings::DEFAULT };
        shared.set(|setup| setup.settings = settings);
        let mut units: Vec<Unit<'a>, FINGERS> = Vec::new();
        for (number, (model, mount)) in models.zip(settings.fingers).enumerate() {
            // There are as many mounts as there is room.
            let mut unit = Unit::new(number as u8, model, mount);
            unit.restore(shared);
            let _ = units.push(unit);
        }
        let now = Instant::now();
        Self {
            shared,
            units,
            settings,
            period: Duration::from_micros(1_000_000 / u64::from(settings.rate_hz.max(1))),
            end: now,
            meter: Meter::new(now.as_micros()),
            sequence: 0,
            ticks: 0,
            search: now,
            next_sought: 0,
            look: now,
            next_looked: 0,
            settings_changed: false,
            setup_is_new: true,
            unkept: Vec::new(),
            restart: false,
            waiting: None,
            scan: false,
            is_scanning: false,
            free: Free::of(settings.support),
            heard_other: None,
            told_other: None,
            board: core::marker::PhantomData,
        }
    }

    fn seconds(&self) -> f64 {
        self.period.as_micros() as f64 * 1e-6
    }

    /// What is left of the period, ticks of the cost clock.
    pub(crate) fn left(&self) -> u64 {
        let us = self.end.saturating_duration_since(Instant::now()).as_micros();
        us.saturating_mul(u64::from(B::COST_HZ)) / 1_000_000
    }

    /// This finger's share of it: the fingers behind want theirs too, and a free object as much as all of them.
    fn share(&self, finger: usize) -> u32 {
        let behind = self.units.iter().skip(finger).filter(|unit| unit.health.is_present() && !unit.is_reported);
        let shares = behind.count().max(1) * if self.free.is_some() { 2 } else { 1 };
        let own = self.left().checked_div(shares as u64).unwrap_or(0);
        u32::try_from(own).unwrap_or(u32::MAX)
    }

    fn chosen_hz(&self) -> f32 {
        1e6 / self.period.as_micros() as f32
    }

    pub(crate) fn pace(&mut self, period_us: u64) {
        self.period = Duration::from_micros(period_us.max(1));
        let hz = self.chosen_hz();
        self.shared.count(|counters| counters.chosen_hz = hz);
        self.shared.tell(Event::Rate { hz, wanted_hz: f32::from(self.settings.rate_hz) });
    }

    /// Waits for the next period and obeys one order.
    async fn begin(&mut self) {
        let now = Instant::now();
        if now < self.end {
            Timer::at(self.end).await;
        } else {
            // Never all of the processor: the link, which comes behind this task, has to live too.
            Timer::after(self.period / LINK_SHARE).await;
        }
        self.advance();
        self.obey(true);
    }

    /// Begins a period where the last one ended, or now if that is more than a period ago.
    fn advance(&mut self) {
        let now = Instant::now();
        let late = now.saturating_duration_since(self.end);
        if late > self.period / 2 {
            self.shared.add(|counters| &mut counters.late_ticks);
        }
        let begin = if late > self.period { now } else { self.end };
        self.end = begin.checked_add(self.period).unwrap_or(Instant::MAX);
        self.ticks = self.ticks.wrapping_add(1);
        self.units.iter_mut().for_each(|unit| unit.is_reported = false);
        self.free.iter_mut().for_each(Free::begin);
        self.shared.add(|counters| &mut counters.ticks);
        let chosen = self.chosen_hz();
        if let Some(second) = self.meter.tick(now.as_micros(), chosen) {
            self.shared.count(|counters| counters.rate_hz = second.hz);
            if second.turned {
                self.shared.tell(Event::RateReached { hz: second.hz, chosen_hz: chosen });
            }
        }
    }

    /// Waits for a transaction on the bus; periods that pass meanwhile are reported as stale.
    pub(crate) async fn patiently<F: Future>(&mut self, transaction: F) -> F::Output {
        let _asking = self.shared.quiet.ask();
        let mut transaction = pin!(transaction);
        loop {
            match select(transaction.as_mut(), Timer::at(self.end)).await {
                Either::First(output) => return output,
                Either::Second(()) => {
                    self.finish();
                    self.advance();
                    self.obey(false);
                }
            }
        }
    }

    /// Waits without a transaction, for so many µs.
    pub(crate) async fn pause(&mut self, us: u64) {
        let until = Instant::now() + Duration::from_micros(us);
        while self.end < until {
            Timer::at(self.end).await;
            self.finish();
            self.advance();
            self.obey(false);
        }
        Timer::at(until).await;
    }

    fn is_any_present(&self) -> bool {
        self.units.iter().any(|unit| unit.health.is_present())
    }

    /// Whether a finger whose servo is there grips.
    fn is_any_gripping(&self) -> bool {
        self.units.iter().any(|unit| unit.health.is_present() && unit.grip.is_gripping())
    }

    /// A servo that is to be looked for now, the fingers in turn. Less often while a finger grips: that costs it ticks.
    fn sought(&mut self) -> Option<(usize, Id)> {
        let present = self.is_any_present();
        let now = Instant::now();
        if present && now < self.search {
            return None;
        }
        let missing = |(_, unit): &(usize, &Unit<'_>)| unit.mount.is_some() && !unit.health.is_present();
        let fingers = self.units.iter().enumerate();
        let (finger, unit) = fingers.clone().skip(self.next_sought).chain(fingers).find(missing)?;
        let id = unit.id()?;
        self.search = now + if self.is_any_gripping() { SEARCH_GRIPPING } else { SEARCH };
        self.next_sought = finger + 1;
        Some((finger, id))
    }

    /// A servo whose torque is to be changed: off, or on with this goal (counts).
    fn torque(&self) -> Option<(usize, Id, Option<i32>)> {
        self.units.iter().enumerate().filter(|(_, unit)| unit.health.is_present()).find_map(|(finger, unit)| {
            let goal = match unit.torque {
                Torque::On | Torque::Off => return None,
                Torque::Falling => None,
                Torque::Rising => Some(unit.last.position),
            };
            Some((finger, unit.id()?, goal))
        })
    }

    /// A servo has or has no torque any more.
    fn has_torque(&mut self, finger: usize, is_on: bool) {
        if let Some(unit) = self.units.get_mut(finger) {
            // Meanwhile it may have been asked for the opposite.
            unit.torque = match (unit.torque, is_on) {
                (Torque::Rising, true) => Torque::On,
                (Torque::Falling, false) => Torque::Off,
                (other, _) => other,
            };
        }
    }

    /// So many instructions of another master were heard: an event, and again when it still speaks a while later.
    fn overheard_others(&mut self, packets: u32) {
        if packets == 0 {
            return;
        }
        self.shared.count(|counters| counters.bus_foreign = counters.bus_foreign.wrapping_add(packets));
        let now = Instant::now();
        self.heard_other = Some(now);
        if self.told_other.is_none_or(|told| now.saturating_duration_since(told) >= OTHER_AGAIN) {
            self.told_other = Some(now);
            self.shared.tell(Event::OtherMaster { packets: self.shared.counters().bus_foreign });
        }
    }

    /// Whether another master has spoken just now.
    pub(crate) fn is_other_about(&self) -> bool {
        self.heard_other.is_some_and(|heard| Instant::now().saturating_duration_since(heard) <= OTHER_ABOUT)
    }

    /// Ends motions whose host has gone away, if that is set.
    fn mind_host(&mut self) {
        let reaction = match self.settings.on_silence {
            Silence::GoOn => return,
            Silence::Hold => Reaction::Hold,
            Silence::Release => Reaction::Release,
        };
        if self.shared.host_silence_ms() > u32::from(self.settings.silence_ms) {
            for unit in &mut self.units {
                if let Some(mount) = &unit.mount {
                    unit.grip.leave(&mount.limits(), reaction);
                }
            }
        }
    }

    /// Whom the tick asks, and for what.
    fn turns<U: BusPort>(&mut self) -> Vec<Turn<U>, FINGERS> {
        self.mind_host();
        let seconds = self.seconds();
        let mut turns = Vec::new();
        for (finger, unit) in self.units.iter_mut().enumerate() {
            if let Some(id) = unit.id()
                && unit.health.is_present()
            {
                // One per finger.
                let _ = turns.push(Turn::new(finger, id, unit.advance(seconds)));
            }
        }
        turns
    }

    /// A position came: estimates and reports.
    pub(crate) fn fresh(&mut self, finger: usize, reading: &Reading) {
        let left = self.share(finger);
        let Some(unit) = self.units.get_mut(finger) else {
            return;
        };
        unit.health.answered();
        unit.seen();
        unit.alert_changed |= reading.alert != unit.alert;
        unit.alert = reading.alert;
        if let Some((position, error)) = reading.refused {
            self.shared.add(|counters| &mut counters.bus_refused);
            self.shared.tell(Event::GoalRefused { finger: finger as u8, position, error: error.code() });
        }
        let start = B::cost_ticks();
        unit.model.set_budget(unit.budget.iterations(left));
        let estimate = unit.model.update(unit.calibration.finger_angle(reading.position));
        let cost = B::cost_ticks().wrapping_sub(start);
        // Without a finger, an object or a motion an estimate costs nothing, and tells nothing of what one costs.
        if estimate.status != Status::OutOfRange && !unit.model.has_rested() {
            unit.budget.spent(cost, u32::from(estimate.iterations));
        }
        self.shared.add(|counters| &mut counters.estimates);
        if self.free.is_some() {
            unit.pending = Some(Pending { reading: *reading, estimate, cost });
            self.balance();
        } else {
            self.conclude(finger, reading, estimate, cost);
        }
    }

    /// An estimate is ready: the grip goes by it, and it is reported.
    pub(crate) fn conclude(&mut self, finger: usize, reading: &Reading, estimate: Estimate, cost: u32) {
        let seconds = self.seconds();
        let faults = Faults { reaction: self.on_fault(), ..self.settings.faults() };
        let Some(unit) = self.units.get_mut(finger) else {
            return;
        };
        let time_us = reading.at_us;
        // The age counts every tick since the last trustworthy estimate, those without a position too; and it is never less than
        // that of the position.
        unit.is_settled = estimate.age == 0;
        let age = if unit.is_settled { unit.repeats } else { unit.last.estimate.age.saturating_add(1) };
        let (position, current) = (reading.position, reading.current);
        unit.last = Report { time_us, position, current, cost, estimate: Estimate { age, ..estimate }, ..unit.last };
        if self.settings.role == Role::Master {
            unit.feel(reading, seconds, &faults);
            let told = unit.witness(reading, seconds);
            if let Some(angle) = told.touched {
                self.shared.tell(Event::Touched { finger: finger as u8, angle: angle as f32 });
            }
            if let Some(disagree) = told.disagree {
                let (finger, demanded) = (finger as u8, unit.last.estimate.torque);
                self.shared.tell(Event::TorquesDisagree { finger, disagree, demanded, current });
            }
        }
        self.publish(finger);
        if let Some(heard) = reading.heard_ticks {
            let latency = B::cost_ticks().wrapping_sub(heard);
            self.shared.count(|counters| {
                counters.latency = latency;
                counters.latency_most = counters.latency_most.max(latency);
            });
        }
        let every = u32::from(self.settings.shape_every);
        // In turn, so that the shapes of several fingers do not wait for one another.
        if every > 0
            && self.ticks.wrapping_add(finger as u32).is_multiple_of(every)
            && let Some(unit) = self.units.get(finger)
        {
            self.shared.show(|| Shape::of(unit.model.follower(), &unit.last));
        }
    }

    /// No position came in this period: the old numbers, marked as such.
    fn stale(&mut self, finger: usize) {
        let reaction = self.settings.on_fault;
        let Some(unit) = self.units.get_mut(finger) else {
            return;
        };
        unit.not_seen();
        let estimate = &mut unit.last.estimate;
        estimate.status = Status::Stale;
        estimate.age = estimate.age.saturating_add(1);
        estimate.iterations = 0;
        (unit.last.time_us, unit.last.cost) = (now_us(), 0);
        if let Some(mount) = &unit.mount {
            unit.grip.miss(&mount.limits(), reaction);
        }
        self.publish(finger);
    }

    pub(crate) fn publish(&mut self, finger: usize) {
        let Some(unit) = self.units.get_mut(finger) else {
            return;
        };
        self.sequence = self.sequence.wrapping_add(1);
        let phase = unit.grip.phase();
        let changed = unit.is_news(phase, now_us());
        unit.last = Report { sequence: self.sequence, phase, goal: unit.grip.goal() as f32, ..unit.last };
        unit.is_reported = true;
        self.shared.report(unit.last);
        if changed {
            self.shared.tell(Event::PhaseChanged { finger: finger as u8, phase });
        }
    }

    /// Ends a tick: fingers without a report are stale, and the grasp is summed up.
    pub(crate) fn finish(&mut self) {
        for finger in 0..self.units.len() {
            if self.units.get(finger).is_some_and(|unit| unit.mount.is_some() && !unit.is_done())
                && !self.repeat(finger)
            {
                self.stale(finger);
            }
        }
        self.leave_unbalanced();
        if self.settings.count() > 1 {
            let fingers = self.units.iter().filter_map(|unit| Some((&unit.last, unit.mount?.side)));
            let free = self.free.as_ref().map(Free::report);
            self.shared.grasp(Grasp { free, ..Grasp::of(fingers) });
        }
    }

    /// A finger's tick without an answer.
    fn failed(&mut self, finger: usize, error: &BusError<B::Bus>) {
        self.count::<B::Bus>(error);
        if self.units.get_mut(finger).is_some_and(|unit| unit.health.failed()) {
            self.shared.add(|counters| &mut counters.servo_losses);
            self.shared.tell(Event::ServoLost { finger: finger as u8, other_master: self.is_other_about() });
        }
    }

    pub(crate) fn count<U: BusPort>(&self, error: &BusError<U>) {
        use dynamixel::Error;
        self.shared.count(|counters| {
            let counter = match error {
                Error::Timeout { .. } | Error::Truncated { .. } => &mut counters.bus_timeouts,
                Error::Damaged(_) | Error::Babble { .. } | Error::Block { .. } => &mut counters.bus_damaged,
                Error::Refused { .. } => &mut counters.bus_refused,
                _ => &mut counters.bus_other,
            };
            *counter = counter.wrapping_add(1);
        });
    }

    fn found(&mut self, finger: usize, id: Id, found: &Found) {
        let Found { setup, firmware, baud, goal, .. } = *found;
        let model = setup.model;
        self.shared.set_servo(finger as u8, Some(setup));
        // Meanwhile the settings may have named another servo: that one is looked for next.
        let unit = self.units.get_mut(finger).filter(|unit| unit.id() == Some(id));
        if let Some(unit) = unit {
            unit.health = Health::READY;
            unit.difference = None;
            (unit.bounds, unit.watch) = (Some(found.bounds), StrainWatch::FREE);
            unit.grip.found(unit.calibration.angle(goal));
            if !unit.torque.is_on() {
                unit.relax();
            }
            self.shared.tell(Event::ServoReady { finger: finger as u8, model, firmware, baud });
        }
    }

    /// A servo that is not what it should be: reported once.
    fn differs(&mut self, finger: usize, found: &Found) {
        self.shared.set_servo(finger as u8, Some(found.setup));
        if let (Some(unit), Some(difference)) = (self.units.get_mut(finger), found.difference)
            && unit.difference.replace(difference) != Some(difference)
        {
            self.shared.tell(Event::ServoDiffers { finger: finger as u8, difference });
        }
    }

    /// A servo that is to be asked how warm it is, the fingers in turn.
    fn strained(&mut self) -> Option<(usize, Id)> {
        let now = Instant::now();
        if now < self.look {
            return None;
        }
        let present = |(_, unit): &(usize, &Unit<'_>)| unit.health.is_present() && unit.bounds.is_some();
        let fingers = self.units.iter().enumerate();
        let count = fingers.clone().filter(present).count().max(1);
        let (finger, unit) = fingers.clone().skip(self.next_looked).chain(fingers).find(present)?;
        let id = unit.id()?;
        self.look = now + LOOK / count as u32;
        self.next_looked = finger + 1;
        Some((finger, id))
    }

    /// A servo has said how warm it is and what supplies it.
    fn derate(&mut self, finger: usize, vitals: &Result<Vitals, BusError<B::Bus>>) {
        match vitals {
            Ok(vitals) => {
                let Some(unit) = self.units.get_mut(finger) else { return };
                let Some(bounds) = unit.bounds else { return };
                if let Some((derating, strain)) = unit.watch.see(*vitals, bounds, self.settings.margins()) {
                    let Vitals { temperature, voltage } = *vitals;
                    let volts = f32::from(voltage) * xm430::VOLTS_PER_UNIT;
                    self.shared.tell(Event::Derated { finger: finger as u8, derating, strain, temperature, volts });
                }
            }
            Err(error) => self.count::<B::Bus>(error),
        }
    }

    /// A servo whose hardware errors have changed.
    fn alerting(&self) -> Option<(usize, Id)> {
        let alerting = |(_, unit): &(usize, &Unit<'_>)| unit.health.is_present() && unit.alert_changed;
        let (finger, unit) = self.units.iter().enumerate().find(alerting)?;
        Some((finger, unit.id()?))
    }

    fn alerted(&mut self, finger: usize, status: &Result<u8, BusError<B::Bus>>) {
        let Ok(hardware_error) = *status else {
            if let Err(error) = status {
                self.count::<B::Bus>(error);
            }
            return;
        };
        if let Some(unit) = self.units.get_mut(finger) {
            unit.alert_changed = false;
            if hardware_error == 0 {
                // Only a restart clears an error, and it leaves the torque off: the servo is set up anew.
                unit.health = Health::Absent;
            }
        }
        self.shared.tell(Event::ServoAlert { finger: finger as u8, hardware_error });
    }
}
