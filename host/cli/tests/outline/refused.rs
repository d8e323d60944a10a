//! What `fre outline` warns of and refuses.

use crate::said;
use crate::scene::{Folder, MARKS, STRAIGHT, command, deviation, exact_marks, mark, sheet, solved, words};
use fre::fit::measured::Measured;
use std::process::Command;
use test_photograph::{DARK_FINGER, Eye, Lights, Sheet, save};

#[test]
fn a_series_outlives_what_cannot_be_added() {
    let folder = Folder::new();
    let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, [8.0, 10.0, 0.0], false);
    save(&eye.photograph(sheet(DARK_FINGER, &solved(), &MARKS, false).light(), 1.3, 3.0, 4), &folder.path("photo.png"));
    let marks = exact_marks(&eye);
    let add = command(&marks, &["--output", "series.csv", "--append"]);
    // An empty file has no other columns: it gets these.
    std::fs::write(folder.path("series.csv"), "").unwrap();
    assert_eq!(folder.fre(&add).status.code(), Some(0));
    let once = std::fs::read_to_string(folder.path("series.csv")).unwrap();
    assert!(once.starts_with("motor_angle_deg,force_n,") && once.lines().count() > 60, "{once}");
    let limited = |trap: &str| {
        let limit = format!("{trap} ulimit -f 4; exec \"$0\" \"$@\"");
        let fre = ["-c", &limit, env!("CARGO_BIN_EXE_fre")];
        let output = Command::new("sh").args(fre).args(&add).current_dir(folder.0.path()).output().unwrap();
        assert!(!output.status.success());
        assert_eq!(std::fs::read_to_string(folder.path("series.csv")).unwrap(), once);
        words(&output.stderr)
    };
    // Refused as by a full disk, and killed.
    let told = limited("trap '' XFSZ;");
    // The file beside it has a name of its own.
    let (before, _) = told.split_once(" at path").unwrap_or((&told, ""));
    assert_eq!(before, "fre: --output: series.csv cannot be written: File too large (os error 27)");
    let files = || std::fs::read_dir(folder.0.path()).unwrap().count();
    assert_eq!(files(), 3, "nothing else is left beside it");
    limited("");

    // By a link, with the permissions of before.
    use std::os::unix::fs::{PermissionsExt, symlink};
    std::fs::set_permissions(folder.path("series.csv"), std::fs::Permissions::from_mode(0o640)).unwrap();
    symlink("series.csv", folder.path("link.csv")).unwrap();
    assert_eq!(folder.fre(&command(&marks, &["--output", "link.csv", "--append"])).status.code(), Some(0));
    assert!(folder.path("link.csv").symlink_metadata().unwrap().is_symlink());
    let file = folder.path("series.csv");
    assert_eq!(file.metadata().unwrap().permissions().mode() & 0o777, 0o640);
    let rows = once.split_once('\n').unwrap().1;
    assert_eq!(std::fs::read_to_string(file).unwrap(), format!("{once}{rows}"));
    // Twice the same photograph is as far from the model as once.
    let mean = |csv: &str| {
        std::fs::write(folder.path("compared.csv"), csv).unwrap();
        let output = folder.fre(&["compare", "case.toml", "--measured", "compared.csv", "--format", "json"]);
        let compared: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        compared["rows"][0]["shape_mean_mm"].as_f64().unwrap()
    };
    assert!((mean(&once) - mean(&format!("{once}{rows}"))).abs() < 1e-9);
    let told = words(&folder.fre(&command(&marks, &["--output", "/dev/null", "--append"])).stderr);
    snapbox::assert_data_eq!(
        told,
        snapbox::str![[r#"
fre: /dev/null: is not a file; --append adds to one

"#]]
    );
}

#[test]
fn marks_that_disagree_or_check_nothing_are_warned_of() {
    let folder = Folder::new();
    let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, [3.0, -2.0, 0.0], false);
    save(
        &eye.photograph(sheet(DARK_FINGER, &solved(), &MARKS, false).light(), 1.2, 2.0, 11),
        &folder.path("photo.png"),
    );
    let told = |fifth: &[[f64; 2]], off: f64| {
        let mut marks = exact_marks(&eye);
        marks.extend(fifth.iter().map(|&mm| mark(eye.pixel(mm), mm)));
        let [x, y] = eye.pixel(MARKS[2]);
        marks[2] = mark([x + off, y], MARKS[2]);
        let output = folder.fre(&command(&marks, &[]));
        assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
        words(&output.stderr)
    };
    snapbox::assert_data_eq!(
        said::words(&told(&[], 0.0)),
        snapbox::str![[r#"
marks #, no residual: four marks fit any perspective, a fifth or a camera would check them
outline # points, arc length # to # mm, # mm per pixel
edges contrast # % of white, blur # px, scatter # mm before smoothing
thickness # % of the design's
"#]]
    );
    // Off the lines between the others all are checked.
    let inside = [[-30.0, 10.0], [12.0, 60.0]];
    snapbox::assert_data_eq!(
        said::words(&told(&inside, 0.0)),
        snapbox::str![[r#"
marks #, residual # px (# mm) rms
outline # points, arc length # to # mm, # mm per pixel
edges contrast # % of white, blur # px, scatter # mm before smoothing
thickness # % of the design's
"#]]
    );
    snapbox::assert_data_eq!(
        said::words(&told(&inside, 12.0)),
        snapbox::str![[r#"
marks #, residual # px (# mm) rms
# mm is more than # mm: a mark's pixel or millimetres are probably wrong, the marks lie in no plane, or the lens bends lines (--checkerboard); the outline is off by as much
outline # points, arc length # to # mm, # mm per pixel
edges contrast # % of white, blur # px, scatter # mm before smoothing
thickness # % of the design's
"#]]
    );
    // Between the first two: the others may lie anywhere on a line.
    let between = told(&[[-9.0, -13.0]], 0.0);
    let [x, y] = eye.pixel(MARKS[2]);
    let named = format!("an error of {x:.0},{y:.0}=14,97 or ");
    assert!(between.lines().any(|line| line.trim_start().starts_with(&named)), "{named}: {between}");
    snapbox::assert_data_eq!(
        said::words(&between),
        snapbox::str![[r#"
marks #, residual # px (# mm) rms
an error of #,#=#,# or #,#=-#,# may not show in the residual: the others do not check it in every direction; more marks, off the lines between these, or a camera would
outline # points, arc length # to # mm, # mm per pixel
edges contrast # % of white, blur # px, scatter # mm before smoothing
thickness # % of the design's
"#]]
    );
}

/// A finger cut out: black under what is transparent, and how much of the finger a pixel is of in its alpha.

#[test]
fn what_is_transparent_is_white_and_a_torn_picture_is_told() {
    let folder = Folder::new();
    let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, [6.0, -5.0, 2.0], false);
    let solution = solved();
    let grey = eye.photograph(sheet(DARK_FINGER, &solution, &MARKS, false).light(), 1.2, 2.0, 12);
    let marks = exact_marks(&eye);
    let save_rgba = |of: &dyn Fn(u8) -> [u8; 4]| {
        let picture =
            image::RgbaImage::from_fn(grey.width(), grey.height(), |x, y| image::Rgba(of(grey.get_pixel(x, y).0[0])));
        picture.save(folder.path("photo.png")).unwrap();
        let output = folder.fre(&command(&marks, &[]));
        assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
        (words(&output.stdout), words(&output.stderr))
    };
    let (opaque, plain) = save_rgba(&|light| [light, light, light, 255]);
    let (cut, said) = save_rgba(&|light| [0, 0, 0, 255 - light]);
    assert_ne!(plain, said);
    snapbox::assert_data_eq!(
        said::words(&said),
        snapbox::str![[r#"
picture transparent in places: taken as before white
marks #, no residual: four marks fit any perspective, a fifth or a camera would check them
outline # points, arc length # to # mm, # mm per pixel
edges contrast # % of white, blur # px, scatter # mm before smoothing
thickness # % of the design's
"#]]
    );
    let points = |csv: &str| Measured::parse("outline", csv).unwrap().measurements[0].front.clone();
    let [a, b] = [points(&opaque), points(&cut)];
    assert_eq!(a.len(), b.len());
    assert!(a.iter().zip(&b).all(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-3));
    let [mean, max] = deviation(&b, solution.front_mm());
    assert!(mean < 0.03 && max < 0.1, "mean {mean}, max {max}");

    let mut jpeg = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 95).encode_image(&grey).unwrap();
    for (length, torn) in [(jpeg.len(), false), (jpeg.len() - 2, true), (jpeg.len() / 3, true), (300, true)] {
        std::fs::write(folder.path("photo.png"), &jpeg[..length]).unwrap();
        let output = folder.fre(&command(&marks, &[]));
        let told = words(&output.stderr);
        assert_eq!(output.status.success(), !torn, "{length}: {told}");
        if torn {
            snapbox::assert_data_eq!(
                told,
                snapbox::str![[r#"
fre: photo.png: cannot be read: it is truncated: the file ends before the picture does

"#]]
            );
        } else {
            assert!(!told.lines().any(|line| line.starts_with("fre: ")), "{told}");
        }
    }
    // What cameras put behind the picture is none of it.
    jpeg.extend(b"\xff\xd8\xff\xda trailer");
    std::fs::write(folder.path("photo.png"), &jpeg).unwrap();
    assert!(folder.fre(&command(&marks, &[])).status.success());
}

#[test]
fn a_picture_too_coarse_for_two_edges_is_told_so() {
    let folder = Folder::new();
    let eye = Eye { size: [125, 163], focal: [212.5, 212.5], centre: [62.0, 81.0], ..STRAIGHT };
    let eye = eye.looking_at([-8.0, 40.0], 170.0, [0.0; 3], false);
    save(&eye.photograph(sheet(DARK_FINGER, &solved(), &MARKS, false).light(), 0.7, 2.0, 9), &folder.path("photo.png"));
    let told = folder.refusal(&exact_marks(&eye), &[]);
    snapbox::assert_data_eq!(
        told,
        snapbox::str![[r#"
fre: no beam 2 mm thick near pixel 72,126 (arc length 4 to 32 mm); the picture is too coarse: the beam is 2.5 pixels thick, needed are about 5

"#]]
    );
}

#[test]
fn what_cannot_be_measured_is_said() {
    let folder = Folder::new();
    let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, [0.0, 0.0, 0.0], false);
    let solution = solved();
    let marks = exact_marks(&eye);
    let faint = Lights { ground: 120, finger: 117, object: 118, dots: 10 };
    save(&eye.photograph(sheet(faint, &solution, &MARKS, false).light(), 1.2, 1.0, 5), &folder.path("photo.png"));
    let mut said = String::new();
    let mut turned = command(&marks, &[]);
    turned[5] = "181";
    said += &format!("turned too far\n{}\n", words(&folder.fre(&turned).stderr));
    std::fs::write(folder.path("marks.toml"), "[[mark]]\npixel = [1.0, 2.0]\nmm = \"here\"\n").unwrap();
    let file = ["outline", "photo.png", "--case", "case.toml", "--angle-deg", "8", "--marks-file", "marks.toml"];
    said += &format!("a mark in words\n{}\n", words(&folder.fre(&file).stderr));
    let mut refused = |what: &str, marks: &[String], options: &[&str]| {
        said += &format!("{what}\n{}\n", folder.refusal(marks, options));
    };
    refused("a faint finger", &marks, &[]);
    let blank = Sheet::draw(DARK_FINGER, |_| ());
    save(&eye.photograph(blank.light(), 1.2, 2.0, 6), &folder.path("photo.png"));
    refused("nothing", &marks, &[]);
    refused("nothing, marks on dots", &marks, &["--dot-mm", "4"]);

    let sheet = sheet(DARK_FINGER, &solution, &MARKS, false);
    save(&eye.photograph(sheet.light(), 1.2, 2.0, 7), &folder.path("photo.png"));
    let mut changed = marks.clone();
    changed[2] = mark([4000.0, 20.0], MARKS[2]);
    refused("a mark beside the picture", &changed, &[]);
    let on_line: Vec<String> =
        [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [5.0, 60.0]].iter().map(|&mm| mark(eye.pixel(mm), mm)).collect();
    refused("three marks on a line", &on_line, &[]);
    refused("three marks", &marks[..3], &[]);
    let crossed: Vec<String> = MARKS.iter().zip([0, 1, 3, 2]).map(|(&mm, i)| mark(eye.pixel(MARKS[i]), mm)).collect();
    refused("exchanged marks", &crossed, &[]);
    let shifted: Vec<String> = MARKS.iter().map(|&mm| mark(eye.pixel(mm), [mm[0] + 12.0, mm[1]])).collect();
    refused("marks 12 mm off", &shifted, &[]);
    let away: Vec<String> = MARKS.iter().map(|&mm| mark(eye.pixel(mm), [mm[0], mm[1] + 200.0])).collect();
    refused("marks 200 mm off", &away, &[]);
    refused("an SVG", &marks, &["--plot", "x.svg"]);
    refused("a force that pulls", &marks, &["--force-n", "-1"]);
    refused("beyond the beam", &marks, &["--to-mm", "99"]);
    refused("a mark without a place", &marks, &["--marks", "1,2=3"]);
    refused("no checkerboard", &marks, &["--squares", "10x7", "--checkerboard", "photo.png", "photo.png", "photo.png"]);

    // A picture that would not fit into memory is refused by its header: a bitmap of 60,000 by 60,000.
    let mut header = [0; 54];
    header[..2].copy_from_slice(b"BM");
    for (at, value) in [(10, 54_u32), (14, 40), (18, 60_000), (22, 60_000), (26, 0x0018_0001)] {
        header[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
    for (what, bytes) in [("too large", &header[..]), ("a GIF", b"GIF89a"), ("no picture", b"no picture")] {
        std::fs::write(folder.path("photo.png"), bytes).unwrap();
        refused(what, &marks, &[]);
    }
    std::fs::remove_file(folder.path("photo.png")).unwrap();
    refused("no file", &marks, &[]);
    snapbox::assert_data_eq!(said, snapbox::file!["../words/outline.txt"].raw());
}
