//! Every public call that promises a bound keeps it: what was computed is counted, not timed.

use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::{FOLLOW_ITERATIONS, Follower, START_CHECKS, Settings, Tracking};
use model_core::estimator::{Estimator, EstimatorSettings};
use model_core::grasp::{EXCESS, Finger, Grasp, Load, Placement};
use model_core::newton::Effort;
use model_core::object::{Corners, Motion, ObjectDesign};
use model_core::random_designs::Random;
use model_core::size::{Paper, Reduced};
use model_core::status::Status;
use reference_tests::{COUNT, circle_80, ladder_80};

const TURNING: Motion = Motion::Rotating { axis: [-14.0, -20.0] };
const SLIDING: Motion = Motion::Translating { direction: [1.0, 0.0] };

type Single = Follower<f32, Reduced>;
type Model = Estimator<f32, Reduced>;

fn follower(object: ObjectDesign, motion: Motion) -> Box<Single> {
    let mut follower: Box<Single> = Box::new(Follower::EMPTY);
    follower.configure(&ladder_80(), &Discretisation::estimator(Physics::Extended)).expect("a valid finger");
    follower.set_object(object, motion);
    follower
}

fn estimator(object: ObjectDesign) -> Box<Model> {
    let mut estimator: Box<Model> = Box::new(Estimator::EMPTY);
    estimator.configure(&ladder_80(), &Discretisation::estimator(Physics::Extended)).expect("a valid finger");
    estimator.set_object(object).expect("a valid object");
    estimator
}

/// What a call computes.
fn effort<R>(follower: &mut Single, call: impl FnOnce(&mut Single) -> R) -> (R, Effort) {
    let before = follower.effort();
    let result = call(follower);
    (result, follower.effort().since(before))
}

/// An object that the finger lies in at every coordinate.
fn everywhere() -> ObjectDesign {
    ObjectDesign::HalfPlane { point: [900.0, 0.0], normal: [1.0, 0.0] }
}

#[test]
fn beginning_takes_one_evaluation_and_a_start_no_more_than_its_checks() {
    for motion in [TURNING, SLIDING] {
        for step in [1e-6, 1e-4, 0.02] {
            let mut follower = follower(everywhere(), motion);
            let settings = Settings { max_angle_step: step, max_distance_step: 200.0 * step, ..Settings::DEFAULT };
            follower.set_settings(settings).expect("allowed");
            let (began, spent) = effort(&mut follower, |follower| follower.begin(0.1));
            // `begin` puts the finger at rest first, which evaluates nothing.
            assert_eq!((began, spent), (false, Effort { evaluations: 1, solves: 0 }));
            let (started, spent) = effort(&mut follower, |follower| follower.start(0.1));
            assert!(!started && spent.solves == 0 && spent.evaluations <= START_CHECKS, "{spent:?} at steps of {step}");
        }
    }
}

/// One accepted step may take one factorisation that is no iteration: the one that judges it.
fn is_within(spent: Effort, iterations: u32, steps: u32, budget: u32) -> bool {
    iterations <= budget && spent.solves <= iterations + steps.max(iterations) + 1
}

