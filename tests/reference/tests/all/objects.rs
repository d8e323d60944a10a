//! Fingers on objects of every shape, turned and translated: each equilibrium checked by code of its own.

use std::collections::BTreeMap;

use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::object::{Circle, Corners, Displacement, Gap, Motion, Object, ObjectDesign, Shape};
use model_core::real::Vec2;
use model_core::size::{Blank, Paper, Reduced};
use model_core::status::Status;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use reference_tests::ladder_80;

struct Random(ChaCha8Rng);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A shape around the origin.
    fn shape(&mut self, kind: usize) -> ObjectDesign {
        let turn = self.between(0.0, std::f64::consts::TAU);
        match kind {
            0 => ObjectDesign::Circle { centre: [0.0; 2], radius: self.between(5.0, 60.0) },
            1 => {
                let long = self.between(10.0, 50.0);
                let semi_axes = [long, long * self.between(0.3, 1.0)];
                ObjectDesign::Ellipse { centre: [0.0; 2], semi_axes, angle: turn }
            }
            2 => {
                let count = 2 + (6.999 * self.between(0.0, 1.0)) as usize;
                let size = self.between(8.0, 40.0);
                let corner = |k: usize, part: f64| {
                    let (sin, cos) = (turn + std::f64::consts::TAU * (k as f64 + part) / count as f64).sin_cos();
                    [size * cos, size * sin]
                };
                let corners: Vec<[f64; 2]> = (0..count).map(|k| corner(k, self.between(0.0, 0.5))).collect();
                let corners = Corners::new(&corners).expect("at most eight");
                ObjectDesign::Polygon { corners, rounding: self.between(1.0, 10.0) }
            }
            _ => {
                // Leaning towards the tip, most of them.
                let (sin, cos) = self.between(-0.45, 0.05).sin_cos();
                ObjectDesign::HalfPlane { point: [0.0; 2], normal: [-cos, sin] }
            }
        }
    }
}

fn moved(design: ObjectDesign, by: [f64; 2]) -> ObjectDesign {
    let to = |p: [f64; 2]| [p[0] + by[0], p[1] + by[1]];
    match design {
        ObjectDesign::Circle { centre, radius } => ObjectDesign::Circle { centre: to(centre), radius },
        ObjectDesign::Ellipse { centre, semi_axes, angle } => {
            ObjectDesign::Ellipse { centre: to(centre), semi_axes, angle }
        }
        ObjectDesign::Polygon { corners, rounding } => ObjectDesign::Polygon { corners: corners.map(to), rounding },
        ObjectDesign::HalfPlane { point, normal } => ObjectDesign::HalfPlane { point: to(point), normal },
        ObjectDesign::Bore { centre, radius } => ObjectDesign::Bore { centre: to(centre), radius },
    }
}

/// The outline grown by a length on all sides.
fn grown(design: ObjectDesign, by: f64) -> Option<ObjectDesign> {
    match design {
        ObjectDesign::Circle { centre, radius } => Some(ObjectDesign::Circle { centre, radius: radius + by }),
        // Not an ellipse any more.
        ObjectDesign::Ellipse { .. } => None,
        ObjectDesign::Polygon { corners, rounding } => Some(ObjectDesign::Polygon { corners, rounding: rounding + by }),
        ObjectDesign::HalfPlane { point, normal: [x, y] } => {
            let length = x.hypot(y);
            Some(ObjectDesign::HalfPlane {
                point: [point[0] + by * x / length, point[1] + by * y / length],
                normal: [x, y],
            })
        }
        ObjectDesign::Bore { centre, radius } => Some(ObjectDesign::Bore { centre, radius: radius - by }),
    }
}

/// The object moved along x to a distance from the undeformed front beam of `ladder-80`.
fn placed(design: ObjectDesign, height: f64, distance: f64) -> ObjectDesign {
    let gap = |x: f64| {
        let object = Shape::<f64>::from(moved(design, [x, height]));
        (0..=160).map(|k| object.gap(Vec2::new(0.0, 0.5 * f64::from(k))).distance - 1.0).fold(f64::MAX, f64::min)
    };
    let (mut low, mut high) = (0.0, 200.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if gap(middle) < distance { low = middle } else { high = middle }
    }
    moved(design, [high, height])
}

