//! `fre outline` on photographs whose truth is known: accuracy with perspective, lens, noise and blur; and its refusals.

mod outline_scene;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use fre::case::Case;
use fre::fit::measured::Measured;
use fre::metrics::distance;
use fre::study::model::Options;
use fre::study::place::Place;
use fre::study::run;
use model_core::object::ObjectDesign;
use tempfile::TempDir;

use outline_scene::{BRIGHT_FINGER, DARK_FINGER, Eye, Lights, Sheet, checkerboard, save};

const ANGLE: f64 = 8.0;
const CASE: &str = "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40.0\n\
    centre_mm = [41.0, 45.0]\n[motion]\nmotor_angles_deg = [8.0]\n";
/// Places of the marks, mm, and their dots' diameter.
const MARKS: [[f64; 2]; 4] = [[-42.0, -12.0], [24.0, -14.0], [14.0, 97.0], [-44.0, 90.0]];
const DOT: f64 = 4.0;

/// 0.1 mm per pixel from 170 mm, without distortion.
const STRAIGHT: Eye =
    Eye { size: [1000, 1300], focal: [1700.0, 1700.0], centre: [499.5, 649.5], lens: [0.0; 4], pose: [[0.0; 3]; 3] };
const LENS: [f64; 4] = [-0.24, 0.07, 0.001, -0.0015];

/// A folder of its own for each test, removed when dropped.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("case.toml"), CASE).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn fre(&self, words: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_fre")).args(words).current_dir(self.0.path()).output().unwrap()
    }

    /// The outline's points of a photograph, with marks and more options.
    fn outline(&self, marks: &[String], options: &[&str]) -> Vec<[f64; 2]> {
        self.outline_and_arcs(ANGLE, marks, options).0
    }

    /// The same at an angle, and their arc lengths.
    fn outline_and_arcs(&self, angle: f64, marks: &[String], options: &[&str]) -> (Vec<[f64; 2]>, Vec<f64>) {
        let angle_words = angle.to_string();
        let mut command = command(marks, options);
        command[5] = &angle_words;
        let output = self.fre(&command);
        assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
        println!("{}", words(&output.stderr));
        let text = words(&output.stdout);
        let measured = Measured::parse("outline", &text).unwrap();
        assert!(measured.problems.is_empty(), "{:?}", measured.problems);
        assert_eq!((measured.measurements.len(), measured.measurements[0].place), (1, angle));
        let arcs: Vec<f64> = text.lines().skip(1).map(|row| row.split(',').nth(4).unwrap().parse().unwrap()).collect();
        let front = measured.measurements[0].front.clone();
        assert_eq!(arcs.len(), front.len());
        (front, arcs)
    }

    fn refusal(&self, marks: &[String], options: &[&str]) -> String {
        let output = self.fre(&command(marks, options));
        assert_eq!(output.status.code(), Some(1), "{} {}", words(&output.stdout), words(&output.stderr));
        assert!(output.stdout.is_empty());
        words(&output.stderr)
    }
}

