//! A new board, made by the steps of `firmware/boards/README.md` from the board that they name: in a copy of the firmware, which is then
//! built and checked like every board.

use crate::command::{headline, run as run_command};
use crate::cross::{Cross, TRIPLE};
use crate::{firmware, in_ram, near, paths};
use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::{Path, PathBuf};

/// The board that is copied, and the name that its copy gets.
const MODEL: &str = "nucleo-f429zi";
const NAME: &str = "template";
/// The same as constants of the list.
const LISTED: [&str; 2] = ["NUCLEO_F429ZI", "TEMPLATE"];
/// What the boards' crates use of the repository, from its root.
const USED: [&str; 9] = [
    "model-core",
    "firmware/board-list",
    "firmware/dynamixel",
    "firmware/grip",
    "firmware/gripper",
    "firmware/messages",
    "firmware/boards/stm32",
    // With the level of the log that images have: what is built with another would take the place of what the boards share.
    "firmware/boards/.cargo",
    "docs/device.md",
];

/// The board's part of the profile: its image is built soon, for nobody to run.
const PROFILE: &str = "[profile.release.package.template]\nopt-level = 1\n";

/// Makes the board, builds it and checks it. It is the copied board but for its name.
pub fn check(cross: &Cross) -> Result<()> {
    headline("a new board, by the steps of firmware/boards/README.md");
    let root = make().context("cannot make a new board")?;
    let boards = root.join("firmware/boards");
    let mut build = cross.cargo("build");
    run_command(build.current_dir(&boards).args(["--quiet", "--release", "--package", NAME, "--bins"]))?;
    let image = paths::boards_target().join(TRIPLE).join("release").join(format!("gripper-{NAME}"));
    let image = fs::read(&image).with_context(|| format!("cannot read {}", image.display()))?;
    let mut board = *fre_boards::named(MODEL).with_context(|| format!("{MODEL} is not a board"))?;
    board.name = NAME;
    firmware::labelled(&board, &image)?;
    near::check(&board, &image)?;
    in_ram::check(&board, &image)
}

/// A copy of the firmware with the new board as its only one.
fn make() -> Result<PathBuf> {
    let (from, root) = (paths::root(), paths::target().join("new-board"));
    if root.exists() {
        fs::remove_dir_all(&root)?;
    }
    for part in USED.iter().chain(&["Cargo.toml", "firmware/boards/Cargo.lock"]) {
        copy(&from.join(part), &root.join(part)).with_context(|| (*part).to_owned())?;
    }
    let boards = root.join("firmware/boards");
    copy(&paths::boards().join(MODEL), &boards.join(NAME))?;
    for file in ["Cargo.toml", "src/main.rs"] {
        let file = boards.join(NAME).join(file);
        let text = fs::read_to_string(&file)?;
        fs::write(&file, text.replace(MODEL, NAME).replace(LISTED[0], LISTED[1]))?;
    }
    let manifest = fs::read_to_string(paths::boards().join("Cargo.toml"))?;
    fs::write(boards.join("Cargo.toml"), only_member(&manifest)?)?;
    let list = root.join("firmware/board-list/src/lib.rs");
    let text = listed(&fs::read_to_string(&list)?)?;
    fs::write(&list, text)?;
    Ok(root)
}

/// A file or a folder, without what was built in it.
fn copy(from: &Path, to: &Path) -> Result<()> {
    if from.is_dir() {
        fs::create_dir_all(to)?;
        for entry in from.read_dir()? {
            let name = entry?.file_name();
            if name != "target" {
                copy(&from.join(&name), &to.join(&name))?;
            }
        }
    } else {
        fs::create_dir_all(to.parent().context("a file is in a folder")?)?;
        fs::copy(from, to)?;
    }
    Ok(())
}

/// The boards' manifest with the new board and what it shares with others as members.
fn only_member(manifest: &str) -> Result<String> {
    let mut found = 0;
    let lines = manifest.lines().filter_map(|line| match line.split_once(" = [") {
        Some(("members", _)) => {
            found += 1;
            Some(format!("members = [\"stm32\", \"{NAME}\"]"))
        }
        Some(("default-members", _)) => None,
        _ => Some(line.to_owned()),
    });
    let text = lines.collect::<Vec<_>>().join("\n");
    ensure!(found == 1, "the boards' Cargo.toml has no line of members");
    // Another board's own profile, the last one, is nobody's here.
    let (shared, own) = text.rsplit_once("[profile.release.package.").context("no board has a profile of its own")?;
    let is_a_boards = fre_boards::ALL.iter().any(|board| own.starts_with(&format!("{}]", board.name)));
    ensure!(is_a_boards && !own.contains('['), "the boards' Cargo.toml does not end with the profile of a board");
    Ok(format!("{shared}{PROFILE}"))
}

/// The list of boards with the copied board's constant under the new name, and with that in its `ALL`.
fn listed(list: &str) -> Result<String> {
    let start = list.find(&format!("pub const {}", LISTED[0])).context("the list does not have the board")?;
    let end = start + list[start..].find("};\n").context("the board's constant does not end")? + 3;
    let new = list[start..end].replace(LISTED[0], LISTED[1]).replace(MODEL, NAME);
    let all = list.replace(&format!("{}];", LISTED[0]), &format!("{}, {}];", LISTED[0], LISTED[1]));
    ensure!(all != list, "`ALL` does not end with {}", LISTED[0]);
    Ok(format!("{}\n/// The new board.\n{new}{}", &all[..end], &all[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The page's first step names the board that is copied here.
    #[test]
    fn the_page_says_what_is_done_here() {
        let page = fs::read_to_string(paths::boards().join("README.md")).unwrap();
        let steps = page.split_once("## A new board").unwrap().1;
        for words in
            [format!("`{MODEL}`"), "`gripper-NAME`".to_owned(), "`../board-list`, and its place in `ALL`".to_owned()]
        {
            assert!(steps.contains(&words), "{words}");
        }
    }

    #[test]
    fn the_new_board_is_one_of_the_list() {
        let text = listed(&fs::read_to_string(paths::root().join("firmware/board-list/src/lib.rs")).unwrap()).unwrap();
        assert!(
            text.contains("pub const TEMPLATE: Board = Board {\n    name: \"template\",")
                && text.contains(", TEMPLATE];")
        );
    }
}
