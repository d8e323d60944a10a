//! Linear plane-stress finite elements of a junction where a rib leaves a beam, and what its rods must be to give way as much.
//!
//! The beam lies along x, −A to A; the rib leaves its upper face at an angle φ from +x, its axis through the origin. Quadratic elements
//! of eight nodes, ever smaller towards the two re-entrant corners. A fillet's arc is halved: one half is the beam's edge, the other the
//! rib's, and the line between the two middles is where the blocks meet. Everything is per width.

use core::f64::consts::{FRAC_PI_2, PI};
use std::collections::HashMap;
use std::vec;
use std::vec::Vec;

type Point = [f64; 2];

/// A junction; lengths in any unit.
#[derive(Clone, Copy, Debug)]
pub struct Junction {
    /// Thickness of the beam.
    pub beam: f64,
    /// Thickness of the rib.
    pub rib: f64,
    /// Angle between both axes, rad, 0 … π/2.
    pub angle: f64,
    /// Radius of the fillets in both corners, 0 if they are sharp.
    pub fillet: f64,
    /// Poisson's ratio.
    pub nu: f64,
    /// Elements across the beam.
    pub fineness: usize,
}

/// What rods are in place of a junction. Lengths in the junction's unit.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// The beam does not bend from so far before the axes' crossing to so far behind it (on the side to which the rib leans).
    pub reach: [f64; 2],
    /// How far inside the beam's face the rib begins to bend, along its axis.
    pub root: f64,
    /// Angle by which the mean of the beam's two shear forces turns the rib, over the beam's shear strain.
    pub coupling: f64,
    /// Angle by which the rib's own shear force turns it at its root, over its shear strain.
    pub turn: f64,
    /// Length of the beam by which it gives way more to a force along it than to the crossing.
    pub stretch: f64,
    /// The same to a shear force.
    pub shear: f64,
}

impl Fit {
    /// The numbers that [`model_core::design::weld_numbers`] has.
    pub fn numbers(&self, of: &Junction) -> [f64; 7] {
        let sine = of.angle.sin();
        let root = of.rib * of.rib / (sine * sine * of.beam);
        let lean = (self.reach[1] - self.reach[0]) * of.angle.tan() / of.beam;
        let stiff = (self.reach[0] + self.reach[1]) / root;
        [stiff, lean, self.root / of.rib, self.coupling, self.turn, self.stretch / root, self.shear / root]
    }
}

/// Lengths of the three arms beyond the root and its fillets (beam: beyond the crossing at least), in thicknesses of the beam and of the rib.
const ARMS: [f64; 2] = [3.0, 3.0];
/// Power by which elements grow from the corners.
const GRADING: f64 = 2.5;

struct Mesh {
    points: Vec<Point>,
    elements: Vec<[usize; 8]>,
    known: HashMap<[i64; 2], usize>,
}

impl Mesh {
    fn node(&mut self, p: Point) -> usize {
        let key = p.map(|x| (x * 1e8).round() as i64);
        let next = self.points.len();
        *self.known.entry(key).or_insert_with(|| {
            self.points.push(p);
            next
        })
    }

    /// Elements of a block between two graded families of lines.
    fn block(&mut self, at: impl Fn(f64, f64) -> Point, along: &[f64], across: &[f64]) {
        for a in along.windows(2) {
            for b in across.windows(2) {
                let (ma, mb) = (0.5 * (a[0] + a[1]), 0.5 * (b[0] + b[1]));
                let corners = [
                    (a[0], b[0]),
                    (a[1], b[0]),
                    (a[1], b[1]),
                    (a[0], b[1]),
                    (ma, b[0]),
                    (a[1], mb),
                    (ma, b[1]),
                    (a[0], mb),
                ];
                let element = corners.map(|(u, v)| self.node(at(u, v)));
                self.elements.push(element);
            }
        }
    }
}

/// Positions 0 … 1, closer together towards 1.
fn graded(n: usize) -> Vec<f64> {
    (0..=n).map(|k| 1.0 - (1.0 - k as f64 / n as f64).powf(GRADING)).collect()
}

/// Positions 0 … 1, closer together towards 0.
fn ungraded(n: usize) -> Vec<f64> {
    graded(n).iter().rev().map(|s| 1.0 - s).collect()
}

/// Positions 0 … 1.
fn even(n: usize) -> Vec<f64> {
    (0..=n).map(|k| k as f64 / n as f64).collect()
}

