//! The book in `docs/` and the pages around it: what they link to, and which code they show.

pub mod block;
pub mod cargo;
pub mod generated;
#[cfg(feature = "html")]
pub mod html;
pub mod link;
pub mod page;
pub mod prose;
pub mod shell;

/// The Rust code of the pages, as doctests.
#[cfg(doctest)]
mod rust {
    #[doc = include_str!("../../../docs/rust.md")]
    struct Page;
}
