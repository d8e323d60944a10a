//! What a comparison prints: a table for people, CSV for programs.

use std::fmt::Write;

use super::comparison::{Comparison, Row};
use super::outlying::LEAST_FORCE;
use crate::case::Case;
use crate::draw::short;
use crate::metrics::mean_and_max;

/// Less than this is printed as 0.0000 N: rounding errors, which have no percentages.
const NO_FORCE: f64 = 5e-5;

impl Comparison {
    /// For people: a table, then what it comes to.
    pub fn text(&self, case: &Case) -> String {
        text(case, self)
    }

    /// One line per place; new columns are added at the end only.
    pub fn csv(&self, case: &Case) -> String {
        csv(case, self)
    }

    /// The outlying points, and what the comparison comes to without them and the outlying readings, a line each.
    pub fn outlier_lines(&self, case: &Case) -> Vec<String> {
        outlier_lines(case, self)
    }
}

fn text(case: &Case, comparison: &Comparison) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_text(&mut out, case, comparison);
    out
}

fn write_text(out: &mut String, case: &Case, comparison: &Comparison) -> std::fmt::Result {
    let number = |value: Option<f64>, decimals: usize| value.map_or("–".into(), |v| format!("{v:.decimals$}"));
    let signed = |value: Option<f64>, decimals: usize| value.map_or("–".into(), |v| format!("{v:+.decimals$}"));
    let reference = if comparison.fea.is_some() { "FEA" } else { "measured" };
    let place = format!("at {}", unit(case));
    writeln!(
        out,
        "{place:>8} {:>10} {:>10} {:>9} {:>8} {:>14} {:>13}  status",
        "force N",
        format!("{reference} N"),
        "diff. N",
        "error %",
        "shape mean mm",
        "shape max mm"
    )?;
    for row in &comparison.rows {
        writeln!(
            out,
            "{:>8.3} {:>10} {:>10} {:>9} {:>8} {:>14} {:>13}  {}{}",
            row.place,
            number(row.force_n, 4),
            number(row.reference_force_n, 4),
            signed(row.difference_n, 4),
            signed(row.error_percent, 2),
            number(row.shape_mean_mm, 3),
            number(row.shape_max_mm, 3),
            row.status,
            remark(row)
        )?;
    }
    let rows = || comparison.rows.iter();
    let worst = |value: &dyn Fn(&Row) -> Option<f64>| {
        let sizes = rows().filter_map(|row| Some((row, value(row)?.abs())));
        sizes.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(row, _)| row)
    };
    let at = |row: &Row| format!("at {}{}", short(row.place, 3), case.path.unit());
    // Percent of a force near zero tell nothing: 0.02 N of a gauge's noise without contact are 100 %.
    let largest = rows().filter_map(|row| row.reference_force_n).fold(0.0, f64::max);
    let is_small = |row: &Row| row.reference_force_n.is_some_and(|force| force < (LEAST_FORCE * largest).max(NO_FORCE));
    let small = rows().filter(|row| row.error_percent.is_some() && is_small(row)).count();
    let percent = |row: &Row| row.error_percent.filter(|_| !is_small(row));
    if let Some([mean, max]) = mean_and_max(rows().filter_map(percent)) {
        let at = worst(&percent).map(at).unwrap_or_default();
        write!(out, "force error: mean {mean:.2} %, max {max:.2} % ({at})")?;
        if small > 0 {
            let (places, least) = (if small == 1 { "place" } else { "places" }, LEAST_FORCE * largest);
            let share = 100.0 * LEAST_FORCE;
            write!(out, "; not counted: {small} {places} with less than {least:.3} N, {share} % of the largest")?;
        }
        writeln!(out)?;
    }
    if let Some([mean, max]) = mean_and_max(rows().filter_map(|row| row.difference_n)) {
        let at = worst(&|row| row.difference_n).map(at).unwrap_or_default();
        let share = if largest >= NO_FORCE {
            format!(
                ": {:.2} and {:.2} % of the largest {reference} force",
                100.0 * mean / largest,
                100.0 * max / largest
            )
        } else {
            String::new()
        };
        writeln!(out, "force difference: mean {mean:.4} N, max {max:.4} N ({at}){share}")?;
    }
    let means = mean_and_max(rows().filter_map(|row| row.shape_mean_mm));
    let worst = worst(&|row| row.shape_max_mm);
    if let (Some([mean, _]), Some((row, [x, y]))) = (means, worst.and_then(|row| Some((row, row.shape_max_at_mm?)))) {
        let max = row.shape_max_mm.unwrap_or(0.0);
        writeln!(
            out,
            "shape deviation (nearest distance): mean {mean:.3} mm, max {max:.3} mm ({} near ({x:.1}, {y:.1}) mm, finger frame)",
            at(row)
        )?;
    }
    for line in outlier_lines(case, comparison) {
        writeln!(out, "{line}")?;
    }
    if let Some(fea) = &comparison.fea {
        writeln!(
            out,
            "CalculiX: {} elements, {} nodes, {} increments ({} attempts failed), {} iterations; files in {}",
            fea.elements, fea.nodes, fea.increments, fea.failed_attempts, fea.iterations, fea.folder
        )?;
        writeln!(
            out,
            "time: CalculiX {:.1} s, model {:.2} ms: {:.0} times faster",
            fea.seconds,
            1e3 * comparison.model_seconds,
            fea.speed_ratio
        )?;
    }
    for note in &comparison.notes {
        writeln!(out, "note: {note}")?;
    }
    let missing = comparison.rows.iter().filter(|row| row.reference_force_n.is_none()).count();
    if missing > 0 {
        writeln!(out, "{missing} of {} places have no {reference} force", comparison.rows.len())?;
    }
    if !comparison.left_out.is_empty() {
        writeln!(out, "left out:")?;
        for problem in &comparison.left_out {
            writeln!(out, "  {problem}")?;
        }
    }
    Ok(())
}

