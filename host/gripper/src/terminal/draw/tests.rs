use std::time::Instant;

use messages::{Event, Grasp, GripMargin, Mount, Notice, PROTOCOL_VERSION, Phase, Report, Settings};
use model_core::estimator::Estimate;
use model_core::solution::LoadedRib;
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
fn a_rib_near_its_buckling_load_is_shown() {
    let mut seen = seen(1);
    let report = report(0, 1000, 5.0, Status::Converged);
    let loaded_rib = Some(LoadedRib { rib: 6, percent: 93 });
    seen.take(Told::Report(Report { estimate: Estimate { loaded_rib, ..report.estimate }, ..report }));
    has(&drawn(&seen, 100, 30), "buckling     rib 7, 93 % of its load");
}

#[test]
fn a_finger_shows_every_number_with_its_status() {
    let mut seen = seen(1);
    seen.take(Told::Event(Notice { time_us: 1_500_000, event: Event::ServoLost { finger: 0, other_master: false } }));
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
