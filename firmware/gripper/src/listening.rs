//! The roles tap and device: another master leads the servos. The gripper listens to what that master reads of them and
//! estimates from it; as a device it answers too, under an address of its own, what its control table says.
//!
//! The bus task hears and answers ([`hear`]), so that an answer waits for no estimate: the control table has the numbers of the last one, and
//! the age of their position. The control task estimates as soon as a position is heard, once per period at most ([`listen`]). In a period
//! without a new position the last estimate is reported again, with the time of its position and its age in ticks, as long as that is a tenth
//! of a second old at most; after that it is `stale`.
//!
//! A tap has nothing that writes to the bus.

use dynamixel::{Device, Heard, Id, Model, Reply, Seen, StatusReturn, Tap, Timing, Watched, xm430};
use embassy_futures::select::{Either, Either3, select, select3};
use embassy_time::{Instant, Timer};
use embedded_io_async::{Read, Write};
use grip::Health;
use heapless::Vec;
use messages::{Direction, Event, FINGERS, For, Object, Role, Settings};

use crate::board::{Board, BusPort};
use crate::bus::{Bus, Job};
use crate::device_table::{BusSettings, Change, DeviceTable, FingerSettings, FingerState};
use crate::servo::Reading;
use crate::setup::Key;
use crate::shared::{Command, Shared, now_us};
use crate::ticks::Core;
use crate::write::write_all;

/// Longest packet that is understood, bytes: an answer with 180 bytes of data.
const PACKET: usize = 256;
/// Bytes that are taken at once.
const CHUNK: usize = 64;
/// So many full chunks in a row are more than a packet: the bus says more than the processor can follow.
const LOUD: u32 = 8;
/// What the tasks below the bus task then get, µs; what is lost meanwhile counts as damaged.
const BREATH_US: u64 = 200;
/// The longest return delay that servos can be set to, µs.
const RETURN_DELAY_US: u32 = xm430::RETURN_DELAY_TIME.item.max as u32 * xm430::RETURN_DELAY_US_PER_UNIT;
/// Version of this program as the control table has it: ten times the major number, and the minor one.
const FIRMWARE: u8 = 10 * number(env!("CARGO_PKG_VERSION_MAJOR")) + number(env!("CARGO_PKG_VERSION_MINOR"));

const fn number(digits: &str) -> u8 {
    match u8::from_str_radix(digits, 10) {
        Ok(number) => number,
        Err(_) => 0,
    }
}

/// What the gripper makes of the bus while another master leads.
pub(crate) struct Ears {
    tap: Tap<PACKET, FINGERS>,
    /// Of a device.
    voice: Option<Voice>,
    role: Role,
    baud: u32,
    /// Each servo watched, and when the last byte of its position came, in ticks of the cost clock.
    heard: Vec<(Id, Option<u32>), FINGERS>,
}

/// What a device answers with.
struct Voice {
    device: Device<PACKET>,
    table: DeviceTable,
    /// When each finger's position was heard, µs.
    heard_us: [Option<u64>; FINGERS],
}

/// An answer, and how long after the question it is due, µs.
struct Said {
    bytes: Vec<u8, PACKET>,
    delay_us: u32,
}

impl Said {
    fn of(reply: &Reply<'_>) -> Self {
        // A reply lies in a buffer of that length.
        Self { bytes: Vec::from_slice(reply.bytes).unwrap_or_default(), delay_us: reply.delay_us }
    }
}

/// One period of a gripper that listens.
pub(crate) async fn listen<B: Board>(core: &mut Core<'_, B>, bus: &Bus<B::Bus>) {
    let [first, ..] = messages::BAUDS;
    let baud = core.hand.settings.baud.unwrap_or(first);
    let role = core.hand.settings.role;
    let is_open = bus.ears().await.as_ref().is_some_and(|ears| (ears.role, ears.baud) == (role, baud));
    if !is_open || core.orders.settings_changed {
        core.orders.settings_changed = false;
        core.pace(1_000_000 / u64::from(core.hand.settings.rate_hz.max(1)));
    }
    if !is_open {
        bus.give(Job::Rest);
        bus.line().await.servos.port_mut().set_baud(baud);
        Ears::open::<B>(&mut *bus.ears().await, &core.hand.settings, baud);
        core.orders.setup_is_new = true;
        bus.give(Job::Listen);
    }
    if core::mem::take(&mut core.orders.setup_is_new)
        && let Some(ears) = &mut *bus.ears().await
    {
        ears.follow(core);
    }
    while Instant::now() < core.scheduler.end {
        if let Either::First(()) = select(bus.heard(), Timer::at(core.scheduler.end)).await {
            take_in(core, bus).await;
        }
    }
    core.finish();
    show(core, bus).await;
    core.keep_next();
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
    while let Some(change) = change(bus).await {
        core.change(change);
    }
    for finger in 0..core.hand.units.len() {
        if let Some(sight) = sight(core, bus, finger).await
            && core.listen_to(finger, &sight)
        {
            show(core, bus).await;
        }
    }
}

