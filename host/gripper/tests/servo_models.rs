//! Simulated servos of every model: each with its own table, units and motor, and what all of them have beyond plain registers.

mod servo_bus;

use dynamixel::{Backup, Effort, Error, Layout, MODELS, Model, Register, ResetScope, StatusError, Tap, Timing, xm430};
use fre_gripper::datasheet::Datasheet;
use fre_gripper::servo::{BOOT_US, Config, Servo};
use servo_bus::{Bus, id, run};

fn model(number: u16) -> &'static Model {
    Model::of(number).unwrap()
}

fn simulated() -> impl Iterator<Item = &'static Model> {
    MODELS.iter().filter(|model| Config::of(model).is_simulated())
}

/// Forty degrees further, in the model's counts.
fn step(model: &Model) -> i32 {
    (model.counts / 9) as i32
}

#[test]
fn every_model_moves_by_its_own_registers() {
    let mut seen = Vec::new();
    for model in simulated() {
        let mut bus = Bus::new([Config::of(model)]);
        assert_eq!(run(bus.master().ping(id(1))).unwrap().value.model, model.number);
        assert_eq!(bus.get(xm430::MODEL_NUMBER), model.number);
        let start = bus.get(model.at(xm430::PRESENT_POSITION));
        assert_eq!(start, if model.layout == Layout::X { 2048 } else { 0 }, "{}", model.name);
        let volts = Datasheet::of(model).unwrap().volts;
        assert_eq!(f64::from(bus.get(model.at(xm430::PRESENT_INPUT_VOLTAGE))), volts * 10.0, "{}", model.name);
        bus.set(model.at(xm430::TORQUE_ENABLE), 1);
        // In one second.
        let slow = (40.0 / 6.0 / f64::from(model.velocity)).round() as u32;
        bus.set(model.at(xm430::PROFILE_VELOCITY), slow);
        bus.set(model.at(xm430::GOAL_POSITION), start + step(model));
        bus.pass(500_000);
        let half = f64::from(bus.get(model.at(xm430::PRESENT_POSITION)) - start) / f64::from(step(model));
        assert!((half - 0.5).abs() < 0.1, "{}: {half} of the way", model.name);
        bus.pass(1_500_000);
        let all = f64::from(bus.get(model.at(xm430::PRESENT_POSITION)) - start) / f64::from(step(model));
        // Friction leaves an error.
        assert!((all - 1.0).abs() < 0.05, "{}: {all} of the way", model.name);
        seen.push(model.name);
    }
    assert_eq!(seen, ["XM430-W350", "XL430-W250", "XM540-W270", "XL330-M288", "XC330-T288", "PM42-010-S260-R"]);
}

/// What lies at 126 is a current in the model's unit, or a load.
#[test]
fn the_effort_is_in_the_models_unit() {
    for model in simulated() {
        let data = Datasheet::of(model).unwrap();
        let mut bus = Bus::new([Config::of(model)]);
        // Half of the voltage against friction alone: it turns, and the torque is the friction's.
        bus.set(xm430::OPERATING_MODE, 16);
        bus.set(model.at(xm430::TORQUE_ENABLE), 1);
        bus.set(model.at(xm430::GOAL_PWM), (model.full_pwm / 2) as i16);
        bus.pass(500_000);
        let shown = f64::from(bus.get(model.at(xm430::PRESENT_CURRENT)));
        let expected = match model.effort {
            Effort::Current(milliamperes) => data.friction / data.torque_constant * 1000.0 / f64::from(milliamperes),
            Effort::Load => data.friction / data.stall_torque * 1000.0,
        };
        assert!((shown - expected).abs() <= 0.5, "{}: {shown}, not {expected}", model.name);
        let speed = f64::from(bus.get(model.at(xm430::PRESENT_VELOCITY))) * f64::from(model.velocity);
        let expected = data.free_speed * (0.5 - data.friction / data.stall_torque);
        assert!((speed / expected - 1.0).abs() < 0.02, "{}: {speed}, not {expected} rev/min", model.name);
    }
}

