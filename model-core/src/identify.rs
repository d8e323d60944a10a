//! What the object is like, from motor angle and torque over a closing motion: its height with the radius known, or its
//! radius with the height known.
//!
//! Weighted least squares over one unknown p and a constant error b of the torque (friction is never known to the newton
//! millimetre), τₖ = τ(αₖ; p) + b + noise: with rₖ = τₖ − τ(αₖ; p) − b and dₖ = ∂τ/∂p of the implicit function theorem
//! ([`crate::sensitivity`]),
//!
//! χ²(p, b) = Σ wₖ rₖ² + b²/σ_b², wₖ = 1/(σ_τ² + (∂τ/∂α σ_α)²).
//!
//! As the weights depend on p, it is the likelihood that is greatest: χ² − Σ ln wₖ is least. The error b is eliminated; the
//! minimum in p is searched by golden section around the best of a few places in its range:
//! contact that moves from sample to sample makes dₖ jump, and with it every step that trusts it alone. The standard
//! deviation is that of the linearised problem, 1/√Σ wₖ dₖ² with b eliminated, made greater where the residuals are greater
//! than the noise that was given. Nothing is stored per measurement.

use crate::drive::Drive;
use crate::equilibrium::Follower;
use crate::object::ObjectDesign;
use crate::real::Real;
use crate::size::Size;

/// Places of the range that are looked at first.
const PLACES: usize = 9;
/// Sections of the bracket at most.
const SECTIONS: usize = 32;
/// Passes over the motion at most; in each, every measurement is followed within
/// [`FOLLOW_ITERATIONS`](crate::equilibrium::FOLLOW_ITERATIONS).
pub const PASSES: usize = PLACES + SECTIONS;
/// A bracket below this part of the standard deviation ends the search.
const SETTLED: f64 = 0.1;
/// The golden section.
const GOLDEN: f64 = 0.618_033_988_749_895;
/// Measurements in contact without which nothing can be said.
const LEAST: usize = 5;

/// A measurement of the closing motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Motor angle, rad.
    pub angle: f64,
    /// Torque that drives the finger against the object, without the friction of a free motion, N·mm.
    pub torque: f64,
}

/// How the motor moves the finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// It turns the base, or moves it along a line.
    pub drive: Drive,
    /// The finger's motor axis, mm.
    pub axis: [f64; 2],
}

/// Standard deviations of the measurements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Of a torque, independent from one to the next, N·mm.
    pub torque: f64,
    /// Of the error that all torques share, N·mm.
    pub offset: f64,
    /// Of an angle, independent, rad: backlash and resolution.
    pub angle: f64,
}

/// What is to be found of a circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// The y coordinate of its centre, mm.
    Height,
    /// Its radius, mm, the centre staying where it is.
    Radius,
    /// Its radius, mm, the side towards the finger (its smallest x) staying where it is: an object that lies against it.
    RadiusBehindSide,
}

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Identified {
    /// The unknown, mm.
    pub value: f64,
    /// Its standard deviation, mm.
    pub standard_deviation: f64,
    /// The error that all torques share, N·mm.
    pub offset: f64,
    /// Root mean square of the residuals in standard deviations: about 1 if the model and the noise are as given.
    pub misfit: f64,
    /// Measurements in contact.
    pub touching: usize,
}

/// Why nothing was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IdentifyError {
    /// Only circles have a radius and a height.
    NotACircle,
    /// The range is empty or not finite, or a radius in it is not positive, mm.
    Range([f64; 2]),
    /// A standard deviation is negative, not finite, or zero where it must not be.
    Noise(f64),
    /// A measurement is not finite, or the angles do not increase (number from 0).
    Measurement(usize),
    /// The model in no place of the range follows the motion.
    NotFollowed,
    /// Fewer measurements in contact than the five that are needed.
    TooFew(usize),
    /// The torque does not depend on the unknown.
    Unobservable,
    /// χ² falls towards the range's end, mm: the object is not in the range.
    AtEnd(f64),
}

