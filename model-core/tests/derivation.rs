//! Equations of `docs/derivation.md` by quadrature, differences and dense algebra; each test names those it holds.

// Every user of the examples' finger has its own copy.
#![allow(clippy::duplicate_mod)]

use model_core::design::{Design, HingeFrom, MaterialLaw, PlaneStrain, ladder_80};
use model_core::discretise::{Discretisation, Physics, Plate, plate_factor};
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::size::Paper;
use model_core::status::Status;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

struct Random(ChaCha8Rng);

impl Random {
    fn seeded(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Uniform in −1 … 1.
    fn signed(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn matrix(&mut self, rows: usize, columns: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |_, _| self.signed())
    }
}

/// Derivative by a central difference of fourth order.
fn slope(f: impl Fn(f64) -> f64, at: f64, h: f64) -> f64 {
    (8.0 * (f(at + h) - f(at - h)) - (f(at + 2.0 * h) - f(at - 2.0 * h))) / (12.0 * h)
}

/// Integral from a to b: Gauss's rule of three points on 400 intervals.
fn integral(f: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let h = (b - a) / 400.0;
    let offset = 0.5 * h * 0.6_f64.sqrt();
    let each = |k: i32| {
        let middle = a + (f64::from(k) + 0.5) * h;
        (5.0 * f(middle - offset) + 8.0 * f(middle) + 5.0 * f(middle + offset)) * h / 18.0
    };
    (0..400).map(each).sum()
}

/// Derivation (8): the Hermite curve ends on Simpson's chord, with the end orientations as tangents.
#[test]
fn samples_lie_on_the_hermite_curve_of_their_element() {
    let mut random = Random::seeded(1);
    for _ in 0..20 {
        let h = 5.0 + 4.0 * random.signed();
        let [a, m, b] = [(); 3].map(|()| 1.5 + 0.3 * random.signed());
        for axis in [f64::cos, f64::sin] {
            let [ea, em, eb] = [a, m, b].map(axis);
            let chord = h / 6.0 * (ea + 4.0 * em + eb);
            let place = |xi: f64| {
                xi * xi * (3.0 - 2.0 * xi) * chord + h * (xi * (1.0 - xi) * (1.0 - xi) * ea + xi * xi * (xi - 1.0) * eb)
            };
            assert!(place(0.0).abs() < 1e-15 && (place(1.0) - chord).abs() < 1e-13);
            assert!((slope(place, 0.0, 1e-3) - h * ea).abs() < 1e-9);
            assert!((slope(place, 1.0, 1e-3) - h * eb).abs() < 1e-9);
        }
    }
}

/// Energy of a fibre over Young's modulus, against its nominal strain.
type Energy = fn(f64) -> f64;

/// Derivation (9): each law's energy has the coefficient c in third order.
#[test]
fn the_laws_have_their_coefficients() {
    let energies: [(MaterialLaw, Energy); 3] = [
        (MaterialLaw::StVenantKirchhoff, |u| 0.5 * (u + 0.5 * u * u).powi(2)),
        (MaterialLaw::NeoHookean, |u| ((1.0 + u).powi(2) + 2.0 / (1.0 + u) - 3.0) / 6.0),
        (MaterialLaw::Linear, |u| 0.5 * u * u),
    ];
    for (law, energy) in energies {
        // The odd part of the energy is ½ c u³ and beyond.
        for u in [0.01, 0.02] {
            let c = (energy(u) - energy(-u)) / (u * u * u);
            assert!((c - law.second_order()).abs() < 10.0 * u * u, "{law:?}: {c}");
        }
    }
}

/// Derivation (10): the section's integral.
#[test]
fn a_stretched_section_bends_more_stiffly() {
    let (e, w, t) = (49.5, 20.0, 2.0);
    let (area, inertia) = (w * t, w * t * t * t / 12.0);
    for (c, stretch, bend) in [(1.0, 0.01, 0.05), (-2.0 / 3.0, -0.02, 0.1), (1.0, -0.005, -0.08)] {
        let fibre = |y: f64| {
            let u = stretch + y * bend;
            0.5 * e * w * (u * u + c * u * u * u)
        };
        let found = integral(fibre, -0.5 * t, 0.5 * t);
        let stated = 0.5 * e * area * stretch * stretch
            + 0.5 * e * inertia * bend * bend * (1.0 + 3.0 * c * stretch)
            + 0.5 * c * e * area * stretch.powi(3);
        assert!((found / stated - 1.0).abs() < 1e-12, "{found} and {stated}");
    }
}

/// Derivation (13): a quadratic element's energy is its interpolation's.
#[test]
fn a_quadratic_element_has_the_energy_of_its_interpolation() {
    let mut random = Random::seeded(2);
    for _ in 0..20 {
        let h = 5.0 + 4.0 * random.signed();
        let [a, m, b] = [(); 3].map(|()| random.signed());
        let bend = |s: f64| ((4.0 * m - 3.0 * a - b) + 4.0 * (a - 2.0 * m + b) * s / h) / h;
        let found = integral(|s| bend(s).powi(2), 0.0, h);
        let springs = (8.0 * (m - a).powi(2) + 8.0 * (b - m).powi(2) - (b - a).powi(2)) / (3.0 * h);
        let form = (7.0 * a * a + 16.0 * m * m + 7.0 * b * b - 16.0 * a * m - 16.0 * m * b + 2.0 * a * b) / (3.0 * h);
        assert!((found - springs).abs() < 1e-12 * (1.0 + found) && (found - form).abs() < 1e-12 * (1.0 + found));
    }
}

/// A node with the element it carries: what derivation (16) to (21) are about.
struct Node {
    length: f64,
    /// EA and κGA.
    stiffness: [f64; 2],
    law: f64,
    /// EI of its element over 3h, and the element's angles at start and end.
    bending: f64,
    ends: [f64; 2],
}

impl Node {
    fn random(random: &mut Random) -> Self {
        let stiffness = [300.0 + 200.0 * random.signed(), 100.0 + 60.0 * random.signed()];
        let (length, bending) = (4.0 + random.signed(), 80.0 + 40.0 * random.signed());
        Self { length, stiffness, law: random.signed(), bending, ends: [0.1 * random.signed(), 0.1 * random.signed()] }
    }

