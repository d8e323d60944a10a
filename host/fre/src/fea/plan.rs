//! What CalculiX is asked: the mesh, the object's surface and its path through the motion.

use model_core::object::{Motion, ObjectDesign};

use super::error::{FeaError, MAX_REFINEMENT};
use super::mesh::Mesh;
use super::place::{in_finger, world_point};
use super::region::{self, Point, Region, is_layered};
use super::start::{closest, start};
use super::surface::Surface;
use crate::case::Case;

/// Largest move of one increment: degrees of a rotation, mm of a translation.
pub const STEP: f64 = 0.5;
/// Increments for which the object holds still before results are read.
pub const HOLD_STEPS: usize = 2;

/// A mesh and a path, ready to be written. Times are CalculiX's: one unit per increment.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The mesh.
    pub mesh: Mesh,
    /// The object's surface at the beginning, finger frame.
    pub surface: Surface,
    /// Displacement of the object's pivot at the times 1, 2, …, mm, finger frame.
    pub path: Vec<Point>,
    /// Turn of the object about its pivot since the beginning at those times, rad, counter-clockwise, finger frame; 0 for a
    /// round one without friction.
    pub turns: Vec<f64>,
    /// The object's pivot at the beginning, finger frame, mm: the centre of a round one.
    pub pivot: Point,
    /// Time at which each place has been reached and held.
    pub stops: Vec<usize>,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Plan {
    /// Meshes a case's finger and divides its motion into steps.
    ///
    /// # Errors
    /// If the finger cannot be meshed, or the motion has no beginning without contact.
    pub fn of(case: &Case, refinement: usize) -> Result<Self, FeaError> {
        if !(1..=MAX_REFINEMENT).contains(&refinement) {
            return Err(FeaError::Refinement { value: refinement });
        }
        closes(case)?;
        let design = &case.finger.design;
        let region = Region::of(design)?;
        let thinnest = [&design.front, &design.back].map(|beam| beam.thickness.at(beam.clamp));
        let thickness = thinnest[0].min(thinnest[1]);
        let mesh = Mesh::finger(&region, thickness, is_layered(design), refinement);
        let begin = start(case, &region)?;
        let touching = closest(case, &region, begin).object;
        let reach = 1.25 * design.front.length();
        let round = match case.object {
            ObjectDesign::Circle { centre, .. } => Some(centre),
            _ => None,
        };
        // A round object's surface is the same however it has turned, but a finger that rubs on it feels it turn.
        let turns_unfelt = round.is_some() && case.friction == 0.0;
        let middle = world_point(case, touching, begin);
        let surface = Surface::whole(&case.object, middle, reach, refinement)
            .near(middle, reach)
            .displaced(&case.path.motion.world_to_finger(case.path.coordinate(begin)));

        let pivot = round.unwrap_or(middle);
        let origin = in_finger(case, pivot, begin);
        let turn = |place: f64| match case.path.motion {
            Motion::Rotating { .. } if !turns_unfelt => case.path.coordinate(place) - case.path.coordinate(begin),
            _ => 0.0,
        };
        let (mut path, mut turns, mut stops) = (Vec::new(), Vec::new(), Vec::new());
        let mut from = begin;
        for &place in &case.path.places {
            let moves = ((place - from).abs() / STEP - 1e-9).ceil().max(1.0) as usize;
            let moving = (1..=moves).map(|i| from + (place - from) * i as f64 / moves as f64);
            for at in moving.chain([place; HOLD_STEPS]) {
                path.push(region::minus(in_finger(case, pivot, at), origin));
                turns.push(turn(at));
            }
            stops.push(path.len());
            from = place;
        }
        Ok(Self { mesh, surface, path, turns, pivot: origin, stops, friction: case.friction })
    }
}

/// That a finger with friction closes all the way: after a reversal, a point that newly touches has slipped by its whole displacement for
/// CalculiX.
fn closes(case: &Case) -> Result<(), FeaError> {
    let places = &case.path.places;
    let opens = places.windows(2).position(|pair| pair[1] < pair[0]).filter(|_| case.friction != 0.0);
    let Some(at) = opens else { return Ok(()) };
    let key = match case.path.motion {
        Motion::Rotating { .. } => "motion.motor_angles_deg",
        Motion::Translating { .. } => "motion.distances_mm",
    };
    let [before, value] = [places[at], places[at + 1]];
    Err(FeaError::Opens { key: format!("{key}[{}]", at + 1), value, before, friction: case.friction })
}
