//! `ribs.csv` and `ribs-centreline.csv`: fingers with welded ribs that bend, by finite elements.

use heapless::Vec;
use model_core::design::{Attachments, Design, LamellaKind, Lamellae, Ribs, ladder_80};
use model_core::object::ObjectDesign;

/// Part of the force by which a halved mesh is softer.
const MESH: f64 = 0.0083;

/// The finger of `ribs.csv`: the beams of `fea-80`, seven welded ribs of a thickness, mm, inclined by an angle, degrees, positive when
/// the front end is lower.
pub fn ribbed_80(thickness: f64, degrees: f64) -> Design {
    let mut design = ladder_80();
    let slope = libm::tan(degrees.to_radians());
    let (mut front, mut back) = (Vec::new(), Vec::new());
    for k in 1..=7 {
        // Through the point midway between the centrelines, whose back one lies at x = −28 + 0.35 y.
        let (y, half) = (9.0 * f64::from(k), 0.5 * (28.0 - 0.35 * 9.0 * f64::from(k)));
        let on_front = y - slope * half;
        let on_back = (y - slope * (-28.0 + half)) / (1.0 + 0.35 * slope);
        front.push(on_front).expect("seven ribs");
        back.push(on_back * libm::hypot(28.0, 80.0) / 80.0).expect("seven ribs");
    }
    design.lamellae = Lamellae {
        attachments: Attachments::Arcs { front, back },
        thickness: Lamellae::uniform(thickness),
        kind: LamellaKind::Rib(Ribs::WELDED),
    };
    design.rigid_above = Some(74.1158);
    design
}

/// A row of `ribs.csv`; units in mm, N, degrees.
#[derive(Clone, Copy, Debug)]
pub struct RibRow {
    /// Name of the series.
    pub series: &'static str,
    /// Thickness of the ribs.
    pub thickness: f64,
    /// Their inclination.
    pub inclination: f64,
    /// Radius of the circle, and height of its centre; it touches at 0.
    pub radius: f64,
    /// Height of its centre.
    pub height: f64,
    /// Motor angle.
    pub degrees: f64,
    /// Magnitude of the force, as a halved mesh would have it.
    pub force: f64,
    /// Torque, N·mm, likewise.
    pub torque: f64,
    /// A rib's bow exceeds 5 % of its length.
    pub bowed: bool,
}

impl RibRow {
    /// The object.
    pub fn object(&self) -> ObjectDesign {
        ObjectDesign::Circle { centre: [1.0 + self.radius, self.height], radius: self.radius }
    }

    /// The deformed front centreline, finger frame; empty at angles that have none.
    pub fn front(&self) -> impl Iterator<Item = [f64; 2]> + use<> {
        let (series, degrees) = (self.series, self.degrees);
        let lines = include_str!("../ribs-centreline.csv").lines().skip(1);
        lines.filter_map(move |line| {
            let field = |column: usize| line.split(',').nth(column).expect("a column");
            let number = |column: usize| -> f64 { field(column).parse().expect("a number") };
            (field(0) == series && number(2) == degrees).then(|| [number(4), number(5)])
        })
    }

    /// Largest nearest distance of that centreline to a line of points, mm.
    pub fn off(&self, line: &[[f64; 2]]) -> f64 {
        self.front().map(|p| super::distance_to(p, || line.iter().copied())).fold(0.0, f64::max)
    }
}

/// The rows of `ribs.csv`.
///
/// # Panics
/// On a malformed file: the data are part of the tests.
pub fn rib_rows() -> impl Iterator<Item = RibRow> {
    let mut lines = include_str!("../ribs.csv").lines();
    let header = lines.next().expect("ribs.csv has a header");
    assert!(header.starts_with("series,code,case,joint,rib_thickness_mm,"), "unexpected header {header}");
    lines.map(|line| {
        let field = |column: usize| line.split(',').nth(column).expect("a column");
        let number = |column: usize| -> f64 { field(column).parse().expect("a number") };
        RibRow {
            series: field(0),
            thickness: number(4),
            inclination: number(5),
            radius: 0.5 * number(10),
            height: number(11),
            degrees: number(13),
            force: number(18) * (1.0 - MESH),
            torque: number(19) * (1.0 - MESH),
            bowed: number(27) != 0.0,
        }
    })
}
