//! What must hold for any finger on any circle along any path: balance of the whole finger, the torque identity, independence of
//! where the finger stands and of the units of length and force.

use model_core::design::{Attachments, Design, Profile};
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::random_designs::Random;
use model_core::size::Paper;
use model_core::status::Status;
use reference_tests::random::{Case, Cases};

type Solver = Box<Follower<f64, Paper>>;

const PHYSICS: [Physics; 2] = [Physics::Paper, Physics::Extended];
const CASES: usize = 60;

fn solver(design: &Design, how: &Discretisation, object: ObjectDesign) -> Solver {
    let mut follower: Solver = Box::new(Follower::EMPTY);
    follower.configure(design, how).expect("a valid design");
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    follower
}

/// Sum of the forces on the finger, N, and of their moments about the finger frame's origin, N·mm: base and contacts.
fn imbalance(follower: &Solver, design: &Design) -> ([f64; 2], f64, f64) {
    let (mut force, mut moment, mut size) = ([0.0; 2], 0.0, 0.0);
    let mut add = |at: [f64; 2], f: [f64; 2]| {
        force = [force[0] + f[0], force[1] + f[1]];
        moment += at[0] * f[1] - at[1] * f[0];
        size += f[0].hypot(f[1]);
    };
    for contact in follower.solution().contacts() {
        add(contact.position, contact.normal.map(|n| n * contact.force));
    }
    let reactions = follower.solution().base_reactions();
    add(design.front.base, reactions[0].0);
    add(design.back.base, reactions[1].0);
    (force, moment + reactions[0].1 + reactions[1].1, size)
}

#[test]
fn base_and_contacts_hold_the_finger_in_balance() {
    for physics in PHYSICS {
        let mut checked = 0;
        for (number, case) in Cases::seeded(41).take(CASES).enumerate() {
            let mut follower = solver(&case.design, &Discretisation::reduced(physics), case.object());
            assert!(follower.start(case.angle));
            if follower.follow(case.angle).status.is_trustworthy() && follower.solution().touching() > 0 {
                let (force, moment, size) = imbalance(&follower, &case.design);
                let what = format!("{physics:?}, case {number}: {force:?} N, {moment} N·mm of {size} N");
                assert!(force[0].hypot(force[1]) < 1e-10 * size && moment.abs() < 1e-8 * (1.0 + 80.0 * size), "{what}");
                checked += 1;
            }
        }
        assert!(checked > CASES * 9 / 10, "{checked} of {CASES}");
    }
}

/// V + ½ ε Σ μ².
fn potential(follower: &Solver) -> f64 {
    let softness = follower.softness();
    follower.solution().energy()
        + follower.solution().contacts().map(|c| 0.5 * softness * c.force * c.force).sum::<f64>()
}

/// Along a path of random turns, closing and opening, the motor's work is the change of the potential: Simpson's rule on every
/// leg that crosses no change of contact and no snap.
#[test]
fn the_motor_does_the_work_along_random_paths() {
    for physics in PHYSICS {
        let how = Discretisation::reduced(physics);
        let mut numbers = Random::new(43);
        let (mut legs, mut worst) = (0, 0.0_f64);
        for case in Cases::seeded(43).take(CASES) {
            let mut follower = solver(&case.design, &how, case.object());
            assert!(follower.start(case.angle));
            for _ in 0..20 {
                let from = case.touch + numbers.unit() * (case.angle - case.touch);
                let step = (numbers.unit() - 0.5) * 0.1_f64.to_radians();
                let mut points = Vec::new();
                for k in 0..3 {
                    let status = follower.follow(from + f64::from(k) * step).status;
                    let touching: Vec<u64> = follower.solution().contacts().map(|c| c.arc.to_bits()).collect();
                    points.push((status, touching, follower.solution().motor_torque(), potential(&follower)));
                }
                let [a, m, b] = [&points[0], &points[1], &points[2]];
                let smooth = points.iter().all(|p| p.0 == Status::Converged && p.1 == a.1);
                // Far from a fold: the torque hardly curves, so the rule's own error is small.
                let bent = (a.2 - 2.0 * m.2 + b.2).abs() > 1e-3 * m.2.abs();
                if !smooth || bent {
                    continue;
                }
                let work = step / 3.0 * (a.2 + 4.0 * m.2 + b.2);
                let error = (work - (b.3 - a.3)).abs() / (work.abs() + 1e-6);
                assert!(error < 1e-4, "{physics:?}: work {work}, potential {}", b.3 - a.3);
                (legs, worst) = (legs + 1, worst.max(error));
            }
        }
        println!("{physics:?}: {legs} legs, work and potential within {worst:.1e}");
        assert!(legs > 4 * CASES, "{legs} legs");
    }
}

