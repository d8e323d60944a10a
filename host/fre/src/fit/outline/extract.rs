//! The front beam's outline: both edges followed from base to tip, and the line between them.

use model_core::design::Beam;

use super::beam::{Line, Look, OnLine, SPACING, Search, Station};
use super::error::OutlineError;
use super::median::median;
use super::photo::{Colour, Photo};
use super::plane::Plane;

/// A contrast in white light that is enough, whatever it may be in another.
const PLAIN: f64 = 0.1;
/// The farthest a point of the outline may be from a place where an edge was seen, mm.
const SEEN: f64 = 1.0;
/// The last stretch before the edges are lost, mm: what hides them has begun to bend them there.
const BEFORE_LOSS: f64 = 2.0;

/// What is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// First arc length, mm.
    pub from: f64,
    /// Last arc length, mm.
    pub to: f64,
    /// How far to either side neighbours smooth a point, mm.
    pub smooth: f64,
    /// Distance of the outline's points, mm.
    pub spacing: f64,
}

impl Options {
    /// The whole beam but one thickness at either end, where base and tip round the edges off; points 1 mm apart,
    /// smoothed over 2.5 mm to either side.
    pub fn of(beam: &Beam) -> Self {
        let length = beam.length();
        let end = length - beam.thickness.at(length);
        Self { from: beam.thickness.at(0.0), to: end, smooth: 2.5, spacing: 1.0 }
    }
}

/// A point of the front centreline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlinePoint {
    /// Arc length from the base, mm.
    pub arc: f64,
    /// Finger frame, mm.
    pub point: [f64; 2],
    /// Direction from base to tip.
    pub tangent: [f64; 2],
    /// Standard deviation across the beam from the scatter of the edges, mm; the calibration's error comes on top.
    pub deviation: f64,
}

/// The outline of a front beam.
#[derive(Clone, Debug)]
pub struct Outline {
    /// Base to tip.
    pub points: Vec<OutlinePoint>,
    /// Stretches of arc length without a visible edge, mm.
    pub gaps: Vec<[f64; 2]>,
    /// Contrast in linear light, and thickness seen over thickness of the design.
    pub look: Look,
    /// The light in which the edges were looked for.
    pub colour: Colour,
    /// Standard deviation of the edges' blur, pixels (median).
    pub blur_px: f64,
    /// Standard deviation of a single place from the smoothed line, mm (median).
    pub scatter: f64,
    /// Millimetres per pixel in the middle of the beam.
    pub mm_per_pixel: f64,
}

/// Finds the front beam of a finger; `plane` leads from the finger frame to pixels.
///
/// # Errors
/// The beam is not in the picture, its contrast is too low, or its edges end before the places wanted.
pub fn extract(photo: &Photo, plane: &Plane, beam: &Beam, options: &Options) -> Result<Outline, OutlineError> {
    let in_white = Search { photo, plane, beam }.seed(options.from, options.to);
    let coloured = in_colour(photo, plane, beam, options, &in_white);
    let (photo, (seed, first_look)) = match &coloured {
        Some((photo, seen)) => (photo, *seen),
        None => (photo, in_white?),
    };
    let search = Search { photo, plane, beam };
    let first = search.follow(seed, &first_look, options.from, options.to)?;
    // The thickness where both edges were seen tells where the centre is where only one is.
    let ratio = median(first.iter().filter_map(|station| station.ratio)).unwrap_or(first_look.ratio);
    let look = Look { ratio, ..first_look };
    // Once more with directions across the beam that noise does not turn, at even distances along it.
    let rough = Line::new(&first, options.smooth.max(2.0));
    let (from, to) = (first.first().map_or(0.0, |s| s.arc), first.last().map_or(0.0, |s| s.arc));
    let along = even(&rough, from, to);
    let stations: Vec<Station> =
        along.iter().filter_map(|(arc, on)| search.station(*arc, on.point, on.tangent, &look)).collect();
    let stations = before_losses(&stations, options);
    let line = Line::new(stations, options.smooth.max(SPACING));
    let mut points = Vec::new();
    let mut scatters = Vec::new();
    let count = ((options.to - options.from) / options.spacing + 1e-9).floor().max(0.0) as usize;
    for i in 0..=count {
        let arc = options.from + options.spacing * i as f64;
        // Inside a gap a point may lie between edges; beyond the last edge there is nothing to hold it.
        if !within(stations, arc) {
            continue;
        }
        let Some(on) = line.at(arc).filter(|on| on.nearest <= SEEN) else { continue };
        scatters.push(on.scatter);
        points.push(OutlinePoint { arc, point: on.point, tangent: on.tangent, deviation: on.deviation });
    }
    if points.is_empty() {
        let at = plane.pixel(beam.point(options.from)).unwrap_or([f64::NAN; 2]);
        return Err(OutlineError::NoEdge { from: options.from, to: options.to, at, inside: photo.contains(at) });
    }
    let mm_per_pixel = plane.mm_per_pixel(beam.point(0.5 * beam.length())).unwrap_or(f64::NAN);
    Ok(Outline {
        gaps: gaps(stations, options),
        points,
        look,
        colour: photo.colour(),
        blur_px: median(stations.iter().map(|station| station.edge.blur)).unwrap_or(f64::NAN) / mm_per_pixel,
        scatter: median(scatters).unwrap_or(f64::NAN),
        mm_per_pixel,
    })
}

