//! The step against dense linear algebra and finite differences, on random states.

use std::boxed::Box;
use std::vec::Vec;

use super::condense::Diagonal;
use super::evaluated::Evaluated;
use super::factored::Factored;
use super::gaps::{Contacts, Sweep};
use super::{Hessian, Workspace, kinematics, slip};
use crate::contact::{ContactState, Direction, Row, Sample};
use crate::design::{Attachments, HingeFrom, HingeKind, LamellaKind, RibEnds, Ribs};
use crate::discretise::{Discretisation, Elements, Physics, Sampling, Scheme, Softness, discretise};
use crate::element::Tangents;
use crate::linear::symmetric;
use crate::model::Model;
use crate::random_designs::Random;
use crate::size::{Blank, Size};
use crate::state::State;
use crate::topology::{CLAMPED, Kind, Role};
use nalgebra::{DMatrix, DVector};

crate::fixed_size!(
    /// Room for any of the models here, with friction.
    Rubbing, cells 13, nodes 1200, samples 300, contacts 40, friction
);

type Case = (Box<Model<f64, Rubbing>>, Box<State<f64, Rubbing>>, Box<Workspace<f64, Rubbing>>);

/// Room for a model's factorisation.
fn factored_for(model: &Model<f64, Rubbing>) -> Box<Factored<f64, Rubbing>> {
    let mut factored = Box::new(Factored::EMPTY);
    assert!(factored.fit(model));
    factored
}

/// A random model in a random state with random contact rows.
fn random_model(random: &mut Random) -> Case {
    let mut design = crate::design::ladder_80();
    let lamellae = 4.0 * (1.0 + random.signed());
    crate::design::tests::set_heights(&mut design, lamellae as usize);
    let physics = if random.signed() > 0.0 { Physics::Extended } else { Physics::Paper };
    if random.signed() > 0.0 {
        design.hinge.from = HingeFrom::Face;
        design.rigid_above = Some(70.0);
        design.hinge.length.fill(1.5);
    }
    design.hinge.kind = match (random.signed() * 4.0) as i32 {
        2 => HingeKind::Pinned,
        3 => HingeKind::Welded,
        _ => HingeKind::Flexible,
    };
    if random.signed() > 0.3 {
        // Ribs, inclined and tapered, welded or with necks.
        let arcs =
            |side: usize, by: f64| (0..design.lamella_count()).map(|k| design.attachment_arcs(k)[side] + by).collect();
        let by = 2.0 * random.signed();
        design.lamellae.attachments = Attachments::Arcs { front: arcs(0, -by), back: arcs(1, by) };
        let thickness = [1.2 + 0.8 * random.signed(), 1.2 + 0.8 * random.signed()];
        design.lamellae.thickness = heapless::Vec::from_iter([thickness]);
        let ends = if random.signed() > 0.0 { RibEnds::Welded } else { RibEnds::Hinged };
        design.lamellae.kind = LamellaKind::Rib(Ribs { ends, ..Ribs::WELDED });
    }
    if random.signed() > 0.0 {
        // Beams through points, and held over some length.
        design.front.via = heapless::Vec::from_iter([[1.0 + random.signed(), 30.0], [1.0 + random.signed(), 55.0]]);
        design.front.clamp = 2.0 + random.signed();
        let is_bar = design.joint() == HingeKind::Welded && design.lamellae.ribs().is_none();
        design.back.clamp = if is_bar { 4.0 } else { 18.0 + 15.0 * random.signed() };
    }
    let scheme = [Scheme::Paper, Scheme::Trapezoid, Scheme::Simpson][(1.5 * (1.0 + random.signed())) as usize % 3];
    let how = Discretisation {
        scheme,
        elements: Elements::PerSpan { span: 2, tip_span: 3, hinge: 2 },
        sampling: if scheme == Scheme::Simpson { Sampling::PerElement(3) } else { Sampling::Nodes },
        softness: Softness::Fixed(1e-3),
        physics,
    };
    let (mut model, mut state, mut work): Case =
        (Box::new(Model::EMPTY), Box::new(State::EMPTY), Box::new(Workspace::EMPTY));
    discretise(&design, &how, &mut model).expect("a valid design");
    assert!(state.fit(&model) && work.fit(&model));
    for angle in &mut state.angle[..model.node_count] {
        *angle = 0.2 * random.signed();
    }
    state.share_joints(&model);
    if physics == Physics::Extended {
        // Softer than any real finger, so that stretch and shear are seen.
        for member in &mut model.topology.members[..] {
            member.compliance = [3e-4 * (1.1 + random.signed()), 1e-3 * (1.1 + random.signed())];
            // A pin or weld has no bending to stiffen.
            member.stiffening = if member.interior > 0 { 1e-3 * random.signed() } else { 0.0 };
        }
    }
    // Strong forces: many states then have indefinite members.
    let strength = 10.0_f64.powf(1.0 + 1.5 * random.signed());
    for lambda in &mut state.lambda[..model.cells()] {
        *lambda = [strength * random.signed(), strength * random.signed()];
    }
    state.load = [10.0 * random.signed(), 10.0 * random.signed()];
    state.load_cell = (model.cells() as f64 * 0.5 * (1.0 + random.signed())) as usize;
    let mut count = 0;
    // At samples, or at places between them.
    model.fineness = 1 + (1.5 * (1.0 + random.signed())) as usize;
    for sample in 0..model.place_count() {
        if random.signed() > 1.0 - 0.4 / model.fineness as f64 && count < 8 {
            let turn = random.signed();
            work.contacts.rows[count] = Row {
                sample: sample as u16,
                direction: Direction::Normal,
                state: ContactState::Closed,
                place: model.place(sample as u16),
                gap: 0.1 * random.signed(),
                tilt: 0.0,
                normal: [-libm::cos(turn), libm::sin(turn)],
                curvature: 0.0,
                softness: model.contact_softness(),
                multiplier: 0.3 * strength * (1.01 + random.signed()),
            };
            count += 1;
        }
    }
    work.contacts.count = count;
    if random.signed() > 0.0 {
        // With friction.
        work.history.slip.coefficient = 0.5;
        work.history.slip.pair(&model, &state, &mut work.contacts);
        for [tangent, _] in work.contacts.rows_mut().as_chunks_mut::<2>().0 {
            (tangent.state, tangent.multiplier) = (ContactState::Stick, 0.3 * strength * random.signed());
            tangent.gap = 0.1 * random.signed();
        }
    }
    (model, state, work)
}