/// Small steps, large ones and jumps, through snaps and back, with every budget.
#[test]
fn following_and_tracking_keep_their_budgets() {
    let objects = [circle_80(45.0), circle_80(60.0), ObjectDesign::Circle { centre: [11.0, 65.0], radius: 10.0 }];
    for object in objects {
        for budget in [0, 1, 2, 3, 5, 8, 30, 500] {
            for track in [false, true] {
                let mut follower = follower(object, TURNING);
                assert!(follower.start(0.0));
                let small = (0..130).map(|count| f64::from(count) * COUNT);
                let large = [0.25, 0.0, 0.33, 0.1, 0.4, -0.2, 0.2].into_iter();
                for angle in small.chain(large) {
                    let (outcome, spent) = effort(&mut follower, |follower| {
                        if track {
                            follower.track(angle, Tracking::DEFAULT, budget)
                        } else {
                            follower.follow_within(angle, budget)
                        }
                    });
                    let (iterations, steps) = (outcome.iterations, outcome.steps);
                    assert!(is_within(spent, iterations, steps, budget), "budget {budget}: {outcome:?} {spent:?}");
                    // Iterations, steps, and what is tried in vain: each is one evaluation or two.
                    let most = 4 * budget + 64;
                    assert!(spent.evaluations <= most, "budget {budget}: {outcome:?} {spent:?}");
                }
            }
        }
        let mut follower = follower(object, TURNING);
        assert!(follower.start(0.0));
        for angle in [0.5, -0.5, 1.5] {
            let (outcome, spent) = effort(&mut follower, |follower| follower.follow(angle));
            assert!(is_within(spent, outcome.iterations, outcome.steps, FOLLOW_ITERATIONS), "{outcome:?} {spent:?}");
        }
    }
}

/// A finger whose object cannot be carried any further is back where it was, without an iteration for the return.
#[test]
fn moving_an_object_costs_its_budget_only_and_failing_changes_nothing() {
    let mut follower = follower(circle_80(45.0), TURNING);
    assert!(follower.start(0.0));
    assert_eq!(follower.follow(0.15).status, Status::Converged);
    let before = (follower.solution().force_world(), follower.solution().coordinate(), follower.solution().touching());
    // Against the clamped base.
    let far = ObjectDesign::Circle { centre: [21.0, 0.0], radius: 40.0 };
    let (outcome, spent) = effort(&mut follower, |follower| follower.shift_object([-20.0, -45.0], far));
    assert!(!outcome.status.is_trustworthy(), "{outcome:?}");
    assert!(is_within(spent, outcome.iterations, outcome.steps, FOLLOW_ITERATIONS), "{outcome:?} {spent:?}");
    assert_eq!(
        (follower.solution().force_world(), follower.solution().coordinate(), follower.solution().touching()),
        before
    );
    let (outcome, spent) = effort(&mut follower, |follower| follower.follow(0.15));
    assert_eq!((outcome.status, outcome.iterations, spent.solves), (Status::Converged, 0, 0));
}

/// Two fingers on random objects that are pushed and turned by more than they can hold, with every budget.
#[test]
fn a_balance_keeps_its_budget() {
    let mut random = Random::new(5);
    let mut between = |least: f64, most: f64| least + (most - least) * random.unit();
    let far = Placement { mirrored: true, angle: 0.0, translation: [56.0, 0.0] };
    let (mut balances, mut over, mut most) = (0, 0, 0);
    for case in 0..200 {
        let (x, y, angle) = (between(24.0, 32.0), between(30.0, 74.0), between(-0.4, 0.4));
        let semi_axes = [between(16.0, 25.0), between(12.0, 32.0)];
        let object = match case % 3 {
            0 => ObjectDesign::Circle { centre: [x, y], radius: semi_axes[0] },
            1 => ObjectDesign::Ellipse { centre: [x, y], semi_axes, angle },
            _ => {
                let (sin, cos) = angle.sin_cos();
                let [a, b] = [semi_axes[0] - 2.0, semi_axes[1] - 2.0];
                let corner = |u: f64, v: f64| [x + cos * u - sin * v, y + sin * u + cos * v];
                let corners = Corners::new(&[corner(-a, -b), corner(a, -b), corner(a, b), corner(-a, b)]);
                ObjectDesign::Polygon { corners: corners.expect("four corners"), rounding: 2.0 }
            }
        };
        let moment = if case % 3 == 0 { 0.0 } else { between(-150.0, 150.0) };
        let load = Load { force: [between(-8.0, 8.0), between(-8.0, 8.0)], moment };
        let mut pair = [follower(circle_80(45.0), TURNING), follower(circle_80(45.0), TURNING)];
        let mut fingers = heapless::Vec::new();
        for (follower, placement) in pair.iter_mut().zip([Placement::HERE, far]) {
            assert!(fingers.push(Finger { follower: &mut **follower, placement, motion: TURNING }).is_ok());
        }
        let mut grasp = Grasp::new(fingers, object, load).expect("a good grasp");
        if grasp.close(&[between(0.05, 0.3), between(0.05, 0.3)]).is_ok_and(|status| !status.is_trustworthy()) {
            continue;
        }
        let budget = [0, 1, 2, 4, 7, 16, 40, 300][case % 8];
        for call in 0..12 {
            let before = grasp.effort();
            let balance = grasp.release_within(budget);
            let spent = grasp.effort().since(before);
            let told = format!("{object:?} {load:?} budget {budget}, call {call}: {balance:?} {spent:?}");
            assert!(balance.iterations <= budget + EXCESS && spent.solves <= budget + EXCESS, "{told}");
            (balances, over) = (balances + 1, over + u32::from(spent.solves > budget));
            most = most.max(spent.solves.saturating_sub(budget));
        }
    }
    println!("{balances} balances, {over} over their budget, by {most} at most");
    assert!(balances > 1_000 && over > 0, "{balances} balances, {over} of them over their budget");
}

