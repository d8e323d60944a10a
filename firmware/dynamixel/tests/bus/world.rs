//! A half-duplex bus in memory, with its own clock: devices hear everything, time jumps from event to event.

use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;
use std::future::{Future, poll_fn};
use std::pin::pin;
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

use dynamixel::{Device, Timing};
use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{ErrorType, Read, Write};

use crate::servo::Servo;

/// What becomes of a device's answer: pieces, each this many microseconds later than it would have come.
pub type Tamper = Box<dyn FnMut(&[u8]) -> Vec<(u64, Vec<u8>)>>;

enum Event {
    /// A packet's last byte has passed; everyone but the speaker has heard it.
    Spoken { by: Option<usize>, bytes: Vec<u8> },
    /// A byte reaches the master.
    Arrived(u8),
}

pub struct World {
    pub now_us: u64,
    pub byte_us: u64,
    /// Whether the master hears itself.
    pub echo: bool,
    pub servos: Vec<(Device<128>, Servo)>,
    /// Applied to the answers to come, one each.
    pub tamper: VecDeque<Tamper>,
    pub sent_until_us: u64,
    /// What the master has sent, write by write.
    pub sent: Vec<Vec<u8>>,
    events: BTreeMap<(u64, u64), Event>,
    count: u64,
    inbox: VecDeque<u8>,
    timers: Vec<u64>,
}

#[derive(Clone)]
pub struct Bus(pub Rc<RefCell<World>>);

impl Bus {
    /// A bus at 1 Mbaud with these servos.
    pub fn new(ids: &[u8]) -> Self {
        Bus(Rc::new(RefCell::new(World {
            now_us: 0,
            byte_us: 10,
            echo: false,
            servos: ids.iter().map(|&id| (Device::new(Timing::at(1_000_000)), Servo::new(id))).collect(),
            tamper: VecDeque::new(),
            sent_until_us: 0,
            sent: Vec::new(),
            events: BTreeMap::new(),
            count: 0,
            inbox: VecDeque::new(),
            timers: Vec::new(),
        })))
    }

    pub fn servo<R>(&self, index: usize, with: impl FnOnce(&mut Servo) -> R) -> R {
        with(&mut self.0.borrow_mut().servos[index].1)
    }

    pub fn tamper(&self, tamper: impl FnMut(&[u8]) -> Vec<(u64, Vec<u8>)> + 'static) {
        self.0.borrow_mut().tamper.push_back(Box::new(tamper));
    }

    pub fn now_us(&self) -> u64 {
        self.0.borrow().now_us
    }

    /// Lets this time pass.
    pub fn rest(&self, us: u64) {
        let until = self.now_us() + us;
        self.0.borrow_mut().run_until(until);
    }

    /// Puts bytes in front of the master now.
    pub fn inject(&self, bytes: &[u8]) {
        self.0.borrow_mut().inbox.extend(bytes);
    }

    /// Bytes that have reached the master and wait to be read.
    pub fn waiting(&self) -> usize {
        self.0.borrow().inbox.len()
    }

    /// Runs a future to its end; the clock advances whenever it waits.
    pub fn run<F: Future>(&self, future: F) -> F::Output {
        let mut future = pin!(future);
        let mut context = Context::from_waker(Waker::noop());
        loop {
            self.0.borrow_mut().timers.clear();
            if let Poll::Ready(output) = future.as_mut().poll(&mut context) {
                return output;
            }
            let mut world = self.0.borrow_mut();
            let event = world.events.keys().next().map(|&(at, _)| at);
            let timer = world.timers.iter().copied().min();
            let next = [event, timer].into_iter().flatten().min().expect("the future waits for nothing");
            world.run_until(next);
        }
    }
}

impl World {
    fn schedule(&mut self, at_us: u64, event: Event) {
        self.count += 1;
        self.events.insert((at_us, self.count), event);
    }

    /// A packet on the wire from `start_us`; returns when its last byte has passed.
    fn speak(&mut self, by: Option<usize>, start_us: u64, bytes: &[u8]) -> u64 {
        let mut at = start_us;
        for &byte in bytes {
            at += self.byte_us;
            if by.is_some() || self.echo {
                self.schedule(at, Event::Arrived(byte));
            }
        }
        self.schedule(at, Event::Spoken { by, bytes: bytes.to_vec() });
        at
    }

    fn run_until(&mut self, until_us: u64) {
        while let Some(entry) = self.events.first_entry().filter(|entry| entry.key().0 <= until_us) {
            let ((at, _), event) = entry.remove_entry();
            self.now_us = self.now_us.max(at);
            match event {
                Event::Arrived(byte) => self.inbox.push_back(byte),
                Event::Spoken { by, bytes } => self.heard(at, by, &bytes),
            }
        }
        self.now_us = self.now_us.max(until_us);
    }

    fn heard(&mut self, at: u64, by: Option<usize>, bytes: &[u8]) {
        for index in (0..self.servos.len()).filter(|&index| Some(index) != by) {
            let mut answers = Vec::new();
            let (device, servo) = &mut self.servos[index];
            // The master speaks after a pause, by which devices know that what they hold will not be completed.
            if by.is_none() {
                device.reset();
            }
            let mut rest = bytes;
            while let Some(reply) = device.hear(at, &mut rest, servo) {
                answers.push((u64::from(reply.delay_us), reply.bytes.to_vec()));
            }
            for (delay, answer) in answers {
                match self.tamper.pop_front() {
                    None => {
                        self.speak(Some(index), at + delay, &answer);
                    }
                    Some(mut tamper) => {
                        for (later, piece) in tamper(&answer) {
                            self.speak(Some(index), at + delay + later, &piece);
                        }
                    }
                }
            }
        }
    }
}

impl ErrorType for Bus {
    type Error = Infallible;
}

impl Read for Bus {
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

impl Write for Bus {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let mut world = self.0.borrow_mut();
        let now = world.now_us;
        world.sent.push(bytes.to_vec());
        world.sent_until_us = world.speak(None, now, bytes);
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        poll_fn(|_| {
            let world = self.0.borrow();
            if world.now_us >= world.sent_until_us { Poll::Ready(Ok(())) } else { Poll::Pending }
        })
        .await
    }
}

/// The bus's clock as a delay.
pub struct Clock(pub Bus);

impl DelayNs for Clock {
    async fn delay_ns(&mut self, ns: u32) {
        let until = self.0.now_us() + u64::from(ns).div_ceil(1000);
        poll_fn(|_| {
            let mut world = self.0.0.borrow_mut();
            if world.now_us >= until {
                return Poll::Ready(());
            }
            world.timers.push(until);
            Poll::Pending
        })
        .await
    }
}
