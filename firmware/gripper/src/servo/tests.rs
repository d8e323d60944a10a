//! Transactions of a tick with devices in memory.

use super::*;
use core::convert::Infallible;
use core::future::poll_fn;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use dynamixel::{ControlTable, Device, Instruction};
use embassy_time::{Duration, MockDriver};
use embedded_io_async::{ErrorType, Read, Write};
use std::collections::VecDeque;

/// As every servo is wanted here.
const HOLDS: Wanted = Wanted { commissioned: None, fence: None, holds: true };

/// A servo's registers; `knows` is whether it does what its firmware promises.
struct Table {
    memory: [u8; 148],
    knows: bool,
}

impl ControlTable for Table {
    fn id(&self) -> Id {
        Id::new(self.memory[7]).unwrap()
    }
    fn model_number(&self) -> u16 {
        xm430::MODEL
    }
    fn firmware_version(&self) -> u8 {
        self.memory[6]
    }
    fn fast_reads(&self) -> bool {
        self.knows
    }
    fn status_return(&self) -> StatusReturn {
        StatusReturn::from_value(self.memory[68]).unwrap()
    }
    fn read(&mut self, address: u16, bytes: &mut [u8]) -> Result<(), StatusError> {
        bytes.copy_from_slice(&self.memory[usize::from(address)..][..bytes.len()]);
        Ok(())
    }
    fn write(&mut self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        let mode = self.memory[11];
        self.memory[usize::from(address)..][..bytes.len()].copy_from_slice(bytes);
        if self.memory[11] != mode {
            // The gain is the factory's again, and the position within its revolution.
            [self.memory[84], self.memory[85]] = 800_u16.to_le_bytes();
            self.memory[133] &= 0x0F;
        }
        Ok(())
    }
}

/// Two servos, whose answers come at once.
struct Wire {
    servos: [(Device<128>, Table); 2],
    inbox: VecDeque<u8>,
    asked: Vec<u8, 64>,
    baud: u32,
    /// How many common writes noise will damage.
    noisy: u8,
    /// Which answers are lost, counted from 0.
    lost: std::vec::Vec<u32>,
    answers: u32,
}

impl Wire {
    /// Servos 1 and 2 at 1 Mbaud.
    fn new(firmware: [u8; 2], knows: bool) -> Self {
        let servo = |id: u8, firmware| {
            let mut memory = [0; 148];
            (memory[6], memory[7], memory[8], memory[132]) = (firmware, id, 3, 10 * id);
            // Status Return Level and Max Position Limit, as they come from the factory.
            memory[68] = 2;
            [memory[48], memory[49]] = 4095_u16.to_le_bytes();
            (Device::new(Timing::at(1_000_000)), Table { memory, knows })
        };
        let servos = [servo(1, firmware[0]), servo(2, firmware[1])];
        Self {
            servos,
            inbox: VecDeque::new(),
            asked: Vec::new(),
            baud: 1_000_000,
            noisy: 0,
            lost: std::vec::Vec::new(),
            answers: 0,
        }
    }
}

impl ErrorType for Wire {
    type Error = Infallible;
}

impl Read for Wire {
    async fn read(&mut self, into: &mut [u8]) -> Result<usize, Infallible> {
        poll_fn(|_| {
            let count = into.len().min(self.inbox.len());
            into.iter_mut().zip(self.inbox.drain(..count)).for_each(|(to, byte)| *to = byte);
            if count > 0 { Poll::Ready(Ok(count)) } else { Poll::Pending }
        })
        .await
    }
}

impl Write for Wire {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let _ = self.asked.push(bytes[7]);
        if bytes[7] == Instruction::SyncWrite.code() && self.noisy > 0 {
            self.noisy -= 1;
            return Ok(bytes.len());
        }
        let mut spoken = VecDeque::from([(None, bytes.to_vec())]);
        while let Some((by, words)) = spoken.pop_front() {
            for (index, (device, table)) in self.servos.iter_mut().enumerate().filter(|it| by != Some(it.0)) {
                if xm430::bits_per_second(table.memory[8]) != Some(self.baud) {
                    continue;
                }
                let mut rest = words.as_slice();
                while let Some(reply) = device.hear(0, &mut rest, table) {
                    self.answers += 1;
                    if self.lost.contains(&(self.answers - 1)) {
                        continue;
                    }
                    self.inbox.extend(reply.bytes);
                    spoken.push_back((Some(index), reply.bytes.to_vec()));
                }
            }
        }
        Ok(bytes.len())
    }
    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

