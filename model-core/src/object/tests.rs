//! Every shape against brute force: nearest points found by search, normals and curvatures by differences.

use std::f64::consts::{PI, TAU};
use std::vec::Vec;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;
use crate::real::{norm, vec2};

struct Random(ChaCha8Rng);

impl Random {
    fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn point(&mut self, reach: f64) -> [f64; 2] {
        [self.between(-reach, reach), self.between(-reach, reach)]
    }

    /// Corners on an ellipse in ascending or descending order of the angle: always convex.
    fn corners(&mut self) -> Corners {
        let count = 1 + (7.999 * self.between(0.0, 1.0)) as usize;
        let (centre, axes) = (self.point(30.0), [self.between(5.0, 40.0), self.between(5.0, 40.0)]);
        let start = self.between(0.0, TAU);
        let mut corners: Vec<[f64; 2]> = (0..count)
            .map(|k| {
                let angle = start + TAU * (k as f64 + self.between(0.0, 0.8)) / count as f64;
                [centre[0] + axes[0] * libm::cos(angle), centre[1] + axes[1] * libm::sin(angle)]
            })
            .collect();
        if self.between(0.0, 1.0) < 0.5 {
            corners.reverse();
        }
        Corners::new(&corners).expect("at most eight")
    }

    fn design(&mut self, kind: usize) -> ObjectDesign {
        let design = match kind {
            0 => ObjectDesign::Circle { centre: self.point(30.0), radius: self.between(5.0, 60.0) },
            1 => ObjectDesign::Ellipse {
                centre: self.point(30.0),
                semi_axes: [self.between(8.0, 40.0), self.between(8.0, 40.0)],
                angle: self.between(-PI, PI),
            },
            2 => ObjectDesign::Polygon { corners: self.corners(), rounding: self.between(0.5, 10.0) },
            3 => ObjectDesign::HalfPlane { point: self.point(30.0), normal: self.point(2.0) },
            _ => ObjectDesign::Bore { centre: self.point(30.0), radius: self.between(20.0, 120.0) },
        };
        design.validate().expect("a good design");
        design
    }

    fn displacement(&mut self) -> Displacement<f64> {
        let (s, c) = libm::sincos(self.between(-PI, PI));
        Displacement { rotation: Vec2::new(c, s), translation: vec2(self.point(50.0)) }
    }
}

/// The outline as a closed curve of a parameter 0 … 1.
fn outline(design: &ObjectDesign, at: f64) -> Option<[f64; 2]> {
    let (s, c) = libm::sincos(TAU * at);
    match design {
        ObjectDesign::Circle { centre, radius } | ObjectDesign::Bore { centre, radius } => {
            Some([centre[0] + radius * c, centre[1] + radius * s])
        }
        ObjectDesign::Ellipse { centre, semi_axes: [a, b], angle } => {
            let (t, u) = libm::sincos(*angle);
            Some([centre[0] + a * c * u - b * s * t, centre[1] + a * c * t + b * s * u])
        }
        _ => None,
    }
}

/// Distance to the outline by search, without the sign.
fn search(design: &ObjectDesign, p: [f64; 2]) -> f64 {
    let apart = |q: [f64; 2]| libm::hypot(p[0] - q[0], p[1] - q[1]);
    match design {
        ObjectDesign::Polygon { corners, rounding } => {
            // Distance to the core by search along its edges; the sign by its winding number.
            let (mut least, mut winding) = (f64::MAX, 0.0);
            for k in 0..corners.len() {
                let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
                let place = |t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
                let (mut low, mut high) = (0.0, 1.0);
                for _ in 0..200 {
                    let (u, v) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                    if apart(place(u)) < apart(place(v)) { high = v } else { low = u }
                }
                least = least.min(apart(place(low)));
                let (da, db) = ([a[0] - p[0], a[1] - p[1]], [b[0] - p[0], b[1] - p[1]]);
                winding += libm::atan2(da[0] * db[1] - da[1] * db[0], da[0] * db[0] + da[1] * db[1]);
            }
            let inside = corners.len() > 2 && winding.abs() > PI;
            (if inside { -least } else { least }) - rounding
        }
        ObjectDesign::HalfPlane { point, normal } => {
            let length = libm::hypot(normal[0], normal[1]);
            ((p[0] - point[0]) * normal[0] + (p[1] - point[1]) * normal[1]) / length
        }
        round => {
            let at = |t: f64| apart(outline(round, t).expect("a closed curve"));
            let count = 2000;
            let best = (0..count).map(|k| f64::from(k) / f64::from(count)).min_by(|a, b| at(*a).total_cmp(&at(*b)));
            let best = best.expect("points");
            let (mut low, mut high) = (best - 1e-3, best + 1e-3);
            for _ in 0..200 {
                let (u, v) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                if at(u) < at(v) { high = v } else { low = u }
            }
            at(low)
        }
    }
}

