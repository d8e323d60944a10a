//! Random fingers that close, open and close again with friction: hardly any lost, each of those reported, and none on another path in one
//! precision or at one size of steps than in the others.

use std::f64::consts::TAU;

use model_core::design::Design;
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::random_designs::{Random, Round, first_contact, random_case};
use model_core::real::Real;

model_core::fixed_size!(
    /// The resolution `reduced` with up to 12 lamellae and 60 touching samples, with friction.
    Many, cells 13, nodes 206, samples 146, contacts 121, friction
);

/// Fingers; all thousand by `FRE_RANDOM_FINGERS=1000 cargo test -p reference-tests --release --test all friction_random::`.
const FINGERS: usize = 60;

/// A finger, a circle, a coefficient of friction, and the angles at which the motion turns round, rad.
struct Rub {
    design: Design,
    round: Round,
    coefficient: f64,
    turns: [f64; 4],
}

fn rubs(count: usize) -> Vec<Rub> {
    let (mut random, mut coefficients) = (Random::new(5), Random::new(6));
    let mut one = || {
        let (design, round, indentation) = random_case(&mut random);
        let touch = first_contact(&design, round.centre, round.radius);
        let (last, back) = (touch + indentation, touch + 0.2 * indentation);
        Rub { design, round, coefficient: 0.1 + 0.9 * coefficients.unit(), turns: [touch - 0.001, last, back, last] }
    };
    (0..count).map(|_| one()).collect()
}

/// Force at the end of a leg, N; none where the path was lost or has snapped.
type Ends = [Option<[f64; 2]>; 3];

/// Follows a motion in steps of so much, rad; its forces, and whether it was lost, which its status says.
fn follow<T: Real>(follower: &mut Follower<T, Many>, rub: &Rub, step: f64) -> (Ends, bool) {
    let how = Discretisation::estimator(Physics::Extended);
    follower.configure(&rub.design, &how).expect("a valid design");
    let object = ObjectDesign::Circle { centre: rub.round.centre, radius: rub.round.radius };
    follower.set_object(object, Motion::Rotating { axis: rub.design.motor_axis });
    follower.set_friction(rub.coefficient).expect("a coefficient in range");
    assert!(follower.start(rub.turns[0]));
    let (mut ends, mut snapped) = ([None; 3], false);
    for (leg, end) in rub.turns.windows(2).zip(&mut ends) {
        let count = ((leg[1] - leg[0]).abs() / step).ceil();
        for k in 1..=count as usize {
            let outcome = follower.follow(leg[0] + (leg[1] - leg[0]) * k as f64 / count);
            if !outcome.status.is_trustworthy() {
                return (ends, true);
            }
            snapped |= outcome.snaps > 0;
        }
        *end = (!snapped).then(|| follower.solution().force_world().map(Real::to_f64));
    }
    (ends, false)
}

#[test]
fn random_fingers_close_open_and_close_again() {
    let count = std::env::var("FRE_RANDOM_FINGERS").ok().and_then(|count| count.parse().ok()).unwrap_or(FINGERS);
    let (mut double, mut single) = (Box::new(Follower::<f64, Many>::EMPTY), Box::new(Follower::<f32, Many>::EMPTY));
    let (coarse, fine) = (0.5_f64.to_radians(), TAU / 4096.0);
    let (mut lost, mut compared, mut worst) = ([0; 4], 0, [0.0_f64; 2]);
    for (case, rub) in rubs(count).iter().enumerate() {
        let paths = [
            follow(&mut double, rub, fine),
            follow(&mut double, rub, coarse),
            follow(&mut single, rub, fine),
            follow(&mut single, rub, coarse),
        ];
        for (count, (_, is_lost)) in lost.iter_mut().zip(&paths) {
            *count += u32::from(*is_lost);
        }
        for leg in 0..3 {
            let Some([x, y]) = paths[0].0[leg] else { continue };
            for (path, &(ends, _)) in paths.iter().enumerate().skip(1) {
                let Some([u, v]) = ends[leg] else { continue };
                let (off, size) = ((x - u).hypot(y - v), x.hypot(y));
                // Opening ends within a reversal where the finger is stiff: the force there depends on the steps.
                let part = off / size.max(0.5);
                worst[usize::from(leg == 1)] = worst[usize::from(leg == 1)].max(part);
                compared += 1;
                let allowed = if leg == 1 { 0.05 } else { 0.02 };
                if part >= allowed {
                    println!("finger {case}, m {}, leg {leg}, path {path}: {off} of {size} N", rub.coefficient);
                }
            }
        }
    }
    println!(
        "{count} fingers: lost {lost:?} (f64 by counts and by 0.5°, f32 likewise), {compared} forces compared, worst {worst:.4?}"
    );
    assert!(lost.iter().all(|&lost| f64::from(lost) <= 0.005 * count as f64), "{lost:?}");
    assert!(compared > 8 * count, "{compared}");
}
