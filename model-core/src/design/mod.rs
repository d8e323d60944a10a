//! What a person describes: beams, lamellae, hinges, material, motor axis; and why a description is refused.
//!
//! Units: mm, N, rad, MPa (N/mm²). Positions are in the finger frame: origin at the front beam's base, y along the
//! undeformed front beam towards the tip, x towards the object; the back beam's base lies at negative x.

mod beam;
mod check;
mod course;
mod error;
pub(crate) mod junction;
mod ladder_80;
mod lamella;
pub(crate) mod weld;
mod weld_tables;

pub use beam::Beam;
pub use error::{DesignError, Field};
use heapless::Vec;
pub use ladder_80::ladder_80;
pub use lamella::{Attachments, LamellaKind, Lamellae, RibEnds, Ribs};
pub use weld::weld_numbers;

use crate::size::Lists;

/// Largest number of lamellae of a finger on this machine.
pub const MAX_LAMELLAE: usize = Lists::HERE.lamellae as usize;
/// Largest number of their thicknesses on this machine.
pub const MAX_THICKNESSES: usize = Lists::HERE.thicknesses as usize;
/// Largest number of knots of a [`Profile`] on this machine.
pub const MAX_KNOTS: usize = Lists::HERE.knots as usize;
/// Largest number of points of a centreline between its ends on this machine.
pub const MAX_POINTS: usize = Lists::HERE.points as usize;

/// A quantity along the finger: constant, or linear between knots and constant beyond the first and last.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Profile {
    /// Pairs (position, value), positions strictly increasing; one pair describes a constant.
    pub knots: Vec<[f64; 2], MAX_KNOTS>,
}

impl Profile {
    /// The same value everywhere.
    pub fn constant(value: f64) -> Self {
        let mut knots = Vec::new();
        // A fresh list always has room for one knot.
        let _ = knots.push([0.0, value]);
        Self { knots }
    }

    /// Value at a position.
    #[inline(never)]
    pub fn at(&self, position: f64) -> f64 {
        let Some(first) = self.knots.first() else { return 0.0 };
        let mut before = *first;
        for &knot in &self.knots {
            if position < knot[0] {
                let span = knot[0] - before[0];
                let part = if span > 0.0 { (position - before[0]) / span } else { 0.0 };
                return before[1] + part.max(0.0) * (knot[1] - before[1]);
            }
            before = knot;
        }
        before[1]
    }
}

/// The material of beams and hinges.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Material {
    /// Young's modulus E, MPa.
    pub youngs_modulus: f64,
    /// Poisson's ratio ν, 0 ≤ ν < 0.5.
    pub poissons_ratio: f64,
    /// How its stiffness changes with strain; seen by the `extended` physics only.
    pub law: MaterialLaw,
}

/// Second-order elasticity: a fibre at nominal strain u stores ½E(u² + c u³) per volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum MaterialLaw {
    /// Linear between Green's strain and the second Piola–Kirchhoff stress, as finite elements with a linear material and
    /// large displacements: u + u²/2 squared, c = 1.
    #[default]
    StVenantKirchhoff,
    /// An incompressible rubber: ⅙E(λ² + 2/λ − 3) with λ = 1 + u, c = −2/3.
    NeoHookean,
    /// Stiffness independent of the strain: c = 0.
    Linear,
}

impl MaterialLaw {
    /// The coefficient c.
    pub fn second_order(self) -> f64 {
        match self {
            Self::StVenantKirchhoff => 1.0,
            Self::NeoHookean => -2.0 / 3.0,
            Self::Linear => 0.0,
        }
    }
}

/// How much a wide beam is stiffened because its cross-section cannot curl.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum PlaneStrain {
    /// Plane stress: EI as it is.
    Stress,
    /// Plane strain: EI/(1−ν²).
    Strain,
    /// Between the two, from width, thickness and clear length.
    #[default]
    Auto,
}

