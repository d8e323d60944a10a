//! Heat and a poor supply: the finger is warned, uses less force, and stops before its servo shuts down and drops what it holds.

use messages::{
    Close, CloseTo, Derating, Event, Grip, GripTo, Phase, Reaction, SetSettings, Settings, Strain, Which, Why,
};
use system_tests::{Bench, GEARED_MOUNT, ready};

const SECOND: u64 = 1_000_000;
const FORCE: f32 = 8.0;

fn gripping(on_strain: Reaction) -> Bench {
    let mut bench = ready(&Settings { rate_hz: 100, on_strain, ..Settings::of(GEARED_MOUNT) });
    grip(&mut bench);
    bench.until("a grip", 10 * SECOND, |report| report.phase == Phase::Gripped);
    bench
}

fn grip(bench: &mut Bench) {
    bench.ask::<Grip>(&GripTo { fingers: Which::All, force: FORCE, speed: None, limit: None }).unwrap();
}

/// The servo's true force, N.
fn force(bench: &Bench) -> f64 {
    let [x, y] = bench.servo.truth().force;
    x.hypot(y)
}

/// Keeps the servo so for some seconds: by itself it would cool down.
fn keep(bench: &mut Bench, volts: f64, temperature: f64, seconds: u64) {
    for _ in 0..10 * seconds {
        bench.servo.surround(Some(volts), Some(temperature));
        bench.run(SECOND / 10);
    }
}

/// The deratings that events have reported.
fn deratings(bench: &Bench) -> Vec<(Derating, Strain)> {
    let of = |event: &Event| match *event {
        Event::Derated { derating, strain, .. } => Some((derating, strain)),
        _ => None,
    };
    bench.events.iter().filter_map(of).collect()
}

fn phase(bench: &Bench) -> Phase {
    bench.reports.last().unwrap().0.phase
}

#[test]
fn heat_warns_limits_and_holds() {
    let mut bench = gripping(Reaction::Hold);
    assert_eq!(deratings(&bench), []);
    keep(&mut bench, 12.0, 62.0, 3);
    assert_eq!(deratings(&bench), [(Derating::Warned, Strain::Heat)]);
    assert!((force(&bench) - f64::from(FORCE)).abs() < 0.8, "{}", force(&bench));
    // Less force, the less the hotter: at 74 °C 5/7 of it and more.
    keep(&mut bench, 12.0, 74.2, 6);
    assert_eq!(deratings(&bench)[1..], [(Derating::Limited, Strain::Heat)]);
    let part = force(&bench) / f64::from(FORCE);
    assert!((0.65..0.78).contains(&part) && phase(&bench) == Phase::Gripped, "{part} {:?}", phase(&bench));
    // It holds what it has, and grips no more.
    let held = force(&bench);
    keep(&mut bench, 12.0, 78.2, 3);
    assert_eq!(deratings(&bench)[2..], [(Derating::Stopped, Strain::Heat)]);
    assert_eq!(phase(&bench), Phase::Held(Why::Heat));
    assert!(force(&bench) > 0.95 * held, "{} N of {held} N", force(&bench));
    grip(&mut bench);
    bench.run(SECOND);
    assert_eq!(phase(&bench), Phase::Held(Why::Heat));
    // Cool again, it does everything again.
    keep(&mut bench, 12.0, 40.0, 3);
    assert_eq!(deratings(&bench).last(), Some(&(Derating::Free, Strain::Heat)));
    grip(&mut bench);
    bench.run(5 * SECOND);
    assert!(phase(&bench) == Phase::Gripped && (force(&bench) - f64::from(FORCE)).abs() < 0.8, "{}", force(&bench));
}

#[test]
fn heat_opens_if_that_is_set() {
    let mut bench = gripping(Reaction::Release);
    keep(&mut bench, 12.0, 79.0, 6);
    assert_eq!(phase(&bench), Phase::Released(Why::Heat));
    assert_eq!(force(&bench), 0.0);
}

#[test]
fn a_poor_supply_is_strain_and_a_dip_is_none() {
    let mut bench = gripping(Reaction::Hold);
    // A dip of half a second, thrice.
    for _ in 0..3 {
        bench.servo.surround(Some(9.7), None);
        bench.run(SECOND / 2);
        bench.servo.surround(Some(12.0), None);
        bench.run(2 * SECOND);
    }
    assert_eq!(deratings(&bench), []);
    keep(&mut bench, 9.6, 40.0, 3);
    assert_eq!(deratings(&bench).last(), Some(&(Derating::Stopped, Strain::Supply)));
    assert_eq!(phase(&bench), Phase::Held(Why::Supply));
    // What has no margin is not minded.
    let settings = Settings { heat_margin: 0, supply_margin: 0.0, rate_hz: 100, ..Settings::of(GEARED_MOUNT) };
    bench.ask::<SetSettings>(&settings).unwrap();
    keep(&mut bench, 9.6, 79.0, 3);
    bench.ask::<Close>(&CloseTo { fingers: Which::All, angle: 0.02, speed: None }).unwrap();
    bench.run(SECOND);
    assert_eq!(phase(&bench), Phase::Moving);
}
