//! What the messages say, against mechanics and against what robots' programs expect.

mod told;

use std::path::Path;

use fre_gripper::source::{Base, Told};
use fre_ros2::message::{Action, DiagnosticArray, DynamicJointState, JointState, Level, MarkerArray, WrenchStamped};
use fre_ros2::{Message, NAMES, Telling};
use messages::{Grasp, GripMargin, Mount, Phase, Report, Side, Why};
use model_core::drive::Drive;
use model_core::estimator::{Estimate, Interval};
use model_core::status::Status;
use told::{model, report, setup};

const MS: u64 = 1_000_000;

/// What became of something, each kind at most once.
#[derive(Default)]
struct Said {
    wrench: Option<WrenchStamped>,
    certainty: Option<DynamicJointState>,
    joint: Option<JointState>,
    markers: Option<MarkerArray>,
    diagnostics: Option<DiagnosticArray>,
}

impl Said {
    fn by(telling: &mut Telling, ns: u64, told: &Told) -> Self {
        let mut said = Self::default();
        for message in telling.tell(ns, told) {
            match message {
                Message::Wrench(0, message) => assert!(said.wrench.replace(message).is_none()),
                Message::Certainty(0, message) => assert!(said.certainty.replace(message).is_none()),
                Message::Joint(message) => assert!(said.joint.replace(message).is_none()),
                Message::Markers(message) => assert!(said.markers.replace(message).is_none()),
                Message::Diagnostics(message) => assert!(said.diagnostics.replace(message).is_none()),
                other => panic!("{other:?}: there is one finger"),
            }
        }
        said
    }

    fn value(&self, name: &str) -> f64 {
        let values = &self.certainty.as_ref().unwrap().interface_values[0];
        let at = values.interface_names.iter().position(|known| known == name).unwrap();
        values.values[at]
    }
}

/// The force and its moment are the sums over the contact points of the shape, which the estimate's torque does not come from.
#[test]
fn a_wrench_is_the_sum_of_the_contact_forces_about_its_frame() {
    for drive in [Drive::Rotating, Drive::linear([1.0, 0.2], 30.0)] {
        let setup = setup(drive);
        let axis = setup.models[0].finger.as_ref().unwrap().design.motor_axis;
        let (mut model, mut telling) = (model(drive), Telling::new(&setup));
        let mut touched = 0;
        for tick in 0..110 {
            let report = report(tick, model.update((0.1 * tick as f64).to_radians()));
            let said = Said::by(&mut telling, tick * 2 * MS, &Told::Report(report));
            let (shape, wrench) = (model.shape(&report), said.wrench.unwrap());
            assert_eq!(wrench.header.frame_id, "finger_0_base");
            if !report.estimate.status.is_trustworthy() {
                continue;
            }
            let base = Base::of(&shape, axis);
            let mut sum = [0.0; 3];
            for contact in &shape.contacts {
                let ([x, y], [fx, fy]) = (base.point(contact.position), base.vector(contact.force));
                sum = [sum[0] + fx, sum[1] + fy, sum[2] + 1e-3 * (x * fy - y * fx)];
            }
            touched += u64::from(!shape.contacts.is_empty());
            let found = [wrench.wrench.force.x, wrench.wrench.force.y, wrench.wrench.torque.z];
            let flat = [wrench.wrench.force.z, wrench.wrench.torque.x, wrench.wrench.torque.y];
            assert_eq!(flat, [0.0; 3]);
            for (found, sum) in found.into_iter().zip(sum) {
                assert!((found - sum).abs() < 1e-4 * (1.0 + sum.abs()), "{drive:?} tick {tick}: {found} and {sum}");
            }
        }
        assert!(touched > 30, "{drive:?}: {touched}");
    }
}