    /// q, and its derivative with the node's angle.
    fn q(&self, angle: f64) -> [f64; 2] {
        let [a, b] = self.ends;
        let value = 8.0 * (angle - a).powi(2) + 8.0 * (b - angle).powi(2) - (b - a).powi(2);
        [self.bending * value, self.bending * 16.0 * (2.0 * angle - a - b)]
    }

    /// (16) at given strains.
    fn share(&self, angle: f64, force: [f64; 2], [stretch, shear]: [f64; 2]) -> f64 {
        let ([a, b], [ea, ga], [q, _]) = (pulls(angle, force), self.stiffness, self.q(angle));
        0.5 * q * (1.0 + 3.0 * self.law * stretch)
            + self.length * (0.5 * ea * stretch * stretch + 0.5 * ga * shear * shear + (1.0 + stretch) * a + shear * b)
    }

    /// η (17), 1/EA and 1/κGA.
    fn shortening(&self, angle: f64) -> [f64; 3] {
        let [ea, ga] = self.stiffness;
        [3.0 * self.law / ea * self.q(angle)[0] / (2.0 * self.length), 1.0 / ea, 1.0 / ga]
    }

    /// ℓψ (18).
    fn psi(&self, angle: f64, force: [f64; 2]) -> f64 {
        let ([a, b], [eta, stretch, shear]) = (pulls(angle, force), self.shortening(angle));
        self.length * ((1.0 - eta) * a - 0.5 * (stretch * a * a + shear * b * b))
    }

