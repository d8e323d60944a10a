//! The keys of a case file: those that are declared before their physics is there, and the page that lists them all.

use std::path::Path;

use fre::case::{Case, Document, PICTURES, describe_finger, keys, reference};
use fre::draw::{self, KEY_PICTURES};
use fre::finger::Body;
use fre::study::run;
use model_core::design::{Beam, Design, HingeKind, Profile, Ribs};

const CASE: &str = r#"
[finger]
width_mm = 20.0
[finger.material]
youngs_modulus_pa = 4.95e7
poissons_ratio = 0.48
[finger.front]
base_mm = [0.0, 0.0]
tip_mm = [0.0, 80.0]
thickness_mm = 2.0
[finger.back]
base_mm = [-28.0, 0.0]
tip_mm = [0.0, 80.0]
thickness_mm = 2.0
[finger.lamellae]
heights_mm = [9, 18, 27]
thickness_mm = 3.0
[finger.hinge]
length_mm = 2.5
thickness_mm = 0.8
[finger.motor]
axis_mm = [-14.0, -20.0]
[object]
shape = "circle"
radius_mm = 40.0
centre_mm = [41.0, 60.0]
[motion]
motor_angles_deg = [6.0, 8]
"#;

/// A table, and a line that is added to it without changing anything.
const DEFAULTS: &[(&str, &str)] = &[
    ("object", "friction = 0"),
    ("finger.front", "clamp_mm = 0.0"),
    ("finger.front", "bending_factor = 1"),
    ("finger.back", "stretch_factor = 1.0"),
    ("finger.lamellae", "bending_factor = 1.0"),
    ("finger.lamellae", "kind = \"rigid\""),
    ("finger.lamellae", "angle_deg = 0"),
    ("finger.lamellae", "fillet_mm = 0.0"),
    ("finger.material", "prony = []"),
    ("finger.material", "memory = \"nodes\""),
];

/// The case with a line below a table's header.
fn with(table: &str, line: &str) -> String {
    CASE.replacen(&format!("[{table}]\n"), &format!("[{table}]\n{line}\n"), 1)
}

#[test]
fn defaults_change_nothing_and_friction_has_its_range() {
    let plain = Case::parse("case.toml", CASE).unwrap();
    for &(table, line) in DEFAULTS {
        assert_eq!(Case::parse("case.toml", &with(table, line)).unwrap(), plain, "{table}: {line}");
    }
    let message = |table, line| Case::parse("case.toml", &with(table, line)).unwrap_err().to_string();
    assert_eq!(message("object", "friction = -0.1"), "case.toml:24: object.friction = -0.1: allowed is 0 to 3");
    let rough = Case::parse("case.toml", &with("object", "friction = 0.6")).unwrap();
    assert_eq!(rough.friction, 0.6);
    assert_eq!(
        rough.frictionless("a gripper").unwrap_err().to_string(),
        "case.toml:24: object.friction = 0.6: a gripper computes without friction; allowed is 0"
    );
}

