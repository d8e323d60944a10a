//! The loop that reads the servos and estimates: one report per finger and period, as the gripper's.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use dynamixel::{Master, Model, SyncAnswer, name_of, xm430};
use messages::{
    Event, FINGERS, Grasp, Notice, Object, Outcome, PROTOCOL_VERSION, Refusal, Settings, SettingsField, Support, Which,
};

use super::address::BusAddress;
use super::error::BusError;
use super::fingers::{BYTES, FIRST, Finger, Reading};
use super::options::BusOptions;
use super::port::{Fault, Line};
use super::search::{AskError, Asker, latency_timer_ms, search, timing};
use super::shared::{Asked, Shared};
use crate::estimator::{AnyEstimator, estimator};
use crate::link::Port;
use crate::source::{GripMargin, Listeners, Margins, Modelled, Order, OrderError, Origin, Setup, Told};

/// What is allowed beyond the wire time: as at first, for a tick that is lost is reported.
const LATENCY_US: u32 = 40_000;
/// Ticks after a failure in which every servo is asked by itself: behind a silent one, a common question leaves the others
/// silent too.
const APART: u8 = 8;
/// How often a servo that is lost is asked: each time costs the others a wait.
const SEARCH: Duration = Duration::from_millis(500);
/// How often a servo is asked to switch its torque off until it has done it.
const RELAXING: u8 = 5;
/// Costs are given in µs.
const COST_HZ: u32 = 1_000_000;
/// A rate below this share of what is wanted is reported.
const SLOW: f32 = 0.95;

pub(super) struct Ticks {
    line: Line,
    master: Asker,
    shared: Arc<Shared>,
    fingers: Vec<Finger>,
    settings: Settings,
    /// All servos know Fast Sync Read.
    reads_fast: bool,
    apart: u8,
    searched: Instant,
    start: Instant,
    sequence: u32,
    ticks: u64,
    /// What the grip bears, from the shapes, and at which tick that was found.
    margins: Margins,
    margin: Option<(GripMargin, u64)>,
    /// When the present second began, its ticks, and whether the last one was slow.
    second: (Instant, u32, bool),
    notes: Vec<String>,
}

impl Ticks {
    pub(super) fn open(address: &BusAddress, options: &BusOptions) -> Result<Self, BusError> {
        let port =
            Port::connect(&address.port).map_err(|source| BusError::Open { address: address.to_string(), source })?;
        let line = Line::new(port);
        let mut master: Asker = Master::new(line.clone(), line.clock(), timing(1_000_000, LATENCY_US));
        let mut settings = options.settings;
        let wanted: Vec<u8> = settings.fingers.iter().flatten().map(|mount| mount.servo_id).collect();
        let census = search(&line, &mut master, address, options.names_servos.then_some(&wanted))?;
        let baud = census.baud;
        if !options.names_servos {
            let found: Vec<u8> = census.servos.iter().map(|servo| servo.id.get()).collect();
            if found.len() > FINGERS {
                return Err(BusError::Many { address: address.to_string(), most: FINGERS, found });
            }
            let first = settings.fingers[0].unwrap_or_default();
            for (number, place) in settings.fingers.iter_mut().enumerate() {
                let mount = place.unwrap_or(first);
                *place = found.get(number).map(|id| messages::Mount { servo_id: *id, ..mount });
            }
        }
        settings.validate(FINGERS)?;
        master.set_timing(timing(baud, LATENCY_US));
        let mut ticks = Self {
            line,
            master,
            shared: shared(address, baud, settings, options),
            fingers: Vec::new(),
            settings,
            reads_fast: census.servos.iter().all(|servo| servo.identity.reads_fast()),
            apart: 0,
            searched: Instant::now(),
            start: Instant::now(),
            sequence: 0,
            ticks: 0,
            margins: Margins::default(),
            margin: None,
            second: (Instant::now(), 0, false),
            notes: Vec::new(),
        };
        if let Some(ms @ 2..) = latency_timer_ms(&address.port) {
            ticks.notes.push(format!(
                "the adapter keeps bytes back for up to {ms} ms, which allows {} Hz or less: echo 1 | sudo tee \
                 /sys/bus/usb-serial/devices/PORT/latency_timer",
                1000 / ms
            ));
        }
        let models = ticks.shared.setup().models.clone();
        ticks.margins = Margins::new(&ticks.shared.setup());
        let mounts: Vec<messages::Mount> = settings.fingers.into_iter().flatten().collect();
        for (number, (mount, model)) in mounts.into_iter().zip(models).enumerate() {
            let number = number as u8;
            let estimator = made(&model, options)?;
            ticks.fingers.push(Finger::new(number, mount, estimator, model.uncertainty)?);
            let servo = census.servos.iter().find(|servo| servo.id.get() == mount.servo_id);
            if let Some(servo) = servo {
                ticks.look_at(address, number, servo.id, servo.identity, baud)?;
            }
        }
        let hz = f32::from(settings.rate_hz);
        ticks.greet(Event::Rate { hz, wanted_hz: hz });
        Ok(ticks)
    }

