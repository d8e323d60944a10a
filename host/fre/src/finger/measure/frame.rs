//! The outline turned upright, with the contact face on the right: where the finger's frame has them.

use super::{Loop, MeasureError, Point, Undecided};
use crate::finger::outline::twice_area;
use crate::finger::{cross, distance, dot, minus};

/// Which side of the upright drawing touches objects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Front {
    /// The straighter side; of two straight ones the more upright.
    #[default]
    Auto,
    /// The left one.
    Left,
    /// The right one.
    Right,
}

/// Smaller holes are not windows, mm².
const SPECK: f64 = 0.2;
/// Isoperimetric quotient above which a window is a bolt's hole.
const ROUND: f64 = 0.95;
/// How far a finger may lean and still be upright, rad.
const LEAN: f64 = 0.5;
/// Sides of a straight run differ by less than this, rad.
const STRAIGHT: f64 = 0.006;
/// Part of a side that its longest straight run must have for the side to be a straight one.
const MOSTLY: f64 = 0.7;

/// Loops of a finger: around it counter-clockwise, around its windows clockwise, base to tip; the material lies on their left.
#[derive(Clone, Debug)]
pub(super) struct Figure {
    pub outer: Loop,
    pub windows: Vec<Loop>,
}

pub(super) struct Framed {
    pub figure: Figure,
    pub has_origin: bool,
    pub undecided: Vec<Undecided>,
}

/// Turns, mirrors and sorts.
pub(super) fn framed(loops: &[Loop], mut has_origin: bool, front: Front) -> Result<Framed, MeasureError> {
    let mut undecided = Vec::new();
    let area = |points: &Loop| 0.5 * twice_area(points).abs();
    let largest = loops.iter().enumerate().max_by(|a, b| area(a.1).total_cmp(&area(b.1)));
    let Some((largest, outer)) = largest else { return Err(MeasureError::Windows { windows: 0 }) };
    let holes = loops.iter().enumerate().filter(|(i, _)| *i != largest).map(|(_, points)| points);
    let (bolts, windows): (Vec<&Loop>, Vec<&Loop>) =
        holes.filter(|points| area(points) > SPECK).partition(|points| is_round(points));
    if windows.len() < 2 {
        return Err(MeasureError::Windows { windows: windows.len() });
    }
    let mut figure = Figure { outer: outer.clone(), windows: windows.into_iter().cloned().collect() };
    // Upright: along the windows, towards the end that the figure's centre of gravity is farther from.
    let middles: Vec<Point> = figure.windows.iter().map(|points| centroid(points)).collect();
    let axis = principal(&middles);
    let reach = |pick: fn(f64, f64) -> f64, from: f64| outer.iter().map(|&p| dot(p, axis)).fold(from, pick);
    let (low, high) = (reach(f64::min, f64::INFINITY), reach(f64::max, f64::NEG_INFINITY));
    let heavy = dot(centroid(outer), axis);
    let tip = if high - heavy > heavy - low { axis } else { [-axis[0], -axis[1]] };
    let lean = tip[0].atan2(tip[1]);
    if lean.abs() > LEAN {
        let quarter = std::f64::consts::FRAC_PI_2;
        figure.turn((lean / quarter).round() * quarter);
        has_origin = false;
    }
    // The contact face.
    let sides = [Front::Left, Front::Right].map(|side| longest_run(&figure, side));
    let side = match front {
        Front::Auto => {
            let [left, right] = &sides;
            let is_straight = |run: &Run| run.share > MOSTLY;
            match (is_straight(left), is_straight(right)) {
                (true, false) => Front::Left,
                (false, true) => Front::Right,
                _ if (left.lean.abs() - right.lean.abs()).abs() > 0.02 => {
                    if left.lean.abs() < right.lean.abs() {
                        Front::Left
                    } else {
                        Front::Right
                    }
                }
                _ => {
                    undecided.push(Undecided {
                        key: "finger.front",
                        why: "both sides look alike: the right one was taken for the contact side (--front chooses)"
                            .to_owned(),
                    });
                    Front::Right
                }
            }
        }
        chosen => chosen,
    };
    let run = &sides[usize::from(side == Front::Right)];
    if run.lean.abs() > 1e-4 {
        figure.turn(run.lean);
        has_origin &= run.lean.abs() < 1e-3;
    }
    if side == Front::Left {
        figure.mirror();
        undecided.push(Undecided {
            key: "finger.front",
            why: "the left side was taken for the contact side, so the outline was mirrored (--front chooses)"
                .to_owned(),
        });
    }
    if !bolts.is_empty() {
        let places: Vec<String> = bolts
            .iter()
            .map(|points| {
                let [x, y] = centroid(points);
                format!("Ø{:.2} at ({x:.2}, {y:.2})", (4.0 * area(points) / std::f64::consts::PI).sqrt())
            })
            .collect();
        undecided.push(Undecided {
            key: "finger.back.clamp_mm",
            why: format!(
                "round holes, in the drawing's own place: {}; what they hold beyond the solid base is not known",
                places.join(", ")
            ),
        });
    }
    figure.orient();
    figure.windows.sort_by(|a, b| centroid(a)[1].total_cmp(&centroid(b)[1]));
    Ok(Framed { figure, has_origin, undecided })
}

