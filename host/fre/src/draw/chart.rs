//! Charts: several series over one axis, in one or more panels above each other (for example force, and below it the
//! difference to a reference).

use super::axis::Scale;
use super::font::Fonts;
use super::heading::{self, MARGIN, Sample, TEXT};
use super::palette::Ink;
use super::path::{Path, Rect};
use super::room::Room;
use super::scene::{Anchor, Item, Scene, Stroke, Text};

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A solid line.
    Line,
    /// A thin solid line.
    Thin,
    /// A dashed line.
    Dashed,
    /// A dot at every point.
    Dots,
    /// A thin line with a dot at every point.
    LineAndDots,
    /// A thick line with a large dot at every point, which shows beneath a thinner one.
    Thick,
    /// A line with the area between it and zero.
    Area,
    /// A light area that the points go round.
    Region,
}

/// A series of points. A point that is not finite interrupts the line.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend; series of the same name share an entry.
    pub name: String,
    /// Colour number ([`Ink::Series`]).
    pub colour: u8,
    /// How it is drawn.
    pub style: Style,
    /// Points in the axes' units.
    pub points: Vec<[f64; 2]>,
}

/// A remark in a panel.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// A vertical line: an event at a place, such as a snap-through.
    At {
        /// Place on the horizontal axis.
        x: f64,
        /// What happens there.
        words: String,
    },
    /// A ring around a point, such as a solution on another branch; drawn only if it lies within the axes.
    Ring {
        /// The point.
        at: [f64; 2],
        /// What it is.
        words: String,
    },
    /// A horizontal line: a value that must not be passed.
    Level {
        /// The value; drawn only if the axis reaches so far.
        y: f64,
        /// What it is.
        words: String,
    },
    /// A stretch of the horizontal axis, such as a branch, named at the panel's bottom.
    Stretch {
        /// Where it begins and ends.
        between: [f64; 2],
        /// What it is.
        words: String,
    },
    /// A band between two values, such as a bound that is asked for.
    Band {
        /// Lower value.
        low: f64,
        /// Upper value.
        high: f64,
        /// What it is.
        words: String,
    },
}

/// One set of axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// Title of the vertical axis with its unit; `*…*` is italic, `_{…}` a subscript.
    pub y_title: String,
    /// Range of the vertical axis; chosen from the points if none.
    pub y_range: Option<[f64; 2]>,
    /// True if the vertical axis shows zero wherever the points are.
    pub with_zero: bool,
    /// Share of the height relative to the other panels; 0 counts as 1.
    pub share: f64,
    /// The series, the lowest first.
    pub series: Vec<Series>,
    /// Remarks.
    pub marks: Vec<Mark>,
}

/// A chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// What it shows; no letter of it is a mark.
    pub title: String,
    /// Under which conditions; `*…*` is italic, `_{…}` a subscript.
    pub subtitle: String,
    /// Title of the horizontal axis with its unit.
    pub x_title: String,
    /// Range of the horizontal axis; that of the points if none.
    pub x_range: Option<[f64; 2]>,
    /// The panels, top to bottom.
    pub panels: Vec<Panel>,
    /// Width, px.
    pub width: f64,
    /// Height, px.
    pub height: f64,
}

const PANEL_GAP: f64 = 18.0;
const TICK: f64 = 5.0;
/// To the right of the axes, px.
const RIGHT: f64 = MARGIN + 10.0;
/// Below the axes, px: labels and title of the horizontal one.
const FOOT: f64 = MARGIN + 2.9 * TEXT;
/// The least width of a chart with equal scales, px.
const NARROWEST: f64 = 360.0;

