//! Another master's traffic with servos, frame by frame, in which every value that a register ever shows is unique.

// Not every test uses all of it.
#![allow(dead_code)]

use std::collections::HashMap;

use dynamixel::{ControlTable, Device, Id, Instruction, StatusError, Timing, Value, encode};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// Microseconds of a byte: 1 Mbaud.
pub const BYTE_US: u64 = 10;
/// Whoever is asked answers within this time; the master asks again only after twice as long.
pub const TIMING: Timing = Timing { latency_us: 100, ..Timing::at(1_000_000) };
/// The servos on the bus. 9 is asked as well, and not there.
pub const SERVOS: [u8; 3] = [1, 2, 7];

/// A frame on the wire.
#[derive(Clone, Debug)]
pub struct Frame {
    pub start_us: u64,
    pub bytes: Vec<u8>,
}

impl Frame {
    pub fn end_us(&self) -> u64 {
        self.start_us + self.bytes.len() as u64 * BYTE_US
    }
}

/// A servo with indirect addresses, whose positions are counted.
pub struct Table {
    pub id: u8,
    memory: Vec<u8>,
    count: u32,
    /// Positions told, in their order.
    pub told: Vec<i32>,
}

impl Table {
    fn new(id: u8) -> Self {
        let mut table = Table { id, memory: vec![0; 700], count: 0, told: Vec::new() };
        table.restart();
        table
    }

    fn restart(&mut self) {
        for (addresses, data) in [(168, 224u16), (578, 634)] {
            for place in 0..28 {
                let at = addresses + 2 * usize::from(place);
                self.memory[at..at + 2].copy_from_slice(&(data + place).to_le_bytes());
            }
        }
    }

    /// Where a byte is really read from.
    fn real(&self, address: usize) -> usize {
        for (addresses, data) in [(168, 224), (578, 634)] {
            if (data..data + 28).contains(&address) {
                let at = addresses + 2 * (address - data);
                return usize::from(u16::from_le_bytes([self.memory[at], self.memory[at + 1]]));
            }
        }
        address
    }

    /// Every register of four bytes shows a number that no register of any servo has shown.
    fn refresh(&mut self) {
        self.count += 1;
        for (kind, at) in [104usize, 108, 112, 116, 128, 132, 136, 140].into_iter().enumerate() {
            let unique = (kind as u32) << 28 | u32::from(self.id) << 20 | self.count;
            self.memory[at..at + 4].copy_from_slice(&unique.to_le_bytes());
        }
    }
}

impl ControlTable for Table {
    fn id(&self) -> Id {
        Id::new(self.id).unwrap()
    }
    fn model_number(&self) -> u16 {
        1020
    }
    fn firmware_version(&self) -> u8 {
        45
    }
    fn read(&mut self, address: u16, bytes: &mut [u8]) -> Result<(), StatusError> {
        if usize::from(address) + bytes.len() > self.memory.len() {
            return Err(StatusError::Access);
        }
        self.refresh();
        let mut position = HashMap::new();
        for (place, byte) in bytes.iter_mut().enumerate() {
            let real = self.real(usize::from(address) + place);
            *byte = self.memory[real];
            position.insert(real, *byte);
        }
        let position: Option<Vec<u8>> = (132..136).map(|at| position.get(&at).copied()).collect();
        if let Some(position) = position {
            self.told.push(i32::from_bytes(position.try_into().unwrap()));
        }
        Ok(())
    }
    fn write(&mut self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        let from = usize::from(address);
        // The numbers that have to be unique stay so.
        if (104..144).contains(&address) {
            return Ok(());
        }
        self.memory.get_mut(from..from + bytes.len()).ok_or(StatusError::Access)?.copy_from_slice(bytes);
        Ok(())
    }
    fn reboot(&mut self) -> Result<(), StatusError> {
        self.restart();
        Ok(())
    }
}

/// The bus of another master.
pub struct Traffic {
    pub now_us: u64,
    pub servos: Vec<(Device<256>, Table)>,
    pub random: ChaCha8Rng,
    /// Whether the master changes indirect addresses, and restarts servos.
    pub redirects: bool,
}

impl Traffic {
    pub fn new(seed: u64) -> Self {
        let servos = SERVOS.map(|id| (Device::new(TIMING), Table::new(id))).into();
        Traffic { now_us: 1_000, servos, random: ChaCha8Rng::seed_from_u64(seed), redirects: true }
    }

    pub fn below(&mut self, limit: usize) -> usize {
        self.random.next_u32() as usize % limit
    }

    pub fn servo(&self, id: u8) -> &Table {
        &self.servos.iter().find(|(_, table)| table.id == id).unwrap().1
    }

