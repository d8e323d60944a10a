//! Free objects between fingers: symmetry, balance, energy, and the same forces from fingers that are solved anew.

use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::estimator::Estimator;
use model_core::grasp::{Balance, Finger, Grasp, GraspError, Held, Load, Place, Placement};
use model_core::object::{Corners, Motion, ObjectDesign};
use model_core::real::Real;
use model_core::size::{Paper, Reduced, Size};
use model_core::status::Status;
use reference_tests::ladder_80;

const TURNING: Motion = Motion::Rotating { axis: [-14.0, -20.0] };

fn follower<T: Real, S: Size>() -> Box<Follower<T, S>> {
    let mut follower = Box::new(Follower::EMPTY);
    follower.configure(&ladder_80(), &Discretisation::reduced(Physics::Extended)).expect("a valid design");
    follower
}

/// The other finger of a pair, so far to the right.
fn opposite(distance: f64) -> Placement {
    Placement { mirrored: true, angle: 0.0, translation: [distance, 0.0] }
}

/// Closes fingers on an object and lets it go.
fn hold<T: Real, S: Size>(
    placements: &[(Placement, Motion)],
    object: ObjectDesign,
    load: Load,
    coordinates: &[f64],
) -> Balance {
    let mut followers: Vec<Box<Follower<T, S>>> = placements.iter().map(|_| follower()).collect();
    let fingers = followers.iter_mut().zip(placements).map(|(follower, &(placement, motion))| Finger {
        follower,
        placement,
        motion,
    });
    let mut grasp = Grasp::new(fingers.collect(), object, load).expect("a good grasp");
    assert_eq!(grasp.close(coordinates), Ok(Status::Converged), "closing on the object where it is held");
    grasp.release()
}

/// Force on an object and energy of a finger that is closed on it from the beginning.
fn anew(placement: Placement, motion: Motion, object: &ObjectDesign, coordinate: f64) -> ([f64; 2], f64) {
    let mut follower = follower::<f64, Paper>();
    follower.set_object(placement.object_back(object), motion);
    assert!(follower.start(coordinate));
    assert!(follower.follow(coordinate).status.is_trustworthy());
    (placement.vector(follower.solution().force_world()), follower.solution().potential())
}

fn circle(x: f64, y: f64) -> ObjectDesign {
    ObjectDesign::Circle { centre: [x, y], radius: 25.0 }
}

#[test]
fn equal_fingers_hold_a_circle_on_their_axis() {
    let pair = [(Placement::HERE, TURNING), (opposite(56.0), TURNING)];
    let angle = 8_f64.to_radians();
    let balance = hold::<f64, Paper>(&pair, circle(28.9, 44.0), Load::default(), &[angle; 2]);
    println!("{balance:?}");
    assert_eq!(balance.status, Status::Converged);
    assert!((balance.centre[0] - 28.0).abs() < 1e-5, "{balance:?}");
    let [one, two] = [balance.forces[0], balance.forces[1]];
    assert!((one[0] + two[0]).abs() < 1e-5 && (one[1] - two[1]).abs() < 1e-5, "{balance:?}");
    assert!(one[1].abs() < 1e-5 && one[0] > 1.0, "{balance:?}");
    // The squeeze is the force of either.
    assert!((balance.squeeze - one[0]).abs() < 1e-5, "{balance:?}");
}

