//! The link to the host: one task writes, one answers.

mod answer;
mod send;
mod wire;

pub use answer::answer;
pub use send::send;
