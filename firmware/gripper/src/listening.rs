//! The roles tap and device: another master leads the servos. The gripper listens to what that master reads of them and
//! estimates from it; as a device it answers too, under an address of its own, what its control table says.
//!
//! A finger's estimate is made as soon as a position is heard, once per period at most. In a period without a new position
//! the last estimate is reported again, with the time of its position and its age in ticks, as long as that is a tenth of a second old at
//! most; after that it is `stale`.
//!
//! A tap has nothing that writes to the bus.

use dynamixel::{Device, Heard, Id, Model, Reply, Seen, StatusReturn, Tap, Timing, Watched, xm430};
use embassy_futures::select::{Either, select};
use embassy_time::{Instant, Timer};
use embedded_io_async::{Read, Write};
use grip::Health;
use messages::{Direction, Event, FINGERS, For, Object, Role, Settings};

use crate::board::{Board, BusPort};
use crate::device_table::{BusSettings, Change, DeviceTable, FingerSettings, FingerState};
use crate::servo::Reading;
use crate::setup::Key;
use crate::shared::{Command, now_us};
use crate::ticks::Core;
use crate::write::write_all;

/// Longest packet that is understood, bytes: an answer with 180 bytes of data.
const PACKET: usize = 256;
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
}

/// What a device answers with.
struct Voice {
    device: Device<PACKET>,
    table: DeviceTable,
}

/// One period of a gripper that listens.
pub(crate) async fn listen<B: Board>(core: &mut Core<'_, B>, bus: &mut B::Bus, ears: &mut Option<Ears>) {
    let [first, ..] = messages::BAUDS;
    let baud = core.hand.settings.baud.unwrap_or(first);
    let is_open = ears.as_ref().is_some_and(|ears| (ears.role, ears.baud) == (core.hand.settings.role, baud));
    if !is_open || core.orders.settings_changed {
        core.orders.settings_changed = false;
        core.pace(1_000_000 / u64::from(core.hand.settings.rate_hz.max(1)));
    }
    let ears = match ears {
        Some(ears) if is_open => ears,
        _ => {
            bus.set_baud(baud);
            core.orders.setup_is_new = true;
            Ears::open::<B>(ears, &core.hand.settings, baud)
        }
    };
    if core::mem::take(&mut core.orders.setup_is_new) {
        ears.follow(core);
    }
    let mut chunk = [0; 64];
    while Instant::now() < core.scheduler.end {
        let due =
            ears.deadline().map_or(core.scheduler.end, |due_us| core.scheduler.end.min(Instant::from_micros(due_us)));
        let heard = match select(bus.read(&mut chunk), Timer::at(due)).await {
            Either::First(Ok(count)) => count,
            Either::First(Err(_)) => {
                core.hand.shared.add(|counters| &mut counters.bus_other);
                // A port that fails at once must not take all of the processor.
                Timer::after_micros(100).await;
                0
            }
            Either::Second(()) => 0,
        };
        ears.hear(core, bus, chunk.get(..heard).unwrap_or_default()).await;
    }
    core.finish();
    core.keep_next();
}