#[test]
fn unequal_fingers_balance_off_the_axis() {
    let pair = [(Placement::HERE, TURNING), (opposite(56.0), TURNING)];
    let angles = [10_f64.to_radians(), 6_f64.to_radians()];
    for load in [[0.0, 0.0], [0.4, -0.2]] {
        let balance = hold::<f64, Paper>(&pair, circle(28.0, 44.0), Load { force: load, moment: 0.0 }, &angles);
        println!("{balance:?}");
        assert_eq!(balance.status, Status::Converged);
        assert!(balance.centre[0] > 28.5, "{balance:?}");
        for i in 0..2 {
            assert!((balance.net[i] + load[i]).abs() < 1e-5, "{balance:?}");
        }
        // Fingers that are closed on an object fixed there press with the same forces: the way does not matter.
        let object = circle(balance.centre[0], balance.centre[1]);
        let again = [0, 1].map(|k| anew(pair[k].0, pair[k].1, &object, angles[k]));
        for k in 0..2 {
            for i in 0..2 {
                assert!((again[k].0[i] - balance.forces[k][i]).abs() < 1e-6, "{again:?} {balance:?}");
            }
        }
        // The whole energy is stationary and least there, and its second derivative is the stiffness: by differences.
        let energy = |x: f64, y: f64| {
            let object = circle(balance.centre[0] + x, balance.centre[1] + y);
            let elastic: f64 = (0..2).map(|k| anew(pair[k].0, pair[k].1, &object, angles[k]).1).sum();
            elastic - load[0] * x - load[1] * y
        };
        let (h, least) = (0.01, energy(0.0, 0.0));
        let (right, left, up, down) = (energy(h, 0.0), energy(-h, 0.0), energy(0.0, h), energy(0.0, -h));
        for (plus, minus) in [(right, left), (up, down)] {
            assert!((plus - minus).abs() / (2.0 * h) < 1e-4, "slope {}", (plus - minus) / (2.0 * h));
        }
        let [kx, ky] = [(right + left - 2.0 * least) / (h * h), (up + down - 2.0 * least) / (h * h)];
        let cross = (energy(h, h) + energy(-h, -h) - energy(h, -h) - energy(-h, h)) / (4.0 * h * h);
        let k = balance.stiffness;
        for (found, exact) in [(kx, k[0][0]), (ky, k[1][1]), (cross, k[0][1]), (cross, k[1][0])] {
            assert!((found - exact).abs() < 0.02 * k[0][0].abs(), "{found} and {exact}: {k:?}");
        }
        assert!(kx > 0.0 && ky > 0.0 && kx * ky > cross * cross);
    }
}

/// A small load moves the object by the inverse of the stiffness.
#[test]
fn a_load_moves_the_object_by_the_grasps_compliance() {
    let pair = [(Placement::HERE, TURNING), (opposite(56.0), TURNING)];
    let angles = [8_f64.to_radians(); 2];
    let mut followers = [follower::<f64, Paper>(), follower()];
    let [one, two] = &mut followers;
    let fingers =
        [one, two].into_iter().zip(pair).map(|(follower, (placement, motion))| Finger { follower, placement, motion });
    let mut grasp = Grasp::new(fingers.collect(), circle(28.0, 44.0), Load::default()).unwrap();
    assert_eq!(grasp.close(&angles), Ok(Status::Converged));
    let free = grasp.release();
    let push = 1e-3;
    for i in 0..2 {
        let mut force = [0.0; 2];
        force[i] = push;
        grasp.set_load(Load { force, moment: 0.0 }).unwrap();
        let pushed = grasp.release();
        assert_eq!(pushed.status, Status::Converged);
        let moved = [pushed.centre[0] - free.centre[0], pushed.centre[1] - free.centre[1]];
        for j in 0..2 {
            let held = free.stiffness[j][0] * moved[0] + free.stiffness[j][1] * moved[1];
            assert!((held - force[j]).abs() < 0.02 * push, "{held} and {force:?}");
        }
    }
}

