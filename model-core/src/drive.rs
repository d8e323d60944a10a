//! What the motor's angle is as a motion of the finger's base: a turn about the motor axis, or a way along a line.
//!
//! Parallel jaws turn the angle α into a distance x(α): in proportion (rack and pinion, belt, screw), or by a table (crank linkages).
//! Between its knots a table is a monotone cubic (Fritsch and Carlson, SIAM J. Numer. Anal. 17, 1980, 238–246), whose
//! derivative is continuous: x′(α) enters the torque, τ = F·x′, and the slope dF/dα = dF/dx·x′ of every estimate.

use core::ops::Deref;

use crate::object::Motion;

/// Most knots of a [`Knots`].
pub const MAX_DRIVE_KNOTS: usize = 6;

/// How the motor moves the base.
// With a tag of its own, so that the first variant is all zeros: an estimator in a static then needs no image in flash.
#[repr(u8)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum Drive {
    /// It turns the base about the design's motor axis.
    #[default]
    Rotating,
    /// It moves the base along a line.
    Translating {
        /// Direction of the base's motion for a growing angle, world frame; any length but zero.
        direction: [f32; 2],
        /// How far.
        travel: Travel,
    },
}

/// Distance of the base over the motor angle; it grows with the angle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum Travel {
    /// In proportion, 0 at angle 0.
    Linear {
        /// mm per rad of the motor angle, 1e-3 to 1e4.
        mm_per_rad: f32,
    },
    /// By a table; beyond its ends every estimate is `out-of-range`.
    Table(Knots),
}

/// Pairs of motor angle (rad) and distance (mm), both growing.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "KnotList", into = "KnotList"))]
pub struct Knots {
    at: [[f32; 2]; MAX_DRIVE_KNOTS],
    count: u8,
}

/// Knots as messages carry them.
type KnotList = heapless::Vec<[f32; 2], MAX_DRIVE_KNOTS>;

impl Knots {
    /// Pairs in order; none if there are more than [`MAX_DRIVE_KNOTS`].
    pub fn new(knots: &[[f32; 2]]) -> Option<Self> {
        KnotList::from_slice(knots).ok().map(Self::from)
    }

    /// Distance and its derivative at an angle; none outside the table.
    fn at(&self, angle: f64) -> Option<[f64; 2]> {
        let knots = |k: usize| self.get(k).map(|knot| knot.map(f64::from));
        // The piece that ends at or above the angle.
        let above = self.iter().position(|knot| f64::from(knot[0]) >= angle)?.max(1);
        let ([a, x], [b, y]) = (knots(above - 1)?, knots(above)?);
        if angle < a {
            return None;
        }
        let (width, chord) = (b - a, (y - x) / (b - a));
        let before = above.checked_sub(2).and_then(knots).map(|[c, z]| [a - c, (x - z) / (a - c)]);
        let behind = knots(above + 1).map(|[c, z]| [c - b, (z - y) / (c - b)]);
        let here = [width, chord];
        let start = if before.is_some() { slope(before, here) } else { end_slope(behind, here) };
        let end = if behind.is_some() { slope(behind, here) } else { end_slope(before, here) };
        let t = (angle - a) / width;
        let (bend, twist) = (3.0 * chord - 2.0 * start - end, start + end - 2.0 * chord);
        let distance = x + width * t * (start + t * (bend + t * twist));
        // Rounding must not turn it back where it stands.
        Some([distance, (start + t * (2.0 * bend + 3.0 * t * twist)).max(0.0)])
    }
}

/// Derivative at the knot where a piece, given by its width and its chord's slope, meets the one beside it: that of the parabola through
/// the three knots, limited to what keeps the cubic monotone. A table of two knots is a line.
fn slope(beside: Option<[f64; 2]>, [width, chord]: [f64; 2]) -> f64 {
    let Some([other_width, other]) = beside else { return chord };
    let parabola = (other_width * chord + width * other) / (width + other_width);
    parabola.min(3.0 * chord.min(other))
}

/// The same at a table's end.
fn end_slope(beside: Option<[f64; 2]>, [width, chord]: [f64; 2]) -> f64 {
    let Some([other_width, other]) = beside else { return chord };
    let parabola = chord + (chord - other) * width / (width + other_width);
    parabola.max(0.0).min(3.0 * chord)
}

impl Deref for Knots {
    type Target = [[f32; 2]];
    fn deref(&self) -> &Self::Target {
        self.at.get(..usize::from(self.count)).unwrap_or(&self.at)
    }
}

impl core::fmt::Debug for Knots {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        (**self).fmt(f)
    }
}

