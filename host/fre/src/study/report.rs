//! Results as text, JSON and CSV.

use std::fmt::Write as _;

use model_core::object::{Motion, ObjectDesign};

use crate::case::Case;
use crate::study::pressure::Pressure;
use crate::study::run::{MaxStrain, Solution};
use crate::study::strains::Strains;
use crate::study::warnings;

/// The results as the JSON of the contract.
///
/// # Errors
/// None for results of the solver.
pub fn json(solutions: &[Solution]) -> Result<String, serde_json::Error> {
    let mut text = serde_json::to_string_pretty(solutions)?;
    text.push('\n');
    Ok(text)
}

/// One line per angle; every name carries its unit. Numbers that are not known are empty.
pub fn csv(solutions: &[Solution]) -> String {
    let mut out = String::new();
    for (index, solution) in solutions.iter().enumerate() {
        let fields = fields(solution);
        if index == 0 {
            out.push_str(&fields.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(","));
            out.push('\n');
        }
        out.push_str(&fields.into_iter().map(|(_, value)| value).collect::<Vec<_>>().join(","));
        out.push('\n');
    }
    out
}

/// A result's CSV columns with their values. New columns are added at the end only.
fn fields(solution: &Solution) -> Vec<(&'static str, String)> {
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    let part = |value: Option<[f64; 2]>, i: usize| number(value.map(|v| v[i]));
    let model = &solution.model;
    let rotating = solution.distance_mm.is_none();
    let slope = solution.sensitivity.and_then(|s| s.force_per_deg_n.or(s.force_per_mm_n));
    let by_centre = |axis: usize| solution.sensitivity.map(|s| s.force_per_centre_mm_n[axis]);
    let first = solution.first_branch;
    let snap = first.and_then(|first| first.snap_between());
    vec![
        ("status", solution.status.to_string()),
        (if rotating { "motor_angle_deg" } else { "distance_mm" }, solution.place().to_string()),
        ("force_x_n", part(solution.force_n, 0)),
        ("force_y_n", part(solution.force_n, 1)),
        ("force_n", number(solution.force_magnitude_n)),
        ("force_finger_frame_x_n", part(solution.force_finger_frame_n, 0)),
        ("force_finger_frame_y_n", part(solution.force_finger_frame_n, 1)),
        ("motor_torque_nmm", number(solution.motor_torque_nmm)),
        ("energy_nmm", number(solution.energy_nmm)),
        ("tip_x_mm", part(solution.tip_mm, 0)),
        ("tip_y_mm", part(solution.tip_mm, 1)),
        ("contacts", solution.contacts.len().to_string()),
        ("iterations", solution.iterations.to_string()),
        ("steps", solution.steps.to_string()),
        ("elapsed_us", solution.elapsed_us.to_string()),
        ("scheme", model.scheme.clone()),
        ("elements_per_beam", model.elements_per_beam.to_string()),
        ("elements_per_hinge", model.elements_per_hinge.to_string()),
        ("unknowns", model.unknowns.to_string()),
        ("physics", model.physics.clone()),
        ("precision", model.precision.word().to_owned()),
        ("max_strain_front", number(solution.max_strain.map(|e| e.front))),
        ("max_strain_back", number(solution.max_strain.map(|e| e.back))),
        ("max_strain_hinge", number(solution.max_strain.map(|e| e.hinge))),
        (if rotating { "force_x_per_deg_n" } else { "force_x_per_mm_n" }, part(slope, 0)),
        (if rotating { "force_y_per_deg_n" } else { "force_y_per_mm_n" }, part(slope, 1)),
        ("gap_mm", number(solution.gap_mm)),
        ("force_x_per_centre_x_mm_n", part(by_centre(0), 0)),
        ("force_y_per_centre_x_mm_n", part(by_centre(0), 1)),
        ("force_x_per_centre_y_mm_n", part(by_centre(1), 0)),
        ("force_y_per_centre_y_mm_n", part(by_centre(1), 1)),
        (
            "max_pressure_n_per_mm2",
            number(solution.force_n.map(|_| peak(solution).map_or(0.0, |p| p.pressure_n_per_mm2))),
        ),
        (
            "beyond_max_strain",
            solution.beyond_max_strain.as_ref().map_or_else(String::new, |b| (!b.is_empty()).to_string()),
        ),
        ("branch", solution.branch.map_or_else(String::new, |branch| branch.to_string())),
        ("first_branch_max_force_n", number(first.map(|first| first.max_force_n))),
        (
            if rotating { "first_branch_max_force_at_deg" } else { "first_branch_max_force_at_mm" },
            number(first.and_then(|first| first.max_force_at())),
        ),
        (if rotating { "snap_after_deg" } else { "snap_after_mm" }, part(snap, 0)),
        (if rotating { "snap_before_deg" } else { "snap_before_mm" }, part(snap, 1)),
        ("overlap_mm", number(solution.overlap_mm)),
    ]
}

