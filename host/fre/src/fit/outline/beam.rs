//! The front beam in the picture: both its edges, followed from a place where they are found.
//!
//! Everything is in the finger frame. The *outer* edge is the surface that touches objects (to the right when looking from
//! base to tip), the *inner* one looks at the lamellae. The centreline lies half-way between them; where one of them cannot be
//! seen (a hinge, the object, the tip's wedge) it is half a thickness from the other.

use std::collections::VecDeque;
use std::ops::RangeInclusive;

use model_core::design::Beam;

use super::edge::{self, Edge};
use super::error::OutlineError;
use super::limits::FAINTEST;
use super::median::median;
use super::photo::Photo;
use super::plane::Plane;
use super::smooth;

/// Distance of places at which edges are looked for, mm.
pub const SPACING: f64 = 0.5;
/// Part of the thickness, inside and outside of the beam, within which an edge is looked for.
const WINDOW: f64 = 0.45;
/// Half the length along the beam over which light is averaged, mm, and the number of profiles in it.
const AVERAGED: (f64, i32) = (0.3, 3);
/// The longest way without any edge, mm.
const LONGEST_GAP: f64 = 6.0;
/// Part of the length at either end that may stay hidden.
const END: f64 = 0.15;
/// Length of beam from which the next place is foretold, mm.
const FORETOLD_FROM: f64 = 6.0;
/// The most of an edge's height that its step may leave unexplained (root mean square).
const CLEAR: f64 = 0.1;
/// Part of the contrast that the outer edge has at least: an object behind it takes some.
const LEAST_HEIGHT: f64 = 0.2;
/// Part of the contrast that an edge before the background has.
const PLAIN: RangeInclusive<f64> = 0.8..=1.25;
/// The most by which an edge that nothing disturbs is more blurred than the first one.
const SHARP: f64 = 1.25;
/// Part of the contrast that the inner edge has, which a neck may take some of.
const INNER_HEIGHT: RangeInclusive<f64> = 0.6..=1.6;
/// Part of the arc lengths looked at first that must have a pair of edges which agrees with the best one.
const SUPPORT: f64 = 0.35;
/// The most by which a bent beam may lean away from its direction without load, mm per mm.
const STEEPEST: f64 = 0.4;
/// How far from its place without load the beam is first looked for, mm.
const LOST: f64 = 4.0;
/// Part of the thickness by which the edges' distance may differ from it.
const THICKNESS: f64 = 0.06;

/// The beam at one arc length.
#[derive(Clone, Copy, Debug)]
pub struct Station {
    /// Arc length, mm.
    pub arc: f64,
    /// Centreline, mm.
    pub centre: [f64; 2],
    /// Distance of the edges over the thickness of the design, where both were seen.
    pub ratio: Option<f64>,
    /// An edge that was seen.
    pub edge: Edge,
}

/// What an edge must look like.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Light of the background less that of the beam; negative for a bright beam.
    pub contrast: f64,
    /// Distance of the edges over the thickness of the design.
    pub ratio: f64,
    /// Standard deviation of the blur, mm.
    pub blur: f64,
}

/// Two edges that may be the beam's.
struct Pair {
    score: f64,
    /// Distance from the beam without load, towards the object, mm.
    shift: f64,
    station: Station,
    look: Look,
}

impl Pair {
    /// Whether both may belong to one beam: the same light, and a line between them that a bent beam may take.
    fn agrees(&self, other: &Self) -> bool {
        let share = self.look.contrast / other.look.contrast;
        let apart = (self.station.arc - other.station.arc).abs();
        (0.5..=2.0).contains(&share) && (self.shift - other.shift).abs() < 0.3 + STEEPEST * apart
    }
}

/// Where to look.
pub struct Search<'a> {
    /// The photograph.
    pub photo: &'a Photo,
    /// Finger frame to pixels.
    pub plane: &'a Plane,
    /// The beam as it was designed.
    pub beam: &'a Beam,
}

