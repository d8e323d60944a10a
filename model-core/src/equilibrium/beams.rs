//! Beams through points, held beams and factors: against closed forms, and against fingers that are described otherwise.

use std::boxed::Box;
use std::vec::Vec;

use nalgebra::{DMatrix, DVector};

use super::Follower;
use crate::design::tests::{ribs, set_heights};
use crate::design::{Attachments, Design, HingeFrom, HingeKind, LamellaKind, Lamellae, Profile, RibEnds, ladder_80};
use crate::discretise::{Discretisation, Elements, Physics, Scheme, discretise};
use crate::model::Model;
use crate::object::{Motion, ObjectDesign};

crate::fixed_size!(
    /// Room for many elements.
    Fine, cells 13, nodes 4000, samples 1200, contacts 40
);

type Solver = Box<Follower<f64, Fine>>;

/// A finger closed on a circle by 5°.
fn closed(design: &Design, how: &Discretisation) -> Solver {
    let mut follower: Solver = Box::new(Follower::EMPTY);
    follower.configure(design, how).expect("a valid finger");
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(0.0));
    let outcome = follower.follow(5_f64.to_radians());
    assert!(outcome.status.is_trustworthy() && follower.solution().touching() > 0, "{outcome:?}");
    follower
}

fn off(a: &Solver, b: &Solver) -> f64 {
    let ([x, y], [u, v]) = (a.solution().force_finger(), b.solution().force_finger());
    (x - u).hypot(y - v) / u.hypot(v)
}

/// Points of a circular arc from one point to another over a sagitta, so many and unevenly far apart.
fn on_arc(base: [f64; 2], tip: [f64; 2], sagitta: f64, count: usize) -> Vec<[f64; 2]> {
    let beam = crate::design::Beam { sagitta, ..crate::design::Beam::straight(base, tip, Profile::constant(1.0)) };
    let uneven = |k: usize| {
        let part = k as f64 / (count + 1) as f64;
        part + 0.2 / (count + 1) as f64 * (7.0 * part).sin()
    };
    (1..=count).map(|k| beam.point(beam.length() * uneven(k))).collect()
}

/// Points on a line or on an arc are another way to write base and tip, or a sagitta.
#[test]
fn points_on_a_line_or_an_arc_are_that_line_or_arc() {
    for sagitta in [0.0, -3.0] {
        for physics in [Physics::Paper, Physics::Extended] {
            let mut bowed = ladder_80();
            (bowed.front.sagitta, bowed.back.sagitta) = (sagitta, 0.5 * sagitta);
            let mut through = ladder_80();
            for (beam, sagitta) in [(&mut through.front, sagitta), (&mut through.back, 0.5 * sagitta)] {
                beam.via = on_arc(beam.base, beam.tip, sagitta, 9).into_iter().collect();
            }
            let how = Discretisation::reduced(physics);
            let error = off(&closed(&through, &how), &closed(&bowed, &how));
            std::println!("{physics:?}, sagitta {sagitta}: {error:.1e}");
            assert!(error < 1e-8, "{physics:?}, sagitta {sagitta}: {error:e}");
        }
    }
}

/// A rod along an arc of a radius and an angle, clamped at its start: what a small force along x at its end moves the end along x, in
/// units of R³/EI.
fn curved_cantilever(scheme: Scheme, elements: u16, radius: f64, angle: f64) -> f64 {
    let mut design = ladder_80();
    set_heights(&mut design, 0);
    let tip = [radius * (1.0 - angle.cos()), radius * angle.sin()];
    let sagitta = -radius * (1.0 - (0.5 * angle).cos());
    (design.front.tip, design.back.tip) = (tip, tip);
    design.front.via = on_arc([0.0; 2], tip, sagitta, 7).into_iter().collect();
    let how = Discretisation {
        elements: Elements::PerBeam { beam: elements, hinge: 1 },
        ..Discretisation::full(scheme, Physics::Paper)
    };
    let mut model: Box<Model<f64, Fine>> = Box::new(Model::EMPTY);
    discretise(&design, &how, &mut model).expect("a valid design");
    let nodes = model.members()[0].nodes();
    let n = nodes.len() - 1;
    let (mut stiffness, mut lever) = (DMatrix::<f64>::zeros(n, n), DVector::<f64>::zeros(n));
    for i in 0..=n {
        for (ahead, &k) in model.coupling[nodes.start + i].iter().enumerate() {
            let j = i + ahead + 1;
            if j <= n && k != 0.0 {
                stiffness[(j - 1, j - 1)] -= k;
                if i > 0 {
                    stiffness[(i - 1, i - 1)] -= k;
                    stiffness[(i - 1, j - 1)] += k;
                    stiffness[(j - 1, i - 1)] += k;
                }
            }
        }
        if i > 0 {
            lever[i - 1] = -model.weight[nodes.start + i] * model.direction[nodes.start + i][1];
        }
    }
    let turn = stiffness.lu().solve(&lever).expect("a clamped rod");
    let units = &model.units;
    let bending = design.material.youngs_modulus * 20.0 * 8.0 / 12.0;
    lever.dot(&turn) * units.length / units.force * bending / radius.powi(3)
}

