//! Another master leads: what a gripper that listens answers it.

use std::cell::RefCell;
use std::rc::Rc;

use dynamixel::{Id, Instruction, Register, Value, xm430};
use fre_gripper::servo::Config;
use gripper::device_table::{FINGERS, FIRST_BLOCK, FingerBlock, ID, MARGIN, MARGIN_KNOWN, STATUS_RETURN_LEVEL};
use messages::{
    For, GetCounters, GetObject, GetSettings, Mount, Object, Role, SetFinger, SetObject, SetSettings, Settings, Side,
};
use model_core::object::ObjectDesign;
use model_core::status::Status;
use system_tests::{Bench, Flash, GEARED_MOUNT, OBJECT, finger, geared_servo};

const SECOND: u64 = 1_000_000;
const TICK: u64 = 2_000;
const GRIPPER: u8 = 100;
/// Where the servos hold a firm grip, counts.
const GRIPPED: i32 = 2048 + 80;

/// A gripper in the role of a device, with two servos, and what it says on the bus.
struct Listener {
    bench: Bench,
    said: Rc<RefCell<Vec<u8>>>,
    id: u8,
}

impl Listener {
    fn new(fingers: usize) -> Self {
        Self::on(fingers, &Flash::new())
    }

    fn on(fingers: usize, flash: &Flash) -> Self {
        let servo = |id| Config { id, ..geared_servo() };
        let mut bench = Bench::of(servo(1), vec![servo(2)], flash);
        let said = Rc::new(RefCell::new(Vec::new()));
        let heard = said.clone();
        bench.meddling = Box::new(move |from_gripper, bytes| {
            if from_gripper {
                heard.borrow_mut().extend_from_slice(&bytes);
            }
            bytes
        });
        let mut listener = Self { bench, said, id: GRIPPER };
        listener.set(&settings(fingers));
        for finger_number in 0..fingers as u8 {
            let object = Object { design: OBJECT, friction: 0.6 };
            listener.bench.ask::<SetFinger>(&For { finger: finger_number, what: finger() }).unwrap();
            listener.bench.ask::<SetObject>(&For { finger: finger_number, what: object }).unwrap();
        }
        listener
    }

    fn set(&mut self, settings: &Settings) {
        self.bench.ask::<SetSettings>(settings).unwrap();
        self.bench.run(2 * TICK);
    }

    /// What the master says, and what the gripper answers: error and data, if anything.
    fn say(&mut self, to: u8, instruction: Instruction, parameters: &[u8]) -> Option<(u8, Vec<u8>)> {
        let mut buffer = [0; 64];
        let packet = dynamixel::encode(&mut buffer, Id::new(to).unwrap(), instruction, parameters).unwrap();
        self.said.borrow_mut().clear();
        self.bench.interject(packet);
        self.bench.run(TICK / 2);
        let said = self.said.borrow();
        // Header, address, length, instruction, error, data, check.
        (said.len() >= 11).then(|| (said[8], said[9..said.len() - 2].to_vec()))
    }

    fn read<T: Value>(&mut self, register: Register<T>) -> Result<Vec<u8>, u8> {
        let [a, b] = register.address().to_le_bytes();
        let [c, d] = T::LENGTH.to_le_bytes();
        match self.say(self.id, Instruction::Read, &[a, b, c, d]).expect("an answer") {
            (0, data) => Ok(data),
            (error, _) => Err(error),
        }
    }

    fn write<T: Value>(&mut self, register: Register<T>, value: T) -> Option<u8> {
        let [a, b] = register.address().to_le_bytes();
        let bytes = value.to_bytes();
        let parameters = [&[a, b][..], &bytes[..usize::from(T::LENGTH)]].concat();
        self.say(self.id, Instruction::Write, &parameters).map(|(error, _)| error)
    }

    /// The master reads both servos' positions.
    fn look(&mut self) {
        for id in [1, 2] {
            self.say(id, Instruction::Read, &[132, 0, 4, 0]);
        }
    }
}

fn settings(fingers: usize) -> Settings {
    let role = Role::Device { id: GRIPPER, return_delay: 0 };
    let mut settings = Settings { role, baud: Some(1_000_000), shape_every: 0, ..Settings::of(GEARED_MOUNT) };
    let other = Mount { servo_id: 2, side: Side::Right, ..GEARED_MOUNT };
    settings.fingers[1] = Some(other).filter(|_| fingers > 1);
    settings
}

/// The margin is found beside a master that reads more seldom than the gripper ticks.
#[test]
fn what_the_grip_bears_is_told_to_another_master() {
    let mut listener = Listener::new(2);
    for id in 0..2 {
        let servo = listener.bench.servo_of(id);
        servo.write(xm430::TORQUE_ENABLE, 1);
        servo.write(xm430::GOAL_POSITION, GRIPPED);
    }
    assert_eq!(listener.read(MARGIN_KNOWN), Ok(vec![0]));
    for _ in 0..500 {
        listener.look();
        listener.bench.run(3 * TICK);
    }
    assert_eq!(listener.read(MARGIN_KNOWN), Ok(vec![1]));
    let margin = listener.read(MARGIN).unwrap();
    let margin = u32::from_le_bytes(margin.try_into().unwrap());
    assert!((100..20_000).contains(&margin), "{margin} mN");
}