/// The angle or distance at which the undeformed finger first touches, from `first` on.
fn first_contact(object: &Shape<f64>, motion: Motion, first: f64) -> Option<f64> {
    (0..1000)
        .map(|k| first + 0.001 * f64::from(k) * if matches!(motion, Motion::Rotating { .. }) { 1.0 } else { 50.0 })
        .find(|&at| {
            let object = object.displaced(&motion.world_to_finger(at));
            (1..=160).any(|k| object.gap(Vec2::new(0.0, 0.5 * f64::from(k))).distance <= 1.0)
        })
}

type Solver<O> = Box<Follower<f64, Paper, O>>;

fn solver<O: Object<f64>>(how: &Discretisation, object: O, motion: Motion) -> Solver<O> {
    let mut follower = Box::new(Follower::EMPTY);
    follower.configure(&ladder_80(), how).expect("a valid design");
    follower.set_object(object, motion);
    follower
}

/// What an equilibrium must satisfy, from the shape and the forces that the solver reports. `false` where the derivative of the energy
/// was not compared, as the branch ends or a contact comes or goes there.
fn check<O: Object<f64>>(follower: &mut Solver<O>, object: &O, motion: Motion) -> Result<bool, String> {
    let softness = follower.softness();
    let at = follower.solution().coordinate();
    let world = |follower: &Solver<O>, p: [f64; 2]| {
        let [x, y] = follower.solution().to_world(p);
        Vec2::new(x, y)
    };
    let most = follower.solution().contacts().fold(0.0_f64, |most, c| most.max(c.force));
    for point in follower.solution().front().skip(1) {
        let gap = object.gap(world(follower, point)).distance - 1.0;
        if gap < -(softness * most + 1e-8) {
            return Err(format!("a front point lies {gap:e} mm inside the object"));
        }
    }
    let (mut force, mut moment) = (Vec2::new(0.0, 0.0), 0.0);
    for contact in follower.solution().contacts() {
        let p = world(follower, contact.position);
        let gap = object.gap(p);
        if contact.force <= 0.0 || (gap.distance + softness * contact.force).abs() > 1e-8 {
            return Err(format!("a contact of {} N at a gap of {:e} mm", contact.force, gap.distance));
        }
        force -= gap.normal * contact.force;
        if let Motion::Rotating { axis } = motion {
            let arm = p - Vec2::new(axis[0], axis[1]);
            moment -= contact.force * (arm.x * gap.normal.y - arm.y * gap.normal.x);
        }
    }
    let reported = follower.solution().force_world();
    if (force.x - reported[0]).abs() > 1e-7 * (1.0 + force.x.hypot(force.y))
        || (force.y - reported[1]).abs() > 1e-7 * (1.0 + force.x.hypot(force.y))
    {
        return Err(format!("the net force {reported:?} is not the sum of the contacts {force:?}"));
    }
    let drive = match motion {
        Motion::Rotating { .. } => -moment,
        Motion::Translating { direction } => force.x * direction[0] + force.y * direction[1],
    };
    let torque = follower.solution().motor_torque();
    if (drive - torque).abs() > 1e-6 * (1.0 + torque.abs()) {
        return Err(format!("torque {torque}, but the contacts' {drive}"));
    }
    // Torque or drive = d(V + ½ ε Σ μ²)/d coordinate: true at an equilibrium only.
    let touching: Vec<f64> = follower.solution().contacts().map(|c| c.arc).collect();
    let total = |f: &Solver<O>| {
        f.solution().energy() + f.solution().contacts().map(|c| 0.5 * softness * c.force * c.force).sum::<f64>()
    };
    let h = if matches!(motion, Motion::Rotating { .. }) { 1e-5 } else { 1e-3 };
    let mut energies = [0.0; 4];
    for (energy, step) in energies.iter_mut().zip([1.0, -1.0, 2.0, -2.0]) {
        let outcome = follower.follow(at + step * h);
        if !outcome.status.is_trustworthy()
            || !follower.solution().contacts().map(|c| c.arc).eq(touching.iter().copied())
        {
            return Ok(false);
        }
        *energy = total(follower);
    }
    let rate = (8.0 * (energies[0] - energies[1]) - (energies[2] - energies[3])) / (12.0 * h);
    if (rate - torque).abs() > 1e-4 * (1.0 + torque.abs()) {
        return Err(format!("torque {torque}, but the energy's derivative {rate}"));
    }
    Ok(true)
}

