//! The tables: forces and times, measures per case, and their summary.

use std::fmt::Write as _;

use super::row::{Agreement, Row};
use super::series::{APPROACH_DEG, PRESET, SERIES};
use super::variant::{COMPARED, variants};
use crate::metrics::mean_and_max;
use crate::study::place::Place;

/// A table: its title, its columns, its rows.
pub(super) struct Table {
    pub(super) title: &'static str,
    /// Names over several columns each, with their number; together they cover all columns. Empty for none.
    pub(super) groups: Vec<(String, usize)>,
    pub(super) columns: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
}

/// What the reader must know before the figures.
pub(super) fn notes() -> Vec<String> {
    let heights: Vec<String> = ["High", "Mid", "Low"]
        .iter()
        .filter_map(|name| SERIES.iter().find(|series| series.height == *name))
        .map(|series| format!("{} {} mm", series.height, series.height_mm))
        .collect();
    vec![
        format!(
            "Motor angles are those of Table 1 in \"Geometrico-Static Modelling of a FRE Finger\", the paper. It prints neither the objects' positions nor the finger's dimensions: \
             here first contact is {APPROACH_DEG}° before α1, at {} above the front beam's base, and the finger is the preset \
             {PRESET}, an approximation. The forces are therefore not the paper's and cannot be held against its measurements; \
             what is compared is one model with another.",
            heights.join(", ")
        ),
        "paper: inextensible beams, hinges from the centrelines, no rigid tip, plane stress; 170/20 by the scheme the paper \
         defines. extended: stretch and shear of beams and hinges, hinges from the beams' faces, rigid tip, plates; 170/20 \
         by the trapezoid scheme. reduced: the microcontroller's resolution. Each case is reached from the angle before it (α1 from \
         1° before contact); its time is that of this way, on one core, the fastest of three."
            .to_owned(),
        "Deviation: nearest distance of a model's front nodes from the reference's front centreline; the mean is along x_f, the \
         place on the beam. Force error: of the \
         net force's magnitude. A case counts only where both models have a trustworthy solution and both have, or neither \
         has, snapped through; all others are named by their status."
            .to_owned(),
    ]
}

/// All tables.
pub(super) fn tables(rows: &[Row]) -> Vec<Table> {
    vec![summary(rows), forces(rows), measures(rows)]
}

/// The force with the status if it says more than that all is well.
fn force(place: &Place) -> String {
    match (place.force_magnitude_n(), place.status.word()) {
        (Some(force), "converged") => format!("{force:.3}"),
        (Some(force), word) => format!("{force:.3} ({word})"),
        (None, word) => word.to_owned(),
    }
}

fn forces(rows: &[Row]) -> Table {
    let mut columns = vec!["case".to_owned(), "α (°)".to_owned()];
    let names = variants().map(|variant| variant.name.to_owned());
    columns.extend(names.iter().chain(&names).cloned());
    let groups =
        vec![(String::new(), 2), ("net force (N)".to_owned(), names.len()), ("time (ms)".to_owned(), names.len())];
    let cells = |row: &Row| {
        let mut cells = vec![row.name(), row.series.angles_deg[row.angle].to_string()];
        let places = || (0..variants().len()).filter_map(|variant| row.place(variant));
        cells.extend(places().map(force));
        cells.extend(places().map(|place| format!("{:.2}", place.effort.elapsed_us / 1000.0)));
        cells
    };
    Table { title: "Net force and time", groups, columns, rows: rows.iter().map(cells).collect() }
}

/// Which model against which.
pub(super) fn pair_name((model, reference): (usize, usize)) -> String {
    let variants = variants();
    format!("{} against {}", variants[model].name, variants[reference].name)
}

