//! Why a description is refused: the place, the value, and what is allowed.

/// Largest length of any part, mm.
pub(super) const MAX_LENGTH: f64 = 5000.0;
/// Smallest thickness of a beam or hinge, mm.
pub(super) const MIN_THICKNESS: f64 = 0.01;

/// Places in a [`crate::design::Design`], named as in a case file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// `width_mm`
    Width,
    /// `material.youngs_modulus_pa`
    YoungsModulus,
    /// `material.poissons_ratio`
    PoissonsRatio,
    /// `front.base_mm`
    FrontBase,
    /// `front.tip_mm`
    FrontTip,
    /// `front.sagitta_mm`
    FrontSagitta,
    /// `front.thickness_mm`
    FrontThickness,
    /// `front.stiffness_factor`
    FrontStiffness,
    /// `front.bending_factor`
    FrontBending,
    /// `front.stretch_factor`
    FrontStretch,
    /// `front.clamp_mm`
    FrontClamp,
    /// `front.centreline_mm`
    FrontCentreline,
    /// `back.base_mm`
    BackBase,
    /// `back.tip_mm`
    BackTip,
    /// `back.sagitta_mm`
    BackSagitta,
    /// `back.thickness_mm`
    BackThickness,
    /// `back.stiffness_factor`
    BackStiffness,
    /// `back.bending_factor`
    BackBending,
    /// `back.stretch_factor`
    BackStretch,
    /// `back.clamp_mm`
    BackClamp,
    /// `back.centreline_mm`
    BackCentreline,
    /// `lamellae.heights_mm`
    Heights,
    /// `lamellae.front_arc_mm`
    FrontArcs,
    /// `lamellae.back_arc_mm`
    BackArcs,
    /// `lamellae.thickness_mm`
    LamellaThickness,
    /// `lamellae.gap_mm`
    RibGap,
    /// `lamellae.fillet_mm`
    Fillet,
    /// `lamellae.bending_factor`
    RibBending,
    /// `lamellae.stretch_factor`
    RibStretch,
    /// `hinge.length_mm`
    HingeLength,
    /// `hinge.thickness_mm`
    HingeThickness,
    /// `tip.rigid_above_mm`
    RigidAbove,
    /// `motor.axis_mm`
    MotorAxis,
}

impl Field {
    /// The key in a case file, below `[finger]`.
    pub fn key(self) -> &'static str {
        match self {
            Self::Width => "width_mm",
            Self::YoungsModulus => "material.youngs_modulus_pa",
            Self::PoissonsRatio => "material.poissons_ratio",
            Self::FrontBase => "front.base_mm",
            Self::FrontTip => "front.tip_mm",
            Self::FrontSagitta => "front.sagitta_mm",
            Self::FrontThickness => "front.thickness_mm",
            Self::FrontStiffness => "front.stiffness_factor",
            Self::FrontBending => "front.bending_factor",
            Self::FrontStretch => "front.stretch_factor",
            Self::FrontClamp => "front.clamp_mm",
            Self::FrontCentreline => "front.centreline_mm",
            Self::BackBase => "back.base_mm",
            Self::BackTip => "back.tip_mm",
            Self::BackSagitta => "back.sagitta_mm",
            Self::BackThickness => "back.thickness_mm",
            Self::BackStiffness => "back.stiffness_factor",
            Self::BackBending => "back.bending_factor",
            Self::BackStretch => "back.stretch_factor",
            Self::BackClamp => "back.clamp_mm",
            Self::BackCentreline => "back.centreline_mm",
            Self::Heights => "lamellae.heights_mm",
            Self::FrontArcs => "lamellae.front_arc_mm",
            Self::BackArcs => "lamellae.back_arc_mm",
            Self::LamellaThickness => "lamellae.thickness_mm",
            Self::RibGap => "lamellae.gap_mm",
            Self::Fillet => "lamellae.fillet_mm",
            Self::RibBending => "lamellae.bending_factor",
            Self::RibStretch => "lamellae.stretch_factor",
            Self::HingeLength => "hinge.length_mm",
            Self::HingeThickness => "hinge.thickness_mm",
            Self::RigidAbove => "tip.rigid_above_mm",
            Self::MotorAxis => "motor.axis_mm",
        }
    }

    /// Smallest and largest number allowed, in the design's units; none where that depends on the rest of the design.
    pub const fn range(self) -> Option<[f64; 2]> {
        match self {
            Self::Width => Some([0.1, MAX_LENGTH]),
            Self::YoungsModulus => Some([1e-3, 1e6]),
            Self::PoissonsRatio => Some([0.0, 0.499]),
            Self::FrontBase
            | Self::FrontTip
            | Self::FrontCentreline
            | Self::BackBase
            | Self::BackTip
            | Self::BackCentreline
            | Self::MotorAxis => Some([-MAX_LENGTH, MAX_LENGTH]),
            Self::FrontStiffness
            | Self::FrontBending
            | Self::FrontStretch
            | Self::BackStiffness
            | Self::BackBending
            | Self::BackStretch
            | Self::RibBending
            | Self::RibStretch => Some([1e-3, 1e3]),
            Self::RibGap | Self::Fillet => Some([0.0, 50.0]),
            Self::LamellaThickness | Self::HingeThickness | Self::HingeLength => Some([MIN_THICKNESS, MAX_LENGTH]),
            Self::FrontSagitta
            | Self::FrontThickness
            | Self::FrontClamp
            | Self::BackClamp
            | Self::BackSagitta
            | Self::BackThickness
            | Self::Heights
            | Self::FrontArcs
            | Self::BackArcs
            | Self::RigidAbove => None,
        }
    }

    /// Checks that a number is finite and within the field's own range.
    pub(super) fn admit(self, value: f64) -> Result<(), DesignError> {
        match self.range() {
            Some([min, max]) => within(self, value, min, max),
            None => within(self, value, f64::MIN, f64::MAX),
        }
    }
}

