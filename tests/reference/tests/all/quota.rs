//! With a quota of one Newton iteration a tick's work is bounded, whatever happens to the finger; what does not fit is spread over ticks, and
//! no force is called better than it is.

use model_core::discretise::{Discretisation, Physics, Sampling};
use model_core::estimator::{Estimate, Estimator};
use model_core::real::Real;
use model_core::size::{Reduced, Rubbing, Size};
use model_core::status::Status;
use reference_tests::campaign::{self, Tick};
use reference_tests::random::Cases;
use reference_tests::{COUNT, ladder_80};

/// Newton iterations per tick.
const QUOTA: u32 = 1;
const SAMPLES: [u8; 3] = [2, 4, 5];

fn estimator<T: Real>(samples: u8, budget: u32) -> Box<Estimator<T, Reduced>> {
    sized(samples, budget, 0.0)
}

/// Coefficient of friction.
const RUBS: f64 = 0.6;

/// The same with friction.
fn rubbing<T: Real>(samples: u8, budget: u32) -> Box<Estimator<T, Rubbing>> {
    sized(samples, budget, RUBS)
}

fn sized<T: Real, S: Size>(samples: u8, budget: u32, friction: f64) -> Box<Estimator<T, S>> {
    let mut estimator: Box<Estimator<T, S>> = Box::new(Estimator::EMPTY);
    let how = Discretisation { sampling: Sampling::PerElement(samples), ..Discretisation::reduced(Physics::Extended) };
    estimator.configure(&ladder_80(), &how).expect("a valid finger");
    estimator.set_friction(friction).expect("a coefficient in range");
    estimator.set_budget(budget);
    estimator
}

/// The estimates with the quota, and those of double precision with all the time they need.
fn estimates(
    samples: u8,
    quota: u32,
    ticks: impl Iterator<Item = Tick>,
) -> impl Iterator<Item = (Tick, Estimate, Estimate)> {
    let (mut short, mut exact) = (estimator::<f32>(samples, quota), estimator::<f64>(samples, 1000));
    ticks.map(move |tick| {
        assert!(tick.prepare(&mut short) && tick.prepare(&mut exact));
        (tick, short.update(tick.angle()), exact.update(tick.angle()))
    })
}

fn difference(one: &Estimate, other: &Estimate) -> f32 {
    (one.force[0] - other.force[0]).hypot(one.force[1] - other.force[1])
}

/// Solves and evaluations of the campaign's tick that takes most of them.
fn most_effort<S: Size>(mut estimator: Box<Estimator<f32, S>>) -> (u32, u32) {
    campaign::ticks().fold((0, 0), |(solves, evaluations), tick| {
        assert!(tick.prepare(&mut estimator));
        let before = estimator.follower().effort();
        let estimate = estimator.update(tick.angle());
        assert!(u32::from(estimate.iterations) <= QUOTA, "{tick:?}: {estimate:?}");
        let spent = estimator.follower().effort().since(before);
        (solves.max(spent.solves), evaluations.max(spent.evaluations))
    })
}

/// With friction the accepted state is evaluated as well, and shown again after a look beside it.
#[test]
fn a_tick_takes_one_step_and_few_evaluations_at_most() {
    for samples in SAMPLES {
        assert_eq!(most_effort(estimator(samples, QUOTA)), (1, 3), "{samples} samples");
        assert_eq!(most_effort(rubbing(samples, QUOTA)), (1, 4), "{samples} samples with friction");
    }
}

#[test]
fn a_force_is_as_good_as_its_status_says() {
    for samples in SAMPLES {
        let (mut sound, mut updating, mut worst) = (0, 0, [0.0_f32; 2]);
        for (tick, estimate, exact) in estimates(samples, QUOTA, campaign::ticks()) {
            let off = difference(&estimate, &exact);
            if estimate.status.is_trustworthy() {
                sound += 1;
                worst[0] = worst[0].max(off);
                assert!(off < 0.01 && estimate.age == 0, "{samples} samples, {tick:?}: off by {off} N, {estimate:?}");
            } else if estimate.status == Status::Updating {
                updating += 1;
                let bound = f32::max(0.01 * exact.force_magnitude(), 0.05);
                worst[1] = worst[1].max(off / bound);
                assert!(off < bound && estimate.age > 0, "{samples} samples, {tick:?}: off by {off} N, {estimate:?}");
            }
        }
        println!(
            "{samples} samples: {sound} good, at most {:.1} mN off; {updating} updating, at most {:.2} of their bound",
            1e3 * worst[0],
            worst[1]
        );
        assert!(sound > 3000 && updating > 10, "{sound} good, {updating} updating");
    }
}

/// Width of what the force's magnitude may be, if that is known.
fn width(estimate: &Estimate) -> Option<f32> {
    estimate.interval.map(|interval| interval.magnitude[1] - interval.magnitude[0])
}

