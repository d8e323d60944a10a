//! The finger that examples, tests and reference data share.

use super::{
    Attachments, Beam, Design, Hinge, HingeFrom, HingeKind, Lamellae, Material, MaterialLaw, PlaneStrain, Profile,
};

/// `ladder-80`, the finger of the reference data: two beams of 80 mm, seven lamellae 9 mm apart, flexible hinges of 2.5 mm measured
/// from the centrelines.
pub fn ladder_80() -> Design {
    let beam = |base| Beam::straight(base, [0.0, 80.0], Profile::constant(2.0));
    Design {
        width: Profile::constant(20.0),
        plane_strain: PlaneStrain::Stress,
        material: Material { youngs_modulus: 49.5, poissons_ratio: 0.48, law: MaterialLaw::default() },
        front: beam([0.0, 0.0]),
        back: beam([-28.0, 0.0]),
        lamellae: Lamellae::rigid(Attachments::Heights((1..=7).map(|k| 9.0 * f64::from(k)).collect()), 3.0),
        hinge: Hinge {
            kind: HingeKind::Flexible,
            length: heapless::Vec::from_iter([2.5]),
            thickness: 0.8,
            from: HingeFrom::Centreline,
        },
        rigid_above: None,
        motor_axis: [-14.0, -20.0],
    }
}
