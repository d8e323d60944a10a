//! Everything that can go wrong, counted, in a time of its own: nothing stops the gripper, and no wrong force is called good.

use std::cell::Cell;
use std::rc::Rc;

use fre_gripper::servo::{Config, OnBranch};
use messages::{
    Event, For, Grip, GripTo, Phase, Reaction, Role, SetFinger, SetObject, SetSettings, Settings, Which, Why,
};
use model_core::object::ObjectDesign;
use model_core::status::Status;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use system_tests::{
    Bench, Flash, GEARED_MOUNT, Judge, OBJECT, an_hour, finger, geared_servo, is_sound, load_of, ready, set_up,
};

const COUNT: f64 = std::f64::consts::TAU / 4096.0;
const SECOND: u64 = 1_000_000;
/// A period at 500 Hz, µs.
const TICK: u64 = 2_000;
/// Random requests of a campaign.
const REQUESTS: u32 = 100_000;

fn grip(force: f32) -> GripTo {
    GripTo { fingers: Which::All, force, speed: None, limit: None }
}

/// The grip in ideal surroundings: what is told is what is, at every tick.
#[test]
fn three_forces_on_three_objects() {
    let circle = |radius, x, y| ObjectDesign::Circle { centre: [x, y], radius };
    for object in [OBJECT, circle(40.0, 41.0, 60.0), circle(30.0, 31.0, 38.0)] {
        let load = load_of(object, 17.0);
        let mut bench = Bench::new(Config { load: load.clone(), ..geared_servo() }, &Flash::new());
        set_up(&mut bench, &Settings::of(GEARED_MOUNT), object);
        for force in [2.0_f64, 5.0, 10.0] {
            bench.ask::<Grip>(&grip(force as f32)).unwrap();
            let (mut most, mut judge) = (0.0_f64, Judge::default());
            bench.run_with(2 * SECOND, |report, truth| {
                most = most.max(truth.force[0].hypot(truth.force[1]));
                judge.look(report, truth);
            });
            let truth = bench.servo.truth();
            let [x, y] = truth.force;
            let magnitude = |counts: f64| {
                let [x, y] = load.at(truth.finger_angle + counts * COUNT, &mut OnBranch::default()).force;
                x.hypot(y)
            };
            let allowed = f64::max(0.05 * force, magnitude(0.5) - magnitude(-0.5));
            let phase = bench.reports.last().unwrap().0.phase;
            eprintln!("{object:?}: {force} N asked, {:.3} N reached (±{allowed:.3}), {most:.3} N most", x.hypot(y));
            assert_eq!(phase, Phase::Gripped);
            assert!((x.hypot(y) - force).abs() <= allowed, "{} N of {force} N", x.hypot(y));
            assert!(most <= 1.1 * force, "{most} N on the way to {force} N");
            judge.verdict("ideal surroundings", &bench);
            bench.ask::<messages::Open>(&Which::All).unwrap();
            bench.run(2 * SECOND);
        }
    }
}

/// Random bytes among the packets in both directions, a million of them.
#[test]
fn a_million_random_bytes_on_the_bus() {
    let mut bench = ready(&Settings::of(GEARED_MOUNT));
    bench.ask::<Grip>(&grip(5.0)).unwrap();
    bench.run(2 * SECOND);
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let done = Rc::new(Cell::new(0_u32));
    let count = done.clone();
    bench.meddling = Box::new(move |_, bytes| {
        // Every few packets: before, behind, or instead of one.
        if random.next_u32() % 4 > 0 {
            return bytes;
        }
        let mut noise = vec![0; (random.next_u32() % 96) as usize];
        random.fill_bytes(&mut noise);
        count.set(count.get() + noise.len() as u32);
        match random.next_u32() % 3 {
            0 => [noise, bytes].concat(),
            1 => [bytes, noise].concat(),
            _ => noise,
        }
    });
    let mut judge = Judge::default();
    bench.keeps = false;
    while done.get() < 1_000_000 {
        judge.run(&mut bench, SECOND);
    }
    let share = judge.share();
    recover(&mut bench, &mut judge);
    judge.verdict("a million random bytes", &bench);
    // A twelfth of the questions and of the answers is replaced.
    within_a_tenth("sound estimates", share, (11.0_f64 / 12.0).powi(2));
}

/// A share that is at most a tenth below what the design gives, and not above it.
fn within_a_tenth(what: &str, found: f64, design: f64) {
    eprintln!("{what}: {found:.3}, by the design {design:.3}");
    assert!((0.9 * design..=1.02 * design).contains(&found), "{what}: {found}, by the design {design}");
}

