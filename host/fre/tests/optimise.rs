//! Design optimisation: derivatives against differences, and searches with known ends.

use std::ops::ControlFlow;

use fre::case::Document;
use fre::optimise::{
    Log, OptimiseError, Problem, ProblemError, Report, Settings, best, front, front_text, optimise, value,
};
use fre::study::choice::elements;
use fre::study::model::Options;
use fre::study::run;

const CASE: &str = r#"
finger = "preset:ladder-80"
[object]
shape = "circle"
radius_mm = 40.0
centre_mm = [41.0, 45.0]
[motion]
motor_angles_deg = [6.0]
"#;

fn document(text: &str) -> Document {
    Document::resolve("case.toml", text, std::path::Path::new("")).expect("a case")
}

fn options(words: &str) -> Options {
    let mut options = Options::default();
    options.discretisation.elements = elements(words).expect("a resolution");
    options
}

fn problem(text: &str, vary: &[&str], goal: &str, limits: &[&str]) -> Problem {
    let variables = vary.iter().map(|text| text.parse().expect("a variable")).collect();
    let limits = limits.iter().map(|text| text.parse().expect("a limit")).collect();
    Problem::new(document(text), variables, (goal.parse().expect("a goal"), limits), &[], options("reduced"))
        .expect("a problem")
}

/// The same with a length for every lamella's hinges, and a taper.
fn detailed() -> String {
    let lengths = document(CASE).text().replace("length_mm = 2.5", "length_mm = [2.5, 2.5, 2.5, 2.5, 2.5, 2.5, 2.5]");
    lengths.replacen("thickness_mm = 2.0", "thickness_mm = [[0.0, 2.0], [80.0, 1.6]]", 1)
}

/// A limit of every measure that the solver has derivatives of.
const LIMITS: [&str; 7] = [
    "force-variation over 4:6:1 <= 2",
    "mean-force over 4:6:1 >= 1",
    "stiffness at 6 >= 0.1",
    "strain up to 6 <= 0.1",
    "conformity at 6 >= 1",
    "contact-length at 6 >= 1",
    "mass <= 20",
];

/// Holds a problem's derivatives against differences of fourth order between solved cases.
fn check(problem: &Problem, vary: &[&str], x: f64) {
    let x = vec![x; vary.len()];
    let found = problem.functions(&x, true);
    assert!(found.exact.iter().flatten().all(|exact| *exact), "{:?}", found.exact);
    for (variable, key) in vary.iter().enumerate() {
        let at = |step: f64| {
            let mut moved = x.clone();
            moved[variable] += step;
            problem.functions(&moved, false).values
        };
        let step = 2e-4;
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|part| at(part * step));
        for (function, row) in found.slopes.iter().enumerate() {
            let expected = (a[function] - 8.0 * b[function] + 8.0 * c[function] - d[function]) / (12.0 * step);
            // The solver's tolerance leaves 1e-8 of a slope that is zero, as of a contact's length with the width.
            let error = (row[variable] - expected).abs() / expected.abs().max(1e-2);
            assert!(error < 1e-5, "{key}, function {function}: {} and {expected}, {error:e}", row[variable]);
        }
    }
}

#[test]
fn derivatives_are_those_of_differences() {
    let vary = [
        "finger.back.base_mm.0=-30:-26",
        "finger.lamellae.heights_mm.2=26:28",
        "finger.hinge.length_mm.4=2:3",
        "finger.front.thickness_mm.1.1=1.5:1.8",
        "finger.back.thickness_mm=1.8:2.2",
        "finger.hinge.thickness_mm=0.7:0.9",
        "finger.width_mm=15:25",
        "finger.material.youngs_modulus_pa=4e7:6e7",
        "finger.motor.axis_mm.1=-22:-18",
        "object.radius_mm=38:42",
        "object.centre_mm.1=44:46",
    ];
    check(&problem(&detailed(), &vary, "force at 6", &LIMITS), &vary, 0.4);
}

