//! The commands of `fre`, one file each: its arguments and its `run`.

/// Tells a person something on standard error. Where nobody listens any more nothing is told, and the work goes on.
macro_rules! tell {
    ($($words:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($words)*);
    }};
}

mod calibrate;
mod compare;
mod demo;
mod flash;
mod gripper;
mod identify;
mod keep;
mod log;
mod monitor;
mod options;
mod outline;
mod replay;
mod servo;
mod solve;
mod source;
mod sweep;
mod table1;
mod view;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Bad input: the message on standard error says what and where.
pub const BAD_INPUT: u8 = 1;
/// Some angle has no trustworthy solution.
pub const UNTRUSTWORTHY: u8 = 2;

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
    Demo(demo::Args),
    Gripper(gripper::Args),
    Flash(flash::Args),
    Log(log::Args),
    Monitor(monitor::Args),
    Replay(replay::Args),
    Outline(outline::Args),
    Servo(servo::Args),
    Solve(solve::Args),
    Sweep(sweep::Args),
    Table1(table1::Args),
}

/// Reads the command line and runs the command.
pub fn run() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are no errors; everything else is bad input.
            let code = if error.use_stderr() { ExitCode::from(BAD_INPUT) } else { ExitCode::SUCCESS };
            let _ = error.print();
            return code;
        }
    };
    match cli.command {
        Command::Calibrate(args) => calibrate::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Demo(args) => demo::run(args),
        Command::Gripper(args) => gripper::run(&args),
        Command::Flash(args) => flash::run(&args),
        Command::Log(args) => log::run(&args),
        Command::Monitor(args) => monitor::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Outline(args) => outline::run(&args),
        Command::Servo(args) => servo::run(&args),
        Command::Solve(args) => solve::run(&args),
        Command::Sweep(args) => sweep::run(&args),
        Command::Table1(args) => table1::run(&args),
    }
}

/// Says on standard error what was wrong with the input.
fn bad_input(error: &dyn std::fmt::Display) -> ExitCode {
    tell!("fre: {error}");
    ExitCode::from(BAD_INPUT)
}

/// Writes a result to standard output. A reader that stops early (`fre … | head`) is no failure; a full disk is.
fn put_out(text: &str) -> Result<(), String> {
    use std::io::{ErrorKind, Write as _};
    let mut out = std::io::stdout();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(format!("standard output: {error}")),
        _ => Ok(()),
    }
}
