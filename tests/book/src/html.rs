//! The book as web pages.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use mdbook_driver::MDBook;

use crate::page::root;

/// The page of the derivation in the book, and the one with its formulas as MathML, which browsers show without any script.
const DERIVATION: [&str; 2] = ["derivation.md", "model-core/src/derivation.md"];

/// Builds the book into a folder.
///
/// # Errors
///
/// If a page of the table of contents is missing, or cannot be written.
pub fn build(out: &Path) -> Result<()> {
    let mut book = MDBook::load(root())?;
    book.config.build.build_dir = out.to_path_buf();
    let [page, shown] = DERIVATION;
    let formulas = fs::read_to_string(root().join(shown)).with_context(|| format!("cannot read {shown}"))?;
    book.book.for_each_chapter_mut(|chapter| {
        if chapter.path.as_deref() == Some(Path::new(page)) {
            chapter.content.clone_from(&formulas);
        }
    });
    book.build()
}
