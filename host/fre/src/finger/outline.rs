//! The closed outline of a finger as it is printed: one loop around it, and one around each window between the rungs. Rungs with free ends leave
//! one window, into which they reach.

use super::{Body, BodyError, Point, Rung, RungEnds, Wall, along, cross, distance, dot, minus};

/// A closed line; its last point is joined to its first. Around the finger it runs counter-clockwise, around a window clockwise.
pub type Loop = Vec<Point>;

/// Largest distance of a fillet's chords from its arc, mm.
const CHORD: f64 = 2e-3;

/// The outline, the loop around the finger first. Below both walls is a solid base that reaches `base` mm below their centrelines' starts
/// (0: it ends there).
///
/// # Errors
/// The finger is not one piece, or the base is too low to lie below the lowest window.
pub fn outline(body: &Body, base: f64) -> Result<Vec<Loop>, BodyError> {
    if body.rungs.iter().any(|rung| rung.joined == RungEnds::Pinned) {
        let (what, allowed) = ("a pinned lamella", "\"flexible\" or \"welded\"");
        return Err(BodyError::Unsupported { key: "hinge.kind", what, allowed });
    }
    let mut loops = vec![around(body, base)];
    if body.rungs.iter().any(|rung| matches!(rung.joined, RungEnds::Free { .. })) {
        loops.push(comb(body));
    } else {
        loops.extend((0..=body.rungs.len()).map(|k| window(body, k)));
    }
    // The floor of the lowest window is as oblique as the walls' ends: a low base would let it through.
    let starts = [body.front.outer(0.0), body.back.outer(0.0)];
    let level = |x: f64| match base > 0.0 {
        true => bottom(body, base),
        false => starts[0][1] + (x - starts[0][0]) / (starts[1][0] - starts[0][0]) * (starts[1][1] - starts[0][1]),
    };
    if loops[1].iter().any(|point| point[1] < level(point[0])) {
        let lowest = loops[1].iter().map(|point| point[1]).fold(f64::INFINITY, f64::min);
        return Err(BodyError::LowBase { base, needed: bottom(body, 0.0) - lowest });
    }
    Ok(loops)
}

/// Height of the lower edge of a solid base that reaches so far below the centrelines' starts.
fn bottom(body: &Body, base: f64) -> f64 {
    body.front.centre(0.0)[1].min(body.back.centre(0.0)[1]) - base
}

fn around(body: &Body, base: f64) -> Loop {
    let (front, back) = (&body.front, &body.back);
    let mut points: Loop = front.knots(0.0, body.ends[0]).into_iter().map(|arc| front.outer(arc)).collect();
    points.extend(&body.top[1..]);
    points.extend(back.knots(0.0, body.ends[1]).into_iter().rev().skip(1).map(|arc| back.outer(arc)));
    if base > 0.0 {
        let bottom = bottom(body, base);
        points.extend([[back.outer(0.0)[0], bottom], [front.outer(0.0)[0], bottom]]);
    }
    points.dedup_by(|b, a| distance(*a, *b) < 1e-9);
    points
}

/// The window below rung k; above the last one for k = number of rungs.
fn window(body: &Body, k: usize) -> Loop {
    let (front, back) = (&body.front, &body.back);
    let base = body.base();
    let below = k.checked_sub(1).and_then(|k| body.rungs.get(k));
    let above = body.rungs.get(k);
    let roots = |rung: &Rung, end: usize| [true, false].map(|is_front| body.roots(rung, is_front)[end]);
    let low = below.map_or(base, |rung| roots(rung, 1));
    let high = above.map_or_else(|| top(body), |rung| roots(rung, 0));
    // Counter-clockwise first, which keeps the order readable: down the back, across, up the front, back over the rung above.
    let mut points: Loop = back.knots(low[1], high[1]).into_iter().rev().map(|arc| back.inner(arc)).collect();
    let mut corners = Vec::new();
    if let Some(rung) = below {
        corners.push((points.len() - 1, fillet(rung)));
        points.extend(edge(rung, 0.5).into_iter().rev());
        corners.push((points.len(), fillet(rung)));
    }
    points.extend(front.knots(low[0], high[0]).into_iter().map(|arc| front.inner(arc)));
    if let Some(rung) = above {
        corners.push((points.len() - 1, fillet(rung)));
        points.extend(edge(rung, -0.5));
        corners.push((0, fillet(rung)));
    }
    hole(&points, &corners)
}

/// Arcs (front, back) at which the highest window ends.
fn top(body: &Body) -> [f64; 2] {
    match body.solid_above {
        Some(height) => [&body.front, &body.back]
            .map(|wall| wall.crossing(Wall::inner, [0.0, height], [1.0, 0.0], wall.arc_at_height(height))),
        None => body.merge,
    }
}

