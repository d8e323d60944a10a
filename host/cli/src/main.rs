//! The commands of `fre`, one file each: its arguments and its `run`.

// `println!` panics when its reader has gone: `output::put_out` does not.
#![deny(clippy::print_stdout, clippy::print_stderr)]

#[cfg(feature = "gripper")]
mod agreed;
#[cfg(feature = "gripper")]
mod along;
#[cfg(all(test, feature = "gripper"))]
mod book;
mod calibrate;
#[cfg(feature = "gripper")]
mod commission;
mod compare;
mod completions;
#[cfg(feature = "gripper")]
mod demo;
#[cfg(feature = "gripper")]
mod environment;
mod examples;
mod exit;
mod finger;
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
mod man;
#[cfg(feature = "gripper")]
mod monitor;
mod new;
mod optimise;
mod options;
mod outline;
mod output;
#[cfg(feature = "gripper")]
mod positions;
mod progress;
#[cfg(feature = "gripper")]
mod replay;
#[cfg(test)]
mod requirements;
#[cfg(feature = "gripper")]
mod ros2;
mod schema;
#[cfg(feature = "gripper")]
mod send;
#[cfg(feature = "gripper")]
mod servo;
#[cfg(feature = "gripper")]
mod signals;
#[cfg(feature = "gripper")]
mod sim;
mod solve;
#[cfg(feature = "gripper")]
mod source;
mod standard;
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

use clap::builder::Styles;
use clap::builder::styling::AnsiColor;
use clap::{Arg, Command as Clap, CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

use exit::Volume;
#[cfg(feature = "gripper")]
use with_gripper::Hardware;
#[cfg(not(feature = "gripper"))]
use without_gripper::Hardware;

/// Colours of the help: those of cargo, which the same people see every day.
const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default());

/// Contact force and shape of a Fin-Ray gripper finger, from its motor angle
///
/// A case file describes a finger, an object and the motor's angles. `fre` solves it with a rod model, compares it with finite
/// elements and measurements, fits it to a real finger, and reads the force of a running gripper.
#[derive(Debug, Parser)]
#[command(name = "fre", version, styles = STYLES, max_term_width = 110)]
struct Cli {
    /// Prints results and errors only
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Also prints which files are read and written, and what the model cost
    #[arg(short, long, global = true)]
    verbose: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Calibrate(calibrate::Args),
    Compare(compare::Args),
    Completions(completions::Args),
    Finger(finger::Args),
    Man(man::Args),
    New(new::Args),
    Optimise(optimise::Args),
    Outline(outline::Args),
    Schema(schema::Args),
    Solve(solve::Args),
    Sweep(sweep::Args),
    Table1(table1::Args),
    #[command(flatten)]
    Hardware(Hardware),
}

/// The command line, with examples.
fn command() -> Clap {
    with_negative_numbers(examples::added(Cli::command()))
}

/// Every option takes a negative number for its value, never for an option of its own: what is wrong with it, the value's reader says.
fn with_negative_numbers(command: Clap) -> Clap {
    let takes = |arg: &Arg| !arg.is_positional() && arg.get_action().takes_values();
    let command = command.mut_args(|arg| if takes(&arg) { arg.allow_negative_numbers(true) } else { arg });
    command.mut_subcommands(with_negative_numbers)
}

fn main() -> ExitCode {
    let parsed = command().try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(error) => return exit::arguments(&error),
    };
    match (cli.quiet, cli.verbose) {
        (true, _) => Volume::Quiet.set(),
        (_, true) => Volume::Verbose.set(),
        _ => {}
    }
    match cli.command {
        Command::Calibrate(args) => calibrate::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Completions(args) => completions::run(&args, command()),
        Command::Finger(args) => finger::run(&args),
        Command::Man(args) => man::run(&args, command()),
        Command::New(args) => new::run(&args),
        Command::Optimise(args) => optimise::run(&args),
        Command::Outline(args) => outline::run(&args),
        Command::Schema(args) => schema::run(&args),
        Command::Solve(args) => solve::run(&args),
        Command::Sweep(args) => sweep::run(&args),
        Command::Table1(args) => table1::run(&args),
        Command::Hardware(command) => command.run(),
    }
}
