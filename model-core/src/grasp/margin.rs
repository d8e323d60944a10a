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

/// A place where a finger touches the object; grasp's world, mm and N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Which finger, from 0.
    pub finger: usize,
    /// Where.
    pub point: [f64; 2],
    /// Unit normal into the object: the way in which the finger pushes.
    pub normal: [f64; 2],
    /// Normal force now, which is the most that counts.
    pub force: f64,
    /// Coefficient of friction.
    pub friction: f64,
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

/// Force in the plane, couple over the arm, force across.
type Wrench = [f64; DIMENSIONS];
const DIMENSIONS: usize = 4;

/// Steps after which the search ends. A body of 12 touches with edges needs about 10, one with round cones about 20.
const STEPS: u32 = 64;
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
pub fn margin(touches: impl Iterator<Item = Touch> + Clone, about: [f64; 2], arm: f64, pull: &Pull) -> Margin {
    let all: f64 = touches.clone().map(|touch| touch.force.max(0.0)).sum();
    let against = [-pull.force[0], -pull.force[1], -pull.couple / arm, -pull.across];
    let length = libm::sqrt(dot(&against, &against));
    let is_plain = pull.across == 0.0;
    let dimensions = if is_plain { DIMENSIONS - 1 } else { DIMENSIONS };
    let usable = all > 0.0 && length > 0.0 && arm > 0.0 && (all + length + arm).is_finite();
    if !usable {
        return Margin::NONE;
    }
    // A little beside the direction, so that the ray meets no edge of a portal.
    let mut ray = [0.0; DIMENSIONS];
    for (i, (part, of)) in ray.iter_mut().zip(against).enumerate().take(dimensions) {
        *part = of / length + ASIDE * (i + 1) as f64;
    }
    let mut portal = Portal::new(&ray, dimensions, SEED * all);
    let mut most = f64::INFINITY;
    let mut plane = [0.0; DIMENSIONS];
    for _ in 0..STEPS {
        let Some(normal) = portal.plane() else { break };
        let farthest = touches.clone().fold([0.0; DIMENSIONS], |sum, touch| {
            let lever = Lever::of(&touch, about, arm, is_plain);
            let part = lever.farthest(&touch, &normal);
            [0, 1, 2, 3].map(|i| sum[i] + part[i])
        });
        let beyond = dot(&normal, &farthest).max(1.0);
        if portal.reach() * beyond < most {
            (most, plane) = (portal.reach() * beyond, normal);
        }
        if beyond <= 1.0 + CLOSE || !portal.take(&farthest) {
            break;
        }
    }
    let reach = portal.reach();
    let holds = reach > CLOSE * all;
    let slips = if holds { first_slip(touches, about, arm, is_plain, &plane) } else { None };
    Margin { bears: reach / length, most: most / length, slips }
}

/// The wrenches of a place's directions.
struct Lever {
    normal: Wrench,
    along: Wrench,
    /// 1 where friction has a second way, across the plane.
    across: f64,
}

impl Lever {
    fn of(touch: &Touch, about: [f64; 2], arm: f64, is_plain: bool) -> Self {
        let [x, y] = [touch.point[0] - about[0], touch.point[1] - about[1]];
        let wrench = |[u, v]: [f64; 2]| [u, v, (x * v - y * u) / arm, 0.0];
        let [n, m] = touch.normal;
        Self { normal: wrench([n, m]), along: wrench([-m, n]), across: if is_plain { 0.0 } else { 1.0 } }
    }

    /// How fast the object slides past along the surface in a motion, both ways.
    fn slides(&self, motion: &Wrench) -> [f64; 2] {
        [dot(&self.along, motion), self.across * motion[3]]
    }

    /// The wrench of its cone, up to the present normal force, that is farthest along a direction.
    fn farthest(&self, touch: &Touch, direction: &Wrench) -> Wrench {
        let [along, across] = self.slides(direction);
        let slides = libm::hypot(along, across);
        let gain = dot(&self.normal, direction) + touch.friction * slides;
        if gain <= 0.0 || touch.force <= 0.0 {
            return [0.0; DIMENSIONS];
        }
        let rubs = |part: f64| if slides > 0.0 { touch.friction * part / slides } else { 0.0 };
        let (along, across) = (rubs(along), self.across * rubs(across));
        let mut sum = [0, 1, 2, 3].map(|i| touch.force * (self.normal[i] + along * self.along[i]));
        sum[3] += touch.force * across;
        sum
    }
}

