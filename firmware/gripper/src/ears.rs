//! What the gripper makes of the bus while another master leads: what the servos do, and as a device what it answers.

use dynamixel::{Device, Heard, Id, Model, Reply, Seen, StatusReturn, Tap, Timing, Watched, xm430};
use heapless::Vec;
use messages::{FINGERS, Role, Settings};

use crate::board::Board;
use crate::device_table::{BusSettings, Change, DeviceTable};
use crate::shared::{Shared, now_us};

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
    pub(crate) voice: Option<Voice>,
    baud: u32,
    /// Each servo watched, and when the last byte of its position came, in ticks of the cost clock.
    heard: Vec<(Id, Option<u32>), FINGERS>,
}

/// What a device answers with.
pub(crate) struct Voice {
    device: Device<PACKET>,
    pub(crate) table: DeviceTable,
    /// When each finger's position was heard, µs.
    pub(crate) heard_us: [Option<u64>; FINGERS],
}

/// An answer, and how long after the question it is due, µs.
pub(crate) struct Said {
    pub(crate) bytes: Vec<u8, PACKET>,
    pub(crate) delay_us: u32,
}

impl Said {
    fn of(reply: &Reply<'_>) -> Self {
        // A reply lies in a buffer of that length.
        Self { bytes: Vec::from_slice(reply.bytes).unwrap_or_default(), delay_us: reply.delay_us }
    }
}

impl Ears {
    /// Opens them at a rate. A control table that there is stays.
    // What making them takes is on the stack in here only.
    #[inline(never)]
    pub(crate) fn open<B: Board>(ears: &mut Option<Self>, settings: &Settings, baud: u32) {
        let table = ears.take().and_then(|ears| ears.voice).map(|voice| voice.table);
        *ears = Some(Self::new::<B>(settings, baud, table));
    }

    fn new<B: Board>(settings: &Settings, baud: u32, table: Option<DeviceTable>) -> Self {
        let latency_us = B::BUS_LATENCY_US + RETURN_DELAY_US;
        let timing = Timing { baud_rate: baud, latency_us, status_return: StatusReturn::All };
        let voice = BusSettings::of(settings).map(|bus| {
            let table = table.unwrap_or_else(|| DeviceTable::new(&bus, FIRMWARE, settings.count(), B::ANSWER_US));
            Voice { device: Device::new(timing), table, heard_us: [None; FINGERS] }
        });
        Self { tap: Tap::new(timing), voice, baud, heard: Vec::new() }
    }

    /// Whether they are those of this role at this rate.
    pub(crate) fn are(&self, role: Role, baud: u32) -> bool {
        (self.voice.is_some(), self.baud) == (matches!(role, Role::Device { .. }), baud)
    }

    /// What the master has changed in the control table and nobody has taken yet, one thing at a time.
    pub(crate) fn take_change(&mut self) -> Option<Change> {
        self.voice.as_mut()?.table.take()
    }

    /// Forgets every servo.
    pub(crate) fn forget(&mut self) {
        self.tap.forget();
        self.heard.clear();
    }

    /// Follows a servo of this model.
    pub(crate) fn watch(&mut self, id: Id, model: &'static Model) {
        // There is room for as many as there are fingers.
        self.tap.watch_model(id, model);
        let _ = self.heard.push((id, None));
    }

    /// What is known of a servo.
    pub(crate) fn sight(&self, id: Id) -> Option<Sight> {
        let heard_ticks = self.heard.iter().find(|(whose, _)| *whose == id).and_then(|(_, ticks)| *ticks);
        self.tap.servo(id).map(|servo| Sight::of(servo, heard_ticks))
    }

    /// When there may be something to say though nothing has come, µs.
    pub(crate) fn deadline(&self) -> Option<u64> {
        self.voice.as_ref()?.device.deadline()
    }

    /// Something was said on the bus, and heard at `now`, µs; its last byte came at `heard_ticks`.
    #[inline(never)]
    pub(crate) fn overhear(&mut self, shared: &Shared, now: u64, bytes: &[u8], heard_ticks: Option<u32>) {
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

    /// For a while nothing was heard: what was half said, or had yet to be answered, is over.
    pub(crate) fn were_deaf(&mut self) {
        self.tap.reset();
        if let Some(voice) = &mut self.voice {
            voice.device.reset();
        }
    }

    /// What was said by the gripper itself.
    pub(crate) fn hear_own(&mut self, mut bytes: &[u8]) {
        while self.tap.hear(now_us(), &mut bytes).is_some() {}
    }
}

impl Voice {
    /// Puts into the control table what is set of the gripper itself.
    pub(crate) fn settle(&mut self, settings: &Settings) {
        if let Some(bus) = BusSettings::of(settings) {
            self.table.set_bus(&bus, settings.count());
        }
    }

    /// The next answer to what was heard at this time, µs; the bytes that it takes are taken off.
    #[inline(never)]
    pub(crate) fn answer(&mut self, now: u64, rest: &mut &[u8]) -> Option<Said> {
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
pub(crate) fn age_us(at_us: u64, now_us: u64) -> u32 {
    u32::try_from(now_us.saturating_sub(at_us)).unwrap_or(u32::MAX - 1)
}

/// What the control task wants to know of a servo.
pub(crate) struct Sight {
    pub(crate) model: &'static Model,
    pub(crate) position: Option<Seen<i32>>,
    pub(crate) effort: Option<Seen<i16>>,
    pub(crate) goal: Option<Seen<i32>>,
    pub(crate) hardware_error: Option<Seen<u8>>,
    pub(crate) alert: bool,
    pub(crate) heard_ticks: Option<u32>,
}

impl Sight {
    fn of(servo: &Watched, heard_ticks: Option<u32>) -> Self {
        let &Watched { model, position, effort, goal, hardware_error, alert, .. } = servo;
        Self { model, position, effort, goal, hardware_error, alert, heard_ticks }
    }
}
