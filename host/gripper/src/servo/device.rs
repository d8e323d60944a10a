//! The servo itself: bytes heard in, answers out; what is true of it, and what goes wrong with it on purpose.

use std::sync::Arc;

use dynamixel::{ControlTable, Device, Register, Reply, StatusReturn, Timing, Value, xm430};
use model_core::status::Status;

use super::config::{Clock, Config, ConfigError};
use super::fault::{Fault, Faults};
use super::load::Load;
use super::table::Table;

/// Longest packet in either direction, bytes.
const LONGEST: usize = 512;
/// How long the servo waits for others. Long, because whatever is simulated besides it can be slow.
const PATIENCE: Timing = Timing { baud_rate: 57_600, latency_us: 1_000_000, status_return: StatusReturn::All };
/// How long it hears and says nothing after a Reboot and when its power comes back, µs: what was found of an XC330 (ROBOTIS-GIT/emanual, issue 1698;
/// the manual gives nothing). That others take as long is an assumption.
pub const BOOT_US: u64 = 400_000;

/// An answer on its way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The status packet.
    pub bytes: Vec<u8>,
    /// Microseconds from the end of the question to the answer; 0 with [`Clock::Requests`].
    pub delay_us: u32,
}

/// What is true of a servo, which its registers show rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// The servo's time, µs since power-on.
    pub time_us: u64,
    /// Present Position as it would be read now, counts.
    pub count: i32,
    /// Motor angle α by the encoder, rad, not rounded.
    pub motor_angle: f64,
    /// Angle of the finger, rad: within the play of the motor angle.
    pub finger_angle: f64,
    /// Force of the finger on the object at that angle, world frame, N, by the model of [`Load`].
    pub force: [f64; 2],
    /// Torque that the contact demands of the motor, N·mm, likewise.
    pub torque: f64,
    /// Status of force and torque.
    pub status: Status,
}

/// Counters of a servo.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Bytes heard.
    pub heard: u64,
    /// Answers given, those that a fault suppressed included.
    pub answers: u64,
    /// Reads of Present Position.
    pub position_reads: u64,
    /// Answers that a fault changed or suppressed.
    pub faults: u64,
}

/// A simulated servo. See the [module](super).
#[derive(Debug)]
pub struct Servo {
    config: Config,
    device: Device<LONGEST>,
    table: Table,
    /// The time of the caller, µs.
    now_us: u64,
    /// Until when it boots: it hears and says nothing.
    booted_at_us: u64,
    faults: Faults,
    statistics: Statistics,
}

impl Servo {
    /// A servo that has just been powered on, and has booted.
    ///
    /// # Errors
    /// The first thing in the configuration that no such servo can have.
    pub fn new(config: Config) -> Result<Self, ConfigError> {
        let table = Table::new(&config)?;
        Ok(Self {
            config,
            device: Device::new(PATIENCE),
            table,
            now_us: 0,
            booted_at_us: 0,
            faults: Faults::default(),
            statistics: Statistics::default(),
        })
    }

    /// What the servo is like.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Lets the time of the caller pass: `now_us` since the servo was made. Nothing with [`Clock::Requests`].
    pub fn advance(&mut self, now_us: u64) {
        self.now_us = now_us;
        if self.config.clock == Clock::Wall {
            self.table.advance(now_us);
        }
    }

    /// Takes bytes that were on the bus at `now_us` and gives the answers to them. Other devices' answers belong to them,
    /// the servo's own do not matter.
    pub fn hear(&mut self, now_us: u64, bytes: &[u8]) -> Vec<Answer> {
        self.advance(now_us);
        self.statistics.heard += bytes.len() as u64;
        if now_us < self.faults.silent_until_us.max(self.booted_at_us) {
            self.device.reset();
            return Vec::new();
        }
        let mut answers = Vec::new();
        let mut rest = bytes;
        let mut asked = rest.len();
        loop {
            // The rate at which a question was asked is that of its answer, even if it changes the rate.
            let byte_us = self.byte_us();
            let Some(reply) = self.device.hear(now_us, &mut rest, &mut self.table) else {
                break;
            };
            let wire = byte_us * (asked - rest.len() + reply.bytes.len()) as f64;
            asked = rest.len();
            let reply = (reply.bytes.to_vec(), reply.delay_us.saturating_add(wire as u32));
            answers.extend(self.say(reply));
            if self.table.take_restarted() {
                // It has answered before.
                self.boot();
                break;
            }
        }
        answers
    }

