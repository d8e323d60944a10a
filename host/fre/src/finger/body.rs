//! The finger's figure from the keys of `[finger]`: two walls, the rungs between them, the solid tip.

use super::{Point, Wall, along, dot, minus};
use crate::case::keys::{
    Along, FingerTable, HingeFrom, HingeKind, HingeTable, LamellaKind, LamellaeTable, PerRib, RibEnds, RibThickness,
    TipFrom,
};

/// Smallest clear length of anything, mm.
const ROOM: f64 = 1e-3;

/// Why keys describe no figure.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BodyError {
    /// A beam has neither ends nor a centreline of some length.
    #[error("{beam}: base_mm and tip_mm, or centreline_mm with two points or more and thickness_mm, are needed")]
    NoBeam {
        /// `finger.front` or `finger.back`.
        beam: &'static str,
    },
    /// The inner faces do not meet below the tip.
    #[error(
        "the beams' inner faces do not meet below the tip; needed are faces that are apart at the base and meet before the tip"
    )]
    NoTip,
    /// Something that is not a solid figure.
    #[error("{key}: {what} cannot be drawn as one piece; allowed is {allowed}")]
    Unsupported {
        /// The key.
        key: &'static str,
        /// What it is.
        what: &'static str,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A list has another length than there are lamellae.
    #[error("{key} has {found} entries; needed is one for all or one per lamella ({needed})")]
    Count {
        /// The key.
        key: &'static str,
        /// Entries found.
        found: usize,
        /// Number of lamellae.
        needed: usize,
    },
    /// A key that is needed is not there.
    #[error("{key} is missing; needed is {needed}")]
    Missing {
        /// The key.
        key: &'static str,
        /// What is needed.
        needed: &'static str,
    },
    /// The lowest window would cut through the base.
    #[error("the solid base is {base} mm high; more than {needed:.2} mm is needed below the lowest window")]
    LowBase {
        /// Its height, mm.
        base: f64,
        /// Height that the window reaches down to, mm.
        needed: f64,
    },
    /// A part has no room.
    #[error("lamella {}: {what} is {value:.3} mm; more than {ROOM} mm is needed", .rung + 1)]
    NoRoom {
        /// Index of the lamella, from 0 at the base.
        rung: usize,
        /// Which length.
        what: &'static str,
        /// The length, mm.
        value: f64,
    },
}

/// How a rung ends at the walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RungEnds {
    /// Of one piece with the walls, with fillets of this radius (0: sharp corners).
    Welded {
        /// Radius, mm.
        fillet: f64,
    },
    /// Of one piece with the front wall, with fillets of this radius, and so far before the back wall's face.
    Free {
        /// Radius, mm.
        fillet: f64,
        /// Gap, mm.
        gap: f64,
    },
    /// By pins on the centrelines.
    Pinned,
    /// By necks of this thickness; `insets` are the distances (front, back) from the centrelines to the ends of the bar.
    Necked {
        /// Thickness of the necks, mm.
        neck: f64,
        /// Along the rung, mm.
        insets: [f64; 2],
    },
}

/// A lamella or rib.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rung {
    /// Arcs (front, back) at which its axis meets the centrelines.
    pub arcs: [f64; 2],
    /// The points there.
    pub ends: [Point; 2],
    /// Unit vector along its axis, front to back.
    pub along: Point,
    /// Unit vector across, towards the tip.
    pub up: Point,
    /// Distance of the two points.
    pub length: f64,
    /// Thickness at the front and at the back face.
    pub thickness: [f64; 2],
    /// How it ends.
    pub joined: RungEnds,
}

impl Rung {
    /// Point so far along the axis from the front centreline, and so far across.
    pub fn at(&self, along_by: f64, up_by: f64) -> Point {
        along(along(self.ends[0], self.along, along_by), self.up, up_by)
    }
}

/// The figure, finger frame, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The finger's name.
    pub name: String,
    /// Width perpendicular to the plane, at the base.
    pub width: f64,
    /// True if the width changes along the finger.
    pub tapers_in_width: bool,
    /// Contact beam.
    pub front: Wall,
    /// The other one.
    pub back: Wall,
    /// Lamellae, base to tip.
    pub rungs: Vec<Rung>,
    /// Arcs (front, back) below which the walls are held.
    pub clamps: [f64; 2],
    /// Arcs (front, back) at which the inner faces meet.
    pub merge: [f64; 2],
    /// Corners of the tip: on the front wall's outer face, on its centreline's end, on the back wall's outer face.
    pub top: [Point; 3],
    /// Arcs (front, back) at which the outer faces end in the tip's corners.
    pub ends: [f64; 2],
    /// Height above which the tip is solid, if that is below the place where the inner faces meet.
    pub solid_above: Option<f64>,
}