/// Whether the servo is lost, by the last event that says so.
fn is_lost(bench: &Bench) -> bool {
    let says = |event: &&Event| matches!(event, Event::ServoLost { .. } | Event::ServoReady { .. });
    matches!(bench.events.iter().rev().find(says), Some(Event::ServoLost { .. }))
}

/// The bus is well again: a sound estimate within three ticks. A servo that was lost meanwhile is found first.
fn recover(bench: &mut Bench, judge: &mut Judge) {
    bench.meddling = Box::new(|_, bytes| bytes);
    let began = bench.now_us();
    while is_lost(bench) {
        assert!(bench.now_us() - began < SECOND, "not found: {judge:?}");
        judge.run(bench, TICK);
    }
    judge.bad = 0;
    let before = judge.reports;
    let mut worst = 0;
    bench.run_with(SECOND, |report, truth| {
        judge.look(report, truth);
        worst = worst.max(judge.bad);
    });
    eprintln!("{worst} ticks without a sound estimate of {}", judge.reports - before);
    assert!(worst <= 3 && judge.bad == 0, "{worst} ticks without a sound estimate: {judge:?}");
}

/// Every bit flips with one in a thousand.
#[test]
fn bit_errors() {
    let mut bench = ready(&Settings::of(GEARED_MOUNT));
    bench.ask::<Grip>(&grip(5.0)).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(2);
    // Questions, and those that came through with their answers.
    let exchanges = Rc::new(Cell::new([0_u32; 2]));
    let (counted, mut is_whole) = (exchanges.clone(), false);
    bench.meddling = Box::new(move |to_servo, mut bytes| {
        let sent = bytes.clone();
        for byte in &mut bytes {
            for bit in 0..8 {
                if random.next_u32() < u32::MAX / 1000 {
                    *byte ^= 1 << bit;
                }
            }
        }
        let [questions, answered] = counted.get();
        if to_servo {
            is_whole = bytes == sent;
            counted.set([questions + 1, answered]);
        } else {
            counted.set([questions, answered + u32::from(is_whole && bytes == sent)]);
        }
        bytes
    });
    let mut judge = Judge::default();
    bench.keeps = false;
    // Reports, sound ones, questions and answers of the ticks in which the servo is there.
    let (mut there, mut lost) = ([0.0; 4], 0);
    for tick in 0..50_000 {
        // Several answers lost in a row lose the servo, which ends a grip; refused as long as it is not found again.
        if tick % 500 == 0 {
            let _ = bench.ask::<Grip>(&grip(5.0));
        }
        let seen = |judge: &Judge| {
            let [questions, answered] = exchanges.get().map(f64::from);
            [judge.reports as f64, judge.sound as f64, questions, answered]
        };
        let before = seen(&judge);
        judge.run(&mut bench, TICK);
        if is_lost(&bench) {
            lost += 1;
        } else {
            (0..4).for_each(|place| there[place] += seen(&judge)[place] - before[place]);
        }
    }
    eprintln!("lost for {lost} of 50,000 ticks");
    recover(&mut bench, &mut judge);
    judge.verdict("bit errors of 1e-3", &bench);
    let [reports, sound, questions, answered] = there;
    within_a_tenth("sound estimates", sound / reports, answered / questions);
    within_a_tenth("of them in contact", judge.touching as f64 / judge.sound as f64, 1.0);
}

/// Single faults, each followed by a well bus: the estimate is sound again within three ticks, whatever the fault was.
#[test]
fn every_fault_passes_within_three_ticks() {
    let mut bench = ready(&Settings::of(GEARED_MOUNT));
    bench.ask::<Grip>(&grip(5.0)).unwrap();
    bench.run(2 * SECOND);
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut judge = Judge::default();
    bench.keeps = false;
    let mut longest = 0;
    for round in 0..3000_u32 {
        let kind = round % 6;
        let seed = random.next_u64();
        let to_servo = random.next_u32() % 2 == 0;
        let mut left = 1;
        let mut last = Vec::new();
        bench.meddling = Box::new(move |outwards, mut bytes| {
            if left == 0 || outwards != to_servo || bytes.len() < 4 {
                last.clone_from(&bytes);
                return bytes;
            }
            left -= 1;
            let at = (seed % bytes.len() as u64) as usize;
            match kind {
                // Lost, doubled, cut, damaged, too much, the one before once more.
                0 => Vec::new(),
                1 => [bytes.clone(), bytes].concat(),
                2 => bytes[..at].to_vec(),
                3 => {
                    bytes[at] ^= 1 << (seed >> 32 & 7);
                    bytes
                }
                4 => [vec![(seed >> 40) as u8; 20], bytes].concat(),
                _ => [last.clone(), bytes].concat(),
            }
        });
        let mut worst = 0;
        bench.run_with(8 * TICK, |report, truth| {
            judge.look(report, truth);
            worst = worst.max(judge.bad);
        });
        assert_eq!(judge.bad, 0, "fault {kind} ({to_servo}) lasts");
        longest = longest.max(worst);
    }
    eprintln!("longest: {longest} ticks without a sound estimate");
    assert!(longest <= 3, "{longest} ticks");
    judge.verdict("single faults", &bench);
}

