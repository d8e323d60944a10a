//! Coulomb friction against finite elements (`friction.csv`), closing and opening, and the work that a loop takes.
//!
//! The finite elements' forces are reduced by 0.95 %, which is what halving their mesh does. Opening begins with a reversal in which a part
//! of the patch sticks; there the force turns round within a degree, and a difference of angles or of the softness along the object shows as
//! one of the force's direction.

use model_core::design::Design;
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::{Follower, SlipWay};
use model_core::object::{Motion, ObjectDesign};
use model_core::random_designs::Random;
use model_core::real::Real;
use model_core::size::{Reduced, Rubbing, Size};
use model_core::status::Status;
use reference_tests::fea_80;
use reference_tests::friction::friction_rows;

model_core::fixed_size!(
    /// The resolution `fine`, with friction.
    Fine, cells 13, nodes 704, samples 184, contacts 81, friction
);

/// A halved mesh is softer by this part.
const MESH: f64 = 0.9905;

fn closing<T: Real, S: Size>(
    design: &Design,
    how: &Discretisation,
    object: ObjectDesign,
    coefficient: f64,
) -> Box<Follower<T, S>> {
    let mut follower: Box<Follower<T, S>> = Box::new(Follower::EMPTY);
    follower.configure(design, how).expect("a valid design");
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    follower.set_friction(coefficient).expect("a coefficient in range");
    assert!(follower.start(0.0));
    follower
}

/// Σ|τ| over m Σμ; 0 without friction.
fn mobilised<T: Real, S: Size>(follower: &Follower<T, S>, coefficient: f64) -> f64 {
    let (push, along) = follower.solution().contacts().fold((0.0, 0.0), |(push, along), contact| {
        (push + contact.force.to_f64(), along + contact.tangential.to_f64().abs())
    });
    if coefficient * push > 0.0 { along / (coefficient * push) } else { 0.0 }
}

/// Differences are counted for at least this force and torque, N and N·mm: below them rounding of the file and first contact decide.
const LEAST: [f64; 2] = [0.3, 10.0];

/// `share_within`: of the mobilised share where a part sticks, which a coarse row of samples resolves badly.
fn compare<T: Real, S: Size>(how: &Discretisation, share_within: f64) {
    let design = fea_80();
    let mut follower: Box<Follower<T, S>> = Box::new(Follower::EMPTY);
    let (mut series, mut partly, mut rows) = (("", -1.0), 0, 0);
    for row in friction_rows() {
        if series != (row.case, row.coefficient) {
            series = (row.case, row.coefficient);
            follower = closing(&design, how, row.object(), row.coefficient);
        }
        let outcome = follower.follow(row.degrees.to_radians());
        let [x, y] = follower.solution().force_world().map(Real::to_f64);
        let [fx, fy] = row.force.map(|part| MESH * part);
        let size = MESH * row.magnitude;
        let (force, vector) = (x.hypot(y) / size - 1.0, (x - fx).hypot(y - fy));
        let torque = follower.solution().motor_torque().to_f64() / (MESH * row.torque) - 1.0;
        let share = mobilised(&follower, row.coefficient);
        let way = if row.opens { "opening" } else { "closing" };
        println!(
            "{} m {} {way} {:5}° {:10} {} its, |F| {:+5.2} %, vector {:5.3} N, torque {:+5.2} %, mobilised {:.3} for {:.3}",
            row.case,
            row.coefficient,
            row.degrees,
            outcome.status.word(),
            outcome.iterations,
            100.0 * force,
            vector,
            100.0 * torque,
            share,
            row.mobilised
        );
        assert!(matches!(outcome.status, Status::Converged | Status::NoContact), "{row:?}: {outcome:?}");
        if size < LEAST[0] || row.torque < LEAST[1] {
            continue;
        }
        rows += 1;
        let sticks = row.coefficient > 0.0 && row.sticking > 0.0;
        if sticks {
            partly += 1;
            assert!(vector < (0.04 * size).max(0.1), "{row:?}: {x} {y}");
            assert!((share - row.mobilised).abs() < share_within, "{row:?}: {share}");
        } else {
            assert!(force.abs() < if row.opens { 0.025 } else { 0.015 }, "{row:?}: {x} {y}");
            assert!(row.coefficient == 0.0 || (share - row.mobilised).abs() < 0.5 * share_within, "{row:?}: {share}");
        }
        assert!(torque.abs() < 0.03, "{row:?}: {}", follower.solution().motor_torque().to_f64());
    }
    assert!(rows > 240 && partly > 8, "{rows} rows, {partly} of them partly stick");
}

#[test]
fn fine_f64_agrees_with_finite_elements() {
    compare::<f64, Fine>(&Discretisation::fine(Physics::Extended), 0.1);
}

#[test]
fn reduced_f32_agrees_with_finite_elements() {
    compare::<f32, Rubbing>(&Discretisation::estimator(Physics::Extended), 0.25);
}

