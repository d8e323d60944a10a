//! The front beam's shape from a photograph.
//!
//! Marks whose place in the finger's plane is known give the plane's perspective, pictures of a checkerboard the lens's
//! distortion. Both edges of the beam are found between the pixels and followed from base to tip; the outline is the
//! centreline between them in the finger frame, as [`crate::fit::measured`] reads it. All places are sampled in the photograph
//! itself: nothing is warped before edges are looked for.

pub mod beam;
pub mod boards;
pub mod camera;
pub mod camera_file;
pub mod checkerboard;
pub mod dots;
pub mod edge;
mod error;
mod extract;
pub mod homography;
mod least_squares;
mod limits;
mod mark;
pub mod marks;
mod median;
pub mod overlay;
pub mod photo;
pub mod plane;
pub mod pose;
mod smooth;
pub mod zhang;

pub use error::OutlineError;
pub use extract::{Options, Outline, OutlinePoint, extract};