impl Search<'_> {
    /// Light along a line, averaged along the beam: pairs (place, light); none if it leaves the picture.
    fn profile(&self, centre: [f64; 2], tangent: [f64; 2], from: f64, to: f64) -> Option<Vec<(f64, f64)>> {
        let normal = [tangent[1], -tangent[0]];
        let step = 0.4 * self.plane.mm_per_pixel(centre)?;
        let count = (((to - from) / step).ceil() as usize).clamp(8, 400);
        let mut profile = Vec::with_capacity(count + 1);
        for i in 0..=count {
            let u = from + (to - from) * i as f64 / count as f64;
            let mut sum = 0.0;
            for j in -AVERAGED.1..=AVERAGED.1 {
                let v = AVERAGED.0 * f64::from(j) / f64::from(AVERAGED.1);
                let x = centre[0] + u * normal[0] + v * tangent[0];
                let y = centre[1] + u * normal[1] + v * tangent[1];
                sum += self.photo.at(self.plane.pixel([x, y])?)?;
            }
            profile.push((u, sum / f64::from(2 * AVERAGED.1 + 1)));
        }
        Some(profile)
    }

    /// Edges (inner, outer) near a centre, places measured from it towards the object.
    fn edges(&self, arc: f64, centre: [f64; 2], tangent: [f64; 2], ratio: f64) -> [Option<Edge>; 2] {
        let thickness = ratio * self.beam.thickness.at(arc);
        [-1.0, 1.0].map(|side| {
            let at = 0.5 * side * thickness;
            let profile = self.profile(centre, tangent, at - WINDOW * thickness, at + WINDOW * thickness)?;
            let clear = |edge: &Edge| edge.rms < CLEAR * edge.height.abs() && edge.blur < 0.7 * WINDOW * thickness;
            let whole = edge::fit(&profile).filter(clear);
            // An object close by is parted from the beam by a narrow gap of background: what lies behind its middle is
            // the next edge.
            whole.or_else(|| edge::fit(before_gap(&profile, side)).filter(clear))
        })
    }

    /// A place near the base where both edges are as far apart as the beam is thick, and their look.
    ///
    /// A pair of edges counts if pairs at other arc lengths agree with it: noise, dots and hinges make single ones.
    pub fn seed(&self, from: f64, to: f64) -> Result<(Station, Look), OutlineError> {
        let length = self.beam.length();
        let low = from.max(0.05 * length);
        let high = to.min(0.4 * length).max(low + 2.0);
        let places = ((high - low) / 1.0).floor() as usize + 1;
        let mut inside = false;
        let pairs: Vec<Pair> = (0..places).filter_map(|i| self.pair(low + i as f64, &mut inside)).collect();
        let supporters = |pair: &Pair| -> Vec<f64> {
            pairs.iter().filter(|other| other.agrees(pair)).map(|other| other.look.contrast).collect()
        };
        let best = pairs.iter().max_by(|a, b| {
            let weight = |pair: &Pair| pair.score * supporters(pair).len() as f64;
            weight(a).total_cmp(&weight(b))
        });
        let at = self.plane.pixel(self.beam.point(low)).unwrap_or([f64::NAN; 2]);
        let thickness = self.beam.thickness.at(low);
        let thickness_px = self.plane.mm_per_pixel(self.beam.point(low)).map_or(f64::NAN, |scale| thickness / scale);
        let none = |contrast| OutlineError::NoBeam { thickness, thickness_px, from: low, to: high, at, contrast };
        let supporters = best.map(supporters).unwrap_or_default();
        match best {
            Some(best) if supporters.len() as f64 >= SUPPORT * places as f64 => {
                let contrast = median(supporters).unwrap_or(0.0);
                if contrast.abs() < FAINTEST {
                    return Err(none(contrast.abs()));
                }
                Ok((best.station, Look { contrast, ..best.look }))
            }
            _ if !inside => Err(OutlineError::FingerOutside { at }),
            _ => Err(none((0..places).filter_map(|i| self.contrast(low + i as f64)).fold(0.0, f64::max))),
        }
    }

    /// The most by which light changes across the place where the beam is looked for, noise averaged out.
    fn contrast(&self, arc: f64) -> Option<f64> {
        let profile = self.profile(self.beam.point(arc), self.beam.direction(arc), -LOST, LOST)?;
        let window = (0.25 * self.beam.thickness.at(arc) / LOST * profile.len() as f64).max(1.0) as usize;
        let means = profile.windows(window).map(|part| part.iter().map(|p| p.1).sum::<f64>() / window as f64);
        let (least, most) = means.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), x| (l.min(x), m.max(x)));
        (most >= least).then_some(most - least)
    }

    /// The clearest pair of edges across the beam at an arc length that are about as far apart as the beam is thick.
    /// `inside` is set if any of the places looked at lies in the picture.
    fn pair(&self, arc: f64, inside: &mut bool) -> Option<Pair> {
        let tangent = self.beam.direction(arc);
        let normal = [tangent[1], -tangent[0]];
        let thickness = self.beam.thickness.at(arc);
        let on = self.beam.point(arc);
        let mut best: Option<Pair> = None;
        for j in 0..=(2.0 * LOST / 0.25) as i32 {
            let shift = -LOST + 0.25 * f64::from(j);
            let centre = [on[0] + shift * normal[0], on[1] + shift * normal[1]];
            *inside |= self.plane.pixel(centre).is_some_and(|pixel| self.photo.contains(pixel));
            let [Some(inner), Some(outer)] = self.edges(arc, centre, tangent, 1.0) else { continue };
            // From the beam to the background the light changes one way on one side, the other way on the other.
            if inner.height * outer.height >= 0.0 {
                continue;
            }
            let contrast = 0.5 * (outer.height - inner.height);
            let ratio = (outer.at - inner.at) / thickness;
            let middle = 0.5 * (outer.at + inner.at);
            if (ratio - 1.0).abs() > 0.3 || middle.abs() > 0.2 {
                continue;
            }
            let equal = inner.height.abs().min(outer.height.abs()) / inner.height.abs().max(outer.height.abs());
            let score = contrast.abs() * equal * (1.0 - (ratio - 1.0).abs());
            if best.as_ref().is_none_or(|known| score > known.score) {
                let centre = [centre[0] + middle * normal[0], centre[1] + middle * normal[1]];
                let station = Station { arc, centre, ratio: Some(ratio), edge: outer };
                best = Some(Pair {
                    score,
                    shift: shift + middle,
                    station,
                    look: Look { contrast, ratio, blur: inner.blur.min(outer.blur) },
                });
            }
        }
        best
    }

    /// The beam at a place, given where it is expected; none without an edge that looks like it.
    pub fn station(&self, arc: f64, centre: [f64; 2], tangent: [f64; 2], look: &Look) -> Option<Station> {
        let normal = [tangent[1], -tangent[0]];
        let width = look.ratio * self.beam.thickness.at(arc);
        let fits = |edge: &Edge, side: f64| {
            let share = side * edge.height / look.contrast;
            // Behind the inner edge lies the background, or a neck that hides it; behind the outer one an object of any light.
            if side < 0.0 { INNER_HEIGHT.contains(&share) } else { share > LEAST_HEIGHT }
        };
        let [inner, outer] = self.edges(arc, centre, tangent, look.ratio);
        let inner = inner.filter(|edge| fits(edge, -1.0));
        let outer = outer.filter(|edge| fits(edge, 1.0));
        let (middle, ratio, edge) = match (inner, outer) {
            // An object behind the outer edge, and what is left of the background before it, shift that edge.
            (Some(inner), Some(outer))
                if !PLAIN.contains(&(outer.height / look.contrast)) && inner.blur < SHARP * look.blur =>
            {
                (inner.at + 0.5 * width, None, inner)
            }
            (Some(inner), Some(outer)) => {
                let apart = outer.at - inner.at;
                if (apart - width).abs() < THICKNESS * width {
                    (0.5 * (inner.at + outer.at), Some(apart / self.beam.thickness.at(arc)), outer)
                } else {
                    // One of them is something else: the one farther from where it was expected.
                    let (by_inner, by_outer) = (inner.at + 0.5 * width, outer.at - 0.5 * width);
                    if by_inner.abs() < by_outer.abs() { (by_inner, None, inner) } else { (by_outer, None, outer) }
                }
            }
            (Some(inner), None) => (inner.at + 0.5 * width, None, inner),
            (None, Some(outer)) => (outer.at - 0.5 * width, None, outer),
            (None, None) => return None,
        };
        let centre = [centre[0] + middle * normal[0], centre[1] + middle * normal[1]];
        Some(Station { arc, centre, ratio, edge })
    }

    /// Follows the beam from a place to both ends. Arc lengths are counted from the end at the base, where the beam lies
    /// as without load.
    pub fn follow(&self, seed: Station, look: &Look, from: f64, to: f64) -> Result<Vec<Station>, OutlineError> {
        let mut stations = VecDeque::from([seed]);
        self.walk(&mut stations, look, -1.0, from)?;
        if let Some(first) = stations.front().copied() {
            let (on, along) = (self.beam.point(first.arc), self.beam.direction(first.arc));
            let ahead = (first.centre[0] - on[0]) * along[0] + (first.centre[1] - on[1]) * along[1];
            stations.iter_mut().for_each(|station| station.arc += ahead);
        }
        self.walk(&mut stations, look, 1.0, to)?;
        Ok(stations.into())
    }

    fn walk(&self, stations: &mut VecDeque<Station>, look: &Look, sign: f64, end: f64) -> Result<(), OutlineError> {
        let Some(start) = (if sign > 0.0 { stations.back() } else { stations.front() }).map(|station| station.arc)
        else {
            return Ok(());
        };
        let mut last = start;
        for step in 1.. {
            let arc = start + sign * SPACING * f64::from(step);
            if sign * (arc - end) > 1e-9 {
                break;
            }
            let (centre, tangent) = self.foretell(stations, arc, sign);
            let seen = self.station(arc, centre, tangent, look);
            match seen {
                Some(station) if sign > 0.0 => stations.push_back(station),
                Some(station) => stations.push_front(station),
                None if (arc - last).abs() < LONGEST_GAP => continue,
                // Near an end the wedge of the tip, the base or an object close by may hide both edges: the outline ends there.
                None if (end - last).abs() < END * self.beam.length() => break,
                None => {
                    let at = self.plane.pixel(centre).unwrap_or([f64::NAN; 2]);
                    let inside = self.photo.contains(at);
                    return Err(OutlineError::NoEdge { from: last.min(arc), to: last.max(arc), at, inside });
                }
            }
            last = arc;
        }
        Ok(())
    }

    /// Where the beam goes on, from the stations nearest to a place; the direction is from base to tip.
    fn foretell(&self, stations: &VecDeque<Station>, arc: f64, sign: f64) -> ([f64; 2], [f64; 2]) {
        let near: Vec<&Station> = if sign > 0.0 {
            stations.iter().rev().take_while(|station| arc - station.arc < FORETOLD_FROM + SPACING).collect()
        } else {
            stations.iter().take_while(|station| station.arc - arc < FORETOLD_FROM + SPACING).collect()
        };
        let rest = self.beam.direction(arc);
        let Some(&&nearest) = near.first().or(stations.back().as_ref()) else { return (self.beam.point(arc), rest) };
        let ahead = arc - nearest.arc;
        let straight = [nearest.centre[0] + ahead * rest[0], nearest.centre[1] + ahead * rest[1]];
        if near.len() < 4 {
            return (straight, rest);
        }
        let axis = |axis: usize| {
            let points: Vec<(f64, f64)> =
                near.iter().map(|station| (station.arc - nearest.arc, station.centre[axis])).collect();
            parabola(&points)
        };
        let (Some([x, dx, ddx]), Some([y, dy, ddy])) = (axis(0), axis(1)) else { return (straight, rest) };
        let unit = |dx: f64, dy: f64| (dx.hypot(dy) > 0.5).then(|| [dx / dx.hypot(dy), dy / dx.hypot(dy)]);
        let slopes = [0.0, ahead, 2.0 * ahead].map(|twice| unit(dx + ddx * twice, dy + ddy * twice));
        let [Some(here), Some(half), Some(there)] = slopes else { return (straight, rest) };
        // Along the beam as far as the arc length says, not as the parabola does: its error would come back at every step.
        let behind = (nearest.centre[0] - x) * here[0] + (nearest.centre[1] - y) * here[1];
        let onward = |axis: usize| [x, y][axis] + behind * here[axis] + ahead * half[axis];
        ([onward(0), onward(1)], there)
    }
}

