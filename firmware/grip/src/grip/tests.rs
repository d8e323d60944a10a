//! Grips of a finger on a spring, by a motor that follows, sags, stalls or is lost.

mod relaxing;

use super::*;
use crate::Firmness;
use relaxing::Relaxing;

const COUNT: f64 = core::f64::consts::TAU / 4096.0;
const TICK: f64 = 0.002;
const LIMITS: Limits =
    Limits { range: [-0.1, 0.3], open_angle: 0.0, speed: core::f32::consts::PI / 9.0, force: 15.0, current: 500.0 };

const FAULTS: Faults = Faults { reaction: Reaction::Hold, untrusted_s: 0.05, strain: Reaction::Hold };

/// Nothing is felt.
const CALM: Touch = Touch {
    firmness: Firmness::XM430,
    angle: 0.0,
    force: Some(0.0),
    slope: None,
    has_model: true,
    current: 0.0,
    alert: false,
    part: 1.0,
    stop: None,
    relaxes: false,
};

/// A finger whose force grows with the square of the angle, on a servo that follows after some ticks.
struct Bench {
    grip: Grip,
    limits: Limits,
    reaction: Reaction,
    /// Goals on their way, the last first.
    delay: Vec<f64>,
    /// Where the servo cannot go on.
    stop: f64,
    /// What the servo leaves, per newton.
    sag: f64,
    /// A servo with the factory's gains instead of all that: where its motor is, counts.
    motor: Option<f64>,
    /// Greatest error that its output follows, counts: less where its PWM is limited.
    strength: f64,
    greatest: f64,
    /// Whether the estimate is trustworthy.
    sound: bool,
    current: f32,
    /// Whether the model tells the slope.
    knows_slope: bool,
    /// The part of its force that the finger may use.
    part: f64,
    /// What fades of the force.
    relaxing: Relaxing,
}

impl Bench {
    fn new(lag: usize) -> Self {
        let mut grip = Grip::REST;
        grip.found(0.0);
        Self {
            grip,
            limits: LIMITS,
            reaction: Reaction::Hold,
            delay: vec![0.0; lag + 1],
            stop: 9.0,
            sag: 0.0,
            motor: None,
            strength: 141.0,
            greatest: 0.0,
            sound: true,
            current: 0.0,
            knows_slope: false,
            part: 1.0,
            relaxing: Relaxing::NONE,
        }
    }

    fn sagging() -> Self {
        let limits = Limits { current: 2000.0, force: 100.0, ..LIMITS };
        Self { limits, motor: Some(0.0), knows_slope: true, ..Self::new(1) }
    }

    fn force(angle: f64) -> f64 {
        let way = (angle - 0.05).max(0.0);
        300.0 * way + 800.0 * way * way
    }

    fn slope(angle: f64) -> f64 {
        let way = (angle - 0.05).max(0.0);
        300.0 + 1600.0 * way
    }

    fn goal(&mut self) {
        let goal = self.grip.advance(TICK, &self.limits);
        self.delay.insert(0, goal);
    }

    fn angle(&mut self) -> f64 {
        let goal = self.delay.pop().unwrap();
        if let Some(motor) = &mut self.motor {
            // Counts of error, with 29 N·mm each: a finger of 45 mm, 233 N·mm of friction, 45 ms.
            let error = |motor: f64| ((goal / COUNT).round() - motor).max(-self.strength).min(self.strength);
            for _ in 0..20 {
                let load = self.relaxing.faded(Self::force(*motor * COUNT));
                let free = error(*motor) - 45.0 / 29.0 * load;
                *motor += (free.abs() - 8.0).max(0.0).copysign(free) / 0.045 * TICK / 20.0;
            }
            // 1.79 N·mm per mA.
            self.current = (error(*motor) * 29.0 / 1.79) as f32;
            return motor.round() * COUNT;
        }
        let mut angle = goal;
        for _ in 0..20 {
            angle = goal - self.sag * Self::force(angle);
        }
        (angle.min(self.stop) / COUNT).round() * COUNT
    }

    fn tick(&mut self) -> f64 {
        self.goal();
        let angle = self.angle();
        let force = self.relaxing.pass(Self::force(angle));
        let slope = (self.knows_slope && force > 0.0).then(|| Self::slope(angle));
        let force_told = self.sound.then(|| force + self.relaxing.noise(angle));
        let (current, part, relaxes) = (self.current, self.part, self.relaxing.relaxes);
        let touch = Touch { angle, force: force_told, slope, current, part, relaxes, ..CALM };
        let faults = Faults { reaction: self.reaction, ..FAULTS };
        self.grip.feel(&touch, COUNT, TICK, &self.limits, &faults);
        self.greatest = self.greatest.max(force);
        force
    }