impl BusPort for Wire {
    fn set_baud(&mut self, baud: u32) -> u32 {
        // No further than the slowest board.
        self.baud = baud.min(1_500_000);
        self.baud
    }
}

/// Polls, and lets time pass: a silent servo is waited for.
fn wait_for<F: Future>(future: F) -> F::Output {
    let mut future = pin!(future);
    for _ in 0..10_000 {
        if let Poll::Ready(output) = future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            return output;
        }
        MockDriver::get().advance(Duration::from_micros(100));
    }
    panic!("a second has passed");
}

fn ready(wire: Wire) -> Servos<Wire> {
    let mut servos = Servos::new(wire, 2_000);
    for finger in [0, 1] {
        let id = Id::new(finger as u8 + 1).unwrap();
        let rates = Rates { look: 1_000_000, wanted: None, bus: None };
        wait_for(servos.bring_up(finger, id, rates, HOLDS)).unwrap();
    }
    servos
}

/// A tick that leads nobody anywhere: the positions read, and the instruction that asked for them.
fn tick(servos: &mut Servos<Wire>) -> ([Option<i32>; 2], u8) {
    tick_to(servos, [10, 20])
}

/// A tick with these goals.
fn tick_to(servos: &mut Servos<Wire>, goals: [i32; 2]) -> ([Option<i32>; 2], u8) {
    let mut turns = [0, 1]
        .map(|finger| Turn { goal: Some(goals[finger]), ..Turn::new(finger, Id::new(finger as u8 + 1).unwrap()) });
    servos.master.port_mut().asked.clear();
    wait_for(servos.tick(&mut turns));
    let asked = servos.master.port_mut().asked[0];
    (turns.map(|turn| turn.result.ok().map(|reading| reading.position)), asked)
}

#[test]
fn servos_are_read_together_as_fast_as_all_of_them_know_how() {
    let (fast, plain) = (Instruction::FastSyncRead.code(), Instruction::SyncRead.code());
    for (firmware, asked) in [([45, 45], fast), ([45, 44], plain), ([44, 44], plain)] {
        let mut servos = ready(Wire::new(firmware, true));
        assert_eq!(tick(&mut servos), ([Some(10), Some(20)], asked), "{firmware:?}");
        assert_eq!(tick(&mut servos), ([Some(10), Some(20)], asked), "{firmware:?}");
    }
}

#[test]
fn a_servo_that_does_not_keep_its_promise_costs_no_tick() {
    let mut servos = ready(Wire::new([45, 45], false));
    assert_eq!(tick(&mut servos), ([Some(10), Some(20)], Instruction::FastSyncRead.code()));
    for _ in 0..APART {
        assert_eq!(tick(&mut servos), ([Some(10), Some(20)], Instruction::Read.code()));
    }
    assert_eq!(tick(&mut servos), ([Some(10), Some(20)], Instruction::SyncRead.code()));
}

/// Behind a servo that is silent the others of a common question are silent too: they are asked again in the same tick.
#[test]
fn a_silent_servo_costs_no_other_ones_answer() {
    for firmware in [45, 44] {
        let mut servos = ready(Wire::new([firmware; 2], true));
        assert_eq!(tick(&mut servos).0, [Some(10), Some(20)]);
        // At another rate it hears nothing.
        servos.port_mut().servos[0].1.memory[8] = 1;
        for _ in 0..3 * APART {
            assert_eq!(tick(&mut servos).0, [None, Some(20)]);
        }
    }
}