/// Why a [`crate::design::Design`] is refused. Values are in mm, MPa or pure numbers, as the design's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DesignError {
    /// A number is infinite or NaN.
    NotFinite {
        /// Where.
        field: Field,
        /// The number.
        value: f64,
    },
    /// A number lies outside its range.
    OutOfRange {
        /// Where.
        field: Field,
        /// The number.
        value: f64,
        /// Smallest allowed.
        min: f64,
        /// Largest allowed.
        max: f64,
    },
    /// A profile has no knots, or its positions do not increase.
    Profile {
        /// Where.
        field: Field,
        /// Index of the first knot at fault.
        knot: usize,
    },
    /// A beam's tip is not above its base by more than its length's tenth.
    BeamNotUpright {
        /// The tip.
        field: Field,
        /// Height of the tip above the base, mm.
        rise: f64,
    },
    /// A point of a centreline is not above the one before, or the centreline turns there too much for one that is smooth.
    Centreline {
        /// Where.
        field: Field,
        /// Index of the point, from 0 at the base.
        point: usize,
        /// What is wrong with it.
        what: &'static str,
    },
    /// A rigid lamella is welded to the part of the back beam that is held: it would hold the front beam as well.
    WeldedToHeld {
        /// Index of the lamella, from 0 at the base.
        lamella: usize,
    },
    /// The back beam's base does not lie behind the front beam's (smaller x).
    BackNotBehindFront {
        /// x of the back beam's base, mm.
        back_x: f64,
        /// x of the front beam's base, mm.
        front_x: f64,
    },
    /// The two tips lie apart by more than a quarter of the front beam's length.
    TipsApart {
        /// Distance, mm.
        distance: f64,
        /// Largest allowed, mm.
        max: f64,
    },
    /// Front and back beam list different numbers of lamellae.
    LamellaCount {
        /// Entries for the front beam.
        front: usize,
        /// Entries for the back beam.
        back: usize,
    },
    /// A lamella is not on the beam's flexible part.
    LamellaOutsideBeam {
        /// Where.
        field: Field,
        /// Index of the lamella, from 0 at the base.
        lamella: usize,
        /// Its value in the file's terms (height or arc length), mm.
        value: f64,
        /// Must be larger than this, mm.
        above: f64,
        /// Must be smaller than this, mm.
        below: f64,
    },
    /// A lamella is not above its predecessor.
    LamellaOrder {
        /// Where.
        field: Field,
        /// Index of the lamella, from 0 at the base.
        lamella: usize,
        /// Its value, mm.
        value: f64,
        /// Its predecessor's value, mm.
        previous: f64,
    },
    /// `hinge.length_mm` has neither one entry nor one per lamella.
    HingeCount {
        /// Entries found.
        found: usize,
        /// Number of lamellae.
        lamellae: usize,
    },
    /// `lamellae.thickness_mm` has neither one entry nor one per lamella.
    ThicknessCount {
        /// Entries found.
        found: usize,
        /// Number of lamellae.
        lamellae: usize,
    },
    /// A rib has no clear length between the beams, or beside it a beam none that bends.
    NoRoomForRib {
        /// What takes the room: its thickness, or its gap.
        field: Field,
        /// Index of the lamella, from 0 at the base.
        lamella: usize,
        /// What is too short.
        what: &'static str,
        /// Its length, mm.
        length: f64,
        /// More than this is needed, mm.
        needed: f64,
    },
    /// A rib ends with a gap before the part of the back beam that is held.
    GapBeforeHeld {
        /// Index of the rib, from 0 at the base.
        lamella: usize,
    },
    /// A rib's fillets are larger than the tables of welds, or overlap with each other, a neighbour's, the held part or the solid tip.
    FilletTooLarge {
        /// Index of the rib, from 0 at the base.
        lamella: usize,
        /// The radius, mm.
        value: f64,
        /// What the largest radius is.
        what: &'static str,
        /// Largest allowed, mm.
        max: f64,
    },
    /// A lamella leaves no room for its hinges.
    NoRoomForHinges {
        /// Index of the lamella, from 0 at the base.
        lamella: usize,
        /// Distance of the two attachments, mm.
        width: f64,
        /// Length the two hinges (and what they start from) need, mm.
        needed: f64,
    },
}