/// Positions 0 … 1, closer together towards both ends.
fn both(n: usize) -> Vec<f64> {
    let mut all: Vec<f64> = ungraded(n / 2).iter().map(|s| 0.5 * s).collect();
    all.extend(graded(n / 2).iter().skip(1).map(|s| 0.5 + 0.5 * s));
    all
}

/// Shape functions and their derivatives of the element with eight nodes.
fn shapes(u: f64, v: f64) -> ([f64; 8], [[f64; 2]; 8]) {
    let corner = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let (mut n, mut d) = ([0.0; 8], [[0.0; 2]; 8]);
    for (i, (a, b)) in corner.into_iter().enumerate() {
        let (p, q) = (1.0 + a * u, 1.0 + b * v);
        n[i] = 0.25 * p * q * (a * u + b * v - 1.0);
        d[i] = [0.25 * a * q * (2.0 * a * u + b * v), 0.25 * b * p * (a * u + 2.0 * b * v)];
    }
    for (i, b) in [(4, -1.0), (6, 1.0)] {
        n[i] = 0.5 * (1.0 - u * u) * (1.0 + b * v);
        d[i] = [-u * (1.0 + b * v), 0.5 * b * (1.0 - u * u)];
    }
    for (i, a) in [(5, 1.0), (7, -1.0)] {
        n[i] = 0.5 * (1.0 + a * u) * (1.0 - v * v);
        d[i] = [0.5 * a * (1.0 - v * v), -v * (1.0 + a * u)];
    }
    (n, d)
}

const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// An end section: its middle, outward axis and thickness.
#[derive(Clone, Copy)]
struct End {
    middle: Point,
    axis: Point,
    thickness: f64,
}

/// A rounded corner: where its arc begins on the beam's face, its middle, and where it ends on the rib's edge.
#[derive(Clone, Copy)]
struct Corner {
    centre: Point,
    radius: f64,
    /// Directions from the centre to the arc's beginning, middle and end, rad.
    angles: [f64; 3],
    /// Distance of the beginning, and of the end, from the sharp corner.
    reach: f64,
}

impl Corner {
    /// That of a sharp corner in the beam's face; the face leads away from it along `sign`·x, the rib's edge along the axis.
    fn of(corner: Point, sign: f64, angle: f64, radius: f64) -> Self {
        let open = if sign > 0.0 { angle } else { PI - angle };
        let reach = radius / (0.5 * open).tan();
        let centre = [corner[0] + sign * reach, corner[1] + radius];
        let begin = -FRAC_PI_2;
        let turn = -sign * (PI - open);
        Self { centre, radius, angles: [begin, begin + 0.5 * turn, begin + turn], reach }
    }

    /// A point of the arc's first half (towards the face) or second half (towards the rib).
    fn at(&self, half: usize, part: f64) -> Point {
        let angle = self.angles[half] + part * (self.angles[half + 1] - self.angles[half]);
        [self.centre[0] + self.radius * angle.cos(), self.centre[1] + self.radius * angle.sin()]
    }
}

impl Junction {
    /// The corners where the rib's two edges meet the beam's face, the one at smaller x first.
    fn corners(&self) -> [Corner; 2] {
        let (half, (sin, cos)) = (0.5 * self.beam, self.angle.sin_cos());
        let (centre, wide) = (half * cos / sin, 0.5 * self.rib / sin);
        let corner = |sign: f64| Corner::of([centre + sign * wide, half], sign, self.angle, self.fillet);
        [corner(-1.0), corner(1.0)]
    }

    /// Lengths of the beam's arms from the crossing, and of the rib's from there.
    fn arms(&self) -> [f64; 2] {
        let [low, high] = self.corners();
        let sin = self.angle.sin();
        let root = 0.5 * self.beam * self.angle.cos() / sin + 0.5 * self.rib / sin;
        let reach = low.reach.max(high.reach);
        let beam = if self.fillet > 0.0 { root + reach + ARMS[0] * self.beam } else { ARMS[0] * self.beam };
        [beam, 0.5 * self.beam / sin + reach + ARMS[1] * self.rib]
    }

    fn ends(&self) -> [End; 3] {
        let (sin, cos) = self.angle.sin_cos();
        let [arm, far] = self.arms();
        [
            End { middle: [-arm, 0.0], axis: [-1.0, 0.0], thickness: self.beam },
            End { middle: [arm, 0.0], axis: [1.0, 0.0], thickness: self.beam },
            End { middle: [far * cos, far * sin], axis: [cos, sin], thickness: self.rib },
        ]
    }

