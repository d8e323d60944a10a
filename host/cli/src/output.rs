//! What a command writes: files by the one rule of [`fre::files`], text on standard output.

use std::io::{ErrorKind, Write};
use std::path::{Display, Path, PathBuf};

use clap::ValueEnum;

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

/// Whether results are drawn, where, and how.
#[derive(Debug, clap::Args)]
pub struct PlotArgs {
    /// Draws the results
    #[arg(long, value_name = "FILE.svg|FILE.png")]
    plot: Option<PathBuf>,
    /// Colours of a PNG; an SVG follows its viewer's
    #[arg(long, value_enum, default_value = "light", requires = "plot")]
    plot_theme: ThemeWord,
    #[command(flatten)]
    force: ForceArgs,
}

impl PlotArgs {
    /// The files of a command that may draw.
    pub fn files(&self) -> Files {
        self.force.files()
    }

    /// Takes note of the picture, if one is asked for.
    ///
    /// # Errors
    /// Its ending names no format, or it must not be written.
    pub fn picture(&self, files: &mut Files) -> Result<Option<Picture>, String> {
        let theme = self.plot_theme.theme();
        self.plot.as_deref().map(|file| Picture::of(files, file, theme)).transpose()
    }
}

/// Colours of a picture of pixels.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum ThemeWord {
    /// On white, for paper.
    Light,
    /// On black, for screens.
    Dark,
}

impl ThemeWord {
    fn theme(self) -> Theme {
        match self {
            Self::Light => Theme::Light,
            Self::Dark => Theme::Dark,
        }
    }
}

/// A picture that is to be written, in the format that its name ends with.
pub struct Picture {
    output: Output,
    format: draw::Format,
    theme: Theme,
    file: PathBuf,
}

impl Picture {
    /// Takes note of it.
    ///
    /// # Errors
    /// Its ending names no format, or it must not be written.
    fn of(files: &mut Files, path: &Path, theme: Theme) -> Result<Self, String> {
        let format = draw::Format::of(path).map_err(|error| error.to_string())?;
        let output = files.output(path, "--plot").map_err(|error| error.to_string())?;
        Ok(Self { output, format, theme, file: path.to_owned() })
    }

    /// Its name as it was given.
    pub fn file(&self) -> Display<'_> {
        self.file.display()
    }

    /// Draws and writes it.
    ///
    /// # Errors
    /// It cannot be drawn or written.
    pub fn draw(self, scene: &Scene) -> Result<(), String> {
        let bytes = draw::encode(scene, self.format, self.theme).map_err(|error| error.to_string())?;
        self.output.write(&bytes).map_err(|error| error.to_string())
    }
}

/// Writes a result to standard output. A reader that stops early (`fre … | head`) is not a failure; a full disk is.
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