/// The servo restarts in the middle of an answer, again and again; its torque is off then. The gripper finds it, says so
/// and holds.
#[test]
fn a_servo_that_restarts() {
    let mut bench = ready(&Settings::of(GEARED_MOUNT));
    let mut judge = Judge::default();
    for round in 0..20 {
        bench.ask::<Grip>(&grip(4.0)).unwrap();
        judge.run(&mut bench, SECOND + 137 * round);
        bench.servo.reset();
        judge.run(&mut bench, SECOND);
        assert_eq!(judge.bad, 0, "round {round}");
        bench.ask::<messages::Open>(&Which::All).unwrap();
        judge.run(&mut bench, SECOND);
    }
    judge.verdict("restarts of the servo", &bench);
}

/// The host vanishes for seconds: the control loop does not notice.
#[test]
fn a_host_that_vanishes() {
    let mut bench = ready(&Settings::of(GEARED_MOUNT));
    bench.ask::<Grip>(&grip(5.0)).unwrap();
    let mut judge = Judge::default();
    let before = bench.ask::<messages::GetCounters>(&());
    for _ in 0..5 {
        bench.listens = false;
        bench.run(4 * SECOND);
        bench.listens = true;
        // The oldest that waited are of before; their truth is another.
        bench.run(SECOND / 10);
        judge.run(&mut bench, SECOND / 2);
    }
    let after = bench.ask::<messages::GetCounters>(&());
    let ticks = after.ticks - before.ticks;
    // 23 s at 500 Hz: no tick is missing, and every one has its estimate; what did not fit the 2 KB of the link was dropped.
    within_a_tenth("ticks", f64::from(ticks), 23.0 * 500.0);
    within_a_tenth("estimates", f64::from(after.estimates - before.estimates), f64::from(ticks));
    let dropped = after.dropped_reports - before.dropped_reports;
    within_a_tenth("dropped reports", f64::from(dropped), 20.0 * 500.0);
    assert_eq!(after.late_ticks, before.late_ticks, "{after:?}");
    judge.verdict("a host that vanishes", &bench);
    assert_eq!(bench.reports.last().unwrap().0.phase, Phase::Gripped);
}

/// Many requests of random bytes, sound frames all of them, and noise between them: each is answered, and once.
#[test]
fn random_requests() {
    let mut bench = ready(&Settings::of(GEARED_MOUNT));
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let keys: Vec<_> = messages::ENDPOINTS.endpoints.iter().map(|(_, key, _)| *key).collect();
    bench.keeps = false;
    let (mut sent, mut answered) = (Vec::new(), Vec::new());
    for round in 0..REQUESTS {
        let key = keys[random.next_u32() as usize % keys.len()];
        let mut body = vec![0; (random.next_u32() % 64) as usize];
        random.fill_bytes(&mut body);
        // Small numbers are valid more often.
        body.iter_mut().for_each(|byte| *byte = if *byte < 128 { *byte % 4 } else { *byte });
        sent.push(bench.send_body(postcard_rpc::header::VarKey::Key8(key), &body));
        if round % 8 == 0 {
            let mut noise = vec![0; 30];
            random.fill_bytes(&mut noise);
            bench.send_raw(&noise);
        }
        if round % 32 == 0 {
            bench.run(TICK / 2);
            answered.extend(bench.take_answered());
        }
    }
    for _ in 0..600 {
        bench.run(SECOND);
        answered.extend(bench.take_answered());
        if bench.unread() == 0 && answered.len() >= sent.len() {
            break;
        }
    }
    eprintln!("{} requests, {} answers", sent.len(), answered.len());
    assert_eq!(bench.unread(), 0, "{} answers", answered.len());
    // One after the other, so in their order.
    let differs = sent.iter().zip(&answered).find(|(sent, answered)| sent != answered);
    assert_eq!(differs, None, "{} requests, {} answers", sent.len(), answered.len());
    assert_eq!(answered.len(), sent.len());
    // As if nothing had been, once a search of the bus is over that may have been asked for last.
    bench.run(10 * SECOND);
    set_up(&mut bench, &Settings::of(GEARED_MOUNT), OBJECT);
    bench.ask::<Grip>(&grip(5.0)).unwrap();
    bench.until("grip", 5 * SECOND, |report| report.phase == Phase::Gripped);
    let (fast, bite) = bench.longest_fast_us();
    assert!(fast < bite, "the watchdog would have bitten after {fast} µs");
}

