//! Colours by role, each with a light and a dark value, distinguishable with the common forms of colour blindness
//! (series after Okabe and Ito).

/// A colour's role in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// The background.
    Paper,
    /// Axes, titles, edges.
    Main,
    /// Secondary text and ticks.
    Muted,
    /// Grid lines and faint areas.
    Faint,
    /// The undeformed finger.
    Ghost,
    /// The object's area.
    Object,
    /// The object's contour.
    ObjectEdge,
    /// The front beam.
    Front,
    /// The back beam.
    Back,
    /// The lamellae and hinges.
    Lamella,
    /// Forces.
    Force,
    /// The n-th series of a chart, from 0; repeats after seven.
    Series(u8),
}

/// Red, green, blue.
pub type Rgb = [u8; 3];

const SERIES: [(Rgb, Rgb); 7] = [
    ([0x00, 0x72, 0xb2], [0x5a, 0xb4, 0xf0]),
    ([0xd5, 0x5e, 0x00], [0xff, 0x8f, 0x4a]),
    ([0x00, 0x8c, 0x68], [0x3f, 0xcf, 0xa5]),
    ([0xb0, 0x50, 0x86], [0xe6, 0x9a, 0xc6]),
    ([0xc4, 0x85, 0x00], [0xf2, 0xbd, 0x4a]),
    ([0x2f, 0x9b, 0xd0], [0x93, 0xd6, 0xf7]),
    ([0x55, 0x5b, 0x63], [0xb4, 0xbc, 0xc6]),
];

impl Ink {
    /// Every ink, for style sheets.
    pub fn all() -> impl Iterator<Item = Self> {
        use Ink::{Back, Faint, Force, Front, Ghost, Lamella, Main, Muted, Object, ObjectEdge, Paper, Series};
        [Paper, Main, Muted, Faint, Ghost, Object, ObjectEdge, Front, Back, Lamella, Force]
            .into_iter()
            .chain((0..SERIES.len() as u8).map(Series))
    }

    /// Colour on white and colour in dark mode.
    pub fn colours(self) -> (Rgb, Rgb) {
        match self {
            Self::Paper => ([0xff, 0xff, 0xff], [0x0f, 0x14, 0x19]),
            Self::Main => ([0x1b, 0x1f, 0x24], [0xe6, 0xea, 0xee]),
            Self::Muted => ([0x5b, 0x63, 0x6c], [0x9a, 0xa4, 0xae]),
            Self::Faint => ([0xe3, 0xe6, 0xe9], [0x2a, 0x31, 0x38]),
            Self::Ghost => ([0x9a, 0xa3, 0xac], [0x6a, 0x74, 0x7e]),
            Self::Object => ([0xee, 0xf0, 0xf2], [0x1d, 0x24, 0x2b]),
            Self::ObjectEdge => ([0x7d, 0x86, 0x90], [0x8b, 0x95, 0x9f]),
            Self::Front => ([0x00, 0x72, 0xb2], [0x5a, 0xb4, 0xf0]),
            Self::Back => ([0x35, 0x4f, 0x66], [0x8f, 0xae, 0xc8]),
            Self::Lamella => ([0xb3, 0xc1, 0xcd], [0x5c, 0x6d, 0x7c]),
            Self::Force => ([0xd5, 0x3e, 0x00], [0xff, 0x83, 0x4a]),
            Self::Series(n) => SERIES[usize::from(n) % SERIES.len()],
        }
    }

    /// Name in a style sheet.
    pub fn class(self) -> String {
        match self {
            Self::Series(n) => format!("series{}", usize::from(n) % SERIES.len()),
            other => format!("{other:?}").to_lowercase(),
        }
    }
}
