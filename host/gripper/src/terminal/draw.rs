//! The picture.

use std::time::Duration;

use messages::{FreeObject, Side};
use model_core::estimator::Interval;
use model_core::status::Status;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style, Stylize};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType, Paragraph, Wrap};

use super::seen::{Finger, Seen, WINDOW_S};
use crate::source::Origin;

/// Lines of a finger that has its numbers below each other, and of one that has a line only.
const TALL: u16 = 10;
/// Lines of the numbers between force and phase, all of them, and least ones of a chart below them.
const BETWEEN: u16 = 6;
const LINES: u16 = BETWEEN + 2;
const CHART: u16 = 6;
/// Columns of the numbers.
const NUMBERS: u16 = 46;
/// Columns from which there is room for a chart beside them.
const WIDE: u16 = 76;
/// Width of an interval that is shown, N.
const SEEN_N: f32 = 0.01;
/// Lines of events.
const EVENTS: u16 = 3;
/// Columns at the end of a line that a long word may leave empty.
const LOST: usize = 8;
/// Silence that is reported.
const QUIET_S: f32 = 0.5;
/// A stop that is not acknowledged by then is shown as NOT STOPPED.
const LATE_S: f32 = 0.9;
/// One colour per finger.
const COLOURS: [Color; 4] = [Color::Cyan, Color::Yellow, Color::Magenta, Color::Green];

/// Draws all of it. What is longer than a line goes on in the next one, in a terminal that is high enough.
pub fn picture(frame: &mut Frame<'_>, seen: &Seen) {
    let area = frame.area();
    let is_high = area.height >= 20;
    let (heading, footer) = (heading(seen, area.width), Line::from(footer(seen)));
    let high = |lines: u16| if is_high { lines } else { 1 };
    let [head, body, below, keys] = Layout::vertical([
        Constraint::Length(1 + high(heading.len() as u16 - 1)),
        Constraint::Min(3),
        Constraint::Length(if is_high { 1 + EVENTS } else { 0 }),
        Constraint::Length(high(lines(&footer, area.width).min(2))),
    ])
    .areas(area);
    frame.render_widget(Paragraph::new(heading), head);
    fingers(frame, body, seen);
    // The last ones that have room, whole.
    let mut room = EVENTS;
    let words = seen.events.iter().map(|words| Line::raw(words.as_str()));
    let mut words: Vec<_> = words
        .rev()
        .take_while(|words| {
            let rest = room.checked_sub(lines(words, area.width));
            room = rest.unwrap_or(0);
            rest.is_some()
        })
        .collect();
    words.reverse();
    let words = Paragraph::new(words).wrap(Wrap { trim: false });
    frame.render_widget(words.block(Block::new().title("events".dim())), below);
    frame.render_widget(Paragraph::new(footer).wrap(Wrap { trim: false }), keys);
}

/// Lines that a text takes where there is so much room, one at least. (Words that do not fit go to the next one: half of the longest word is
/// lost per line.)
fn lines(text: &Line<'_>, width: u16) -> u16 {
    let room = usize::from(width).saturating_sub(LOST).max(1);
    let long = text.width();
    if long <= usize::from(width) { 1 } else { u16::try_from(long.div_ceil(room)).unwrap_or(u16::MAX) }
}

/// Who it is, and its counts in as many lines as they take.
fn heading(seen: &Seen, width: u16) -> Vec<Line<'static>> {
    let setup = &seen.setup;
    let who = match setup.origin {
        Origin::Gripper => format!("gripper {} on {}, {}", setup.firmware, setup.board, setup.place),
        Origin::Bus => format!("{} on {}, estimated on this PC", setup.board, setup.place),
        Origin::Recording => format!("recording {}", setup.place),
    };
    let quiet = seen.silence().as_secs_f32();
    let state = if quiet > QUIET_S {
        Span::styled(format!("nothing for {quiet:.1} s"), bad())
    } else {
        Span::styled("live", Style::new().fg(Color::Green).add_modifier(Modifier::BOLD))
    };
    let statistics = &seen.statistics;
    let mut counts = vec![
        state,
        Span::raw(format!("  {:.0} reports/s", seen.per_second)),
        count("missing", statistics.missing_reports),
        count(if setup.origin == Origin::Bus { "unanswered" } else { "damaged" }, statistics.damaged),
    ];
    if let Some(counters) = &seen.counters {
        let dropped =
            [counters.dropped_reports, counters.dropped_grasps, counters.dropped_shapes, counters.dropped_events];
        counts.push(Span::raw(format!("  loop {:.0} of {:.0} Hz", counters.rate_hz, counters.chosen_hz)));
        counts.push(count("late", u64::from(counters.late_ticks)));
        counts.push(count("dropped", dropped.map(u64::from).iter().sum()));
        counts.push(count("servo lost", u64::from(counters.servo_losses)));
    }
    let mut lines = vec![Line::from(who.bold()), Line::default()];
    for count in counts {
        let last = lines.last().map_or(0, Line::width);
        if last > 0 && last + count.width() > usize::from(width) {
            lines.push(Line::from(Span::styled(count.content.trim_start().to_owned(), count.style)));
        } else if let Some(last) = lines.last_mut() {
            last.push_span(count);
        }
    }
    lines
}