impl Ears {
    // What making them takes is on the stack in here only.
    #[inline(never)]
    fn open<'e, B: Board>(ears: &'e mut Option<Self>, settings: &Settings, baud: u32) -> &'e mut Self {
        ears.insert(Self::new::<B>(settings, baud))
    }

    fn new<B: Board>(settings: &Settings, baud: u32) -> Self {
        let latency_us = B::BUS_LATENCY_US + RETURN_DELAY_US;
        // What comes while an estimate is made is heard when that is done.
        let busy_us = 1_000_000 / u32::from(settings.rate_hz.max(1));
        let timing = |latency_us| Timing { baud_rate: baud, latency_us, status_return: StatusReturn::All };
        let voice = match settings.role {
            Role::Device { id, return_delay } => {
                let bus = BusSettings { id: Id::new(id).unwrap_or(Id::MAX), baud_rate: baud, return_delay };
                let table = DeviceTable::new(&bus, FIRMWARE, settings.count());
                Some(Voice { device: Device::new(timing(latency_us)), table })
            }
            Role::Idle | Role::Master | Role::Tap => None,
        };
        Self { tap: Tap::new(timing(latency_us + busy_us)), voice, role: settings.role, baud }
    }

    /// Takes what is set.
    fn follow<B: Board>(&mut self, core: &mut Core<'_, B>) {
        self.tap.forget();
        for unit in &mut core.hand.units {
            unit.heard_us = None;
            if let Some(id) = unit.id() {
                let commissioned = unit.mount.and_then(|mount| mount.servo).and_then(|servo| Model::of(servo.model));
                // There is room for as many as there are fingers.
                self.tap.watch_model(id, commissioned.unwrap_or(Model::ASSUMED));
            }
        }
        let Some(Voice { table, .. }) = &mut self.voice else {
            return;
        };
        let objects = core.hand.shared.setup(|setup| setup.objects);
        for (finger, (mount, object)) in core.hand.settings.fingers.iter().zip(&objects).enumerate() {
            if let Some(mount) = mount {
                let reversed = mount.direction == Direction::Reversed;
                let (servo_id, gear_ratio, zero) = (mount.servo_id, mount.gear_ratio, mount.zero);
                table.set_finger(finger, &FingerSettings { servo_id, reversed, gear_ratio, zero });
            }
            table.set_object(finger, object.as_ref().map(|object| &object.design));
        }
    }

    /// When to call [`Self::hear`] though nothing has come, µs.
    fn deadline(&self) -> Option<u64> {
        self.voice.as_ref()?.device.deadline()
    }

    /// Takes what was heard: answers first, because a master waits for that, and estimates then.
    async fn hear<B: Board>(&mut self, core: &mut Core<'_, B>, bus: &mut B::Bus, bytes: &[u8]) {
        let (now, heard_ticks) = (now_us(), bus.heard_ticks());
        let mut rest = bytes;
        while let Some(heard) = self.tap.hear(now, &mut rest) {
            core.overheard(&heard);
        }
        if let Some(Voice { device, table }) = &mut self.voice {
            core.show(table, now);
            let mut rest = bytes;
            while let Some(reply) = device.hear(now, &mut rest, table) {
                say(core, bus, &mut self.tap, &reply).await;
            }
            if let Some(reply) = device.poll(now_us(), table) {
                say(core, bus, &mut self.tap, &reply).await;
            }
            while let Some(change) = table.take() {
                core.change(change);
            }
        }
        for finger in 0..core.hand.units.len() {
            let id = core.hand.units.get(finger).and_then(|unit| unit.id());
            if let Some(servo) = id.and_then(|id| self.tap.servo(id)) {
                core.listen_to(finger, servo, heard_ticks);
            }
        }
    }
}

/// Sends an answer, and has the tap hear it like everybody else: a port does not hear itself.
async fn say<B: Board>(core: &mut Core<'_, B>, bus: &mut B::Bus, tap: &mut Tap<PACKET, FINGERS>, reply: &Reply<'_>) {
    let speak = async {
        if reply.delay_us > 0 {
            Timer::after_micros(u64::from(reply.delay_us)).await;
        }
        write_all(bus, reply.bytes).await && bus.flush().await.is_ok()
    };
    if !core.patiently(speak).await {
        core.hand.shared.add(|counters| &mut counters.bus_other);
    }
    let mut own = reply.bytes;
    while tap.hear(now_us(), &mut own).is_some() {}
}

impl<B: Board> Core<'_, B> {
    /// Something was said on the bus.
    fn overheard(&mut self, heard: &Heard<'_>) {
        match *heard {
            Heard::Damaged(_) => self.hand.shared.add(|counters| &mut counters.bus_damaged),
            Heard::Refused { .. } => self.hand.shared.add(|counters| &mut counters.bus_refused),
            _ => {}
        }
    }

    /// Shows the master what the fingers feel.
    fn show(&self, table: &mut DeviceTable, now: u64) {
        for (finger, unit) in self.hand.units.iter().enumerate().filter(|(_, unit)| unit.mount.is_some()) {
            let age_us = unit.heard_us.map(|at_us| u32::try_from(now.saturating_sub(at_us)).unwrap_or(u32::MAX - 1));
            let (estimate, position, current) = (unit.last.estimate, unit.last.position, unit.last.current);
            table.show(finger, &FingerState { estimate, position, current, age_us, alert: unit.alert });
        }
        table.show_margin(self.estimation.margins.report(self.scheduler.ticks).as_ref());
    }

    /// Estimates from a position that was not there before, once per period.
    fn listen_to(&mut self, finger: usize, servo: &Watched, heard_ticks: Option<u32>) {
        let Some(unit) = self.hand.units.get_mut(finger) else {
            return;
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
            return;
        };
        if unit.is_done() || unit.heard_us == Some(seen.at_us) {
            return;
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
            heard_ticks,
            position: servo.model.to_4096ths(seen.value),
            current,
            alert: servo.alert,
            refused: None,
        };
        self.fresh(finger, &reading);
    }

    /// Does what the master wants.
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
