//! The files that a command reads and writes, and the one rule for all of them.
//!
//! An output is never an input, nor another output, however it is named (links, relative paths, `/dev/fd`). A file that exists is
//! overwritten on request only. A result is written beside its place and renamed: whole or not at all. What is written as it
//! comes (a recording) is locked meanwhile.
//!
//! ```
//! use fre::files::Files;
//! # let folder = tempfile::tempdir()?;
//! # let (case, plot) = (folder.path().join("case.toml"), folder.path().join("plot.svg"));
//! # std::fs::write(&case, "")?;
//! let mut files = Files::new(false);
//! files.input(&case, "the case")?;
//! assert!(files.output(&case, "--plot").is_err());
//! let output = files.output(&plot, "--plot")?;
//! output.write(b"<svg/>")?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs::{self, File, Metadata, OpenOptions, Permissions, TryLockError};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// Links that are followed before a name counts as leading nowhere.
const LINKS: usize = 40;

/// Why a file is refused, or was not written. `what` names its use: an option, or an input.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// Two uses of one file, one of them writing.
    #[error("{what}: {} is the same file as {other}; an output needs a file of its own", path.display())]
    Shared {
        /// Its use.
        what: String,
        /// As it was named.
        path: PathBuf,
        /// Its other use, and the name there.
        other: String,
    },
    /// The file is there already.
    #[error("{what}: {} exists; --force overwrites it", path.display())]
    Exists {
        /// Its use.
        what: String,
        /// As it was named.
        path: PathBuf,
    },
    /// Another program, or another part of this one, is writing it.
    #[error("{what}: {} is being written by another program", path.display())]
    Busy {
        /// Its use.
        what: String,
        /// As it was named.
        path: PathBuf,
    },
    /// Neither a file nor something like a pipe.
    #[error("{what}: {} is a folder", path.display())]
    Folder {
        /// Its use.
        what: String,
        /// As it was named.
        path: PathBuf,
    },
    /// The system refuses.
    #[error("{what}: {} cannot be written: {source}", path.display())]
    Unwritable {
        /// Its use.
        what: String,
        /// As it was named.
        path: PathBuf,
        /// The system's words.
        source: io::Error,
    },
}

/// The files of one command.
#[derive(Debug)]
pub struct Files {
    overwrite: bool,
    uses: Vec<Use>,
}

/// A use of a file.
#[derive(Debug)]
struct Use {
    what: String,
    identity: Identity,
    writes: bool,
}

/// What makes two names the same file.
#[derive(Debug, PartialEq, Eq)]
enum Identity {
    /// Device and number of a file that exists: links of both kinds lead to the same.
    #[cfg(unix)]
    Number(u64, u64),
    /// A file that is to be made, or any file where the system gives no number: its folder without links, and its name.
    Name(PathBuf),
}

impl Files {
    /// No files yet, except standard output if that is a file. `overwrite`: files that exist may be replaced.
    pub fn new(overwrite: bool) -> Self {
        let mut files = Self { overwrite, uses: Vec::new() };
        if let Some(identity) = standard_output() {
            files.uses.push(Use { what: "standard output".to_owned(), identity, writes: true });
        }
        files
    }

    /// Takes note of a file that is read.
    ///
    /// # Errors
    /// It is an output. (A file that is not there is its reader's affair.)
    pub fn input(&mut self, path: &Path, what: &str) -> Result<(), FileError> {
        self.note(path, what, false)
    }

    /// Takes note of a file that is to be written, before time is spent on what goes into it.
    ///
    /// # Errors
    /// It is an input or another output; it exists and is not to be overwritten; it is being written; it cannot be written.
    pub fn output(&mut self, path: &Path, what: &str) -> Result<Output, FileError> {
        let output =
            Output { what: what.to_owned(), path: path.to_owned(), place: Place::Open, overwrite: self.overwrite };
        let resolved = resolve(path).map_err(|source| output.unwritable(source))?;
        let place = match fs::metadata(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => {
                self.note(path, what, true)?;
                let folder = resolved.path.parent().unwrap_or(Path::new("."));
                fs::metadata(folder).map_err(|source| output.unwritable(source))?;
                Place::New(resolved.path)
            }
            Err(source) => return Err(output.unwritable(source)),
            Ok(meta) if meta.is_dir() => return Err(FileError::Folder { what: output.what, path: output.path }),
            // A pipe, a terminal, /dev/null.
            Ok(meta) if !meta.is_file() => Place::Open,
            Ok(meta) => {
                self.note(path, what, true)?;
                if resolved.is_descriptor {
                    Place::Open
                } else {
                    output.may_replace()?;
                    Place::Old(resolved.path, meta.permissions())
                }
            }
        };
        Ok(Output { place, ..output })
    }