fn count(name: &str, number: u64) -> Span<'static> {
    let words = format!("  {name} {number}");
    if number > 0 { Span::styled(words, Style::new().fg(Color::Yellow)) } else { Span::raw(words).dim() }
}

fn footer(seen: &Seen) -> Vec<Span<'static>> {
    let mut words = vec![" q ".reversed(), " end  ".into()];
    if seen.moves() {
        let red = Style::new().fg(Color::White).bg(Color::Red).add_modifier(Modifier::BOLD);
        words.extend([Span::styled(" space ", red), Span::from(" STOP all fingers  ")]);
        // A stop that is under way needs the room.
        if seen.stopping.is_none() {
            words.extend([" x ".reversed(), " torque off  ".into()]);
        }
    }
    let late = seen.stopping.map(|since| since.elapsed().as_secs_f32());
    match (&seen.stop, late) {
        (Some(Err(why)), Some(late)) => {
            words.push(Span::styled(format!(" NOT STOPPED for {late:.1} s: {why}. Still trying. "), bad()));
        }
        (_, Some(late)) if late > LATE_S => {
            let words_late = format!(" NOT STOPPED for {late:.1} s: the gripper does not answer. Still trying. ");
            words.push(Span::styled(words_late, bad()));
        }
        (_, Some(_)) => words.push("stopping …".bold()),
        (Some(Ok(answer)), None) => words.push(Span::styled(answer.clone(), Style::new().fg(Color::Green))),
        (Some(Err(why)), None) => words.push(Span::styled(why.clone(), bad())),
        (None, None) => {}
    }
    words
}

fn bad() -> Style {
    Style::new().fg(Color::White).bg(Color::Red).add_modifier(Modifier::BOLD)
}

fn fingers(frame: &mut Frame<'_>, area: Rect, seen: &Seen) {
    let count = seen.fingers.len().max(1) as u16;
    let grasp = u16::from(seen.grasp.is_some());
    if area.height >= count * TALL + grasp {
        let rooms = [grasp].into_iter().map(Constraint::Length).chain((0..count).map(|_| Constraint::Fill(1)));
        let areas = Layout::vertical(rooms).split(area);
        together(frame, areas[0], seen);
        for (number, finger) in seen.fingers.iter().enumerate() {
            whole(frame, areas[number + 1], seen, number, finger);
        }
        return;
    }
    // Not that many lines: one per finger, and one chart for all.
    let [table, sum, chart] =
        Layout::vertical([Constraint::Length(count + 1), Constraint::Length(grasp), Constraint::Fill(1)]).areas(area);
    let head = "finger        force N    ±  angle °  torque Nmm  status";
    let rows = seen.fingers.iter().enumerate().map(|(number, finger)| row(seen, number, finger));
    frame.render_widget(Paragraph::new([Line::from(head.dim())].into_iter().chain(rows).collect::<Vec<_>>()), table);
    together(frame, sum, seen);
    if chart.height >= 5 {
        forces(frame, chart, seen, &seen.fingers.iter().enumerate().collect::<Vec<_>>());
    }
}

/// Where a free object is.
fn free_words(free: &FreeObject) -> String {
    let [x, y] = free.shift;
    format!("free object {}, gone {x:.2}, {y:.2} mm", free.status)
}

/// What the fingers come to together.
fn together(frame: &mut Frame<'_>, area: Rect, seen: &Seen) {
    let Some(grasp) = seen.grasp else { return };
    let line = if seen.silent().is_some() {
        Line::from("grasp  the gripper is silent".red())
    } else if grasp.is_trustworthy {
        let [x, y] = grasp.sum;
        let balance = 100.0 * grasp.balance;
        let free = grasp.free.map(|free| format!(", {}", free_words(&free))).unwrap_or_default();
        let bears = grasp.margin.map(|margin| format!(", bears {:.2} N", margin.least.min(margin.across)));
        Line::raw(format!(
            "grasp  pressed together {:.2} N{}, sum {x:.2}, {y:.2} N, balance {balance:.0} %{free}",
            grasp.squeeze,
            bears.unwrap_or_default()
        ))
    } else if let Some(free) = grasp.free {
        Line::from(format!("grasp  {}", free_words(&free)).red())
    } else {
        Line::from("grasp  an estimate is untrustworthy".red())
    };
    frame.render_widget(Paragraph::new(line), area);
}

