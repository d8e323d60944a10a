//! A picture as a list of paths and texts, before it is written as SVG or painted as PNG.
//!
//! Coordinates are in CSS pixels, x to the right, y down.

use super::palette::Ink;
use super::path::{Path, Rect};

/// How an area is filled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fill {
    /// Colour.
    pub ink: Ink,
    /// 0 to 1.
    pub opacity: f64,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Colour.
    pub ink: Ink,
    /// Width, px.
    pub width: f64,
    /// Lengths of dash and gap, px.
    pub dash: Option<[f64; 2]>,
    /// True for round ends and corners, false for butt ends.
    pub round: bool,
}

impl Stroke {
    /// A solid line with butt ends.
    pub fn new(ink: Ink, width: f64) -> Self {
        Self { ink, width, dash: None, round: false }
    }

    /// The same with round ends and corners.
    pub fn round(self) -> Self {
        Self { round: true, ..self }
    }

    /// The same, dashed.
    pub fn dashed(self, dash: f64, gap: f64) -> Self {
        Self { dash: Some([dash, gap]), ..self }
    }
}

/// Which point of a text its position is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Its left end.
    Start,
    /// Its middle.
    Middle,
    /// Its right end.
    End,
}

/// A text that is shown as it is: no letter of it is a mark. Line breaks and tabs are blanks.
pub fn literal(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        if matches!(letter, '*' | '_' | '}' | '\\') {
            out.push('\\');
        }
        out.push(if letter.is_control() { ' ' } else { letter });
    }
    out
}

/// A line of text. `*…*` is italic, `_{…}` a subscript; a letter after a backslash is itself ([`literal`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    /// Position of the anchor on the base line.
    pub at: [f64; 2],
    /// The words with their marks.
    pub words: String,
    /// Size, px.
    pub size: f64,
    /// Colour.
    pub ink: Ink,
    /// Anchor.
    pub anchor: Anchor,
    /// Bold.
    pub bold: bool,
    /// Quarter turn to the left (for the title of a vertical axis).
    pub upright: bool,
    /// Width of a rim in the background's colour, px; 0 for none.
    pub halo: f64,
}

impl Text {
    /// Plain text in the main colour, anchored at its left end.
    pub fn new(at: [f64; 2], size: f64, words: impl Into<String>) -> Self {
        Self {
            at,
            words: words.into(),
            size,
            ink: Ink::Main,
            anchor: Anchor::Start,
            bold: false,
            upright: false,
            halo: 0.0,
        }
    }

    /// The same in another colour.
    pub fn ink(self, ink: Ink) -> Self {
        Self { ink, ..self }
    }

    /// The same with another anchor.
    pub fn anchor(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    /// The same in bold.
    pub fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// The same with a rim in the background's colour.
    pub fn halo(self) -> Self {
        Self { halo: 3.5, ..self }
    }

    /// The pieces of the text with their styles.
    pub fn pieces(&self) -> Vec<Piece> {
        let mut pieces = Vec::new();
        let mut piece = Piece::default();
        let mut letters = self.words.chars().peekable();
        let finish = |piece: &mut Piece, pieces: &mut Vec<Piece>, next: Piece| {
            let done = std::mem::replace(piece, next);
            if !done.words.is_empty() {
                pieces.push(done);
            }
        };
        while let Some(letter) = letters.next() {
            let Piece { italic, subscript, .. } = piece;
            match letter {
                '\\' => piece.words.extend(letters.next()),
                '*' => finish(&mut piece, &mut pieces, Piece { italic: !italic, subscript, ..Piece::default() }),
                '_' if letters.peek() == Some(&'{') => {
                    letters.next();
                    finish(&mut piece, &mut pieces, Piece { italic, subscript: true, ..Piece::default() });
                }
                '}' if subscript => {
                    finish(&mut piece, &mut pieces, Piece { italic, subscript: false, ..Piece::default() });
                }
                other => piece.words.push(other),
            }
        }
        finish(&mut piece, &mut pieces, Piece::default());
        pieces
    }
}

/// Parts one after the other, each ended with a stop before the next; empty ones are left out.
pub(super) fn sentences<'t>(parts: impl IntoIterator<Item = &'t str>) -> String {
    let mut out = String::new();
    for part in parts.into_iter().filter(|part| !part.is_empty()) {
        if !out.is_empty() {
            out.push_str(if out.ends_with('.') { " " } else { ". " });
        }
        out.push_str(part);
    }
    out
}