/// What joins a lamella to a beam.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum HingeKind {
    /// A thin flexible neck: a Cosserat rod.
    #[default]
    Flexible,
    /// A pin: the lamella turns freely about the beam's centreline.
    Pinned,
    /// None: the lamella turns with the beams.
    Welded,
}

/// What a hinge's length is measured from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum HingeFrom {
    /// The beam's centreline, as in *Geometrico-Static Modelling of a FRE Finger*.
    #[default]
    Centreline,
    /// The beam's face: the clear length of the neck; the flexible length then reaches into beam and bar.
    Face,
}

/// The flexible hinges between lamellae and beams.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Hinge {
    /// Flexible, pinned or welded.
    pub kind: HingeKind,
    /// Length, mm: one entry for all lamellae or one per lamella.
    pub length: Vec<f64, MAX_LAMELLAE>,
    /// Thickness in the plane, mm.
    pub thickness: f64,
    /// What the length is measured from.
    pub from: HingeFrom,
}

impl Hinge {
    /// Length of the hinges of lamella k, mm.
    pub fn length_of(&self, lamella: usize) -> f64 {
        let entry = if self.length.len() == 1 { 0 } else { lamella };
        self.length.get(entry).copied().unwrap_or(0.0)
    }
}

/// A Fin-Ray finger.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Design {
    /// Width perpendicular to the plane against height, mm.
    pub width: Profile,
    /// Stiffening of wide beams.
    pub plane_strain: PlaneStrain,
    /// Material of beams and hinges.
    pub material: Material,
    /// Contact beam.
    pub front: Beam,
    /// The other beam.
    pub back: Beam,
    /// Lamellae.
    pub lamellae: Lamellae,
    /// Hinges.
    pub hinge: Hinge,
    /// Height (finger-frame y, mm) above which both beams are one rigid wedge; `None`: no wedge.
    pub rigid_above: Option<f64>,
    /// Motor axis M, mm.
    pub motor_axis: [f64; 2],
}

impl Design {
    /// Number of lamellae.
    pub fn lamella_count(&self) -> usize {
        self.lamellae.attachments.len()
    }

    /// Arc lengths (front, back), mm, at which lamella k is joined to the beams.
    pub fn attachment_arcs(&self, lamella: usize) -> [f64; 2] {
        match &self.lamellae.attachments {
            Attachments::Heights(heights) => {
                let height = heights.get(lamella).copied().unwrap_or(0.0);
                [self.front.arc_at_height(height), self.back.arc_at_height(height)]
            }
            Attachments::Arcs { front, back } => {
                [front.get(lamella).copied().unwrap_or(0.0), back.get(lamella).copied().unwrap_or(0.0)]
            }
        }
    }

    /// Thickness (front, back) in the plane of lamella k, mm.
    pub fn lamella_thickness(&self, lamella: usize) -> [f64; 2] {
        self.lamellae.thickness_of(lamella)
    }

    /// What joins the lamellae to the beams: hinges as [`Self::hinge`] has them, or what ribs end in.
    pub fn joint(&self) -> HingeKind {
        match self.lamellae.kind {
            LamellaKind::Rigid => self.hinge.kind,
            LamellaKind::Rib(Ribs { ends: RibEnds::Welded | RibEnds::Gap(_), .. }) => HingeKind::Welded,
            LamellaKind::Rib(Ribs { ends: RibEnds::Hinged, .. }) => HingeKind::Flexible,
        }
    }

    /// Distance of lamella k's two attachments on the undeformed centrelines, mm.
    pub fn lamella_width(&self, lamella: usize) -> f64 {
        let [front, back] = self.attachment_arcs(lamella);
        let (p, q) = (self.front.point(front), self.back.point(back));
        libm::hypot(q[0] - p[0], q[1] - p[1])
    }

    /// Lamella k ends on the part of the back beam that is held.
    pub fn is_held(&self, lamella: usize) -> bool {
        self.attachment_arcs(lamella)[1] <= self.back.clamp
    }

