//! What a command writes: files by the one rule of [`fre::files`], text on standard output.

use std::path::{Display, Path, PathBuf};

use clap::ValueEnum;

use crate::exit::detail;
use crate::standard::{self, Target, is_standard};
use fre::case::named_finger;
use fre::draw::{self, Scene, Theme};
use fre::files::{FileError, Files};

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

/// Takes note of a file that is read; `-` is standard input.
///
/// # Errors
/// It is an output.
#[cfg(any(feature = "gripper", feature = "outline"))]
pub fn reads(files: &mut Files, path: &Path, what: &str) -> Result<(), FileError> {
    if is_standard(path) { Ok(()) } else { files.input(path, what) }
}

/// Takes note of a case that is read, and of the finger's file that it names. What comes through a pipe is not looked into: it can be read
/// once only.
///
/// # Errors
/// One of them is an output.
pub fn reads_case(files: &mut Files, path: &Path) -> Result<(), FileError> {
    if is_standard(path) {
        return Ok(());
    }
    files.input(path, "the case")?;
    if std::fs::metadata(path).is_ok_and(|meta| !meta.is_file()) {
        return Ok(());
    }
    named_finger(path).map_or(Ok(()), |file| files.input(&file, "the finger of the case"))
}

/// Whether results are drawn, where, and how.
#[derive(Debug, clap::Args)]
pub struct PlotArgs {
    /// Draws the results; - for an SVG on standard output in place of the text
    #[arg(short, long, value_name = "FILE.svg|FILE.png")]
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

    /// Whether the picture goes to standard output, where no other result may be then.
    pub fn takes_output(&self) -> bool {
        self.plot.as_deref().is_some_and(is_standard)
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
    output: Target,
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
        let format = if is_standard(path) { Ok(draw::Format::Svg) } else { draw::Format::of(path) };
        let format = format.map_err(|error| error.to_string())?;
        let output = Target::of(files, path, "--plot").map_err(|error| error.to_string())?;
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
        self.output.write(&bytes)?;
        detail!("fre: drew {}", self.file.display());
        Ok(())
    }
}

/// Refuses two documents on standard output, each with its option and whether it was asked for; results as text are none.
///
/// # Errors
/// Two are asked for.
pub fn one_document<'o>(documents: impl IntoIterator<Item = (&'o str, bool)>) -> Result<(), String> {
    let mut named = documents.into_iter().filter_map(|(option, is_there)| is_there.then_some(option));
    match (named.next(), named.next()) {
        (Some(one), Some(other)) => Err(format!("{one} and {other}: standard output has room for one of them")),
        _ => Ok(()),
    }
}

/// Writes a result to standard output. A reader that stops early (`fre … | head`) is not a failure; a full disk is.
///
/// # Errors
/// It cannot be written.
pub fn put_out(text: &str) -> Result<(), String> {
    standard::put_out(text.as_bytes())
}