/// What the whole grip bears is with every finger's force, while it is new: the weaker one of what is reported in the plane and across it.
#[test]
fn the_margin_of_a_grip_is_with_the_forces_of_its_fingers() {
    let mut setup = setup(Drive::Rotating);
    setup.models.push(setup.models[0].clone());
    setup.settings.fingers[1] = Some(Mount { servo_id: 2, side: Side::Right, ..Mount::DEFAULT });
    let tick_ns = 1_000_000_000 / u64::from(setup.settings.rate_hz);
    let (mut model, mut telling) = (model(Drive::Rotating), Telling::new(&setup));
    let report = (0..90).map(|tick| report(tick, model.update((0.1 * tick as f64).to_radians()))).last().unwrap();
    let mut of = |ns: u64, told: Told| {
        let messages = telling.tell(ns, &told).into_iter();
        let mut margins = messages.filter_map(|message| match message {
            Message::Certainty(finger, certainty) => Some((finger, certainty.interface_values[0].values[4])),
            _ => None,
        });
        margins.next_back()
    };
    let margin = |least: f32, across: f32, age: u16| GripMargin {
        least,
        direction: 0.0,
        across,
        couple: 9.0,
        slips: Some(1),
        carried: Some(2.0),
        age,
    };
    let grasp = |margin: Option<GripMargin>| {
        let (sum, squeeze, balance) = ([0.0; 2], 4.0, 1.0);
        Told::Grasp(Grasp { sequence: 90, is_trustworthy: true, sum, squeeze, balance, free: None, margin })
    };
    assert!(of(0, Told::Report(report)).is_some_and(|(_, margin)| margin.is_nan()), "before a grasp was reported");
    for (given, weaker) in [(margin(3.5, 5.0, 0), 3.5), (margin(3.5, 1.25, 0), 1.25)] {
        assert_eq!(of(0, grasp(Some(given))), None);
        for finger in [0, 1] {
            assert_eq!(of(MS, Told::Report(Report { finger, ..report })), Some((finger, weaker)));
        }
    }
    // Its age counts from the contact forces that it is of.
    let late = 600 * MS;
    of(late, grasp(Some(margin(3.5, 5.0, 10))));
    let last = late + 500 * MS - 10 * tick_ns;
    assert_eq!(of(last - 1, Told::Report(report)), Some((0, 3.5)));
    assert!(of(last, Told::Report(report)).is_some_and(|(_, margin)| margin.is_nan()), "a margin that is old");
    of(last, grasp(Some(margin(3.5, 5.0, 0))));
    of(last, grasp(None));
    assert!(of(last, Told::Report(report)).is_some_and(|(_, margin)| margin.is_nan()), "a margin that is withdrawn");
}

