//! Ribs that bend: against closed forms, rigid lamellae and the energy's derivative.

use core::f64::consts::PI;
use std::boxed::Box;
use std::vec::Vec;

use super::Follower;
use crate::design::tests::{ribs, set_heights};
use crate::design::{Design, HingeFrom, HingeKind, RibEnds, ladder_80};
use crate::discretise::{Discretisation, Elements, Physics, Scheme, discretise};
use crate::element::Tangents;
use crate::model::Model;
use crate::newton::Hessian;
use crate::newton::Workspace;
use crate::newton::condense::Diagonal;
use crate::newton::factored::Factored;
use crate::newton::memory::Memory;
use crate::object::{Motion, ObjectDesign};
use crate::size::Ribs as Room;
use crate::state::State;
use crate::topology::Role;

crate::fixed_size!(
    /// Room for ribs of many elements.
    Fine, cells 13, nodes 4000, samples 800, contacts 40
);

/// The beams of `fea-80` with welded ribs of a thickness.
fn ribbed(thickness: f64) -> Design {
    let mut design = ladder_80();
    ribs(&mut design, thickness);
    design.rigid_above = Some(74.116);
    design
}

fn start(design: &Design, how: &Discretisation, height: f64) -> Box<Follower<f64, Fine>> {
    let mut follower: Box<Follower<f64, Fine>> = Box::new(Follower::EMPTY);
    follower.configure(design, how).expect("a valid finger");
    let object = ObjectDesign::Circle { centre: [41.0, height], radius: 40.0 };
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(0.0));
    follower
}

fn force(follower: &Follower<f64, Fine>) -> f64 {
    let [x, y] = follower.solution().force_finger();
    x.hypot(y)
}

/// A rib of a finger by itself, its ends clamped, compressed by a force in shares of π²EI/L²: the negative pivots of its interior, and
/// how far its end moves sidewise per force.
fn column(scheme: Scheme, elements: u16, share: f64) -> (usize, f64) {
    let mut design = ladder_80();
    set_heights(&mut design, 1);
    ribs(&mut design, 0.4);
    // Elements as long as those of the front beam, and one more as the rib is slender.
    let length = design.lamella_width(0);
    let beam = f64::from(elements - 1) / length * 80.0;
    let how = Discretisation {
        elements: Elements::PerBeam { beam: beam as u16, hinge: 1 },
        ..Discretisation::full(scheme, Physics::Paper)
    };
    let mut model: Box<Model<f64, Fine>> = Box::new(Model::EMPTY);
    let mut state: Box<State<f64, Fine>> = Box::new(State::EMPTY);
    let mut work: Box<Workspace<f64, Fine>> = Box::new(Workspace::EMPTY);
    discretise(&design, &how, &mut model).expect("a valid finger");
    assert!(state.fit(&model) && work.fit(&model));
    let stiffness = 49.5 * 20.0 * 0.4_f64.powi(3) / 12.0;
    // The rib leads in −x; in the Lagrangian's sign a force along it compresses it.
    state.lambda[0] = [-share * PI * PI * stiffness / (length * length), 0.0];
    let rib = model.topology.find(Role::Rung(0, 0)).expect("a rib");
    work.kinematics.direct(&model, &state);
    work.kinematics.place_front::<Tangents>(&model, &Memory::EMPTY, &state, &[]);
    work.kinematics.complete::<Tangents>(&model, &Memory::EMPTY, &state);
    let mut factored: Box<Factored<f64, Fine>> = Box::new(Factored::EMPTY);
    assert!(factored.fit(&model));
    factored.kkt.curved = true;
    let (condensed, negative) =
        factored.kkt.condense(&model, &work.kinematics, rib, Diagonal::of(Hessian::Newton, 0.0));
    // In units of L³/EI.
    (negative, -condensed.yy * stiffness / length.powi(3))
}

/// A rib's interior, its force fixed, is singular at n² π²EI/L², and at 4 it buckles between ends that cannot move sidewise either. Its
/// sidewise compliance is (tan u/u − 1)/(2u)² L³/EI with 2u = L √(P/EI): the orders of the schemes.
#[test]
fn a_rib_is_the_textbooks_column() {
    for (share, negative) in [(0.9, 0), (1.1, 1), (3.9, 1), (4.1, 2), (8.8, 2), (9.2, 3)] {
        for scheme in [Scheme::Trapezoid, Scheme::Simpson] {
            let elements = if scheme == Scheme::Simpson { 6 } else { 60 };
            assert_eq!(column(scheme, elements, share).0, negative, "{scheme:?} at {share}");
        }
    }
    for share in [0.5, 2.0, 3.4] {
        let u = 0.5 * PI * f64::sqrt(share);
        let exact = (u.tan() / u - 1.0) / (4.0 * u * u);
        let error = |scheme, elements| (column(scheme, elements, share).1 / exact - 1.0).abs();
        // A column is alike from both ends, which makes `paper` as good as `trapezoid`.
        for (scheme, few, order) in [(Scheme::Paper, 30, 2.0), (Scheme::Trapezoid, 30, 2.0), (Scheme::Simpson, 6, 4.0)]
        {
            let (coarse, fine) = (error(scheme, few + 1), error(scheme, 2 * few + 1));
            let finer = f64::from(2 * few + 1) / f64::from(few + 1);
            let found = (coarse / fine).ln() / finer.ln();
            std::println!("{share} π²EI/L², {scheme:?}: {coarse:.1e}, {fine:.1e}, order {found:.2}");
            assert!(found > order - 0.35 && fine < 1e-3, "{scheme:?} at {share}: {coarse:e}, {fine:e}, order {found}");
        }
    }
}

