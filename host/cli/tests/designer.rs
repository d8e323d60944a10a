//! What a designer asks: strains, contact pressure, stiffness, and how far the first branch reaches.

mod said;

use std::process::{Command, Output};

use fre::case::Case;
use fre::study::model::Options;
use fre::study::place::{Place, State};
use fre::study::run::{self, Run};
use model_core::discretise::{Discretisation, Elements, Physics, Sampling, Scheme};

/// A finger on a cylinder that it snaps through on, at 11.05°; its force is largest at 10.5°.
fn case(angles: &str) -> Case {
    Case::parse(
        "case.toml",
        &format!(
            "finger = \"preset:fea-80\"\nobject = {{ shape = \"circle\", radius_mm = 40, centre_mm = [41, 60] }}\n\
             motion.motor_angles_deg = {angles}\n"
        ),
    )
    .unwrap()
}

fn fine(elements: Elements) -> Options {
    let discretisation = Discretisation { elements, ..Discretisation::fine(Physics::Extended) };
    Options { discretisation, ..Options::default() }
}

fn solve(case: &Case, options: &Options) -> Run {
    let run = run::solve(case, options).unwrap();
    assert!(run.is_trustworthy(), "{run:?}");
    run
}

fn states(run: Run) -> Vec<State> {
    run.places.into_iter().filter_map(|place| place.state).collect()
}

#[test]
fn strain_is_half_the_thickness_times_the_drawn_curvature() {
    // Without shear, which tilts cross-sections against the centreline, and without stretch.
    let mut options = fine(Elements::PerSpan { span: 24, tip_span: 24, hinge: 6 });
    options.discretisation.physics = Physics::Paper;
    let state = states(solve(&case("[4]"), &options)).remove(0);
    let strains = state.strains;
    let bending = |section: &fre::study::strains::Section| 0.5 * (section.object_side - section.back_side);
    let line = &state.shape.back;
    let length = |a: [f64; 2], b: [f64; 2]| (b[0] - a[0]).hypot(b[1] - a[1]);
    // Curvature of the centreline as it is drawn: through an element's end and its neighbours' other ends.
    let ends: Vec<[f64; 2]> = line.iter().step_by(2).copied().collect();
    let (mut arc, mut compared) = (0.0, 0);
    for window in ends.windows(3) {
        let [a, b, c] = [window[0], window[1], window[2]];
        arc += length(a, b);
        let (first, second) = (length(a, b), length(b, c));
        let cross = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]);
        let curvature = 2.0 * cross / (first * second * (first + second));
        // Two sections share the arc: the end of an element and the start of the next; at a joint the bend jumps.
        let here: Vec<f64> =
            strains.back.iter().filter(|section| (section.arc_mm - arc).abs() < 0.02).map(bending).collect();
        if let [before, after] = here[..]
            && (before - after).abs() < 1e-4
        {
            // Half the thickness is 1 mm.
            assert!((before - curvature).abs() < 2e-4 + 0.01 * before.abs(), "{arc:.2}: {before:.5} {curvature:.5}");
            compared += 1;
        }
    }
    assert!(compared > 130, "{compared}");
}

#[test]
fn the_back_beam_is_pushed_together_and_the_front_beam_drawn_out() {
    let strains = states(solve(&case("[9]"), &Options::default())).remove(0).strains;
    let mean = |sections: &[fre::study::strains::Section]| {
        let sum: f64 = sections.iter().map(|section| 0.5 * (section.object_side + section.back_side)).sum();
        sum / sections.len() as f64
    };
    assert!(mean(&strains.back) < -0.01 && mean(&strains.front) > 0.01);
}

