//! A finger measured in its closed outline: beams, thicknesses, ribs or hinged lamellae, angles, clamp and tip.
//!
//! Rays from the windows' edges into the material say what each edge belongs to: a ray that leaves the finger has crossed a wall, one that
//! enters the next window a rung.

mod frame;
mod rungs;
mod section;
mod walls;
mod written;

use super::{Loop, Point};
pub use frame::Front;
pub use rungs::{MeasuredRung, Necks};
pub use walls::MeasuredWall;
pub use written::case_text;

/// Why an outline cannot be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeasureError {
    /// There are too few windows.
    #[error("the outline has too few windows ({windows}); needed are two or more, with a rung between each two")]
    Windows {
        /// Windows found, bolts' holes left out.
        windows: usize,
    },
    /// A wall was not found.
    #[error(
        "no {wall} wall was found: needed is a wall of material between the windows and the outside, on either side"
    )]
    NoWall {
        /// `front` or `back`.
        wall: &'static str,
    },
    /// A rung could not be measured.
    #[error("rung {} (at about {height:.1} mm) cannot be measured: its two edges are not found", .rung + 1)]
    NoRung {
        /// Its number, from 0 at the base.
        rung: usize,
        /// Its height in the drawing's turned frame, mm.
        height: f64,
    },
}

/// What could not be decided from the outline, with what was assumed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Undecided {
    /// The key of a case that it concerns.
    pub key: &'static str,
    /// What was assumed, and why it cannot be known.
    pub why: String,
}

/// A measured finger, finger frame, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The contact beam.
    pub front: MeasuredWall,
    /// The other one.
    pub back: MeasuredWall,
    /// Rungs, base to tip.
    pub rungs: Vec<MeasuredRung>,
    /// Radius of the fillets between rungs and walls; 0 for sharp corners.
    pub fillet: f64,
    /// Height above which the tip is solid.
    pub solid_above: f64,
    /// Depth of the solid, if the file knows it.
    pub width: Option<f64>,
    /// What is left to decide.
    pub undecided: Vec<Undecided>,
}

/// Measures the outline that closed lines make.
///
/// # Errors
/// The first part that is not found.
pub fn measure(loops: &[Loop], width: Option<f64>, has_origin: bool, front: Front) -> Result<Measured, MeasureError> {
    let frame::Framed { figure, has_origin, mut undecided } = frame::framed(loops, has_origin, front)?;
    let edges = section::edges(&figure);
    let mut walls = walls::walls(&figure, &edges, has_origin)?;
    undecided.append(&mut walls.undecided);
    let rungs = rungs::rungs(&figure, &edges, &walls)?;
    let fillet = rungs::fillet(&figure);
    let origin = walls.origin;
    let moved = |p: Point| [p[0] - origin[0], p[1] - origin[1]];
    let solid_above = figure
        .windows
        .last()
        .map_or(0.0, |window| window.iter().map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max) - origin[1]);
    let [front, back] = walls.measured(moved);
    let rungs = rungs.into_iter().map(|rung| rung.moved(-origin[1])).collect();
    Ok(Measured { front, back, rungs, fillet, solid_above, width, undecided })
}
