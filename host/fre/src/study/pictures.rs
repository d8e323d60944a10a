//! Pictures of results: the finger on its object, force over the motion, contact pressure and strain along the beams.

use model_core::object::Motion;
use model_core::status::Status;

use crate::case::Case;
use crate::draw::{self, Chart, FingerPicture, Mark, Panel, Scene, Series, Style, literal};
use crate::study::course;
use crate::study::headline::headline;
use crate::study::place::{Place, State};
use crate::study::run::Run;
use crate::study::strains::{Section, percent};

/// A kind of picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Deformed finger, object, contact forces to scale, at one place.
    Finger,
    /// Force over the motion, with branches and snap-throughs; where time passes, over time.
    Force,
    /// Force and torque while the motion closes and opens.
    Loop,
    /// Contact pressure along the front beam, at one place.
    Pressure,
    /// Strains along both beams and in the hinges, at one place.
    Strain,
}

/// Pictures of a case, one below the other. What belongs to one place shows `at`, an index of the run's places; `None` without a
/// state there.
pub fn stacked(case: &Case, run: &Run, at: usize, kinds: &[Kind]) -> Option<Scene> {
    let place = run.places.get(at)?;
    let state = place.state.as_ref()?;
    let scenes = kinds.iter().map(|kind| match kind {
        Kind::Finger => finger(case, run, place, state),
        Kind::Force => course(case, run).scene(),
        Kind::Loop => course::hysteresis(case, run, &subject(case)).scene(),
        Kind::Pressure => pressure(case, place, state).scene(),
        Kind::Strain => strain(case, place, state).scene(),
    });
    scenes.reduce(|above, below| above.above(&below))
}

/// The finger at the last trustworthy place and, if there are several, the force over the places; in time also the loop of a motion that
/// comes back. `None` without any.
pub fn overview(case: &Case, run: &Run) -> Option<Scene> {
    let kinds = [Kind::Finger, Kind::Force, Kind::Loop];
    let turns = run.places.windows(2).any(|pair| pair[1].at.value() < pair[0].at.value());
    let shown = match run.places.len() {
        0 | 1 => 1,
        _ if turns && case.path.has_time() => 3,
        _ => 2,
    };
    stacked(case, run, run.last_known()?, &kinds[..shown])
}

/// The finger on its object and its force at each place that has a state, in the case's order: the frames of a moving picture.
pub fn film(case: &Case, run: &Run) -> Vec<Scene> {
    let known = || run.places.iter().filter_map(|place| Some((place, place.state.as_ref()?)));
    let pictures: Vec<FingerPicture> = known().map(|(place, state)| picture(case, run, place, state)).collect();
    let chart = course(case, run);
    draw::frames(&pictures)
        .into_iter()
        .zip(known())
        .map(|(finger, (place, state))| {
            let mut chart = chart.clone();
            let at = [place.time_s.unwrap_or(place.at.value()), state.force_magnitude_n()];
            if let Some(panel) = chart.panels.first_mut() {
                panel.marks.push(Mark::Ring { at, words: String::new() });
            }
            finger.above(&chart.scene())
        })
        .collect()
}

fn finger(case: &Case, run: &Run, place: &Place, state: &State) -> Scene {
    picture(case, run, place, state).scene()
}

fn picture<'a>(case: &'a Case, run: &Run, place: &Place, state: &'a State) -> FingerPicture<'a> {
    FingerPicture {
        title: with_minus(&headline(case)),
        subtitle: run.model.words(),
        design: &case.finger.design,
        motion: case.path.motion,
        coordinate: case.path.coordinate(place.at.value()),
        object: case.object,
        friction: case.friction,
        shape: &state.shape,
        force: Some(state.force_n),
    }
}

/// A text with true minus signs before its numbers; hyphens within names stay.
fn with_minus(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut letters = text.chars().peekable();
    let mut before = ' ';
    while let Some(letter) = letters.next() {
        let sign = letter == '-' && " (".contains(before) && letters.peek().is_some_and(char::is_ascii_digit);
        out.push(if sign { '−' } else { letter });
        before = letter;
    }
    out
}

/// A place in words: "α = 10°".
fn place_words(case: &Case, place: &Place) -> String {
    let place = draw::short(place.at.value(), 3);
    match case.path.motion {
        Motion::Rotating { .. } => format!("*α* = {place}°"),
        Motion::Translating { .. } => format!("*d* = {place} mm"),
    }
}

/// Finger and object in a chart's subtitle.
fn subject(case: &Case) -> String {
    literal(&with_minus(&headline(case)))
}

/// The force over time, or where none passes over the motion.
fn course(case: &Case, run: &Run) -> Chart {
    course::over_time(case, run, &subject(case), jumps).unwrap_or_else(|| force(case, run))
}

