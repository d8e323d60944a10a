//! The preset `umi`, as a microcontroller has it.

use heapless::Vec;
use model_core::design::{
    Attachments, Beam, Design, Hinge, HingeKind, LamellaKind, Lamellae, Material, PlaneStrain, Profile, Ribs, ladder_80,
};

/// The soft finger of the Universal Manipulation Interface: 15 welded ribs between a thin front wall and a back wall that curves and
/// tapers. A test of the bench compares it with the preset.
///
/// # Panics
/// On a microcontroller whose lists are too short for it, [`model_core::size::Lists::TARGET`].
pub fn umi() -> Design {
    let plain = ladder_80();
    let back: [[f64; 2]; 12] = [
        [-36.740, 0.000],
        [-34.845, 14.314],
        [-33.320, 26.822],
        [-30.732, 42.000],
        [-28.125, 53.712],
        [-24.923, 65.276],
        [-13.879, 95.288],
        [-10.564, 102.568],
        [-6.145, 111.537],
        [-4.240, 115.055],
        [-3.288, 116.813],
        [-1.765, 119.624],
    ];
    let taper = [
        [42.44, 5.678],
        [46.44, 5.657],
        [50.44, 5.666],
        [54.44, 5.566],
        [60.44, 5.400],
        [70.44, 5.084],
        [78.44, 4.758],
        [86.44, 4.394],
        [96.44, 3.799],
        [100.44, 3.656],
        [102.44, 3.540],
        [106.44, 3.221],
        [116.44, 2.642],
        [125.63, 1.929],
    ];
    let front_arcs = [
        14.0, 17.886, 21.82, 25.851, 30.028, 34.408, 39.06, 44.067, 49.533, 55.596, 61.891, 69.3, 77.831, 87.851,
        99.904,
    ];
    let back_arcs = [
        14.122, 20.61, 27.06, 33.524, 40.043, 46.66, 53.419, 60.356, 67.521, 74.97, 82.328, 89.959, 97.965, 106.398,
        115.333,
    ];
    let front = Beam::straight([0.0, 0.0], [0.0, 122.365], Profile::constant(1.8));
    let [base, via @ .., tip] = back;
    Design {
        width: Profile::constant(25.8),
        plane_strain: PlaneStrain::Auto,
        material: Material { youngs_modulus: 10.0, poissons_ratio: 0.45, ..plain.material },
        front: Beam { clamp: 10.0, ..front },
        back: Beam {
            via: Vec::from_iter(via),
            clamp: 42.44,
            ..Beam::straight(base, tip, Profile { knots: Vec::from_iter(taper) })
        },
        lamellae: Lamellae {
            attachments: Attachments::Arcs { front: Vec::from_iter(front_arcs), back: Vec::from_iter(back_arcs) },
            thickness: (0..15).map(|rib| [if rib < 10 { 2.0 } else { 1.2 }; 2]).collect(),
            kind: LamellaKind::Rib(Ribs::WELDED),
        },
        hinge: Hinge { kind: HingeKind::Welded, length: Vec::new(), thickness: 1.0, ..plain.hinge },
        rigid_above: Some(119.198),
        motor_axis: [0.0; 2],
    }
}
