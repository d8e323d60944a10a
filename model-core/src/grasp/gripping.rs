//! A free object between fingers with friction: energy, the length of steps, the largest load, precision and budget.

use std::boxed::Box;
use std::vec::Vec;

use super::{Balance, Course, EXCESS, Finger, Grasp, Load, Placement, Pull, margin, touches};
use crate::discretise::{Discretisation, Physics};
use crate::equilibrium::Follower;
use crate::object::{Corners, Motion, ObjectDesign};
use crate::random_designs::Random;
use crate::real::Real;
use crate::size::{Rubbing, Size};
use crate::status::Status;

const TURNING: Motion = Motion::Rotating { axis: [-14.0, -20.0] };
const PAIR: [Placement; 2] = [Placement::HERE, Placement { mirrored: true, angle: 0.0, translation: [56.0, 0.0] }];
const CIRCLE: ObjectDesign = ObjectDesign::Circle { centre: [28.6, 44.0], radius: 25.0 };
const ELLIPSE: ObjectDesign = ObjectDesign::Ellipse { centre: [28.3, 42.0], semi_axes: [25.0, 32.0], angle: 0.06 };
const LOADED: Load = Load { force: [0.0, -0.5], moment: 3.0 };
const FREE: Load = Load { force: [0.0; 2], moment: 0.0 };

/// How two fingers are placed and moved.
type Hand = [(Placement, Motion); 2];
const TURN: Hand = [(PAIR[0], TURNING), (PAIR[1], TURNING)];
const SLIDING: Motion = Motion::Translating { direction: [1.0, 0.0] };
/// Parallel jaws.
const JAWS: Hand = [(PAIR[0], SLIDING), (Placement { translation: [70.0, 0.0], ..PAIR[1] }, SLIDING)];

type Pair<T> = [Box<Follower<T, Rubbing>>; 2];

fn finger<T: Real>(friction: f64) -> Box<Follower<T, Rubbing>> {
    let mut follower = Box::new(Follower::EMPTY);
    let how = Discretisation::reduced(Physics::Extended);
    follower.configure(&crate::design::ladder_80(), &how).expect("a valid design");
    follower.set_friction(friction).expect("in range");
    follower
}

fn pair<T: Real>(friction: f64) -> Pair<T> {
    [finger(friction), finger(friction)]
}

/// Two fingers close on an object that is held, which is then let go.
fn gripped<'a, T: Real>(pair: &'a mut Pair<T>, object: ObjectDesign, load: Load) -> (Grasp<'a, T, Rubbing>, Balance) {
    gripped_at(pair, &TURN, object, load, angles(0.0))
}

fn gripped_at<'a, T: Real>(
    pair: &'a mut Pair<T>,
    hand: &Hand,
    object: ObjectDesign,
    load: Load,
    coordinates: [f64; 2],
) -> (Grasp<'a, T, Rubbing>, Balance) {
    let fingers = pair.iter_mut().zip(hand).map(|(follower, &(placement, motion))| Finger {
        follower: &mut **follower,
        placement,
        motion,
    });
    let mut grasp = Grasp::new(fingers.collect(), object, load).expect("a good grasp");
    assert_eq!(grasp.close(&coordinates), Ok(Status::Converged));
    let balance = grasp.release();
    (grasp, balance)
}

/// Angles of the two fingers, °: at first, and closed.
const BEGIN: [f64; 2] = [6.0, 5.0];
const CLOSED: [f64; 2] = [9.0, 9.5];

fn angles(part: f64) -> [f64; 2] {
    [0, 1].map(|i| (BEGIN[i] + part * (CLOSED[i] - BEGIN[i])).to_radians())
}

/// What a motion has taken and left.
struct Way {
    /// Work of the motors and of the load, and what the fingers store and dissipate more than at first.
    work: f64,
    gained: f64,
    closed: Balance,
    opened: Balance,
    snaps: u32,
    lost: u32,
    iterations: u32,
}

fn stored<T: Real, S: Size>(grasp: &Grasp<'_, T, S>) -> f64 {
    let solutions = grasp.fingers.iter().map(|finger| finger.follower.solution());
    solutions.map(|solution| (solution.potential() + solution.dissipated()).to_f64()).sum()
}