/// The photograph in the light of a primary, and what was seen in it, where a finger hardly differs from what is behind it but
/// in its colour.
fn in_colour(
    photo: &Photo,
    plane: &Plane,
    beam: &Beam,
    options: &Options,
    in_white: &Result<(Station, Look), OutlineError>,
) -> Option<(Photo, (Station, Look))> {
    let needed = match in_white {
        Ok((_, look)) if look.contrast.abs() >= PLAIN => return None,
        // Twice as much: a primary alone has more noise.
        Ok((_, look)) => 2.0 * look.contrast.abs(),
        Err(OutlineError::NoBeam { .. }) => 0.0,
        Err(_) => return None,
    };
    let seen = Colour::PRIMARIES.into_iter().filter_map(|colour| {
        let photo = photo.in_light(colour);
        let seed = Search { photo: &photo, plane, beam }.seed(options.from, options.to).ok()?;
        (seed.1.contrast.abs() > needed).then_some((photo, seed))
    });
    seen.max_by(|(_, (_, a)), (_, (_, b))| a.contrast.abs().total_cmp(&b.contrast.abs()))
}

/// Places about `SPACING` apart, with their lengths along the line from its start at `from`.
fn even(line: &Line<'_>, from: f64, to: f64) -> Vec<(f64, OnLine)> {
    let count = ((to - from) / SPACING).round().max(0.0) as usize;
    let mut places: Vec<(f64, OnLine)> = Vec::with_capacity(count + 1);
    for on in (0..=count).filter_map(|i| line.at(from + SPACING * i as f64)) {
        let length = match places.last() {
            Some((length, before)) => length + (on.point[0] - before.point[0]).hypot(on.point[1] - before.point[1]),
            None => from,
        };
        places.push((length, on));
    }
    places
}

/// The stations without those just before an end that was not reached. A few stations beyond a gap do not reach it: what hides
/// the edges may look like one.
fn before_losses<'a>(stations: &'a [Station], options: &Options) -> &'a [Station] {
    let torn = |pair: &[Station]| pair[1].arc - pair[0].arc > 2.0 * SEEN;
    let ends = [stations.first(), stations.last()].map(|end| end.map_or(0.0, |station| station.arc));
    let start = stations.windows(2).rposition(|pair| torn(pair) && pair[0].arc < ends[0] + 2.0 * BEFORE_LOSS);
    let end = stations.windows(2).position(|pair| torn(pair) && pair[1].arc > ends[1] - 2.0 * BEFORE_LOSS);
    let whole = start.map_or(0, |last| last + 1)..end.map_or(stations.len(), |last| last + 1);
    let stations = stations.get(whole).unwrap_or(stations);
    let (Some(first), Some(last)) = (stations.first(), stations.last()) else { return stations };
    let low = if first.arc > options.from + 2.0 * SPACING { first.arc + BEFORE_LOSS } else { first.arc };
    let high = if last.arc < options.to - 2.0 * SPACING { last.arc - BEFORE_LOSS } else { last.arc };
    let start = stations.partition_point(|station| station.arc < low);
    let end = stations.partition_point(|station| station.arc <= high);
    stations.get(start..end).unwrap_or_default()
}

fn within(stations: &[Station], arc: f64) -> bool {
    let ends = stations.first().zip(stations.last());
    ends.is_some_and(|(first, last)| (first.arc - SPACING..=last.arc + SPACING).contains(&arc))
}

fn gaps(stations: &[Station], options: &Options) -> Vec<[f64; 2]> {
    let ends = [options.from - SPACING, options.to + SPACING];
    let arcs: Vec<f64> =
        std::iter::once(ends[0]).chain(stations.iter().map(|station| station.arc)).chain([ends[1]]).collect();
    arcs.windows(2).filter(|pair| pair[1] - pair[0] > 2.0 * SEEN).map(|pair| [pair[0], pair[1]]).collect()
}