const WORDS: [&str; 4] = ["circle", "ellipse", "polygon", "half-plane"];

fn random_motion(random: &mut Random) -> Motion {
    if random.between(0.0, 1.0) < 0.5 {
        Motion::Rotating { axis: [-14.0, -20.0] }
    } else {
        let (sin, cos) = random.between(-0.6, 0.6).sin_cos();
        Motion::Translating { direction: [cos, sin] }
    }
}

fn indentation(random: &mut Random, motion: Motion) -> f64 {
    match motion {
        Motion::Rotating { .. } => random.between(1.0, 12.0).to_radians(),
        Motion::Translating { .. } => random.between(1.0, 12.0),
    }
}

#[test]
fn random_objects_and_motions() {
    let mut random = Random(ChaCha8Rng::seed_from_u64(32));
    let mut table: BTreeMap<(&str, &str), Vec<usize>> = BTreeMap::new();
    let (mut trusted, mut all, mut derived) = (0, 0, 0);
    const CASES: usize = 400;
    for case in 0..CASES {
        let physics = if case % 8 < 4 { Physics::Paper } else { Physics::Extended };
        let how = Discretisation::reduced(physics);
        let design = random.shape(case % 4);
        let design = placed(design, random.between(20.0, 75.0), random.between(0.0, 4.0));
        design.validate().expect("a good object");
        let (motion, object) = (random_motion(&mut random), Shape::<f64>::from(design));
        let mut follower = solver(&how, object, motion);
        let indentation = indentation(&mut random, motion);
        if !follower.start(0.0) {
            panic!("{design:?} {motion:?}: no place to begin");
        }
        let Some(touch) = first_contact(&object, motion, follower.solution().coordinate()) else {
            table.entry((WORDS[case % 4], "never touched")).or_default().push(case);
            continue;
        };
        let inside = object.displaced(&motion.world_to_finger(touch + indentation)).gap(Vec2::new(0.0, 0.0));
        if inside.distance < 1.0 {
            // Pressing the clamped base itself on the object is beyond the model, and it says so.
            let status = follower.follow(touch + indentation).status;
            assert!(!status.is_trustworthy(), "{design:?} {motion:?}: {status}");
            table.entry((WORDS[case % 4], "base in the way")).or_default().push(case);
            continue;
        }
        all += 1;
        let status = follower.follow(touch + indentation).status;
        table.entry((WORDS[case % 4], status.word())).or_default().push(case);
        if status.is_trustworthy() {
            trusted += 1;
            // The nearest sample touches, and is as deep as the softness lets it.
            let most = follower.solution().contacts().fold(0.0_f64, |most, c| most.max(c.force));
            let distance = follower.solution().distance();
            assert!(
                most == 0.0 || (distance + follower.softness() * most).abs() < 1e-8,
                "{design:?}: distance {distance}"
            );
            match check(&mut follower, &object, motion) {
                Ok(compared) => derived += usize::from(compared),
                Err(what) => panic!("case {case}, {design:?}, {motion:?}, {}: {what}", touch + indentation),
            }
        }
    }
    assert!(all > 350 && trusted * 100 >= all * 97, "{trusted} of {all}: {table:?}");
    assert!(derived * 100 >= trusted * 90, "{derived} of {trusted} with the energy's derivative: {table:?}");
}

/// A rounded bar, by code of its own: the solver learns of it through the trait only.
#[derive(Clone, Copy, Debug)]
struct Bar {
    ends: [Vec2<f64>; 2],
    radius: f64,
}

impl Blank for Bar {
    const BLANK: Self = Self { ends: [Vec2::new(0.0, 0.0); 2], radius: 0.0 };
}

impl Object<f64> for Bar {
    fn displaced(&self, by: &Displacement<f64>) -> Self {
        Self { ends: self.ends.map(|end| by.point(end)), radius: self.radius }
    }

