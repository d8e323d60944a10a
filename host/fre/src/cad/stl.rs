//! STL: the outline extruded, as triangles; and the outline of an extruded solid.

use std::collections::HashMap;
use std::io::Cursor;

use earcut::Earcut;
use stl_io::{Normal, Triangle, Vertex};

use super::{CadError, Drawing};
use crate::finger::{Loop, Point, cross, distance, minus};

/// Largest part of a solid's surface that may lie neither across nor along the direction of extrusion: roundings of edges.
const OTHER: f64 = 0.02;
/// How far a normal may lean, as a cosine or a sine.
const LEAN: f64 = 0.02;
/// Triangles with less than this area are slivers of a triangulation, mm².
const SLIVER: f64 = 1e-9;
/// A vertex is on an edge that it is nearer to than this, mm: single precision moves it by less.
const ON_EDGE: f64 = 2e-5;
/// Vertices nearer than this are one, mm.
const SAME: f64 = 1e-3;

/// Triangles of the solid from 0 to `width` in z.
pub(super) fn encode(loops: &[Loop], width: f64) -> Result<Vec<u8>, CadError> {
    let loops: Vec<Loop> = loops.iter().map(|points| apart(points)).collect();
    let (mut flat, mut holes): (Vec<Point>, Vec<usize>) = (Vec::new(), Vec::new());
    for (i, points) in loops.iter().enumerate() {
        if i > 0 {
            holes.push(flat.len());
        }
        flat.extend(points);
    }
    let mut corners: Vec<usize> = Vec::new();
    Earcut::new().earcut(flat.iter().copied(), &holes, &mut corners);
    if corners.is_empty() {
        return Err(CadError::Unwritable("it has no inside".to_owned()));
    }
    let vertex = |[x, y]: Point, z: f64| [x as f32, y as f32, z as f32];
    let mut triangles = Vec::new();
    let mut add = |corners: [[f32; 3]; 3]| {
        let [a, b, c] = corners.map(nalgebra::Vector3::from);
        let normal = (b - a).cross(&(c - a));
        let normal: [f32; 3] = normal.try_normalize(0.0).unwrap_or_default().into();
        triangles.push(Triangle { normal: Normal::new(normal), vertices: corners.map(Vertex::new) });
    };
    let corners = split(corners, &flat);
    // All triangles turn the same way.
    let turn = |three: &[usize]| cross(minus(flat[three[1]], flat[three[0]]), minus(flat[three[2]], flat[three[0]]));
    let turned = corners.chunks_exact(3).map(turn).sum::<f64>() < 0.0;
    for three in corners.chunks_exact(3) {
        let mut points = [0, 1, 2].map(|i| flat[three[i]]);
        if turned {
            points.swap(1, 2);
        }
        let [a, b, c] = points;
        add([vertex(a, width), vertex(b, width), vertex(c, width)]);
        add([vertex(a, 0.0), vertex(c, 0.0), vertex(b, 0.0)]);
    }
    for points in &loops {
        // Counter-clockwise about the material, so that the sides face out of it.
        for (&a, &b) in points.iter().zip(points.iter().cycle().skip(1)) {
            add([vertex(a, 0.0), vertex(b, 0.0), vertex(b, width)]);
            add([vertex(a, 0.0), vertex(b, width), vertex(a, width)]);
        }
    }
    let mut bytes = Vec::new();
    stl_io::write_stl(&mut bytes, triangles.iter()).map_err(|error| CadError::Unwritable(error.to_string()))?;
    Ok(bytes)
}

/// A loop without points that single precision or a triangulation would take for their neighbours.
fn apart(points: &[Point]) -> Loop {
    let mut kept: Loop = Vec::with_capacity(points.len());
    for &point in points {
        if kept.last().is_none_or(|&last| distance(last, point) > SAME) {
            kept.push(point);
        }
    }
    while kept.len() > 1 && distance(kept[0], kept[kept.len() - 1]) <= SAME {
        kept.pop();
    }
    kept
}

