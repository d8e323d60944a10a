//! How a source is shown: the options, and what they choose.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use super::address::page_address;
use super::stop::Stop;
use super::{lines, page, terminal};
use fre_gripper::source::Source;

/// How a source is shown.
#[derive(Debug, clap::Args)]
pub struct ViewArgs {
    /// Prints lines even in a terminal
    #[arg(long, conflicts_with = "web")]
    lines: bool,
    /// Prints every N-th report only
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,
    /// Serves a live page instead, and prints its address
    ///
    /// Needs a build with `--features web`, which is on by default.
    #[arg(long)]
    web: bool,
    /// Address of the page
    ///
    /// Without a port it is 7878. If other machines can reach it, the page needs the token that is printed with it.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:7878", requires = "web", conflicts_with = "lines", value_parser = page_address)]
    listen: SocketAddr,
    /// Opens the page in a browser
    #[arg(long, requires = "web", conflicts_with = "lines")]
    open: bool,
}

impl ViewArgs {
    /// Whether a person watches, in the terminal or in a browser: lines end with their source.
    pub fn is_live(&self) -> bool {
        self.web || (!self.lines && terminal::is_possible())
    }

    /// Shows it until the time is over, somebody stops it, or nothing more comes.
    ///
    /// # Errors
    /// A source that does not answer, or an output that cannot be written.
    pub fn show(&self, source: &Arc<dyn Source>, length: Option<Duration>, stop: &AtomicBool) -> Result<(), Stop> {
        if self.web {
            return page::serve(source, self.listen, self.open, length, stop);
        }
        #[cfg(feature = "terminal")]
        if self.is_live() {
            return terminal::show(source, length, stop);
        }
        #[cfg(not(feature = "terminal"))]
        if !self.lines {
            terminal::hint();
        }
        lines::show(source, length, self.every, stop)
    }
}