/// Closes further, and opens again as far, in so many steps each.
fn moved<T: Real>(friction: f64, object: ObjectDesign, load: Load, steps: u32) -> Way {
    let mut pair = pair::<T>(friction);
    let (mut grasp, first) = gripped(&mut pair, object, load);
    let torques =
        |grasp: &Grasp<'_, T, Rubbing>| [0, 1].map(|i| grasp.fingers[i].follower.solution().motor_torque().to_f64());
    let place = |grasp: &Grasp<'_, T, Rubbing>| [grasp.centre[0], grasp.centre[1], grasp.turn];
    let before = stored(&grasp);
    let mut motion =
        Way { work: 0.0, gained: 0.0, closed: first.clone(), opened: first, snaps: 0, lost: 0, iterations: 0 };
    let (mut torque, mut at, mut from) = (torques(&grasp), angles(0.0), place(&grasp));
    for k in 1..=2 * steps {
        let to = angles(f64::from(k.min(2 * steps - k)) / f64::from(steps));
        let balance = grasp.advance_within(&to, u32::MAX).expect("as many coordinates as fingers");
        motion.iterations += balance.iterations;
        motion.snaps += u32::from(balance.status == Status::Snapped);
        motion.lost += u32::from(!balance.status.is_trustworthy());
        let (now, there) = (torques(&grasp), place(&grasp));
        let pulls = [load.force[0], load.force[1], load.moment];
        motion.work += (0..2).map(|i| 0.5 * (now[i] + torque[i]) * (to[i] - at[i])).sum::<f64>();
        motion.work += (0..3).map(|i| pulls[i] * (there[i] - from[i])).sum::<f64>();
        (torque, at, from) = (now, to, there);
        let left = [0, 1].map(|i| balance.net[i] + load.force[i]);
        let forces: f64 = balance.forces.iter().map(|&[x, y]| x.hypot(y)).sum();
        let tolerance = if T::EPSILON.to_f64() > 1e-10 { 1.1e-3 } else { 1.1e-4 };
        let balanced = left[0].hypot(left[1]) <= 1.5 * tolerance * (1.0 + forces);
        assert!(!balance.status.is_trustworthy() || balanced, "{balance:?}");
        if k == steps {
            motion.closed = balance;
        } else {
            motion.opened = balance;
        }
    }
    motion.gained = stored(&grasp) - before;
    motion
}

/// Closing and opening take the work that the fingers store and friction dissipates; whether in long or in short steps, the forces are the same.
#[test]
fn what_a_grip_takes_is_stored_or_dissipated() {
    for friction in [0.3, 0.6, 1.0] {
        for (object, load) in [(CIRCLE, FREE), (CIRCLE, LOADED), (ELLIPSE, FREE)] {
            let short = moved::<f64>(friction, object, load, 80);
            assert_eq!((short.lost, short.snaps), (0, 0), "{friction} {object:?}");
            // 29 N·mm go in and come back.
            let off = short.work - short.gained;
            std::println!("{friction}: {} {} in {} iterations", short.work, short.gained, short.iterations);
            assert!(off.abs() < 1e-3 && short.gained > 0.0, "{friction} {object:?}: {off} of {}", short.gained);
            assert!(short.iterations < 20 * 160, "{}", short.iterations);
            let long = moved::<f64>(friction, object, load, 20);
            assert_eq!(long.lost, 0, "{friction} {object:?}");
            for (one, other) in [(&short.closed, &long.closed), (&short.opened, &long.opened)] {
                for k in 0..2 {
                    let off = [0, 1].map(|i| one.forces[k][i] - other.forces[k][i]);
                    assert!(off[0].hypot(off[1]) < 2e-3, "{friction} {object:?}: {one:?} {other:?}");
                }
            }
        }
    }
}

/// With little friction the object slides down between the fingers, at times all at once: never does more come out than went in, and what snaps is
/// flagged. It is never lost for long.
#[test]
fn an_object_that_slides_between_the_fingers_comes_to_rest_again() {
    for friction in [0.05, 0.1, 0.2] {
        for object in [CIRCLE, ELLIPSE] {
            let slid = moved::<f64>(friction, object, FREE, 40);
            std::println!("{friction}: {} {} {} {}", slid.work, slid.gained, slid.snaps, slid.lost);
            assert!(slid.gained < slid.work + 0.02, "{friction}: {} {}", slid.gained, slid.work);
            assert!(slid.snaps > 0 || slid.work - slid.gained < 0.02, "{friction}");
            assert!(
                slid.lost <= 3 && slid.opened.status.is_trustworthy(),
                "{friction}: {} {:?}",
                slid.lost,
                slid.opened
            );
        }
    }
}