/// The force over the places of a case; a line per branch.
fn force(case: &Case, run: &Run) -> Chart {
    let (title, x_title) = match case.path.motion {
        Motion::Rotating { .. } => ("Contact force over motor angle", "motor angle *α* (°)"),
        Motion::Translating { .. } => ("Contact force over distance", "distance *d* (mm)"),
    };
    let nothing = [f64::NAN; 2];
    let mut lines: [Vec<[f64; 2]>; 3] = Default::default();
    let mut jump = Vec::new();
    let mut last: Option<(&Place, [f64; 3])> = None;
    for place in &run.places {
        let values = place.force_n().map(|[x, y]| [x.hypot(y), x, y]);
        if last.is_some_and(|(before, _)| jumps(before, place)) {
            // The lines end where the branch does; the jump is drawn apart.
            lines.iter_mut().for_each(|line| line.push(nothing));
            if let (Some((before, [from, ..])), Some([to, ..])) = (last, values) {
                jump.extend([[before.at.value(), from], [place.at.value(), to], nothing]);
            }
        }
        for (line, i) in lines.iter_mut().zip(0..) {
            line.push(values.map_or(nothing, |values: [f64; 3]| [place.at.value(), values[i]]));
        }
        last = values.map(|values| (place, values)).or(last);
    }
    let [mut magnitude, x, y] = lines;
    let touches = run.places.iter().any(|place| place.force_magnitude_n().is_some_and(|force| force > 0.0));
    // A component that is nearly all of the force must not hide the magnitude.
    let series = |name: &str, colour, style, points| Series { name: name.into(), colour, style, points };
    let mut shown = Vec::new();
    let interval = interval(run);
    if !interval.is_empty() {
        shown.push(series("|*F*| if the path is unknown", 0, Style::Region, interval));
        let opening = opening(run, &mut magnitude);
        shown.push(series("|*F*|, closing", 0, Style::Thick, magnitude));
        if !opening.is_empty() {
            shown.push(series("|*F*|, opening", 3, Style::Thick, opening));
        }
    } else {
        shown.push(series("magnitude |*F*|", 0, Style::Thick, magnitude));
    }
    shown.push(series("*F*_{x}", 1, Style::LineAndDots, x));
    shown.push(series("*F*_{y}", 2, Style::LineAndDots, y));
    if !jump.is_empty() {
        shown.push(Series { name: "jump of |*F*|".into(), colour: 6, style: Style::Dashed, points: jump });
    }
    let mut chart = Chart::new(title, format!("{}; force on the object, world frame", subject(case)), x_title);
    chart.height = 400.0;
    // Places without a trustworthy solution belong to the axis: what failed is not cut off.
    chart.x_range = Some(range(run));
    chart.panels = vec![Panel {
        y_title: "force (N)".into(),
        y_range: (!touches).then_some([0.0, 1.0]),
        series: shown,
        marks: force_marks(run, case.path.unit()),
        ..Panel::default()
    }];
    chart
}

/// Round the values between which the force's magnitude lies if the path is unknown: the least ones by growing place, and the greatest ones
/// back. Empty without friction.
fn interval(run: &Run) -> Vec<[f64; 2]> {
    let known = run.places.iter().filter_map(|place| {
        let interval = place.state.as_ref()?.force_interval?;
        Some((place.at.value(), interval.magnitude))
    });
    let mut ends: Vec<(f64, [f64; 2])> = known.collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    ends.dedup_by(|a, b| a.0 == b.0);
    let low = ends.iter().map(|&(at, [low, _])| [at, low]);
    low.chain(ends.iter().rev().map(|&(at, [_, high])| [at, high])).collect()
}

/// Parts the opening motions from a line over the places, which begin where the closing ends. (A line has one point per place, and one more
/// where the finger snaps.)
fn opening(run: &Run, line: &mut [[f64; 2]]) -> Vec<[f64; 2]> {
    let mut parted = Vec::new();
    let mut last: Option<[f64; 2]> = None;
    let mut opens = false;
    if !run.places.is_sorted_by(|a, b| a.at.value() <= b.at.value()) {
        for point in line {
            let here = *point;
            let before = last.filter(|before| before[0].is_finite() && here[0].is_finite());
            if let Some(before) = before.filter(|before| before[0] != here[0]) {
                let turned = (here[0] < before[0]) != opens;
                opens = here[0] < before[0];
                if turned && opens {
                    parted.extend([[f64::NAN; 2], before]);
                }
            }
            if opens {
                parted.push(here);
                *point = [f64::NAN; 2];
            }
            last = Some(here);
        }
    }
    parted
}

/// The least and the greatest place.
fn range(run: &Run) -> [f64; 2] {
    let places = || run.places.iter().map(|place| place.at.value());
    [places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max)]
}