    fn gap(&self, point: Vec2<f64>) -> Gap<f64> {
        let [a, b] = self.ends;
        let along = (point - a).dot(&(b - a)) / (b - a).dot(&(b - a));
        let offset = point - (a + (b - a) * along.clamp(0.0, 1.0));
        let distance = offset.x.hypot(offset.y);
        let curvature = if (0.0..=1.0).contains(&along) { 0.0 } else { 1.0 / distance };
        Gap { distance: distance - self.radius, normal: offset / distance, curvature }
    }
}

#[test]
fn a_fifth_shape_needs_nothing_of_the_solver() {
    for (ends, degrees) in [([[9.0, 30.0], [25.0, 60.0]], 6.0), ([[30.0, 20.0], [14.0, 66.0]], 9.0)] {
        let [a, b] = ends;
        let bar = Bar { ends: [Vec2::new(a[0], a[1]), Vec2::new(b[0], b[1])], radius: 6.0 };
        let corners = Corners::new(&ends).expect("two");
        let same = Shape::from(ObjectDesign::Polygon { corners, rounding: 6.0 });
        for physics in [Physics::Paper, Physics::Extended] {
            let how = Discretisation::reduced(physics);
            let motion = Motion::Rotating { axis: [-14.0, -20.0] };
            let (mut one, mut two) = (solver(&how, bar, motion), solver(&how, same, motion));
            assert!(one.start(0.0) && two.start(0.0));
            let (to, touching) = (degrees * 1_f64.to_radians(), one.follow(degrees * 1_f64.to_radians()).status);
            assert_eq!(touching, Status::Converged);
            assert_eq!(two.follow(to).status, Status::Converged);
            assert!(one.solution().touching() > 0);
            let (mine, theirs) = (one.solution().force_world(), two.solution().force_world());
            assert!((mine[0] - theirs[0]).abs() < 1e-7 && (mine[1] - theirs[1]).abs() < 1e-7, "{mine:?} {theirs:?}");
            check(&mut one, &bar, motion).expect("an equilibrium");
        }
    }
}

/// The same object said in another way gives the same equilibrium.
#[test]
fn shapes_that_are_the_same_give_the_same_force() {
    let how = Discretisation::reduced(Physics::Extended);
    let force = |design: ObjectDesign, motion: Motion, to: f64| {
        let mut follower = solver(&how, Shape::from(design), motion);
        assert!(follower.start(0.0));
        assert_eq!(follower.follow(to).status, Status::Converged, "{design:?}");
        assert!(follower.solution().touching() > 0);
        follower.solution().force_world()
    };
    let motions = [
        (Motion::Rotating { axis: [-14.0, -20.0] }, 6_f64.to_radians()),
        (Motion::Translating { direction: [0.98, 0.2] }, 5.0),
    ];
    for (motion, to) in motions {
        let near = |one: [f64; 2], two: [f64; 2], within: f64| {
            assert!((one[0] - two[0]).abs() < within && (one[1] - two[1]).abs() < within, "{one:?} {two:?}");
        };
        let (centre, radius) = ([31.5, 48.0], 30.0);
        let circle = force(ObjectDesign::Circle { centre, radius }, motion, to);
        near(circle, force(ObjectDesign::Ellipse { centre, semi_axes: [radius; 2], angle: 0.7 }, motion, to), 1e-7);
        let corners = Corners::new(&[centre]).expect("one");
        near(circle, force(ObjectDesign::Polygon { corners, rounding: radius }, motion, to), 1e-7);
        // A wall is a circle of any size: the difference falls as 1/R.
        let (sin, cos) = 0.2_f64.sin_cos();
        let (point, normal) = ([4.0, 70.0], [-cos, -sin]);
        let wall = force(ObjectDesign::HalfPlane { point, normal }, motion, to);
        let round = |r: f64| {
            Shape::<f64>::Circle(Circle { centre: Vec2::new(point[0] + r * cos, point[1] + r * sin), radius: r })
        };
        let mut off = [0.0; 2];
        for (off, r) in off.iter_mut().zip([1e5, 1e6]) {
            let mut follower = solver(&how, round(r), motion);
            assert!(follower.start(0.0) && follower.follow(to).status == Status::Converged);
            let found = follower.solution().force_world();
            *off = (found[0] - wall[0]).hypot(found[1] - wall[1]) / wall[0].hypot(wall[1]);
        }
        assert!(off[0] < 1e-2 && off[1] < 1e-3 && off[1] < 0.2 * off[0] + 1e-6, "{off:?}");
    }
}