/// The touching sample under the largest pressure.
fn peak(solution: &Solution) -> Option<&Pressure> {
    solution.contact_pressure.iter().max_by(|a, b| a.pressure_n_per_mm2.total_cmp(&b.pressure_n_per_mm2))
}

/// A table for people.
pub fn text(case: &Case, solutions: &[Solution]) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "{}", headline(case));
    if let Some(solution) = solutions.first() {
        let _ = writeln!(out, "{}, {} unknowns", model_words(solution), solution.model.unknowns);
    }
    out.push('\n');
    let (place, torque) = match case.path.motion {
        Motion::Rotating { .. } => (["angle", "°"], ["torque", "N·mm"]),
        Motion::Translating { .. } => (["distance", "mm"], ["drive", "N"]),
    };
    let number = |value: Option<f64>, decimals: usize| value.map_or("–".to_owned(), |v| fixed(v, decimals));
    let columns = [
        place,
        ["status", ""],
        ["force", "N"],
        ["fx", "N"],
        ["fy", "N"],
        torque,
        ["energy", "N·mm"],
        ["tip x", "mm"],
        ["tip y", "mm"],
        ["strain", "%"],
        ["gap", "mm"],
        ["contacts", ""],
        ["iterations", ""],
        ["time", "ms"],
    ];
    let rows: Vec<[String; 14]> = solutions
        .iter()
        .map(|s| {
            [
                format!("{:.3}", s.place()),
                s.status.to_string(),
                number(s.force_magnitude_n, 4),
                number(s.force_n.map(|f| f[0]), 4),
                number(s.force_n.map(|f| f[1]), 4),
                number(s.motor_torque_nmm, 2),
                number(s.energy_nmm, 3),
                number(s.tip_mm.map(|p| p[0]), 3),
                number(s.tip_mm.map(|p| p[1]), 3),
                number(s.max_strain.map(|e| 100.0 * e.front.max(e.back).max(e.hinge)), 2),
                number(s.gap_mm, 3),
                s.contacts.len().to_string(),
                s.iterations.to_string(),
                format!("{:.2}", s.elapsed_us / 1000.0),
            ]
        })
        .collect();
    table(&mut out, columns, &rows, 1);
    if let Some(slopes) = slopes(case, solutions) {
        out.push_str(&slopes);
    }
    out.push('\n');

    let columns = [
        place,
        ["front", "strain %"],
        ["back", "strain %"],
        ["hinges", "strain %"],
        ["worst hinge", ""],
        ["pressure", "N/mm²"],
        ["dFx/dx", "N/mm"],
        ["dFx/dy", "N/mm"],
        ["dFy/dx", "N/mm"],
        ["dFy/dy", "N/mm"],
    ];
    let rows: Vec<[String; 10]> = solutions
        .iter()
        .map(|s| {
            let strain = |pick: fn(&MaxStrain) -> f64| number(s.max_strain.as_ref().map(|e| 100.0 * pick(e)), 2);
            let by_centre =
                |of: usize, axis: usize| number(s.sensitivity.map(|d| d.force_per_centre_mm_n[axis][of]), 3);
            [
                format!("{:.3}", s.place()),
                strain(|e| e.front),
                strain(|e| e.back),
                strain(|e| e.hinge),
                s.strains.as_ref().and_then(Strains::worst_hinge).unwrap_or_else(|| "–".to_owned()),
                number(peak(s).map(|peak| peak.pressure_n_per_mm2), 4),
                by_centre(0, 0),
                by_centre(0, 1),
                by_centre(1, 0),
                by_centre(1, 1),
            ]
        })
        .collect();
    out.push_str("For the designer: largest strains at the outer fibres and largest contact pressure; stiffness that the object\nsees, dF/dC: force on it per displacement of it, world frame\n");
    table(&mut out, columns, &rows, 4);
    out.push('\n');
    out.push_str(&branch_words(case, solutions));
    if case.finger.max_strain.is_none() {
        out.push_str("Strains are held against no limit: finger.material.max_strain is not given\n");
    }
    for words in warnings::warnings(case, solutions) {
        let _ = writeln!(out, "warning: {words}");
    }
    out
}

