//! What a source reports, kept in a file: every estimate and event, none left out.
//!
//! A recording is an [MCAP](https://mcap.dev) file (feature `record`) of JSON messages with their schemas, which Foxglove opens
//! without a plugin; `docs/recordings.md` lists the topics. [`Csv`] is a table of the reports.

#[cfg(feature = "record")]
mod again;
mod columns;
#[cfg(feature = "record")]
mod container;
mod csv;
#[cfg(feature = "record")]
mod error;
#[cfg(feature = "record")]
mod foxglove;
#[cfg(feature = "record")]
mod message;
#[cfg(feature = "record")]
mod number;
#[cfg(feature = "record")]
mod pace;
#[cfg(feature = "record")]
mod playback;
#[cfg(feature = "record")]
mod read;
#[cfg(feature = "record")]
mod topic;
#[cfg(feature = "record")]
mod write;

#[cfg(feature = "record")]
pub use again::{Again, AgainError, Changes, Difference};
pub use columns::{COLUMNS, Cell, ReportColumn, ReportTable};
#[cfg(feature = "record")]
pub use container::Damage;
pub use csv::Csv;
#[cfg(feature = "record")]
pub use error::RecordError;
#[cfg(feature = "record")]
pub use pace::{Pace, Speed};
#[cfg(feature = "record")]
pub use playback::{PlayError, Playback, beginning};
#[cfg(feature = "record")]
pub use read::{Recorded, Recording};
#[cfg(feature = "record")]
pub use write::{Counts, Recorder};