/// Castigliano's theorem: ∫ (sin φ₀ − sin φ)² dφ from 0 to φ₀; and the schemes' orders.
#[test]
fn an_arc_as_a_centreline_is_the_textbooks_curved_cantilever() {
    let (radius, angle) = (75.0, 1.05_f64);
    let (s, c) = angle.sin_cos();
    let exact = s * s * angle - 2.0 * s * (1.0 - c) + 0.5 * angle - 0.25 * (2.0 * angle).sin();
    for (scheme, few, order) in [(Scheme::Paper, 40, 0.95), (Scheme::Trapezoid, 40, 1.95), (Scheme::Simpson, 3, 3.5)] {
        let error = |elements| (curved_cantilever(scheme, elements, radius, angle) / exact - 1.0).abs();
        let (coarse, fine) = (error(few), error(2 * few));
        let found = (coarse / fine).log2();
        std::println!("{scheme:?}: {coarse:.1e}, {fine:.1e}, order {found:.2}");
        assert!(found > order && fine < 0.03, "{scheme:?}: {coarse:e}, {fine:e}, order {found}");
    }
}

/// A finger whose beams are held over some length is one whose base lies higher.
#[test]
fn a_clamp_is_a_base_that_is_moved() {
    for physics in [Physics::Paper, Physics::Extended] {
        for is_rib in [false, true] {
            let mut held = ladder_80();
            let taper = [[0.0, 2.4], [30.0, 2.1], [80.0, 1.6]];
            held.front.thickness = Profile { knots: heapless::Vec::from_iter(taper) };
            if is_rib {
                ribs(&mut held, 1.2);
            }
            let arcs = |side: usize, by: f64| {
                (1..7).map(|k| ladder_80().attachment_arcs(k)[side] - by).collect::<heapless::Vec<_, _>>()
            };
            let clamps = [5.0, 7.5];
            held.lamellae.attachments = Attachments::Arcs { front: arcs(0, 0.0), back: arcs(1, 0.0) };
            (held.front.clamp, held.back.clamp) = (clamps[0], clamps[1]);
            let mut moved = held.clone();
            moved.lamellae.attachments = Attachments::Arcs { front: arcs(0, clamps[0]), back: arcs(1, clamps[1]) };
            for (beam, from) in [(&mut moved.front, &held.front), (&mut moved.back, &held.back)] {
                beam.base = from.point(from.clamp);
                beam.clamp = 0.0;
                for knot in &mut beam.thickness.knots {
                    knot[0] -= from.clamp;
                }
            }
            let how = Discretisation::reduced(physics);
            let (a, b) = (closed(&held, &how), closed(&moved, &how));
            let error = off(&a, &b);
            assert!(error < 1e-8, "{physics:?}, ribs {is_rib}: {error:e}");
            // Arcs go on being counted from the beam's own start.
            let arcs =
                a.solution().contacts().zip(b.solution().contacts()).map(|(a, b)| (a.arc - b.arc - clamps[0]).abs());
            assert!(arcs.fold(0.0, f64::max) < 1e-6);
        }
    }
}

/// Rungs that end on a held beam: where that is thick instead, the finger comes the nearer to it the thicker the beam, and what holds it
/// is in balance with the contacts.
#[test]
fn a_held_beam_is_one_that_does_not_bend() {
    type Change = fn(&mut Design);
    let kinds: [(&str, Change); 3] = [
        ("flexible", |_| {}),
        ("pinned", |design| design.hinge.kind = HingeKind::Pinned),
        ("rib", |design| {
            design.lamellae.kind =
                LamellaKind::Rib(crate::design::Ribs { ends: RibEnds::Hinged, ..crate::design::Ribs::WELDED });
            design.lamellae.thickness = Lamellae::uniform(1.0);
        }),
    ];
    for (name, change) in kinds {
        for (scheme, physics) in [
            (Scheme::Simpson, Physics::Extended),
            (Scheme::Simpson, Physics::Paper),
            (Scheme::Trapezoid, Physics::Extended),
        ] {
            let how = match scheme {
                Scheme::Simpson => Discretisation::fine(physics),
                _ => Discretisation {
                    elements: Elements::PerBeam { beam: 60, hinge: 6 },
                    ..Discretisation::full(scheme, physics)
                },
            };
            let mut held = ladder_80();
            change(&mut held);
            assert_eq!(held.hinge.from, HingeFrom::Centreline);
            held.back.clamp = held.attachment_arcs(1)[1];
            let found = closed(&held, &how);
            let error = |thickness: f64| {
                let mut thick = held.clone();
                let knots = [[0.0, thickness], [held.back.clamp, thickness], [held.back.clamp + 1e-9, 2.0]];
                thick.back.thickness = Profile { knots: heapless::Vec::from_iter(knots) };
                thick.back.clamp = 0.0;
                off(&closed(&thick, &how), &found)
            };
            // Springs at a joint see the one thickness or the other: for links the quadratic elements are the reference.
            if scheme == Scheme::Trapezoid {
                let error = off(&found, &closed(&held, &Discretisation::fine(physics)));
                assert!(error < 0.02, "{name}, {scheme:?}: {error:e}");
            }
            let errors = if scheme == Scheme::Simpson { [10.0, 30.0].map(error) } else { [1.0, 0.0] };
            std::println!("{name}, {scheme:?}, {physics:?}: {errors:?}");
            assert!(errors[1] < 6e-3 && errors[1] < 0.15 * errors[0], "{name}, {scheme:?}, {physics:?}: {errors:?}");

            let (mut force, mut moment) = ([0.0; 2], 0.0);
            let mut add = |at: [f64; 2], f: [f64; 2]| {
                force = [force[0] + f[0], force[1] + f[1]];
                moment += at[0] * f[1] - at[1] * f[0];
            };
            for contact in found.solution().contacts() {
                add(contact.position, contact.normal.map(|n| n * contact.force));
            }
            let [front, back] = found.solution().base_reactions();
            add(held.front.base, front.0);
            add(held.back.point(held.back.clamp), back.0);
            let moment = moment + front.1 + back.1;
            assert!(force[0].hypot(force[1]) < 1e-8 && moment.abs() < 1e-6, "{name}: {force:?} N, {moment} N·mm");
            assert_eq!(found.solution().lamellae().count(), 7);
            // A lamella's ends are where they are built, but for what the held beam's neck bends.
            let [at, _] = found.solution().lamellae().next().map(|bar| bar.map(|end| end)).expect("lamellae");
            assert!((at[0] - (-2.5)).abs() < 3.0 && (at[1] - 9.0).abs() < 1.0, "{name}: {at:?}");
        }
    }
}