impl Chart {
    /// An empty chart of a size that suits a page's column.
    pub fn new(title: impl Into<String>, subtitle: impl Into<String>, x_title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            subtitle: subtitle.into(),
            x_title: x_title.into(),
            x_range: None,
            panels: Vec::new(),
            width: 680.0,
            height: 460.0,
        }
    }

    /// The picture.
    pub fn scene(&self) -> Scene {
        let fonts = Fonts::new();
        let mut scene = Scene::new(self.width, self.height, heading::described(&self.title, &self.subtitle));
        let top = self.headings(&mut scene, &fonts);
        let bottom = self.height - FOOT;
        let gaps = PANEL_GAP * self.panels.len().saturating_sub(1) as f64;
        let share = |panel: &Panel| if panel.share > 0.0 { panel.share } else { 1.0 };
        let shares: f64 = self.panels.iter().map(share).sum();
        let unit = (bottom - top - gaps) / shares.max(1e-9);

        let range = self.horizontal_range();
        let scales: Vec<Scale> = self.panels.iter().map(|panel| vertical(panel, range, unit * share(panel))).collect();
        let left = axes_left(&scales, &fonts);
        let right = self.width - RIGHT;
        let x = self.horizontal(right - left);

        let mut y = top;
        for (index, (panel, scale)) in self.panels.iter().zip(&scales).enumerate() {
            let frame = Rect { left, right, top: y, bottom: y + unit * share(panel) };
            let last = index + 1 == self.panels.len();
            PanelView { panel, frame, x: &x, y: scale, fonts: &fonts }.draw(&mut scene, last);
            y = frame.bottom + PANEL_GAP;
        }
        scene.text(
            Text::new([0.5 * (left + right), self.height - MARGIN], TEXT, self.x_title.clone()).anchor(Anchor::Middle),
        );
        scene
    }

    /// Sizes a chart of one panel so that both axes have one scale, px per unit; both ranges have to be set. A narrow range of
    /// the horizontal axis is widened to both sides, for the headings have to fit.
    pub fn with_equal_scales(mut self, scale: f64) -> Self {
        let (Some([low, high]), Some([bottom, top])) =
            (self.x_range, self.panels.first().and_then(|panel| panel.y_range))
        else {
            return self;
        };
        let fonts = Fonts::new();
        let tall = scale * (top - bottom);
        let scales: Vec<Scale> =
            self.panels.first().map(|panel| vertical(panel, [low, high], tall)).into_iter().collect();
        let aside = axes_left(&scales, &fonts) + RIGHT;
        let wide = (scale * (high - low)).max(NARROWEST - aside);
        let more = 0.5 * (wide / scale - (high - low));
        self.x_range = Some([low - more, high + more]);
        self.width = wide + aside;
        // What the headings take up is known once the width is.
        let above = self.headings(&mut Scene::new(self.width, 0.0, ""), &fonts);
        self.height = above + tall + FOOT;
        self
    }

    fn headings(&self, scene: &mut Scene, fonts: &Fonts) -> f64 {
        let mut legend: Vec<(&str, Sample)> = Vec::new();
        for series in self.panels.iter().flat_map(|panel| &panel.series) {
            if series.name.is_empty() || legend.iter().any(|(name, _)| *name == series.name) {
                continue;
            }
            let sample = match series.stroke() {
                None if series.style == Style::Region => Sample::Area(Ink::Series(series.colour)),
                None => Sample::Dot(Ink::Series(series.colour)),
                Some(stroke) if matches!(series.style, Style::LineAndDots | Style::Thick) => {
                    Sample::LineAndDots(stroke)
                }
                Some(stroke) => Sample::Line(stroke),
            };
            legend.push((&series.name, sample));
        }
        heading::draw(scene, fonts, [&self.title, &self.subtitle], &legend)
    }

    fn horizontal(&self, width: f64) -> Scale {
        let [low, high] = self.horizontal_range();
        Scale::covering(low, high, width / 75.0, false)
    }

    fn horizontal_range(&self) -> [f64; 2] {
        let points = self.panels.iter().flat_map(|panel| &panel.series).flat_map(|series| &series.points);
        self.x_range.unwrap_or_else(|| extent(points.map(|p| p[0])))
    }
}

/// Where the axes begin, px, beside the title and the widest label of a vertical axis.
fn axes_left(scales: &[Scale], fonts: &Fonts) -> f64 {
    let width = |words: String| fonts.width(&Text::new([0.0, 0.0], TEXT, words));
    let labels = scales.iter().flat_map(|scale| scale.ticks.iter().map(|&tick| width(scale.words(tick))));
    MARGIN + 1.5 * TEXT + labels.fold(0.0, f64::max) + TICK + 6.0
}