/// What the angles of a row's section add to its slip, mm; none to a gap.
fn turned(model: &Model<f64, Rubbing>, state: &State<f64, Rubbing>, row: &Row<f64>) -> f64 {
    if row.direction != Direction::Tangent {
        return 0.0;
    }
    let (node, arms) = slip::arms(model, row);
    arms.iter().zip(node..).filter(|(arm, _)| **arm != 0.0).map(|(arm, node)| arm * state.angle[node]).sum()
}

/// Where each unknown lives: interior angles, joint angles, λ, μ.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place {
    Node(usize),
    Joint(u16),
    Lambda(usize, usize),
    Row(usize),
}

pub(crate) fn places(model: &Model<f64, Rubbing>, rows: usize) -> Vec<Place> {
    let mut places = Vec::new();
    let mut joints = Vec::new();
    for member in model.members() {
        let nodes = member.nodes();
        places.extend((nodes.start + 1..nodes.end - 1).map(Place::Node));
        if !joints.contains(&member.end) {
            joints.push(member.end);
        }
    }
    places.extend(joints.into_iter().map(Place::Joint));
    places.extend((0..model.cells()).flat_map(|cell| [Place::Lambda(cell, 0), Place::Lambda(cell, 1)]));
    places.extend((0..rows).map(Place::Row));
    places
}

fn add(
    model: &Model<f64, Rubbing>,
    state: &mut State<f64, Rubbing>,
    work: &mut Workspace<f64, Rubbing>,
    place: Place,
    by: f64,
) {
    match place {
        Place::Node(node) => state.angle[node] += by,
        Place::Joint(joint) => {
            for member in model.members() {
                if member.start == joint {
                    state.angle[usize::from(member.first)] += by;
                }
                if member.end == joint {
                    state.angle[member.nodes().end - 1] += by;
                }
            }
        }
        Place::Lambda(cell, i) => state.lambda[cell][i] += by,
        Place::Row(row) => work.contacts.rows[row].multiplier += by,
    }
}