#[test]
fn an_ellipse_and_a_bar_turn_until_the_moments_balance() {
    let pair = [(Placement::HERE, TURNING), (opposite(56.0), TURNING)];
    let angles = [8_f64.to_radians(); 2];
    let ellipse = |turn: f64| ObjectDesign::Ellipse { centre: [28.3, 42.0], semi_axes: [25.0, 32.0], angle: turn };
    let corners = |turn: f64| {
        let (sin, cos) = turn.sin_cos();
        let corner = |x: f64, y: f64| [28.3 + cos * x - sin * y, 42.0 + sin * x + cos * y];
        Corners::new(&[corner(-17.0, -10.0), corner(17.0, -10.0), corner(17.0, 10.0), corner(-17.0, 10.0)]).unwrap()
    };
    let block = |turn: f64| ObjectDesign::Polygon { corners: corners(turn), rounding: 8.0 };
    for object in [&ellipse as &dyn Fn(f64) -> ObjectDesign, &block] {
        let balance = hold::<f64, Paper>(&pair, object(0.06), Load::default(), &angles);
        println!("{balance:?}");
        assert_eq!(balance.status, Status::Converged);
        // Symmetric object and fingers: upright in the middle.
        assert!((0.06 + balance.turn).abs() < 1e-5 && (balance.centre[0] - 28.0).abs() < 1e-5, "{balance:?}");
        let k = balance.stiffness;
        assert!(k[2][2] > 0.0);
        for i in 0..3 {
            for j in 0..i {
                assert!((k[i][j] - k[j][i]).abs() < 1e-6 * (k[i][i] * k[j][j]).sqrt(), "symmetric: {k:?}");
            }
        }
        // A moment turns it by the inverse of the stiffness against turning, the shifts free.
        let load = Load { force: [0.0; 2], moment: 0.05 };
        let turned = hold::<f64, Paper>(&pair, object(0.06), load, &angles);
        assert_eq!(turned.status, Status::Converged);
        let moved =
            [turned.centre[0] - balance.centre[0], turned.centre[1] - balance.centre[1], turned.turn - balance.turn];
        let held: Vec<f64> = k.iter().map(|row| (0..3).map(|j| row[j] * moved[j]).sum()).collect();
        assert!((held[2] - 0.05).abs() < 2e-3 && held[0].abs() < 1e-3 && held[1].abs() < 1e-3, "{held:?}");
    }
}

#[test]
fn three_fingers_around_a_circle_and_a_translated_pair() {
    // Three fingers a third of a turn apart, the circle at the height 44 of each.
    let ring = [0.0, 120.0, 240.0_f64].map(|degrees| {
        let placement = Placement { mirrored: false, angle: degrees.to_radians(), translation: [0.0; 2] };
        let [x, y] = placement.vector([28.0, 44.0]);
        (Placement { translation: [-x, -y], ..placement }, TURNING)
    });
    let balance = hold::<f64, Paper>(&ring, circle(0.7, -0.4), Load::default(), &[7_f64.to_radians(); 3]);
    println!("{balance:?}");
    assert_eq!(balance.status, Status::Converged);
    // The same forces turned by a third of a turn, and none left over.
    let size = balance.forces[0][0].hypot(balance.forces[0][1]);
    for k in 0..3 {
        assert!((balance.forces[k][0].hypot(balance.forces[k][1]) - size).abs() < 1e-5, "{balance:?}");
    }
    assert!((balance.squeeze - 1.5 * size).abs() < 1e-4);

    let sliding = Motion::Translating { direction: [1.0, 0.0] };
    let pair = [(Placement::HERE, sliding), (opposite(70.0), sliding)];
    let balance = hold::<f64, Paper>(&pair, circle(34.0, 44.0), Load::default(), &[12.0, 10.0]);
    println!("{balance:?}");
    assert_eq!(balance.status, Status::Converged);
    // Bases at 12 and 60 mm: the middle is at 36.
    assert!((balance.centre[0] - 36.0).abs() < 1e-5, "{balance:?}");
}

