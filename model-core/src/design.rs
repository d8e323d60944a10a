//! What a person describes: beams, lamellae, hinges, material, motor axis; and why a description is refused.
//!
//! Units: mm, N, rad, MPa (N/mm²). Positions are in the finger frame: origin at the front beam's base, y along the
//! undeformed front beam towards the tip, x towards the object; the back beam's base lies at negative x.

use heapless::Vec;

/// Largest number of lamellae of a finger.
pub const MAX_LAMELLAE: usize = 12;
/// Largest number of knots of a [`Profile`].
pub const MAX_KNOTS: usize = 8;

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
    /// Between the two, from width and thickness.
    #[default]
    Auto,
}

/// One of the two flexible beams: a straight rod from its base to the tip.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Beam {
    /// Centreline's start, clamped to the base lamella, mm.
    pub base: [f64; 2],
    /// Centreline's end, joined to the other beam, mm.
    pub tip: [f64; 2],
    /// Thickness in the plane against arc length from the base, mm.
    pub thickness: Profile,
    /// Multiplies EI and EA of this beam.
    pub stiffness_factor: f64,
}

impl Beam {
    /// Length of the centreline, mm.
    pub fn length(&self) -> f64 {
        libm::hypot(self.tip[0] - self.base[0], self.tip[1] - self.base[1])
    }

    /// Unit vector from base to tip.
    pub fn direction(&self) -> [f64; 2] {
        let length = self.length();
        [(self.tip[0] - self.base[0]) / length, (self.tip[1] - self.base[1]) / length]
    }

    /// Point of the undeformed centreline at an arc length from the base, mm.
    pub fn point(&self, arc: f64) -> [f64; 2] {
        let e = self.direction();
        [self.base[0] + arc * e[0], self.base[1] + arc * e[1]]
    }

    /// Arc length at which the undeformed centreline reaches a height (finger-frame y), mm.
    pub fn arc_at_height(&self, height: f64) -> f64 {
        (height - self.base[1]) / self.direction()[1]
    }
}

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