    fn run(&mut self, ticks: usize) -> f64 {
        (0..ticks).map(|_| self.tick()).last().unwrap()
    }
}

#[test]
fn it_reaches_the_force_without_overshoot_and_keeps_it() {
    // A servo that follows 24 ms late is a slow one. What it does between first contact and the first answer nobody can
    // take back: such a one has to be led slowly.
    for (lag, knows_slope) in [(0, false), (1, false), (2, false), (0, true), (2, true), (5, true), (12, true)] {
        for sag in [0.0, 0.001] {
            for force in [1.0, 2.0, 5.0, 10.0, 30.0] {
                let mut bench = Bench { sag, knows_slope, ..Bench::new(lag) };
                let speed = (lag > 2).then_some(0.1);
                bench.grip.grip(&Target { speed, ..Target::of(force) }, &LIMITS);
                let slope = 300.0 + 1600.0 * 0.03;
                let allowed = f64::max(0.05 * f64::from(force), slope * COUNT);
                let reached = bench.run(2500);
                assert!((reached - f64::from(force)).abs() <= allowed, "{reached} N of {force} N, lag {lag}");
                assert_eq!(bench.grip.phase(), Phase::Gripped, "{force} N, lag {lag}, sag {sag}");
                let most = f64::from(force) + f64::max(0.1 * f64::from(force), slope * COUNT);
                assert!(bench.greatest <= most, "{} N of {force} N, lag {lag}, sag {sag}", bench.greatest);
                let goal = bench.grip.goal();
                bench.run(500);
                assert_eq!(bench.grip.goal(), goal, "a finger that holds does not move");
            }
        }
    }
}

/// A servo that holds by its error, with friction: the goal is far from the motor, and nowhere the same.
#[test]
fn a_servo_that_sags_grips_as_well() {
    for speed in [None, Some(0.1), Some(0.02)] {
        for force in [1.0, 2.0, 5.0, 10.0, 30.0] {
            let mut bench = Bench::sagging();
            bench.grip.grip(&Target { speed, ..Target::of(force) }, &bench.limits);
            let slope = Bench::slope(0.05 + f64::from(force) / 350.0);
            let reached = bench.run(8000);
            let (force, count) = (f64::from(force), slope * COUNT);
            let what = format!("{reached} N of {force} N at {speed:?}, at most {} N", bench.greatest);
            assert_eq!(bench.grip.phase(), Phase::Gripped, "{what}");
            assert!((reached - force).abs() <= f64::max(0.05 * force, count), "{what}");
            assert!(bench.greatest <= force + f64::max(0.1 * force, count), "{what}");
            let goal = bench.grip.goal();
            bench.run(500);
            assert_eq!(bench.grip.goal(), goal, "a finger that holds does not move");
            // A little less: the friction holds the motor at first.
            bench.grip.grip(&Target { speed, ..Target::of(0.7 * force as f32) }, &bench.limits);
            let reached = bench.run(3000);
            assert!((reached - 0.7 * force).abs() <= f64::max(0.05 * force, count), "{reached} N, {what}");
        }
    }
}

/// Whatever stops it, a motor that comes late does not come on: its goal goes back to where the motor is.
#[test]
fn a_stop_is_a_stop_of_the_motor() {
    for speed in [0.35, 0.1] {
        for by_estimate in [false, true] {
            let mut bench = Bench::sagging();
            bench.grip.grip(&Target { speed: Some(speed), ..Target::of(30.0) }, &bench.limits);
            while bench.tick() < 3.0 {}
            if by_estimate {
                bench.sound = false;
                bench.tick();
                assert_eq!(bench.grip.phase(), Phase::Waiting(Why::Estimate));
            } else {
                bench.grip.hold();
            }
            let before = bench.tick();
            let after = bench.run(1000);
            assert!((after - before).abs() < 2.0 * Bench::slope(0.06) * COUNT, "{before} N, then {after} N");
        }
    }
}

