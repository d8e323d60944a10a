//! Outlines are written, read again and measured: the finger that comes back is the one that went out.
#![cfg(feature = "cad")]

use std::path::Path;

use fre::cad::{Format, decode, encode};
use fre::case::{PRESETS, describe_finger};
use fre::finger::measure::{Front, Measured, measure};
use fre::finger::{Body, Loop, RungEnds, Wall, outline};

const FORMATS: [Format; 3] = [Format::Dxf, Format::Svg, Format::Stl];

fn body(text: &str) -> Body {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("finger.toml");
    std::fs::write(&file, text).unwrap();
    Body::of(&describe_finger(&file).unwrap()).unwrap()
}

fn again(loops: &[Loop], width: f64, format: Format) -> Measured {
    let drawing = decode(&encode(loops, width, format).unwrap(), format).unwrap();
    assert_eq!(drawing.loops.len(), loops.len(), "{format:?}: {:?}", drawing.notes);
    measure(&drawing.loops, drawing.width, drawing.has_origin, Front::Auto)
        .unwrap_or_else(|e| panic!("{format:?}: {e}"))
}

fn near(what: &str, found: f64, expected: f64, within: f64) {
    assert!((found - expected).abs() <= within, "{what}: {found} instead of {expected}");
}

/// Every measure of a body against what was measured in its outline.
fn compare(name: &str, body: &Body, measured: &Measured) {
    for (side, (wall, found)) in [(&body.front, &measured.front), (&body.back, &measured.back)].into_iter().enumerate()
    {
        // Above the notch there is no wall by itself.
        let (clamp, end) = (body.base()[side], body.merge[side]);
        let again = Wall::new(found.centreline.clone(), found.thickness.clone(), 1.0).unwrap();
        near(&format!("{name}: clamp"), found.clamp, clamp, 0.05);
        for i in 0..=20 {
            let arc = clamp + (end - clamp) * f64::from(i) / 20.0;
            let point = wall.centre(arc);
            let beside = again.centre(again.arc_beside(point));
            near(
                &format!("{name}: centreline at {arc}"),
                (beside[0] - point[0]).hypot(beside[1] - point[1]),
                0.0,
                0.05,
            );
            near(&format!("{name}: thickness at {arc}"), again.thickness(arc), wall.thickness(arc), 0.05);
        }
    }
    let top = body.solid_above.unwrap_or(body.notch()[1]);
    near(&format!("{name}: solid tip"), measured.solid_above, top, 0.05);
    assert_eq!(measured.rungs.len(), body.rungs.len());
    for (k, (rung, found)) in body.rungs.iter().zip(&measured.rungs).enumerate() {
        let name = format!("{name}: rung {}", k + 1);
        near(&format!("{name}: front arc"), found.arcs[0], rung.arcs[0], 0.05);
        near(&format!("{name}: back arc"), found.arcs[1], rung.arcs[1], 0.05);
        near(&format!("{name}: angle"), found.angle_deg, rung.along[1].atan2(-rung.along[0]).to_degrees(), 0.1);
        near(&format!("{name}: thickness"), found.thickness[0], rung.thickness[0], 0.05);
        near(&format!("{name}: thickness"), found.thickness[1], rung.thickness[1], 0.05);
        match (rung.joined, found.necks) {
            (RungEnds::Necked { neck, insets }, Some(necks)) => {
                let faces = body.face_insets(rung);
                near(&format!("{name}: neck"), necks.thickness, neck, 0.05);
                near(&format!("{name}: front neck"), necks.lengths[0], insets[0] - faces[0], 0.05);
                near(&format!("{name}: back neck"), necks.lengths[1], insets[1] - faces[1], 0.05);
            }
            (RungEnds::Welded { fillet }, None) => near(&format!("{name}: fillet"), measured.fillet, fillet, 0.05),
            other => panic!("{name}: {other:?}"),
        }
    }
}

/// Angles and thicknesses of the rungs, which are the same from whatever height they are counted.
fn compare_rungs(name: &str, body: &Body, measured: &Measured) {
    assert_eq!(measured.rungs.len(), body.rungs.len());
    for (rung, found) in body.rungs.iter().zip(&measured.rungs) {
        near(&format!("{name}: angle"), found.angle_deg, rung.along[1].atan2(-rung.along[0]).to_degrees(), 0.1);
        near(&format!("{name}: thickness"), found.thickness[0], rung.thickness[0], 0.05);
        near(&format!("{name}: thickness"), found.thickness[1], rung.thickness[1], 0.05);
    }
}

