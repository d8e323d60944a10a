//! Both walls: centreline, thickness, clamp and tip.

use super::frame::Figure;
use super::section::Sample;
use super::{MeasureError, Point, Undecided};
use crate::finger::{along, cross, distance, dot, minus};

/// Rays that leave a wall more slantwise than this have crossed more than the wall.
const SQUARE: f64 = 0.97;
/// A centreline or thickness that strays less than this is straight or constant, mm.
const STRAY: f64 = 0.04;
/// Tolerance of a polyline in place of what was measured, mm; it grows until few points are left.
const FINE: f64 = 0.01;
/// Most knots of a thickness and most points of a centreline.
const KNOTS: usize = 32;
/// A clamp nearer to the base than this is the base, mm.
const AT_BASE: f64 = 0.03;
/// Ends of centrelines this far apart are so when they are rounded to a micrometre, mm.
const CLEAR: f64 = 0.002;
/// A solid base thinner than this part of the height is doubtful.
const THIN: f64 = 0.02;

/// A wall as it was measured, finger frame, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredWall {
    /// Centreline from base to tip; two points if it is straight.
    pub centreline: Vec<Point>,
    /// Pairs (arc, thickness); one if it is the same everywhere.
    pub thickness: Vec<[f64; 2]>,
    /// Arc at which the solid base ends.
    pub clamp: f64,
}

/// A wall in the figure's frame.
#[derive(Clone, Debug)]
pub(super) struct Line {
    /// Centreline.
    pub centre: Vec<Point>,
    /// Points of the inner face, base to tip.
    pub inner: Vec<Point>,
    thickness: Vec<[f64; 2]>,
    clamp: f64,
}

pub(super) struct Walls {
    pub front: Line,
    pub back: Line,
    /// The finger frame's origin.
    pub origin: Point,
    pub undecided: Vec<Undecided>,
}

impl Walls {
    pub(super) fn measured(self, moved: impl Fn(Point) -> Point) -> [MeasuredWall; 2] {
        [self.front, self.back].map(|line| MeasuredWall {
            centreline: line.centre.into_iter().map(&moved).collect(),
            thickness: line.thickness,
            clamp: line.clamp,
        })
    }
}

/// Finds both walls.
pub(super) fn walls(figure: &Figure, samples: &[Sample], has_origin: bool) -> Result<Walls, MeasureError> {
    let mut undecided = Vec::new();
    let heights = || figure.outer.iter().map(|p| p[1]);
    let (bottom, top) = (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
    // The lowest window's lower edge: what lies below it is the solid base.
    let is_down = |s: &Sample| s.normal[1] < -0.8;
    let floor: Vec<&Sample> =
        samples.iter().filter(|s| s.window == 0 && is_down(s) && s.hit.window.is_none()).collect();
    let (corners, under) = corners(figure, &floor);
    if floor.is_empty() || under < THIN * (top - bottom) {
        undecided.push(Undecided {
            key: "finger.front.clamp_mm",
            why: "there is no solid base below the lowest window: the beams were taken to be held at its lower end"
                .to_owned(),
        });
    }
    let base_height = if has_origin && (bottom - 1e-6..=corners[0][1].min(corners[1][1]) + 0.5).contains(&0.0) {
        Some(0.0)
    } else {
        None
    };
    let side = |name: &'static str, sign: f64| -> Result<Raw, MeasureError> {
        let mut found: Vec<Crossing> = samples
            .iter()
            .filter(|s| !is_down(s) && s.hit.window.is_none() && s.normal[0] * sign > 0.5 && s.hit.square > SQUARE)
            .map(|s| Crossing {
                inner: s.point,
                centre: along(s.point, s.normal, 0.5 * s.hit.distance),
                thickness: s.hit.distance * s.hit.square.clamp(0.0, 1.0).sqrt(),
            })
            .collect();
        found.sort_by(|a, b| a.centre[1].total_cmp(&b.centre[1]));
        if found.len() < 4 { Err(MeasureError::NoWall { wall: name }) } else { Ok(Raw { found }) }
    };
    let (front, back) = (side("front", 1.0)?, side("back", -1.0)?);
    let mut front_line = front.line(corners[0], base_height);
    let origin = front_line[0];
    // The front ends at the figure's top, the back where it would meet the front's centreline.
    let last = front_line.len() - 1;
    let toward = unit(minus(front_line[last], front_line[last - 1]));
    let tip = along(front_line[last], toward, (top - front_line[last][1]) / toward[1].max(0.1));
    let mut back_line = back.line(corners[1], base_height);
    let last = back_line.len() - 1;
    let d = unit(minus(back_line[last], back_line[last - 1]));
    let turn = cross(d, toward);
    let meeting = along(back_line[last], d, cross(minus(tip, back_line[last]), toward) / turn);
    let above = |line: &[Point]| line.last().is_none_or(|last| meeting[1] > last[1]);
    let meets =
        turn.abs() > 0.02 && distance(meeting, tip) < 0.2 * (top - bottom) && above(&back_line) && above(&front_line);
    let outwards = unit(minus(front_line[0], back_line[0]));
    let ends = if meets { Ends::of(tip, meeting, d, outwards) } else { Ends::apart(tip, back_line[last], d) };
    if ends.cut > STRAY {
        undecided.push(Undecided {
            key: "finger.front.tip_mm",
            why: format!(
                "the centrelines meet {:.2} mm below the front wall's upper end, and both beams were ended there",
                ends.cut
            ),
        });
    }
    set_end(&mut front_line, ends.front);
    set_end(&mut back_line, ends.back);
    let front = front.finished(front_line, corners[0]);
    let back = back.finished(back_line, corners[1]);
    undecided.push(Undecided {
        key: "finger.back.clamp_mm",
        why: "both beams were taken to be held as far as the solid base reaches; bolts or a holder may hold the back beam higher".to_owned(),
    });
    Ok(Walls { front, back, origin, undecided })
}