    /// d (20).
    fn direction(&self, angle: f64, force: [f64; 2]) -> [f64; 2] {
        let ([a, b], [eta, stretch, shear]) = (pulls(angle, force), self.shortening(angle));
        let (along, across) = (1.0 - eta - stretch * a, -shear * b);
        let (sin, cos) = angle.sin_cos();
        [along * cos - across * sin, along * sin + across * cos]
    }
}

/// f·e and f·e′.
fn pulls(angle: f64, force: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [force[0] * cos + force[1] * sin, force[1] * cos - force[0] * sin]
}

/// Derivation (16) to (18): stationary in the strains, the share is ½q + ℓψ − ½ℓEA η².
#[test]
fn stretch_and_shear_are_eliminated() {
    let mut random = Random::seeded(3);
    for _ in 0..100 {
        let node = Node::random(&mut random);
        let (angle, force) = (random.signed(), [20.0 * random.signed(), 20.0 * random.signed()]);
        let ([a, b], [ea, ga], [eta, ..]) = (pulls(angle, force), node.stiffness, node.shortening(angle));
        let (stretch, shear) = (-a / ea - eta, -b / ga);
        let size = node.length * ea;
        let stationary = [
            slope(|x| node.share(angle, force, [x, shear]), stretch, 1e-3),
            slope(|x| node.share(angle, force, [stretch, x]), shear, 1e-3),
        ];
        assert!(stationary.iter().all(|s| s.abs() < 1e-9 * size), "{stationary:?}");
        let stated = 0.5 * node.q(angle)[0] + node.psi(angle, force) - 0.5 * node.length * ea * eta * eta;
        let found = node.share(angle, force, [stretch, shear]);
        assert!((found - stated).abs() < 1e-12 * size, "{found} and {stated}");
    }
}

/// Derivation (19) to (21): first and second derivatives, those through q with them.
#[test]
fn a_nodes_derivatives_are_those_of_its_share() {
    let mut random = Random::seeded(4);
    let h = 1e-3;
    for _ in 0..100 {
        let node = Node::random(&mut random);
        let (angle, force) = (random.signed(), [20.0 * random.signed(), 20.0 * random.signed()]);
        let close = |found: f64, stated: f64, what: &str| {
            assert!((found - stated).abs() < 1e-7 * (1.0 + found.abs()), "{what}: {found} and {stated}");
        };
        let ([a, b], [eta, stretch, shear]) = (pulls(angle, force), node.shortening(angle));
        let ([q, dq], k, zeta) = (node.q(angle), stretch - shear, 3.0 * node.law * stretch);
        let (l, ddq) = (node.length, 32.0 * node.bending);
        let (sin, cos) = angle.sin_cos();

        let gradient = l * b * (1.0 - eta - k * a) - 0.5 * zeta * a * dq;
        close(slope(|x| node.psi(x, force), angle, h), gradient, "(19)");
        let d = node.direction(angle, force);
        for i in 0..2 {
            let along = |x: f64| {
                let mut moved = force;
                moved[i] = x;
                node.psi(angle, moved)
            };
            close(slope(along, force[i], 1e-2), l * d[i], "(20)");
        }
        let curvature = l * (a * (1.0 - eta - k * a) + k * b * b);
        let second = -curvature - zeta * b * dq - 0.5 * zeta * a * ddq;
        let found = slope(|x| slope(|y| node.psi(y, force), x, h), angle, h);
        assert!((found - second).abs() < 1e-5 * (1.0 + second.abs()), "(21): {found} and {second}");
        let lever = [
            l * (-(1.0 - eta - k * a) * sin - k * b * cos) - 0.5 * zeta * dq * cos,
            l * ((1.0 - eta - k * a) * cos - k * b * sin) - 0.5 * zeta * dq * sin,
        ];
        let compliance = |i: usize, j: usize| {
            let (e, across) = ([cos, sin], [-sin, cos]);
            stretch * e[i] * e[j] + shear * across[i] * across[j]
        };
        for i in 0..2 {
            close(slope(|x| l * node.direction(x, force)[i], angle, h), lever[i], "(21), lever");
            for j in 0..2 {
                let along = |x: f64| {
                    let mut moved = force;
                    moved[j] = x;
                    l * node.direction(angle, moved)[i]
                };
                close(slope(along, force[j], 1e-2), -l * compliance(i, j), "(21), compliance");
            }
        }
        assert!(q.is_finite());
    }
}

fn negative(matrix: &DMatrix<f64>) -> usize {
    matrix.clone().symmetric_eigenvalues().iter().filter(|v| **v < 0.0).count()
}

/// Derivation (37) to (39): a KKT matrix in pieces, with soft and hard contacts and a turning row of either sign, counts the negative
/// eigenvalues of the energy's Hessian on the constraints.
#[test]
fn the_count_of_pivots_says_whether_the_energy_has_a_minimum() {
    let mut random = Random::seeded(5);
    let (angles, closures) = (9, 4);
    let mut met = [[0; 2]; 3];
    for _ in 0..600 {
        let contacts = 1 + (1.5 * (1.0 + random.signed())) as usize % 3;
        let softness = if random.signed() > 0.0 { 1e-3 } else { 0.0 };
        let turning = (1.5 * (1.0 + random.signed())) as usize % 3;
        let stiffness = [0.0, 2.0, -2.0][turning];
        // Mostly positive, so that both answers are met.
        let root = random.matrix(angles, angles);
        let bump = random.matrix(angles, 2);
        let hessian = &root * root.transpose() - 1.5 * &bump * bump.transpose();
        let (b, g, slide) =
            (random.matrix(angles, closures), random.matrix(angles, contacts), random.matrix(angles, 1));

        // The minimum of (14): Hessian with contact curvature, on the tangent space of closures and hard contacts, soft ones as a
        // penalty.
        let mut energy = &hessian - stiffness * &slide * slide.transpose();
        let mut constraints = b.clone();
        if softness > 0.0 {
            energy += &g * g.transpose() / softness;
        } else {
            constraints = DMatrix::from_fn(angles, closures + contacts, |i, j| {
                if j < closures { b[(i, j)] } else { g[(i, j - closures)] }
            });
        }
        let decomposed = (&constraints * constraints.transpose()).symmetric_eigen();
        let tangent: Vec<DVector<f64>> = (0..angles)
            .filter(|&i| decomposed.eigenvalues[i].abs() < 1e-9)
            .map(|i| decomposed.eigenvectors.column(i).into_owned())
            .collect();
        assert_eq!(tangent.len(), angles - constraints.ncols());
        let tangent = DMatrix::from_columns(&tangent);
        let reduced = tangent.transpose() * energy * &tangent;
        let eigenvalues = reduced.clone().symmetric_eigenvalues();
        if eigenvalues.iter().any(|v| v.abs() < 1e-3) {
            continue;
        }
        let is_stable = eigenvalues.iter().all(|v| *v > 0.0);

        // The pieces: angles and closures, then the rows' D = softness + Qᵀ A⁻¹ Q.
        let rows = contacts + usize::from(turning > 0);
        let size = angles + closures;
        let a = DMatrix::from_fn(size, size, |i, j| match (i < angles, j < angles) {
            (true, true) => hessian[(i, j)],
            (true, false) => b[(i, j - angles)],
            (false, true) => b[(j, i - angles)],
            (false, false) => 0.0,
        });
        let q = DMatrix::from_fn(size, rows, |i, j| match (i < angles, j < contacts) {
            (true, true) => g[(i, j)],
            (true, false) => slide[(i, 0)],
            _ => 0.0,
        });
        let Some(inverse) = a.clone().try_inverse() else { continue };
        let mut d = q.transpose() * inverse * &q;
        for j in 0..rows {
            d[(j, j)] += if j < contacts { softness } else { -1.0 / stiffness };
        }
        let excess = negative(&a) as isize - closures as isize;
        let border = negative(&d) as isize - isize::from(stiffness > 0.0);
        assert_eq!(excess == border, is_stable, "{excess} and {border}, s = {stiffness}");
        met[turning][usize::from(is_stable)] += 1;
    }
    assert!(met.iter().flatten().all(|&count| count > 30), "{met:?}");
}

/// Derivation (51): the force against a translated base's motion is the derivative of the energy with the contact's.
#[test]
fn a_translated_base_does_the_work() {
    let how = Discretisation::reduced(Physics::Extended);
    let mut follower: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
    follower.configure(&ladder_80(), &how).expect("a valid design");
    let direction = [0.8, 0.6];
    follower.set_object(ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 }, Motion::Translating { direction });
    assert!(follower.start(0.0));
    let mut checked = 0;
    for at in [3.0, 5.05, 7.1] {
        let mut energy = |to: f64| {
            assert_eq!(follower.follow(to).status, Status::Converged);
            let [x, y] = follower.solution().force_world();
            let arcs: Vec<u64> = follower.solution().contacts().map(|contact| contact.arc.to_bits()).collect();
            (follower.solution().potential(), direction[0] * x + direction[1] * y, arcs)
        };
        let h = 0.002;
        let all = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k| energy(at + k * h));
        // Where a sample comes or goes the energy's second derivative has a step.
        if all.iter().any(|(_, _, arcs)| *arcs != all[2].2) {
            continue;
        }
        let [a, b, (_, force, _), c, d] = &all;
        let found = (8.0 * (c.0 - b.0) - (d.0 - a.0)) / (12.0 * h);
        assert!((found / force - 1.0).abs() < 1e-7, "at {at} mm: {found} and {force}");
        checked += 1;
    }
    assert!(checked >= 2, "{checked}");
}

