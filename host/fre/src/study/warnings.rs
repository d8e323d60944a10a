//! What a designer must not overlook: what the model leaves out, what a case may not mean as it is written, and parts strained
//! beyond what the material bears.

use std::fmt;

use model_core::design::{HingeKind, Profile};
use model_core::equilibrium::Buckling;
use model_core::status::Status;

use crate::case::Case;
use crate::study::idle::{self, Idle};
use crate::study::model::Options;
use crate::study::number::short;
use crate::study::overlap::{self, Overlap};
use crate::study::place::{At, Place};
use crate::study::remedy::Remedy;
use crate::study::self_contact::SelfContact;
use crate::study::strains::Beyond;

/// How far beyond an end a taper may reach, as a part of its length: roundings of a drawing's measures.
const BEYOND: f64 = 0.01;

/// A warning; its words are a sentence for people.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Warning {
    /// With friction the force depends on the path.
    Friction,
    /// With memory the force depends on the path and its time.
    Memory,
    /// The material has memory, and no time passes.
    Sudden,
    /// Welded lamellae are rigid in the model.
    RigidLamellae,
    /// Keys have no effect.
    Idle(Idle),
    /// A taper ends where the finger does not.
    Taper(Taper),
    /// There is no number from this place on.
    Lost {
        /// The first place without one.
        at: At,
        /// What happened.
        why: Loss,
    },
    /// The solver has failed, and other options are known to help.
    Unsolved {
        /// The first place with this status.
        at: At,
        /// How it failed.
        status: Status,
        /// What helps.
        remedy: Remedy,
    },
    /// The object reaches into a part without contact, the most at this place.
    Reached(Overlap),
    /// Two parts of the finger pass through each other, the deepest at this place.
    Touching {
        /// The parts, and how far.
        contact: SelfContact,
        /// Where on the motion it is deepest.
        at: At,
        /// The first place where any parts touch.
        from: At,
    },
    /// A rib is about to bow, or has bowed, and its force nears its buckling load the most at this place.
    Buckling {
        /// The rib and its share of that load.
        buckling: Buckling,
        /// Where on the motion.
        at: At,
        /// The first place where one does.
        from: At,
    },
    /// A part is strained beyond the limit (the material's, or 30 % if that is not known), the most at this place.
    Strained {
        /// Part, strain and limit.
        beyond: Beyond,
        /// Where on the motion.
        at: At,
    },
}

/// A taper's knot that lies beyond the finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taper {
    /// The taper's key below `finger`.
    pub key: &'static str,
    /// The knot: position and value, mm.
    pub knot: [f64; 2],
    /// The end of the finger that it lies beyond.
    pub end: End,
    /// Position of that end, and the taper's value there, mm.
    pub there: [f64; 2],
}

/// An end of the finger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The clamped one.
    Base,
    /// The other one.
    Tip,
}

/// Why a place is out of range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// The object is in the way of the finger's clamped base.
    BaseCovered,
    /// The finger has passed the object.
    Passed,
}

