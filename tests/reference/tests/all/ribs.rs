//! Welded ribs that bend, against finite elements (`ribs.csv`), force, torque and front centreline.

use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::real::Real;
use model_core::size::{Paper, Ribs as Room, Size};
use model_core::status::Status;
use reference_tests::ribs::{rib_rows, ribbed_80};

fn compare<T: Real, S: Size>(how: &Discretisation) {
    let mut follower: Box<Follower<T, S>> = Box::new(Follower::EMPTY);
    let mut series = "";
    for row in rib_rows() {
        if series != row.series {
            series = row.series;
            let design = ribbed_80(row.thickness, row.inclination);
            follower.configure(&design, how).expect("a valid design");
            follower.set_object(row.object(), Motion::Rotating { axis: design.motor_axis });
            assert!(follower.start(0.0));
        }
        let outcome = follower.follow(row.degrees.to_radians());
        let [x, y] = follower.solution().force_finger().map(Real::to_f64);
        let force = x.hypot(y);
        let torque = follower.solution().motor_torque().to_f64();
        let line: Vec<[f64; 2]> = follower.solution().front().map(|p| p.map(Real::to_f64)).collect();
        let (error, moment, shape) = (force / row.force - 1.0, torque / row.torque - 1.0, row.off(&line));
        println!(
            "{} {:4}° {:9} {:2} FEA {:7.4} N, ours {force:7.4} N ({:+6.2} %), torque {:+6.2} %, shape {shape:.3} mm{}",
            row.series,
            row.degrees,
            outcome.status.word(),
            outcome.iterations,
            row.force,
            100.0 * error,
            100.0 * moment,
            if row.bowed { ", bowed" } else { "" }
        );
        assert!(outcome.status.is_trustworthy(), "{} {}°: {outcome:?}", row.series, row.degrees);
        let is_high = row.height > 50.0;
        assert_eq!(outcome.status == Status::Snapped, is_high && row.degrees > 9.0, "{} {}°", row.series, row.degrees);
        if !row.bowed {
            assert!(error.abs() < 0.02 && moment.abs() < 0.02, "{} {}°: {error} {moment}", row.series, row.degrees);
            assert!(shape < 0.1, "{} {}°: {shape} mm", row.series, row.degrees);
        }
    }
}

/// The snap of ribs of 1.2 mm at High: where it comes when closing and goes when opening, and the largest force before it. Finite
/// elements: between 8.75° and 9°, back between 8.25° and 8°, 22.5 N at 8.75°.
#[test]
fn the_snap_at_high() {
    let design = ribbed_80(1.2, 0.0);
    let mut follower: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
    follower.configure(&design, &Discretisation::fine(Physics::Extended)).expect("a valid design");
    let object = ObjectDesign::Circle { centre: [41.0, 60.0], radius: 40.0 };
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(0.0));
    let (mut snap, mut peak) = (None, 0.0_f64);
    let at = |follower: &mut Follower<f64, Paper>, step: i32| {
        let degrees = 0.05 * f64::from(step);
        let outcome = follower.follow(degrees.to_radians());
        assert!(outcome.status.is_trustworthy(), "{degrees}°: {outcome:?}");
        let [x, y] = follower.solution().force_finger();
        (degrees, x.hypot(y), outcome.snaps > 0)
    };
    for step in 0..=200 {
        let (degrees, force, snaps) = at(&mut follower, step);
        if snaps {
            snap.get_or_insert(degrees);
        }
        peak = if snap.is_none() { peak.max(force) } else { peak };
    }
    let mut back = None;
    for step in (120..200).rev() {
        let (degrees, _, snaps) = at(&mut follower, step);
        if snaps {
            back.get_or_insert(degrees);
        }
    }
    println!("snap at {snap:?}°, back at {back:?}°, peak {peak:.2} N");
    let near = |found: Option<f64>, low: f64, high: f64| found.is_some_and(|found| (low..=high).contains(&found));
    assert!(near(snap, 8.75, 9.2) && near(back, 7.75, 8.5), "{snap:?} {back:?}");
    // CalculiX on the case's own mesh, in steps of 0.05° (`fre compare --fea`): 22.86 N at 8.9°, snapped at 8.95°. At the same angles the
    // forces are within 0.4 %, but the snap comes 0.2° later.
    assert!((peak / 22.86 - 1.0).abs() < 0.03, "{peak}");
}

#[test]
fn fine_in_double_precision() {
    compare::<f64, Paper>(&Discretisation::fine(Physics::Extended));
}

#[test]
fn reduced_in_single_precision() {
    compare::<f32, Room>(&Discretisation::estimator(Physics::Extended));
}
