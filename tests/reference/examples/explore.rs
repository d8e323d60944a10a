#![allow(missing_docs)]
use model_core::design::*;
use model_core::discretise::*;
use model_core::equilibrium::*;
use model_core::object::*;
use model_core::real::Real;
use model_core::size::*;
use model_core::status::Status;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use std::collections::BTreeMap;
use std::time::Instant;

fn unit(r: &mut ChaCha8Rng) -> f64 {
    (r.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}
fn pm(r: &mut ChaCha8Rng, v: f64) -> f64 {
    v * (0.7 + 0.6 * unit(r))
}

pub fn random(r: &mut ChaCha8Rng) -> (Design, ObjectDesign, f64) {
    let mut d = reference_tests::ladder_80();
    let h = pm(r, 80.0);
    let b = -pm(r, 28.0);
    d.front.tip = [0.0, h];
    d.back.tip = [0.0, h];
    d.back.base = [b, 0.0];
    d.front.thickness = Profile::constant(pm(r, 2.0));
    d.back.thickness = Profile::constant(pm(r, 2.0));
    d.width = Profile::constant(pm(r, 20.0));
    d.hinge.length = heapless::Vec::from_iter([pm(r, 2.5)]);
    d.hinge.thickness = pm(r, 0.8);
    let k = 3 + (unit(r) * 7.0) as usize;
    let pitch = 0.7 * h / k as f64;
    d.lamellae.attachments =
        Attachments::Heights((1..=k).map(|i| pitch * (i as f64 + 0.3 * (unit(r) - 0.5))).collect());
    d.material.youngs_modulus = pm(r, 49.5);
    d.motor_axis = [pm(r, -14.0), pm(r, -20.0)];
    let radius = 10.0 + 50.0 * unit(r);
    let y = h * (0.3 + 0.5 * unit(r));
    let x = radius + 0.5 * d.front.thickness.at(0.0) + 3.0 * unit(r);
    let ind = 2.0 + 18.0 * unit(r);
    (d, ObjectDesign::Circle { centre: [x, y], radius }, ind)
}

fn run<T: Real, S: Size>(
    goal: Option<f64>,
    f: &mut Follower<T, S>,
    d: &Design,
    how: &Discretisation,
    o: ObjectDesign,
    ind: f64,
    max_step: f64,
) -> (Outcome, [f64; 2], f64, f64) {
    f.configure(d, how).unwrap();
    f.set_settings(Settings { max_angle_step: max_step.to_radians(), ..Settings::DEFAULT });
    f.set_object(o, Motion::Rotating { axis: d.motor_axis });
    assert!(f.start(0.5));
    let at = goal.unwrap_or(f.coordinate() + ind.to_radians());
    let out = f.follow(at);
    (out, f.force_world().map(|x| x.to_f64()), f.coordinate(), at)
}

fn main() {
    let n: usize = std::env::args().nth(1).map_or(2000, |s| s.parse().unwrap());
    let phys = if std::env::args().nth(2).as_deref() == Some("ext") { Physics::Extended } else { Physics::Paper };
    let mut r = ChaCha8Rng::seed_from_u64(1);
    let mut a = Box::new(Follower::<f64, Reduced>::EMPTY);
    let mut b = Box::new(Follower::<f32, Reduced>::EMPTY);
    let mut c = Box::new(Follower::<f64, Paper>::EMPTY);
    let mut tally: BTreeMap<String, usize> = BTreeMap::new();
    let mut times = [0.0; 3];
    let mut differ = [0; 3];
    for i in 0..n {
        let (d, o, ind) = random(&mut r);
        if d.validate().is_err() {
            *tally.entry(format!("{:?}", d.validate())).or_default() += 1;
            continue;
        }
        let t = Instant::now();
        let ra = run(None, &mut a, &d, &Discretisation::reduced(phys), o, ind, 1.0);
        times[0] += t.elapsed().as_secs_f64();
        let t = Instant::now();
        let rb = run(Some(ra.3), &mut b, &d, &Discretisation::reduced(phys), o, ind, 1.0);
        times[1] += t.elapsed().as_secs_f64();
        let t = Instant::now();
        let rc = run(Some(ra.3), &mut c, &d, &Discretisation::reduced(phys), o, ind, 0.1);
        times[2] += t.elapsed().as_secs_f64();
        *tally
            .entry(format!("64 {} | 32 {} | 64 fine steps {}", ra.0.status, rb.0.status, rc.0.status))
            .or_default() += 1;
        let m = |v: [f64; 2]| v[0].hypot(v[1]);
        let df = |p: [f64; 2], q: [f64; 2]| m([p[0] - q[0], p[1] - q[1]]);
        if ra.0.status.is_trustworthy() && rc.0.status.is_trustworthy() && df(ra.1, rc.1) > 1e-3 * m(rc.1) + 1e-4 {
            differ[0] += 1;
            println!("{i}: 64 vs fine steps {:?} {:?} {:?} {:?}", ra.0.status, ra.1, rc.0.status, rc.1);
        }
        if ra.0.status.is_trustworthy() && rb.0.status.is_trustworthy() && df(ra.1, rb.1) > 1e-3 * m(ra.1) + 1e-3 {
            differ[1] += 1;
            println!("{i}: 64 vs 32 {:?} {:?} {:?} {:?}", ra.0.status, ra.1, rb.0.status, rb.1);
        }
        if !ra.0.status.is_trustworthy() || !rb.0.status.is_trustworthy() {
            println!(
                "{i}: {:?} at {} | {:?} at {} ind {ind} | {:?}",
                ra.0,
                ra.2.to_degrees(),
                rb.0,
                rb.2.to_degrees(),
                rc.0.status
            );
        }
        let _ = Status::Converged;
    }
    println!("{tally:#?} {times:?} {differ:?}");
}
