//! `cargo xtask release`: everything that a release consists of, in one folder with its checksums.
//!
//! The command `fre` for this PC with its completions and manual pages, the Python wheel, an image for each board, and the crates as a registry takes them. It publishes nothing.

mod checksums;
mod packages;
mod versions;
mod words;

use crate::command::{capture, headline, output, run as run_command};
use crate::cross::Cross;
use crate::pc::cargo;
use crate::{firmware, paths, portable, python};
use anyhow::{Context, Result, bail, ensure};
use pulldown_cmark::{Event, Options, Parser, Tag};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// Features of the released command. `probe` is left out: it doubles the time to build and the size.
const FEATURES: [&str; 2] = ["--features", "gripper,log,web,record,outline,parquet,terminal"];

/// Files that go with the command.
const BESIDE: [&str; 8] = [
    "README.md",
    "CHANGELOG.md",
    "LICENSE-MIT",
    "LICENSE-APACHE",
    "CITATION.cff",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "SECURITY.md",
];

/// Folders that go with it: the pages that the README sends its reader to, and the cases that they use.
const FOLDERS: [&str; 2] = ["docs", "examples"];

/// What a release is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parts {
    /// Built for it, optimised.
    Built,
    /// What the test suite has built: the command with its assertions, no wheel if there is none, the images that are there. For a test
    /// of the release itself.
    Suite,
}

/// Makes a release in a folder that is made anew.
pub fn run(parts: Parts, folder: &Path) -> Result<()> {
    let version = versions::check(&paths::root())?;
    if folder.exists() {
        fs::remove_dir_all(folder).with_context(|| format!("cannot remove the old {}", folder.display()))?;
    }
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;

    if parts == Parts::Built {
        portable::check(portable::Systems::All)?;
        let cross = Cross::find()?;
        for board in fre_boards::ALL.iter().filter(|board| board.name != firmware::SIMULATED) {
            firmware::lint(&cross, board.name)?;
        }
    }
    headline(&format!("release {version}: the command"));
    let name = format!("fre-{version}-{}-{}", std::env::consts::ARCH, std::env::consts::OS);
    let archive = pack(&command(parts)?, &name, folder)?;
    headline("release: the Python wheel");
    let wheel = wheel(parts)?;
    if let Some(wheel) = &wheel {
        copy(wheel, folder)?;
    }
    headline("release: images");
    for image in images(parts)? {
        copy(&image, folder)?;
    }
    headline("release: crates");
    for package in packages::make()? {
        copy(&package, folder)?;
    }
    let files = checksums::write(folder)?;

    headline("release: checked");
    checksums::check(folder)?;
    check_archive(&archive, &name, &version)?;
    for file in &files {
        println!("{file}");
    }
    println!("{} files and {} in {}", files.len(), checksums::FILE, folder.display());
    if wheel.is_none() {
        println!("without a wheel: the suite's part `python` makes one");
    }
    Ok(())
}

/// The command's program.
fn command(parts: Parts) -> Result<PathBuf> {
    let program = match parts {
        Parts::Suite => paths::target().join("debug/fre"),
        Parts::Built => {
            let begun = Instant::now();
            run_command(cargo("build").args(["--release", "--locked", "--package", "fre-cli"]).args(FEATURES))?;
            println!("built in {:.0} s, less what was built before", begun.elapsed().as_secs_f64());
            paths::target().join("release/fre")
        }
    };
    ensure!(program.exists(), "{} is not there: `cargo xtask test pc` builds it", program.display());
    let bytes = fs::metadata(&program).with_context(|| format!("cannot read {}", program.display()))?.len();
    println!("{}: {:.1} MB", program.display(), bytes as f64 / 1e6);
    Ok(program)
}

/// The Python wheel; with [`Parts::Suite`] none if the suite has not made one.
fn wheel(parts: Parts) -> Result<Option<PathBuf>> {
    match parts {
        Parts::Suite => python::built(),
        Parts::Built => python::wheel("release").map(Some),
    }
}

