//! The grip's margin: the largest load that friction cones bear in a direction, and the finger that slips first.
//!
//! Every place where a finger touches pushes with a normal force μ, and friction adds up to m μ in any direction along the surface. A load is
//! borne if there are forces in these cones, none pressing harder than now, that balance it. All wrenches that the cones can give are a convex
//! body with the origin in it; the largest load is where the load's ray leaves the body.
//!
//! The body is known by its support function: the farthest of its wrenches along any direction is a sum over the places, in closed form.
//! A *portal* of as many wrenches as the space has dimensions is the facet of a simplex through which the ray goes. Each step finds the
//! farthest wrench beyond the portal and puts it in place of the one that keeps the ray inside (the simplex method of Dantzig and Wolfe;
//! in games Minkowski portal refinement). The portal gives a load that is borne, the farthest wrench one that is not.
//!
//! In the plane a wrench has three parts: two forces and a couple. A load across the plane has one more force, and friction is shared between
//! both ways; couples about axes in the plane are left out.

use super::MAX_FINGERS;
use super::portal::{DIMENSIONS, Portal, Wrench, dot};
use crate::real::Real;

/// A place where a finger touches the object; grasp's world, mm and N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch<T = f64> {
    /// Which finger, from 0.
    pub finger: usize,
    /// Where.
    pub point: [T; 2],
    /// Unit normal into the object: the way in which the finger pushes.
    pub normal: [T; 2],
    /// Normal force now, which is the most that counts.
    pub force: T,
    /// Coefficient of friction.
    pub friction: T,
}

/// A load of size 1, by its parts: it acts at the point about which couples are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pull {
    /// Force, N per unit of load.
    pub force: [f64; 2],
    /// Force across the plane, N per unit of load.
    pub across: f64,
    /// Couple, N·mm per unit of load, counter-clockwise.
    pub couple: f64,
}

/// How large a load is borne.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    /// The largest load that was found to be borne, in units of the [`Pull`].
    pub bears: f64,
    /// A larger load than this is not borne. The two differ where the bounded search ended early.
    pub most: f64,
    /// The finger that slips first at that load: the one that slides fastest as the object begins to move; of equal ones the one
    /// with the least friction. `None` where none slides, or where nothing is borne.
    pub slips: Option<usize>,
}

impl Margin {
    /// Nothing is borne.
    pub const NONE: Self = Self { bears: 0.0, most: 0.0, slips: None };
}

/// Passes after which the search ends. A body of 12 touches with edges needs about 10, one with round cones about 20.
const PASSES: u32 = 64;
/// Difference of the two bounds at which it ends, as a part of them.
const CLOSE: f64 = 1e-4;
/// Size of the first portal as a part of all normal forces, and what the ray is turned by, much less: both are errors.
const SEED: f64 = 1e-6;
const ASIDE: f64 = 1e-11;
/// Sliding speeds that differ by less are the same, as a part of the fastest.
const ALIKE: f64 = 1e-3;

/// The largest load along a pull that places of contact bear, with couples about a point. `arm` is a length like the object's radius, mm: it
/// makes couples and forces comparable in the search, and does not change what is found.
///
/// Takes at most 64 passes over the places. A pull of 0 and places without force bear nothing.
///
/// ```
/// use model_core::grasp::{Pull, Touch, margin};
///
/// // Two fingers press a cylinder of 20 mm radius with 5 N from left and right: friction holds 2 · 0.6 · 5 N.
/// let left = Touch { finger: 0, point: [-20.0, 0.0], normal: [1.0, 0.0], force: 5.0, friction: 0.6 };
/// let right = Touch { finger: 1, point: [20.0, 0.0], normal: [-1.0, 0.0], ..left };
/// let weight = Pull { force: [0.0, -1.0], ..Pull::default() };
/// let found = margin([left, right].into_iter(), [0.0, 0.0], 20.0, &weight);
/// assert!((found.bears - 6.0).abs() < 1e-3);
/// ```
pub fn margin<T: Real>(
    touches: impl Iterator<Item = Touch<T>> + Clone,
    about: [T; 2],
    arm: f64,
    pull: &Pull,
) -> Margin {
    let cones = touches.map(|touch| Cone::of(&touch, about, T::of(arm)));
    let Some(mut search) = Search::new(force_of(cones.clone()), arm, pull) else { return Margin::NONE };
    while search.step(cones.clone()) {}
    search.found(cones)
}

