//! The servos on their bus: controlled and read.

mod bring_up;
mod fence;

use dynamixel::xm430;
use dynamixel::{Answer, Id, Master, Model, Register, StatusError, StatusReturn, SyncAnswer, Timing};
use embassy_time::Delay;
use grip::Vitals;
use heapless::Vec;
use messages::{BAUDS, FINGERS};

use crate::board::BusPort;
use crate::rate;
use crate::shared::now_us;

pub(crate) use bring_up::{Found, Rates, Wanted};
pub(crate) use fence::{Fence, lever, reach};

/// First of the registers read in every tick: Present Current (or Load), Velocity, Position.
const PRESENT: Register<i16> = xm430::PRESENT_CURRENT;
/// Bytes of those registers.
const PRESENT_BYTES: usize = 10;

/// Present Input Voltage and, behind it, Present Temperature.
const VITAL: Register<u16> = xm430::PRESENT_INPUT_VOLTAGE;
/// Bytes of those registers.
const VITAL_BYTES: usize = 3;

/// What a servo holds with: Torque Enable, and up to Bus Watchdog what is behind it.
const HOLD: Register<u8> = xm430::TORQUE_ENABLE;
/// Bytes of those registers.
const HOLD_BYTES: usize = (xm430::BUS_WATCHDOG.address() + 1 - HOLD.address()) as usize;

/// Why the bus gave nothing.
pub(crate) type BusError<U> = dynamixel::Error<<U as embedded_io_async::ErrorType>::Error>;

/// What a tick reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading {
    /// When it came, µs.
    pub(crate) at_us: u64,
    /// When its last byte came, in ticks of the cost clock.
    pub(crate) heard_ticks: Option<u32>,
    /// Counts, 4096 per revolution.
    pub(crate) position: i32,
    /// mA; of a servo that shows a load, what that is of its current at stall.
    pub(crate) current: f32,
    /// The servo has a hardware error.
    pub(crate) alert: bool,
    /// The goal that it did not take.
    pub(crate) refused: Option<(i32, StatusError)>,
}

/// What a servo is asked now and then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Look {
    /// How warm it is, and what supplies it.
    pub(crate) vitals: Vitals,
    /// It has its torque, or a hardware error, which is reported by itself.
    pub(crate) holds: bool,
    /// Another program has set its Bus Watchdog, by which it takes no goals, or will take none, or its Status Return Level, by which it does not
    /// answer whoever writes.
    pub(crate) is_changed: bool,
}

/// Each finger's goal, counts; none for a servo without torque.
pub(crate) type Goals = [Option<i32>; FINGERS];

/// One finger's part of a tick.
pub(crate) struct Turn<U: BusPort> {
    pub(crate) finger: usize,
    pub(crate) id: Id,
    /// The goal, counts (4096 per revolution); none for a servo without torque.
    pub(crate) goal: Option<i32>,
    /// What came of it.
    pub(crate) result: Result<Reading, BusError<U>>,
}

impl<U: BusPort> Turn<U> {
    pub(crate) fn new(finger: usize, id: Id) -> Self {
        // Stands until the servo has answered.
        Self { finger, id, goal: None, result: Err(dynamixel::Error::Timeout { id, waited_us: 0 }) }
    }
}

/// Ticks after a failure in which every servo is asked by itself from the start: behind a silent one, a common question leaves the others
/// silent too, and they have to be asked again.
const APART: u8 = 8;

/// Ticks in which a goal that nobody confirms is written once more: noise may have damaged it.
const AGAIN: u8 = 2;