impl core::fmt::Display for IdentifyError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotACircle => {
                f.write_str("the object is not a circle: only a circle's height or radius is identified")
            }
            Self::Range([least, most]) => {
                write!(f, "the range is {least} to {most} mm; it must be finite, not empty, and a radius positive")
            }
            Self::Noise(value) => {
                write!(f, "a standard deviation is {value}; it must be finite and not negative, the torque's positive")
            }
            Self::Measurement(number) => {
                write!(f, "measurement {number}: angle and torque must be finite, and angles increase")
            }
            Self::NotFollowed => f.write_str("the finger cannot be followed over the motion anywhere in the range"),
            Self::TooFew(count) => {
                write!(f, "{count} measurements in contact; at least {LEAST} are needed")
            }
            Self::Unobservable => f.write_str("the torque does not depend on what is to be identified"),
            Self::AtEnd(value) => write!(f, "the measurements fit best at {value} mm, the end of the range"),
        }
    }
}

impl core::error::Error for IdentifyError {}

/// The sums of one pass over the motion.
#[derive(Clone, Copy, Debug)]
struct Pass {
    /// χ² with the best b.
    chi2: f64,
    /// What is minimal: −2 ln of the likelihood, as the weights depend on p too.
    objective: f64,
    /// Curvature of χ²/2 in p, b eliminated.
    curvature: f64,
    offset: f64,
    touching: usize,
}

/// Finds the unknown within its range, mm, in at most [`PASSES`] passes. The follower has the finger; `object` is what is known of the circle, its
/// unknown part aside.
///
/// # Errors
/// Input that is not as it has to be, or an unknown that cannot be found in the range.
pub fn identify<T: Real, S: Size>(
    follower: &mut Follower<T, S>,
    moved: &Moved,
    object: ObjectDesign,
    unknown: Unknown,
    range: [f64; 2],
    measurements: &[Measurement],
    noise: &Noise,
) -> Result<Identified, IdentifyError> {
    let ObjectDesign::Circle { centre, radius } = object else {
        return Err(IdentifyError::NotACircle);
    };
    let [least, most] = range;
    let is_fine = least.is_finite() && most.is_finite() && least < most;
    if !is_fine || (unknown != Unknown::Height && least <= 0.0) {
        return Err(IdentifyError::Range(range));
    }
    for value in [noise.torque, noise.offset, noise.angle] {
        if !value.is_finite() || value < 0.0 {
            return Err(IdentifyError::Noise(value));
        }
    }
    if noise.torque == 0.0 {
        return Err(IdentifyError::Noise(0.0));
    }
    let mut before = f64::NEG_INFINITY;
    for (number, measurement) in measurements.iter().enumerate() {
        if !measurement.torque.is_finite() || !measurement.angle.is_finite() || measurement.angle <= before {
            return Err(IdentifyError::Measurement(number));
        }
        before = measurement.angle;
    }
    let at = |value: f64| match unknown {
        Unknown::Height => ObjectDesign::Circle { centre: [centre[0], value], radius },
        Unknown::Radius => ObjectDesign::Circle { centre, radius: value },
        Unknown::RadiusBehindSide => {
            ObjectDesign::Circle { centre: [centre[0] - radius + value, centre[1]], radius: value }
        }
    };
    let mut pass = |value: f64| {
        follower.set_object(at(value), moved.drive.motion(moved.axis));
        go(follower, &moved.drive, unknown, measurements, noise)
    };

    let width = (most - least) / PLACES as f64;
    let mut best: Option<(f64, Pass)> = None;
    for place in 0..PLACES {
        let value = least + width * (place as f64 + 0.5);
        if let Some(found) = pass(value)
            && best.is_none_or(|(_, best)| found.objective < best.objective)
        {
            best = Some((value, found));
        }
    }
    let (mut value, mut here) = best.ok_or(IdentifyError::NotFollowed)?;
    let (mut low, mut high) = ((value - width).max(least), (value + width).min(most));
    for _ in 0..SECTIONS {
        if here.touching < LEAST {
            return Err(IdentifyError::TooFew(here.touching));
        }
        if !here.curvature.is_finite() || here.curvature <= 0.0 {
            return Err(IdentifyError::Unobservable);
        }
        if high - low <= SETTLED * libm::sqrt(1.0 / here.curvature) {
            break;
        }
        // In the longer part; where the model cannot follow, nothing is better.
        let is_above = high - value > value - low;
        let tried = if is_above { high - GOLDEN * (high - value) } else { low + GOLDEN * (value - low) };
        match pass(tried) {
            Some(there) if there.objective < here.objective => {
                if is_above {
                    low = value
                } else {
                    high = value
                }
                (value, here) = (tried, there);
            }
            _ if is_above => high = tried,
            _ => low = tried,
        }
    }
    let deviation = libm::sqrt(1.0 / here.curvature);
    if value - least < deviation || most - value < deviation {
        return Err(IdentifyError::AtEnd(value));
    }
    Ok(found(value, &here, measurements.len()))
}

