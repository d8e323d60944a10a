//! A run as tables for people.

use std::fmt::Write as _;

use crate::case::{Case, Coordinate, Memory};
use crate::study::columns::{AT_TIME, Column, DESIGN, GAINS, RESULTS, RUBBING};
use crate::study::headline::headline;
use crate::study::number::short;
use crate::study::place::Place;
use crate::study::run::Run;
use crate::study::strains::{Limit, percent};

/// Tables, the first branch, and warnings.
pub fn text(case: &Case, run: &Run) -> String {
    let along = case.path.along();
    let mut out = String::new();
    let _ = writeln!(out, "{}", headline(case));
    let _ = writeln!(out, "{}, {} unknowns", run.model.words(), run.model.unknowns);
    if !case.finger.prony.is_empty() {
        let terms: Vec<String> = case.finger.prony.iter().map(|[part, time]| format!("{part} in {time} s")).collect();
        let stays = 1.0 - case.finger.prony.iter().map(|[part, _]| part).sum::<f64>();
        let _ = writeln!(
            out,
            "material with memory{}: of a sudden stress fades {}; {} stays",
            if case.finger.memory == Memory::Force { " (of its force alone)" } else { "" },
            terms.join(", "),
            short(stays)
        );
    }
    out.push('\n');
    table(&mut out, &RESULTS, along, run, |_| true);
    if case.friction > 0.0 {
        let _ = writeln!(
            out,
            "\nfriction {}: sums over the contacts, + where the object pulls the finger towards its tip; the mobilised share is 1 where\n\
             everything slips",
            case.friction
        );
        table(&mut out, &RUBBING, along, run, |place| place.state.is_some());
    }
    let touches = |place: &Place| {
        place.state.as_ref().is_some_and(|state| state.sensitivity.is_some() && state.force_magnitude_n() > 0.0)
    };
    if run.places.iter().any(touches) {
        out.push_str("\nsensitivity of the force's magnitude to\n");
        table(&mut out, &GAINS, along, run, touches);
    }
    out.push_str(
        "\nFor the designer: largest strains at the outer fibres and largest contact pressure; stiffness that the object\n\
         sees, dF/dC: force on it per displacement of it, world frame\n",
    );
    table(&mut out, &DESIGN, along, run, |_| true);
    out.push('\n');
    out.push_str(&first_branch(case, run));
    if case.finger.max_strain.is_none() {
        let limit = percent(Limit::Plausible.share());
        let _ = writeln!(out, "Strains are checked against {limit} %: finger.material.max_strain is not given");
    }
    for warning in &run.warnings {
        let _ = writeln!(out, "warning: {warning}");
    }
    out
}

/// Two lines of headings, then a line per place; words to the left, numbers to the right.
fn table(out: &mut String, columns: &[Column], along: Coordinate, run: &Run, shown: impl Fn(&Place) -> bool) {
    let places: Vec<&Place> = run.places.iter().filter(|place| shown(place)).collect();
    let mut lines = vec![String::new(); 2 + places.len()];
    // A motion that comes back, or holds, meets a place several times: its time says which one it is.
    let timed = run.places.iter().any(|place| place.time_s.is_some());
    let (first, others) = columns.split_at(1.min(columns.len()));
    for column in first.iter().chain(timed.then_some(&AT_TIME)).chain(others) {
        let cells: Vec<String> = column
            .heading(along)
            .into_iter()
            .map(str::to_owned)
            .chain(places.iter().map(|place| column.cell(run, place)))
            .collect();
        let width = cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0);
        for (line, cell) in lines.iter_mut().zip(cells) {
            let _ = if column.is_words() { write!(line, "{cell:<width$}  ") } else { write!(line, "{cell:>width$}  ") };
        }
    }
    for line in lines {
        let _ = writeln!(out, "{}", line.trim_end());
    }
}

/// How far the first branch reaches.
fn first_branch(case: &Case, run: &Run) -> String {
    let unit = case.path.unit();
    let Some(first) = run.first_branch else {
        return "First branch: no trustworthy solution on it\n".to_owned();
    };
    let at = first.max_force_at().map_or_else(String::new, |place| format!(" at {}{unit}", short(place)));
    let end = match (first.snap_between(), run.places.iter().all(|place| place.branch.is_some())) {
        (Some([after, before]), _) => {
            format!("the finger snaps through between {} and {}{unit}", short(after), short(before))
        }
        (None, true) => "the motion meets no snap-through".to_owned(),
        (None, false) => "it is followed up to the first place without a trustworthy solution".to_owned(),
    };
    format!("First branch: largest force {:.4} N{at}; {end}\n", first.max_force_n)
}
