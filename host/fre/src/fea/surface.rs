//! The rigid object as finite elements see it: a strip of elements along its surface, where the finger may reach.

use std::f64::consts::TAU;

use model_core::object::{Displacement, ObjectDesign, Piece};

use super::region::{Point, dot, minus};

/// Longest side of an element on a curved surface at refinement 1, mm.
const EDGE: f64 = 0.75;
/// Longest side on a flat one, mm.
const FLAT_EDGE: f64 = 4.0;
/// The most by which the surface turns along an element, rad.
const TURN: f64 = 0.05;
/// How far the strip turns to either side of where the finger first comes near, rad: round a corner of a square and a little.
const REACHED_TURN: f64 = 1.65;
/// Depth of the strip, mm, where the surface's curvature leaves room for it.
const DEPTH: f64 = 2.0;

/// A point of a surface, and the unit normal out of the object.
type OnSurface = (Point, Point);

/// A strip along a surface, counter-clockwise about the object.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Points at half steps: ends and middles of the elements' sides.
    points: Vec<OnSurface>,
    depth: f64,
}

impl Surface {
    /// All of an object's surface, world frame; of a wall, also a bore's, the part within `reach` of `middle`.
    pub fn whole(object: &ObjectDesign, middle: Point, reach: f64, refinement: usize) -> Self {
        let mut points: Vec<OnSurface> = Vec::new();
        // Neighbouring pieces share a point.
        let mut add = |piece: &mut dyn Iterator<Item = OnSurface>| {
            points.pop();
            points.extend(piece);
        };
        let edge = EDGE / refinement as f64;
        let steps = |length: f64, turn: f64| 2 * (length / edge).max(turn / TURN).ceil().max(1.0) as usize;
        let mut sharpest = f64::INFINITY;
        for piece in object.outline(middle, reach) {
            sharpest = piece.sharpest().unwrap_or(f64::INFINITY).min(sharpest);
            match piece {
                Piece::Line { from, to } => {
                    let along = minus(to, from);
                    let size = along[0].hypot(along[1]);
                    add(&mut line(from, to, [along[1] / size, -along[0] / size]));
                }
                Piece::Arc { centre, semi_axes: [a, b], from, turn, .. } if a == b => {
                    let size = turn.abs();
                    // Of a hollow wall the normals point to the centre.
                    let outwards = |(p, n): OnSurface| (p, if turn < 0.0 { [-n[0], -n[1]] } else { n });
                    add(&mut arc(centre, a, from, turn, steps(a * size, size)).map(outwards));
                }
                Piece::Arc { centre, semi_axes: [a, b], angle, .. } => {
                    let (sin, cos) = angle.sin_cos();
                    let turned = |[x, y]: Point| [cos * x - sin * y, sin * x + cos * y];
                    let at = |t: f64| {
                        let (s, c) = t.sin_cos();
                        let [x, y] = turned([a * c, b * s]);
                        let size = (b * c).hypot(a * s);
                        ([centre[0] + x, centre[1] + y], turned([b * c / size, a * s / size]))
                    };
                    // Per radian of the parameter: length, and turn of the normal.
                    let density = |t: f64| {
                        let speed = (a * t.sin()).hypot(b * t.cos());
                        (speed / edge).max(a * b / (speed * speed) / TURN)
                    };
                    add(&mut spread(density).into_iter().map(at));
                }
            }
        }
        Self { points, depth: DEPTH.min(0.5 * sharpest) }
    }

    /// The part that a finger may reach: from the element nearest to a point to both sides, as long as `reach` and no
    /// farther than the surface turns by about a right angle.
    pub fn near(mut self, point: Point, reach: f64) -> Self {
        let away = |p: Point| (p[0] - point[0]).hypot(p[1] - point[1]);
        let count = self.elements();
        let middle = |element: usize| self.points[2 * element + 1];
        let Some(first) = (0..count).min_by(|&a, &b| away(middle(a).0).total_cmp(&away(middle(b).0))) else {
            return self;
        };
        let closed = away_from(self.points[0].0, self.points[2 * count].0) < 1e-9;
        // Elements to either side, at most half of a closed surface.
        let [before, after] = [-1, 1].map(|sign: i64| {
            let (mut length, mut turn, mut taken) = (0.0, 0.0, 0);
            while 2 * taken + 2 < count || !closed {
                let next = first as i64 + sign * (taken as i64 + 1);
                if !closed && !(0..count as i64).contains(&next) {
                    break;
                }
                let (p, q) = (middle(wrap(next - sign, count)), middle(wrap(next, count)));
                length += away_from(p.0, q.0);
                turn += dot(p.1, q.1).clamp(-1.0, 1.0).acos();
                if length > reach || turn > REACHED_TURN {
                    break;
                }
                taken += 1;
            }
            taken
        });
        let start = first as i64 - before as i64;
        let halves = 2 * (before + after + 1);
        let points = (0..=halves as i64).map(|i| self.points[wrap(2 * start + i, 2 * count)]).collect();
        // The last point of a wall's strip is not its first one.
        self.points =
            if closed { points } else { self.points[2 * start as usize..=2 * start as usize + halves].to_vec() };
        self
    }

    /// The surface after a displacement.
    pub fn displaced(mut self, by: &Displacement<f64>) -> Self {
        for (point, normal) in &mut self.points {
            let (p, n) = (by.point((*point).into()), by.vector((*normal).into()));
            (*point, *normal) = ([p.x, p.y], [n.x, n.y]);
        }
        self
    }

    /// Number of elements.
    pub fn elements(&self) -> usize {
        self.points.len().saturating_sub(1) / 2
    }

