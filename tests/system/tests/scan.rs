//! The search of the bus: who is there is told, within bounds, and never while a finger grips.

use std::time::Duration;

use fre_gripper::link::LinkError;
use fre_gripper::servo::{Clock, Config};
use messages::{Event, GripTo, Mount, Refusal, Settings, Which};
use system_tests::{Machine, OBJECT, Watch, finger};

const SECONDS: fn(u64) -> Duration = Duration::from_secs;

/// QEMU's bus carries bytes at any rate: everybody answers at each that the board has, and is reported once.
#[test]
fn everybody_on_the_bus_is_told_of() {
    let stranger = |id: u8, firmware: u8| Config {
        id,
        firmware,
        clock: Clock::Requests { period_us: 2_000 },
        return_delay_us: 0,
        ..Config::default()
    };
    let machine = Machine::boot_all(vec![Machine::servo(), stranger(7, 44), stranger(252, 46)]);
    machine.servos[2].fail(0x04);
    let link = machine.link();
    let mut watch = Watch::new(&link);
    let mount = Mount {
        open_angle: -std::f32::consts::PI / 180.0,
        force_limit: 100.0,
        current_limit: 2000.0,
        ..Mount::DEFAULT
    };
    link.set_settings(&Settings { rate_hz: 100, shape_every: 0, ..Settings::of(mount) }).unwrap();
    link.set_finger(0, &finger()).unwrap();
    link.set_object(0, OBJECT).unwrap();
    let good = |watch: &mut Watch| {
        watch.until_report("trustworthy estimate", SECONDS(60), |report| {
            report.estimate.status.is_trustworthy() && report.estimate.age == 0
        });
    };
    good(&mut watch);
    let ready = |watch: &Watch| watch.events.iter().filter(|event| matches!(event, Event::ServoReady { .. })).count();
    let before = ready(&watch);

    link.scan().unwrap();
    // Nothing grips meanwhile.
    let grip = GripTo { fingers: Which::All, force: 3.0, speed: None, limit: None };
    assert!(matches!(link.grip(&grip), Err(LinkError::Refused(Refusal::Scanning))));
    watch.until_event("end of the search", SECONDS(60), |event| matches!(event, Event::ScanDone { .. }));
    assert_eq!(watch.events.last(), Some(&Event::ScanDone { found: 3, rates: 3 }));
    let found = watch.events.iter().filter(|event| matches!(event, Event::DeviceFound { .. })).copied();
    let expected = [(1, 45, false, 1_000_000), (7, 44, false, 57_600), (252, 46, true, 57_600)]
        .map(|(id, firmware, alert, baud)| Event::DeviceFound { id, model: 1020, firmware, baud, alert });
    assert_eq!(found.collect::<Vec<_>>(), expected);

    // The loop goes on as before; the servo was not lost for it.
    good(&mut watch);
    assert_eq!(ready(&watch), before);
    link.grip(&grip).unwrap();
    assert!(matches!(link.scan(), Err(LinkError::Refused(Refusal::Gripping))));
    watch.until_report("force", SECONDS(120), |report| report.phase == messages::Phase::Gripped);
    assert!(matches!(link.scan(), Err(LinkError::Refused(Refusal::Gripping))));
}