/// A block that is held askew goes from one balance to another between two ticks, a third of a millimetre away: what is lost at once is flagged.
#[test]
fn a_step_that_leads_to_another_balance_is_flagged() {
    let corners = [[12.094965, 28.941315], [40.133874, 26.246008], [43.195125, 58.09177], [15.156216, 60.787087]];
    let block = ObjectDesign::Polygon { corners: Corners::new(&corners).expect("four corners"), rounding: 8.0 };
    let load = Load { force: [0.2721, -0.0212], moment: 2.6122 };
    let mut pair = pair::<f64>(0.3832161195750068);
    let angle = |part: f64| [7.9271 + part * 3.5845, 5.2031 + part * 2.5184].map(f64::to_radians);
    let (mut grasp, first) = gripped_at(&mut pair, &TURN, block, load, angle(0.0));
    assert_eq!(first.status, Status::Converged);
    let mut snapped = Vec::new();
    for k in 1..=80 {
        let from = grasp.centre;
        let balance =
            grasp.advance_within(&angle(f64::from(k) / 80.0), u32::MAX).expect("as many coordinates as fingers");
        assert!(balance.status.is_trustworthy(), "{k}: {balance:?}");
        let way = (grasp.centre[0] - from[0]).hypot(grasp.centre[1] - from[1]);
        if balance.status == Status::Snapped {
            snapped.push((k, way));
        } else {
            assert!(way < 0.25, "{k}: {way} mm");
        }
    }
    std::println!("{snapped:?}");
    assert!(snapped.iter().any(|(_, way)| *way > 0.3) && snapped.len() <= 3, "{snapped:?}");
}

/// The load that moves the object is the one that the friction cones bear.
#[test]
fn a_load_is_borne_as_far_as_the_margin_says() {
    for (friction, pull) in [
        (0.3, Pull { force: [0.0, -1.0], ..Pull::default() }),
        (0.5, Pull { force: [0.0, -1.0], ..Pull::default() }),
        (0.4, Pull { couple: 20.0, ..Pull::default() }),
    ] {
        let mut pair = pair::<f64>(friction);
        let (mut grasp, held) = gripped(&mut pair, CIRCLE, FREE);
        assert_eq!(held.status, Status::Converged);
        let about = grasp.centre;
        let place = |grasp: &Grasp<'_, f64, Rubbing>| [grasp.centre[0], grasp.centre[1], grasp.turn];
        let mut places = Vec::new();
        for (number, finger) in grasp.fingers.iter().enumerate() {
            let [x, y] = finger.follower.solution().force_world();
            let mirrored = finger.placement.mirrored;
            let own = finger.placement.point_back(about);
            places.extend(touches(finger.follower, number, mirrored, own, x.hypot(y)));
        }
        let bears = margin(places.iter().copied(), [0.0; 2], 25.0, &pull).bears;
        let from = place(&grasp);
        let moved = |grasp: &Grasp<'_, f64, Rubbing>| {
            let to = place(grasp);
            [to[0] - from[0], to[1] - from[1], 25.0 * (to[2] - from[2])]
                .into_iter()
                .fold(0.0, |most: f64, way| most.max(way.abs()))
        };
        // By steps up to nine tenths of it, and then beyond.
        let mut load_of = |part: f64| {
            let load = part * bears;
            grasp.set_load(Load { force: pull.force.map(|f| load * f), moment: load * pull.couple }).expect("finite");
            let balance = grasp.release();
            (balance.status, moved(&grasp))
        };
        let mut last = (Status::Converged, 0.0);
        for k in 1..=9 {
            last = load_of(0.1 * f64::from(k));
            assert_eq!(last.0, Status::Converged, "{friction} {pull:?}: {k}");
        }
        let beyond = load_of(1.15);
        std::println!("{friction} {pull:?}: bears {bears}, {last:?}, {beyond:?}");
        assert!(last.1 < 0.1, "{last:?}");
        assert!(!beyond.0.is_trustworthy() || beyond.0 == Status::Snapped || beyond.1 > 10.0 * last.1, "{beyond:?}");
    }
}

