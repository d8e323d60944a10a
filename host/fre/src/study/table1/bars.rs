//! Bars of deviation and force error per case, as in figure 6 of *Geometrico-Static Modelling of a FRE Finger*.

use super::row::{Agreement, Row};
use super::table::pair_name;
use super::variant::COMPARED;
use crate::draw::font::Fonts;
use crate::draw::heading::{self, Sample};
use crate::draw::path::{Path, Rect};
use crate::draw::scene::{Anchor, Scene, Stroke, Text};
use crate::draw::{Ink, short};

const WIDTH: f64 = 1060.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 14.0;
const PANEL: f64 = 170.0;
/// Between panels; the lower one's title is there.
const GAP: f64 = 44.0;
/// Height of the row of names, px.
const NAMES: f64 = 54.0;

/// What a panel shows of a comparison, and its title.
type Measure = (&'static str, fn(&Agreement) -> Option<f64>);

const PANELS: [Measure; 3] = [
    ("mean deviation along *x*_{f} (mm)", |comparison| match comparison {
        Agreement::Same { shape, .. } => Some(shape.mean),
        _ => None,
    }),
    ("largest deviation along *x*_{f} (mm)", |comparison| match comparison {
        Agreement::Same { shape, .. } => Some(shape.max),
        _ => None,
    }),
    ("net force error, magnitude (%)", |comparison| match comparison {
        Agreement::Same { force_percent, .. } => Some(force_percent.abs()),
        _ => None,
    }),
];

/// The picture. A case that cannot be compared has a cross in the place of its bar. The vertical axis is logarithmic:
/// what resolution changes and what physics changes are orders of magnitude apart.
pub(super) fn scene(rows: &[Row]) -> Scene {
    let title = "Differences between the models in the twenty cases (logarithmic scales)";
    let mut scene = Scene::new(WIDTH, 0.0, title);
    let names = COMPARED.map(pair_name);
    let sample = |bar: usize| Sample::Line(Stroke::new(ink(bar), 12.0));
    let legend: Vec<(&str, Sample)> =
        names.iter().enumerate().map(|(bar, name)| (name.as_str(), sample(bar))).collect();
    let top = heading::draw(&mut scene, &Fonts::new(), [title, ""], &legend) + 14.0;
    let slot = (WIDTH - LEFT - RIGHT) / rows.len().max(1) as f64;
    for (index, (title, pick)) in PANELS.into_iter().enumerate() {
        panel(&mut scene, rows, slot, top + index as f64 * (PANEL + GAP), title, pick);
    }
    let base = top + PANELS.len() as f64 * (PANEL + GAP) - GAP;
    scene.height = base + NAMES;
    for (index, row) in rows.iter().enumerate() {
        let middle = LEFT + (index as f64 + 0.5) * slot;
        let angle = format!("{}°", row.series.angles_deg[row.angle]);
        scene.text(Text::new([middle, base + 18.0], 12.0, angle).anchor(Anchor::Middle));
        if row.angle == 0 {
            let name = format!("Ø{} {}", row.series.diameter_mm, row.series.height);
            scene.text(Text::new([middle + 1.5 * slot, base + 38.0], 13.0, name).anchor(Anchor::Middle));
        }
    }
    scene
}

fn ink(bar: usize) -> Ink {
    Ink::Series(bar as u8)
}

fn panel(scene: &mut Scene, rows: &[Row], slot: f64, top: f64, title: &str, pick: fn(&Agreement) -> Option<f64>) {
    let bottom = top + PANEL;
    let right = WIDTH - RIGHT;
    let found = |row: &Row, (model, reference): (usize, usize)| pick(&row.compare(model, reference));
    let values: Vec<f64> = rows
        .iter()
        .flat_map(|row| COMPARED.map(|pair| found(row, pair)))
        .flatten()
        .filter(|value| *value > 0.0)
        .collect();
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(0.0, f64::max);
    // Whole decades around the values; two at least.
    let low = if least.is_finite() { least.log10().floor().max(-6.0) } else { -1.0 };
    let high = if most > 0.0 { most.log10().ceil().max(low + 2.0) } else { 1.0 };
    let at = |value: f64| bottom - (value.log10().clamp(low, high) - low) / (high - low) * PANEL;
    scene.text(Text::new([LEFT, top - 8.0], 13.0, title).bold());
    for decade in low as i32..=high as i32 {
        let value = 10_f64.powi(decade);
        let y = at(value);
        scene.line(Path::lines([[LEFT, y], [right, y]]), Stroke::new(Ink::Faint, 1.0));
        let words = Text::new([LEFT - 8.0, y + 4.0], 12.0, short(value, 6)).ink(Ink::Muted);
        scene.text(words.anchor(Anchor::End));
    }
    let width = 0.78 * slot / COMPARED.len() as f64;
    for (index, row) in rows.iter().enumerate() {
        let left = LEFT + (index as f64 + 0.11) * slot;
        if row.angle == 0 && index > 0 {
            let x = LEFT + index as f64 * slot;
            scene.line(Path::lines([[x, top], [x, bottom]]), Stroke::new(Ink::Faint, 1.0));
        }
        for (bar, pair) in COMPARED.into_iter().enumerate() {
            let x = left + bar as f64 * width;
            match found(row, pair) {
                Some(value) => {
                    let y = at(value.max(1e-9)).min(bottom - 1.0);
                    let area = Rect { left: x, top: y, right: x + width - 1.0, bottom };
                    scene.fill(Path::rectangle(area), ink(bar), 1.0);
                }
                None => {
                    let (x, y) = (x + 0.5 * width, bottom - 8.0);
                    for side in [-3.5, 3.5] {
                        let line = Path::lines([[x - 3.5, y - side], [x + 3.5, y + side]]);
                        scene.line(line, Stroke::new(ink(bar), 2.0));
                    }
                }
            }
        }
    }
    scene.line(Path::lines([[LEFT, bottom], [right, bottom]]), Stroke::new(Ink::Main, 1.2));
}