/// The same finger elsewhere: turned by an angle and moved, object and motor axis with it.
fn moved(case: &Case, angle: f64, by: [f64; 2]) -> (Design, ObjectDesign) {
    let (s, c) = angle.sin_cos();
    let place = |p: [f64; 2]| [c * p[0] - s * p[1] + by[0], s * p[0] + c * p[1] + by[1]];
    let mut design = case.design.clone();
    let arcs = |side: usize| (0..design.lamella_count()).map(|k| design.attachment_arcs(k)[side]).collect();
    design.lamellae.attachments = Attachments::Arcs { front: arcs(0), back: arcs(1) };
    for beam in [&mut design.front, &mut design.back] {
        (beam.base, beam.tip) = (place(beam.base), place(beam.tip));
    }
    design.motor_axis = place(design.motor_axis);
    (design, ObjectDesign::Circle { centre: place(case.centre), radius: case.radius })
}

#[test]
fn where_the_finger_stands_changes_nothing() {
    for physics in PHYSICS {
        let how = Discretisation::reduced(physics);
        let mut checked = 0;
        for (number, case) in Cases::seeded(47).take(CASES).enumerate() {
            let turn = 0.3;
            let (design, object) = moved(&case, turn, [12.0, -7.0]);
            let mut here = solver(&case.design, &how, case.object());
            let mut there = solver(&design, &how, object);
            assert!(here.start(case.angle) && there.start(case.angle));
            let [a, b] = [&mut here, &mut there].map(|follower| follower.follow(case.angle).status);
            if a != Status::Converged || b != Status::Converged {
                continue;
            }
            let [x, y] = here.solution().force_world();
            let (s, c) = turn.sin_cos();
            let expected = [c * x - s * y, s * x + c * y];
            for i in 0..2 {
                let off = there.solution().force_world()[i] - expected[i];
                assert!(off.abs() < 1e-6 * (1.0 + x.hypot(y)), "{physics:?}, case {number}: off by {off} N");
            }
            assert!(
                (there.solution().energy() - here.solution().energy()).abs() < 1e-6 * (1.0 + here.solution().energy()),
                "case {number}: energy"
            );
            checked += 1;
        }
        assert!(checked > CASES * 8 / 10, "{checked} of {CASES}");
    }
}

/// Lengths s times as large and E e times as large: forces e s² times, energies e s³ times, angles the same.
#[test]
fn scaling_length_and_modulus_scales_force_and_energy() {
    const S: f64 = 1.25;
    const E: f64 = 3.0;
    for physics in PHYSICS {
        let how = Discretisation::reduced(physics);
        let mut checked = 0;
        for (number, case) in Cases::seeded(53).take(CASES).enumerate() {
            let mut design = case.design.clone();
            let scale = |p: [f64; 2]| p.map(|x| S * x);
            for beam in [&mut design.front, &mut design.back] {
                (beam.base, beam.tip) = (scale(beam.base), scale(beam.tip));
                beam.thickness = Profile::constant(S * beam.thickness.at(0.0));
            }
            design.width = Profile::constant(S * design.width.at(0.0));
            if let Attachments::Heights(heights) = &mut design.lamellae.attachments {
                heights.iter_mut().for_each(|height| *height *= S);
            }
            design.lamellae.thickness.iter_mut().flatten().for_each(|thickness| *thickness *= S);
            design.hinge.length.iter_mut().for_each(|length| *length *= S);
            design.hinge.thickness *= S;
            design.motor_axis = scale(design.motor_axis);
            design.material.youngs_modulus *= E;
            let object = ObjectDesign::Circle { centre: scale(case.centre), radius: S * case.radius };
            let mut small = solver(&case.design, &how, case.object());
            let mut large = solver(&design, &how, object);
            assert!(small.start(case.angle) && large.start(case.angle));
            let [a, b] = [&mut small, &mut large].map(|follower| follower.follow(case.angle).status);
            if a != Status::Converged || b != Status::Converged {
                continue;
            }
            let size = small.solution().force_world()[0].hypot(small.solution().force_world()[1]);
            for i in 0..2 {
                let off = large.solution().force_world()[i] / (E * S * S) - small.solution().force_world()[i];
                assert!(off.abs() < 1e-6 * (1.0 + size), "{physics:?}, case {number}: off by {off} N");
            }
            let off = large.solution().energy() / (E * S * S * S) - small.solution().energy();
            assert!(
                off.abs() < 1e-6 * (1.0 + small.solution().energy()),
                "{physics:?}, case {number}: off by {off} N·mm"
            );
            checked += 1;
        }
        assert!(checked > CASES * 8 / 10, "{checked} of {CASES}");
    }
}