fn name(seen: &Seen, number: usize) -> String {
    match seen.setup.settings.fingers.get(number).copied().flatten().map(|mount| mount.side) {
        Some(Side::Left) => format!("finger {number}, left"),
        Some(Side::Right) => format!("finger {number}, right"),
        None => format!("finger {number}"),
    }
}

fn status(status: Status, age: u32, silent: Option<Duration>) -> Span<'static> {
    if let Some(silent) = silent {
        return Span::styled(format!(" silent, {:.1} s old ", silent.as_secs_f32()), bad());
    }
    let words = if age > 0 { format!(" {status}, {age} ticks old ") } else { format!(" {status} ") };
    if status.is_trustworthy() {
        Span::styled(words, Style::new().fg(Color::Black).bg(Color::Green).add_modifier(Modifier::BOLD))
    } else {
        Span::styled(words, bad())
    }
}

fn deviation(value: f32) -> String {
    if value.is_finite() { format!("{value:.2}") } else { "?".to_owned() }
}

/// No minus before a zero.
fn fixed(value: f32, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    if text.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.')) { text.replace('-', "") } else { text }
}

fn row(seen: &Seen, number: usize, finger: &Finger) -> Line<'static> {
    let name = format!("{:<13}", name(seen, number).replace("finger ", ""));
    let Some(report) = finger.shown.report() else { return Line::raw(name + "nothing yet") };
    let estimate = report.estimate;
    let force = format!("{:>8.2} {:>4}", estimate.force_magnitude(), deviation(estimate.standard_deviation));
    let rest = format!("  {:>7.2}  {:>10.0}  ", estimate.motor_angle.to_degrees(), estimate.torque);
    let silent = seen.silent();
    let is_good = estimate.status.is_trustworthy() && silent.is_none();
    let force = if is_good { force.bold() } else { force.dim().crossed_out() };
    Line::from(vec![
        Span::styled(name, Style::new().fg(COLOURS[number % COLOURS.len()])),
        force,
        rest.into(),
        status(estimate.status, estimate.age, silent),
    ])
}

fn whole(frame: &mut Frame<'_>, area: Rect, seen: &Seen, number: usize, finger: &Finger) {
    let colour = COLOURS[number % COLOURS.len()];
    let block =
        Block::bordered().title(Span::styled(format!(" {} ", name(seen, number)), Style::new().fg(colour).bold()));
    let inside = block.inner(area);
    frame.render_widget(block, area);
    let Some(report) = finger.shown.report() else {
        frame.render_widget(Paragraph::new("nothing yet"), inside);
        return;
    };
    let estimate = report.estimate;
    let silent = seen.silent();
    let phase = report.phase.to_string();
    let doing = Line::from(vec![
        "doing        ".dim(),
        if silent.is_some() { phase.dim().crossed_out() } else { phase.into() },
        lost(finger),
    ]);
    // Above and below the numbers: what the chart beside them must not cut.
    let below = lines(&doing, inside.width).min(inside.height.saturating_sub(LINES) + 1);
    let rooms = [Constraint::Length(1), Constraint::Fill(1), Constraint::Length(below)];
    let [above, middle, below] = Layout::vertical(rooms).areas(inside);
    let (numbers, chart) = if inside.width >= WIDE {
        let [numbers, chart] = Layout::horizontal([Constraint::Length(NUMBERS), Constraint::Fill(1)]).areas(middle);
        (numbers, Some(chart))
    } else if inside.height >= LINES + CHART {
        let [numbers, chart] = Layout::vertical([Constraint::Length(BETWEEN), Constraint::Fill(1)]).areas(middle);
        (numbers, Some(chart))
    } else {
        (middle, None)
    };
    let trustworthy = estimate.status.is_trustworthy() && silent.is_none();
    let value = |words: String| if trustworthy { Span::raw(words) } else { words.dim().crossed_out() };
    let row = |name: &'static str, words: String| Line::from(vec![format!("{name:<13}").dim(), value(words)]);
    let force = format!("{:.2} N", estimate.force_magnitude());
    let [fx, fy] = estimate.force.map(|x| fixed(x, 2));
    let touching = estimate.force != [0.0; 2];
    let contact = if touching {
        let [x, y] = estimate.contact_centre.map(|x| fixed(x, 1));
        row("contact", format!("at {x}, {y} mm, {:.1} mm long", estimate.contact_extent))
    } else {
        row("distance", format!("{} mm", fixed(estimate.distance, 2)))
    };
    let micros = 1e6 * f64::from(report.cost) / f64::from(seen.setup.cost_hz.max(1));
    let force = Line::from(vec![
        "force        ".dim(),
        if trustworthy { Span::styled(force, Style::new().fg(colour).bold()) } else { force.dim().crossed_out() },
        Span::raw(format!(" ± {} ", deviation(estimate.standard_deviation))),
        status(estimate.status, estimate.age, silent),
    ]);
    let lines = vec![
        match (estimate.loaded_rib, estimate.interval) {
            (Some(loaded), _) => row("buckling", loaded.to_string()),
            (None, Some(Interval { magnitude: [low, high], .. })) if high - low >= SEEN_N => {
                row("between", format!("{low:.2} and {high:.2} N, by friction"))
            }
            _ => row("components", format!("{fx}, {fy} N")),
        },
        row(
            "motor angle",
            format!("{}° → {}°", fixed(estimate.motor_angle.to_degrees(), 2), fixed(report.goal.to_degrees(), 2)),
        ),
        contact,
        row("torque", format!("{} N·mm", fixed(estimate.torque, 0))),
        Line::from(vec![
            "current      ".dim(),
            format!("{} mA, limit {:.0}", fixed(report.current, 0), limit(seen, number)).into(),
        ]),
        Line::from(vec!["cost         ".dim(), format!("{micros:.0} µs, {} iterations", estimate.iterations).into()]),
    ];
    frame.render_widget(Paragraph::new(force), above);
    frame.render_widget(Paragraph::new(lines), numbers);
    frame.render_widget(Paragraph::new(doing).wrap(Wrap { trim: false }), below);
    if let Some(chart) = chart {
        forces(frame, chart, seen, &[(number, finger)]);
    }
}

