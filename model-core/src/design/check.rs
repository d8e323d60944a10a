//! Why a description is refused.

use super::junction::{BAR_ROOT, face_distances};
use super::weld::Weld;
use super::{Attachments, Beam, Design, HingeFrom, HingeKind, LamellaKind, Profile};
use crate::size::{Lists, TooLong};

/// Places in a [`Design`], named as in a case file.
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
            Self::Fillet => Some([0.0, 50.0]),
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
    fn admit(self, value: f64) -> Result<(), DesignError> {
        match self.range() {
            Some([min, max]) => within(self, value, min, max),
            None => within(self, value, f64::MIN, f64::MAX),
        }
    }
}

/// Why a [`Design`] is refused. Values are in mm, MPa or pure numbers, as the design's.
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
        /// Index of the lamella, from 0 at the base.
        lamella: usize,
        /// What is too short.
        what: &'static str,
        /// Its length, mm.
        length: f64,
        /// More than this is needed, mm.
        needed: f64,
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
            Self::NoRoomForRib { lamella, what, length, needed } => {
                let number = lamella + 1;
                write!(
                    f,
                    "lamellae.thickness_mm: at rib {number} {what} is {length} mm long; more than {needed} mm is needed"
                )
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

fn within(field: Field, value: f64, min: f64, max: f64) -> Result<(), DesignError> {
    if !value.is_finite() {
        return Err(DesignError::NotFinite { field, value });
    }
    if value < min || value > max {
        return Err(DesignError::OutOfRange { field, value, min, max });
    }
    Ok(())
}

fn profile(field: Field, profile: &Profile, admit: impl Fn(f64) -> Result<(), DesignError>) -> Result<(), DesignError> {
    if profile.knots.is_empty() {
        return Err(DesignError::Profile { field, knot: 0 });
    }
    let mut previous = f64::NEG_INFINITY;
    for (knot, &[position, value]) in profile.knots.iter().enumerate() {
        if !position.is_finite() {
            return Err(DesignError::NotFinite { field, value: position });
        }
        if position <= previous {
            return Err(DesignError::Profile { field, knot });
        }
        previous = position;
        admit(value)?;
    }
    Ok(())
}

/// A beam's places in the design.
struct BeamFields {
    base: Field,
    tip: Field,
    sagitta: Field,
    centreline: Field,
    thickness: Field,
    factors: [Field; 3],
    clamp: Field,
}

const FRONT: BeamFields = BeamFields {
    base: Field::FrontBase,
    tip: Field::FrontTip,
    sagitta: Field::FrontSagitta,
    centreline: Field::FrontCentreline,
    thickness: Field::FrontThickness,
    factors: [Field::FrontStiffness, Field::FrontBending, Field::FrontStretch],
    clamp: Field::FrontClamp,
};

const BACK: BeamFields = BeamFields {
    base: Field::BackBase,
    tip: Field::BackTip,
    sagitta: Field::BackSagitta,
    centreline: Field::BackCentreline,
    thickness: Field::BackThickness,
    factors: [Field::BackStiffness, Field::BackBending, Field::BackStretch],
    clamp: Field::BackClamp,
};

/// Cosine of the largest angle by which a centreline may turn from one way between two of its points to the next: 60 degrees.
const MOST_TURN: f64 = 0.5;

#[inline(never)]
fn validate_beam(beam: &Beam, fields: &BeamFields) -> Result<(), DesignError> {
    let is_chain = !beam.via.is_empty();
    let of_end = |field| if is_chain { fields.centreline } else { field };
    for (field, point) in [(of_end(fields.base), beam.base), (of_end(fields.tip), beam.tip)] {
        for coordinate in point {
            field.admit(coordinate)?;
        }
    }
    let rise = beam.tip[1] - beam.base[1];
    if rise < 1.0 || rise <= 0.1 * beam.chord() {
        return Err(DesignError::BeamNotUpright { field: of_end(fields.tip), rise });
    }
    if is_chain {
        validate_chain(beam, fields.centreline)?;
    }
    // So far that the ends still rise, and no further than a quarter of the chord (a sixth of a circle's turn each).
    let lean = libm::asin(rise / beam.chord());
    let most = 0.5 * beam.chord() * libm::tan(0.5 * (lean - 0.1).min(core::f64::consts::FRAC_PI_3));
    within(fields.sagitta, beam.sagitta, -most, most)?;
    let most = 0.5 * beam.length();
    profile(fields.thickness, &beam.thickness, |value| within(fields.thickness, value, MIN_THICKNESS, most))?;
    for (field, factor) in
        fields.factors.into_iter().zip([beam.stiffness_factor, beam.bending_factor, beam.stretch_factor])
    {
        field.admit(factor)?;
    }
    Ok(())
}

/// A chain of arcs rises from point to point, and turns little enough at each to be one line.
#[inline(never)]
fn validate_chain(beam: &Beam, field: Field) -> Result<(), DesignError> {
    let mut before: Option<[f64; 2]> = None;
    let mut from = beam.base;
    for (point, &at) in beam.via.iter().chain([&beam.tip]).enumerate() {
        for coordinate in at {
            field.admit(coordinate)?;
        }
        let way = [at[0] - from[0], at[1] - from[1]];
        if way[1] < MIN_THICKNESS {
            return Err(DesignError::Centreline { field, point: point + 1, what: "is not above the one before" });
        }
        if let Some(before) = before {
            let sizes = libm::hypot(before[0], before[1]) * libm::hypot(way[0], way[1]);
            if before[0] * way[0] + before[1] * way[1] < MOST_TURN * sizes {
                let what = "is a corner of more than 60 degrees; more points there would round it";
                return Err(DesignError::Centreline { field, point, what });
            }
        }
        (before, from) = (Some(way), at);
    }
    Ok(())
}

/// Largest length of any part, mm.
const MAX_LENGTH: f64 = 5000.0;
/// Smallest thickness of a beam or hinge, mm.
const MIN_THICKNESS: f64 = 0.01;

impl Design {
    /// Checks everything that the solver takes for granted.
    ///
    /// # Errors
    /// The first [`DesignError`] met, in the order of the struct's fields.
    pub fn validate(&self) -> Result<(), DesignError> {
        profile(Field::Width, &self.width, |width| Field::Width.admit(width))?;
        Field::YoungsModulus.admit(self.material.youngs_modulus)?;
        Field::PoissonsRatio.admit(self.material.poissons_ratio)?;
        validate_beam(&self.front, &FRONT)?;
        validate_beam(&self.back, &BACK)?;
        if self.back.base[0] >= self.front.base[0] {
            return Err(DesignError::BackNotBehindFront { back_x: self.back.base[0], front_x: self.front.base[0] });
        }
        let distance = libm::hypot(self.front.tip[0] - self.back.tip[0], self.front.tip[1] - self.back.tip[1]);
        let max = 0.25 * self.front.length();
        if distance > max {
            return Err(DesignError::TipsApart { distance, max });
        }
        if let Some(height) = self.rigid_above {
            let min = self.front.base[1].max(self.back.base[1]);
            within(Field::RigidAbove, height, min + 0.1 * (self.front.tip[1] - min), MAX_LENGTH)?;
        }
        for ((beam, fields), end) in [(&self.front, &FRONT), (&self.back, &BACK)].into_iter().zip(self.flexible_ends())
        {
            within(fields.clamp, beam.clamp, 0.0, 0.9 * end)?;
        }
        self.validate_lamellae()?;
        for axis in self.motor_axis {
            Field::MotorAxis.admit(axis)?;
        }
        Ok(())
    }

    /// Checks that another machine has room for the design's lists.
    ///
    /// # Errors
    /// The first list that is too long.
    pub fn fits(&self, room: Lists) -> Result<(), TooLong> {
        for (field, profile) in [
            (Field::Width, &self.width),
            (Field::FrontThickness, &self.front.thickness),
            (Field::BackThickness, &self.back.thickness),
        ] {
            TooLong::check(field.key(), profile.knots.len(), room.knots)?;
        }
        for (field, beam) in [(Field::FrontCentreline, &self.front), (Field::BackCentreline, &self.back)] {
            // The list has the ends as well.
            if beam.via.len() > room.points {
                TooLong::check(field.key(), beam.via.len() + 2, room.points + 2)?;
            }
        }
        let lamellae = match self.lamellae.attachments {
            Attachments::Heights(_) => Field::Heights,
            Attachments::Arcs { .. } => Field::FrontArcs,
        };
        TooLong::check(lamellae.key(), self.lamella_count(), room.lamellae)?;
        TooLong::check(Field::LamellaThickness.key(), self.lamellae.thickness.len(), room.thicknesses)?;
        TooLong::check(Field::HingeLength.key(), self.hinge.length.len(), room.lamellae)
    }

    fn validate_lamellae(&self) -> Result<(), DesignError> {
        let ends = self.flexible_ends();
        match &self.lamellae.attachments {
            Attachments::Heights(heights) => {
                let top = [self.front.point(ends[0])[1], self.back.point(ends[1])[1]];
                let bottom = self.front.point(self.front.clamp)[1].max(self.back.base[1]);
                ascending(Field::Heights, heights, bottom, top[0].min(top[1]))?;
            }
            Attachments::Arcs { front, back } => {
                if front.len() != back.len() {
                    return Err(DesignError::LamellaCount { front: front.len(), back: back.len() });
                }
                ascending(Field::FrontArcs, front, self.front.clamp, ends[0])?;
                ascending(Field::BackArcs, back, 0.0, ends[1])?;
            }
        }
        for &thickness in self.lamellae.thickness.iter().flatten() {
            Field::LamellaThickness.admit(thickness)?;
        }
        let count = self.lamella_count();
        if count == 0 {
            return Ok(());
        }
        let found = self.lamellae.thickness.len();
        if found != 1 && found != count {
            return Err(DesignError::ThicknessCount { found, lamellae: count });
        }
        if self.joint() == HingeKind::Flexible {
            Field::HingeThickness.admit(self.hinge.thickness)?;
            if self.hinge.length.len() != 1 && self.hinge.length.len() != count {
                return Err(DesignError::HingeCount { found: self.hinge.length.len(), lamellae: count });
            }
            for &length in &self.hinge.length {
                Field::HingeLength.admit(length)?;
            }
        }
        for lamella in 0..count {
            let is_weld = self.joint() == HingeKind::Welded && self.lamellae.ribs().is_none();
            if is_weld && self.is_held(lamella) {
                return Err(DesignError::WeldedToHeld { lamella });
            }
            let width = self.lamella_width(lamella);
            let needed = self.hinge_room(lamella);
            if width <= needed || width <= MIN_THICKNESS {
                return Err(DesignError::NoRoomForHinges { lamella, width, needed });
            }
        }
        match &self.lamellae.kind {
            LamellaKind::Rigid => Ok(()),
            LamellaKind::Rib(ribs) => {
                Field::Fillet.admit(ribs.fillet)?;
                Field::RibBending.admit(ribs.bending_factor)?;
                Field::RibStretch.admit(ribs.stretch_factor)?;
                self.validate_ribs(ends)
            }
        }
    }

    /// Ribs bend over some length, and so does each beam between two of them.
    #[inline(never)]
    fn validate_ribs(&self, ends: [f64; 2]) -> Result<(), DesignError> {
        let mut below = [self.front.clamp, self.back.clamp];
        for lamella in 0..self.lamella_count() {
            let room = |what, length: f64, needed: f64| {
                if length > needed { Ok(()) } else { Err(DesignError::NoRoomForRib { lamella, what, length, needed }) }
            };
            let faces = face_distances(self, lamella);
            room("it", self.lamella_width(lamella) - self.hinge_room(lamella).max(faces[0] + faces[1]), MIN_THICKNESS)?;
            let weld = Weld::of(self, lamella);
            let arcs = self.attachment_arcs(lamella);
            let words = [
                ["the front beam's part below it", "the front beam's part above it"],
                ["the back beam's part below it", "the back beam's part above it"],
            ];
            for side in 0..2 {
                let [down, up] = weld.reach[side];
                if !(side == 1 && weld.held) {
                    room(words[side][0], arcs[side] - down - below[side], MIN_THICKNESS)?;
                }
                below[side] = below[side].max(arcs[side] + up);
                room(words[side][1], ends[side] - below[side], MIN_THICKNESS)?;
            }
        }
        Ok(())
    }

    /// Part of lamella k's width that its hinges and what they start from take up, mm.
    fn hinge_room(&self, lamella: usize) -> f64 {
        if self.joint() != HingeKind::Flexible {
            return 0.0;
        }
        let hinges = 2.0 * self.hinge.length_of(lamella);
        match self.hinge.from {
            HingeFrom::Centreline => hinges,
            HingeFrom::Face => {
                let [front, back] = face_distances(self, lamella);
                hinges + front + back + 2.0 * BAR_ROOT * self.hinge.thickness
            }
        }
    }
}

fn ascending(field: Field, values: &[f64], above: f64, below: f64) -> Result<(), DesignError> {
    let mut previous = above;
    for (lamella, &value) in values.iter().enumerate() {
        if !value.is_finite() {
            return Err(DesignError::NotFinite { field, value });
        }
        if value <= above || value >= below {
            return Err(DesignError::LamellaOutsideBeam { field, lamella, value, above, below });
        }
        if value <= previous {
            return Err(DesignError::LamellaOrder { field, lamella, value, previous });
        }
        previous = value;
    }
    Ok(())
}
