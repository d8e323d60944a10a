//! Ribs that end with a gap before the back beam: open and shut, in balance, and along random motions.

use std::boxed::Box;
use std::vec::Vec;

use super::{Follower, Settings, Target};
use crate::design::tests::{ribs, set_heights};
use crate::design::{Attachments, Design, RibEnds, ladder_80};
use crate::discretise::{Discretisation, Elements, Physics, Scheme, Softness};
use crate::object::{Motion, ObjectDesign};
use crate::random_designs::{Random, Round, first_contact, random_case};
use crate::real::Real;
use crate::sensitivity::Probe;
use crate::size::{Ribs as Room, Size};
use crate::status::Status;
use crate::topology::Role;

crate::fixed_size!(
    /// Room for ribs of many elements.
    Fine, cells 13, nodes 4000, samples 800, contacts 40, memory 2
);
crate::fixed_size!(
    /// The same with friction.
    Rubbing, cells 13, nodes 4000, samples 800, contacts 80, friction
);

/// The beams of `fea-80` with ribs of a thickness that end so far before the back beam.
fn gapped(thickness: f64, gap: f64) -> Design {
    let mut design = ladder_80();
    ribs(&mut design, thickness).ends = RibEnds::Gap(gap);
    design.rigid_above = Some(74.116);
    design
}

/// The same inclined by so much between the beams, mm; six of them.
fn inclined(thickness: f64, gap: f64, by: f64) -> Design {
    let mut design = gapped(thickness, gap);
    let arcs = |from: f64| (1..=6).map(|k| 9.0 * f64::from(k) + from).collect();
    design.lamellae.attachments = Attachments::Arcs { front: arcs(3.0), back: arcs(5.0 + by) };
    design
}

fn start<T: Real, S: Size>(design: &Design, how: &Discretisation, height: f64) -> Box<Follower<T, S>> {
    let mut follower: Box<Follower<T, S>> = Box::new(Follower::EMPTY);
    follower.configure(design, how).expect("a valid finger");
    let object = ObjectDesign::Circle { centre: [41.0, height], radius: 40.0 };
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(0.0));
    follower
}

fn force<T: Real, S: Size>(follower: &Follower<T, S>) -> f64 {
    let [x, y] = follower.solution().force_finger().map(Real::to_f64);
    x.hypot(y)
}

/// Rungs whose free ends touch the back beam.
fn shut<T: Real, S: Size>(follower: &Follower<T, S>) -> u32 {
    (0..follower.model.cells()).filter(|&rung| is_shut(follower, rung)).count() as u32
}

fn is_shut<T: Real, S: Size>(follower: &Follower<T, S>, rung: usize) -> bool {
    let member = follower.model.topology.find(Role::Gap(rung as u8)).and_then(|index| follower.model.member(index));
    member.is_some_and(|gap| follower.work.kinematics.nodes.as_ref()[usize::from(gap.first)].bent[0] != T::ZERO)
}

/// Where the joint at the upper end of a back span lies, in the model's units.
fn back_joint(follower: &Follower<f64, Fine>, span: u8) -> [f64; 2] {
    let (base, rung) = (follower.model.base, follower.model.base_rung);
    let from = [base[0] + rung[0], base[1] + rung[1]];
    let each = follower.model.members().iter().zip(follower.work.kinematics.members.as_ref());
    each.filter(|(member, _)| matches!(member.role, Role::Back(cell) if cell <= span)).fold(from, |at, (_, out)| {
        let way = out.end_to_end();
        [at[0] + way[0], at[1] + way[1]]
    })
}

/// Every scheme with elements fine enough.
fn schemes(physics: Physics) -> [Discretisation; 3] {
    let links = |scheme| Discretisation {
        elements: Elements::PerBeam { beam: 51, hinge: 4 },
        ..Discretisation::full(scheme, physics)
    };
    [Discretisation::fine(physics), links(Scheme::Trapezoid), links(Scheme::Paper)]
}

