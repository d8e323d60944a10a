//! Parts of the finger that touch each other. The model lets them pass through one another: it is seen in its results, not solved for.

use model_core::design::{Beam, Design};
use serde::{Deserialize, Serialize};

use crate::finger::{Point, distance, dot, minus};
use crate::shape::{self, Shape};

/// A part that may touch another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Member {
    /// The contact beam.
    FrontBeam,
    /// The other one.
    BackBeam,
    /// A rigid lamella, from 0 at the base.
    Lamella(usize),
    /// A rib, from 0 at the base.
    Rib(usize),
}

impl std::fmt::Display for Member {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::FrontBeam => f.write_str("front beam"),
            Self::BackBeam => f.write_str("back beam"),
            Self::Lamella(index) => write!(f, "lamella {}", index + 1),
            Self::Rib(index) => write!(f, "rib {}", index + 1),
        }
    }
}

/// Two parts of a deformed finger whose faces have passed through each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelfContact {
    /// The parts.
    pub between: [Member; 2],
    /// How far their faces overlap, mm.
    pub depth: f64,
    /// The middle of the overlap, finger frame, mm.
    pub position: Point,
}

/// The same as JSON has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Written {
    /// Names of the parts, such as `rib 3`.
    pub between: [String; 2],
    /// How far their faces overlap, mm.
    pub depth_mm: f64,
    /// The middle of the overlap, finger frame, mm.
    pub position_mm: Point,
}

impl From<SelfContact> for Written {
    fn from(contact: SelfContact) -> Self {
        let between = contact.between.map(|member| member.to_string());
        Self { between, depth_mm: contact.depth, position_mm: contact.position }
    }
}

/// Faces that are nearer than this part of both thicknesses' mean in the undeformed finger are of one piece or about to be (the wedge
/// below the tip, ribs that spring from one place). Such pairs are not examined.
const ROOM: f64 = 0.5;
/// Overlaps up to this one, mm, are rounding.
const LEAST: f64 = 1e-6;

/// The deepest overlap of the two beams or of neighbouring lamellae in a deformed finger; `None` where they are clear of each other.
/// Faces are half a thickness from the centrelines.
pub fn deepest(design: &Design, shape: &Shape) -> Option<SelfContact> {
    let beams =
        [Line::of_beam(Member::FrontBeam, design, &shape.front), Line::of_beam(Member::BackBeam, design, &shape.back)];
    let rungs: Vec<Line> = if shape.ribs.is_empty() {
        let bars = shape.lamellae.iter().enumerate();
        bars.map(|(k, bar)| Line::of_lamella(Member::Lamella(k), design, k, bar)).collect()
    } else {
        shape.ribs.iter().enumerate().map(|(k, rib)| Line::of_lamella(Member::Rib(k), design, k, rib)).collect()
    };
    let pairs = std::iter::once(&beams[..]).chain(rungs.windows(2));
    let overlaps = pairs.flat_map(|pair| match pair {
        [a, b] => [a.overlap(b), b.overlap(a).map(|found| SelfContact { between: [a.member, b.member], ..found })],
        _ => [None; 2],
    });
    overlaps.flatten().max_by(|x, y| x.depth.total_cmp(&y.depth))
}

/// A member as a chain of discs along its centreline.
struct Line {
    member: Member,
    discs: Vec<Disc>,
}

/// A disc between both faces: its centre in the deformed and in the undeformed finger, mm.
#[derive(Clone, Copy)]
struct Disc {
    centre: Point,
    at_rest: Point,
    radius: f64,
}

impl Line {
    fn of_beam(member: Member, design: &Design, points: &[Point]) -> Self {
        let beam = if member == Member::FrontBeam { &design.front } else { &design.back };
        // Arcs counted from the tip, where every centreline ends. In a solid tip that the back beam ends below, a straight line leads on to
        // the front beam's tip: that line is left out.
        let (points, mut arc) = match points {
            [bends @ .., tip] if beam.tip != design.front.tip && !bends.is_empty() => (
                bends,
                arc_apart(beam, design.flexible_ends()[1], design.front.tip, distance(bends[bends.len() - 1], *tip)),
            ),
            points => (points, beam.length()),
        };
        let mut discs = Vec::with_capacity(points.len());
        for (i, &centre) in points.iter().enumerate().rev() {
            arc -= points.get(i + 1).map_or(0.0, |&next| distance(centre, next));
            let at = arc.max(0.0);
            discs.push(Disc { centre, at_rest: beam.point(at), radius: 0.5 * beam.thickness.at(at) });
        }
        Self { member, discs }
    }

    fn of_lamella(member: Member, design: &Design, lamella: usize, points: &[Point]) -> Self {
        let [from, to] = shape::bar(design, lamella);
        let thickness = design.lamella_thickness(lamella);
        let total: f64 = points.windows(2).map(|pair| distance(pair[0], pair[1])).sum();
        let mut along = 0.0;
        let mut discs = Vec::with_capacity(points.len());
        for (i, &centre) in points.iter().enumerate() {
            along += i.checked_sub(1).map_or(0.0, |before| distance(points[before], centre));
            let part = if total > 0.0 { along / total } else { 0.0 };
            let mixed = |a: f64, b: f64| a + part * (b - a);
            let at_rest = [mixed(from[0], to[0]), mixed(from[1], to[1])];
            discs.push(Disc { centre, at_rest, radius: 0.5 * mixed(thickness[0], thickness[1]) });
        }
        Self { member, discs }
    }

