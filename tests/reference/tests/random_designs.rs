//! Two thousand random fingers on random objects, each converged equilibrium checked by code of its own.

use std::collections::BTreeMap;

use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::{Follower, Settings};
use model_core::object::Motion;
use model_core::size::Paper;
use model_core::status::Status;
use reference_tests::random::{Case, Cases, centre_in_finger};

type Solver = Follower<f64, Paper>;

fn solve(follower: &mut Solver, case: &Case, how: &Discretisation, max_step: f64) -> Status {
    follower.configure(&case.design, how).expect("a valid design");
    follower
        .set_settings(Settings { max_angle_step: max_step.to_radians(), ..Settings::DEFAULT })
        .expect("an allowed step");
    follower.set_object(case.object(), Motion::Rotating { axis: case.design.motor_axis });
    if !follower.start(case.angle) {
        return Status::OutOfRange;
    }
    follower.follow(case.angle).status
}

/// What an equilibrium must satisfy, computed from the shape and the forces that the solver reports.
fn check(follower: &mut Solver, case: &Case) -> Result<(), String> {
    let softness = follower.softness();
    let Case { design, radius, .. } = case;
    let (angle, m) = (follower.coordinate(), design.motor_axis);
    let centre = centre_in_finger(design, case.centre, angle);
    let half = 0.5 * design.front.thickness.at(0.0);
    let fail = |what: &str, value: f64| Err(format!("{what}: {value:e}"));

    let give = 0.2 + softness * follower.contacts().fold(0.0_f64, |most, c| most.max(c.force));
    // The clamped base itself is no contact sample: it cannot give way.
    for point in follower.front().skip(1) {
        let gap = (point[0] - centre[0]).hypot(point[1] - centre[1]) - radius - half;
        if gap < -give {
            return fail("a front point lies inside the object", gap);
        }
    }
    let (mut force, mut moment) = ([0.0; 2], 0.0);
    for contact in follower.contacts() {
        let offset = [contact.position[0] - centre[0], contact.position[1] - centre[1]];
        let distance = offset[0].hypot(offset[1]);
        if contact.force < 0.0 {
            return fail("a contact pulls", contact.force);
        }
        if (distance - radius + softness * contact.force).abs() > 1e-8 {
            return fail("a contact is off the surface", distance - radius);
        }
        for i in 0..2 {
            if (contact.normal[i] - offset[i] / distance).abs() > 1e-9 {
                return fail("a force is not along the normal", contact.normal[i]);
            }
            force[i] -= contact.force * offset[i] / distance;
        }
        moment += (centre[0] - m[0]) * -contact.force * offset[1] / distance
            - (centre[1] - m[1]) * -contact.force * offset[0] / distance;
    }
    for i in 0..2 {
        if (force[i] - follower.force_finger()[i]).abs() > 1e-9 * (1.0 + force[i].abs()) {
            return fail("the net force is not the sum of the contacts", force[i]);
        }
    }
    // The beams meet at the tip, and bend no link out of length.
    let tip = follower.tip();
    let back = follower.back().last().expect("a back beam");
    if (tip[0] - back[0]).hypot(tip[1] - back[1]) > 1e-9 {
        return fail("the tip is open", tip[0] - back[0]);
    }
    for lamella in follower.lamellae() {
        let length = (lamella[1][0] - lamella[0][0]).hypot(lamella[1][1] - lamella[0][1]);
        if length > 28.0 * 1.3 || length <= 0.0 {
            return fail("a lamella has no length", length);
        }
    }
    // τ = d(V + ½ ε Σ μ²)/dα: independent of the multipliers, and only true at an equilibrium.
    let torque = follower.motor_torque();
    if (torque + moment).abs() > 1e-6 * (1.0 + moment.abs()) {
        return fail("the torque is not the force's moment", torque);
    }
    let total = |f: &Solver| f.energy() + f.contacts().map(|c| 0.5 * softness * c.force * c.force).sum::<f64>();
    let mut rates = [0.0; 2];
    for (rate, h) in rates.iter_mut().zip([2e-5, 1e-5]) {
        let mut side = [0.0; 2];
        for (energy, by) in side.iter_mut().zip([h, -h]) {
            if !follower.follow(angle + by).status.is_trustworthy() {
                return Ok(()); // The end of a branch: no derivative there.
            }
            *energy = total(follower);
        }
        *rate = (side[0] - side[1]) / (2.0 * h);
    }
    let rate = (4.0 * rates[1] - rates[0]) / 3.0;
    // A contact that opens or closes within the difference leaves a kink of first order in h.
    if (rate - torque).abs() > 1e-3 * torque.abs() + 1e-2 {
        return fail("the torque is not the energy's derivative", rate / torque - 1.0);
    }
    Ok(())
}

#[test]
fn two_thousand_random_designs() {
    let mut follower: Box<Solver> = Box::new(Follower::EMPTY);
    let reduced = Discretisation::reduced(Physics::Paper);
    let fine = Discretisation::fine(Physics::Paper);
    let mut table: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    let mut converged = 0;
    const CASES: usize = 2000;
    for (number, case) in Cases::seeded(2000).take(CASES).enumerate() {
        let status = solve(&mut follower, &case, &reduced, 1.0);
        if status.is_trustworthy() {
            converged += 1;
            *table.entry((status.word(), "")).or_default() += 1;
            if let Err(what) = check(&mut follower, &case) {
                panic!("case {number}: {what}\n{}", case.file());
            }
        } else {
            let again = solve(&mut follower, &case, &fine, 0.1);
            *table.entry((status.word(), again.word())).or_default() += 1;
            println!("case {number}: {status}, fine: {again}\n{}", case.file());
        }
    }
    for ((first, fine), count) in &table {
        println!("{count:5}  reduced, 1° steps: {first:16} fine, 0.1° steps: {fine}");
    }
    assert!(converged >= CASES * 95 / 100, "{converged} of {CASES} converged");
}
