//! `-` in place of a file: standard input, or standard output.

use std::io::{BufWriter, ErrorKind, Read as _, Stdout, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use fre::case::{Case, CaseError, Document};
use fre::files::{Draft, FileError, Files, Output};
use fre::fit::measured::{Measured, MeasuredError};

use crate::exit::detail;
use crate::progress::ProgressLine;

/// What standard input is called in messages.
const INPUT: &str = "standard input";

/// Whether a path stands for standard input or output.
pub fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// A file that cannot be standard output.
///
/// # Errors
/// It is `-`.
pub fn only_file(words: &str) -> Result<PathBuf, String> {
    only("a file", words)
}

/// A folder, which standard output cannot be.
///
/// # Errors
/// It is `-`.
pub fn only_folder(words: &str) -> Result<PathBuf, String> {
    only("a folder", words)
}

fn only(what: &str, words: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(words);
    if is_standard(&path) { Err(format!("allowed is {what}; - is standard output")) } else { Ok(path) }
}

/// Takes standard input for one reader; a second one would find nothing.
fn claim() -> Result<(), &'static str> {
    static TAKEN: AtomicBool = AtomicBool::new(false);
    if TAKEN.swap(true, Ordering::Relaxed) {
        return Err("it is named twice (-), and can be read once only");
    }
    Ok(())
}

/// The text on standard input.
fn text() -> Result<String, CaseError> {
    let unreadable = |error: std::io::Error| CaseError::Unreadable {
        file: INPUT.to_owned(),
        kind: error.kind(),
        reason: error.to_string(),
    };
    claim().map_err(|reason| unreadable(std::io::Error::other(reason)))?;
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text).map_err(unreadable)?;
    Ok(text)
}

/// What a file is called in messages.
pub fn name(path: &Path) -> String {
    if is_standard(path) { INPUT.to_owned() } else { path.display().to_string() }
}

/// Everything in a file or on standard input.
///
/// # Errors
/// With its name: it cannot be read.
#[cfg(any(feature = "gripper", feature = "outline"))]
pub fn bytes(path: &Path) -> Result<Vec<u8>, String> {
    let unreadable = |reason: String| format!("{}: {reason}", name(path));
    if !is_standard(path) {
        return std::fs::read(path).map_err(|error| unreadable(error.to_string()));
    }
    claim().map_err(|reason| unreadable(reason.to_owned()))?;
    let mut bytes = Vec::new();
    std::io::stdin().read_to_end(&mut bytes).map_err(|error| unreadable(error.to_string()))?;
    Ok(bytes)
}

/// The same as text.
///
/// # Errors
/// With its name: it cannot be read, or is not UTF-8.
#[cfg(feature = "gripper")]
pub fn words(path: &Path) -> Result<String, String> {
    String::from_utf8(bytes(path)?).map_err(|error| format!("{}: {error}", name(path)))
}

/// Reads a case file, or a case on standard input, which finds finger files in the current folder.
///
/// # Errors
/// As [`Case::read`].
pub fn case(path: &Path) -> Result<Case, CaseError> {
    detail!("fre: reads {}", path.display());
    if is_standard(path) { Case::parse(INPUT, &text()?) } else { Case::read(path) }
}

/// The same, as a document that can be changed.
///
/// # Errors
/// As [`Document::read`].
pub fn document(path: &Path) -> Result<Document, CaseError> {
    detail!("fre: reads {}", path.display());
    if is_standard(path) { Document::resolve(INPUT, &text()?, Path::new("")) } else { Document::read(path) }
}

/// Reads measurements from a file or from standard input, and says how far it is.
///
/// # Errors
/// As [`Measured::read`].
pub fn measured(path: &Path) -> Result<Measured, MeasuredError> {
    detail!("fre: reads {}", path.display());
    let mut line = ProgressLine::new(false);
    let name = name(path);
    let watch = |progress: fre::fit::measured::Progress| {
        line.show(false, || format!("reading {name}: line {} of {}", progress.line, progress.of));
        ControlFlow::Continue(())
    };
    let unreadable = |source| MeasuredError::Unreadable { file: name.clone(), source };
    let measured = if is_standard(path) {
        claim().map_err(|reason| unreadable(std::io::Error::other(reason)))?;
        Measured::read_from(&name, std::io::stdin(), watch)
    } else {
        let file = std::fs::File::open(path).map_err(unreadable)?;
        Measured::read_from(&name, file, watch)
    };
    line.wipe();
    measured
}

/// Where a result goes that may be written to standard output.
pub enum Target {
    /// A file, by the one rule for files.
    File(Output),
    /// Standard output.
    Standard,
}

impl Target {
    /// Takes note of a file that will be written; `-` is standard output.
    ///
    /// # Errors
    /// It must not be written.
    pub fn of(files: &mut Files, path: &Path, what: &str) -> Result<Self, FileError> {
        if is_standard(path) { Ok(Self::Standard) } else { files.output(path, what).map(Self::File) }
    }

    /// Writes it whole. A reader of standard output that stops early is not a failure.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(self, bytes: &[u8]) -> Result<(), String> {
        match self {
            Self::File(output) => output.write(bytes).map_err(|error| error.to_string()),
            Self::Standard => put_out(bytes),
        }
    }

    /// Begins a long result.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn draft(self) -> Result<Stream, FileError> {
        match self {
            Self::File(output) => output.draft().map(Stream::File),
            Self::Standard => Ok(Stream::Standard(BufWriter::new(std::io::stdout()))),
        }
    }
}

/// A long result on its way.
pub enum Stream {
    /// A file, which takes its place when it is finished.
    File(Draft),
    /// Standard output. A reader that stops early is not a failure.
    Standard(BufWriter<Stdout>),
}

impl Stream {
    /// Ends it.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(mut self) -> Result<(), FileError> {
        match self {
            Self::File(draft) => draft.finish(),
            Self::Standard(_) => self.flush().map_err(|source| FileError::Unwritable {
                what: "standard output".to_owned(),
                path: "-".into(),
                source,
            }),
        }
    }
}

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        match self {
            Self::File(draft) => draft.write(bytes),
            Self::Standard(out) => match out.write(bytes) {
                Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(bytes.len()),
                written => written,
            },
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        match self {
            Self::File(draft) => draft.flush(),
            Self::Standard(out) => match out.flush() {
                Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
                flushed => flushed,
            },
        }
    }
}

/// Writes to standard output. A reader that stops early (`fre … | head`) is not a failure; a full disk is.
///
/// # Errors
/// It cannot be written.
pub fn put_out(bytes: &[u8]) -> Result<(), String> {
    let mut out = std::io::stdout();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(format!("standard output: {error}")),
        _ => Ok(()),
    }
}