/// The servos.
pub(crate) struct Servos<U: BusPort> {
    master: Master<U, Delay, 128>,
    latency_us: u32,
    /// The return delay of each finger's servo since it was found, in the unit of its register.
    delays: [u8; FINGERS],
    /// The goals last written.
    written: [Option<i32>; FINGERS],
    /// In how many further ticks they are written, as nobody has confirmed them.
    unconfirmed: [u8; FINGERS],
    /// Which servos can be read together in one packet.
    fast: [bool; FINGERS],
    /// What the servos are.
    models: [&'static Model; FINGERS],
    /// Current Limit, in its unit, of servos that limit their current by themselves.
    most_current: [Option<i16>; FINGERS],
    /// Goal Current last written to them.
    fences: [Option<i16>; FINGERS],
    apart: u8,
}

impl<U: BusPort> Servos<U> {
    pub(crate) fn new(bus: U, latency_us: u32) -> Self {
        let timing = Timing { baud_rate: 1_000_000, latency_us, status_return: StatusReturn::All };
        Self {
            master: Master::new(bus, Delay, timing),
            latency_us,
            delays: [0; FINGERS],
            written: [None; FINGERS],
            unconfirmed: [0; FINGERS],
            fast: [false; FINGERS],
            models: [Model::ASSUMED; FINGERS],
            most_current: [None; FINGERS],
            fences: [None; FINGERS],
            apart: 0,
        }
    }

    fn is_a(&mut self, finger: usize, model: &'static Model) {
        if let Some(known) = self.models.get_mut(finger) {
            *known = model;
        }
    }

    fn model(&self, finger: usize) -> &'static Model {
        self.models.get(finger).copied().unwrap_or(Model::ASSUMED)
    }

    fn reads_fast(&mut self, finger: usize, fast: bool) {
        if let Some(known) = self.fast.get_mut(finger) {
            *known = fast;
        }
    }

    /// The rates of servos that the port has.
    pub(crate) fn rates(&mut self) -> Vec<u32, { BAUDS.len() }> {
        let present = self.master.timing().baud_rate;
        BAUDS.into_iter().filter(|rate| self.reaches(*rate, present)).collect()
    }

    /// Asks everybody at one rate who they are: as many as there is room for.
    pub(crate) async fn discover(
        &mut self,
        rate: u32,
        found: &mut [Option<dynamixel::Found>],
    ) -> Result<usize, BusError<U>> {
        self.master.port_mut().set_baud(rate);
        self.listen_at(rate, xm430::RETURN_DELAY_TIME.item.max as u32);
        self.master.discover(found).await
    }

    /// How many instructions of another master were heard since this was last called.
    pub(crate) fn take_foreign(&mut self) -> u32 {
        self.master.take_foreign()
    }

    /// The rate to which a device is set, bits per second, if it says.
    pub(crate) async fn rate_of(&mut self, id: Id) -> Option<u32> {
        let code = self.master.get(id, xm430::BAUD_RATE).await.ok()?;
        // The models have the same codes as far as they have the same rates.
        xm430::bits_per_second(code.value)
    }

    /// The servos are controlled at this rate again.
    pub(crate) fn go_on_at(&mut self, bus: Option<u32>) {
        if let Some(baud) = bus {
            self.master.port_mut().set_baud(baud);
            self.listen_to_all_at(baud);
        }
    }

    /// Whether the port has a rate, within what a receiver bears; the port is left at `present`.
    fn reaches(&mut self, wanted: u32, present: u32) -> bool {
        let reached = self.master.port_mut().set_baud(wanted);
        self.master.port_mut().set_baud(present);
        u64::from(reached.abs_diff(wanted)) * 50 <= u64::from(wanted)
    }

    fn listen_at(&mut self, baud_rate: u32, delay_units: u32) {
        let latency_us = self.latency_us + delay_units * xm430::RETURN_DELAY_US_PER_UNIT;
        self.master.set_timing(Timing { baud_rate, latency_us, status_return: StatusReturn::All });
    }

    /// As [`Self::listen_at`], for as long as the slowest of the servos takes.
    fn listen_to_all_at(&mut self, baud_rate: u32) {
        let longest = self.delays.iter().copied().max().unwrap_or(0);
        self.listen_at(baud_rate, u32::from(longest));
    }

    fn delays_by(&mut self, finger: usize, delay: u8) {
        if let Some(known) = self.delays.get_mut(finger) {
            *known = delay;
        }
    }

    /// Forgets the servos' return delays: none is there.
    pub(crate) fn forget(&mut self) {
        self.delays = [0; FINGERS];
    }

    /// The bus itself.
    pub(crate) fn port_mut(&mut self) -> &mut U {
        self.master.port_mut()
    }