/// What the master has changed, one thing at a time.
async fn change<U: BusPort>(bus: &Bus<U>) -> Option<Change> {
    bus.ears().await.as_mut()?.voice.as_mut()?.table.take()
}

/// What is known of a finger's servo.
async fn sight<B: Board>(core: &Core<'_, B>, bus: &Bus<B::Bus>, finger: usize) -> Option<Sight> {
    let id = core.hand.units.get(finger)?.id()?;
    let ears = bus.ears().await;
    let ears = ears.as_ref()?;
    let heard_ticks = ears.heard.iter().find(|(whose, _)| *whose == id).and_then(|(_, ticks)| *ticks);
    ears.tap.servo(id).map(|servo| Sight::of(servo, heard_ticks))
}

/// Shows in the control table what the fingers feel.
async fn show<B: Board>(core: &Core<'_, B>, bus: &Bus<B::Bus>) {
    if let Some(Ears { voice: Some(voice), .. }) = &mut *bus.ears().await {
        core.show(voice);
    }
}

/// The bus task of a gripper that listens: hears and answers until there is another job for it.
pub(crate) async fn hear<B: Board>(shared: &Shared, bus: &Bus<B::Bus>, port: &mut B::Bus) -> Job {
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
            say::<B>(shared, bus, port, &said).await;
        }
        bus.has_heard();
    }
}

async fn answer<U: BusPort>(bus: &Bus<U>, now: u64, rest: &mut &[u8]) -> Option<Said> {
    bus.ears().await.as_mut()?.voice.as_mut()?.answer(now, rest)
}

/// Sends an answer, and has the tap hear it like everybody else: a port does not hear itself.
async fn say<B: Board>(shared: &Shared, bus: &Bus<B::Bus>, port: &mut B::Bus, said: &Said) {
    let asking = shared.quiet.ask();
    if said.delay_us > 0 {
        // From the end of the question on.
        let ticks = port.heard_ticks().map_or(0, |heard| B::cost_ticks().wrapping_sub(heard));
        let passed_us = u64::from(ticks) * 1_000_000 / u64::from(B::COST_HZ.max(1));
        Timer::after_micros(u64::from(said.delay_us).saturating_sub(passed_us)).await;
    }
    if !(write_all(port, &said.bytes).await && port.flush().await.is_ok()) {
        shared.add(|counters| &mut counters.bus_other);
    }
    drop(asking);
    if let Some(ears) = &mut *bus.ears().await {
        ears.hear_own(&said.bytes);
    }
}

impl Ears {
    // What making them takes is on the stack in here only.
    #[inline(never)]
    fn open<B: Board>(ears: &mut Option<Self>, settings: &Settings, baud: u32) {
        *ears = Some(Self::new::<B>(settings, baud));
    }

    fn new<B: Board>(settings: &Settings, baud: u32) -> Self {
        let latency_us = B::BUS_LATENCY_US + RETURN_DELAY_US;
        let timing = Timing { baud_rate: baud, latency_us, status_return: StatusReturn::All };
        let voice = match settings.role {
            Role::Device { id, return_delay } => {
                let bus = BusSettings { id: Id::new(id).unwrap_or(Id::MAX), baud_rate: baud, return_delay };
                let table = DeviceTable::new(&bus, FIRMWARE, settings.count());
                Some(Voice { device: Device::new(timing), table, heard_us: [None; FINGERS] })
            }
            Role::Idle | Role::Master | Role::Tap => None,
        };
        Self { tap: Tap::new(timing), voice, role: settings.role, baud, heard: Vec::new() }
    }

