//! How a command ends: its exit status, and what it says on standard error.

use std::process::ExitCode;

/// Bad input: the message on standard error says what and where.
pub const BAD_INPUT: u8 = 1;
/// Some angle has no trustworthy solution.
pub const UNTRUSTWORTHY: u8 = 2;

/// Writes a line to standard error. Where nobody reads it any more the line is lost, and the work goes on.
macro_rules! tell {
    ($($words:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($words)*);
    }};
}
pub(crate) use tell;

/// Says on standard error what was wrong with the input.
pub fn bad_input(error: &dyn std::fmt::Display) -> ExitCode {
    tell!("fre: {error}");
    ExitCode::from(BAD_INPUT)
}

/// The status of a command whose results are all trustworthy, or not.
pub fn trusted(all: bool) -> ExitCode {
    if all { ExitCode::SUCCESS } else { ExitCode::from(UNTRUSTWORTHY) }
}
