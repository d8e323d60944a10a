//! What a command writes: files by the one rule of [`fre::files`], text on standard output.

use std::io::{ErrorKind, Write};
use std::path::Path;

use fre::case::Document;
use fre::draw::{self, Scene, Theme};
use fre::files::{FileError, Files, Output};

/// Whether files that exist are overwritten.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct ForceArgs {
    /// Overwrites files that exist
    #[arg(long)]
    force: bool,
}

impl ForceArgs {
    /// The files of this command.
    pub fn files(self) -> Files {
        Files::new(self.force)
    }
}

/// Takes note of a case that is read, and of the finger's file that it names.
///
/// # Errors
/// One of them is an output.
pub fn reads_case(files: &mut Files, path: &Path) -> Result<(), FileError> {
    files.input(path, "the case")?;
    // What is wrong with the file, its reader says.
    let Ok(document) = Document::read(path) else { return Ok(()) };
    document.finger_file().map_or(Ok(()), |file| files.input(file, "the finger of the case"))
}

/// A picture that is to be written, in the format that its name ends with.
pub struct Picture {
    output: Output,
    format: draw::Format,
}

impl Picture {
    /// Takes note of it.
    ///
    /// # Errors
    /// Its ending names no format, or it must not be written.
    pub fn of(files: &mut Files, path: &Path) -> Result<Self, String> {
        let format = draw::Format::of(path).map_err(|error| error.to_string())?;
        let output = files.output(path, "--plot").map_err(|error| error.to_string())?;
        Ok(Self { output, format })
    }

    /// Draws and writes it.
    ///
    /// # Errors
    /// It cannot be drawn or written.
    pub fn draw(self, scene: &Scene, theme: Theme) -> Result<(), String> {
        let bytes = draw::encode(scene, self.format, theme).map_err(|error| error.to_string())?;
        self.output.write(&bytes).map_err(|error| error.to_string())
    }
}

/// Writes a result to standard output. A reader that stops early (`fre … | head`) is no failure; a full disk is.
///
/// # Errors
/// It cannot be written.
pub fn put_out(text: &str) -> Result<(), String> {
    let mut out = std::io::stdout();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(format!("standard output: {error}")),
        _ => Ok(()),
    }
}
