//! The gripper as a device on a bus where the servo answers too: ROBOTIS' own SDK leads the servo and reads the force.

mod sdk;

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::thread::{JoinHandle, spawn};
use std::time::{Duration, Instant};

use dynamixel::{Device, Id, StatusReturn, Tap, Timing};
use fre_gripper::servo::{Hub, Servo};
use gripper::device_table::{BusSettings, Change, DeviceTable, FingerState};
use model_core::estimator::{Estimate, Estimator};
use model_core::object::ObjectDesign;
use model_core::size::Reduced;
use model_core::status::Status;
use system_tests::{Machine, OBJECT, finger};

use sdk::{GRIPPER, SERVO, angle, ask, check};

/// A PC may be busy.
const PATIENT: Timing = Timing { baud_rate: 1_000_000, latency_us: 1_000_000, status_return: StatusReturn::All };

/// A gripper in the role of a device, on this PC: it listens, estimates from what it hears, and answers.
fn device(mut port: UnixStream) -> JoinHandle<Option<ObjectDesign>> {
    spawn(move || {
        let id = |id| Id::new(id).unwrap();
        let mut tap = Tap::<256, 1>::new(PATIENT);
        assert!(tap.watch(id(SERVO)));
        let mut device = Device::<256>::new(PATIENT);
        let bus = BusSettings { id: id(GRIPPER), baud_rate: 1_000_000, return_delay: 0 };
        let mut table = DeviceTable::new(&bus, sdk::version(), 1, 0);
        let mut model: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
        let finger = finger();
        model.configure(&finger.design, &finger.how).unwrap();
        let mut object = None;
        let mut estimate = Estimate::blank(Status::OutOfRange);
        let began = Instant::now();
        let mut chunk = [0; 256];
        let mut heard_at = 0;
        port.set_read_timeout(Some(Duration::from_millis(5))).unwrap();
        loop {
            let count = match port.read(&mut chunk) {
                Ok(0) => return object,
                Ok(count) => count,
                Err(_) => 0,
            };
            let now_us = began.elapsed().as_micros() as u64;
            let mut rest = &chunk[..count];
            while tap.hear(now_us, &mut rest).is_some() {}
            if let Some(seen) = tap.servo(id(SERVO)).and_then(|servo| servo.position) {
                // Every position is a tick, and so is a while without one as long as the estimate is on its way.
                if seen.at_us != heard_at || estimate.age > 0 {
                    estimate = model.update(angle(seen.value));
                    heard_at = seen.at_us;
                }
                let age_us = Some(seen.age_us(now_us) as u32);
                table.show(0, &FingerState { estimate, position: seen.value, current: 0.0, age_us, alert: false });
            }
            let mut rest = &chunk[..count];
            while let Some(reply) = device.hear(now_us, &mut rest, &mut table) {
                port.write_all(reply.bytes).unwrap();
            }
            if let Some(reply) = device.poll(began.elapsed().as_micros() as u64, &mut table) {
                port.write_all(reply.bytes).unwrap();
            }
            while let Some(change) = table.take() {
                if let Change::Object(0, circle) = change {
                    model.set_object(circle).unwrap();
                    object = Some(circle);
                }
            }
        }
    })
}

/// The role's state machines with the SDK of ROBOTIS on a pseudo-terminal, without QEMU between them.
#[test]
fn the_sdk_of_robotis_reads_the_force() {
    let mut hub = Hub::new();
    hub.servo(Servo::new(Machine::servo()).unwrap());
    let device = device(hub.stream().unwrap());
    let port = hub.pty().unwrap();
    let bus = hub.spawn().unwrap();
    let facts = ask(&port);
    assert_eq!(bus.lost(), 0);
    bus.stop();
    assert_eq!(device.join().unwrap(), Some(OBJECT));
    check(&facts);
}