fn found(value: f64, here: &Pass, measurements: usize) -> Identified {
    let free = (measurements as f64 - 1.0).max(1.0);
    let misfit = libm::sqrt(here.chi2 / free);
    Identified {
        value,
        standard_deviation: libm::sqrt(1.0 / here.curvature) * misfit.max(1.0),
        offset: here.offset,
        misfit,
        touching: here.touching,
    }
}

/// Follows the motion once; nothing if the model cannot.
fn go<T: Real, S: Size>(
    follower: &mut Follower<T, S>,
    drive: &Drive,
    unknown: Unknown,
    measurements: &[Measurement],
    noise: &Noise,
) -> Option<Pass> {
    let [first, _] = drive.coordinate(measurements.first()?.angle)?;
    if !follower.start(first) {
        return None;
    }
    let (mut w, mut wd, mut wr) = (1.0 / (noise.offset * noise.offset).max(f64::MIN_POSITIVE), 0.0, 0.0);
    let (mut wdd, mut wrr) = (0.0, 0.0);
    let (mut touching, mut logarithms) = (0, 0.0);
    let mut last = (0.0, 0.0);
    for measurement in measurements {
        let [coordinate, ratio] = drive.coordinate(measurement.angle)?;
        if !follower.follow(coordinate).status.is_trustworthy() {
            return None;
        }
        if follower.solution().touching() > 0 {
            touching += 1;
            // Where there is no room for derivatives, those of the equilibrium before are near.
            if let Some(slopes) = follower.sensitivity() {
                let derivative = match unknown {
                    Unknown::Height => slopes.centre[1].torque,
                    Unknown::Radius => slopes.radius.torque,
                    Unknown::RadiusBehindSide => slopes.radius.torque + slopes.centre[0].torque,
                };
                last = (ratio * derivative.to_f64(), ratio * ratio * slopes.coordinate.torque.to_f64());
            }
        } else {
            last = (0.0, 0.0);
        }
        let (derivative, stiffness) = last;
        let rest = measurement.torque - ratio * follower.solution().motor_torque().to_f64();
        let lateral = stiffness * noise.angle;
        let weight = 1.0 / (noise.torque * noise.torque + lateral * lateral);
        logarithms += libm::log(weight * noise.torque * noise.torque);
        w += weight;
        wd += weight * derivative;
        wr += weight * rest;
        wdd += weight * derivative * derivative;
        wrr += weight * rest * rest;
    }
    // Minimal in b at b = Σwr / Σw.
    let offset = wr / w;
    let chi2 = wrr - wr * offset;
    Some(Pass { chi2, objective: chi2 - logarithms, curvature: wdd - wd * wd / w, offset, touching })
}

#[cfg(test)]
mod tests {
    use std::boxed::Box;
    use std::vec::Vec;

    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{RngCore, SeedableRng};

    use super::*;
    use crate::discretise::{Discretisation, Physics, Scheme};
    use crate::object::Motion;
    use crate::size::{Paper, Reduced};

    const COUNT: f64 = core::f64::consts::TAU / 4096.0;
    const NOISE: Noise = Noise { torque: 20.0, offset: 30.0, angle: COUNT };
    const AXIS: [f64; 2] = [-14.0, -20.0];
    const TURNED: Moved = Moved { drive: Drive::Rotating, axis: AXIS };

    fn circle(radius: f64, height: f64) -> ObjectDesign {
        ObjectDesign::Circle { centre: [radius + 1.0, height], radius }
    }

    fn normal(random: &mut ChaCha8Rng) -> f64 {
        let mut uniform = || (f64::from(random.next_u32()) + 0.5) / 4_294_967_296.0;
        let (a, b) = (uniform(), uniform());
        (-2.0 * a.ln()).sqrt() * (core::f64::consts::TAU * b).cos()
    }