/// Derivation (53) to (55): the bar that the follower shows at rest has the length that the roots leave it.
#[test]
fn effective_hinges_and_bar_span_the_width() {
    let mut design = ladder_80();
    design.hinge.from = HingeFrom::Face;
    design.hinge.length.fill(1.5);
    let mut follower: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
    follower.configure(&design, &Discretisation::reduced(Physics::Extended)).expect("a valid design");
    let (root_beam, root_bar) = (0.33 * 0.8, 0.32 * 0.8);
    for (k, [front, back]) in follower.solution().lamellae().enumerate() {
        let y = 9.0 * (k + 1) as f64;
        let width = 28.0 * (1.0 - y / 80.0);
        // Half the beams' thickness of 2 mm over the sine of the angle to the horizontal lamella.
        let (s_front, s_back) = (1.0, 28.0_f64.hypot(80.0) / 80.0);
        let bar = width - s_front - s_back - 2.0 * 1.5 - 2.0 * root_bar;
        let hinge = 1.5 + root_beam + root_bar;
        assert!(((front[0] - back[0]).hypot(front[1] - back[1]) - bar).abs() < 1e-9, "lamella {k}");
        assert!((front[0] + (s_front - root_beam) + hinge).abs() < 1e-9, "lamella {k}: {front:?}");
        assert!(((s_front - root_beam) + hinge + bar + hinge + (s_back - root_beam) - width).abs() < 1e-12);
    }
}