    /// Points of the surface, half an element apart, mm.
    pub fn line(&self) -> impl Iterator<Item = Point> {
        self.points.iter().map(|on| on.0)
    }

    /// Nodes of the strip, mm: five per element (outer corner, inner corner, middle of the side between them, outer middle,
    /// inner middle) and three for the last side.
    pub fn nodes(&self) -> Vec<Point> {
        let deep = |&(p, n): &OnSurface, depth: f64| [p[0] - depth * n[0], p[1] - depth * n[1]];
        let mut nodes = Vec::with_capacity(5 * self.elements() + 3);
        for (i, on) in self.points.iter().enumerate() {
            nodes.extend([on.0, deep(on, self.depth)]);
            if i % 2 == 0 {
                nodes.push(deep(on, 0.5 * self.depth));
            }
        }
        nodes
    }
}

fn wrap(index: i64, count: usize) -> usize {
    index.rem_euclid(count as i64) as usize
}

fn away_from(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// An arc in half steps.
fn arc(centre: Point, radius: f64, from: f64, turn: f64, steps: usize) -> impl Iterator<Item = OnSurface> {
    (0..=steps).map(move |i| {
        let (sin, cos) = (from + turn * i as f64 / steps as f64).sin_cos();
        ([centre[0] + radius * cos, centre[1] + radius * sin], [cos, sin])
    })
}

/// A straight side in half steps.
fn line(from: Point, to: Point, normal: Point) -> impl Iterator<Item = OnSurface> {
    let steps = 2 * (away_from(from, to) / FLAT_EDGE).ceil().max(1.0) as usize;
    (0..=steps).map(move |i| {
        let t = i as f64 / steps as f64;
        ([0, 1].map(|axis| from[axis] + t * (to[axis] - from[axis])), normal)
    })
}

/// Parameters from 0 to 2π at half steps, so many per radian.
fn spread(density: impl Fn(f64) -> f64) -> Vec<f64> {
    const SAMPLES: usize = 4000;
    let step = TAU / SAMPLES as f64;
    let mut sums = vec![0.0];
    for i in 0..SAMPLES {
        sums.push(sums[i] + density((i as f64 + 0.5) * step) * step);
    }
    let total = sums[SAMPLES];
    let half_steps = 2 * total.ceil().max(1.0) as usize;
    let at = |k: usize| {
        let wanted = total * k as f64 / half_steps as f64;
        let i = sums.partition_point(|&sum| sum <= wanted).clamp(1, SAMPLES) - 1;
        (i as f64 + (wanted - sums[i]) / (sums[i + 1] - sums[i])) * step
    };
    (0..=half_steps).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_core::object::{Corners, Object as _, Shape};

    fn objects() -> Vec<ObjectDesign> {
        let square = Corners::new(&[[20.0, 10.0], [20.0, 50.0], [60.0, 50.0], [60.0, 10.0]]).unwrap();
        let bar = Corners::new(&[[20.0, 10.0], [30.0, 60.0]]).unwrap();
        vec![
            ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 },
            ObjectDesign::Ellipse { centre: [31.0, 45.0], semi_axes: [20.0, 45.0], angle: 0.4 },
            ObjectDesign::Polygon { corners: square, rounding: 3.0 },
            ObjectDesign::Polygon { corners: bar, rounding: 8.0 },
            ObjectDesign::HalfPlane { point: [5.0, 0.0], normal: [-3.0, 0.5] },
            ObjectDesign::Bore { centre: [-60.0, 45.0], radius: 70.0 },
            ObjectDesign::Bore { centre: [-2e6, 45.0], radius: 2e6 + 5.0 },
        ]
    }

    #[test]
    fn a_surface_lies_on_its_object_and_faces_out_of_it() {
        for object in objects() {
            let shape = Shape::<f64>::from(object);
            let whole = Surface::whole(&object, [0.0, 40.0], 100.0, 2);
            for surface in [whole.clone(), whole.near([1.0, 45.0], 100.0)] {
                assert!(surface.elements() > 20 && surface.points.len() == 2 * surface.elements() + 1);
                for &(point, normal) in &surface.points {
                    let gap = shape.gap(point.into());
                    assert!(gap.distance.abs() < 1e-9, "{object:?}: {point:?} is {} mm off", gap.distance);
                    assert!(
                        (gap.normal.x - normal[0]).hypot(gap.normal.y - normal[1]) < 1e-6,
                        "{object:?} at {point:?}"
                    );
                }
                for pair in surface.points.windows(2) {
                    let along = minus(pair[1].0, pair[0].0);
                    // Counter-clockwise: the normal is on the right of the way.
                    assert!(dot(along, [-pair[0].1[1], pair[0].1[0]]) > 0.0, "{object:?}: {pair:?}");
                    assert!(along[0].hypot(along[1]) < 2.1, "{object:?}: {pair:?}");
                }
            }
        }
    }

    #[test]
    fn strips_end_where_the_finger_cannot_reach() {
        for object in objects() {
            let strip = Surface::whole(&object, [0.0, 40.0], 100.0, 1).near([1.0, 45.0], 60.0);
            let turn: f64 = strip.points.windows(2).map(|p| dot(p[0].1, p[1].1).clamp(-1.0, 1.0).acos()).sum();
            assert!(turn < 2.0 * REACHED_TURN + 0.2, "{object:?}: turns by {turn}");
            let length: f64 = strip.points.windows(2).map(|p| away_from(p[0].0, p[1].0)).sum();
            assert!(length < 2.0 * 60.0 + 4.0 * FLAT_EDGE, "{object:?}: {length} mm");
            assert_eq!(strip.nodes().len(), 5 * strip.elements() + 3);
        }
    }
}
