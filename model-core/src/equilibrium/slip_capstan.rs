//! Friction on a strip that is pulled over a cylinder, against the capstan with thickness.
//!
//! A strip of thickness h, bent round a cylinder, slips on its surface, not on its centreline: the friction's moment is held by a shear force. The
//! force in the strip keeps its angle to it, and grows with the angle φ by which it turns as
//!
//! > e^{kφ}, k = m (1 − a) / (1 + a m k), a = h / (2 r), r the radius of the centreline.

use std::boxed::Box;

use super::Follower;
use crate::discretise::{Discretisation, Elements, Physics, Sampling, Scheme, Softness};
use crate::object::{Motion, ObjectDesign};
use crate::topology::Role;

crate::fixed_size!(
    /// A strip of 160 elements.
    Strip, cells 1, nodes 700, samples 700, contacts 161, friction
);

const RADIUS: f64 = 10.0;
const THICKNESS: f64 = 2.0;
const LENGTH: f64 = 70.0;

/// Force at the held end over that at the pulled one, and the angle between them, rad.
fn pulled(coefficient: f64, wrap: f64) -> [f64; 2] {
    let mut design = crate::design::ladder_80();
    crate::design::tests::set_heights(&mut design, 0);
    (design.front.tip[1], design.back.tip[1]) = (LENGTH, LENGTH);
    let how = Discretisation {
        scheme: Scheme::Simpson,
        elements: Elements::PerBeam { beam: 160, hinge: 1 },
        sampling: Sampling::PerElement(1),
        softness: Softness::Fixed(1e-5),
        physics: Physics::Paper,
    };
    let mut follower: Box<Follower<f64, Strip>> = Box::new(Follower::EMPTY);
    follower.configure(&design, &how).expect("a valid design");
    // The back beam carries nothing, and the front beam hardly bends.
    let model = &mut follower.model;
    let back = model.topology.find(Role::Back(0)).expect("a back beam");
    model.topology.members[back].compliance = [1e12; 2];
    for coupling in &mut model.coupling[model.topology.members[back].nodes()] {
        *coupling = coupling.map(|entry| 1e-9 * entry);
    }
    let front = model.topology.find(Role::Front(0)).expect("a front beam");
    for coupling in &mut model.coupling[model.topology.members[front].nodes()] {
        *coupling = coupling.map(|entry| 1e-3 * entry);
    }
    model.complete_stiffness();
    let centre = [RADIUS + 0.5 * THICKNESS + 0.2, 12.0];
    // The base goes down and pulls the strip along.
    follower
        .set_object(ObjectDesign::Circle { centre, radius: RADIUS }, Motion::Translating { direction: [0.0, -1.0] });
    follower.set_friction(coefficient).expect("a coefficient in range");
    assert!(follower.start(0.0));
    let (load, steps) = (2.0, 400);
    let mut at = 0.0;
    for step in 0..=steps {
        let angle = core::f64::consts::FRAC_PI_2 - wrap * f64::from(step) / f64::from(steps);
        follower.set_dead_load(9, [load * libm::cos(angle), load * libm::sin(angle)]);
        at += 1e-3;
        let outcome = follower.follow(at);
        assert!(outcome.status.is_trustworthy(), "wrap {angle}: {outcome:?}");
    }
    for _ in 0..20 {
        at += 0.02;
        assert!(follower.follow(at).status.is_trustworthy());
    }
    assert!(
        follower.solution().contacts().all(|contact| contact.tangential.abs() > 0.999 * coefficient * contact.force)
    );
    let ([x, y], _) = follower.solution().base_reactions()[0];
    let end = core::f64::consts::FRAC_PI_2 - wrap;
    [libm::hypot(x, y) / load, libm::atan2(-y, -x) - end]
}

#[test]
fn a_strip_is_pulled_over_a_cylinder_as_over_a_capstan() {
    for (coefficient, wrap) in [(0.3, 2.2), (0.6, 1.5)] {
        let [ratio, turned] = pulled(coefficient, wrap);
        let a = 0.5 * THICKNESS / (RADIUS + 0.5 * THICKNESS);
        let mut k = coefficient;
        for _ in 0..50 {
            k = coefficient * (1.0 - a) / (1.0 + a * coefficient * k);
        }
        let exact = libm::exp(k * turned);
        std::println!("m {coefficient}: {ratio:.4} for {exact:.4} over {turned:.3} rad");
        assert!((ratio / exact - 1.0).abs() < 1e-3, "{ratio} {exact}");
        assert!(libm::exp(coefficient * turned) / ratio > 1.05, "not that of a strip without thickness");
    }
}