/// Ribs that never touch are none: the finger is that without lamellae.
#[test]
fn an_open_gap_is_no_rib() {
    let open = gapped(1.0, 3.0);
    let mut bare = ladder_80();
    set_heights(&mut bare, 0);
    bare.lamellae.thickness.clear();
    // Without cross-sections, so that welds stiffen nothing, and with elements as short.
    let how =
        Discretisation { elements: Elements::PerBeam { beam: 64, hinge: 1 }, ..Discretisation::fine(Physics::Paper) };
    let mut pair: [Box<Follower<f64, Fine>>; 2] = [start(&open, &how, 45.0), start(&bare, &how, 45.0)];
    for degrees in [1.0, 4.0, 8.0_f64] {
        let [open, bare] = pair.each_mut().map(|follower| {
            assert!(follower.follow(degrees.to_radians()).status.is_trustworthy());
            (force(follower), shut(follower))
        });
        std::println!("{degrees}°: {open:?}, without lamellae {bare:?}");
        assert!(open.1 == 0 && (open.0 / bare.0 - 1.0).abs() < 2e-4, "{degrees}°: {open:?} against {bare:?}");
    }
}

/// Where a gap is shut the force through the rib is across the back beam's face, and presses; its end is at the face; where it is open there is
/// none. The moment at the end vanishes: the last element of the rib is straight.
#[test]
fn a_shut_gap_bears_what_presses_and_nothing_else() {
    let mut seen = [0; 2];
    for design in [gapped(2.0, 0.1), inclined(1.6, 0.05, -6.0), inclined(1.6, 0.05, 6.0)] {
        let how = Discretisation::fine(Physics::Extended);
        let mut follower: Box<Follower<f64, Fine>> = start(&design, &how, 33.0);
        for half in (0..=16).chain((0..16).rev()) {
            let outcome = follower.follow((0.5 * f64::from(half)).to_radians());
            assert!(outcome.status.is_trustworthy(), "{half}: {outcome:?}");
            let units = follower.model.units;
            let rungs: Vec<_> = follower.solution().lamellae().collect();
            for (index, member) in follower.model.members().iter().enumerate() {
                let Role::Gap(rung) = member.role else { continue };
                let is_shut = is_shut(&follower, usize::from(rung));
                let across = follower.work.kinematics.nodes.as_ref()[usize::from(member.first)].e;
                let [x, y] = follower.work.kinematics.members.as_ref()[index].force.map(|f| f * units.force);
                let (pressed, slid) = (x * across[0] + y * across[1], y * across[0] - x * across[1]);
                assert!(slid.abs() < 1e-9 && pressed > -1e-9 && (is_shut || pressed < 1e-9), "{pressed} {slid}");
                // From the rib's end to the back beam's joint, less the way from the face to there.
                let end = rungs[usize::from(rung)][1];
                let rigid = follower.work.kinematics.members.as_ref()[index].rigid_start;
                let joint = back_joint(&follower, rung);
                let way = [0, 1].map(|axis| units.length * (joint[axis] - rigid[axis]) - end[axis]);
                let width = way[0] * across[0] + way[1] * across[1];
                assert!(if is_shut { width.abs() < 1e-9 } else { width > -1e-9 }, "{is_shut}: {width}");
                seen[usize::from(is_shut)] += 1;
            }
        }
    }
    assert!(seen.iter().all(|&count| count > 50), "{seen:?}");
}

/// The torque is the energy's derivative in every scheme, whether gaps are open or shut: they have no energy of their own.
#[test]
fn the_torque_is_the_energys_derivative() {
    let mut most = 0;
    for design in [gapped(2.0, 0.1), inclined(1.6, 0.05, -6.0)] {
        for how in schemes(Physics::Extended) {
            let mut follower: Box<Follower<f64, Fine>> = start(&design, &how, 33.0);
            let step = 1e-4;
            for degrees in [0.7, 2.0, 4.0, 7.0_f64] {
                let mut at = |angle: f64| {
                    let outcome = follower.follow(angle);
                    assert!(outcome.status.is_trustworthy(), "{how:?} {degrees}°: {outcome:?}");
                    (follower.solution().potential(), follower.solution().motor_torque())
                };
                let angle = degrees.to_radians();
                let (below, torque, above) = (at(angle - step).0, at(angle).1, at(angle + step).0);
                let derivative = (above - below) / (2.0 * step);
                assert!((derivative / torque - 1.0).abs() < 1e-4, "{how:?} {degrees}°: {derivative}, {torque}");
                most = most.max(shut(&follower));
            }
        }
    }
    assert!(most >= 2, "{most} gaps shut at once");
}

