//! A finger file from a finger: the keys of `[finger]`, readable again.

use std::fmt::Write as _;

use model_core::design::{Attachments, Beam, HingeFrom, HingeKind, MaterialLaw, PlaneStrain, Profile};

use crate::case::Finger;

/// Pascal per megapascal.
const PA_PER_MPA: f64 = 1e6;

/// The text of a finger file; `remarks` stand at its top, a comment line each.
pub fn finger_file(finger: &Finger, remarks: &[String]) -> String {
    let design = &finger.design;
    let mut out = String::new();
    for remark in remarks {
        let _ = writeln!(out, "# {remark}");
    }
    let plane_strain = match design.plane_strain {
        PlaneStrain::Stress => "stress",
        PlaneStrain::Strain => "strain",
        PlaneStrain::Auto => "auto",
    };
    let law = match design.material.law {
        MaterialLaw::StVenantKirchhoff => "st-venant-kirchhoff",
        MaterialLaw::NeoHookean => "neo-hookean",
        MaterialLaw::Linear => "linear",
    };
    // JSON quotes text as TOML does.
    let name = serde_json::Value::String(finger.name.clone());
    let _ = writeln!(out, "name = {name}\nwidth_mm = {}", profile(&design.width));
    let _ = writeln!(out, "plane_strain = \"{plane_strain}\"\n\n[material]");
    let _ = writeln!(out, "youngs_modulus_pa = {:?}", design.material.youngs_modulus * PA_PER_MPA);
    let _ = writeln!(out, "poissons_ratio = {:?}\nlaw = \"{law}\"", design.material.poissons_ratio);
    if let Some(limit) = finger.max_strain {
        let _ = writeln!(out, "max_strain = {limit:?}");
    }
    for (key, beam) in [("front", &design.front), ("back", &design.back)] {
        write_beam(&mut out, key, beam);
    }
    if !design.lamellae.attachments.is_empty() {
        let _ = writeln!(out, "\n[lamellae]");
        match &design.lamellae.attachments {
            Attachments::Heights(heights) => {
                let _ = writeln!(out, "heights_mm = {heights:?}");
            }
            Attachments::Arcs { front, back } => {
                let _ = writeln!(out, "front_arc_mm = {front:?}\nback_arc_mm = {back:?}");
            }
        }
        let _ = writeln!(out, "thickness_mm = {:?}", design.lamellae.thickness);
        let hinge = &design.hinge;
        let kind = match hinge.kind {
            HingeKind::Flexible => "flexible",
            HingeKind::Pinned => "pinned",
            HingeKind::Welded => "welded",
        };
        let from = match hinge.from {
            HingeFrom::Centreline => "centreline",
            HingeFrom::Face => "face",
        };
        let _ = writeln!(out, "\n[hinge]\nkind = \"{kind}\"");
        match hinge.length.as_slice() {
            [] => {}
            [length] => {
                let _ = writeln!(out, "length_mm = {length:?}");
            }
            lengths => {
                let _ = writeln!(out, "length_mm = {lengths:?}");
            }
        }
        let _ = writeln!(out, "thickness_mm = {:?}\nfrom = \"{from}\"", hinge.thickness);
    }
    if let Some(height) = design.rigid_above {
        let _ = writeln!(out, "\n[tip]\nrigid_above_mm = {height:?}");
    }
    if finger.has_motor {
        let _ = writeln!(out, "\n[motor]\naxis_mm = {:?}", design.motor_axis);
    }
    out
}

fn write_beam(out: &mut String, key: &str, beam: &Beam) {
    let _ = writeln!(out, "\n[{key}]\nbase_mm = {:?}\ntip_mm = {:?}", beam.base, beam.tip);
    if beam.sagitta != 0.0 {
        let _ = writeln!(out, "sagitta_mm = {:?}", beam.sagitta);
    }
    let _ = writeln!(out, "thickness_mm = {}", profile(&beam.thickness));
    let _ = writeln!(out, "stiffness_factor = {:?}", beam.stiffness_factor);
}

fn profile(profile: &Profile) -> String {
    match profile.knots.as_slice() {
        [[_, value]] => format!("{value:?}"),
        knots => format!("{knots:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{PRESETS, preset, read_finger};

    #[test]
    fn what_is_written_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        for name in PRESETS {
            let mut finger = preset(name).unwrap().unwrap();
            finger.name = "a \"name\" with = and #".to_owned();
            finger.max_strain = Some(0.3);
            // Beams with a taper, too.
            finger.design.width.knots.push([50.0, 17.5]).unwrap();
            let file = folder.path().join("finger.toml");
            std::fs::write(&file, finger_file(&finger, &["remark".to_owned()])).unwrap();
            let read = read_finger(&file).unwrap();
            assert!(
                (read.design.material.youngs_modulus / finger.design.material.youngs_modulus - 1.0).abs() < 1e-15,
                "{name}"
            );
            finger.design.material.youngs_modulus = read.design.material.youngs_modulus;
            assert_eq!(read, finger, "{name}");
        }
    }
}