    /// Takes note of a file that is continued, not overwritten: one that holds the beginning of what is to be written.
    ///
    /// # Errors
    /// It is an input or another output.
    pub fn continued(&mut self, path: &Path, what: &str) -> Result<(), FileError> {
        self.note(path, what, true)
    }

    /// Makes a folder, if it is not there, and takes note of the files that are to be written into it.
    ///
    /// # Errors
    /// As [`Self::output`], of the first that must not be written.
    pub fn folder(&mut self, path: &Path, names: &[&str], what: &str) -> Result<Folder, FileError> {
        fs::create_dir_all(path).map_err(|source| FileError::Unwritable {
            what: what.to_owned(),
            path: path.to_owned(),
            source,
        })?;
        let output = |name: &&str| Ok(((*name).to_owned(), self.output(&path.join(name), what)?));
        Ok(Folder { path: path.to_owned(), outputs: names.iter().map(output).collect::<Result<_, _>>()? })
    }

    fn note(&mut self, path: &Path, what: &str, writes: bool) -> Result<(), FileError> {
        let identity = match fs::metadata(path) {
            Ok(meta) if !meta.is_file() => return Ok(()),
            Ok(meta) => number(&meta),
            Err(_) => None,
        };
        let name = || resolve(path).map_or_else(|_| path.to_owned(), |resolved| resolved.path);
        let identity = identity.unwrap_or_else(|| Identity::Name(name()));
        if let Some(other) = self.uses.iter().find(|other| (other.writes || writes) && other.identity == identity) {
            let (what, path, other) = (what.to_owned(), path.to_owned(), other.what.clone());
            return Err(FileError::Shared { what, path, other });
        }
        self.uses.push(Use { what: format!("{what} ({})", path.display()), identity, writes });
        Ok(())
    }
}

/// An output that may be written.
#[derive(Debug)]
#[must_use]
pub struct Output {
    what: String,
    path: PathBuf,
    place: Place,
    overwrite: bool,
}

/// A file on its way.
#[derive(Debug)]
#[must_use]
pub struct Draft {
    output: Output,
    sink: BufWriter<Sink>,
}

/// Where a draft is written.
#[derive(Debug)]
enum Sink {
    Open(File),
    Beside(NamedTempFile),
}

impl Draft {
    /// Puts the file in its place.
    ///
    /// # Errors
    /// It cannot be written, or was made by another program meanwhile.
    pub fn finish(self) -> Result<(), FileError> {
        let Self { output, sink } = self;
        match (sink.into_inner(), &output.place) {
            (Err(error), _) => Err(output.unwritable(error.into_error())),
            (Ok(Sink::Beside(beside)), Place::New(path) | Place::Old(path, _)) => output.rename(beside, path).map(drop),
            (Ok(_), _) => Ok(()),
        }
    }
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.sink.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Open(file) => file.write(bytes),
            Self::Beside(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Open(file) => file.flush(),
            Self::Beside(file) => file.flush(),
        }
    }
}

/// Files of one folder that may be written.
#[derive(Debug)]
#[must_use]
pub struct Folder {
    path: PathBuf,
    outputs: BTreeMap<String, Output>,
}

impl Folder {
    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes one of the files, whole or not at all; gives its path.
    ///
    /// # Errors
    /// As [`Output::write`]; a file that was not taken note of must be new.
    pub fn write(&mut self, name: &str, bytes: &[u8]) -> Result<PathBuf, FileError> {
        self.take(name)?.write(bytes)?;
        Ok(self.path.join(name))
    }

    /// Opens one of the files to be written as its content comes.
    ///
    /// # Errors
    /// As [`Output::stream`]; a file that was not taken note of must be new.
    pub fn stream(&mut self, name: &str) -> Result<File, FileError> {
        self.take(name)?.stream()
    }

    fn take(&mut self, name: &str) -> Result<Output, FileError> {
        match self.outputs.remove(name) {
            Some(output) => Ok(output),
            None => Files::new(false).output(&self.path.join(name), "the folder"),
        }
    }
}

/// How an output is written.
#[derive(Debug)]
enum Place {
    /// Not by renaming: a pipe, a device, an open file.
    Open,
    /// A new file.
    New(PathBuf),
    /// A file that is replaced, and its permissions.
    Old(PathBuf, Permissions),
}

impl Output {
    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// It cannot be written, or was made by another program meanwhile.
    pub fn write(self, bytes: &[u8]) -> Result<(), FileError> {
        let mut draft = self.draft()?;
        draft.write_all(bytes).map_err(|source| draft.output.unwritable(source))?;
        draft.finish()
    }