/// Upper ends of the centrelines. As a case has them, the front's is not behind the back's.
struct Ends {
    front: Point,
    back: Point,
    /// How much of the front was left away.
    cut: f64,
}

impl Ends {
    /// Of centrelines that meet near the front's end `tip`; the back's direction is `d`, and the front's base lies `outwards` of the
    /// back's.
    fn of(tip: Point, meeting: Point, d: Point, outwards: Point) -> Self {
        if distance(meeting, tip) < STRAY {
            return Self { front: tip, back: tip, cut: 0.0 };
        }
        let clear = dot(minus(tip, meeting), outwards);
        // The back may end a hair earlier to be clear.
        let earlier = ((CLEAR - clear) / dot(d, outwards)).max(0.0);
        if clear >= CLEAR || (dot(d, outwards) > 0.0 && earlier < STRAY) {
            return Self { front: tip, back: along(meeting, d, if clear >= CLEAR { 0.0 } else { -earlier }), cut: 0.0 };
        }
        if meeting[1] < tip[1] {
            return Self { front: meeting, back: meeting, cut: distance(meeting, tip) };
        }
        Self::apart(tip, meeting, d)
    }

    /// Of centrelines that end beside each other; `p` is on the back's.
    fn apart(tip: Point, p: Point, d: Point) -> Self {
        Self { front: tip, back: along(p, d, dot(minus(tip, p), d)), cut: 0.0 }
    }
}

/// A ray across a wall.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    inner: Point,
    centre: Point,
    thickness: f64,
}

struct Raw {
    found: Vec<Crossing>,
}

impl Raw {
    /// The centreline from the base (at a height, or across from the lowest window's corner) to the last crossing.
    fn line(&self, corner: Point, base_height: Option<f64>) -> Vec<Point> {
        let centres: Vec<Point> = self.found.iter().map(|c| c.centre).collect();
        let straight = fitted(&centres);
        let stray = centres.iter().map(|&p| straight.off(p).abs()).fold(0.0, f64::max);
        let mut line = if stray < STRAY {
            let ends = [centres[0], centres[centres.len() - 1]].map(|p| straight.foot(p));
            ends.to_vec()
        } else {
            reduced(&centres, |a, b, p| Fit::through(a, b).off(p).abs())
        };
        let d = unit(minus(line[1], line[0]));
        let by = match base_height {
            Some(height) => (height - line[0][1]) / d[1].max(0.1),
            None => dot(minus(corner, line[0]), d),
        };
        // Straight on to the base; a first point that lies below it goes.
        let base = along(line[0], d, by);
        if by <= 0.0 {
            line.insert(0, base)
        } else {
            line[0] = base
        }
        if line.len() == 3 && stray < STRAY {
            line.remove(1);
        }
        line
    }

    fn finished(self, centre: Vec<Point>, corner: Point) -> Line {
        let arc = |p: Point| arc_beside(&centre, p);
        let mut thickness: Vec<[f64; 2]> = self.found.iter().map(|c| [arc(c.centre), c.thickness]).collect();
        thickness.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let values = || thickness.iter().map(|knot| knot[1]);
        let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
        let mut sorted: Vec<f64> = values().collect();
        sorted.sort_by(f64::total_cmp);
        let share = |part: f64| sorted[((sorted.len() - 1) as f64 * part) as usize];
        let thickness = if most - least < STRAY || share(0.97) - share(0.03) < 0.5 * STRAY {
            vec![[0.0, share(0.5)]]
        } else {
            let linear = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| {
                let t = if b[0] > a[0] { (p[0] - a[0]) / (b[0] - a[0]) } else { 0.0 };
                (a[1] + t * (b[1] - a[1]) - p[1]).abs()
            };
            let mut knots = reduced(&thickness, linear);
            knots.dedup_by(|b, a| b[0] - a[0] < 1e-3);
            knots
        };
        let clamp = arc(corner);
        let inner = self.found.iter().map(|c| c.inner).collect();
        Line { clamp: if clamp < AT_BASE { 0.0 } else { clamp }, centre, inner, thickness }
    }
}