    fn mesh(&self) -> Mesh {
        let mut mesh = Mesh { points: Vec::new(), elements: Vec::new(), known: HashMap::new() };
        let (half, arm) = (0.5 * self.beam, self.arms()[0]);
        let (sin, cos) = self.angle.sin_cos();
        let n = self.fineness;
        let across = graded(n);
        let mix = |a: Point, b: Point, t: f64| [0, 1].map(|i| a[i] + t * (b[i] - a[i]));
        let corners = self.corners();
        let roots = corners.map(|corner| corner.at(0, 1.0));
        let starts = corners.map(|corner| corner.at(0, 0.0));
        // Across the beam, from its lower face to a point of its upper edge.
        let beam = |upper: &dyn Fn(f64) -> Point, from: f64, to: f64, u: f64, v: f64| {
            mix([from + u * (to - from), -half], upper(u), v)
        };
        let face = |from: f64, to: f64| move |u: f64| [from + u * (to - from), half];
        let rounded = self.fillet > 0.0;
        // Where lines across the beam begin, below the roots.
        let feet = [0, 1].map(|side| corners[side].centre[0] - [-1.0, 1.0][side] * corners[side].reach);
        let outer = |side: usize| if rounded { starts[side][0] } else { feet[side] };
        let (left, right) = (outer(0), outer(1));
        mesh.block(|u, v| beam(&face(-arm, left), -arm, left, u, v), &graded(2 * n), &across);
        mesh.block(|u, v| beam(&|u| mix(roots[0], roots[1], u), feet[0], feet[1], u, v), &both(2 * n), &across);
        mesh.block(|u, v| beam(&face(right, arm), right, arm, u, v), &ungraded(2 * n), &across);
        if rounded {
            let [low, high] = corners;
            mesh.block(|u, v| beam(&|u| low.at(0, u), left, feet[0], u, v), &even(n), &across);
            mesh.block(|u, v| beam(&|u| high.at(0, 1.0 - u), feet[1], right, u, v), &even(n), &across);
        }
        let end = self.ends()[2];
        let side = |s: f64| [0, 1].map(|i| end.middle[i] + 0.5 * s * self.rib * [-sin, cos][i]);
        let (left, right) = (side(1.0), side(-1.0));
        let tops = corners.map(|corner| corner.at(1, 1.0));
        // Its lines along run to the right, as the block wants them.
        let rib = |u: f64, v: f64| mix(mix(tops[0], tops[1], u), mix(left, right, u), v);
        mesh.block(rib, &both(2 * n), &ungraded(2 * n));
        if rounded {
            let root = |u: f64, v: f64| mix(corners[0].at(1, v), corners[1].at(1, v), u);
            mesh.block(root, &both(2 * n), &even(n));
        }
        mesh
    }

