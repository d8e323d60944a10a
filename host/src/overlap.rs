//! Where an object stands in a finger's way: only the front beam's outer face knows contact in the model.

use model_core::object::{Object as _, Shape};

use crate::case::Case;
use crate::run::Solution;

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
/// Points along the base lamella.
const ALONG_BASE: i32 = 20;

/// The deepest overlap of each part that knows no contact, over all trustworthy solutions; none where the object stays clear.
pub fn worst(case: &Case, solutions: &[Solution]) -> Vec<Overlap> {
    let mut worst: Vec<Overlap> = Vec::new();
    for solution in solutions.iter().filter(|solution| solution.status.is_trustworthy()) {
        let place = solution.place();
        let by = case.path.motion.world_to_finger(case.path.coordinate(place));
        let object = Shape::<f64>::from(case.object).displaced(&by);
        let deepest = |points: &mut dyn Iterator<Item = [f64; 2]>| {
            points.map(|point| -object.gap(point.into()).distance).fold(f64::NEG_INFINITY, f64::max)
        };
        let (front, back) = (case.finger.design.front.base, case.finger.design.back.base);
        let mut base = (0..=ALONG_BASE).map(|i| {
            let part = f64::from(i) / f64::from(ALONG_BASE);
            [0, 1].map(|axis| front[axis] + part * (back[axis] - front[axis]))
        });
        let mut lamellae = solution.lamellae_mm.iter().flatten().copied();
        let parts = [
            ("the base between the beams", deepest(&mut base)),
            ("the back beam", deepest(&mut solution.back_mm.iter().copied())),
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