/// Ticks without time, or with little, while the motor moves: no fold, no snap, and the forces of an estimator that had it.
#[test]
fn ticks_without_time_end_in_no_fold() {
    for (object, from) in [(circle_80(45.0), 60), (circle_80(60.0), 40), (circle_80(20.0), 60), (circle_80(45.0), 4)] {
        for budget in 0..=3 {
            for (ticks, pace) in [(10, 1), (10, 5), (40, 2), (3, 20)] {
                let mut starved = estimator(object);
                for count in -8..=from {
                    assert!(starved.update(f64::from(count) * COUNT).status.is_trustworthy());
                }
                starved.set_budget(budget);
                for tick in 1..=ticks {
                    let before = starved.follower().effort();
                    let estimate = starved.update(f64::from(from + pace * tick) * COUNT);
                    let spent = starved.follower().effort().since(before);
                    assert!(
                        !matches!(estimate.status, Status::Folded | Status::Snapped | Status::OutOfRange),
                        "budget {budget}, tick {tick} of {ticks}, {pace} counts each: {estimate:?}"
                    );
                    assert!(u32::from(estimate.iterations) <= budget && spent.solves <= 2 * budget + 1, "{spent:?}");
                }
                starved.set_budget(EstimatorSettings::DEFAULT.budget);
                let last = f64::from(from + pace * ticks) * COUNT;
                let recovered = (0..20).map(|_| starved.update(last)).find(|estimate| estimate.age == 0);
                let mut fed = estimator(object);
                let fed = (-8..=from + pace * ticks).map(|count| fed.update(f64::from(count) * COUNT)).last();
                let (recovered, fed) = (recovered.expect("an estimate within 20 ticks"), fed.expect("many ticks"));
                assert_eq!(recovered.status, fed.status, "budget {budget}, {ticks} ticks of {pace}");
                let apart = (recovered.force[0] - fed.force[0]).hypot(recovered.force[1] - fed.force[1]);
                assert!(apart < 2e-3, "budget {budget}: {recovered:?} {fed:?}");
            }
        }
    }
}