#[test]
fn single_precision_grips_as_double_does() {
    for (friction, object, load) in [(0.3, CIRCLE, FREE), (0.6, CIRCLE, LOADED), (0.6, ELLIPSE, FREE)] {
        let (single, double) = (moved::<f32>(friction, object, load, 40), moved::<f64>(friction, object, load, 40));
        assert_eq!((single.lost, double.lost), (0, 0));
        for (one, other) in [(&single.closed, &double.closed), (&single.opened, &double.opened)] {
            for k in 0..2 {
                let off = [0, 1].map(|i| one.forces[k][i] - other.forces[k][i]);
                assert!(off[0].hypot(off[1]) < 1e-2, "{friction} {object:?}: {one:?} {other:?}");
            }
        }
    }
}

/// Tick by tick, each with what is left of its time, the object comes to where it comes to at once; a tick without time moves nothing.
#[test]
fn balances_in_bounded_time_are_those_of_a_grip_that_has_all_time() {
    for friction in [0.3, 0.6] {
        let whole = moved::<f32>(friction, CIRCLE, FREE, 80);
        let mut pair = pair::<f32>(friction);
        let (grasp, _) = gripped(&mut pair, CIRCLE, FREE);
        let (mut course, mut late, mut row, mut longest) = (Course::default(), 0, 0, 0);
        let mut grasp = grasp;
        let mut closed = None;
        for k in 1..=160 {
            let to = angles(f64::from(k.min(160 - k)) / 80.0);
            grasp = grasp.with_course(course);
            let balance = grasp.advance_within(&to, 16).expect("as many coordinates as fingers");
            course = grasp.course();
            assert!(balance.iterations <= 16 + EXCESS, "{balance:?}");
            let is_late = !balance.status.is_trustworthy();
            late += u32::from(is_late);
            row = if is_late { row + 1 } else { 0 };
            longest = longest.max(row);
            if k == 80 {
                closed = Some(balance);
            }
        }
        std::println!("{friction}: {late} late, {longest} in a row");
        assert!(late <= 12 && longest <= 5, "{late} {longest}");
        let closed = closed.expect("80 steps");
        for k in 0..2 {
            let off = [0, 1].map(|i| closed.forces[k][i] - whole.closed.forces[k][i]);
            assert!(off[0].hypot(off[1]) < 0.02, "{closed:?} {:?}", whole.closed);
        }
        let before = (grasp.centre, grasp.turn);
        let none = grasp.advance_within(&angles(0.5), 0).expect("as many coordinates as fingers");
        assert_eq!((none.status, grasp.centre, grasp.turn), (Status::MaxIterations, before.0, before.1));
    }
}

/// Few ticks of a closing and opening end without a balance, whatever the coefficient. With some of these 24 the object falls while it is let go.
#[test]
fn few_ticks_end_without_a_balance() {
    let mut late = std::vec::Vec::new();
    for k in 0..24 {
        let mut pair = pair::<f32>(0.26 + 0.02 * f64::from(k));
        let (mut grasp, _) = gripped(&mut pair, CIRCLE, FREE);
        let ticks = (1..=160).filter(|&k: &u32| {
            let to = angles(f64::from(k.min(160 - k)) / 80.0);
            !grasp.advance_within(&to, 16).expect("as many coordinates as fingers").status.is_trustworthy()
        });
        late.push(ticks.count());
    }
    late.sort_unstable();
    std::println!("{late:?}");
    assert!(late.get(12).is_some_and(|&median| median <= 4) && late.iter().sum::<usize>() < 24 * 12, "{late:?}");
}

fn between(random: &mut Random, from: f64, to: f64) -> f64 {
    from + (to - from) * random.unit()
}

/// How random grips are: the fingers, where the object lies on their way (mm), and their coordinates, rad or mm.
struct Grips {
    hand: Hand,
    x: [f64; 2],
    begin: [f64; 2],
    goes: [f64; 2],
    within: [f64; 2],
    /// What a tick moves them by at most, and the servo's resolution.
    tick: f64,
    count: f64,
}

