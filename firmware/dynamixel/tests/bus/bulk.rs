//! Reads and writes of different bytes of several devices.

use dynamixel::{Answer, BulkAnswer, BulkWrite, Error, Id, xm430};

use crate::world::Bus;
use crate::{id, master};

#[test]
fn different_bytes_of_several_devices() {
    let bus = Bus::new(&[1, 7, 3]);
    bus.servo(0, |servo| servo.put(xm430::PRESENT_POSITION, i32::from_le_bytes([0xFF, 0xFF, 0xFD, 0])));
    bus.servo(1, |servo| servo.put(xm430::PRESENT_INPUT_VOLTAGE, 119));
    bus.servo(2, |servo| servo.put(xm430::PRESENT_TEMPERATURE, 36));
    bus.servo(2, |servo| servo.put(xm430::HARDWARE_ERROR_STATUS, 1));
    let mut master = master(&bus);
    for fast in [false, true] {
        let (mut position, mut voltage, mut temperature, mut nothing) = ([0; 4], [0; 2], [0; 1], [5; 3]);
        let mut devices = [
            BulkAnswer::new(id(7), 144, &mut voltage),
            BulkAnswer::new(id(3), 146, &mut temperature),
            BulkAnswer::new(id(1), 132, &mut position),
            BulkAnswer::new(id(9), 132, &mut nothing),
        ];
        let asked =
            if fast { bus.run(master.fast_bulk_read(&mut devices)) } else { bus.run(master.bulk_read(&mut devices)) };
        assert_eq!(asked, Ok(()));
        let results = devices.map(|device| device.result.unwrap());
        assert_eq!(results[..3], [false, true, false].map(|alert| Ok(Answer { value: (), alert })));
        assert!(matches!(results[3], Err(Error::Timeout { .. })), "{:?}", results[3]);
        assert_eq!((voltage, temperature, nothing), ([119, 0], [36], [5; 3]));
        assert_eq!(position, [0xFF, 0xFF, 0xFD, 0]);
    }
    let writes = [
        BulkWrite { id: id(1), address: 116, bytes: &[150, 0, 0, 0] },
        BulkWrite { id: id(7), address: 65, bytes: &[1] },
    ];
    assert_eq!(bus.run(master.bulk_write(&writes)), Ok(()));
    bus.rest(1_000);
    assert_eq!(bus.servo(0, |servo| servo.value(xm430::GOAL_POSITION)), 150);
    assert_eq!([1, 2].map(|index| bus.servo(index, |servo| servo.value(xm430::LED))), [1, 0]);

    let sent = bus.0.borrow().sent.len();
    let twice = [writes[0], BulkWrite { address: 65, bytes: &[1], ..writes[0] }];
    assert_eq!(bus.run(master.bulk_write(&twice)), Err(Error::Twice { id: id(1) }));
    let everyone = [BulkWrite { id: Id::BROADCAST, ..writes[0] }];
    assert_eq!(bus.run(master.bulk_write(&everyone)), Err(Error::Broadcast));
    assert_eq!(bus.0.borrow().sent.len(), sent);
}
