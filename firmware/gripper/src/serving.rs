//! The bus task: asks the servos while the control task computes, and hears and answers another master.

use core::task::Poll;

use embassy_futures::poll_once;
use embassy_futures::select::{Either, Either4, select, select4};
use embassy_time::{Instant, Timer};
use embedded_io_async::{Read, Write};

use crate::board::{Board, BusPort};
use crate::bus::{Bus, Job, Line};
use crate::ears::{Ears, Said};
use crate::shared::{Shared, now_us};
use crate::write::write_all;

/// Bytes that are taken at once.
const CHUNK: usize = 64;
/// So many full chunks in a row are more than a packet: the bus says more than the processor can follow.
const LOUD: u32 = 8;
/// What the tasks below the bus task then get, µs; what is lost meanwhile counts as damaged.
const BREATH_US: u64 = 200;
/// Chunks that are thrown away after the processor was held, at most: more than a port keeps.
const WAITING: usize = 32;

/// Does on the bus what the control task wants, for ever.
pub async fn serve<B: Board>(shared: &Shared, bus: &Bus<B::Bus>) -> ! {
    let mut job = Job::Rest;
    loop {
        job = match job {
            Job::Rest => bus.job().await,
            Job::Ask(due) => {
                Timer::at(due).await;
                ask(shared, bus).await;
                bus.job().await
            }
            Job::Listen => {
                let mut line = bus.line().await;
                hear::<B>(shared, bus, line.servos.port_mut()).await
            }
        };
    }
}

/// Asks the servos.
async fn ask<U: BusPort>(shared: &Shared, bus: &Bus<U>) {
    let mut line = bus.line().await;
    let Line { servos, turns, took } = &mut *line;
    let goals = bus.goals();
    for turn in turns.iter_mut() {
        turn.goal = goals.get(turn.finger).copied().flatten();
    }
    let asking = shared.quiet.ask();
    let begun = Instant::now();
    servos.tick(turns).await;
    *took = begun.elapsed();
    drop((asking, line));
    bus.has_answered();
}

/// Hears another master, and answers it, until there is another job.
async fn hear<B: Board>(shared: &Shared, bus: &Bus<B::Bus>, port: &mut B::Bus) -> Job {
    let mut chunk = [0; CHUNK];
    let mut full = 0;
    loop {
        if full > LOUD {
            full = 0;
            Timer::after_micros(BREATH_US).await;
        }
        let deadline_us = bus.ears().await.as_ref().and_then(Ears::deadline);
        let deadline = deadline_us.map_or(Instant::MAX, Instant::from_micros);
        let heard = select4(shared.quiet.held(), port.read(&mut chunk), Timer::at(deadline), bus.job()).await;
        let was_held = matches!(heard, Either4::First(()));
        let count = match heard {
            Either4::First(()) => {
                throw_away(shared, port, &mut chunk);
                0
            }
            Either4::Second(Ok(count)) => count,
            Either4::Second(Err(_)) => {
                shared.add(|counters| &mut counters.bus_other);
                // A port that fails at once must not take all of the processor.
                Timer::after_micros(100).await;
                0
            }
            Either4::Third(()) => 0,
            Either4::Fourth(job) => return job,
        };
        full = if count == CHUNK { full + 1 } else { 0 };
        let (now, heard_ticks) = (now_us(), port.heard_ticks());
        let mut rest = chunk.get(..count).unwrap_or_default();
        if let Some(ears) = &mut *bus.ears().await {
            if was_held {
                ears.were_deaf();
            }
            ears.overhear(shared, now, rest, heard_ticks);
        }
        while let Some(said) = answer(bus, now, &mut rest).await {
            // After a pause it is another device that has been waited for.
            if count > 0 {
                note::<B>(shared, &said, port.heard_ticks());
            }
            say::<B>(shared, bus, port, &said).await;
        }
        bus.has_heard();
    }
}

/// Throws away what has come and was not read: a question in it is over by now, and the age of an answer is not known.
#[inline(never)]
fn throw_away(shared: &Shared, port: &mut impl Read, chunk: &mut [u8]) {
    let chunks = (0..WAITING).take_while(|_| matches!(poll_once(port.read(chunk)), Poll::Ready(Ok(1..)))).count();
    if chunks > 0 {
        shared.add(|counters| &mut counters.bus_damaged);
    }
}

async fn answer<U: BusPort>(bus: &Bus<U>, now: u64, rest: &mut &[u8]) -> Option<Said> {
    bus.ears().await.as_mut()?.voice.as_mut()?.answer(now, rest)
}

/// Notes how long an answer has taken.
fn note<B: Board>(shared: &Shared, said: &Said, heard_ticks: Option<u32>) {
    let Some(heard) = heard_ticks else { return };
    let ticks = B::cost_ticks().wrapping_sub(heard);
    let is_late = said.delay_us > 0 && microseconds::<B>(ticks) > u64::from(said.delay_us);
    shared.count(|counters| {
        counters.answer = ticks;
        counters.answer_most = counters.answer_most.max(ticks);
        counters.late_answers = counters.late_answers.wrapping_add(u32::from(is_late));
    });
}

