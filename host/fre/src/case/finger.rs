//! A finger: the keys of `[finger]` as a design in the solver's units, and back.

use model_core::design::{
    Attachments, Beam, Design, Hinge, HingeFrom, HingeKind, LamellaKind, Lamellae, Material, MaterialLaw, PlaneStrain,
    Profile, RibEnds, Ribs,
};
use model_core::equilibrium::{PRONY_PARTS, PRONY_TIMES};

use super::check;
use super::error::CaseError;
use super::explain::explain;
use super::fits;
use super::inclined;
use super::keys::{
    self, Along, BeamTable, FingerTable, HingeTable, LamellaeTable, Memory, PerRib, RibThickness, TipFrom, TipTable,
    TipWord,
};
use super::source::Table;
use crate::faces;
use crate::visible::visible;

/// Pascal per megapascal (N/mm²), the solver's unit.
pub(super) const PA_PER_MPA: f64 = 1e6;
/// Thickness, mm, that a design's hinges have where a file gives none: there they have no necks.
pub(crate) const NO_NECK: f64 = 1.0;

/// A finger as a file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Finger {
    /// Name for titles and tables.
    pub name: String,
    /// The design, validated.
    pub design: Design,
    /// True if the rigid tip begins where the beams' inner faces meet (`rigid_above_mm = "auto"`), so that it moves with their thicknesses.
    pub is_tip_auto: bool,
    /// False if the file gives no motor axis: such a finger can only be moved along a line.
    pub has_motor: bool,
    /// The strain that the material bears, dimensionless; none if it is not known.
    pub max_strain: Option<f64>,
    /// Terms [gᵢ, τᵢ in s] of a material with memory; none of an elastic one.
    pub prony: Vec<[f64; 2]>,
    /// What of it remembers.
    pub memory: Memory,
}

/// Reads the keys of a finger's table that is to be drawn or meshed.
pub(super) fn describe(table: &Table<'_>, name: &str) -> Result<FingerTable, CaseError> {
    check::table(table, keys::finger_schema())?;
    let mut keys: FingerTable = table.read()?;
    keys.name.get_or_insert_with(|| name.to_owned());
    Ok(keys)
}

/// Reads and validates a finger's table; `name` stands in for a missing one.
pub(super) fn read(table: &Table<'_>, name: &str) -> Result<Finger, CaseError> {
    check::table(table, keys::finger_schema())?;
    build(&table.read()?, table, name)
}

/// The finger of a table that the schema's check has passed.
pub(super) fn build(keys: &FingerTable, table: &Table<'_>, name: &str) -> Result<Finger, CaseError> {
    // A name is printed: an escape sequence in it would be obeyed by the terminal.
    if keys.name.as_ref().is_some_and(|name| name.contains(char::is_control)) {
        return Err(table.refuse("name", "has control characters; allowed is a text without them, in one line"));
    }
    let front = beam(&keys.front, table.child("front"), table)?;
    let back = beam(&keys.back, table.child("back"), table)?;
    let lamellae = lamellae(keys.lamellae.as_ref(), table, [&front, &back])?;
    if keys.hinge.is_some() && keys.lamellae.is_none() {
        return Err(
            table.missing("lamellae", "a table with heights_mm beside hinge (heights_mm = [] for a finger without)")
        );
    }
    let tip = keys.tip.as_ref().and_then(|tip| tip.rigid_above_mm);
    let mut design = Design {
        width: profile(&keys.width_mm),
        plane_strain: match keys.plane_strain {
            keys::PlaneStrain::Stress => PlaneStrain::Stress,
            keys::PlaneStrain::Strain => PlaneStrain::Strain,
            keys::PlaneStrain::Auto => PlaneStrain::Auto,
        },
        material: Material {
            youngs_modulus: keys.material.youngs_modulus_pa / PA_PER_MPA,
            poissons_ratio: keys.material.poissons_ratio,
            law: match keys.material.law {
                keys::MaterialLaw::StVenantKirchhoff => MaterialLaw::StVenantKirchhoff,
                keys::MaterialLaw::NeoHookean => MaterialLaw::NeoHookean,
                keys::MaterialLaw::Linear => MaterialLaw::Linear,
            },
        },
        front,
        back,
        hinge: hinge(keys.hinge.as_ref(), table, &lamellae)?,
        lamellae,
        rigid_above: match tip {
            Some(TipFrom::Height(height)) => Some(height),
            Some(TipFrom::Word(TipWord::Auto)) | None => None,
        },
        motor_axis: keys.motor.as_ref().map_or([0.0, 0.0], |motor| motor.axis_mm),
    };
    design.validate().map_err(|error| explain(table, error))?;
    if tip == Some(TipFrom::Word(TipWord::Auto)) {
        // Of beams that are good ones.
        let height = faces::solid_above(&design.front, &design.back).ok_or_else(|| {
            let reason =
                "the beams' inner faces do not meet below the tip; allowed is a number of mm, or no [finger.tip]";
            table.refuse("tip.rigid_above_mm", reason)
        })?;
        design.rigid_above = Some(height);
        design.validate().map_err(|error| explain(table, error))?;
    }
    fits::beams_apart(table, &design)?;
    fits::lamellae_apart(table, &design)?;
    Ok(Finger {
        name: keys.name.clone().unwrap_or_else(|| visible(name)),
        design,
        is_tip_auto: tip == Some(TipFrom::Word(TipWord::Auto)),
        has_motor: keys.motor.is_some(),
        max_strain: keys.material.max_strain,
        prony: prony(keys.material.prony.as_deref().unwrap_or_default(), table)?,
        memory: keys.material.memory.unwrap_or_default(),
    })
}