/// Nobody answers a common write: one that is lost is made good in the ticks after, and then nothing is written any more.
#[test]
fn a_goal_that_noise_has_damaged_is_written_again() {
    let mut servos = ready(Wire::new([45, 45], true));
    tick(&mut servos);
    let goals = |servos: &mut Servos<Wire>| servos.port_mut().servos.each_ref().map(|(_, table)| table.memory[116]);
    for noisy in 0..=AGAIN {
        servos.port_mut().noisy = noisy;
        let to = [30 + noisy, 40];
        let mut writes = 0;
        for _ in 0..6 {
            tick_to(&mut servos, to.map(i32::from));
            writes += servos.port_mut().asked.iter().filter(|code| **code == Instruction::SyncWrite.code()).count();
        }
        assert_eq!((goals(&mut servos), writes), (to, usize::from(1 + AGAIN)), "{noisy}");
    }
}

#[test]
fn servos_come_to_the_rate_that_is_set() {
    let mut wire = Wire::new([45, 45], true);
    // The second as it comes from the factory.
    wire.servos[1].1.memory[8] = xm430::baud_code(57_600).unwrap();
    let mut servos = Servos::new(wire, 2_000);
    let [one, two] = [1, 2].map(|id| Id::new(id).unwrap());
    let at = |look, wanted, bus| Rates { look, wanted, bus };
    wait_for(servos.bring_up(0, one, at(1_000_000, Some(1_000_000), None), HOLDS)).unwrap();
    // Not there at the others' rate, found at its own, led at the others'.
    assert!(wait_for(servos.bring_up(1, two, at(1_000_000, Some(1_000_000), Some(1_000_000)), HOLDS)).is_err());
    // Where no rate is set it stays as it is, and the bus goes on at the others' rate.
    assert!(wait_for(servos.bring_up(1, two, at(57_600, None, Some(1_000_000)), HOLDS)).is_err());
    assert_eq!(servos.port_mut().baud, 1_000_000);
    servos.port_mut().servos[1].1.memory[64] = 0;
    let found = wait_for(servos.bring_up(1, two, at(57_600, Some(1_000_000), Some(1_000_000)), HOLDS)).unwrap();
    assert_eq!(
        (found.baud, servos.port_mut().servos[1].1.memory[8], servos.port_mut().servos[1].1.memory[9]),
        (1_000_000, 3, 0)
    );
    assert_eq!(servos.master.timing().baud_rate, 1_000_000);
    assert_eq!(tick(&mut servos).0, [Some(10), Some(20)]);
}

/// Another rate was set while the servos had torque. One that comes back without goes on at the others' rate: at the new one it would be alone.
#[test]
fn a_servo_that_comes_back_stays_at_the_others_rate() {
    let mut servos = ready(Wire::new([45, 45], true));
    servos.port_mut().servos[1].1.memory[64] = 0;
    let rates = Rates { look: 1_000_000, wanted: Some(57_600), bus: Some(1_000_000) };
    let found = wait_for(servos.bring_up(1, Id::new(2).unwrap(), rates, HOLDS)).map(|found| found.baud);
    assert_eq!((found.ok(), servos.port_mut().servos[1].1.memory[8]), (Some(1_000_000), 3));
}

#[test]
fn everybody_is_discovered_at_his_own_rate() {
    assert_eq!(BAUDS.len(), xm430::BAUD_RATES.len() - 1, "all of the servo's but 9,600");
    assert!(xm430::BAUD_RATES[1..].iter().all(|rate| BAUDS.contains(rate)));
    let mut wire = Wire::new([45, 44], true);
    wire.servos[1].1.memory[8] = xm430::baud_code(57_600).unwrap();
    let mut servos = Servos::new(wire, 2_000);
    // What the port does not reach is not tried; it is left at its rate.
    let rates = servos.rates();
    assert_eq!(rates, [1_000_000, 57_600, 115_200]);
    assert_eq!(servos.port_mut().baud, 1_000_000);
    let mut heard = Vec::<_, 8>::new();
    for rate in rates {
        let mut found = [None; 4];
        let count = wait_for(servos.discover(rate, &mut found)).unwrap();
        assert_eq!(count, found.iter().flatten().count());
        heard.extend(found.into_iter().flatten().map(|found| (rate, found.id.get(), found.identity.firmware)));
    }
    assert_eq!(heard, [(1_000_000, 1, 45), (57_600, 2, 44)]);
    servos.go_on_at(Some(1_000_000));
    assert_eq!((servos.port_mut().baud, servos.master.timing().baud_rate), (1_000_000, 1_000_000));
}

