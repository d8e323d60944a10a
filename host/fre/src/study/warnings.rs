//! What a designer must not overlook: what the model leaves out or reads otherwise than it may be meant, and parts strained beyond
//! what the material bears.

use model_core::design::{HingeKind, Profile};
use model_core::status::Status;

use crate::case::Case;
use crate::study::overlap;
use crate::study::report::short;
use crate::study::run::Solution;
use crate::study::strains::Beyond;

/// How far beyond an end a taper may reach, as a part of its length: roundings of a drawing's measures.
const BEYOND: f64 = 0.01;

/// One sentence each, the finger's own first; without solutions those of the case alone.
pub fn warnings(case: &Case, solutions: &[Solution]) -> Vec<String> {
    left_out(case)
        .into_iter()
        .chain(tapers(case))
        .chain(lost(case, solutions))
        .chain(reached(case, solutions))
        .chain(strained(case, solutions))
        .collect()
}

/// What the model leaves out of a finger, so much that its forces are wrong by more than a few percent.
fn left_out(case: &Case) -> Option<String> {
    // Measured on the preset fea-80 with welded lamellae, by `fre compare --fea`.
    let design = &case.finger.design;
    (design.hinge.kind == HingeKind::Welded && design.lamella_count() > 0).then(|| {
        "finger.hinge.kind = \"welded\": the model's lamellae are rigid, real ones bend with the beams; the force is too large \
         (by 22 % for fea-80 with lamellae of 3 mm; `fre compare --fea` tells for this case)"
            .to_owned()
    })
}

/// Tapers whose ends do not lie on the finger: what is written there is not what is there.
fn tapers(case: &Case) -> Vec<String> {
    let design = &case.finger.design;
    let heights = [design.front.base, design.back.base, design.front.tip, design.back.tip].map(|[_, y]| y);
    let lowest = heights.into_iter().fold(f64::INFINITY, f64::min);
    let highest = heights.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let mut found = Vec::new();
    for (key, profile, [from, to]) in [
        ("width_mm", &design.width, [lowest, highest]),
        ("front.thickness_mm", &design.front.thickness, [0.0, design.front.length()]),
        ("back.thickness_mm", &design.back.thickness, [0.0, design.back.length()]),
    ] {
        let slack = BEYOND * (to - from);
        for [position, value] in ends(profile) {
            let (end, place) = match position {
                below if below < from - slack => (from, "base"),
                above if above > to + slack => (to, "tip"),
                _ => continue,
            };
            found.push(format!(
                "finger.{key}: {} mm at {} mm lies beyond the {place}, which is at {} mm: there it is {} mm",
                short(value),
                short(position),
                short(end),
                short(profile.at(end))
            ));
        }
    }
    found
}

/// First and last knot of a taper.
fn ends(profile: &Profile) -> Vec<[f64; 2]> {
    match profile.knots.as_slice() {
        [first, .., last] => vec![*first, *last],
        _ => Vec::new(),
    }
}

/// Why there is no number from the first place on that is out of range.
fn lost(case: &Case, solutions: &[Solution]) -> Option<String> {
    let place = solutions.iter().find(|solution| solution.status == Status::OutOfRange)?.place();
    let why = if overlap::covers_base(case, place) {
        "the object is in the way of the finger's clamped base"
    } else {
        "the finger has slipped off the object and past it, has it behind its front beam, or came against it with its clamped base on \
         the way"
    };
    Some(format!(
        "at {}{}: out-of-range: {why}; what follows is known again once the hand was open",
        short(place),
        case.path.unit()
    ))
}

/// Parts that an object reaches into.
fn reached(case: &Case, solutions: &[Solution]) -> Vec<String> {
    let words = |found: overlap::Overlap| {
        format!(
            "the object reaches {:.1} mm into {} (at {}{}), where the model knows no contact: check where the case has it",
            found.depth,
            found.part,
            short(found.place),
            case.path.unit()
        )
    };
    overlap::worst(case, solutions).into_iter().map(words).collect()
}

/// Parts strained beyond the limit, each with its worst place.
fn strained(case: &Case, solutions: &[Solution]) -> Vec<String> {
    let unit = case.path.unit();
    let mut worst: Vec<(&str, &Beyond, f64)> = Vec::new();
    for solution in solutions {
        for beyond in solution.beyond_max_strain.iter().flatten() {
            // Beams are named with the arc of their worst section: one warning per beam.
            let part = beyond.part.split(" at ").next().unwrap_or_default();
            match worst.iter_mut().find(|(known, ..)| *known == part) {
                Some((_, most, _)) if most.strain >= beyond.strain => {}
                Some((_, most, place)) => (*most, *place) = (beyond, solution.place()),
                None => worst.push((part, beyond, solution.place())),
            }
        }
    }
    worst.sort_by(|a, b| b.1.strain.total_cmp(&a.1.strain));
    worst.into_iter().map(|(_, beyond, place)| format!("{beyond} (at {}{unit})", short(place))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(change: impl FnOnce(&mut model_core::design::Design)) -> Vec<String> {
        let text = "finger = \"preset:ladder-80\"\nobject = { shape = \"circle\", radius_mm = 40, centre_mm = [41, 45] }\n\
                    motion.motor_angles_deg = [2]\n";
        let mut case = Case::parse("case.toml", text).unwrap();
        change(&mut case.finger.design);
        warnings(&case, &[])
    }

    fn taper(knots: &[[f64; 2]]) -> Profile {
        Profile { knots: heapless::Vec::from_slice(knots).unwrap() }
    }

    #[test]
    fn a_taper_beyond_the_finger_is_warned_of() {
        let clear = [
            told(|d| d.front.thickness = taper(&[[0.0, 2.0], [80.5, 1.0]])),
            told(|d| d.width = taper(&[[10.0, 22.0], [70.0, 18.0]])),
            told(|d| d.back.thickness = taper(&[[500.0, 2.0]])),
        ];
        assert_eq!(clear, [const { Vec::<String>::new() }; 3]);
        assert_eq!(
            told(|d| d.front.thickness = taper(&[[0.0, 2.0], [160.0, 1.0]])),
            ["finger.front.thickness_mm: 1 mm at 160 mm lies beyond the tip, which is at 80 mm: there it is 1.5 mm"]
        );
        assert_eq!(
            told(|d| d.width = taper(&[[-80.0, 24.0], [80.0, 16.0]])),
            ["finger.width_mm: 24 mm at -80 mm lies beyond the base, which is at 0 mm: there it is 20 mm"]
        );
    }
}
