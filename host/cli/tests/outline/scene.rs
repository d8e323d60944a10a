//! The case, its solved finger on a sheet, and a folder in which the command runs.

use fre::case::Case;
use fre::fit::measured::Measured;
use fre::metrics::distance;
use fre::study::model::Options;
use fre::study::place::Place;
use fre::study::run;
use model_core::object::ObjectDesign;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;
use test_photograph::{Eye, Lights, Sheet, checkerboard, save};

pub(crate) const ANGLE: f64 = 8.0;
pub(crate) const CASE: &str = "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40.0\n\
    centre_mm = [41.0, 45.0]\n[motion]\nmotor_angles_deg = [8.0]\n";
/// Places of the marks, mm, and their dots' diameter.
pub(crate) const MARKS: [[f64; 2]; 4] = [[-42.0, -12.0], [24.0, -14.0], [14.0, 97.0], [-44.0, 90.0]];
pub(crate) const DOT: f64 = 4.0;

/// 0.1 mm per pixel from 170 mm, without distortion.
pub(crate) const STRAIGHT: Eye =
    Eye { size: [1000, 1300], focal: [1700.0, 1700.0], centre: [499.5, 649.5], lens: [0.0; 4], pose: [[0.0; 3]; 3] };
pub(crate) const LENS: [f64; 4] = [-0.24, 0.07, 0.001, -0.0015];

/// A folder of its own for each test, removed when dropped.
pub(crate) struct Folder(pub(crate) TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("case.toml"), CASE).unwrap();
        Self(folder)
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn fre(&self, words: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_fre")).args(words).current_dir(self.0.path()).output().unwrap()
    }

    /// The outline's points of a photograph, with marks and more options.
    pub(crate) fn outline(&self, marks: &[String], options: &[&str]) -> Vec<[f64; 2]> {
        self.outline_and_arcs(ANGLE, marks, options).0
    }

    /// The same at an angle, and their arc lengths.
    pub(crate) fn outline_and_arcs(&self, angle: f64, marks: &[String], options: &[&str]) -> (Vec<[f64; 2]>, Vec<f64>) {
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

    pub(crate) fn refusal(&self, marks: &[String], options: &[&str]) -> String {
        let output = self.fre(&command(marks, options));
        assert_eq!(output.status.code(), Some(1), "{} {}", words(&output.stdout), words(&output.stderr));
        assert!(output.stdout.is_empty());
        words(&output.stderr)
    }
}

pub(crate) fn command<'a>(marks: &'a [String], options: &[&'a str]) -> Vec<&'a str> {
    let mut command = vec!["outline", "photo.png", "--case", "case.toml", "--angle-deg", "8"];
    command.extend(options);
    command.push("--marks");
    command.extend(marks.iter().map(String::as_str));
    command
}

pub(crate) fn words(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

pub(crate) fn mark([px, py]: [f64; 2], [x, y]: [f64; 2]) -> String {
    format!("{px:.2},{py:.2}={x},{y}")
}

pub(crate) fn case() -> Case {
    Case::parse("case.toml", CASE).unwrap()
}

pub(crate) fn solved() -> Place {
    solved_at(&[ANGLE]).remove(0)
}

pub(crate) fn solved_at(angles: &[f64]) -> Vec<Place> {
    let text = CASE.replace("[8.0]", &format!("{angles:?}"));
    run::solve(&Case::parse("case.toml", &text).unwrap(), &Options::default()).unwrap().places
}

/// The deformed finger, its object and the marks; world frame if asked for.
pub(crate) fn sheet(lights: Lights, place: &Place, marks: &[[f64; 2]], world: bool) -> Sheet {
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
pub(crate) fn turned(p: [f64; 2], axis: [f64; 2], degrees: f64) -> [f64; 2] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let [x, y] = [p[0] - axis[0], p[1] - axis[1]];
    [axis[0] + cos * x - sin * y, axis[1] + sin * x + cos * y]
}

/// Mean and largest distance of points to the true centreline, mm.
pub(crate) fn deviation(points: &[[f64; 2]], truth: &[[f64; 2]]) -> [f64; 2] {
    let each: Vec<f64> = points.iter().map(|&p| distance(p, truth).unwrap()).collect();
    let mean = each.iter().sum::<f64>() / each.len() as f64;
    let max = each.iter().copied().fold(0.0, f64::max);
    let last: Vec<String> =
        points.iter().zip(&each).rev().take(6).map(|(p, d)| format!("y {:.2}: {d:.4}", p[1])).collect();
    println!("last points: {}", last.join(", "));
    [mean, max]
}

/// Largest difference of arc lengths to those of the nearest places of the true centreline, mm.
pub(crate) fn arc_error(points: &[[f64; 2]], arcs: &[f64], truth: &[[f64; 2]]) -> f64 {
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

pub(crate) fn exact_marks(eye: &Eye) -> Vec<String> {
    MARKS.iter().map(|&mm| mark(eye.pixel(mm), mm)).collect()
}

/// Pictures of the checkerboard, tilted differently.
pub(crate) fn boards(eye: &Eye, folder: &Path) -> Vec<String> {
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
