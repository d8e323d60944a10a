//! The step against dense linear algebra and finite differences, on random states.

use std::boxed::Box;
use std::vec::Vec;

use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::condense::Diagonal;
use super::residual::{self, Sweep};
use super::{Workspace, active_set, step};
use crate::contact::Row;
use crate::design::{HingeFrom, HingeKind};
use crate::discretise::{Discretisation, Elements, Physics, Sampling, Scheme, discretise};
use crate::ladder::{CLAMPED, Ladder, State};
use crate::size::{Paper, Size};

type Model = (Box<Ladder<f64, Paper>>, Box<State<f64, Paper>>, Box<Workspace<f64, Paper>>);

struct Random(ChaCha8Rng);

impl Random {
    /// Uniform in −1 … 1.
    fn signed(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A random model in a random state with random contact rows.
fn random_model(random: &mut Random) -> Model {
    let mut design = crate::design::tests::ladder_80();
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
    let scheme = [Scheme::Paper, Scheme::Trapezoid, Scheme::Simpson][(1.5 * (1.0 + random.signed())) as usize % 3];
    let how = Discretisation {
        scheme,
        elements: Elements::PerSpan { span: 2, tip_span: 3, hinge: 2 },
        sampling: if scheme == Scheme::Simpson { Sampling::PerElement(3) } else { Sampling::Nodes },
        softness: 1e-3,
        physics,
    };
    let (mut ladder, mut state, mut work): Model =
        (Box::new(Ladder::EMPTY), Box::new(State::EMPTY), Box::new(Workspace::EMPTY));
    discretise(&design, &how, &mut ladder).expect("a valid design");
    assert!(state.fit(&ladder) && work.fit(&ladder));
    for angle in &mut state.angle[..ladder.node_count] {
        *angle = 0.2 * random.signed();
    }
    step::share_joints(&ladder, &mut state);
    for index in 0..ladder.member_count() {
        if ladder.members[index].axial > 0.0 {
            state.stretch[index] = 0.01 * random.signed();
        }
    }
    // Strong forces: many states then have indefinite members.
    let strength = 10.0_f64.powf(1.0 + 1.5 * random.signed());
    for lambda in &mut state.lambda[..ladder.cells] {
        *lambda = [strength * random.signed(), strength * random.signed()];
    }
    state.load = [10.0 * random.signed(), 10.0 * random.signed()];
    state.load_cell = (ladder.cells as f64 * 0.5 * (1.0 + random.signed())) as usize;
    let mut count = 0;
    for sample in 0..ladder.sample_count {
        if random.signed() > 0.6 && count < 8 {
            let turn = random.signed();
            work.rows[count] = Row {
                sample: sample as u16,
                gap: 0.1 * random.signed(),
                normal: [-libm::cos(turn), libm::sin(turn)],
                curvature: 0.0,
                softness: ladder.softness,
                multiplier: 0.3 * strength * (1.01 + random.signed()),
            };
            count += 1;
        }
    }
    work.row_count = count;
    (ladder, state, work)
}

/// Where each unknown lives: interior angles, joint angles, stretches, λ, μ.
#[derive(Clone, Copy, Debug)]
enum Place {
    Node(usize),
    Joint(u16),
    Stretch(usize),
    Lambda(usize, usize),
    Row(usize),
}

fn places(ladder: &Ladder<f64, Paper>, rows: usize) -> Vec<Place> {
    let mut places = Vec::new();
    let mut joints = Vec::new();
    for (index, member) in ladder.members[..ladder.member_count()].iter().enumerate() {
        let nodes = member.nodes();
        places.extend((nodes.start + 1..nodes.end - 1).map(Place::Node));
        if !joints.contains(&member.end) {
            joints.push(member.end);
        }
        if member.axial > 0.0 {
            places.push(Place::Stretch(index));
        }
    }
    places.extend(joints.into_iter().map(Place::Joint));
    places.extend((0..ladder.cells).flat_map(|cell| [Place::Lambda(cell, 0), Place::Lambda(cell, 1)]));
    places.extend((0..rows).map(Place::Row));
    places
}

fn add(
    ladder: &Ladder<f64, Paper>,
    state: &mut State<f64, Paper>,
    work: &mut Workspace<f64, Paper>,
    place: Place,
    by: f64,
) {
    match place {
        Place::Node(node) => state.angle[node] += by,
        Place::Joint(joint) => {
            for member in &ladder.members[..ladder.member_count()] {
                if member.start == joint {
                    state.angle[usize::from(member.first)] += by;
                }
                if member.end == joint {
                    state.angle[member.nodes().end - 1] += by;
                }
            }
        }
        Place::Stretch(index) => state.stretch[index] += by,
        Place::Lambda(cell, i) => state.lambda[cell][i] += by,
        Place::Row(row) => work.rows[row].multiplier += by,
    }
}

/// Points of the ladder computed straight from its constants: (front joint positions, closures, sample positions).
fn geometry(ladder: &Ladder<f64, Paper>, state: &State<f64, Paper>) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
    let rotated = |v: [f64; 2], a: f64| [a.cos() * v[0] - a.sin() * v[1], a.sin() * v[0] + a.cos() * v[1]];
    let vector = |index: usize| {
        let member = &ladder.members[index];
        let nodes = member.nodes();
        let a = rotated(member.rigid_start, state.angle[nodes.start]);
        let b = rotated(member.rigid_end, state.angle[nodes.end - 1]);
        let mut d = [a[0] + b[0], a[1] + b[1]];
        for node in nodes {
            let e = rotated(ladder.direction[node], state.angle[node]);
            for i in 0..2 {
                d[i] += (1.0 + state.stretch[index]) * ladder.weight[node] * e[i];
            }
        }
        d
    };
    let mut starts = vec![ladder.base];
    let mut closures = Vec::new();
    let mut rung = ladder.base_rung;
    for cell in 0..ladder.cells {
        let (f, b) = (vector(4 * cell), vector(4 * cell + 1));
        let mut next = [0.0; 2];
        if cell + 1 < ladder.cells {
            for hinge in 2..4 {
                let d = vector(4 * cell + hinge);
                next = [next[0] + d[0], next[1] + d[1]];
            }
        }
        closures.push([f[0] + next[0] - b[0] - rung[0], f[1] + next[1] - b[1] - rung[1]]);
        let last = starts[cell];
        starts.push([last[0] + f[0], last[1] + f[1]]);
        rung = next;
    }
    (starts, closures)
}

fn sample_point(ladder: &Ladder<f64, Paper>, state: &State<f64, Paper>, starts: &[[f64; 2]], index: usize) -> [f64; 2] {
    let sample = &ladder.samples[index];
    let member = 4 * usize::from(sample.cell);
    let rotated = |v: [f64; 2], a: f64| [a.cos() * v[0] - a.sin() * v[1], a.sin() * v[0] + a.cos() * v[1]];
    let nodes = ladder.members[member].nodes();
    let end = rotated(ladder.members[member].rigid_end, state.angle[nodes.end - 1]);
    let mut p = starts[usize::from(sample.cell)];
    for i in 0..2 {
        p[i] += sample.rigid * end[i];
    }
    let first = usize::from(sample.node);
    for node in nodes {
        let w =
            if node < first { ladder.weight[node] } else { sample.weights.get(node - first).copied().unwrap_or(0.0) };
        let e = rotated(ladder.direction[node], state.angle[node]);
        for i in 0..2 {
            p[i] += (1.0 + state.stretch[member]) * w * e[i];
        }
    }
    p
}

/// L = V + λ·h − μ (g₀ + n·(P − P₀)) − ½ ε μ² − load·P, normals and g₀, P₀ frozen.
fn lagrangian(
    ladder: &Ladder<f64, Paper>,
    state: &State<f64, Paper>,
    work: &Workspace<f64, Paper>,
    frozen: &[[f64; 2]],
) -> f64 {
    let (starts, closures) = geometry(ladder, state);
    let mut value = 0.0;
    for (index, member) in ladder.members[..ladder.member_count()].iter().enumerate() {
        let nodes = member.nodes();
        for i in nodes.clone() {
            for j in i + 1..(i + 3).min(nodes.end) {
                value -= 0.5 * ladder.coupling[i][j - i - 1] * (state.angle[j] - state.angle[i]).powi(2);
            }
        }
        value += 0.5 * member.axial * state.stretch[index].powi(2);
    }
    for cell in 0..ladder.cells {
        for i in 0..2 {
            value += state.lambda[cell][i] * (closures[cell][i] - ladder.rest[cell][i]);
        }
    }
    for (row, at) in work.rows[..work.row_count].iter().zip(frozen) {
        let p = sample_point(ladder, state, &starts, usize::from(row.sample));
        let gap = row.gap + row.normal[0] * (p[0] - at[0]) + row.normal[1] * (p[1] - at[1]);
        value -= row.multiplier * gap + 0.5 * ladder.softness * row.multiplier.powi(2);
    }
    let loaded = starts[state.load_cell + 1];
    value - state.load[0] * loaded[0] - state.load[1] * loaded[1]
}

/// Gradient of the frozen Lagrangian as the product computes it.
fn gradient(
    ladder: &Ladder<f64, Paper>,
    state: &State<f64, Paper>,
    work: &mut Workspace<f64, Paper>,
    frozen: &[[f64; 2]],
    places: &[Place],
) -> Vec<f64> {
    residual::kinematics(ladder, state, work);
    let sweep = Sweep { nearest: 0.0, normal: [0.0; 2], nearest_free: 0.0, overflow: false, crowded: false };
    residual::gradient(ladder, state, work, &sweep);
    let value = |place: &Place| match *place {
        Place::Node(node) => work.gradient[node],
        Place::Joint(joint) => work.rhs[usize::from(joint)],
        Place::Stretch(index) => work.members[index].stretch_gradient,
        Place::Lambda(cell, i) => work.closure[cell][i],
        Place::Row(j) => {
            let row = &work.rows[j];
            let p = residual::sample_position(ladder, state, work, &ladder.samples[usize::from(row.sample)]);
            let moved = row.normal[0] * (p.x - frozen[j][0]) + row.normal[1] * (p.y - frozen[j][1]);
            -(row.gap + moved) - ladder.softness * row.multiplier
        }
    };
    places.iter().map(value).collect()
}

fn frozen_points(
    ladder: &Ladder<f64, Paper>,
    state: &State<f64, Paper>,
    work: &Workspace<f64, Paper>,
) -> Vec<[f64; 2]> {
    let (starts, _) = geometry(ladder, state);
    work.rows[..work.row_count]
        .iter()
        .map(|row| sample_point(ladder, state, &starts, usize::from(row.sample)))
        .collect()
}

#[test]
fn the_gradient_is_the_lagrangians_derivative() {
    let mut random = Random(ChaCha8Rng::seed_from_u64(11));
    for _ in 0..40 {
        let (ladder, mut state, mut work) = random_model(&mut random);
        let places = places(&ladder, work.row_count);
        let frozen = frozen_points(&ladder, &state, &work);
        let exact = gradient(&ladder, &state, &mut work, &frozen, &places);
        let size = exact.iter().fold(1.0_f64, |m, g| m.max(g.abs()));
        for (place, exact) in places.iter().zip(exact) {
            let h = 1e-5;
            let mut at = |by: f64| {
                add(&ladder, &mut state, &mut work, *place, by);
                let value = lagrangian(&ladder, &state, &work, &frozen);
                add(&ladder, &mut state, &mut work, *place, -by);
                value
            };
            // Fourth-order central difference.
            let difference = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
            assert!((difference - exact).abs() < 1e-6 * size, "{place:?}: {difference} against {exact}");
        }
    }
}

/// Dense KKT matrix by differences of the gradient (already checked).
fn dense(
    ladder: &Ladder<f64, Paper>,
    state: &mut State<f64, Paper>,
    work: &mut Workspace<f64, Paper>,
    frozen: &[[f64; 2]],
    places: &[Place],
) -> DMatrix<f64> {
    let n = places.len();
    let mut matrix = DMatrix::<f64>::zeros(n, n);
    let h = 1e-4;
    for (k, place) in places.iter().enumerate() {
        let mut at = |by: f64| {
            add(ladder, state, work, *place, by);
            let value = gradient(ladder, state, work, frozen, places);
            add(ladder, state, work, *place, -by);
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
    let mut random = Random(ChaCha8Rng::seed_from_u64(12));
    let (mut compared, mut indefinite, mut steps) = (0, 0, 0);
    while compared < 1000 {
        let (ladder, mut state, mut work) = random_model(&mut random);
        let places = places(&ladder, work.row_count);
        let frozen = frozen_points(&ladder, &state, &work);
        let matrix = dense(&ladder, &mut state, &mut work, &frozen, &places);
        let eigenvalues = matrix.clone().symmetric_eigenvalues();
        // A state within rounding of a singular matrix has no inertia to agree on.
        if eigenvalues.iter().any(|v| v.abs() < 1e-5) {
            continue;
        }
        compared += 1;
        let dense_negative = eigenvalues.iter().filter(|v| **v < 0.0).count();

        let g = gradient(&ladder, &state, &mut work, &frozen, &places);
        let negative = step::factorise(&ladder, &state, &mut work, Diagonal { curvature: 1.0, shift: 0.0 });
        let rows = work.row_count;
        let mut d: Vec<f64> = work.flexibility.to_vec();
        let mut order = vec![0; rows];
        let border = active_set::factorise(&mut d, rows, Paper::CONTACTS, &mut order);
        assert_eq!(negative + rows - border, dense_negative, "negative eigenvalues of the whole KKT");
        indefinite += usize::from(dense_negative != 2 * ladder.cells + rows);

        // The whole step with every row active.
        let mut row_delta: Vec<f64> = work.row_rhs[..rows].to_vec();
        let mut scratch = vec![0.0; rows];
        active_set::solve(&d, rows, Paper::CONTACTS, &order, &mut row_delta, &mut scratch);
        work.row_delta[..rows].copy_from_slice(&row_delta);
        step::increments(&ladder, &state, &mut work);
        let Some(exact) = matrix.clone().lu().solve(&-DVector::from_vec(g)) else { continue };
        let size = exact.amax();
        let condition = eigenvalues.amax() / eigenvalues.iter().fold(f64::MAX, |m, v| m.min(v.abs()));
        if condition > 1e8 {
            continue;
        }
        steps += 1;
        for (place, exact) in places.iter().zip(exact.iter()) {
            let found = match *place {
                Place::Node(node) => work.delta[node],
                Place::Joint(joint) => work.rhs[usize::from(joint)],
                Place::Stretch(index) => work.stretch_delta[index],
                Place::Lambda(cell, i) => work.rhs[5 * cell + i],
                Place::Row(row) => work.row_delta[row],
            };
            assert!((found - exact).abs() < 1e-4 * size, "{place:?}: {found} against {exact}");
        }
    }
    std::println!("{compared} states, {indefinite} not stable, {steps} steps compared");
    assert!(indefinite > 200 && compared - indefinite > 200, "both kinds of states must be met: {indefinite}");
    assert!(steps > 800);
}

#[test]
fn members_share_their_joints() {
    let mut random = Random(ChaCha8Rng::seed_from_u64(13));
    for _ in 0..20 {
        let (ladder, state, _) = random_model(&mut random);
        for a in &ladder.members[..ladder.member_count()] {
            for b in &ladder.members[..ladder.member_count()] {
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
