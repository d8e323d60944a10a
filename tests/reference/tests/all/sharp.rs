//! Sharp objects, thin pins and the corners of polygons, at every height: none slips between two samples.

use model_core::design::Design;
use model_core::discretise::{Discretisation, Elements, Physics, Sampling, Scheme, Softness};
use model_core::equilibrium::Follower;
use model_core::object::{Corners, Motion, ObjectDesign};
use model_core::real::Real;
use model_core::size::{Paper, Reduced, Size};
use model_core::status::Status;
use reference_tests::{COUNT, fea_80, ladder_80};

model_core::fixed_size!(
    /// Room for ten times as many elements as the PC's default has.
    Dense, cells 8, nodes 3200, samples 3000, contacts 100
);

/// Ten times as fine as [`Discretisation::fine`], and ten times as many samples.
fn dense() -> Discretisation {
    Discretisation {
        elements: Elements::PerSpan { span: 40, tip_span: 40, hinge: 6 },
        sampling: Sampling::PerElement(4),
        ..Discretisation::fine(Physics::Extended)
    }
}

/// Status, magnitude (N) and direction (°) of the force after closing to an angle from an open hand.
fn closed<T: Real, S: Size>(
    design: &Design,
    how: &Discretisation,
    object: ObjectDesign,
    degrees: f64,
) -> (Status, f64, f64) {
    object.validate().expect("a good object");
    let mut finger: Box<Follower<T, S>> = Box::new(Follower::EMPTY);
    finger.configure(design, how).expect("a valid design");
    finger.set_object(object, Motion::Rotating { axis: design.motor_axis });
    assert!(finger.start(0.0), "{object:?}: no open hand");
    let status = finger.follow(degrees.to_radians()).status;
    let [x, y] = finger.solution().force_world().map(Real::to_f64);
    (status, x.hypot(y), y.atan2(x).to_degrees())
}

fn pin(radius: f64, height: f64) -> ObjectDesign {
    ObjectDesign::Circle { centre: [radius + 1.5, height], radius }
}

/// A square standing on a corner, half a millimetre in front of the finger.
fn corner(height: f64, turn: f64) -> ObjectDesign {
    let (sin, cos) = turn.sin_cos();
    let corners = [[0.0, 0.0], [12.0, -12.0], [24.0, 0.0], [12.0, 12.0]];
    let corners = corners.map(|[x, y]| [1.7 + cos * x - sin * y, height + sin * x + cos * y]);
    ObjectDesign::Polygon { corners: Corners::new(&corners).expect("four"), rounding: 0.2 }
}

/// Worst deviation from the dense model, of the force (parts of it) and its direction (°): PC's default, `trapezoid` 170/20, and both
/// resolutions of the microcontroller in single precision.
fn deviations(design: &Design, objects: &[ObjectDesign], degrees: f64) -> [[f64; 2]; 4] {
    let extended = Physics::Extended;
    let each = objects.iter().map(|&object| {
        let (status, force, direction) = closed::<f64, Dense>(design, &dense(), object, degrees);
        assert_eq!(status, Status::Converged, "{object:?}, dense");
        [
            closed::<f64, Paper>(design, &Discretisation::fine(extended), object, degrees),
            closed::<f64, Dense>(design, &Discretisation::full(Scheme::Trapezoid, extended), object, degrees),
            closed::<f32, Reduced>(design, &Discretisation::estimator(extended), object, degrees),
            closed::<f32, Reduced>(design, &Discretisation::reduced(extended), object, degrees),
        ]
        .map(|found| {
            assert_eq!(found.0, Status::Converged, "{object:?}");
            let off = [(found.1 / force - 1.0).abs(), (found.2 - direction).abs()];
            assert!(off[0] < 0.03 && off[1] < 2.0, "{object:?}: {found:?} against {force} N, {direction}°");
            off
        })
    });
    let worst: [[f64; 2]; 4] =
        each.fold([[0.0; 2]; 4], |a, b| core::array::from_fn(|i| core::array::from_fn(|k| f64::max(a[i][k], b[i][k]))));
    println!("force, direction (°): {worst:?}");
    worst
}

/// Heights in fine steps across a lamella, an element's end and samples, and coarse ones along the beam.
fn heights() -> Vec<f64> {
    let fine = (0..12).map(|k| 58.0 + 0.37 * f64::from(k));
    fine.chain((0..9).map(|k| 12.3 + 7.1 * f64::from(k))).collect()
}

#[test]
fn pins_are_met_at_every_height() {
    for radius in [0.15, 0.3, 1.0, 2.0, 5.0] {
        let pins: Vec<ObjectDesign> = heights().into_iter().map(|height| pin(radius, height)).collect();
        let [fine, trapezoid, five, four] = deviations(&ladder_80(), &pins, 8.0);
        for off in [fine, trapezoid] {
            assert!(off[0] < 0.01 && off[1] < 1.5, "Ø{}: {off:?}", 2.0 * radius);
        }
        for off in [five, four] {
            assert!(off[0] < 0.015 && off[1] < 1.0, "Ø{}: {off:?}", 2.0 * radius);
        }
    }
}

#[test]
fn corners_are_met_at_every_height() {
    for turn in [0.0, 0.4, -0.6] {
        let corners: Vec<ObjectDesign> = heights().into_iter().map(|height| corner(height, turn)).collect();
        let [fine, trapezoid, five, four] = deviations(&ladder_80(), &corners, 7.0);
        for off in [fine, trapezoid] {
            assert!(off[0] < 0.01 && off[1] < 1.5, "turned by {turn}: {off:?}");
        }
        for off in [five, four] {
            assert!(off[0] < 0.015 && off[1] < 1.0, "turned by {turn}: {off:?}");
        }
    }
}