/// Derivatives with respect to the motion, the object's place and its outline, against differences, for every shape and
/// both motions. The unknown turn of the normal on a flat face is what a division by its curvature would lose.
#[test]
fn derivatives_agree_with_differences_for_every_shape() {
    let mut random = Random(ChaCha8Rng::seed_from_u64(33));
    let how = Discretisation::reduced(Physics::Extended);
    let mut compared = [0; 4];
    for case in 0..160 {
        let kind = case % 4;
        let design = placed(random.shape(kind), random.between(25.0, 60.0), random.between(0.0, 3.0));
        let motion = random_motion(&mut random);
        let object = Shape::<f64>::from(design);
        let mut follower = solver(&how, object, motion);
        assert!(follower.start(0.0));
        let Some(touch) = first_contact(&object, motion, follower.solution().coordinate()) else { continue };
        let to = touch + 0.6 * indentation(&mut random, motion);
        if follower.follow(to).status != Status::Converged {
            continue;
        }
        let Some(exact) = follower.sensitivity() else { continue };
        let touching: Vec<f64> = follower.solution().contacts().map(|c| c.arc).collect();
        let force = |design: ObjectDesign, to: f64| {
            let mut follower = solver(&how, Shape::from(design), motion);
            assert!(follower.start(0.0));
            let status = follower.follow(to).status;
            let alike = status == Status::Converged
                && follower.solution().contacts().map(|c| c.arc).eq(touching.iter().copied());
            alike.then(|| follower.solution().force_world())
        };
        let differ = |by: &dyn Fn(f64) -> Option<[f64; 2]>, h: f64| -> Option<[f64; 2]> {
            let [a, b, c, d] = [by(h)?, by(-h)?, by(2.0 * h)?, by(-2.0 * h)?];
            Some([0, 1].map(|i| (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h)))
        };
        let h = if matches!(motion, Motion::Rotating { .. }) { 1e-5 } else { 1e-3 };
        let found = [
            (exact.coordinate.force, differ(&|by| force(design, to + by), h)),
            (exact.centre[0].force, differ(&|by| force(moved(design, [by, 0.0]), to), 1e-3)),
            (exact.centre[1].force, differ(&|by| force(moved(design, [0.0, by]), to), 1e-3)),
            (exact.radius.force, differ(&|by| force(grown(design, by)?, to), 1e-3)),
        ];
        let size = |v: [f64; 2]| v[0].hypot(v[1]);
        for (which, (exact, difference)) in found.into_iter().enumerate() {
            let Some(difference) = difference else { continue };
            compared[which] += 1;
            let off = size([exact[0] - difference[0], exact[1] - difference[1]]);
            assert!(
                off < 2e-4 * (size(difference) + 0.1),
                "derivative {which} of {design:?} {motion:?} at {to}: {exact:?}, difference {difference:?}"
            );
        }
    }
    println!("{compared:?} derivatives by the coordinate, x, y and growth");
    assert!(compared.iter().all(|&count| count > 60), "{compared:?}");
}

/// The estimate's distance before contact is that of the nearest point of the finger, for every shape.
#[test]
fn the_distance_before_contact_is_the_shapes() {
    let mut random = Random(ChaCha8Rng::seed_from_u64(34));
    let how = Discretisation::reduced(Physics::Paper);
    for case in 0..200 {
        let distance = random.between(0.5, 30.0);
        let design = placed(random.shape(case % 4), random.between(10.0, 70.0), distance);
        let motion = Motion::Translating { direction: [1.0, 0.0] };
        let mut follower = solver(&how, Shape::from(design), motion);
        assert!(follower.start(0.0));
        assert_eq!(follower.follow(0.0).status, Status::NoContact);
        // The samples are 1.2 mm apart, the first one that far from the base.
        let object = Shape::<f64>::from(design);
        let beyond = (3..=160).map(|k| object.gap(Vec2::new(0.0, 0.5 * f64::from(k))).distance - 1.0);
        let most = beyond.fold(f64::MAX, f64::min) + 0.02 + 0.25 / distance;
        let found = follower.solution().distance();
        assert!(found > distance - 0.01 && found < most, "{design:?}: {found} for {distance} to {most}");
    }
}