/// Derivation (57), (58): between plane stress and plane strain, and how wide walls and long spans differ.
#[test]
fn plates_are_between_plane_stress_and_plane_strain() {
    let nu: f64 = 0.48;
    let plate = |width: f64, clear: f64| Plate { width, thickness: 2.0, clear, holders: [1.0, f64::INFINITY] };
    let with = |plane_strain, plate: &Plate| plate_factor(&Design { plane_strain, ..ladder_80() }, plate);
    let strain = 1.0 / (1.0 - nu * nu);
    assert_eq!(with(PlaneStrain::Stress, &plate(20.0, 9.0)), 1.0);
    assert!((with(PlaneStrain::Strain, &plate(20.0, 9.0)) - strain).abs() < 1e-15);
    for (width, clear) in [(2.0, 4.0), (4.8, 9.0), (20.0, 9.0), (20.0, 78.0), (60.0, 9.0)] {
        // The formula, in the hyperbolic functions that the derivation has.
        let length = 0.7 * clear + 2.0 * (2.0 + 0.25 * 2.0 / 1.0);
        let beta = 0.5 * std::f64::consts::PI * width * width / (width + 2.0) / length;
        let waves = 2.0 * beta / (2.0 * beta).sinh();
        let curled = 2.0 * (1.0 + nu) * beta.tanh() / (beta * (3.0 + nu - (1.0 - nu) * waves));
        let found = with(PlaneStrain::Auto, &plate(width, clear));
        assert!((found - (1.0 + (strain - 1.0) * (1.0 - curled))).abs() < 1e-12, "{width} {clear}: {found}");
        assert!((1.0..strain).contains(&found));
    }
    let share = |width, clear| plate(width, clear).share(nu);
    assert!(share(1e-3, 9.0) < 1e-6 && share(2000.0, 9.0) > 0.99, "a beam, a plate");
    assert!(share(20.0, 2.0) > share(20.0, 9.0) && share(20.0, 9.0) > share(20.0, 78.0), "held at its ends");
}