fn command<'a>(marks: &'a [String], options: &[&'a str]) -> Vec<&'a str> {
    let mut command = vec!["outline", "photo.png", "--case", "case.toml", "--angle-deg", "8"];
    command.extend(options);
    command.push("--marks");
    command.extend(marks.iter().map(String::as_str));
    command
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn mark([px, py]: [f64; 2], [x, y]: [f64; 2]) -> String {
    format!("{px:.2},{py:.2}={x},{y}")
}

fn case() -> Case {
    Case::parse("case.toml", CASE).unwrap()
}

fn solved() -> Place {
    solved_at(&[ANGLE]).remove(0)
}

fn solved_at(angles: &[f64]) -> Vec<Place> {
    let text = CASE.replace("[8.0]", &format!("{angles:?}"));
    run::solve(&Case::parse("case.toml", &text).unwrap(), &Options::default()).unwrap().places
}

/// The deformed finger, its object and the marks; world frame if asked for.
fn sheet(lights: Lights, place: &Place, marks: &[[f64; 2]], world: bool) -> Sheet {
    let case = case();
    let design = &case.finger.design;
    let angle = place.at.value();
    let shape = &place.state.as_ref().unwrap().shape;
    let seen = |p: [f64; 2]| if world { turned(p, design.motor_axis, -angle) } else { p };
    let line = |points: &[[f64; 2]]| points.iter().map(|&p| seen(p)).collect::<Vec<_>>();
    let along = |points: &[[f64; 2]], arc: f64| {
        let mut before = 0.0;
        for pair in points.windows(2) {
            let length = (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
            if before + length >= arc {
                let part = (arc - before) / length;
                return [0, 1].map(|i| pair[0][i] + part * (pair[1][i] - pair[0][i]));
            }
            before += length;
        }
        points[points.len() - 1]
    };
    let ObjectDesign::Circle { centre, radius } = case.object else { panic!("the case has a circle") };
    Sheet::draw(lights, |pen| {
        pen.disc(seen(turned(centre, design.motor_axis, angle)), radius, lights.object);
        pen.line(&line(&shape.front), 2.0, lights.finger);
        pen.line(&line(&shape.back), 2.0, lights.finger);
        pen.line(&line(&[[1.0, -2.0], [-29.0, -2.0]]), 4.0, lights.finger);
        for (lamella, bar) in shape.lamellae.iter().enumerate() {
            let arcs = design.attachment_arcs(lamella);
            pen.line(&line(bar), 3.0, lights.finger);
            pen.line(&line(&[along(&shape.front, arcs[0]), bar[0]]), 0.8, lights.finger);
            pen.line(&line(&[bar[1], along(&shape.back, arcs[1])]), 0.8, lights.finger);
        }
        for &at in marks {
            pen.disc(at, 0.5 * DOT, lights.dots);
        }
    })
}

/// A point turned about an axis, counter-clockwise.
fn turned(p: [f64; 2], axis: [f64; 2], degrees: f64) -> [f64; 2] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let [x, y] = [p[0] - axis[0], p[1] - axis[1]];
    [axis[0] + cos * x - sin * y, axis[1] + sin * x + cos * y]
}

/// Mean and largest distance of points to the true centreline, mm.
fn deviation(points: &[[f64; 2]], truth: &[[f64; 2]]) -> [f64; 2] {
    let each: Vec<f64> = points.iter().map(|&p| distance(p, truth).unwrap()).collect();
    let mean = each.iter().sum::<f64>() / each.len() as f64;
    let max = each.iter().copied().fold(0.0, f64::max);
    let last: Vec<String> =
        points.iter().zip(&each).rev().take(6).map(|(p, d)| format!("y {:.2}: {d:.4}", p[1])).collect();
    println!("last points: {}", last.join(", "));
    [mean, max]
}

/// Largest difference of arc lengths to those of the nearest places of the true centreline, mm.
fn arc_error(points: &[[f64; 2]], arcs: &[f64], truth: &[[f64; 2]]) -> f64 {
    let nearest = |p: [f64; 2]| {
        let (mut before, mut best) = (0.0, [f64::INFINITY, 0.0]);
        for pair in truth.windows(2) {
            let along = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
            let length = along[0].hypot(along[1]);
            let part = ((p[0] - pair[0][0]) * along[0] + (p[1] - pair[0][1]) * along[1]) / length;
            let part = part.clamp(0.0, length);
            let at = [0, 1].map(|i| pair[0][i] + part / length * along[i]);
            let distance = (p[0] - at[0]).hypot(p[1] - at[1]);
            if distance < best[0] {
                best = [distance, before + part];
            }
            before += length;
        }
        best[1]
    };
    points.iter().zip(arcs).map(|(&p, arc)| (nearest(p) - arc).abs()).fold(0.0, f64::max)
}

fn exact_marks(eye: &Eye) -> Vec<String> {
    MARKS.iter().map(|&mm| mark(eye.pixel(mm), mm)).collect()
}

/// Pictures of the checkerboard, tilted differently.
fn boards(eye: &Eye, folder: &Path) -> Vec<String> {
    let tilts: [[f64; 3]; 7] = [
        [28.0, 4.0, 88.0],
        [-30.0, 8.0, 95.0],
        [6.0, 30.0, 85.0],
        [-4.0, -32.0, 92.0],
        [22.0, 22.0, 100.0],
        [-20.0, 24.0, 80.0],
        [3.0, -5.0, 90.0],
    ];
    let shift = [[0.0, 0.0], [6.0, 2.0], [-5.0, 3.0], [4.0, -4.0], [0.0, 5.0], [-6.0, -2.0], [3.0, 0.0]];
    let name = |i: usize| format!("board-{i}.png");
    for (i, (tilt, [dx, dy])) in tilts.into_iter().zip(shift).enumerate() {
        let eye = eye.looking_at([48.0 + dx, 30.0 + dy], 175.0, tilt, false);
        save(&eye.photograph(checkerboard, 0.9, 2.0, 50 + i as u64), &folder.join(name(i)));
    }
    (0..tilts.len()).map(name).collect()
}

#[test]
fn perspective_noise_and_blur_leave_a_tenth_of_a_millimetre() {
    let folder = Folder::new();
    let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, [14.0, -17.0, 6.0], false);
    let solution = solved();
    let sheet = sheet(DARK_FINGER, &solution, &MARKS, false);
    save(&eye.photograph(sheet.light(), 1.3, 3.0, 1), &folder.path("photo.png"));
    // Marks are clicked, a few pixels off; their dots are found.
    let clicks = [[7.0, -5.0], [-6.0, 4.0], [3.0, 9.0], [-8.0, -3.0]];
    let clicked: Vec<String> = MARKS
        .iter()
        .zip(clicks)
        .map(|(&mm, [dx, dy])| {
            let [x, y] = eye.pixel(mm);
            mark([x + dx, y + dy], mm)
        })
        .collect();
    let (points, arcs) = folder.outline_and_arcs(ANGLE, &clicked, &["--dot-mm", "4", "--plot", "overlay.png"]);
    let off = arc_error(&points, &arcs, solution.front_mm());
    println!("arc lengths within {off:.3} mm");
    assert!(off < 0.3, "arc length off by {off}");
    let [mean, max] = deviation(&points, solution.front_mm());
    println!("perspective, clicked dots: mean {mean:.4} mm, max {max:.4} mm of {} points", points.len());
    assert!(mean < 0.03 && max < 0.1, "mean {mean}, max {max}");
    // From base to tip, without holes.
    assert!(points[0][1] < 3.0 && points[points.len() - 1][1] > 75.0, "{points:?}");
    assert!(points.windows(2).all(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]) < 2.5));
    let overlay = image::open(folder.path("overlay.png")).unwrap().to_rgb8();
    let red = overlay.pixels().filter(|p| p.0[0] > 180 && p.0[1] < 90 && p.0[2] < 90).count();
    assert!(red > 800, "{red} red pixels of the outline");

    // A similarity instead of a perspective through the same marks is far off: the perspective is really needed.
    let similar: Vec<[f64; 2]> = MARKS.iter().map(|&mm| eye.pixel(mm)).collect();
    let flat: Vec<String> = similarity(&MARKS, &similar).iter().zip(MARKS).map(|(&p, mm)| mark(p, mm)).collect();
    let [mean, _] = deviation(&folder.outline(&flat, &[]), solution.front_mm());
    println!("without perspective: mean {mean:.3} mm");
    assert!(mean > 0.5, "mean {mean}");
}