/// Heads in two lines, then the rows; the column of words stands to the left, numbers to the right.
fn table<const N: usize>(out: &mut String, columns: [[&str; 2]; N], rows: &[[String; N]], words: usize) {
    let width = |column: usize| {
        let cells = rows.iter().map(|row| row[column].chars().count());
        let heads = columns[column].iter().map(|word| word.chars().count());
        cells.chain(heads).max().unwrap_or(0)
    };
    let mut line = |cells: [&str; N]| {
        let mut text = String::new();
        for (column, cell) in cells.into_iter().enumerate() {
            let width = width(column);
            let _ = if column == words { write!(text, "{cell:<width$}  ") } else { write!(text, "{cell:>width$}  ") };
        }
        let _ = writeln!(out, "{}", text.trim_end());
    };
    line(columns.map(|[name, _]| name));
    line(columns.map(|[_, unit]| unit));
    for row in rows {
        line(std::array::from_fn(|column| row[column].as_str()));
    }
}

/// What the force's magnitude gains per unit of what it depends on; none if nothing touches anywhere.
fn slopes(case: &Case, solutions: &[Solution]) -> Option<String> {
    let rotating = matches!(case.path.motion, Motion::Rotating { .. });
    let (place, per) = if rotating { (["angle", "°"], "N/°") } else { (["distance", "mm"], "N/mm") };
    let columns = [
        place,
        [if rotating { "angle" } else { "distance" }, per],
        ["centre x", "N/mm"],
        ["centre y", "N/mm"],
        ["radius", "N/mm"],
        ["E", "N/MPa"],
        ["front thk.", "N/mm"],
        ["back thk.", "N/mm"],
        ["hinge thk.", "N/mm"],
        ["hinge len.", "N/mm"],
        ["axis x", "N/mm"],
        ["axis y", "N/mm"],
    ];
    let row = |solution: &Solution| -> Option<[String; 12]> {
        let s = solution.sensitivity?;
        let (force, size) = (solution.force_n?, solution.force_magnitude_n.filter(|&size| size > 0.0)?);
        let cell = |slope: Option<[f64; 2]>| {
            slope.map_or("–".to_owned(), |[x, y]| fixed((x * force[0] + y * force[1]) / size, 4))
        };
        Some([
            format!("{:.3}", solution.place()),
            cell(s.force_per_deg_n.or(s.force_per_mm_n)),
            cell(Some(s.force_per_centre_mm_n[0])),
            cell(Some(s.force_per_centre_mm_n[1])),
            cell(Some(s.force_per_radius_mm_n)),
            cell(Some(s.force_per_youngs_modulus_mpa_n)),
            cell(s.force_per_front_thickness_mm_n),
            cell(s.force_per_back_thickness_mm_n),
            cell(s.force_per_hinge_thickness_mm_n),
            cell(s.force_per_hinge_length_mm_n),
            cell(Some(s.force_per_motor_axis_mm_n[0])),
            cell(Some(s.force_per_motor_axis_mm_n[1])),
        ])
    };
    let rows: Vec<_> = solutions.iter().filter_map(row).collect();
    if rows.is_empty() {
        return None;
    }
    let mut out = "\nsensitivity of the force's magnitude to\n".to_owned();
    table(&mut out, columns, &rows, usize::MAX);
    Some(out)
}

