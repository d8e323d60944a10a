//! Case files: a finger, an object and a motion, read from TOML.
//!
//! This is the only place where a file's units (mm, Pa, degrees) become the solver's (mm, MPa, rad). Every error names
//! the file, the line, the key, its value and what is allowed.

mod check;
mod described;
mod edit;
mod error;
mod explain;
mod finger;
mod finger_file;
mod fits;
mod inclined;
pub mod keys;
mod motion;
mod object;
mod object_words;
mod preset;
mod read;
mod reference;
mod source;
mod written;

pub use described::{Described, describe_finger};
pub use edit::Document;
pub(crate) use edit::dotted;
pub use error::{CaseError, KeyError, KnownKeys, Place};
pub use finger::Finger;
pub(crate) use finger::NO_NECK;
pub use finger_file::{named_finger, preset, read_finger};
pub use keys::{MAX_ANGLE, MAX_DISTANCE, MAX_TIME, Memory};
pub use motion::{Clock, Coordinate, Path as MotionPath};
pub use object::read_object;
pub use object_words::{ObjectWords, object_keys};
pub(crate) use preset::no_such_preset;
pub use preset::{NEW, PRESETS};
pub use read::Case;
pub use reference::{PICTURES, reference};
pub use written::Written;