/// A gripper that the host makes a tap never transmits again, whatever the bus's master has written to it just before.
#[test]
fn a_device_that_becomes_a_tap_stays_one() {
    let mut listener = Listener::new(1);
    let device = settings(1);
    let mut buffer = [0; 64];
    let me = Id::new(GRIPPER).unwrap();
    let write = dynamixel::encode(&mut buffer, me, Instruction::Write, &[7, 0, GRIPPER + 1]).unwrap();
    for offset in (0..TICK).step_by(100) {
        listener.set(&device);
        listener.bench.run(offset);
        listener.bench.send::<SetSettings>(&Settings { role: Role::Tap, ..device });
        listener.bench.run(100);
        listener.bench.interject(write);
        listener.bench.run(5 * TICK);
        assert_eq!(listener.bench.ask::<GetSettings>(&()).role, Role::Tap, "{offset} µs after a tick");
    }
}

/// What is set through the link shows in the control table, and one finger more has registers.
#[test]
fn a_finger_that_is_added_has_registers() {
    let mut listener = Listener::new(1);
    let second = FingerBlock::of(1).status;
    assert!(second.address() > FIRST_BLOCK);
    assert_eq!((listener.read(FINGERS), listener.read(second)), (Ok(vec![1]), Err(7)));
    // Its servo's address is free until then.
    assert_eq!((listener.write(ID, 2), listener.write(STATUS_RETURN_LEVEL, 2)), (Some(0), None));
    listener.id = 2;
    assert_eq!(listener.write(ID, GRIPPER), Some(0));
    listener.id = GRIPPER;
    listener.set(&settings(2));
    assert_eq!(listener.read(FINGERS), Ok(vec![2]));
    assert!(listener.read(second).is_ok());
    assert_eq!(listener.write(ID, 2), Some(6), "the second finger's servo has that address");
    listener.set(&settings(1));
    assert_eq!((listener.read(FINGERS), listener.read(second)), (Ok(vec![1]), Err(7)));
}

/// A new address or rate leaves the rest of the table as it is.
#[test]
fn a_new_address_changes_nothing_else() {
    let mut listener = Listener::new(1);
    assert_eq!(listener.write(STATUS_RETURN_LEVEL, 1), Some(0));
    assert_eq!(listener.write(ID, GRIPPER + 1), None, "no answer to a write from then on");
    listener.id = GRIPPER + 1;
    listener.bench.run(SECOND / 10);
    assert_eq!(listener.read(STATUS_RETURN_LEVEL), Ok(vec![1]));
    assert_eq!((listener.write(STATUS_RETURN_LEVEL, 2), listener.write(STATUS_RETURN_LEVEL, 2)), (None, Some(0)));
    assert_eq!(listener.bench.ask::<GetSettings>(&()).role, Role::Device { id: GRIPPER + 1, return_delay: 0 });
}

/// A zero that the master sets is of no calibration: the same one may be sent again.
#[test]
fn a_zero_from_the_bus_is_of_no_calibration() {
    let mut listener = Listener::new(1);
    let mut calibrated = settings(1);
    calibrated.fingers[0] = Some(Mount { calibration: 77, ..GEARED_MOUNT });
    listener.set(&calibrated);
    let kept = |listener: &mut Listener| listener.bench.ask::<GetSettings>(&()).fingers[0].unwrap();
    let block = FingerBlock::of(0);
    assert_eq!(listener.write(block.gear_ratio, 1_000), Some(0));
    listener.bench.run(2 * TICK);
    assert_eq!(kept(&mut listener).calibration, 77);
    assert_eq!(listener.write(block.zero, 205_000), Some(0));
    listener.bench.run(2 * TICK);
    assert_eq!((kept(&mut listener).calibration, kept(&mut listener).zero), (0, 2050.0));
}

