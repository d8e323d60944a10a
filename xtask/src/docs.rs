//! `cargo xtask docs`: the parts of the book that the program makes, and the book as web pages.

use crate::command::{headline, run as run_command};
use crate::pc::{FEATURES, cargo};
use crate::{derivation, firmware, paths};
use anyhow::Result;

/// What to do with the pages and pictures that the program makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Compare them with those of the repository.
    Check,
    /// Write them.
    Write,
}

/// The tests that make them: they compare, or write if this variable has the value `write`.
const MAKERS: [&str; 2] = ["book", "messages"];
/// The tests of the links between them.
const LINKS: [&str; 2] = ["links", "built"];
const VARIABLE: &str = "FRE_DOCS";

/// Makes the picture of the live page, `docs/live-page.png`: by the test of the page with two fingers, in Chromium, on the firmware in QEMU.
pub fn page() -> Result<()> {
    let image = firmware::show(firmware::SIMULATED)?;
    headline("the picture of the live page");
    let mut test = cargo("test");
    test.args(["--quiet", "--workspace"]).args(FEATURES).args(["--test", "live_page", "several"]);
    run_command(test.env("FRE_FIRMWARE_ELF", image).env(VARIABLE, "write"))
}

/// Makes or compares the pages and pictures, checks the links, and builds the book in `target/book`.
pub fn run(way: Way) -> Result<()> {
    match way {
        Way::Check => derivation::check()?,
        Way::Write => derivation::write()?,
    }
    headline("pages and pictures that the program makes");
    let tests = |names: [&'static str; 2]| {
        let mut tests = cargo("test");
        tests.args(["--quiet", "--workspace"]).args(FEATURES).env_remove(VARIABLE);
        tests.args(names.iter().flat_map(|name| ["--test", name]));
        tests
    };
    let mut makers = tests(MAKERS);
    if way == Way::Write {
        makers.env(VARIABLE, "write");
    }
    run_command(&mut makers)?;
    headline("links");
    run_command(&mut tests(LINKS))?;
    headline("the book");
    let folder = paths::target().join("book");
    run_command(cargo("run").args(["--quiet", "--package", "book", "--"]).arg(&folder))?;
    println!("{}", folder.join("index.html").display());
    Ok(())
}