/// Ends (front, back) of the lowest window's lower edge, and how much material lies below it.
fn corners(figure: &Figure, floor: &[&Sample]) -> ([Point; 2], f64) {
    let window = &figure.windows[0];
    let under = floor.iter().map(|s| s.hit.distance).fold(f64::INFINITY, f64::min);
    let lowest = window.iter().copied().min_by(|a, b| a[1].total_cmp(&b[1])).unwrap_or(window[0]);
    // Vertices on the edges that the floor's samples lie on.
    let near = |p: &&Point| {
        floor.iter().any(|s| dot(minus(**p, s.point), s.normal).abs() < 1e-3 + 1e-3 * distance(**p, s.point))
    };
    let on: Vec<Point> = window.iter().filter(near).copied().collect();
    let extreme =
        |sign: f64| on.iter().copied().max_by(|a, b| (sign * a[0]).total_cmp(&(sign * b[0]))).unwrap_or(lowest);
    ([extreme(1.0), extreme(-1.0)], if under.is_finite() { under } else { 0.0 })
}

/// Replaces the last point of a straight end by one farther on, or adds it.
fn set_end(line: &mut Vec<Point>, end: Point) {
    let last = line.len() - 1;
    if last == 1 { line[1] = end } else { line.push(end) }
}

fn unit(v: Point) -> Point {
    let size = v[0].hypot(v[1]).max(1e-12);
    v.map(|x| x / size)
}

/// A straight line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    point: Point,
    direction: Point,
}

impl Fit {
    pub(super) fn through(a: Point, b: Point) -> Self {
        Self { point: a, direction: unit(minus(b, a)) }
    }

    /// Signed distance, positive to the left.
    fn off(&self, p: Point) -> f64 {
        cross(self.direction, minus(p, self.point))
    }

    /// Its direction.
    pub(super) fn direction(&self) -> Point {
        self.direction
    }

    fn foot(&self, p: Point) -> Point {
        along(self.point, self.direction, dot(minus(p, self.point), self.direction))
    }
}

/// Least squares of distances, in the order of the points.
pub(super) fn fitted(points: &[Point]) -> Fit {
    let count = points.len() as f64;
    let mean = [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / count);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for &p in points {
        let [x, y] = minus(p, mean);
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
    }
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    let direction = [angle.cos(), angle.sin()];
    let sign = dot(direction, minus(points[points.len() - 1], points[0])).signum();
    Fit { point: mean, direction: direction.map(|x| sign * x) }
}

/// Fewer points of a line (Douglas and Peucker), within the finest tolerance that leaves few enough.
fn reduced(points: &[Point], off: impl Fn(Point, Point, Point) -> f64) -> Vec<Point> {
    let mut tolerance = FINE;
    loop {
        let mut kept = vec![false; points.len()];
        kept[0] = true;
        kept[points.len() - 1] = true;
        let mut open = vec![(0, points.len() - 1)];
        while let Some((from, to)) = open.pop() {
            let far = (from + 1..to)
                .map(|i| (off(points[from], points[to], points[i]), i))
                .max_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, i)) = far.filter(|far| far.0 > tolerance) {
                kept[i] = true;
                open.extend([(from, i), (i, to)]);
            }
        }
        let few: Vec<Point> = points.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(&p, _)| p).collect();
        // Two more points come at the ends of a centreline.
        if few.len() + 2 <= KNOTS {
            return few;
        }
        tolerance *= 1.5;
    }
}

/// Arc along a polyline of the place next to a point; straight on beyond the ends.
pub(super) fn arc_beside(line: &[Point], p: Point) -> f64 {
    let (mut best, mut from) = ((f64::INFINITY, 0.0), 0.0);
    let last = line.len() - 2;
    for (i, pair) in line.windows(2).enumerate() {
        let length = distance(pair[0], pair[1]);
        let d = unit(minus(pair[1], pair[0]));
        let low = if i == 0 { f64::NEG_INFINITY } else { 0.0 };
        let high = if i == last { f64::INFINITY } else { length };
        let by = dot(minus(p, pair[0]), d).clamp(low, high);
        let off = distance(p, along(pair[0], d, by));
        if off < best.0 {
            best = (off, from + by);
        }
        from += length;
    }
    best.1
}

/// Where a straight line crosses a polyline, which goes straight on beyond its ends: the place nearest to `near`.
pub(super) fn crossing(line: &[Point], p: Point, d: Point, near: Point) -> Point {
    let mut best = (f64::INFINITY, near);
    let last = line.len() - 2;
    for (i, pair) in line.windows(2).enumerate() {
        let e = minus(pair[1], pair[0]);
        let turn = cross(d, e);
        if turn.abs() < 1e-12 {
            continue;
        }
        let at = cross(minus(p, pair[0]), d) / cross(e, d);
        let low = if i == 0 { f64::NEG_INFINITY } else { -1e-9 };
        let high = if i == last { f64::INFINITY } else { 1.0 + 1e-9 };
        let point = along(pair[0], e, at);
        if (low..=high).contains(&at) && distance(point, near) < best.0 {
            best = (distance(point, near), point);
        }
    }
    best.1
}
