//! The reference data of `tests/reference` and the fingers they were made with, for the tests on the PC and on the target.

#![no_std]

#[cfg(not(target_os = "none"))]
extern crate std;

pub mod campaign;
pub mod closing;
#[cfg(not(target_os = "none"))]
pub mod friction;
#[cfg(not(target_os = "none"))]
pub mod junction;
#[cfg(not(target_os = "none"))]
pub mod plates;
#[cfg(not(target_os = "none"))]
pub mod random;
pub mod ribs;
#[cfg(not(target_os = "none"))]
pub mod twins;
pub mod umi;
#[cfg(not(target_os = "none"))]
pub mod wide;

use heapless::Vec;
pub use model_core::design::ladder_80;
use model_core::design::{Attachments, Design, HingeFrom};
use model_core::discretise::{Discretisation, Physics, Sampling, Scheme, Softness};
use model_core::object::ObjectDesign;

/// Terms [gᵢ, τᵢ in s] of a material with memory for tests and benches: tenths of a second and half a minute. No printed TPU was measured.
pub const TERMS: [[f64; 2]; 2] = [[0.2, 0.1], [0.2, 30.0]];
/// A tick of a controller at 500 Hz, s.
pub const TICK_S: f64 = 0.002;

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
            "SIMPSON 2/3/1 H4 eps1e-3" => {
                Discretisation { softness: Softness::Fixed(1e-3), ..Discretisation::reduced(Physics::Paper) }
            }
            "SIMPSON 2/3/1 node" => Discretisation {
                sampling: Sampling::Nodes,
                softness: Softness::Fixed(0.0),
                ..Discretisation::reduced(Physics::Paper)
            },
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

/// A row of `fea-80-fine.csv`: the finger [`fea_80`] pressed on a circle, by finite elements; units in mm, N, degrees.
#[derive(Clone, Debug)]
pub struct FeaRow {
    /// Name of the series.
    pub series: &'static str,
    /// Radius of the circle, and height of its centre; it touches at 0.
    pub radius: f64,
    /// Height of its centre.
    pub height: f64,
    /// Motor angle, degrees.
    pub degrees: f64,
    /// Magnitude of the force.
    pub force: f64,
    /// Deformed front centreline, finger frame.
    pub front: Vec<[f64; 2], 48>,
}

impl FeaRow {
    /// The object.
    pub fn object(&self) -> ObjectDesign {
        ObjectDesign::Circle { centre: [1.0 + self.radius, self.height], radius: self.radius }
    }

    /// Allowed deviations of force (relative) and front centreline (mm) of the extended physics; none beyond the peak at
    /// High, where percentages mean nothing.
    pub fn allowed(&self) -> Option<(f64, f64)> {
        match (self.series, self.degrees) {
            ("R40_High", angle) if angle > 10.5 => None,
            ("R40_High", angle) if angle > 8.0 => Some((0.02, 0.14)),
            ("R40_High", _) => Some((0.01, 0.08)),
            _ => Some((0.01, 0.05)),
        }
    }

    /// Largest nearest distance of the reference's centreline to a line of points, mm.
    pub fn off<I: Iterator<Item = [f64; 2]>>(&self, line: impl Fn() -> I) -> f64 {
        self.front.iter().map(|&p| distance_to(p, &line)).fold(0.0, f64::max)
    }
}

/// Distance of a point to a line of points.
fn distance_to<I: Iterator<Item = [f64; 2]>>(p: [f64; 2], line: impl Fn() -> I) -> f64 {
    let distance = |a: [f64; 2], b: [f64; 2]| {
        let d = [b[0] - a[0], b[1] - a[1]];
        let along = ((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / (d[0] * d[0] + d[1] * d[1]);
        let part = along.clamp(0.0, 1.0);
        let off = [p[0] - a[0] - part * d[0], p[1] - a[1] - part * d[1]];
        off[0] * off[0] + off[1] * off[1]
    };
    libm::sqrt(line().zip(line().skip(1)).map(|(a, b)| distance(a, b)).fold(f64::MAX, f64::min))
}

/// The rows of `fea-80-fine.csv`.
///
/// # Panics
/// On a malformed file: the data are part of the tests.
pub fn fea_rows() -> impl Iterator<Item = FeaRow> {
    let mut lines = include_str!("../fea-80-fine.csv").lines();
    let header = lines.next().expect("fea-80-fine.csv has a header");
    assert!(header.starts_with("solver,case,diameter_mm,"), "unexpected header {header}");
    lines.map(|line| {
        let field = |column: usize| line.split(',').nth(column).expect("a column");
        let number = |text: &str| -> f64 { text.parse().expect("a number") };
        let list = |column: usize| field(column).split(' ').map(number);
        FeaRow {
            series: field(1),
            radius: 0.5 * number(field(2)),
            height: number(field(3)),
            degrees: number(field(4)),
            force: number(field(9)),
            front: list(13).zip(list(14)).map(|(x, y)| [x, y]).collect(),
        }
    })
}

/// Radians per count of a Dynamixel position sensor.
pub const COUNT: f64 = core::f64::consts::TAU / 4096.0;

/// The circle of 80 mm diameter at one of the contact heights 30 (Low), 45 (Mid) and 60 mm (High), touching at 0.
pub fn circle_80(height: f64) -> ObjectDesign {
    ObjectDesign::Circle { centre: [41.0, height], radius: 40.0 }
}
