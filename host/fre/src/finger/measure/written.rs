//! A measured finger as a case file, with what it could not decide marked.

use std::fmt::Write as _;

use super::{Measured, MeasuredRung, MeasuredWall, Undecided};

/// Angles below this are none, degrees.
const LEVEL: f64 = 0.05;
/// Measures that differ by less than this are one, mm.
const SAME: f64 = 0.02;
/// Width that stands in for that of a drawing, mm.
const WIDTH: f64 = 20.0;
/// A bar so many times as thick as its necks is rigid beside them.
const RIGID: f64 = 2.0;

/// The case. What is marked `TO DECIDE` is an assumption.
pub fn case_text(measured: &Measured, name: &str) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut out, measured, name);
    out
}

fn write(out: &mut String, measured: &Measured, name: &str) -> std::fmt::Result {
    let name: String = name.chars().filter(|c| !c.is_control() && *c != '"' && *c != '\\').collect();
    writeln!(out, "# A finger measured in its outline. What is marked TO DECIDE is an assumption.")?;
    for Undecided { key, why } in &measured.undecided {
        writeln!(out, "# TO DECIDE {key}: {why}")?;
    }
    writeln!(out, "\n[finger]\nname = \"{name}\"")?;
    match measured.width {
        Some(width) => writeln!(out, "width_mm = {}", number(width))?,
        None => writeln!(out, "width_mm = {}    # TO DECIDE: a drawing has no depth", number(WIDTH))?,
    }
    writeln!(out, "plane_strain = \"auto\"")?;
    writeln!(
        out,
        "\n[finger.material]\nyoungs_modulus_pa = 1e7    # TO DECIDE: a placeholder; forces are proportional to it (fre calibrate)\n\
         poissons_ratio = 0.45    # TO DECIDE: a placeholder"
    )?;
    wall(out, "front", &measured.front)?;
    wall(out, "back", &measured.back)?;
    let hinged = measured.rungs.iter().filter(|rung| rung.necks.is_some()).count();
    let rigid = hinged > 0
        && measured
            .rungs
            .iter()
            .all(|rung| rung.necks.is_some_and(|necks| rung.thickness[0] > RIGID * necks.thickness));
    if !measured.rungs.is_empty() {
        rungs(out, measured, hinged, rigid)?;
    }
    writeln!(out, "\n[finger.tip]\nrigid_above_mm = {}", number(measured.solid_above))?;
    let height = measured.front.centreline.last().map_or(0.0, |tip| tip[1]);
    let face = measured.front.thickness.first().map_or(0.0, |knot| 0.5 * knot[1]);
    writeln!(
        out,
        "\n[object]    # TO DECIDE: an example\nshape = \"circle\"\nradius_mm = {}\ncentre_mm = [{}, {}]",
        number(0.5 * height),
        number(face + 0.5 * height),
        number(0.5 * height)
    )?;
    writeln!(
        out,
        "\n[motion]    # TO DECIDE: an example; a motor needs [finger.motor] axis_mm and motor_angles_deg\ndirection = [1.0, 0.0]\n\
         distances_mm = [1, 2, 3, 4, 5]"
    )
}

fn wall(out: &mut String, key: &str, wall: &MeasuredWall) -> std::fmt::Result {
    writeln!(out, "\n[finger.{key}]")?;
    match wall.centreline.as_slice() {
        [base, tip] => {
            writeln!(out, "base_mm = {}\ntip_mm = {}", pair(*base), pair(*tip))?;
        }
        points => {
            let points: Vec<String> = points.iter().map(|&point| pair(point)).collect();
            writeln!(out, "centreline_mm = [{}]", points.join(", "))?;
        }
    }
    match wall.thickness.as_slice() {
        [[_, thickness]] => writeln!(out, "thickness_mm = {}", number(*thickness))?,
        knots => {
            let knots: Vec<String> = knots.iter().map(|&knot| pair(knot)).collect();
            writeln!(out, "thickness_mm = [{}]", knots.join(", "))?;
        }
    }
    if wall.clamp > 0.0 {
        writeln!(out, "clamp_mm = {}", number(wall.clamp))?;
    }
    Ok(())
}

