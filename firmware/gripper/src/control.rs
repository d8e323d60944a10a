//! The control task: one report per period, whatever the bus does.
//!
//! A tick leads the servo (Goal Position), reads where it is, and estimates the force there. When no answer has come by
//! the period's end, the report says so (`stale`, with its age) and the wait goes on until the bus' own deadline.

use core::future::Future;
use core::pin::pin;

use dynamixel::Id;
use embassy_futures::select::{Either, select};
use embassy_futures::yield_now;
use embassy_time::{Duration, Instant, Timer};
use messages::{CloseTo, Event, Outcome, Refusal, Report, Settings, SettingsField};
use model_core::estimator::Estimate;
use model_core::status::Status;

use crate::Model;
use crate::board::{Board, BusPort, Watchdog};
use crate::calibration::Calibration;
use crate::health::Health;
use crate::motion::Motion;
use crate::rate::Meter;
use crate::servo::{BusError, Reading, Servo};
use crate::shape::shape;
use crate::shared::{Command, Order, Shared, now_us};

/// Runs the gripper for ever.
pub async fn control<B: Board>(shared: &Shared, models: &mut [Model], bus: B::Bus, mut watchdog: B::Watchdog) -> ! {
    let Some((model, _)) = models.split_first_mut() else {
        // Without a model there is nothing to control; the watchdog goes on being fed for the link's sake.
        loop {
            watchdog.feed();
            Timer::after_millis(100).await;
        }
    };
    let mut servo = Servo::new(bus, B::BUS_LATENCY_US);
    let mut core = Core::<B>::new(shared, model);
    let mut bauds = B::BAUDS.iter().copied().cycle();
    let mut baud = None;
    loop {
        core.begin().await;
        watchdog.feed();
        if core.health.is_present() {
            let goal = core.step();
            match core.patiently(servo.tick(goal)).await {
                Ok(reading) => core.fresh(reading),
                Err(error) => core.failed(&error),
            }
            if core.alert_changed {
                let status = core.patiently(servo.hardware_error()).await;
                core.alerted(&status);
            }
        } else {
            let rate = baud.or_else(|| bauds.next()).unwrap_or(1_000_000);
            let id = core.id();
            let found = core.patiently(servo.bring_up(id, rate)).await;
            // Found once, the servo is looked for at its rate first, then at the others.
            baud = None;
            match found {
                Ok(found) => {
                    baud = Some(rate);
                    // Meanwhile the settings may have named another servo: that one is looked for next.
                    if core.id() == id {
                        core.found(&found, servo.period_us(core.settings.rate_hz));
                    }
                }
                Err(error) => core.count::<B::Bus>(&error),
            }
            core.stale();
        }
        if core.settings_changed {
            core.settings_changed = false;
            core.pace(servo.period_us(core.settings.rate_hz));
        }
    }
}

/// Everything but the bus.
struct Core<'a, B> {
    shared: &'a Shared,
    model: &'a mut Model,
    settings: Settings,
    calibration: Calibration,
    motion: Motion,
    health: Health,
    period: Duration,
    /// When the present period ends.
    end: Instant,
    meter: Meter,
    last: Report,
    alert: bool,
    alert_changed: bool,
    settings_changed: bool,
    board: core::marker::PhantomData<B>,
}

const NO_REPORT: Report = Report {
    sequence: 0,
    time_us: 0,
    estimate: Estimate::blank(Status::Stale),
    goal: 0.0,
    position: 0,
    current: 0.0,
    cost: 0,
};

impl<'a, B: Board> Core<'a, B> {
    fn new(shared: &'a Shared, model: &'a mut Model) -> Self {
        let settings = shared.setup(|setup| setup.settings);
        let period = Duration::from_micros(1_000_000 / u64::from(settings.rate_hz.max(1)));
        let now = Instant::now();
        Self {
            shared,
            model,
            settings,
            calibration: Calibration::new(&settings),
            motion: Motion::REST,
            health: Health::Absent,
            period,
            end: now,
            meter: Meter::new(now.as_micros()),
            last: NO_REPORT,
            alert: false,
            alert_changed: false,
            settings_changed: false,
            board: core::marker::PhantomData,
        }
    }