    /// Reports to whoever listens from now on.
    fn greet(&self, event: Event) {
        self.shared.listeners.greet(Told::Event(Notice { time_us: 0, event }));
    }

    /// Looks at a servo that was found: whether its registers are those that are read, and what makes it slow.
    fn look_at(
        &mut self,
        address: &BusAddress,
        finger: u8,
        id: dynamixel::Id,
        identity: dynamixel::Identity,
        baud: u32,
    ) -> Result<(), BusError> {
        let model = identity.model;
        // The X series' numbers (ROBOTIS e-Manual); others have other registers.
        if !(1000..=1350).contains(&model) {
            return Err(BusError::Model { address: address.to_string(), id: id.get(), model });
        }
        self.is_a(usize::from(finger), model);
        if Model::of(model).is_none() {
            self.notes.push(format!(
                "servo {} is {}: in which unit it shows its current is not known, it is read as the {}'s",
                id.get(),
                name_of(model).map_or_else(|| format!("of the unknown model {model}"), |name| format!("a {name}")),
                Model::ASSUMED.name
            ));
        }
        let delay = self.line.run(self.master.get(id, xm430::RETURN_DELAY_TIME));
        let delay_us = delay.map_or(0, |answer| u32::from(answer.value) * xm430::RETURN_DELAY_US_PER_UNIT);
        if delay_us > 100 {
            self.notes.push(format!(
                "servo {} waits {delay_us} µs with every answer (its Return Delay Time; 0 is best, set by ROBOTIS' Wizard)",
                id.get()
            ));
        }
        if baud < 1_000_000 {
            self.notes.push(format!("the bus runs at {baud} baud; 500 Hz needs 1,000,000 (the servo's Baud Rate)"));
        }
        self.greet(Event::ServoReady { finger, model, firmware: identity.firmware, baud });
        Ok(())
    }

    /// A finger's servo has this model number.
    fn is_a(&mut self, finger: usize, model: u16) {
        if let Some(finger) = self.fingers.get_mut(finger) {
            finger.model = Model::of(model).unwrap_or(Model::ASSUMED);
        }
    }

    pub(super) fn shared(&self) -> Arc<Shared> {
        self.shared.clone()
    }

    pub(super) fn take_notes(&mut self) -> Vec<String> {
        let mut notes = std::mem::take(&mut self.notes);
        notes.dedup();
        notes
    }

    /// Runs until nobody wants it any more, or the port is gone.
    pub(super) fn run(mut self, asked: &Receiver<Asked>) {
        let mut next = Instant::now();
        self.second.0 = next;
        while !self.shared.stop.load(Ordering::Acquire) {
            self.obey(asked);
            let now = Instant::now();
            let period = Duration::from_secs(1) / u32::from(self.settings.rate_hz.max(1));
            match next.checked_duration_since(now) {
                Some(early) => std::thread::sleep(early),
                None if now - next > period => next = now,
                None => {}
            }
            next += period;
            if self.tick().is_err() {
                break;
            }
            self.measure();
        }
        self.shared.closed.store(true, Ordering::Release);
        self.shared.listeners.close();
    }