#[test]
fn derivatives_with_an_objects_shape_are_those_of_differences() {
    let object = |text: &str| CASE.replace("shape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 45.0]\n", text);
    let ellipse =
        object("shape = \"ellipse\"\nsemi_axes_mm = [40.0, 30.0]\ncentre_mm = [41.0, 45.0]\nangle_deg = 5.0\n");
    let vary = ["object.semi_axes_mm.0=39:41", "object.semi_axes_mm.1=28:32", "object.angle_deg=0:20"];
    check(&problem(&ellipse, &vary, "force at 6", &LIMITS), &vary, 0.4);
    let polygon = object(
        "shape = \"polygon\"\ncorners_mm = [[11.0, 35.0], [70.0, 30.0], [70.0, 60.0], [12.0, 55.0]]\nrounding_mm = 10.0\n",
    );
    let vary = ["object.corners_mm.0.0=10:12", "object.corners_mm.3.1=53:57", "object.rounding_mm=9.9:10.1"];
    check(&problem(&polygon, &vary, "force at 6", &LIMITS), &vary, 0.5);
}

/// A snap-through has none of the solver; without one the place is the one that was given.
#[test]
fn the_slope_of_a_snap_through_is_a_difference() {
    let vary = ["finger.front.thickness_mm=1.5:2.6", "finger.back.thickness_mm=1.5:2.6"];
    let problem = problem(CASE, &vary, "snap up to 40", &["no-snap before 8"]);
    let x = [0.4, 0.6];
    let found = problem.functions(&x, true);
    assert_eq!(found.exact, [[false; 2], [true; 2]]);
    for variable in 0..2 {
        let at = |step: f64| {
            let mut moved = x;
            moved[variable] += step;
            problem.functions(&moved, false).values
        };
        let (low, high) = (at(-1e-2), at(1e-2));
        let expected = (high[0] - low[0]) / 2e-2;
        assert!((found.slopes[0][variable] - expected).abs() < 0.05 * expected.abs(), "{found:?}, {expected}");
        assert_eq!((found.slopes[1][variable], high[1] - low[1]), (0.0, 0.0));
    }
}

