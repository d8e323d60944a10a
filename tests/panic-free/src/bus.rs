//! The bus: a master that asks everything there is, a device that answers everything, a listener.

use core::hint::black_box;

use dynamixel::{
    Backup, BulkAnswer, BulkWrite, ControlTable, Device, Id, ResetScope, StatusError, StatusReturn, SyncAnswer, Tap,
    Timing, blocking::Master, check_read, writes, xm430,
};
use embedded_hal::delay::DelayNs;
use embedded_io::{ErrorKind, ErrorType, Read, ReadReady, Write};

/// A port on which anything can arrive.
struct Port;

impl ErrorType for Port {
    type Error = ErrorKind;
}

impl ReadReady for Port {
    fn read_ready(&mut self) -> Result<bool, ErrorKind> {
        black_box(Ok(true))
    }
}

impl Read for Port {
    fn read(&mut self, into: &mut [u8]) -> Result<usize, ErrorKind> {
        for place in into {
            *place = black_box(0);
        }
        black_box(Ok(0))
    }
}

impl Write for Port {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        black_box(bytes);
        black_box(Ok(0))
    }

    fn flush(&mut self) -> Result<(), ErrorKind> {
        black_box(Ok(()))
    }
}

/// Time that passes.
struct Wait;

impl DelayNs for Wait {
    fn delay_ns(&mut self, ns: u32) {
        black_box(ns);
    }
}

/// A control table of which anything can become.
struct Table;

impl ControlTable for Table {
    fn id(&self) -> Id {
        black_box(Id::MAX)
    }

    fn model_number(&self) -> u16 {
        black_box(xm430::MODEL)
    }

    fn firmware_version(&self) -> u8 {
        black_box(xm430::FAST_READ_FIRMWARE)
    }

    fn status_return(&self) -> StatusReturn {
        black_box(StatusReturn::All)
    }

    fn read(&mut self, address: u16, bytes: &mut [u8]) -> Result<(), StatusError> {
        bytes.fill(black_box(0));
        check_read(&xm430::ITEMS, address, bytes.len())
    }

    fn write(&mut self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        writes(&xm430::ITEMS, black_box(false), address, bytes).try_for_each(|part| black_box(part).map(|_| ()))
    }

    fn factory_reset(&mut self, scope: ResetScope) -> Result<(), StatusError> {
        black_box(scope);
        black_box(Ok(()))
    }

    fn backup(&mut self, what: Backup) -> Result<(), StatusError> {
        black_box(what);
        black_box(Ok(()))
    }
}

/// Who is on the bus.
pub struct Bus {
    master: Master<Port, Wait>,
    device: Device<128>,
    tap: Tap<128, 2>,
}

impl Bus {
    /// Nobody has said anything.
    pub fn new() -> Self {
        let timing = Timing::at(1_000_000);
        Self { master: Master::new(Port, Wait, timing), device: Device::new(timing), tap: Tap::new(timing) }
    }

    /// Everything once.
    pub fn run(&mut self) {
        self.ask();
        self.ask_several();
        self.answer();
    }

    fn ask(&mut self) {
        let (master, id) = (&mut self.master, black_box(Id::MAX));
        black_box(master.ping(id).is_ok());
        black_box(master.discover(&mut [None; 4]).is_ok());
        black_box(master.get(id, xm430::PRESENT_POSITION).is_ok());
        black_box(master.set(id, xm430::GOAL_POSITION, black_box(0)).is_ok());
        black_box(master.write(id, black_box(0), black_box(&[0; 4])).is_ok());
        black_box(master.reg_write(id, black_box(0), black_box(&[0; 4])).is_ok());
        black_box(master.action(id).is_ok());
        black_box(master.reboot(id).is_ok());
        black_box(master.factory_reset(id, black_box(ResetScope::ExceptId)).is_ok());
        black_box(master.clear_turns(id).is_ok());
        black_box(master.backup(id, black_box(Backup::Store)).is_ok());
    }

    fn ask_several(&mut self) {
        let (master, id) = (&mut self.master, black_box(Id::MAX));
        let mut same = [SyncAnswer::<_, 10>::new(id); 2];
        black_box(master.sync_read(black_box(126), &mut same).is_ok());
        black_box(master.fast_sync_read(black_box(126), &mut same).is_ok());
        black_box(master.sync_write(black_box(116), &[(id, black_box([0; 4])); 2]).is_ok());
        let (mut one, mut two) = ([0; 4], [0; 2]);
        let mut different = [BulkAnswer::new(id, 132, &mut one), BulkAnswer::new(black_box(id), 144, &mut two)];
        black_box(master.bulk_read(&mut different).is_ok());
        black_box(master.fast_bulk_read(&mut different).is_ok());
        black_box(master.bulk_write(&[BulkWrite { id, address: 116, bytes: black_box(&[0; 4]) }]).is_ok());
    }

    fn answer(&mut self) {
        let now_us = black_box(0);
        let mut heard: &[u8] = black_box(&[0; 64]);
        while let Some(reply) = self.device.hear(now_us, &mut heard, &mut Table) {
            black_box(reply);
        }
        black_box(self.device.poll(now_us, &mut Table));
        black_box(self.device.deadline());
        let mut heard: &[u8] = black_box(&[0; 64]);
        while let Some(heard) = self.tap.hear(now_us, &mut heard) {
            black_box(heard);
        }
    }
}
