//! Random fingers on random circles, the same ones for the same seed: what tests and benches draw their cases from.

extern crate std;

use model_core::design::{Attachments, Design};
use model_core::object::ObjectDesign;
use model_core::random_designs::{Random, Round, first_contact, random_case};
use std::string::String;

/// A finger, a circle in front of it and a motor angle that presses them together.
#[derive(Clone, Debug)]
pub struct Case {
    /// The finger: geometry of `ladder-80` ±30 %, 3 to 9 lamellae, uneven.
    pub design: Design,
    /// The circle's centre, world frame, mm.
    pub centre: [f64; 2],
    /// Its radius, 10 to 60 mm.
    pub radius: f64,
    /// Motor angle at which the undeformed front beam's surface, or its tip, touches first, rad.
    pub touch: f64,
    /// Motor angle to close to: 2 to 20° further.
    pub angle: f64,
}

impl Case {
    /// The circle.
    pub fn object(&self) -> ObjectDesign {
        ObjectDesign::Circle { centre: self.centre, radius: self.radius }
    }

    /// The case as a file for `fre solve`, to look into.
    pub fn file(&self) -> String {
        let design = &self.design;
        let Attachments::Heights(heights) = &design.lamellae.attachments else { return String::new() };
        std::format!(
            "[finger]\nwidth_mm = {:?}\nplane_strain = \"stress\"\n\n[finger.material]\nyoungs_modulus_pa = {:?}\n\
             poissons_ratio = {:?}\n\n[finger.front]\nbase_mm = {:?}\ntip_mm = {:?}\nthickness_mm = {:?}\n\n\
             [finger.back]\nbase_mm = {:?}\ntip_mm = {:?}\nthickness_mm = {:?}\n\n[finger.lamellae]\n\
             heights_mm = {:?}\nthickness_mm = {:?}\n\n[finger.hinge]\nkind = \"flexible\"\nlength_mm = {:?}\n\
             thickness_mm = {:?}\nfrom = \"centreline\"\n\n[finger.motor]\naxis_mm = {:?}\n\n[object]\n\
             shape = \"circle\"\nradius_mm = {:?}\ncentre_mm = {:?}\n\n[motion]\nmotor_angles_deg = [{:?}]\n",
            design.width.at(0.0),
            design.material.youngs_modulus * 1e6,
            design.material.poissons_ratio,
            design.front.base,
            design.front.tip,
            design.front.thickness.at(0.0),
            design.back.base,
            design.back.tip,
            design.back.thickness.at(0.0),
            heights,
            design.lamellae.thickest(),
            design.hinge.length_of(0),
            design.hinge.thickness,
            design.motor_axis,
            self.radius,
            self.centre,
            self.angle.to_degrees(),
        )
    }
}

/// Draws cases without end.
pub struct Cases(Random);

impl Cases {
    /// The cases of a seed.
    pub fn seeded(seed: u64) -> Self {
        Self(Random::new(seed))
    }
}

impl Iterator for Cases {
    type Item = Case;

    fn next(&mut self) -> Option<Case> {
        let (design, Round { centre, radius }, indentation) = random_case(&mut self.0);
        let touch = first_contact(&design, centre, radius);
        Some(Case { design, centre, radius, touch, angle: touch + indentation })
    }
}

/// An object's centre in the finger frame at a motor angle, mm: C − M turned by α about M.
pub fn centre_in_finger(design: &Design, centre: [f64; 2], angle: f64) -> [f64; 2] {
    let (s, c) = angle.sin_cos();
    let m = design.motor_axis;
    let arm = [centre[0] - m[0], centre[1] - m[1]];
    [m[0] + c * arm[0] - s * arm[1], m[1] + s * arm[0] + c * arm[1]]
}