/// What is set survives; what is damaged is told and gone, and never stops the start.
#[test]
fn settings_survive_and_damaged_ones_are_told() {
    let flash = Flash::new();
    let settings = Settings { on_fault: Reaction::Release, rate_hz: 250, ..Settings::of(GEARED_MOUNT) };
    let mut bench = Bench::new(geared_servo(), &flash);
    set_up(&mut bench, &settings, OBJECT);
    drop(bench);

    let mut bench = Bench::new(geared_servo(), &flash);
    bench.until("estimate without being told anything", 5 * SECOND, is_sound);
    assert!(bench.events.contains(&Event::Restored { records: 3, damaged: 0 }), "{:?}", bench.events);
    assert_eq!(bench.ask::<messages::GetSettings>(&()), settings);
    assert_eq!(bench.ask::<messages::GetFinger>(&0), Some(finger()));
    assert_eq!(bench.ask::<messages::GetObject>(&0), Some(OBJECT.into()));
    drop(bench);

    let mut random = ChaCha8Rng::seed_from_u64(5);
    for round in 0..40 {
        for _ in 0..1 << (round % 12) {
            flash.damage(random.next_u32() as usize, random.next_u32() as u8);
        }
        let mut bench = Bench::new(geared_servo(), &flash);
        bench.run(SECOND / 10);
        set_up(&mut bench, &settings, OBJECT);
        assert_eq!(bench.ask::<messages::GetSettings>(&()), settings);
    }
}

/// An hour of gripping and releasing on a bus that is never quite well.
#[test]
fn an_hour_of_gripping_is_sound() {
    let hour = an_hour();
    eprintln!("an hour: {}; longest fast {} µs", hour.judge, hour.fast_us);
    assert!(hour.faults().is_empty(), "{:?}: {hour:?}", hour.faults());
}

/// Closes the finger firmly.
fn close(bench: &mut Bench) {
    bench.ask::<messages::Close>(&messages::CloseTo { fingers: Which::All, angle: 0.17, speed: Some(0.6) }).unwrap();
}

/// A processor that is too slow for its rate: it does with few iterations; where these do not suffice, a tick tells the last good
/// force with its age. None is late, and none is wrong.
#[test]
fn a_slow_processor_tells_old_forces_in_time() {
    // An estimate may take as long as the time between two positions.
    let mut bench = ready(&Settings::of(GEARED_MOUNT));
    bench.set_cost(TICK as u32);
    let before = bench.ask::<messages::GetCounters>(&());
    let mut judge = Judge::default();
    let (mut old, mut dearest) = (0, 0);
    let mut good = None;
    for _ in 0..4 {
        close(&mut bench);
        bench.run_with(SECOND, |report, truth| {
            judge.look(report, truth);
            dearest = dearest.max(report.estimate.iterations);
            // One within its bound is repeated as well.
            if is_sound(report) || report.estimate.status == Status::Updating {
                good = Some(report.estimate.force);
            } else if report.estimate.status == Status::MaxIterations {
                old += 1;
                assert!(report.estimate.age > 0 && good.is_none_or(|good| good == report.estimate.force), "{report:?}");
            }
        });
        bench.ask::<messages::Open>(&Which::All).unwrap();
        judge.run(&mut bench, SECOND);
    }
    let after = bench.ask::<messages::GetCounters>(&());
    eprintln!("{old} of {} reports repeat the last good force; {dearest} iterations at most", judge.reports);
    judge.verdict("a slow processor", &bench);
    assert!(old > 0, "{judge:?}");
    within_a_tenth("sound estimates", judge.share(), 1.0);
    assert_eq!(after.late_ticks, before.late_ticks);
    // There is time for as many.
    assert!(dearest <= 2, "{dearest} iterations in one tick, which has time for 2");
    // One that is fast enough never does.
    bench.set_cost(0);
    close(&mut bench);
    bench.run(SECOND / 10);
    bench.run_with(SECOND, |report, _| assert!(is_sound(report), "{report:?}"));
}

