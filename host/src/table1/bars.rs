//! Bars of deviation and force error per case, as in the paper's figure 6.

use std::fmt::Write as _;

use super::table::pair_name;
use super::{COMPARED, Comparison, Row};
use crate::draw::Ink;

const WIDTH: f64 = 1060.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 84.0;
const PANEL: f64 = 170.0;
const GAP: f64 = 44.0;
/// Height of the row of names, px.
const NAMES: f64 = 54.0;

/// What a panel shows of a comparison, and its title.
type Measure = (&'static str, fn(&Comparison) -> Option<f64>);

const PANELS: [Measure; 3] = [
    ("mean deviation along x_f (mm)", |comparison| match comparison {
        Comparison::Same { shape, .. } => Some(shape.mean),
        _ => None,
    }),
    ("largest deviation along x_f (mm)", |comparison| match comparison {
        Comparison::Same { shape, .. } => Some(shape.max),
        _ => None,
    }),
    ("net force error, magnitude (%)", |comparison| match comparison {
        Comparison::Same { force_percent, .. } => Some(force_percent.abs()),
        _ => None,
    }),
];

/// The picture. A case that cannot be compared has a cross in the place of its bar. The vertical axis is logarithmic:
/// what resolution changes and what physics changes are orders of magnitude apart.
pub(super) fn svg(rows: &[Row]) -> String {
    let height = TOP + PANELS.len() as f64 * (PANEL + GAP) + NAMES - GAP;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {WIDTH} {height}\" \
         role=\"img\" aria-label=\"Deviations and force errors of the twenty cases\">\n{}\
         <rect class=\"b-paper\" width=\"{WIDTH}\" height=\"{height}\"/>\n\
         <text x=\"14\" y=\"26\" class=\"b-main\" font-size=\"16\" font-weight=\"700\">Differences between the models in the \
         twenty cases (logarithmic scales)</text>\n",
        style()
    );
    let mut x = 14.0;
    for (index, pair) in COMPARED.into_iter().enumerate() {
        let name = pair_name(pair);
        let _ = writeln!(
            out,
            "<rect class=\"b-s{index}\" x=\"{x}\" y=\"42\" width=\"14\" height=\"14\"/><text x=\"{}\" y=\"54\" \
             class=\"b-main\" font-size=\"13\">{name}</text>",
            x + 20.0
        );
        x += 50.0 + 7.6 * name.chars().count() as f64;
    }
    let slot = (WIDTH - LEFT - RIGHT) / rows.len().max(1) as f64;
    for (index, (title, pick)) in PANELS.into_iter().enumerate() {
        let top = TOP + index as f64 * (PANEL + GAP);
        panel(&mut out, rows, slot, top, title, pick);
    }
    let base = TOP + PANELS.len() as f64 * (PANEL + GAP) - GAP;
    for (index, row) in rows.iter().enumerate() {
        let middle = LEFT + (index as f64 + 0.5) * slot;
        let _ = writeln!(
            out,
            "<text x=\"{middle:.1}\" y=\"{:.1}\" class=\"b-main\" font-size=\"12\" text-anchor=\"middle\">{}°</text>",
            base + 18.0,
            row.series.angles_deg[row.angle]
        );
        if row.angle == 0 {
            let _ = writeln!(
                out,
                "<text x=\"{:.1}\" y=\"{:.1}\" class=\"b-main\" font-size=\"13\" text-anchor=\"middle\">Ø{} {}</text>",
                middle + 1.5 * slot,
                base + 38.0,
                row.series.diameter_mm,
                row.series.height
            );
        }
    }
    out += "</svg>\n";
    out
}

fn panel(out: &mut String, rows: &[Row], slot: f64, top: f64, title: &str, pick: fn(&Comparison) -> Option<f64>) {
    let bottom = top + PANEL;
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
    let _ = writeln!(
        out,
        "<text x=\"{LEFT}\" y=\"{:.1}\" class=\"b-main\" font-size=\"13\" font-weight=\"700\">{title}</text>",
        top - 8.0
    );
    for decade in low as i32..=high as i32 {
        let value = 10_f64.powi(decade);
        let y = at(value);
        let _ = writeln!(
            out,
            "<path class=\"b-rule\" d=\"M{LEFT} {y:.1}H{:.1}\"/><text x=\"{:.1}\" y=\"{:.1}\" class=\"b-muted\" \
             font-size=\"12\" text-anchor=\"end\">{value}</text>",
            WIDTH - RIGHT,
            LEFT - 8.0,
            y + 4.0
        );
    }
    let width = 0.78 * slot / COMPARED.len() as f64;
    for (index, row) in rows.iter().enumerate() {
        let left = LEFT + (index as f64 + 0.11) * slot;
        if row.angle == 0 && index > 0 {
            let x = LEFT + index as f64 * slot;
            let _ = writeln!(out, "<path class=\"b-rule\" d=\"M{x:.1} {top:.1}V{bottom:.1}\"/>");
        }
        for (bar, pair) in COMPARED.into_iter().enumerate() {
            let x = left + bar as f64 * width;
            match found(row, pair) {
                Some(value) => {
                    let y = at(value.max(1e-9));
                    let _ = writeln!(
                        out,
                        "<rect class=\"b-s{bar}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\"><title>{}: \
                         {value:.4}</title></rect>",
                        width - 1.0,
                        (bottom - y).max(1.0),
                        row.name()
                    );
                }
                None => {
                    let (x, y) = (x + width / 2.0, bottom - 8.0);
                    let _ = writeln!(
                        out,
                        "<path class=\"b-cross b-c{bar}\" d=\"M{:.1} {:.1}l7 7m0 -7l-7 7\"/>",
                        x - 3.5,
                        y - 3.5
                    );
                }
            }
        }
    }
    let _ = writeln!(out, "<path class=\"b-axis\" d=\"M{LEFT} {bottom:.1}H{:.1}\"/>", WIDTH - RIGHT);
}

fn style() -> String {
    let rules = |dark: bool| {
        let colour = |ink: Ink| {
            let (light, black) = ink.colours();
            let [r, g, b] = if dark { black } else { light };
            format!("#{r:02x}{g:02x}{b:02x}")
        };
        let mut out = String::new();
        for (class, ink) in [("paper", Ink::Paper), ("main", Ink::Main), ("muted", Ink::Muted)] {
            let _ = write!(out, ".b-{class}{{fill:{}}}", colour(ink));
        }
        for index in 0..COMPARED.len() as u8 {
            let ink = colour(Ink::Series(index));
            let _ = write!(out, ".b-s{index}{{fill:{ink}}}.b-c{index}{{stroke:{ink}}}");
        }
        let _ = write!(out, ".b-rule{{stroke:{}}}.b-axis{{stroke:{}}}", colour(Ink::Faint), colour(Ink::Main));
        out
    };
    format!(
        "<style>text{{font-family:'Noto Sans','Helvetica Neue',Helvetica,Arial,sans-serif}}.b-cross{{stroke-width:2;\
         fill:none}}{}@media (prefers-color-scheme:dark){{{}}}</style>\n",
        rules(false),
        rules(true)
    )
}
