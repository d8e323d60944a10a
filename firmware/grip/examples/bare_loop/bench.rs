//! A servo on a simulated bus, which pushes a finger against a spring with a load cell.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::rc::Rc;

use dynamixel::{ControlTable, Device, Id, StatusError, Timing, check_read, xm430};
use embedded_hal::delay::DelayNs;
use embedded_io::{ErrorType, Read, ReadReady, Write};

/// The servo's address.
pub const ID: Id = match Id::new(1) {
    Some(id) => id,
    None => Id::MAX,
};
/// Where the spring begins, counts from the middle of the revolution.
const GAP: f64 = 60.0;
/// N per count.
const STIFFNESS: f64 = 0.25;
/// Counts per second and count of distance to the goal.
const PACE: f64 = 40.0;

/// What is on the table.
struct Things {
    device: Device<128>,
    servo: Servo,
    answers: VecDeque<u8>,
    now_us: u64,
    /// Part of a microsecond that has passed.
    ns: u32,
}

/// The servo: what is written can be read, and the motor follows its goal.
struct Servo {
    memory: [u8; 148],
    motor: f64,
}

/// All of it, as the loop's port, its delay and its cell see it.
#[derive(Clone)]
pub struct Bench(Rc<RefCell<Things>>);

/// The bus.
pub struct Port(Bench);
/// Time.
pub struct Delay(Bench);

impl Bench {
    /// A servo in the middle of its revolution.
    pub fn new() -> Self {
        let mut servo = Servo { memory: [0; 148], motor: 2048.0 };
        for item in xm430::ITEMS {
            let (from, length) = (usize::from(item.address), usize::from(item.length));
            servo.memory[from..from + length].copy_from_slice(&item.default.to_le_bytes()[..length]);
        }
        servo.pass(0.0);
        let device = Device::new(Timing::at(1_000_000));
        Self(Rc::new(RefCell::new(Things { device, servo, answers: VecDeque::new(), now_us: 0, ns: 0 })))
    }

    /// The bus as a port.
    pub fn port(&self) -> Port {
        Port(self.clone())
    }

    /// A delay in its time.
    pub fn delay(&self) -> Delay {
        Delay(self.clone())
    }

    /// What the cell measures, N.
    pub fn force(&self) -> Option<f64> {
        Some(STIFFNESS * (self.0.borrow().servo.motor - 2048.0 - GAP).max(0.0))
    }

    /// So many seconds pass.
    pub fn pass(&self, seconds: f64) {
        let mut things = self.0.borrow_mut();
        things.now_us += (seconds * 1e6) as u64;
        things.servo.pass(seconds);
    }
}

impl Servo {
    fn pass(&mut self, seconds: f64) {
        let at = |address: u16| usize::from(address)..usize::from(address) + 4;
        let mut goal = [0; 4];
        goal.copy_from_slice(&self.memory[at(xm430::GOAL_POSITION.address())]);
        let has_torque = self.memory[usize::from(xm430::TORQUE_ENABLE.address())] == 1;
        if has_torque {
            self.motor += (f64::from(i32::from_le_bytes(goal)) - self.motor) * (PACE * seconds).min(1.0);
        }
        let position = self.motor.round() as i32;
        self.memory[at(xm430::PRESENT_POSITION.address())].copy_from_slice(&position.to_le_bytes());
    }
}

impl ControlTable for Servo {
    fn id(&self) -> Id {
        ID
    }

    fn model_number(&self) -> u16 {
        xm430::MODEL
    }

    fn firmware_version(&self) -> u8 {
        45
    }

    fn read(&mut self, address: u16, bytes: &mut [u8]) -> Result<(), StatusError> {
        check_read(&xm430::ITEMS, address, bytes.len())?;
        bytes.copy_from_slice(&self.memory[usize::from(address)..][..bytes.len()]);
        Ok(())
    }

    fn write(&mut self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        self.check(address, bytes)?;
        self.memory[usize::from(address)..][..bytes.len()].copy_from_slice(bytes);
        Ok(())
    }

    fn check(&self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        dynamixel::writes(&xm430::ITEMS, false, address, bytes).try_for_each(|part| part.map(|_| ()))
    }
}

impl Things {
    fn answer(&mut self, mut heard: &[u8]) {
        while let Some(reply) = self.device.hear(self.now_us, &mut heard, &mut self.servo) {
            self.answers.extend(reply.bytes);
        }
    }
}

impl ErrorType for Port {
    type Error = Infallible;
}

impl ReadReady for Port {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.0.0.borrow().answers.is_empty())
    }
}

impl Read for Port {
    fn read(&mut self, into: &mut [u8]) -> Result<usize, Infallible> {
        let answers = &mut self.0.0.borrow_mut().answers;
        let count = into.len().min(answers.len());
        into.iter_mut().zip(answers.drain(..count)).for_each(|(into, byte)| *into = byte);
        Ok(count)
    }
}

impl Write for Port {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        self.0.0.borrow_mut().answer(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        let mut things = self.0.0.borrow_mut();
        let all = things.ns + ns;
        (things.ns, things.now_us) = (all % 1_000, things.now_us + u64::from(all / 1_000));
    }
}
