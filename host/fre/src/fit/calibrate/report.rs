//! A finished fit as text, JSON and a finger file.

use std::fmt::Write as _;

use model_core::drive::{Drive, Travel};
use model_core::object::ObjectDesign;
use serde_json::{Value, json};

use super::{Combination, Fit, Input, Parameter, Quantity, uncertainty, zero_counts};
use crate::case::Finger;

/// A combination as a person reads it.
fn words(combination: &Combination) -> String {
    let terms = combination
        .terms
        .iter()
        .map(|(parameter, change)| format!("{} {change:+.3} {}", parameter.word(), parameter.unit()));
    terms.collect::<Vec<_>>().join(" with ")
}

/// For people: the parameters, their correlation, what the data leave open, and what it means for a gripper.
pub fn text(input: &Input, fit: &Fit) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_text(&mut out, input, fit);
    out
}

/// What a plan's readings determine, without the values: nothing was measured.
pub(super) fn write_expected(out: &mut String, fit: &Fit) -> std::fmt::Result {
    writeln!(out, "{:<16} {:>10} {:>10}  unit", "parameter", "start", "σ")?;
    for estimate in &fit.estimates {
        let note = if estimate.determined { "" } else { "  not determined" };
        let (word, unit) = (estimate.parameter.word(), estimate.parameter.unit());
        writeln!(out, "{word:<16} {:>10.4} {:>10.4}  {unit}{note}", estimate.start, estimate.standard_deviation)?;
    }
    write_relations(out, fit)
}

/// What the data leave open, and how the parameters hang together.
fn write_relations(out: &mut String, fit: &Fit) -> std::fmt::Result {
    for combination in &fit.undetermined {
        writeln!(out, "the data do not tell {} from no change", words(combination))?;
    }
    if fit.estimates.len() > 1 {
        writeln!(out, "correlation")?;
        for (i, estimate) in fit.estimates.iter().enumerate() {
            let row: Vec<String> = fit.correlation[i][..=i].iter().map(|value| format!("{value:>6.2}")).collect();
            writeln!(out, "{:<16} {}", estimate.parameter.word(), row.join(" "))?;
        }
    }
    Ok(())
}