    /// Takes what is set.
    #[inline(never)]
    fn follow<B: Board>(&mut self, core: &mut Core<'_, B>) {
        self.tap.forget();
        self.heard.clear();
        for unit in &mut core.hand.units {
            unit.heard_us = None;
            if let Some(id) = unit.id() {
                let commissioned = unit.mount.and_then(|mount| mount.servo).and_then(|servo| Model::of(servo.model));
                // There is room for as many as there are fingers.
                self.tap.watch_model(id, commissioned.unwrap_or(Model::ASSUMED));
                let _ = self.heard.push((id, None));
            }
        }
        let Some(voice) = &mut self.voice else {
            return;
        };
        let objects = core.hand.shared.setup(|setup| setup.objects);
        for (finger, (mount, object)) in core.hand.settings.fingers.iter().zip(&objects).enumerate() {
            if let Some(mount) = mount {
                let reversed = mount.direction == Direction::Reversed;
                let (servo_id, gear_ratio, zero) = (mount.servo_id, mount.gear_ratio, mount.zero);
                voice.table.set_finger(finger, &FingerSettings { servo_id, reversed, gear_ratio, zero });
            }
            voice.table.set_object(finger, object.as_ref().map(|object| &object.design));
        }
        core.show(voice);
    }

    /// When there may be something to say though nothing has come, µs.
    fn deadline(&self) -> Option<u64> {
        self.voice.as_ref()?.device.deadline()
    }

    /// Something was said on the bus, and heard at `now`, µs; its last byte came at `heard_ticks`.
    #[inline(never)]
    fn overhear(&mut self, shared: &Shared, now: u64, bytes: &[u8], heard_ticks: Option<u32>) {
        let mut rest = bytes;
        while let Some(heard) = self.tap.hear(now, &mut rest) {
            match heard {
                Heard::Damaged(_) => shared.add(|counters| &mut counters.bus_damaged),
                Heard::Refused { .. } => shared.add(|counters| &mut counters.bus_refused),
                _ => {}
            }
        }
        for (id, ticks) in &mut self.heard {
            if self.tap.servo(*id).and_then(|servo| servo.position).is_some_and(|seen| seen.at_us == now) {
                *ticks = heard_ticks;
            }
        }
    }

    /// What was said by the gripper itself.
    fn hear_own(&mut self, mut bytes: &[u8]) {
        while self.tap.hear(now_us(), &mut bytes).is_some() {}
    }
}

impl Voice {
    /// The next answer to what was heard at this time, µs; the bytes that it takes are taken off.
    #[inline(never)]
    fn answer(&mut self, now: u64, rest: &mut &[u8]) -> Option<Said> {
        let Self { device, table, heard_us } = self;
        for (finger, at_us) in heard_us.iter().enumerate() {
            table.show_age(finger, at_us.map(|at_us| age_us(at_us, now)));
        }
        if let Some(reply) = device.hear(now, rest, table) {
            return Some(Said::of(&reply));
        }
        device.poll(now_us(), table).map(|reply| Said::of(&reply))
    }
}

/// Time since then, µs; less than what stands for no time.
fn age_us(at_us: u64, now_us: u64) -> u32 {
    u32::try_from(now_us.saturating_sub(at_us)).unwrap_or(u32::MAX - 1)
}

/// What the control task wants to know of a servo.
struct Sight {
    model: &'static Model,
    position: Option<Seen<i32>>,
    effort: Option<Seen<i16>>,
    goal: Option<Seen<i32>>,
    hardware_error: Option<Seen<u8>>,
    alert: bool,
    heard_ticks: Option<u32>,
}

impl Sight {
    fn of(servo: &Watched, heard_ticks: Option<u32>) -> Self {
        let &Watched { model, position, effort, goal, hardware_error, alert, .. } = servo;
        Self { model, position, effort, goal, hardware_error, alert, heard_ticks }
    }
}

impl<B: Board> Core<'_, B> {
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
            Change::Bus(BusSettings { id, baud_rate, return_delay }) => {
                settings.role = Role::Device { id: id.get(), return_delay };
                settings.baud = Some(baud_rate);
                (Command::Settings(settings), Key::Settings)
            }
            Change::Finger(finger, FingerSettings { servo_id, reversed, gear_ratio, zero }) => {
                let direction = if reversed { Direction::Reversed } else { Direction::Same };
                if let Some(Some(mount)) = settings.fingers.get_mut(finger) {
                    *mount = messages::Mount { servo_id, direction, gear_ratio, zero, ..*mount };
                }
                (Command::Settings(settings), Key::Settings)
            }
            Change::Object(finger, design) => {
                let object = self.hand.shared.setup(|setup| setup.objects.get(finger).copied().flatten());
                // The table has no register for friction: it stays.
                let what = Object { design, friction: object.map_or(0.0, |object| object.friction) };
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

    /// Has one thing that the master has set written to flash; restarts, if it wants that, when all of them are.
    fn keep_next(&mut self) {
        if let Some(&key) = self.unkept.first() {
            if self.hand.shared.keep_soon(key) {
                self.unkept.remove(0);
            }
        } else if self.restart && self.hand.shared.is_all_kept() {
            B::restart("");
        }
    }
}