#[test]
fn what_is_not_held_is_said_so() {
    let pair = [(Placement::HERE, TURNING), (opposite(90.0), TURNING)];
    let balance = hold::<f64, Paper>(&pair, circle(45.0, 44.0), Load::default(), &[0.0; 2]);
    assert_eq!((balance.status, balance.steps, balance.squeeze), (Status::NoContact, 0, 0.0));
    // Nothing catches it on the way up.
    let up = Load { force: [0.0, 1.0], moment: 0.0 };
    assert_eq!(hold::<f64, Paper>(&pair, circle(45.0, 44.0), up, &[0.0; 2]).status, Status::MaxIterations);
    // One finger alone pushes the object away.
    let balance = hold::<f64, Paper>(&pair[..1], circle(26.5, 44.0), Load::default(), &[0.1]);
    assert!(balance.status != Status::Converged && balance.squeeze < 1e-3, "{balance:?}");
    // With a load towards it, it holds.
    let load = Load { force: [-1.0, 0.0], moment: 0.0 };
    let balance = hold::<f64, Paper>(&pair[..1], circle(26.5, 44.0), load, &[0.1]);
    println!("{balance:?}");
    assert!(balance.status != Status::Converged || (balance.net[0] - 1.0).abs() < 1e-5, "{balance:?}");

    let mut one = follower::<f64, Paper>();
    let mut fingers = heapless::Vec::new();
    let finger = Finger { follower: &mut *one, placement: Placement::HERE, motion: TURNING };
    assert!(fingers.push(finger).is_ok());
    let wall = ObjectDesign::HalfPlane { point: [30.0, 0.0], normal: [-1.0, 0.0] };
    assert_eq!(Grasp::new(fingers, wall, Load::default()).err(), Some(GraspError::Endless));
    let none = heapless::Vec::<Finger<'_, f64, Paper>, 4>::new();
    assert_eq!(Grasp::new(none, circle(1.0, 1.0), Load::default()).err(), Some(GraspError::Fingers { count: 0 }));
}

#[test]
fn single_precision_holds_as_double_does() {
    let pair = [(Placement::HERE, TURNING), (opposite(56.0), TURNING)];
    let angles = [9_f64.to_radians(), 7_f64.to_radians()];
    let double = hold::<f64, Paper>(&pair, circle(28.3, 44.0), Load::default(), &angles);
    let single = hold::<f32, Reduced>(&pair, circle(28.3, 44.0), Load::default(), &angles);
    println!("{double:?}\n{single:?}");
    assert_eq!((double.status, single.status), (Status::Converged, Status::Converged));
    assert!((double.squeeze - single.squeeze).abs() < 1e-2);
    for i in 0..2 {
        assert!((double.centre[i] - single.centre[i]).abs() < 0.05, "{double:?} {single:?}");
    }
}

/// Two estimators, as a gripper's, and where the object is that they hold.
struct Hand {
    fingers: [Box<Estimator<f32, Reduced>>; 2],
    place: Place,
}

impl Hand {
    fn new(objects: [ObjectDesign; 2]) -> Self {
        let finger = |object| {
            let mut finger = Box::new(Estimator::EMPTY);
            let how = Discretisation::reduced(Physics::Extended);
            finger.configure(&ladder_80(), &how).expect("a valid design");
            finger.set_object(object).expect("a valid object");
            finger
        };
        Self { fingers: objects.map(finger), place: Place::default() }
    }

    /// Closes both by counts on the object where it is held.
    fn close(&mut self, angles: [f64; 2]) {
        for tick in 0..=200 {
            self.estimate(angles.map(|angle| f64::from(tick) / 200.0 * angle));
        }
    }

    fn estimate(&mut self, angles: [f64; 2]) {
        for (finger, angle) in self.fingers.iter_mut().zip(angles) {
            let estimate = finger.update(angle);
            assert!(estimate.status.is_trustworthy(), "{estimate:?}");
        }
    }

