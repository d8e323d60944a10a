//! Friction on a single rod against the exact elastica: clamped, without thickness, pushed by a cylinder that does not turn
//! (`tests/reference/friction-elastica.csv`, `friction-elastica-reversal.csv`).

use std::boxed::Box;

use super::Follower;
use crate::discretise::{Discretisation, Elements, Physics, Sampling, Scheme, Softness};
use crate::object::{Motion, ObjectDesign};
use crate::topology::Role;

crate::fixed_size!(
    /// One rod of 256 elements with 16 samples each, and another that carries nothing: the force goes with the cube of the contact's
    /// place, which is that of a sample.
    Rod, cells 1, nodes 1100, samples 4200, contacts 41, friction
);

/// Length to the cylinder's height, mm, and bending stiffness, N·mm².
const LENGTH: f64 = 80.0;
const STIFFNESS: f64 = 49.5 * 20.0 * 8.0 / 12.0;

/// A rod that reaches a quarter beyond the cylinder's height.
fn rod(coefficient: f64) -> Box<Follower<f64, Rod>> {
    let mut design = crate::design::ladder_80();
    crate::design::tests::set_heights(&mut design, 0);
    design.front.tip[1] = 1.25 * LENGTH;
    design.back.tip[1] = 1.25 * LENGTH;
    let how = Discretisation {
        scheme: Scheme::Simpson,
        elements: Elements::PerBeam { beam: 256, hinge: 1 },
        sampling: Sampling::PerElement(16),
        softness: Softness::Fixed(1e-5),
        physics: Physics::Paper,
    };
    let mut follower: Box<Follower<f64, Rod>> = Box::new(Follower::EMPTY);
    follower.configure(&design, &how).expect("a valid design");
    // The back beam carries nothing, and the front beam has no thickness.
    let model = &mut follower.model;
    let back = model.topology.find(Role::Back(0)).expect("a back beam");
    model.topology.members[back].compliance = [1e12; 2];
    for coupling in &mut model.coupling[model.topology.members[back].nodes()] {
        *coupling = coupling.map(|entry| 1e-9 * entry);
    }
    model.complete_stiffness();
    for sample in &mut model.samples {
        sample.half_thickness = 0.0;
    }
    let radius = 0.2 * LENGTH;
    let object = ObjectDesign::Circle { centre: [radius, LENGTH], radius };
    follower.set_object(object, Motion::Translating { direction: [1.0, 0.0] });
    follower.set_friction(coefficient).expect("a coefficient in range");
    assert!(follower.start(-0.5));
    follower
}

/// Normal and tangential force in units of EI/L² at a distance in units of L.
fn forces(follower: &mut Follower<f64, Rod>, distance: f64) -> [f64; 2] {
    let outcome = follower.follow(distance * LENGTH);
    assert!(outcome.status.is_trustworthy(), "{distance}: {outcome:?}");
    let sum =
        follower.solution().contacts().fold([0.0; 2], |[n, t], contact| [n + contact.force, t + contact.tangential]);
    sum.map(|force| force * LENGTH * LENGTH / STIFFNESS)
}

/// Coefficient, distance, normal and tangential force of the lines of a file, and whether they stick.
fn rows(text: &str, [distance, normal, tangential]: [usize; 3]) -> impl Iterator<Item = (f64, f64, [f64; 2], bool)> {
    text.lines().skip(1).map(move |line| {
        let number = |column: usize| line.split(',').nth(column).and_then(|x| x.parse().ok()).expect("a number");
        (number(1), number(distance), [number(normal), number(tangential)], line.ends_with("stick"))
    })
}

#[test]
fn a_rod_that_slips_is_the_elastica() {
    let text = include_str!("../../../tests/reference/friction-elastica.csv");
    let (mut follower, mut coefficient, mut worst) = (rod(0.0), 0.0, 0.0_f64);
    for (m, distance, exact, _) in rows(text, [3, 4, 5]) {
        if m != coefficient {
            (follower, coefficient) = (rod(m), m);
        }
        let found = forces(&mut follower, distance);
        let off = (found[0] - exact[0]).hypot(found[1] - exact[1]) / exact[0].hypot(exact[1]);
        worst = worst.max(off);
        assert!(off < 1e-3, "m {m} at {distance}: {found:?} for {exact:?}");
    }
    std::println!("slip: worst {worst:.1e}");
}

#[test]
fn a_rod_that_turns_round_sticks_as_the_elastica_does() {
    let text = include_str!("../../../tests/reference/friction-elastica-reversal.csv");
    let (mut follower, mut coefficient, mut worst, mut stuck) = (rod(0.0), 0.0, 0.0_f64, 0);
    for (m, distance, exact, sticks) in rows(text, [2, 3, 4]) {
        if m != coefficient {
            (follower, coefficient) = (rod(m), m);
        }
        let found = forces(&mut follower, distance);
        let off = (found[0] - exact[0]).hypot(found[1] - exact[1]) / exact[0].hypot(exact[1]);
        worst = worst.max(off);
        stuck += u32::from(sticks);
        assert!(off < 5e-3, "m {m} at {distance}: {found:?} for {exact:?}");
    }
    std::println!("reversal: worst {worst:.1e}, {stuck} rows stick");
    assert!(stuck > 3, "{stuck}");
}
