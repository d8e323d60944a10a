//! `cargo run -p book -- FOLDER`: builds the book into a folder.

use std::process::ExitCode;

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1) else {
        eprintln!("usage: cargo run -p book -- FOLDER");
        return ExitCode::FAILURE;
    };
    match std::path::absolute(&folder).map_err(Into::into).and_then(|folder| book::html::build(&folder)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