/// Coordinates of two fingers that close and open by turns, in a servo's counts: from where they begin, to a few others and a rest at each.
fn to_and_fro(random: &mut Random, grips: &Grips) -> Vec<[f64; 2]> {
    let Grips { begin, goes, within, tick, count, .. } = *grips;
    let mut at = [0, 1].map(|_| between(random, begin[0], begin[1]));
    let (mut goal, mut coordinates) = (at, std::vec![at]);
    for way in [1.0, -1.0, 1.0, -1.0] {
        goal = goal.map(|goal: f64| (goal + way * between(random, goes[0], goes[1])).clamp(within[0], within[1]));
        while at != goal {
            at = [0, 1].map(|i| at[i] + (goal[i] - at[i]).clamp(-tick, tick));
            coordinates.push(at);
        }
        coordinates.extend([at; 15]);
    }
    coordinates.iter().map(|at| at.map(|coordinate| (coordinate / count).round() * count)).collect()
}

/// Ticks of random grips in single precision with little time.
struct Hurried {
    ticks: u32,
    late: u32,
    /// Those compared with a motion with all time and in double precision, and by how much a force differs from that one's at most, N.
    compared: u32,
    off: f64,
}

fn hurried(grips: &Grips, scenes: u32, iterations: u32) -> Hurried {
    let mut random = Random::new(5);
    let mut found = Hurried { ticks: 0, late: 0, compared: 0, off: 0.0 };
    for _ in 0..scenes {
        let friction = between(&mut random, 0.3, 0.8);
        let centre = [between(&mut random, grips.x[0], grips.x[1]), between(&mut random, 38.0, 50.0)];
        let load = Load {
            force: [between(&mut random, -0.15, 0.15), between(&mut random, -0.3, 0.1)],
            moment: between(&mut random, -2.0, 2.0),
        };
        let way = to_and_fro(&mut random, grips);
        let object = ObjectDesign::Circle { centre, radius: 25.0 };
        let (mut single, mut double) = (pair::<f32>(friction), pair::<f64>(friction));
        let first = way.first().copied().expect("a place");
        let (mut quick, _) = gripped_at(&mut single, &grips.hand, object, load, first);
        let (mut patient, _) = gripped_at(&mut double, &grips.hand, object, load, first);
        let mut fell = false;
        for at in way.iter().skip(1) {
            let balance = quick.advance_within(at, iterations).expect("as many coordinates as fingers");
            let exact = patient.advance_within(at, u32::MAX).expect("as many coordinates as fingers");
            // Which balance an object falls to is a matter of how long it takes.
            fell |= exact.status != Status::Converged || balance.status == Status::Snapped;
            (found.ticks, found.late) = (found.ticks + 1, found.late + u32::from(!balance.status.is_trustworthy()));
            if fell || !balance.status.is_trustworthy() {
                continue;
            }
            found.compared += 1;
            for (one, other) in balance.forces.iter().zip(&exact.forces) {
                found.off = found.off.max((one[0] - other[0]).hypot(one[1] - other[1]));
            }
        }
    }
    let Hurried { ticks, late, compared, off } = found;
    std::println!("{late} of {ticks} late, {compared} compared, {off} N at most");
    found
}

/// Where the fingers turn round, what slipped sticks: few ticks have too little time for that, and those that end in balance are where a motion with
/// all time and in double precision is.
#[test]
fn a_motion_with_little_time_comes_to_the_same_places() {
    let degrees = |[from, to]: [f64; 2]| [from.to_radians(), to.to_radians()];
    let turning = Grips {
        hand: TURN,
        x: [27.4, 28.6],
        begin: degrees([5.5, 8.5]),
        goes: degrees([0.5, 2.5]),
        within: degrees([4.0, 12.0]),
        tick: 0.11_f64.to_radians(),
        count: core::f64::consts::TAU / 4096.0,
    };
    let Hurried { ticks, late, compared, off } = hurried(&turning, 30, 48);
    assert!(late * 300 < ticks && compared * 10 > ticks * 9, "{late} {compared} {ticks}");
    assert!(off < 0.015, "{off} N");
}

/// So it is with parallel jaws that press firmly enough for the object's load.
#[test]
fn jaws_with_little_time_come_to_the_same_places() {
    let jaws = Grips {
        hand: JAWS,
        x: [34.7, 35.7],
        begin: [11.5, 13.5],
        goes: [0.5, 2.5],
        within: [11.0, 17.0],
        tick: 0.1,
        count: 0.05,
    };
    let Hurried { ticks, late, compared, off } = hurried(&jaws, 30, 48);
    assert!(late * 300 < ticks && compared * 10 > ticks * 9, "{late} {compared} {ticks}");
    assert!(off < 0.015, "{off} N");
}