/// A piece of text in one style.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    /// The words.
    pub words: String,
    /// Italic.
    pub italic: bool,
    /// Smaller and lower.
    pub subscript: bool,
}

/// Size of a subscript relative to its text.
pub const SUBSCRIPT_SIZE: f64 = 0.72;
/// How far a subscript lies below the base line, relative to the text's size.
pub const SUBSCRIPT_DROP: f64 = 0.22;

/// A thing in a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A path, filled, drawn or both.
    Path(Path, Option<Fill>, Option<Stroke>),
    /// A text.
    Text(Text),
    /// What follows is only visible inside.
    Clip(Rect),
    /// What follows is visible everywhere.
    Unclip,
}

/// A picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Width, px.
    pub width: f64,
    /// Height, px.
    pub height: f64,
    /// What it shows, for readers who cannot see it.
    pub description: String,
    /// The things in it, the lowest first.
    pub items: Vec<Item>,
}

impl Scene {
    /// An empty picture.
    pub fn new(width: f64, height: f64, description: impl Into<String>) -> Self {
        Self { width, height, description: description.into(), items: Vec::new() }
    }

    /// This picture with another one below it.
    pub fn above(mut self, other: &Self) -> Self {
        let down = self.height;
        self.width = self.width.max(other.width);
        self.height += other.height;
        self.take(other, [0.0, down]);
        self
    }

    /// This picture with another one to the right of it.
    pub fn beside(mut self, other: &Self) -> Self {
        let right = self.width;
        self.width += other.width;
        self.height = self.height.max(other.height);
        self.take(other, [right, 0.0]);
        self
    }

    /// Adds all of another picture, moved.
    fn take(&mut self, other: &Self, by: [f64; 2]) {
        let shift = |[x, y]: [f64; 2]| [x + by[0], y + by[1]];
        self.description = sentences([self.description.as_str(), &other.description]);
        self.items.extend(other.items.iter().cloned().map(|item| match item {
            Item::Path(path, fill, stroke) => Item::Path(path.mapped(shift), fill, stroke),
            Item::Text(text) => Item::Text(Text { at: shift(text.at), ..text }),
            Item::Clip(r) => Item::Clip(Rect {
                left: r.left + by[0],
                right: r.right + by[0],
                top: r.top + by[1],
                bottom: r.bottom + by[1],
            }),
            Item::Unclip => Item::Unclip,
        }));
    }

    /// Adds a filled area.
    pub fn fill(&mut self, path: Path, ink: Ink, opacity: f64) {
        self.items.push(Item::Path(path, Some(Fill { ink, opacity }), None));
    }

    /// Adds a line.
    pub fn line(&mut self, path: Path, stroke: Stroke) {
        self.items.push(Item::Path(path, None, Some(stroke)));
    }

    /// Adds a filled area with an edge.
    pub fn area(&mut self, path: Path, ink: Ink, opacity: f64, stroke: Stroke) {
        self.items.push(Item::Path(path, Some(Fill { ink, opacity }), Some(stroke)));
    }

    /// Adds a text.
    pub fn text(&mut self, text: Text) {
        self.items.push(Item::Text(text));
    }

    /// Adds an arrow with a filled head.
    pub fn arrow(&mut self, from: [f64; 2], to: [f64; 2], ink: Ink, width: f64) {
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        if length < 0.1 {
            return;
        }
        let along = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
        let across = [-along[1], along[0]];
        let head = (4.5 * width).min(0.6 * length);
        let half = 0.36 * head;
        let neck = [to[0] - 0.85 * head * along[0], to[1] - 0.85 * head * along[1]];
        let wing = |side: f64| {
            let back = [to[0] - head * along[0], to[1] - head * along[1]];
            [back[0] + side * half * across[0], back[1] + side * half * across[1]]
        };
        self.line(Path::lines([from, neck]), Stroke::new(ink, width));
        self.fill(Path::polygon([to, wing(1.0), neck, wing(-1.0)]), ink, 1.0);
    }
}

/// Unit vector along a vector; zero for a vector without length.
pub(crate) fn unit([x, y]: [f64; 2]) -> [f64; 2] {
    let length = x.hypot(y);
    if length > 0.0 { [x / length, y / length] } else { [0.0, 0.0] }
}