/// Least-squares similarity (mirrored: y is up in mm, down in pixels) of places, applied to them.
fn similarity(mm: &[[f64; 2]], pixels: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let count = mm.len() as f64;
    let centre = |points: &[[f64; 2]]| [0, 1].map(|i| points.iter().map(|p| p[i]).sum::<f64>() / count);
    let (from, to) = (centre(mm), centre(pixels));
    let (mut a, mut b, mut size) = (0.0, 0.0, 0.0);
    for (p, q) in mm.iter().zip(pixels) {
        let (x, y) = (p[0] - from[0], from[1] - p[1]);
        let (u, v) = (q[0] - to[0], q[1] - to[1]);
        a += x * u + y * v;
        b += x * v - y * u;
        size += x * x + y * y;
    }
    let (a, b) = (a / size, b / size);
    let map = |p: &[f64; 2]| {
        let (x, y) = (p[0] - from[0], from[1] - p[1]);
        [to[0] + a * x - b * y, to[1] + b * x + a * y]
    };
    mm.iter().map(map).collect()
}

#[test]
fn a_checkerboard_removes_the_lens() {
    let folder = Folder::new();
    let lens = Eye { lens: LENS, centre: [507.0, 640.0], focal: [1705.0, 1698.0], ..STRAIGHT };
    let eye = lens.looking_at([-8.0, 40.0], 170.0, [-10.0, 12.0, -4.0], false);
    let solution = solved();
    let sheet = sheet(DARK_FINGER, &solution, &MARKS, false);
    save(&eye.photograph(sheet.light(), 1.1, 2.5, 2), &folder.path("photo.png"));
    let boards = boards(&lens, folder.0.path());
    let marks = exact_marks(&eye);
    let mut options = vec!["--squares", "10x7", "--square-mm", "12", "--save-camera", "camera.toml", "--checkerboard"];
    options.extend(boards.iter().map(String::as_str));
    let points = folder.outline(&marks, &options);
    let [mean, max] = deviation(&points, solution.front_mm());
    println!("lens and perspective: mean {mean:.4} mm, max {max:.4} mm");
    assert!(mean < 0.03 && max < 0.1, "mean {mean}, max {max}");

    // The camera kept in a file gives the same.
    let again = folder.outline(&marks, &["--camera", "camera.toml"]);
    assert_eq!(points, again);

    // Without it the lens is really in the way.
    let [ignored, max] = deviation(&folder.outline(&marks, &[]), solution.front_mm());
    println!("lens ignored: mean {ignored:.4} mm, max {max:.4} mm");
    assert!(ignored > 4.0 * mean && max > 0.15, "mean {ignored}, max {max}");
}

