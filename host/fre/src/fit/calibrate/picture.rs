//! Forces and residuals over the angle.

use super::{Fit, Readings, Residual};
use crate::draw::{Chart, Mark, Panel, Scene, Series, Style, literal};

/// Measured and fitted forces, below them the residuals with the band of two standard deviations, below those the residuals in
/// standard deviations.
pub fn picture(name: &str, runs: &[Readings], fit: &Fit) -> Scene {
    let subtitle =
        format!("{} readings, residual rms {:.3} N; residual: measured less fitted", fit.residuals.len(), fit.rms_n());
    let mut chart = Chart::new(format!("{name}: calibration"), subtitle, "measured motor angle (°)");
    chart.height = 560.0;
    let of_run = |run: usize| fit.residuals.iter().filter(move |residual| residual.run == run);
    let points = |run: usize, value: &dyn Fn(&Residual) -> Option<f64>| -> Vec<[f64; 2]> {
        of_run(run).map(|r| [r.angle_deg, value(r).unwrap_or(f64::NAN)]).collect()
    };
    // Colours for as many runs as there are; then they repeat.
    let colour = |run: usize| (run % 6) as u8;
    let short = |run: &Readings| literal(run.name.rsplit('/').next().unwrap_or(&run.name));
    let mut forces = Vec::new();
    let (mut residuals, mut standardised) = (Vec::new(), Vec::new());
    for (index, run) in runs.iter().enumerate() {
        let series = |name: String, style, points| Series { name, colour: colour(index), style, points };
        forces.push(series(format!("{}, fitted", short(run)), Style::Line, points(index, &|r| r.predicted_n)));
        forces.push(series(short(run), Style::Dots, points(index, &|r| Some(r.measured_n))));
        residuals.push(series(short(run), Style::Dots, points(index, &Residual::difference_n)));
        // An outlier would leave the others no height; the panel above has it.
        let ratio = |r: &Residual| r.difference_n().filter(|_| !r.is_outlier()).map(|d| d / r.standard_deviation_n);
        standardised.push(series(short(run), Style::Dots, points(index, &ratio)));
    }
    let outliers = fit.residuals.iter().filter(|r| r.is_outlier());
    let rings = outliers.filter_map(|r| {
        r.difference_n().map(|y| Mark::Ring { at: [r.angle_deg, y], words: format!("outlier, line {}", r.line) })
    });
    chart.panels = vec![
        Panel { y_title: "*F* (N)".into(), share: 2.0, series: forces, ..Panel::default() },
        Panel {
            y_title: "residual (N)".into(),
            share: 1.2,
            series: residuals,
            marks: rings.collect(),
            ..Panel::default()
        },
        Panel {
            y_title: "residual / *σ*".into(),
            share: 1.0,
            series: standardised,
            marks: vec![Mark::Band { low: -2.0, high: 2.0, words: "±2 *σ*".into() }],
            ..Panel::default()
        },
    ];
    chart.scene()
}