#[test]
fn every_preset_comes_back_from_every_format() {
    for name in PRESETS {
        let body = Body::of(&describe_finger(Path::new(&format!("preset:{name}"))).unwrap()).unwrap();
        for format in FORMATS {
            let measured = again(&outline(&body, 5.0).unwrap(), body.width, format);
            if format == Format::Svg && body.clamps != [0.0; 2] {
                // A page has no origin, and heights are counted from the top of the solid base: what has a height is another number.
                compare_rungs(name, &body, &measured);
                continue;
            }
            compare(&format!("{name} {format:?}"), &body, &measured);
            assert_eq!(measured.width.is_some(), format == Format::Stl);
            measured.width.iter().for_each(|width| near("width", *width, body.width, 1e-3));
        }
    }
}

const RIBS: &str = "width_mm = 20\nmaterial = { youngs_modulus_pa = 1e7, poissons_ratio = 0.4 }\n\
    [front]\nbase_mm = [0, 0]\ntip_mm = [0, 80]\nthickness_mm = 2\n\
    [back]\nbase_mm = [-28, 0]\ntip_mm = [0, 80]\nthickness_mm = 2\n\
    [lamellae]\nkind = \"rib\"\nends = \"welded\"\nheights_mm = [9, 18, 27, 36, 45, 54, 63]\n";

#[test]
fn ribs_come_back_inclined_tapered_rounded_and_between_curved_and_tapered_walls() {
    let fingers = [
        ("level", RIBS.to_owned() + "thickness_mm = 1.2\n"),
        ("inclined", RIBS.to_owned() + "thickness_mm = 0.8\nangle_deg = 20\n"),
        ("other way", RIBS.to_owned() + "thickness_mm = 2.0\nangle_deg = [-20, -15, -10, -5, 0, 5, 10]\n"),
        ("rounded", RIBS.to_owned() + "thickness_mm = 1.2\nangle_deg = 10\nfillet_mm = 0.5\n"),
        (
            "tapered",
            RIBS.to_owned()
                + "thickness_mm = [[1.0, 1.5], [1.2, 1.6], [1.2, 1.2], [1.0, 0.8], [1.2, 1.4], [1.0, 1.2], [1.0, 1.1]]\n",
        ),
        (
            "bowed",
            RIBS.replacen(
                "tip_mm = [0, 80]\nthickness_mm = 2\n[lamellae]",
                "tip_mm = [0, 80]\nsagitta_mm = -2.5\nthickness_mm = [[0, 3.5], [85, 1.5]]\n[lamellae]",
                1,
            ) + "thickness_mm = 1.2\nangle_deg = 15\n",
        ),
    ];
    for (name, text) in fingers {
        let body = body(&text);
        for format in FORMATS {
            compare(&format!("{name} {format:?}"), &body, &again(&outline(&body, 4.0).unwrap(), body.width, format));
        }
    }
}

/// Rows of a reference table below its heading, split at commas.
fn reference(name: &str) -> Vec<Vec<String>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/reference").join(name);
    let text = std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn value(cell: &str) -> f64 {
    cell.parse().unwrap_or_else(|_| panic!("{cell:?}"))
}

/// The outline of the UMI soft finger: contact face at x = 0, the other wall at larger x, three bolts' holes.
fn umi() -> Vec<Loop> {
    let mut loops: Vec<(String, Loop)> = Vec::new();
    for row in reference("umi-outline.csv") {
        let (point, name) = ([value(&row[2]), value(&row[3])], row[0].clone());
        if let Some((hole, diameter)) = name.split_once(" centre d=") {
            let circle = (0..48).map(|i| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 48.0).sin_cos();
                [point[0] + 0.5 * value(diameter) * cos, point[1] + 0.5 * value(diameter) * sin]
            });
            loops.push((hole.to_owned(), circle.collect()));
            continue;
        }
        match loops.iter_mut().find(|known| known.0 == name) {
            Some((_, points)) => points.push(point),
            None => loops.push((name, vec![point])),
        }
    }
    loops.into_iter().map(|(_, points)| points).collect()
}