/// The part of a profile from the beam's inside to where the light differs most from there; `side` is 1 if the inside comes
/// first, −1 if it comes last.
fn before_gap(profile: &[(f64, f64)], side: f64) -> &[(f64, f64)] {
    let third = profile.len() / 3;
    let inside = if side > 0.0 { &profile[..third] } else { &profile[profile.len() - third..] };
    let light = inside.iter().map(|p| p.1).sum::<f64>() / third.max(1) as f64;
    let differs = |i: &usize| (profile[*i].1 - light).abs();
    let farthest = (0..profile.len()).max_by(|a, b| differs(a).total_cmp(&differs(b))).unwrap_or(0);
    if side > 0.0 { &profile[..=farthest] } else { &profile[farthest..] }
}

/// Coefficients of 1, u and u² of the least-squares parabola through points; a line through fewer than eight of them.
fn parabola(points: &[(f64, f64)]) -> Option<[f64; 3]> {
    let columns = if points.len() < 8 { 2 } else { 3 };
    let matrix = nalgebra::DMatrix::from_fn(points.len(), columns, |row, power| points[row].0.powi(power as i32));
    let values = nalgebra::DVector::from_iterator(points.len(), points.iter().map(|point| point.1));
    let solved = matrix.svd(true, true).solve(&values, 1e-12).ok()?;
    Some([solved[0], solved[1], solved.get(2).copied().unwrap_or(0.0)])
}