/// The terms of a material with memory.
fn prony(terms: &[(f64, f64)], finger: &Table<'_>) -> Result<Vec<[f64; 2]>, CaseError> {
    let table = finger.child("material").unwrap_or_else(|| finger.clone());
    let list = table.find("prony");
    for (index, &(part, time)) in terms.iter().enumerate() {
        for (at, name, value, [least, most], unit) in
            [(0, "gᵢ", part, PRONY_PARTS, ""), (1, "τᵢ", time, PRONY_TIMES, " s")]
        {
            if !(least..=most).contains(&value) {
                let reason = format!("{name}: allowed is {}{unit}", check::range(least, most));
                let entry =
                    list.as_ref().and_then(|list| list.entries(String::new, usize::MAX).ok()?.into_iter().nth(index));
                let number =
                    entry.as_ref().and_then(|pair| pair.entries(String::new, usize::MAX).ok()?.into_iter().nth(at));
                return Err(number.map_or_else(|| table.refuse("prony", &*reason), |number| number.refuse(&*reason)));
            }
        }
    }
    let sum: f64 = terms.iter().map(|(part, _)| part).sum();
    if sum > PRONY_PARTS[1] {
        let reason = format!("Σ gᵢ is {}; allowed is up to {}", (1e6 * sum).round() / 1e6, PRONY_PARTS[1]);
        return Err(table.refuse("prony", reason));
    }
    Ok(terms.iter().map(|&(part, time)| [part, time]).collect())
}

fn beam(keys: &BeamTable, table: Option<Table<'_>>, finger: &Table<'_>) -> Result<Beam, CaseError> {
    let table = table.as_ref().unwrap_or(finger);
    let end = |place: Option<[f64; 2]>, key: &str, which: &str| {
        place.ok_or_else(|| table.missing(key, &format!("[x, y] in mm, the {which} of the centreline")))
    };
    let (base, via, tip) = match keys.centreline_mm.as_deref() {
        None => (end(keys.base_mm, "base_mm", "start")?, &[][..], end(keys.tip_mm, "tip_mm", "end")?),
        Some([base, via @ .., tip]) => {
            for (key, given) in [
                ("base_mm", keys.base_mm.is_some()),
                ("tip_mm", keys.tip_mm.is_some()),
                ("sagitta_mm", keys.sagitta_mm != 0.0),
            ] {
                if given {
                    return Err(
                        table.refuse(key, "cannot be given together with centreline_mm; allowed is one or the other")
                    );
                }
            }
            (*base, via, *tip)
        }
        // The schema's check refuses fewer than two points before.
        Some(_) => return Err(table.refuse("centreline_mm", "needed are two points or more")),
    };
    Ok(Beam {
        sagitta: keys.sagitta_mm,
        via: via.iter().copied().collect(),
        stiffness_factor: keys.stiffness_factor,
        bending_factor: keys.bending_factor,
        stretch_factor: keys.stretch_factor,
        clamp: keys.clamp_mm,
        ..Beam::straight(base, tip, profile(&keys.thickness_mm))
    })
}

