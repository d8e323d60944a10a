//! Parts of their thickness must not reach into each other.

use model_core::design::{Design, Field, HingeKind};

use super::error::CaseError;
use super::explain::rounded;
use super::source::Table;
use crate::shape::Shape;

/// Places that are looked at between two lamellae.
const BETWEEN: i32 = 24;

/// The beams of their thickness must not reach into each other below the last lamella; above, they merge into the tip, but do not
/// cross.
pub(super) fn beams_apart(table: &Table<'_>, design: &Design) -> Result<(), CaseError> {
    let count = design.lamella_count();
    let mut stations: Vec<[f64; 2]> = vec![[0.0; 2]];
    stations.extend((0..count).map(|lamella| design.attachment_arcs(lamella)));
    stations.push([design.front.length(), design.back.length()]);
    let outwards = [0, 1].map(|axis| design.front.base[axis] - design.back.base[axis]);
    let name = |station: usize| if station == 0 { "the base".to_owned() } else { format!("lamella {station}") };
    for (below, ends) in stations.windows(2).enumerate() {
        let merges = below == count;
        for step in 0..=BETWEEN {
            let part = f64::from(step) / f64::from(BETWEEN);
            let [front, back] = [0, 1].map(|beam| ends[0][beam] + part * (ends[1][beam] - ends[0][beam]));
            let (p, q) = (design.front.point(front), design.back.point(back));
            let way = [p[0] - q[0], p[1] - q[1]];
            let apart = way[0].hypot(way[1]);
            let place = || match step {
                0 => format!("at {}", name(below)),
                BETWEEN if !merges => format!("at {}", name(below + 1)),
                _ if merges => format!("above {}", name(below)),
                _ => format!("between {} and {}", name(below), name(below + 1)),
            };
            if way[0] * outwards[0] + way[1] * outwards[1] < -1e-6 * outwards[0].hypot(outwards[1]) {
                let key = if design.front.sagitta.abs() > design.back.sagitta.abs() { "front" } else { "back" };
                let crosses = format!(
                    "the beams cross {}: the front beam's centreline is {} mm behind the back beam's there",
                    place(),
                    rounded(apart)
                );
                return Err(
                    match [format!("{key}.sagitta_mm"), format!("{key}.tip_mm")]
                        .iter()
                        .find(|key| table.find(key).is_some())
                    {
                        Some(key) => table.refuse(key, crosses),
                        None => table.refuse("back.tip_mm", crosses),
                    },
                );
            }
            let thickness = [design.front.thickness.at(front), design.back.thickness.at(back)];
            if !(merges && step > 0) && 0.5 * (thickness[0] + thickness[1]) >= apart {
                let key = if thickness[0] >= thickness[1] { "front.thickness_mm" } else { "back.thickness_mm" };
                let [front, back, apart, most] = [thickness[0], thickness[1], apart, 2.0 * apart].map(rounded);
                return Err(table.refuse(
                    key,
                    format!(
                        "the beams reach into each other {}: they are {front} and {back} mm thick, their centrelines {apart} mm \
                         apart; both thicknesses together must be less than {most} mm",
                        place()
                    ),
                ));
            }
        }
    }
    Ok(())
}

/// Lamellae and hinges of their thickness must not reach into each other or into the base.
pub(super) fn lamellae_apart(table: &Table<'_>, design: &Design) -> Result<(), CaseError> {
    // A tapered lamella counts with its mean.
    let of = |lamella: usize| {
        let [front, back] = design.lamella_thickness(lamella);
        let mean = 0.5 * (front + back);
        match design.joint() {
            HingeKind::Flexible if design.hinge.thickness > mean => (design.hinge.thickness, "its hinges' thickness"),
            _ => (mean, "its thickness"),
        }
    };
    let arcs = Field::FrontArcs.key();
    let key = if table.find(arcs).is_some() { arcs } else { Field::Heights.key() };
    let refuse = |lamella: usize, reason: String| table.refuse_entry(key, lamella, reason);
    let base = [design.front.base, design.back.base];
    let bars = Shape::undeformed(design).lamellae;
    for (lamella, bar) in bars.iter().enumerate() {
        let (thickness, whose) = of(lamella);
        let (below, what, needed) = match lamella.checked_sub(1).and_then(|before| bars.get(before)) {
            Some(before) => (before, "the lamella below", 0.5 * (thickness + of(lamella - 1).0)),
            None => (&base, "the base", 0.5 * thickness),
        };
        let apart = distance(bar, below);
        if apart < needed - 1e-9 {
            return Err(refuse(
                lamella,
                format!(
                    "its lamella's middle is {} mm from {what}'s; {whose} of {thickness} mm needs {} mm",
                    rounded(apart),
                    rounded(needed)
                ),
            ));
        }
    }
    Ok(())
}

/// Distance of two segments that do not cross.
fn distance(a: &[[f64; 2]; 2], b: &[[f64; 2]; 2]) -> f64 {
    let to_segment = |p: [f64; 2], [q, r]: &[[f64; 2]; 2]| {
        let along = [r[0] - q[0], r[1] - q[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        let part = ((p[0] - q[0]) * along[0] + (p[1] - q[1]) * along[1]) / square.max(f64::MIN_POSITIVE);
        let part = part.clamp(0.0, 1.0);
        (p[0] - q[0] - part * along[0]).hypot(p[1] - q[1] - part * along[1])
    };
    let each = [to_segment(a[0], b), to_segment(a[1], b), to_segment(b[0], a), to_segment(b[1], a)];
    each.into_iter().fold(f64::INFINITY, f64::min)
}