/// Ribs that are stiff enough are welded lamellae, and with necks hinged ones.
#[test]
fn stiff_ribs_are_rigid_lamellae() {
    for (ends, kind) in [(RibEnds::Welded, HingeKind::Welded), (RibEnds::Hinged, HingeKind::Flexible)] {
        for scheme in [Scheme::Simpson, Scheme::Trapezoid] {
            let how = match scheme {
                Scheme::Simpson => Discretisation::fine(Physics::Paper),
                _ => Discretisation::full(scheme, Physics::Paper),
            };
            let how = Discretisation { elements: Elements::PerBeam { beam: 34, hinge: 2 }, ..how };
            let mut rigid = ladder_80();
            rigid.hinge.kind = kind;
            let mut design = ladder_80();
            // 64 times as stiff as a beam, and 1000 times besides.
            let rib = ribs(&mut design, 7.0);
            (rib.ends, rib.bending_factor, rib.stretch_factor) = (ends, 1e3, 1e3);
            let mut pair = [start(&design, &how, 45.0), start(&rigid, &how, 45.0)];
            for degrees in [2.0, 6.0_f64] {
                let [rib, rigid] = pair.each_mut().map(|follower| {
                    let outcome = follower.follow(degrees.to_radians());
                    assert!(outcome.status.is_trustworthy(), "{ends:?} {scheme:?} {degrees}°: {outcome:?}");
                    force(follower)
                });
                std::println!("{ends:?} {scheme:?} {degrees}°: {rib:.5} N, rigid {rigid:.5} N");
                assert!((rib / rigid - 1.0).abs() < 1e-3, "{ends:?} {scheme:?} {degrees}°: {rib} against {rigid}");
            }
        }
    }
}

/// The torque is the energy's derivative, in every scheme, with ribs of every kind, and the rib's own strains are part of the energy.
#[test]
fn the_torque_is_the_energys_derivative() {
    let mut tapered = ribbed(1.2);
    tapered.lamellae.thickness = heapless::Vec::from_iter([[1.6, 0.8]]);
    let mut necked = ribbed(2.0);
    ribs(&mut necked, 2.0).ends = RibEnds::Hinged;
    necked.hinge.from = HingeFrom::Face;
    necked.hinge.length = heapless::Vec::from_iter([1.2]);
    for (name, design) in [("welded", ribbed(1.2)), ("tapered", tapered), ("necked", necked)] {
        for scheme in [Scheme::Simpson, Scheme::Trapezoid, Scheme::Paper] {
            let how = match scheme {
                Scheme::Simpson => Discretisation::fine(Physics::Extended),
                _ => Discretisation {
                    elements: Elements::PerBeam { beam: 51, hinge: 4 },
                    ..Discretisation::full(scheme, Physics::Extended)
                },
            };
            let mut follower = start(&design, &how, 52.0);
            let step = 1e-4;
            for degrees in [3.0, 6.0_f64] {
                let mut at = |angle: f64| {
                    let outcome = follower.follow(angle);
                    assert!(outcome.status.is_trustworthy(), "{name} {scheme:?} {degrees}°: {outcome:?}");
                    (follower.solution().potential(), follower.solution().motor_torque())
                };
                let angle = degrees.to_radians();
                let (below, torque, above) = (at(angle - step).0, at(angle).1, at(angle + step).0);
                let derivative = (above - below) / (2.0 * step);
                assert!(
                    (derivative / torque - 1.0).abs() < 1e-4,
                    "{name} {scheme:?} {degrees}°: {derivative}, {torque}"
                );
            }
        }
    }
}