#[test]
fn ribs_may_end_with_a_gap() {
    let ribs = |lines: &str| {
        let text = CASE.replacen("[finger.hinge]\nlength_mm = 2.5\nthickness_mm = 0.8\n", "", 1);
        Case::parse("case.toml", &text.replacen("[finger.lamellae]\n", &format!("[finger.lamellae]\n{lines}\n"), 1))
    };
    let case = ribs("kind = \"rib\"\nends = \"gap\"\ngap_mm = 0.4").unwrap();
    assert_eq!(case.finger.design.lamellae.gap(), Some(0.4));
    let message = |lines: &str| ribs(lines).unwrap_err().to_string();
    for (lines, expected) in [
        (
            "kind = \"rib\"\nends = \"gap\"",
            "case.toml:15: finger.lamellae.gap_mm: is missing; needed is a number of mm",
        ),
        (
            "kind = \"rib\"\ngap_mm = 0.4",
            "case.toml:17: finger.lamellae.gap_mm = 0.4: means nothing to these ribs; ends = \"gap\" makes free ends",
        ),
        (
            "gap_mm = 0.4",
            "case.toml:16: finger.lamellae.gap_mm = 0.4: means nothing to rigid lamellae; kind = \"rib\" makes ribs that bend",
        ),
        (
            "kind = \"rib\"\nends = \"gap\"\ngap_mm = -0.1",
            "case.toml:18: finger.lamellae.gap_mm = -0.1: allowed is 0 to 50 mm",
        ),
        (
            "kind = \"rib\"\nends = \"gap\"\ngap_mm = 20.0",
            "case.toml:18: finger.lamellae.gap_mm = 20.0: at rib 2 (counted from 1 at the base) it is -1.5491 mm long; needed is more than 0.01 mm",
        ),
    ] {
        assert_eq!(message(lines), expected);
    }
    // The back beam is held up to above the first rib.
    let held = CASE
        .replacen("[finger.hinge]\nlength_mm = 2.5\nthickness_mm = 0.8\n", "", 1)
        .replacen("[finger.back]\n", "[finger.back]\nclamp_mm = 12.0\n", 1)
        .replacen("[finger.lamellae]\n", "[finger.lamellae]\nkind = \"rib\"\nends = \"gap\"\ngap_mm = 0.4\n", 1);
    let error = Case::parse("case.toml", &held).unwrap_err().to_string();
    assert_eq!(
        error,
        "case.toml:18: finger.lamellae.ends = \"gap\": rib 1 (counted from 1 at the base) ends at the held part of the back beam; \
         allowed are \"welded\" and \"hinged\" there, or ribs above back.clamp_mm"
    );
}

