//! `fre table1`: the twenty cases of *Geometrico-Static Modelling of a FRE Finger*, the paper.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;

use crate::exit::{bad_input, tell, trusted};
use crate::output::{ForceArgs, put_out};
use crate::progress::ProgressLine;
use crate::standard::only_folder;
use fre::study::run::Run;
use fre::study::table1;

/// Solve the paper's twenty cases with both physics, and compare the models
///
/// They are those of Table 1 in "Geometrico-Static Modelling of a FRE Finger", each at full and at reduced resolution.
///
/// Prints the tables as Markdown; with --out also writes report.html (one page with pictures), table1.md, table1.csv,
/// errors.svg and errors.png. The finger is the preset dhas-80, an approximation; the paper prints no object positions: they
/// are chosen so that first contact is 6° before the first angle. Exit status: 0 all converged; 1 bad input; 2 some case
/// without a trustworthy solution.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for report, table and data
    #[arg(short, long, value_name = "DIR", value_parser = only_folder)]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: ForceArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    let folder =
        args.out.as_deref().map(|folder| args.force.files().folder(folder, &table1::FILES, "--out")).transpose();
    let mut folder = match folder {
        Ok(folder) => folder,
        Err(error) => return bad_input(&error),
    };
    let mut line = ProgressLine::new(false);
    let solved = table1::solve_watched(|progress| {
        let table1::Progress { done, total, series, variant } = progress;
        line.show(false, || format!("solving: path {} of {total}, {} by {}", done + 1, series.name(0), variant.name));
        ControlFlow::Continue(())
    });
    line.wipe();
    let rows = match solved {
        Ok(rows) => rows,
        Err(error) => return bad_input(&error),
    };
    if let Err(error) = put_out(&table1::markdown(&rows)) {
        return bad_input(&error);
    }
    if let Some(folder) = &mut folder {
        match table1::write(folder, &rows) {
            Ok(files) => files.iter().for_each(|file| tell!("fre: {}", file.display())),
            Err(error) => return bad_input(&error),
        }
    }
    trusted(rows.iter().flat_map(|row| &row.runs).all(Run::is_trustworthy))
}