/// A motor that is too weak for a while: it does not jump when its strength comes back, and opens at once.
#[test]
fn a_weak_motor_does_not_jump_when_it_is_strong_again() {
    for reaction in [Reaction::Hold, Reaction::Release] {
        let mut bench = Bench { strength: 19.0, reaction, ..Bench::sagging() };
        bench.grip.grip(&Target { speed: Some(0.1), ..Target::of(30.0) }, &bench.limits);
        while !matches!(bench.grip.phase(), Phase::Held(Why::Stall) | Phase::Released(Why::Stall)) {
            bench.tick();
        }
        let before = bench.tick();
        bench.strength = 141.0;
        bench.greatest = 0.0;
        bench.run(500);
        assert!(bench.greatest < before + 3.0 * Bench::slope(0.08) * COUNT, "{} N, {before} N", bench.greatest);
        bench.grip.open(&bench.limits);
        bench.run(1000);
        assert_eq!((bench.grip.phase(), bench.tick()), (Phase::Released(Why::Asked), 0.0));
    }
}

/// The range is the motor's: the goal goes beyond it by what the load keeps back, and back when the motor follows.
#[test]
fn the_range_is_the_motors_and_not_its_goals() {
    let (mut bench, limit) = (Bench::sagging(), 0.08);
    bench.grip.grip(&Target { limit: Some(limit), ..Target::of(30.0) }, &bench.limits);
    let reached = bench.run(5000);
    assert_eq!(bench.grip.phase(), Phase::Held(Why::Angle));
    let motor = bench.motor.unwrap() * COUNT;
    assert!((motor - f64::from(limit)).abs() <= 1.5 * COUNT, "{motor} rad, {reached} N");
    assert!(bench.grip.goal() > f64::from(limit) + 5.0 * COUNT);
}

/// New limits do not end a grip: within them it goes on, and beyond them it gives way to them.
#[test]
fn a_grip_goes_on_within_new_limits() {
    let mut bench = Bench::sagging();
    bench.grip.grip(&Target { speed: Some(0.1), ..Target::of(10.0) }, &bench.limits);
    let before = bench.run(5000);
    assert_eq!(bench.grip.phase(), Phase::Gripped);
    let goal = bench.grip.goal();
    let others = Limits { open_angle: -0.05, speed: 1.0, current: 1500.0, force: 50.0, range: [-0.2, 0.2] };
    bench.limits = others;
    bench.grip.restrict(&others);
    bench.run(500);
    assert_eq!((bench.grip.phase(), bench.grip.goal()), (Phase::Gripped, goal), "{before} N");
    bench.limits.force = 5.0;
    let limits = bench.limits;
    bench.grip.restrict(&limits);
    let after = bench.run(3000);
    assert!(bench.grip.phase() == Phase::Gripped && (after - 5.0).abs() < Bench::slope(0.07) * COUNT, "{after} N");
    // On its way to an angle it stops at the new end of its range.
    let mut bench = Bench::new(1);
    bench.grip.head(0.2, 0.35);
    bench.run(10);
    let limits = Limits { range: [-0.1, 0.04], ..bench.limits };
    bench.grip.restrict(&limits);
    bench.run(500);
    assert_eq!((bench.grip.phase(), bench.grip.goal()), (Phase::Moving, f64::from(0.04_f32)));
}

/// A finger that is found outside its range, or beyond the limit of its next grip, goes there at the speed that is asked for.
#[test]
fn no_grip_jumps_into_its_range_or_to_its_limit() {
    // Where the motor is behind its goal, that goes back to it at once.
    let (step, back) = (0.05 * TICK + 1e-9, COUNT);
    let to = |limit| Target { speed: Some(0.05), limit, ..Target::of(5.0) };
    let mut bench = Bench { knows_slope: true, ..Bench::new(1) };
    bench.grip.found(-0.2);
    bench.grip.grip(&to(None), &LIMITS);
    for _ in 0..4000 {
        let before = bench.grip.goal();
        bench.tick();
        assert!((bench.grip.goal() - before).abs() <= step, "from {before} to {} rad", bench.grip.goal());
    }
    assert_eq!(bench.grip.phase(), Phase::Gripped);
    // On the way to 0.055 rad it passes the 3 N that are asked for now, and does not stay there.
    bench.grip.grip(&Target { force: 3.0, ..to(Some(0.055)) }, &LIMITS);
    while bench.grip.phase() != Phase::Held(Why::Angle) {
        let before = bench.grip.goal();
        bench.tick();
        assert!((before - bench.grip.goal()).abs() <= back, "from {before} to {} rad", bench.grip.goal());
        assert_ne!(bench.grip.phase(), Phase::Gripped);
    }
    assert!((bench.grip.goal() - 0.055).abs() <= 1.5 * COUNT, "{} rad", bench.grip.goal());
    // What is wrong meanwhile leaves it where it is.
    bench.grip.found(-0.2);
    bench.grip.grip(&to(None), &LIMITS);
    bench.sound = false;
    bench.run(20);
    assert!(bench.grip.goal() <= -0.2 + 2.0 * step, "{} rad", bench.grip.goal());
}