/// True if the finger snapped through between two places that follow each other.
fn jumps(before: &Place, after: &Place) -> bool {
    let released = after.status == Status::NoContact;
    before.branch.zip(after.branch).is_some_and(|(before, after)| before != after) && !released
}

/// Snap-throughs, failures and branches.
fn force_marks(run: &Run, unit: &str) -> Vec<Mark> {
    let places = &run.places;
    let mut marks = Vec::new();
    let mut before = Status::NoContact;
    let mut first_snap = true;
    let snap = run.first_branch.and_then(|first| Some((first, first.snap_between()?)));
    let named = |[after, to]: [f64; 2]| {
        let at = 0.5 * (after + to);
        (at, format!("snap-through at {at:.2}{unit}"))
    };
    // A finger that is on a later branch from the first place on has snapped through on the way there.
    let later = places.first().filter(|first| first.branch.is_some_and(|branch| branch > 1));
    if let Some((place, (first, between))) = later.zip(snap) {
        let [low, high] = range(run);
        let (at, words) = named(between);
        marks.push(if (low..=high).contains(&at) {
            Mark::At { x: at, words }
        } else {
            let most = draw::significant(first.max_force_n, 2);
            Mark::At {
                x: place.at.value(),
                words: format!("{words}, before the first place; up to {most} N until then"),
            }
        });
        first_snap = false;
    }
    for (index, place) in places.iter().enumerate() {
        let status = place.status;
        let earlier =
            index.checked_sub(1).and_then(|before| places.get(before)).filter(|earlier| jumps(earlier, place));
        if let Some(earlier) = earlier {
            let known = snap.filter(|_| first_snap);
            first_snap = false;
            marks.push(match known {
                Some((_, between)) => {
                    let (x, words) = named(between);
                    Mark::At { x, words }
                }
                None => {
                    let [from, to] = [earlier.at.value(), place.at.value()];
                    let [low, high] = [from.min(to), from.max(to)].map(|place| draw::short(place, 3));
                    Mark::At { x: 0.5 * (from + to), words: format!("snap-through between {low} and {high}{unit}") }
                }
            });
        } else if !status.is_trustworthy() && status != before {
            marks.push(Mark::At { x: place.at.value(), words: status.to_string() });
        }
        before = status;
    }
    // The largest force of the first branch may lie between two places.
    if let Some((first, place)) = snap.and_then(|(first, _)| Some((first, first.max_force_at()?))) {
        let words = format!("{} N at {}{unit}", draw::significant(first.max_force_n, 2), draw::short(place, 2));
        marks.push(Mark::Ring { at: [place, first.max_force_n], words });
    }
    // Branches are named where each place belongs to one: not on the way back.
    let most = places.iter().filter_map(|place| place.branch).max().unwrap_or(1);
    if most > 1 && places.is_sorted_by_key(|place| place.at.value()) {
        for branch in 1..=most {
            let mut on = places.iter().filter(|place| place.branch == Some(branch)).map(|place| place.at.value());
            if let (Some(from), Some(to)) = (on.next(), on.next_back()) {
                marks.push(Mark::Stretch { between: [from, to], words: format!("branch {branch}") });
            }
        }
    }
    marks
}

/// Where the lamellae are joined to a beam, as marks with their numbers.
fn lamella_marks(case: &Case, side: usize, named: bool) -> Vec<Mark> {
    let design = &case.finger.design;
    let mark = |lamella: usize| Mark::At {
        x: design.attachment_arcs(lamella)[side],
        words: if named { (lamella + 1).to_string() } else { String::new() },
    };
    (0..design.lamella_count()).map(mark).collect()
}

/// Contact pressure along the front beam.
fn pressure(case: &Case, place: &Place, state: &State) -> Chart {
    let mut points = Vec::new();
    for pressure in &state.contact_pressure {
        let ([from, to], load) = (pressure.between_mm, pressure.line_load_n_per_mm);
        points.extend([[from, 0.0], [from, load], [to, load], [to, 0.0], [f64::NAN; 2]]);
    }
    let peak = state.contact_pressure.iter().max_by(|a, b| a.line_load_n_per_mm.total_cmp(&b.line_load_n_per_mm));
    let subtitle = match peak {
        Some(peak) => format!(
            "{}: *F* = {} N; largest {} N/mm at {:.1} mm, that is {} N/mm² over the finger's width",
            place_words(case, place),
            draw::significant(state.force_magnitude_n(), 2),
            draw::significant(peak.line_load_n_per_mm, 3),
            peak.arc_mm,
            draw::significant(peak.pressure_n_per_mm2, 4),
        ),
        None => format!("{}: no contact", place_words(case, place)),
    };
    let mut chart = Chart::new(
        "Contact force per length along the front beam",
        subtitle,
        "arc length from the base *s* (mm); dashed: lamellae, numbered from the base",
    );
    chart.height = 330.0;
    chart.x_range = Some([0.0, case.finger.design.front.length()]);
    chart.panels = vec![Panel {
        y_title: "force per length (N/mm)".into(),
        series: vec![Series {
            name: "touching samples, each over the length it stands for".into(),
            colour: 1,
            style: Style::Area,
            points,
        }],
        y_range: peak.is_none().then_some([0.0, 1.0]),
        marks: lamella_marks(case, 0, true),
        ..Panel::default()
    }];
    chart
}