/// On the rigid wedge and across its root.
#[test]
fn pins_are_met_on_the_wedge() {
    let pins: Vec<ObjectDesign> = [68.3, 71.0, 73.9, 74.2, 75.0, 77.1].map(|height| pin(0.3, height)).into();
    let worst = deviations(&fea_80(), &pins, 3.0);
    assert!(worst.iter().all(|off| off[0] < 0.015 && off[1] < 1.0), "{worst:?}");
}

/// A pin of 0.6 mm in front of a long, soft finger of few links.
#[test]
fn no_pin_slips_between_the_nodes_of_few_links() {
    let mut design = ladder_80();
    let scale = |p: [f64; 2]| p.map(|x| 1.5 * x);
    for beam in [&mut design.front, &mut design.back] {
        (beam.base, beam.tip) = (scale(beam.base), scale(beam.tip));
    }
    if let model_core::design::Attachments::Heights(heights) = &mut design.lamellae.attachments {
        heights.iter_mut().for_each(|height| *height *= 1.5);
    }
    design.material.youngs_modulus = 26.0;
    let object = ObjectDesign::Circle { centre: [8.0, 60.0], radius: 0.3 };
    for scheme in [Scheme::Paper, Scheme::Trapezoid] {
        let how = Discretisation {
            scheme,
            elements: Elements::FINE,
            sampling: Sampling::Nodes,
            softness: Softness::Fixed(0.0),
            physics: Physics::Extended,
        };
        let (status, force, _) = closed::<f64, Dense>(&design, &how, object, 10.0);
        let (sure, expected, _) = closed::<f64, Dense>(&design, &dense(), object, 10.0);
        assert!(status == Status::Converged && sure == Status::Converged, "{scheme:?}: {status}, {sure}");
        // So few links of first order are far from the limit themselves.
        let allowed = if scheme == Scheme::Paper { 0.35 } else { 0.05 };
        assert!((force / expected - 1.0).abs() < allowed, "{scheme:?}: {force} against {expected}");
    }
}

/// A motion in one call, and one in counts: an object in front of the finger ends in contact with it, and nowhere else.
#[test]
fn nothing_is_cut_through() {
    let cases: Vec<ObjectDesign> = (0..40)
        .map(|k| {
            let (height, k) = (9.0 + 1.61 * f64::from(k), k % 4);
            match k {
                0 => pin(0.15, height),
                1 => pin(0.7, height),
                2 => corner(height, 0.2),
                _ => ObjectDesign::Ellipse { centre: [5.3, height], semi_axes: [4.0, 0.65], angle: 0.0 },
            }
        })
        .collect();
    for object in cases {
        for design in [ladder_80(), fea_80()] {
            let how = Discretisation::estimator(Physics::Extended);
            let mut finger: Box<Follower<f32, Reduced>> = Box::new(Follower::EMPTY);
            finger.configure(&design, &how).expect("a valid design");
            finger.set_object(object, Motion::Rotating { axis: design.motor_axis });
            assert!(finger.start(0.0));
            let whole = finger.follow(4.0_f64.to_radians()).status;
            let force = finger.solution().force_world();
            assert!(matches!(whole, Status::Converged | Status::Snapped), "{object:?}: {whole} at once");
            assert!(finger.start(0.0));
            let mut status = Status::NoContact;
            for count in 0..=(4.0_f64.to_radians() / COUNT) as u32 {
                let next = finger.follow(f64::from(count) * COUNT).status;
                // Once touched, it does not let go.
                assert!(next == status || next != Status::NoContact, "{object:?}: {next} after {status}");
                assert!(next.is_trustworthy(), "{object:?}: {next} at count {count}");
                status = next;
            }
            assert!(status != Status::NoContact, "{object:?}");
            finger.follow(4.0_f64.to_radians());
            let [x, y] = finger.solution().force_world();
            let size = force[0].hypot(force[1]);
            let off = (x - force[0]).hypot(y - force[1]);
            assert!(off < 0.02 * size + 2e-3, "{object:?}: {:?} and {force:?}", [x, y]);
        }
    }
}

/// A box's side of 60 mm that touches with both corners, which do not slide alike: closing and opening by a servo's counts.
#[test]
fn two_corners_take_few_iterations() {
    fn most_and_mean<T: Real>() -> (u32, f64) {
        let corners = Corners::new(&[[2.0, 15.0], [62.0, 15.0], [62.0, 75.0], [2.0, 75.0]]).expect("four corners");
        let design = ladder_80();
        let mut follower: Box<Follower<T, Reduced>> = Box::new(Follower::EMPTY);
        follower.configure(&design, &Discretisation::estimator(Physics::Extended)).expect("a valid finger");
        let motion = Motion::Rotating { axis: design.motor_axis };
        follower.set_object(ObjectDesign::Polygon { corners, rounding: 1.0 }, motion);
        assert!(follower.start(0.0));
        let (mut most, mut sum, mut ticks) = (0, 0, 0);
        for count in (0..=113).chain((0..113).rev()) {
            let outcome = follower.follow(f64::from(count) * COUNT);
            assert!(outcome.status.is_trustworthy(), "{count}: {outcome:?}");
            if follower.solution().touching() > 1 {
                (most, sum, ticks) = (most.max(outcome.iterations), sum + outcome.iterations, ticks + 1);
            }
        }
        assert!(ticks > 150, "{ticks}");
        (most, f64::from(sum) / f64::from(ticks))
    }
    let (single, double) = (most_and_mean::<f32>(), most_and_mean::<f64>());
    println!("iterations, most and mean: {single:?} in single, {double:?} in double precision");
    assert!(single.0 <= 8 && single.1 < 3.0, "{single:?}");
    assert!(double.0 <= 25 && double.1 < 6.0, "{double:?}");
}