#[test]
fn distances_are_those_found_by_search() {
    let mut random = Random::new(41);
    for case in 0..4000 {
        let design = random.design(case % 5);
        let object = Shape::<f64>::from(design);
        let p = random.point(90.0);
        let (gap, found) = (object.gap(vec2(p)), search(&design, p));
        let off =
            if matches!(design, ObjectDesign::Circle { .. } | ObjectDesign::Ellipse { .. } | ObjectDesign::Bore { .. })
            {
                gap.distance.abs() - found
            } else {
                gap.distance - found
            };
        assert!(off.abs() < 1e-9, "{design:?} at {p:?}: {gap:?} against {found}");
        // The foot lies on the outline, and inside is negative.
        let foot = vec2::<f64>(p) - gap.normal * gap.distance;
        assert!(object.gap(foot).distance.abs() < 1e-9, "{design:?} at {p:?}: foot {foot:?}");
        let inner = object.gap(foot - gap.normal * 1e-3).distance;
        assert!((inner + 1e-3).abs() < 1e-9, "{design:?} at {p:?}: {inner} a little way in");
    }
}

#[test]
fn normals_and_curvatures_are_those_of_differences() {
    let mut random = Random::new(42);
    let mut compared = 0;
    for case in 0..4000 {
        let object = Shape::<f64>::from(random.design(case % 5));
        let p: Vec2<f64> = vec2(random.point(90.0));
        let gap = object.gap(p);
        // Near a bore's axis the curvature is that of a point.
        if gap.distance < 0.0 || gap.curvature < -0.2 {
            continue;
        }
        assert!((norm(gap.normal) - 1.0).abs() < 1e-12);
        let h = 1e-5;
        let d = |x: f64, y: f64| object.gap(p + Vec2::new(x, y)).distance;
        let gradient = Vec2::new((d(h, 0.0) - d(-h, 0.0)) / (2.0 * h), (d(0.0, h) - d(0.0, -h)) / (2.0 * h));
        assert!(norm(gradient - gap.normal) < 1e-6, "{object:?} at {p:?}: {gradient:?} against {gap:?}");
        let along = Vec2::new(-gap.normal.y, gap.normal.x);
        let turn = (object.gap(p + along * h).normal - object.gap(p - along * h).normal) / (2.0 * h);
        let curvature = turn.x * along.x + turn.y * along.y;
        let near = |q: Vec2<f64>| object.gap(q).curvature;
        if (near(p + along * h) - near(p - along * h)).abs() > 1e-3 {
            continue; // Where an edge begins.
        }
        compared += 1;
        assert!((curvature - gap.curvature).abs() < 1e-6, "{object:?} at {p:?}: {curvature} against {gap:?}");
    }
    assert!(compared > 2000, "{compared}");
}