#[test]
fn a_motion_of_a_servo_that_sags_ends_at_the_force_limit() {
    for speed in [0.35, 0.1] {
        let mut bench = Bench::sagging();
        bench.limits.force = 6.0;
        bench.grip.head(0.2, speed);
        bench.run(3000);
        assert_eq!(bench.grip.phase(), Phase::Held(Why::Force));
        assert!(bench.greatest <= 6.0 * 1.05 && bench.greatest > 5.0, "{} N", bench.greatest);
    }
}

/// Wherever the counts lie, a count that is worth 0.5 N is not taken if it gives more than a tenth too much.
#[test]
fn the_next_count_is_left_out_where_it_would_be_too_much() {
    for place in 0..20 {
        let mut bench = Bench { knows_slope: true, ..Bench::new(1) };
        let force = 3.0 + 0.025 * place as f32;
        bench.grip.grip(&Target::of(force), &LIMITS);
        let reached = bench.run(1000);
        assert_eq!(bench.grip.phase(), Phase::Gripped);
        assert!(bench.greatest <= 1.1 * f64::from(force), "{} N of {force} N", bench.greatest);
        assert!(f64::from(force) - reached <= Bench::slope(0.06) * COUNT, "{reached} N of {force} N");
    }
}

/// Asked again while it holds something, as after a servo that was lost: it knows nothing but what it feels.
#[test]
fn a_grip_from_within_contact_does_not_jump() {
    for knows_slope in [false, true] {
        let mut bench = Bench { knows_slope, ..Bench::new(1) };
        bench.grip.grip(&Target::of(9.0), &LIMITS);
        bench.run(1000);
        let goal = bench.grip.goal();
        bench.grip.found(goal);
        bench.grip.grip(&Target::of(9.5), &LIMITS);
        bench.run(1000);
        assert_eq!(bench.grip.phase(), Phase::Gripped);
        assert!(bench.greatest <= 1.1 * 9.5, "{} N", bench.greatest);
    }
}

#[test]
fn a_new_force_is_reached_from_either_side() {
    let mut bench = Bench::new(1);
    for force in [5.0, 2.0, 8.0] {
        bench.grip.grip(&Target::of(force), &LIMITS);
        let reached = bench.run(800);
        assert!((reached - f64::from(force)).abs() <= 0.6, "{reached} N of {force} N");
    }
}

#[test]
fn the_angle_ends_a_grip_on_nothing() {
    let mut bench = Bench::new(1);
    let to = Target { limit: Some(0.04), speed: Some(0.2), ..Target::of(5.0) };
    bench.grip.grip(&to, &LIMITS);
    let mut last = 0.0;
    for _ in 0..400 {
        bench.tick();
        assert!(bench.grip.goal() <= 0.04 + 1e-6 && bench.grip.goal() - last <= 0.2 * TICK + 1e-9);
        last = bench.grip.goal();
    }
    assert_eq!(bench.grip.phase(), Phase::Held(Why::Angle));
}

#[test]
fn a_bad_estimate_holds_within_the_tick_or_releases() {
    for (reaction, phase) in
        [(Reaction::Hold, Phase::Waiting(Why::Estimate)), (Reaction::Release, Phase::Released(Why::Estimate))]
    {
        let mut bench = Bench { reaction, ..Bench::new(0) };
        bench.grip.grip(&Target::of(5.0), &LIMITS);
        bench.run(90);
        bench.sound = false;
        let goal = bench.grip.goal() + 1e-9;
        bench.tick();
        assert_eq!(bench.grip.phase(), phase);
        bench.tick();
        assert!(bench.grip.goal() <= goal + 0.35 * TICK, "one tick's goal was on its way");
        bench.run(200);
        bench.sound = true;
        bench.run(800);
        match reaction {
            Reaction::Hold => assert_eq!(bench.grip.phase(), Phase::Gripped),
            Reaction::Release => {
                assert_eq!(bench.grip.phase(), phase);
                assert_eq!(bench.grip.goal(), f64::from(LIMITS.open_angle));
            }
        }
    }
}

