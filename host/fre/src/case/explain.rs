//! A design error in the file's words: its line, its key, its units.

use model_core::design::{DesignError, Field};

use super::error::CaseError;
use super::source::{Table, Value};

/// A design error in the file's words: its line, its key, its units.
pub(super) fn explain(table: &Table<'_>, error: DesignError) -> CaseError {
    let number = |field: Field, value: f64, reason: String| match table.find(field.key()) {
        Some(found) => found.entry_holding(value).refuse(reason),
        None => table.refuse(field.key(), reason),
    };
    let entry = |field: Field, index: usize, reason: String| table.refuse_entry(field.key(), index, reason);
    match error {
        DesignError::NotFinite { field, value } => number(field, value, "a finite number is needed".into()),
        DesignError::OutOfRange { field, value, min, max } => {
            let reason = format!("allowed is {} to {} mm", rounded(min), rounded(max));
            match table.find(field.key()).and_then(|found| knot_value(&found, value)) {
                Some(knot) => knot.refuse(reason),
                None => number(field, value, reason),
            }
        }
        DesignError::Profile { field, knot } => {
            entry(field, knot, "its position must be larger than its predecessor's".into())
        }
        DesignError::BeamNotUpright { field, rise } => table.refuse(
            field.key(),
            format!(
                "is {} mm above the beam's base; needed is at least 1 mm and more than a tenth of the beam's length",
                rounded(rise)
            ),
        ),
        DesignError::Centreline { field, point, what } => entry(field, point, what.into()),
        DesignError::WeldedToHeld { lamella } => table.refuse(
            "hinge.kind",
            format!(
                "lamella {} (counted from 1 at the base) is rigid, welded, and ends on the held part of the back beam; allowed is \
                 \"flexible\" or \"pinned\"",
                lamella + 1
            ),
        ),
        DesignError::BackNotBehindFront { back_x, front_x } => table
            .refuse(Field::BackBase.key(), format!("x is {back_x}; it must be less than the front beam's {front_x}")),
        DesignError::TipsApart { distance, max } => table.refuse(
            Field::BackTip.key(),
            format!("lies {} mm from front.tip_mm; allowed is up to {} mm", rounded(distance), rounded(max)),
        ),
        DesignError::LamellaCount { front, back } => table.refuse(
            Field::BackArcs.key(),
            format!("has {back} entries, front_arc_mm has {front}; they must be as many"),
        ),
        DesignError::LamellaOutsideBeam { field, lamella, value, above, below } => {
            let allowed = format!("allowed is more than {} and less than {} mm", rounded(above), rounded(below));
            match met(table, field, value) {
                Some(met) => entry(Field::Heights, lamella, format!("{met}; {allowed}")),
                None => entry(field, lamella, format!("lies outside the flexible beam; {allowed}")),
            }
        }
        DesignError::LamellaOrder { field, lamella, value, previous } => {
            let previous = rounded(previous);
            match met(table, field, value) {
                Some(met) => {
                    entry(Field::Heights, lamella, format!("{met}; must be larger than its predecessor's {previous} mm"))
                }
                None => entry(field, lamella, format!("must be larger than its predecessor {previous}")),
            }
        }
        DesignError::HingeCount { found, lamellae } => table.refuse(
            Field::HingeLength.key(),
            format!("has {found} entries; allowed is one for all or one per lamella ({lamellae})"),
        ),
        DesignError::ThicknessCount { found, lamellae } => table.refuse(
            Field::LamellaThickness.key(),
            format!("has {found} entries; allowed is one for all or one per lamella ({lamellae})"),
        ),
        DesignError::GapBeforeHeld { lamella } => table.refuse(
            "lamellae.ends",
            format!(
                "rib {} (counted from 1 at the base) ends at the held part of the back beam; allowed are \"welded\" and \"hinged\" \
                 there, or ribs above back.clamp_mm",
                lamella + 1
            ),
        ),
        DesignError::NoRoomForRib { field, lamella, what, length, needed } => {
            let reason = format!(
                "at rib {} (counted from 1 at the base) {what} is {} mm long; needed is more than {} mm",
                lamella + 1,
                rounded(length),
                rounded(needed)
            );
            entry(field, lamella, reason)
        }
        DesignError::FilletTooLarge { lamella, max, what, .. } => {
            let reason = format!(
                "at rib {} (counted from 1 at the base) at most {} mm is allowed, {what}",
                lamella + 1,
                rounded(max)
            );
            table.refuse(Field::Fillet.key(), reason)
        }
        DesignError::NoRoomForHinges { lamella, width, needed } => {
            let reason = format!(
                "lamella {} (counted from 1 at the base) is {} mm wide, its two hinges need {} mm",
                lamella + 1,
                rounded(width),
                rounded(needed)
            );
            entry(Field::HingeLength, lamella, reason)
        }
    }
}

/// Where an inclined lamella meets a beam, in words, if the file gives its height and angle instead of the arc.
fn met(table: &Table<'_>, field: Field, arc: f64) -> Option<String> {
    let beam = match field {
        Field::FrontArcs => "front",
        Field::BackArcs => "back",
        _ => return None,
    };
    let is_made = table.find(field.key()).is_none();
    is_made.then(|| format!("inclined by angle_deg, the lamella meets the {beam} beam {} mm along it", rounded(arc)))
}

/// The second number of a taper's pair that is this one: a position may be the same number.
fn knot_value<'d>(profile: &Value<'d>, number: f64) -> Option<Value<'d>> {
    let pairs = profile.is_array().then(|| profile.entries(String::new, usize::MAX).ok()).flatten()?;
    let values =
        pairs.iter().filter(|pair| pair.is_array()).filter_map(|pair| pair.entries(String::new, 2).ok()?.pop());
    values.into_iter().find(|value| value.number(String::new).is_ok_and(|found| found.to_bits() == number.to_bits()))
}

/// At most four decimals, for messages.
pub(super) fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}
