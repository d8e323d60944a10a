//! `fre man`: the manual pages, made of the same words as the help.

use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Command;
use clap_mangen::Man;

use crate::exit::bad_input;
use crate::output::ForceArgs;
use crate::standard::{only_folder, put_out};

/// Write the manual pages: fre.1 and one for each command
///
/// Without a folder the page of `fre` itself goes to standard output.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Writes all pages into a folder, such as ~/.local/share/man/man1
    #[arg(short, long, value_name = "FOLDER", value_parser = only_folder)]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: ForceArgs,
}

/// Writes the pages of a command and all below it, or prints its own.
pub fn run(args: &Args, mut command: Command) -> ExitCode {
    command.build();
    let done = match &args.out {
        Some(folder) => write(&command, folder, args.force),
        None => page(&command).map_err(|error| error.to_string()).and_then(|text| put_out(&text)),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => bad_input(&error),
    }
}

/// Writes the pages of a command and all below it.
fn write(command: &Command, folder: &Path, force: ForceArgs) -> Result<(), String> {
    let mut pages = Vec::new();
    add(command, &mut pages).map_err(|error| error.to_string())?;
    let names: Vec<&str> = pages.iter().map(|(name, _)| name.as_str()).collect();
    let mut out = force.files().folder(folder, &names, "--out").map_err(|error| error.to_string())?;
    for (name, text) in &pages {
        out.write(name, text).map_err(|error| error.to_string())?;
    }
    Ok(())
}

fn add(command: &Command, pages: &mut Vec<(String, Vec<u8>)>) -> io::Result<()> {
    // A page is called by its words joined, as those of `git` are: fre-sweep-merge.1.
    pages.push((Man::new(command.clone()).get_filename(), page(command)?));
    for below in command.get_subcommands().filter(|below| below.get_name() != "help" && !below.is_hide_set()) {
        add(below, pages)?;
    }
    Ok(())
}

fn page(command: &Command) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    Man::new(command.clone()).render(&mut text)?;
    Ok(text)
}
