//! What a reader of a comparison must know of its two sides.

use model_core::design::{Design, HingeFrom, HingeKind, MaterialLaw, PlaneStrain};
use model_core::discretise::{Physics, Plate, plate_factor};

use super::comparison::Row;
use super::order::Order;
use crate::case::Case;
use crate::draw::short;
use crate::fit::measured::{Measured, Measurement};
use crate::metrics::Point;
use crate::study::place::Place;

/// Measured forces so many times the model's, or the other way round, are probably in another unit.
const DOUBTFUL_RATIO: f64 = 20.0;
/// An outline that covers less of the front beam's length is probably in another unit.
const DOUBTFUL_COVER: f64 = 0.25;

/// What a reader of the results must know of the measurements.
pub(super) fn doubts(
    order: Order,
    case: &Case,
    measured: &Measured,
    measurements: &[Measurement],
    rows: &[Row],
) -> Vec<String> {
    let mut notes = Vec::new();
    if !measured.aside.is_empty() {
        notes.push(format!("columns left aside: {}", measured.aside.join(", ")));
    }
    if order == Order::Closing
        && let Some(line) = measured.turns_at()
    {
        notes.push(format!(
            "the places go back at line {line}; every reading is compared with a closing motion (--order file follows the file)"
        ));
    }
    let known = rows.iter().filter_map(|row| row.force_n.zip(row.reference_force_n));
    let mut ratios: Vec<f64> =
        known.filter(|(force, reference)| *force > 0.0 && *reference > 0.0).map(|(f, r)| r / f).collect();
    ratios.sort_by(f64::total_cmp);
    if let Some(&ratio) = ratios.get(ratios.len() / 2).filter(|r| !(1.0 / DOUBTFUL_RATIO..DOUBTFUL_RATIO).contains(*r))
    {
        notes.push(format!(
            "the measured forces are about {} times the model's: check the units (N, and degrees or mm) and where the case has \
             its object",
            if ratio >= 1.0 { format!("{ratio:.0}") } else { format!("{ratio:.2}") }
        ));
    }
    let length = case.finger.design.front.length();
    for m in measurements.iter().filter(|m| m.front.len() > 1) {
        let span = |part: &[Point]| part.windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).sum::<f64>();
        let span = m.outlines().into_iter().map(|part| span(&m.front[part])).fold(0.0, f64::max);
        if span < DOUBTFUL_COVER * length {
            notes.push(format!(
                "the outline of line {} is {span:.1} mm long, the front beam {length:.1} mm: only that part is compared",
                m.line
            ));
        }
    }
    notes
}

/// What finite elements have otherwise than the model.
pub(super) fn differences(case: &Case, physics: Physics, places: &[Place]) -> Vec<String> {
    let design = &case.finger.design;
    let mut notes = Vec::new();
    if design.material.law != MaterialLaw::StVenantKirchhoff {
        notes.push("the finite elements' material is St. Venant–Kirchhoff; the case has another law".to_owned());
    }
    if physics == Physics::Paper {
        notes.push(
            "the finite elements are the finger as it is built; the model has the simplifications of --physics paper"
                .to_owned(),
        );
    } else if design.joint() == HingeKind::Flexible && design.hinge.from == HingeFrom::Centreline {
        notes.push(
            "finger.hinge.from = \"centreline\": the model's hinges bend from the beams' centrelines, the mesh's necks from the \
             faces"
                .to_owned(),
        );
    }
    notes.extend(plates(design, physics));
    let length = design.front.length();
    let contacts = places.iter().filter_map(|place| place.state.as_ref()).flat_map(|state| &state.shape.contacts);
    if contacts.into_iter().any(|contact| contact.arc > length - TIP) {
        notes.push(format!(
            "the object touches the tip: the model's is round, {} mm beyond the end of the centreline, the mesh's is cut square \
             at that end; pressed on its end, the model touches that much earlier",
            short(0.5 * design.front.thickness.at(length), 3)
        ));
    }
    if design.joint() == HingeKind::Pinned {
        notes.push(
            "pinned lamellae are stiff links between the centrelines in the mesh, and have no thickness there"
                .to_owned(),
        );
    }
    notes
}

/// A contact so near to the end of the front beam, mm, is one of its tip.
const TIP: f64 = 1e-6;

/// What the two sides make of a finger that bends as a plate: the model's physics have the factor in bending only.
fn plates(design: &Design, physics: Physics) -> Option<String> {
    let factor = plate_factor(design, &Plate::of_beam(design, 0, design.front.clamp));
    if physics == Physics::Paper || factor == 1.0 {
        return None;
    }
    match design.plane_strain {
        PlaneStrain::Stress => None,
        PlaneStrain::Auto => Some(format!(
            "finger.plane_strain = \"auto\": beams and necks bend as plates, {factor:.3} times as stiff at the front beam's base, \
             and stretch as bars on both sides; the factor is the model's own in the mesh too (as stiffer outer layers), so it is \
             not put to the test"
        )),
        // Measured on the preset dhas-80 with "strain", Ø80 at (41, 45) mm, by `fre compare --fea`.
        PlaneStrain::Strain => Some(format!(
            "finger.plane_strain = \"strain\": the mesh is in plane strain throughout, {factor:.3} times as stiff in stretch as \
             well; the model has that factor in bending only, as a wide strip with free edges has it, and its force is smaller \
             (dhas-80 on Ø80 at mid-height: by 3.4 % at 2°, 13 % at 10°)"
        )),
    }
}