/// Strains below this are the solver's rounding; an axis of their size would make them look like something.
const AT_REST: f64 = 1e-6;

/// Strains along both beams, and below them the hinges'.
fn strain(case: &Case, place: &Place, state: &State) -> Chart {
    let design = &case.finger.design;
    let limit = case.finger.max_strain;
    let strains = &state.strains;
    let in_percent = |share: f64| 100.0 * share;
    let face = |name: &str, colour, sections: &[Section], pick: fn(&Section) -> f64| Series {
        name: name.into(),
        colour,
        style: Style::Line,
        points: sections.iter().map(|section| [section.arc_mm, in_percent(pick(section))]).collect(),
    };
    // A limit far away would flatten the curves: it is drawn where it is near, and named in any case.
    let levels = |most: f64, both: bool| {
        let near = limit.filter(|limit| *limit < 3.0 * most).map(percent);
        let level = |y: f64, words: String| Mark::Level { y, words };
        let upper = near.map(|limit| level(limit, format!("limit {limit} %")));
        let lower = near.filter(|_| both).map(|limit| level(-limit, String::new()));
        upper.into_iter().chain(lower).collect::<Vec<_>>()
    };
    let largest = |sections: &[Section]| sections.iter().map(Section::largest).fold(0.0, f64::max);
    let beam = |title: &str, side: usize, sections: &[Section]| {
        let most = largest(sections);
        let at_rest = most < AT_REST;
        let mut marks = lamella_marks(case, side, side == 0);
        marks.extend(levels(most, true));
        Panel {
            y_title: format!("{title} (%)"),
            series: vec![
                face("face on the object's side", 0, sections, |section| section.object_side),
                face("other face", 1, sections, |section| section.back_side),
            ],
            y_range: at_rest.then_some([-1.0, 1.0]),
            marks,
            ..Panel::default()
        }
    };
    let mut panels = vec![beam("front beam", 0, &strains.front), beam("back beam", 1, &strains.back)];
    if !strains.hinges.is_empty() {
        let dots = |name: &str, colour, pick: fn(&crate::study::strains::Pair) -> f64, side: usize| Series {
            name: name.into(),
            colour,
            style: Style::Dots,
            points: strains
                .hinges
                .iter()
                .enumerate()
                .map(|(lamella, pair)| [design.attachment_arcs(lamella)[side], in_percent(pick(pair))])
                .collect(),
        };
        let most = strains.hinges.iter().map(|pair| pair.front.max(pair.back)).fold(0.0, f64::max);
        panels.push(Panel {
            y_title: "hinges, largest (%)".into(),
            series: vec![dots("front hinges", 2, |pair| pair.front, 0), dots("back hinges", 3, |pair| pair.back, 1)],
            marks: levels(most, false),
            y_range: (most < AT_REST).then_some([0.0, 1.0]),
            with_zero: true,
            share: 0.8,
        });
    }
    if !strains.ribs.is_empty() {
        let points = strains.ribs.iter().enumerate();
        let points = points.map(|(rib, &strain)| [design.attachment_arcs(rib)[0], in_percent(strain)]).collect();
        let most = strains.ribs.iter().copied().fold(0.0, f64::max);
        panels.push(Panel {
            y_title: "ribs, largest (%)".into(),
            series: vec![Series { name: "ribs".into(), colour: 2, style: Style::Dots, points }],
            marks: levels(most, false),
            y_range: (most < AT_REST).then_some([0.0, 1.0]),
            with_zero: true,
            share: 0.8,
        });
    }
    let bears = match limit {
        Some(limit) => format!("the material bears {} %", percent(limit)),
        None => "the material's limit is not known (finger.material.max_strain)".to_owned(),
    };
    let mut chart = Chart::new(
        "Strain at the outer fibres",
        format!("{}: bending and stretch, positive where drawn out; {bears}", place_words(case, place)),
        "arc length of the beam from the base *s* (mm); dashed: lamellae",
    );
    chart.height = 600.0;
    chart.x_range = Some([0.0, design.front.length().max(design.back.length())]);
    chart.panels = panels;
    chart
}