/// Smallest and largest of the finite values.
fn extent(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values
        .filter(|value| value.is_finite())
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

/// The vertical axis of a panel over a range of the horizontal one: what is not drawn asks for no room.
fn vertical(panel: &Panel, [from, to]: [f64; 2], height: f64) -> Scale {
    let count = (height / 36.0).max(2.0);
    if let Some([low, high]) = panel.y_range {
        return Scale::covering(low, high, count, false);
    }
    let points = panel.series.iter().flat_map(|series| series.points.iter().map(|p| p[1]));
    let bands = panel.marks.iter().flat_map(|mark| match mark {
        Mark::Band { low, high, .. } => vec![*low, *high],
        Mark::Level { y, .. } => vec![*y],
        Mark::Ring { at, .. } if (from..=to).contains(&at[0]) => vec![at[1]],
        Mark::Ring { .. } | Mark::At { .. } | Mark::Stretch { .. } => Vec::new(),
    });
    let [low, high] = extent(points.chain(bands).chain(panel.with_zero.then_some(0.0)));
    // Room for words at the top.
    let words = panel.marks.iter().any(|mark| matches!(mark, Mark::At { words, .. } if !words.is_empty()));
    let high = if words { high + 0.12 * (high - low) } else { high };
    // An axis that nearly reaches zero shows it.
    let low = if low > 0.0 && low < 0.4 * high { 0.0 } else { low };
    Scale::covering(low, high, count, true)
}

/// A panel with its frame and scales.
struct PanelView<'p> {
    panel: &'p Panel,
    frame: Rect,
    x: &'p Scale,
    y: &'p Scale,
    fonts: &'p Fonts,
}

