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
        match estimate.interval {
            Some(Interval { magnitude: [low, high], .. }) if high - low >= SEEN_N => {
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
mod tests {
    use std::time::Instant;

    use messages::{Event, Grasp, GripMargin, Mount, Notice, PROTOCOL_VERSION, Phase, Report, Settings};
    use model_core::estimator::Estimate;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    use super::*;
    use crate::source::{Modelled, Setup, Told};

    fn seen(fingers: u8) -> Seen {
        let mut settings = Settings::DEFAULT;
        for number in 1..fingers {
            let side = if number % 2 == 0 { Side::Left } else { Side::Right };
            settings.fingers[usize::from(number)] = Some(Mount { servo_id: number + 1, side, ..Mount::DEFAULT });
        }
        let mut seen = Seen::new(Setup {
            origin: Origin::Gripper,
            place: "unix:link".to_owned(),
            board: "mps2".to_owned(),
            firmware: "0.1.0".to_owned(),
            protocol: PROTOCOL_VERSION,
            cost_hz: 25_000_000,
            settings,
            models: vec![Modelled::default(); usize::from(fingers)],
        });
        // However busy the PC is, it is not silent.
        seen.heard += Duration::from_secs(3600);
        for tick in 0..1000_u32 {
            for finger in 0..fingers {
                seen.take(Told::Report(report(finger, tick, 5.0 * tick as f32 / 999.0, Status::Converged)));
            }
        }
        seen
    }

    fn report(finger: u8, tick: u32, force: f32, status: Status) -> Report {
        let estimate = Estimate {
            motor_angle: 0.1,
            force: [0.8 * force, -0.6 * force],
            contact_centre: [1.04, 44.96],
            contact_extent: 12.3,
            torque: 345.4,
            iterations: 2,
            standard_deviation: 0.114,
            age: if status.is_trustworthy() { 0 } else { 7 },
            ..Estimate::blank(status)
        };
        Report {
            sequence: tick,
            finger,
            phase: Phase::Gripped,
            time_us: 20_000 * u64::from(tick),
            estimate,
            goal: 0.2,
            position: 0,
            current: 81.0,
            cost: 10_000,
        }
    }

    fn drawn(seen: &Seen, width: u16, height: u16) -> Vec<String> {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        terminal.draw(|frame| picture(frame, seen)).unwrap();
        let buffer = terminal.backend().buffer();
        (0..height).map(|y| (0..width).map(|x| buffer[(x, y)].symbol()).collect()).collect()
    }

    fn has(lines: &[String], words: &str) {
        assert!(lines.iter().any(|line| line.contains(words)), "no `{words}` in\n{}", lines.join("\n"));
    }

    #[test]
    fn a_finger_shows_every_number_with_its_status() {
        let mut seen = seen(1);
        seen.take(Told::Event(Notice {
            time_us: 1_500_000,
            event: Event::ServoLost { finger: 0, other_master: false },
        }));
        let lines = drawn(&seen, 110, 24);
        for words in [
            "gripper 0.1.0 on mps2, unix:link",
            "live",
            "missing 0",
            "finger 0, left",
            "5.00 N ± 0.11  converged",
            "4.00, -3.00 N",
            "5.73° → 11.46°",
            "at 1.0, 45.0 mm, 12.3 mm long",
            "345 N·mm",
            "81 mA",
            "400 µs, 2 iterations",
            "gripped",
            "STOP all fingers",
            "1.500 s",
        ] {
            has(&lines, words);
        }
        // The chart rises from the left to the right, and its greatest value is the newest force.
        let braille = |line: &String| line.chars().filter(|c| ('\u{2801}'..='\u{28ff}').contains(c)).count();
        assert!(lines.iter().filter(|line| braille(line) > 0).count() >= 5, "{}", lines.join("\n"));
        has(&lines, "6 N");
        has(&lines, "−20 s");
    }

    /// Whatever a finger does and why, how old its estimate is, and how much has been counted: no word is cut.
    #[test]
    fn nothing_is_cut_at_110_columns() {
        let mut seen = seen(1);
        let event = Event::TorquesDisagree { finger: 0, disagree: true, demanded: 12_345.0, current: 1_234.0 };
        seen.take(Told::Event(Notice { time_us: 86_400_000_000, event }));
        seen.counters = Some(messages::Counters {
            rate_hz: 498.7,
            chosen_hz: 500.0,
            late_ticks: 12_345_678,
            dropped_reports: 12_345_678,
            servo_losses: 12_345,
            ..messages::Counters::default()
        });
        seen.statistics.missing_reports = 12_345_678;
        seen.statistics.damaged = 12_345;
        let mut last = report(0, 1010, 9.0, Status::ContactCapacity);
        last.estimate.age = 12_345_678;
        for phase in [
            Phase::Released(messages::Why::Angle),
            Phase::Waiting(messages::Why::Bus),
            Phase::Held(messages::Why::Host),
            Phase::Held(messages::Why::Estimate),
        ] {
            seen.take(Told::Report(Report { phase, ..last }));
            seen.asked();
            seen.stopping = seen.stopping.map(|since| since - Duration::from_secs(100));
            for (width, height) in [(110, 24), (110, 40), (80, 30)] {
                let lines = drawn(&seen, width, height);
                // Words that went on in the next line follow each other without the frame.
                let text = lines.join(" ").replace(['│', '┃'], " ");
                let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
                let has = |words: &str| assert!(text.contains(words), "no `{words}` in\n{}", lines.join("\n"));
                has("± 0.11 contact-capacity, 12345678 ticks old");
                has(&phase.to_string());
                has("servo lost 12345");
                has("the object is not as described");
                has("Still trying.");
            }
        }
    }

    #[test]
    fn what_may_not_be_used_is_said() {
        let mut seen = seen(1);
        seen.take(Told::Report(report(0, 1010, 9.0, Status::Stale)));
        has(&drawn(&seen, 100, 24), "stale, 7 ticks old");
        assert!(seen.fingers[0].forces.iter().all(|&(_, force)| force <= 5.0), "an untrustworthy force in the chart");
        seen.asked();
        has(&drawn(&seen, 100, 24), "stopping …");
        seen.stopping = seen.stopping.map(|since| since - Duration::from_secs(1));
        has(&drawn(&seen, 100, 24), "s: the gripper does not answer");
        seen.asked();
        seen.answered(Err("no servo".to_owned()));
        has(&drawn(&seen, 100, 24), "NOT STOPPED for ");
        has(&drawn(&seen, 100, 24), "s: no servo. Still trying.");
        seen.answered(Ok("stopped".to_owned()));
        assert!(!drawn(&seen, 100, 24).iter().any(|line| line.contains("NOT STOPPED")));
    }

    /// A gripper that is dead or frozen: nothing that it told looks as if it were of now.
    #[test]
    fn what_a_silent_gripper_told_is_struck_out_and_aged() {
        let mut seen = seen(1);
        has(&drawn(&seen, 110, 24), "converged");
        seen.heard = Instant::now() - Duration::from_millis(1_500);
        for (width, height) in [(110, 24), (80, 12)] {
            let lines = drawn(&seen, width, height);
            has(&lines, "silent, ");
            has(&lines, " s old");
            assert!(!lines.iter().any(|line| line.contains("converged")), "{}", lines.join("\n"));
        }
        let mut terminal = Terminal::new(TestBackend::new(110, 24)).unwrap();
        terminal.draw(|frame| picture(frame, &seen)).unwrap();
        let buffer = terminal.backend().buffer();
        let struck = buffer.content().iter().filter(|cell| cell.modifier.contains(Modifier::CROSSED_OUT));
        let struck: String = struck.map(|cell| cell.symbol()).collect();
        assert!(struck.contains("5.00 N") && struck.contains("gripped"), "{struck}");
        // A gripper that reports once a second is not silent yet.
        seen.setup.settings.rate_hz = 1;
        seen.heard = Instant::now() - Duration::from_millis(500);
        has(&drawn(&seen, 110, 24), "converged");
        seen.setup.origin = Origin::Recording;
        seen.setup.settings.rate_hz = 500;
        has(&drawn(&seen, 110, 24), "converged");
    }

    const NOTHING: GripMargin =
        GripMargin { least: 0.0, direction: 0.0, across: 0.0, couple: 0.0, slips: None, carried: None, age: 0 };

    #[test]
    fn four_fingers_fit_into_a_small_terminal_and_a_large_one() {
        let mut seen = seen(4);
        seen.take(Told::Grasp(Grasp {
            sequence: 1,
            is_trustworthy: true,
            sum: [0.0, -6.0],
            squeeze: 8.0,
            balance: 0.7,
            free: None,
            margin: None,
        }));
        let small = drawn(&seen, 80, 24);
        for words in ["0, left", "3, right", "5.00 0.11     5.73", "pressed together 8.00 N", "balance 70 %"] {
            has(&small, words);
        }
        let Some(mut grasp) = seen.grasp else { panic!("just taken") };
        let shift = [0.456, -23.0];
        let free = FreeObject { status: Status::Converged, shift, turn: 0.0, residual: 0.0, iterations: 4, cost: 9 };
        (grasp.free, grasp.margin) = (None, Some(GripMargin { least: 2.4, across: 3.0, ..NOTHING }));
        seen.take(Told::Grasp(grasp));
        has(&drawn(&seen, 80, 24), "pressed together 8.00 N, bears 2.40 N, sum 0.00, -6.00 N, balance 70 %");
        (grasp.free, grasp.margin) = (Some(free), None);
        seen.take(Told::Grasp(grasp));
        has(&drawn(&seen, 120, 24), "balance 70 %, free object converged, gone 0.46, -23.00 mm");
        (grasp.is_trustworthy, grasp.free) = (false, Some(FreeObject { status: Status::MaxIterations, ..free }));
        seen.take(Told::Grasp(grasp));
        has(&drawn(&seen, 80, 24), "grasp  free object max-iterations, gone 0.46");
        let large = drawn(&seen, 120, 60);
        has(&large, "finger 3, right");
        assert_eq!(large.iter().filter(|line| line.contains("5.00 N ± 0.11  converged")).count(), 4);
        // Nothing, and nobody, in a terminal of any size.
        for (width, height) in [(1, 1), (10, 3), (30, 8), (75, 12), (300, 100)] {
            drawn(&seen, width, height);
        }
    }

    #[test]
    fn the_chart_ends_at_a_round_number() {
        for (greatest, top) in [(0.0, 0.5), (0.3, 0.4), (0.7, 0.8), (1.0, 1.0), (5.2, 6.0), (9.0, 10.0), (11.0, 20.0)] {
            assert!(ceiling(greatest) >= greatest);
            if greatest >= 0.5 {
                assert!((ceiling(greatest) - top).abs() < 1e-9, "{greatest}: {}", ceiling(greatest));
            }
        }
    }
}