    /// The deepest overlap of this line's discs with another line that runs beside it.
    fn overlap(&self, other: &Self) -> Option<SelfContact> {
        let mut beside = 0;
        let mut worst: Option<SelfContact> = None;
        for disc in &self.discs {
            let near = other.nearest(disc.centre, |disc| disc.centre, &mut beside)?;
            let depth = disc.radius + near.radius - distance(disc.centre, near.point);
            if depth <= worst.map_or(LEAST, |worst| worst.depth) {
                continue;
            }
            let mut start = beside;
            let rest = other.nearest(disc.at_rest, |disc| disc.at_rest, &mut start)?;
            let thickness = disc.radius + rest.radius;
            if distance(disc.at_rest, rest.point) - thickness > ROOM * thickness {
                let position = [0, 1].map(|axis| 0.5 * (disc.centre[axis] + near.point[axis]));
                worst = Some(SelfContact { between: [self.member, other.member], depth, position });
            }
        }
        worst
    }

    /// The nearest point of the centreline, sought from one of its segments on: lines that run beside each other have one nearest point
    /// that moves along with them.
    fn nearest(&self, point: Point, centre: impl Fn(&Disc) -> Point, segment: &mut usize) -> Option<Nearest> {
        let last = self.discs.len().checked_sub(2)?;
        let on = |i: usize| {
            let (a, b) = (&self.discs[i], &self.discs[i + 1]);
            let (p, q) = (centre(a), centre(b));
            let along = minus(q, p);
            let square = dot(along, along);
            let part = if square > 0.0 { (dot(along, minus(point, p)) / square).clamp(0.0, 1.0) } else { 0.0 };
            let foot = [p[0] + part * along[0], p[1] + part * along[1]];
            Nearest { point: foot, radius: a.radius + part * (b.radius - a.radius) }
        };
        let away = |near: &Nearest| distance(point, near.point);
        let mut at = (*segment).min(last);
        let mut best = on(at);
        for forward in [true, false] {
            loop {
                let next = if forward { (at < last).then(|| at + 1) } else { at.checked_sub(1) };
                let Some(next) = next else { break };
                let candidate = on(next);
                if away(&candidate) > away(&best) {
                    break;
                }
                (at, best) = (next, candidate);
            }
        }
        *segment = at;
        Some(best)
    }
}

/// The arc from a start on, mm, at which a beam has come to a distance from a place beyond its end.
fn arc_apart(beam: &Beam, start: f64, place: Point, away: f64) -> f64 {
    let (mut low, mut high) = (start, beam.length());
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if distance(beam.point(middle), place) > away {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// A point of a centreline, and half the thickness there.
struct Nearest {
    point: Point,
    radius: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{PRESETS, preset};

    /// A printed finger with ribs of 1.2 mm, 5 mm apart.
    fn ribbed() -> Design {
        let mut design = preset("fea-80").unwrap().unwrap().design;
        let heights = (2..12).map(|k| 5.0 * f64::from(k)).collect();
        design.lamellae.attachments = model_core::design::Attachments::Heights(heights);
        design.lamellae.thickness = model_core::design::Lamellae::uniform(1.2);
        design.lamellae.kind = model_core::design::LamellaKind::Rib(model_core::design::Ribs::WELDED);
        design
    }

    /// Its undeformed shape with ten pieces per rib.
    fn pieces(design: &Design) -> Shape {
        let mut shape = Shape::undeformed(design);
        for rib in &mut shape.ribs {
            let [from, to] = [rib[0], rib[rib.len() - 1]];
            *rib = (0..=10)
                .map(|i| [0, 1].map(|axis| from[axis] + 0.1 * f64::from(i) * (to[axis] - from[axis])))
                .collect();
        }
        shape
    }

    #[test]
    fn nothing_touches_in_a_finger_at_rest() {
        for name in PRESETS {
            let design = preset(name).unwrap().unwrap().design;
            assert_eq!(deepest(&design, &Shape::undeformed(&design)), None, "{name}");
        }
        let design = ribbed();
        assert_eq!(deepest(&design, &pieces(&design)), None);
    }

    #[test]
    fn a_rib_that_bows_into_the_next_one_is_found_with_its_depth_and_place() {
        let design = ribbed();
        let bowed = |by: f64| {
            let mut shape = pieces(&design);
            shape.ribs[3][5][1] += by;
            (shape.ribs[3][5][0], deepest(&design, &shape))
        };
        // 5 mm apart and 1.2 mm thick: 3.8 mm of room.
        assert_eq!(bowed(3.79).1, None);
        let (x, found) = bowed(4.1);
        let found = found.unwrap();
        assert_eq!(found.between.map(|member| member.to_string()), ["rib 4", "rib 5"]);
        assert!((found.depth - 0.3).abs() < 1e-9, "{found:?}");
        // Between a centreline at 25 + 4.1 mm and one at 30 mm.
        assert!((found.position[0] - x).abs() < 1e-9 && (found.position[1] - 29.55).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn beams_that_meet_below_the_tip_are_found_though_they_are_one_at_the_tip() {
        let design = preset("fea-80").unwrap().unwrap().design;
        let pressed = |share: f64| {
            let mut shape = Shape::undeformed(&design);
            let room = shape.back[34][0] - shape.front[34][0];
            shape.front[34][0] += share * room;
            deepest(&design, &shape)
        };
        assert_eq!(pressed(0.1), None);
        let found = pressed(0.95).unwrap();
        assert_eq!(found.between, [Member::FrontBeam, Member::BackBeam]);
        assert!(found.depth > 0.5, "{found:?}");
    }
}
