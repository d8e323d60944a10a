//! The pictures of the report.

use model_core::object::Motion;

use super::sample::{REFERENCES, Sample, Way};
use super::seen::Seen;
use super::summary::ALLOWED_PERCENT;
use super::task::{OBJECT, PRESET, RADIUS};
use fre::draw::{Chart, FingerPicture, Mark, Panel, Scene, Series, Style};
use fre::shape::Shape;
use fre::study::model::physics_word;

/// Points of a curve over time.
const POINTS: usize = 1200;
/// Colours of the references.
const COLOURS: [u8; 2] = [0, 2];

/// The deformed finger with its contact forces: the target's, and beside it the trapezoid reference's. None without a
/// shape from the target to which the reference has one.
pub fn finger(seen: &Seen) -> Option<Scene> {
    let (shape, reference, angle) = seen.shape_beside_reference()?;
    let picture = |title: &str, subtitle: &str, shape: &Shape| {
        let [mut x, mut y] = [0.0, 0.0];
        for contact in &shape.contacts {
            (x, y) = (x - contact.force * contact.normal[0], y - contact.force * contact.normal[1]);
        }
        // From the finger's frame to the world's.
        let (sin, cos) = angle.sin_cos();
        FingerPicture {
            title: title.to_owned(),
            subtitle: subtitle.to_owned(),
            design: &seen.design,
            motion: Motion::Rotating { axis: seen.design.motor_axis },
            coordinate: angle,
            object: OBJECT,
            friction: 0.0,
            shape,
            force: Some([cos * x + sin * y, cos * y - sin * x]),
        }
        .scene()
    };
    let target = picture("Microcontroller", "simpson 17/1, single precision, as the target sent it", &shape);
    let full = picture("Reference on the PC", "trapezoid 170/20, double precision, same angle", reference);
    Some(target.beside(&full))
}

/// The force over the angle, and the differences.
pub fn force(seen: &Seen) -> Scene {
    let samples = once_per_angle(&seen.samples);
    let mut chart = Chart::new(
        format!("Contact force while closing on a cylinder Ø{} mm and opening again", 2.0 * RADIUS),
        format!(
            "finger {}, cylinder at Mid height, physics {}, one point per count of the servo",
            PRESET,
            physics_word(seen.physics)
        ),
        "motor angle *α* (°)",
    );
    let series = |name: &str, colour: u8, style: Style, value: &dyn Fn(&Sample) -> Option<f64>| Series {
        name: name.into(),
        colour,
        style,
        points: samples.iter().map(|s| [s.angle_deg, value(s).unwrap_or(f64::NAN)]).collect(),
    };
    // Sorted, so that a line does not run to and fro.
    let curve = |name: &str, style: Style, which: usize| {
        let mut one = series(name, COLOURS[which], style, &|sample| sample.reference(which));
        one.points.retain(|point| point[1].is_finite());
        one.points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        one
    };
    // The colours are those of the references' curves; the way back is a line, so that both ways can be seen.
    let difference = |which: usize, way: Way, value: fn(&Sample, usize) -> Option<f64>| {
        let style = if way == Way::Closing { Style::Dots } else { Style::Line };
        let name = format!("target − {}, {}", REFERENCES[which], way.word());
        let colour = COLOURS[which];
        series(&name, colour, style, &|sample| (sample.way == way).then(|| value(sample, which))?)
    };
    let differences = |value: fn(&Sample, usize) -> Option<f64>| {
        let each = |which| Way::BOTH.map(|way| difference(which, way, value));
        [each(1), each(0)].into_iter().flatten().collect::<Vec<_>>()
    };
    let bound = format!("±{ALLOWED_PERCENT} %");
    chart.panels = vec![
        Panel {
            y_title: "force |*F*| (N)".into(),
            share: 2.2,
            series: vec![
                curve("trapezoid 170/20, f64", Style::Line, 0),
                curve("paper 170/20, f64", Style::Dashed, 1),
                series("target: simpson 17/1, f32", 1, Style::Dots, &|sample| Some(sample.magnitude())),
            ],
            ..Panel::default()
        },
        Panel { y_title: "difference (N)".into(), share: 1.0, series: differences(Sample::excess), ..Panel::default() },
        Panel {
            y_title: "difference (%)".into(),
            share: 1.0,
            series: differences(Sample::excess_percent),
            marks: vec![Mark::Band { low: -ALLOWED_PERCENT, high: ALLOWED_PERCENT, words: bound }],
            ..Panel::default()
        },
    ];
    chart.height = 720.0;
    chart.scene()
}

/// Angle, force and cost over time.
pub fn time(seen: &Seen) -> Scene {
    let fresh: Vec<&Sample> = seen.samples.iter().filter(|sample| sample.is_fresh()).collect();
    let step = fresh.len().div_ceil(POINTS).max(1);
    let series = |colour: u8, value: &dyn Fn(&Sample) -> f64| Series {
        name: String::new(),
        colour,
        style: Style::Line,
        points: fresh.iter().step_by(step).map(|s| [s.time_s, value(s)]).collect(),
    };
    // Of every few ticks the dearest: means are in the table.
    let dearest = |value: &dyn Fn(&Sample) -> f64| Series {
        name: String::new(),
        colour: 1,
        style: Style::Dots,
        points: fresh
            .chunks(step)
            .map(|some| [some[0].time_s, some.iter().map(|sample| value(sample)).fold(0.0, f64::max)])
            .collect(),
    };
    let each = seen.pace.instructions_per_tick(seen.version.cost_hz);
    let (cost_title, unit) = match each {
        Some(each) => ("cost (10³ instr.)", each * 1e-3),
        None => ("cost (ms of the PC)", 1e3 / f64::from(seen.version.cost_hz.max(1))),
    };
    let mut chart = Chart::new(
        "What the target did, tick by tick",
        format!("its own clock; of every {step} ticks the first, for the cost the most expensive"),
        "time (s)",
    );
    let panel =
        |y_title: &str, series: Series| Panel { y_title: y_title.into(), series: vec![series], ..Panel::default() };
    chart.panels = vec![
        panel("angle *α* (°)", series(6, &|sample| sample.angle_deg)),
        panel("force |*F*| (N)", series(0, &Sample::magnitude)),
        panel(cost_title, dearest(&|sample| f64::from(sample.report.cost) * unit)),
    ];
    chart.height = 520.0;
    chart.scene()
}

/// The last trustworthy sample of every stay at an angle in which both references have spoken.
fn once_per_angle(samples: &[Sample]) -> Vec<Sample> {
    let mut once: Vec<Sample> = Vec::new();
    let whole = |sample: &&Sample| sample.is_trustworthy() && sample.references.iter().all(Option::is_some);
    for sample in samples.iter().filter(whole) {
        match once.last_mut() {
            Some(last) if last.report.position == sample.report.position => *last = *sample,
            _ => once.push(*sample),
        }
    }
    once
}
