//! The servo on its bus: found, set up, led and read.

use dynamixel::xm430;
use dynamixel::{Id, Master, StatusError, StatusReturn, Timing};
use embassy_time::Delay;

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

/// The servo.
pub(crate) struct Servo<U: BusPort> {
    master: Master<U, Delay, 64>,
    latency_us: u32,
    id: Id,
    /// The goal last written.
    written: Option<i32>,
}

impl<U: BusPort> Servo<U> {
    pub(crate) fn new(bus: U, latency_us: u32) -> Self {
        let timing = Timing { baud_rate: 1_000_000, latency_us, status_return: StatusReturn::All };
        Self { master: Master::new(bus, Delay, timing), latency_us, id: Id::BROADCAST, written: None }
    }

    /// Looks for the servo at one rate, makes it answer at once and hold its position.
    ///
    /// A servo that already has torque keeps it, and its settings: it may be holding something.
    pub(crate) async fn bring_up(&mut self, id: Id, baud: u32) -> Result<Found, BusError<U>> {
        self.id = id;
        self.written = None;
        let baud_rate = self.master.port_mut().set_baud(baud);
        self.listen_at(baud_rate, xm430::RETURN_DELAY_TIME.item.max as u32);
        let identity = self.master.ping(id).await?.value;
        let code = self.master.get(id, xm430::BAUD_RATE).await?.value;
        // The servo knows its rate better than the board's divider.
        let baud = xm430::bits_per_second(code).unwrap_or(baud_rate);
        let torque = self.master.get(id, xm430::TORQUE_ENABLE).await?.value != 0;
        if !torque {
            self.master.set(id, xm430::STATUS_RETURN_LEVEL, 2).await?;
            self.ensure(xm430::RETURN_DELAY_TIME, 0).await?;
            self.ensure(xm430::OPERATING_MODE, xm430::POSITION_CONTROL).await?;
        }
        let delay = self.master.get(id, xm430::RETURN_DELAY_TIME).await?.value;
        self.listen_at(baud, u32::from(delay));
        let position = self.master.get(id, xm430::PRESENT_POSITION).await?.value;
        self.master.set(id, xm430::GOAL_POSITION, position).await?;
        if !torque {
            match self.master.set(id, xm430::TORQUE_ENABLE, 1).await {
                // After a shutdown the servo can be read, not led, until it is restarted; its alert tells.
                Ok(_) | Err(dynamixel::Error::Refused { alert: true, .. }) => {}
                Err(error) => return Err(error),
            }
        }
        self.written = Some(position);
        Ok(Found { model: identity.model, firmware: identity.firmware, baud, position })
    }

    fn listen_at(&mut self, baud_rate: u32, delay_units: u32) {
        let latency_us = self.latency_us + delay_units * xm430::RETURN_DELAY_US_PER_UNIT;
        self.master.set_timing(Timing { baud_rate, latency_us, status_return: StatusReturn::All });
    }

    /// Writes a byte that outlives power only if it is another one: the EEPROM wears.
    async fn ensure(&mut self, register: dynamixel::Register<u8>, value: u8) -> Result<(), BusError<U>> {
        if self.master.get(self.id, register).await?.value != value {
            self.master.set(self.id, register, value).await?;
        }
        Ok(())
    }

    /// Period of the control loop with this servo, µs.
    pub(crate) fn period_us(&self, wanted_hz: u16) -> u64 {
        let Timing { baud_rate, latency_us, .. } = self.master.timing();
        rate::period_us(wanted_hz, baud_rate, latency_us.saturating_sub(self.latency_us))
    }

    /// One tick: the goal, if it is a new one, and what the servo does at present.
    pub(crate) async fn tick(&mut self, goal: i32) -> Result<Reading, BusError<U>> {
        let mut refused = None;
        if self.written != Some(goal) {
            match self.master.set(self.id, xm430::GOAL_POSITION, goal).await {
                Ok(_) => {}
                Err(dynamixel::Error::Refused { error, .. }) => refused = Some((goal, error)),
                Err(error) => return Err(error),
            }
            self.written = Some(goal);
        }
        let mut bytes = [0; PRESENT_BYTES];
        let alert = self.master.read(self.id, PRESENT, &mut bytes).await?.alert;
        let [c0, c1, _, _, _, _, p0, p1, p2, p3] = bytes;
        Ok(Reading {
            position: i32::from_le_bytes([p0, p1, p2, p3]),
            current: f32::from(i16::from_le_bytes([c0, c1])) * xm430::MILLIAMPERES_PER_UNIT,
            alert,
            refused,
        })
    }

    /// Which hardware errors the servo has.
    pub(crate) async fn hardware_error(&mut self) -> Result<u8, BusError<U>> {
        Ok(self.master.get(self.id, xm430::HARDWARE_ERROR_STATUS).await?.value)
    }
}