/// The rigid lamellae.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Lamellae {
    /// Where they are joined to the beams.
    pub attachments: Attachments,
    /// Thickness, mm (for pictures and finite elements; a lamella is rigid).
    pub thickness: f64,
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
    /// The beam's centreline (the paper's).
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
    /// `front.thickness_mm`
    FrontThickness,
    /// `front.stiffness_factor`
    FrontStiffness,
    /// `back.base_mm`
    BackBase,
    /// `back.tip_mm`
    BackTip,
    /// `back.thickness_mm`
    BackThickness,
    /// `back.stiffness_factor`
    BackStiffness,
    /// `lamellae.heights_mm`
    Heights,
    /// `lamellae.front_arc_mm`
    FrontArcs,
    /// `lamellae.back_arc_mm`
    BackArcs,
    /// `lamellae.thickness_mm`
    LamellaThickness,
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
            Self::FrontThickness => "front.thickness_mm",
            Self::FrontStiffness => "front.stiffness_factor",
            Self::BackBase => "back.base_mm",
            Self::BackTip => "back.tip_mm",
            Self::BackThickness => "back.thickness_mm",
            Self::BackStiffness => "back.stiffness_factor",
            Self::Heights => "lamellae.heights_mm",
            Self::FrontArcs => "lamellae.front_arc_mm",
            Self::BackArcs => "lamellae.back_arc_mm",
            Self::LamellaThickness => "lamellae.thickness_mm",
            Self::HingeLength => "hinge.length_mm",
            Self::HingeThickness => "hinge.thickness_mm",
            Self::RigidAbove => "tip.rigid_above_mm",
            Self::MotorAxis => "motor.axis_mm",
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
                write!(f, "{}: knot {knot} is missing or not beyond its predecessor", field.key())
            }
            Self::BeamNotUpright { field, rise } => {
                write!(
                    f,
                    "{}: the tip is {rise} mm above the base; more than a tenth of the beam is needed",
                    field.key()
                )
            }
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
                    "{}: lamella {lamella} at {value} is outside the flexible beam; allowed is more than {above} and less than {below}",
                    field.key()
                )
            }
            Self::LamellaOrder { field, lamella, value, previous } => {
                write!(f, "{}: lamella {lamella} at {value} is not beyond its predecessor at {previous}", field.key())
            }
            Self::HingeCount { found, lamellae } => {
                write!(f, "hinge.length_mm has {found} entries; allowed is one for all or one per lamella ({lamellae})")
            }
            Self::NoRoomForHinges { lamella, width, needed } => {
                write!(
                    f,
                    "hinge.length_mm: lamella {lamella} is {width} mm wide, its hinges need more than {needed} mm"
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

fn profile(field: Field, profile: &Profile, min: f64, max: f64) -> Result<(), DesignError> {
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
        within(field, value, min, max)?;
    }
    Ok(())
}

/// Largest length of any part, mm: beyond it the solver's tolerances lose their meaning in single precision.
const MAX_LENGTH: f64 = 1000.0;
/// Smallest thickness of a beam or hinge, mm.
const MIN_THICKNESS: f64 = 0.01;

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

    /// Distance of lamella k's two attachments on the undeformed centrelines, mm.
    pub fn lamella_width(&self, lamella: usize) -> f64 {
        let [front, back] = self.attachment_arcs(lamella);
        let (p, q) = (self.front.point(front), self.back.point(back));
        libm::hypot(q[0] - p[0], q[1] - p[1])
    }

    /// Arc lengths (front, back), mm, at which the flexible part of the beams ends.
    pub fn flexible_ends(&self) -> [f64; 2] {
        let end = |beam: &Beam| match self.rigid_above {
            Some(height) => beam.arc_at_height(height).min(beam.length()),
            None => beam.length(),
        };
        [end(&self.front), end(&self.back)]
    }

    /// Checks everything that the solver takes for granted.
    ///
    /// # Errors
    /// The first [`DesignError`] met, in the order of the struct's fields.
    pub fn validate(&self) -> Result<(), DesignError> {
        profile(Field::Width, &self.width, 0.1, MAX_LENGTH)?;
        within(Field::YoungsModulus, self.material.youngs_modulus, 1e-3, 1e6)?;
        within(Field::PoissonsRatio, self.material.poissons_ratio, 0.0, 0.499)?;
        self.validate_beam(
            &self.front,
            [Field::FrontBase, Field::FrontTip, Field::FrontThickness, Field::FrontStiffness],
        )?;
        self.validate_beam(&self.back, [Field::BackBase, Field::BackTip, Field::BackThickness, Field::BackStiffness])?;
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
        self.validate_lamellae()?;
        for axis in self.motor_axis {
            within(Field::MotorAxis, axis, -MAX_LENGTH, MAX_LENGTH)?;
        }
        Ok(())
    }

    fn validate_beam(&self, beam: &Beam, [base, tip, thickness, factor]: [Field; 4]) -> Result<(), DesignError> {
        for (field, point) in [(base, beam.base), (tip, beam.tip)] {
            for coordinate in point {
                within(field, coordinate, -MAX_LENGTH, MAX_LENGTH)?;
            }
        }
        let rise = beam.tip[1] - beam.base[1];
        if rise < 1.0 || rise <= 0.1 * beam.length() {
            return Err(DesignError::BeamNotUpright { field: tip, rise });
        }
        profile(thickness, &beam.thickness, MIN_THICKNESS, 0.5 * beam.length())?;
        within(factor, beam.stiffness_factor, 1e-3, 1e3)
    }

    fn validate_lamellae(&self) -> Result<(), DesignError> {
        let ends = self.flexible_ends();
        match &self.lamellae.attachments {
            Attachments::Heights(heights) => {
                let top = [self.front.point(ends[0])[1], self.back.point(ends[1])[1]];
                let bottom = self.front.base[1].max(self.back.base[1]);
                ascending(Field::Heights, heights, bottom, top[0].min(top[1]))?;
            }
            Attachments::Arcs { front, back } => {
                if front.len() != back.len() {
                    return Err(DesignError::LamellaCount { front: front.len(), back: back.len() });
                }
                ascending(Field::FrontArcs, front, 0.0, ends[0])?;
                ascending(Field::BackArcs, back, 0.0, ends[1])?;
            }
        }
        within(Field::LamellaThickness, self.lamellae.thickness, MIN_THICKNESS, MAX_LENGTH)?;
        let count = self.lamella_count();
        if count == 0 {
            return Ok(());
        }
        if self.hinge.kind == HingeKind::Flexible {
            within(Field::HingeThickness, self.hinge.thickness, MIN_THICKNESS, MAX_LENGTH)?;
            if self.hinge.length.len() != 1 && self.hinge.length.len() != count {
                return Err(DesignError::HingeCount { found: self.hinge.length.len(), lamellae: count });
            }
            for &length in &self.hinge.length {
                within(Field::HingeLength, length, 0.01, MAX_LENGTH)?;
            }
        }
        for lamella in 0..count {
            let width = self.lamella_width(lamella);
            let needed = self.hinge_room(lamella);
            if width <= needed || width <= MIN_THICKNESS {
                return Err(DesignError::NoRoomForHinges { lamella, width, needed });
            }
        }
        Ok(())
    }

    /// Part of lamella k's width that its hinges and what they start from take up, mm.
    fn hinge_room(&self, lamella: usize) -> f64 {
        if self.hinge.kind != HingeKind::Flexible {
            return 0.0;
        }
        let hinges = 2.0 * self.hinge.length_of(lamella);
        match self.hinge.from {
            HingeFrom::Centreline => hinges,
            HingeFrom::Face => {
                let [front, back] = crate::discretise::face_distances(self, lamella);
                hinges + front + back + 2.0 * crate::discretise::BAR_ROOT * self.hinge.thickness
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

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The finger of the reference data `ladder-80.csv`.
    pub(crate) fn ladder_80() -> Design {
        let beam = |base| Beam { base, tip: [0.0, 80.0], thickness: Profile::constant(2.0), stiffness_factor: 1.0 };
        let mut design = Design {
            width: Profile::constant(20.0),
            plane_strain: PlaneStrain::Stress,
            material: Material { youngs_modulus: 49.5, poissons_ratio: 0.48 },
            front: beam([0.0, 0.0]),
            back: beam([-28.0, 0.0]),
            lamellae: Lamellae { attachments: Attachments::Heights(Vec::new()), thickness: 3.0 },
            hinge: Hinge {
                kind: HingeKind::Flexible,
                length: Vec::from_iter([2.5]),
                thickness: 0.8,
                from: HingeFrom::Centreline,
            },
            rigid_above: None,
            motor_axis: [-14.0, -20.0],
        };
        set_heights(&mut design, 7);
        design
    }

    /// So many lamellae, evenly spaced (9 mm apart for seven, otherwise up to a height of 55 mm).
    pub(crate) fn set_heights(design: &mut Design, count: usize) {
        let pitch = if count == 7 { 9.0 } else { 55.0 / count.max(1) as f64 };
        design.lamellae.attachments = Attachments::Heights((1..=count).map(|k| pitch * k as f64).collect());
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
            ("lamellae.thickness_mm", &|d| d.lamellae.thickness = 0.0),
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