/// How far the first branch reaches.
fn branch_words(case: &Case, solutions: &[Solution]) -> String {
    let unit = case.path.unit();
    let Some(first) = solutions.first().and_then(|solution| solution.first_branch) else {
        return "First branch: no trustworthy solution on it\n".to_owned();
    };
    let at = first.max_force_at().map_or_else(String::new, |place| format!(" at {}{unit}", short(place)));
    let end = match (first.snap_between(), solutions.iter().all(|solution| solution.branch.is_some())) {
        (Some([after, before]), _) => {
            format!("the finger snaps through between {} and {}{unit}", short(after), short(before))
        }
        (None, true) => "the motion meets no snap-through".to_owned(),
        (None, false) => "it is followed up to the first place without a trustworthy solution".to_owned(),
    };
    format!("First branch: largest force {:.4} N{at}; {end}\n", first.max_force_n)
}

/// A number of decimals; what rounds to zero has no sign.
fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|letter| "0.".contains(letter)) => digits.to_owned(),
        _ => text,
    }
}

/// At most three decimals.
pub(crate) fn short(value: f64) -> f64 {
    (1e3 * value).round() / 1e3 + 0.0
}

/// Finger and object in words.
pub(crate) fn headline(case: &Case) -> String {
    let at = |[x, y]: [f64; 2]| format!("at ({x}, {y}) mm");
    let object = match case.object {
        ObjectDesign::Circle { centre, radius } => format!("a cylinder Ø{} mm {}", 2.0 * radius, at(centre)),
        ObjectDesign::Ellipse { centre, semi_axes: [a, b], angle } => {
            let turned = if angle == 0.0 {
                String::new()
            } else {
                format!(" turned by {}°", (1e6 * angle.to_degrees()).round() / 1e6)
            };
            format!("an ellipse {} × {} mm {}{turned}", 2.0 * a, 2.0 * b, at(centre))
        }
        ObjectDesign::Polygon { corners, rounding } => {
            let corner = if corners.len() == 1 { "corner" } else { "corners" };
            format!("a polygon of {} {corner}, rounding {rounding} mm", corners.len())
        }
        ObjectDesign::HalfPlane { point, normal: [x, y] } => format!("a wall {}, normal ({x}, {y})", at(point)),
        ObjectDesign::Bore { centre, radius } => format!("a bore Ø{} mm {}", 2.0 * radius, at(centre)),
    };
    format!("{} on {object}", case.finger.name)
}

/// The model in words.
pub(crate) fn model_words(solution: &Solution) -> String {
    let model = &solution.model;
    format!(
        "scheme {} {}/{}, physics {}, {}",
        model.scheme,
        model.elements_per_beam,
        model.elements_per_hinge,
        model.physics,
        model.precision.word()
    )
}

#[cfg(test)]
mod tests {
    use super::fixed;

    #[test]
    fn what_rounds_to_zero_has_no_sign() {
        assert_eq!(
            [fixed(-4e-5, 4), fixed(-6e-5, 4), fixed(0.0, 2), fixed(-12.3, 1)],
            ["0.0000", "-0.0001", "0.00", "-12.3"]
        );
    }
}