#[test]
fn marks_that_stand_still_and_a_bright_finger_seen_from_behind() {
    let folder = Folder::new();
    let eye = STRAIGHT.looking_at([0.0, 38.0], 170.0, [-9.0, 8.0, -5.0], true);
    let solution = solved();
    // Everything is drawn where it stands in the world; the outline must come back in the finger frame.
    let sheet = sheet(BRIGHT_FINGER, &solution, &MARKS, true);
    save(&eye.photograph(sheet.light(), 1.2, 2.5, 3), &folder.path("photo.png"));
    let marks = exact_marks(&eye);
    let points = folder.outline(&marks, &["--frame", "world"]);
    let [mean, max] = deviation(&points, solution.front_mm());
    println!("world frame, mirrored, bright: mean {mean:.4} mm, max {max:.4} mm of {} points", points.len());
    assert!(mean < 0.03 && max < 0.1, "mean {mean}, max {max}");

    // Taken for the finger frame, the same marks have the finger turned by the motor's angle.
    let [mean, _] = deviation(&folder.outline(&marks, &[]), solution.front_mm());
    println!("world taken for finger: mean {mean:.3} mm");
    assert!(mean > 2.0, "mean {mean}");
}

#[test]
fn any_load_and_light_will_do() {
    let folder = Folder::new();
    let solutions = solved_at(&[0.0, 4.0, 11.0]);
    // Free, touching, and bent as far as it goes without a snap.
    assert!(solutions[0].force_magnitude_n() == Some(0.0) && solutions[2].force_magnitude_n() > Some(10.0));
    let lights = [
        Lights { ground: 250, finger: 60, object: 140, dots: 10 },
        Lights { ground: 90, finger: 30, object: 160, dots: 220 },
        Lights { ground: 60, finger: 110, object: 10, dots: 240 },
    ];
    for (i, (solution, lights)) in solutions.iter().zip(lights).chain(solutions.iter().rev().zip(lights)).enumerate() {
        let tilt = [10.0 - 4.0 * i as f64, 3.0 * i as f64 - 8.0, 2.0];
        let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, tilt, false);
        let sheet = sheet(lights, solution, &MARKS, false);
        save(
            &eye.photograph(sheet.light(), 1.0 + 0.2 * i as f64, 1.0 + 0.5 * i as f64, 20 + i as u64),
            &folder.path("photo.png"),
        );
        let plot = format!("overlay-{i}.png");
        let (points, arcs) = folder.outline_and_arcs(solution.at.value(), &exact_marks(&eye), &["--plot", &plot]);
        let [mean, max] = deviation(&points, solution.front_mm());
        let off = arc_error(&points, &arcs, solution.front_mm());
        println!(
            "{} degrees: mean {mean:.4} mm, max {max:.4} mm of {} points, arc length {off:.3} mm",
            solution.at.value(),
            points.len()
        );
        assert!(
            mean < 0.05 && max < 0.2 && off < 0.3,
            "{} degrees: mean {mean}, max {max}, arc length {off}",
            solution.at.value()
        );
        assert!(points.len() > 60, "{} points", points.len());
    }
}

