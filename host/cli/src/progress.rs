//! A line on standard error that says how far a long work is.

use std::io::{IsTerminal as _, Write as _};
use std::time::{Duration, Instant};

use crate::exit::Volume;

/// How often a terminal's line changes.
const TERMINAL: Duration = Duration::from_millis(100);
/// How often a line is added elsewhere.
const LINES: Duration = Duration::from_secs(1);

/// The line. It comes when a work takes a while, changes in place in a terminal, and is wiped away at the end.
pub struct ProgressLine {
    shown: bool,
    terminal: bool,
    drawn: bool,
    last: Instant,
}

impl ProgressLine {
    /// Shown in a terminal; `asked` for, it is shown elsewhere too, as lines.
    pub fn new(asked: bool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let shown = (terminal || asked) && Volume::Usual.is_on();
        Self { shown, terminal, drawn: false, last: Instant::now() }
    }

    /// Says how far it is, if it is time to; `now`: even if it is not.
    pub fn show(&mut self, now: bool, words: impl FnOnce() -> String) {
        let due = if self.terminal { TERMINAL } else { LINES };
        if !self.shown || (!now && self.last.elapsed() < due) {
            return;
        }
        self.last = Instant::now();
        self.drawn = true;
        let (start, end) = if self.terminal { ("\r", "\u{1b}[K") } else { ("", "\n") };
        // Where nobody reads it any more, the work goes on.
        let _ = write!(std::io::stderr(), "{start}{}{end}", words());
        let _ = std::io::stderr().flush();
    }

    /// Ends the line where it is, so that what comes next begins below it.
    pub fn keep(&mut self) {
        if std::mem::take(&mut self.drawn) && self.terminal {
            let _ = writeln!(std::io::stderr());
        }
    }

    /// Wipes it away, so that what comes next takes its place.
    pub fn wipe(&mut self) {
        if std::mem::take(&mut self.drawn) && self.terminal {
            let _ = write!(std::io::stderr(), "\r\u{1b}[K");
        }
    }
}