fn measures(rows: &[Row]) -> Table {
    let mut columns = vec!["case".to_owned()];
    let mut groups = vec![(String::new(), 1)];
    for pair in COMPARED {
        let measures = ["mean (mm)", "max (mm)", "force (%)"];
        groups.push((pair_name(pair), measures.len()));
        columns.extend(measures.map(str::to_owned));
    }
    let cells = |row: &Row| {
        let mut cells = vec![row.name()];
        for (model, reference) in COMPARED {
            cells.extend(match row.compare(model, reference) {
                Agreement::Same { shape, force_percent } => {
                    [format!("{:.3}", shape.mean), format!("{:.3}", shape.max), signed(force_percent)]
                }
                Agreement::OtherBranch => ["other branch".to_owned(), "–".to_owned(), "–".to_owned()],
                Agreement::None => {
                    let bad = [model, reference].map(|index| row.place(index).map(|place| place.status));
                    let bad = bad.into_iter().flatten().find(|status| !status.is_trustworthy());
                    [bad.map_or("–", |status| status.word()).to_owned(), "–".to_owned(), "–".to_owned()]
                }
            });
        }
        cells
    };
    Table { title: "Deviation along x_f and force error", groups, columns, rows: rows.iter().map(cells).collect() }
}

fn signed(percent: f64) -> String {
    format!("{percent:+.2}").replace('-', "−")
}

fn summary(rows: &[Row]) -> Table {
    let columns = [
        "comparison",
        "cases compared",
        "mean deviation (mm)",
        "max deviation (mm)",
        "mean force error (%)",
        "max force error (%)",
        "times faster",
    ];
    let mut lines = Vec::new();
    for (model, reference) in COMPARED {
        let mut shapes = Vec::new();
        let mut forces = Vec::new();
        for row in rows {
            if let Agreement::Same { shape, force_percent } = row.compare(model, reference) {
                shapes.push(shape);
                forces.push(force_percent);
            }
        }
        let time = |index: usize| {
            rows.iter().filter_map(|row| row.place(index)).map(|place| place.effort.elapsed_us).sum::<f64>()
        };
        let words = |pair: Option<[f64; 2]>, index: usize, digits: usize| {
            pair.map_or_else(|| "–".to_owned(), |pair| format!("{:.digits$}", pair[index]))
        };
        let mean_shape = mean_and_max(shapes.iter().map(|shape| shape.mean));
        let max_shape = mean_and_max(shapes.iter().map(|shape| shape.max));
        let force = mean_and_max(forces);
        lines.push(vec![
            pair_name((model, reference)),
            format!("{} of {}", shapes.len(), rows.len()),
            words(mean_shape, 0, 3),
            words(max_shape, 1, 3),
            words(force, 0, 2),
            words(force, 1, 2),
            format!("{:.1}", time(reference) / time(model)),
        ]);
    }
    Table { title: "Summary", groups: Vec::new(), columns: columns.map(str::to_owned).to_vec(), rows: lines }
}

/// The tables as Markdown.
pub fn markdown(rows: &[Row]) -> String {
    let mut out = String::from("# The paper's twenty cases\n");
    for note in notes() {
        let _ = write!(out, "\n{note}\n");
    }
    for Table { title, groups, columns, rows } in tables(rows) {
        // Markdown knows neither cells over several columns nor a second line of heads: a group's name stands over its first
        // column, the columns' own names in the first row.
        let over =
            groups.iter().flat_map(|(name, count)| (0..*count).map(move |at| if at == 0 { name.as_str() } else { "" }));
        let over: Vec<&str> = over.collect();
        let heads = if over.is_empty() { columns.join(" | ") } else { over.join(" | ") };
        let _ = write!(out, "\n## {title}\n\n| {heads} |\n|---|");
        out += &"---:|".repeat(columns.len() - 1);
        out.push('\n');
        if !over.is_empty() {
            let names: Vec<String> = columns.iter().map(|name| format!("**{name}**")).collect();
            let _ = writeln!(out, "| {} |", names.join(" | "));
        }
        for cells in rows {
            let _ = writeln!(out, "| {} |", cells.join(" | "));
        }
    }
    out
}