    /// Torques of the finger at full resolution, from before the contact to 10°.
    fn truth(object: ObjectDesign) -> Vec<Measurement> {
        let mut follower: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
        let how = Discretisation::full(Scheme::Trapezoid, Physics::Extended);
        follower.configure(&crate::design::ladder_80(), &how).expect("a valid finger");
        follower.set_object(object, Motion::Rotating { axis: AXIS });
        assert!(follower.start(-0.01));
        let angles = (-3..=57).map(|step| f64::from(step) * 2.0 * COUNT);
        let measured = |angle| {
            assert!(follower.follow(angle).status.is_trustworthy());
            Measurement { angle, torque: follower.solution().motor_torque() }
        };
        angles.map(measured).collect()
    }

    /// What a servo makes of them: its angle is a whole count and its play is not known to it, its torque is a current's.
    fn measured(truth: &[Measurement], random: &mut ChaCha8Rng) -> Vec<Measurement> {
        let offset = NOISE.offset * normal(random);
        let noisy = |true_one: &Measurement| Measurement {
            angle: true_one.angle + 0.3 * COUNT * normal(random).clamp(-2.0, 2.0),
            torque: true_one.torque + offset + NOISE.torque * normal(random),
        };
        truth.iter().map(noisy).collect()
    }

    fn model() -> Box<Follower<f32, Reduced>> {
        let mut follower: Box<Follower<f32, Reduced>> = Box::new(Follower::EMPTY);
        let how = Discretisation::estimator(Physics::Extended);
        follower.configure(&crate::design::ladder_80(), &how).expect("a valid finger");
        follower
    }

    /// The microcontroller's model finds what full resolution and noise were made of, and says how well.
    fn found_within(unknown: Unknown, range: [f64; 2], cases: &[(f64, f64)], allowed: f64) {
        let mut follower = model();
        let mut random = ChaCha8Rng::seed_from_u64(11);
        let (mut squares, mut count) = (0.0, 0);
        for &(radius, height) in cases {
            let truth = truth(circle(radius, height));
            for _ in 0..4 {
                let measurements = measured(&truth, &mut random);
                // What is known of it, and nothing of what is not.
                let (known, value) = match unknown {
                    Unknown::Height => (circle(radius, 0.0), height),
                    Unknown::Radius => (circle(radius, height), radius),
                    Unknown::RadiusBehindSide => (circle(1.0, height), radius),
                };
                let found = identify(&mut *follower, &TURNED, known, unknown, range, &measurements, &NOISE)
                    .unwrap_or_else(|error| panic!("{unknown:?} of {radius} mm at {height} mm: {error}"));
                let error = found.value - value;
                std::eprintln!("{unknown:?}, {radius} mm at {height} mm: {error:+.3} mm, {found:?}");
                assert!(error.abs() <= allowed, "{unknown:?} of {radius} mm at {height} mm: {found:?}");
                assert!(found.standard_deviation < allowed, "{found:?}");
                squares += (error / found.standard_deviation).powi(2);
                count += 1;
            }
        }
        // χ² of 12 degrees of freedom is within 2.2 … 32.9 (0.1 % on either side).
        assert!(count == 12 && (2.2..32.9).contains(&squares), "{unknown:?}: {squares} of {count}");
    }

    #[test]
    fn the_height_is_found() {
        found_within(Unknown::Height, [25.0, 65.0], &[(40.0, 45.0), (40.0, 56.0), (30.0, 50.0)], 0.6);
    }

    /// Jaws that a rack of 20 mm per rad moves along a line: the motor's torque is the force times that.
    #[test]
    fn jaws_that_translate_find_the_height() {
        let moved = Moved { drive: Drive::linear([1.0, 0.0], 20.0), axis: AXIS };
        let mut follower: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
        let how = Discretisation::full(Scheme::Trapezoid, Physics::Extended);
        follower.configure(&crate::design::ladder_80(), &how).expect("a valid finger");
        follower.set_object(circle(40.0, 45.0), moved.drive.motion(AXIS));
        assert!(follower.start(-1.0));
        let measure = |step: i32| {
            let angle = f64::from(step) * 2.0 * COUNT;
            assert!(follower.follow(20.0 * angle).status.is_trustworthy());
            Measurement { angle, torque: 20.0 * follower.solution().motor_torque() }
        };
        let measurements: Vec<_> = (0..=130).map(measure).collect();
        let known = circle(40.0, 0.0);
        // The force along the line says less of the height than a torque about an axis does.
        let quiet = Noise { torque: 1.0, offset: 1.0, angle: 0.01 * COUNT };
        let found = identify(&mut *model(), &moved, known, Unknown::Height, [25.0, 65.0], &measurements, &quiet);
        let found = found.expect("a height");
        assert!((found.value - 45.0).abs() < 2.0 && found.standard_deviation < 2.0, "{found:?}");
    }

