//! `fre schema`: the keys of a case file, for editors and for people.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use fre::case::{PICTURES, keys, reference};
use fre::draw::{self, Scene};
use fre::files::FileError;

use crate::exit::bad_input;
use crate::output::{ForceArgs, put_out};
use crate::standard::only_folder;

/// Print the JSON Schema of a case file, by which editors check and complete its keys.
///
/// In an editor with Taplo: `fre schema > case.schema.json`, and `#:schema case.schema.json` in a case's first line.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Writes the page of all keys into a folder instead
    ///
    /// The page is case.md; its pictures are case/*.svg.
    #[arg(long, value_name = "FOLDER", value_parser = only_folder)]
    page: Option<PathBuf>,
    #[command(flatten)]
    force: ForceArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    let done = match &args.page {
        Some(folder) => write_page(folder, args.force).map_err(|error| error.to_string()),
        None => put_out(&format!("{:#}\n", keys::schema())),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => bad_input(&message),
    }
}

fn write_page(folder: &Path, force: ForceArgs) -> Result<(), FileError> {
    let mut files = force.files();
    let pictures: Vec<(String, Scene)> = draw::KEY_PICTURES
        .into_iter()
        .filter_map(|name| Some((format!("{name}.svg"), draw::key_picture(name)?)))
        .collect();
    let names: Vec<&str> = pictures.iter().map(|(name, _)| name.as_str()).collect();
    let mut page = files.folder(folder, &["case.md"], "--page")?;
    let mut beside = files.folder(&folder.join(PICTURES), &names, "--page")?;
    page.write("case.md", reference().as_bytes())?;
    pictures.iter().try_for_each(|(name, scene)| beside.write(name, draw::svg(scene).as_bytes()).map(drop))
}