/// How many estimates may not be used, lately.
fn lost(finger: &Finger) -> Span<'static> {
    match finger.shown.untrustworthy_percent() {
        0.0 => Span::raw(""),
        percent => Span::styled(format!("  ({percent:.0} % untrustworthy)"), Style::new().fg(Color::Yellow)),
    }
}

/// The finger's limit of the current, mA.
fn limit(seen: &Seen, number: usize) -> f32 {
    seen.setup.settings.fingers.get(number).copied().flatten().map_or(f32::NAN, |mount| mount.current_limit)
}

/// Force over the last seconds.
fn forces(frame: &mut Frame<'_>, area: Rect, seen: &Seen, fingers: &[(usize, &Finger)]) {
    let now =
        fingers.iter().filter_map(|(_, finger)| finger.shown.report()).map(|report| report.time_us).max().unwrap_or(0);
    // Without a silent source's reports the time goes on all the same.
    let now = now as f64 * 1e-6 + seen.silent().map_or(0.0, |silent| silent.as_secs_f64());
    let points: Vec<Vec<(f64, f64)>> = fingers
        .iter()
        .map(|(_, finger)| finger.forces.iter().map(|&(time, force)| (time - now, force)).collect())
        .collect();
    let greatest = points.iter().flatten().map(|point| point.1).fold(0.0, f64::max);
    let top = ceiling(1.05 * greatest);
    let sets = points.iter().zip(fingers).map(|(points, (number, _))| {
        Dataset::default()
            .marker(Marker::Braille)
            .graph_type(GraphType::Line)
            .style(Style::new().fg(COLOURS[number % COLOURS.len()]))
            .data(points)
    });
    let digits = usize::from(top < 5.0);
    let chart = Chart::new(sets.collect())
        .x_axis(
            Axis::default()
                .style(Style::new().dim())
                .bounds([-WINDOW_S, 0.0])
                .labels([format!("−{WINDOW_S:.0} s"), "now".to_owned()]),
        )
        .y_axis(Axis::default().style(Style::new().dim()).bounds([0.0, top]).labels([
            "0".to_owned(),
            format!("{:.digits$}", 0.5 * top),
            format!("{top:.digits$} N"),
        ]));
    frame.render_widget(chart, area);
}

/// A round number above this.
fn ceiling(greatest: f64) -> f64 {
    let power = 10_f64.powf(greatest.max(0.5).log10().floor());
    [1.0, 2.0, 4.0, 6.0, 8.0].into_iter().map(|k| k * power).find(|&top| top >= greatest).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests;
