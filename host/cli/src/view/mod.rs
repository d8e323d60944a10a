//! How a command shows a source: live in the terminal, as lines of text, or on a page.

mod address;
mod args;
mod lines;
mod page;
mod stop;
mod terminal;

pub use address::page_address;
pub use args::ViewArgs;
pub use stop::Stop;
