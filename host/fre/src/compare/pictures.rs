//! What a comparison draws: both shapes, or forces and residuals.

use model_core::design::Design;
use model_core::object::Motion;

use super::comparison::{Reading, Row};
use crate::case::Case;
use crate::draw::{Chart, Mark, Panel, Scene, Series, Style, short, significant};
use crate::fea::{self, FeaError, Pose};
use crate::metrics::Point;
use crate::study::place::State;

/// How large a finger is drawn, px: fingers of all sizes alike.
const SIZE: f64 = 520.0;

/// Height or width of a finger, mm, the larger one.
fn size_of(design: &Design) -> f64 {
    let ends = [design.front.base, design.front.tip, design.back.base, design.back.tip];
    let extent = |axis: usize| {
        let of = ends.map(|p| p[axis]);
        of.into_iter().fold(f64::NEG_INFINITY, f64::max) - of.into_iter().fold(f64::INFINITY, f64::min)
    };
    extent(0).max(extent(1))
}

/// Both shapes over each other, finger frame.
pub(super) fn overlay(case: &Case, state: &State, pose: &Pose) -> Result<Scene, FeaError> {
    let series = |name: &str, colour, style, points: &[Point]| Series {
        name: name.to_owned(),
        colour,
        style,
        points: points.to_vec(),
    };
    let size = size_of(&case.finger.design);
    let room = size / 27.0;
    let lines = [&pose.front, &pose.back, &state.shape.front, &state.shape.back];
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for p in lines.into_iter().flatten() {
        for axis in 0..2 {
            low[axis] = low[axis].min(p[axis] - room);
            high[axis] = high[axis].max(p[axis] + room);
        }
    }
    high[0] += 4.0 * room;
    let middle = [high[0], 0.5 * (low[1] + high[1])];
    let object: Vec<Point> = fea::object_line(case, pose.place, middle, 2.0 * (high[1] - low[1]))
        .into_iter()
        .map(|[x, y]| {
            // The axes end where the finger does; the rest of the object is not drawn.
            let inside = (low[0]..=high[0]).contains(&x) && (low[1]..=high[1]).contains(&y);
            if inside { [x, y] } else { [f64::NAN; 2] }
        })
        .collect();
    let mut chart = Chart::new(
        format!("{}: model and finite elements", case.finger.name),
        format!(
            "{}{}, force {} N, FEA {} N; finger frame",
            short(pose.place, 3),
            case.path.unit(),
            significant(state.force_magnitude_n(), 3),
            significant(pose.magnitude(), 3)
        ),
        "*x* (mm)",
    );
    chart.x_range = Some([low[0], high[0]]);
    let mut mesh = Vec::new();
    if !pose.mesh_edge.is_empty() {
        mesh.push(series("FEA, edge of the mesh", 1, Style::Thin, &pose.mesh_edge));
    }
    chart.panels.push(Panel {
        y_title: "*y* (mm)".to_owned(),
        y_range: Some([low[1], high[1]]),
        series: mesh
            .into_iter()
            .chain([
                series("object", 6, Style::Line, &object),
                series("FEA", 1, Style::Line, &pose.front),
                series("FEA", 1, Style::Line, &pose.back),
                series("model", 0, Style::Dashed, &state.shape.front),
                series("model", 0, Style::Dashed, &state.shape.back),
            ])
            .collect(),
        ..Panel::default()
    });
    Ok(chart.with_equal_scales(SIZE / size).scene())
}

/// Forces over the place, and below them the residuals.
pub(super) fn residual_chart(case: &Case, rows: &[Row]) -> Scene {
    let points = |value: &dyn Fn(&Row) -> Option<f64>| -> Vec<Point> {
        rows.iter().map(|row| [row.place, value(row).unwrap_or(f64::NAN)]).collect()
    };
    let x_title = match case.path.motion {
        Motion::Rotating { .. } => "motor angle *α* (°)",
        Motion::Translating { .. } => "distance *d* (mm)",
    };
    let readings: Vec<(f64, &Reading)> =
        rows.iter().flat_map(|row| row.readings.iter().map(|reading| (row.place, reading))).collect();
    let residual = |(place, reading): &(f64, &Reading)| [*place, reading.difference_n.unwrap_or(f64::NAN)];
    let several = rows.iter().any(|row| row.readings.len() > 1);
    let subtitle = format!("{} measured forces; residual: model less measured", readings.len());
    let mut chart = Chart::new(format!("{}: model and measurements", case.finger.name), subtitle, x_title);
    let series = |name: &str, colour, style, points| Series { name: name.to_owned(), colour, style, points };
    chart.panels.push(Panel {
        y_title: "*F* (N)".to_owned(),
        share: 2.0,
        series: vec![
            series("model", 0, Style::Line, points(&|row| row.force_n)),
            series(
                "measured",
                1,
                Style::Dots,
                readings.iter().map(|(place, reading)| [*place, reading.force_n]).collect(),
            ),
        ],
        ..Panel::default()
    });
    let rings = readings.iter().filter(|(_, reading)| reading.outlier);
    let rings = rings.map(|on| Mark::Ring { at: residual(on), words: format!("line {}", on.1.line) });
    chart.panels.push(Panel {
        y_title: "residual (N)".to_owned(),
        share: 1.0,
        marks: rings.collect(),
        series: vec![
            series(
                if several { "residual of the mean" } else { "residual" },
                4,
                Style::Line,
                points(&|row| row.difference_n),
            ),
            series("residual", 4, Style::Dots, readings.iter().map(residual).collect()),
        ],
        ..Panel::default()
    });
    chart.scene()
}