#[test]
fn what_must_not_be_used_is_not_a_number_and_has_its_status() {
    let mut telling = Telling::new(&setup(Drive::Rotating));
    let good =
        Estimate { force: [3.0, -1.0], torque: 14.0, standard_deviation: 0.2, ..Estimate::blank(Status::Converged) };
    let said = Said::by(&mut telling, 10 * MS, &Told::Report(report(0, good)));
    // Motor axis (-14, -20) mm: -14·(-1) + 20·3 - 14 N·mm.
    assert!((said.wrench.as_ref().unwrap().wrench.torque.z - 0.060).abs() < 1e-12);
    assert_eq!(said.wrench.as_ref().unwrap().header.stamp.nanosec, 10_000_000);
    assert!(
        (said.value("force") - 10_f64.sqrt()).abs() < 1e-6
            && (said.value("force_standard_deviation") - 0.2).abs() < 1e-6
    );
    assert_eq!(["trusted", "status", "age"].map(|name| said.value(name)), [1.0, 0.0, 0.0]);
    // Without friction there is no interval; a single finger does not grip.
    assert!(["force_interval_low", "force_interval_high", "margin"].iter().all(|name| said.value(name).is_nan()));
    let interval = Some(Interval { magnitude: [4.5, 5.5], ..Interval::default() });
    let rough = Told::Report(report(1, Estimate { interval, ..good }));
    let rough = Said::by(&mut Telling::new(&setup(Drive::Rotating)), 10 * MS, &rough);
    assert_eq!(["force_interval_low", "force_interval_high"].map(|name| rough.value(name)), [4.5, 5.5]);
    assert_eq!(said.joint.as_ref().unwrap().effort, [0.014]);

    // Numbers of a tick ago, and ones that did not converge.
    for (at, status, age) in [(2, Status::Stale, 1), (3, Status::MaxIterations, 2), (4, Status::Tracking, 3)] {
        let ns = 10 * MS + at * 2 * MS;
        let said = Said::by(&mut telling, ns, &Told::Report(report(at, Estimate { status, age, ..good })));
        let wrench = said.wrench.as_ref().unwrap().wrench;
        let numbers = [wrench.force, wrench.torque].map(|v| [v.x, v.y, v.z]).concat();
        assert!(numbers.iter().all(|number| number.is_nan()), "{status}: {numbers:?}");
        assert!(said.value("force").is_nan() && said.value("force_standard_deviation").is_nan());
        assert_eq!([said.value("trusted"), said.value("status")], [0.0, f64::from(status as u8)]);
        assert!((said.value("age") - 0.002 * at as f64).abs() < 1e-9);
        let diagnostics = &said.diagnostics.as_ref().expect("said at once").status[0];
        let level = if status == Status::Stale { Level::Stale } else { Level::Error };
        assert_eq!((diagnostics.level, diagnostics.message.as_str()), (level as u8, status.word()));
        match &said.joint {
            None => assert_eq!(status, Status::Stale, "no position came in this tick"),
            Some(joint) => assert!(joint.effort[0].is_nan() && joint.velocity.is_empty()),
        }
    }
    // Report 1 never came.
    let lost = Said::by(&mut telling, 200 * MS, &Told::Report(report(5, good))).diagnostics.unwrap();
    assert!(
        lost.status[0].values.iter().any(|pair| (pair.key.as_str(), pair.value.as_str()) == ("missing_reports", "1"))
    );
}

#[test]
fn the_numbers_of_the_statuses_stay() {
    let words = [
        Status::Converged,
        Status::Tracking,
        Status::NoContact,
        Status::Snapped,
        Status::MaxIterations,
        Status::Stagnated,
        Status::Folded,
        Status::ContactCapacity,
        Status::OutOfRange,
        Status::Stale,
        Status::Precision,
        Status::Unsettled,
        Status::Updating,
    ];
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/ros2.md");
    let page = std::fs::read_to_string(page).unwrap();
    for (number, status) in words.iter().enumerate() {
        assert_eq!(usize::from(*status as u8), number, "{status}");
        assert!(page.contains(&format!("{number} `{status}`")), "docs/ros2.md does not list {number} {status}");
    }
    assert_eq!(NAMES.len(), 8);
}

#[test]
fn diagnostics_come_ten_times_a_second_and_at_once_when_something_changes() {
    let mut telling = Telling::new(&setup(Drive::Rotating));
    let at =
        |telling: &mut Telling, ms: u64, report: Report| Said::by(telling, ms * MS, &Told::Report(report)).diagnostics;
    let calm = report(0, Estimate::blank(Status::NoContact));
    let mut count = 0;
    for tick in 0..500 {
        count += usize::from(at(&mut telling, 1000 + 2 * tick, Report { sequence: tick as u32, ..calm }).is_some());
    }
    assert_eq!(count, 10);
    let waiting = Report { sequence: 500, phase: Phase::Waiting(Why::Bus), ..calm };
    let status = at(&mut telling, 2001, waiting).expect("at once").status.remove(0);
    assert_eq!(
        (status.level, status.name.as_str(), status.hardware_id.as_str()),
        (Level::Warn as u8, "fre: finger 0", "a test")
    );
    assert!(at(&mut telling, 2003, Report { sequence: 501, ..waiting }).is_none());

    // Nothing more comes.
    assert!(telling.silence(2400 * MS).is_none());
    let Some(Message::Diagnostics(silent)) = telling.silence(2600 * MS) else { panic!("it is silent") };
    assert_eq!((silent.status[0].level, silent.status[0].message.as_str()), (Level::Stale as u8, "nothing for 0.6 s"));
    assert!(telling.silence(2650 * MS).is_none() && telling.silence(2700 * MS).is_some());
    // Before the first report there is nothing to be old.
    let Some(Message::Diagnostics(first)) = Telling::new(&setup(Drive::Rotating)).silence(5000 * MS) else { panic!() };
    assert_eq!((first.status[0].level, first.status[0].message.as_str()), (Level::Stale as u8, "no report yet"));
}