/// All normal forces together.
pub(super) fn force_of<T: Real>(cones: impl Iterator<Item = Cone<T>>) -> f64 {
    cones.map(|cone| cone.force.to_f64()).sum()
}

/// The search for one margin, pass by pass.
#[derive(Clone, Debug)]
pub(super) struct Search {
    portal: Portal,
    /// The least bound so far, and the motion that shows it.
    most: f64,
    motion: Wrench,
    /// Size of a load of 1, and all normal forces.
    length: f64,
    all: f64,
    is_plain: bool,
    passes: u32,
}

impl Search {
    /// None where nothing can be borne: without a pull or a force.
    pub(super) fn new(all: f64, arm: f64, pull: &Pull) -> Option<Self> {
        let against = [-pull.force[0], -pull.force[1], -pull.couple / arm, -pull.across];
        let length = libm::sqrt(dot(&against, &against));
        let is_plain = pull.across == 0.0;
        let dimensions = if is_plain { DIMENSIONS - 1 } else { DIMENSIONS };
        let usable = all > 0.0 && length > 0.0 && arm > 0.0 && (all + length + arm).is_finite();
        if !usable {
            return None;
        }
        // A little beside the direction, so that the ray meets no edge of a portal.
        let mut ray = [0.0; DIMENSIONS];
        for (i, (part, of)) in ray.iter_mut().zip(against).enumerate().take(dimensions) {
            *part = of / length + ASIDE * (i + 1) as f64;
        }
        let portal = Portal::new(&ray, dimensions, SEED * all);
        Some(Self { portal, most: f64::INFINITY, motion: [0.0; DIMENSIONS], length, all, is_plain, passes: 0 })
    }

    /// One pass over the places; false once there is nothing left to find.
    pub(super) fn step<T: Real>(&mut self, cones: impl Iterator<Item = Cone<T>>) -> bool {
        self.passes += 1;
        let Some(normal) = self.portal.plane() else { return false };
        // Of length 1: in single precision the parts of a small portal's plane are too large.
        let size = libm::sqrt(dot(&normal, &normal));
        let direction = normal.map(|part| T::of(part / size));
        let farthest = cones.fold([T::ZERO; DIMENSIONS], |mut sum, cone| {
            for (of, part) in sum.iter_mut().zip(cone.farthest(&direction, self.is_plain)) {
                *of += part;
            }
            sum
        });
        let farthest = farthest.map(Real::to_f64);
        let beyond = dot(&normal, &farthest).max(1.0);
        let most = self.portal.reach() * beyond;
        if most < self.most {
            (self.most, self.motion) = (most, normal);
        }
        beyond > 1.0 + CLOSE && self.portal.take(&farthest) && self.passes < PASSES
    }

    /// What was found.
    pub(super) fn found<T: Real>(&self, cones: impl Iterator<Item = Cone<T>>) -> Margin {
        let reach = self.portal.reach();
        let holds = reach > CLOSE * self.all;
        let slips = if holds { first_slip(cones, self.is_plain, &self.motion) } else { None };
        Margin { bears: reach / self.length, most: self.most / self.length, slips }
    }
}

/// A place's friction cone, by the wrenches of its directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone<T> {
    finger: u8,
    /// Two forces, and the couple over the arm.
    normal: [T; 3],
    along: [T; 3],
    pub(super) force: T,
    friction: T,
}