    /// Compliances of six loads, E and width 1: force along x, along y and moment at the beam's right end, force along the rib, across
    /// it and moment at the rib's end; the beam's left end holds them all.
    fn compliance(&self) -> [[f64; 6]; 6] {
        let mesh = self.mesh();
        let order = ordering(&mesh);
        let unknowns = 2 * mesh.points.len();
        let place = |node: usize, axis: usize| 2 * order[node] + axis;
        // Envelope: first column of each row.
        let mut first: Vec<usize> = (0..unknowns).collect();
        for element in &mesh.elements {
            let least = element.iter().map(|&node| place(node, 0)).min().unwrap_or(0);
            for &node in element {
                for axis in 0..2 {
                    let row = place(node, axis);
                    first[row] = first[row].min(least);
                }
            }
        }
        let mut rows: Vec<Vec<f64>> = (0..unknowns).map(|row| vec![0.0; row - first[row] + 1]).collect();
        let factor = 1.0 / (1.0 - self.nu * self.nu);
        let law = [[factor, factor * self.nu, 0.0], [factor * self.nu, factor, 0.0], [0.0, 0.0, 0.5 / (1.0 + self.nu)]];
        for element in &mesh.elements {
            let stiffness = stiffness(element.map(|node| mesh.points[node]), &law);
            for (i, a) in element.iter().enumerate() {
                for (j, b) in element.iter().enumerate() {
                    for (p, q) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                        let (row, column) = (place(*a, p), place(*b, q));
                        if column <= row {
                            rows[row][column - first[row]] += stiffness[2 * i + p][2 * j + q];
                        }
                    }
                }
            }
        }
        let loads = self.loads(&mesh, &place);
        let arm = self.arms()[0];
        // Balanced loads need no support but against the three motions of a rigid body: two nodes far apart.
        let held = [
            place(order_of(&mesh, [-arm, -0.5 * self.beam]), 0),
            place(order_of(&mesh, [-arm, -0.5 * self.beam]), 1),
            place(order_of(&mesh, [arm, -0.5 * self.beam]), 1),
        ];
        for row in held {
            let last = rows[row].len() - 1;
            rows[row][last] += 1e12;
        }
        cholesky(&mut rows, &first);
        let answers: Vec<Vec<f64>> = loads.iter().map(|load| solve(&rows, &first, load)).collect();
        let mut all = [[0.0; 6]; 6];
        for i in 0..6 {
            for j in 0..6 {
                all[i][j] = loads[i].iter().zip(&answers[j]).map(|(f, u)| f * u).sum();
            }
        }
        all
    }

    /// The six loads with what holds them, as nodal forces.
    fn loads(&self, mesh: &Mesh, place: &dyn Fn(usize, usize) -> usize) -> Vec<Vec<f64>> {
        let ends = self.ends();
        unit_loads(&ends)
            .into_iter()
            .map(|resultants| {
                let mut load = vec![0.0; 2 * mesh.points.len()];
                for (end, [x, y, moment]) in ends.iter().zip(resultants) {
                    let (e, n) = (end.axis, [-end.axis[1], end.axis[0]]);
                    let (normal, shear) = (x * e[0] + y * e[1], x * n[0] + y * n[1]);
                    let t = end.thickness;
                    let traction = |s: f64| {
                        let along = normal / t - 12.0 * s * moment / (t * t * t);
                        let across = 1.5 * shear / t * (1.0 - 4.0 * s * s / (t * t));
                        [0, 1].map(|i| along * e[i] + across * n[i])
                    };
                    let across = |p: Point| (p[0] - end.middle[0]) * n[0] + (p[1] - end.middle[1]) * n[1];
                    let is_on = |p: Point| {
                        ((p[0] - end.middle[0]) * e[0] + (p[1] - end.middle[1]) * e[1]).abs() < 1e-7
                            && across(p).abs() < 0.5 * t + 1e-7
                    };
                    for element in &mesh.elements {
                        for [a, m, b] in [[0, 4, 1], [1, 5, 2], [3, 6, 2], [0, 7, 3]] {
                            let side = [element[a], element[m], element[b]];
                            if !side.iter().all(|&node| is_on(mesh.points[node])) {
                                continue;
                            }
                            let [p, q] = [mesh.points[side[0]], mesh.points[side[2]]].map(across);
                            for (u, weight) in GAUSS {
                                let shape = [0.5 * u * (u - 1.0), 1.0 - u * u, 0.5 * u * (u + 1.0)];
                                let pull = traction(0.5 * (p + q) + 0.5 * u * (q - p));
                                for (node, part) in side.iter().zip(shape) {
                                    for (axis, pull) in pull.iter().enumerate() {
                                        load[place(*node, axis)] += 0.5 * (q - p).abs() * weight * part * pull;
                                    }
                                }
                            }
                        }
                    }
                }
                load
            })
            .collect()
    }

    /// The compliances of rods that meet in the crossing, the rib's from the beam's face on. Their shear coefficient is that of the
    /// parabola that the ends' tractions are.
    fn rods(&self) -> [[f64; 6]; 6] {
        let ends = self.ends();
        let loads = unit_loads(&ends);
        let kappa = 5.0 / 6.0;
        let mut all = [[0.0; 6]; 6];
        // Inner ends of the rods.
        let (sin, cos) = self.angle.sin_cos();
        let inner = [[0.0; 2], [0.0; 2], [0.5 * self.beam * cos / sin, 0.5 * self.beam]];
        for (arm, (end, from)) in ends.iter().zip(inner).enumerate() {
            let length = (end.middle[0] - from[0]).hypot(end.middle[1] - from[1]);
            let t = end.thickness;
            let compliance = [1.0 / t, 2.0 * (1.0 + self.nu) / (kappa * t), 12.0 / (t * t * t)];
            for (u, weight) in GAUSS {
                let part = 0.5 * (1.0 + u);
                let at = [0, 1].map(|i| from[i] + part * (end.middle[i] - from[i]));
                let inside: Vec<[f64; 3]> = loads
                    .iter()
                    .map(|load| {
                        let [x, y, m] = load[arm];
                        let r = [end.middle[0] - at[0], end.middle[1] - at[1]];
                        let (e, n) = (end.axis, [-end.axis[1], end.axis[0]]);
                        [x * e[0] + y * e[1], x * n[0] + y * n[1], m + r[0] * y - r[1] * x]
                    })
                    .collect();
                for i in 0..6 {
                    for j in 0..6 {
                        let sum: f64 = (0..3).map(|k| compliance[k] * inside[i][k] * inside[j][k]).sum();
                        all[i][j] += 0.5 * weight * length * sum;
                    }
                }
            }
        }
        all
    }

    /// Compliances that the elements have and rods do not, for what acts at the crossing: the means of the normal forces, shear forces and
    /// moments in the beam's two arms, then force along x, along y and moment of the rib. No arm is set apart by that.
    fn excess(&self) -> [[f64; 6]; 6] {
        let (exact, rods) = (self.compliance(), self.rods());
        let (sin, cos) = self.angle.sin_cos();
        let [arm, far] = self.arms();
        // The loads of the beam's right end and the rib's end that make up each of them.
        let turn = |x: f64, y: f64| [x * cos + y * sin, y * cos - x * sin];
        let rib = |x: f64, y: f64, moment: f64| {
            let [along, across] = turn(x, y);
            [-0.5 * x, -0.5 * y, -0.5 * moment + 0.5 * arm * y, along, across, moment - far * across]
        };
        let parts = [
            [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, -arm, 0.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
            rib(1.0, 0.0, 0.0),
            rib(0.0, 1.0, 0.0),
            rib(0.0, 0.0, 1.0),
        ];
        let mut all = [[0.0; 6]; 6];
        for (i, a) in parts.iter().enumerate() {
            for (j, b) in parts.iter().enumerate() {
                let more = |k: usize, l: usize| a[k] * b[l] * (exact[k][l] - rods[k][l]);
                all[i][j] = (0..6).map(|k| (0..6).map(|l| more(k, l)).sum::<f64>()).sum();
            }
        }
        all
    }

    /// The rods that give way as the elements do: to bending of the beam, bending of the rib, both at once, the turn of the rib by the beam's
    /// shear, and the beam's stretch and shear.
    pub fn fit(&self) -> Fit {
        let excess = self.excess();
        let bending = 12.0 / self.beam.powi(3);
        // What does not bend takes its length from the beam's bending, and half the difference of its two parts from both at once.
        let (length, lean) = (-excess[2][2] / bending, 2.0 * excess[2][5] / bending);
        let [a, b] = [0.5 * (length - lean), 0.5 * (length + lean)];
        let root = (excess[5][5] + 0.25 * bending * length) * self.rib.powi(3) / 12.0;
        let shear = 2.0 * (1.0 + self.nu) / (kappa(self.nu) * self.beam);
        let coupling = (excess[1][5] + 0.25 * bending * (a * a + b * b)) / shear;
        let (sin, cos) = self.angle.sin_cos();
        let inside = 12.0 / self.rib.powi(3) * root * (0.5 * self.beam / sin - 0.5 * root);
        let about = 0.125 * bending * (b * b - a * a) * cos - inside;
        let turn = (about + sin * excess[3][5] - cos * excess[4][5]) * self.rib / (shear * self.beam);
        let sheared = excess[1][1] + bending * (a.powi(3) + b.powi(3)) / 3.0 - 2.0 * coupling * shear * length;
        Fit { reach: [a, b], root, coupling, turn, stretch: excess[0][0] * self.beam, shear: sheared / shear }
    }
}

