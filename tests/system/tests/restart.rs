//! What ends a program ends it for a moment: it starts again, says why, and is as it was set.

use std::time::{Duration, Instant};

use fre_gripper::link::{Link, LinkError};
use messages::{Mount, Provocation, ResetCause, Settings};
use model_core::uncertainty::Uncertainty;
use system_tests::{Machine, OBJECT, Watch, finger};

const PATIENCE: Duration = Duration::from_secs(60);

/// A link to the program that started after a provocation.
fn provoked(machine: &Machine, link: Link, what: Provocation) -> Link {
    let mut link = link;
    link.set_patience(Duration::from_millis(500));
    match link.provoke(what) {
        // It has no time to answer.
        Err(LinkError::Timeout { .. } | LinkError::Closed) | Ok(()) => {}
        Err(error) => panic!("{what:?}: {error}"),
    }
    drop(link);
    let end = Instant::now() + PATIENCE;
    loop {
        let mut link = machine.link();
        link.set_patience(Duration::from_secs(2));
        match link.boot() {
            Ok(boot) if boot.cause != ResetCause::PowerOn => return link,
            _ => assert!(Instant::now() < end, "no restart after {what:?}"),
        }
    }
}

/// A panic, a stopped control loop, a stopped link, an overflowing stack and a wanted restart: each is survived and told, and design,
/// object and settings are still there.
#[test]
fn every_end_is_a_beginning() {
    let machine = Machine::boot(Machine::servo());
    let mut link = machine.link();
    assert_eq!(link.boot().unwrap().cause, ResetCause::PowerOn);
    let settings = Settings { rate_hz: 100, ..Settings::of(Mount::DEFAULT) };
    link.set_settings(&settings).unwrap();
    link.set_finger(0, &finger()).unwrap();
    link.set_object(0, OBJECT).unwrap();
    let uncertainty = Some(Uncertainty { zero_angle: 0.01, youngs_modulus: 0.02, ..Uncertainty::DEFAULT });
    link.set_uncertainty(0, uncertainty).unwrap();
    for (what, cause, words) in [
        (Provocation::Restart, ResetCause::Software, None),
        (Provocation::Panic, ResetCause::Software, Some("provoke")),
        (Provocation::Hang, ResetCause::Watchdog, None),
        (Provocation::HangLink, ResetCause::Software, Some("the task that answers the host was stuck")),
        (Provocation::StackOverflow, ResetCause::Software, Some("the stack has overflowed")),
    ] {
        link = provoked(&machine, link, what);
        let boot = link.boot().unwrap();
        assert_eq!(boot.cause, cause, "{what:?}: {boot:?}");
        match (words, boot.last_words) {
            (None, None) => {}
            (Some(words), Some(last)) => assert!(last.contains(words), "{what:?}: {last}"),
            (words, last) => panic!("{what:?}: {last:?} instead of {words:?}"),
        }
        assert_eq!(link.settings().unwrap(), settings);
        assert_eq!(link.finger(0).unwrap(), Some(finger()));
        assert_eq!(link.object(0).unwrap(), Some(OBJECT.into()));
        assert_eq!(link.uncertainty(0).unwrap(), uncertainty);
        let mut watch = Watch::new(&link);
        watch.until_report("sound estimate", PATIENCE, |report| {
            report.estimate.status.is_trustworthy() && report.estimate.age == 0
        });
    }
}