    fn tick(&mut self) -> Result<(), AskError> {
        self.ticks += 1;
        let readings = self.read()?;
        let mut alerts = Vec::new();
        for (number, reading) in readings.into_iter().enumerate() {
            let finger = &mut self.fingers[number];
            let change = match &reading {
                Some(reading) => finger.fresh(reading, self.start).then_some(true),
                None => finger.stale(self.start).then_some(false),
            };
            if let Some(reading) = reading.filter(|reading| reading.alert != finger.alert) {
                finger.alert = reading.alert;
                alerts.push(number);
            }
            self.sequence = self.sequence.wrapping_add(1);
            finger.last.sequence = self.sequence;
            let report = finger.last;
            let every = u64::from(self.settings.shape_every);
            let shape = (reading.is_some() && every > 0 && (self.ticks + number as u64).is_multiple_of(every))
                .then(|| Told::Shape(Box::new(finger.estimator.shape(&report))));
            self.shared.tell(&Told::Report(report));
            if let Some(shape) = shape {
                if let Some(margin) = self.margins.take(&shape) {
                    self.margin = Some((margin, self.ticks));
                }
                self.shared.tell(&shape);
            }
            match change {
                Some(false) => self.event(Event::ServoLost { finger: number as u8, other_master: false }),
                Some(true) => self.found_again(number)?,
                None => {}
            }
        }
        if self.fingers.len() > 1 {
            let fingers = self.fingers.iter().map(|finger| (&finger.last, finger.mount.side));
            let grasp = Grasp::of(fingers);
            self.margin = self.margin.take().filter(|_| grasp.is_trustworthy);
            let margin = self.margin.as_ref().map(|(margin, then)| margin.of_age(self.ticks - then));
            self.shared.tell(&Told::Grasp(Grasp { margin, ..grasp }));
        }
        for number in alerts {
            let status = self.line.run(self.master.get(self.fingers[number].id(), xm430::HARDWARE_ERROR_STATUS));
            match serious(status)? {
                Some(answer) => {
                    self.event(Event::ServoAlert { finger: number as u8, hardware_error: answer.value });
                }
                // Asked again with the next answer.
                None => self.fingers[number].alert = !self.fingers[number].alert,
            }
        }
        Ok(())
    }

    fn found_again(&mut self, number: usize) -> Result<(), AskError> {
        let baud = self.master.timing().baud_rate;
        if let Some(answer) = serious(self.line.run(self.master.ping(self.fingers[number].id())))? {
            let dynamixel::Identity { model, firmware } = answer.value;
            self.is_a(number, model);
            self.event(Event::ServoReady { finger: number as u8, model, firmware, baud });
        }
        Ok(())
    }