/// Triangles whose edges have no vertex between their ends: where the triangulation left one on an edge, the triangle is divided there. Slivers,
/// of which one corner is on the edge between the others, are left out: their neighbours are divided at that corner, and meet there.
fn split(corners: Vec<usize>, points: &[Point]) -> Vec<usize> {
    let is_sliver = |three: &[usize; 3]| {
        (0..3).any(|i| between(points[three[i]], points[three[(i + 1) % 3]], points[three[(i + 2) % 3]]))
    };
    let mut open: Vec<[usize; 3]> = corners.chunks_exact(3).map(|three| [three[0], three[1], three[2]]).collect();
    let mut done = Vec::with_capacity(corners.len());
    while let Some(three) = open.pop() {
        if is_sliver(&three) {
            continue;
        }
        let inside = (0..3).find_map(|side| {
            let (a, b) = (three[side], three[(side + 1) % 3]);
            (0..points.len())
                .find(|&p| !three.contains(&p) && between(points[p], points[a], points[b]))
                .map(|p| (side, p))
        });
        match inside {
            // Each part has fewer vertices on its edges.
            Some((side, p)) => {
                let [a, b, c] = [0, 1, 2].map(|i| three[(side + i) % 3]);
                open.extend([[a, p, c], [p, b, c]]);
            }
            None => done.extend(three),
        }
    }
    done
}

/// True for a point on the inside of an edge.
fn between(p: Point, a: Point, b: Point) -> bool {
    let (e, to) = (minus(b, a), minus(p, a));
    let length = e[0].hypot(e[1]);
    let by = crate::finger::dot(to, e) / length.max(1e-12);
    by > SAME && by < length - SAME && cross(e, to).abs() < ON_EDGE * length
}

type Vector = nalgebra::Vector3<f64>;

