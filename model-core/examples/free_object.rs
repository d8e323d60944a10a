//! Two fingers close on a cylinder that nothing else holds: where it comes to rest, and how hard it is squeezed, without friction and with it.
//!
//!     cargo run --release -p model-core --example free_object

use model_core::design::ladder_80;
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::grasp::{Finger, Grasp, Load, Placement};
use model_core::object::{Motion, ObjectDesign};
use model_core::size::{Paper, Rubbing};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let design = ladder_80();
    let mut models: [Box<Follower<f64, Paper>>; 2] = [Box::new(Follower::EMPTY), Box::new(Follower::EMPTY)];
    for model in &mut models {
        model.configure(&design, &Discretisation::reduced(Physics::Extended))?;
    }
    // The right finger is the left one's mirror image, 56 mm away.
    let right = Placement { mirrored: true, angle: 0.0, translation: [56.0, 0.0] };
    let motion = Motion::Rotating { axis: design.motor_axis };
    let fingers = models.iter_mut().zip([Placement::HERE, right]);
    let fingers = fingers.map(|(follower, placement)| Finger { follower, placement, motion });

    // A cylinder of 20 g, held at (28, 44) mm while the fingers close, the left one further; then let go.
    let weight = Load { force: [0.0, -0.2], moment: 0.0 };
    let object = ObjectDesign::Circle { centre: [28.0, 44.0], radius: 25.0 };
    let mut grasp = Grasp::new(fingers.collect(), object, weight)?;
    for left in [8.0, 9.0, 10.0_f64] {
        grasp.close(&[left.to_radians(), 8_f64.to_radians()])?;
        let balance = grasp.release();
        let [x, y] = balance.centre;
        println!(
            "left {left}°, right 8°: {}, centre ({x:.3}, {y:.3}) mm, squeeze {:.3} N",
            balance.status, balance.squeeze
        );
        let [fx, fy] = balance.net;
        assert!(balance.status.is_trustworthy() && (fx + weight.force[0]).hypot(fy + weight.force[1]) < 1e-4);
    }

    // With friction the fingers move together with it, and it stays where they have gripped it.
    let mut models: [Box<Follower<f64, Rubbing>>; 2] = [Box::new(Follower::EMPTY), Box::new(Follower::EMPTY)];
    for model in &mut models {
        model.configure(&design, &Discretisation::reduced(Physics::Extended))?;
        model.set_friction(0.5)?;
    }
    let fingers = models.iter_mut().zip([Placement::HERE, right]);
    let fingers = fingers.map(|(follower, placement)| Finger { follower, placement, motion });
    let mut grasp = Grasp::new(fingers.collect(), object, weight)?;
    grasp.close(&[8_f64.to_radians(); 2])?;
    grasp.release();
    for left in [8.5, 9.0, 9.5, 10.0_f64] {
        let balance = grasp.advance_within(&[left.to_radians(), 8_f64.to_radians()], u32::MAX)?;
        let [x, y] = balance.centre;
        println!(
            "friction 0.5, left {left}°, right 8°: {}, centre ({x:.3}, {y:.3}) mm, squeeze {:.3} N",
            balance.status, balance.squeeze
        );
        assert!(balance.status.is_trustworthy() && (balance.net[1] + weight.force[1]).abs() < 1e-3);
    }
    Ok(())
}
