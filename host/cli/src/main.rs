//! The commands of `fre`, one file each: its arguments and its `run`.

// `println!` panics when its reader has gone: `output::put_out` does not.
#![deny(clippy::print_stdout, clippy::print_stderr)]

#[cfg(all(test, feature = "gripper"))]
mod book;
mod calibrate;
mod compare;
#[cfg(feature = "gripper")]
mod demo;
mod exit;
#[cfg(feature = "gripper")]
mod flash;
#[cfg(feature = "gripper")]
mod gripper;
#[cfg(feature = "gripper")]
mod identify;
#[cfg(feature = "gripper")]
mod keep;
#[cfg(feature = "gripper")]
mod log;
#[cfg(feature = "gripper")]
mod monitor;
mod new;
mod options;
mod outline;
mod output;
#[cfg(feature = "gripper")]
mod replay;
mod schema;
#[cfg(feature = "gripper")]
mod send;
#[cfg(feature = "gripper")]
mod servo;
mod solve;
#[cfg(feature = "gripper")]
mod source;
mod sweep;
mod table1;
#[cfg(feature = "gripper")]
mod view;
#[cfg(feature = "gripper")]
mod with_gripper;
#[cfg(not(feature = "gripper"))]
mod without_gripper;
#[cfg(not(feature = "gripper"))]
use without_gripper as send;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[cfg(feature = "gripper")]
use with_gripper::Hardware;
#[cfg(not(feature = "gripper"))]
use without_gripper::Hardware;

/// Contact force and shape of a Fin-Ray finger from its motor angle.
#[derive(Debug, Parser)]
#[command(name = "fre", version, about)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Calibrate(calibrate::Args),
    Compare(compare::Args),
    New(new::Args),
    Outline(outline::Args),
    Schema(schema::Args),
    Solve(solve::Args),
    Sweep(sweep::Args),
    Table1(table1::Args),
    #[command(flatten)]
    Hardware(Hardware),
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are no errors; everything else is bad input.
            let code = if error.use_stderr() { ExitCode::from(exit::BAD_INPUT) } else { ExitCode::SUCCESS };
            let _ = error.print();
            return code;
        }
    };
    match cli.command {
        Command::Calibrate(args) => calibrate::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::New(args) => new::run(&args),
        Command::Outline(args) => outline::run(&args),
        Command::Schema(args) => schema::run(&args),
        Command::Solve(args) => solve::run(&args),
        Command::Sweep(args) => sweep::run(&args),
        Command::Table1(args) => table1::run(&args),
        Command::Hardware(command) => command.run(),
    }
}