impl Warning {
    /// The place that it speaks of; `None` if it is about the finger itself.
    pub fn at(&self) -> Option<At> {
        match self {
            Self::Friction | Self::Memory | Self::Sudden | Self::RigidLamellae | Self::Idle(_) | Self::Taper(_) => None,
            Self::Lost { at, .. }
            | Self::Unsolved { at, .. }
            | Self::Touching { at, .. }
            | Self::Buckling { at, .. }
            | Self::Strained { at, .. } => Some(*at),
            Self::Reached(overlap) => Some(overlap.at),
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Friction => f.write_str(
                "object.friction: the force depends on the path, which is from an open hand through the places in their order; \
                 derivatives are left out",
            ),
            Self::Memory => f.write_str(
                "finger.material.prony: the force depends on the path and its time, from an open hand through the places in their \
                 order; derivatives and energies are left out",
            ),
            Self::Sudden => f.write_str(
                "finger.material.prony: no time passes, so that forces are those of a sudden motion; motion.times_s or \
                 motion.speed_deg_per_s says how time passes",
            ),
            Self::RigidLamellae => f.write_str(
                "finger.hinge.kind = \"welded\": the model's lamellae are rigid, real ones bend with the beams; the force is too \
                 large (by 22 % for fea-80 with lamellae of 3 mm; `fre compare --fea` measures it for this case)",
            ),
            Self::Idle(idle) => idle.fmt(f),
            Self::Taper(Taper { key, knot: [position, value], end, there: [end_at, there] }) => write!(
                f,
                "finger.{key}: {} mm at {} mm lies beyond the {}, which is at {} mm: there it is {} mm",
                short(*value),
                short(*position),
                match end {
                    End::Base => "base",
                    End::Tip => "tip",
                },
                short(*end_at),
                short(*there)
            ),
            Self::Lost { at, why } => {
                let why = match why {
                    Loss::BaseCovered => "the object is in the way of the finger's clamped base",
                    Loss::Passed => {
                        "the finger has slipped off the object and past it, has it behind its front beam, or came against it \
                         with its clamped base on the way"
                    }
                };
                write!(f, "at {at}: out-of-range: {why}; later places have results again once the hand has been open")
            }
            Self::Unsolved { at, status, remedy } => write!(f, "at {at}: {status}: {remedy}"),
            Self::Reached(Overlap { part, depth, at }) => write!(
                f,
                "the object reaches {depth:.1} mm into {} (at {at}), which the model lets it pass through: check where the case \
                 has it",
                part.words()
            ),
            Self::Touching { contact: SelfContact { between: [one, other], depth, position: [x, y] }, at, from } => write!(
                f,
                "{one} and {other} touch each other (from {from} on; at {at} they overlap by {depth:.2} mm at x = {x:.1} mm, \
                 y = {y:.1} mm), which the model does not know: its force is too small from there on"
            ),
            Self::Buckling { buckling: Buckling { rib, share }, at, from } => write!(
                f,
                "rib {} carries up to {share:.2} of its buckling load (at {at}; 0.8 or more from {from} on): \
                 it bows, and the force depends by several percent on what changes the finger a little",
                rib + 1
            ),
            Self::Strained { beyond, at } => write!(f, "{beyond} (at {at})"),
        }
    }
}

/// Warnings about a case and its results, those about the finger first; without places those about the case alone.
pub fn warnings(case: &Case, options: &Options, places: &[Place]) -> Vec<Warning> {
    (case.friction > 0.0)
        .then_some(Warning::Friction)
        .into_iter()
        .chain(remembered(case, places))
        .chain(left_out(case))
        .chain(idle::idle(case).map(Warning::Idle))
        .chain(tapers(case))
        .chain(lost(case, places))
        .chain(unsolved(case, options, places))
        .chain(overlap::worst(case, places).into_iter().map(Warning::Reached))
        .chain(touching(places))
        .chain(buckling(places))
        .chain(strained(places))
        .collect()
}

/// What a material with memory makes of the results.
fn remembered(case: &Case, places: &[Place]) -> impl Iterator<Item = Warning> {
    let remembers = !case.finger.prony.is_empty();
    let is_sudden = !case.path.has_time() && places.iter().all(|place| place.time_s.is_none());
    [(remembers, Warning::Memory), (remembers && is_sudden, Warning::Sudden)]
        .into_iter()
        .filter_map(|(applies, warning)| applies.then_some(warning))
}

/// What the model leaves out of a finger, so much that its forces are wrong by more than a few percent.
fn left_out(case: &Case) -> Option<Warning> {
    // Measured on the preset fea-80 with welded lamellae, by `fre compare --fea`.
    let design = &case.finger.design;
    let rigid = design.lamellae.ribs().is_none() && design.lamella_count() > 0;
    (rigid && design.joint() == HingeKind::Welded).then_some(Warning::RigidLamellae)
}

/// Tapers whose ends do not lie on the finger: what is written there is not what is there.
fn tapers(case: &Case) -> Vec<Warning> {
    let design = &case.finger.design;
    let heights = [design.front.base, design.back.base, design.front.tip, design.back.tip].map(|[_, y]| y);
    let lowest = heights.into_iter().fold(f64::INFINITY, f64::min);
    let highest = heights.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let mut found = Vec::new();
    for (key, profile, [from, to]) in [
        ("width_mm", &design.width, [lowest, highest]),
        ("front.thickness_mm", &design.front.thickness, [0.0, design.front.length()]),
        ("back.thickness_mm", &design.back.thickness, [0.0, design.back.length()]),
    ] {
        let slack = BEYOND * (to - from);
        for knot in ends(profile) {
            let (end, at) = match knot[0] {
                below if below < from - slack => (End::Base, from),
                above if above > to + slack => (End::Tip, to),
                _ => continue,
            };
            found.push(Warning::Taper(Taper { key, knot, end, there: [at, profile.at(at)] }));
        }
    }
    found
}

