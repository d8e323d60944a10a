//! Keys of `[finger]`.

use model_core::design::{Field, MAX_KNOTS, MAX_LAMELLAE, MAX_POINTS};
use model_core::equilibrium::{PRONY_PARTS, PRONY_TERMS, PRONY_TIMES};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::values::{Along, PerRib, RibThickness, TipFrom};
use crate::case::finger::PA_PER_MPA;

/// Range of a finger's strain at failure: below the first nothing bends, above the second no strain is small.
const MAX_STRAIN: [f64; 2] = [1e-5, 10.0];

fn one() -> f64 {
    1.0
}

/// The range of a modulus in the file's unit.
fn pascals(range: Option<[f64; 2]>) -> Option<[f64; 2]> {
    range.map(|range| range.map(|limit| limit * PA_PER_MPA))
}

/// The range of the terms of a material with memory.
fn prony_limits() -> String {
    let ([least, most], [shortest, longest]) = (PRONY_PARTS, PRONY_TIMES);
    format!("gᵢ and Σ gᵢ {least} to {most}, τᵢ {shortest} to {longest:e} s; up to {PRONY_TERMS} entries")
}

/// Two flexible beams that meet at the tip, and lamellae between them. Finger frame: origin at the front beam's base, y
/// towards the tip, x towards the object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FingerTable {
    /// Name for titles and tables.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "the name of the file or preset"))]
    pub name: Option<String>,
    /// Width perpendicular to the plane of motion: a number, or a taper against height.
    #[schemars(extend(
        "x-unit" = "mm", "x-range" = Field::Width.range(), "x-pair" = "[height_mm, width_mm]",
        "maxItems" = MAX_KNOTS, "minItems" = 1
    ))]
    pub width_mm: Along,
    /// How much a wide beam is stiffened because its cross-section cannot curl.
    #[serde(default)]
    pub plane_strain: PlaneStrain,
    /// Material of beams, lamellae and hinges.
    #[schemars(extend("x-needed" = "a table with youngs_modulus_pa and poissons_ratio"))]
    pub material: MaterialTable,
    /// The contact beam: the side that touches the object.
    #[schemars(extend("x-needed" = "a table with base_mm, tip_mm and thickness_mm"))]
    pub front: BeamTable,
    /// The other beam.
    #[schemars(extend("x-needed" = "a table with base_mm, tip_mm and thickness_mm"))]
    pub back: BeamTable,
    /// Lamellae between the beams, base to tip. A finger without this table has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "no lamellae"))]
    pub lamellae: Option<LamellaeTable>,
    /// What joins rigid lamellae to the beams, or the necks of ribs with `ends = "hinged"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "none without lamellae"))]
    pub hinge: Option<HingeTable>,
    /// The tip, where the beams merge.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "the beams meet in a point"))]
    pub tip: Option<TipTable>,
    /// The motor; needed with `motor_angles_deg`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "none: the base moves along a line"))]
    pub motor: Option<MotorTable>,
}

/// How much a wide beam is stiffened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlaneStrain {
    /// Plane stress: EI as it is.
    Stress,
    /// Plane strain: EI/(1 − ν²).
    Strain,
    /// Between the two, from width, thickness and clear length.
    #[default]
    Auto,
}

/// The material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialTable {
    /// Young's modulus E.
    #[schemars(extend("x-unit" = "Pa", "x-range" = pascals(Field::YoungsModulus.range())))]
    pub youngs_modulus_pa: f64,
    /// Poisson's ratio ν.
    #[schemars(extend("x-range" = Field::PoissonsRatio.range()))]
    pub poissons_ratio: f64,
    /// How the stiffness changes with strain (`extended` physics).
    #[serde(default)]
    pub law: MaterialLaw,
    /// Strain that the material bears, as a share: 0.05 is 5 %. Results beyond it carry a warning; without it, those beyond
    /// 0.3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-range" = MAX_STRAIN, "x-note" = " (a share: 0.05 is 5 %)", "x-default" = "unknown"))]
    pub max_strain: Option<f64>,
    /// Relaxation: pairs of a share gᵢ of a sudden stress and the time τᵢ (s) in which it fades (Prony series). Young's modulus is that
    /// of a sudden strain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-pair" = "[gᵢ, τᵢ in s]", "x-default" = "elastic", "maxItems" = PRONY_TERMS, "x-needed" = "an array of pairs [gᵢ, τᵢ in s]",
        "x-limits" = prony_limits()
    ))]
    pub prony: Option<Vec<(f64, f64)>>,
    /// What of a material with memory remembers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "\"nodes\""))]
    pub memory: Option<Memory>,
}

