//! Grips on a servo as it comes from the factory, which holds a load by its error and comes late, in a time of its own.

use fre_gripper::servo::{Config, Load, OnBranch};
use messages::{Grip, GripTo, Open, Phase, Settings, Which};
use model_core::object::ObjectDesign;
use system_tests::{Bench, Flash, GEARED_MOUNT, OBJECT, geared_servo, is_sound, load_of, set_up};

const SECOND: u64 = 1_000_000;
/// One count of the servo, rad.
const COUNT: f64 = std::f64::consts::TAU / 4096.0;

fn circle(radius: f64, x: f64, y: f64) -> ObjectDesign {
    ObjectDesign::Circle { centre: [x, y], radius }
}

/// 5 % of a force, or what one count makes there.
fn allowed(load: &Load, angle: f64, force: f64) -> f64 {
    let magnitude = |angle: f64| {
        let [x, y] = load.at(angle, &mut OnBranch::default()).force;
        x.hypot(y)
    };
    f64::max(0.05 * force, magnitude(angle + 0.5 * COUNT) - magnitude(angle - 0.5 * COUNT))
}

/// Three objects, three forces, two rates: the force asked for is reached, never a tenth more, and then nothing moves.
#[test]
fn a_grip_ends_and_rests() {
    for object in [OBJECT, circle(40.0, 41.0, 60.0), circle(30.0, 31.0, 38.0)] {
        let load = load_of(object, 17.0);
        for rate_hz in [100, 500] {
            let mut bench = Bench::new(Config { load: load.clone(), ..geared_servo() }, &Flash::new());
            set_up(&mut bench, &Settings { rate_hz, shape_every: 0, ..Settings::of(GEARED_MOUNT) }, object);
            for force in [2.0_f64, 5.0, 10.0] {
                let what = format!("{force} N at {rate_hz} Hz on {object:?}");
                let to = GripTo { fingers: Which::All, force: force as f32, speed: Some(0.1), limit: None };
                bench.ask::<Grip>(&to).unwrap();
                let (mut most, mut grips, mut last) = (0.0_f64, 0, Phase::Gripping);
                let end = bench.now_us() + 12 * SECOND;
                let (mut goal, mut moved) = (0.0, 0);
                while bench.now_us() < end {
                    bench.run(SECOND / 50);
                    let (report, truth) = *bench.reports.last().unwrap();
                    most = most.max(truth.force[0].hypot(truth.force[1]));
                    grips += u32::from(report.phase == Phase::Gripped && last != Phase::Gripped);
                    moved = if report.goal == goal { moved } else { bench.now_us() };
                    (last, goal) = (report.phase, report.goal);
                }
                let truth = bench.servo.truth();
                let reached = truth.force[0].hypot(truth.force[1]);
                let still = (bench.now_us() - moved) / 1000;
                eprintln!("{what}: {reached:.3} N, at most {most:.3} N, gripped {grips} times, at rest for {still} ms");
                assert_eq!(last, Phase::Gripped, "{what}");
                assert!((reached - force).abs() <= allowed(&load, truth.finger_angle, force), "{what}: {reached} N");
                assert!(most <= 1.1 * force, "{what}: {most} N on the way");
                assert!(still > 2_000 && grips <= 2, "{what}: gripped {grips} times, at rest for {still} ms");
                bench.ask::<Open>(&Which::All).unwrap();
                bench.until("open finger", 10 * SECOND, |report| report.estimate.force == [0.0; 2] && is_sound(report));
                bench.run(SECOND);
                bench.reports.clear();
            }
        }
    }
}
