//! The gripper's control table, read and written as a master on the bus would.

use dynamixel::{Access, ControlTable, Decoder, Device, Id, Instruction, StatusError, Timing, encode};
use gripper::device_table::{
    BLOCK, BLOCKS, BusSettings, Change, DeviceTable, FIRST_BLOCK, FingerBlock, FingerSettings, FingerState, ITEMS,
};
use model_core::estimator::Estimate;
use model_core::object::ObjectDesign;
use model_core::status::Status;

const ME: u8 = 100;

fn table(fingers: usize) -> DeviceTable {
    let bus = BusSettings { id: Id::new(ME).unwrap(), baud_rate: 1_000_000, return_delay: 0 };
    DeviceTable::new(&bus, 7, fingers, 10)
}

/// What the gripper answers: error and data.
fn ask(table: &mut DeviceTable, instruction: Instruction, parameters: &[u8]) -> (Option<StatusError>, bool, Vec<u8>) {
    let mut device = Device::<256>::new(Timing::at(1_000_000));
    let mut buffer = [0; 256];
    let mut question = encode(&mut buffer, Id::new(ME).unwrap(), instruction, parameters).unwrap();
    let reply = device.hear(0, &mut question, table).unwrap();
    let mut decoder = Decoder::<256>::new();
    let packet = decoder.feed(&mut &*reply.bytes).unwrap().unwrap();
    let status = packet.status().unwrap();
    (status.error, status.alert, status.parameters.to_vec())
}

fn read(table: &mut DeviceTable, address: u16, length: u16) -> (Option<StatusError>, Vec<u8>) {
    let parameters = [address.to_le_bytes(), length.to_le_bytes()].concat();
    let (error, _, data) = ask(table, Instruction::Read, &parameters);
    (error, data)
}

fn write(table: &mut DeviceTable, address: u16, bytes: &[u8]) -> Option<StatusError> {
    ask(table, Instruction::Write, &[&address.to_le_bytes(), bytes].concat()).0
}

fn numbers(data: &[u8]) -> Vec<i32> {
    data.chunks_exact(4).map(|four| i32::from_le_bytes(four.try_into().unwrap())).collect()
}

const TOUCHING: FingerState = FingerState {
    estimate: Estimate {
        status: Status::Converged,
        motor_angle: 0.191_986,
        force: [33.4567, -1.2345],
        contact_centre: [1.5, 47.25],
        torque: 812.3456,
        ..Estimate::blank(Status::Converged)
    },
    position: 2173,
    current: -310.4,
    age_us: Some(1234),
    alert: false,
};

#[test]
fn a_finger_is_read_at_once() {
    let mut table = table(2);
    assert!(!table.alert());
    for finger in [0, 1] {
        let at = FIRST_BLOCK + finger as u16 * BLOCK;
        // Before the first tick: nothing to be trusted.
        assert_eq!(read(&mut table, at + 24, 2), (None, vec![9, 0]));
        assert_eq!(read(&mut table, at + 28, 4), (None, vec![0xFF; 4]));
        table.show(finger, &TOUCHING);
        let (error, data) = read(&mut table, at, 40);
        assert_eq!(error, None);
        assert_eq!(numbers(&data[..24]), [33_457, -1_235, 33_479, 1_500, 47_250, 812_346]);
        assert_eq!((data[24], data[25], i16::from_le_bytes([data[26], data[27]])), (0, 1, -310));
        assert_eq!(numbers(&data[28..]), [1_234, 191_986, 2_173]);
    }
}

/// A finger that is taken away takes its hardware error along: otherwise every answer would have the alert from then on.
#[test]
fn a_finger_that_is_gone_alerts_no_more() {
    let mut table = table(2);
    table.show(1, &FingerState { alert: true, ..TOUCHING });
    assert!(table.alert());
    let bus = BusSettings { id: Id::new(ME).unwrap(), baud_rate: 1_000_000, return_delay: 0 };
    table.set_bus(&bus, 2);
    assert!(table.alert());
    table.set_bus(&bus, 1);
    assert!(!table.alert());
}