#[test]
fn largest_strains_are_those_of_the_sections_spans_and_hinges() {
    for (scheme, sampling) in [
        (Scheme::Simpson, Sampling::PerElement(4)),
        (Scheme::Trapezoid, Sampling::Nodes),
        (Scheme::Paper, Sampling::Nodes),
    ] {
        let mut options = fine(Elements::PerBeam { beam: 56, hinge: 6 });
        (options.discretisation.scheme, options.discretisation.sampling) = (scheme, sampling);
        let state = states(solve(&case("[5]"), &options)).remove(0);
        let (strains, most) = (state.strains, state.max_strain);
        let largest =
            |sections: &[fre::study::strains::Section]| sections.iter().map(|s| s.largest()).fold(0.0, f64::max);
        assert_eq!((largest(&strains.front), largest(&strains.back)), (most.front, most.back));
        assert_eq!((strains.spans.len(), strains.hinges.len()), (7, 6));
        assert_eq!(strains.spans.iter().map(|pair| pair.front).fold(0.0, f64::max), most.front);
        assert_eq!(strains.hinges.iter().map(|pair| pair.front.max(pair.back)).fold(0.0, f64::max), most.hinge);
        assert!(strains.front.is_sorted_by(|a, b| a.arc_mm < b.arc_mm + 1e-9), "{scheme:?}");
        let last = strains.back.last().unwrap().arc_mm;
        assert!((70.0..84.8).contains(&last), "{scheme:?}: {last}");
        // Schemes agree on what a designer reads; the springs of `paper` know the bend to first order.
        assert!((most.hinge - 0.0889).abs() < 0.012, "{scheme:?}: {most:?}");
    }
}

#[test]
fn pressure_times_length_is_the_force() {
    for state in states(solve(&case("[0, 2, 5, 9, 12]"), &Options::default())) {
        let force: f64 = state.shape.contacts.iter().map(|contact| contact.force).sum();
        let length = |pressure: &fre::study::pressure::Pressure| pressure.between_mm[1] - pressure.between_mm[0];
        let sum: f64 = state.contact_pressure.iter().map(|p| p.line_load_n_per_mm * length(p)).sum();
        assert!((sum - force).abs() < 1e-9 * force.max(1.0), "{sum} {force}");
        for pressure in &state.contact_pressure {
            assert!((pressure.pressure_n_per_mm2 * 20.0 - pressure.line_load_n_per_mm).abs() < 1e-12);
            let [from, to] = pressure.between_mm;
            assert!(from < pressure.arc_mm && pressure.arc_mm <= to && to <= 80.0, "{pressure:?}");
        }
        // What one sample stands for ends where the next one's begins.
        for pair in state.contact_pressure.windows(2) {
            assert!(pair[0].between_mm[1] <= pair[1].between_mm[0] + 1e-9, "{pair:?}");
        }
    }
}

#[test]
fn the_first_branch_ends_where_small_steps_snap() {
    let coarse = solve(&case("[5, 10, 11, 12, 13]"), &Options::default());
    assert_eq!(coarse.places.iter().map(|place| place.branch.unwrap()).collect::<Vec<_>>(), [1, 1, 1, 2, 2]);
    let first = coarse.first_branch.unwrap();
    let angles: Vec<String> = (0..=140).map(|i| format!("{}", 10.5 + 0.01 * f64::from(i))).collect();
    let small = solve(&case(&format!("[{}]", angles.join(","))), &Options::default()).places;
    let snapped = small.iter().position(|place| place.branch == Some(2)).unwrap();
    let [after, before] = first.snap_between().unwrap();
    assert!(before - after < 0.041 && (11.0..12.0).contains(&after));
    assert!(after - 0.04 < small[snapped - 1].at.value() && small[snapped].at.value() < before + 0.04, "{first:?}");
    let force = |place: &Place| place.force_magnitude_n().unwrap();
    let most = small[..snapped].iter().max_by(|a, b| force(a).total_cmp(&force(b))).unwrap();
    assert!((force(most) - first.max_force_n).abs() < 0.01, "{first:?}");
    assert!((most.at.value() - first.max_force_at().unwrap()).abs() < 0.1, "{first:?}");
    // A motion that ends before the snap has none.
    let calm = solve(&case("[5, 10]"), &Options::default());
    let first = calm.first_branch.unwrap();
    assert_eq!((first.snap_between(), first.max_force_at()), (None, Some(10.0)));
    assert_eq!(Some(first.max_force_n), calm.places[1].force_magnitude_n());
}