/// A smooth line through stations.
pub struct Line<'a> {
    stations: &'a [Station],
    reach: f64,
}

/// A place on the line.
pub struct OnLine {
    /// The point, mm.
    pub point: [f64; 2],
    /// Direction from base to tip.
    pub tangent: [f64; 2],
    /// Standard deviation of a single station across the line, mm.
    pub scatter: f64,
    /// Standard deviation of the point across the line, mm.
    pub deviation: f64,
    /// Distance along the beam to the nearest station, mm.
    pub nearest: f64,
}

impl<'a> Line<'a> {
    /// Takes neighbours up to `reach` mm to either side.
    pub fn new(stations: &'a [Station], reach: f64) -> Self {
        Self { stations, reach }
    }

    /// The line at an arc length; none without stations around it.
    pub fn at(&self, arc: f64) -> Option<OnLine> {
        let nearest = self.stations.iter().min_by(|a, b| (a.arc - arc).abs().total_cmp(&(b.arc - arc).abs()))?;
        let near: Vec<&Station> =
            self.stations.iter().filter(|station| (station.arc - arc).abs() < self.reach.max(2.0) + 1.0).collect();
        // A first direction: along the neighbours.
        let (first, last) = (near.first()?, near.last()?);
        let along = [last.centre[0] - first.centre[0], last.centre[1] - first.centre[1]];
        let size = along[0].hypot(along[1]);
        if size < 1e-6 {
            return None;
        }
        let tangent = [along[0] / size, along[1] / size];
        let normal = [tangent[1], -tangent[0]];
        let ahead = arc - nearest.arc;
        let origin = [nearest.centre[0] + ahead * tangent[0], nearest.centre[1] + ahead * tangent[1]];
        // Across the direction over along it: arc lengths are only as good as their steps.
        let local: Vec<(f64, f64)> = near
            .iter()
            .map(|station| {
                let d = [station.centre[0] - origin[0], station.centre[1] - origin[1]];
                (d[0] * tangent[0] + d[1] * tangent[1], d[0] * normal[0] + d[1] * normal[1])
            })
            .collect();
        let fitted = smooth::fit(&local, self.reach)?;
        let point = [origin[0] + fitted.value * normal[0], origin[1] + fitted.value * normal[1]];
        let turned = [tangent[0] + fitted.slope * normal[0], tangent[1] + fitted.slope * normal[1]];
        let size = turned[0].hypot(turned[1]);
        Some(OnLine {
            point,
            tangent: [turned[0] / size, turned[1] / size],
            scatter: fitted.scatter,
            deviation: fitted.deviation,
            nearest: ahead.abs(),
        })
    }
}
