//! Random fingers of every scale: 4 mm to 2 m long, of 0.1 MPa to 210 GPa, tapered or not, with every kind of hinge and widths over a
//! factor of 10, each with a circle of its own size in front of it.

extern crate std;

use heapless::Vec;
use model_core::design::{
    Attachments, Beam, Design, Hinge, HingeFrom, HingeKind, Lamellae, Material, MaterialLaw, PlaneStrain, Profile,
};
use model_core::object::ObjectDesign;
use model_core::random_designs::Random;

/// A finger, a circle in front of it and a motor angle that presses them together.
#[derive(Clone, Debug)]
pub struct WideCase {
    /// The finger.
    pub design: Design,
    /// The circle's centre, world frame, mm.
    pub centre: [f64; 2],
    /// Its radius, mm: a tenth of the finger's length to twice that.
    pub radius: f64,
    /// Motor angle to close to, rad: up to 10° from where the circle lies clear of the finger.
    pub angle: f64,
}

impl WideCase {
    /// The circle.
    pub fn object(&self) -> ObjectDesign {
        ObjectDesign::Circle { centre: self.centre, radius: self.radius }
    }
}

/// Draws cases without end.
pub struct WideCases(Random);

impl WideCases {
    /// The cases of a seed.
    pub fn seeded(seed: u64) -> Self {
        Self(Random::new(seed))
    }
}

/// Between two positive numbers, uniform in the logarithm.
fn between(random: &mut Random, least: f64, most: f64) -> f64 {
    least * libm::pow(most / least, random.unit())
}

/// One of several.
fn one_of<X: Copy, const N: usize>(random: &mut Random, of: [X; N]) -> X {
    of[(random.unit() * N as f64) as usize % N]
}

/// A thickness along a beam of this length: constant, or a taper of up to three knots over a factor of up to seven.
fn taper(random: &mut Random, length: f64, typical: f64) -> Profile {
    if random.unit() < 0.5 {
        return Profile::constant(typical);
    }
    let ends = [0.0, length].map(|arc| [arc, typical * between(random, 0.38, 2.6)]);
    let arc = length * (0.05 + 0.9 * random.unit());
    let mut knots = Vec::from_iter(ends);
    if random.unit() < 0.5 {
        // A short thin or thick end.
        let _ = knots.insert(1, [arc, typical * between(random, 0.38, 2.6)]);
    }
    Profile { knots }
}

impl Iterator for WideCases {
    type Item = WideCase;

    fn next(&mut self) -> Option<WideCase> {
        let random = &mut self.0;
        loop {
            let length = between(random, 4.0, 2000.0);
            let typical = length * between(random, 0.012, 0.045);
            let other = typical * between(random, 0.6, 1.6);
            let beam = |base: [f64; 2], thickness: Profile, stiffness_factor| Beam {
                stiffness_factor,
                ..Beam::straight(base, [0.0, length], thickness)
            };
            let front = taper(random, length, typical);
            let back = taper(random, length, other);
            let count = 3 + (5.0 * random.unit()) as usize;
            let pitch = 0.72 * length / count as f64;
            let heights = (1..=count).map(|k| pitch * (k as f64 + 0.3 * (random.unit() - 0.5))).collect();
            let width = length * between(random, 0.05, 0.5);
            let width = if random.unit() < 0.7 {
                Profile::constant(width)
            } else {
                Profile { knots: Vec::from_iter([[0.0, width], [length, width * between(random, 0.4, 1.0)]]) }
            };
            let design = Design {
                width,
                plane_strain: one_of(random, [PlaneStrain::Stress, PlaneStrain::Strain, PlaneStrain::Auto]),
                material: Material {
                    youngs_modulus: between(random, 0.1, 210e3),
                    poissons_ratio: 0.49 * random.unit(),
                    law: one_of(random, [MaterialLaw::StVenantKirchhoff, MaterialLaw::NeoHookean, MaterialLaw::Linear]),
                },
                front: beam([0.0, 0.0], front, 1.0),
                back: beam([-length * between(random, 0.22, 0.5), 0.0], back, between(random, 0.5, 2.0)),
                lamellae: Lamellae::rigid(Attachments::Heights(heights), 1.5 * typical),
                hinge: Hinge {
                    kind: one_of(
                        random,
                        [HingeKind::Flexible, HingeKind::Flexible, HingeKind::Pinned, HingeKind::Welded],
                    ),
                    length: Vec::from_iter([(length * between(random, 0.0005, 0.03)).max(0.01)]),
                    thickness: (typical * between(random, 0.2, 1.2)).max(0.01),
                    from: one_of(random, [HingeFrom::Centreline, HingeFrom::Face]),
                },
                rigid_above: (random.unit() < 0.4).then_some(length * (0.88 + 0.08 * random.unit())),
                motor_axis: [-length * 0.3 * random.unit(), -length * 0.4 * random.unit()],
            };
            let radius = length * between(random, 0.1, 2.0);
            let thickest = design.front.thickness.knots.iter().fold(0.0_f64, |most, knot| most.max(knot[1]));
            let centre = [radius + 0.5 * thickest + 0.02 * length, length * (0.35 + 0.45 * random.unit())];
            let angle = (2.0 + 8.0 * random.unit()).to_radians();
            if design.validate().is_ok() {
                return Some(WideCase { design, centre, radius, angle });
            }
        }
    }
}