#[test]
fn a_search_finds_the_best_design_within_its_limits_and_goes_on_where_it_was() {
    let vary = ["finger.front.thickness_mm=1.5:2.6", "finger.back.thickness_mm=1.5:2.6"];
    let problem = problem(CASE, &vary, "force at 6", &["strain up to 6 <= 6%"]);
    let settings = Settings { starts: 2, most: 40, ..Settings::default() };
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("search.json");
    let mut log = Log::open(Some(&file), &problem, &settings).expect("a log");
    // Stopped after the first start.
    let stopped = optimise(&problem, &settings, &mut log, |progress| {
        if progress.done == 1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert!(matches!(stopped, Err(OptimiseError::Stopped)));
    let mut log = Log::open(Some(&file), &problem, &settings).expect("the same log");
    let before = problem.solved();
    let tries = optimise(&problem, &settings, &mut log, |_| ControlFlow::Continue(())).expect("tries");
    assert_eq!(tries.len(), 2);
    let best = best(&tries).expect("one").clone();
    assert!(best.keeps(), "{best:?}");
    let report = Report::of(&problem, &tries, 0.0).expect("tries");
    assert!(report.kept && report.goal.better_percent.is_some_and(|percent| percent > 1.0), "{}", report.text());
    // Nowhere in the bounds is a better one.
    for i in 0..25 {
        let values = problem.functions(&[f64::from(i % 5) / 4.0, f64::from(i / 5) / 4.0], false).values;
        assert!(values[1] < 0.0 || values[0] > best.value - 1e-4, "{values:?}");
    }
    // Everything is there already.
    let solved = problem.solved();
    assert!(solved > before);
    let mut log = Log::open(Some(&file), &problem, &settings).expect("the same log");
    let again = optimise(&problem, &settings, &mut log, |_| ControlFlow::Continue(())).expect("tries");
    assert!(again == tries && problem.solved() == solved);
    let other = Settings { seed: 1, ..settings };
    assert!(matches!(Log::open(Some(&file), &problem, &other), Err(OptimiseError::Log { .. })));
}

#[test]
fn several_objects_count_by_the_worst() {
    let small = vec![("object.radius_mm".to_owned(), 20.0), ("object.centre_mm.0".to_owned(), 21.0)];
    let make = |objects: &[Vec<(String, f64)>]| {
        let variables = vec!["finger.front.thickness_mm=1.5:2.6".parse().expect("a variable")];
        let goal = "conformity at 8".parse().expect("a goal");
        Problem::new(document(CASE), variables, (goal, Vec::new()), objects, options("reduced")).expect("a problem")
    };
    let goal = |problem: &Problem| problem.values(&[0.5]).goal.expect("contact");
    let (one, two) = (make(&[]), make(std::slice::from_ref(&small)));
    let alone = {
        let mut other = document(CASE);
        for (key, number) in &small {
            other.set(key, *number).expect("a key");
        }
        let variables = vec!["finger.front.thickness_mm=1.5:2.6".parse().expect("a variable")];
        let goal = "conformity at 8".parse().expect("a goal");
        Problem::new(other, variables, (goal, Vec::new()), &[], options("reduced")).expect("a problem")
    };
    assert_eq!(goal(&two), goal(&one).min(goal(&alone)));
    assert_ne!(goal(&one), goal(&alone));
}

#[test]
fn a_front_leads_from_one_goal_to_the_other() {
    let vary = ["finger.front.thickness_mm=1.5:2.6", "finger.back.thickness_mm=1.5:2.6"];
    let problem = problem(CASE, &vary, "force at 6", &[]);
    let settings = Settings { starts: 1, most: 30, ..Settings::default() };
    let mut log = Log::open(None, &problem, &settings).expect("a log");
    let second = "least strain up to 6".parse().expect("a goal");
    let found = front(&problem, second, 4, &settings, &mut log, |_, _| ControlFlow::Continue(())).expect("a front");
    assert!(found.points.len() >= 3 && found.before.is_some(), "{}", front_text(&problem, &found));
    for pair in found.points.windows(2) {
        assert!(pair[0].goals[0] > pair[1].goals[0] && pair[0].goals[1] > pair[1].goals[1], "{pair:?}");
    }
}

#[test]
fn a_snap_through_is_placed_where_a_run_finds_it() {
    let problem = problem(CASE, &["finger.front.thickness_mm=1.5:2.6"], "snap up to 40", &[]);
    let at = problem.values_before().goal.expect("a place");
    let mut case = document(CASE).case().expect("a case");
    case.path.places = (0..=40).map(f64::from).collect();
    let run = run::solve(&case, &options("reduced")).expect("solved");
    let [low, high] = run.first_branch.and_then(|branch| branch.snap_between()).expect("a snap-through");
    assert!(low - 1e-3 <= at && at <= high + 1e-3, "{at} is not in {low} to {high}");
}

#[test]
fn a_measure_beyond_the_motion_has_no_value() {
    let case = document(CASE).case().expect("a case");
    for words in ["force at -1e9", "strain up to 180.5", "mean-force over 0:200:50"] {
        let measure = words.parse().expect("a measure");
        let error = value(&case, measure, &options("reduced")).expect_err(words);
        assert!(matches!(error, ProblemError::Beyond { most: 180.0, .. }), "{words}: {error}");
        let vary = vec!["finger.width_mm=10:20".parse().expect("a variable")];
        let goal = (words.parse().expect("a goal"), Vec::new());
        assert_eq!(Problem::new(document(CASE), vary, goal, &[], Options::default()).err(), Some(error));
    }
}

#[test]
fn what_cannot_be_a_problem_is_refused_by_its_key() {
    let goal = || ("force at 6".parse().expect("a goal"), Vec::new());
    let none = Problem::new(document(CASE), Vec::new(), goal(), &[], Options::default());
    assert_eq!(none.err(), Some(ProblemError::NoVariables));
    let vary = vec!["object.size=1:2".parse().expect("a variable")];
    let unknown = Problem::new(document(CASE), vary, goal(), &[], Options::default()).expect_err("no such key");
    snapbox::assert_data_eq!(
        unknown.to_string(),
        snapbox::str![[
            r#""object.size" is not a number of this case; the nearest are finger.back.tip_mm.0, finger.back.tip_mm.1, finger.front.tip_mm.0, finger.front.tip_mm.1"#
        ]]
    );
    let vary = vec!["object.friction=0:1".parse().expect("a variable")];
    let later = Problem::new(document(CASE), vary, goal(), &[], Options::default()).expect_err("not computed");
    snapbox::assert_data_eq!(later.to_string(), snapbox::str!["object.friction: a search computes without friction"]);
}