#[test]
fn a_finger_that_touches_along_many_samples_still_has_its_numbers() {
    // 140 of 680 samples touch.
    let options = fine(Elements::PAPER);
    let state = states(solve(&case("[12]"), &options)).remove(0);
    assert!(state.shape.contacts.len() > 64, "{}", state.shape.contacts.len());
    assert!(state.sensitivity.is_some());
}

fn fre(folder: &std::path::Path, text: &str, arguments: &[&str]) -> Output {
    let file = folder.join("case.toml");
    std::fs::write(&file, text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
    command.arg(arguments[0]).arg(&file).args(&arguments[1..]).current_dir(folder).output().unwrap()
}

#[test]
fn strains_beyond_the_limit_are_warned_of_in_every_format() {
    let own = tempfile::tempdir().unwrap();
    let folder = own.path();
    let finger = include_str!("../../fre/src/case/presets/fea-80.toml").replace("\n[", "\n[finger.");
    let text = |limit: &str| {
        let finger = finger.replace("poissons_ratio = 0.48", &format!("poissons_ratio = 0.48\n{limit}"));
        format!(
            "[finger]\n{finger}\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 60]\n\
             [motion]\nmotor_angles_deg = [2, 6]\n"
        )
    };
    let words = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let low = text("max_strain = 0.05");
    let said = words(&fre(folder, &low, &["solve"]).stdout);
    let notes = |said: &str| {
        said.lines()
            .skip_while(|line| !line.starts_with("First branch"))
            .fold(String::new(), |all, line| all + line + "\n")
    };
    snapbox::assert_data_eq!(
        said::words(&notes(&said)),
        snapbox::str![[r#"
First branch: largest force # N at #°; the motion meets no snap-through
warning: front hinge of lamella #: strain # %, the material bears # % (at #°)
warning: back hinge of lamella #: strain # %, the material bears # % (at #°)
warning: front hinge of lamella #: strain # %, the material bears # % (at #°)
warning: back hinge of lamella #: strain # %, the material bears # % (at #°)
warning: front hinge of lamella #: strain # %, the material bears # % (at #°)
warning: back hinge of lamella #: strain # %, the material bears # % (at #°)
"#]]
    );
    let csv = fre(folder, &low, &["solve", "--format", "csv"]);
    let is_sixth = |line: &str| {
        line.starts_with("warning: back hinge of lamella 6: strain 10.4")
            && line.ends_with("%, the material bears 5 % (at 6°)")
    };
    assert!(said.lines().any(is_sixth), "{said}");
    assert!(words(&csv.stderr).lines().filter_map(|line| line.strip_prefix("fre: ")).any(is_sixth));
    snapbox::assert_data_eq!(
        said::words(&words(&csv.stderr)),
        snapbox::str![[r#"
fre: warning: front hinge of lamella #: strain # %, the material bears # % (at #°)
fre: warning: back hinge of lamella #: strain # %, the material bears # % (at #°)
fre: warning: front hinge of lamella #: strain # %, the material bears # % (at #°)
fre: warning: back hinge of lamella #: strain # %, the material bears # % (at #°)
fre: warning: front hinge of lamella #: strain # %, the material bears # % (at #°)
fre: warning: back hinge of lamella #: strain # %, the material bears # % (at #°)
"#]]
    );
    let lines = words(&csv.stdout);
    let column = lines.lines().next().unwrap().split(',').position(|name| name == "beyond_max_strain").unwrap();
    let cells: Vec<&str> = lines.lines().skip(1).map(|line| line.split(',').nth(column).unwrap()).collect();
    assert_eq!(cells, ["false", "true"]);
    let json: serde_json::Value =
        serde_json::from_slice(&fre(folder, &low, &["solve", "--format", "json"]).stdout).unwrap();
    assert_eq!(json[0]["beyond_max_strain"], serde_json::json!([]));
    assert_eq!(json[1]["beyond_max_strain"][0]["limit"], 0.05);
    let sweep = ["sweep", "--vary", "finger.material.max_strain=0.05,0.2", "--out", "out.csv"];
    // Told again by a sweep that finds all its rows known.
    for computed in [4, 0] {
        let output = fre(folder, &low, &sweep);
        let said = words(&output.stderr);
        let computed = if computed == 0 { "(0 computed, 4 from before)" } else { "(4 computed)" };
        assert_eq!(said.matches(computed).count(), 1, "{said}");
        let said = said.replace("fre: 4 of 4 rows are known already\n", "").replace(computed, "(COMPUTED)");
        snapbox::assert_data_eq!(
            said,
            snapbox::str![[r#"
fre: 4 rows (COMPUTED): 4 converged
fre: warning: 1 of 4 rows are strained beyond finger.material.max_strain, or beyond 30 % without it (true in column beyond_max_strain); the first is row 1: finger.material.max_strain=0.05 at 6°

"#]]
        );
        assert_eq!((output.status.code(), output.stdout.is_empty()), (Some(0), true));
    }
    let swept = std::fs::read_to_string(folder.join("out.csv")).unwrap();
    assert_eq!(swept.matches(",true,1,").count(), 1, "{swept}");
    // A limit that nothing reaches, and none.
    let said = words(&fre(folder, &text("max_strain = 0.3"), &["solve"]).stdout);
    assert_eq!(said::words(&notes(&said)), "First branch: largest force # N at #°; the motion meets no snap-through");
    let said = words(&fre(folder, &text(""), &["solve"]).stdout);
    let expected = "First branch: largest force # N at #°; the motion meets no snap-through\n\
                    Strains are checked against # %: finger.material.max_strain is not given";
    assert_eq!(said::words(&notes(&said)), expected);
    let last = notes(&said).lines().last().map(str::to_owned);
    assert_eq!(last.as_deref(), Some("Strains are checked against 30 %: finger.material.max_strain is not given"));
    let json: serde_json::Value =
        serde_json::from_slice(&fre(folder, &text(""), &["solve", "--format", "json"]).stdout).unwrap();
    assert_eq!(json[1]["beyond_max_strain"], serde_json::json!([]));
}

/// The object is far out of place: every kind of finger says so, be the material's limit known or not.
#[test]
fn implausible_strains_are_warned_of_without_a_limit_and_for_every_kind_of_finger() {
    let own = tempfile::tempdir().unwrap();
    let folder = own.path();
    let finger = include_str!("../../fre/src/case/presets/fea-80.toml").replace("\n[", "\n[finger.");
    let flexible = "kind = \"flexible\"";
    assert!(finger.contains(flexible));
    let without = finger
        .split("\n[finger.lamellae]")
        .next()
        .unwrap()
        .to_owned()
        .replace("thickness_mm = 2.0", "thickness_mm = 10")
        + "\n[finger.motor]\naxis_mm = [-14, -20]\n";
    let bowed = finger.replacen("thickness_mm = 2.0", "thickness_mm = 2.0\nsagitta_mm = 1.0", 1);
    let fingers = [
        ("flexible", finger.clone()),
        ("pinned", finger.replace(flexible, "kind = \"pinned\"")),
        ("welded", finger.replace(flexible, "kind = \"welded\"")),
        ("bowed", bowed),
        ("without lamellae", without),
    ];
    let mut all = String::new();
    for (kind, finger) in fingers {
        let text = format!(
            "[finger]\n{finger}\n[object]\nshape = \"circle\"\nradius_mm = 10\ncentre_mm = [11, 45]\n\
             [motion]\nmotor_angles_deg = [2, 10, 20, 30, 40]\n"
        );
        let output = fre(folder, &text, &["solve", "--format", "json"]);
        let json: serde_json::Value = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|_| panic!("{kind}: {}", String::from_utf8_lossy(&output.stderr)));
        let mut warned = 0;
        for place in json.as_array().unwrap() {
            let strain = &place["max_strain"];
            let largest = ["front", "back", "hinge"].map(|part| strain[part].as_f64().unwrap_or(0.0));
            let beyond = largest.into_iter().fold(0.0, f64::max) > 0.3;
            let listed = place["beyond_max_strain"].as_array().is_some_and(|parts| !parts.is_empty());
            assert_eq!(listed, beyond, "{kind}: {place}");
            warned += place["warnings"]
                .as_array()
                .unwrap()
                .iter()
                .filter(|w| w.as_str().unwrap().contains("more than 30 %"))
                .count();
        }
        assert!(warned > 0, "{kind}: {json}");
        let said = String::from_utf8_lossy(&fre(folder, &text, &["solve"]).stdout).into_owned();
        let warnings =
            said.lines().filter(|line| line.starts_with("warning: ")).map(|line| format!("{kind}: {line}\n"));
        let warnings = warnings.collect::<String>();
        assert!(warnings.lines().any(|line| line.contains("%, more than 30 %: check where")), "{warnings}");
        all += &warnings;
    }
    snapbox::assert_data_eq!(
        said::words(&all),
        snapbox::str![[r#"
flexible: warning: lamella # and lamella # touch each other (from #° on; at #° they overlap by # mm at x = # mm, y = # mm), which the model does not know: its force is too small from there on
flexible: warning: front hinge of lamella #: strain # %, more than # %: check where the case has its object and how far the finger moves; finger.material.max_strain sets another limit (at #°)
flexible: warning: back hinge of lamella #: strain # %, more than # %: check where the case has its object and how far the finger moves; finger.material.max_strain sets another limit (at #°)
flexible: warning: front hinge of lamella #: strain # %, more than # %: check where the case has its object and how far the finger moves; finger.material.max_strain sets another limit (at #°)
pinned: warning: finger.hinge.length_mm, finger.hinge.thickness_mm, finger.hinge.from have no effect: hinges with finger.hinge.kind = "pinned" have no necks
pinned: warning: lamella # and lamella # touch each other (from #° on; at #° they overlap by # mm at x = # mm, y = # mm), which the model does not know: its force is too small from there on
pinned: warning: back beam at # mm: strain # %, more than # %: check where the case has its object and how far the finger moves; finger.material.max_strain sets another limit (at #°)
welded: warning: finger.hinge.kind = "welded": the model's lamellae are rigid, real ones bend with the beams; the force is too large (by # % for fea-# with lamellae of # mm; `fre compare --fea` measures it for this case)
welded: warning: finger.hinge.length_mm, finger.hinge.thickness_mm, finger.hinge.from have no effect: hinges with finger.hinge.kind = "welded" have no necks
welded: warning: back beam at # mm: strain # %, more than # %: check where the case has its object and how far the finger moves; finger.material.max_strain sets another limit (at #°)
welded: warning: front beam at # mm: strain # %, more than # %: check where the case has its object and how far the finger moves; finger.material.max_strain sets another limit (at #°)
bowed: warning: lamella # and lamella # touch each other (from #° on; at #° they overlap by # mm at x = # mm, y = # mm), which the model does not know: its force is too small from there on
bowed: warning: front hinge of lamella #: strain # %, more than # %: check where the case has its object and how far the finger moves; finger.material.max_strain sets another limit (at #°)
bowed: warning: back hinge of lamella #: strain # %, more than # %: check where the case has its object and how far the finger moves; finger.material.max_strain sets another limit (at #°)
bowed: warning: front hinge of lamella #: strain # %, more than # %: check where the case has its object and how far the finger moves; finger.material.max_strain sets another limit (at #°)
without lamellae: warning: the object reaches # mm into the back beam (at #°), which the model lets it pass through: check where the case has it
without lamellae: warning: front beam and back beam touch each other (from #° on; at #° they overlap by # mm at x = # mm, y = # mm), which the model does not know: its force is too small from there on
without lamellae: warning: front beam at # mm: strain # %, more than # %: check where the case has its object and how far the finger moves; finger.material.max_strain sets another limit (at #°)
without lamellae: warning: back beam at # mm: strain # %, more than # %: check where the case has its object and how far the finger moves; finger.material.max_strain sets another limit (at #°)
"#]]
    );
}

/// A picture's words, without what are numbers only.
fn labels(words: &str) -> String {
    said::words(words).lines().filter(|line| line.chars().any(char::is_alphabetic)).collect::<Vec<_>>().join("\n")
}

#[test]
fn every_kind_of_picture_is_drawn() {
    let own = tempfile::tempdir().unwrap();
    let folder = own.path();
    let text = "finger = \"preset:fea-80\"\nobject = { shape = \"circle\", radius_mm = 40, centre_mm = [41, 60] }\n\
        motion.motor_angles_deg = [0, 9, 12, 13]\n";
    let words = |name: &str| {
        let svg = std::fs::read_to_string(folder.join(name)).unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
        let tree = roxmltree::Document::parse(&svg).unwrap();
        // Letters are outlines; the words lie over them.
        assert!(svg.contains("<use href=\"#letter0-") && svg.contains(".hidden{fill-opacity:0}"));
        let texts = tree.descendants().filter(|node| node.has_tag_name("text"));
        let joined = |node: roxmltree::Node| {
            node.descendants().filter(roxmltree::Node::is_text).filter_map(|n| n.text()).collect::<String>()
        };
        texts.map(joined).collect::<Vec<_>>().join("\n")
    };
    let drawn = |kind: &str, more: &[&str]| {
        let arguments = [&["solve", "--force", "--plot", "a.svg", "--plot-kind", kind], more].concat();
        let output = fre(folder, text, &arguments);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        words("a.svg")
    };
    let force = drawn("force", &[]);
    snapbox::assert_data_eq!(
        labels(&force),
        snapbox::str![[r#"
Contact force over motor angle
fea-# on a cylinder Ø# mm at (#, #) mm; force on the object, world frame
magnitude |F|
Fx
Fy
jump of |F|
force (N)
snap-through at #°
# N at #°
branch #
motor angle α (°)
"#]]
    );
    assert!(force.lines().any(|line| line.starts_with("snap-through at 11.")), "{force}");
    // The largest force lies between two places; it is marked where it is.
    assert!(force.lines().any(|line| line.starts_with("22.3") && line.contains(" N at 10.")), "{force}");
    // Rounding of an undeformed finger is not drawn as if it were something.
    let open = drawn("strain", &["--plot-at", "0"]);
    snapbox::assert_data_eq!(
        labels(&open),
        snapbox::str![[r#"
Strain at the outer fibres
α = #°: bending and stretch, positive where drawn out; the material's limit is not known
(finger.material.max_strain)
face on the object's side
other face
front hinges
back hinges
front beam (%)
back beam (%)
hinges, largest (%)
arc length of the beam from the base s (mm); dashed: lamellae
"#]]
    );
    // Where there is no trustworthy solution the axis goes on, and says why.
    let failing = text
        .replace("radius_mm = 40", "radius_mm = 1000")
        .replace("[41, 60]", "[1001, 60]")
        .replace("[0, 9,", "[0, 3, 9,");
    let output = fre(folder, &failing, &["solve", "--force", "--plot", "a.svg", "--plot-kind", "finger,force"]);
    assert_eq!(output.status.code(), Some(2));
    let lost = words("a.svg");
    assert!(
        lost.lines().any(|word| word == "12") && lost.lines().any(|word| word.contains("cylinder Ø2000 mm")),
        "{lost}"
    );
    snapbox::assert_data_eq!(
        labels(&lost),
        snapbox::str![[r#"
fea-# on a cylinder Ø# mm at (#, #) mm
scheme simpson #/#, physics extended, f#
front beam
back beam
lamellae
undeformed
contact forces
net force
cylinder Ø# mm
α = #°
F = # N
# N
# mm
Contact force over motor angle
fea-# on a cylinder Ø# mm at (#, #) mm; force on the object, world frame
magnitude |F|
Fx
Fy
force (N)
out-of-range
motor angle α (°)
"#]]
    );
    snapbox::assert_data_eq!(
        labels(&drawn("pressure", &[])),
        snapbox::str![[r#"
Contact force per length along the front beam
α = #°: F = # N; largest # N/mm at # mm, that is # N/mm² over the finger's width
touching samples, each over the length it stands for
force per length (N/mm)
arc length from the base s (mm); dashed: lamellae, numbered from the base
"#]]
    );
    snapbox::assert_data_eq!(
        labels(&drawn("pressure", &["--plot-at", "0"])),
        snapbox::str![[r#"
Contact force per length along the front beam
α = #°: no contact
touching samples, each over the length it stands for
force per length (N/mm)
arc length from the base s (mm); dashed: lamellae, numbered from the base
"#]]
    );
    let strain = drawn("strain", &["--plot-at", "9"]);
    assert!(strain.lines().any(|line| line.starts_with("α = 9°: ")), "{strain}");
    snapbox::assert_data_eq!(
        labels(&strain),
        snapbox::str![[r#"
Strain at the outer fibres
α = #°: bending and stretch, positive where drawn out; the material's limit is not known
(finger.material.max_strain)
face on the object's side
other face
front hinges
back hinges
front beam (%)
back beam (%)
hinges, largest (%)
arc length of the beam from the base s (mm); dashed: lamellae
"#]]
    );
    snapbox::assert_data_eq!(
        labels(&drawn("all", &[])),
        snapbox::str![[r#"
fea-# on a cylinder Ø# mm at (#, #) mm
scheme simpson #/#, physics extended, f#
front beam
back beam
lamellae
undeformed
contact forces
net force
cylinder Ø# mm
α = #°
F = # N
# N
# mm
Contact force over motor angle
fea-# on a cylinder Ø# mm at (#, #) mm; force on the object, world frame
magnitude |F|
Fx
Fy
jump of |F|
force (N)
snap-through at #°
# N at #°
branch #
motor angle α (°)
Force and torque while closing and opening
fea-# on a cylinder Ø# mm at (#, #) mm
closing
force |F| (N)
torque (N·mm)
motor angle α (°)
Contact force per length along the front beam
α = #°: F = # N; largest # N/mm at # mm, that is # N/mm² over the finger's width
touching samples, each over the length it stands for
force per length (N/mm)
arc length from the base s (mm); dashed: lamellae, numbered from the base
Strain at the outer fibres
α = #°: bending and stretch, positive where drawn out; the material's limit is not known
(finger.material.max_strain)
face on the object's side
other face
front hinges
back hinges
front beam (%)
back beam (%)
hinges, largest (%)
arc length of the beam from the base s (mm); dashed: lamellae
"#]]
    );
    snapbox::assert_data_eq!(
        labels(&drawn("finger,strain", &[])),
        snapbox::str![[r#"
fea-# on a cylinder Ø# mm at (#, #) mm
scheme simpson #/#, physics extended, f#
front beam
back beam
lamellae
undeformed
contact forces
net force
cylinder Ø# mm
α = #°
F = # N
# N
# mm
Strain at the outer fibres
α = #°: bending and stretch, positive where drawn out; the material's limit is not known
(finger.material.max_strain)
face on the object's side
other face
front hinges
back hinges
front beam (%)
back beam (%)
hinges, largest (%)
arc length of the beam from the base s (mm); dashed: lamellae
"#]]
    );
    let [light, dark] = ["light", "dark"].map(|theme| {
        fre(folder, text, &["solve", "--force", "--plot", "a.png", "--plot-theme", theme]);
        tiny_skia::Pixmap::decode_png(&std::fs::read(folder.join("a.png")).unwrap()).unwrap().pixel(1, 1).unwrap()
    });
    assert!(light.red() == 255 && dark.red() < 30);
}