fn rotated(v: [f64; 2], a: f64) -> [f64; 2] {
    [a.cos() * v[0] - a.sin() * v[1], a.sin() * v[0] + a.cos() * v[1]]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// L written as a sum over links: with f the force per weight at a node, each adds l (f·e − ½ ((f·e)²/EA + (f·e′)²/κGA)),
/// less t/2 f·e times the bending energies that it carries, each rigid part f·r; the closures' and gaps' constants complete it. Normals, g₀ and P₀ are frozen.
fn lagrangian(
    model: &Model<f64, Rubbing>,
    state: &State<f64, Rubbing>,
    work: &Workspace<f64, Rubbing>,
    frozen: &[[f64; 2]],
) -> f64 {
    let rows = &work.contacts.rows[..work.contacts.count];
    fn sample(row: &Row<f64>) -> &Sample<f64> {
        &row.place
    }
    let mut value = 0.0;
    for (index, member) in model.members().iter().enumerate() {
        let mut force = [0.0; 2];
        for term in member.terms() {
            let [x, y] = state.lambda[usize::from(term.closure)];
            force = [force[0] + term.sign * x, force[1] + term.sign * y];
        }
        let is_front = matches!(member.role, Role::Front(_));
        if is_front {
            for row in rows.iter().filter(|row| usize::from(sample(row).cell) > index) {
                force = [force[0] - row.multiplier * row.normal[0], force[1] - row.multiplier * row.normal[1]];
            }
            if state.load_cell >= index {
                force = [force[0] - state.load[0], force[1] - state.load[1]];
            }
        }
        let nodes = member.nodes();
        for i in nodes.clone() {
            for j in i + 1..(i + 3).min(nodes.end) {
                value -= 0.5 * model.coupling[i][j - i - 1] * (state.angle[j] - state.angle[i]).powi(2);
            }
            let l = model.weight[i];
            // Bending energies that the force at this node softens: the element around it, or the springs it carries.
            let spring = |i: usize| {
                let theta = &state.angle;
                let mut q = -model.coupling[i][0] * (theta[i + 1] - theta[i]).powi(2);
                if member.kind == Kind::Quadratic {
                    q -= model.coupling[i + 1][0] * (theta[i + 2] - theta[i + 1]).powi(2);
                    q -= model.coupling[i][1] * (theta[i + 2] - theta[i]).powi(2);
                }
                q
            };
            let mut carried = 0.0;
            if member.kind == Kind::Quadratic {
                if (i - nodes.start) % 2 == 1 {
                    carried += spring(i - 1);
                }
            } else {
                if l != 0.0 && i > nodes.start {
                    carried += spring(i - 1);
                }
                if i + 1 < nodes.end && model.weight[i + 1] == 0.0 {
                    carried += spring(i);
                }
            }
            if l == 0.0 {
                continue;
            }
            let mut f = force;
            for row in rows.iter().filter(|row| is_front && usize::from(sample(row).cell) == index) {
                let first = usize::from(sample(row).node);
                let w = if i < first { l } else { sample(row).weights.get(i - first).copied().unwrap_or(0.0) };
                for k in 0..2 {
                    f[k] -= row.multiplier * row.normal[k] * w / l;
                }
            }
            let e = rotated(model.direction[i], state.angle[i]);
            let (along, across) = (dot(f, e), dot(f, [-e[1], e[0]]));
            let [stretch, shear] = member.compliance;
            value -= 0.5 * member.stiffening * carried * along;
            value += l * (along - 0.5 * (stretch * along * along + shear * across * across));
        }
        value += dot(force, rotated(member.rigid_start, state.angle[nodes.start]));
        let end = rotated(member.rigid_end, state.angle[nodes.end - 1]);
        value += dot(force, end);
        for row in rows.iter().filter(|row| is_front && usize::from(sample(row).cell) == index) {
            value -= sample(row).rigid * row.multiplier * dot(row.normal, end);
        }
    }
    for (lambda, closure) in state.lambda.iter().zip(model.topology.closures()) {
        value -= dot(*lambda, closure.rest);
    }
    for (row, at) in rows.iter().zip(frozen) {
        let gap = row.gap + dot(row.normal, [model.base[0] - at[0], model.base[1] - at[1]]);
        let gap = gap + turned(model, state, row);
        value -= row.multiplier * gap + 0.5 * row.softness * row.multiplier.powi(2);
    }
    value - dot(state.load, model.base)
}

/// Gradient of the frozen Lagrangian as the product computes it.
fn gradient(
    model: &Model<f64, Rubbing>,
    state: &State<f64, Rubbing>,
    work: &mut Workspace<f64, Rubbing>,
    frozen: &[[f64; 2]],
    places: &[Place],
) -> Vec<f64> {
    let Workspace { kinematics, contacts, residual, history, .. } = work;
    kinematics.direct(model, state);
    kinematics.place_front::<Tangents>(model, &history.memory, state, contacts.rows());
    slip::turn(model, kinematics, contacts.rows());
    kinematics.complete::<Tangents>(model, &history.memory, state);
    residual.gather(model, kinematics, contacts, &Sweep::NONE);
    let value = |place: &Place| match *place {
        Place::Node(node) => work.kinematics.nodes[node].gradient,
        Place::Joint(joint) => work.residual.joints[usize::from(joint)],
        Place::Lambda(cell, i) => work.residual.closure[cell][i],
        Place::Row(j) => {
            let row = &work.contacts.rows[j];
            let p = work.kinematics.position(model, &row.place);
            let moved = row.normal[0] * (p.x - frozen[j][0]) + row.normal[1] * (p.y - frozen[j][1]);
            -(row.gap + moved + turned(model, state, row)) - row.softness * row.multiplier
        }
    };
    places.iter().map(value).collect()
}

/// Where the gaps are measured from: any point does, the rows' constants being random.
pub(crate) fn frozen_points(work: &Workspace<f64, Rubbing>) -> Vec<[f64; 2]> {
    (0..work.contacts.count).map(|j| [-3.0 - j as f64, 20.0 + 5.0 * j as f64]).collect()
}

#[test]
fn the_gradient_is_the_lagrangians_derivative() {
    let mut random = Random::new(11);
    for _ in 0..40 {
        let (model, mut state, mut work) = random_model(&mut random);
        let places = places(&model, work.contacts.count);
        let frozen = frozen_points(&work);
        let exact = gradient(&model, &state, &mut work, &frozen, &places);
        let size = exact.iter().fold(1.0_f64, |m, g| m.max(g.abs()));
        for (place, exact) in places.iter().zip(exact) {
            let h = 1e-5;
            let mut at = |by: f64| {
                add(&model, &mut state, &mut work, *place, by);
                let value = lagrangian(&model, &state, &work, &frozen);
                add(&model, &mut state, &mut work, *place, -by);
                value
            };
            // Fourth-order central difference.
            let difference = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
            assert!((difference - exact).abs() < 1e-6 * size, "{place:?}: {difference} against {exact}");
        }
    }
}

/// Dense KKT matrix by differences of the gradient (already checked).
pub(crate) fn dense(
    model: &Model<f64, Rubbing>,
    state: &mut State<f64, Rubbing>,
    work: &mut Workspace<f64, Rubbing>,
    frozen: &[[f64; 2]],
    places: &[Place],
) -> DMatrix<f64> {
    let n = places.len();
    let mut matrix = DMatrix::<f64>::zeros(n, n);
    let h = 1e-4;
    for (k, place) in places.iter().enumerate() {
        let mut at = |by: f64| {
            add(model, state, work, *place, by);
            let value = gradient(model, state, work, frozen, places);
            add(model, state, work, *place, -by);
            value
        };
        let (a, b, c, d) = (at(h), at(-h), at(2.0 * h), at(-2.0 * h));
        for i in 0..n {
            matrix[(i, k)] = (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h);
        }
    }
    0.5 * (&matrix + matrix.transpose())
}

#[test]
fn inertia_and_step_agree_with_dense_algebra_on_1000_states() {
    let mut random = Random::new(12);
    let (mut compared, mut indefinite, mut steps, mut worst) = (0, 0, 0, 0.0_f64);
    while compared < 1000 {
        let (model, mut state, mut work) = random_model(&mut random);
        let mut factored = factored_for(&model);
        let places = places(&model, work.contacts.count);
        let frozen = frozen_points(&work);
        let matrix = dense(&model, &mut state, &mut work, &frozen, &places);
        let eigenvalues = matrix.clone().symmetric_eigenvalues();
        // A state within rounding of a singular matrix has no inertia to agree on.
        if eigenvalues.iter().any(|v| v.abs() < 1e-5) {
            continue;
        }
        compared += 1;
        let dense_negative = eigenvalues.iter().filter(|v| **v < 0.0).count();

        let g = gradient(&model, &state, &mut work, &frozen, &places);
        // What the sweep would have found.
        for (j, value) in g[places.len() - work.contacts.count..].iter().enumerate() {
            work.contacts.rows[j].gap = -value - work.contacts.rows[j].softness * work.contacts.rows[j].multiplier;
        }
        let negative = work.factorise(&model, &mut factored, Diagonal::of(Hessian::Newton, 0.0));
        let rows = work.contacts.count;
        let mut d: Vec<f64> = factored.border.flexibility.to_vec();
        let mut order = vec![0; rows];
        let border = symmetric::factorise(&mut d, rows, Rubbing::CONTACTS, &mut order);
        assert_eq!(negative + rows - border, dense_negative, "negative eigenvalues of the whole KKT");
        indefinite += usize::from(dense_negative != 2 * model.cells() + rows);

        // The whole step with every row active.
        let mut row_delta: Vec<f64> = work.right.rows[..rows].to_vec();
        let mut scratch = vec![0.0; rows];
        symmetric::solve(&d, rows, Rubbing::CONTACTS, &order, &mut row_delta, &mut scratch);
        work.solution.delta[..rows].copy_from_slice(&row_delta);
        let Workspace { kinematics, contacts, right, solution, increment, .. } = &mut *work;
        let at = Evaluated { model: &model, kinematics, contacts };
        increment.find(at, &factored.kkt, &factored.border, right, &solution.delta);
        let Some(exact) = matrix.clone().lu().solve(&-DVector::from_vec(g)) else { continue };
        let size = exact.amax();
        let condition = eigenvalues.amax() / eigenvalues.iter().fold(f64::MAX, |m, v| m.min(v.abs()));
        if condition > 1e8 {
            continue;
        }
        steps += 1;
        for (place, exact) in places.iter().zip(exact.iter()) {
            let found = match *place {
                Place::Node(node) => work.increment.angle[node],
                Place::Joint(joint) => work.increment.joints[usize::from(joint)],
                Place::Lambda(cell, i) => {
                    work.increment.joints[usize::from(model.topology.closures()[cell].unknown) + i]
                }
                Place::Row(row) => work.solution.delta[row],
            };
            worst = worst.max((found - exact).abs() / size);
            assert!((found - exact).abs() < 1e-4 * size, "{place:?}: {found} against {exact}");
        }
    }
    std::println!("{compared} states, {indefinite} not stable, {steps} steps compared, worst difference {worst:.1e}");
    assert!(indefinite > 200 && compared - indefinite > 200, "both kinds of states must be met: {indefinite}");
    assert!(steps > 800);
}

/// What is left of a symmetric matrix once its first unknowns are eliminated, and the eigenvalues of what was taken out.
fn eliminate(matrix: &DMatrix<f64>, first: usize) -> (DVector<f64>, DMatrix<f64>) {
    let rest = matrix.nrows() - first;
    let taken = matrix.view((0, 0), (first, first)).clone_owned();
    let beside = matrix.view((0, first), (first, rest)).clone_owned();
    let solved = taken.clone().lu().solve(&beside).expect("a regular block");
    let left = matrix.view((first, first), (rest, rest)) - beside.transpose() * solved;
    (taken.symmetric_eigenvalues(), left)
}

/// Negative pivots of condensation, banded factorisation and border, each against the eigenvalues of the block that it eliminates.
#[test]
fn every_stage_has_the_inertia_of_its_block() {
    let mut random = Random::new(21);
    let (mut compared, mut met) = (0, [0; 3]);
    while compared < 300 {
        let (model, mut state, mut work) = random_model(&mut random);
        let mut factored = factored_for(&model);
        if work.contacts.count == 0 {
            continue;
        }
        let places = places(&model, work.contacts.count);
        let frozen = frozen_points(&work);
        let matrix = dense(&model, &mut state, &mut work, &frozen, &places);
        let interior = places.iter().filter(|place| matches!(place, Place::Node(_))).count();
        let condensed = places.len() - work.contacts.count - interior;
        let (members, left) = eliminate(&matrix, interior);
        let (banded, border) = eliminate(&left, condensed);
        // A block within rounding of a singular one has no inertia to agree on.
        let border = border.symmetric_eigenvalues();
        if members.iter().chain(&banded).chain(&border).any(|value| value.abs() < 1e-4) {
            continue;
        }
        compared += 1;
        let negative = |values: &DVector<f64>| values.iter().filter(|value| **value < 0.0).count();

        gradient(&model, &state, &mut work, &frozen, &places);
        let diagonal = Diagonal::of(Hessian::Newton, 0.0);
        factored.kkt.curved = true;
        let mut condense = |index| factored.kkt.condense(&model, &work.kinematics, index, diagonal).1;
        let found = (0..model.topology.member_count()).map(&mut condense).sum();
        assert_eq!(negative(&members), found, "members");
        assert_eq!(negative(&banded), work.factorise(&model, &mut factored, diagonal) - found, "banded system");
        let rows = work.contacts.count;
        let mut order = vec![0; rows];
        let flexibility =
            symmetric::factorise(&mut factored.border.flexibility.to_vec(), rows, Rubbing::CONTACTS, &mut order);
        // D is the block with its sign changed.
        assert_eq!(negative(&border), rows - flexibility, "border");
        let odd = [found > 0, negative(&banded) != 2 * model.cells(), flexibility > 0];
        met.iter_mut().zip(odd).for_each(|(met, odd)| *met += usize::from(odd));
    }
    std::println!("{compared} states, of an unusual inertia: {met:?}");
    assert!(met.iter().all(|&met| met > 20), "{met:?}");
}

#[test]
fn members_share_their_joints() {
    let mut random = Random::new(13);
    for _ in 0..20 {
        let (model, state, _) = random_model(&mut random);
        for a in model.members() {
            for b in model.members() {
                if b.start == a.end {
                    assert_eq!(state.angle[usize::from(b.first)], state.angle[a.nodes().end - 1]);
                }
            }
            if a.start == CLAMPED {
                assert_eq!(state.angle[usize::from(a.first)], 0.0);
            }
        }
    }
}

/// Directions after a small step are the same by its increments as from their sines.
#[test]
fn directions_turned_by_the_increments_are_those_of_the_angles() {
    let mut random = Random::new(12);
    let mut worst = 0.0_f64;
    for _ in 0..40 {
        let (model, mut state, mut work) = random_model(&mut random);
        let found = &mut work.kinematics;
        found.direct(&model, &state);
        let increments: Vec<f64> = (0..model.node_count).map(|_| kinematics::SMALL * random.signed()).collect();
        for (angle, delta) in state.angle.iter_mut().zip(&increments) {
            *angle += delta;
        }
        found.turn(&model, &increments);
        let turned: Vec<[f64; 2]> = found.nodes[..model.node_count].iter().map(|node| node.e).collect();
        found.direct(&model, &state);
        for (node, turned) in found.nodes.iter().zip(&turned) {
            worst = worst.max((node.e[0] - turned[0]).abs()).max((node.e[1] - turned[1]).abs());
        }
    }
    assert!(worst <= 5e-16, "{worst:e}");
}

/// Two patches whose normals are off by opposite angles, as a block's two corners are: the beam between them is pushed wrongly, which
/// the sum of both does not show.
#[test]
fn opposite_tilts_of_two_contacts_do_not_make_up_for_each_other() {
    let (model, _, mut work) = random_model(&mut Random::new(3));
    let last = model.sample_count as u16 - 1;
    let row = |sample, tilt| Row {
        sample,
        state: ContactState::Closed,
        tilt,
        normal: [-1.0, 0.0],
        multiplier: 2.0,
        ..Row::BLANK
    };
    let mut misdirected = |rows: &[Row<f64>]| {
        let contacts: &mut Contacts<f64, Rubbing> = &mut work.contacts;
        contacts.rows[..rows.len()].copy_from_slice(rows);
        contacts.count = rows.len();
        contacts.misdirected(&model)
    };
    let [low, high] = [last / 4, 3 * (last / 4)];
    let alone = misdirected(&[row(high, -1e-3)]);
    assert!(alone > 1e-4, "{alone}");
    assert!(misdirected(&[row(low, 1e-3), row(high, -1e-3)]) >= alone);
    assert!(misdirected(&[row(low, -1e-3), row(high, -1e-3)]) >= 2.0 * alone);
    assert!(misdirected(&[row(low, f64::NAN), row(high, 1e-3)]).is_nan());
    assert_eq!(misdirected(&[row(low, 0.0), row(high, 0.0)]), 0.0);
}