impl Body {
    /// The figure of a finger's keys.
    ///
    /// # Errors
    /// The first thing that makes no figure.
    pub fn of(keys: &FingerTable) -> Result<Self, BodyError> {
        let front = Wall::of(&keys.front, 1.0).ok_or(BodyError::NoBeam { beam: "finger.front" })?;
        let back = Wall::of(&keys.back, -1.0).ok_or(BodyError::NoBeam { beam: "finger.back" })?;
        let merge = merge(&front, &back)?;
        let length = front.length();
        let tip = front.centre(length);
        let top_arc = back.crossing(Wall::outer, tip, front.inward(length), back.length());
        let top = [front.outer(length), tip, back.outer(top_arc)];
        let notch = front.inner(merge[0]);
        let solid = match keys.tip.as_ref().and_then(|tip| tip.rigid_above_mm) {
            Some(TipFrom::Height(height)) if height < notch[1] - ROOM => Some(height),
            _ => None,
        };
        let rungs = match &keys.lamellae {
            Some(lamellae) => rungs(lamellae, keys.hinge.as_ref(), &front, &back)?,
            None => Vec::new(),
        };
        let (width, tapers_in_width) = match &keys.width_mm {
            Along::Everywhere(width) => (*width, false),
            Along::Taper(pairs) => (pairs.first().map_or(0.0, |pair| pair.1), pairs.len() > 1),
        };
        let name = keys.name.clone().unwrap_or_else(|| "finger".to_owned());
        let ends = [length, top_arc];
        let clamps = [keys.front.clamp_mm, keys.back.clamp_mm];
        let body =
            Self { clamps, name, width, tapers_in_width, front, back, rungs, merge, top, ends, solid_above: solid };
        body.check_room()?;
        Ok(body)
    }

    /// Arcs (front, back) of the inner faces at which the window above the solid base begins: the clamps, or, where a wall is held
    /// beyond its first rung, the height of the other wall's clamp.
    pub fn base(&self) -> [f64; 2] {
        let lowest = |side: usize| self.rungs.first().map_or(self.merge[side], |rung| self.roots(rung, side == 0)[0]);
        let walls = [&self.front, &self.back];
        let mut arcs = self.clamps;
        for side in [0, 1] {
            if arcs[side] >= lowest(side) {
                let level = walls[1 - side].centre(arcs[1 - side].min(lowest(1 - side)));
                arcs[side] = walls[side].crossing(Wall::centre, level, [1.0, 0.0], 0.0).clamp(0.0, lowest(side) - ROOM);
            }
        }
        arcs
    }

    /// Where the inner faces meet.
    pub fn notch(&self) -> Point {
        self.front.inner(self.merge[0])
    }

    /// Arcs (lower, upper) at which the edges of a rung meet the inner face of a wall, fillets left out.
    pub fn roots(&self, rung: &Rung, is_front: bool) -> [f64; 2] {
        let (wall, arc) = if is_front { (&self.front, rung.arcs[0]) } else { (&self.back, rung.arcs[1]) };
        [-0.5, 0.5].map(|side| {
            let halves = self.root_thickness(rung).map(|t| side * t);
            let (p, q) = (rung.at(0.0, halves[0]), rung.at(rung.length, halves[1]));
            wall.crossing(Wall::inner, p, minus(q, p), arc)
        })
    }

    /// Thickness of what joins a rung to the (front, back) wall, extrapolated to the centrelines: a neck's, or the rib's own.
    fn root_thickness(&self, rung: &Rung) -> [f64; 2] {
        match rung.joined {
            RungEnds::Necked { neck, .. } => [neck; 2],
            RungEnds::Welded { .. } | RungEnds::Free { .. } | RungEnds::Pinned => {
                let mut faces = self.face_insets(rung);
                faces[1] += self.gap_along(rung);
                let clear = rung.length - faces[0] - faces[1];
                let slope = (rung.thickness[1] - rung.thickness[0]) / clear.max(ROOM);
                [rung.thickness[0] - slope * faces[0], rung.thickness[1] + slope * faces[1]]
            }
        }
    }

    /// Distances (front, back) along a rung's axis from the centrelines to the inner faces.
    pub fn face_insets(&self, rung: &Rung) -> [f64; 2] {
        let reach = |wall: &Wall, near: f64, end: Point, sign: f64| {
            let arc = wall.crossing(Wall::inner, end, rung.along, near);
            sign * dot(minus(wall.inner(arc), end), rung.along)
        };
        [reach(&self.front, rung.arcs[0], rung.ends[0], 1.0), reach(&self.back, rung.arcs[1], rung.ends[1], -1.0)]
    }

