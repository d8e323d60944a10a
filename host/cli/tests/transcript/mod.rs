//! What commands answer, kept to be compared as a whole.

use std::path::Path;

/// Commands as typed, each followed by its words and, unless it went well, its exit status.
#[derive(Default)]
pub struct Transcript(String);

impl Transcript {
    /// Adds a command. Of paths in its folder only the names stay.
    pub fn add(&mut self, command: &str, folder: &Path, (code, words): (Option<i32>, &str)) {
        let folder = format!("{}/", folder.display());
        let words = format!("$ {command}\n{}\n", words.trim_end()).replace(&folder, "");
        self.0 += &words;
        if code != Some(0) {
            self.0 += &format!("? {}\n", code.map_or_else(|| "no status".to_owned(), |code| code.to_string()));
        }
        self.0.push('\n');
    }

    /// The whole text.
    pub fn text(&self) -> &str {
        self.0.trim_end()
    }
}