/// What of a material with memory remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Memory {
    /// Every strain, for any motion.
    #[default]
    Nodes,
    /// The contact force alone, as in a gripper's estimate: for closing and holding.
    Force,
}

/// How the stiffness changes with strain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MaterialLaw {
    /// Linear between Green's strain and the second Piola–Kirchhoff stress, as in finite elements with a linear
    /// material and large displacements.
    #[default]
    StVenantKirchhoff,
    /// An incompressible rubber.
    NeoHookean,
    /// Stiffness independent of the strain.
    Linear,
}

/// A beam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BeamTable {
    /// Start of the centreline, clamped to the base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-unit" = "mm", "x-range" = Field::FrontBase.range(), "x-picture" = "finger",
        "x-default" = "needed, unless the centreline is given"
    ))]
    pub base_mm: Option<[f64; 2]>,
    /// End of the centreline, joined to the other beam.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-unit" = "mm", "x-range" = Field::FrontTip.range(), "x-picture" = "finger",
        "x-default" = "needed, unless the centreline is given"
    ))]
    pub tip_mm: Option<[f64; 2]>,
    /// Rise of the unloaded centreline's circular arc over its chord: positive bows towards the object, 0 is straight.
    #[serde(default)]
    #[schemars(extend("x-unit" = "mm", "x-limits" = "about ± a quarter of the chord", "x-picture" = "beam"))]
    pub sagitta_mm: f64,
    /// Thickness in the plane: a number, or a taper against arc length from the base.
    #[schemars(extend(
        "x-unit" = "mm", "x-limits" = "0.01 to half the beam's length", "x-pair" = "[arc_mm, thickness_mm]",
        "maxItems" = MAX_KNOTS, "minItems" = 1, "x-picture" = "finger"
    ))]
    pub thickness_mm: Along,
    /// Multiplies bending and stretching stiffness (EI and EA).
    #[serde(default = "one")]
    #[schemars(extend("x-range" = Field::FrontStiffness.range()))]
    pub stiffness_factor: f64,
    /// Multiplies the bending stiffness EI alone.
    #[serde(default = "one")]
    #[schemars(extend("x-range" = Field::FrontBending.range()))]
    pub bending_factor: f64,
    /// Multiplies the stretching stiffness EA, and with it the shear stiffness, alone.
    #[serde(default = "one")]
    #[schemars(extend("x-range" = Field::FrontStretch.range()))]
    pub stretch_factor: f64,
    /// Arc length from the base below which the beam is held. Lamellae may end on the held part of the back beam, but not of the front
    /// beam.
    #[serde(default)]
    #[schemars(extend(
        "x-unit" = "mm", "x-limits" = "0 to nine tenths of what bends", "x-picture" = "beam"
    ))]
    pub clamp_mm: f64,
    /// The unloaded centreline from the base to the tip, in place of `base_mm` and `tip_mm`: points that rise from one to the next. It
    /// goes through all of them in circular arcs without a kink; points on a line or a circle give that line or circle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-unit" = "mm", "x-range" = Field::FrontCentreline.range(), "x-default" = "a line or an arc from base to tip",
        "minItems" = 2, "maxItems" = MAX_POINTS + 2
    ))]
    pub centreline_mm: Option<Vec<[f64; 2]>>,
}

