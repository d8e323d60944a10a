//! Parts of the finger that the object reaches into. In the model only the front beam's outer face can touch it.

use model_core::design::Beam;
use model_core::object::{Object as _, Shape};
use model_core::status::Status;

use crate::case::Case;
use crate::study::place::{At, Place};

/// A part without contact in the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// The base between the beams.
    Base,
    /// The back beam.
    BackBeam,
    /// The lamellae.
    Lamellae,
}

impl Reached {
    /// The part with its article.
    pub fn words(self) -> &'static str {
        match self {
            Self::Base => "the base between the beams",
            Self::BackBeam => "the back beam",
            Self::Lamellae => "the lamellae",
        }
    }
}

/// A part of the finger that an object reaches into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// The part.
    pub part: Reached,
    /// How far the part's centreline lies inside the object, mm.
    pub depth: f64,
    /// Where on the motion.
    pub at: At,
}

/// Below this depth, mm, an overlap is the contact's own softness.
const LEAST: f64 = 0.05;
/// Points along the base, and along a beam at rest.
const ALONG: i32 = 40;

/// The deepest overlap of each part over all places; none where the object stays clear.
pub fn worst(case: &Case, places: &[Place]) -> Vec<Overlap> {
    let mut worst: Vec<Overlap> = Vec::new();
    for found in places.iter().flat_map(|place| overlaps(case, place)) {
        match worst.iter_mut().find(|known| known.part == found.part) {
            Some(known) if known.depth >= found.depth => {}
            Some(known) => *known = found,
            None => worst.push(found),
        }
    }
    worst
}

/// The parts that the object reaches into at a place. Without a state: the base and what is held of the back beam, which cannot move. If the
/// place is out of range, the whole back beam at rest: the object is then perhaps not where it was meant to be. After any other failure the
/// beam is bent in an unknown way, and at rest an object of a deep grasp always reaches into it.
fn overlaps(case: &Case, place: &Place) -> Vec<Overlap> {
    let by = case.path.motion.world_to_finger(case.path.coordinate(place.at.value()));
    let object = Shape::<f64>::from(case.object).displaced(&by);
    let deepest = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        points.map(|point| -object.gap(point.into()).distance).fold(f64::NEG_INFINITY, f64::max)
    };
    let beam = &case.finger.design.back;
    let between = |from: [f64; 2], to: [f64; 2]| {
        (0..=ALONG).map(move |i| {
            let part = f64::from(i) / f64::from(ALONG);
            [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]))
        })
    };
    let along = |beam: &Beam, end: f64| {
        let beam = beam.clone();
        (0..=ALONG).map(move |i| beam.point(end * f64::from(i) / f64::from(ALONG)))
    };
    let held = |beam: &Beam| along(beam, beam.clamp);
    let mut base = between(case.finger.design.front.base, beam.base);
    let (back, lamellae) = match &place.state {
        Some(state) => {
            let ribs = state.shape.ribs.iter().flatten();
            let mut lamellae = state.shape.lamellae.iter().flatten().chain(ribs).copied();
            (deepest(&mut state.shape.back.iter().copied().chain(held(beam))), deepest(&mut lamellae))
        }
        None if place.status == Status::OutOfRange => (deepest(&mut along(beam, beam.length())), f64::NEG_INFINITY),
        None => (deepest(&mut held(beam)), f64::NEG_INFINITY),
    };
    [(Reached::Base, deepest(&mut base)), (Reached::BackBeam, back), (Reached::Lamellae, lamellae)]
        .into_iter()
        .filter(|(_, depth)| *depth > LEAST)
        .map(|(part, depth)| Overlap { part, depth, at: place.at })
        .collect()
}

/// The depth of the deepest overlap at a place, mm.
pub fn depth(case: &Case, place: &Place) -> Option<f64> {
    overlaps(case, place).into_iter().map(|overlap| overlap.depth).reduce(f64::max)
}

/// True if the object lies over the front beam's clamped end, or over the part that is held, at a place.
pub fn covers_base(case: &Case, at: At) -> bool {
    let design = &case.finger.design;
    let by = case.path.motion.world_to_finger(case.path.coordinate(at.value()));
    let object = Shape::<f64>::from(case.object).displaced(&by);
    let front = &design.front;
    let pieces = if front.clamp > 0.0 { ALONG } else { 0 };
    (0..=pieces).any(|i| {
        let arc = front.clamp * f64::from(i) / f64::from(ALONG);
        object.gap(front.point(arc).into()).distance < 0.5 * front.thickness.at(arc)
    })
}
