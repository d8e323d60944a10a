//! Random fingers on random circles, the same ones for the same seed: what tests and benches draw their cases from.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use crate::design::{Attachments, Design, Profile, ladder_80};

/// A stream of random numbers (ChaCha8).
pub struct Random(ChaCha8Rng);

impl Random {
    /// The stream of a seed.
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Uniform in 0 … 1.
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in −1 … 1.
    #[cfg(test)]
    pub(crate) fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Within ±30 %.
    fn about(&mut self, value: f64) -> f64 {
        value * (0.7 + 0.6 * self.unit())
    }
}

/// A circle's centre and radius, mm.
#[derive(Clone, Copy, Debug)]
pub struct Round {
    /// Centre in the world frame, mm.
    pub centre: [f64; 2],
    /// Radius, mm.
    pub radius: f64,
}

/// A finger, a circle in front of it and an indentation, rad: geometry of `ladder-80` ±30 %, 3 to 9 uneven lamellae, radius 10 to
/// 60 mm, indentation 2 to 20°.
pub fn random_case(random: &mut Random) -> (Design, Round, f64) {
    loop {
        let mut design = ladder_80();
        let height = random.about(80.0);
        design.front.tip = [0.0, height];
        design.back.tip = [0.0, height];
        design.back.base = [random.about(-28.0), 0.0];
        design.front.thickness = Profile::constant(random.about(2.0));
        design.back.thickness = Profile::constant(random.about(2.0));
        design.width = Profile::constant(random.about(20.0));
        design.hinge.length = heapless::Vec::from_iter([random.about(2.5)]);
        design.hinge.thickness = random.about(0.8);
        let count = 3 + (7.0 * random.unit()) as usize;
        let pitch = 0.7 * height / count as f64;
        let heights = (1..=count).map(|k| pitch * (k as f64 + 0.3 * (random.unit() - 0.5))).collect();
        design.lamellae.attachments = Attachments::Heights(heights);
        design.material.youngs_modulus = random.about(49.5);
        design.motor_axis = [random.about(-14.0), random.about(-20.0)];
        let radius = 10.0 + 50.0 * random.unit();
        let centre =
            [radius + 0.5 * design.front.thickness.at(0.0) + 3.0 * random.unit(), height * (0.3 + 0.5 * random.unit())];
        let indentation = (2.0 + 18.0 * random.unit()).to_radians();
        if design.validate().is_ok() {
            return (design, Round { centre, radius }, indentation);
        }
    }
}

/// Angle at which the undeformed front beam's surface, or its tip, first touches the circle when closing from −30°.
pub fn first_contact(design: &Design, centre: [f64; 2], radius: f64) -> f64 {
    let half = 0.5 * design.front.thickness.at(0.0);
    let mut angle = -30.0_f64.to_radians();
    loop {
        let (s, c) = angle.sin_cos();
        let arm = [centre[0] - design.motor_axis[0], centre[1] - design.motor_axis[1]];
        let x = design.motor_axis[0] + c * arm[0] - s * arm[1];
        let y = design.motor_axis[1] + s * arm[0] + c * arm[1];
        let beyond = y.clamp(0.0, design.front.length()) - y;
        if x.hypot(beyond) <= radius + half {
            return angle;
        }
        angle += 1e-4;
    }
}