#[test]
fn a_rate_that_the_board_does_not_have_is_left_alone() {
    let mut servos = Servos::new(Wire::new([45, 45], true), 2_000);
    let rates = Rates { look: 1_000_000, wanted: Some(4_000_000), bus: None };
    let found = wait_for(servos.bring_up(0, Id::new(1).unwrap(), rates, HOLDS)).unwrap();
    assert_eq!((found.baud, servos.port_mut().servos[0].1.memory[8]), (1_000_000, 3));
}

/// A lost answer to the first read is noise. Only a servo that never answers reads, beside sound answers to pings, is set to answer them.
#[test]
fn one_lost_answer_is_no_status_return_level() {
    let rates = Rates { look: 1_000_000, wanted: None, bus: None };
    let id = Id::new(1).unwrap();
    let mut wire = Wire::new([45, 45], true);
    // The answer to the ping comes.
    wire.lost = std::vec![1];
    let mut servos = Servos::new(wire, 2_000);
    assert!(wait_for(servos.bring_up(0, id, rates, HOLDS)).is_err());
    let writes = |servos: &mut Servos<Wire>| servos.port_mut().asked.contains(&Instruction::Write.code());
    assert!(!writes(&mut servos));
    assert_eq!(wait_for(servos.bring_up(0, id, rates, HOLDS)).unwrap().difference, None);
    // All of them but those to pings.
    let mut wire = Wire::new([45, 45], true);
    wire.servos[0].1.memory[68] = 0;
    let mut servos = Servos::new(wire, 2_000);
    let difference = wait_for(servos.bring_up(0, id, rates, HOLDS)).unwrap().difference.map(|found| found.field);
    assert_eq!(
        (difference, servos.port_mut().servos[0].1.memory[68]),
        (Some(messages::ServoField::StatusReturnLevel), 2)
    );
    assert_eq!(wait_for(servos.bring_up(0, id, rates, HOLDS)).unwrap().difference, None);
}

/// A change of Operating Mode changes what was read before: gain, position, and with it whether its limits allow that.
#[test]
fn what_a_change_of_mode_resets_is_read_again() {
    let mut wire = Wire::new([45, 45], true);
    let memory = &mut wire.servos[0].1.memory;
    // Several turns away, with another gain.
    memory[11] = 4;
    [memory[84], memory[85]] = 200_u16.to_le_bytes();
    [memory[132], memory[133]] = 5000_u16.to_le_bytes();
    let mut servos = Servos::new(wire, 2_000);
    let rates = Rates { look: 1_000_000, wanted: None, bus: None };
    let found = wait_for(servos.bring_up(0, Id::new(1).unwrap(), rates, HOLDS)).unwrap();
    assert_eq!((found.difference, found.goal, found.gain, found.setup.operating_mode), (None, 904, 800, 3));
    let memory = &servos.port_mut().servos[0].1.memory;
    assert_eq!((memory[64], i16::from_le_bytes([memory[116], memory[117]])), (1, 904));
}

/// A servo that is found with torque keeps its return delay, and all are waited for as long. Once it is found without, it answers at once, and
/// nobody is waited for any more: not even while another one has been there all along.
#[test]
fn a_return_delay_that_is_gone_is_not_waited_for() {
    let mut wire = Wire::new([45, 45], true);
    // As from the factory, and with torque.
    (wire.servos[1].1.memory[9], wire.servos[1].1.memory[11], wire.servos[1].1.memory[64]) = (250, 3, 1);
    let mut servos = ready(wire);
    assert_eq!(servos.master.timing().latency_us, 2_000 + 500);
    servos.port_mut().servos[1].1.memory[64] = 0;
    let rates = Rates { look: 1_000_000, wanted: None, bus: Some(1_000_000) };
    wait_for(servos.bring_up(1, Id::new(2).unwrap(), rates, HOLDS)).unwrap();
    assert_eq!(servos.port_mut().servos[1].1.memory[9], 0);
    assert_eq!(servos.master.timing().latency_us, 2_000);
}
