//! Asking the person at the terminal.

use std::io::{BufRead, IsTerminal, Write};

/// Asks a person; without a terminal, `flag` is how a script agrees.
///
/// # Errors
/// There is nobody to ask.
pub fn agreed(question: &str, flag: &str) -> Result<bool, String> {
    let input = std::io::stdin();
    if !input.is_terminal() {
        return Err(format!("{question}\nstandard input cannot answer: confirm with {flag}"));
    }
    let ask = || {
        let mut error = std::io::stderr().lock();
        write!(error, "{question}\nGo on? (yes/no) ")?;
        error.flush()?;
        let mut answer = String::new();
        input.lock().read_line(&mut answer)?;
        Ok(matches!(answer.trim(), "y" | "yes"))
    };
    ask().map_err(|error: std::io::Error| error.to_string())
}
