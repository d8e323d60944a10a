//! Charts of a motion in time, and of a motion that comes back: force over time, and the loops of force and torque.

use model_core::object::Motion;
use model_core::status::Status;

use crate::case::Case;
use crate::draw::{Chart, Mark, Panel, Series, Style, significant};
use crate::study::place::Place;
use crate::study::run::Run;

/// True if the finger snapped through between two places that follow each other.
pub(super) type Jumps = fn(&Place, &Place) -> bool;

/// Force, and below it the motion, over time; `None` where no time passes.
pub(super) fn over_time(case: &Case, run: &Run, subject: &str, jumps: Jumps) -> Option<Chart> {
    let times = || run.places.iter().filter_map(|place| place.time_s);
    let last = times().reduce(f64::max)?;
    let line = |of: &dyn Fn(&Place) -> Option<f64>| {
        let point = |place: &Place| [place.time_s.unwrap_or(f64::NAN), of(place).unwrap_or(f64::NAN)];
        run.places.iter().map(point).collect::<Vec<_>>()
    };
    let series = |name: &str, colour, style, points| Series { name: name.into(), colour, style, points };
    let force = |axis: usize| move |place: &Place| place.force_n().map(|force| force[axis]);
    let touches = run.places.iter().any(|place| place.force_magnitude_n().is_some_and(|force| force > 0.0));
    let mut marks = Vec::new();
    for pair in run.places.windows(2) {
        if let [before, after] = pair
            && let Some((from, to)) = before.time_s.zip(after.time_s)
        {
            if jumps(before, after) {
                marks.push(Mark::At { x: 0.5 * (from + to), words: "snap-through".to_owned() });
            } else if !after.status.is_trustworthy() && after.status != before.status {
                marks.push(Mark::At { x: to, words: after.status.to_string() });
            }
        }
    }
    let motion = match case.path.motion {
        Motion::Rotating { .. } => "*α* (°)",
        Motion::Translating { .. } => "*d* (mm)",
    };
    let mut chart =
        Chart::new("Contact force over time", format!("{subject}; force on the object, world frame"), "time *t* (s)");
    chart.height = 480.0;
    chart.x_range = Some([times().fold(last, f64::min), last]);
    chart.panels = vec![
        Panel {
            y_title: "force (N)".into(),
            y_range: (!touches).then_some([0.0, 1.0]),
            with_zero: true,
            share: 2.0,
            series: vec![
                series("magnitude |*F*|", 0, Style::Thick, line(&Place::force_magnitude_n)),
                series("*F*_{x}", 1, Style::LineAndDots, line(&force(0))),
                series("*F*_{y}", 2, Style::LineAndDots, line(&force(1))),
            ],
            marks,
        },
        Panel {
            y_title: motion.into(),
            series: vec![series("motion", 3, Style::LineAndDots, line(&|place| Some(place.at.value())))],
            ..Panel::default()
        },
    ];
    Some(chart)
}

/// Ways of a motion, and how each is drawn.
const WAYS: [(&str, u8); 3] = [("closing", 0), ("opening", 1), ("holding", 2)];

/// Force and torque over the motion, closing and opening apart.
pub(super) fn hysteresis(case: &Case, run: &Run, subject: &str) -> Chart {
    let torque = |place: &Place| place.state.as_ref().map(|state| state.motor_torque_nmm);
    let (title, x_title, y_title) = match case.path.motion {
        Motion::Rotating { .. } => {
            ("Force and torque while closing and opening", "motor angle *α* (°)", "torque (N·mm)")
        }
        Motion::Translating { .. } => ("Force while closing and opening", "distance *d* (mm)", "drive (N)"),
    };
    let subject = match work(case, run) {
        Some([done, returned]) if returned > 0.0 => format!(
            "{subject}: closing takes {} N·mm, of which {} come back",
            significant(done, 1),
            significant(returned, 1)
        ),
        _ => subject.to_owned(),
    };
    let mut chart = Chart::new(title, subject, x_title);
    chart.height = 560.0;
    chart.panels = vec![
        Panel { y_title: "force |*F*| (N)".into(), series: ways(run, &Place::force_magnitude_n), ..Panel::default() },
        Panel { y_title: y_title.into(), series: ways(run, &torque), ..Panel::default() },
    ];
    chart
}

/// A value over the motion: a series for each way that the motion takes.
fn ways(run: &Run, of: &dyn Fn(&Place) -> Option<f64>) -> Vec<Series> {
    let point = |place: &Place| [place.at.value(), of(place).unwrap_or(f64::NAN)];
    let mut found: [Vec<[f64; 2]>; 3] = Default::default();
    for pair in run.places.windows(2) {
        if let [before, after] = pair {
            let way = way(before, after);
            found[way].extend([point(before), point(after), [f64::NAN; 2]]);
        }
    }
    let series = |((name, colour), points): (&(&str, u8), Vec<[f64; 2]>)| {
        let name = (*name).to_owned();
        (!points.is_empty()).then_some(Series { name, colour: *colour, style: Style::LineAndDots, points })
    };
    WAYS.iter().zip(found).filter_map(series).collect()
}

/// Index of the way between two places.
fn way(before: &Place, after: &Place) -> usize {
    let (from, to) = (before.at.value(), after.at.value());
    if to > from {
        0
    } else if to < from {
        1
    } else {
        2
    }
}

/// Work that the motor does while it closes and gets back while it opens, N·mm, from the open hand on; `None` with a place that has no state.
///
/// Between two places it is what the finger stores and friction dissipates, however far apart they are. Over a snap-through, and of a material with
/// memory, whose energy is not known, it is the torque's, even between the places; what is done before the first place is then left out.
pub fn work(case: &Case, run: &Run) -> Option<[f64; 2]> {
    let (mut done, mut returned) = (0.0, 0.0);
    if let Some(first) = run.places.first().filter(|place| place.status != Status::Snapped) {
        done += spent(first).unwrap_or(0.0);
    }
    for pair in run.places.windows(2) {
        let [before, after] = pair else { continue };
        let mean = 0.5 * (before.state.as_ref()?.motor_torque_nmm + after.state.as_ref()?.motor_torque_nmm);
        let way = case.path.coordinate(after.at.value()) - case.path.coordinate(before.at.value());
        let is_followed = after.status != Status::Snapped && before.branch == after.branch;
        let work = match spent(before).zip(spent(after)) {
            Some((before, after)) if is_followed => after - before,
            _ => mean * way,
        };
        if way > 0.0 { done += work } else { returned -= work }
    }
    Some([done, returned])
}

/// What has been stored, and dissipated since the path began, N·mm; `None` where it is not known.
fn spent(place: &Place) -> Option<f64> {
    let state = place.state.as_ref()?;
    Some(state.energy_nmm? + state.friction.as_ref().map_or(0.0, |friction| friction.dissipated_nmm))
}