    /// Begins a long file, which takes its place when it is finished; dropped before, it leaves nothing.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn draft(self) -> Result<Draft, FileError> {
        let sink = match &self.place {
            Place::Open => Sink::Open(self.open_in_place()?),
            Place::New(path) | Place::Old(path, _) => {
                Sink::Beside(self.beside(path).map_err(|source| self.unwritable(source))?)
            }
        };
        Ok(Draft { output: self, sink: BufWriter::new(sink) })
    }

    /// Opens the file to be written as its content comes; it is locked until it is closed. What it held before is gone only when
    /// the new one is in its place.
    ///
    /// # Errors
    /// It cannot be written, is being written, or was made by another program meanwhile.
    pub fn stream(self) -> Result<File, FileError> {
        match &self.place {
            Place::Open => self.open_in_place(),
            Place::New(path) | Place::Old(path, _) => {
                let beside = self.beside(path).map_err(|source| self.unwritable(source))?;
                beside.as_file().lock().map_err(|source| self.unwritable(source))?;
                self.rename(beside, path)
            }
        }
    }

    fn open_in_place(&self) -> Result<File, FileError> {
        OpenOptions::new().append(true).open(&self.path).map_err(|source| self.unwritable(source))
    }

    /// A file in the same folder, with the permissions that the output is to have.
    fn beside(&self, path: &Path) -> io::Result<NamedTempFile> {
        let folder = path.parent().unwrap_or(Path::new("."));
        let name = path.file_name().unwrap_or_else(|| OsStr::new("output"));
        let prefix = format!(".{}.", name.to_string_lossy());
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // Less the user's mask.
            builder.permissions(Permissions::from_mode(0o666));
        }
        let beside = builder.tempfile_in(folder)?;
        if let Place::Old(_, permissions) = &self.place {
            beside.as_file().set_permissions(permissions.clone())?;
        }
        Ok(beside)
    }

    fn rename(&self, beside: NamedTempFile, path: &Path) -> Result<File, FileError> {
        // On the disk before the name is: else a power failure may leave the name without its content.
        beside.as_file().sync_all().map_err(|source| self.unwritable(source))?;
        let renamed = if self.overwrite { beside.persist(path) } else { beside.persist_noclobber(path) };
        renamed.map_err(|error| match error.error.kind() {
            ErrorKind::AlreadyExists => FileError::Exists { what: self.what.clone(), path: self.path.clone() },
            _ => self.unwritable(error.error),
        })
    }

    /// That the file, which exists, is not being written and may be replaced.
    fn may_replace(&self) -> Result<(), FileError> {
        let (what, path) = (self.what.clone(), self.path.clone());
        // A rename asks the folder only: a file that must not be written is not replaced either.
        match OpenOptions::new().append(true).open(&self.path).map(|file| file.try_lock()) {
            Ok(Err(TryLockError::WouldBlock)) => Err(FileError::Busy { what, path }),
            _ if !self.overwrite => Err(FileError::Exists { what, path }),
            Err(source) => Err(self.unwritable(source)),
            Ok(_) => Ok(()),
        }
    }

    fn unwritable(&self, source: io::Error) -> FileError {
        FileError::Unwritable { what: self.what.clone(), path: self.path.clone(), source }
    }
}

/// Where a name leads.
struct Resolved {
    /// The file, in a folder without links.
    path: PathBuf,
    /// Whether the name is that of an open file (`/dev/fd/3`, `/dev/stdout`).
    is_descriptor: bool,
}

/// Follows links, to a file that need not exist.
fn resolve(path: &Path) -> io::Result<Resolved> {
    let mut path = path.to_owned();
    let mut is_descriptor = false;
    for _ in 0..LINKS {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let Some(name) = path.file_name() else { break };
        let folder = folder.canonicalize()?;
        is_descriptor |= folder.starts_with("/proc") || folder.starts_with("/dev/fd");
        path = folder.join(name);
        match fs::read_link(&path) {
            Ok(target) if !is_descriptor => path = folder.join(target),
            _ => break,
        }
    }
    Ok(Resolved { path, is_descriptor })
}

#[cfg(unix)]
fn number(meta: &Metadata) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    Some(Identity::Number(meta.dev(), meta.ino()))
}

#[cfg(not(unix))]
fn number(_: &Metadata) -> Option<Identity> {
    None
}

/// Standard output, if it is a file.
#[cfg(unix)]
fn standard_output() -> Option<Identity> {
    use std::os::fd::AsFd;
    let file = File::from(io::stdout().as_fd().try_clone_to_owned().ok()?);
    file.metadata().ok().filter(Metadata::is_file).and_then(|meta| number(&meta))
}

#[cfg(not(unix))]
fn standard_output() -> Option<Identity> {
    None
}
