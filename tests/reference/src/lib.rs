//! The reference data of `tests/reference` and the fingers they were made with.

use heapless::Vec;
use model_core::design::{
    Attachments, Beam, Design, Hinge, HingeFrom, HingeKind, Lamellae, Material, PlaneStrain, Profile,
};

/// The finger of `ladder-80.csv`: 80 mm front beam, seven lamellae at heights 9k, hinges from the centrelines.
pub fn ladder_80() -> Design {
    let beam = |base| Beam { base, tip: [0.0, 80.0], thickness: Profile::constant(2.0), stiffness_factor: 1.0 };
    Design {
        width: Profile::constant(20.0),
        plane_strain: PlaneStrain::Stress,
        material: Material { youngs_modulus: 49.5, poissons_ratio: 0.48 },
        front: beam([0.0, 0.0]),
        back: beam([-28.0, 0.0]),
        lamellae: Lamellae {
            attachments: Attachments::Heights((1..=7).map(|k| 9.0 * f64::from(k)).collect()),
            thickness: 3.0,
        },
        hinge: Hinge {
            kind: HingeKind::Flexible,
            length: Vec::from_iter([2.5]),
            thickness: 0.8,
            from: HingeFrom::Centreline,
        },
        rigid_above: None,
        motor_axis: [-14.0, -20.0],
    }
}

/// A row of `ladder-80.csv`; column names as in the file, units in mm, N, degrees.
#[derive(Clone, Debug)]
pub struct LadderRow {
    /// `paper-170-20-nodes`, `trapezoid-170-20-nodes`, `SIMPSON 2/3/1 H4 eps1e-3` or `SIMPSON 2/3/1 node`.
    pub scheme: String,
    /// Name of the case.
    pub case: String,
    /// Radius of the circle.
    pub radius: f64,
    /// Its centre, world frame.
    pub centre: [f64; 2],
    /// Motor angle, degrees.
    pub angle: f64,
    /// Force on the object, finger frame.
    pub force_finger: [f64; 2],
    /// Force on the object, world frame.
    pub force_world: [f64; 2],
    /// Elastic energy, N·mm.
    pub energy: f64,
    /// Tip, finger frame.
    pub tip: [f64; 2],
    /// Samples with a positive force.
    pub active_contacts: usize,
    /// Motor torque, N·mm.
    pub torque: f64,
}

/// The rows of `ladder-80.csv`.
///
/// # Panics
/// On a malformed file: the data are part of the tests.
pub fn ladder_rows() -> std::vec::Vec<LadderRow> {
    let text = include_str!("../ladder-80.csv");
    let mut lines = text.lines();
    let header = lines.next().expect("ladder-80.csv has a header");
    assert!(header.starts_with("scheme,case,radius_mm,centre_x_mm"), "unexpected header {header}");
    lines
        .map(|line| {
            let field: std::vec::Vec<&str> = line.split(',').collect();
            let number = |i: usize| -> f64 { field[i].parse().unwrap_or_else(|_| panic!("column {i} of {line}")) };
            LadderRow {
                scheme: field[0].to_string(),
                case: field[1].to_string(),
                radius: number(2),
                centre: [number(3), number(4)],
                angle: number(5),
                force_finger: [number(6), number(7)],
                force_world: [number(8), number(9)],
                energy: number(11),
                tip: [number(12), number(13)],
                active_contacts: number(14) as usize,
                torque: number(15),
            }
        })
        .collect()
}