    fn wrote(&mut self, finger: usize, goal: Option<i32>) {
        if let (Some(written), Some(left)) = (self.written.get_mut(finger), self.unconfirmed.get_mut(finger)) {
            (*written, *left) = (goal, 0);
        }
    }

    /// The same where nobody answers.
    fn wrote_unconfirmed(&mut self, finger: usize, goal: Option<i32>) {
        if let (Some(written), Some(left)) = (self.written.get_mut(finger), self.unconfirmed.get_mut(finger)) {
            *left = if *written == goal { left.saturating_sub(1) } else { AGAIN };
            *written = goal;
        }
    }

    /// The goal, if it is not the one last written, or nobody has confirmed that.
    fn new_goal(&self, turn: &Turn<U>) -> Option<i32> {
        let is_known = |goal: &i32| self.written.get(turn.finger).is_some_and(|written| *written == Some(*goal));
        let is_confirmed = self.unconfirmed.get(turn.finger).is_none_or(|left| *left == 0);
        turn.goal.filter(|goal| !(is_confirmed && is_known(goal)))
    }

    /// Switches a servo's torque off, or on with this goal.
    pub(crate) async fn set_torque(&mut self, finger: usize, id: Id, goal: Option<i32>) -> Result<(), BusError<U>> {
        self.wrote(finger, None);
        let model = self.model(finger);
        if let Some(goal) = goal {
            self.master.set(id, model.at(xm430::GOAL_POSITION), model.from_4096ths(goal)).await?;
        }
        self.master.set(id, model.at(xm430::TORQUE_ENABLE), u8::from(goal.is_some())).await?;
        self.wrote(finger, goal);
        Ok(())
    }

    /// Period of the control loop with so many servos, µs.
    pub(crate) fn period_us(&self, wanted_hz: u16, fingers: usize) -> u64 {
        let Timing { baud_rate, latency_us, .. } = self.master.timing();
        let first = self.model(0).layout;
        let is_alike = (1..fingers).all(|finger| self.model(finger).layout == first);
        let period_us = if is_alike { rate::period_us } else { rate::period_apart_us };
        period_us(wanted_hz, baud_rate, latency_us.saturating_sub(self.latency_us), fingers)
    }

    /// One tick: the goals that are new, and what the servos do at present.
    pub(crate) async fn tick(&mut self, turns: &mut [Turn<U>]) {
        // A common question has one address for all.
        let layout = |turn: &Turn<U>| self.model(turn.finger).layout;
        let is_alike = turns.first().is_some_and(|first| turns.iter().all(|turn| layout(turn) == layout(first)));
        let is_common = turns.len() > 1 && is_alike && self.apart == 0;
        if is_common {
            self.together(turns).await;
        } else {
            self.apart = self.apart.saturating_sub(1);
        }
        // Whoever has not answered yet: behind a silent one nobody does.
        for turn in turns.iter_mut().filter(|turn| turn.result.is_err()) {
            turn.result = self.alone(turn).await;
            if is_common || turn.result.is_err() {
                self.apart = APART;
            }
        }
    }

    /// A servo by itself.
    async fn alone(&mut self, turn: &Turn<U>) -> Result<Reading, BusError<U>> {
        let mut refused = None;
        let model = self.model(turn.finger);
        if let Some(goal) = self.new_goal(turn) {
            match self.master.set(turn.id, model.at(xm430::GOAL_POSITION), model.from_4096ths(goal)).await {
                Ok(_) => {}
                Err(dynamixel::Error::Refused { error, .. }) => refused = Some((goal, error)),
                Err(error) => return Err(error),
            }
            self.wrote(turn.finger, Some(goal));
        }
        let mut bytes = [0; PRESENT_BYTES];
        let alert = self.master.read(turn.id, model.at(PRESENT).address(), &mut bytes).await?.alert;
        let heard_ticks = self.master.port_mut().heard_ticks();
        Ok(Reading { refused, heard_ticks, ..reading(model, Answer { value: bytes, alert }) })
    }

