//! Texts that come with the program: fingers, and a case to start from.

/// A commented case with a whole finger, to start from.
pub const NEW: &str = include_str!("new.toml");

/// Names of the fingers that come with the program.
pub const PRESETS: [&str; 6] = ["ladder-80", "fea-80", "dhas-80", "umi", "vekkax", "hamburg-80"];

/// What is wrong with a preset that is none, and which there are.
pub(crate) fn no_such_preset() -> String {
    let names = PRESETS.map(|name| format!("\"preset:{name}\""));
    format!("there is no such preset; allowed are {}", names.join(", "))
}

/// The text of a finger that comes with the program.
pub(super) fn preset_text(name: &str) -> Option<&'static str> {
    match name {
        "ladder-80" => Some(include_str!("presets/ladder-80.toml")),
        "fea-80" => Some(include_str!("presets/fea-80.toml")),
        "dhas-80" => Some(include_str!("presets/dhas-80.toml")),
        "umi" => Some(include_str!("presets/umi.toml")),
        "vekkax" => Some(include_str!("presets/vekkax.toml")),
        "hamburg-80" => Some(include_str!("presets/hamburg-80.toml")),
        _ => None,
    }
}
