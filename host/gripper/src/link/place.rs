//! The place where a program lets others use its link: a socket in a folder of this user's own.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};

use super::Address;

/// The way to the program that has this gripper's link, if there is one.
pub(super) fn way(address: &Address) -> Option<UnixStream> {
    UnixStream::connect(place(address).ok()?).ok()
}

/// The socket of a gripper's link.
pub(super) fn place(address: &Address) -> io::Result<PathBuf> {
    let mut hasher = DefaultHasher::new();
    let real = |path: &Path| std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    match address {
        Address::Unix(path) => ("unix", real(path)).hash(&mut hasher),
        Address::Tcp(words) => ("tcp", words).hash(&mut hasher),
        // Whatever its rate: a port has one user.
        Address::Serial { path, .. } => ("serial", real(path)).hash(&mut hasher),
    }
    Ok(folder()?.join(format!("{:016x}.sock", hasher.finish())))
}

/// A folder of this user's own.
fn folder() -> io::Result<PathBuf> {
    let user = || std::fs::metadata("/proc/self").map_or(0, |own| own.uid());
    let path = match std::env::var_os("XDG_RUNTIME_DIR") {
        Some(path) if !path.is_empty() => PathBuf::from(path).join("fre"),
        _ => std::env::temp_dir().join(format!("fre-{}", user())),
    };
    match std::fs::DirBuilder::new().mode(0o700).create(&path) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(error),
        _ => {}
    }
    let found = std::fs::symlink_metadata(&path)?;
    if found.is_dir() && found.mode() & 0o077 == 0 && found.uid() == user() {
        Ok(path)
    } else {
        Err(io::Error::other(format!("{} is not this user's own folder", path.display())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_has_one_place_whatever_it_is_called() {
        let folder = tempfile::tempdir().unwrap();
        let real = folder.path().join("port");
        std::fs::write(&real, "").unwrap();
        let link = folder.path().join("by-id");
        std::os::unix::fs::symlink(&real, &link).unwrap();
        let serial = |path: &Path, baud| place(&Address::Serial { path: path.to_owned(), baud }).unwrap();
        assert_eq!(serial(&real, 57_600), serial(&link, 1_000_000));
        assert_ne!(serial(&real, 57_600), place(&Address::Unix(real)).unwrap());
    }
}