#[test]
fn settings_that_would_never_end_are_refused_by_name() {
    let mut single = follower(circle_80(45.0), TURNING);
    let mut refused = |settings| single.set_settings(settings).expect_err("must be refused").name;
    for value in [0.0, -0.01, f64::NAN, f64::INFINITY, 1e-9, 2.0] {
        assert_eq!(refused(Settings { max_angle_step: value, ..Settings::DEFAULT }), "max_angle_step");
    }
    for value in [0.0, -1.0, f64::NAN, 1e3] {
        assert_eq!(refused(Settings { max_distance_step: value, ..Settings::DEFAULT }), "max_distance_step");
        assert_eq!(refused(Settings { min_step: 2.0 * value, ..Settings::DEFAULT }), "min_step");
    }
    assert_eq!(refused(Settings { max_iterations: 0, ..Settings::DEFAULT }), "max_iterations");
    assert_eq!(refused(Settings { margin: -1e-3, ..Settings::DEFAULT }), "margin");
    // The old ones stay.
    assert!(single.start(0.0) && single.follow(0.1).status == Status::Converged);
    let error = single.set_settings(Settings { max_angle_step: 0.0, ..Settings::DEFAULT }).unwrap_err();
    assert_eq!(error.to_string(), "max_angle_step is 0; allowed is 0.000001 to 1");

    let mut model = estimator(circle_80(45.0));
    let mut refused = |settings| model.set_settings(settings, Settings::DEFAULT).expect_err("must be refused").name;
    for range in [[0.2, 0.1], [f64::NAN, 1.0], [f64::NEG_INFINITY, 0.0], [0.0, 1e4]] {
        assert_eq!(refused(EstimatorSettings { range, ..EstimatorSettings::DEFAULT }), "range");
    }
    let content = |gradient, length| EstimatorSettings {
        one_iteration: Some(Tracking { gradient, length }),
        ..EstimatorSettings::DEFAULT
    };
    assert_eq!(refused(content(-1.0, 0.01)), "one_iteration.gradient");
    assert_eq!(refused(content(1.0, f64::NAN)), "one_iteration.length");
    let error = model.set_settings(EstimatorSettings::DEFAULT, Settings { min_step: 0.0, ..Settings::DEFAULT });
    assert_eq!(error.unwrap_err().name, "min_step");
    assert!(model.update(0.0).status.is_trustworthy());
}

/// A design in which nothing is clear keeps an estimator's search for an open finger within its checks per tick.
#[test]
fn an_estimator_looks_for_an_open_finger_a_few_places_a_tick() {
    let mut model = estimator(everywhere());
    for _ in 0..200 {
        let before = model.follower().effort();
        let estimate = model.update(0.3);
        let spent = model.follower().effort().since(before);
        assert!(!estimate.status.is_trustworthy() && spent.evaluations <= 8 && spent.solves == 0, "{spent:?}");
    }
}

/// The largest model too.
/// A closing and opening at 1 rad/s and 500 Hz, from several first angles: a tick is two thirds of what a judged state is near enough
/// for, and first contact lies anywhere within one.
#[test]
fn an_estimator_in_double_precision_keeps_up_with_a_fast_motion_within_its_default_budget() {
    const TICK: f64 = 2e-3;
    let (mut ticks, mut late) = (0, Vec::new());
    for (height, first) in
        [30.0, 45.0, 60.0].into_iter().flat_map(|y| (0..8).map(move |part| (y, f64::from(part) / 8.0)))
    {
        let mut model: Box<Estimator<f64, Reduced>> = Box::new(Estimator::EMPTY);
        model.configure(&ladder_80(), &Discretisation::estimator(Physics::Extended)).expect("a valid finger");
        model.set_object(circle_80(height)).expect("a valid object");
        for tick in (-10..60).chain((-10..60).rev()) {
            let estimate = model.update((f64::from(tick) + first) * TICK);
            ticks += 1;
            if !estimate.status.is_trustworthy() {
                late.push((height, first, tick, estimate.status, estimate.iterations));
            }
        }
    }
    assert!(late.is_empty(), "{} of {ticks} ticks: {late:?}", late.len());
}

#[test]
fn a_call_that_follows_far_keeps_its_bound_in_double_precision() {
    let mut follower: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
    follower.configure(&ladder_80(), &Discretisation::reduced(Physics::Extended)).expect("a valid finger");
    follower.set_object(circle_80(65.0), TURNING);
    assert!(follower.start(0.0));
    for (angle, budget) in [(0.3, 40), (0.3, 200), (0.0, 15), (0.6, 3000)] {
        let before = follower.effort();
        let outcome = follower.follow_within(angle, budget);
        let spent = follower.effort().since(before);
        assert!(is_within(spent, outcome.iterations, outcome.steps, budget), "{outcome:?} {spent:?}");
    }
}
