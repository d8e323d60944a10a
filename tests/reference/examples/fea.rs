#![allow(missing_docs)]
use model_core::design::*;
use model_core::discretise::*;
use model_core::equilibrium::*;
use model_core::object::*;
use model_core::size::*;

fn main() {
    let mut d = reference_tests::ladder_80();
    d.lamellae.attachments = Attachments::Heights((1..=6).map(|k| 10.0 * k as f64).collect());
    d.hinge.length = heapless::Vec::from_slice(&[2.5, 2.5, 2.5, 2.5, 2.5, 1.97]).unwrap();
    d.hinge.from = HingeFrom::Face;
    d.rigid_above = Some(74.116);
    let text = include_str!("../fea-80-fine.csv");
    let mut f = Box::new(Follower::<f64, Paper>::EMPTY);
    let mut last = String::new();
    let mut how = Discretisation::fine(Physics::Extended);
    if std::env::args().nth(1).as_deref() == Some("reduced") {
        how = Discretisation::reduced(Physics::Extended);
    }
    for line in text.lines().skip(1) {
        let v: Vec<&str> = line.split(',').collect();
        let n = |i: usize| v[i].parse::<f64>().unwrap();
        let r = n(2) / 2.0;
        if last != v[1] {
            last = v[1].to_string();
            f.configure(&d, &how).unwrap();
            f.set_object(
                ObjectDesign::Circle { centre: [1.0 + r, n(3)], radius: r },
                Motion::Rotating { axis: d.motor_axis },
            );
            f.start(0.0);
        }
        let out = f.follow(n(4).to_radians());
        let force = f.force_finger();
        let mag = force[0].hypot(force[1]);
        let nums = |s: &str| s.split(' ').map(|x| x.parse::<f64>().unwrap()).collect::<Vec<_>>();
        let (fx, fy) = (nums(v[13]), nums(v[14]));
        let line: Vec<[f64; 2]> = f.front().collect();
        let mut worst = 0.0_f64;
        for (x, y) in fx.iter().zip(&fy) {
            let mut near = f64::MAX;
            for w in line.windows(2) {
                let (p, q) = (w[0], w[1]);
                let d = [q[0] - p[0], q[1] - p[1]];
                let t = (((x - p[0]) * d[0] + (y - p[1]) * d[1]) / (d[0] * d[0] + d[1] * d[1])).clamp(0.0, 1.0);
                near = near.min((x - p[0] - t * d[0]).hypot(y - p[1] - t * d[1]));
            }
            worst = worst.max(near);
        }
        println!(
            "{} {:5}° {:10} fea {:8.4} ours {:8.4} {:+6.2} % shape {:.3} mm it {}",
            v[1],
            v[4],
            out.status,
            n(9),
            mag,
            100.0 * (mag / n(9) - 1.0),
            worst,
            out.iterations
        );
    }
}