impl PartialEq for Knots {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl From<KnotList> for Knots {
    fn from(list: KnotList) -> Self {
        let mut at = [[0.0; 2]; MAX_DRIVE_KNOTS];
        for (to, from) in at.iter_mut().zip(&list) {
            *to = *from;
        }
        Self { at, count: list.len() as u8 }
    }
}

impl From<Knots> for KnotList {
    fn from(knots: Knots) -> Self {
        let mut list = Self::new();
        for knot in knots.iter() {
            // As much room as there are knots.
            let _ = list.push(*knot);
        }
        list
    }
}

#[cfg(feature = "schema")]
impl postcard_schema::Schema for Knots {
    const SCHEMA: &'static postcard_schema::schema::NamedType = <KnotList as postcard_schema::Schema>::SCHEMA;
}

/// Why a [`Drive`] is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriveError {
    /// A value is outside its range.
    Value {
        /// Its name.
        name: &'static str,
        /// The value.
        value: f32,
        /// Least and greatest allowed.
        allowed: [f32; 2],
    },
    /// Fewer than two knots.
    Few {
        /// How many.
        count: usize,
    },
    /// A knot's angle or distance does not grow enough.
    Order {
        /// Which knot, from 0.
        knot: usize,
        /// `angle` or `distance`.
        name: &'static str,
        /// By how much it grows from the knot before, rad or mm.
        step: f32,
        /// The least allowed.
        least: f32,
    },
}

impl core::fmt::Display for DriveError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Value { name, value, allowed: [least, most] } => {
                write!(f, "{name} is {value}; allowed is {least} to {most}")
            }
            Self::Few { count } => write!(f, "the table has {count} knots; allowed is 2 to {MAX_DRIVE_KNOTS}"),
            Self::Order { knot, name, step, least } => {
                write!(f, "knot {knot}: {name} grows by {step}; allowed is {least} or more (rad, mm)")
            }
        }
    }
}

impl core::error::Error for DriveError {}

/// Lengths of a direction, before it is scaled to 1.
const LENGTHS: [f32; 2] = [1e-3, 1e3];
/// Distances per angle, mm/rad.
const PACES: [f32; 2] = [1e-3, 1e4];
/// Least difference of two knots' angles, rad, and distances, mm.
const APART: [f32; 2] = [1e-3, 1e-3];
/// Largest angle, rad, and distance, mm, of a knot.
const FARTHEST: [f32; 2] = [1e3, 1e3];