    /// A question and what comes of it: the frames, the question first.
    pub fn ask(&mut self, id: u8, instruction: Instruction, parameters: &[u8]) -> Vec<Frame> {
        let id = Id::new(id).unwrap_or(Id::BROADCAST);
        let bytes = encode(&mut [0; 256], id, instruction, parameters).unwrap().to_vec();
        let mut frames = vec![Frame { start_us: self.now_us, bytes }];
        let mut by = None;
        // One speaks at a time, and what is said is heard by all others.
        loop {
            let last = frames.last().unwrap();
            let heard_us = last.end_us();
            let mut next: Option<(u64, usize, Vec<u8>)> = None;
            for (index, (device, table)) in self.servos.iter_mut().enumerate() {
                let mut bytes = last.bytes.as_slice();
                while by != Some(index)
                    && let Some(reply) = device.hear(heard_us, &mut bytes, table)
                {
                    next = Some((heard_us + u64::from(reply.delay_us), index, reply.bytes.to_vec()));
                }
            }
            if next.is_none() {
                let waiting = self.servos.iter_mut().enumerate();
                let waiting = waiting.filter_map(|(index, (device, _))| Some((device.deadline()?, index)));
                if let Some((due_us, index)) = waiting.min() {
                    let (device, table) = &mut self.servos[index];
                    next = device.poll(due_us, table).map(|reply| (due_us, index, reply.bytes.to_vec()));
                }
            }
            let Some((start_us, index, bytes)) = next else { break };
            by = Some(index);
            frames.push(Frame { start_us, bytes });
        }
        self.now_us = frames.last().unwrap().end_us() + 2 * u64::from(TIMING.latency_us) + 100;
        // Devices give up what was cut short by silence.
        for (device, table) in &mut self.servos {
            assert!(device.poll(self.now_us, table).is_none());
        }
        frames
    }

    fn some(&mut self) -> u8 {
        SERVOS[self.below(SERVOS.len())]
    }

    /// Several servos, each once, in any order, now and then one that is not there.
    fn several(&mut self) -> Vec<u8> {
        let mut ids = vec![1, 2, 7, 9];
        let start = self.below(4);
        ids.rotate_left(start);
        if self.below(2) == 0 {
            ids.swap(0, 2);
        }
        if self.below(4) > 0 {
            ids.retain(|&id| id != 9);
        }
        ids.truncate(1 + self.below(ids.len()));
        ids
    }

    /// Some part of the control table: often four bytes, often with the position.
    fn part(&mut self) -> [u8; 4] {
        let parts: [(u16, u16); 9] =
            [(132, 4), (132, 4), (128, 4), (126, 10), (116, 4), (136, 4), (224, 4), (634, 4), (120, 27)];
        let (address, length) = parts[self.below(parts.len())];
        let ([a, b], [c, d]) = (address.to_le_bytes(), length.to_le_bytes());
        [a, b, c, d]
    }

    /// Something that a master may want.
    pub fn anything(&mut self) -> Vec<Frame> {
        let id = self.some();
        match self.below(16) {
            0..=3 => {
                let part = self.part();
                self.ask(id, Instruction::Read, &part)
            }
            4..=7 => {
                let fast = self.below(2) == 0;
                let instruction = if fast { Instruction::FastSyncRead } else { Instruction::SyncRead };
                let asked = [&self.part()[..], &self.several()].concat();
                self.ask(254, instruction, &asked)
            }
            8 | 9 => {
                let fast = self.below(2) == 0;
                let instruction = if fast { Instruction::FastBulkRead } else { Instruction::BulkRead };
                let ids = self.several();
                let asked: Vec<u8> = ids.into_iter().flat_map(|id| [vec![id], self.part().to_vec()].concat()).collect();
                self.ask(254, instruction, &asked)
            }
            10 if self.redirects => {
                // Indirect data to a register of four bytes: position, velocity, trajectory.
                let at = [128u16, 132, 136][self.below(3)];
                let shown: Vec<u8> = (at..at + 4).flat_map(u16::to_le_bytes).collect();
                let area = [168u16, 578][self.below(2)].to_le_bytes();
                if self.below(2) == 0 {
                    self.ask(id, Instruction::Write, &[&area, shown.as_slice()].concat())
                } else {
                    let several = [&area[..], &8u16.to_le_bytes(), &[id], &shown].concat();
                    self.ask(254, Instruction::SyncWrite, &several)
                }
            }
            11 => self.ask(id, Instruction::Ping, &[]),
            12 => self.ask(id, Instruction::Write, &[116, 0, 1, 2, 3, 4]),
            13 => self.ask(9, Instruction::Read, &[132, 0, 4, 0]),
            14 if self.redirects && self.below(8) == 0 => self.ask(id, Instruction::Reboot, &[]),
            14 => self.ask(id, Instruction::Read, &[168, 0, 8, 0]),
            _ => self.ask(id, Instruction::Read, &[0xFF, 0xFF, 1, 0]),
        }
    }
}

/// The number of Present Position as told: position's kind is 5.
pub fn is_position(id: u8, value: i32) -> bool {
    (value as u32) >> 20 == 5 << 8 | u32::from(id)
}