/// What has closed opens the same way, in both precisions and in the microcontroller's resolution.
#[test]
fn closing_and_opening_is_one_path() {
    for design in [gapped(2.0, 0.1), gapped(1.2, 0.3), inclined(2.0, 0.05, -6.0)] {
        let mut small: Box<Follower<f32, Room>> = start(&design, &Discretisation::estimator(Physics::Extended), 33.0);
        let mut large: Box<Follower<f64, Fine>> = start(&design, &Discretisation::fine(Physics::Extended), 33.0);
        let (mut closing, mut most) = (Vec::new(), 0);
        for half in (0..=16).chain((0..16).rev()) {
            let angle = (0.5 * f64::from(half)).to_radians();
            let (a, b) = (small.follow(angle), large.follow(angle));
            assert!(a.status.is_trustworthy() && b.status.is_trustworthy(), "{half}: {a:?} {b:?}");
            assert!(
                a.iterations <= 12 && b.iterations <= 20,
                "{half}: {} and {} iterations",
                a.iterations,
                b.iterations
            );
            let (a, b) = (force(&small), force(&large));
            assert!((a - b).abs() <= 0.01 * b + 0.002, "{half}: {a} N, {b} N");
            most = most.max(shut(&large));
            if closing.len() <= 16 {
                closing.push(b);
            } else {
                let before = closing[half as usize];
                assert!((b - before).abs() < 1e-6 * (1.0 + before), "{half}: {b} N opening, {before} N closing");
            }
        }
        assert!(most > 0, "some gap is shut on the way");
    }
}

/// A finger that is held relaxes as its material, however many of its gaps are shut.
#[test]
fn a_held_finger_relaxes_as_its_material() {
    let design = inclined(1.6, 0.05, -6.0);
    let how = Discretisation { softness: Softness::Fixed(1e-9), ..Discretisation::fine(Physics::Extended) };
    let mut follower: Box<Follower<f64, Fine>> = start(&design, &how, 33.0);
    let terms = [[0.2, 1.0], [0.1, 30.0]];
    follower.set_prony(&terms).expect("two terms");
    assert!(follower.start(0.0));
    let outcome = follower.follow(4.0_f64.to_radians());
    assert!(outcome.status.is_trustworthy() && shut(&follower) > 0, "{outcome:?}");
    let sudden = force(&follower);
    for (at, step) in [(2.0, 2.0), (10.0, 8.0), (100.0, 90.0)] {
        let outcome = follower.follow(Target { coordinate: 4.0_f64.to_radians(), time_step_s: step });
        assert!(outcome.status.is_trustworthy(), "{outcome:?}");
        let left = terms.iter().fold(1.0, |left, [part, time]| left - part * (1.0 - f64::exp(-at / time)));
        assert!(
            (force(&follower) / sudden / left - 1.0).abs() < 1e-6,
            "{at} s: {} of {sudden}, {left}",
            force(&follower)
        );
    }
}

/// Random fingers whose ribs have gaps close on random circles and open again, in both precisions.
#[test]
fn random_fingers_close_and_open() {
    let mut random = Random::new(17);
    let (mut states, mut touching, mut lost, mut apart) = (0, 0, Vec::new(), Vec::new());
    for case in 0..200 {
        let (mut design, Round { centre, radius }, indentation) = random_case(&mut random);
        let thickness = 1.0 + 1.5 * random.unit();
        let gap = 0.5 * random.unit().powi(2);
        ribs(&mut design, thickness).ends = RibEnds::Gap(gap);
        if design.validate().is_err() {
            continue;
        }
        let object = ObjectDesign::Circle { centre, radius };
        // A little before: a finger that is pressed from the beginning is another matter.
        let touch = first_contact(&design, centre, radius) - 1e-3;
        let mut small: Box<Follower<f32, Room>> = Box::new(Follower::EMPTY);
        let mut large: Box<Follower<f64, Fine>> = Box::new(Follower::EMPTY);
        let how = Discretisation::reduced(Physics::Extended);
        small.configure(&design, &how).expect("a valid finger");
        large.configure(&design, &how).expect("a valid finger");
        small.set_object(object, Motion::Rotating { axis: design.motor_axis });
        large.set_object(object, Motion::Rotating { axis: design.motor_axis });
        small.set_settings(Settings::DEFAULT).expect("the defaults");
        if !small.start(touch) || !large.start(touch) {
            continue;
        }
        let count = (indentation.to_degrees() / 0.5) as u32;
        for k in (0..=count).chain((0..count).rev()) {
            let angle = touch + (0.5 * f64::from(k)).to_radians();
            let (a, b) = (small.follow(angle), large.follow(angle));
            if !(a.status.is_trustworthy() && b.status.is_trustworthy()) {
                lost.push((case, k, a.status, b.status));
                break;
            }
            states += 1;
            touching += u32::from(shut(&large) > 0);
            let (single, double) = (force(&small), force(&large));
            if a.status != Status::Snapped
                && b.status != Status::Snapped
                && (single - double).abs() > 2e-3 * double + 1e-3
            {
                apart.push((case, k, single, double));
            }
        }
    }
    std::println!("{states} states, {touching} with a gap shut; lost {lost:?}; apart {apart:?}");
    assert!(states > 3000 && touching > 1000, "{states} {touching}");
    assert!(lost.is_empty() && apart.is_empty());
}