    /// All of them with one question, at the same addresses. (Nobody answers a common write: it is repeated, and a goal that is refused shows in
    /// the position only; a single servo's is answered.)
    async fn together(&mut self, turns: &mut [Turn<U>]) {
        let mut goals: Vec<(Id, [u8; 4]), FINGERS> = Vec::new();
        let mut answers: Vec<SyncAnswer<U::Error, PRESENT_BYTES>, FINGERS> = Vec::new();
        let layout = turns.first().map_or(Model::ASSUMED, |turn| self.model(turn.finger)).layout;
        let [goal_at, present_at] = [layout.at(xm430::GOAL_POSITION).address(), layout.at(PRESENT).address()];
        for turn in turns.iter() {
            // There are as many turns as fingers.
            let _ = answers.push(SyncAnswer::new(turn.id));
            if let Some(goal) = self.new_goal(turn) {
                let _ = goals.push((turn.id, self.model(turn.finger).from_4096ths(goal).to_le_bytes()));
            }
        }
        if !goals.is_empty() {
            let written = self.master.sync_write(goal_at, &goals).await.is_ok();
            for turn in turns.iter().filter(|turn| written && turn.goal.is_some()) {
                self.wrote_unconfirmed(turn.finger, turn.goal);
            }
        }
        let fast = turns.iter().all(|turn| self.fast.get(turn.finger) == Some(&true));
        let asked = if fast {
            self.master.fast_sync_read(present_at, &mut answers).await
        } else {
            self.master.sync_read(present_at, &mut answers).await
        };
        match asked {
            Ok(()) => {
                // Who does not know the instruction is silent: from then on the plain one is used, until it is found anew.
                let is_silent = |answer: &SyncAnswer<U::Error, PRESENT_BYTES>| {
                    matches!(answer.result, Some(Err(dynamixel::Error::Timeout { .. })))
                };
                if fast && let Some(silent) = answers.iter().position(is_silent) {
                    self.reads_fast(turns.get(silent).map_or(FINGERS, |turn| turn.finger), false);
                }
                let heard_ticks = self.master.port_mut().heard_ticks();
                for (turn, answer) in turns.iter_mut().zip(&mut answers) {
                    if let Some(result) = answer.result.take() {
                        let model = self.model(turn.finger);
                        turn.result = result.map(|answer| Reading { heard_ticks, ..reading(model, answer) });
                    }
                }
            }
            Err(error) => {
                if let Some(turn) = turns.first_mut() {
                    turn.result = Err(error);
                }
            }
        }
    }

    /// How warm a servo is, what supplies it, and whether it still holds: has its torque, and if that is in doubt, takes goals.
    pub(crate) async fn look(&mut self, finger: usize, id: Id, is_doubted: bool) -> Result<Look, BusError<U>> {
        let model = self.model(finger);
        let mut bytes = [0; VITAL_BYTES];
        self.master.read(id, model.at(VITAL).address(), &mut bytes).await?;
        let [low, high, temperature] = bytes;
        let mut bytes = [0; HOLD_BYTES];
        // A long answer would cost every servo's look a tick.
        let asked = bytes.get_mut(..if is_doubted { HOLD_BYTES } else { 1 }).unwrap_or_default();
        let Answer { alert, .. } = self.master.read(id, model.at(HOLD).address(), asked).await?;
        let [torque, _, _, _, level, .., watchdog] = bytes;
        let vitals = Vitals { temperature, voltage: u16::from_le_bytes([low, high]) };
        Ok(Look { vitals, holds: alert || torque != 0, is_changed: is_doubted && (level != 2 || watchdog != 0) })
    }

    /// Which hardware errors a servo has.
    pub(crate) async fn hardware_error(&mut self, finger: usize, id: Id) -> Result<u8, BusError<U>> {
        Ok(self.master.get(id, self.model(finger).at(xm430::HARDWARE_ERROR_STATUS)).await?.value)
    }
}

/// A servo's answer as a reading.
fn reading(model: &Model, answer: Answer<[u8; PRESENT_BYTES]>) -> Reading {
    let [c0, c1, _, _, _, _, p0, p1, p2, p3] = answer.value;
    Reading {
        at_us: now_us(),
        heard_ticks: None,
        position: model.to_4096ths(i32::from_le_bytes([p0, p1, p2, p3])),
        current: f32::from(i16::from_le_bytes([c0, c1])) * model.effort_milliamperes(),
        alert: answer.alert,
        refused: None,
    }
}

#[cfg(test)]
mod tests;