#[test]
fn beams_may_go_through_points_be_held_and_have_factors() {
    let beam = |lines: &str| {
        let ends = "base_mm = [-28.0, 0.0]\ntip_mm = [0.0, 80.0]\n";
        Case::parse("case.toml", &CASE.replacen(ends, &format!("{lines}\n"), 1)).map(|case| case.finger.design.back)
    };
    let plain = beam("base_mm = [-28.0, 0.0]\ntip_mm = [0.0, 80.0]").unwrap();
    assert_eq!(plain, Beam::straight([-28.0, 0.0], [0.0, 80.0], Profile::constant(2.0)));
    let through = beam(
        "centreline_mm = [[-28, 0], [-20, 40], [0, 80]]\nclamp_mm = 4\nbending_factor = 1.2\nstretch_factor = 0.7\n\
         stiffness_factor = 0.9",
    );
    let through = through.unwrap();
    assert_eq!((through.base, through.tip, through.via.as_slice()), (plain.base, plain.tip, &[[-20.0, 40.0]][..]));
    assert_eq!((through.clamp, through.factors()), (4.0, [0.9 * 1.2, 0.9 * 0.7]));
    let straight = beam("centreline_mm = [[-28, 0], [0, 80]]").unwrap();
    assert_eq!(straight, plain);
    let refused = [
        "centreline_mm = [[-28, 0]]",
        "centreline_mm = [[-28, 0], [-20, 40], [-18, 40]]",
        "centreline_mm = [[-28, 0], [-27.9, 40], [0, 41]]",
        "centreline_mm = [[-28, 0], [0, 80]]\nsagitta_mm = 2",
        "tip_mm = [0, 80]\ncentreline_mm = [[-28, 0], [0, 80]]",
        "centreline_mm = [[-28, 0], [0, 80]]\nclamp_mm = 79",
        "centreline_mm = [[-28, 0], [0, 80]]\nbending_factor = 0",
    ];
    let said: String = refused.iter().map(|lines| format!("{}\n", beam(lines).unwrap_err())).collect();
    snapbox::assert_data_eq!(
        said,
        snapbox::str![[r#"
case.toml:12: finger.back.centreline_mm = [[-28, 0]]: has 1 entries; needed is an array of [x, y] in mm, at least 2
case.toml:12: finger.back.centreline_mm[2] = [-18, 40]: is not above the one before
case.toml:12: finger.back.centreline_mm[1] = [-27.9, 40]: is a corner of more than 60 degrees; more points there would round it
case.toml:13: finger.back.sagitta_mm = 2: cannot be given together with centreline_mm; allowed is one or the other
case.toml:12: finger.back.tip_mm = [0, 80]: cannot be given together with centreline_mm; allowed is one or the other
case.toml:13: finger.back.clamp_mm = 79: allowed is 0 to 76.2826 mm
case.toml:13: finger.back.bending_factor = 0: allowed is 0.001 to 1000

"#]]
    );
}

#[test]
fn lamellae_may_be_ribs_inclined_tapered_and_with_necks() {
    let lamellae = |lines: &str| {
        let text = CASE.replacen("thickness_mm = 3.0\n", &format!("{lines}\n"), 1);
        Case::parse("case.toml", &text).map(|case| case.finger.design)
    };
    let rib = |lines: &str| lamellae(&format!("kind = \"rib\"\n{lines}")).unwrap();
    let plain = rib("thickness_mm = 1.2");
    assert_eq!(plain.lamellae.ribs(), Some(&Ribs::WELDED));
    assert_eq!((plain.joint(), plain.lamella_thickness(2)), (HingeKind::Welded, [1.2; 2]));
    let each = rib("thickness_mm = [1, 1.2, 1.4]");
    assert_eq!(each.lamella_thickness(2), [1.4; 2]);
    let tapered = rib("thickness_mm = [[1, 1.2], [1.4, 1.1], [0.9, 0.8]]\nbending_factor = 0.7\nstretch_factor = 0.8");
    assert_eq!(tapered.lamella_thickness(1), [1.4, 1.1]);
    let factors = tapered.lamellae.ribs().map(|ribs| (ribs.bending_factor, ribs.stretch_factor));
    assert_eq!(factors, Some((0.7, 0.8)));
    assert_eq!(rib("thickness_mm = 1.2\nends = \"hinged\"").joint(), HingeKind::Flexible);
    // Through the point midway between the centrelines, the front end lower: the first of `ribs.csv`, at height 9.
    let inclined = rib("thickness_mm = 1.2\nangle_deg = 20");
    let [front, back] = inclined.attachment_arcs(0);
    let (p, q) = (inclined.front.point(front), inclined.back.point(back));
    let lean = (q[1] - p[1]).atan2(p[0] - q[0]).to_degrees();
    let half = 0.5 * (28.0 - 0.35 * 9.0);
    assert!(
        (lean - 20.0).abs() < 1e-9 && (p[1] - (9.0 - half * 20_f64.to_radians().tan())).abs() < 1e-9,
        "{p:?} {lean}"
    );
    let one = rib("thickness_mm = 1.2\nangle_deg = [0, 10, 20]");
    assert_eq!(one.front.point(one.attachment_arcs(0)[0])[1], 9.0);

    let refused = [
        "kind = \"rib\"\nthickness_mm = [1, 1.2]",
        "kind = \"rib\"\nthickness_mm = 1\nangle_deg = [1, 2]",
        "kind = \"rib\"\nthickness_mm = 1\nangle_deg = 75",
        "kind = \"rib\"\nthickness_mm = 12",
        "thickness_mm = 3\nends = \"welded\"",
        "thickness_mm = 3\nbending_factor = 2",
    ];
    let said: String = refused.iter().map(|lines| format!("{}\n", lamellae(lines).unwrap_err())).collect();
    snapbox::assert_data_eq!(
        said,
        snapbox::str![[r#"
case.toml:18: finger.lamellae.thickness_mm = [1, 1.2]: has 2 entries; allowed is one for all or one per lamella (3)
case.toml:19: finger.lamellae.angle_deg = [1, 2]: has 2 entries; allowed is one for all or one per lamella (3)
case.toml:19: finger.lamellae.angle_deg = 75: lamella 1 (counted from 1 at the base) at 9 mm, inclined by 75 degrees, does not meet the front beam
case.toml:18: finger.lamellae.thickness_mm = 12: at rib 2 (counted from 1 at the base) the front beam's part below it is -7.56 mm long; needed is more than 0.01 mm
case.toml:18: finger.lamellae.ends = "welded": means nothing to rigid lamellae; kind = "rib" makes ribs that bend
case.toml:18: finger.lamellae.bending_factor = 2: means nothing to rigid lamellae; kind = "rib" makes ribs that bend

"#]]
    );
    // What is written is read again.
    for design in [plain, each, tapered, inclined] {
        let finger = model(&design);
        assert_eq!(finger.lamellae.thickness, design.lamellae.thickness);
        assert_eq!(finger.lamellae.kind, design.lamellae.kind);
        let apart = |k| {
            (0..2).map(|side| (finger.attachment_arcs(k)[side] - design.attachment_arcs(k)[side]).abs()).sum::<f64>()
        };
        assert!((0..3).all(|k| apart(k) < 1e-9));
    }
}

/// Heights and angles become arcs along the beams; what is wrong with these is wrong with the heights.
#[test]
fn an_inclined_lamella_is_refused_by_its_height() {
    let inclined = |heights: &str, angles: &str| {
        CASE.replacen("heights_mm = [9, 18, 27]", &format!("heights_mm = {heights}\nangle_deg = {angles}"), 1)
    };
    let clamped = CASE.replacen("thickness_mm = 2.0", "thickness_mm = 2.0\nclamp_mm = 12", 1);
    let refused = [
        inclined("[18, 9]", "20"),
        inclined("[18, 20]", "[0, 40]"),
        inclined("[30, 32]", "20"),
        clamped.replacen("heights_mm = [9, 18, 27]", "heights_mm = [14, 30]\nangle_deg = 20", 1),
        // As without an angle, and as with arcs.
        inclined("[18, 9]", "0"),
        CASE.replacen("heights_mm = [9, 18, 27]", "front_arc_mm = [30, 32]\nback_arc_mm = [30, 32]", 1),
        CASE.replacen("heights_mm = [9, 18, 27]", "front_arc_mm = [18, 27]\nback_arc_mm = [18, 9]", 1),
    ];
    let said: String =
        refused.iter().map(|text| format!("{}\n", Case::parse("case.toml", text).unwrap_err())).collect();
    snapbox::assert_data_eq!(
        said,
        snapbox::str![[r#"
case.toml:16: finger.lamellae.heights_mm[1] = 9: inclined by angle_deg, the lamella meets the front beam 4.4777 mm along it; must be larger than its predecessor's 14.0509 mm
case.toml:16: finger.lamellae.heights_mm[1] = 20: inclined by angle_deg, the lamella meets the front beam 11.1895 mm along it; must be larger than its predecessor's 18 mm
case.toml:16: finger.lamellae.heights_mm[1] = 32: its lamella's middle is 1.9991 mm from the lamella below's; its thickness of 3 mm needs 3 mm
case.toml:17: finger.lamellae.heights_mm[0] = 14: inclined by angle_deg, the lamella meets the front beam 9.7961 mm along it; allowed is more than 12 and less than 80 mm
case.toml:16: finger.lamellae.heights_mm[1] = 9: must be larger than its predecessor 18
case.toml:16: finger.lamellae.front_arc_mm[1] = 32: its lamella's middle is 1.843 mm from the lamella below's; its thickness of 3 mm needs 3 mm
case.toml:17: finger.lamellae.back_arc_mm[1] = 9: must be larger than its predecessor 18

"#]]
    );
}

/// A design written as a case's keys and read again.
fn model(design: &Design) -> Design {
    let mut document = Document::resolve("case.toml", CASE, Path::new("")).unwrap();
    let mut finger = document.case().unwrap().finger;
    finger.design = design.clone();
    document.set_finger(&finger);
    document.case().unwrap().finger.design
}

#[test]
fn every_static_range_is_kept() {
    let objects = [
        "shape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 60]",
        "shape = \"ellipse\"\ncentre_mm = [41, 60]\nsemi_axes_mm = [40, 20]\nangle_deg = 5",
        "shape = \"polygon\"\nrounding_mm = 2\ncorners_mm = [[30, 30], [60, 30], [60, 60]]",
        "shape = \"half-plane\"\npoint_mm = [10, 40]\nnormal = [-1, 0]",
        "shape = \"bore\"\nradius_mm = 150\ncentre_mm = [-122, 0]",
    ];
    let mut count = 0;
    for object in objects {
        let start = CASE.find("shape").unwrap();
        let text = format!("{}{object}\n[motion]\nmotor_angles_deg = [6]\n", &CASE[..start]);
        let document = Document::resolve("case.toml", &text, Path::new("")).unwrap();
        for key in document.keys() {
            let mut schema = keys::schema();
            for part in key.split('.').filter(|part| part.parse::<usize>().is_err()) {
                let forms = schema["anyOf"].as_array().into_iter().chain(schema["oneOf"].as_array()).flatten();
                let holds = |form: &&serde_json::Value| {
                    let tag = form["properties"]["shape"]["const"].as_str();
                    form["properties"][part].is_object() && tag.is_none_or(|tag| object.contains(&format!("\"{tag}\"")))
                };
                schema = &forms.chain([schema]).find(holds).unwrap()["properties"][part];
            }
            let Some([least, most]) = schema["x-range"].as_array().map(Vec::as_slice) else { continue };
            let (least, most) = (least.as_f64().unwrap(), most.as_f64().unwrap());
            for beyond in [least - 1e-3 * least.abs().max(1e-6), most * 1.001] {
                let mut varied = document.clone();
                varied.set(&key, beyond).unwrap();
                let error = varied.case().expect_err(&key);
                let named = error.key().unwrap().replace('[', ".").replace(']', "");
                assert_eq!(named, key, "{error}");
                assert!(error.to_string().contains("allowed is"), "{error}");
                count += 1;
            }
        }
    }
    assert!(count > 100, "{count}");
}

#[test]
fn a_finger_of_64_lamellae_with_tapers_of_64_knots_grips_a_polygon_of_64_corners() {
    let knots = |least: f64, most: f64, length: f64| {
        let knot = |k: u32| {
            let part = f64::from(k) / 63.0;
            format!("[{}, {}]", length * part, most + (least - most) * part)
        };
        format!("[{}]", (0..64).map(knot).collect::<Vec<_>>().join(", "))
    };
    let heights: Vec<String> = (1..=64).map(|k| format!("{}", 2.0 * f64::from(k))).collect();
    let corner = |k: u32| {
        let angle = f64::from(k) * std::f64::consts::TAU / 64.0;
        format!("[{}, {}]", 46.0 + 40.0 * angle.cos(), 90.0 + 40.0 * angle.sin())
    };
    let text = format!(
        "[finger]\nwidth_mm = {}\nmaterial = {{ youngs_modulus_pa = 4.95e7, poissons_ratio = 0.48 }}\n\
         front = {{ base_mm = [0, 0], tip_mm = [0, 160], thickness_mm = {} }}\n\
         back = {{ base_mm = [-56, 0], tip_mm = [0, 160], thickness_mm = {} }}\n\
         lamellae = {{ heights_mm = [{}], thickness_mm = 1 }}\nhinge = {{ length_mm = 1.5, thickness_mm = 0.8 }}\n\
         motor.axis_mm = [-28, -20]\n[object]\nshape = \"polygon\"\nrounding_mm = 2\ncorners_mm = [{}]\n\
         [motion]\nmotor_angles_deg = [0, 1, 2, 3]\n",
        knots(15.0, 20.0, 160.0),
        knots(1.5, 2.5, 160.0),
        knots(1.5, 2.5, 169.0),
        heights.join(", "),
        (0..64).map(corner).collect::<Vec<_>>().join(", ")
    );
    let case = Case::parse("case.toml", &text).unwrap();
    let design = &case.finger.design;
    assert_eq!((design.lamella_count(), design.width.knots.len(), design.back.thickness.knots.len()), (64, 64, 64));
    let run = run::solve(&case, &Default::default()).unwrap();
    assert!(run.is_trustworthy(), "{run:?}");
    let force = run.places.last().unwrap().force_n().unwrap();
    assert!(force[0].hypot(force[1]) > 0.1, "{force:?}");
}

#[test]
fn the_page_of_all_keys_is_current() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let stale = "is not current; run `cargo run --release --bin fre -- schema --force --page docs`";
    let page = docs.join("case.md");
    assert!(std::fs::read_to_string(&page).unwrap_or_default() == reference(), "{} {stale}", page.display());
    for name in KEY_PICTURES {
        let file = docs.join(PICTURES).join(format!("{name}.svg"));
        let scene = draw::key_picture(name).unwrap();
        assert!(std::fs::read_to_string(&file).unwrap_or_default() == draw::svg(&scene), "{} {stale}", file.display());
        assert!(reference().contains(&format!("({PICTURES}/{name}.svg)")), "{name} is on no line of the page");
    }
    assert!(draw::key_picture("other").is_none());
}

/// By hand for straight beams; and by the figure's own walls for others, whatever their course.
#[test]
fn a_tip_that_is_auto_begins_where_the_inner_faces_meet() {
    let of = |front: f64, back: f64, base: f64| {
        let text = CASE
            .replacen("thickness_mm = 2.0", &format!("thickness_mm = {front}"), 1)
            .replacen("thickness_mm = 2.0", &format!("thickness_mm = {back}"), 1)
            .replacen("-28.0, 0.0", &format!("{base}, 0.0"), 1)
            + "[finger.tip]\nrigid_above_mm = \"auto\"\n";
        Case::parse("case.toml", &text).unwrap().finger.design.rigid_above.unwrap()
    };
    for (front, back, base) in [(2.0, 2.0, -28.0), (3.0, 1.2, -36.0), (1.2, 3.0, -24.0)] {
        let across = 0.5 * front + 0.5 * back * 80.0_f64.hypot(base) / 80.0;
        let height = of(front, back, base);
        assert!((height - (80.0 - across * 80.0 / -base)).abs() < 1e-9, "{height} of {front}, {back}, {base}");
    }
    let bowed = [
        ("finger.front", "sagitta_mm = 1.5", "thickness_mm = 2.0"),
        ("finger.back", "sagitta_mm = -2.0", "thickness_mm = [[0, 4.0], [84, 1.5]]"),
    ];
    let text = bowed.iter().fold(CASE.to_owned(), |text, (table, line, thickness)| {
        let (head, tail) = text.split_once(&format!("[{table}]\n")).unwrap();
        format!("{head}[{table}]\n{line}\n{}", tail.replacen("thickness_mm = 2.0", thickness, 1))
    });
    let text = text + "[finger.tip]\nrigid_above_mm = \"auto\"\n";
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bowed.toml");
    std::fs::write(&file, &text).unwrap();
    let notch = Body::of(&describe_finger(&file).unwrap()).unwrap().notch();
    let height = Case::parse("case.toml", &text).unwrap().finger.design.rigid_above.unwrap();
    assert!((height - notch[1]).abs() < 1e-3 && height < 79.0, "{height} {notch:?}");
}

/// Fitted numbers are written; the tip's word stays where the tip stays.
#[test]
fn a_finger_that_is_written_keeps_a_tip_that_is_auto() {
    let mut document =
        Document::resolve("case.toml", &format!("{CASE}[finger.tip]\nrigid_above_mm = \"auto\"\n"), Path::new(""))
            .unwrap();
    let mut finger = document.case().unwrap().finger;
    finger.design.material.youngs_modulus = 30.0;
    document.set_finger(&finger);
    assert!(document.finger_text(&[]).contains("rigid_above_mm = \"auto\""), "{}", document.finger_text(&[]));
    assert_eq!(document.case().unwrap().finger, finger);
    finger.design.front.thickness = Profile::constant(2.5);
    finger.is_tip_auto = false;
    document.set_finger(&finger);
    assert_eq!(document.case().unwrap().finger, finger, "a tip that stays where it was is a number now");
}
