//! Widths and paths of letters, from fonts inside the program: pictures need no font of the system.

use kurbo::Point;
use ttf_parser::{Face, OutlineBuilder};

use super::path::Path;
use super::scene::{Anchor, SUBSCRIPT_DROP, SUBSCRIPT_SIZE, Text};

/// The faces that pictures use.
pub(crate) struct Fonts {
    regular: Option<Face<'static>>,
    italic: Option<Face<'static>>,
    bold: Option<Face<'static>>,
}

impl Fonts {
    /// Opens the fonts inside the program.
    pub(crate) fn new() -> Self {
        let face = |bytes: &'static [u8]| Face::parse(bytes, 0).ok();
        Self {
            regular: face(include_bytes!("../../fonts/NotoSans-Regular.ttf")),
            italic: face(include_bytes!("../../fonts/NotoSans-Italic.ttf")),
            bold: face(include_bytes!("../../fonts/NotoSans-Bold.ttf")),
        }
    }

    fn face(&self, bold: bool, italic: bool) -> Option<&Face<'static>> {
        match (bold, italic) {
            (_, true) => self.italic.as_ref(),
            (true, false) => self.bold.as_ref(),
            (false, false) => self.regular.as_ref(),
        }
    }

    /// The letters of a text, placed before any turn of it, for documents that hold each letter's path once.
    pub(crate) fn glyphs(&self, text: &Text) -> Vec<Glyph> {
        let start = self.start(text);
        let mut glyphs = Vec::new();
        self.letters(text, |face, id, size, [x, y]| {
            let style = [&self.regular, &self.italic, &self.bold]
                .into_iter()
                .position(|one| one.as_ref().is_some_and(|one| std::ptr::eq(one, face)));
            let scale = size / f64::from(face.units_per_em());
            let at = [text.at[0] + start + x, text.at[1] + y];
            glyphs.push(Glyph { style: style.unwrap_or(0), id: id.0, scale, at });
        });
        glyphs
    }

    /// Shape of a letter in the font's units, y down; empty for a blank.
    pub(crate) fn glyph_path(&self, glyph: &Glyph) -> Path {
        let mut path = Path::default();
        let face = [&self.regular, &self.italic, &self.bold].get(glyph.style).and_then(|face| face.as_ref());
        if let Some(face) = face {
            let mut pen = Pen { path: &mut path, scale: 1.0, offset: [0.0; 2], at: [0.0; 2], upright: false };
            face.outline_glyph(ttf_parser::GlyphId(glyph.id), &mut pen);
        }
        path
    }

    /// Offset of a text's left end from its position, px.
    fn start(&self, text: &Text) -> f64 {
        match text.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -0.5 * self.width(text),
            Anchor::End => -self.width(text),
        }
    }

    /// Calls `place` for every letter with its face, glyph, size (px) and offset from the text's left end (px).
    fn letters<'f>(
        &'f self,
        text: &Text,
        mut place: impl FnMut(&'f Face<'static>, ttf_parser::GlyphId, f64, [f64; 2]),
    ) -> f64 {
        let mut x = 0.0;
        for piece in text.pieces() {
            let Some(face) = self.face(text.bold, piece.italic) else { continue };
            let size = if piece.subscript { SUBSCRIPT_SIZE * text.size } else { text.size };
            let drop = if piece.subscript { SUBSCRIPT_DROP * text.size } else { 0.0 };
            let scale = size / f64::from(face.units_per_em());
            for letter in piece.words.chars() {
                let found = face.glyph_index(letter).or_else(|| face.glyph_index(nearest(letter)?));
                // A letter that the font lacks shows as its empty box, never as nothing.
                let glyph = found.unwrap_or(ttf_parser::GlyphId(0));
                place(face, glyph, size, [x, drop]);
                x += scale * f64::from(face.glyph_hor_advance(glyph).unwrap_or(0));
            }
        }
        x
    }

    /// Width of a text, px.
    pub(crate) fn width(&self, text: &Text) -> f64 {
        self.letters(text, |_, _, _, _| {})
    }

    /// Shapes of the letters of a text, placed in the picture.
    pub(crate) fn path(&self, text: &Text) -> Path {
        let start = self.start(text);
        let mut path = Path::default();
        self.letters(text, |face, glyph, size, [x, y]| {
            let mut pen = Pen {
                path: &mut path,
                scale: size / f64::from(face.units_per_em()),
                offset: [start + x, y],
                at: text.at,
                upright: text.upright,
            };
            face.outline_glyph(glyph, &mut pen);
        });
        path
    }
}

/// A letter of the fonts that looks like one which they lack. Debian's Noto Sans has the mathematical signs in a font of their own.
fn nearest(letter: char) -> Option<char> {
    (letter == '−').then_some('–')
}

/// A letter of a text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Glyph {
    /// Regular, italic, bold.
    pub(crate) style: usize,
    /// Number in its font.
    pub(crate) id: u16,
    /// Pixels per unit of the font.
    pub(crate) scale: f64,
    /// Where its origin lies before the text's turn, px.
    pub(crate) at: [f64; 2],
}

/// Writes a glyph into a path.
struct Pen<'p> {
    path: &'p mut Path,
    scale: f64,
    offset: [f64; 2],
    at: [f64; 2],
    upright: bool,
}

impl Pen<'_> {
    fn point(&self, x: f32, y: f32) -> Point {
        let (x, y) = (self.offset[0] + self.scale * f64::from(x), self.offset[1] - self.scale * f64::from(y));
        let [x, y] = if self.upright { [y, -x] } else { [x, y] };
        Point::new(self.at[0] + x, self.at[1] + y)
    }
}

impl OutlineBuilder for Pen<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        let to = self.point(x, y);
        self.path.0.move_to(to);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let to = self.point(x, y);
        self.path.0.line_to(to);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (control, to) = (self.point(x1, y1), self.point(x, y));
        self.path.0.quad_to(control, to);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let (first, second, to) = (self.point(x1, y1), self.point(x2, y2), self.point(x, y));
        self.path.0.curve_to(first, second, to);
    }

    fn close(&mut self) {
        self.path.0.close_path();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sign_of_the_pictures_own_words_has_a_shape() {
        let fonts = Fonts::new();
        for words in ["−0123456789.e", "°×Ø·–…±²³µ", "*ασφλθΔ*", "ÄÖÜäöüßéè"] {
            for bold in [false, true] {
                let mut text = Text::new([0.0; 2], 13.0, words.to_owned());
                text.bold = bold;
                let glyphs = fonts.glyphs(&text);
                assert_eq!(glyphs.len(), words.replace('*', "").chars().count());
                assert!(glyphs.iter().all(|glyph| glyph.id != 0), "{words}: {glyphs:?}");
            }
        }
    }
}
