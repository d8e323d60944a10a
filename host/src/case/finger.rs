//! The `[finger]` table: a design in the solver's units.

use model_core::design::{
    Attachments, Beam, Design, DesignError, Field, Hinge, HingeFrom, HingeKind, Lamellae, MAX_KNOTS, MAX_LAMELLAE,
    Material, MaterialLaw, PlaneStrain, Profile,
};

use super::document::{Table, Value};
use super::error::CaseError;
use crate::shape::Shape;

/// Pascal per megapascal (N/mm²), the solver's unit.
const PA_PER_MPA: f64 = 1e6;

/// A finger as a file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Finger {
    /// Name for titles and tables.
    pub name: String,
    /// The design, validated.
    pub design: Design,
    /// False if the file gives no motor axis: such a finger can only be moved along a line.
    pub has_motor: bool,
    /// The strain that the material bears, dimensionless; none if it is not known.
    pub max_strain: Option<f64>,
}

/// Limits of a material's strain: below the first nothing bends, above the second nothing is left of small strains.
const MAX_STRAIN: std::ops::RangeInclusive<f64> = 1e-5..=10.0;

/// Reads and validates the table; `name` stands in for a missing one.
pub(super) fn read(table: Table<'_>, name: &str) -> Result<Finger, CaseError> {
    let table = table.only(&[
        "name",
        "width_mm",
        "plane_strain",
        "material",
        "front",
        "back",
        "lamellae",
        "hinge",
        "tip",
        "motor",
    ])?;
    let name = match table.get("name") {
        Some(value) => value.text()?.to_owned(),
        None => name.to_owned(),
    };
    let lamellae = lamellae(&table)?;
    if table.has("hinge") && !table.has("lamellae") {
        return Err(
            table.missing("lamellae", "a table with heights_mm beside hinge (heights_mm = [] for a finger without)")
        );
    }
    let motor = match table.get("motor") {
        Some(motor) => {
            let motor = motor.table()?.only(&["axis_mm"])?;
            Some(motor.need("axis_mm", "the motor axis, [x, y] in mm")?.pair("[x, y] in mm")?)
        }
        None => None,
    };
    let rigid_above = match table.get("tip") {
        Some(tip) => tip.table()?.only(&["rigid_above_mm"])?.get("rigid_above_mm").map(|v| v.number()).transpose()?,
        None => None,
    };
    let plane_strain = match table.get("plane_strain") {
        Some(word) => word.choice(&[
            ("stress", PlaneStrain::Stress),
            ("strain", PlaneStrain::Strain),
            ("auto", PlaneStrain::Auto),
        ])?,
        None => PlaneStrain::Auto,
    };
    let (material, max_strain) = material(&table)?;
    let design = Design {
        width: profile(&table.need("width_mm", "a number of mm, or a taper [[height_mm, width_mm], …]")?)?,
        plane_strain,
        material,
        front: beam(&table, "front")?,
        back: beam(&table, "back")?,
        hinge: hinge(&table, !lamellae.attachments.is_empty())?,
        lamellae,
        rigid_above,
        motor_axis: motor.unwrap_or([0.0, 0.0]),
    };
    design.validate().map_err(|error| explain(&table, error))?;
    beams_apart(&table, &design)?;
    lamellae_apart(&table, &design)?;
    Ok(Finger { name, design, has_motor: motor.is_some(), max_strain })
}

/// The material, and the strain that it bears.
fn material(finger: &Table<'_>) -> Result<(Material, Option<f64>), CaseError> {
    let table = finger.need("material", "a table with youngs_modulus_pa and poissons_ratio")?.table()?;
    let table = table.only(&["youngs_modulus_pa", "poissons_ratio", "law", "max_strain"])?;
    let law = match table.get("law") {
        Some(value) => value.choice(&[
            ("st-venant-kirchhoff", MaterialLaw::StVenantKirchhoff),
            ("neo-hookean", MaterialLaw::NeoHookean),
            ("linear", MaterialLaw::Linear),
        ])?,
        None => MaterialLaw::default(),
    };
    let material = Material {
        youngs_modulus: table.need("youngs_modulus_pa", "a number of Pa")?.number()? / PA_PER_MPA,
        poissons_ratio: table.need("poissons_ratio", "a number from 0 to 0.499")?.number()?,
        law,
    };
    let max_strain = match table.get("max_strain") {
        Some(value) => match value.number()? {
            limit if MAX_STRAIN.contains(&limit) => Some(limit),
            _ => {
                let (least, most) = MAX_STRAIN.into_inner();
                return Err(value.refuse(format!("allowed is {least} to {most} (a share: 0.05 is 5 %)")));
            }
        },
        None => None,
    };
    Ok((material, max_strain))
}