impl Figure {
    fn loops(&mut self) -> impl Iterator<Item = &mut Loop> {
        std::iter::once(&mut self.outer).chain(&mut self.windows)
    }

    /// Turns counter-clockwise.
    fn turn(&mut self, angle: f64) {
        let (sin, cos) = angle.sin_cos();
        self.loops().flatten().for_each(|p| *p = [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1]]);
    }

    fn mirror(&mut self) {
        self.loops().flatten().for_each(|p| p[0] = -p[0]);
    }

    fn orient(&mut self) {
        if twice_area(&self.outer) < 0.0 {
            self.outer.reverse();
        }
        self.windows.iter_mut().filter(|points| twice_area(points) > 0.0).for_each(|points| points.reverse());
    }
}

fn is_round(points: &Loop) -> bool {
    let around: f64 = points.iter().zip(points.iter().cycle().skip(1)).map(|(&a, &b)| distance(a, b)).sum();
    points.len() > 7 && 2.0 * std::f64::consts::PI * twice_area(points).abs() / (around * around) > ROUND
}

/// Centre of gravity of what a closed line encloses.
pub(super) fn centroid(points: &[Point]) -> Point {
    let (mut sum, mut twice) = ([0.0; 2], 0.0);
    let first = points[0];
    for (&a, &b) in points.iter().zip(points.iter().cycle().skip(1)) {
        let (a, b) = (minus(a, first), minus(b, first));
        let c = cross(a, b);
        twice += c;
        sum = [sum[0] + c * (a[0] + b[0]), sum[1] + c * (a[1] + b[1])];
    }
    [first[0] + sum[0] / (3.0 * twice), first[1] + sum[1] / (3.0 * twice)]
}

/// Direction along which points spread most.
fn principal(points: &[Point]) -> Point {
    let count = points.len() as f64;
    let mean = [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / count);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for &p in points {
        let [x, y] = minus(p, mean);
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
    }
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    [angle.cos(), angle.sin()]
}

/// The longest straight run of a side.
struct Run {
    /// Its part of the figure's height.
    share: f64,
    /// How far it leans to the right, rad.
    lean: f64,
}

fn longest_run(figure: &Figure, side: Front) -> Run {
    let outer = &figure.outer;
    let ys = || outer.iter().map(|p| p[1]);
    let height = ys().fold(f64::NEG_INFINITY, f64::max) - ys().fold(f64::INFINITY, f64::min);
    let centre = centroid(outer);
    let mut best = Run { share: 0.0, lean: 0.0 };
    let count = outer.len();
    for start in 0..count {
        // On while the sides keep the first one's direction.
        let first = minus(outer[(start + 1) % count], outer[start]);
        let mut end = start + 1;
        while end < start + count {
            let next = minus(outer[(end + 1) % count], outer[end % count]);
            if cross(first, next).atan2(dot(first, next)).abs() > STRAIGHT {
                break;
            }
            end += 1;
        }
        let (a, b) = (outer[start], outer[end % count]);
        let along = minus(b, a);
        let lean = (along[0] * along[1].signum()).atan2(along[1].abs());
        let is_right = 0.5 * (a[0] + b[0]) > centre[0];
        let share = distance(a, b) / height;
        if lean.abs() < LEAN + 0.3 && is_right == (side == Front::Right) && share > best.share {
            best = Run { share, lean };
        }
    }
    best
}
