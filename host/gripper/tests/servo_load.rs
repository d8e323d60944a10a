//! The load's table against the model it is made from.

use std::f64::consts::TAU;

use fre::case::preset;
use fre::heap::Host;
use fre::study::model::Options;
use fre_gripper::servo::{Load, LoadError, OnBranch};
use model_core::design::Design;
use model_core::discretise::{Discretisation, Physics, Scheme};
use model_core::drive::{Drive, Knots, Travel};
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::status::Status;

fn ladder() -> Design {
    preset("ladder-80").unwrap().unwrap().design
}

fn circle(x: f64, y: f64) -> ObjectDesign {
    ObjectDesign::Circle { centre: [x, y], radius: 40.0 }
}

#[test]
fn the_table_is_the_model() {
    for (scheme, y) in [(Scheme::Paper, 45.0), (Scheme::Trapezoid, 30.0)] {
        let options = Options { discretisation: Discretisation::full(scheme, Physics::Paper), ..Load::REFERENCE };
        let load = Load::of(&ladder(), circle(41.0, y), &Drive::Rotating, &options, 11.0).unwrap();
        let mut follower = Follower::<f64, Host>::EMPTY;
        follower.configure(&ladder(), &options.discretisation).unwrap();
        follower.set_object(circle(41.0, y), Motion::Rotating { axis: ladder().motor_axis });
        assert!(follower.start(0.0));
        let mut on = OnBranch::default();
        for step in 0..60 {
            // Counts, and places between them.
            let count = 2.03 * f64::from(step);
            let count = if step % 2 == 0 { count.round() } else { count };
            let angle = count / 4096.0 * TAU;
            assert!(follower.follow(angle).status.is_trustworthy());
            let there = load.at(angle, &mut on);
            // On the nodes nothing is lost; between them the contact's kinks are cut off.
            let allowed = if step % 2 == 0 { 1e-6 } else { 0.04 };
            for (table, model) in there.force.iter().zip(follower.solution().force_world()) {
                assert!((table - model).abs() < allowed, "{scheme:?} at {count}: {table} {model}");
            }
            assert!((there.torque - follower.solution().motor_torque()).abs() < 100.0 * allowed);
        }
    }
}

/// A jaw: the force is the model's at the drive's distance, and the motor's torque is the force times the distance per angle.
#[test]
fn a_jaw_moves_along_its_line() {
    let crank: Vec<[f32; 2]> =
        [-20.0_f32, 0.0, 20.0, 40.0].map(|angle| [angle.to_radians(), 25.0 * angle.to_radians().sin()]).to_vec();
    let table = Travel::Table(Knots::new(&crank).unwrap());
    let drives = [Drive::linear([1.0, 0.0], 20.0), Drive::Translating { direction: [2.0, 0.0], travel: table }];
    let object = circle(45.0, 45.0);
    for drive in drives {
        let load = Load::of(&ladder(), object, &drive, &Load::REFERENCE, 30.0).unwrap();
        let mut follower = Follower::<f64, Host>::EMPTY;
        follower.configure(&ladder(), &Load::REFERENCE.discretisation).unwrap();
        follower.set_object(object, Motion::Translating { direction: [1.0, 0.0] });
        assert!(follower.start(0.0));
        let (mut on, mut most) = (OnBranch::default(), 0.0_f64);
        for count in 0..320 {
            let angle = f64::from(count) / 4096.0 * TAU;
            let [distance, slope] = drive.coordinate(angle).unwrap();
            assert!(follower.follow(distance).status.is_trustworthy(), "{drive:?} at {count}");
            let there = load.at(angle, &mut on);
            for (table, model) in there.force.iter().zip(follower.solution().force_world()) {
                assert!((table - model).abs() < 1e-6, "{drive:?} at {count}: {table} {model}");
            }
            let torque = follower.solution().force_world()[0] * slope;
            assert!((there.torque - torque).abs() < 1e-3, "{drive:?} at {count}: {} {torque}", there.torque);
            most = most.max(torque);
        }
        assert!(most > 50.0, "{drive:?}: {most}");
    }
    let open = Travel::Table(Knots::new(&[[0.1, 0.0], [1.0, 20.0]]).unwrap());
    let drive = Drive::Translating { direction: [1.0, 0.0], travel: open };
    assert_eq!(Load::of(&ladder(), object, &drive, &Load::REFERENCE, 30.0).err(), Some(LoadError::NoZero));
    let still = Drive::linear([0.0, 0.0], 20.0);
    assert!(matches!(Load::of(&ladder(), object, &still, &Load::REFERENCE, 30.0), Err(LoadError::Drive(_))));
}

#[test]
fn it_says_where_it_ends() {
    let load = Load::of(&ladder(), circle(45.0, 45.0), &Drive::Rotating, &Load::REFERENCE, 6.0).unwrap();
    let first = load.first_contact().unwrap().to_degrees();
    assert!((2.0..4.0).contains(&first), "{first}");
    let mut on = OnBranch::default();
    assert_eq!(load.at(-0.5, &mut on).status, Status::NoContact);
    assert_eq!(load.at((first - 0.1).to_radians(), &mut on).torque, 0.0);
    assert_eq!(load.at((first + 0.5).to_radians(), &mut on).status, Status::Converged);
    assert_eq!(load.at(7f64.to_radians(), &mut on).status, Status::OutOfRange);
    assert!(load.at(5f64.to_radians(), &mut on).torque > 0.0, "and the way back is open");
}

#[test]
fn no_table_is_made_from_nonsense() {
    let of = |highest| Load::of(&ladder(), circle(41.0, 45.0), &Drive::Rotating, &Load::REFERENCE, highest).err();
    assert!(matches!(of(f64::NAN), Some(LoadError::Range { .. })));
    assert!(matches!(of(-3.0), Some(LoadError::Range { .. })));
    let inside = ObjectDesign::Circle { centre: [-14.0, -20.0], radius: 300.0 };
    assert_eq!(Load::of(&ladder(), inside, &Drive::Rotating, &Load::REFERENCE, 10.0).err(), Some(LoadError::NoRoom));
}