    #[test]
    fn the_radius_is_found() {
        let cases = [(40.0, 45.0), (50.0, 45.0), (40.0, 56.0)];
        found_within(Unknown::RadiusBehindSide, [15.0, 70.0], &cases, 1.5);
    }

    #[test]
    fn what_cannot_be_is_told() {
        let mut follower = model();
        let some: Vec<_> = (0..20).map(|k| Measurement { angle: f64::from(k) * 0.01, torque: 0.0 }).collect();
        let mut ask = |object, unknown, range, measurements: &[Measurement], noise| {
            identify(&mut *follower, &TURNED, object, unknown, range, measurements, noise).unwrap_err()
        };
        let (object, range) = (circle(40.0, 45.0), [30.0, 60.0]);
        let polygon = ObjectDesign::Ellipse { centre: [60.0, 45.0], semi_axes: [20.0, 30.0], angle: 0.0 };
        assert_eq!(ask(polygon, Unknown::Height, range, &some, &NOISE), IdentifyError::NotACircle);
        assert_eq!(ask(object, Unknown::Radius, [0.0, 5.0], &some, &NOISE), IdentifyError::Range([0.0, 5.0]));
        let none = Noise { torque: 0.0, ..NOISE };
        assert_eq!(ask(object, Unknown::Height, range, &some, &none), IdentifyError::Noise(0.0));
        let mut turned = some.clone();
        turned.swap(3, 4);
        assert_eq!(ask(object, Unknown::Height, range, &turned, &NOISE), IdentifyError::Measurement(4));
        assert_eq!(ask(object, Unknown::Height, range, &[], &NOISE), IdentifyError::NotFollowed);
        let before: Vec<_> = (0..20).map(|k| Measurement { angle: -0.2 + f64::from(k) * 0.001, torque: 0.0 }).collect();
        assert_eq!(ask(object, Unknown::Height, range, &before, &NOISE), IdentifyError::TooFew(0));
    }

    /// The search ends, also where it is fooled: a torque without noise that no circle of this height gives.
    #[test]
    fn a_search_takes_no_more_than_its_passes() {
        let mut follower = model();
        let measurements: Vec<_> =
            (0..40).map(|k| Measurement { angle: f64::from(k) * 0.004, torque: 3e3 * f64::from(k % 5) }).collect();
        let range = [30.0, 60.0];
        let sharp = Noise { torque: 1e-6, offset: 1e-6, angle: 0.0 };
        let mut most = 0;
        for place in 0..=60 {
            follower.set_object(circle(40.0, 30.0 + 0.5 * f64::from(place)), Motion::Rotating { axis: AXIS });
            let before = follower.effort();
            let _ = go(&mut follower, &Drive::Rotating, Unknown::Height, &measurements, &sharp);
            most = most.max(follower.effort().since(before).evaluations);
        }
        let before = follower.effort();
        let _ = identify(&mut *follower, &TURNED, circle(40.0, 45.0), Unknown::Height, range, &measurements, &sharp);
        let spent = follower.effort().since(before).evaluations;
        let passes = spent as f64 / f64::from(most);
        assert!((PLACES as f64..PASSES as f64 + 1.0).contains(&passes), "{passes} passes");
    }

    #[test]
    fn an_object_outside_the_range_is_not_found_at_its_end() {
        let truth = truth(circle(40.0, 45.0));
        let found = identify(&mut *model(), &TURNED, circle(40.0, 0.0), Unknown::Height, [52.0, 60.0], &truth, &NOISE);
        assert!(matches!(found, Err(IdentifyError::AtEnd(_))), "{found:?}");
    }
}