/// The window of a finger whose rungs end before the back wall.
fn comb(body: &Body) -> Loop {
    let (front, back) = (&body.front, &body.back);
    let (mut from, high) = (body.base(), top(body));
    let mut points: Loop = back.knots(from[1], high[1]).into_iter().rev().map(|arc| back.inner(arc)).collect();
    let mut corners = Vec::new();
    for rung in &body.rungs {
        let [low, up] = body.roots(rung, true);
        points.extend(front.knots(from[0], low).into_iter().map(|arc| front.inner(arc)));
        corners.push((points.len() - 1, fillet(rung)));
        points.extend(body.free_end(rung));
        corners.push((points.len(), fillet(rung)));
        from[0] = up;
    }
    points.extend(front.knots(from[0], high[0]).into_iter().map(|arc| front.inner(arc)));
    hole(&points, &corners)
}

/// A window from its corners counter-clockwise, some of them rounded.
fn hole(points: &[Point], corners: &[(usize, f64)]) -> Loop {
    let mut points = rounded(points, corners);
    points.dedup_by(|b, a| distance(*a, *b) < 1e-9);
    if points.len() > 1 && distance(points[0], points[points.len() - 1]) < 1e-9 {
        points.pop();
    }
    points.reverse();
    points
}

fn fillet(rung: &Rung) -> f64 {
    match rung.joined {
        RungEnds::Welded { fillet } | RungEnds::Free { fillet, .. } => fillet,
        RungEnds::Necked { .. } | RungEnds::Pinned => 0.0,
    }
}

/// Corners of a rung's lower (−½) or upper (½) edge between the faces, front to back; none for a straight one.
fn edge(rung: &Rung, side: f64) -> Vec<Point> {
    let RungEnds::Necked { neck, insets } = rung.joined else { return Vec::new() };
    let (first, last) = (insets[0], rung.length - insets[1]);
    let [front, back] = rung.thickness.map(|t| side * t.max(neck));
    vec![rung.at(first, side * neck), rung.at(first, front), rung.at(last, back), rung.at(last, side * neck)]
}

/// A loop with arcs of given radii in place of some of its corners.
fn rounded(points: &[Point], corners: &[(usize, f64)]) -> Loop {
    let count = points.len();
    let mut dropped = vec![false; count];
    let mut arcs: Vec<(usize, Vec<Point>)> = Vec::new();
    for &(corner, radius) in corners.iter().filter(|corner| corner.1 > 0.0) {
        let at = points[corner];
        let to = |step: usize| {
            let d = minus(points[(corner + step) % count], at);
            let size = d[0].hypot(d[1]).max(1e-12);
            d.map(|x| x / size)
        };
        let (before, after) = (to(count - 1), to(1));
        let half = 0.5 * dot(before, after).clamp(-1.0, 1.0).acos();
        // A corner that is hardly one needs no arc.
        if !(1e-3..=1.5).contains(&half) {
            continue;
        }
        let reach = radius / half.tan();
        for step in [count - 1, 1] {
            let mut i = (corner + step) % count;
            while i != corner && distance(points[i], at) < reach {
                dropped[i] = true;
                i = (i + step) % count;
            }
        }
        let middle = [before[0] + after[0], before[1] + after[1]];
        let size = middle[0].hypot(middle[1]);
        let centre = along(at, middle.map(|x| x / size), radius / half.sin());
        let spoke = minus(along(at, before, reach), centre);
        let turn = std::f64::consts::PI - 2.0 * half;
        let turn = turn * cross(spoke, minus(along(at, after, reach), centre)).signum();
        let pieces = (turn.abs() / (8.0 * CHORD / radius).sqrt()).ceil().max(1.0) as usize;
        let on_arc = |i: usize| {
            let (sin, cos) = (turn * i as f64 / pieces as f64).sin_cos();
            [centre[0] + cos * spoke[0] - sin * spoke[1], centre[1] + sin * spoke[0] + cos * spoke[1]]
        };
        arcs.push((corner, (0..=pieces).map(on_arc).collect()));
    }
    let mut out = Loop::new();
    for (i, &point) in points.iter().enumerate() {
        match arcs.iter().find(|arc| arc.0 == i) {
            Some((_, arc)) => out.extend(arc),
            None if dropped[i] => {}
            None => out.push(point),
        }
    }
    out
}

