//! The reference data of `tests/reference` and the fingers they were made with, for the tests on the PC and on the target.

#![no_std]

#[cfg(not(target_os = "none"))]
pub mod random;

use heapless::Vec;
use model_core::design::{
    Attachments, Beam, Design, Hinge, HingeFrom, HingeKind, Lamellae, Material, MaterialLaw, PlaneStrain, Profile,
};
use model_core::discretise::{Discretisation, Physics, Sampling, Scheme};
use model_core::object::ObjectDesign;

/// The finger of `ladder-80.csv`: 80 mm front beam, seven lamellae at heights 9k, hinges from the centrelines.
pub fn ladder_80() -> Design {
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
            length: Vec::from_iter([2.5]),
            thickness: 0.8,
            from: HingeFrom::Centreline,
        },
        rigid_above: None,
        motor_axis: [-14.0, -20.0],
    }
}

/// The finger of `fea-80.csv` and `fea-80-fine.csv`: six lamellae, necks between faces, a solid wedge at the tip.
pub fn fea_80() -> Design {
    let mut design = ladder_80();
    design.lamellae.attachments = Attachments::Heights((1..=6).map(|k| 10.0 * f64::from(k)).collect());
    design.hinge.length = Vec::from_iter([2.5, 2.5, 2.5, 2.5, 2.5, 1.97]);
    design.hinge.from = HingeFrom::Face;
    design.rigid_above = Some(74.116);
    design
}

/// A row of `ladder-80.csv`; column names as in the file, units in mm, N, degrees.
#[derive(Clone, Copy, Debug)]
pub struct LadderRow {
    /// `paper-170-20-nodes`, `trapezoid-170-20-nodes`, `SIMPSON 2/3/1 H4 eps1e-3` or `SIMPSON 2/3/1 node`.
    pub scheme: &'static str,
    /// Name of the case.
    pub case: &'static str,
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

impl LadderRow {
    /// The discretisation that the row was computed with.
    ///
    /// # Panics
    /// On an unknown scheme: the data are part of the tests.
    pub fn discretisation(&self) -> Discretisation {
        match self.scheme {
            "paper-170-20-nodes" => Discretisation::full(Scheme::Paper, Physics::Paper),
            "trapezoid-170-20-nodes" => Discretisation::full(Scheme::Trapezoid, Physics::Paper),
            "SIMPSON 2/3/1 H4 eps1e-3" => Discretisation::reduced(Physics::Paper),
            "SIMPSON 2/3/1 node" => {
                Discretisation { sampling: Sampling::Nodes, softness: 0.0, ..Discretisation::reduced(Physics::Paper) }
            }
            other => panic!("unknown scheme {other}"),
        }
    }

    /// The object.
    pub fn object(&self) -> ObjectDesign {
        ObjectDesign::Circle { centre: self.centre, radius: self.radius }
    }
}

/// The rows of `ladder-80.csv`.
///
/// # Panics
/// On a malformed file: the data are part of the tests.
pub fn ladder_rows() -> impl Iterator<Item = LadderRow> {
    let mut lines = include_str!("../ladder-80.csv").lines();
    let header = lines.next().expect("ladder-80.csv has a header");
    assert!(header.starts_with("scheme,case,radius_mm,centre_x_mm"), "unexpected header {header}");
    lines.map(|line| {
        let field = |column: usize| line.split(',').nth(column).expect("a column");
        let number = |column: usize| -> f64 { field(column).parse().expect("a number") };
        LadderRow {
            scheme: field(0),
            case: field(1),
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
}

/// Radians per count of a Dynamixel position sensor.
pub const COUNT: f64 = core::f64::consts::TAU / 4096.0;

/// The circle of 80 mm diameter at one of the contact heights 30 (Low), 45 (Mid) and 60 mm (High), touching at 0.
pub fn circle_80(height: f64) -> ObjectDesign {
    ObjectDesign::Circle { centre: [41.0, height], radius: 40.0 }
}
