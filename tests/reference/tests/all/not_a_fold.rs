//! What is wrong with an object is not reported as the end of a branch.

use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::object::{Displacement, Gap, Motion, Object};
use model_core::real::Vec2;
use model_core::size::{Blank, Paper};
use model_core::status::Status;
use reference_tests::ladder_80;

/// What a circle's owner may get wrong.
#[derive(Clone, Copy, Debug)]
enum Fault {
    /// None.
    None,
    /// The distance comes in steps of 0.01 mm.
    Coarse,
    /// Normals that lean to one side and the other.
    Leaning,
}

#[derive(Clone, Copy)]
struct Faulty {
    centre: Vec2<f64>,
    fault: Fault,
}

impl Blank for Faulty {
    const BLANK: Self = Self { centre: Vec2::new(0.0, 0.0), fault: Fault::None };
}

impl Object<f64> for Faulty {
    fn displaced(&self, by: &Displacement<f64>) -> Self {
        Self { centre: by.point(self.centre), ..*self }
    }

    fn gap(&self, point: Vec2<f64>) -> Gap<f64> {
        let offset = point - self.centre;
        let distance = offset.x.hypot(offset.y);
        let normal = offset / distance;
        let curvature = 1.0 / distance;
        match self.fault {
            Fault::None => Gap { distance: distance - 40.0, normal, curvature },
            Fault::Coarse => Gap { distance: (distance * 100.0).floor() / 100.0 - 40.0, normal, curvature },
            Fault::Leaning => {
                let lean = if (point.y * 0.3).floor() as i64 % 2 == 0 { 2.0 } else { -2.0 };
                let leaning = normal + Vec2::new(-normal.y, normal.x) * lean;
                Gap { distance: distance - 40.0, normal: leaning / leaning.x.hypot(leaning.y), curvature }
            }
        }
    }
}

fn closed(fault: Fault) -> Status {
    let design = ladder_80();
    let mut follower: Box<Follower<f64, Paper, Faulty>> = Box::new(Follower::EMPTY);
    follower.configure(&design, &Discretisation::reduced(Physics::Extended)).expect("a valid finger");
    let object = Faulty { centre: Vec2::new(41.0, 60.0), fault };
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(0.0));
    follower.follow(2.0_f64.to_radians()).status
}

#[test]
fn a_distance_that_is_none_is_no_end_of_a_branch() {
    assert_eq!(closed(Fault::None), Status::Converged);
    for fault in [Fault::Coarse, Fault::Leaning] {
        let status = closed(fault);
        println!("{fault:?}: {status}");
        assert!(!status.is_trustworthy() && status != Status::Folded, "{fault:?}: {status}");
    }
}