    /// What the servos say, one entry per finger.
    fn read(&mut self) -> Result<Vec<Option<Reading>>, AskError> {
        let searching = self.searched.elapsed() > SEARCH;
        if searching {
            self.searched = Instant::now();
        }
        let is_asked: Vec<bool> = self.fingers.iter().map(|finger| finger.is_present() || searching).collect();
        let together = self.apart == 0 && self.fingers.iter().all(Finger::is_present);
        self.apart = self.apart.saturating_sub(1);
        let mut readings = vec![None; self.fingers.len()];
        let mut failed = false;
        if together && (self.reads_fast || self.fingers.len() > 1) {
            let mut answers: Vec<SyncAnswer<Fault, BYTES>> =
                self.fingers.iter().map(|finger| SyncAnswer::new(finger.id())).collect();
            let asked = if self.reads_fast {
                self.line.run(self.master.fast_sync_read(FIRST, &mut answers))
            } else {
                self.line.run(self.master.sync_read(FIRST, &mut answers))
            };
            failed |= serious(asked)?.is_none();
            for ((place, answer), finger) in readings.iter_mut().zip(answers).zip(&self.fingers) {
                if let Some(result) = answer.result {
                    *place = self.heard(result)?.map(|answer| Reading::new(&answer.value, answer.alert, finger.model));
                }
                failed |= place.is_none();
            }
        } else {
            for (number, place) in readings.iter_mut().enumerate() {
                if is_asked[number] {
                    let mut bytes = [0; BYTES];
                    let result = self.line.run(self.master.read(self.fingers[number].id(), FIRST, &mut bytes));
                    let model = self.fingers[number].model;
                    *place = self.heard(result)?.map(|answer| Reading::new(&bytes, answer.alert, model));
                    failed |= place.is_none();
                }
            }
        }
        if failed {
            self.apart = APART;
        }
        Ok(readings)
    }

    /// Counts an answer.
    fn heard<X>(&self, result: Result<X, AskError>) -> Result<Option<X>, AskError> {
        let counter = match &result {
            Ok(_) => &self.shared.frames,
            Err(_) => &self.shared.damaged,
        };
        counter.fetch_add(1, Ordering::Relaxed);
        serious(result)
    }

    fn event(&self, event: Event) {
        self.shared.tell(&Told::Event(Notice { time_us: self.start.elapsed().as_micros() as u64, event }));
    }

    /// Reports when the rate is not kept, and when it is again.
    fn measure(&mut self) {
        let (began, count, was_slow) = &mut self.second;
        *count += 1;
        let seconds = began.elapsed().as_secs_f32();
        if seconds < 1.0 {
            return;
        }
        let (hz, chosen_hz) = (*count as f32 / seconds, f32::from(self.settings.rate_hz));
        let is_slow = hz < SLOW * chosen_hz;
        let told = is_slow != *was_slow;
        self.second = (Instant::now(), 0, is_slow);
        if told {
            self.event(Event::RateReached { hz, chosen_hz });
        }
    }

    /// Obeys one order, if there is one.
    fn obey(&mut self, asked: &Receiver<Asked>) {
        if let Ok(Asked { order, outcome }) = asked.try_recv() {
            let done = self.execute(&order);
            if done.is_ok() && !matches!(order, Order::Relax(_)) {
                let setup = self.shared.setup().clone();
                (self.margins, self.margin) = (Margins::new(&setup), None);
                self.shared.tell(&Told::Setup(Box::new(setup)));
            }
            // Who asked may have given up.
            let _ = outcome.send(done);
        }
    }

    fn execute(&mut self, order: &Order) -> Result<(), OrderError> {
        match order {
            Order::Relax(which) => return self.relax(*which),
            Order::Object(number, object) => {
                let index = self.finger(*number)?;
                place(self.fingers[index].estimator.as_mut(), *object)?;
                self.shared.setup().models[index].grasp(Some(*object));
            }
            Order::Finger(number, finger) => {
                let index = self.finger(*number)?;
                let made = configure(self.fingers[index].estimator.as_mut(), finger);
                self.shared.setup().models[index].finger = made.is_ok().then(|| (**finger).clone());
                made?;
            }
            Order::Settings(settings) => {
                settings.validate(FINGERS)?;
                if settings.support != Support::Fixed {
                    let why = Refusal::text(&"a free object: the gripper's firmware finds its place");
                    return Err(Refusal::Object(why).into());
                }
                // Fingers are not added while it runs.
                let count = self.fingers.len() as f32;
                SettingsField::Fingers.check(settings.count() as f32, count, count)?;
                for (finger, mount) in self.fingers.iter_mut().zip(settings.fingers.into_iter().flatten()) {
                    finger.set_mount(mount)?;
                }
                self.settings = *settings;
                self.shared.setup().settings = *settings;
            }
            // Refused before they come here.
            Order::Open(_) | Order::Close(_) | Order::Grip(_) | Order::Hold(_) => {
                return Err(Refusal::NoServo.into());
            }
        }
        Ok(())
    }