impl<T: Real> Cone<T> {
    pub(super) fn of(touch: &Touch<T>, about: [T; 2], arm: T) -> Self {
        let [x, y] = [touch.point[0] - about[0], touch.point[1] - about[1]];
        let wrench = |[u, v]: [T; 2]| [u, v, (x * v - y * u) / arm];
        let [n, m] = touch.normal;
        let force = touch.force.max(T::ZERO);
        Self {
            finger: touch.finger as u8,
            normal: wrench([n, m]),
            along: wrench([-m, n]),
            force,
            friction: touch.friction,
        }
    }

    /// How fast the object slides past along the surface in a motion, both ways.
    fn slides(&self, motion: &[T; DIMENSIONS], is_plain: bool) -> [T; 2] {
        [with(&self.along, motion), if is_plain { T::ZERO } else { motion[3] }]
    }

    /// The wrench of the cone, up to the present normal force, that is farthest along a direction of length 1.
    fn farthest(&self, direction: &[T; DIMENSIONS], is_plain: bool) -> [T; DIMENSIONS] {
        let [along, across] = self.slides(direction, is_plain);
        let slides = (along * along + across * across).sqrt();
        if with(&self.normal, direction) + self.friction * slides <= T::ZERO {
            return [T::ZERO; DIMENSIONS];
        }
        let rubs = if slides > T::ZERO { self.friction / slides } else { T::ZERO };
        let (along, across) = (rubs * along, rubs * across);
        let [x, y, couple] = [0, 1, 2].map(|i| self.force * (self.normal[i] + along * self.along[i]));
        [x, y, couple, self.force * across]
    }
}

/// The part of a wrench in the plane along a motion.
fn with<T: Real>(wrench: &[T; 3], motion: &[T; DIMENSIONS]) -> T {
    wrench[0] * motion[0] + wrench[1] * motion[1] + wrench[2] * motion[2]
}

/// The finger that slides fastest in the motion with which the object begins to give way.
fn first_slip<T: Real>(cones: impl Iterator<Item = Cone<T>>, is_plain: bool, motion: &Wrench) -> Option<usize> {
    let size = libm::sqrt(dot(motion, motion));
    let motion = motion.map(|part| T::of(part / size));
    // Speed and friction of each finger: of those that do not come off.
    let mut fingers = [(T::ZERO, T::ZERO); MAX_FINGERS];
    for cone in cones {
        let [along, across] = cone.slides(&motion, is_plain);
        let speed = (along * along + across * across).sqrt();
        let stays = with(&cone.normal, &motion) + (cone.friction + T::of(ALIKE)) * speed > T::ZERO;
        if let Some((fastest, rubs)) = fingers.get_mut(usize::from(cone.finger)).filter(|_| stays) {
            *fastest = fastest.max(speed);
            *rubs += cone.friction * cone.force;
        }
    }
    let fingers = fingers.map(|(speed, rubs)| (speed.to_f64(), rubs.to_f64()));
    let fastest = fingers.iter().fold(0.0_f64, |most, finger| most.max(finger.0));
    let slides = |finger: &(usize, &(f64, f64))| finger.1.0 > 0.0 && finger.1.0 >= (1.0 - ALIKE) * fastest;
    let numbered = fingers.iter().enumerate().filter(slides);
    numbered.min_by(|(_, a), (_, b)| a.1.total_cmp(&b.1)).map(|(finger, _)| finger)
}

#[cfg(test)]
pub(super) mod tests {
    use std::vec::Vec;

    use super::*;

    /// The arm of couples, and radius of the cylinder, mm.
    pub(in crate::grasp) const ARM: f64 = 20.0;

    /// A place at an angle on a cylinder's outline.
    pub(in crate::grasp) fn at(finger: usize, degrees: f64, force: f64, friction: f64) -> Touch {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        Touch { finger, point: [ARM * cos, ARM * sin], normal: [-cos, -sin], force, friction }
    }

