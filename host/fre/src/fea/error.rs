//! Why there are no finite elements.

/// Largest refinement: 256 times the elements.
pub const MAX_REFINEMENT: usize = 16;

/// Why there are no finite elements.
#[derive(Debug, thiserror::Error)]
pub enum FeaError {
    /// The program is not installed.
    #[error("CalculiX's `ccx` is not in PATH; `cargo xtask setup --fea` installs it")]
    NoCalculix,
    /// The finger has something that is not meshed.
    #[error("{what} cannot be meshed; allowed is {allowed}")]
    Unsupported {
        /// What it is, as a case file has it.
        what: &'static str,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A part has no room.
    #[error("lamella {}: {what} is {value:.3} mm; more than 0.001 mm is needed", .lamella + 1)]
    NoRoom {
        /// Index of the lamella, from 0 at the base.
        lamella: usize,
        /// Which length.
        what: &'static str,
        /// The length, mm.
        value: f64,
    },
    /// The refinement is out of range.
    #[error("--mesh is {value}; allowed is 1 to {MAX_REFINEMENT}")]
    Refinement {
        /// What was asked for.
        value: usize,
    },
    /// The finger opens on a rough object.
    #[error(
        "{key} = {value}: the finger opens from {before}, and object.friction is {friction}; CalculiX takes friction for what it is \
         only while a finger closes: allowed are places that grow, or object.friction = 0"
    )]
    Opens {
        /// The place, as a case file has it.
        key: String,
        /// The place, degrees or mm.
        value: f64,
        /// The place before it.
        before: f64,
        /// The coefficient of friction.
        friction: f64,
    },
    /// The object touches the undeformed finger, or lies behind it, wherever the motion began.
    #[error(
        "the object touches the undeformed finger or lies behind its front beam at every place before the first; a place at \
         which it lies clear in front is needed"
    )]
    NoStart,
    /// A file could not be read or written.
    #[error("{file}: {source}")]
    Io {
        /// The file.
        file: String,
        /// The system's words.
        source: std::io::Error,
    },
    /// CalculiX wrote something unexpected.
    #[error("CalculiX's .{file}, line {line}: unexpected \"{text}\"")]
    Output {
        /// Ending of the file.
        file: &'static str,
        /// Line, from 1.
        line: usize,
        /// The line.
        text: String,
    },
    /// Another run works in the folder.
    #[error(
        "{folder}: another `fre compare --fea` works here, or a CalculiX (`ccx`) that outlived its own; wait for it, end it, or \
         name another folder (--folder)"
    )]
    Busy {
        /// The folder.
        folder: String,
    },
    /// The watcher stopped it.
    #[error("stopped")]
    Stopped,
    /// CalculiX reached no place at all.
    #[error("CalculiX reached no place ({ended}); its files are in {folder}{}", .complaint.as_ref().map(|words| format!("; it says: {words}")).unwrap_or_default())]
    NothingReached {
        /// Where its files are.
        folder: String,
        /// How the program ended.
        ended: String,
        /// Its first error message.
        complaint: Option<String>,
    },
}
