//! Whether a description makes sense.

use super::error::{DesignError, Field, MAX_LENGTH, MIN_THICKNESS, within};
use super::junction::{BAR_ROOT, face_distances};
use super::weld::{LARGEST_FILLET, Weld, clear_of_back};
use super::{Attachments, Beam, Design, HingeFrom, HingeKind, LamellaKind, Profile, RibEnds, Ribs};
use crate::size::{Lists, TooLong};

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

/// What may be too short of a rib.
const ITSELF: &str = "it";

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
            let points = usize::from(room.points);
            if beam.via.len() > points {
                TooLong::check(field.key(), beam.via.len() + 2, points + 2)?;
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
                if let RibEnds::Gap(gap) = ribs.ends {
                    Field::RibGap.admit(gap)?;
                    if let Some(lamella) = (0..count).find(|&lamella| self.is_held(lamella)) {
                        return Err(DesignError::GapBeforeHeld { lamella });
                    }
                }
                self.validate_ribs(ends)?;
                self.validate_fillets(ends)
            }
        }
    }

    /// Ribs bend over some length, and so does each beam between two of them.
    #[inline(never)]
    fn validate_ribs(&self, ends: [f64; 2]) -> Result<(), DesignError> {
        let mut below = [self.front.clamp, self.back.clamp];
        for lamella in 0..self.lamella_count() {
            let room = |what, length: f64, needed: f64| {
                let is_short = what == ITSELF && self.lamellae.gap().is_some();
                let field = if is_short { Field::RibGap } else { Field::LamellaThickness };
                let error = DesignError::NoRoomForRib { field, lamella, what, length, needed };
                if length > needed { Ok(()) } else { Err(error) }
            };
            let [front, back] = face_distances(self, lamella);
            let taken = front + clear_of_back(self, lamella, back);
            room(ITSELF, self.lamella_width(lamella) - self.hinge_room(lamella).max(taken), MIN_THICKNESS)?;
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

    /// Fillets end where another one, a held part or the solid tip begins, or before.
    #[inline(never)]
    fn validate_fillets(&self, ends: [f64; 2]) -> Result<(), DesignError> {
        let Some(&Ribs { ends: joints, fillet, .. }) = self.lamellae.ribs() else { return Ok(()) };
        if joints == RibEnds::Hinged || fillet == 0.0 {
            return Ok(());
        }
        // Arcs up to which a face is free below the next rib, and what the fillet above it takes of that per radius.
        let mut below = [(self.front.clamp, 0.0), (self.back.clamp, 0.0)];
        for lamella in 0..self.lamella_count() {
            let fits = |room: f64, reach: f64, what| {
                let max = (room / reach).max(0.0);
                if fillet <= max {
                    Ok(())
                } else {
                    Err(DesignError::FilletTooLarge { lamella, value: fillet, what, max })
                }
            };
            let thickness = self.lamella_thickness(lamella);
            fits(LARGEST_FILLET * thickness[0].min(thickness[1]), 1.0, "twice the rib's thickness")?;
            let roots = Weld::roots(self, lamella);
            let clear = self.lamella_width(lamella) - roots.iter().map(|root| root.face).sum::<f64>();
            let [lower, upper] = [roots[0].fillet[0] + roots[1].fillet[0], roots[0].fillet[1] + roots[1].fillet[1]];
            // An edge is shorter on the side to which the rib leans.
            let leant = 0.5 * (thickness[0] * roots[0].lean + thickness[1] * roots[1].lean);
            fits(clear + leant, lower, "what fits along its edge")?;
            fits(clear - leant, upper, "what fits along its edge")?;
            for (((root, end), below), is_back) in roots.iter().zip(ends).zip(&mut below).zip([false, true]) {
                let (from, reach) = *below;
                let [low, high] = root.edges;
                // What lies on a beam's held part has no fillet that matters below it.
                if !(is_back && low <= self.back.clamp) {
                    fits(low - from, root.fillet[0] + reach, "what fits along the beam below it")?;
                }
                fits(end - high, root.fillet[1], "what fits below the solid tip")?;
                *below = (high, root.fillet[1]);
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