fn write_text(out: &mut String, input: &Input, fit: &Fit) -> std::fmt::Result {
    let design = &input.finger.design;
    let quantities = fit.quantities();
    let each = |words: &dyn Fn(Quantity) -> String| {
        quantities.iter().map(|&quantity| words(quantity)).collect::<Vec<_>>().join(" and ")
    };
    let measured = each(&|quantity| format!("{} {}", fit.of(quantity).count(), quantity.plural()));
    let runs = input.runs.len();
    let plural = if runs == 1 { "" } else { "s" };
    writeln!(out, "{}: {measured} of {runs} run{plural}", input.finger.name)?;
    writeln!(out, "{:<16} {:>10} {:>10} {:>10}  unit", "parameter", "start", "fitted", "σ")?;
    for estimate in &fit.estimates {
        let note = if estimate.determined { "" } else { "  not determined by the data" };
        writeln!(
            out,
            "{:<16} {:>10.4} {:>10.4} {:>10.4}  {}{note}",
            estimate.parameter.word(),
            estimate.start,
            estimate.value,
            estimate.standard_deviation,
            estimate.parameter.unit()
        )?;
    }
    write_relations(out, fit)?;
    let rms = each(&|quantity| {
        let number = |rms: f64| match quantity {
            Quantity::Force => format!("{rms:.4} N"),
            Quantity::Torque => format!("{rms:.3} N·mm"),
        };
        let kept = number(fit.rms(quantity));
        match fit.outliers(quantity) {
            0 => kept,
            count => {
                let (plural, all) = (if count == 1 { "" } else { "s" }, number(fit.rms_of_all(quantity)));
                format!(
                    "{kept} without {count} outlier{plural} ({all} with {})",
                    if count == 1 { "it" } else { "them" }
                )
            }
        }
    });
    writeln!(
        out,
        "residuals: rms {rms}, {} times what the stated noise allows; {} passes{}",
        each(&|quantity| format!("{:.2}", fit.inflation.of(quantity))),
        fit.passes,
        if fit.converged { "" } else { ", NOT CONVERGED" }
    )?;
    if let Some((points, rms)) = fit.outline {
        let times = fit.inflation.outline;
        writeln!(
            out,
            "outlines: {points} points, rms distance {rms:.3} mm, {times:.2} times what the stated noise allows"
        )?;
    }
    for residual in fit.residuals.iter().filter(|residual| residual.is_outlier()) {
        let name = &input.runs[residual.run].name;
        match residual.difference() {
            Some(difference) => writeln!(
                out,
                "outlier: {name}:{}: {:.3} {unit} at {:.3}°, {difference:+.3} {unit} off",
                residual.line,
                residual.measured,
                residual.angle_deg,
                unit = residual.quantity.unit(),
            )?,
            None => writeln!(out, "no solution: {name}:{}: at {:.3}°", residual.line, residual.angle_deg)?,
        }
    }
    for remark in &input.remarks {
        writeln!(out, "{remark}")?;
    }
    let prony = &input.finger.prony;
    let given = uncertainty(fit, design, prony);
    writeln!(out, "for the gripper (--send does it):")?;
    writeln!(
        out,
        "  zero position {:+.2} counts, if its counts grow on closing and it has no gear",
        zero_counts(fit, design)
    )?;
    writeln!(out, "  finger        E = {:.4} MPa", fit.trial.design(design).material.youngs_modulus)?;
    if let Drive::Translating { travel, .. } = fit.trial.drive(&input.drive, design) {
        let factor = 1.0 + fit.trial.change(Parameter::Travel, design);
        match travel {
            Travel::Linear { mm_per_rad } => {
                writeln!(out, "  drive         {mm_per_rad:.4} mm per rad (× {factor:.4})")?
            }
            Travel::Table(_) => writeln!(out, "  drive         the table's distances × {factor:.4}")?,
        }
    }
    for (run, object) in input.runs.iter().zip(&input.objects) {
        if let ObjectDesign::Circle { centre, radius } = fit.trial.object(*object, design) {
            writeln!(
                out,
                "  object        ({:.3}, {:.3}) mm, radius {radius:.3} mm ({})",
                centre[0], centre[1], run.name
            )?;
        }
    }
    for run in input.runs.iter().filter(|run| fit.trial.friction(run.friction, design) != 0.0) {
        writeln!(out, "  friction      {:.4} ({})", fit.trial.friction(run.friction, design), run.name)?;
    }
    writeln!(
        out,
        "  uncertainty   zero {:.4}°, E {:.2} %, place ({:.3}, {:.3}) mm, radius {:.3} mm",
        given.zero_angle.to_degrees(),
        100.0 * given.youngs_modulus,
        given.centre[0],
        given.centre[1],
        given.radius
    )?;
    let deviations = given.memory.parts.iter().zip(&given.memory.times);
    for (k, ([part, time], (sd, relative))) in fit.trial.prony(prony).iter().zip(deviations).enumerate() {
        let number = k + 1;
        writeln!(out, "  term {number}        g = {part:.4} ± {sd:.4}, τ = {time:.4} s ± {:.2} %", 100.0 * relative)?;
    }
    Ok(())
}