    fn found(touches: &[Touch], pull: &Pull) -> Margin {
        margin(touches.iter().copied(), [0.0; 2], ARM, pull)
    }

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() <= 2e-4 * expected.abs().max(1.0), "{found} instead of {expected}");
    }

    const DOWN: Pull = Pull { force: [0.0, -1.0], across: 0.0, couple: 0.0 };

    #[test]
    fn two_opposed_fingers_bear_what_the_closed_forms_say() {
        let pair = [at(0, 180.0, 5.0, 0.6), at(1, 0.0, 5.0, 0.6)];
        near(found(&pair, &DOWN).bears, 6.0);
        // Along the squeeze one of them comes off.
        near(found(&pair, &Pull { force: [1.0, 0.0], ..Pull::default() }).bears, 5.0);
        near(found(&pair, &Pull { couple: 1.0, ..Pull::default() }).bears, 2.0 * 0.6 * 5.0 * ARM);
        near(found(&pair, &Pull { across: 1.0, ..Pull::default() }).bears, 6.0);
        // Friction is shared by both ways.
        near(found(&pair, &Pull { force: [0.0, 3.0], across: 4.0, couple: 0.0 }).bears, 6.0 / 5.0);
        // A load beside the middle: what one finger has less, both have.
        let beside = Pull { couple: 0.5 * ARM, ..DOWN };
        near(found(&pair, &beside).bears, 3.0 / 0.75);
    }

    #[test]
    fn nothing_is_borne_without_friction_across_the_normals_and_by_one_finger() {
        let smooth = [at(0, 180.0, 5.0, 0.0), at(1, 0.0, 5.0, 0.0)];
        assert!(found(&smooth, &DOWN).bears < 1e-4);
        assert_eq!(found(&smooth, &DOWN).slips, None);
        near(found(&smooth, &Pull { force: [1.0, 0.0], ..Pull::default() }).bears, 5.0);
        let one = [at(0, 180.0, 5.0, 0.6)];
        assert!(found(&one, &DOWN).bears < 1e-4);
        assert_eq!(found(&[], &DOWN), Margin::NONE);
        assert_eq!(found(&smooth, &Pull::default()), Margin::NONE);
        assert_eq!(found(&[at(0, 0.0, f64::NAN, 0.6)], &DOWN), Margin::NONE);
    }

    #[test]
    fn the_finger_with_less_friction_slips_first_and_one_about_which_the_object_turns_does_not() {
        let pair = |left, right| [at(0, 180.0, 5.0, left), at(1, 0.0, 5.0, right)];
        assert_eq!(found(&pair(0.6, 0.3), &DOWN).slips, Some(1));
        assert_eq!(found(&pair(0.3, 0.6), &DOWN).slips, Some(0));
        // All of the weight at the left finger: the object turns about the right one.
        let left = Pull { couple: 0.98 * ARM, ..DOWN };
        assert_eq!(found(&pair(0.5, 0.5), &left).slips, Some(0));
        assert_eq!(found(&pair(0.5, 0.5), &Pull { couple: -0.98 * ARM, ..DOWN }).slips, Some(1));
    }

    /// A stream of numbers from 0 to 1.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn between(&mut self, low: f64, high: f64) -> f64 {
            low + (high - low) * self.next()
        }
    }

    fn random(numbers: &mut Numbers, count: usize) -> Vec<Touch> {
        let mut touch = |i| Touch {
            finger: i % 4,
            force: numbers.between(0.5, 8.0),
            friction: numbers.between(0.1, 1.0),
            ..at(i % 4, 360.0 * i as f64 / count as f64 + numbers.between(-40.0, 40.0), 1.0, 0.5)
        };
        (0..count).map(&mut touch).collect()
    }

    /// Every wrench that corners of the cones sum up to; the ray leaves their hull through the farthest of all triangles of them.
    fn by_search(touches: &[Touch], pull: &Pull) -> f64 {
        let mut sums = std::vec![[0.0; DIMENSIONS]];
        for touch in touches {
            let cone = Cone::of(touch, [0.0; 2], ARM);
            let edge = |way: f64| {
                let [x, y, couple] =
                    [0, 1, 2].map(|i| touch.force * (cone.normal[i] + way * touch.friction * cone.along[i]));
                [x, y, couple, 0.0]
            };
            let corners = [[0.0; DIMENSIONS], edge(1.0), edge(-1.0)];
            sums = sums.iter().flat_map(|sum| corners.map(|corner| [0, 1, 2, 3].map(|i| sum[i] + corner[i]))).collect();
        }
        let ray = [-pull.force[0], -pull.force[1], -pull.couple / ARM];
        let mut farthest = 0.0_f64;
        for (i, a) in sums.iter().enumerate() {
            for (j, b) in sums.iter().enumerate().skip(i + 1) {
                for c in sums.iter().skip(j + 1) {
                    let cross = |u: &Wrench, v: &Wrench| {
                        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
                    };
                    let with = |u: [f64; 3], v: &[f64]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
                    let volume = with(cross(a, b), c);
                    if volume.abs() < 1e-9 {
                        continue;
                    }
                    let parts = [with(cross(b, c), &ray), with(cross(c, a), &ray), with(cross(a, b), &ray)];
                    if parts.iter().all(|part| part / volume >= -1e-12) {
                        farthest = farthest.max(volume / parts.iter().sum::<f64>());
                    }
                }
            }
        }
        farthest
    }

    #[test]
    fn random_grips_bear_what_a_search_of_all_facets_finds() {
        let mut numbers = Numbers(7);
        for round in 0..40 {
            let touches = random(&mut numbers, 2 + round % 3);
            let (sin, cos) = libm::sincos(numbers.between(0.0, 6.3));
            let pull = Pull { force: [cos, sin], across: 0.0, couple: numbers.between(-15.0, 15.0) };
            let (margin, expected) = (found(&touches, &pull), by_search(&touches, &pull));
            assert!((margin.bears - expected).abs() <= 1e-3 * expected + 1e-4, "{round}: {margin:?}, {expected}");
            assert!(margin.most >= expected * (1.0 - 1e-4) && margin.bears <= margin.most * (1.0 + 1e-9), "{margin:?}");
        }
    }

    /// With friction shared between both ways the cones are round: no direction of motion shows a lower bound than the one found.
    #[test]
    fn random_grips_across_the_plane_meet_the_least_bound_of_many_motions() {
        let mut numbers = Numbers(11);
        for round in 0..40 {
            let touches = random(&mut numbers, 2 + round % 11);
            let (sin, cos) = libm::sincos(numbers.between(0.0, 6.3));
            let across = numbers.between(0.2, 1.0);
            let pull = Pull { force: [0.6 * cos, 0.6 * sin], across, couple: numbers.between(-5.0, 5.0) };
            let margin = found(&touches, &pull);
            assert!(margin.bears >= 0.999 * margin.most, "{round}: {margin:?}");
            let ray = [-pull.force[0], -pull.force[1], -pull.couple / ARM, -pull.across];
            let bound = |motion: &Wrench| {
                let all = touches.iter().map(|touch| {
                    let cone = Cone::of(touch, [0.0; 2], ARM);
                    dot(&cone.farthest(motion, false), motion)
                });
                all.sum::<f64>() / dot(motion, &ray)
            };
            // Downhill from the ray's own direction, by random steps that shrink.
            let (mut best, mut least) = (ray, bound(&ray));
            for step in 0..4000 {
                let size = libm::pow(0.998, f64::from(step));
                let mut there = best.map(|part| part + size * numbers.between(-1.0, 1.0));
                let length = libm::sqrt(dot(&there, &there));
                there = there.map(|part| part / length);
                let value = bound(&there);
                if dot(&there, &ray) > 0.0 && value < least {
                    (best, least) = (there, value);
                }
            }
            assert!(margin.bears <= least * (1.0 + 1e-6) + 1e-4, "{round}: {margin:?}, {least}");
            assert!(least <= margin.most * 1.02 + 1e-4, "{round}: {margin:?}, {least}");
        }
    }
}
