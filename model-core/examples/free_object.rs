//! Two fingers close on a cylinder that nothing else holds: where it comes to rest, and how hard it is squeezed.
//!
//!     cargo run --release -p model-core --example free_object

use model_core::design::{
    Attachments, Beam, Design, Hinge, HingeFrom, HingeKind, Lamellae, Material, MaterialLaw, PlaneStrain, Profile,
};
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::grasp::{Finger, Grasp, Load, Placement};
use model_core::object::{Motion, ObjectDesign};
use model_core::size::Paper;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let beam =
        |base| Beam { base, tip: [0.0, 80.0], sagitta: 0.0, thickness: Profile::constant(2.0), stiffness_factor: 1.0 };
    let design = Design {
        width: Profile::constant(20.0),
        plane_strain: PlaneStrain::Stress,
        material: Material { youngs_modulus: 49.5, poissons_ratio: 0.48, law: MaterialLaw::default() },
        front: beam([0.0, 0.0]),
        back: beam([-28.0, 0.0]),
        lamellae: Lamellae {
            attachments: Attachments::Heights((1..=7).map(|k| 9.0 * f64::from(k)).collect()),
            thickness: 3.0,
        },
        hinge: Hinge {
            kind: HingeKind::Flexible,
            length: [2.5].into_iter().collect(),
            thickness: 0.8,
            from: HingeFrom::Centreline,
        },
        rigid_above: None,
        motor_axis: [-14.0, -20.0],
    };
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
    Ok(())
}
