//! How much stiffer a wall between ribs bends than a narrow beam: finite elements in three dimensions beside the model's formula.

use std::fmt::Write;
use std::process::Command;

use anyhow::{Result, bail};
use reference_tests::plates::{folder, spans};

/// Two meshes of one span may differ by so much from one release of CalculiX to the next.
const REPEATS: f64 = 2e-4;

/// Solves every row of `tests/reference/plates.csv` again; none, and a line that says so, where CalculiX is not installed.
pub fn measure() -> Result<String> {
    if Command::new("ccx").arg("-v").output().is_err() {
        return Ok("left out: CalculiX (`ccx`) is not installed; `cargo xtask setup --fea` installs it\n".to_owned());
    }
    let folder = folder().map_err(anyhow::Error::msg)?;
    let mut text = String::from(
        "width,clear,rib,nu,curvature,factor,formula,error_percent (lengths in thicknesses of the wall)\n",
    );
    let mut worst = [0.0_f64; 2];
    for (span, known, fitted) in spans() {
        let found = span.elements(&folder).map_err(anyhow::Error::msg)?;
        let error = span.formula() / found - 1.0;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{},{},{},{},{},{found:.5},{:.5},{:+.2}",
            span.width,
            span.clear,
            span.rib,
            span.nu,
            span.curvature,
            span.formula(),
            100.0 * error
        );
        if (found / known - 1.0).abs() > REPEATS {
            bail!("{span:?}: {found} by finite elements, {known} in the table\n{text}");
        }
        if span.curvature == 0.0 {
            let worst = &mut worst[usize::from(fitted)];
            *worst = worst.max(error.abs());
        }
    }
    let _ = writeln!(
        text,
        "hardly bent: within {:.2} % where the constants were chosen, {:.2} % elsewhere",
        100.0 * worst[1],
        100.0 * worst[0]
    );
    std::fs::remove_dir_all(&folder)?;
    Ok(text)
}