fn microseconds<B: Board>(ticks: u32) -> u64 {
    u64::from(ticks) * 1_000_000 / u64::from(B::COST_HZ.max(1))
}

/// Sends an answer, and has the tap hear it like everybody else: a port does not hear itself.
async fn say<B: Board>(shared: &Shared, bus: &Bus<B::Bus>, port: &mut B::Bus, said: &Said) {
    let asking = shared.quiet.ask();
    if said.delay_us > 0 {
        // From the end of the question on.
        let ticks = port.heard_ticks().map_or(0, |heard| B::cost_ticks().wrapping_sub(heard));
        let wait_us = u64::from(said.delay_us).saturating_sub(microseconds::<B>(ticks));
        listen_for(wait_us, shared, bus, port).await;
    }
    if !(write_all(port, &said.bytes).await && port.flush().await.is_ok()) {
        shared.add(|counters| &mut counters.bus_other);
    }
    drop(asking);
    if let Some(ears) = &mut *bus.ears().await {
        ears.hear_own(&said.bytes);
    }
}

/// Hears others for so many µs. Behind a broadcast Ping that may be most of a second, in which a master that does not wait as long reads
/// positions: kept in the port, they would be heard behind the answer, and count as new then.
async fn listen_for<U: BusPort>(us: u64, shared: &Shared, bus: &Bus<U>, port: &mut U) {
    let mut chunk = [0; CHUNK];
    let mut until = Timer::after_micros(us);
    while let Either::Second(heard) = select(&mut until, port.read(&mut chunk)).await {
        let Ok(count) = heard else {
            shared.add(|counters| &mut counters.bus_other);
            return until.await;
        };
        let heard = chunk.get(..count).unwrap_or_default();
        if let Some(ears) = &mut *bus.ears().await {
            ears.overhear(shared, now_us(), heard, port.heard_ticks());
        }
        bus.has_heard();
    }
}

#[cfg(test)]
mod tests {
    use core::convert::Infallible;
    use core::future::Future;
    use core::pin::pin;
    use core::task::{Context, Waker};
    use std::cell::RefCell;
    use std::collections::VecDeque;
    use std::vec::Vec;

    use dynamixel::{Id, Instruction, Model, encode};
    use embassy_futures::block_on;
    use embassy_time::{Duration, MockDriver};
    use embedded_io_async::ErrorType;
    use embedded_storage::nor_flash::{self, NorFlash, NorFlashErrorKind, ReadNorFlash};
    use messages::{FINGERS, Role, Settings};

    use super::*;
    use crate::board::Watchdog;

    /// A bus on which others speak.
    #[derive(Default)]
    struct Wire {
        waiting: RefCell<VecDeque<u8>>,
        said: RefCell<Vec<u8>>,
    }

    impl ErrorType for &Wire {
        type Error = Infallible;
    }