    /// Arc lengths (front, back), mm, at which the flexible part of the beams ends.
    pub fn flexible_ends(&self) -> [f64; 2] {
        let end = |beam: &Beam| match self.rigid_above {
            Some(height) => beam.arc_at_height(height).min(beam.length()),
            None => beam.length(),
        };
        [end(&self.front), end(&self.back)]
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// So many lamellae, evenly spaced (9 mm apart for seven, otherwise up to a height of 55 mm).
    pub(crate) fn set_heights(design: &mut Design, count: usize) {
        let pitch = if count == 7 { 9.0 } else { 55.0 / count.max(1) as f64 };
        design.lamellae.attachments = Attachments::Heights((1..=count).map(|k| pitch * k as f64).collect());
    }

    /// Makes a finger's lamellae welded ribs of a thickness.
    pub(crate) fn ribs(design: &mut Design, thickness: f64) -> &mut Ribs {
        design.lamellae.thickness = Lamellae::uniform(thickness);
        design.lamellae.kind = LamellaKind::Rib(Ribs::WELDED);
        match &mut design.lamellae.kind {
            LamellaKind::Rib(ribs) => ribs,
            LamellaKind::Rigid => unreachable!("just made ribs"),
        }
    }

    #[test]
    fn every_reason_for_rejection_names_its_field() {
        let reject = |change: &dyn Fn(&mut Design)| {
            let mut design = ladder_80();
            change(&mut design);
            design.validate().expect_err("must be refused")
        };
        let message = |change: &dyn Fn(&mut Design)| std::format!("{}", reject(change));
        type Change<'a> = (&'a str, &'a dyn Fn(&mut Design));
        let cases: &[Change<'_>] = &[
            ("width_mm", &|d| d.width = Profile::constant(-1.0)),
            ("width_mm", &|d| d.width.knots.clear()),
            ("material.youngs_modulus_pa", &|d| d.material.youngs_modulus = f64::NAN),
            ("material.youngs_modulus_pa", &|d| d.material.youngs_modulus = 0.0),
            ("material.poissons_ratio", &|d| d.material.poissons_ratio = 0.5),
            ("front.base_mm", &|d| d.front.base[0] = f64::INFINITY),
            ("front.tip_mm", &|d| d.front.tip[1] = 0.0),
            ("front.thickness_mm", &|d| d.front.thickness = Profile::constant(-2.0)),
            ("front.stiffness_factor", &|d| d.front.stiffness_factor = 0.0),
            ("front.bending_factor", &|d| d.front.bending_factor = f64::NAN),
            ("front.stretch_factor", &|d| d.front.stretch_factor = -1.0),
            ("front.clamp_mm", &|d| d.front.clamp = -1.0),
            ("front.clamp_mm", &|d| d.front.clamp = 80.0),
            ("lamellae.heights_mm", &|d| d.front.clamp = 9.5),
            ("back.clamp_mm", &|d| d.back.clamp = f64::NAN),
            ("back.bending_factor", &|d| d.back.bending_factor = 0.0),
            ("back.stretch_factor", &|d| d.back.stretch_factor = 0.0),
            // A rigid lamella that is welded to what is held would hold the front beam as well.
            ("hinge.kind", &|d| {
                d.hinge.kind = HingeKind::Welded;
                d.back.clamp = 12.0;
            }),
            ("front.centreline_mm", &|d| d.front.via = Vec::from_iter([[0.0, f64::NAN]])),
            ("front.centreline_mm", &|d| d.front.via = Vec::from_iter([[0.0, 40.0], [0.0, 40.0]])),
            ("back.centreline_mm", &|d| d.back.via = Vec::from_iter([[-27.0, 40.0], [-10.0, 41.0]])),
            ("back.base_mm", &|d| d.back.base = [5.0, 0.0]),
            ("back.tip_mm", &|d| d.back.tip = [-40.0, 80.0]),
            ("back.thickness_mm", &|d| d.back.thickness = Profile::constant(f64::NAN)),
            ("back.stiffness_factor", &|d| d.back.stiffness_factor = -1.0),
            ("lamellae.heights_mm", &|d| d.lamellae.attachments = Attachments::Heights(Vec::from_iter([90.0]))),
            ("lamellae.heights_mm", &|d| d.lamellae.attachments = Attachments::Heights(Vec::from_iter([20.0, 10.0]))),
            ("lamellae.heights_mm", &|d| d.lamellae.attachments = Attachments::Heights(Vec::from_iter([f64::NAN]))),
            ("lamellae.front_arc_mm", &|d| {
                d.lamellae.attachments =
                    Attachments::Arcs { front: Vec::from_iter([-1.0]), back: Vec::from_iter([9.0]) };
            }),
            ("lamellae.back_arc_mm", &|d| {
                d.lamellae.attachments =
                    Attachments::Arcs { front: Vec::from_iter([9.0]), back: Vec::from_iter([99.0]) };
            }),
            ("lamellae.back_arc_mm", &|d| {
                d.lamellae.attachments = Attachments::Arcs { front: Vec::from_iter([9.0]), back: Vec::new() };
            }),
            ("lamellae.thickness_mm", &|d| d.lamellae.thickness = Lamellae::uniform(0.0)),
            ("lamellae.thickness_mm", &|d| d.lamellae.thickness = Vec::from_iter([[1.0; 2]; 3])),
            ("lamellae.thickness_mm", &|d| {
                ribs(d, 1.2);
                d.lamellae.thickness = Vec::from_iter([[1.2, f64::NAN]]);
            }),
            ("lamellae.bending_factor", &|d| ribs(d, 1.2).bending_factor = 0.0),
            ("lamellae.stretch_factor", &|d| ribs(d, 1.2).stretch_factor = f64::INFINITY),
            ("lamellae.fillet_mm", &|d| ribs(d, 1.2).fillet = -1.0),
            // More than twice the ribs' thickness; more than the window between two ribs has room for.
            ("lamellae.fillet_mm is 2.5; at rib 1 at most 2.4", &|d| ribs(d, 1.2).fillet = 2.5),
            ("lamellae.fillet_mm is 4; at rib 2 at most 3.2", &|d| ribs(d, 2.5).fillet = 4.0),
            // Thicker than there is room between two, and a last one that the wedge leaves no room for.
            ("lamellae.thickness_mm", &|d| {
                ribs(d, 12.0);
            }),
            ("lamellae", &|d| {
                ribs(d, 1.2);
                set_heights(d, 1);
                d.lamellae.attachments = Attachments::Heights(Vec::from_iter([75.0]));
            }),
            ("hinge.length_mm", &|d| d.hinge.length.clear()),
            ("hinge.length_mm", &|d| d.hinge.length = Vec::from_iter([-2.5])),
            ("hinge.length_mm", &|d| d.hinge.length = Vec::from_iter([15.0])),
            ("hinge.thickness_mm", &|d| d.hinge.thickness = -0.8),
            ("tip.rigid_above_mm", &|d| d.rigid_above = Some(-3.0)),
            ("motor.axis_mm", &|d| d.motor_axis[1] = f64::NAN),
        ];
        for (key, change) in cases {
            let text = message(change);
            assert!(text.contains(key), "{text:?} does not name {key}");
        }
        assert_eq!(ladder_80().validate(), Ok(()));
    }

    #[test]
    fn a_profile_is_linear_between_its_knots() {
        let profile = Profile { knots: Vec::from_iter([[10.0, 2.0], [20.0, 4.0]]) };
        assert_eq!([0.0, 10.0, 15.0, 20.0, 99.0].map(|x| profile.at(x)), [2.0, 2.0, 3.0, 4.0, 4.0]);
    }
}
