//! SVG: a path in mm on a page of the outline's size.

use std::fmt::Write as _;

use kurbo::{BezPath, PathEl, Point as KurboPoint};
use usvg::tiny_skia_path::PathSegment;

use super::{CadError, Drawing};
use crate::finger::Loop;

/// Millimetres per unit of a page at 96 units an inch.
const MM_PER_UNIT: f64 = 25.4 / 96.0;
/// Largest distance of a curve from the chords that it is read as, mm.
const CHORD: f64 = 2e-3;
/// Empty border of the page, mm.
const BORDER: f64 = 2.0;

/// The page.
pub(super) fn encode(loops: &[Loop]) -> String {
    let extreme = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| {
        loops.iter().flatten().map(|point| point[axis]).fold(from, pick)
    };
    let [left, low] = [0, 1].map(|axis| extreme(axis, f64::min, f64::INFINITY) - BORDER);
    let [right, high] = [0, 1].map(|axis| extreme(axis, f64::max, f64::NEG_INFINITY) + BORDER);
    let (width, height) = (right - left, high - low);
    let mut path = String::new();
    for points in loops {
        for (i, [x, y]) in points.iter().enumerate() {
            // Writing to a string cannot fail.
            let _ = write!(path, "{}{:.5} {:.5}", if i == 0 { "M" } else { "L" }, x, -y);
        }
        path.push('Z');
    }
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.5}mm\" \
         height=\"{height:.5}mm\" viewBox=\"{left:.5} {:.5} {width:.5} {height:.5}\">\n<path fill=\"#888\" \
         fill-rule=\"evenodd\" d=\"{path}\"/>\n</svg>\n",
        -high
    )
}

/// Closed paths of the page, whatever their colours.
pub(super) fn decode(bytes: &[u8]) -> Result<Drawing, CadError> {
    let tree = usvg::Tree::from_data(bytes, &usvg::Options::default())
        .map_err(|error| CadError::Content(format!("not an SVG that can be read: {error}")))?;
    let mut drawing = Drawing::default();
    let mut open = Vec::new();
    collect(tree.root(), &mut drawing.loops, &mut open);
    let (joined, left) = super::joined(open, 1e-2);
    drawing.loops.extend(joined);
    if left > 0 {
        drawing.notes.push(format!("{left} lines that are not closed were left aside"));
    }
    Ok(drawing)
}

fn collect(group: &usvg::Group, loops: &mut Vec<Loop>, open: &mut Vec<Loop>) {
    for node in group.children() {
        match node {
            usvg::Node::Group(inner) => collect(inner, loops, open),
            usvg::Node::Path(path) => {
                let transform = path.abs_transform();
                let at = |p: usvg::tiny_skia_path::Point| {
                    let (x, y) = (f64::from(p.x), f64::from(p.y));
                    let (sx, kx, tx) = (f64::from(transform.sx), f64::from(transform.kx), f64::from(transform.tx));
                    let (ky, sy, ty) = (f64::from(transform.ky), f64::from(transform.sy), f64::from(transform.ty));
                    // Pages have y downwards.
                    KurboPoint::new(MM_PER_UNIT * (sx * x + kx * y + tx), -MM_PER_UNIT * (ky * x + sy * y + ty))
                };
                let mut curve = BezPath::new();
                for segment in path.data().segments() {
                    match segment {
                        PathSegment::MoveTo(p) => curve.move_to(at(p)),
                        PathSegment::LineTo(p) => curve.line_to(at(p)),
                        PathSegment::QuadTo(p, q) => curve.quad_to(at(p), at(q)),
                        PathSegment::CubicTo(p, q, r) => curve.curve_to(at(p), at(q), at(r)),
                        PathSegment::Close => curve.close_path(),
                    }
                }
                let mut line = Loop::new();
                let mut end = |line: &mut Loop, closed: bool| {
                    let line = std::mem::take(line);
                    if line.len() > 1 {
                        if closed { loops.push(line) } else { open.push(line) }
                    }
                };
                kurbo::flatten(curve, CHORD, |element| match element {
                    PathEl::MoveTo(p) => {
                        end(&mut line, false);
                        line.push([p.x, p.y]);
                    }
                    PathEl::LineTo(p) => line.push([p.x, p.y]),
                    PathEl::ClosePath => end(&mut line, true),
                    // Flattened curves have lines only.
                    PathEl::QuadTo(..) | PathEl::CurveTo(..) => {}
                });
                end(&mut line, false);
            }
            usvg::Node::Image(_) | usvg::Node::Text(_) => {}
        }
    }
}
