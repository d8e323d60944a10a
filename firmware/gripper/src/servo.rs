//! The servos on their bus: found, set up, led and read.

use dynamixel::xm430;
use dynamixel::{Answer, Id, Master, StatusError, StatusReturn, SyncAnswer, Timing};
use embassy_time::Delay;
use heapless::Vec;
use messages::FINGERS;

use crate::board::BusPort;
use crate::rate;

/// First of the registers read in every tick: Present Current, Velocity, Position.
const PRESENT: u16 = xm430::PRESENT_CURRENT.address();
/// Bytes of those registers.
const PRESENT_BYTES: usize = 10;

/// Why the bus gave nothing.
pub(crate) type BusError<U> = dynamixel::Error<<U as embedded_io_async::ErrorType>::Error>;

/// A servo that was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Found {
    pub(crate) model: u16,
    pub(crate) firmware: u8,
    /// Bits per second.
    pub(crate) baud: u32,
    /// Counts.
    pub(crate) position: i32,
}

/// What a tick reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading {
    /// Counts.
    pub(crate) position: i32,
    /// mA.
    pub(crate) current: f32,
    /// The servo has a hardware error.
    pub(crate) alert: bool,
    /// The goal that it did not take.
    pub(crate) refused: Option<(i32, StatusError)>,
}

/// One finger's part of a tick.
pub(crate) struct Turn<U: BusPort> {
    pub(crate) finger: usize,
    pub(crate) id: Id,
    /// The goal, counts.
    pub(crate) goal: i32,
    /// What came of it.
    pub(crate) result: Result<Reading, BusError<U>>,
}

impl<U: BusPort> Turn<U> {
    pub(crate) fn new(finger: usize, id: Id, goal: i32) -> Self {
        // Stands until the servo has answered.
        Self { finger, id, goal, result: Err(dynamixel::Error::Timeout { id, waited_us: 0 }) }
    }
}

/// Ticks after a failure in which every servo is asked by itself: behind a silent one, a common question leaves the others
/// silent too.
const APART: u8 = 8;

/// The servos.
pub(crate) struct Servos<U: BusPort> {
    master: Master<U, Delay, 128>,
    latency_us: u32,
    /// The longest return delay of the servos found, in the unit of their register.
    delay: u8,
    /// The goals last written.
    written: [Option<i32>; FINGERS],
    apart: u8,
}

impl<U: BusPort> Servos<U> {
    pub(crate) fn new(bus: U, latency_us: u32) -> Self {
        let timing = Timing { baud_rate: 1_000_000, latency_us, status_return: StatusReturn::All };
        Self { master: Master::new(bus, Delay, timing), latency_us, delay: 0, written: [None; FINGERS], apart: 0 }
    }

    /// Looks for a finger's servo at one rate, makes it answer at once and hold its position.
    ///
    /// A servo that already has torque keeps it, and its settings: it may be holding something.
    pub(crate) async fn bring_up(&mut self, finger: usize, id: Id, baud: u32) -> Result<Found, BusError<U>> {
        self.wrote(finger, None);
        let others = self.delay;
        let found = self.look_for(id, baud).await;
        self.delay = self.delay.max(others);
        self.listen_at(self.master.timing().baud_rate, u32::from(self.delay));
        if let Ok(found) = &found {
            self.wrote(finger, Some(found.position));
        }
        found
    }

