//! Sweeps: a case solved over a grid of its numbers and of the resolution, in parallel, into a CSV file that a stopped
//! sweep goes on with.

mod axis;
mod columns;
mod error;
mod grid;
mod identity;
mod ledger;
mod merge;
mod shard;
mod study;
mod work;

pub use axis::{Axis, numbers};
#[cfg(feature = "parquet")]
pub use columns::write_parquet;
pub use columns::{kind, table};
pub use error::SweepError;
pub use grid::Sweep;
pub use ledger::{Known, Ledger};
pub use merge::{Merge, Merged};
pub use shard::Shard;
pub use study::{Tuned, study};
pub use work::{LISTED, Progress, Tally, run};