/// Shear coefficient of a rectangle (Cowper).
fn kappa(nu: f64) -> f64 {
    10.0 * (1.0 + nu) / (12.0 + 11.0 * nu)
}

/// Resultants (x, y, moment) at each end of the six loads; the first end holds the others.
fn unit_loads(ends: &[End; 3]) -> Vec<[[f64; 3]; 3]> {
    let mut all = Vec::new();
    for end in [1, 2] {
        let (e, n) = (ends[end].axis, [-ends[end].axis[1], ends[end].axis[0]]);
        for [x, y, moment] in [[e[0], e[1], 0.0], [n[0], n[1], 0.0], [0.0, 0.0, 1.0]] {
            let r = [0, 1].map(|i| ends[end].middle[i] - ends[0].middle[i]);
            let mut load = [[0.0; 3]; 3];
            load[end] = [x, y, moment];
            load[0] = [-x, -y, -(moment + r[0] * y - r[1] * x)];
            all.push(load);
        }
    }
    all
}

fn order_of(mesh: &Mesh, p: Point) -> usize {
    mesh.known[&p.map(|x| (x * 1e8).round() as i64)]
}

fn stiffness(points: [Point; 8], law: &[[f64; 3]; 3]) -> [[f64; 16]; 16] {
    let mut k = [[0.0; 16]; 16];
    for (u, wu) in GAUSS {
        for (v, wv) in GAUSS {
            let (_, d) = shapes(u, v);
            let mut jacobian = [[0.0; 2]; 2];
            for (slope, p) in d.iter().zip(&points) {
                for i in 0..2 {
                    for j in 0..2 {
                        jacobian[i][j] += slope[i] * p[j];
                    }
                }
            }
            let det = jacobian[0][0] * jacobian[1][1] - jacobian[0][1] * jacobian[1][0];
            let mut b = [[0.0; 16]; 3];
            for (i, slope) in d.iter().enumerate() {
                let x = (jacobian[1][1] * slope[0] - jacobian[0][1] * slope[1]) / det;
                let y = (-jacobian[1][0] * slope[0] + jacobian[0][0] * slope[1]) / det;
                (b[0][2 * i], b[1][2 * i + 1], b[2][2 * i], b[2][2 * i + 1]) = (x, y, y, x);
            }
            let scale = wu * wv * det.abs();
            for i in 0..16 {
                for j in 0..16 {
                    for p in 0..3 {
                        for q in 0..3 {
                            k[i][j] += scale * b[p][i] * law[p][q] * b[q][j];
                        }
                    }
                }
            }
        }
    }
    k
}