#[test]
fn a_finger_as_bright_as_what_is_behind_it_is_known_by_its_colour() {
    let folder = Folder::new();
    let solution = solved();
    let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, [7.0, -6.0, 2.0], false);
    // Orange on green: red, green and blue light of ground, finger, object and dots. Both have 20 % of white's light.
    let lights = [[26, 153, 90, 4], [64, 27, 90, 4], [13, 8, 90, 4]];
    let channels = [0, 1, 2].map(|i| {
        let [ground, finger, object, dots] = lights[i];
        let sheet = sheet(Lights { ground, finger, object, dots }, &solution, &MARKS, false);
        eye.photograph(sheet.light(), 1.2, 2.0, 40 + i as u64)
    });
    let [red, green, blue] = &channels;
    let picture = image::RgbImage::from_fn(red.width(), red.height(), |x, y| {
        image::Rgb([red, green, blue].map(|channel| channel.get_pixel(x, y).0[0]))
    });
    picture.save(folder.path("photo.png")).unwrap();
    let output = folder.fre(&command(&exact_marks(&eye), &[]));
    assert!(words(&output.stderr).contains("of white's red"), "{}", words(&output.stderr));
    let [mean, max] = deviation(&folder.outline(&exact_marks(&eye), &["--plot", "overlay.png"]), solution.front_mm());
    println!("orange on green: mean {mean:.4} mm, max {max:.4} mm");
    assert!(mean < 0.03 && max < 0.1, "mean {mean}, max {max}");
}

#[test]
fn compare_reads_a_series_and_finds_the_model_again() {
    let folder = Folder::new();
    let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, [8.0, 10.0, 0.0], false);
    let solution = solved();
    let sheet = sheet(DARK_FINGER, &solution, &MARKS, false);
    save(&eye.photograph(sheet.light(), 1.3, 3.0, 4), &folder.path("photo.png"));
    let marks = exact_marks(&eye);
    let force = format!("{}", solution.force_magnitude_n().unwrap());
    let file = ["--output", "measured.csv", "--force-n", &force];
    assert_eq!(folder.fre(&command(&marks, &file)).status.code(), Some(0));
    // The same photograph as if at another angle: another place in the same file.
    let mut other = command(&marks, &["--output", "measured.csv", "--append"]);
    other[5] = "9";
    assert_eq!(folder.fre(&other).status.code(), Some(0));
    let output = folder.fre(&["compare", "case.toml", "--measured", "measured.csv", "--format", "json"]);
    assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
    let compared: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = compared["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    let number = |row: usize, key: &str| rows[row][key].as_f64().unwrap();
    assert!(number(0, "shape_mean_mm") < 0.05, "{compared}");
    assert!(number(0, "difference_n").abs() < 1e-6, "{compared}");
    assert!(number(1, "shape_mean_mm") > 2.0 * number(0, "shape_mean_mm"), "{compared}");

    std::fs::write(folder.path("measured.csv"), "something,else\n").unwrap();
    assert!(
        words(&folder.fre(&command(&marks, &["--output", "measured.csv", "--append"])).stderr)
            .contains("measured.csv:1")
    );
}

/// A kill, or a disk that fills up, while a photograph is added to a series: here a limit of the file's size.
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
    assert!(told.contains("series.csv cannot be written: "), "{told}");
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
    assert!(told.contains("/dev/null: is no file"), "{told}");
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
        let told = words(&output.stderr);
        println!("{told}");
        told
    };
    let (wrong, hidden) = ("more than 0.1 mm: a mark's pixel or millimetres", "may not show in the residual");
    assert!(told(&[], 0.0).contains("four marks fit any perspective"));
    // Off the lines between the others all are checked.
    let inside = [[-30.0, 10.0], [12.0, 60.0]];
    let fine = told(&inside, 0.0);
    assert!(!fine.contains(wrong) && !fine.contains(hidden), "{fine}");
    assert!(told(&inside, 12.0).contains(wrong));
    // Between the first two: the others may lie anywhere on a line.
    let between = told(&[[-9.0, -13.0]], 0.0);
    let [x, y] = eye.pixel(MARKS[2]);
    assert!(between.contains(&format!("an error of {x:.0},{y:.0}=14,97 or ")) && between.contains(hidden), "{between}");
    assert!(!between.contains(wrong), "{between}");
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
        (words(&output.stdout), words(&output.stderr).contains("transparent in places: taken as before white"))
    };
    let (opaque, told) = save_rgba(&|light| [light, light, light, 255]);
    assert!(!told);
    let (cut, told) = save_rgba(&|light| [0, 0, 0, 255 - light]);
    assert!(told);
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
        assert_eq!(told.contains("photo.png: cannot be read: it is truncated"), torn, "{length}: {told}");
        assert_eq!(output.status.success(), !torn, "{length}: {told}");
    }
    // What cameras put behind the picture is none of it.
    jpeg.extend(b"\xff\xd8\xff\xda trailer");
    std::fs::write(folder.path("photo.png"), &jpeg).unwrap();
    assert!(folder.fre(&command(&marks, &[])).status.success());
}

