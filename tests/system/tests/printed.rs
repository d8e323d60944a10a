//! The whole gripper with a finger that people print: fifteen welded ribs of two thicknesses between a thin front wall and a back wall that
//! curves and tapers. Its lists are longer than a board with little memory takes.

use std::sync::Arc;
use std::time::Duration;

use fre::case::preset;
use fre::study::model::Options;
use fre_gripper::link::set;
use fre_gripper::servo::{Config, Load};
use messages::{Finger, Mount, Settings, Which};
use model_core::discretise::{Discretisation, Physics};
use model_core::drive::Drive;
use model_core::object::ObjectDesign;
use model_core::status::Status;
use system_tests::{Agreement, Machine, Watch};

/// Longest wait for anything, on a busy PC.
const PATIENCE: Duration = Duration::from_secs(120);
/// 2.3 mm in front of the front wall at motor angle 0.
const OBJECT: ObjectDesign = ObjectDesign::Circle { centre: [43.2, 65.0], radius: 40.0 };
/// Where it closes to, rad: 6.7 mm onto the object.
const CLOSED: f32 = 0.75;

#[test]
fn the_finger_of_the_umi_runs_on_the_gripper() {
    let design = preset("umi").expect("a preset").expect("a sound one").design;
    let drive = Drive::linear([1.0, 0.0], 12.0);
    // Contact at nodes, as the reference has it for thicker walls, presses this thin one at too few points.
    let fine = Options { discretisation: Discretisation::fine(Physics::Extended), ..Load::REFERENCE };
    let load = Arc::new(Load::of(&design, OBJECT, &drive, &fine, 50.0).expect("a load"));
    let machine = Machine::boot(Config { load: load.clone(), ..Machine::servo() });
    let link = machine.link();
    let mut watch = Watch::new(&link);
    let mount =
        Mount { open_angle: 0.0, range: [-0.2, 1.0], force_limit: 100.0, current_limit: 2000.0, ..Mount::DEFAULT };
    let mut settings = Settings { rate_hz: 100, shape_every: 10, ..Settings::of(mount) };
    set(&mut settings, "finger.0.drive=linear 1,0 12").unwrap();
    link.set_settings(&settings).unwrap();
    let finger = Finger::elastic(design, Discretisation::estimator(Physics::Extended));
    link.set_finger(0, &finger).unwrap();
    assert_eq!(link.finger(0).unwrap().as_ref(), Some(&finger), "kept as it was sent");
    link.set_object(0, OBJECT).unwrap();
    watch.until_report("a finger clear of the object", PATIENCE, |report| report.estimate.status == Status::NoContact);
    watch.reports.clear();
    link.close(Which::All, CLOSED, Some(0.2)).unwrap();
    watch.until_report("a closed finger", PATIENCE, |report| {
        report.goal == CLOSED && (report.estimate.motor_angle - CLOSED).abs() < 0.004 && report.estimate.age == 0
    });
    let agreement = Agreement::of(&watch.reports, &load);
    assert!(agreement.is_within(0.01), "{agreement:?}");
    // All ribs are in the picture.
    let ribs = |shape: &messages::Shape| [shape.lamella_front.len(), shape.lamella_back.len()];
    assert_eq!(watch.shapes.last().map(ribs), Some([15, 15]));
}
