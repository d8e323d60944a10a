//! What lies between the beams: rigid lamellae, or ribs that bend.

use super::{MAX_LAMELLAE, MAX_THICKNESSES};
use heapless::Vec;

/// Where the lamellae are joined to the beams, base to tip.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum Attachments {
    /// The same height (finger-frame y, mm) on both beams.
    Heights(Vec<f64, MAX_LAMELLAE>),
    /// Arc lengths from the bases, mm, one entry per lamella on each beam.
    Arcs {
        /// Along the front beam.
        front: Vec<f64, MAX_LAMELLAE>,
        /// Along the back beam.
        back: Vec<f64, MAX_LAMELLAE>,
    },
}

impl Attachments {
    /// Number of lamellae.
    pub fn len(&self) -> usize {
        match self {
            Self::Heights(heights) => heights.len(),
            Self::Arcs { front, .. } => front.len(),
        }
    }

    /// True for a finger without lamellae.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// How ribs end at the beams.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum RibEnds {
    /// Of one piece with both beams.
    #[default]
    Welded,
    /// With necks, as the design's hinge describes them: their kind is flexible, whatever it says.
    Hinged,
    /// Of one piece with the front beam, and free before the back beam: the middle of the end is so far from the back beam's face, mm. Where
    /// it meets the face it presses against it, and slides along it without friction.
    Gap(f64),
}

/// Ribs: lamellae that bend, of the beams' material.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Ribs {
    /// How they end.
    pub ends: RibEnds,
    /// Radius of the fillets at welded ends, mm.
    pub fillet: f64,
    /// Multiplies EI.
    pub bending_factor: f64,
    /// Multiplies EA and, with it, the shear stiffness.
    pub stretch_factor: f64,
}

impl Ribs {
    /// Welded, with sharp corners, as stiff as the material is.
    pub const WELDED: Self = Self { ends: RibEnds::Welded, fillet: 0.0, bending_factor: 1.0, stretch_factor: 1.0 };
}

/// What the lamellae are.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum LamellaKind {
    /// Rigid bars, joined to the beams by the design's hinges.
    #[default]
    Rigid,
    /// Ribs that bend.
    Rib(Ribs),
}

/// The lamellae.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Lamellae {
    /// Where they are joined to the beams.
    pub attachments: Attachments,
    /// Thickness (front, back) in the plane, mm: one pair for all lamellae or one per lamella, linear from the front beam's face to the
    /// back beam's. That of rigid lamellae is for pictures and finite elements.
    pub thickness: Vec<[f64; 2], MAX_THICKNESSES>,
    /// Rigid, or ribs.
    pub kind: LamellaKind,
}

impl Lamellae {
    /// Thickness that is the same everywhere, mm.
    pub fn uniform(thickness: f64) -> Vec<[f64; 2], MAX_THICKNESSES> {
        Vec::from_iter([[thickness; 2]])
    }

    /// Rigid ones of one thickness, mm.
    pub fn rigid(attachments: Attachments, thickness: f64) -> Self {
        Self { attachments, thickness: Self::uniform(thickness), kind: LamellaKind::Rigid }
    }

    /// Thickness (front, back) of lamella k, mm.
    pub fn thickness_of(&self, lamella: usize) -> [f64; 2] {
        let entry = if self.thickness.len() == 1 { 0 } else { lamella };
        self.thickness.get(entry).copied().unwrap_or([0.0; 2])
    }

    /// The largest thickness of any, mm; 0 without one.
    pub fn thickest(&self) -> f64 {
        self.thickness.iter().flatten().fold(0.0, |most, &thickness| most.max(thickness))
    }

    /// Distance of the ribs' free ends from the back beam's face, mm, if they have such ends.
    pub fn gap(&self) -> Option<f64> {
        match self.kind {
            LamellaKind::Rib(Ribs { ends: RibEnds::Gap(gap), .. }) => Some(gap),
            _ => None,
        }
    }

    /// The ribs, if the lamellae bend.
    pub fn ribs(&self) -> Option<&Ribs> {
        match &self.kind {
            LamellaKind::Rigid => None,
            LamellaKind::Rib(ribs) => Some(ribs),
        }
    }
}
