//! A picture as a list of paths and texts, before it is written as SVG or painted as PNG.
//!
//! Coordinates are in CSS pixels, x to the right, y down.

use super::palette::Ink;

/// One step of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Starts a new outline.
    Move([f64; 2]),
    /// A straight line.
    Line([f64; 2]),
    /// A cubic Bézier curve: two control points and the end.
    Cubic([f64; 2], [f64; 2], [f64; 2]),
    /// Closes the outline.
    Close,
}

/// An outline or line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path(pub Vec<Step>);

/// Distance of a quarter circle's control points, radii.
const QUARTER: f64 = 0.552_284_75;

impl Path {
    /// The path with every point moved.
    pub(super) fn mapped(&self, to: impl Fn([f64; 2]) -> [f64; 2]) -> Self {
        let step = |step: &Step| match *step {
            Step::Move(p) => Step::Move(to(p)),
            Step::Line(p) => Step::Line(to(p)),
            Step::Cubic(a, b, c) => Step::Cubic(to(a), to(b), to(c)),
            Step::Close => Step::Close,
        };
        Self(self.0.iter().map(step).collect())
    }

    /// A polyline.
    pub fn lines(points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let mut path = Self::default();
        for point in points {
            path.0.push(if path.0.is_empty() { Step::Move(point) } else { Step::Line(point) });
        }
        path
    }

    /// A smooth curve through points (Catmull–Rom).
    pub fn smooth(points: &[[f64; 2]]) -> Self {
        let mut path = Self::default();
        path.0.extend(points.first().map(|&p| Step::Move(p)));
        path.extend_smooth(points);
        path
    }

    /// Continues from the first point, where the path stands, through the others.
    pub fn extend_smooth(&mut self, points: &[[f64; 2]]) {
        let Some(last) = points.len().checked_sub(1) else { return };
        for i in 0..last {
            let (before, a, b, after) =
                (points[i.saturating_sub(1)], points[i], points[i + 1], points[(i + 2).min(last)]);
            let first = [a[0] + (b[0] - before[0]) / 6.0, a[1] + (b[1] - before[1]) / 6.0];
            let second = [b[0] - (after[0] - a[0]) / 6.0, b[1] - (after[1] - a[1]) / 6.0];
            self.0.push(Step::Cubic(first, second, b));
        }
    }

    /// A closed polygon.
    pub fn polygon(points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Self::lines(points).closed()
    }

    /// The same, closed.
    pub fn closed(mut self) -> Self {
        self.0.push(Step::Close);
        self
    }

    /// A circle.
    pub fn circle([x, y]: [f64; 2], r: f64) -> Self {
        let k = QUARTER * r;
        Self(vec![
            Step::Move([x + r, y]),
            Step::Cubic([x + r, y + k], [x + k, y + r], [x, y + r]),
            Step::Cubic([x - k, y + r], [x - r, y + k], [x - r, y]),
            Step::Cubic([x - r, y - k], [x - k, y - r], [x, y - r]),
            Step::Cubic([x + k, y - r], [x + r, y - k], [x + r, y]),
            Step::Close,
        ])
    }

    /// Continues from where the path stands along an arc of a circle, angles in rad; the path stands at its beginning.
    pub fn extend_arc(&mut self, [x, y]: [f64; 2], r: f64, from: f64, to: f64) {
        let pieces = ((to - from).abs() / std::f64::consts::FRAC_PI_2).ceil().clamp(1.0, 4.0);
        let step = (to - from) / pieces;
        let k = 4.0 / 3.0 * (0.25 * step).tan() * r;
        for piece in 0..pieces as u32 {
            let (a, b) = (from + step * f64::from(piece), from + step * f64::from(piece + 1));
            let on = |angle: f64, aside: f64| {
                let (sin, cos) = angle.sin_cos();
                [x + r * cos - aside * sin, y + r * sin + aside * cos]
            };
            self.0.push(Step::Cubic(on(a, k), on(b, -k), on(b, 0.0)));
        }
    }

    /// An arc of a circle as a polyline, angles in rad, clockwise on the screen for growing angles.
    pub fn arc([x, y]: [f64; 2], r: f64, from: f64, to: f64) -> Self {
        Self::lines((0..=32).map(|i| {
            let angle = from + (to - from) * f64::from(i) / 32.0;
            [x + r * angle.cos(), y + r * angle.sin()]
        }))
    }

    /// A rectangle.
    pub fn rectangle(Rect { left, top, right, bottom }: Rect) -> Self {
        Self::polygon([[left, top], [right, top], [right, bottom], [left, bottom]])
    }
}

/// A rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// Smallest x.
    pub left: f64,
    /// Smallest y.
    pub top: f64,
    /// Largest x.
    pub right: f64,
    /// Largest y.
    pub bottom: f64,
}

impl Rect {
    /// The rectangle at another place.
    pub fn moved(self, [right, down]: [f64; 2]) -> Self {
        Self { left: self.left + right, top: self.top + down, right: self.right + right, bottom: self.bottom + down }
    }

    /// The smallest rectangle that holds this one and another.
    pub fn with(self, other: Self) -> Self {
        Self {
            left: self.left.min(other.left),
            top: self.top.min(other.top),
            right: self.right.max(other.right),
            bottom: self.bottom.max(other.bottom),
        }
    }

    /// True if all of it lies in another one.
    pub fn within(self, other: Self) -> bool {
        self.left >= other.left && self.top >= other.top && self.right <= other.right && self.bottom <= other.bottom
    }

    /// The corners one after the other, the first again at the end.
    pub fn corners(self) -> Vec<[f64; 2]> {
        let Self { left, top, right, bottom } = self;
        vec![[left, top], [right, top], [right, bottom], [left, bottom], [left, top]]
    }

    /// True if a straight line between two points has a part in it.
    pub fn meets(self, [a, b]: [[f64; 2]; 2]) -> bool {
        // The part of the line, 0 at its beginning and 1 at its end, that lies between the sides, and between top and bottom.
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (axis, [low, high]) in [[self.left, self.right], [self.top, self.bottom]].into_iter().enumerate() {
            let step = b[axis] - a[axis];
            if step == 0.0 {
                if !(low..=high).contains(&a[axis]) {
                    return false;
                }
                continue;
            }
            let ends = [(low - a[axis]) / step, (high - a[axis]) / step];
            from = from.max(ends[0].min(ends[1]));
            to = to.min(ends[0].max(ends[1]));
        }
        from <= to
    }
}

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

    /// Adds a filled area with an outline.
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