/// The outline of one end of an extruded solid.
pub(super) fn decode(bytes: &[u8]) -> Result<Drawing, CadError> {
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes))
        .map_err(|error| CadError::Content(format!("not an STL that can be read: {error}")))?;
    let vertices: Vec<Vector> =
        mesh.vertices.iter().map(|v| Vector::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]))).collect();
    let triangles: Vec<([usize; 3], Vector)> = mesh
        .faces
        .iter()
        .map(|face| {
            let [a, b, c] = face.vertices.map(|i| vertices[i]);
            (face.vertices, 0.5 * (b - a).cross(&(c - a)))
        })
        .collect();
    let (triangles, slivers): (Vec<_>, Vec<_>) = triangles.into_iter().partition(|(_, area)| area.norm() > SLIVER);
    let total: f64 = triangles.iter().map(|(_, area)| area.norm()).sum();
    if triangles.is_empty() || !total.is_finite() {
        return Err(CadError::Content("the solid has no surface".to_owned()));
    }
    let axes = [Vector::z(), Vector::y(), Vector::x()];
    let other = |axis: &Vector| -> f64 {
        let stray = triangles.iter().filter(|(_, area)| {
            let cosine = area.dot(axis).abs() / area.norm();
            cosine > LEAN && cosine < 1.0 - LEAN
        });
        stray.map(|(_, area)| area.norm()).sum::<f64>() / total
    };
    let caps = |axis: &Vector| -> f64 {
        let flat = triangles.iter().filter(|(_, area)| area.dot(axis).abs() / area.norm() >= 1.0 - LEAN);
        flat.map(|(_, area)| area.norm()).sum::<f64>() / total
    };
    // The best of the three: a finger lies along one of them, and has more sides than ends.
    let extruded = axes.iter().filter(|axis| other(axis) <= OTHER && caps(axis) > 0.0);
    let Some(axis) = extruded.min_by_key(|axis| sides(&triangles, axis)) else {
        let stray = 100.0 * axes.iter().map(other).fold(f64::INFINITY, f64::min);
        return Err(CadError::Content(format!(
            "not an extrusion along x, y or z: {stray:.0} % of its surface lies neither across nor along any of them; allowed is {:.0} %",
            100.0 * OTHER
        )));
    };
    let along = |i: usize| vertices[i].dot(axis);
    let [low, high] = [f64::min as fn(f64, f64) -> f64, f64::max]
        .map(|pick| triangles.iter().flat_map(|(corners, _)| corners).map(|&i| along(i)).reduce(pick).unwrap_or(0.0));
    // The plane of the drawing: z is drawn as x and y, y as x and z, x as y and z.
    let plane: fn(&Vector) -> Point = match axis.iter().position(|&x| x != 0.0) {
        Some(0) => |v| [v.y, v.z],
        Some(1) => |v| [v.x, v.z],
        _ => |v| [v.x, v.y],
    };
    let within = 0.05 * (high - low);
    let on_top = |corners: &[usize; 3]| corners.iter().all(|&i| along(i) > high - within);
    let cap = triangles.iter().filter(|(_, area)| area.dot(axis) / area.norm() >= 1.0 - LEAN).chain(&slivers);
    let cap = cap.filter(|(corners, _)| on_top(corners));
    // Vertices that coincide are one, so that the edges inside the cap cancel.
    let mut places: HashMap<[i64; 2], usize> = HashMap::new();
    let mut points: Vec<Point> = Vec::new();
    let mut place = |i: usize| {
        let p = plane(&vertices[i]);
        *places.entry(p.map(|x| (x / SAME).round() as i64)).or_insert_with(|| {
            points.push(p);
            points.len() - 1
        })
    };
    let mut edges: HashMap<[usize; 2], i32> = HashMap::new();
    for (corners, _) in cap {
        let at = corners.map(&mut place);
        for i in 0..3 {
            let (a, b) = (at[i], at[(i + 1) % 3]);
            if a < b {
                *edges.entry([a, b]).or_default() += 1;
            } else if b < a {
                *edges.entry([b, a]).or_default() -= 1;
            }
        }
    }
    let left = |edges: &HashMap<[usize; 2], i32>| {
        let mut left: Vec<([usize; 2], i32)> = edges.iter().filter(|e| *e.1 != 0).map(|(e, n)| (*e, *n)).collect();
        left.sort_unstable();
        left
    };
    // An edge that runs past a vertex of others cancels with theirs piece by piece.
    let boundary = left(&edges);
    let mut ends: Vec<usize> = boundary.iter().flat_map(|(edge, _)| *edge).collect();
    ends.sort_unstable();
    ends.dedup();
    let mut edges: HashMap<[usize; 2], i32> = HashMap::new();
    for ([a, b], times) in boundary {
        let mut stations: Vec<usize> =
            ends.iter().copied().filter(|&p| p != a && p != b && between(points[p], points[a], points[b])).collect();
        let from_a = |p: usize| crate::finger::distance(points[a], points[p]);
        stations.extend([a, b]);
        stations.sort_by(|&p, &q| from_a(p).total_cmp(&from_a(q)));
        for pair in stations.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let (edge, sign) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
            *edges.entry(edge).or_default() += sign * times;
        }
    }
    let pieces = left(&edges).into_iter().map(|(edge, _)| edge);
    let pieces = pieces.map(|[a, b]| vec![points[a], points[b]]).collect();
    let (loops, open) = super::joined(pieces, 0.5 * SAME);
    let mut drawing = Drawing { loops, width: Some(high - low), has_origin: true, notes: Vec::new() };
    if open > 0 {
        drawing.notes.push(format!("{open} edges of the solid's end do not close and were left aside"));
    }
    Ok(drawing)
}

/// How many directions the sides of an extrusion along an axis have not: fewer for the true axis of a figure with slanted sides.
fn sides(triangles: &[([usize; 3], Vector)], axis: &Vector) -> (std::cmp::Reverse<usize>, usize) {
    let mut directions: Vec<[i32; 3]> = triangles
        .iter()
        .filter(|(_, area)| area.dot(axis).abs() / area.norm() <= LEAN)
        .map(|(_, area)| {
            let n = area.normalize();
            [n.x, n.y, n.z].map(|x| (50.0 * x).round() as i32)
        })
        .collect();
    directions.sort_unstable();
    directions.dedup();
    (std::cmp::Reverse(directions.len()), 0)
}