fn rungs(out: &mut String, measured: &Measured, hinged: usize, rigid: bool) -> std::fmt::Result {
    let rungs = &measured.rungs;
    writeln!(out, "\n[finger.lamellae]")?;
    if hinged > 0 && hinged < rungs.len() {
        writeln!(out, "# TO DECIDE: {hinged} of {} rungs have necks; all are written as if they had", rungs.len())?;
    }
    if !rigid {
        writeln!(out, "kind = \"rib\"\nends = \"{}\"", if hinged > 0 { "hinged" } else { "welded" })?;
    }
    writeln!(out, "heights_mm = {}", list(rungs.iter().map(|rung| rung.height)))?;
    if rungs.iter().any(|rung| rung.angle_deg.abs() > LEVEL) {
        writeln!(out, "angle_deg = {}", one_or_list(rungs.iter().map(|rung| rung.angle_deg).collect(), LEVEL))?;
    }
    let tapers = |rung: &MeasuredRung| (rung.thickness[0] - rung.thickness[1]).abs() > SAME;
    if rigid {
        let bars: Vec<f64> = rungs.iter().map(|rung| rung.thickness[0]).collect();
        let mean = bars.iter().sum::<f64>() / bars.len() as f64;
        writeln!(out, "thickness_mm = {}", number(mean))?;
        if bars.iter().any(|bar| (bar - mean).abs() > 0.1) {
            writeln!(out, "# TO DECIDE: the bars' thicknesses are {}", list(bars.into_iter()))?;
        }
    } else if rungs.iter().any(tapers) {
        let pairs: Vec<String> = rungs.iter().map(|rung| pair(rung.thickness)).collect();
        writeln!(out, "thickness_mm = [{}]", pairs.join(", "))?;
    } else {
        let mean = |rung: &MeasuredRung| 0.5 * (rung.thickness[0] + rung.thickness[1]);
        writeln!(out, "thickness_mm = {}", one_or_list(rungs.iter().map(mean).collect(), SAME))?;
    }
    if measured.fillet > 0.0 {
        writeln!(out, "fillet_mm = {}", number(measured.fillet))?;
    }
    let arcs = |side: usize| list(rungs.iter().map(move |rung| rung.arcs[side]));
    writeln!(out, "# arcs of the axes on the centrelines: front {}, back {}", arcs(0), arcs(1))?;
    writeln!(out, "# clear lengths between the walls' faces: {}", list(rungs.iter().map(|rung| rung.clear)))?;
    if hinged > 0 {
        let necks: Vec<_> = rungs.iter().filter_map(|rung| rung.necks).collect();
        let lengths: Vec<f64> = necks.iter().map(|necks| 0.5 * (necks.lengths[0] + necks.lengths[1])).collect();
        let thickness = necks.iter().map(|necks| necks.thickness).sum::<f64>() / necks.len() as f64;
        writeln!(
            out,
            "\n[finger.hinge]\nkind = \"flexible\"\nlength_mm = {}\nthickness_mm = {}\nfrom = \"face\"",
            one_or_list(lengths, SAME),
            number(thickness)
        )?;
        if necks.iter().any(|necks| (necks.lengths[0] - necks.lengths[1]).abs() > 0.05) {
            writeln!(
                out,
                "# TO DECIDE: front and back necks differ; their mean is written. Front {}, back {}",
                list(necks.iter().map(|necks| necks.lengths[0])),
                list(necks.iter().map(|necks| necks.lengths[1]))
            )?;
        }
        if necks.iter().any(|necks| (necks.thickness - thickness).abs() > 0.05) {
            writeln!(
                out,
                "# TO DECIDE: the necks' thicknesses differ; their mean is written: {}",
                list(necks.iter().map(|necks| necks.thickness))
            )?;
        }
    }
    Ok(())
}

/// With a micrometre's digits, and a point.
fn number(value: f64) -> String {
    let rounded = (1e3 * value).round() / 1e3 + 0.0;
    format!("{rounded:?}")
}

fn pair([x, y]: [f64; 2]) -> String {
    format!("[{}, {}]", number(x), number(y))
}

fn list(values: impl Iterator<Item = f64>) -> String {
    format!("[{}]", values.map(number).collect::<Vec<_>>().join(", "))
}

/// The mean if all are the same.
fn one_or_list(values: Vec<f64>, same: f64) -> String {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    if values.iter().all(|value| (value - mean).abs() <= same) { number(mean) } else { list(values.into_iter()) }
}