/// At rest a rib lies on its axis, from weld to weld.
#[test]
fn a_rib_at_rest_is_where_the_design_has_it() {
    let mut design = ribbed(1.2);
    design.lamellae.attachments = crate::design::Attachments::Arcs {
        front: (1..=5).map(|k| 10.0 * f64::from(k)).collect(),
        back: (1..=5).map(|k| 10.0 * f64::from(k) + 7.0).collect(),
    };
    design.back.sagitta = -3.0;
    let follower = start(&design, &Discretisation::reduced(Physics::Extended), 45.0);
    let ribs: Vec<Vec<[f64; 2]>> = follower.solution().ribs().map(Iterator::collect).collect();
    assert_eq!(ribs.len(), 5);
    for ((k, rib), bar) in ribs.iter().enumerate().zip(follower.solution().lamellae()) {
        let arcs = design.attachment_arcs(k);
        let (p, q) = (design.front.point(arcs[0]), design.back.point(arcs[1]));
        let width = design.lamella_width(k);
        let along = [(q[0] - p[0]) / width, (q[1] - p[1]) / width];
        let first = rib[0];
        for point in rib {
            let by = [point[0] - p[0], point[1] - p[1]];
            assert!((by[0] * along[1] - by[1] * along[0]).abs() < 1e-9, "rib {k}: {point:?} is off the axis");
        }
        let from = (first[0] - p[0]) * along[0] + (first[1] - p[1]) * along[1];
        let last = rib[rib.len() - 1];
        let to = (last[0] - p[0]) * along[0] + (last[1] - p[1]) * along[1];
        // A little inside the faces, which are a beam's half thickness away, or more where it is inclined.
        assert!((0.3..1.3).contains(&from) && (0.3..1.6).contains(&(width - to)), "rib {k}: {from} to {to} of {width}");
        assert!((bar[0][0] - first[0]).abs() + (bar[1][0] - last[0]).abs() < 1e-9);
    }
    // The beams are as long as they were, welds included.
    let length: f64 = follower
        .solution()
        .front()
        .collect::<Vec<_>>()
        .windows(2)
        .map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]))
        .sum();
    assert!((length - 80.0).abs() < 1e-9, "{length}");
}

/// Resolution and precision: what a microcontroller computes is what a fine model does.
#[test]
fn the_reduced_model_is_near_the_fine_one() {
    let mut small: Box<Follower<f32, Room>> = Box::new(Follower::EMPTY);
    let mut large: Box<Follower<f64, Fine>> = Box::new(Follower::EMPTY);
    for thickness in [0.8, 1.2, 2.0] {
        let design = ribbed(thickness);
        let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
        let motion = Motion::Rotating { axis: design.motor_axis };
        small.configure(&design, &Discretisation::estimator(Physics::Extended)).expect("room for seven ribs");
        let finest = Discretisation {
            elements: Elements::PerSpan { span: 8, tip_span: 8, hinge: 4 },
            ..Discretisation::fine(Physics::Extended)
        };
        large.configure(&design, &finest).expect("a valid finger");
        small.set_object(object, motion);
        large.set_object(object, motion);
        assert!(small.start(0.0) && large.start(0.0));
        let mut worst = 0.0_f64;
        for half in 2..=18 {
            let angle = (0.5 * f64::from(half)).to_radians();
            let (a, b) = (small.follow(angle), large.follow(angle));
            assert!(a.status.is_trustworthy() && b.status.is_trustworthy(), "{thickness} mm {half}: {a:?} {b:?}");
            let [x, y] = small.solution().force_finger().map(f64::from);
            worst = worst.max((x.hypot(y) / force(&large) - 1.0).abs());
        }
        std::println!("ribs of {thickness} mm: reduced f32 within {:.2} % of 8 elements per span, f64", 100.0 * worst);
        assert!(worst < 0.006, "{thickness} mm: {worst}");
    }
}

/// A rib's share of its buckling load is that of 4π²EI/L² between clamped ends.
#[test]
fn a_ribs_share_of_its_buckling_load_is_the_textbooks() {
    let mut design = ladder_80();
    ribs(&mut design, 0.6);
    let how = Discretisation {
        elements: Elements::PerSpan { span: 12, tip_span: 12, hinge: 1 },
        ..Discretisation::fine(Physics::Paper)
    };
    let mut follower = start(&design, &how, 45.0);
    let mut reported = 0;
    for half in 1..=15 {
        let outcome = follower.follow((0.5 * f64::from(half)).to_radians());
        assert!(outcome.status.is_trustworthy(), "{half}: {outcome:?}");
        let before = force(&follower);
        let shares = (0..7).map(|rib| {
            let lambda = follower.timeline.present.lambda.as_ref();
            let force = [0, 1].map(|axis| lambda[rib][axis] - lambda[rib + 1][axis]);
            let [from, to] = follower.solution().lamellae().nth(rib).expect("seven ribs");
            let chord = [to[0] - from[0], to[1] - from[1]];
            let pressed = (force[0] * chord[0] + force[1] * chord[1]) / chord[0].hypot(chord[1]);
            let units = &follower.model.units;
            let length = design.lamella_width(rib);
            let stiffness = design.material.youngs_modulus * 20.0 * 0.6_f64.powi(3) / 12.0;
            (pressed * units.force * length * length / (4.0 * PI * PI * stiffness), rib)
        });
        let (largest, rib) = shares.fold((0.0, 0), |most, share| if share.0 > most.0 { share } else { most });
        let found = follower.buckling(0.1);
        std::println!("{} °: {largest:.4} of rib {rib}, {found:?}", 0.5 * f64::from(half));
        assert!((force(&follower) / before - 1.0).abs() < 1e-9, "asking changes nothing");
        if largest < 0.09 || (0.09..0.11).contains(&largest) {
            continue;
        }
        let found = found.expect("more than a tenth");
        reported += 1;
        // The chord of a bowed rib is a little shorter, and its force not quite along it.
        assert!(found.rib == rib && (found.share / largest - 1.0).abs() < 0.03, "{found:?}, {largest}");
    }
    assert!(reported >= 3, "{reported} states with such a rib");
}
