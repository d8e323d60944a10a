//! The finger of these examples: two beams of 80 mm, seven lamellae 9 mm apart, hinges from the centrelines. mm, MPa.

use model_core::design::{
    Attachments, Beam, Design, Hinge, HingeFrom, HingeKind, Lamellae, Material, MaterialLaw, PlaneStrain, Profile,
};

pub fn design() -> Design {
    let beam =
        |base| Beam { base, tip: [0.0, 80.0], sagitta: 0.0, thickness: Profile::constant(2.0), stiffness_factor: 1.0 };
    Design {
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
    }
}
