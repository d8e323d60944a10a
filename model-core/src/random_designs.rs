//! Two thousand random fingers on random objects, each converged equilibrium checked by code of its own.

use std::boxed::Box;
use std::collections::BTreeMap;
use std::string::String;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use crate::design::{Attachments, Design, Profile};
use crate::discretise::{Discretisation, Physics};
use crate::equilibrium::{Follower, Settings};
use crate::object::{Motion, ObjectDesign};
use crate::size::Paper;
use crate::status::Status;

pub(crate) struct Random(ChaCha8Rng);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Uniform in 0 … 1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Within ±30 %.
    fn about(&mut self, value: f64) -> f64 {
        value * (0.7 + 0.6 * self.unit())
    }
}

/// A circle's centre and radius, mm.
#[derive(Clone, Copy)]
pub(crate) struct Round {
    pub(crate) centre: [f64; 2],
    pub(crate) radius: f64,
}

/// Geometry ±30 %, 3 to 9 lamellae, radius 10 to 60 mm, indentation 2 to 20°.
pub(crate) fn random_case(random: &mut Random) -> (Design, Round, f64) {
    loop {
        let mut design = crate::design::tests::ladder_80();
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

/// The case as a file for `fre solve`.
fn case_file(design: &Design, object: Round, angle: f64) -> String {
    let Round { centre, radius } = object;
    let Attachments::Heights(heights) = &design.lamellae.attachments else { return String::new() };
    std::format!(
        "[finger]\nwidth_mm = {:?}\nplane_strain = \"stress\"\n\n[finger.material]\nyoungs_modulus_pa = {:?}\n\
         poissons_ratio = {:?}\n\n[finger.front]\nbase_mm = {:?}\ntip_mm = {:?}\nthickness_mm = {:?}\n\n\
         [finger.back]\nbase_mm = {:?}\ntip_mm = {:?}\nthickness_mm = {:?}\n\n[finger.lamellae]\n\
         heights_mm = {:?}\nthickness_mm = {:?}\n\n[finger.hinge]\nkind = \"flexible\"\nlength_mm = {:?}\n\
         thickness_mm = {:?}\nfrom = \"centreline\"\n\n[finger.motor]\naxis_mm = {:?}\n\n[object]\nshape = \"circle\"\n\
         radius_mm = {radius:?}\ncentre_mm = {centre:?}\n\n[motion]\nmotor_angles_deg = [{:?}]\n",
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
        design.lamellae.thickness,
        design.hinge.length_of(0),
        design.hinge.thickness,
        design.motor_axis,
        angle.to_degrees(),
    )
}

type Solver = Follower<f64, Paper>;

fn solve(
    follower: &mut Solver,
    design: &Design,
    how: &Discretisation,
    Round { centre, radius }: Round,
    angle: f64,
    max_step: f64,
) -> Status {
    follower.configure(design, how).expect("a valid design");
    follower.set_settings(Settings { max_angle_step: max_step.to_radians(), ..Settings::DEFAULT });
    follower.set_object(ObjectDesign::Circle { centre, radius }, Motion::Rotating { axis: design.motor_axis });
    if !follower.start(angle) {
        return Status::OutOfRange;
    }
    follower.follow(angle).status
}

/// Angle at which the undeformed front beam's surface, or its tip, first touches the circle when closing from −30°.
pub(crate) fn first_contact(design: &Design, centre: [f64; 2], radius: f64) -> f64 {
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

/// What an equilibrium must satisfy, computed from the shape and the forces that the solver reports.
fn check(follower: &mut Solver, design: &Design, object: Round, softness: f64) -> Result<(), String> {
    let Round { centre, radius } = object;
    let angle = follower.coordinate();
    let (s, c) = angle.sin_cos();
    let m = design.motor_axis;
    let arm = [centre[0] - m[0], centre[1] - m[1]];
    let centre = [m[0] + c * arm[0] - s * arm[1], m[1] + s * arm[0] + c * arm[1]];
    let half = 0.5 * design.front.thickness.at(0.0);
    let fail = |what: &str, value: f64| Err(std::format!("{what}: {value:e}"));

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
    let mut random = Random::new(2000);
    let mut follower: Box<Solver> = Box::new(Follower::EMPTY);
    let reduced = Discretisation::reduced(Physics::Paper);
    let fine = Discretisation::fine(Physics::Paper);
    let mut table: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    let mut converged = 0;
    const CASES: usize = 2000;
    for case in 0..CASES {
        let (design, object, indentation) = random_case(&mut random);
        let angle = first_contact(&design, object.centre, object.radius) + indentation;
        let status = solve(&mut follower, &design, &reduced, object, angle, 1.0);
        if status.is_trustworthy() {
            converged += 1;
            *table.entry((status.word(), "")).or_default() += 1;
            if let Err(what) = check(&mut follower, &design, object, reduced.softness) {
                panic!("case {case}: {what}\n{}", case_file(&design, object, angle));
            }
        } else {
            let again = solve(&mut follower, &design, &fine, object, angle, 0.1);
            *table.entry((status.word(), again.word())).or_default() += 1;
            std::println!("case {case}: {status}, fine: {again}\n{}", case_file(&design, object, angle));
        }
    }
    for ((first, fine), count) in &table {
        std::println!("{count:5}  reduced, 1° steps: {first:16} fine, 0.1° steps: {fine}");
    }
    assert!(converged >= CASES * 95 / 100, "{converged} of {CASES} converged");
}