impl Drive {
    /// Parallel jaws whose distance is in proportion to the motor angle.
    pub const fn linear(direction: [f32; 2], mm_per_rad: f32) -> Self {
        Self::Translating { direction, travel: Travel::Linear { mm_per_rad } }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first that is not allowed.
    pub fn validate(&self) -> Result<(), DriveError> {
        let check = |name, value: f32, allowed: [f32; 2]| {
            let fine = (allowed[0]..=allowed[1]).contains(&value);
            fine.then_some(()).ok_or(DriveError::Value { name, value, allowed })
        };
        let Self::Translating { direction: [x, y], travel } = self else { return Ok(()) };
        check("length of the direction", libm::hypotf(*x, *y), LENGTHS)?;
        let knots = match travel {
            Travel::Linear { mm_per_rad } => return check("mm_per_rad", *mm_per_rad, PACES),
            Travel::Table(knots) => knots,
        };
        if knots.len() < 2 {
            return Err(DriveError::Few { count: knots.len() });
        }
        let mut before = None;
        for (knot, &[angle, distance]) in knots.iter().enumerate() {
            check("angle of a knot", angle, [-FARTHEST[0], FARTHEST[0]])?;
            check("distance of a knot", distance, [-FARTHEST[1], FARTHEST[1]])?;
            if let Some([a, d]) = before.replace([angle, distance]) {
                for (name, step, least) in [("angle", angle - a, APART[0]), ("distance", distance - d, APART[1])] {
                    if step < least {
                        return Err(DriveError::Order { knot, name, step, least });
                    }
                }
            }
        }
        Ok(())
    }

    /// The base's motion; `axis` is the design's motor axis.
    pub fn motion(&self, axis: [f64; 2]) -> Motion {
        match *self {
            Self::Rotating => Motion::Rotating { axis },
            Self::Translating { direction, .. } => {
                let [x, y] = direction.map(f64::from);
                let length = libm::hypot(x, y);
                Motion::Translating { direction: [x / length, y / length] }
            }
        }
    }

    /// The motion's coordinate (rad or mm) at a motor angle (rad), and its derivative; none outside a table.
    pub fn coordinate(&self, angle: f64) -> Option<[f64; 2]> {
        match self {
            Self::Rotating => Some([angle, 1.0]),
            Self::Translating { travel: Travel::Linear { mm_per_rad }, .. } => {
                let ratio = f64::from(*mm_per_rad);
                Some([ratio * angle, ratio])
            }
            Self::Translating { travel: Travel::Table(knots), .. } => knots.at(angle),
        }
    }

    /// Motor angles that it is defined for, rad.
    pub fn range(&self) -> [f32; 2] {
        match self {
            Self::Translating { travel: Travel::Table(knots), .. } => {
                [knots.first(), knots.last()].map(|knot| knot.map_or(0.0, |knot| knot[0]))
            }
            _ => [f32::NEG_INFINITY, f32::INFINITY],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A crank of 20 mm: x = r sin α, from −50° to 50°.
    fn crank(count: usize) -> Drive {
        let knot = |k: usize| {
            let angle = (-50.0 + 100.0 * k as f64 / (count - 1) as f64).to_radians();
            [angle as f32, (20.0 * angle.sin()) as f32]
        };
        let knots: std::vec::Vec<_> = (0..count).map(knot).collect();
        Drive::Translating { direction: [1.0, 0.0], travel: Travel::Table(Knots::new(&knots).expect("as many")) }
    }

    #[test]
    fn a_table_follows_its_crank() {
        let drive = crank(6);
        assert_eq!(drive.validate(), Ok(()));
        let (mut off, mut off_slope) = (0.0_f64, 0.0_f64);
        for step in 0..=1000 {
            let angle = (-49.99 + 0.09998 * f64::from(step)).to_radians();
            let [distance, slope] = drive.coordinate(angle).expect("within the table");
            off = off.max((distance - 20.0 * angle.sin()).abs());
            off_slope = off_slope.max((slope / (20.0 * angle.cos()) - 1.0).abs());
            // The slope is the distance's derivative.
            let h = 1e-6;
            let [more, less] = [h, -h].map(|h| drive.coordinate(angle + h).map_or(f64::NAN, |[x, _]| x));
            assert!(((more - less) / (2.0 * h) - slope).abs() < 1e-4 || more.is_nan() || less.is_nan());
        }
        assert!(off < 0.05 && off_slope < 0.055, "{off} mm, {off_slope} of the slope");
    }

    /// Monotone, whatever the table.
    #[test]
    fn a_table_never_turns_back_and_meets_its_knots() {
        let mut random = crate::random_designs::Random::new(4);
        for _ in 0..300 {
            let count = 2 + (5.0 * random.unit()) as usize;
            let (mut angle, mut distance) = (-1.0, -10.0);
            let mut knots = std::vec::Vec::new();
            for _ in 0..count {
                knots.push([angle, distance]);
                angle += 0.01 + 0.5 * random.unit() as f32;
                distance += 0.01 + 20.0 * (random.unit() as f32).powi(4);
            }
            let knots = Knots::new(&knots).expect("no more than there is room");
            let drive = Drive::Translating { direction: [0.0, 2.0], travel: Travel::Table(knots) };
            assert_eq!(drive.validate(), Ok(()));
            for &[angle, distance] in knots.iter() {
                let [found, _] = drive.coordinate(f64::from(angle)).expect("on a knot");
                assert!((found - f64::from(distance)).abs() < 1e-9, "{knots:?}");
            }
            let [first, last] = drive.range().map(f64::from);
            let mut before = f64::NEG_INFINITY;
            for step in 0..=200 {
                let angle = (first + (last - first) * f64::from(step) / 200.0).min(last);
                let [found, slope] = drive.coordinate(angle).expect("within the table");
                assert!(found > before && slope >= 0.0, "{knots:?} at {angle}: {found} after {before}, slope {slope}");
                before = found;
            }
            for outside in [first - 1e-6, last + 1e-6, f64::NAN] {
                assert_eq!(drive.coordinate(outside), None);
            }
        }
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        let said = |drive: Drive| std::string::ToString::to_string(&drive.validate().expect_err("must be refused"));
        assert!(said(Drive::linear([0.0, 0.0], 10.0)).starts_with("length of the direction is 0;"));
        for ratio in [0.0, -3.0, f32::NAN, 1e9] {
            assert!(said(Drive::linear([1.0, 0.0], ratio)).starts_with("mm_per_rad is"));
        }
        let table = |knots: &[[f32; 2]]| Drive::Translating {
            direction: [1.0, 0.0],
            travel: Travel::Table(Knots::new(knots).expect("not too many")),
        };
        assert_eq!(table(&[[0.0, 0.0]]).validate(), Err(DriveError::Few { count: 1 }));
        let order = |knots: &[[f32; 2]]| match table(knots).validate() {
            Err(DriveError::Order { knot, name, .. }) => (knot, name),
            other => panic!("{other:?}"),
        };
        assert_eq!(order(&[[0.0, 0.0], [0.5, 9.0], [0.4, 12.0]]), (2, "angle"));
        assert_eq!(order(&[[0.0, 0.0], [0.5, -1.0]]), (1, "distance"));
        assert!(said(table(&[[0.0, f32::NAN], [1.0, 2.0]])).starts_with("distance of a knot"));
        assert_eq!(Knots::new(&[[0.0; 2]; MAX_DRIVE_KNOTS + 1]), None);
        assert_eq!(Drive::Rotating.validate(), Ok(()));
    }
}
