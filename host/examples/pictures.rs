//! Draws one picture of each kind from made-up numbers: `cargo run -p host --example pictures -- FOLDER`.

use host::case::preset;
use host::draw::{self, Chart, FingerPicture, Mark, Panel, Series, Style};
use host::shape::{Contact, Shape};
use model_core::object::{Motion, ObjectDesign};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).map_or_else(std::env::temp_dir, std::path::PathBuf::from);
    let finger = preset("fea-80").ok_or("the preset is missing")??;
    let design = &finger.design;
    // A bump pushed into the front beam; the back beam follows less.
    let push =
        |[x, y]: [f64; 2], part: f64| [x - part * 9.0 * (y / 60.0).powi(2) * (-((y - 55.0) / 45.0).powi(2)).exp(), y];
    let mut shape = Shape::undeformed(design);
    shape.front.iter_mut().for_each(|p| *p = push(*p, 1.0));
    shape.back.iter_mut().for_each(|p| *p = push(*p, 0.9));
    shape.lamellae.iter_mut().for_each(|[p, q]| (*p, *q) = (push(*p, 1.0), push(*q, 0.9)));
    let angle = 10.0_f64.to_radians();
    shape.contacts = (0..5)
        .map(|i| {
            let arc = 44.0 + 2.3 * f64::from(i);
            let position = push([0.0, arc], 1.0);
            let tilt = -0.03 * f64::from(i - 2) + 0.05;
            Contact {
                arc,
                position,
                normal: [-tilt.cos(), -tilt.sin()],
                force: 4.0 - 0.6 * f64::from((i - 2) * (i - 2)),
            }
        })
        .collect();
    let picture = FingerPicture {
        title: "Finger fea-80 on a cylinder of 80 mm".into(),
        subtitle: "simpson 17/1, extended physics, *α* = 10°, made-up numbers".into(),
        design,
        motion: Motion::Rotating { axis: design.motor_axis },
        coordinate: angle,
        object: ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 },
        shape: &shape,
        force: Some([13.6, -1.9]),
    };
    for ending in ["svg", "png"] {
        draw::write(&picture.scene(), &folder.join(format!("finger.{ending}")))?;
    }

    let angles: Vec<f64> = (0..=110).map(|i| 0.1 * f64::from(i)).collect();
    let force = |a: f64| 0.12 * a.powf(2.05);
    let line = |name: &str, colour, style, value: &dyn Fn(f64) -> f64| Series {
        name: name.into(),
        colour,
        style,
        points: angles.iter().map(|&a| [a, value(a)]).collect(),
    };
    let mut chart = Chart::new(
        "Contact force while closing on an 80 mm cylinder",
        "finger ladder-80, object at Mid height; target: simpson 17/1 in f32",
        "motor angle *α* (°)",
    );
    chart.panels = vec![
        Panel {
            y_title: "force |*F*| (N)".into(),
            share: 2.2,
            series: vec![
                line("reference, trapezoid 170/20", 0, Style::Line, &force),
                line("reference, paper 170/20", 2, Style::Dashed, &|a| 1.03 * force(a)),
                Series {
                    name: "target".into(),
                    colour: 1,
                    style: Style::Dots,
                    points: angles.iter().step_by(5).map(|&a| [a, 1.004 * force(a)]).collect(),
                },
            ],
            marks: vec![
                Mark::At { x: 8.3, words: "snap-through".into() },
                Mark::Ring { at: [9.5, force(9.5)], words: "other branch".into() },
            ],
            ..Panel::default()
        },
        Panel {
            y_title: "difference (N)".into(),
            share: 1.0,
            series: vec![
                line("to trapezoid", 0, Style::Line, &|a| 0.004 * force(a) * (3.0 * a).sin()),
                line("to paper", 2, Style::Dashed, &|a| -0.03 * force(a)),
            ],
            marks: vec![Mark::Band { low: -0.1, high: 0.1, words: "1 %".into() }],
            ..Panel::default()
        },
    ];
    for ending in ["svg", "png"] {
        draw::write(&chart.scene(), &folder.join(format!("chart.{ending}")))?;
    }
    Ok(())
}