    /// Distance of a rung's free end from the back wall's face along its axis; 0 of one that is joined.
    fn gap_along(&self, rung: &Rung) -> f64 {
        match rung.joined {
            RungEnds::Free { gap, .. } => gap / dot(self.back.inward(rung.arcs[1]), rung.along).abs().max(0.1),
            _ => 0.0,
        }
    }

    /// Corners of a rung's free end, the lower one first: so far before the face as the gap is wide.
    pub fn free_end(&self, rung: &Rung) -> [Point; 2] {
        let gap = self.gap_along(rung);
        self.roots(rung, false).map(|arc| along(self.back.inner(arc), rung.along, -gap))
    }

    fn check_room(&self) -> Result<(), BodyError> {
        let mut below = [0.0; 2];
        for (rung, r) in self.rungs.iter().enumerate() {
            let room = |value: f64, what: &'static str| {
                if value > ROOM { Ok(()) } else { Err(BodyError::NoRoom { rung, what, value }) }
            };
            let faces = self.face_insets(r);
            let clear = match r.joined {
                RungEnds::Welded { .. } | RungEnds::Free { .. } | RungEnds::Pinned => {
                    r.length - faces[0] - faces[1] - self.gap_along(r)
                }
                RungEnds::Necked { neck, insets } => {
                    // Each corner of the bar's ends stands clear of the face that the neck comes from.
                    for up in [-0.5, 0.5].map(|side| side * r.thickness[0].max(neck)) {
                        let corner = self.front.height_over_inner(r.at(insets[0], up)).0;
                        room(corner, "the front neck's clear length")?;
                        let corner = self.back.height_over_inner(r.at(r.length - insets[1], up)).0;
                        room(corner, "the back neck's clear length")?;
                    }
                    r.length - insets[0] - insets[1]
                }
            };
            room(clear, "the length between its ends")?;
            for (side, is_front) in [true, false].into_iter().enumerate() {
                let [low, high] = self.roots(r, is_front);
                let free = ["the front beam below it", "the back beam below it"][side];
                room(low - below[side], free)?;
                let free =
                    ["the front beam above it, below the solid tip", "the back beam above it, below the solid tip"]
                        [side];
                room(self.merge[side] - high, free)?;
                below[side] = high;
            }
        }
        Ok(())
    }
}

/// Arcs at which the inner faces meet: below that they are apart.
fn merge(front: &Wall, back: &Wall) -> Result<[f64; 2], BodyError> {
    const STEPS: usize = 200;
    let open = |arc: f64| back.height_over_inner(front.inner(arc)).0;
    let at = |i: usize| front.length() * i as f64 / STEPS as f64;
    if open(0.0) <= 0.0 {
        return Err(BodyError::NoTip);
    }
    let closed = (1..=STEPS).find(|&i| open(at(i)) <= 0.0).ok_or(BodyError::NoTip)?;
    let (mut below, mut above) = (at(closed - 1), at(closed));
    for _ in 0..80 {
        let middle = 0.5 * (below + above);
        if open(middle) > 0.0 { below = middle } else { above = middle }
    }
    let arc = 0.5 * (below + above);
    Ok([arc, back.height_over_inner(front.inner(arc)).1])
}

/// One value for each of so many.
fn each(values: &PerRib, count: usize, key: &'static str) -> Result<Vec<f64>, BodyError> {
    match values {
        PerRib::All(value) => Ok(vec![*value; count]),
        PerRib::Each(values) if values.len() == count => Ok(values.clone()),
        PerRib::Each(values) if values.len() == 1 => Ok(vec![values[0]; count]),
        PerRib::Each(values) => Err(BodyError::Count { key, found: values.len(), needed: count }),
    }
}