    async fn look_for(&mut self, id: Id, baud: u32) -> Result<Found, BusError<U>> {
        let baud_rate = self.master.port_mut().set_baud(baud);
        self.listen_at(baud_rate, xm430::RETURN_DELAY_TIME.item.max as u32);
        let identity = self.master.ping(id).await?.value;
        let code = self.master.get(id, xm430::BAUD_RATE).await?.value;
        // The servo knows its rate better than the board's divider.
        let baud = xm430::bits_per_second(code).unwrap_or(baud_rate);
        let torque = self.master.get(id, xm430::TORQUE_ENABLE).await?.value != 0;
        if !torque {
            self.master.set(id, xm430::STATUS_RETURN_LEVEL, 2).await?;
            self.ensure(id, xm430::RETURN_DELAY_TIME, 0).await?;
            self.ensure(id, xm430::OPERATING_MODE, xm430::POSITION_CONTROL).await?;
        }
        self.delay = self.master.get(id, xm430::RETURN_DELAY_TIME).await?.value;
        self.listen_at(baud, u32::from(self.delay));
        let position = self.master.get(id, xm430::PRESENT_POSITION).await?.value;
        self.master.set(id, xm430::GOAL_POSITION, position).await?;
        if !torque {
            match self.master.set(id, xm430::TORQUE_ENABLE, 1).await {
                // After a shutdown the servo can be read, not led, until it is restarted; its alert tells.
                Ok(_) | Err(dynamixel::Error::Refused { alert: true, .. }) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(Found { model: identity.model, firmware: identity.firmware, baud, position })
    }

    fn listen_at(&mut self, baud_rate: u32, delay_units: u32) {
        let latency_us = self.latency_us + delay_units * xm430::RETURN_DELAY_US_PER_UNIT;
        self.master.set_timing(Timing { baud_rate, latency_us, status_return: StatusReturn::All });
    }

    /// Writes a byte that outlives power only if it is another one: the EEPROM wears.
    async fn ensure(&mut self, id: Id, register: dynamixel::Register<u8>, value: u8) -> Result<(), BusError<U>> {
        if self.master.get(id, register).await?.value != value {
            self.master.set(id, register, value).await?;
        }
        Ok(())
    }

    /// Forgets the servos' return delays: none is there.
    pub(crate) fn forget(&mut self) {
        self.delay = 0;
    }

    fn wrote(&mut self, finger: usize, goal: Option<i32>) {
        if let Some(written) = self.written.get_mut(finger) {
            *written = goal;
        }
    }

    fn is_new(&self, turn: &Turn<U>) -> bool {
        self.written.get(turn.finger).is_none_or(|written| *written != Some(turn.goal))
    }

    /// Period of the control loop with so many servos, µs.
    pub(crate) fn period_us(&self, wanted_hz: u16, fingers: usize) -> u64 {
        let Timing { baud_rate, latency_us, .. } = self.master.timing();
        rate::period_us(wanted_hz, baud_rate, latency_us.saturating_sub(self.latency_us), fingers)
    }

    /// One tick: the goals that are new, and what the servos do at present.
    pub(crate) async fn tick(&mut self, turns: &mut [Turn<U>]) {
        if turns.len() > 1 && self.apart == 0 {
            self.together(turns).await;
        } else {
            self.apart = self.apart.saturating_sub(1);
            for turn in turns.iter_mut() {
                turn.result = self.alone(turn).await;
            }
        }
        if turns.iter().any(|turn| turn.result.is_err()) {
            self.apart = APART;
        }
    }

    /// A servo by itself.
    async fn alone(&mut self, turn: &Turn<U>) -> Result<Reading, BusError<U>> {
        let mut refused = None;
        if self.is_new(turn) {
            match self.master.set(turn.id, xm430::GOAL_POSITION, turn.goal).await {
                Ok(_) => {}
                Err(dynamixel::Error::Refused { error, .. }) => refused = Some((turn.goal, error)),
                Err(error) => return Err(error),
            }
            self.wrote(turn.finger, Some(turn.goal));
        }
        let mut bytes = [0; PRESENT_BYTES];
        let alert = self.master.read(turn.id, PRESENT, &mut bytes).await?.alert;
        Ok(Reading { refused, ..reading(Answer { value: bytes, alert }) })
    }

    /// All of them with one question. (Nobody answers a common write, so that a goal that is refused shows in the position
    /// only; a single servo's does.)
    async fn together(&mut self, turns: &mut [Turn<U>]) {
        let mut goals: Vec<(Id, [u8; 4]), FINGERS> = Vec::new();
        let mut answers: Vec<SyncAnswer<U::Error, PRESENT_BYTES>, FINGERS> = Vec::new();
        for turn in turns.iter() {
            // There are as many turns as fingers.
            let _ = answers.push(SyncAnswer::new(turn.id));
            if self.is_new(turn) {
                let _ = goals.push((turn.id, turn.goal.to_le_bytes()));
            }
        }
        if !goals.is_empty() {
            let written = self.master.sync_write(xm430::GOAL_POSITION.address(), &goals).await.is_ok();
            for turn in turns.iter().filter(|_| written) {
                self.wrote(turn.finger, Some(turn.goal));
            }
        }
        match self.master.sync_read(PRESENT, &mut answers).await {
            Ok(()) => {
                for (turn, answer) in turns.iter_mut().zip(answers) {
                    if let Some(result) = answer.result {
                        turn.result = result.map(reading);
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

    /// Which hardware errors a servo has.
    pub(crate) async fn hardware_error(&mut self, id: Id) -> Result<u8, BusError<U>> {
        Ok(self.master.get(id, xm430::HARDWARE_ERROR_STATUS).await?.value)
    }
}

fn reading(answer: Answer<[u8; PRESENT_BYTES]>) -> Reading {
    let [c0, c1, _, _, _, _, p0, p1, p2, p3] = answer.value;
    Reading {
        position: i32::from_le_bytes([p0, p1, p2, p3]),
        current: f32::from(i16::from_le_bytes([c0, c1])) * xm430::MILLIAMPERES_PER_UNIT,
        alert: answer.alert,
        refused: None,
    }
}