#[test]
fn an_object_brighter_than_the_background_ends_the_outline_where_it_hides_the_tip() {
    let folder = Folder::new();
    let solution = solved();
    let lights = Lights { ground: 190, finger: 30, object: 255, dots: 100 };
    let sheet = sheet(lights, &solution, &MARKS, false);
    for (seed, tilt) in [[12.0, -6.0, 3.0], [-9.0, 8.0, 0.0], [0.0; 3]].into_iter().enumerate() {
        let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, tilt, false);
        save(&eye.photograph(sheet.light(), 1.1, 2.5, 60 + seed as u64), &folder.path("photo.png"));
        let points = folder.outline(&exact_marks(&eye), &[]);
        let [mean, max] = deviation(&points, solution.front_mm());
        println!("bright object: mean {mean:.4} mm, max {max:.4} mm of {} points", points.len());
        assert!(mean < 0.03 && max < 0.2 && points.len() > 60, "mean {mean}, max {max}, {} points", points.len());
    }
}

#[test]
fn a_picture_too_coarse_for_two_edges_is_told_so() {
    let folder = Folder::new();
    let eye = Eye { size: [125, 163], focal: [212.5, 212.5], centre: [62.0, 81.0], ..STRAIGHT };
    let eye = eye.looking_at([-8.0, 40.0], 170.0, [0.0; 3], false);
    save(&eye.photograph(sheet(DARK_FINGER, &solved(), &MARKS, false).light(), 0.7, 2.0, 9), &folder.path("photo.png"));
    let told = folder.refusal(&exact_marks(&eye), &[]);
    assert!(told.contains("too coarse: the beam is 2.5 pixels thick, needed are about 5"), "{told}");
}