#[test]
fn a_force_that_is_not_to_be_trusted_says_so() {
    let mut table = table(1);
    let show = |table: &mut DeviceTable, change: fn(&mut FingerState)| {
        let mut state = TOUCHING;
        change(&mut state);
        table.show(0, &state);
        let (_, data) = read(table, FIRST_BLOCK + 24, 2);
        (data[0], data[1])
    };
    assert_eq!(show(&mut table, |_| {}), (0, 1));
    assert_eq!(show(&mut table, |state| state.estimate.age = 1), (0, 1));
    assert_eq!(show(&mut table, |state| state.age_us = None), (0, 0));
    assert_eq!(show(&mut table, |state| state.estimate.status = Status::NoContact), (2, 1));
    assert_eq!(show(&mut table, |state| state.estimate.status = Status::MaxIterations), (4, 0));
    assert_eq!(show(&mut table, |state| state.estimate.status = Status::Stale), (9, 0));
    assert_eq!(show(&mut table, |state| state.estimate.status = Status::Precision), (10, 0));
    assert_eq!(show(&mut table, |state| state.estimate.status = Status::Unsettled), (11, 0));
    assert_eq!(show(&mut table, |state| state.estimate.status = Status::Updating), (12, 0));
    // No number at all is 0, one that does not fit the greatest.
    show(&mut table, |state| state.estimate.force = [f32::NAN, -f32::INFINITY]);
    assert_eq!(numbers(&read(&mut table, FIRST_BLOCK, 8).1), [0, i32::MIN]);
    // A servo's hardware error is told in every answer.
    show(&mut table, |state| state.alert = true);
    assert_eq!(ask(&mut table, Instruction::Ping, &[]), (None, true, vec![b'F', b'R', 7]));
    assert_eq!(read(&mut table, 70, 1).1, [1]);
    show(&mut table, |_| {});
    assert_eq!(ask(&mut table, Instruction::Ping, &[]), (None, false, vec![b'F', b'R', 7]));
}

#[test]
fn an_object_is_taken_whole() {
    let mut table = table(2);
    let at = FIRST_BLOCK + BLOCK + 68;
    let bytes: Vec<u8> = [41_000, -5_500, 40_000].into_iter().flat_map(i32::to_le_bytes).collect();
    // A centre without a radius is no object yet.
    assert_eq!(write(&mut table, at, &bytes[..8]), None);
    assert_eq!((table.take(), read(&mut table, at - 4, 1).1), (None, vec![0]));
    assert_eq!(write(&mut table, at, &bytes), None);
    let circle = ObjectDesign::Circle { centre: [41.0, -5.5], radius: 40.0 };
    assert_eq!((table.take(), table.take()), (Some(Change::Object(1, circle)), None));
    assert_eq!(read(&mut table, at - 4, 1).1, [1]);
    // What is set otherwise shows.
    table.set_object(1, Some(&ObjectDesign::Circle { centre: [1.0, 2.0], radius: 3.0 }));
    assert_eq!(numbers(&read(&mut table, at, 12).1), [1_000, 2_000, 3_000]);
    table.set_object(1, Some(&ObjectDesign::HalfPlane { point: [1.0, 2.0], normal: [1.0, 0.0] }));
    assert_eq!(read(&mut table, at - 4, 1).1, [2]);
    table.set_object(1, None);
    assert_eq!((read(&mut table, at - 4, 1).1, table.take()), (vec![0], None));
    assert_eq!(write(&mut table, at + 8, &[0; 4]), Some(StatusError::DataRange));
    // A circle of a micrometre is none that the model can touch.
    assert_eq!(write(&mut table, at + 8, &[1, 0, 0, 0]), Some(StatusError::DataLimit));
}

#[test]
fn settings_are_taken() {
    let mut table = table(2);
    let settings = FingerSettings { servo_id: 3, reversed: true, gear_ratio: 2.5, zero: -17.25 };
    table.set_finger(1, &settings);
    assert_eq!(table.take(), None);
    let at = FIRST_BLOCK + BLOCK + 40;
    assert_eq!(read(&mut table, at, 12).1, [3, 1, 0, 0, 0xC4, 9, 0, 0, 0x43, 0xF9, 0xFF, 0xFF]);
    assert_eq!(write(&mut table, at, &[4]), None);
    assert_eq!(table.take(), Some(Change::Finger(1, FingerSettings { servo_id: 4, ..settings })));
    // Address, rate and return delay together.
    assert_eq!(write(&mut table, 7, &[99, 6, 10]), None);
    let bus = BusSettings { id: Id::new(99).unwrap(), baud_rate: 4_000_000, return_delay: 10 };
    assert_eq!((table.take(), table.id(), table.return_delay_us()), (Some(Change::Bus(bus)), bus.id, 20));
}

#[test]
fn a_restart_is_asked_for_once() {
    let mut table = table(1);
    assert_eq!(ask(&mut table, Instruction::Reboot, &[]), (None, false, vec![]));
    assert_eq!((table.take(), table.take()), (Some(Change::Reboot), None));
}