/// The images of all boards; with [`Parts::Suite`] those that are there.
fn images(parts: Parts) -> Result<Vec<PathBuf>> {
    let mut images = Vec::new();
    for board in fre_boards::ALL {
        match parts {
            Parts::Built => images.push(firmware::show(board.name)?),
            Parts::Suite => images.extend(Some(firmware::image(board.name)).filter(|image| image.exists())),
        }
    }
    ensure!(!images.is_empty(), "there is no image: `cargo xtask firmware mps2` builds one");
    Ok(images)
}

/// Packs the command with what goes beside it.
fn pack(program: &Path, name: &str, folder: &Path) -> Result<PathBuf> {
    let beside = tempfile::tempdir().context("cannot make a folder")?;
    let packed = beside.path().join(name);
    fs::create_dir(&packed)?;
    copy(program, &packed)?;
    for file in BESIDE {
        copy(&paths::root().join(file), &packed)?;
    }
    let listed = capture(Command::new("git").current_dir(paths::root()).args(["ls-files", "-z"]).args(FOLDERS))?;
    for file in String::from_utf8(listed.stdout).context("names of files")?.split_terminator('\0') {
        let to = packed.join(file);
        fs::create_dir_all(to.parent().unwrap_or(&packed))?;
        copy(&paths::root().join(file), to.parent().unwrap_or(&packed))?;
    }
    words::write(program, &packed)?;
    let archive = folder.join(format!("{name}.tar.gz"));
    // The same input makes the same archive.
    let same = ["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "--mtime=@0", "--directory"];
    output(Command::new("tar").args(same).arg(beside.path()).args(["-czf"]).arg(&archive).arg(name))?;
    Ok(archive)
}

/// That the archive's program runs and is of this version, that its pages are beside it, and what the README links to as well.
fn check_archive(archive: &Path, name: &str, version: &str) -> Result<()> {
    let folder = tempfile::tempdir().context("cannot make a folder")?;
    output(Command::new("tar").arg("-xzf").arg(archive).arg("--directory").arg(folder.path()))?;
    words::check(&folder.path().join(name))?;
    let readme = fs::read_to_string(folder.path().join(name).join("README.md")).context("no README in the archive")?;
    for link in links(&readme) {
        ensure!(
            folder.path().join(name).join(&link).exists(),
            "README.md links to {link}, which is not in the archive"
        );
    }
    let program = folder.path().join(name).join("fre");
    let said = capture(Command::new(&program).arg("--version"))?;
    let said = String::from_utf8_lossy(&said.stdout);
    if said.trim() != format!("fre {version}") {
        bail!("the packed command says `{}`, not `fre {version}`", said.trim());
    }
    Ok(())
}

/// The files that a page links to.
fn links(page: &str) -> Vec<String> {
    let target = |event| match event {
        Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => Some(dest_url.into_string()),
        _ => None,
    };
    let mut links: Vec<String> = Parser::new_ext(page, Options::ENABLE_TABLES).filter_map(target).collect();
    links.retain(|link| !link.contains("://"));
    links.into_iter().filter_map(|link| link.split('#').next().map(str::to_owned)).collect()
}

fn copy(file: &Path, folder: &Path) -> Result<()> {
    let name = file.file_name().with_context(|| format!("{} has no name", file.display()))?;
    // An image has no ending of its own.
    let mut to = folder.join(name);
    if name.to_string_lossy().starts_with("gripper-") {
        to.set_extension("elf");
    }
    fs::copy(file, &to).with_context(|| format!("cannot copy {} to {}", file.display(), to.display()))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_of_a_page_are_its_files() {
        let page = "[a](docs/a.md#b) and [web](https://example.org)\n\n| x |\n|---|\n| [c](c.md) ![d](d.svg) |\n";
        assert_eq!(links(page), ["docs/a.md", "c.md", "d.svg"]);
    }
}