/// Ribs read from the front whichever way they are computed.
#[test]
fn a_held_rib_leads_from_front_to_back() {
    for scheme in [Scheme::Simpson, Scheme::Trapezoid] {
        let mut design = ladder_80();
        ribs(&mut design, 1.0);
        design.back.clamp = 22.0;
        let how = match scheme {
            Scheme::Simpson => Discretisation::fine(Physics::Extended),
            _ => Discretisation {
                elements: Elements::PerBeam { beam: 60, hinge: 6 },
                ..Discretisation::full(scheme, Physics::Extended)
            },
        };
        let found = closed(&design, &how);
        let lines: Vec<Vec<[f64; 2]>> = found.solution().ribs().map(Iterator::collect).collect();
        let bars: Vec<[[f64; 2]; 2]> = found.solution().lamellae().collect();
        assert_eq!((lines.len(), bars.len()), (7, 7));
        for (k, (line, [from, to])) in lines.iter().zip(&bars).enumerate() {
            let gap = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
            assert!(gap(&line[0], from) < 1e-9 && gap(&line[line.len() - 1], to) < 1e-9, "{scheme:?}, rib {k}");
            assert!(line.windows(2).all(|pair| pair[1][0] < pair[0][0]), "{scheme:?}, rib {k}: {line:?}");
            // Held ribs end on the back beam's face.
            if k < 2 {
                let arc = design.attachment_arcs(k)[1];
                let face = design.back.point(arc)[0] + crate::design::junction::face_distances(&design, k)[1];
                assert!((to[0] - face).abs() < 1e-9, "{scheme:?}, rib {k}: {to:?}, {face}");
            }
        }
    }
}

/// Factors on EI and EA: their product with Young's modulus is all that counts, and the bending factor is the plate's.
#[test]
fn factors_act_on_bending_and_on_stretch() {
    let how = Discretisation::reduced(Physics::Extended);
    let all = |bending: f64, stretch: f64, both: f64| {
        let mut design = ladder_80();
        ribs(&mut design, 1.2);
        for beam in [&mut design.front, &mut design.back] {
            (beam.bending_factor, beam.stretch_factor, beam.stiffness_factor) = (bending, stretch, both);
        }
        if let LamellaKind::Rib(ribs) = &mut design.lamellae.kind {
            (ribs.bending_factor, ribs.stretch_factor) = (bending * both, stretch * both);
        }
        design
    };
    let same = [all(1.3, 1.3, 1.0), all(1.0, 1.0, 1.3)].map(|design| closed(&design, &how));
    assert!(off(&same[0], &same[1]) < 1e-9);
    // A softer material by as much as the factors are larger; the contact's softness is the beam's own.
    let mut soft = all(1.3, 1.3, 1.0);
    soft.material.youngs_modulus /= 1.3;
    assert!(off(&closed(&soft, &how), &closed(&all(1.0, 1.0, 1.0), &how)) < 1e-9);
    // In plane strain bending alone is stiffer by 1/(1 − ν²).
    let mut plate = all(1.0, 1.0, 1.0);
    plate.plane_strain = crate::design::PlaneStrain::Strain;
    let nu = plate.material.poissons_ratio;
    let error = off(&closed(&all(1.0 / (1.0 - nu * nu), 1.0, 1.0), &how), &closed(&plate, &how));
    assert!(error < 1e-9, "{error:e}");
}