/// The table has fewer digits than the settings: what was not written keeps its own, and its calibration.
#[test]
fn a_register_changes_nothing_but_what_it_is_of() {
    let mut listener = Listener::new(1);
    let fine = Mount { calibration: 77, zero: 2050.123, gear_ratio: 1.000_4, ..GEARED_MOUNT };
    let mut before = Settings { baud: None, ..settings(1) };
    before.fingers[0] = Some(fine);
    // That is the rate at which a gripper listens to which none was given, too.
    assert_eq!((before.baud_heard(), settings(1).baud_heard()), (1_000_000, 1_000_000));
    listener.set(&before);
    let block = FingerBlock::of(0);
    let kept = |listener: &mut Listener| {
        listener.bench.run(2 * TICK);
        listener.bench.ask::<GetSettings>(&())
    };
    let with = |mount: Mount| Settings { fingers: [Some(mount), None, None, None], ..before };
    assert_eq!(listener.write(block.servo_id, 3), Some(0));
    assert_eq!(kept(&mut listener), with(Mount { servo_id: 3, ..fine }));
    assert_eq!(listener.write(block.servo_id, 1), Some(0));
    // A number that is what it shows is as it was.
    assert_eq!((listener.write(block.zero, 205_012), listener.write(block.gear_ratio, 1_000)), (Some(0), Some(0)));
    assert_eq!(kept(&mut listener), before);
    assert_eq!(listener.write(block.gear_ratio, 2_000), Some(0));
    assert_eq!(kept(&mut listener), with(Mount { gear_ratio: 2.0, ..fine }));
    assert_eq!(listener.write(block.zero, 205_013), Some(0));
    assert_eq!(kept(&mut listener), with(Mount { gear_ratio: 2.0, zero: 2050.13, calibration: 0, ..fine }));
    let id = GRIPPER + 1;
    assert_eq!(listener.write(ID, id), Some(0));
    listener.id = id;
    let role = Role::Device { id, return_delay: 0 };
    let last = Mount { gear_ratio: 2.0, zero: 2050.13, calibration: 0, ..fine };
    assert_eq!(kept(&mut listener), Settings { role, ..with(last) });
    // Of an object likewise.
    let ObjectDesign::Circle { radius, .. } = OBJECT else { panic!("a circle") };
    let object = Object { design: ObjectDesign::Circle { centre: [41.000_2, 45.000_3], radius }, friction: 0.6 };
    listener.bench.ask::<SetObject>(&For { finger: 0, what: object }).unwrap();
    listener.bench.run(2 * TICK);
    assert_eq!(listener.write(block.object_radius, 39_500), Some(0));
    listener.bench.run(2 * TICK);
    let design = ObjectDesign::Circle { centre: [41.000_2, 45.000_3], radius: 39.5 };
    assert_eq!(listener.bench.ask::<GetObject>(&0), Some(Object { design, ..object }));
}

/// An object that the master sets counts at once, and is stored when it rests: not in the middle of a sequence of writes, and not for every
/// place of an object that moves. A restart that is asked for, or another role, does not cost it.
#[test]
fn an_object_is_stored_once_it_rests() {
    let flash = Flash::new();
    let mut listener = Listener::on(1, &flash);
    let block = FingerBlock::of(0);
    let [x, _] = block.object_centre;
    let writes = |listener: &mut Listener| listener.bench.ask::<GetCounters>(&()).flash_writes;
    let before = writes(&mut listener);
    for step in 0..20 {
        assert_eq!(listener.write(x, 42_000 + step), Some(0));
        listener.bench.run(SECOND / 2);
    }
    let set = listener.bench.ask::<GetObject>(&0);
    assert_ne!(set, Some(Object { design: OBJECT, friction: 0.6 }));
    listener.bench.run(4 * SECOND);
    assert_eq!(writes(&mut listener), before, "it moves, or has just moved");
    // Meanwhile the gripper listens no more.
    listener.set(&Settings { role: Role::Idle, ..settings(1) });
    let idle = writes(&mut listener);
    listener.bench.run(2 * SECOND);
    assert_eq!(writes(&mut listener), idle + 1);
    listener.bench.restart(&flash);
    listener.bench.run(SECOND / 10);
    assert_eq!(listener.bench.ask::<GetObject>(&0), set);
    // A setting is stored at once.
    listener.set(&settings(1));
    let before = writes(&mut listener);
    assert_eq!(listener.write(block.gear_ratio, 2_000), Some(0));
    listener.bench.run(SECOND / 10);
    assert_eq!(writes(&mut listener), before + 1);
}

/// A slow gripper calls numbers old when they are, not when its period ends.
#[test]
fn old_numbers_are_stale_within_a_slow_period() {
    let mut listener = Listener::new(1);
    listener.set(&Settings { rate_hz: 1, ..settings(1) });
    listener.bench.run(SECOND);
    let block = FingerBlock::of(0);
    let stale = vec![9];
    for _ in 0..3 {
        // Asked until a period with its estimate has been shown: one that begins waits for a sixteenth of itself.
        let is_shown = (0..100).any(|_| {
            listener.say(1, Instruction::Read, &[132, 0, 4, 0]);
            listener.bench.run(SECOND / 50);
            listener.read(block.trustworthy) == Ok(vec![1])
        });
        assert!(is_shown, "{:?}", listener.bench.reports.last());
        listener.bench.run(SECOND / 10);
        assert_eq!((listener.read(block.trustworthy), listener.read(block.status)), (Ok(vec![0]), Ok(stale.clone())));
    }
    assert!(listener.bench.reports.iter().any(|(report, _)| report.estimate.status == Status::NoContact));
}