/// With friction, against the same estimator with all the time it needs: where both know the way that the contact has come, and the finger has not
/// jumped in one of them only.
#[test]
fn a_force_with_friction_is_that_of_an_estimator_with_time() {
    const KNOWN: f32 = 1e-3;
    // Rounding decides some ticks, so that the 95 % of one campaign are anywhere from 0.041 to 0.062 N: several count together.
    const BESIDE: [f64; 5] = [0.0, 1e-6, -1e-6, 1e-5, -1e-5];
    for samples in [2, 5] {
        let (mut off, mut sound, mut late, mut touching) = (Vec::new(), 0_usize, 0_usize, 0);
        let (mut updating, mut within) = (0_usize, 0_usize);
        for beside in BESIDE {
            let [mut short, mut whole] =
                [QUOTA, 1000].map(|budget| sized::<f32, Rubbing>(samples, budget, RUBS + beside));
            let mut shown = [0.0; 2];
            for tick in campaign::ticks() {
                assert!(tick.prepare(&mut short) && tick.prepare(&mut whole));
                let (estimate, exact) = (short.update(tick.angle()), whole.update(tick.angle()));
                touching += u32::from(exact.force != [0.0; 2]);
                if estimate.status == Status::MaxIterations {
                    late += 1;
                    assert_eq!(
                        estimate.force, shown,
                        "{samples} samples, {tick:?}: the old numbers stay, {estimate:?}"
                    );
                }
                shown = estimate.force;
                let alike = (estimate.status == Status::Snapped) == (exact.status == Status::Snapped);
                let known = [&estimate, &exact].iter().all(|one| width(one).is_some_and(|width| width < KNOWN));
                if estimate.status.is_trustworthy() && exact.force != [0.0; 2] {
                    sound += 1;
                    if known && alike {
                        off.push(difference(&estimate, &exact));
                    }
                } else if estimate.status == Status::Updating && known {
                    updating += 1;
                    within +=
                        usize::from(difference(&estimate, &exact) < f32::max(0.01 * exact.force_magnitude(), 0.05));
                }
            }
        }
        off.sort_unstable_by(f32::total_cmp);
        let part = |part: usize| off.get(part * (off.len() - 1) / 100).copied().unwrap_or(f32::INFINITY);
        println!(
            "{samples} samples, friction: {sound} of {touching} good, {late} max-iterations; of {} whose way is known, off by {:.4} N in the \
             median, 95 % {:.3}, 99 % {:.3}, {:.2} at most; {within} of {updating} updating within their bound",
            off.len(),
            part(50),
            part(95),
            part(99),
            part(100)
        );
        let each = BESIDE.len();
        assert!(sound > 2300 * each && late < 480 * each && off.len() > 1500 * each, "{sound} {late} {}", off.len());
        assert!(within * 100 > 90 * updating && updating > 100 * each, "{within} of {updating}");
        assert!(part(50) < 0.005 && part(95) < 0.06 && part(99) < 0.15, "{:?}", [50, 95, 99].map(part));
    }
}

/// An object that is set while the finger is closed is approached as if there were no friction; then both ends of what the force may be are those
/// that are found with time.
#[test]
fn an_object_that_rubs_is_approached_over_ticks() {
    for samples in [2, 5] {
        let (mut short, mut whole) = (rubbing::<f32>(samples, QUOTA), rubbing::<f32>(samples, 1000));
        let closed = (11_f64.to_radians() / COUNT).round() * COUNT;
        let set = |estimator: &mut Estimator<f32, Rubbing>| {
            let first = Tick { position: 0, height: Some(56.0) };
            assert!(first.prepare(estimator));
        };
        set(&mut short);
        set(&mut whole);
        let mut ends = None;
        for tick in 1..=90 {
            let estimate = short.update(closed);
            assert!(estimate.status.is_trustworthy() || estimate.age > 0, "{estimate:?}");
            if let Some(interval) = short.interval().filter(|_| estimate.standard_deviation.is_finite()) {
                ends = Some((tick, interval));
                break;
            }
        }
        let Some((tick, found)) = ends else { panic!("{samples} samples: nothing is known") };
        let known = (0..20).map(|_| whole.update(closed)).last().and_then(|_| whole.interval());
        let Some(known) = known else { panic!("{samples} samples: nothing is known with time") };
        println!(
            "{samples} samples, friction: after {tick} ticks {:?} N, with time {:?}",
            found.magnitude, known.magnitude
        );
        for (one, other) in found.magnitude.into_iter().zip(known.magnitude) {
            assert!((one / other - 1.0).abs() < 1e-3, "{found:?} {known:?}");
        }
        assert!(tick < 60, "{tick}");
    }
}