/// Lists are no longer than the schema allows, which is what the design holds.
fn profile(along: &Along) -> Profile {
    match along {
        Along::Everywhere(value) => Profile::constant(*value),
        Along::Taper(pairs) => Profile { knots: pairs.iter().map(|&(position, value)| [position, value]).collect() },
    }
}

fn lamellae(keys: Option<&LamellaeTable>, finger: &Table<'_>, beams: [&Beam; 2]) -> Result<Lamellae, CaseError> {
    let none = Lamellae::rigid(Attachments::Heights(heapless::Vec::new()), 1.0);
    let (Some(keys), Some(table)) = (keys, finger.child("lamellae")) else { return Ok(none) };
    let list = |numbers: &[f64]| numbers.iter().copied().collect();
    let attachments = match (&keys.heights_mm, &keys.front_arc_mm, &keys.back_arc_mm) {
        (Some(heights), None, None) => match angles(keys, &table, heights.len())? {
            Some(angles) => inclined::attachments(&table, beams, heights, &angles)?,
            None => Attachments::Heights(list(heights)),
        },
        (None, Some(_), Some(_)) if keys.angle_deg != PerRib::zero() => {
            return Err(table.refuse(
                "angle_deg",
                "cannot be given together with front_arc_mm and back_arc_mm, which say how the lamellae are inclined",
            ));
        }
        (None, Some(front), Some(back)) => Attachments::Arcs { front: list(front), back: list(back) },
        (Some(_), _, _) => {
            return Err(table.refuse(
                "heights_mm",
                "cannot be given together with front_arc_mm or back_arc_mm; allowed is one or the other",
            ));
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
    let thickness = match &keys.thickness_mm {
        Some(RibThickness::All(thickness)) => Lamellae::uniform(*thickness),
        Some(RibThickness::Each(each)) => each.iter().map(|&thickness| [thickness; 2]).collect(),
        Some(RibThickness::Tapered(each)) => each.iter().copied().collect(),
        None => {
            return Err(
                table.missing("thickness_mm", "a number of mm, one per lamella, or a pair [front, back] per lamella")
            );
        }
    };
    let kind = match keys.kind {
        keys::LamellaKind::Rigid => {
            for (key, given) in [
                ("ends", keys.ends.is_some()),
                ("gap_mm", keys.gap_mm.is_some()),
                ("fillet_mm", keys.fillet_mm != 0.0),
                ("bending_factor", keys.bending_factor != 1.0),
                ("stretch_factor", keys.stretch_factor != 1.0),
            ] {
                if given {
                    return Err(
                        table.refuse(key, "means nothing to rigid lamellae; kind = \"rib\" makes ribs that bend")
                    );
                }
            }
            LamellaKind::Rigid
        }
        keys::LamellaKind::Rib if keys.ends == Some(keys::RibEnds::Hinged) && keys.fillet_mm != 0.0 => {
            return Err(table.refuse("fillet_mm", "means nothing to hinged ribs; ends = \"welded\" makes corners"));
        }
        keys::LamellaKind::Rib => LamellaKind::Rib(Ribs {
            ends: match (keys.ends, keys.gap_mm) {
                (Some(keys::RibEnds::Gap), Some(gap)) => RibEnds::Gap(gap),
                (Some(keys::RibEnds::Gap), None) => return Err(table.missing("gap_mm", "a number of mm")),
                (_, Some(_)) => {
                    return Err(table.refuse("gap_mm", "means nothing to these ribs; ends = \"gap\" makes free ends"));
                }
                (None | Some(keys::RibEnds::Welded), None) => RibEnds::Welded,
                (Some(keys::RibEnds::Hinged), None) => RibEnds::Hinged,
            },
            fillet: keys.fillet_mm,
            bending_factor: keys.bending_factor,
            stretch_factor: keys.stretch_factor,
        }),
    };
    Ok(Lamellae { attachments, thickness, kind })
}

/// One angle for each lamella, degrees; none if all are zero.
fn angles(keys: &LamellaeTable, table: &Table<'_>, count: usize) -> Result<Option<Vec<f64>>, CaseError> {
    let angles = match &keys.angle_deg {
        PerRib::All(angle) => vec![*angle; count],
        PerRib::Each(angles) if angles.len() == count => angles.clone(),
        PerRib::Each(angles) => {
            let found = angles.len();
            let reason = format!("has {found} entries; allowed is one for all or one per lamella ({count})");
            return Err(table.refuse("angle_deg", reason));
        }
    };
    Ok(angles.iter().any(|&angle| angle != 0.0).then_some(angles))
}

fn hinge(keys: Option<&HingeTable>, finger: &Table<'_>, lamellae: &Lamellae) -> Result<Hinge, CaseError> {
    // Ribs say by themselves how they end.
    let needed = !lamellae.attachments.is_empty() && lamellae.ribs().is_none_or(|ribs| ribs.ends == RibEnds::Hinged);
    let (Some(keys), Some(table)) = (keys, finger.child("hinge")) else {
        if needed {
            return Err(
                finger.missing("hinge", "a table with length_mm and thickness_mm, or kind = \"pinned\" or \"welded\"")
            );
        }
        let (kind, from) = (HingeKind::Welded, HingeFrom::Centreline);
        return Ok(Hinge { kind, length: heapless::Vec::new(), thickness: NO_NECK, from });
    };
    if needed && lamellae.ribs().is_some() && keys.kind != keys::HingeKind::Flexible {
        return Err(table.refuse("kind", "ribs with ends = \"hinged\" have necks; allowed is \"flexible\""));
    }
    let flexible = needed && keys.kind == keys::HingeKind::Flexible;
    let length = match &keys.length_mm {
        Some(PerRib::Each(lengths)) => lengths.iter().copied().collect(),
        Some(PerRib::All(length)) => [*length].into_iter().collect(),
        None if flexible => return Err(table.missing("length_mm", "a number of mm, or one per lamella")),
        None => heapless::Vec::new(),
    };
    let thickness = match keys.thickness_mm {
        Some(thickness) => thickness,
        None if flexible => return Err(table.missing("thickness_mm", "a number of mm")),
        None => NO_NECK,
    };
    Ok(Hinge {
        kind: match keys.kind {
            keys::HingeKind::Flexible => HingeKind::Flexible,
            keys::HingeKind::Pinned => HingeKind::Pinned,
            keys::HingeKind::Welded => HingeKind::Welded,
        },
        length,
        thickness,
        from: match keys.from {
            keys::HingeFrom::Centreline => HingeFrom::Centreline,
            keys::HingeFrom::Face => HingeFrom::Face,
        },
    })
}

impl From<&Finger> for FingerTable {
    fn from(finger: &Finger) -> Self {
        let design = &finger.design;
        let has_lamellae = !design.lamellae.attachments.is_empty();
        Self {
            name: Some(finger.name.clone()),
            width_mm: (&design.width).into(),
            plane_strain: match design.plane_strain {
                PlaneStrain::Stress => keys::PlaneStrain::Stress,
                PlaneStrain::Strain => keys::PlaneStrain::Strain,
                PlaneStrain::Auto => keys::PlaneStrain::Auto,
            },
            material: keys::MaterialTable {
                youngs_modulus_pa: design.material.youngs_modulus * PA_PER_MPA,
                poissons_ratio: design.material.poissons_ratio,
                law: match design.material.law {
                    MaterialLaw::StVenantKirchhoff => keys::MaterialLaw::StVenantKirchhoff,
                    MaterialLaw::NeoHookean => keys::MaterialLaw::NeoHookean,
                    MaterialLaw::Linear => keys::MaterialLaw::Linear,
                },
                max_strain: finger.max_strain,
                prony: (!finger.prony.is_empty())
                    .then(|| finger.prony.iter().map(|&[part, time]| (part, time)).collect()),
                memory: (finger.memory != Memory::default()).then_some(finger.memory),
            },
            front: (&design.front).into(),
            back: (&design.back).into(),
            lamellae: has_lamellae.then(|| (&design.lamellae).into()),
            hinge: (has_lamellae && design.lamellae.ribs().is_none_or(|ribs| ribs.ends == RibEnds::Hinged))
                .then(|| (&design.hinge).into()),
            tip: design.rigid_above.map(|height| TipTable { rigid_above_mm: Some(TipFrom::Height(height)) }),
            motor: finger.has_motor.then_some(keys::MotorTable { axis_mm: design.motor_axis }),
        }
    }
}

impl From<&Profile> for Along {
    fn from(profile: &Profile) -> Self {
        match profile.knots.as_slice() {
            [[_, value]] => Self::Everywhere(*value),
            knots => Self::Taper(knots.iter().map(|&[position, value]| (position, value)).collect()),
        }
    }
}

impl From<&Beam> for BeamTable {
    fn from(beam: &Beam) -> Self {
        let is_chain = !beam.via.is_empty();
        let points = || [beam.base].into_iter().chain(beam.via.iter().copied()).chain([beam.tip]).collect();
        Self {
            base_mm: (!is_chain).then_some(beam.base),
            tip_mm: (!is_chain).then_some(beam.tip),
            sagitta_mm: if is_chain { 0.0 } else { beam.sagitta },
            thickness_mm: (&beam.thickness).into(),
            stiffness_factor: beam.stiffness_factor,
            bending_factor: beam.bending_factor,
            stretch_factor: beam.stretch_factor,
            clamp_mm: beam.clamp,
            centreline_mm: is_chain.then(points),
        }
    }
}

impl From<&Lamellae> for LamellaeTable {
    fn from(lamellae: &Lamellae) -> Self {
        let (heights_mm, front_arc_mm, back_arc_mm) = match &lamellae.attachments {
            Attachments::Heights(heights) => (Some(heights.to_vec()), None, None),
            Attachments::Arcs { front, back } => (None, Some(front.to_vec()), Some(back.to_vec())),
        };
        let thickness = lamellae.thickness.as_slice();
        let is_even = thickness.iter().all(|[front, back]| front == back);
        let thickness_mm = Some(match thickness {
            [[front, back]] if front == back => RibThickness::All(*front),
            // A single pair is that of all lamellae.
            [pair] => RibThickness::Tapered(vec![*pair; lamellae.attachments.len()]),
            each if is_even => RibThickness::Each(each.iter().map(|pair| pair[0]).collect()),
            each => RibThickness::Tapered(each.to_vec()),
        });
        let places = Self { heights_mm, front_arc_mm, back_arc_mm, thickness_mm, ..Self::default() };
        match lamellae.kind {
            LamellaKind::Rigid => places,
            LamellaKind::Rib(ribs) => Self {
                kind: keys::LamellaKind::Rib,
                ends: Some(match ribs.ends {
                    RibEnds::Welded => keys::RibEnds::Welded,
                    RibEnds::Hinged => keys::RibEnds::Hinged,
                    RibEnds::Gap(_) => keys::RibEnds::Gap,
                }),
                gap_mm: lamellae.gap(),
                fillet_mm: ribs.fillet,
                bending_factor: ribs.bending_factor,
                stretch_factor: ribs.stretch_factor,
                ..places
            },
        }
    }
}

impl From<&Hinge> for HingeTable {
    fn from(hinge: &Hinge) -> Self {
        Self {
            kind: match hinge.kind {
                HingeKind::Flexible => keys::HingeKind::Flexible,
                HingeKind::Pinned => keys::HingeKind::Pinned,
                HingeKind::Welded => keys::HingeKind::Welded,
            },
            length_mm: match hinge.length.as_slice() {
                [] => None,
                [length] => Some(PerRib::All(*length)),
                lengths => Some(PerRib::Each(lengths.to_vec())),
            },
            thickness_mm: Some(hinge.thickness),
            from: match hinge.from {
                HingeFrom::Centreline => keys::HingeFrom::Centreline,
                HingeFrom::Face => keys::HingeFrom::Face,
            },
        }
    }
}