/// Where the past is unknown, normal force and torque lie between those of closing slip and of opening slip.
#[test]
fn random_pasts_lie_between_closing_slip_and_opening_slip() {
    let how = Discretisation::fine(Physics::Extended);
    let mut random = Random::new(19);
    let (mut inside, mut sticking) = (0, 0);
    for (coefficient, height) in [(0.3, 45.0), (0.6, 45.0), (0.3, 30.0), (0.6, 30.0)] {
        let object = ObjectDesign::Circle { centre: [41.0, height], radius: 40.0 };
        let found = |follower: &Follower<f64, Fine>| {
            [
                follower.solution().contacts().map(|contact| contact.force).sum::<f64>(),
                follower.solution().motor_torque(),
            ]
        };
        let mut follower = closing::<f64, Fine>(&fea_80(), &how, object, coefficient);
        let bounds = [SlipWay::Closing, SlipWay::Opening].map(|way| {
            follower.force_slip(Some(way));
            assert!(follower.start(0.0));
            assert_eq!(follower.follow(8.0_f64.to_radians()).status, Status::Converged);
            assert!((mobilised(&follower, coefficient) - 1.0).abs() < 1e-9);
            found(&follower)
        });
        follower.force_slip(None);
        for _ in 0..25 {
            assert!(follower.start(0.0));
            // Back and forth between 4 and 10°, and by less and less around 8°.
            let mut wide = 2.0 + 2.0 * random.unit();
            for turn in 0..6 {
                let side = if turn % 2 == 0 { wide.min(2.0) } else { -wide };
                assert!(follower.follow((8.0 + side * random.unit()).to_radians()).status.is_trustworthy());
                wide *= 0.3 + 0.6 * random.unit();
            }
            assert_eq!(follower.follow(8.0_f64.to_radians()).status, Status::Converged);
            sticking += u32::from(mobilised(&follower, coefficient) < 0.99);
            for (k, value) in found(&follower).into_iter().enumerate() {
                let [low, high] = [bounds[0][k].min(bounds[1][k]), bounds[0][k].max(bounds[1][k])];
                let slack = 0.01 * high;
                assert!(
                    (low - slack..=high + slack).contains(&value),
                    "m {coefficient}: {value} outside of {low} to {high}"
                );
                inside += 1;
            }
        }
        println!("m {coefficient}, {height} mm: closing slip {:.3?}, opening slip {:.3?}", bounds[0], bounds[1]);
    }
    println!("{inside} inside, {sticking} of 100 pasts partly stick");
    assert!(sticking > 25, "{sticking}");
}

/// What friction costs at one count per step, in iterations, and where friction has room but the coefficient is zero: nothing.
#[test]
fn friction_takes_few_more_iterations() {
    fn iterations<S: Size>(coefficient: f64) -> (f64, u32, Vec<[u32; 2]>) {
        let design = reference_tests::ladder_80();
        let how = Discretisation::estimator(Physics::Extended);
        let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
        let mut follower = closing::<f32, S>(&design, &how, object, coefficient);
        let (mut spent, mut ticks, mut most, mut forces) = (0, 0, 0, Vec::new());
        for count in (0..=125).chain((0..125).rev()) {
            let outcome = follower.follow(f64::from(count) * reference_tests::COUNT);
            assert!(outcome.status.is_trustworthy(), "count {count}: {outcome:?}");
            if follower.solution().touching() > 0 {
                (spent, ticks, most) = (spent + outcome.iterations, ticks + 1, most.max(outcome.iterations));
            }
            forces.push(follower.solution().force_world().map(f32::to_bits));
        }
        (f64::from(spent) / f64::from(ticks), most, forces)
    }
    let (without, with_room, rubbing) =
        (iterations::<Reduced>(0.0), iterations::<Rubbing>(0.0), iterations::<Rubbing>(0.6));
    println!(
        "iterations, mean and most: {:?} without, {:?} with friction",
        (without.0, without.1),
        (rubbing.0, rubbing.1)
    );
    assert!(without == with_room, "room for friction changes nothing");
    assert!(rubbing.0 < 1.25 && rubbing.1 <= 3, "{} {}", rubbing.0, rubbing.1);
}

/// ∮ τ dα = ΔV + dissipation: closing and opening, the torque with the true points of action.
#[test]
fn a_loops_work_is_what_friction_dissipates() {
    for (coefficient, height) in [(0.3, 45.0), (0.6, 30.0), (1.0, 45.0)] {
        let object = ObjectDesign::Circle { centre: [41.0, height], radius: 40.0 };
        let mut follower =
            closing::<f64, Fine>(&fea_80(), &Discretisation::fine(Physics::Extended), object, coefficient);
        let (mut work, mut before, mut at) = (0.0, 0.0, 0.0);
        let steps = 4000;
        for step in (0..=steps).chain((0..steps).rev()) {
            let outcome = follower.follow((8.0 * f64::from(step) / f64::from(steps)).to_radians());
            assert!(outcome.status.is_trustworthy(), "{outcome:?}");
            let torque = follower.solution().motor_torque();
            work += 0.5 * (torque + before) * (follower.solution().coordinate() - at);
            (before, at) = (torque, follower.solution().coordinate());
            if step == steps {
                // Half-way: what was not dissipated is stored.
                let stored = follower.solution().potential();
                let missing = work - stored - follower.solution().dissipated();
                println!("m {coefficient}: half-way {work:.5} N·mm, stored {stored:.5}, missing {missing:.6}");
                assert!(missing.abs() < 1e-4 * work, "{missing}");
            }
        }
        let missing = work - follower.solution().potential() - follower.solution().dissipated();
        println!("m {coefficient}: loop {work:.5} N·mm, dissipated {:.5}", follower.solution().dissipated());
        assert!(work > 1.0 && missing.abs() < 1e-4 * work, "{work} {missing}");
    }
}
