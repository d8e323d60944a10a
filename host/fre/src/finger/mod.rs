//! A finger as a plane figure: its walls, rungs and solid tip from the keys of a case, and its closed outline. Drawings and solids are made
//! from it. It knows every key, whether the solver computes it yet or not.

mod body;
pub mod measure;
mod outline;
mod wall;

pub use body::{Body, BodyError, Rung, RungEnds};
pub use outline::{Loop, outline};
pub use wall::Wall;

pub use crate::faces::Point;
pub(crate) use crate::faces::{cross, dot, minus};

/// The point `by` times a direction away.
pub(crate) fn along(p: Point, direction: Point, by: f64) -> Point {
    [p[0] + by * direction[0], p[1] + by * direction[1]]
}

pub(crate) fn distance(a: Point, b: Point) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}