/// The lamellae.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LamellaeTable {
    /// Heights at which the lamellae meet both beams, base to tip. With `angle_deg`: heights of the points midway
    /// between the beams' centrelines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-unit" = "mm", "x-limits" = "ascending, on the flexible beams", "maxItems" = MAX_LAMELLAE,
        "x-default" = "needed, unless the arcs are given", "x-picture" = "finger"
    ))]
    pub heights_mm: Option<Vec<f64>>,
    /// Arc lengths from the base at which the lamellae meet the front beam, in place of `heights_mm`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-unit" = "mm", "x-limits" = "ascending, on the flexible beam", "maxItems" = MAX_LAMELLAE,
        "x-default" = "from heights_mm", "x-picture" = "beam"
    ))]
    pub front_arc_mm: Option<Vec<f64>>,
    /// The same on the back beam, as many as in `front_arc_mm`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-unit" = "mm", "x-limits" = "ascending, on the flexible beam", "maxItems" = MAX_LAMELLAE,
        "x-default" = "from heights_mm", "x-picture" = "beam"
    ))]
    pub back_arc_mm: Option<Vec<f64>>,
    /// Thickness: a number, one per lamella, or for each a pair at its front and its back end. Of rigid lamellae it matters
    /// for pictures, for finite elements and for the room between them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-unit" = "mm", "x-range" = Field::LamellaThickness.range(), "maxItems" = MAX_LAMELLAE,
        "x-default" = "needed with lamellae", "x-picture" = "hinge"
    ))]
    pub thickness_mm: Option<RibThickness>,
    /// What the lamellae are.
    #[serde(default)]
    pub kind: LamellaKind,
    /// How ribs end at the beams.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-default" = "welded"))]
    pub ends: Option<RibEnds>,
    /// Angle of the lamellae's axes, positive when the front end is lower: a number, or one per lamella.
    #[serde(default = "PerRib::zero")]
    #[schemars(extend("x-unit" = "degrees", "x-range" = [-80.0, 80.0], "maxItems" = MAX_LAMELLAE))]
    pub angle_deg: PerRib,
    /// Clearance between the ribs' free ends and the back beam's face, with `ends = "gap"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "mm", "x-range" = Field::RibGap.range(), "x-default" = "needed with ends = \"gap\""))]
    pub gap_mm: Option<f64>,
    /// Radius of the fillets in the corners where welded ribs meet beams, at most twice a rib's thickness.
    #[serde(default)]
    #[schemars(extend("x-unit" = "mm", "x-range" = Field::Fillet.range()))]
    pub fillet_mm: f64,
    /// Multiplies the ribs' bending stiffness EI alone.
    #[serde(default = "one")]
    #[schemars(extend("x-range" = Field::RibBending.range()))]
    pub bending_factor: f64,
    /// Multiplies the ribs' stretching stiffness EA alone.
    #[serde(default = "one")]
    #[schemars(extend("x-range" = Field::RibStretch.range()))]
    pub stretch_factor: f64,
}

impl Default for LamellaeTable {
    /// Rigid lamellae without a place.
    fn default() -> Self {
        Self {
            heights_mm: None,
            front_arc_mm: None,
            back_arc_mm: None,
            thickness_mm: None,
            kind: LamellaKind::Rigid,
            ends: None,
            angle_deg: PerRib::zero(),
            gap_mm: None,
            fillet_mm: 0.0,
            bending_factor: 1.0,
            stretch_factor: 1.0,
        }
    }
}

/// What the lamellae are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LamellaKind {
    /// Rigid bars, joined to the beams as `[finger.hinge]` says.
    #[default]
    Rigid,
    /// Ribs that bend, joined to the beams as `ends` says.
    Rib,
}

/// How ribs end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RibEnds {
    /// Of one piece with the beams.
    Welded,
    /// With necks, as `[finger.hinge]` says.
    Hinged,
    /// Welded to the front beam, `gap_mm` away from the back beam. Where an end meets that beam, it presses against it with its middle and
    /// slides along it without friction.
    Gap,
}

/// The hinges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HingeTable {
    /// What joins a lamella to a beam.
    #[serde(default)]
    pub kind: HingeKind,
    /// Length of a neck: a number, or one per lamella. Needed with flexible hinges.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-unit" = "mm", "x-range" = Field::HingeLength.range(), "maxItems" = MAX_LAMELLAE,
        "x-default" = "needed with flexible hinges", "x-picture" = "hinge"
    ))]
    pub length_mm: Option<PerRib>,
    /// Thickness of a neck in the plane. Needed with flexible hinges.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-unit" = "mm", "x-range" = Field::HingeThickness.range(), "x-default" = "needed with flexible hinges",
        "x-picture" = "hinge"
    ))]
    pub thickness_mm: Option<f64>,
    /// What a neck's length is measured from.
    #[serde(default)]
    #[schemars(extend("x-picture" = "hinge"))]
    pub from: HingeFrom,
}

/// What joins a lamella to a beam.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum HingeKind {
    /// A thin neck that bends.
    #[default]
    Flexible,
    /// A pin on the beam's centreline.
    Pinned,
    /// Nothing: the lamella turns with the beam.
    Welded,
}

/// What a neck's length is measured from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum HingeFrom {
    /// The beam's centreline.
    #[default]
    Centreline,
    /// The beam's face: the clear length. The flexible length then reaches a little into beam and lamella.
    Face,
}

/// The tip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TipTable {
    /// Height above which both beams are one rigid wedge; `"auto"`: where their inner faces meet, whatever their thicknesses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "x-unit" = "mm", "x-limits" = "at least a tenth of the finger's height", "x-default" = "no wedge",
        "x-picture" = "finger"
    ))]
    pub rigid_above_mm: Option<TipFrom>,
}

/// The motor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotorTable {
    /// The axis about which the motor turns the finger.
    #[schemars(extend(
        "x-unit" = "mm", "x-range" = Field::MotorAxis.range(), "x-needed" = "[x, y] in mm, the motor axis",
        "x-picture" = "finger"
    ))]
    pub axis_mm: [f64; 2],
}