fn beam(finger: &Table<'_>, key: &'static str) -> Result<Beam, CaseError> {
    let table = finger.need(key, "a table with base_mm, tip_mm and thickness_mm")?.table()?;
    let table = table.only(&["base_mm", "tip_mm", "sagitta_mm", "thickness_mm", "stiffness_factor"])?;
    let point = |key, what| table.need(key, what)?.pair("[x, y] in mm");
    Ok(Beam {
        base: point("base_mm", "the start of the centreline, [x, y] in mm")?,
        tip: point("tip_mm", "the end of the centreline, [x, y] in mm")?,
        sagitta: table.get("sagitta_mm").map_or(Ok(0.0), |value| value.number())?,
        thickness: profile(&table.need("thickness_mm", "a number of mm, or a taper [[arc_mm, thickness_mm], …]")?)?,
        stiffness_factor: table.get("stiffness_factor").map_or(Ok(1.0), |value| value.number())?,
    })
}

fn lamellae(finger: &Table<'_>) -> Result<Lamellae, CaseError> {
    let none = Lamellae { attachments: Attachments::Heights(heapless::Vec::new()), thickness: 1.0 };
    let Some(value) = finger.get("lamellae") else {
        return Ok(none);
    };
    let table = value.table()?.only(&["heights_mm", "front_arc_mm", "back_arc_mm", "thickness_mm"])?;
    let attachments = match (table.get("heights_mm"), table.get("front_arc_mm"), table.get("back_arc_mm")) {
        (Some(heights), None, None) => Attachments::Heights(bounded(&heights)?),
        (None, Some(front), Some(back)) => Attachments::Arcs { front: bounded(&front)?, back: bounded(&back)? },
        (Some(_), _, _) => {
            return Err(table
                .refuse("heights_mm", "cannot stand beside front_arc_mm or back_arc_mm; allowed is one or the other"));
        }
        (None, Some(_), None) => {
            return Err(table.missing("back_arc_mm", "an array of mm beside front_arc_mm"));
        }
        (None, None, Some(_)) => {
            return Err(table.missing("front_arc_mm", "an array of mm beside back_arc_mm"));
        }
        (None, None, None) => {
            return Err(table.missing("heights_mm", "an array of mm, or front_arc_mm and back_arc_mm"));
        }
    };
    if attachments.is_empty() {
        return Ok(none);
    }
    Ok(Lamellae { attachments, thickness: table.need("thickness_mm", "a number of mm")?.number()? })
}

fn hinge(finger: &Table<'_>, needed: bool) -> Result<Hinge, CaseError> {
    let value = match finger.get("hinge") {
        Some(value) => value,
        None if needed => {
            return Err(
                finger.missing("hinge", "a table with length_mm and thickness_mm, or kind = \"pinned\" or \"welded\"")
            );
        }
        None => {
            let (kind, from) = (HingeKind::Welded, HingeFrom::Centreline);
            return Ok(Hinge { kind, length: heapless::Vec::new(), thickness: 1.0, from });
        }
    };
    let table = value.table()?.only(&["kind", "length_mm", "thickness_mm", "from"])?;
    let kind = match table.get("kind") {
        Some(word) => word.choice(&[
            ("flexible", HingeKind::Flexible),
            ("pinned", HingeKind::Pinned),
            ("welded", HingeKind::Welded),
        ])?,
        None => HingeKind::Flexible,
    };
    let from = match table.get("from") {
        Some(word) => word.choice(&[("centreline", HingeFrom::Centreline), ("face", HingeFrom::Face)])?,
        None => HingeFrom::Centreline,
    };
    let flexible = needed && kind == HingeKind::Flexible;
    let length = match table.get("length_mm") {
        Some(value) if value.is_array() => bounded(&value)?,
        Some(value) => heapless::Vec::from_slice(&[value.number()?]).unwrap_or_default(),
        None if flexible => {
            return Err(table.missing("length_mm", "a number of mm, or one per lamella"));
        }
        None => heapless::Vec::new(),
    };
    let thickness = match table.get("thickness_mm") {
        Some(value) => value.number()?,
        None if flexible => return Err(table.missing("thickness_mm", "a number of mm")),
        None => 1.0,
    };
    Ok(Hinge { kind, length, thickness, from })
}

/// A list with at most one entry per lamella.
fn bounded(value: &Value<'_>) -> Result<heapless::Vec<f64, MAX_LAMELLAE>, CaseError> {
    let numbers = value.numbers(MAX_LAMELLAE)?;
    heapless::Vec::from_slice(&numbers)
        .map_err(|_| value.refuse(format!("has {} entries; at most {MAX_LAMELLAE} are allowed", numbers.len())))
}