impl core::fmt::Display for DesignError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match *self {
            Self::NotFinite { field, value } => write!(f, "{} is {value}; a finite number is needed", field.key()),
            Self::OutOfRange { field, value, min, max } => {
                write!(f, "{} is {value}; allowed is {min} to {max}", field.key())
            }
            Self::Profile { field, knot } => {
                write!(f, "{}: knot {} is missing or not beyond its predecessor", field.key(), knot + 1)
            }
            Self::BeamNotUpright { field, rise } => {
                write!(
                    f,
                    "{}: the tip is {rise} mm above the base; more than a tenth of the beam is needed",
                    field.key()
                )
            }
            Self::Centreline { field, point, what } => write!(f, "{}: point {} {what}", field.key(), point + 1),
            Self::WeldedToHeld { lamella } => write!(
                f,
                "hinge.kind: lamella {} is rigid, welded, and ends on the held part of the back beam; allowed is \"flexible\" or \"pinned\"",
                lamella + 1
            ),
            Self::BackNotBehindFront { back_x, front_x } => {
                write!(f, "back.base_mm: x is {back_x}; it must be less than the front beam's {front_x}")
            }
            Self::TipsApart { distance, max } => {
                write!(f, "back.tip_mm lies {distance} mm from front.tip_mm; at most {max} mm is allowed")
            }
            Self::LamellaCount { front, back } => {
                write!(
                    f,
                    "lamellae.front_arc_mm has {front} entries, lamellae.back_arc_mm has {back}; they must be equal"
                )
            }
            Self::LamellaOutsideBeam { field, lamella, value, above, below } => {
                write!(
                    f,
                    "{}: lamella {} at {value} is outside the flexible beam; allowed is more than {above} and less than {below}",
                    field.key(),
                    lamella + 1
                )
            }
            Self::LamellaOrder { field, lamella, value, previous } => {
                let (key, number) = (field.key(), lamella + 1);
                write!(f, "{key}: lamella {number} at {value} is not beyond its predecessor at {previous}")
            }
            Self::HingeCount { found, lamellae } => {
                write!(f, "hinge.length_mm has {found} entries; allowed is one for all or one per lamella ({lamellae})")
            }
            Self::ThicknessCount { found, lamellae } => {
                write!(
                    f,
                    "lamellae.thickness_mm has {found} entries; allowed is one for all or one per lamella ({lamellae})"
                )
            }
            Self::NoRoomForRib { field, lamella, what, length, needed } => {
                let (key, number) = (field.key(), lamella + 1);
                write!(f, "{key}: at rib {number} {what} is {length} mm long; more than {needed} mm is needed")
            }
            Self::GapBeforeHeld { lamella } => write!(
                f,
                "lamellae.ends is \"gap\": rib {} ends at the held part of the back beam; allowed are \"welded\" and \"hinged\" there, or ribs above back.clamp_mm",
                lamella + 1
            ),
            Self::FilletTooLarge { lamella, value, what, max } => {
                let number = lamella + 1;
                write!(f, "lamellae.fillet_mm is {value}; at rib {number} at most {max} mm is allowed, {what}")
            }
            Self::NoRoomForHinges { lamella, width, needed } => {
                write!(
                    f,
                    "hinge.length_mm: lamella {} is {width} mm wide, its hinges need more than {needed} mm",
                    lamella + 1
                )
            }
        }
    }
}

impl core::error::Error for DesignError {}

pub(super) fn within(field: Field, value: f64, min: f64, max: f64) -> Result<(), DesignError> {
    if !value.is_finite() {
        return Err(DesignError::NotFinite { field, value });
    }
    if value < min || value > max {
        return Err(DesignError::OutOfRange { field, value, min, max });
    }
    Ok(())
}
