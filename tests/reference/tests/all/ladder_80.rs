//! Every row of `ladder-80.csv`: the discrete model of *Geometrico-Static Modelling of a FRE Finger*, computed independently.

use model_core::equilibrium::Follower;
use model_core::object::Motion;
use model_core::size::Paper;
use model_core::status::Status;
use reference_tests::{ladder_80, ladder_rows};

#[test]
fn every_row_is_reproduced() {
    let design = ladder_80();
    let mut follower = Box::new(Follower::<f64, Paper>::EMPTY);
    let mut rows = 0;
    for row in ladder_rows() {
        rows += 1;
        follower.configure(&design, &row.discretisation()).expect("the reference finger is valid");
        follower.set_object(row.object(), Motion::Rotating { axis: design.motor_axis });
        assert!(follower.start(0.0));
        let outcome = follower.follow(row.angle.to_radians());
        let name = format!("{} {} {}°", row.scheme, row.case, row.angle);
        println!(
            "{name}: {outcome:?} force {:?} energy {}",
            follower.solution().force_finger(),
            follower.solution().energy()
        );
        assert_eq!(outcome.status, Status::Converged, "{name}");
        let force = row.force_finger[0].hypot(row.force_finger[1]);
        let close = |found: f64, expected: f64, allowed: f64, what: &str| {
            assert!((found - expected).abs() <= allowed, "{name}: {what} is {found}, expected {expected}");
        };
        for i in 0..2 {
            close(
                follower.solution().force_finger()[i],
                row.force_finger[i],
                1e-7 * force,
                "force in the finger frame",
            );
            close(follower.solution().force_world()[i], row.force_world[i], 1e-7 * force, "force in the world frame");
            close(follower.solution().tip()[i], row.tip[i], 1e-6, "tip");
        }
        close(follower.solution().energy(), row.energy, 1e-7 * row.energy, "energy");
        close(follower.solution().motor_torque(), row.torque, 1e-7 * row.torque, "torque");
        assert_eq!(follower.solution().contacts().count(), row.active_contacts, "{name}: active contacts");
    }
    assert_eq!(rows, 24);
}