/// A number, or an array of pairs.
fn profile(value: &Value<'_>) -> Result<Profile, CaseError> {
    if !value.is_array() {
        return Ok(Profile::constant(value.number()?));
    }
    let mut knots = heapless::Vec::new();
    for entry in value.entries("an array of pairs", MAX_KNOTS)? {
        let full = |_| value.refuse(format!("at most {MAX_KNOTS} pairs are allowed"));
        knots.push(entry.pair("a pair [position_mm, value_mm]")?).map_err(full)?;
    }
    if knots.is_empty() {
        return Err(value.refuse("is empty; needed is at least one pair [position_mm, value_mm]"));
    }
    Ok(Profile { knots })
}

/// Places that are looked at between two lamellae.
const BETWEEN: i32 = 24;

/// The beams of their thickness must not reach into each other below the last lamella; above, they merge into the tip, but do not
/// cross.
fn beams_apart(table: &Table<'_>, design: &Design) -> Result<(), CaseError> {
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
fn lamellae_apart(table: &Table<'_>, design: &Design) -> Result<(), CaseError> {
    let (thickness, whose) = match design.hinge.kind {
        HingeKind::Flexible if design.hinge.thickness > design.lamellae.thickness => {
            (design.hinge.thickness, "its hinges' thickness")
        }
        _ => (design.lamellae.thickness, "its thickness"),
    };
    let key = match design.lamellae.attachments {
        Attachments::Heights(_) => "lamellae.heights_mm",
        Attachments::Arcs { .. } => "lamellae.front_arc_mm",
    };
    let refuse = |lamella: usize, reason: String| {
        let entries = table.find(key).and_then(|value| value.entries("", usize::MAX).ok());
        match entries.as_ref().and_then(|entries| entries.get(lamella)) {
            Some(value) => value.refuse(reason),
            None => table.refuse(key, reason),
        }
    };
    let base = [design.front.base, design.back.base];
    let bars = Shape::undeformed(design).lamellae;
    for (lamella, bar) in bars.iter().enumerate() {
        let (below, what, needed) = match lamella.checked_sub(1).and_then(|before| bars.get(before)) {
            Some(before) => (before, "the lamella below", thickness),
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

/// A design error in the file's words: its line, its key, its units.
fn explain(table: &Table<'_>, error: DesignError) -> CaseError {
    let number = |field: Field, value: f64, reason: String| match table.find(field.key()) {
        Some(found) => found.entry_holding(value).refuse(reason),
        None => table.refuse(field.key(), reason),
    };
    let entry = |field: Field, index: usize, reason: String| {
        let entries = table.find(field.key()).and_then(|value| value.entries("", usize::MAX).ok());
        match entries.as_ref().and_then(|entries| entries.get(index)) {
            Some(value) => value.refuse(reason),
            None => table.refuse(field.key(), reason),
        }
    };
    match error {
        DesignError::NotFinite { field, value } => number(field, value, "a finite number is needed".into()),
        DesignError::OutOfRange { field: Field::YoungsModulus, min, max, .. } => table.refuse(
            Field::YoungsModulus.key(),
            format!("allowed is {:e} to {:e} Pa", min * PA_PER_MPA, max * PA_PER_MPA),
        ),
        DesignError::OutOfRange {
            field: field @ (Field::PoissonsRatio | Field::FrontStiffness | Field::BackStiffness),
            min,
            max,
            ..
        } => table.refuse(field.key(), format!("allowed is {min} to {max}")),
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
        DesignError::LamellaOutsideBeam { field, lamella, above, below, .. } => entry(
            field,
            lamella,
            format!(
                "lies outside the flexible beam; allowed is more than {} and less than {} mm",
                rounded(above),
                rounded(below)
            ),
        ),
        DesignError::LamellaOrder { field, lamella, previous, .. } => {
            entry(field, lamella, format!("must be larger than its predecessor {previous}"))
        }
        DesignError::HingeCount { found, lamellae } => table.refuse(
            Field::HingeLength.key(),
            format!("has {found} entries; allowed is one for all or one per lamella ({lamellae})"),
        ),
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

/// The second number of a taper's pair that is this one: a position may be the same number.
fn knot_value<'d>(profile: &Value<'d>, number: f64) -> Option<Value<'d>> {
    let pairs = profile.is_array().then(|| profile.entries("", usize::MAX).ok()).flatten()?;
    let values = pairs.iter().filter(|pair| pair.is_array()).filter_map(|pair| pair.entries("", 2).ok()?.pop());
    values.into_iter().find(|value| value.number().is_ok_and(|found| found.to_bits() == number.to_bits()))
}

/// At most four decimals, for messages.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}