fn rungs(keys: &LamellaeTable, hinge: Option<&HingeTable>, front: &Wall, back: &Wall) -> Result<Vec<Rung>, BodyError> {
    let axes = axes(keys, front, back)?;
    let count = axes.len();
    if count == 0 {
        return Ok(Vec::new());
    }
    let count_of = |found: usize| BodyError::Count { key: "lamellae.thickness_mm", found, needed: count };
    let thickness = match &keys.thickness_mm {
        Some(RibThickness::All(t)) => vec![[*t; 2]; count],
        Some(RibThickness::Each(each)) if each.len() == count => each.iter().map(|&t| [t; 2]).collect(),
        Some(RibThickness::Tapered(each)) if each.len() == count => each.clone(),
        Some(RibThickness::Each(each)) => return Err(count_of(each.len())),
        Some(RibThickness::Tapered(each)) => return Err(count_of(each.len())),
        None => return Err(BodyError::Missing { key: "lamellae.thickness_mm", needed: "a number of mm" }),
    };
    let necked = match (keys.kind, keys.ends, hinge.map(|hinge| hinge.kind)) {
        (LamellaKind::Rib, Some(RibEnds::Hinged), _) | (LamellaKind::Rigid, _, Some(HingeKind::Flexible)) => true,
        (LamellaKind::Rib, _, _) | (LamellaKind::Rigid, _, Some(HingeKind::Welded | HingeKind::Pinned)) => false,
        (LamellaKind::Rigid, _, None) => {
            return Err(BodyError::Missing { key: "hinge", needed: "a table with length_mm and thickness_mm" });
        }
    };
    let necks = match hinge.filter(|_| necked) {
        None => None,
        Some(hinge) => {
            let missing = |key| BodyError::Missing { key, needed: "a number of mm" };
            let lengths = hinge.length_mm.as_ref().ok_or_else(|| missing("hinge.length_mm"))?;
            let lengths = each(lengths, count, "hinge.length_mm")?;
            Some((lengths, hinge.thickness_mm.ok_or_else(|| missing("hinge.thickness_mm"))?, hinge.from))
        }
    };
    if necked && necks.is_none() {
        return Err(BodyError::Missing { key: "hinge", needed: "a table with length_mm and thickness_mm" });
    }
    if keys.ends == Some(RibEnds::Gap) && keys.gap_mm.is_none() {
        return Err(BodyError::Missing { key: "lamellae.gap_mm", needed: "a number of mm" });
    }
    let pinned = keys.kind == LamellaKind::Rigid && hinge.is_some_and(|hinge| hinge.kind == HingeKind::Pinned);
    let rung = |(k, (arcs, thickness)): (usize, ([f64; 2], [f64; 2]))| {
        let ends = [front.centre(arcs[0]), back.centre(arcs[1])];
        let length = super::distance(ends[0], ends[1]);
        let direction = minus(ends[1], ends[0]).map(|x| x / length.max(ROOM));
        let up = [direction[1], -direction[0]];
        let joined = match &necks {
            None if pinned => RungEnds::Pinned,
            None => match keys.gap_mm.filter(|_| keys.ends == Some(RibEnds::Gap)) {
                Some(gap) => RungEnds::Free { fillet: keys.fillet_mm, gap },
                None => RungEnds::Welded { fillet: keys.fillet_mm },
            },
            Some((lengths, neck, from)) => {
                let inset = |wall: &Wall, arc: f64| {
                    let e = wall.direction(arc);
                    let sine = (e[0] * direction[1] - e[1] * direction[0]).abs().max(0.1);
                    match from {
                        HingeFrom::Centreline => lengths[k],
                        HingeFrom::Face => lengths[k] + 0.5 * wall.thickness(arc) / sine,
                    }
                };
                RungEnds::Necked { neck: *neck, insets: [inset(front, arcs[0]), inset(back, arcs[1])] }
            }
        };
        Rung { arcs, ends, along: direction, up, length, thickness, joined }
    };
    Ok(axes.into_iter().zip(thickness).enumerate().map(rung).collect())
}

/// Arcs (front, back) of every axis.
fn axes(keys: &LamellaeTable, front: &Wall, back: &Wall) -> Result<Vec<[f64; 2]>, BodyError> {
    match (&keys.heights_mm, &keys.front_arc_mm, &keys.back_arc_mm) {
        (Some(heights), None, None) => {
            let angles = each(&keys.angle_deg, heights.len(), "lamellae.angle_deg")?;
            let axis = |(&height, angle): (&f64, f64)| {
                let level = [front, back].map(|wall| wall.arc_at_height(height));
                let (p, q) = (front.centre(level[0]), back.centre(level[1]));
                let middle = [0.5 * (p[0] + q[0]), height];
                // Positive when the front end, at larger x, is lower.
                let (sin, cos) = angle.to_radians().sin_cos();
                let d = [-cos, sin];
                [front.crossing(Wall::centre, middle, d, level[0]), back.crossing(Wall::centre, middle, d, level[1])]
            };
            Ok(heights.iter().zip(angles).map(axis).collect())
        }
        (None, Some(front), Some(back)) if front.len() == back.len() => {
            Ok(front.iter().zip(back).map(|(&f, &b)| [f, b]).collect())
        }
        (None, Some(front), Some(back)) => {
            Err(BodyError::Count { key: "lamellae.back_arc_mm", found: back.len(), needed: front.len() })
        }
        _ => Err(BodyError::Missing {
            key: "lamellae.heights_mm",
            needed: "an array of mm, or front_arc_mm and back_arc_mm instead",
        }),
    }
}