/// The P series counts to both sides of its zero: its turns are dropped to within half a revolution.
#[test]
fn the_p_series_drops_its_turns_to_half_a_revolution() {
    let model = model(2100);
    let revolution = model.counts as i32;
    for turns in [-1.3, -0.4, 0.4, 1.3] {
        let mut bus = Bus::new([Config::of(model)]);
        bus.set(xm430::OPERATING_MODE, 4);
        bus.set(model.at(xm430::TORQUE_ENABLE), 1);
        bus.set(model.at(xm430::GOAL_POSITION), (turns * f64::from(revolution)) as i32);
        bus.pass(10_000_000);
        let there = bus.get(model.at(xm430::PRESENT_POSITION));
        let off = f64::from(there) / f64::from(revolution) - turns;
        assert!(off.abs() < 0.05, "{there} for {turns} turns");
        bus.reboot();
        let within = bus.get(model.at(xm430::PRESENT_POSITION));
        assert!(within.abs() <= revolution / 2, "{within} of {there}");
        assert_eq!((there - within).rem_euclid(revolution), 0, "{within} of {there}");
    }
}

#[test]
fn what_a_model_does_not_have_is_refused() {
    let refusal = |number: u16, register: Register<i16>, value| {
        Bus::new([Config::of(model(number))]).refusal(model(number).at(register), value)
    };
    assert_eq!(refusal(1060, xm430::GOAL_CURRENT, 1), Some(StatusError::Access));
    assert_eq!(refusal(1120, xm430::GOAL_CURRENT, 2000), None);
    assert_eq!(refusal(1020, xm430::GOAL_CURRENT, 2000), Some(StatusError::DataRange));
    let mode = |number: u16, value| Bus::new([Config::of(model(number))]).refusal(xm430::OPERATING_MODE, value);
    assert_eq!(mode(1060, 0), Some(StatusError::DataRange));
    assert_eq!(mode(2100, 5), Some(StatusError::DataRange));
    assert_eq!(mode(1200, 5), None);
    let startup = |number: u16| Bus::new([Config::of(model(number))]).refusal(xm430::STARTUP_CONFIGURATION, 1);
    assert_eq!((startup(1220), startup(2100)), (None, Some(StatusError::Access)));
    // The X330 series' PWM Slope does nothing here.
    let slope = Register::<u8>::write(62, false, dynamixel::Area::Eeprom, 0, 0, 255);
    let mut bus = Bus::new([Config::of(model(1200))]);
    assert_eq!((bus.refusal(slope, 140), bus.refusal(slope, 141)), (None, Some(StatusError::DataRange)));
    assert_eq!(bus.refusal(xm430::PROTOCOL_TYPE, 20), Some(StatusError::DataRange));
    // No motor, no table.
    let error = Servo::new(Config::of(model(1030))).unwrap_err().to_string();
    assert!(error.starts_with("the XM430-W210 is not simulated; simulated are XM430-W350, "), "{error}");
    let rate = Servo::new(Config { baud_rate: 4_500_000, ..Config::of(model(1200)) }).unwrap_err().to_string();
    assert!(rate.ends_with("the XL330-M288 knows 9600, 57600, 115200, 1000000, 2000000, 3000000, 4000000"), "{rate}");
}