#[test]
fn nobody_gets_an_address_twice() {
    let mut table = table(2);
    let servo = |finger: u16| FIRST_BLOCK + finger * BLOCK + 40;
    assert_eq!(read(&mut table, servo(0), 1).1, [1]);
    assert_eq!(read(&mut table, servo(1), 1).1, [2]);
    assert_eq!(write(&mut table, servo(0), &[2]), Some(StatusError::DataLimit));
    assert_eq!(write(&mut table, servo(1), &[ME]), Some(StatusError::DataLimit));
    assert_eq!(write(&mut table, 7, &[1]), Some(StatusError::DataLimit));
    // A finger that the gripper has not is in nobody's way.
    assert_eq!(write(&mut table, 7, &[3]), None);
}

#[test]
fn refusals_are_the_protocols() {
    let mut table = table(1);
    let cases: [(u16, &[u8], StatusError); 11] = [
        (0, &[1, 2], StatusError::Access),
        (FIRST_BLOCK, &[0; 4], StatusError::Access),
        (FIRST_BLOCK + 64, &[1], StatusError::Access),
        (FIRST_BLOCK + 69, &[0; 4], StatusError::Access),
        (FIRST_BLOCK + BLOCK + 40, &[9], StatusError::Access),
        (FIRST_BLOCK + 68, &[0; 3], StatusError::DataLength),
        (8, &[8], StatusError::DataRange),
        (8, &[0], StatusError::DataRange),
        (68, &[3], StatusError::DataRange),
        // Ten µs until an answer is ready and ten of a byte, or 174 at the lowest rate.
        (9, &[9], StatusError::DataRange),
        (8, &[1, 91], StatusError::DataRange),
    ];
    for (address, bytes, error) in cases {
        assert_eq!(write(&mut table, address, bytes), Some(error), "{address}");
        // A Reg Write is refused at once, not by its Action.
        let registered = ask(&mut table, Instruction::RegWrite, &[&address.to_le_bytes(), bytes].concat());
        assert_eq!(registered.0, Some(error), "{address}");
    }
    // A rate at which the delay would not be kept.
    assert_eq!(write(&mut table, 8, &[1, 92]), None);
    assert_eq!((write(&mut table, 8, &[3, 10]), write(&mut table, 8, &[1])), (None, Some(StatusError::DataRange)));
    assert!(matches!(table.take(), Some(Change::Bus(BusSettings { baud_rate: 1_000_000, return_delay: 10, .. }))));
    assert_eq!(read(&mut table, FIRST_BLOCK + BLOCK, 4).0, Some(StatusError::Access));
    assert_eq!(read(&mut table, 71, 1).0, Some(StatusError::Access));
    assert_eq!(read(&mut table, 0, 0).0, Some(StatusError::DataLength));
    assert_eq!((read(&mut table, FIRST_BLOCK, 80).0, table.take()), (None, None));
}

#[test]
fn items_are_in_order_and_sound() {
    for pair in ITEMS.windows(2) {
        assert!(pair[0].end() <= pair[1].address, "{pair:?}");
    }
    for item in ITEMS.iter().filter(|item| item.access == Access::ReadWrite && item.min <= 0) {
        assert!(item.min <= item.default && item.default <= item.max, "{item:?}");
    }
}

/// The table in the documentation is the one in the code: every address, length and access.
#[test]
fn the_documentation_tells_the_truth() {
    let text = include_str!("../../../docs/device.md");
    let mut documented = Vec::new();
    let mut tables = 0;
    for row in text.lines().filter_map(|line| line.strip_prefix("| ")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        tables += usize::from(cells[0] == "address" || cells[0] == "offset");
        for address in cells[0].split(", ").filter_map(|address| address.parse::<u16>().ok()) {
            let (length, writable): (u16, bool) = (cells[1].parse().unwrap(), cells[2] == "W");
            let bases = if tables == 1 { 0..1 } else { 0..BLOCKS as u16 };
            let base = |block: u16| if tables == 1 { 0 } else { FIRST_BLOCK + BLOCK * block };
            documented.extend(bases.map(|block| (base(block) + address, length, writable)));
        }
    }
    documented.sort();
    let coded: Vec<_> =
        ITEMS.iter().map(|item| (item.address, item.length, item.access == Access::ReadWrite)).collect();
    assert_eq!((tables, documented), (2, coded));
    assert_eq!(FingerBlock::of(3).object_radius.address(), 128 + 3 * 96 + 76);
}