/// A slow bus takes nine tenths of a period. The estimates have that time, too: the next question waits for none of them.
#[test]
fn a_slow_bus_leaves_estimates_their_time() {
    let settings = Settings { baud: Some(57_600), ..Settings::of(GEARED_MOUNT) };
    let mut bench = ready(&settings);
    bench.run(SECOND);
    let before = bench.ask::<messages::GetCounters>(&());
    let [bus_us, period_us] = [62.0 * 10.0 / 57_600.0 * 1e6, 1e6 / before.chosen_hz];
    // More than the bus leaves, and less than half of the period.
    let cost_us = 0.4 * period_us;
    assert!(bus_us + cost_us > period_us && period_us > 10_000.0, "{bus_us} of {period_us} µs");
    bench.set_cost(cost_us as u32);
    let (mut judge, mut most) = (Judge::default(), 0);
    for round in 0..24 {
        close(&mut bench);
        bench.run_with(SECOND, |report, truth| {
            judge.look(report, truth);
            // What an estimate takes is learnt by then.
            most = most.max(if round < 20 { 0 } else { report.estimate.iterations });
        });
        bench.ask::<messages::Open>(&Which::All).unwrap();
        judge.run(&mut bench, SECOND);
    }
    let after = bench.ask::<messages::GetCounters>(&());
    eprintln!("{most} iterations at most");
    judge.verdict("a slow bus", &bench);
    // What the bus leaves would do for one.
    assert!(most > 1, "{most} iterations at most, though there is time for more");
    assert_eq!(after.late_ticks, before.late_ticks);
}

/// A listener whose master pauses repeats the estimate with the age of its position, and calls it stale after 100 ms.
#[test]
fn a_position_that_was_heard_has_its_age() {
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    let settings = Settings { role: Role::Tap, baud: Some(1_000_000), ..Settings::of(GEARED_MOUNT) };
    bench.ask::<SetSettings>(&settings).unwrap();
    bench.ask::<SetFinger>(&For { finger: 0, what: finger() }).unwrap();
    bench.ask::<SetObject>(&For { finger: 0, what: OBJECT.into() }).unwrap();
    let mut buffer = [0; 64];
    let id = dynamixel::Id::new(1).unwrap();
    let question = dynamixel::encode(&mut buffer, id, dynamixel::Instruction::Read, &[132, 0, 4, 0]).unwrap().to_vec();
    for _ in 0..100 {
        bench.interject(&question);
        bench.run(TICK);
    }
    bench.reports.clear();
    bench.run(SECOND / 5);
    let ages: Vec<u32> = bench.reports.iter().map(|(report, _)| report.estimate.age).collect();
    let first = ages.first().copied().unwrap();
    assert!(first <= 1, "{ages:?}");
    assert!(ages.iter().zip(first..).all(|(age, tick)| *age == tick), "{ages:?}");
    let is_stale = |(report, _): &(messages::Report, _)| report.estimate.status == Status::Stale;
    let young = bench.reports.iter().position(is_stale).expect("stale at last");
    assert!((49..=51).contains(&young), "repeated for {young} ticks of 2 ms");
    assert!(bench.reports[young..].iter().all(is_stale));
}

/// With `Release`, a single lost answer opens the finger in the tick it was missed.
#[test]
fn release_within_a_tick() {
    let settings = Settings { on_fault: Reaction::Release, ..Settings::of(GEARED_MOUNT) };
    let mut bench = ready(&settings);
    bench.ask::<Grip>(&grip(5.0)).unwrap();
    bench.run(SECOND);
    let before = bench.reports.len();
    let mut left = 1;
    bench.meddling = Box::new(move |outwards, bytes| {
        if outwards || left == 0 {
            return bytes;
        }
        left -= 1;
        Vec::new()
    });
    bench.run(SECOND);
    let first = bench.reports[before..].iter().position(|(report, _)| !is_sound(report)).unwrap();
    assert_eq!(bench.reports[before + first].0.phase, Phase::Released(Why::Bus));
    let goals: Vec<f32> = bench.reports[before + first..].iter().take(3).map(|(report, _)| report.goal).collect();
    assert!(goals[1] < goals[0] || goals[2] < goals[1], "{goals:?}");
    assert_eq!(bench.reports.last().unwrap().0.goal, GEARED_MOUNT.open_angle);
}