    /// Something was on the bus at another rate: what was heard before it begins no packet.
    pub(super) fn noise(&mut self, now_us: u64) {
        self.advance(now_us);
        self.device.reset();
    }

    /// Bits per second on the bus.
    pub(super) fn rate(&self) -> Option<u32> {
        self.config.model.bits_per_second(self.table.get(xm430::BAUD_RATE))
    }

    /// Gives the answer that is due although nothing was heard: a turn that somebody has let pass.
    pub fn poll(&mut self, now_us: u64) -> Option<Answer> {
        self.advance(now_us);
        let Reply { bytes, delay_us } = self.device.poll(now_us, &mut self.table)?;
        let reply = (bytes.to_vec(), delay_us);
        self.say(reply)
    }

    /// When [`Self::poll`] may have something, µs.
    pub fn deadline(&self) -> Option<u64> {
        self.device.deadline()
    }

    /// Counts an answer and makes it wrong where that was asked for.
    fn say(&mut self, (bytes, delay_us): (Vec<u8>, u32)) -> Option<Answer> {
        self.statistics.answers += 1;
        let delay_us = match self.config.clock {
            Clock::Wall => delay_us,
            Clock::Requests { .. } => 0,
        };
        let (bytes, delay_us) = self.faults.apply(bytes, delay_us)?;
        Some(Answer { bytes, delay_us })
    }

    /// Microseconds of one byte on the wire; 0 if they do not count.
    fn byte_us(&self) -> f64 {
        if !self.config.wire_time {
            return 0.0;
        }
        self.rate().map_or(0.0, |rate| 1e7 / f64::from(rate))
    }

    /// What is true now.
    pub fn truth(&self) -> Truth {
        let motor = &self.table.motor;
        Truth {
            time_us: self.table.now_us,
            count: self.table.present_position(),
            motor_angle: motor.angle(motor.position),
            finger_angle: motor.angle(motor.finger),
            force: motor.contact.force,
            torque: motor.contact.torque,
            status: motor.contact.status,
        }
    }

    /// What has happened so far.
    pub fn statistics(&self) -> Statistics {
        Statistics { position_reads: self.table.position_reads, faults: self.faults.done, ..self.statistics }
    }

    /// The finger's load.
    pub fn load(&self) -> &Arc<Load> {
        &self.config.load
    }

    /// What becomes of the answers to come, one each, behind those said before.
    pub fn inject(&mut self, faults: impl IntoIterator<Item = Fault>) {
        self.faults.queue.extend(faults);
    }

    /// Makes the servo deaf and dumb until a time in µs since it was made; `u64::MAX` for good, 0 ends it.
    pub fn silence(&mut self, until_us: u64) {
        self.faults.silent_until_us = until_us;
    }

    /// Sets bits of Hardware Error Status; those that Shutdown names turn the torque off.
    pub fn fail(&mut self, bits: u8) {
        self.table.fail(bits);
    }

    /// Writes a register as another master would, at once; what the servo refuses stays as it is. It is named as the XM430's.
    pub fn write<T: Value>(&mut self, register: Register<T>, value: T) {
        let bytes = value.to_bytes();
        let _ = self.table.write(self.config.model.at(register).address(), &bytes[..usize::from(T::LENGTH)]);
    }

    /// A register as it was last refreshed, named as the XM430's.
    pub fn read<T: Value>(&self, register: Register<T>) -> T {
        self.table.get(register)
    }

    /// Changes what is around it: the supply, V, and the temperature inside, °C, from which it cools or warms on.
    pub fn surround(&mut self, volts: Option<f64>, temperature: Option<f64>) {
        let surroundings = &mut self.table.surroundings;
        surroundings.volts = volts.unwrap_or(surroundings.volts);
        surroundings.temperature = temperature.unwrap_or(surroundings.temperature);
    }

    /// Cuts the power for a moment: RAM is lost, the torque is off, and it boots.
    pub fn reset(&mut self) {
        self.device = Device::new(PATIENCE);
        // Never refused: only a bus can be told that a device does not know the instruction.
        let _ = self.table.reboot();
        self.table.take_restarted();
        self.boot();
    }

    /// It hears nothing until it has booted. The time of [`Clock::Requests`] does not pass meanwhile: it has booted at once.
    fn boot(&mut self) {
        self.device.reset();
        if self.config.clock == Clock::Wall {
            self.booted_at_us = self.now_us.saturating_add(BOOT_US);
        }
    }
}
