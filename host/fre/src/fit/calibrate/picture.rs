//! Forces and residuals over the angle; torques, where they were measured instead or as well.

use super::{Fit, Quantity, Readings, Residual};
use crate::draw::{Chart, Mark, Panel, Scene, Series, Style, literal};

/// Measured and fitted forces, below them the residuals with the band of two standard deviations; the same of torques; below those the
/// residuals in standard deviations.
pub fn picture(name: &str, runs: &[Readings], fit: &Fit) -> Scene {
    let shown = fit.quantities();
    let rms = |&quantity: &Quantity| match quantity {
        Quantity::Force => format!("{:.3} N", fit.rms(quantity)),
        Quantity::Torque => format!("{:.1} N·mm", fit.rms(quantity)),
    };
    let rms = shown.iter().map(rms).collect::<Vec<_>>().join(" and ");
    let subtitle = format!("{} readings, residual rms {rms}; residual: measured less fitted", fit.residuals.len());
    let mut chart = Chart::new(format!("{name}: calibration"), subtitle, "measured motor angle (°)");
    chart.height = if shown.len() > 1 { 900.0 } else { 560.0 };
    // Colours for as many runs as there are; then they repeat.
    let colour = |run: usize| (run % 6) as u8;
    let short = |run: &Readings| literal(run.name.rsplit('/').next().unwrap_or(&run.name));
    let points = |run: usize, quantity: Quantity, value: &dyn Fn(&Residual) -> Option<f64>| -> Vec<[f64; 2]> {
        let of_run = fit.of(quantity).filter(|residual| residual.run == run);
        of_run.map(|r| [r.angle_deg, value(r).unwrap_or(f64::NAN)]).collect()
    };
    let mut standardised = Vec::new();
    for &quantity in &shown {
        let (mut values, mut residuals) = (Vec::new(), Vec::new());
        for (index, run) in runs.iter().enumerate() {
            let series = |name: String, style, points| Series { name, colour: colour(index), style, points };
            let fitted = points(index, quantity, &|r| r.predicted);
            values.push(series(format!("{}, fitted", short(run)), Style::Line, fitted));
            values.push(series(short(run), Style::Dots, points(index, quantity, &|r| Some(r.measured))));
            residuals.push(series(short(run), Style::Dots, points(index, quantity, &Residual::difference)));
            // An outlier would leave the others no height; the panel above has it.
            let ratio = |r: &Residual| r.difference().filter(|_| !r.is_outlier()).map(|d| d / r.standard_deviation);
            standardised.push(series(short(run), Style::Dots, points(index, quantity, &ratio)));
        }
        let rings = fit.of(quantity).filter(|r| r.is_outlier()).filter_map(|r| {
            r.difference().map(|y| Mark::Ring { at: [r.angle_deg, y], words: format!("outlier, line {}", r.line) })
        });
        let symbol = if quantity == Quantity::Force { "*F*" } else { "*T*" };
        let unit = quantity.unit();
        chart.panels.extend([
            Panel { y_title: format!("{symbol} ({unit})"), share: 2.0, series: values, ..Panel::default() },
            Panel {
                y_title: format!("residual ({unit})"),
                share: 1.2,
                series: residuals,
                marks: rings.collect(),
                ..Panel::default()
            },
        ]);
    }
    chart.panels.push(Panel {
        y_title: "residual / *σ*".into(),
        share: 1.0,
        series: standardised,
        marks: vec![Mark::Band { low: -2.0, high: 2.0, words: "±2 *σ*".into() }],
        ..Panel::default()
    });
    chart.scene()
}