#[test]
fn a_silent_bus_moves_nothing() {
    let mut bench = Bench::new(0);
    bench.grip.grip(&Target::of(5.0), &LIMITS);
    bench.run(90);
    bench.grip.miss(&LIMITS, Reaction::Hold);
    assert_eq!(bench.grip.phase(), Phase::Waiting(Why::Bus));
    let goal = bench.grip.goal();
    for _ in 0..100 {
        bench.goal();
        bench.grip.miss(&LIMITS, Reaction::Hold);
    }
    assert_eq!(bench.grip.goal(), goal);
    bench.grip.miss(&LIMITS, Reaction::Release);
    assert_eq!(bench.grip.phase(), Phase::Released(Why::Bus));
}

/// What a finger has gripped it keeps when its host is gone, whatever becomes of its phase; a grip on its way ends.
#[test]
fn a_finger_that_has_gripped_does_not_let_go_without_its_host() {
    let mut bench = Bench::new(1);
    bench.grip.grip(&Target::of(5.0), &LIMITS);
    bench.run(90);
    let mut closing = bench.grip.clone();
    closing.leave(&LIMITS, Reaction::Hold);
    assert_eq!(closing.phase(), Phase::Held(Why::Host), "on its way");
    bench.run(800);
    assert_eq!(bench.grip.phase(), Phase::Gripped);
    bench.grip.miss(&LIMITS, Reaction::Hold);
    bench.grip.leave(&LIMITS, Reaction::Release);
    assert_eq!(bench.grip.phase(), Phase::Waiting(Why::Bus), "one answer is lost");
    // The object gives way.
    bench.part = 1.2;
    bench.run(1);
    bench.grip.leave(&LIMITS, Reaction::Release);
    assert_eq!(bench.grip.phase(), Phase::Gripping, "it follows");
    bench.run(800);
    bench.grip.leave(&LIMITS, Reaction::Release);
    assert_eq!(bench.grip.phase(), Phase::Gripped);
}

#[test]
fn a_servo_found_again_holds() {
    let mut bench = Bench::new(0);
    bench.grip.grip(&Target::of(5.0), &LIMITS);
    bench.run(90);
    bench.grip.found(0.02);
    assert_eq!(bench.grip.phase(), Phase::Held(Why::ServoLost));
    assert_eq!(bench.grip.advance(TICK, &LIMITS), 0.02);
    assert!(!bench.grip.is_gripping());
}

#[test]
fn a_blocked_motor_is_not_led_on() {
    let mut bench = Bench { stop: 0.03, ..Bench::new(0) };
    bench.grip.grip(&Target::of(5.0), &LIMITS);
    bench.run(600);
    assert_eq!(bench.grip.phase(), Phase::Held(Why::Stall));
    let mut bench = Bench { stop: 0.03, reaction: Reaction::Release, ..Bench::new(0) };
    bench.grip.grip(&Target::of(5.0), &LIMITS);
    bench.run(600);
    assert_eq!(bench.grip.phase(), Phase::Released(Why::Stall));
}

#[test]
fn current_ends_every_closing_motion() {
    for gripping in [true, false] {
        let mut bench = Bench { limits: Limits { current: 300.0, ..LIMITS }, ..Bench::new(0) };
        if gripping {
            bench.grip.grip(&Target::of(5.0), &LIMITS);
        } else {
            bench.grip.head(0.2, 0.3);
        }
        bench.run(20);
        bench.current = 301.0;
        bench.tick();
        assert_eq!(bench.grip.phase(), Phase::Held(Why::Current));
        // Opening is free.
        bench.grip.open(&LIMITS);
        bench.run(200);
        assert_eq!(bench.grip.phase(), Phase::Released(Why::Asked));
        assert_eq!(bench.grip.goal(), 0.0);
    }
}

#[test]
fn no_motion_goes_beyond_the_force_limit() {
    for lag in 0..3 {
        let mut bench = Bench { limits: Limits { force: 6.0, ..LIMITS }, ..Bench::new(lag) };
        bench.grip.head(0.2, 0.35);
        bench.run(800);
        assert_eq!(bench.grip.phase(), Phase::Held(Why::Force));
        assert!(bench.greatest <= 6.0 * 1.02 && bench.greatest > 5.0, "{} N", bench.greatest);
    }
}

#[test]
fn an_alert_stops_a_grip() {
    let mut bench = Bench::new(0);
    bench.grip.grip(&Target::of(5.0), &LIMITS);
    bench.run(50);
    let touch = Touch { angle: 0.03, alert: true, ..CALM };
    bench.grip.feel(&touch, COUNT, TICK, &LIMITS, &FAULTS);
    assert_eq!(bench.grip.phase(), Phase::Held(Why::Alert));
}
