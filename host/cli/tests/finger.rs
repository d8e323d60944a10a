//! `fre finger`: a finger goes out as a drawing or a solid and comes back as a case that can be solved.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn fre(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fre")).args(words).current_dir(folder).output().unwrap()
}

const CASE: &str = "finger = \"preset:ladder-80\"\nobject = { shape = \"circle\", radius_mm = 40, centre_mm = [41, 45] }\n\
    motion = { motor_angles_deg = [2] }\n";

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_preset_goes_out_and_comes_back_as_a_case_that_can_be_solved() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for ending in ["dxf", "svg", "stl"] {
        let file = format!("a.{ending}");
        let out = fre(folder, &["finger", "export", "preset:fea-80", "--output", &file]);
        assert!(out.status.success(), "{}", said(&out));
        let back = fre(folder, &["finger", "import", &file, "--output", "a.toml", "--force"]);
        assert!(back.status.success(), "{}", said(&back));
        if ending == "dxf" {
            snapbox::assert_data_eq!(
                said(&back),
                snapbox::str![[r#"
fre: front wall 2.00 mm, back wall 2.00 mm, 6 rungs, solid above 74.12 mm
fre: rung 1: height 10.00 mm, angle 0.00°, thickness 3.00 to 3.00 mm, clear length 22.44 mm, necks 0.80 mm thick, 2.50 and 2.50 mm long
fre: rung 2: height 20.00 mm, angle 0.00°, thickness 3.00 to 3.00 mm, clear length 18.94 mm, necks 0.80 mm thick, 2.50 and 2.50 mm long
fre: rung 3: height 30.00 mm, angle 0.00°, thickness 3.00 to 3.00 mm, clear length 15.44 mm, necks 0.80 mm thick, 2.50 and 2.50 mm long
fre: rung 4: height 40.00 mm, angle 0.00°, thickness 3.00 to 3.00 mm, clear length 11.94 mm, necks 0.80 mm thick, 2.50 and 2.50 mm long
fre: rung 5: height 50.00 mm, angle 0.00°, thickness 3.00 to 3.00 mm, clear length 8.44 mm, necks 0.80 mm thick, 2.50 and 2.50 mm long
fre: rung 6: height 60.00 mm, angle 0.00°, thickness 3.00 to 3.00 mm, clear length 4.94 mm, necks 0.80 mm thick, 1.97 and 1.97 mm long
fre: to decide: finger.back.clamp_mm: both beams were taken to be held as far as the solid base reaches; bolts or a holder may hold the back beam higher

"#]]
            );
        }
        let text = fs::read_to_string(folder.join("a.toml")).unwrap();
        if ending == "dxf" {
            snapbox::assert_data_eq!(
                text.as_str(),
                snapbox::str![[r##"
# A finger measured in its outline. What is marked TO DECIDE is an assumption.
# TO DECIDE finger.back.clamp_mm: both beams were taken to be held as far as the solid base reaches; bolts or a holder may hold the back beam higher

[finger]
name = "a"
width_mm = 20.0    # TO DECIDE: a drawing has no depth
plane_strain = "auto"

[finger.material]
youngs_modulus_pa = 1e7    # TO DECIDE: a placeholder; forces are proportional to it (fre calibrate)
poissons_ratio = 0.45    # TO DECIDE: a placeholder

[finger.front]
base_mm = [0.0, 0.0]
tip_mm = [0.0, 80.0]
thickness_mm = 2.0

[finger.back]
base_mm = [-28.0, 0.0]
tip_mm = [0.0, 80.0]
thickness_mm = 2.0

[finger.lamellae]
heights_mm = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0]
thickness_mm = 3.0
# arcs of the axes on the centrelines: front [10.0, 20.0, 30.0, 40.0, 50.0, 60.0], back [10.595, 21.19, 31.784, 42.379, 52.974, 63.569]
# clear lengths between the walls' faces: [22.441, 18.941, 15.441, 11.941, 8.441, 4.941]

[finger.hinge]
kind = "flexible"
length_mm = [2.5, 2.5, 2.5, 2.5, 2.5, 1.97]
thickness_mm = 0.8
from = "face"

[finger.tip]
rigid_above_mm = 74.116

[object]    # TO DECIDE: an example
shape = "circle"
radius_mm = 40.0
centre_mm = [41.0, 40.0]

[motion]    # TO DECIDE: an example; a motor needs [finger.motor] axis_mm and motor_angles_deg
direction = [1.0, 0.0]
distances_mm = [1, 2, 3, 4, 5]

"##]]
            );
        }
        assert_eq!(text.matches("a drawing has no depth").count(), usize::from(ending != "stl"), "{text}");
        let solved = fre(folder, &["solve", "a.toml", "--format", "csv"]);
        assert!(solved.status.success(), "{ending}: {}\n{text}", said(&solved));
        assert_eq!(String::from_utf8_lossy(&solved.stdout).matches("converged").count(), 5);
    }
    // Text formats go to standard output, and a file that exists is kept.
    let svg = fre(folder, &["finger", "export", "preset:fea-80", "--format", "svg"]);
    assert!(String::from_utf8_lossy(&svg.stdout).contains("fill-rule=\"evenodd\""));
    let kept = fre(folder, &["finger", "export", "preset:fea-80", "--output", "a.svg"]);
    let refused = "fre: --output: a.svg exists; --force overwrites it\n";
    assert_eq!((kept.status.code(), said(&kept).as_str()), (Some(1), refused));
}

#[test]
fn ribs_are_drawn_measured_and_solved() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let finger = "width_mm = 20\nmaterial = { youngs_modulus_pa = 1e7, poissons_ratio = 0.4 }\n\
        front = { base_mm = [0, 0], tip_mm = [0, 80], thickness_mm = 2 }\n\
        back = { base_mm = [-28, 0], tip_mm = [0, 80], thickness_mm = 2 }\n\
        lamellae = { kind = \"rib\", ends = \"welded\", heights_mm = [9, 18, 27, 36, 45, 54, 63], angle_deg = 20, thickness_mm = 1.2 }\n";
    fs::write(folder.join("ribs.toml"), finger).unwrap();
    let out = fre(folder, &["finger", "export", "ribs.toml", "--output", "ribs.stl"]);
    assert!(out.status.success(), "{}", said(&out));
    let back = fre(folder, &["finger", "import", "ribs.stl"]);
    assert!(back.status.success(), "{}", said(&back));
    let text = String::from_utf8(back.stdout).unwrap();
    snapbox::assert_data_eq!(
        &text,
        snapbox::str![[r##"
# A finger measured in its outline. What is marked TO DECIDE is an assumption.
# TO DECIDE finger.back.clamp_mm: both beams were taken to be held as far as the solid base reaches; bolts or a holder may hold the back beam higher

[finger]
name = "ribs"
width_mm = 20.0
plane_strain = "auto"

[finger.material]
youngs_modulus_pa = 1e7    # TO DECIDE: a placeholder; forces are proportional to it (fre calibrate)
poissons_ratio = 0.45    # TO DECIDE: a placeholder

[finger.front]
base_mm = [0.0, 0.0]
tip_mm = [0.0, 80.0]
thickness_mm = 2.0

[finger.back]
base_mm = [-28.0, 0.0]
tip_mm = [0.0, 80.0]
thickness_mm = 2.0

[finger.lamellae]
kind = "rib"
ends = "welded"
heights_mm = [9.0, 18.0, 27.0, 36.0, 45.0, 54.0, 63.0]
angle_deg = 20.0
thickness_mm = 1.2
# arcs of the axes on the centrelines: front [4.478, 14.051, 23.624, 33.197, 42.771, 52.344, 61.917], back [13.785, 22.782, 31.778, 40.775, 49.772, 58.768, 67.765]
# clear lengths between the walls' faces: [22.886, 19.724, 16.561, 13.398, 10.235, 7.073, 3.91]

[finger.tip]
rigid_above_mm = 74.116

[object]    # TO DECIDE: an example
shape = "circle"
radius_mm = 40.0
centre_mm = [41.0, 40.0]

[motion]    # TO DECIDE: an example; a motor needs [finger.motor] axis_mm and motor_angles_deg
direction = [1.0, 0.0]
distances_mm = [1, 2, 3, 4, 5]

"##]]
    );
    fs::write(folder.join("again.toml"), &text).unwrap();
    // A case with ribs can be drawn again, and solved.
    assert!(fre(folder, &["finger", "export", "again.toml", "--output", "again.dxf"]).status.success());
    let solved = fre(folder, &["solve", "again.toml", "--format", "csv"]);
    assert!(solved.status.success(), "{}", said(&solved));
    assert_eq!(String::from_utf8_lossy(&solved.stdout).matches("converged").count(), 5);
}

#[test]
fn no_drawing_takes_the_place_of_what_it_is_drawn_from() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // One that can be drawn and not be computed, with fillets of more than twice a thickness: what is named must not depend on that.
    let finger = "width_mm = 20\nmaterial = { youngs_modulus_pa = 1e7, poissons_ratio = 0.4 }\n\
        front = { base_mm = [0, 0], tip_mm = [0, 80], thickness_mm = 2 }\n\
        back = { base_mm = [-28, 0], tip_mm = [0, 80], thickness_mm = 2 }\n\
        lamellae = { kind = \"rib\", ends = \"welded\", fillet_mm = 2.5, heights_mm = [9, 27], thickness_mm = 1.2 }\n";
    let case = "finger = \"drawn.svg\"\nobject = { shape = \"circle\", radius_mm = 40, centre_mm = [41, 45] }\n\
        motion.motor_angles_deg = [2]\n";
    fs::write(folder.join("drawn.svg"), finger).unwrap();
    fs::write(folder.join("case.toml"), case).unwrap();
    for (file, what) in [("case.toml", "the case"), ("drawn.svg", "the finger of the case")] {
        let words = ["finger", "export", "case.toml", "--format", "svg", "--force", "--output", file];
        let refused = fre(folder, &words);
        let expected =
            format!("fre: --output: {file} is the same file as {what} ({file}); an output needs a file of its own\n");
        assert_eq!((refused.status.code(), said(&refused)), (Some(1), expected));
    }
    assert_eq!(fs::read_to_string(folder.join("drawn.svg")).unwrap(), finger);
    assert_eq!(fs::read_to_string(folder.join("case.toml")).unwrap(), case);
    // The same as by a file's name, on standard output.
    let [named, plain] = [&["--output", "-"][..], &[]]
        .map(|output| fre(folder, &[&["finger", "export", "case.toml", "--format", "svg"], output].concat()));
    assert!(named.status.success() && named.stdout == plain.stdout, "{}", said(&named));
    assert!(!folder.join("-").exists());
}

/// Tips that do not meet in a point, either side as the front, walls that narrow: what is written can be solved.
#[test]
fn whatever_is_measured_can_be_solved() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let ribs = "lamellae = { kind = \"rib\", ends = \"welded\", heights_mm = [9, 18, 27, 36, 45, 54, 63], thickness_mm = 1.2 }\n";
    let blunt = "base_mm = [-28, -4], tip_mm = [-8, 80]";
    for (front, back) in [
        ("tip_mm = [0, 80], thickness_mm = 2", "base_mm = [-35, -4], tip_mm = [0, 80]"),
        ("tip_mm = [-8, 80], thickness_mm = 2", blunt),
        ("tip_mm = [0, 80], thickness_mm = [[0, 3], [80, 1]]", "base_mm = [-28, 0], tip_mm = [0, 80]"),
        ("tip_mm = [-8, 80], thickness_mm = [[0, 2.4], [80, 1.6]]", blunt),
    ] {
        let finger = format!(
            "width_mm = 20\nmaterial = {{ youngs_modulus_pa = 1e7, poissons_ratio = 0.4 }}\n\
             front = {{ base_mm = [0, 0], {front} }}\nback = {{ {back}, thickness_mm = 2 }}\n{ribs}"
        );
        fs::write(folder.join("drawn.toml"), &finger).unwrap();
        let out = fre(folder, &["finger", "export", "drawn.toml", "--output", "drawn.dxf", "--force"]);
        assert!(out.status.success(), "{}", said(&out));
        for side in ["right", "left"] {
            let words = ["finger", "import", "drawn.dxf", "--front", side, "--output", "again.toml", "--force"];
            let back = fre(folder, &words);
            assert!(back.status.success(), "{}", said(&back));
            let solved = fre(folder, &["solve", "again.toml", "--elements", "reduced"]);
            let text = fs::read_to_string(folder.join("again.toml")).unwrap();
            assert!(solved.status.success(), "{side}, {finger}: {}\n{text}", said(&solved));
        }
    }
}

/// Necks that leave no bar between them: they can be drawn, and not be computed.
#[test]
fn what_cannot_be_solved_is_refused_by_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let finger = "width_mm = 20\nmaterial = { youngs_modulus_pa = 1e7, poissons_ratio = 0.4 }\n\
        front = { base_mm = [0, 0], tip_mm = [0, 80], thickness_mm = 2 }\n\
        back = { base_mm = [-35, 0], tip_mm = [0, 80], thickness_mm = 2 }\n\
        lamellae = { heights_mm = [9, 18, 27, 36, 45, 54, 63], thickness_mm = 3 }\n\
        hinge = { kind = \"flexible\", length_mm = 2.5, thickness_mm = 0.8, from = \"face\" }\n";
    fs::write(folder.join("drawn.toml"), finger).unwrap();
    assert!(fre(folder, &["finger", "export", "drawn.toml", "--output", "drawn.dxf"]).status.success());
    let refused = fre(folder, &["finger", "import", "drawn.dxf", "--output", "again.toml"]);
    assert_eq!(refused.status.code(), Some(1));
    let last = said(&refused).lines().last().unwrap_or_default().to_owned();
    snapbox::assert_data_eq!(
        last,
        snapbox::str![
            "fre: drawn.dxf: what was measured cannot be solved: finger.hinge.length_mm = 2.5: lamella 7 (counted from 1 at the base) is [..] mm wide, its two hinges need [..] mm"
        ]
    );
    assert!(!folder.join("again.toml").exists());
}

/// A pipe is gone once it is read.
#[cfg(unix)]
#[test]
fn a_finger_is_read_from_a_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("case.toml"), CASE).unwrap();
    for format in ["svg", "urdf"] {
        let file = format!("piped.{format}");
        let mut command = Command::new("sh");
        let words = "cat case.toml | \"$1\" finger export /dev/stdin --output \"$2\"";
        let output = command.args(["-c", words, "sh", env!("CARGO_BIN_EXE_fre"), &file]).current_dir(folder);
        let output = output.output().unwrap();
        assert!(output.status.success() && folder.join(&file).exists(), "{}", said(&output));
    }
}
