//! A master on simulated servos in memory: an answer comes at once or never, time passes when the test says so.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::future::{Future, poll_fn};
use std::pin::pin;
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

use dynamixel::{Answer, Error, Id, Master, Register, StatusError, Timing, Value};
use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{ErrorType, Read, Write};
use fre_gripper::servo::{BOOT_US, Config, Servo};

pub struct World {
    pub servos: Vec<Servo>,
    pub now_us: u64,
    /// Everything the servos have said.
    pub said: Vec<u8>,
    inbox: VecDeque<u8>,
}

#[derive(Clone)]
pub struct Wire(pub Rc<RefCell<World>>);

pub type Failure = Error<Infallible>;

pub struct Bus {
    pub wire: Wire,
    master: Master<Wire, Never, 256>,
}

/// Runs what never waits for anything outside.
pub fn run<F: Future>(future: F) -> F::Output {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(output) = future.as_mut().poll(&mut context) {
            return output;
        }
    }
}

impl Bus {
    pub fn new(configs: impl IntoIterator<Item = Config>) -> Self {
        let servos = configs.into_iter().map(|config| Servo::new(config).unwrap()).collect();
        let world = World { servos, now_us: 0, said: Vec::new(), inbox: VecDeque::new() };
        let wire = Wire(Rc::new(RefCell::new(world)));
        Bus { master: Master::new(wire.clone(), Never, Timing::at(1_000_000)), wire }
    }

    pub fn master(&mut self) -> &mut Master<Wire, Never, 256> {
        &mut self.master
    }

    pub fn servo<R>(&self, with: impl FnOnce(&mut Servo) -> R) -> R {
        with(&mut self.wire.0.borrow_mut().servos[0])
    }

    /// Lets time pass on the wall.
    pub fn pass(&self, us: u64) {
        let mut world = self.wire.0.borrow_mut();
        world.now_us += us;
        let now_us = world.now_us;
        for servo in &mut world.servos {
            servo.advance(now_us);
        }
    }

    /// Restarts the servo, and waits until it has booted.
    pub fn reboot(&mut self) {
        run(self.master.reboot(id(1))).unwrap();
        self.pass(BOOT_US);
    }

    pub fn try_get<T: Value>(&mut self, register: Register<T>) -> Result<Answer<T>, Failure> {
        let mut bytes = [0; 4];
        let part = &mut bytes[..usize::from(T::LENGTH)];
        let answer = run(self.master.read(id(1), register.address(), part))?;
        Ok(Answer { value: T::from_bytes(bytes), alert: answer.alert })
    }

    pub fn get<T: Value>(&mut self, register: Register<T>) -> T {
        self.try_get(register).unwrap().value
    }

    pub fn try_set<T: Value>(&mut self, register: Register<T>, value: T) -> Result<(), Failure> {
        let bytes = value.to_bytes();
        run(self.master.write(id(1), register.address(), &bytes[..usize::from(T::LENGTH)])).map(|_| ())
    }

    pub fn set<T: Value>(&mut self, register: Register<T>, value: T) {
        self.try_set(register, value).unwrap();
    }

    /// Why a write is refused; none if it is not.
    pub fn refusal<T: Value>(&mut self, register: Register<T>, value: T) -> Option<StatusError> {
        match self.try_set(register, value) {
            Ok(()) => None,
            Err(Error::Refused { error, .. }) => Some(error),
            Err(other) => panic!("{other:?}"),
        }
    }
}

pub fn id(id: u8) -> Id {
    Id::new(id).unwrap()
}

impl ErrorType for Wire {
    type Error = Infallible;
}

impl Read for Wire {
    async fn read(&mut self, into: &mut [u8]) -> Result<usize, Infallible> {
        poll_fn(|_| {
            let mut world = self.0.borrow_mut();
            let count = into.len().min(world.inbox.len());
            if count == 0 {
                return Poll::Pending;
            }
            for (place, byte) in into.iter_mut().zip(world.inbox.drain(..count)) {
                *place = byte;
            }
            Poll::Ready(Ok(count))
        })
        .await
    }
}

impl Write for Wire {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let mut world = self.0.borrow_mut();
        let World { servos, now_us, said, inbox } = &mut *world;
        // What one says, all others hear.
        let mut spoken = VecDeque::from([(None, bytes.to_vec())]);
        while let Some((by, words)) = spoken.pop_front() {
            for (index, servo) in servos.iter_mut().enumerate().filter(|&(index, _)| by != Some(index)) {
                for answer in servo.hear(*now_us, &words) {
                    inbox.extend(&answer.bytes);
                    said.extend(&answer.bytes);
                    spoken.push_back((Some(index), answer.bytes));
                }
            }
        }
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// A deadline that has passed as soon as nothing else is ready.
pub struct Never;

impl DelayNs for Never {
    async fn delay_ns(&mut self, _: u32) {}
}