/// The finger that slides fastest in the motion with which the object begins to give way.
fn first_slip(
    touches: impl Iterator<Item = Touch>,
    about: [f64; 2],
    arm: f64,
    is_plain: bool,
    motion: &Wrench,
) -> Option<usize> {
    // Speed and friction of each finger: of those that do not come off.
    let mut fingers = [(0.0_f64, 0.0_f64); MAX_FINGERS];
    for touch in touches {
        let lever = Lever::of(&touch, about, arm, is_plain);
        let [along, across] = lever.slides(motion);
        let speed = libm::hypot(along, across);
        let stays = dot(&lever.normal, motion) + (touch.friction + ALIKE) * speed > 0.0;
        if let Some((fastest, rubs)) = fingers.get_mut(touch.finger).filter(|_| stays) {
            *fastest = fastest.max(speed);
            *rubs += touch.friction * touch.force;
        }
    }
    let fastest = fingers.iter().fold(0.0_f64, |most, finger| most.max(finger.0));
    let slides = |finger: &(usize, &(f64, f64))| finger.1.0 > 0.0 && finger.1.0 >= (1.0 - ALIKE) * fastest;
    let numbered = fingers.iter().enumerate().filter(slides);
    numbered.min_by(|(_, a), (_, b)| a.1.total_cmp(&b.1)).map(|(finger, _)| finger)
}

/// Wrenches, as many as dimensions count, whose cone has the ray in it.
struct Portal {
    corners: [Wrench; DIMENSIONS],
    /// The ray as their sum.
    parts: [f64; DIMENSIONS],
    dimensions: usize,
}

impl Portal {
    /// Of small wrenches along the axes.
    fn new(ray: &Wrench, dimensions: usize, size: f64) -> Self {
        let mut corners = [[0.0; DIMENSIONS]; DIMENSIONS];
        for (i, corner) in corners.iter_mut().enumerate() {
            let one = if ray.get(i).is_some_and(|&part| part < 0.0) { -size } else { size };
            if let Some(part) = corner.get_mut(i) {
                *part = one;
            }
        }
        Self { corners, parts: ray.map(|part| part.abs() / size), dimensions }
    }

    /// How far along the ray it is.
    fn reach(&self) -> f64 {
        1.0 / self.parts.iter().sum::<f64>()
    }

    /// Its plane, as the direction along which every corner is at 1.
    fn plane(&self) -> Option<Wrench> {
        solve(self.corners, [1.0; DIMENSIONS], self.dimensions)
    }

    /// Takes a wrench for the corner that then keeps the ray within. False: the numbers do not serve any more.
    fn take(&mut self, wrench: &Wrench) -> bool {
        let mut columns = [[0.0; DIMENSIONS]; DIMENSIONS];
        for (i, row) in columns.iter_mut().enumerate() {
            *row = self.corners.map(|corner| corner.get(i).copied().unwrap_or_default());
        }
        let Some(made_of) = solve(columns, *wrench, self.dimensions) else { return false };
        let within = self.parts.iter().zip(&made_of).enumerate().take(self.dimensions);
        let ratios = within.filter(|(_, (_, of))| **of > 0.0).map(|(k, (part, of))| (k, part / of));
        let Some((leaving, weight)) = ratios.min_by(|a, b| a.1.total_cmp(&b.1)) else { return false };
        for (part, of) in self.parts.iter_mut().zip(&made_of) {
            *part = (*part - weight * of).max(0.0);
        }
        if let (Some(part), Some(corner)) = (self.parts.get_mut(leaving), self.corners.get_mut(leaving)) {
            (*part, *corner) = (weight, *wrench);
        }
        true
    }
}

fn dot(a: &Wrench, b: &Wrench) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Solves rows · x = right in the first so many dimensions by elimination with pivoting; the others are 0.
fn solve(mut rows: [Wrench; DIMENSIONS], mut right: Wrench, dimensions: usize) -> Option<Wrench> {
    let n = dimensions.min(DIMENSIONS);
    for k in 0..n {
        let size = |i: &usize| rows.get(*i).and_then(|row| row.get(k)).map_or(0.0, |entry| entry.abs());
        let pivot = (k..n).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        rows.swap(k, pivot);
        right.swap(k, pivot);
        let (top, below) = rows.split_at_mut_checked(k + 1)?;
        let (top_right, below_right) = right.split_at_mut_checked(k + 1)?;
        let (row, value) = (top.last()?, *top_right.last()?);
        let diagonal = *row.get(k)?;
        if diagonal == 0.0 || !diagonal.is_finite() {
            return None;
        }
        for (other, of) in below.iter_mut().zip(below_right) {
            let factor = other.get(k)? / diagonal;
            for (entry, above) in other.iter_mut().zip(row).skip(k) {
                *entry -= factor * above;
            }
            *of -= factor * value;
        }
    }
    let mut x = [0.0; DIMENSIONS];
    for k in (0..n).rev() {
        let row = rows.get(k)?;
        let known: f64 = row.iter().zip(&x).skip(k + 1).map(|(entry, of)| entry * of).sum();
        *x.get_mut(k)? = (right.get(k)? - known) / row.get(k)?;
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    const ARM: f64 = 20.0;

    /// From an angle on a cylinder's outline.
    fn at(finger: usize, degrees: f64, force: f64, friction: f64) -> Touch {
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
            let lever = Lever::of(touch, [0.0; 2], ARM, true);
            let edge = |way: f64| {
                [0, 1, 2, 3].map(|i| touch.force * (lever.normal[i] + way * touch.friction * lever.along[i]))
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
                    let lever = Lever::of(touch, [0.0; 2], ARM, false);
                    dot(&lever.farthest(touch, motion), motion)
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
