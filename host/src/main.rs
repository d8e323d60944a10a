//! The `fre` command.

fn main() -> std::process::ExitCode {
    host::cli::run()
}