    /// One tick: estimates, and the balance in so many iterations.
    fn tick(&mut self, angles: [f64; 2], load: Load, iterations: u32) -> Result<Balance, GraspError> {
        self.estimate(angles);
        let held = self.fingers.iter_mut().zip([false, true]).map(|(finger, mirrored)| {
            let object = *finger.object().expect("an object");
            Held { follower: finger.follower_mut(), mirrored, object }
        });
        let mut grasp = Grasp::resume(held, load, self.place)?;
        let balance = grasp.release_within(iterations);
        self.place = grasp.place();
        Ok(balance)
    }
}

/// Each finger sees the object in its own world.
fn seen(object: &ObjectDesign) -> [ObjectDesign; 2] {
    [*object, opposite(56.0).object_back(object)]
}

#[test]
fn balances_taken_up_tick_by_tick_are_the_ones_of_a_grasp_let_go_at_the_end() {
    const COUNT: f64 = std::f64::consts::TAU / 4096.0;
    let pair = [(Placement::HERE, TURNING), (opposite(56.0), TURNING)];
    let ellipse = ObjectDesign::Ellipse { centre: [28.0, 42.0], semi_axes: [25.0, 32.0], angle: 0.03 };
    for (object, load) in [
        (circle(28.3, 44.0), Load::default()),
        (circle(28.3, 44.0), Load { force: [0.3, -0.2], moment: 0.0 }),
        (ellipse, Load { force: [0.0, -0.2], moment: 0.5 }),
    ] {
        let mut hand = Hand::new(seen(&object));
        let start = [9_f64.to_radians(), 7_f64.to_radians()];
        hand.close(start);
        let (mut settling, mut lost, mut most) = (0, 0, 0);
        let mut last = None;
        for tick in 0..60 {
            // It is let go, then pressed further.
            let further = f64::from((tick - 30).max(0)) * COUNT;
            let angles = start.map(|angle| angle + further);
            let balance = hand.tick(angles, load, 16).expect("the same object");
            let good = balance.status.is_trustworthy();
            (settling, lost) = (settling + i32::from(!good && tick < 30), lost + i32::from(!good && tick >= 30));
            most = most.max(balance.iterations);
            assert!(!good || balance.residual <= 3e-4 * (2.0 + 2.0 * balance.squeeze), "{balance:?}");
            last = Some((angles, balance));
        }
        let (angles, single) = last.expect("60 ticks");
        let double = hold::<f64, Paper>(&pair, object, load, &angles);
        println!("let go in {settling} ticks, {most} iterations at most\n{double:?}\n{single:?}");
        assert!(settling < 30 && lost <= 6, "{settling} {lost}");
        assert!(most <= 16 + 2 * 4, "{most}");
        assert_eq!((single.status, double.status), (Status::Converged, Status::Converged));
        for k in 0..2 {
            for i in 0..2 {
                let (one, other) = (single.forces[k][i], double.forces[k][i]);
                assert!((one - other).abs() < 2e-2, "{one} {other}");
            }
        }
        let [x, y] = hand.place.shift;
        let middle = match object {
            ObjectDesign::Circle { centre, .. } | ObjectDesign::Ellipse { centre, .. } => centre,
            _ => unreachable!("one of the two above"),
        };
        assert!((middle[0] + x - double.centre[0]).abs() < 0.02, "{:?}", hand.place);
        assert!((middle[1] + y - double.centre[1]).abs() < 0.05, "{:?}", hand.place);
        assert!((hand.place.turn - double.turn).abs() < 2e-3, "{:?}", hand.place);
        // Each finger's estimate, read anew, is its force on the object there.
        for (k, finger) in hand.fingers.iter_mut().enumerate() {
            let estimate = finger.reread();
            let force = pair[k].0.vector(estimate.force.map(f64::from));
            assert!(estimate.status == Status::Converged && (force[0] - single.forces[k][0]).abs() < 1e-4);
        }
    }
}