/// Derivatives with the motion, the object's place and the gaps' width are those of differences of equilibria.
#[test]
fn derivatives_agree_with_differences() {
    let how = Discretisation::fine(Physics::Extended);
    for (design, degrees) in [(inclined(1.6, 0.05, -6.0), 4.0_f64), (gapped(2.0, 0.1), 2.0)] {
        let RibEnds::Gap(gap) = design.lamellae.ribs().expect("ribs").ends else { panic!("a gap") };
        let with = |by: f64| {
            let mut other = design.clone();
            ribs(&mut other, design.lamella_thickness(0)[0]).ends = RibEnds::Gap(gap + by);
            other
        };
        let at = |design: &Design, angle: f64, x: f64| {
            let mut follower: Box<Follower<f64, Fine>> = Box::new(Follower::EMPTY);
            follower.configure(design, &how).expect("a valid finger");
            let object = ObjectDesign::Circle { centre: [41.0 + x, 33.0], radius: 40.0 };
            follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
            assert!(follower.start(0.0));
            assert!(follower.follow(angle).status.is_trustworthy());
            follower
        };
        let angle = degrees.to_radians();
        let mut here = at(&design, angle, 0.0);
        assert!(shut(&here) > 0, "some gap is shut");
        let sensitivity = here.sensitivity().expect("a derivative");
        let mut probe = Box::new(Probe::EMPTY);
        let step = 1e-5;
        let along = here.design_derivative(&mut probe, [&with(-step), &with(step)], &how, step).expect("a derivative");
        let read = |follower: &Follower<f64, Fine>| {
            let [x, y] = follower.solution().force_world();
            [x, y, follower.solution().motor_torque()]
        };
        let h = 1e-4;
        for (name, exact, low, high) in [
            ("angle", sensitivity.coordinate, at(&design, angle - h, 0.0), at(&design, angle + h, 0.0)),
            ("centre x", sensitivity.centre[0], at(&design, angle, -h), at(&design, angle, h)),
            ("gap", along, at(&with(-h), angle, 0.0), at(&with(h), angle, 0.0)),
        ] {
            let [low, high] = [read(&low), read(&high)];
            let found = [0, 1, 2].map(|i| (high[i] - low[i]) / (2.0 * h));
            let exact = [exact.force[0], exact.force[1], exact.torque];
            std::println!("{name}: {exact:?}, differences {found:?}");
            let size = exact.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            for (exact, found) in exact.iter().zip(found) {
                assert!((exact - found).abs() < 3e-5 * size, "{name}: {exact} {found}");
            }
        }
    }
}

/// With friction at the object the force over the angle is a loop, whose area is what friction dissipates: gaps dissipate nothing.
#[test]
fn a_loops_work_is_what_friction_dissipates() {
    let design = inclined(1.6, 0.05, -6.0);
    let mut follower: Box<Follower<f64, Rubbing>> = start(&design, &Discretisation::fine(Physics::Extended), 33.0);
    follower.set_friction(0.5).expect("a coefficient");
    assert!(follower.start(0.0));
    let (step, count) = (0.02_f64.to_radians(), 200);
    let (mut work, mut torque, mut most) = (0.0, 0.0, 0);
    for (k, way) in (1..=count).map(|k| (k, 1.0)).chain((0..count).rev().map(|k| (k, -1.0))) {
        let outcome = follower.follow(step * f64::from(k));
        assert!(outcome.status.is_trustworthy(), "{k}: {outcome:?}");
        let next = follower.solution().motor_torque();
        work += 0.5 * way * step * (torque + next);
        (torque, most) = (next, most.max(shut(&follower)));
    }
    let dissipated = follower.solution().dissipated();
    std::println!("work {work} N·mm, dissipated {dissipated} N·mm, {most} gaps shut at once");
    assert!(most >= 2 && dissipated > 0.05, "{dissipated}");
    assert!((work / dissipated - 1.0).abs() < 0.01, "{work} and {dissipated}");
}