/// Parallel jaws, and three fingers around a cylinder: as they are moved on, one further than the others, work and forces are balanced as well.
#[test]
fn jaws_and_three_fingers_grip_as_two_that_turn_do() {
    let ring = [0.0, 120.0, 240.0_f64].map(|degrees| {
        let placement = Placement { mirrored: false, angle: degrees.to_radians(), translation: [0.0; 2] };
        let [x, y] = placement.vector([28.0, 44.0]);
        (Placement { translation: [-x, -y], ..placement }, TURNING)
    });
    let circle = |x: f64, y: f64| ObjectDesign::Circle { centre: [x, y], radius: 25.0 };
    // Fingers, object, where they begin and how far they go.
    type Case<'a> = (&'a [(Placement, Motion)], ObjectDesign, &'a [f64], f64);
    let cases: [Case<'_>; 2] =
        [(&JAWS, circle(35.3, 44.0), &[9.0, 8.5], 3.0), (&ring, circle(0.3, -0.2), &[0.09; 3], 0.05)];
    for (fingers, object, begin, further) in cases {
        let mut followers: Vec<Box<Follower<f64, Rubbing>>> = (0..fingers.len()).map(|_| finger(0.5)).collect();
        let placed = followers.iter_mut().zip(fingers).map(|(follower, &(placement, motion))| Finger {
            follower: &mut **follower,
            placement,
            motion,
        });
        let mut grasp = Grasp::new(placed.collect(), object, FREE).expect("a good grasp");
        assert_eq!(grasp.close(begin), Ok(Status::Converged));
        let first = grasp.release();
        assert!(first.status.is_trustworthy(), "{first:?}");
        let torques = |grasp: &Grasp<'_, f64, Rubbing>| -> Vec<f64> {
            grasp.fingers.iter().map(|finger| finger.follower.solution().motor_torque()).collect()
        };
        let (before, mut work, mut torque, mut at) = (stored(&grasp), 0.0, torques(&grasp), begin.to_vec());
        for k in 1..=60 {
            // The first goes all the way, the others a half.
            let part = f64::from(k) / 60.0;
            let shares = (0..begin.len()).map(|i| if i == 0 { 1.0 } else { 0.5 });
            let to: Vec<f64> = begin.iter().zip(shares).map(|(begin, share)| begin + share * part * further).collect();
            let balance = grasp.advance_within(&to, u32::MAX).expect("as many coordinates as fingers");
            assert!(balance.status.is_trustworthy(), "{k}: {balance:?}");
            let forces: f64 = balance.forces.iter().map(|&[x, y]| x.hypot(y)).sum();
            assert!(balance.net[0].hypot(balance.net[1]) < 2e-4 * (1.0 + forces), "{balance:?}");
            let now = torques(&grasp);
            work += (0..to.len()).map(|i| 0.5 * (now[i] + torque[i]) * (to[i] - at[i])).sum::<f64>();
            (torque, at) = (now, to);
        }
        let gained = stored(&grasp) - before;
        std::println!("{} fingers: {work} {gained}", fingers.len());
        assert!((work - gained).abs() < 1e-3 * gained, "{work} {gained}");
    }
}

/// Friction holds a cylinder against a couple, which nothing else does; without friction the bases are moved first and the object after them.
#[test]
fn without_friction_a_motion_is_fingers_first_and_then_the_object() {
    let mut pair = pair::<f64>(0.0);
    let (mut grasp, _) = gripped(&mut pair, CIRCLE, FREE);
    assert!(grasp.set_load(LOADED).is_err());
    let moved = grasp.advance_within(&angles(1.0), u32::MAX).expect("as many coordinates as fingers");
    let mut again = self::pair::<f64>(0.0);
    let (mut other, _) = gripped(&mut again, CIRCLE, FREE);
    assert_eq!(other.close(&angles(1.0)), Ok(Status::Converged));
    assert_eq!(other.release(), moved);
    assert!(grasp.advance_within(&[0.1], 10).is_err() && grasp.advance_within(&[f64::NAN; 2], 10).is_err());
}
