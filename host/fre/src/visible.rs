//! Pieces of files in messages: on one line, with every letter to be seen.

/// A text whose control characters, and blanks other than the usual one, are escaped.
pub fn visible(text: &str) -> String {
    let hidden = |letter: char| letter.is_control() || (letter.is_whitespace() && letter != ' ');
    let letter = |letter: char| if hidden(letter) { letter.escape_default().to_string() } else { letter.into() };
    text.chars().map(letter).collect()
}

/// The same of at most so many letters, with an ellipsis for the rest.
pub fn shortened(text: &str, longest: usize) -> String {
    match text.char_indices().nth(longest) {
        Some((end, _)) => visible(&text[..end]) + "…",
        None => visible(text),
    }
}

#[cfg(test)]
mod tests {
    use super::shortened;

    #[test]
    fn what_no_editor_shows_is_escaped() {
        assert_eq!(shortened("a\tb\u{a0}c\u{7}", 9), "a\\tb\\u{a0}c\\u{7}");
        assert_eq!((shortened("äöü", 3), shortened("äöüß", 3)), ("äöü".to_owned(), "äöü…".to_owned()));
    }
}
