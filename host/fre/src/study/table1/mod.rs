//! Table 1 of *Geometrico-Static Modelling of a FRE Finger* (the paper): twenty grasps of the preset `dhas-80`, by the paper's physics and
//! the extended one, at full and at reduced resolution, with the paper's measures between them.
//!
//! The paper prints the motor angles, not the objects' positions nor the finger's dimensions. Here every series has the
//! contact height of its name and an object placed so that first contact is 6° before its first angle.

mod bars;
mod error;
mod page;
mod report;
mod row;
mod series;
mod solve;
mod table;
mod variant;

pub use error::Table1Error;
pub use page::STYLE;
pub use report::{FILES, csv, write};
pub use row::{Agreement, Row};
pub use series::{APPROACH_DEG, CASES, PRESET, SERIES, Series};
pub use solve::{Progress, solve, solve_watched};
pub use table::markdown;
pub use variant::{COMPARED, EXTENDED_FULL, EXTENDED_REDUCED, PAPER_FULL, PAPER_REDUCED, Variant, variants};