fn outlier_lines(case: &Case, comparison: &Comparison) -> Vec<String> {
    let mut lines = Vec::new();
    for (row, point) in comparison.rows.iter().flat_map(|row| row.outlying_points.iter().map(move |point| (row, point)))
    {
        let ([x, y], place) = (point.point_mm, short(row.place, 3));
        lines.push(format!(
            "outlier: the point ({x}, {y}) mm of line {}, at {place}{}, is {:.3} mm from the model",
            point.line,
            case.path.unit(),
            point.distance_mm
        ));
    }
    let counted = |count: usize, what: &str| match count {
        0 => None,
        1 => Some(format!("1 {what}")),
        _ => Some(format!("{count} {what}s")),
    };
    let readings = comparison.rows.iter().map(|row| row.outlier_lines().len()).sum();
    let what: Vec<String> =
        [counted(readings, "reading"), counted(lines.len(), "point")].into_iter().flatten().collect();
    if what.is_empty() {
        return lines;
    }
    let rows = || comparison.rows.iter().map(|row| row.without_outliers.as_deref().unwrap_or(row));
    let largest = rows().filter_map(|row| row.reference_force_n).fold(0.0, f64::max);
    let counts = |row: &&Row| row.reference_force_n.is_some_and(|force| force >= LEAST_FORCE * largest);
    let mut figures = Vec::new();
    if let Some([mean, max]) = mean_and_max(rows().filter(counts).filter_map(|row| row.error_percent)) {
        figures.push(format!("force error: mean {mean:.2} %, max {max:.2} %"));
    }
    if let Some([mean, max]) = mean_and_max(rows().filter_map(|row| row.difference_n)) {
        figures.push(format!("force difference: mean {mean:.4} N, max {max:.4} N"));
    }
    let means = mean_and_max(rows().filter_map(|row| row.shape_mean_mm));
    if let (Some([mean, _]), Some([_, max])) = (means, mean_and_max(rows().filter_map(|row| row.shape_max_mm))) {
        figures.push(format!("shape deviation: mean {mean:.3} mm, max {max:.3} mm"));
    }
    if figures.is_empty() {
        figures.push("nothing is left to compare".to_owned());
    }
    lines.push(format!("without these ({}): {}", what.join(", "), figures.join("; ")));
    lines
}

/// What is to be said of a row beside its numbers.
fn remark(row: &Row) -> String {
    let mut words = String::new();
    if row.readings.len() > 1 {
        let forces = row.readings.iter().map(|reading| reading.force_n);
        let (least, most) = forces.fold((f64::INFINITY, 0.0), |(l, m): (f64, f64), f| (l.min(f), m.max(f)));
        // Writing to a string cannot fail.
        let _ = write!(words, ", mean of {} readings ({least} to {most} N)", row.readings.len());
    }
    let lines = row.outlier_lines();
    if !lines.is_empty() {
        let several = if lines.len() > 1 { "s" } else { "" };
        let _ = write!(words, ", outlier{several} (line{several} {})", lines.join(", "));
    }
    words
}

fn csv(case: &Case, comparison: &Comparison) -> String {
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    let place = if unit(case) == "°" { "motor_angle_deg" } else { "distance_mm" };
    let mut out = format!(
        "{place},status,force_n,reference_force_n,difference_n,error_percent,shape_mean_mm,shape_max_mm,shape_max_x_mm,\
         shape_max_y_mm,readings,line,outlier_lines,outlying_point_lines\n"
    );
    for row in &comparison.rows {
        let [x, y] = [0, 1].map(|axis| number(row.shape_max_at_mm.map(|at| at[axis])));
        let numbers = [
            row.force_n,
            row.reference_force_n,
            row.difference_n,
            row.error_percent,
            row.shape_mean_mm,
            row.shape_max_mm,
        ];
        let mut points: Vec<String> = row.outlying_points.iter().map(|point| point.line.to_string()).collect();
        // A row may hold a list of points: its line once.
        points.dedup();
        let _ = writeln!(
            out,
            "{},{},{},{x},{y},{},{},{},{}",
            row.place,
            row.status,
            numbers.map(number).join(","),
            if row.line.is_some() { row.readings.len().to_string() } else { String::new() },
            row.line.map_or_else(String::new, |line| line.to_string()),
            row.outlier_lines().join(" "),
            points.join(" ")
        );
    }
    out
}

/// The unit of a place.
fn unit(case: &Case) -> &'static str {
    case.path.unit().trim_start()
}