#[test]
fn what_cannot_be_measured_is_said() {
    let folder = Folder::new();
    let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, [0.0, 0.0, 0.0], false);
    let solution = solved();
    let marks = exact_marks(&eye);
    let faint = Lights { ground: 120, finger: 117, object: 118, dots: 10 };
    save(&eye.photograph(sheet(faint, &solution, &MARKS, false).light(), 1.2, 1.0, 5), &folder.path("photo.png"));
    let told = folder.refusal(&marks, &[]);
    assert!(told.contains("contrast is too low"), "{told}");
    let blank = Sheet::draw(DARK_FINGER, |_| ());
    save(&eye.photograph(blank.light(), 1.2, 2.0, 6), &folder.path("photo.png"));
    assert!(folder.refusal(&marks, &[]).contains("contrast is too low"));
    assert!(folder.refusal(&marks, &["--dot-mm", "4"]).contains("not on a round dot"));

    let sheet = sheet(DARK_FINGER, &solution, &MARKS, false);
    save(&eye.photograph(sheet.light(), 1.2, 2.0, 7), &folder.path("photo.png"));
    let mut changed = marks.clone();
    changed[2] = mark([4000.0, 20.0], MARKS[2]);
    assert!(folder.refusal(&changed, &[]).contains("4000,20=14,97 lies outside the picture"));
    let on_line: Vec<String> =
        [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [5.0, 60.0]].iter().map(|&mm| mark(eye.pixel(mm), mm)).collect();
    assert!(folder.refusal(&on_line, &[]).contains("on a line"));
    assert!(folder.refusal(&marks[..3], &[]).contains("at least 4"));
    let crossed: Vec<String> = MARKS.iter().zip([0, 1, 3, 2]).map(|(&mm, i)| mark(eye.pixel(MARKS[i]), mm)).collect();
    assert!(folder.refusal(&crossed, &[]).contains("each other's millimetres"));
    let shifted: Vec<String> = MARKS.iter().map(|&mm| mark(eye.pixel(mm), [mm[0] + 12.0, mm[1]])).collect();
    assert!(folder.refusal(&shifted, &[]).contains("no two edges so far apart"));
    let away: Vec<String> = MARKS.iter().map(|&mm| mark(eye.pixel(mm), [mm[0], mm[1] + 200.0])).collect();
    assert!(folder.refusal(&away, &[]).contains("outside the picture"));
    assert!(folder.refusal(&marks, &["--plot", "x.svg"]).contains("ends in .png"));
    assert!(folder.refusal(&marks, &["--force-n", "-1"]).contains("--force-n is -1; allowed is"));
    let mut turned = command(&marks, &[]);
    turned[5] = "181";
    assert!(words(&folder.fre(&turned).stderr).contains("--angle-deg is 181; allowed is -180 to 180"));
    assert!(folder.refusal(&marks, &["--to-mm", "99"]).contains("--to-mm is 99; allowed is"));
    assert!(folder.refusal(&marks, &["--marks", "1,2=3"]).contains("PX,PY=X,Y"));
    let board = ["--squares", "10x7", "--checkerboard", "photo.png", "photo.png", "photo.png"];
    assert!(folder.refusal(&marks, &board).contains("needed is 9 by 6"));

    std::fs::write(folder.path("marks.toml"), "[[mark]]\npixel = [1.0, 2.0]\nmm = \"here\"\n").unwrap();
    let file = ["outline", "photo.png", "--case", "case.toml", "--angle-deg", "8", "--marks-file", "marks.toml"];
    assert!(words(&folder.fre(&file).stderr).contains("marks.toml:3:"), "{}", words(&folder.fre(&file).stderr));
    // A picture that would not fit into memory is refused by its header: a bitmap of 60,000 by 60,000.
    let mut header = vec![0; 54];
    header[..2].copy_from_slice(b"BM");
    for (at, value) in [(10, 54_u32), (14, 40), (18, 60_000), (22, 60_000), (26, 0x0018_0001)] {
        header[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
    std::fs::write(folder.path("photo.png"), header).unwrap();
    let told = folder.refusal(&marks, &[]);
    assert!(told.contains("60000×60000 pixels; allowed are up to 120 million"), "{told}");
    std::fs::write(folder.path("photo.png"), b"GIF89a").unwrap();
    assert!(folder.refusal(&marks, &[]).contains("allowed are PNG, JPEG, TIFF, BMP and WebP"));
    std::fs::write(folder.path("photo.png"), b"no picture").unwrap();
    assert!(folder.refusal(&marks, &[]).contains("photo.png: cannot be read"));
    std::fs::remove_file(folder.path("photo.png")).unwrap();
    assert!(folder.refusal(&marks, &[]).contains("photo.png: cannot be read"));
}

#[test]
fn a_camera_held_upright_is_turned_as_its_file_says() {
    let folder = Folder::new();
    let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, [6.0, -5.0, 2.0], false);
    let solution = solved();
    let sheet = sheet(DARK_FINGER, &solution, &MARKS, false);
    let upright = eye.photograph(sheet.light(), 1.2, 2.0, 8);
    // Stored lying; orientation 6: turn clockwise to see it upright.
    let mut jpeg = Vec::new();
    let stored = image::imageops::rotate270(&upright);
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 95).encode_image(&stored).unwrap();
    let tiff = [&b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0"[..]].concat();
    let mut file = vec![0xFF, 0xD8, 0xFF, 0xE1];
    file.extend(((2 + 6 + tiff.len()) as u16).to_be_bytes());
    file.extend(b"Exif\0\0");
    file.extend(tiff);
    file.extend(&jpeg[2..]);
    // The content counts, not the ending.
    std::fs::write(folder.path("photo.png"), file).unwrap();
    let points = folder.outline(&exact_marks(&eye), &[]);
    let [mean, max] = deviation(&points, solution.front_mm());
    println!("JPEG with orientation: mean {mean:.4} mm, max {max:.4} mm");
    assert!(mean < 0.03 && max < 0.1, "mean {mean}, max {max}");
}