/// First and last knot of a taper.
fn ends(profile: &Profile) -> Vec<[f64; 2]> {
    match profile.knots.as_slice() {
        [first, .., last] => vec![*first, *last],
        _ => Vec::new(),
    }
}

/// Why there is no number from the first place on that is out of range.
fn lost(case: &Case, places: &[Place]) -> Option<Warning> {
    let at = places.iter().find(|place| place.status == Status::OutOfRange)?.at;
    let why = if overlap::covers_base(case, at) { Loss::BaseCovered } else { Loss::Passed };
    Some(Warning::Lost { at, why })
}

/// The first place at which the solver has failed in a way that other options are known to help against.
fn unsolved(case: &Case, options: &Options, places: &[Place]) -> Option<Warning> {
    places.iter().find_map(|&Place { at, status, .. }| {
        let remedy = Remedy::of(case, options, status)?;
        Some(Warning::Unsolved { at, status, remedy })
    })
}

/// Where parts of the finger touch each other, and where they do so the most.
fn touching(places: &[Place]) -> Option<Warning> {
    let found = places.iter().filter_map(|place| Some((place.at, place.state.as_ref()?.self_contact?)));
    let (from, _) = found.clone().next()?;
    let (at, contact) = found.max_by(|a, b| a.1.depth.total_cmp(&b.1.depth))?;
    Some(Warning::Touching { contact, at, from })
}

/// Where a rib is near its buckling load, and where the nearest.
fn buckling(places: &[Place]) -> Option<Warning> {
    let found = places.iter().filter_map(|place| Some((place.at, place.state.as_ref()?.buckling?)));
    let (from, _) = found.clone().next()?;
    let (at, buckling) = found.max_by(|a, b| a.1.share.total_cmp(&b.1.share))?;
    Some(Warning::Buckling { buckling, at, from })
}

/// Parts strained beyond the limit, each at its worst place; one warning per beam.
fn strained(places: &[Place]) -> Vec<Warning> {
    let mut worst: Vec<(Beyond, At)> = Vec::new();
    for place in places {
        for &beyond in place.state.iter().flat_map(|state| &state.beyond_max_strain) {
            match worst.iter_mut().find(|(known, _)| known.part.is_same(beyond.part)) {
                Some((most, _)) if most.strain >= beyond.strain => {}
                Some(known) => *known = (beyond, place.at),
                None => worst.push((beyond, place.at)),
            }
        }
    }
    worst.sort_by(|a, b| b.0.strain.total_cmp(&a.0.strain));
    worst.into_iter().map(|(beyond, at)| Warning::Strained { beyond, at }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(change: impl FnOnce(&mut model_core::design::Design)) -> Vec<String> {
        let text = "finger = \"preset:ladder-80\"\nobject = { shape = \"circle\", radius_mm = 40, centre_mm = [41, 45] }\n\
                    motion.motor_angles_deg = [2]\n";
        let mut case = Case::parse("case.toml", text).unwrap();
        change(&mut case.finger.design);
        warnings(&case, &Options::default(), &[]).iter().map(Warning::to_string).collect()
    }

    fn taper(knots: &[[f64; 2]]) -> Profile {
        Profile { knots: heapless::Vec::from_slice(knots).unwrap() }
    }

    #[test]
    fn a_taper_beyond_the_finger_is_warned_of() {
        let clear = [
            told(|d| d.front.thickness = taper(&[[0.0, 2.0], [80.5, 1.0]])),
            told(|d| d.width = taper(&[[10.0, 22.0], [70.0, 18.0]])),
            told(|d| d.back.thickness = taper(&[[500.0, 2.0]])),
        ];
        assert_eq!(clear, [const { Vec::<String>::new() }; 3]);
        assert_eq!(
            told(|d| d.front.thickness = taper(&[[0.0, 2.0], [160.0, 1.0]])),
            ["finger.front.thickness_mm: 1 mm at 160 mm lies beyond the tip, which is at 80 mm: there it is 1.5 mm"]
        );
        assert_eq!(
            told(|d| d.width = taper(&[[-80.0, 24.0], [80.0, 16.0]])),
            ["finger.width_mm: 24 mm at -80 mm lies beyond the base, which is at 0 mm: there it is 20 mm"]
        );
    }
}