#[test]
fn the_umi_finger_is_measured_in_its_mesh() {
    let loops = umi();
    assert_eq!(loops.len(), 20);
    for format in FORMATS {
        let measured = again(&loops, 25.8, format);
        near("front wall", measured.front.thickness[0][1], 1.8, 0.01);
        assert_eq!((measured.front.centreline.len(), measured.front.thickness.len()), (2, 1));
        let ribs = reference("umi-ribs.csv");
        assert_eq!(measured.rungs.len(), ribs.len());
        // An SVG has no origin: its finger stands on the top of the solid base.
        let lifted = if format == Format::Svg { 10.0 } else { 0.0 };
        near("clamp", measured.front.clamp, 10.0 - lifted, 0.01);
        near("solid tip", measured.solid_above, 119.198 - lifted, 0.02);
        let back = Wall::new(measured.back.centreline.clone(), measured.back.thickness.clone(), -1.0).unwrap();
        for (rung, row) in measured.rungs.iter().zip(&ribs) {
            let name = format!("rib {} of {format:?}", row[0]);
            assert!(rung.necks.is_none(), "{name}");
            near(&format!("{name}: angle"), rung.angle_deg, value(&row[6]), 0.3);
            near(&format!("{name}: clear length"), rung.clear, value(&row[5]), 0.1);
            near(&format!("{name}: front thickness"), rung.thickness[0], value(&row[7]), 0.1);
            near(&format!("{name}: back thickness"), rung.thickness[1], value(&row[8]), 0.1);
            let front = rung.arcs[0] + 0.9 * rung.angle_deg.to_radians().tan();
            near(&format!("{name}: front height"), front, value(&row[2]) - lifted, 0.1);
            // The axis goes on from the back face to the centreline.
            let meets = back.centre(rung.arcs[1]);
            let (sin, cos) = rung.angle_deg.to_radians().sin_cos();
            let face = [0.9 - value(&row[3]), value(&row[4]) - lifted];
            let across = (meets[0] - face[0]) * sin + (meets[1] - face[1]) * cos;
            near(&format!("{name}: back end"), across, 0.0, 0.1);
        }
        for row in reference("umi-rod.csv").iter().filter(|row| row[1] == "back_centreline") {
            let point = [value(&row[6]), value(&row[7]) - lifted];
            // Lower down a boss for the bolt stands out, which the table leaves out.
            if point[1] + lifted < 49.0 {
                continue;
            }
            let arc = back.arc_beside(point);
            let there = back.centre(arc);
            near(&format!("back wall at {point:?}"), (there[0] - point[0]).hypot(there[1] - point[1]), 0.0, 0.1);
            near(&format!("back thickness at {point:?}"), back.thickness(arc), value(&row[8]), 0.1);
        }
        let said: Vec<&str> = measured.undecided.iter().map(|undecided| undecided.key).collect();
        assert!(said.contains(&"finger.back.clamp_mm") && said.contains(&"finger.front"), "{said:?}");
    }
}

#[test]
fn what_is_no_finger_is_refused_with_what_is_needed() {
    let square: Loop = vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
    let error = measure(std::slice::from_ref(&square), None, true, Front::Auto).unwrap_err();
    snapbox::assert_data_eq!(
        error.to_string(),
        snapbox::str!["the outline has too few windows (0); needed are two or more, with a rung between each two"]
    );
    for format in FORMATS {
        assert!(decode(b"no such thing", format).is_err(), "{format:?}");
    }
    snapbox::assert_data_eq!(
        Format::of(Path::new("finger.step")).unwrap_err().to_string(),
        snapbox::str!["finger.step: the ending names no format; allowed is .dxf, .svg and .stl"]
    );
    // A pinned finger is not one piece.
    let pinned = RIBS.replace("kind = \"rib\"\nends = \"welded\"", "kind = \"rigid\"")
        + "thickness_mm = 2\n[hinge]\nkind = \"pinned\"\n";
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("finger.toml");
    std::fs::write(&file, pinned).unwrap();
    let error = outline(&Body::of(&describe_finger(&file).unwrap()).unwrap(), 5.0).unwrap_err().to_string();
    assert!(error.contains("hinge.kind: a pinned lamella cannot be drawn as one piece"), "{error}");
}
