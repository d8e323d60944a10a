//! A calibration goes into the firmware's memory, and the force that it estimates changes as the fit says.

use std::time::Duration;

use fre_gripper::calibrated::{Calibrated, SendError, Sent, send};
use messages::{Direction, Mount, Report, Settings};
use model_core::drive::Drive;
use model_core::estimator::Estimate;
use model_core::object::ObjectDesign;
use model_core::status::Status;
use model_core::uncertainty::{MemoryUncertainty, Uncertainty};
use system_tests::{Machine, OBJECT, Watch, finger};

/// Longest wait for anything, on a busy PC.
const PATIENCE: Duration = Duration::from_secs(60);

#[test]
fn what_was_fitted_is_sent_and_read_back() {
    let machine = Machine::boot(Machine::servo());
    let link = machine.link();
    let mut watch = Watch::new(&link);
    // Its angle is called 10° although it is open, so that it stands in the object without moving.
    let counts = 4096.0 / 360.0;
    let mount = Mount {
        zero: 2048.0 - 10.0 * counts,
        gear_ratio: 1.0,
        force_limit: 100.0,
        current_limit: 2000.0,
        ..Mount::DEFAULT
    };
    // Slow, for a busy PC.
    let settings = |mount| Settings { rate_hz: 50, ..Settings::of(mount) };
    link.set_settings(&settings(mount)).unwrap();
    link.set_finger(0, &finger()).unwrap();
    link.set_object(0, OBJECT).unwrap();
    let mut settled = |what: &str, angle_deg: f32| -> Report {
        let mut last = None;
        watch.until_report(what, PATIENCE, |report| {
            let near = (report.estimate.motor_angle.to_degrees() - angle_deg).abs() < 0.2;
            let settled = near && report.estimate.status == Status::Converged && report.estimate.age == 0;
            last = settled.then_some(*report);
            settled
        });
        last.expect("a report")
    };
    let before = settled("a force at 9°", 9.0);
    assert!(before.estimate.force_magnitude() > 3.0, "{before:?}");

    // Twice as stiff, 2° less, the object half a millimetre higher.
    let mut fitted = finger();
    fitted.design.material.youngs_modulus *= 2.0;
    let object = ObjectDesign::Circle { centre: [41.0, 45.5], radius: 40.0 };
    let zero_counts = 2.0 * counts;
    // A zero known to 0.5°, and nothing else that is uncertain, but that it goes with the object's place.
    let mut uncertainty = Uncertainty { zero_angle: 0.5_f32.to_radians(), centre: [0.1, 0.0], ..Uncertainty::NONE };
    uncertainty.quantisation = Uncertainty::DEFAULT.quantisation;
    uncertainty.correlations[1] = -0.8;
    let (zero, place) = (f64::from(zero_counts), Some(object));
    let calibrated = Calibrated {
        finger: fitted.clone(),
        zero_counts: zero,
        drive: Drive::Rotating,
        uncertainty,
        object: place.map(messages::Object::from),
    };
    assert_eq!(link.uncertainty(0).unwrap(), None);
    let Sent { before: was, now, was_there } = send(&link, 0, &calibrated, false).unwrap();
    assert!(was == mount.zero && !was_there);
    // Again: its zero is a difference, which is not added twice.
    assert_eq!(send(&link, 0, &calibrated, false).unwrap(), Sent { before: now, now, was_there: true });
    // Another one on top of it only if a person says so.
    let another = Calibrated { zero_counts: zero + 1.0, ..calibrated.clone() };
    let error = send(&link, 0, &another, false).unwrap_err();
    assert!(matches!(error, SendError::OnTop { number: 0, .. }), "{error}");
    assert_eq!(link.settings().unwrap().fingers[0].unwrap().zero, now);
    assert!((now - was - zero_counts).abs() < 1e-3, "{was} {now}");
    assert_eq!(link.finger(0).unwrap(), Some(fitted.clone()));
    assert_eq!(link.object(0).unwrap(), Some(object.into()));
    let after = settled("a force at 7°", 7.0);
    assert_eq!(link.uncertainty(0).unwrap(), Some(uncertainty));
    // The same as the model makes of it on this PC.
    let mut model = fre_gripper::estimator::estimator(fre::study::model::Precision::F64, Default::default());
    model.configure(&fitted.design, &fitted.how).unwrap();
    model.set_object(object).unwrap();
    model.set_uncertainty(uncertainty).unwrap();
    let angle = f64::from(after.estimate.motor_angle);
    // An object that is set while the finger is on it is approached over several ticks.
    let mut ticks = (0..100).map(|_| model.update(angle));
    let expected = ticks.find(|estimate| estimate.status.is_trustworthy()).expect("a force within 100 ticks");
    let apart = (expected.force_magnitude() - after.estimate.force_magnitude()).abs();
    assert!(apart < 0.05, "{after:?}, this PC says {expected:?}");
    let deviation = after.estimate.standard_deviation;
    assert!((deviation / expected.standard_deviation - 1.0).abs() < 0.05, "{deviation}, this PC says {expected:?}");

    // Three times as uncertain a zero, and nothing else: three times the deviation, but for the reading's own.
    let wider = Uncertainty { zero_angle: 1.5_f32.to_radians(), centre: [0.0; 2], ..uncertainty };
    link.set_uncertainty(0, Some(wider)).unwrap();
    watch_deviation(&link, "a wider one", |estimate| {
        let [fx, fy] = estimate.force;
        let [dx, dy] = estimate.force_per_angle;
        let slope = ((fx * dx + fy * dy) / estimate.force_magnitude()).abs();
        let wanted = slope * (wider.zero_angle.powi(2) + wider.quantisation.powi(2) / 12.0).sqrt();
        slope > 0.0
            && (estimate.standard_deviation / wanted - 1.0).abs() < 0.02
            && estimate.standard_deviation > 2.0 * deviation
    });
    let refused = link.set_uncertainty(0, Some(Uncertainty { radius: -1.0, ..wider })).unwrap_err();
    assert!(refused.to_string().contains("radius is -1; allowed is 0 to 1000"), "{refused}");
    assert_eq!(link.uncertainty(0).unwrap(), Some(wider), "the old one stays");
    // None: what is usual.
    link.set_uncertainty(0, None).unwrap();
    assert_eq!(link.uncertainty(0).unwrap(), None);

    // A material that relaxes, of which nothing but a term's part is uncertain. Once it has relaxed, F = (1 − g) Fₑ, whose derivative is −Fₑ.
    let memory = MemoryUncertainty { parts: [0.05, 0.0, 0.0, 0.0], ..MemoryUncertainty::NONE };
    let relaxing = Calibrated {
        finger: fitted.clone().relaxing(&[[0.2, 0.3]]),
        zero_counts: 0.0,
        uncertainty: Uncertainty { memory, ..Uncertainty::NONE },
        ..calibrated.clone()
    };
    send(&link, 0, &relaxing, false).unwrap();
    watch_deviation(&link, "a term's", |estimate| {
        let part = estimate.standard_deviation / estimate.force_magnitude();
        estimate.interval.is_none() && (part / (0.05 / 0.8) - 1.0).abs() < 0.02
    });
    send(&link, 0, &Calibrated { zero_counts: 0.0, ..calibrated.clone() }, false).unwrap();

    // Reversed and geared, the zero goes the other way, by more.
    let reversed = Mount { direction: Direction::Reversed, gear_ratio: 2.0, ..mount };
    link.set_settings(&settings(reversed)).unwrap();
    let only_zero = Calibrated { object: None, ..calibrated };
    let Sent { before: was, now, .. } = send(&link, 0, &only_zero, false).unwrap();
    assert!((now - was + 2.0 * zero_counts).abs() < 1e-3, "{was} {now}");
    assert_eq!(link.object(0).unwrap(), Some(object.into()), "it stays");

    let error = send(&link, 2, &only_zero, false).unwrap_err();
    assert!(matches!(error, SendError::NoFinger { number: 2, count: 1 }), "{error}");
    let mut bad = only_zero;
    bad.finger.design.material.youngs_modulus = -1.0;
    let error = send(&link, 0, &bad, true).unwrap_err();
    assert!(error.to_string().contains("youngs_modulus"), "{error}");
    assert_eq!(link.settings().unwrap().fingers[0].unwrap().zero, now, "a refused finger leaves the zero alone");
}

/// Waits for an estimate whose deviation is as it should be.
fn watch_deviation(link: &fre_gripper::link::Link, what: &str, is_so: impl Fn(&Estimate) -> bool) {
    let mut watch = Watch::new(link);
    watch.until_report(what, PATIENCE, |report| {
        let estimate = &report.estimate;
        estimate.status == Status::Converged && estimate.age == 0 && is_so(estimate)
    });
}
