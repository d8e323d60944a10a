//! The `fre` command.

fn main() -> std::process::ExitCode {
    std::process::ExitCode::SUCCESS
}