#[test]
fn what_clears_a_shape_is_farther_away_than_asked() {
    let mut random = Random::new(47);
    let mut spared = [0; 5];
    for case in 0..4000 {
        let object = Shape::<f64>::from(random.design(case % 5));
        let p: Vec2<f64> = vec2(random.point(90.0));
        let distance = object.gap(p).distance;
        for least in [0.0, 0.9 * distance.max(0.0), 3.0] {
            let clears = object.clears(p, least);
            assert!(!clears || distance > least, "{object:?} at {p:?}: {distance} against {least}");
            spared[case % 5] += usize::from(clears);
        }
        if case % 5 == 0 {
            assert!(distance < 0.1 || object.clears(p, 0.0), "a circle: {object:?} at {p:?}");
        }
    }
    // A half-plane's gap is as cheap as any test.
    assert!([0, 1, 2, 4].iter().all(|&kind| spared[kind] > 200), "{spared:?}");
}

#[test]
fn a_displacement_moves_points_and_objects_alike() {
    let mut random = Random::new(43);
    for case in 0..2000 {
        let object = Shape::<f64>::from(random.design(case % 5));
        let (p, by) = (vec2(random.point(90.0)), random.displacement());
        let (here, there) = (object.gap(p), object.displaced(&by).gap(by.point(p)));
        assert!((here.distance - there.distance).abs() < 1e-10);
        // On the medial axis of a polygon the nearest edge is a matter of rounding.
        let inside = here.distance < 0.0;
        assert!(inside || norm(by.vector(here.normal) - there.normal) < 1e-9);
        assert!(inside || (here.curvature - there.curvature).abs() < 1e-9);
    }
}

#[test]
fn single_precision_is_as_good_as_its_digits() {
    let mut random = Random::new(44);
    let mut worst = [0.0_f64; 2];
    for case in 0..8000 {
        let design = random.design(case % 5);
        let (single, double) = (Shape::<f32>::from(design), Shape::<f64>::from(design));
        let p = random.point(90.0);
        let (low, high) = (single.gap(vec2(p)), double.gap(vec2(p)));
        worst[0] = worst[0].max((f64::from(low.distance) - high.distance).abs());
        if high.distance > -0.1 {
            let turn = f64::from(low.normal.x) * high.normal.y - f64::from(low.normal.y) * high.normal.x;
            worst[1] = worst[1].max(turn.abs());
        }
    }
    assert!(worst[0] < 4e-5 && worst[1] < 2e-5, "distance {:e} mm, normal {:e} rad", worst[0], worst[1]);
}

fn single(p: Vec2<f64>) -> Vec2<f32> {
    Vec2::new(p.x as f32, p.y as f32)
}

fn double(gap: Gap<f32>) -> Gap<f64> {
    let normal = Vec2::new(f64::from(gap.normal.x), f64::from(gap.normal.y));
    Gap { distance: f64::from(gap.distance), normal, curvature: f64::from(gap.curvature) }
}

#[test]
fn shapes_that_are_the_same_agree() {
    let mut random = Random::new(45);
    for _ in 0..500 {
        let (centre, radius, angle) = (random.point(30.0), random.between(5.0, 50.0), random.between(-PI, PI));
        let p = vec2::<f64>(random.point(90.0));
        let circle = Shape::from(ObjectDesign::Circle { centre, radius }).gap(p);
        let dot = Corners::new(&[centre]).expect("one");
        let same = [
            ObjectDesign::Ellipse { centre, semi_axes: [radius, radius], angle },
            ObjectDesign::Polygon { corners: dot, rounding: radius },
        ];
        for other in same.map(|design| Shape::from(design).gap(p)) {
            assert!((circle.distance - other.distance).abs() < 1e-12);
            assert!(norm(circle.normal - other.normal) < 1e-12);
            assert!((circle.curvature - other.curvature).abs() < 1e-9 * (1.0 + circle.curvature));
        }
        // A half-plane is a circle of any size.
        let (s, c) = libm::sincos(angle);
        let far = [centre[0] - 1e6 * c, centre[1] - 1e6 * s];
        let huge = Shape::from(ObjectDesign::Circle { centre: far, radius: 1e6 }).gap(p);
        let flat = Shape::from(ObjectDesign::HalfPlane { point: centre, normal: [3.0 * c, 3.0 * s] }).gap(p);
        assert!((huge.distance - flat.distance).abs() < 2e-2 && norm(huge.normal - flat.normal) < 2e-4);
        assert!((huge.curvature - flat.curvature).abs() < 2e-6);
        // And a bore.
        let far = [centre[0] + 2e6 * c, centre[1] + 2e6 * s];
        let wide = ObjectDesign::Bore { centre: far, radius: 2e6 };
        for hollow in [Shape::<f64>::from(wide).gap(p), double(Shape::<f32>::from(wide).gap(single(p)))] {
            assert!((hollow.distance - flat.distance).abs() < 1e-2, "{hollow:?} against {flat:?}");
            assert!(norm(hollow.normal - flat.normal) < 1e-4 && (hollow.curvature + 5e-7).abs() < 1e-9);
        }
        // Corners either way round.
        let corners = random.corners();
        let mut other: Vec<[f64; 2]> = corners.to_vec();
        other.reverse();
        let other = Corners::new(&other).expect("as many");
        let [one, two] = [corners, other].map(|corners| Shape::from(ObjectDesign::Polygon { corners, rounding: 1.5 }));
        assert!((one.gap(p).distance - two.gap(p).distance).abs() < 1e-12);
    }
}

