//! Where an object stands in a finger's way: only the front beam's outer face knows contact in the model.

use model_core::object::{Object as _, Shape};

use crate::case::Case;
use crate::study::run::Solution;

/// A part of the finger that an object reaches into.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlap {
    /// The part, with its article.
    pub part: &'static str,
    /// How far the part's centreline lies inside the object, mm.
    pub depth: f64,
    /// Place of the motion, degrees or mm.
    pub place: f64,
}

/// Below this depth, mm, an overlap is the contact's own softness.
const LEAST: f64 = 0.05;
/// Points along the base, and along a beam at rest.
const ALONG: i32 = 40;

/// The deepest overlap of each part that knows no contact, over all solutions; none where the object stays clear. Where there is no
/// trustworthy solution, of the base and of the back beam at rest.
pub fn worst(case: &Case, solutions: &[Solution]) -> Vec<Overlap> {
    let mut worst: Vec<Overlap> = Vec::new();
    for solution in solutions {
        let place = solution.place();
        let by = case.path.motion.world_to_finger(case.path.coordinate(place));
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
        let mut base = between(case.finger.design.front.base, beam.base);
        let at_rest = between(beam.base, beam.tip).filter(|_| !solution.status.is_trustworthy());
        let mut lamellae = solution.lamellae_mm.iter().flatten().copied();
        let parts = [
            ("the base between the beams", deepest(&mut base)),
            ("the back beam", deepest(&mut solution.back_mm.iter().copied().chain(at_rest))),
            ("the lamellae", deepest(&mut lamellae)),
        ];
        for (part, depth) in parts.into_iter().filter(|(_, depth)| *depth > LEAST) {
            match worst.iter_mut().find(|known| known.part == part) {
                Some(known) if known.depth >= depth => {}
                Some(known) => (known.depth, known.place) = (depth, place),
                None => worst.push(Overlap { part, depth, place }),
            }
        }
    }
    worst
}

/// The depth of the deepest overlap of a solution, mm.
pub fn depth(case: &Case, solution: &Solution) -> Option<f64> {
    worst(case, std::slice::from_ref(solution)).into_iter().map(|overlap| overlap.depth).reduce(f64::max)
}

/// True if the object lies over the front beam's clamped end at a place.
pub fn covers_base(case: &Case, place: f64) -> bool {
    let design = &case.finger.design;
    let by = case.path.motion.world_to_finger(case.path.coordinate(place));
    let gap = Shape::<f64>::from(case.object).displaced(&by).gap(design.front.base.into());
    gap.distance < 0.5 * design.front.thickness.at(0.0)
}