/// Twice the signed area of a closed line, positive counter-clockwise, mm².
pub(crate) fn twice_area(points: &[Point]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(&a, &b)| cross(a, b)).sum()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::case::describe_finger;

    fn preset(name: &str) -> Body {
        Body::of(&describe_finger(Path::new(&format!("preset:{name}"))).unwrap()).unwrap()
    }

    #[test]
    fn the_outline_of_a_finger_has_a_window_per_cell_and_the_area_of_its_parts() {
        let body = preset("fea-80");
        let loops = outline(&body, 5.0).unwrap();
        assert_eq!(loops.len(), 8);
        assert!(twice_area(&loops[0]) > 0.0 && loops[1..].iter().all(|hole| twice_area(hole) < 0.0));
        let area: f64 = 0.5 * loops.iter().map(|points| twice_area(points)).sum::<f64>();
        // The finite elements' mesh is the same figure without the base, which ends where the clamped ends of the walls begin.
        let case = crate::case::Case::parse(
            "case.toml",
            "finger = \"preset:fea-80\"\nobject = { shape = \"circle\", radius_mm = 40, centre_mm = [41, 45] }\n\
             motion.motor_angles_deg = [2]\n",
        );
        let mesh = crate::fea::Plan::of(&case.unwrap(), 1).unwrap().mesh;
        let (front, back) = (&body.front, &body.back);
        let ends = [front.outer(0.0), front.inner(0.0), back.inner(0.0), back.outer(0.0)];
        let slab = [ends[0], ends[1], ends[2], ends[3], [ends[3][0], -5.0], [ends[0][0], -5.0]];
        let walls_and_rungs = area - 0.5 * twice_area(&slab);
        assert!((walls_and_rungs / mesh.area() - 1.0).abs() < 1e-3, "{walls_and_rungs} {}", mesh.area());
    }

    /// Ribs with a gap leave one window, and the rest has the area of the finite elements' mesh.
    #[test]
    fn ribs_with_a_gap_reach_into_one_window() {
        let text = "[finger]\nwidth_mm = 20\nmaterial = { youngs_modulus_pa = 5e7, poissons_ratio = 0.4 }\n\
             front = { base_mm = [0, 0], tip_mm = [0, 80], thickness_mm = 2 }\n\
             back = { base_mm = [-28, 0], tip_mm = [0, 80], thickness_mm = 2 }\n\
             lamellae = { kind = \"rib\", heights_mm = [15, 30, 45, 58], angle_deg = [-20, 0, 20, 0], \
             thickness_mm = [[2, 1.2], [1.5, 1.5], [1.2, 2], [1, 1]], ends = \"gap\", gap_mm = 0.8 }\n\
             [object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 45]\n\
             [motion]\ndirection = [1, 0]\ndistances_mm = [1]\n";
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("gap.toml");
        std::fs::write(&file, text).unwrap();
        let body = Body::of(&describe_finger(&file).unwrap()).unwrap();
        let loops = outline(&body, 5.0).unwrap();
        assert_eq!(loops.len(), 2);
        assert!(twice_area(&loops[0]) > 0.0 && twice_area(&loops[1]) < 0.0);
        let (front, back) = (&body.front, &body.back);
        let ends = [front.outer(0.0), front.inner(0.0), back.inner(0.0), back.outer(0.0)];
        let slab = [ends[0], ends[1], ends[2], ends[3], [ends[3][0], -5.0], [ends[0][0], -5.0]];
        let area = 0.5 * (twice_area(&loops[0]) + twice_area(&loops[1]) - twice_area(&slab));
        let case = crate::case::Case::parse("case.toml", text).unwrap();
        let mesh = crate::fea::Plan::of(&case, 1).unwrap().mesh;
        assert!((area / mesh.area() - 1.0).abs() < 1e-3, "{area} {}", mesh.area());
        // Each free end is as far from the back wall's face as the gap is wide.
        for rung in &body.rungs {
            for corner in body.free_end(rung) {
                assert!((body.back.height_over_inner(corner).0 - 0.8).abs() < 1e-3, "{corner:?}");
            }
        }
    }

    #[test]
    fn a_base_that_the_lowest_window_would_cut_through_is_refused() {
        // The back wall leans by 19°: its inner face begins 1 mm · sin 19° = 0.33 mm below its centreline.
        let body = preset("fea-80");
        for base in [0.0, 0.3] {
            let error = outline(&body, base).unwrap_err();
            assert!(matches!(error, BodyError::LowBase { needed, .. } if (0.3..0.35).contains(&needed)), "{error}");
        }
        assert!(outline(&body, 0.4).is_ok());
    }

    #[test]
    fn fillets_take_away_their_share_of_a_right_angle() {
        let square = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
        let sharp = 0.5 * twice_area(&square);
        let round = 0.5 * twice_area(&rounded(&square, &[(0, 2.0), (1, 0.0), (2, 2.0)]));
        let share = 4.0 * (1.0 - std::f64::consts::FRAC_PI_4);
        assert!((sharp - round - 2.0 * share).abs() < 0.02, "{}", sharp - round);
    }
}
