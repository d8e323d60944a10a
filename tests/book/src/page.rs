//! The pages that people read: the book and what is around it.

use std::fs;
use std::path::{Path, PathBuf};

/// The folder of the book's pages, from the repository's root.
pub const BOOK: &str = "docs";
/// The book's table of contents, which is no page of it.
pub const CONTENTS: &str = "docs/SUMMARY.md";

/// A page of Markdown.
#[derive(Clone, Debug)]
pub struct Page {
    /// Path from the repository's root, with slashes.
    pub path: String,
    /// Its Markdown.
    pub text: String,
}

impl Page {
    /// Whether the page belongs to the book, so that it is built into `docs/`'s web pages.
    pub fn is_of_book(&self) -> bool {
        self.path.starts_with("docs/")
    }

    /// The folder that its links start from.
    pub fn folder(&self) -> PathBuf {
        Path::new(&self.path).parent().map(Path::to_path_buf).unwrap_or_default()
    }

    /// Line of a byte of the text, from 1.
    pub fn line(&self, at: usize) -> usize {
        1 + self.text[..at].matches('\n').count()
    }
}

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// What `cargo xtask docs` makes for rustdoc of the book's page: not for people to read as it is.
const FOR_RUSTDOC: &str = "model-core/src/derivation.md";

/// Every page of Markdown in the repository, sorted by its path. What git does not keep is left out.
///
/// # Panics
///
/// If a folder or a page cannot be read.
pub fn all() -> Vec<Page> {
    let (root, mut folders, mut pages) = (root(), vec![PathBuf::new()], Vec::new());
    while let Some(folder) = folders.pop() {
        let entries =
            root.join(&folder).read_dir().unwrap_or_else(|error| panic!("cannot list {}: {error}", folder.display()));
        for entry in entries.flatten() {
            let name = entry.file_name().into_string().expect("a name in UTF-8");
            let path = folder.join(&name);
            if entry.path().is_dir() {
                if !name.starts_with('.') && !["target", "node_modules", "__pycache__"].contains(&name.as_str()) {
                    folders.push(path);
                }
            } else if name.ends_with(".md") {
                let text = fs::read_to_string(entry.path())
                    .unwrap_or_else(|error| panic!("cannot read {}: {error}", path.display()));
                pages.push(Page { path: path.to_str().expect("a path in UTF-8").replace('\\', "/"), text });
            }
        }
    }
    pages.retain(|page| page.path != FOR_RUSTDOC);
    pages.sort_by(|a, b| a.path.cmp(&b.path));
    pages
}

/// The pages of the book, without its table of contents.
pub fn book() -> Vec<Page> {
    all().into_iter().filter(|page| page.is_of_book() && page.path != CONTENTS).collect()
}