impl PanelView<'_> {
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let Rect { left, top, right, bottom } = self.frame;
        [left + (right - left) * self.x.part(x), bottom - (bottom - top) * self.y.part(y)]
    }

    fn draw(&self, scene: &mut Scene, with_x_labels: bool) {
        let Rect { left, top, right, bottom } = self.frame;
        self.bands(scene);
        for &tick in &self.y.ticks {
            let y = self.at([0.0, tick])[1];
            let ink = if tick == 0.0 && self.y.low < 0.0 { Ink::Ghost } else { Ink::Faint };
            scene.line(Path::lines([[left, y], [right, y]]), Stroke::new(ink, 1.0));
            scene.line(Path::lines([[left - TICK, y], [left, y]]), Stroke::new(Ink::Main, 1.0));
            let label = Text::new([left - TICK - 4.0, y + 0.35 * TEXT], TEXT, self.y.words(tick));
            scene.text(label.anchor(Anchor::End));
        }
        for &tick in &self.x.ticks {
            let x = self.at([tick, 0.0])[0];
            scene.line(Path::lines([[x, bottom], [x, bottom + TICK]]), Stroke::new(Ink::Main, 1.0));
            if with_x_labels {
                let label = Text::new([x, bottom + TICK + 1.15 * TEXT], TEXT, self.x.words(tick));
                scene.text(label.anchor(Anchor::Middle));
            }
        }
        let title = Text::new([MARGIN + 0.8 * TEXT, 0.5 * (top + bottom)], TEXT, self.panel.y_title.clone());
        scene.text(Text { upright: true, ..title.anchor(Anchor::Middle) });

        scene.items.push(Item::Clip(Rect {
            left: left - 6.0,
            right: right + 6.0,
            top: top - 6.0,
            bottom: bottom + 6.0,
        }));
        for series in &self.panel.series {
            for run in series.points.split(|p| !(p[0].is_finite() && p[1].is_finite())) {
                let run: Vec<[f64; 2]> = run.iter().map(|&p| self.at(p)).collect();
                if let (Style::Area, Some(first), Some(last)) = (series.style, run.first(), run.last()) {
                    let zero = self.at([0.0, 0.0])[1].clamp(top, bottom);
                    let area = run.iter().copied().chain([[last[0], zero], [first[0], zero]]);
                    scene.fill(Path::polygon(area), Ink::Series(series.colour), 0.3);
                }
                if series.style == Style::Region {
                    scene.fill(Path::polygon(run), Ink::Series(series.colour), 0.25);
                    continue;
                }
                draw_series(scene, series, &run);
            }
        }
        scene.items.push(Item::Unclip);
        scene.line(Path::lines([[left, top], [left, bottom], [right, bottom]]), Stroke::new(Ink::Main, 1.2));
        self.marks(scene);
    }

    fn bands(&self, scene: &mut Scene) {
        for mark in &self.panel.marks {
            if let Mark::Band { low, high, words } = mark {
                let [a, b] = [self.at([self.x.low, *high]), self.at([self.x.high, *low])];
                scene.fill(Path::rectangle(Rect { left: a[0], top: a[1], right: b[0], bottom: b[1] }), Ink::Faint, 0.6);
                let text = Text::new([b[0], a[1] - 4.0], 0.92 * TEXT, words.clone());
                scene.text(text.ink(Ink::Muted).anchor(Anchor::End));
            }
        }
    }

    fn marks(&self, scene: &mut Scene) {
        let Rect { left, top, right, bottom } = self.frame;
        let size = 0.92 * TEXT;
        // Left and right ends of the words at the top, by their row: words that would cover others go a row down.
        let mut rows: Vec<Vec<[f64; 2]>> = Vec::new();
        let within = Rect { left, top, right: right + 8.0, bottom };
        let mut room = Room::default();
        for mark in &self.panel.marks {
            match mark {
                Mark::Ring { at, .. } => room.take(around(self.at(*at), 6.5)),
                Mark::At { x, .. } => {
                    let x = self.at([*x, 0.0])[0];
                    room.take(Rect { left: x, top, right: x + 0.1, bottom });
                }
                Mark::Level { .. } | Mark::Stretch { .. } | Mark::Band { .. } => {}
            }
        }
        for series in self.panel.series.iter().filter(|series| matches!(series.style, Style::Dots | Style::LineAndDots))
        {
            let points =
                series.points.iter().map(|point| self.at(*point)).filter(|point| point.iter().all(|x| x.is_finite()));
            points.for_each(|point| room.avoid(around(point, 4.0)));
        }
        // They come first: other words make way for them.
        let (first, others): (Vec<&Mark>, Vec<&Mark>) =
            self.panel.marks.iter().partition(|mark| matches!(mark, Mark::At { .. }));
        for mark in first.into_iter().chain(others) {
            match mark {
                Mark::At { x, words } => {
                    let x = self.at([*x, 0.0])[0];
                    if !(left - 0.5..=right + 0.5).contains(&x) {
                        continue;
                    }
                    scene.line(Path::lines([[x, top], [x, bottom]]), Stroke::new(Ink::Muted, 1.0).dashed(3.0, 3.0));
                    if words.is_empty() {
                        continue;
                    }
                    let text = Text::new([x + 5.0, 0.0], size, words.clone()).ink(Ink::Muted).halo();
                    let width = self.fonts.width(&text);
                    let from = if x + 5.0 + width <= right + 8.0 { x + 5.0 } else { x - 5.0 - width };
                    let free = |row: &Vec<[f64; 2]>| row.iter().all(|&[a, b]| from + width < a || b < from);
                    let row = rows.iter().position(free).unwrap_or(rows.len());
                    if row == rows.len() {
                        rows.push(Vec::new());
                    }
                    rows[row].push([from - 3.0, from + width + 3.0]);
                    scene.text(Text { at: [from, top + size * (1.0 + 1.25 * row as f64)], ..text });
                }
                Mark::Ring { at, words } => {
                    let [x, y] = self.at(*at);
                    if !((left - 0.5..=right + 0.5).contains(&x) && (top - 0.5..=bottom + 0.5).contains(&y)) {
                        continue;
                    }
                    scene.line(Path::circle([x, y], 6.5), Stroke::new(Ink::Force, 1.6));
                    let text = Text::new([x, y], size, words.clone()).ink(Ink::Force).halo();
                    let places = beside([x, y], self.fonts.width(&text), size);
                    // Where there is no room at all the ring must do.
                    if let Some(place) = room.first(within, places) {
                        scene.text(Text { at: [place.left, place.bottom - 0.25 * size], ..text });
                    }
                }
                Mark::Level { y, words } => {
                    if !(self.y.low..=self.y.high).contains(y) {
                        continue;
                    }
                    let y = self.at([0.0, *y])[1];
                    scene.line(Path::lines([[left, y], [right, y]]), Stroke::new(Ink::Force, 1.4).dashed(7.0, 4.0));
                    let text = Text::new([right - 4.0, y - 5.0], size, words.clone()).ink(Ink::Force).halo();
                    let from = right - 4.0 - self.fonts.width(&text);
                    // Above the line, else below it, else below the words at the top.
                    let free = |base: f64| {
                        base - size >= top
                            && rows.iter().enumerate().all(|(row, ends)| {
                                let other = top + size * (1.0 + 1.25 * row as f64);
                                base - size >= other + 0.2 * size
                                    || other - size >= base
                                    || ends.iter().all(|&[a, b]| b < from || right < a)
                            })
                    };
                    let bottom_row = top + size * (1.2 + 1.25 * rows.len() as f64);
                    let base = [y - 5.0, y + size + 3.0].into_iter().find(|&base| free(base)).unwrap_or(bottom_row);
                    let text = Text { at: [right - 4.0, base], ..text };
                    scene.text(text.anchor(Anchor::End));
                }
                Mark::Stretch { between, words } => {
                    let [from, to] = between.map(|x| self.at([x, 0.0])[0].clamp(left, right));
                    let y = bottom - 7.0;
                    for line in [[[from + 2.0, y], [to - 2.0, y]], [[from + 2.0, y - 4.0], [from + 2.0, y + 4.0]]] {
                        scene.line(Path::lines(line), Stroke::new(Ink::Muted, 1.0));
                    }
                    scene.line(Path::lines([[to - 2.0, y - 4.0], [to - 2.0, y + 4.0]]), Stroke::new(Ink::Muted, 1.0));
                    let text = Text::new([0.5 * (from + to), y - 5.0], size, words.clone()).ink(Ink::Muted).halo();
                    // A stretch too short for its words is left without.
                    if self.fonts.width(&text) < to - from {
                        scene.text(text.anchor(Anchor::Middle));
                    }
                }
                Mark::Band { .. } => {}
            }
        }
    }
}