/// Everything, as JSON.
pub fn document(input: &Input, fit: &Fit) -> Value {
    let design = &input.finger.design;
    let estimates = fit.estimates.iter().map(|estimate| {
        json!({
            "parameter": estimate.parameter.word(),
            "unit": estimate.parameter.unit(),
            "start": estimate.start,
            "value": estimate.value,
            "standard_deviation": estimate.standard_deviation,
            "determined": estimate.determined,
        })
    });
    let combination = |combination: &Combination| -> Value {
        let terms = combination.terms.iter().map(|(p, change)| (p.word().to_owned(), json!(change)));
        Value::Object(terms.collect())
    };
    let residuals = fit.residuals.iter().map(|residual| {
        let (file, line, angle) = (&input.runs[residual.run].name, residual.line, residual.angle_deg);
        let (measured, fitted, deviation) = (residual.measured, residual.predicted, residual.standard_deviation);
        match residual.quantity {
            Quantity::Force => json!({
                "file": file, "line": line, "motor_angle_deg": angle, "measured_n": measured, "fitted_n": fitted,
                "standard_deviation_n": deviation, "weight": residual.weight,
            }),
            Quantity::Torque => json!({
                "file": file, "line": line, "motor_angle_deg": angle, "measured_nmm": measured, "fitted_nmm": fitted,
                "standard_deviation_nmm": deviation, "weight": residual.weight,
            }),
        }
    });
    let torques = fit.quantities().contains(&Quantity::Torque);
    json!({
        "converged": fit.converged,
        "passes": fit.passes,
        "parameters": estimates.collect::<Vec<_>>(),
        "correlation": fit.correlation,
        "undetermined": fit.undetermined.iter().map(combination).collect::<Vec<_>>(),
        "rms_n": fit.rms(Quantity::Force),
        "rms_nmm": torques.then(|| fit.rms(Quantity::Torque)),
        "rms_of_all_n": fit.rms_of_all(Quantity::Force),
        "rms_of_all_nmm": torques.then(|| fit.rms_of_all(Quantity::Torque)),
        "outliers": fit.quantities().into_iter().map(|quantity| fit.outliers(quantity)).sum::<usize>(),
        "inflation": fit.inflation.largest(),
        "inflation_forces": fit.inflation.force,
        "inflation_torques": torques.then_some(fit.inflation.torque),
        "outline": fit.outline.map(|(points, rms)| {
            json!({ "points": points, "rms_mm": rms, "inflation": fit.inflation.outline })
        }),
        "residuals": residuals.collect::<Vec<_>>(),
        "left_out": input.remarks,
        "prony": fit.trial.prony(&input.finger.prony),
        "gripper": {
            "zero_counts": zero_counts(fit, design),
            "travel_factor": 1.0 + fit.trial.change(Parameter::Travel, design),
            "friction": input.runs.iter().map(|run| fit.trial.friction(run.friction, design)).collect::<Vec<_>>(),
            "youngs_modulus_mpa": fit.trial.design(design).material.youngs_modulus,
            "uncertainty": as_written(&uncertainty(fit, design, &input.finger.prony)),
        },
    })
}

/// Numbers of single precision with the digits that they are written with. A JSON value keeps them so or doubles their digits, as another
/// crate in the build would have it.
fn as_written(value: &impl serde::Serialize) -> serde_json::Value {
    serde_json::to_string(value).and_then(|text| serde_json::from_str(&text)).unwrap_or_default()
}

/// The finger file of the first case with the fitted values, their standard deviations in its comments; what was not fitted stays as
/// it was written.
pub fn fitted_finger(input: &Input, fit: &Fit) -> String {
    let design = &input.finger.design;
    let mut remarks = vec!["written by `fre calibrate`; standard deviations in brackets".to_owned()];
    for estimate in &fit.estimates {
        let mut remark = format!(
            "{} = {:.5} ({:.5}) {}",
            estimate.parameter.word(),
            estimate.value,
            estimate.standard_deviation,
            estimate.parameter.unit()
        );
        if !estimate.determined {
            let _ = write!(remark, ", not determined by the data");
        }
        remarks.push(remark);
    }
    remarks.push(
        "zero, travel, friction and object offset belong to the gripper and the case; they are not part of a finger"
            .to_owned(),
    );
    let prony = fit.trial.prony(&input.finger.prony);
    let fitted = Finger { design: fit.trial.design(design), prony, ..input.finger.clone() };
    let mut document = input.document.clone();
    document.set_finger(&fitted);
    document.finger_text(&remarks)
}