    impl Read for &Wire {
        async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
            core::future::poll_fn(|_| {
                let mut waiting = self.waiting.borrow_mut();
                let count = waiting.len().min(buffer.len());
                buffer.iter_mut().zip(waiting.drain(..count)).for_each(|(to, byte)| *to = byte);
                if count == 0 { Poll::Pending } else { Poll::Ready(Ok(count)) }
            })
            .await
        }
    }

    impl Write for &Wire {
        async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
            self.said.borrow_mut().extend(bytes);
            Ok(bytes.len())
        }

        async fn flush(&mut self) -> Result<(), Infallible> {
            Ok(())
        }
    }

    impl BusPort for &'static Wire {
        fn set_baud(&mut self, baud: u32) -> u32 {
            baud
        }
    }

    /// What a board has besides its bus, none of which is used here.
    struct Nothing;

    impl nor_flash::ErrorType for Nothing {
        type Error = NorFlashErrorKind;
    }

    impl ReadNorFlash for Nothing {
        const READ_SIZE: usize = 1;

        fn read(&mut self, _: u32, _: &mut [u8]) -> Result<(), NorFlashErrorKind> {
            Ok(())
        }

        fn capacity(&self) -> usize {
            0
        }
    }

    impl NorFlash for Nothing {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = 4;

        fn erase(&mut self, _: u32, _: u32) -> Result<(), NorFlashErrorKind> {
            Ok(())
        }

        fn write(&mut self, _: u32, _: &[u8]) -> Result<(), NorFlashErrorKind> {
            Ok(())
        }
    }

    impl Watchdog for Nothing {
        fn feed(&mut self) {}
    }

    impl Board for Nothing {
        type Bus = &'static Wire;
        type Flash = Self;
        type Watchdog = Self;
        const NAME: &'static str = "none";
        const FINGERS: usize = FINGERS;
        const BUS_LATENCY_US: u32 = 500;
        const ANSWER_US: u32 = 100;
        const COST_HZ: u32 = 1_000_000;
        const WATCHDOG_MS: u32 = 1_000;
        const FLASH_STALLS: bool = true;

        fn cost_ticks() -> u32 {
            0
        }

        fn restart(last_words: &'static str) -> ! {
            panic!("{last_words}")
        }
    }

    /// A gripper that is a device by this address, and watches a servo.
    fn device(own: Id, servo: Id) -> (&'static Wire, Bus<&'static Wire>) {
        let wire: &'static Wire = std::boxed::Box::leak(std::boxed::Box::default());
        let bus = Bus::<&'static Wire>::new(wire, Nothing::BUS_LATENCY_US);
        let settings = Settings { role: Role::Device { id: own.get(), return_delay: 0 }, ..Settings::DEFAULT };
        block_on(async {
            let ears = &mut *bus.ears().await;
            Ears::open::<Nothing>(ears, &settings, 1_000_000);
            ears.as_mut().unwrap().watch(servo, Model::XM430);
        });
        (wire, bus)
    }

    /// The processor was held while a sector was erased: the questions that waited are not answered any more, and the answers to them are not
    /// taken for those of a servo that is where it says now.
    #[test]
    fn what_came_while_flash_was_erased_is_neither_answered_nor_learnt_from() {
        let (servo, own) = (Id::new(1).unwrap(), Id::new(100).unwrap());
        let (wire, bus) = device(own, servo);
        let shared = Shared::new();
        let (mut port, polled) = (wire, &mut Context::from_waker(Waker::noop()));
        let mut hearing = pin!(hear::<Nothing>(&shared, &bus, &mut port));
        // A read of the servo's position, its answer, and a ping of the gripper.
        let traffic = |position: i32| {
            let mut buffer = [0; 64];
            let mut bytes = encode(&mut buffer, servo, Instruction::Read, &[132, 0, 4, 0]).unwrap().to_vec();
            let answer = [&[0][..], &position.to_le_bytes()].concat();
            bytes.extend(encode(&mut buffer, servo, Instruction::Status, &answer).unwrap());
            bytes.extend(encode(&mut buffer, own, Instruction::Ping, &[]).unwrap());
            wire.waiting.borrow_mut().extend(bytes);
        };
        let seen = || block_on(bus.ears()).as_ref().unwrap().sight(servo).and_then(|sight| sight.position);
        assert!(hearing.as_mut().poll(polled).is_pending());
        traffic(1000);
        block_on(shared.quiet.when(|| MockDriver::get().advance(Duration::from_millis(2))));
        assert!(hearing.as_mut().poll(polled).is_pending());
        assert_eq!((seen(), wire.said.borrow().len()), (None, 0));
        // What is heard from then on counts as ever.
        traffic(1001);
        assert!(hearing.as_mut().poll(polled).is_pending());
        assert_eq!(seen().map(|seen| seen.value), Some(1001));
        assert_eq!(wire.said.borrow().len(), 14, "an answer to a ping");
    }

    /// An answer to a broadcast Ping comes as late as the address is high. What others say until then is heard when they say it.
    #[test]
    fn positions_are_heard_while_a_broadcast_ping_waits_for_its_answer() {
        let (servo, own) = (Id::new(1).unwrap(), Id::new(100).unwrap());
        let (wire, bus) = device(own, servo);
        let shared = Shared::new();
        let (mut port, polled) = (wire, &mut Context::from_waker(Waker::noop()));
        let mut hearing = pin!(hear::<Nothing>(&shared, &bus, &mut port));
        let mut say = |packets: &[(Id, Instruction, &[u8])]| {
            for (id, instruction, parameters) in packets {
                let mut buffer = [0; 64];
                wire.waiting.borrow_mut().extend(encode(&mut buffer, *id, *instruction, parameters).unwrap());
            }
            assert!(hearing.as_mut().poll(polled).is_pending());
        };
        say(&[(Id::BROADCAST, Instruction::Ping, &[])]);
        MockDriver::get().advance(Duration::from_millis(20));
        // The clock is every test's: a question and its answer at once, and bounds of their time.
        let before_us = now_us();
        say(&[(servo, Instruction::Read, &[132, 0, 4, 0]), (servo, Instruction::Status, &[0, 0xE8, 3, 0, 0])]);
        let after_us = now_us();
        MockDriver::get().advance(Duration::from_millis(300));
        assert!(hearing.as_mut().poll(polled).is_pending());
        assert_eq!(wire.said.borrow().len(), 14, "an answer to a ping");
        let seen = block_on(bus.ears()).as_ref().unwrap().sight(servo).and_then(|sight| sight.position);
        let seen = seen.expect("a position");
        assert!(
            seen.value == 1000 && (before_us..=after_us).contains(&seen.at_us),
            "{seen:?} in {before_us}..{after_us}"
        );
    }
}