impl Series {
    fn stroke(&self) -> Option<Stroke> {
        let ink = Ink::Series(self.colour);
        match self.style {
            Style::Line => Some(Stroke::new(ink, 2.0).round()),
            Style::Thin => Some(Stroke::new(ink, 0.7).round()),
            Style::Area => Some(Stroke::new(ink, 1.4).round()),
            Style::Dashed => Some(Stroke::new(ink, 1.8).dashed(6.0, 4.0)),
            Style::LineAndDots => Some(Stroke::new(ink, 1.2).round()),
            Style::Thick => Some(Stroke::new(ink, 3.4).round()),
            Style::Dots | Style::Region => None,
        }
    }
}

/// Draws a run of points, already placed in the picture.
fn draw_series(scene: &mut Scene, series: &Series, points: &[[f64; 2]]) {
    if let (Some(stroke), true) = (series.stroke(), points.len() > 1) {
        scene.line(Path::lines(points.iter().copied()), stroke);
    }
    let dotted = matches!(series.style, Style::Dots | Style::LineAndDots | Style::Thick);
    // A single point of a line would be invisible.
    if dotted || points.len() == 1 {
        let radius = if points.len() > 150 { 1.6 } else { 3.0 } + if series.style == Style::Thick { 1.8 } else { 0.0 };
        for &point in points {
            scene.fill(Path::circle(point, radius), Ink::Series(series.colour), 1.0);
        }
    }
}

/// The square about a point.
fn around([x, y]: [f64; 2], half: f64) -> Rect {
    Rect { left: x - half, top: y - half, right: x + half, bottom: y + half }
}

/// Places for the words of a ring, the best place first: after it, before it, then a line higher or lower each time.
fn beside([x, y]: [f64; 2], width: f64, size: f64) -> impl Iterator<Item = Rect> {
    let line = 1.2 * size;
    let rows = (0..6).flat_map(|row| if row == 0 { vec![0.0] } else { vec![-f64::from(row), f64::from(row)] });
    rows.flat_map(move |row| {
        let bottom = y - 8.0 + 0.25 * size + row * line;
        [x + 10.0, x - 10.0 - width].map(|left| Rect { left, top: bottom - line, right: left + width, bottom })
    })
}
