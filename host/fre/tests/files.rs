//! The rule for files: no output is an input or another output, nothing is lost, nothing is torn.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use fre::files::{FileError, Files};

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

/// What stands in a folder, by name.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// A message, with its folder's path cut off the names.
fn named(folder: &tempfile::TempDir, error: &str) -> String {
    error.replace(&folder.path().display().to_string(), "FOLDER").replace('\\', "/")
}

/// A symbolic link to a file, where the system has them for everybody.
#[cfg(unix)]
fn soft_link(to: &Path) -> Option<PathBuf> {
    let link = to.with_file_name("soft");
    std::os::unix::fs::symlink(to, &link).unwrap();
    Some(link)
}

#[cfg(not(unix))]
fn soft_link(_: &Path) -> Option<PathBuf> {
    None
}

#[test]
fn an_output_is_never_an_input_however_it_is_named() {
    let folder = folder();
    let case = folder.path().join("case.toml");
    fs::write(&case, "case").unwrap();
    fs::create_dir(folder.path().join("sub")).unwrap();
    let hard = folder.path().join("hard");
    fs::hard_link(&case, &hard).unwrap();
    let mut same = vec![case.clone(), folder.path().join("sub/../case.toml"), folder.path().join("./case.toml"), hard];
    same.extend(soft_link(&case));
    for name in same {
        // `overwrite` is no excuse.
        for overwrite in [false, true] {
            let mut files = Files::new(overwrite);
            files.input(&case, "the case").unwrap();
            let error = files.output(&name, "--plot").unwrap_err();
            assert!(matches!(error, FileError::Shared { .. }), "{}: {error}", name.display());
            let words = error.to_string();
            assert!(words.contains("--plot") && words.contains("the case") && words.contains("case.toml"), "{words}");
            let mut files = Files::new(true);
            let _output = files.output(&name, "--plot").unwrap();
            assert!(files.input(&case, "the case").is_err(), "the other way round");
        }
    }
    assert_eq!(fs::read_to_string(&case).unwrap(), "case");
}

#[cfg(target_os = "linux")]
#[test]
fn an_open_file_is_the_file_it_is_of() {
    use std::os::fd::AsRawFd;
    let folder = folder();
    let case = folder.path().join("case.toml");
    fs::write(&case, "case").unwrap();
    let open = File::options().append(true).open(&case).unwrap();
    let descriptor = Path::new("/dev/fd").join(open.as_raw_fd().to_string());
    let mut files = Files::new(true);
    files.input(&case, "the case").unwrap();
    assert!(files.output(&descriptor, "--plot").is_err());
    // By itself it is written as it is: whoever opened it has decided.
    Files::new(false).output(&descriptor, "--plot").unwrap().write(b" and more").unwrap();
    assert_eq!(fs::read_to_string(&case).unwrap(), "case and more");
    assert_eq!(names(folder.path()), ["case.toml"]);
}

#[test]
fn two_outputs_are_two_files() {
    let folder = folder();
    let name = folder.path().join("x");
    let mut files = Files::new(true);
    let _log = files.output(&name, "--log").unwrap();
    let error = files.output(&folder.path().join("./x"), "--record").unwrap_err().to_string();
    snapbox::assert_data_eq!(
        named(&folder, &error),
        snapbox::str!["--record: FOLDER/./x is the same file as --log (FOLDER/x); an output needs a file of its own"]
    );
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("x", folder.path().join("link")).unwrap();
        assert!(
            files.output(&folder.path().join("link"), "--record").is_err(),
            "through a link that leads nowhere yet"
        );
        let null = Path::new("/dev/null");
        assert!(files.output(null, "--a").is_ok() && files.output(null, "--b").is_ok(), "no file, and nothing to lose");
    }
    let mut files = Files::new(false);
    files.input(&name, "the case").unwrap();
    files.input(&name, "the finger").unwrap();
}

#[test]
fn a_file_that_exists_is_replaced_on_request_only() {
    let folder = folder();
    let name = folder.path().join("x.csv");
    fs::write(&name, "old").unwrap();
    let error = Files::new(false).output(&name, "--csv").unwrap_err().to_string();
    snapbox::assert_data_eq!(
        named(&folder, &error),
        snapbox::str!["--csv: FOLDER/x.csv exists; --force overwrites it"]
    );
    assert_eq!(fs::read_to_string(&name).unwrap(), "old");
    let output = Files::new(true).output(&name, "--csv").unwrap();
    assert_eq!(fs::read_to_string(&name).unwrap(), "old", "until the new one is whole");
    output.write(b"new").unwrap();
    assert_eq!(fs::read_to_string(&name).unwrap(), "new");
    // Made by another program meanwhile.
    let late = folder.path().join("late");
    let output = Files::new(false).output(&late, "--csv").unwrap();
    fs::write(&late, "theirs").unwrap();
    assert!(matches!(output.write(b"ours").unwrap_err(), FileError::Exists { .. }));
    assert_eq!(fs::read_to_string(&late).unwrap(), "theirs");
    assert_eq!(names(folder.path()), ["late", "x.csv"], "nothing beside them");
}

#[cfg(unix)]
#[test]
fn links_and_permissions_stay() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let (real, link) = (folder.path().join("real"), folder.path().join("link"));
    fs::write(&real, "old").unwrap();
    fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
    std::os::unix::fs::symlink("real", &link).unwrap();
    Files::new(true).output(&link, "--csv").unwrap().write(b"new").unwrap();
    assert!(link.is_symlink());
    assert_eq!(fs::read_to_string(&real).unwrap(), "new");
    assert_eq!(real.metadata().unwrap().permissions().mode() & 0o777, 0o640);
    // A new file is everybody's to read, as the user's mask has it: as one made in the usual way.
    let (ours, usual) = (folder.path().join("ours"), folder.path().join("usual"));
    Files::new(false).output(&ours, "--csv").unwrap().write(b"").unwrap();
    fs::write(&usual, "").unwrap();
    let mode = |path: &Path| path.metadata().unwrap().permissions().mode();
    assert_eq!(mode(&ours), mode(&usual));
}

#[test]
fn what_is_being_written_is_not_written_twice() {
    let folder = folder();
    let name = folder.path().join("f.mcap");
    let mut first = Files::new(false).output(&name, "--record").unwrap().stream().unwrap();
    first.write_all(b"first").unwrap();
    for overwrite in [false, true] {
        let error = Files::new(overwrite).output(&name, "--record").unwrap_err();
        assert!(matches!(error, FileError::Busy { .. }), "{error}");
    }
    drop(first);
    assert!(matches!(Files::new(false).output(&name, "--record").unwrap_err(), FileError::Exists { .. }));
    let mut second = Files::new(true).output(&name, "--record").unwrap().stream().unwrap();
    second.write_all(b"2").unwrap();
    assert_eq!(fs::read_to_string(&name).unwrap(), "2");
    assert!(Files::new(true).output(&name, "--record").is_err(), "the new one is locked as well");
}

#[test]
fn what_cannot_be_written_is_refused_before_the_work() {
    let folder = folder();
    let error = Files::new(false).output(&folder.path().join("no/such/x"), "--csv").unwrap_err().to_string();
    // What follows are the system's words.
    let (words, _) = error.rsplit_once(": ").unwrap();
    assert_eq!(named(&folder, words), "--csv: FOLDER/no/such/x cannot be written");
    let error = Files::new(true).output(folder.path(), "--csv").unwrap_err().to_string();
    snapbox::assert_data_eq!(named(&folder, &error), snapbox::str!["--csv: FOLDER is a folder"]);
}