/// Closing and opening, slow and fast: the force is never old for long.
#[test]
fn a_moving_finger_is_kept_up_with() {
    for (quota, speed, least) in
        [(1, 0.1, 0.97), (1, 0.35, 0.95), (1, 1.0, 0.85), (2, 0.1, 0.99), (2, 0.35, 0.99), (2, 1.0, 0.95)]
    {
        let ticks = (0.19 / (speed * 0.002)) as i32;
        let ticks = (0..=ticks).chain((0..ticks).rev()).map(move |tick| {
            let position = (f64::from(tick) * speed * 0.002 / COUNT).round() as i32;
            Tick { position, height: (tick == 0).then_some(45.0) }
        });
        let (mut touching, mut sound, mut usable, mut oldest) = (0, 0, 0, 0);
        for (_, estimate, exact) in estimates(5, quota, ticks) {
            oldest = oldest.max(estimate.age);
            if exact.status != Status::NoContact {
                touching += 1;
                sound += u32::from(estimate.status.is_trustworthy());
                usable += u32::from(estimate.status.is_trustworthy() || estimate.status == Status::Updating);
            }
        }
        println!(
            "{quota} iterations, {speed} rad/s: {sound} of {touching} good, {usable} with those updating, {oldest} ticks old at most"
        );
        let part = |count: u32| f64::from(count) / f64::from(touching);
        assert!(part(sound) > least && part(usable) > 0.95 && oldest <= 5, "{sound}, {usable} of {touching}, {oldest}");
    }
}

/// Another object while the finger is closed by 11°: approached from the open finger within 45 ticks, and until then the old force has its age.
#[test]
fn another_object_is_approached_over_ticks() {
    for samples in SAMPLES {
        let closed = (11_f64.to_radians() / COUNT).round() as i32;
        let closing = (-11..=closed).map(|position| Tick { position, height: (position == -11).then_some(45.0) });
        let holding = (0..90).map(|tick| Tick { position: closed, height: (tick == 0).then_some(56.0) });
        let held: Vec<_> = estimates(samples, QUOTA, closing.chain(holding)).collect();
        let held = held.get(held.len() - 90..).expect("ninety ticks");
        let first = held.iter().position(|(_, estimate, _)| estimate.status.is_trustworthy()).expect("an estimate");
        println!("{samples} samples: the other object's force after {first} ticks");
        assert!((20..=45).contains(&first), "{first}");
        for (tick, (_, estimate, exact)) in held.iter().enumerate() {
            let good = estimate.status.is_trustworthy();
            assert!(good == (tick >= first) || estimate.status == Status::Updating, "{tick}: {estimate:?}");
            assert!(
                if good { difference(estimate, exact) < 0.01 } else { estimate.age as usize == tick + 1 },
                "{estimate:?}"
            );
        }
    }
}

/// Random fingers that are closed already when a random circle is set: the approach ends where small steps lead, with the quota as with the time
/// for the whole way in one tick.
#[test]
fn an_approach_ends_on_the_branch_of_small_steps() {
    const FINGERS: usize = 300;
    const PATIENCE: usize = 400;
    let (mut ticks, mut held, mut apart, mut lost) = (Vec::new(), 0, [0; 2], [0; 2]);
    for case in Cases::seeded(29).take(FINGERS) {
        let make = |budget| {
            let mut estimator: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
            let how =
                Discretisation { sampling: Sampling::PerElement(4), ..Discretisation::reduced(Physics::Extended) };
            // With nine lamellae there are more samples than a gripper has room for.
            estimator.configure(&case.design, &how).ok()?;
            estimator.set_object(case.object()).expect("a valid object");
            estimator.set_budget(budget);
            Some(estimator)
        };
        let Some(mut exact) = make(1000) else { continue };
        let first = ((case.touch - 0.02) / COUNT).floor() as i32;
        let last = (case.angle / COUNT).round() as i32;
        let mut followed = exact.update(f64::from(first) * COUNT);
        let mut snapped = false;
        for count in first..=last {
            followed = exact.update(f64::from(count) * COUNT);
            snapped |= followed.status == Status::Snapped;
        }
        // Behind a snap-through it depends on the steps where one ends.
        if !followed.status.is_trustworthy() || followed.status == Status::NoContact || snapped {
            continue;
        }
        held += 1;
        let angle = f64::from(last) * COUNT;
        for (which, budget) in [QUOTA, 1000].into_iter().enumerate() {
            let mut estimator = make(budget).expect("room as before");
            let found = (1..PATIENCE).find_map(|tick| {
                let estimate = estimator.update(angle);
                estimate.status.is_trustworthy().then_some((tick, estimate))
            });
            match found {
                None => lost[which] += 1,
                Some((tick, estimate)) => {
                    let off = difference(&estimate, &followed);
                    apart[which] += u32::from(off > 0.01 + 0.01 * followed.force_magnitude());
                    if which == 0 {
                        ticks.push(tick);
                    }
                }
            }
        }
    }
    ticks.sort_unstable();
    let part = |part: usize| ticks.get(part * ticks.len() / 100).copied().unwrap_or_default();
    println!(
        "{held} fingers: {apart:?} elsewhere, {lost:?} nowhere with the quota and without; median {} ticks, 90 % {}, {:?} at most",
        part(50),
        part(90),
        ticks.last()
    );
    assert!(held > FINGERS / 2 && (apart, lost) == ([0; 2], [0; 2]));
    assert!(part(50) <= 45 && part(90) <= 70, "{ticks:?}");
}