#[test]
fn the_nearest_point_of_an_ellipse_takes_few_iterations() {
    let mut random = Random::new(46);
    let mut most = [0; 2];
    let exponent = |random: &mut Random, low: f64, high: f64| libm::exp10(random.between(low, high));
    for case in 0..200_000 {
        // Any two axes allowed, and points near the outline, near the axes, far away and near the centre.
        let long = exponent(&mut random, -1.0, 3.0);
        let short = libm::sqrt(0.1 * long) + (long - libm::sqrt(0.1 * long)).max(0.0) * random.between(0.0, 1.0);
        let (u, v) = match case % 4 {
            0 => (exponent(&mut random, -12.0, 4.0), exponent(&mut random, -12.0, 4.0)),
            1 => (random.between(0.0, 2.0 * long), 0.0),
            2 => (0.0, random.between(0.0, 2.0 * long)),
            _ => (random.between(0.0, 1.5 * long), random.between(0.0, 1.5 * long)),
        };
        let double = Ellipse::<f64>::new([0.0; 2], [long, short], 0.0);
        let (x, y, passes) = double.foot(u, v);
        most[0] = most[0].max(passes);
        assert!(((x / long).powi(2) + (y / short).powi(2) - 1.0).abs() < 1e-12);
        // The foot's normal leads to the point: (p − f) × ∇ vanishes beside their sizes.
        let (nx, ny) = (x * short / long, y * long / short);
        let (dx, dy) = (u - x, v - y);
        let size = (libm::hypot(dx, dy) + long) * libm::hypot(nx, ny);
        let aside = (dx * ny - dy * nx).abs() / size;
        let single = Ellipse::<f32>::new([0.0; 2], [long, short], 0.0).foot(u as f32, v as f32);
        most[1] = most[1].max(single.2);
        assert!(aside < 1e-9, "{long} {short} {u} {v}: {aside:e}");
    }
    // The last pass finds that nothing is left to gain.
    std::println!("iterations: {} in double, {} in single precision", most[0], most[1]);
    assert!(most[0] <= 12 && most[1] <= 12, "{most:?}");
}