#[test]
fn a_finger_is_drawn_thirty_times_a_second_where_it_is() {
    let setup = setup(Drive::Rotating);
    let (mut model, mut telling) = (model(Drive::Rotating), Telling::new(&setup));
    let closing = (0..=90).map(|tenth| (0.1 * f64::from(tenth)).to_radians());
    let report = report(0, closing.map(|angle| model.update(angle)).last().unwrap());
    let shape = model.shape(&report);
    assert!(shape.contacts.len() > 1);
    let drawn = |telling: &mut Telling, ns| Said::by(telling, ns, &Told::Shape(Box::new(shape.clone()))).markers;
    let count = (0..500).filter(|tick| drawn(&mut telling, 2 * MS * tick).is_some()).count();
    assert!((28..=30).contains(&count), "{count} in a second");

    let markers = drawn(&mut telling, 5000 * MS).unwrap().markers;
    let (sin, cos) = 9_f64.to_radians().sin_cos();
    // The front beam's base turns clockwise about the motor axis (-14, -20) mm.
    let (x, y) = (-14.0 + 14.0 * cos + 20.0 * sin, -20.0 + 20.0 * cos - 14.0 * sin);
    let foot = markers[0].points[0];
    assert!((foot.x - 1e-3 * x).abs() < 1e-6 && (foot.y - 1e-3 * y).abs() < 1e-6 && foot.z == 0.0, "{foot:?}");
    assert_eq!(markers.iter().map(|marker| marker.id).collect::<Vec<_>>(), [0, 1, 2, 3]);
    assert!(markers.iter().all(|marker| marker.ns == "finger_0" && marker.header.frame_id == "finger_0_base"));
    assert_eq!(markers[2].points.len(), 2 * 7, "a pair per lamella");
    assert_eq!((markers[3].action, markers[3].points.len()), (Action::Add as i32, 2 * shape.contacts.len()));

    // Without a trustworthy estimate there are no forces, and no colour that says so.
    let untrusted = Told::Shape(Box::new(messages::Shape { status: Status::Folded, ..shape.clone() }));
    let grey = Said::by(&mut telling, 6000 * MS, &untrusted).markers.unwrap().markers;
    assert_eq!(grey[3].action, Action::Delete as i32);
    assert!(grey[0].color == grey[2].color && markers[0].color != markers[2].color);
}

#[test]
fn a_jaw_is_a_prismatic_joint() {
    let drive = Drive::linear([1.0, 0.0], 30.0);
    let mut telling = Telling::new(&setup(drive));
    let estimate = Estimate { motor_angle: 0.5, torque: 60.0, ..Estimate::blank(Status::Converged) };
    let joint = Said::by(&mut telling, MS, &Told::Report(report(0, estimate))).joint.unwrap();
    // 30 mm/rad · 0.5 rad; 60 N·mm at the motor are 2 N along the way.
    assert_eq!((joint.name, joint.position, joint.effort), (vec!["finger_0_joint".to_owned()], vec![0.015], vec![2.0]));
}