    /// Switches torque off, whatever becomes of other fingers. A servo that answers reads only is asked what became of the write.
    fn relax(&mut self, which: Which) -> Result<(), OrderError> {
        let numbers = match which {
            Which::All => (0..).take(self.fingers.len()).collect(),
            Which::One(number) => {
                self.finger(number)?;
                vec![number]
            }
        };
        let silent: Vec<u8> = numbers.into_iter().filter(|number| !self.is_relaxed(usize::from(*number))).collect();
        if silent.is_empty() { Ok(()) } else { Err(OrderError::Silent(silent)) }
    }

    fn is_relaxed(&mut self, number: usize) -> bool {
        let id = self.fingers[number].id();
        (0..RELAXING).any(|_| {
            let _ = self.line.run(self.master.set(id, xm430::TORQUE_ENABLE, 0));
            self.line.run(self.master.get(id, xm430::TORQUE_ENABLE)).is_ok_and(|answer| answer.value == 0)
        })
    }

    fn finger(&self, number: u8) -> Result<usize, Refusal> {
        let last = self.fingers.len().saturating_sub(1) as f32;
        SettingsField::Finger.check(f32::from(number), 0.0, last)?;
        Ok(usize::from(number))
    }
}

/// An answer, or none; an error only if the port itself is gone.
fn serious<X>(result: Result<X, AskError>) -> Result<Option<X>, AskError> {
    match result {
        Ok(answer) => Ok(Some(answer)),
        Err(error @ (AskError::Port(_) | AskError::Closed)) => Err(error),
        Err(_) => Ok(None),
    }
}

fn shared(address: &BusAddress, baud: u32, settings: Settings, options: &BusOptions) -> Arc<Shared> {
    let model = |number: usize| options.models.get(number).or(options.models.last()).cloned().unwrap_or_default();
    let setup = Setup {
        origin: Origin::Bus,
        place: format!("{address} at {baud} baud"),
        board: "this PC".to_owned(),
        firmware: env!("CARGO_PKG_VERSION").to_owned(),
        protocol: PROTOCOL_VERSION,
        cost_hz: COST_HZ,
        settings,
        models: (0..settings.count()).map(model).collect(),
    };
    Arc::new(Shared {
        listeners: Listeners::default(),
        setup: setup.into(),
        frames: AtomicU64::new(0),
        damaged: AtomicU64::new(0),
        unheard: AtomicU64::new(0),
        stop: AtomicBool::new(false),
        closed: AtomicBool::new(false),
    })
}

/// A finger's estimator.
fn made(model: &Modelled, options: &BusOptions) -> Result<Box<dyn AnyEstimator>, Refusal> {
    let mut made = estimator(options.precision, options.hessian);
    if let Some(finger) = &model.finger {
        configure(made.as_mut(), finger)?;
    }
    if let Some(object) = model.grasped() {
        place(made.as_mut(), object)?;
    }
    Ok(made)
}

/// Takes a finger.
fn configure(estimator: &mut dyn AnyEstimator, finger: &messages::Finger) -> Outcome {
    estimator.set_prony(&finger.terms()).map_err(|error| Refusal::Finger(Refusal::text(&error)))?;
    estimator.configure(&finger.design, &finger.how).map_err(|error| Refusal::Finger(Refusal::text(&error)))
}

/// Takes an object; what is wrong with it changes nothing.
fn place(estimator: &mut dyn AnyEstimator, object: Object) -> Outcome {
    object.design.validate().map_err(|error| Refusal::Object(Refusal::text(&error)))?;
    estimator.set_friction(object.friction).map_err(|error| Refusal::Object(Refusal::text(&error)))?;
    estimator.set_object(object.design).map_err(|error| Refusal::Object(Refusal::text(&error)))
}