#[test]
fn too_small_a_budget_is_said_and_made_up_for() {
    let object = circle(28.3, 44.0);
    let mut hand = Hand::new(seen(&object));
    let angles = |degrees: f64| [degrees.to_radians(); 2];
    hand.close(angles(8.0));
    while hand.tick(angles(8.0), Load::default(), 100).unwrap().status != Status::Converged {}
    // A load, and hardly any time.
    let mut statuses = Vec::new();
    for _ in 0..20 {
        let balance = hand.tick(angles(8.0), Load { force: [0.5, 0.0], moment: 0.0 }, 4).unwrap();
        assert!(balance.iterations <= 4 + 2 * 4, "{balance:?}");
        let (net, load) = (balance.net, [0.5, 0.0]);
        let off = (net[0] + load[0]).hypot(net[1] + load[1]);
        assert!(!balance.status.is_trustworthy() || off < 4e-3, "{balance:?}");
        statuses.push(balance.status);
    }
    println!("{statuses:?}");
    assert_eq!((statuses[0], statuses[19]), (Status::MaxIterations, Status::Converged));
    // Nothing may be spent: nothing is said to be balanced, and nothing moves.
    let before = hand.place;
    let balance = hand.tick(angles(8.0), Load::default(), 0).unwrap();
    assert_eq!((balance.status, hand.place), (Status::MaxIterations, before));
}

#[test]
fn fingers_with_different_objects_hold_none() {
    let mut hand = Hand::new([circle(28.0, 44.0), ObjectDesign::Circle { centre: [28.0, 44.0], radius: 24.0 }]);
    let refused = hand.tick([0.0; 2], Load::default(), 16).err();
    assert_eq!(refused, Some(GraspError::Different { finger: 1 }));
    let push = Load { force: [0.0; 2], moment: 1.0 };
    let mut hand = Hand::new(seen(&circle(28.0, 44.0)));
    assert_eq!(hand.tick([0.0; 2], push, 16).err(), Some(GraspError::Load));
}

/// Where a free object has come to is the same place whether it is moved in the gripper's frame and then seen by a finger, or
/// moved in the finger's own: its points turn about its reference point, in a mirror image the other way.
#[test]
fn a_finger_sees_the_place_of_a_free_object_in_its_own_frame() {
    let place = Place { shift: [1.5, -4.0], turn: 0.3 };
    let corners = Corners::new(&[[20.0, 30.0], [60.0, 35.0], [45.0, 70.0]]).unwrap();
    let triangle = ObjectDesign::Polygon { corners, rounding: 2.0 };
    let ObjectDesign::Polygon { corners: set, .. } = triangle else { panic!("a polygon") };
    let ObjectDesign::Polygon { corners: now, .. } = place.of(&triangle) else { panic!("a polygon") };
    let middle = [0, 1].map(|i| set.iter().map(|corner| corner[i]).sum::<f64>() / 3.0);
    for (set, now) in set.iter().zip(now.iter()) {
        let [x, y] = [set[0] - middle[0], set[1] - middle[1]];
        let (sin, cos) = place.turn.sin_cos();
        let there = [middle[0] + 1.5 + cos * x - sin * y, middle[1] - 4.0 + sin * x + cos * y];
        assert!((now[0] - there[0]).hypot(now[1] - there[1]) < 1e-9, "{now:?} instead of {there:?}");
    }
    let finger = Placement { mirrored: true, angle: 0.0, translation: [56.0, 0.0] };
    let ellipse = ObjectDesign::Ellipse { centre: [28.0, 44.0], semi_axes: [25.0, 18.0], angle: 0.4 };
    let seen = finger.object_back(&place.of(&ellipse));
    let own = place.mirrored().of(&finger.object_back(&ellipse));
    let (ObjectDesign::Ellipse { centre: p, angle: a, .. }, ObjectDesign::Ellipse { centre: q, angle: b, .. }) =
        (seen, own)
    else {
        panic!("ellipses")
    };
    assert!((p[0] - q[0]).hypot(p[1] - q[1]) < 1e-9 && (a - b).abs() < 1e-12, "{seen:?} instead of {own:?}");
}