/// In single precision and in the microcontroller's size every shape is followed as in double precision.
#[test]
fn single_precision_follows_every_shape() {
    let mut random = Random(ChaCha8Rng::seed_from_u64(35));
    let how = Discretisation::reduced(Physics::Extended);
    let mut small: Box<Follower<f32, Reduced>> = Box::new(Follower::EMPTY);
    let mut compared = 0;
    let mut table: BTreeMap<(&str, &str, &str), usize> = BTreeMap::new();
    for case in 0..200 {
        let design = placed(random.shape(case % 4), random.between(25.0, 65.0), random.between(0.0, 3.0));
        let motion = random_motion(&mut random);
        let object = Shape::<f64>::from(design);
        let mut follower = solver(&how, object, motion);
        small.configure(&ladder_80(), &how).expect("a valid design");
        small.set_object(design, motion);
        assert!(follower.start(0.0) && small.start(0.0));
        let Some(touch) = first_contact(&object, motion, follower.solution().coordinate()) else { continue };
        let to = touch + 0.5 * indentation(&mut random, motion);
        let (double, single) = (follower.follow(to).status, small.follow(to).status);
        *table.entry((WORDS[case % 4], double.word(), single.word())).or_default() += 1;
        if double == Status::Converged && single == Status::Converged {
            compared += 1;
            let (one, two) = (follower.solution().force_world(), small.solution().force_world().map(f64::from));
            let off = (one[0] - two[0]).hypot(one[1] - two[1]);
            assert!(off < 5e-3 * (1.0 + one[0].hypot(one[1])), "{design:?} {motion:?} {to}: {one:?} {two:?}");
        }
    }
    for ((shape, double, single), count) in &table {
        println!("{count:5}  {shape:10}  double {double:12}  single {single}");
    }
    assert!(compared > 150, "{compared}");
}

/// Outlines that are nearly flat, down to a radius of curvature of 81 m, in single precision: between a circle and a wall
/// there is no gap in which the precision is lost.
#[test]
fn nearly_flat_outlines_in_single_precision() {
    let how = Discretisation::reduced(Physics::Extended);
    let motion = Motion::Rotating { axis: [-14.0, -20.0] };
    let mut small: Box<Follower<f32, Reduced>> = Box::new(Follower::EMPTY);
    let mut most = [0; 2];
    for short in [10.0, 20.0, 40.0, 80.0, 160.0] {
        let design = ObjectDesign::Ellipse { centre: [short - 18.0, 0.0], semi_axes: [900.0, short], angle: 1.82 };
        let design = placed(design, 40.0, 0.5);
        let mut follower = solver(&how, Shape::from(design), motion);
        small.configure(&ladder_80(), &how).expect("a valid design");
        small.set_object(design, motion);
        assert!(follower.start(0.0) && small.start(0.0));
        for step in 1..=60 {
            let to = (0.1 * f64::from(step)).to_radians();
            let (double, single) = (follower.follow(to), small.follow(to));
            assert!(double.status.is_trustworthy() && single.status.is_trustworthy(), "{short}: {double:?} {single:?}");
            most = [most[0].max(double.iterations), most[1].max(single.iterations)];
            let (one, two) = (follower.solution().force_world(), small.solution().force_world().map(f64::from));
            let off = (one[0] - two[0]).hypot(one[1] - two[1]);
            assert!(off < 2e-3 * (1.0 + one[0].hypot(one[1])), "{short} at {step}: {one:?} {two:?}");
        }
        assert!(follower.solution().touching() > 0);
    }
    println!("iterations per 0.1°: at most {} in double, {} in single precision", most[0], most[1]);
}
