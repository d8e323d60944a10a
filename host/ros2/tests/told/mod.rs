//! A gripper whose one finger closes on a cylinder, and its reports.

use fre::case::preset;
use fre::study::model::Precision;
use fre_gripper::estimator::{AnyEstimator, estimator};
use fre_gripper::source::{Modelled, Origin, Setup};
use messages::{Finger, Mount, PROTOCOL_VERSION, Phase, Report, Settings};
use model_core::discretise::{Discretisation, Physics};
use model_core::drive::Drive;
use model_core::estimator::Estimate;
use model_core::newton::Hessian;
use model_core::object::ObjectDesign;

/// Ø80 at Mid height, world frame, mm.
pub const OBJECT: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };

/// A gripper with one finger that is moved so.
pub fn setup(drive: Drive) -> Setup {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let how = Discretisation::estimator(Physics::Extended);
    Setup {
        origin: Origin::Gripper,
        place: "a test".to_owned(),
        board: "bench".to_owned(),
        firmware: "1.2.3".to_owned(),
        protocol: PROTOCOL_VERSION,
        cost_hz: 1_000_000,
        settings: Settings::of(Mount { drive, ..Mount::DEFAULT }),
        models: vec![Modelled {
            finger: Some(Finger::elastic(design, how)),
            object: Some(OBJECT),
            friction: 0.0,
            uncertainty: None,
        }],
    }
}

/// Its estimator.
pub fn model(drive: Drive) -> Box<dyn AnyEstimator> {
    let setup = setup(drive);
    let finger = setup.models[0].finger.as_ref().unwrap();
    let mut model = estimator(Precision::F64, Hessian::default());
    model.configure(&finger.design, &finger.how).unwrap();
    model.set_drive(drive).unwrap();
    model.set_object(OBJECT).unwrap();
    model
}

/// A tick at 500 Hz.
pub fn report(tick: u64, estimate: Estimate) -> Report {
    Report {
        sequence: tick as u32,
        finger: 0,
        phase: Phase::Moving,
        time_us: 2000 * tick,
        estimate,
        goal: estimate.motor_angle,
        position: 2048,
        current: 12.5,
        cost: 0,
    }
}
