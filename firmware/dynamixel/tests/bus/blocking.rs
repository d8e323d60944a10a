//! The blocking master does what the asynchronous one does, in the same time on the bus.

use std::convert::Infallible;

use dynamixel::blocking::Master;
use dynamixel::{BulkAnswer, BulkWrite, Error, Id, StatusError, SyncAnswer, xm430};
use embedded_hal::delay::DelayNs;
use embedded_io::{ErrorType, Read, ReadReady, Write};

use crate::world::Bus;
use crate::{TIMING, id};

/// The bus as a port without an executor.
struct Port(Bus);

/// Time that passes while somebody waits.
struct Wait {
    bus: Bus,
    /// Part of a microsecond that has passed.
    ns: u32,
}

impl ErrorType for Port {
    type Error = Infallible;
}

impl ReadReady for Port {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.0.waiting() > 0)
    }
}

impl Read for Port {
    fn read(&mut self, into: &mut [u8]) -> Result<usize, Infallible> {
        let mut bus = self.0.clone();
        self.0.run(embedded_io_async::Read::read(&mut bus, into))
    }
}

impl Write for Port {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let mut bus = self.0.clone();
        self.0.run(embedded_io_async::Write::write(&mut bus, bytes))
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        let mut bus = self.0.clone();
        self.0.run(embedded_io_async::Write::flush(&mut bus))
    }
}

impl DelayNs for Wait {
    fn delay_ns(&mut self, ns: u32) {
        let all = self.ns + ns;
        self.ns = all % 1_000;
        self.bus.rest(u64::from(all / 1_000));
    }
}

fn master(bus: &Bus) -> Master<Port, Wait> {
    Master::new(Port(bus.clone()), Wait { bus: bus.clone(), ns: 0 }, TIMING)
}

#[test]
fn asks_and_is_answered() {
    let bus = Bus::new(&[1, 2]);
    bus.servo(1, |servo| servo.put(xm430::PRESENT_POSITION, -5_000));
    let mut master = master(&bus);
    assert_eq!(master.ping(id(2)).unwrap().value.model, 1020);
    assert_eq!(master.get(id(2), xm430::PRESENT_POSITION).unwrap().value, -5_000);
    assert_eq!(master.set(id(1), xm430::GOAL_POSITION, 2_048).map(|answer| answer.alert), Ok(false));
    assert_eq!(bus.servo(0, |servo| servo.value(xm430::GOAL_POSITION)), 2_048);
    let refused = master.write(id(1), 132, &[0; 4]);
    assert_eq!(refused, Err(Error::Refused { id: id(1), error: StatusError::Access, alert: false }));

    assert!(master.reg_write(id(2), 116, &7u32.to_le_bytes()).is_ok());
    assert_eq!(bus.servo(1, |servo| servo.value(xm430::GOAL_POSITION)), 0);
    assert!(master.action(Id::BROADCAST).is_ok());
    bus.rest(1_000);
    assert_eq!(bus.servo(1, |servo| servo.value(xm430::GOAL_POSITION)), 7);

    let mut found = [None; 4];
    assert_eq!(master.discover(&mut found), Ok(2));
    assert_eq!(found.map(|found| found.map(|found| found.id.get())), [Some(1), Some(2), None, None]);
}

#[test]
fn several_devices_at_once() {
    let bus = Bus::new(&[1, 2]);
    bus.servo(0, |servo| servo.put(xm430::PRESENT_POSITION, 166));
    bus.servo(1, |servo| servo.put(xm430::PRESENT_TEMPERATURE, 36));
    let mut master = master(&bus);
    let mut same = [2, 1].map(|n| SyncAnswer::<_, 4>::new(id(n)));
    assert_eq!(master.fast_sync_read(132, &mut same), Ok(()));
    assert_eq!(same.map(|device| i32::from_le_bytes(device.result.unwrap().unwrap().value)), [0, 166]);
    let (mut position, mut temperature) = ([0; 4], [0; 1]);
    let mut different = [BulkAnswer::new(id(1), 132, &mut position), BulkAnswer::new(id(2), 146, &mut temperature)];
    assert_eq!(master.bulk_read(&mut different), Ok(()));
    assert!(different.iter().all(|device| matches!(device.result, Some(Ok(_)))));
    assert_eq!((i32::from_le_bytes(position), temperature), (166, [36]));
    let writes = [BulkWrite { id: id(1), address: 116, bytes: &[9, 0, 0, 0] }];
    assert_eq!(master.bulk_write(&writes), Ok(()));
    bus.rest(1_000);
    assert_eq!(bus.servo(0, |servo| servo.value(xm430::GOAL_POSITION)), 9);
}

/// Deadlines end as they are stated: never sooner, and by not more than a step later, for this bus takes no time to compute.
#[test]
fn silence_ends_at_the_deadline() {
    let bus = Bus::new(&[1]);
    let mut master = master(&bus);
    master.ping(id(1)).unwrap();
    let start = bus.now_us();
    let Err(Error::Timeout { waited_us, .. }) = master.ping(id(77)) else { panic!("nobody has this address") };
    // The question takes 100 µs; the wait counts from its end.
    let passed = bus.now_us() - start - 100;
    assert!((u64::from(waited_us)..=u64::from(waited_us) + 5).contains(&passed), "{passed} {waited_us}");
    // And the bus is in order again.
    assert!(master.ping(id(1)).is_ok());
}