#[test]
fn nowhere_is_there_a_nan() {
    let designs = [
        ObjectDesign::Circle { centre: [0.0; 2], radius: 10.0 },
        ObjectDesign::Ellipse { centre: [0.0; 2], semi_axes: [10.0, 5.0], angle: 0.0 },
        ObjectDesign::Ellipse { centre: [0.0; 2], semi_axes: [5.0, 5.0], angle: 0.0 },
        ObjectDesign::Polygon { corners: Corners::new(&[[0.0; 2]]).expect("one"), rounding: 1.0 },
        ObjectDesign::Polygon { corners: Corners::new(&[[-5.0, 0.0], [5.0, 0.0]]).expect("two"), rounding: 1.0 },
        ObjectDesign::Polygon {
            corners: Corners::new(&[[-5.0, 0.0], [5.0, 0.0], [0.0, 5.0]]).expect("three"),
            rounding: 1.0,
        },
        ObjectDesign::HalfPlane { point: [0.0; 2], normal: [0.0, 1e-6] },
        ObjectDesign::Bore { centre: [0.0; 2], radius: 7.5 },
        ObjectDesign::Bore { centre: [1e4, 0.0], radius: 1e4 },
    ];
    let places = [0.0, -0.0, 1e-30, 5.0, -5.0, 7.5, 10.0, 1e-7, 1e4];
    for design in designs {
        let (single, double) = (Shape::<f32>::from(design), Shape::<f64>::from(design));
        for (x, y) in places.into_iter().flat_map(|x| places.map(|y| (x, y))) {
            let gap = double.gap(Vec2::new(x, y));
            assert!(gap.distance.is_finite() && gap.curvature.is_finite(), "{design:?} at {x}, {y}: {gap:?}");
            assert!((norm(gap.normal) - 1.0).abs() < 1e-9, "{design:?} at {x}, {y}: {gap:?}");
            let low = single.gap(vec2([x, y]));
            assert!((f64::from(low.distance) - gap.distance).abs() < 1e-6 * (10.0 + gap.distance.abs()));
            assert!((norm(low.normal) - 1.0).abs() < 1e-5);
        }
    }
}

#[test]
fn bad_designs_are_refused() {
    let polygon = |corners: &[[f64; 2]], rounding| ObjectDesign::Polygon {
        corners: Corners::new(corners).expect("room"),
        rounding,
    };
    let ellipse = |semi_axes, angle| ObjectDesign::Ellipse { centre: [0.0; 2], semi_axes, angle };
    let triangle = [[0.0, 0.0], [10.0, 0.0], [0.0, 10.0]];
    assert_eq!(polygon(&triangle, 1.0).validate(), Ok(()));
    assert_eq!(ellipse([0.1, 0.1], 0.0).validate(), Ok(()));
    assert!(Corners::new(&[[0.0; 2]; MAX_CORNERS + 1]).is_none());
    for bad in [
        polygon(&[], 1.0),
        polygon(&triangle, 0.0),
        polygon(&triangle, f64::NAN),
        polygon(&[[0.0, 0.0], [10.0, f64::INFINITY], [0.0, 10.0]], 1.0),
        polygon(&[[0.0, 0.0], [0.0, 0.0]], 1.0),
        polygon(&[[0.0, 0.0], [10.0, 0.0], [2.0, 2.0], [0.0, 10.0]], 1.0),
        polygon(&[[0.0, 0.0], [10.0, 10.0], [10.0, 0.0], [0.0, 10.0]], 1.0),
        ellipse([1.0, f64::NAN], 0.0),
        ellipse([100.0, 1.0], 0.0),
        ellipse([10.0, 5.0], 7.0),
        ObjectDesign::HalfPlane { point: [0.0; 2], normal: [0.0; 2] },
        ObjectDesign::HalfPlane { point: [0.0; 2], normal: [f64::NAN, 0.0] },
        ObjectDesign::HalfPlane { point: [f64::NAN, 0.0], normal: [1.0, 0.0] },
        ObjectDesign::Circle { centre: [0.0, 1e9], radius: 1.0 },
        ObjectDesign::Bore { centre: [0.0, 3000.0], radius: 100.0 },
        ObjectDesign::Bore { centre: [0.0; 2], radius: 1e8 },
        ObjectDesign::Bore { centre: [0.0; 2], radius: f64::NAN },
    ] {
        let error = bad.validate().expect_err("a bad design");
        assert!(std::format!("{error}").contains("allowed") || matches!(error, ObjectError::RepeatedCorner { .. }));
    }
}
