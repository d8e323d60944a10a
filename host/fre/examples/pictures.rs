//! Draws a finger and a chart with a difference panel: `cargo run -p fre --release --example pictures -- FOLDER`.
//!
//! The chart compares the microcontroller's model with the full-resolution ones over a closing motion.

use std::path::PathBuf;

use fre::case::Case;
use fre::draw::{self, Chart, Mark, Panel, Series, Style, Theme};
use fre::study::model::{Options, Precision};
use fre::study::pictures;
use fre::study::place::Place;
use fre::study::run::{self, Run};
use model_core::discretise::{Discretisation, Physics, Scheme};

const CASE: &str = r#"
finger = "preset:ladder-80"
object = { shape = "circle", radius_mm = 40.0, centre_mm = [41.0, 45.0] }
motion.motor_angles_deg = [
    0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5,
    6.0, 6.5, 7.0, 7.5, 8.0, 8.5, 9.0, 9.5, 10.0, 10.5, 11.0,
]
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).map_or_else(std::env::temp_dir, PathBuf::from);
    let case = Case::parse("pictures.toml", CASE)?;
    let solve =
        |discretisation, precision| run::solve(&case, &Options { discretisation, precision, ..Options::default() });
    let target = solve(Discretisation::reduced(Physics::Paper), Precision::F32)?;
    let trapezoid = solve(Discretisation::full(Scheme::Trapezoid, Physics::Paper), Precision::F64)?;
    let paper = solve(Discretisation::full(Scheme::Paper, Physics::Paper), Precision::F64)?;

    let finger = target.only(22).and_then(|last| pictures::overview(&case, &last)).ok_or("nothing to draw")?;
    let chart = chart(&target, &trapezoid, &paper).scene();
    for (name, scene) in [("finger", finger), ("chart", chart)] {
        draw::write(&scene, &folder.join(format!("{name}.svg")))?;
        draw::write(&scene, &folder.join(format!("{name}.png")))?;
        std::fs::write(folder.join(format!("{name}-dark.png")), draw::png(&scene, 2.0, Theme::Dark)?)?;
    }
    Ok(())
}

fn chart(target: &Run, trapezoid: &Run, paper: &Run) -> Chart {
    let force = |place: &Place| place.force_magnitude_n().unwrap_or(f64::NAN);
    let series = |name: &str, colour, style, of: &Run| Series {
        name: name.into(),
        colour,
        style,
        points: of.places.iter().map(|place| [place.at.value(), force(place)]).collect(),
    };
    let difference = |name: &str, colour, to: &Run| Series {
        name: name.into(),
        colour,
        style: Style::LineAndDots,
        points: target.places.iter().zip(&to.places).map(|(t, r)| [t.at.value(), force(t) - force(r)]).collect(),
    };
    let mut chart = Chart::new(
        "Contact force while closing on a cylinder Ø80 mm",
        "finger ladder-80, cylinder at Mid height, physics paper",
        "motor angle *α* (°)",
    );
    chart.panels = vec![
        Panel {
            y_title: "force |*F*| (N)".into(),
            share: 2.0,
            series: vec![
                series("trapezoid 170/20, f64", 0, Style::Line, trapezoid),
                series("paper 170/20, f64", 2, Style::Dashed, paper),
                series("microcontroller's model: simpson 17/1, f32", 1, Style::Dots, target),
            ],
            ..Panel::default()
        },
        Panel {
            y_title: "difference (N)".into(),
            share: 1.0,
            series: vec![
                difference("difference to trapezoid", 0, trapezoid),
                difference("difference to paper", 2, paper),
            ],
            marks: vec![Mark::Band { low: -0.05, high: 0.05, words: "±0.05 N".into() }],
            ..Panel::default()
        },
    ];
    chart
}
