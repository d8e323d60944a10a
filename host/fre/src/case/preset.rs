//! What comes with the program: fingers, and a case to start from.

use super::error::CaseError;
use super::finger::Finger;
use super::finger_file::finger_from_source;
use super::source::Source;

/// A commented case with a whole finger, to start from.
pub const NEW: &str = include_str!("new.toml");

/// Names of the fingers that come with the program.
pub const PRESETS: [&str; 3] = ["ladder-80", "fea-80", "dhas-80"];

/// A finger that comes with the program; none for another name.
///
/// # Errors
/// As for a file; the texts inside the program are tested to have none.
pub fn preset(name: &str) -> Option<Result<Finger, CaseError>> {
    let text = preset_text(name)?.to_owned();
    Some(finger_from_source(&Source { name: format!("preset:{name}"), text }, name))
}

/// The text of a finger that comes with the program.
pub(super) fn preset_text(name: &str) -> Option<&'static str> {
    match name {
        "ladder-80" => Some(include_str!("presets/ladder-80.toml")),
        "fea-80" => Some(include_str!("presets/fea-80.toml")),
        "dhas-80" => Some(include_str!("presets/dhas-80.toml")),
        _ => None,
    }
}
