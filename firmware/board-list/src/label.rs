//! What an image's file says of itself: the board it is for, and its version.

/// The section of the file. It is not loaded: it takes no room on the board.
pub const SECTION: &str = ".fre_image";

/// Bytes of a label.
const BYTES: usize = 64;

/// The board's name and the version, each with a zero behind it; then zeros.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Label([u8; BYTES]);

impl Label {
    /// The label of a board's image. Names that are too long do not compile, where it is a constant.
    pub const fn new(board: &str, version: &str) -> Self {
        assert!(board.len() + version.len() + 2 <= BYTES, "board and version do not fit into a label");
        let mut bytes = [0; BYTES];
        let (board, version) = (board.as_bytes(), version.as_bytes());
        let mut place = 0;
        while place < board.len() {
            bytes[place] = board[place];
            place += 1;
        }
        place = 0;
        while place < version.len() {
            bytes[board.len() + 1 + place] = version[place];
            place += 1;
        }
        Self(bytes)
    }

    /// Reads a label: board and version. Nothing if the bytes are not one.
    pub fn read(section: &[u8]) -> Option<(&str, &str)> {
        let mut words = section.split(|byte| *byte == 0);
        let mut word = || core::str::from_utf8(words.next()?).ok().filter(|word| !word.is_empty());
        Some((word()?, word()?)).filter(|_| section.len() == BYTES)
    }

    /// Its bytes, as they are in the file.
    pub const fn bytes(&self) -> &[u8; BYTES] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_is_read_as_it_was_written_and_nothing_else_is_one() {
        let label = Label::new("opencr", "0.2.0");
        assert_eq!(Label::read(label.bytes()), Some(("opencr", "0.2.0")));
        let long = Label::new("a-name-of-thirty-two-letters-and", "a-version-of-thirty-letters-ok");
        assert_eq!(Label::read(long.bytes()).map(|(board, _)| board.len()), Some(32));
        for other in [&[][..], &[0; BYTES], &[0xff; BYTES], &label.bytes()[1..], Label::new("opencr", "").bytes()] {
            assert_eq!(Label::read(other), None, "{other:?}");
        }
    }
}