/// The manual's second example: four bytes of indirect data are Goal Position, four more Present Position.
#[test]
fn indirect_registers_show_and_write_others() {
    for model in simulated() {
        let area = model.indirect[0];
        let mut bus = Bus::new([Config::of(model)]);
        let (goal, present) = (model.at(xm430::GOAL_POSITION).address(), model.at(xm430::PRESENT_POSITION).address());
        let addresses: Vec<u8> =
            (goal..goal + 4).chain(present..present + 4).flat_map(|address| address.to_le_bytes()).collect();
        run(bus.master().write(id(1), area.addresses, &addresses)).unwrap();
        bus.set(model.at(xm430::TORQUE_ENABLE), 1);
        let to = bus.get(model.at(xm430::PRESENT_POSITION)) + step(model);
        run(bus.master().write(id(1), area.data, &to.to_le_bytes())).unwrap();
        assert_eq!(bus.get(model.at(xm430::GOAL_POSITION)), to, "{}", model.name);
        bus.pass(3_000_000);
        let mut shown = [0; 8];
        run(bus.master().read(id(1), area.data, &mut shown)).unwrap();
        assert_eq!(shown[..4], to.to_le_bytes());
        assert_eq!(shown[4..], bus.get(model.at(xm430::PRESENT_POSITION)).to_le_bytes());
        // A byte that shows nothing is a byte of memory; half an address, and an address in the EEPROM, are refused.
        let last = area.data + area.length - 1;
        run(bus.master().write(id(1), last, &[7])).unwrap();
        let mut byte = [0];
        run(bus.master().read(id(1), last, &mut byte)).unwrap();
        assert_eq!(byte, [7]);
        bus.set(model.at(xm430::TORQUE_ENABLE), 0);
        let mut refused = |address, bytes: &[u8]| match run(bus.master().write(id(1), address, bytes)) {
            Err(Error::Refused { error, .. }) => Some(error),
            _ => None,
        };
        assert_eq!(refused(area.addresses, &[132]), Some(StatusError::DataLength));
        assert_eq!(refused(area.addresses + 1, &[0, 0]), Some(StatusError::Access));
        assert_eq!(refused(area.addresses, &[10, 0]), Some(StatusError::DataRange));
        // Read-only is read-only behind an indirect register too.
        assert_eq!(refused(area.data + 4, &to.to_le_bytes()), Some(StatusError::Access));
        // The X series forgets the addresses with the power.
        bus.reboot();
        run(bus.master().read(id(1), area.data, &mut shown)).unwrap();
        assert_eq!(shown[..4] == [0; 4], model.layout == Layout::X, "{}", model.name);
    }
}

/// The manual's example: several servos with one Secondary ID take a write to it, in silence, and no EEPROM changes.
#[test]
fn a_secondary_id_is_heard_in_silence() {
    let mut bus = Bus::new([1, 2].map(|id| Config { id, ..Config::default() }));
    for servo in [1, 2] {
        run(bus.master().write(id(servo), xm430::SECONDARY_ID.address(), &[100])).unwrap();
    }
    bus.wire.0.borrow_mut().said.clear();
    let mut write = |address: u16, byte| {
        let written = run(bus.master().write(id(100), address, &[byte]));
        assert!(matches!(written, Err(Error::Timeout { .. })), "{written:?}");
    };
    write(xm430::LED.address(), 1);
    write(xm430::HOMING_OFFSET.address(), 1);
    write(xm430::BAUD_RATE.address(), 3);
    assert!(bus.wire.0.borrow().said.is_empty());
    for servo in [1, 2] {
        let mut byte = |address: u16| {
            let mut byte = [0];
            run(bus.master().read(id(servo), address, &mut byte)).unwrap();
            byte[0]
        };
        assert_eq!([xm430::LED.address(), 8, 20].map(&mut byte), [1, 1, 0]);
    }
    // The own address comes first; 253 and up is none.
    run(bus.master().write(id(2), xm430::SECONDARY_ID.address(), &[1])).unwrap();
    run(bus.master().write(id(1), xm430::LED.address(), &[0])).unwrap();
    assert_eq!([0, 1].map(|servo| bus.wire.0.borrow().servos[servo].read(xm430::LED)), [0, 0]);
    run(bus.master().write(id(2), xm430::SECONDARY_ID.address(), &[255])).unwrap();
    run(bus.master().write(id(1), xm430::LED.address(), &[1])).unwrap();
    assert_eq!([0, 1].map(|servo| bus.wire.0.borrow().servos[servo].read(xm430::LED)), [1, 0]);
}