    fn id(&self) -> Id {
        Id::new(self.settings.servo_id).unwrap_or(Id::BROADCAST)
    }

    fn chosen_hz(&self) -> f32 {
        1e6 / self.period.as_micros() as f32
    }

    fn pace(&mut self, period_us: u64) {
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
            // Never all of the processor: the link has to live too.
            yield_now().await;
        }
        self.advance();
        self.obey();
    }

    /// Begins a period where the last one ended, or now if that is more than a period ago.
    fn advance(&mut self) {
        let now = Instant::now();
        let late = now.saturating_duration_since(self.end);
        if late * 2 > self.period {
            self.shared.add(|counters| &mut counters.late_ticks);
        }
        self.end = if late > self.period { now } else { self.end } + self.period;
        let chosen = self.chosen_hz();
        if let Some(second) = self.meter.tick(now.as_micros(), chosen) {
            self.shared.count(|counters| counters.rate_hz = second.hz);
            if second.turned {
                self.shared.tell(Event::RateReached { hz: second.hz, chosen_hz: chosen });
            }
        }
    }

    /// Waits for the bus; periods that pass meanwhile are reported as stale.
    async fn patiently<F: Future>(&mut self, transaction: F) -> F::Output {
        let mut transaction = pin!(transaction);
        loop {
            match select(transaction.as_mut(), Timer::at(self.end)).await {
                Either::First(output) => return output,
                Either::Second(()) => {
                    self.stale();
                    self.advance();
                    self.obey();
                }
            }
        }
    }

    /// Advances the motion by a tick; gives the goal in counts.
    fn step(&mut self) -> i32 {
        let seconds = self.period.as_micros() as f64 * 1e-6;
        self.calibration.position(self.motion.step(seconds))
    }

    /// A position came: estimates and reports.
    fn fresh(&mut self, reading: Reading) {
        self.health.answered();
        let Reading { position, current, alert, refused } = reading;
        self.alert_changed |= alert != self.alert;
        self.alert = alert;
        if let Some((position, error)) = refused {
            self.shared.add(|counters| &mut counters.bus_refused);
            self.shared.tell(Event::GoalRefused { position, error: error.code() });
        }
        let time_us = now_us();
        let start = B::cost_ticks();
        let estimate = self.model.update(self.calibration.angle(position));
        let cost = B::cost_ticks().wrapping_sub(start);
        // The age counts every tick since the last trustworthy estimate, those without a position too.
        let age = if estimate.age == 0 { 0 } else { self.last.estimate.age.saturating_add(1) };
        self.last.estimate = Estimate { age, ..estimate };
        self.shared.add(|counters| &mut counters.estimates);
        self.publish(Report { time_us, position, current, cost, ..self.last });
        let every = u32::from(self.settings.shape_every);
        if every > 0 && self.last.sequence.is_multiple_of(every) {
            let (follower, sequence) = (self.model.follower(), self.last.sequence);
            self.shared.show(|| shape(follower, sequence, estimate.status));
        }
    }

    /// No position came in this period: the old numbers, marked as such.
    fn stale(&mut self) {
        let mut estimate = self.last.estimate;
        estimate.status = Status::Stale;
        estimate.age = estimate.age.saturating_add(1);
        estimate.iterations = 0;
        self.publish(Report { time_us: now_us(), estimate, cost: 0, ..self.last });
    }

    fn publish(&mut self, report: Report) {
        let sequence = self.last.sequence.wrapping_add(1);
        self.last = Report { sequence, goal: self.motion.goal() as f32, ..report };
        self.shared.report(self.last);
        self.shared.add(|counters| &mut counters.ticks);
    }

    /// A tick without an answer.
    fn failed(&mut self, error: &BusError<B::Bus>) {
        self.count::<B::Bus>(error);
        if self.health.failed() {
            self.shared.add(|counters| &mut counters.servo_losses);
            self.shared.tell(Event::ServoLost);
        }
        self.stale();
    }

    fn count<U: BusPort>(&self, error: &BusError<U>) {
        use dynamixel::Error;
        self.shared.count(|counters| {
            let counter = match error {
                Error::Timeout { .. } | Error::Truncated { .. } => &mut counters.bus_timeouts,
                Error::Damaged(_) | Error::Babble { .. } => &mut counters.bus_damaged,
                Error::Refused { .. } => &mut counters.bus_refused,
                _ => &mut counters.bus_other,
            };
            *counter = counter.wrapping_add(1);
        });
    }

    fn found(&mut self, found: &crate::servo::Found, period_us: u64) {
        let crate::servo::Found { model, firmware, baud, position } = *found;
        self.health = Health::READY;
        self.motion.start(self.calibration.angle(position));
        self.shared.tell(Event::ServoReady { model, firmware, baud });
        self.pace(period_us);
    }

    fn alerted(&mut self, status: &Result<u8, BusError<B::Bus>>) {
        match status {
            Ok(hardware_error) => {
                self.alert_changed = false;
                self.shared.tell(Event::ServoAlert { hardware_error: *hardware_error });
                if *hardware_error == 0 {
                    // Only a restart clears an error, and it leaves the torque off: the servo is set up anew.
                    self.health = Health::Absent;
                }
            }
            Err(error) => self.count::<B::Bus>(error),
        }
    }

    /// Obeys one order, if there is one.
    fn obey(&mut self) {
        if let Ok(Order { ticket, command }) = self.shared.orders.try_receive() {
            let outcome = self.execute(command);
            self.shared.outcome.signal((ticket, outcome));
        }
    }

    fn execute(&mut self, command: Command) -> Outcome {
        match command {
            Command::Finger(finger) => {
                let start = B::cost_ticks();
                let made = self.model.configure(&finger.design, &finger.how);
                let cost = B::cost_ticks().wrapping_sub(start);
                let refusal = made.map_err(|error| Refusal::Finger(Refusal::text(&error)));
                self.shared.set(|setup| setup.finger = refusal.is_ok().then_some(finger));
                if refusal.is_ok() {
                    self.shared.tell(Event::ModelReady { cost });
                }
                refusal
            }
            Command::Object(object) => {
                self.model.set_object(object).map_err(|error| Refusal::Object(Refusal::text(&error)))?;
                self.shared.set(|setup| setup.object = Some(object));
                Ok(())
            }
            Command::Settings(settings) => {
                settings.validate()?;
                if settings.servo_id != self.settings.servo_id {
                    self.health = Health::Absent;
                }
                let at = self.calibration.position(self.motion.goal());
                self.settings = settings;
                self.calibration = Calibration::new(&settings);
                // The motor stays where it is, at the angle it now is called.
                self.motion.hold();
                self.motion.start(self.calibration.angle(at));
                self.settings_changed = true;
                self.shared.set(|setup| setup.settings = settings);
                Ok(())
            }
            Command::Open => self.head(self.settings.open_angle, self.settings.speed),
            Command::Close(CloseTo { angle, speed }) => self.head(angle, speed.unwrap_or(self.settings.speed)),
        }
    }

    fn head(&mut self, angle: f32, speed: f32) -> Outcome {
        let Settings { range: [least, most], .. } = self.settings;
        for (field, value, min, max) in
            [(SettingsField::Angle, angle, least, most), (SettingsField::Speed, speed, 1e-3, 20.0)]
        {
            if !(min..=max).contains(&value) {
                return Err(Refusal::Setting { field, value, min, max });
            }
        }
        if !self.health.is_present() {
            return Err(Refusal::NoServo);
        }
        self.motion.head(f64::from(angle), f64::from(speed));
        Ok(())
    }
}