/// A numbering with a narrow envelope: Cuthill and McKee's, from a corner.
fn ordering(mesh: &Mesh) -> Vec<usize> {
    let count = mesh.points.len();
    let mut near: Vec<Vec<usize>> = vec![Vec::new(); count];
    for element in &mesh.elements {
        for &a in element {
            near[a].extend(element.iter().copied().filter(|&b| b != a));
        }
    }
    for list in &mut near {
        list.sort_unstable();
        list.dedup();
    }
    let mut order = vec![usize::MAX; count];
    let mut queue = vec![0];
    order[0] = 0;
    let mut next = 1;
    let mut at = 0;
    while at < queue.len() {
        let mut list: Vec<usize> = near[queue[at]].iter().copied().filter(|&node| order[node] == usize::MAX).collect();
        list.sort_by_key(|&node| near[node].len());
        for node in list {
            order[node] = next;
            next += 1;
            queue.push(node);
        }
        at += 1;
    }
    order
}

/// L Lᵀ of rows within their envelope, in place.
fn cholesky(rows: &mut [Vec<f64>], first: &[usize]) {
    for i in 0..rows.len() {
        for j in first[i]..=i {
            let from = first[i].max(first[j]);
            let dot: f64 = {
                let (a, b) = (&rows[i][from - first[i]..j - first[i]], &rows[j][from - first[j]..j - first[j]]);
                a.iter().zip(b).map(|(x, y)| x * y).sum()
            };
            let value = rows[i][j - first[i]] - dot;
            rows[i][j - first[i]] = if i == j { value.sqrt() } else { value / rows[j][j - first[j]] };
        }
    }
}

fn solve(rows: &[Vec<f64>], first: &[usize], right: &[f64]) -> Vec<f64> {
    let mut x = right.to_vec();
    for i in 0..x.len() {
        let row = &rows[i];
        let dot: f64 = row[..row.len() - 1].iter().zip(&x[first[i]..i]).map(|(a, b)| a * b).sum();
        x[i] = (x[i] - dot) / row[row.len() - 1];
    }
    for i in (0..x.len()).rev() {
        let row = &rows[i];
        x[i] /= row[row.len() - 1];
        let value = x[i];
        for (entry, into) in row[..row.len() - 1].iter().zip(&mut x[first[i]..i]) {
            *into -= entry * value;
        }
    }
    x
}