#[test]
fn a_backup_brings_settings_and_gains_back() {
    let mut bus = Bus::new([Config::default()]);
    let failed =
        |result: Result<_, Error<_>>| matches!(result, Err(Error::Refused { error: StatusError::ResultFail, .. }));
    assert!(failed(run(bus.master().backup(id(1), Backup::Restore))), "nothing was stored");
    bus.set(xm430::HOMING_OFFSET, 50);
    bus.set(xm430::POSITION_P_GAIN, 1000);
    bus.set(xm430::PROFILE_VELOCITY, 77);
    bus.set(xm430::TORQUE_ENABLE, 1);
    assert!(failed(run(bus.master().backup(id(1), Backup::Store))), "not with torque");
    bus.set(xm430::TORQUE_ENABLE, 0);
    assert_eq!(bus.get(xm430::BACKUP_READY), 0);
    run(bus.master().backup(id(1), Backup::Store)).unwrap();
    assert_eq!(bus.get(xm430::BACKUP_READY), 1);
    bus.set(xm430::HOMING_OFFSET, 0);
    bus.set(xm430::LED, 1);
    run(bus.master().backup(id(1), Backup::Restore)).unwrap();
    bus.pass(BOOT_US);
    assert_eq!((bus.get(xm430::HOMING_OFFSET), bus.get(xm430::LED)), (50, 0));
    assert_eq!((bus.get(xm430::POSITION_P_GAIN), bus.get(xm430::PROFILE_VELOCITY)), (1000, 77));
    // The RAM comes back at power-on only if Startup Configuration says so.
    bus.reboot();
    assert_eq!(bus.get(xm430::POSITION_P_GAIN), 800);
    bus.set(xm430::STARTUP_CONFIGURATION, 2);
    bus.reboot();
    assert_eq!((bus.get(xm430::POSITION_P_GAIN), bus.get(xm430::BACKUP_READY)), (1000, 1));
    run(bus.master().factory_reset(id(1), ResetScope::ExceptIdAndBaudRate)).unwrap();
    bus.pass(BOOT_US);
    assert_eq!((bus.get(xm430::POSITION_P_GAIN), bus.get(xm430::HOMING_OFFSET)), (800, 0));
    // Older firmware does not know the instruction.
    let mut old = Bus::new([Config { firmware: 44, ..Config::default() }]);
    let refused = run(old.master().backup(id(1), Backup::Store));
    assert!(matches!(refused, Err(Error::Refused { error: StatusError::Instruction, .. })), "{refused:?}");
}

/// A tap understands a servo by its own table once that has said what it is.
#[test]
fn a_tap_reads_every_model() {
    for model in simulated() {
        let mut bus = Bus::new([Config { start_deg: Some(5.0), ..Config::of(model) }]);
        let mut tap = Tap::<128, 1>::new(Timing::at(1_000_000));
        assert!(tap.watch(id(1)));
        let mut at_us = 1_000;
        let mut hear = |tap: &mut Tap<128, 1>, bus: &mut Bus, question: &[u8]| {
            bus.wire.0.borrow_mut().said.clear();
            let mut heard = question;
            while tap.hear(at_us, &mut heard).is_some() {}
            let answers = bus.servo(|servo| servo.hear(0, question));
            for answer in answers {
                let mut heard = answer.bytes.as_slice();
                while tap.hear(at_us + 300, &mut heard).is_some() {}
            }
            at_us += 10_000;
        };
        let mut buffer = [0; 64];
        let ping = dynamixel::encode(&mut buffer, id(1), dynamixel::Instruction::Ping, &[]).unwrap().to_vec();
        hear(&mut tap, &mut bus, &ping);
        let [low, high] = model.at(xm430::PRESENT_CURRENT).address().to_le_bytes();
        let read = dynamixel::Instruction::Read;
        let question = dynamixel::encode(&mut buffer, id(1), read, &[low, high, 10, 0]).unwrap().to_vec();
        hear(&mut tap, &mut bus, &question);
        let heard = tap.servo(id(1)).unwrap();
        assert_eq!(heard.model.number, model.number);
        let position = bus.get(model.at(xm430::PRESENT_POSITION));
        assert_eq!(heard.position.map(|seen| seen.value), Some(position), "{}", model.name);
        assert_eq!(heard.effort.map(|seen| seen.value), Some(0), "{}", model.name);
    }
}
