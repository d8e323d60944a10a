//! The standard deviation of an estimated force: what the angle's reading and the parameters leave uncertain.
//!
//! To first order σ² = Σᵢⱼ gᵢ gⱼ Cov(pᵢ, pⱼ), g the derivatives of the force's magnitude. The reading of the angle adds two
//! independent errors: rounding to a count q, uniform in ±q/2, σ = q/√12; and backlash b. The contact presses the gears
//! against one flank, so that the finger may lag the reading by anything from 0 to b, uniform and one-sided; as the estimate is made
//! for the reading itself, what counts is the root mean square of that lag, b/√3 (its standard deviation about its
//! mean b/2, which no one subtracts, would be b/√12). A zero angle that was calibrated in contact, approached from one side, holds
//! the mean lag: b is then what remains.

use crate::linear::cholesky::cholesky;
use crate::newton::memory::MOST_TERMS;

/// Parameters of finger and object whose uncertainty has a covariance, in its order.
pub const PARAMETERS: usize = 5;
/// Parameters of the memory: a part and a time per term.
pub const MEMORY_PARAMETERS: usize = 2 * MOST_TERMS;
/// All of them.
pub const ALL: usize = PARAMETERS + MEMORY_PARAMETERS;
/// Names of the first.
const NAMES: [&str; PARAMETERS] = ["zero_angle", "youngs_modulus", "centre x", "centre y", "radius"];
/// Names of the memory's.
const MEMORY_NAMES: [&str; MEMORY_PARAMETERS] = ["g1", "tau1", "g2", "tau2", "g3", "tau3", "g4", "tau4"];
/// Diagonal of a factor in single precision below which it is rounding.
const LEAST: f32 = 1e-3;
/// How far below zero an eigenvalue of the correlations may lie, which are given in single precision.
const ROUNDING: f64 = 1e-5;

/// How uncertain angle and parameters are. Angles in rad, lengths in mm; standard deviations unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Uncertainty {
    /// A count of the position sensor, rad: the whole step.
    pub quantisation: f32,
    /// Play of the gears, rad: the whole of it.
    pub backlash: f32,
    /// Of the zero angle, rad.
    pub zero_angle: f32,
    /// Of Young's modulus, relative.
    pub youngs_modulus: f32,
    /// Of the object's place, world frame, mm.
    pub centre: [f32; 2],
    /// Of the object's radius, mm.
    pub radius: f32,
    /// Correlations, −1 … 1, of zero angle, modulus, centre x, centre y and radius: the lower triangle row by row (modulus with
    /// zero angle; x with zero angle, x with modulus; …).
    pub correlations: [f32; PARAMETERS * (PARAMETERS - 1) / 2],
    /// Of a material with memory.
    #[cfg_attr(feature = "serde", serde(default))]
    pub memory: MemoryUncertainty,
}

/// How uncertain the terms of a material with memory are: standard deviations, and how they go together with each other and with the
/// [`PARAMETERS`] of finger and object.
///
/// Together these are thirteen parameters, the memory's in the order g₁, τ₁, g₂, τ₂, …; their correlations are L Lᵀ, L lower
/// triangular with rows of length 1. Here are the memory's rows of L in 127ths, each without its diagonal, which is positive and makes the
/// length 1. (Correlations themselves would have to be far more accurate: where a force is known much better than each of its
/// parameters, it is a small difference of theirs.)
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MemoryUncertainty {
    /// Of the parts gᵢ.
    pub parts: [f32; MOST_TERMS],
    /// Of the times τᵢ, relative.
    pub times: [f32; MOST_TERMS],
    /// Row by row the entries of L with finger and object.
    pub with_others: [[i8; PARAMETERS]; MEMORY_PARAMETERS],
    /// Row by row the entries of L with the memory's parameters before the row's own.
    pub among: [i8; MEMORY_PARAMETERS * (MEMORY_PARAMETERS - 1) / 2],
}

impl Default for MemoryUncertainty {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What an entry of [`MemoryUncertainty`]'s rows is a part of.
const WHOLE: f32 = 127.0;

impl MemoryUncertainty {
    /// Terms from a measurement of another print of the same material: parts within 0.02, times within 20 %.
    pub const DEFAULT: Self = Self { parts: [0.02; MOST_TERMS], times: [0.2; MOST_TERMS], ..Self::NONE };

    /// Nothing is uncertain.
    pub const NONE: Self = Self {
        parts: [0.0; MOST_TERMS],
        times: [0.0; MOST_TERMS],
        with_others: [[0; PARAMETERS]; MEMORY_PARAMETERS],
        among: [0; MEMORY_PARAMETERS * (MEMORY_PARAMETERS - 1) / 2],
    };

    /// From standard deviations and the correlations of all thirteen parameters, of which the lower triangle is read. Entries of parameters
    /// that are not uncertain count for nothing, and a matrix that rounding has made indefinite for the nearest that is not.
    pub fn of(parts: [f32; MOST_TERMS], times: [f32; MOST_TERMS], correlations: &[[f64; ALL]; ALL]) -> Self {
        let mut given = Self { parts, times, ..Self::NONE };
        // Rows that depend on those before them have no diagonal of their own.
        let mut factor = [[0.0; ALL]; ALL];
        for (i, wanted) in correlations.iter().enumerate() {
            let Some((above, [row, ..])) = factor.split_at_mut_checked(i) else { break };
            let mut left = 1.0;
            for (j, (other, &correlation)) in above.iter().zip(wanted).enumerate() {
                let taken = row.iter().zip(other).take(j).fold(correlation, |sum, (x, y)| sum - x * y);
                let diagonal = other.get(j).copied().unwrap_or(0.0);
                let most = libm::sqrt(f64::max(left, 0.0));
                let entry = if diagonal > 1e-6 { (taken / diagonal).min(most).max(-most) } else { 0.0 };
                left -= entry * entry;
                if let Some(place) = row.get_mut(j) {
                    *place = entry;
                }
            }
            if let Some(place) = row.get_mut(i) {
                *place = libm::sqrt(f64::max(left, 0.0));
            }
        }
        let whole = |entry: f64| libm::round(entry * f64::from(WHOLE)) as i8;
        let mut among = given.among.iter_mut();
        for (j, (row, others)) in factor.iter().skip(PARAMETERS).zip(&mut given.with_others).enumerate() {
            for (into, &entry) in others.iter_mut().zip(row) {
                *into = whole(entry);
            }
            for (&entry, into) in row.iter().skip(PARAMETERS).take(j).zip(&mut among) {
                *into = whole(entry);
            }
        }
        given
    }

    /// Standard deviations in the parameters' order.
    fn deviations(&self) -> [f32; MEMORY_PARAMETERS] {
        let mut deviations = [0.0; MEMORY_PARAMETERS];
        let (pairs, _) = deviations.as_chunks_mut::<2>();
        for (pair, (&part, &time)) in pairs.iter_mut().zip(self.parts.iter().zip(&self.times)) {
            *pair = [part, time];
        }
        deviations
    }

    fn validate(&self) -> Result<(), UncertaintyError> {
        let ranges = [[0.0, 1.0], [0.0, 10.0]];
        let allowed = ranges.iter().cycle();
        for ((value, name), &allowed) in self.deviations().into_iter().zip(MEMORY_NAMES).zip(allowed) {
            if !(allowed[0]..=allowed[1]).contains(&value) {
                return Err(UncertaintyError::Value { name, value, allowed });
            }
        }
        let mut among = self.among.iter();
        for (j, (others, parameter)) in self.with_others.iter().zip(MEMORY_NAMES).enumerate() {
            let row = others.iter().chain(among.by_ref().take(j));
            let square: f32 = row.map(|&entry| f32::from(entry) * f32::from(entry)).sum();
            // Each of thirteen entries is rounded.
            if square > (WHOLE + 6.5) * (WHOLE + 6.5) {
                return Err(UncertaintyError::Correlations { parameter });
            }
        }
        Ok(())
    }
}

/// Derivatives of the force's magnitude, N per rad, per relative modulus, per mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slopes {
    /// With the motor angle, N/rad.
    pub angle: f32,
    /// With the relative change of Young's modulus, N.
    pub youngs_modulus: f32,
    /// With the object's place, N/mm.
    pub centre: [f32; 2],
    /// With the object's radius, N/mm.
    pub radius: f32,
}

/// Why an [`Uncertainty`] is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UncertaintyError {
    /// A value is outside its range.
    Value {
        /// Its name.
        name: &'static str,
        /// The value.
        value: f32,
        /// Least and greatest allowed.
        allowed: [f32; 2],
    },
    /// No errors can be correlated so: the matrix of the correlations is not positive semidefinite.
    Correlations {
        /// The first parameter whose correlations contradict each other and those of the parameters before it.
        parameter: &'static str,
    },
}

impl core::fmt::Display for UncertaintyError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Value { name, value, allowed: [least, most] } => {
                write!(f, "{name} is {value}; allowed is {least} to {most}")
            }
            Self::Correlations { parameter } => {
                write!(f, "correlations of {parameter} contradict the others: no positive semidefinite matrix")
            }
        }
    }
}

impl core::error::Error for UncertaintyError {}

impl Uncertainty {
    /// A gripper that was measured but not calibrated: a Dynamixel XM430 (4096 counts, 0.25° of backlash), its zero angle within
    /// 0.2°, the modulus within 5 %, the object's place within 0.5 mm and its radius within 0.2 mm.
    pub const DEFAULT: Self = Self {
        quantisation: core::f32::consts::TAU / 4096.0,
        backlash: 0.25 * core::f32::consts::PI / 180.0,
        zero_angle: 0.2 * core::f32::consts::PI / 180.0,
        youngs_modulus: 0.05,
        centre: [0.5; 2],
        radius: 0.2,
        correlations: [0.0; PARAMETERS * (PARAMETERS - 1) / 2],
        memory: MemoryUncertainty::DEFAULT,
    };

    /// Nothing is uncertain.
    pub const NONE: Self = Self {
        quantisation: 0.0,
        backlash: 0.0,
        zero_angle: 0.0,
        youngs_modulus: 0.0,
        centre: [0.0; 2],
        radius: 0.0,
        correlations: [0.0; PARAMETERS * (PARAMETERS - 1) / 2],
        memory: MemoryUncertainty::NONE,
    };

    /// Checks every value.
    ///
    /// # Errors
    /// The first that is not allowed.
    pub fn validate(&self) -> Result<(), UncertaintyError> {
        let check = |name, value: f32, allowed: [f32; 2]| {
            let fine = (allowed[0]..=allowed[1]).contains(&value);
            fine.then_some(()).ok_or(UncertaintyError::Value { name, value, allowed })
        };
        check("quantisation", self.quantisation, [0.0, 1.0])?;
        check("backlash", self.backlash, [0.0, 1.0])?;
        check("zero_angle", self.zero_angle, [0.0, 1.0])?;
        check("youngs_modulus", self.youngs_modulus, [0.0, 10.0])?;
        check("centre x", self.centre[0], [0.0, 1000.0])?;
        check("centre y", self.centre[1], [0.0, 1000.0])?;
        check("radius", self.radius, [0.0, 1000.0])?;
        self.correlations.iter().try_for_each(|&value| check("correlation", value, [-1.0, 1.0]))?;
        self.memory.validate()?;
        let contradicts =
            |row: usize| UncertaintyError::Correlations { parameter: NAMES.get(row).copied().unwrap_or_default() };
        cholesky(&self.matrix(), PARAMETERS, ROUNDING).map(|_| ()).map_err(contradicts)
    }

    /// Lower triangle of the correlations' matrix.
    fn matrix(&self) -> [[f64; PARAMETERS]; PARAMETERS] {
        let mut matrix = [[0.0; PARAMETERS]; PARAMETERS];
        let mut correlations = self.correlations.iter();
        for (i, row) in matrix.iter_mut().enumerate() {
            for (value, correlation) in row.iter_mut().take(i).zip(&mut correlations) {
                *value = f64::from(*correlation);
            }
            if let Some(diagonal) = row.get_mut(i) {
                *diagonal = 1.0;
            }
        }
        matrix
    }

    /// Standard deviation of the force's magnitude, N.
    pub fn standard_deviation(&self, slopes: &Slopes) -> f32 {
        let reading = self.quantisation * self.quantisation / 12.0 + self.backlash * self.backlash / 3.0;
        let mut variance = slopes.angle * slopes.angle * reading;
        let parts = self.parts(slopes);
        let mut correlations = self.correlations.iter();
        for (i, part) in parts.iter().enumerate() {
            variance += part * part;
            for (other, correlation) in parts.iter().take(i).zip(&mut correlations) {
                variance += 2.0 * correlation * part * other;
            }
        }
        // Rounding can make it negative.
        libm::sqrtf(variance.max(0.0))
    }

    /// What each parameter's standard deviation makes of the force, N.
    fn parts(&self, slopes: &Slopes) -> [f32; PARAMETERS] {
        [
            slopes.angle * self.zero_angle,
            slopes.youngs_modulus * self.youngs_modulus,
            slopes.centre[0] * self.centre[0],
            slopes.centre[1] * self.centre[1],
            slopes.radius * self.radius,
        ]
    }

    /// By how much a material with memory raises the variance of the force's magnitude, N²; less than zero where its errors make up for
    /// others. `memory`: derivatives of the force's magnitude with each term's part and, relatively, its time, N.
    ///
    /// With the standard deviations' parts p of the force, σ² = |Lᵀp|² over all thirteen parameters.
    pub fn memory_variance(&self, slopes: &Slopes, memory: &[[f32; 2]; MOST_TERMS]) -> f32 {
        let uncertain = self.memory.deviations();
        let mut parts = [0.0; MEMORY_PARAMETERS];
        for (part, (slope, deviation)) in parts.iter_mut().zip(memory.as_flattened().iter().zip(uncertain)) {
            *part = slope * deviation;
        }
        if parts == [0.0; MEMORY_PARAMETERS] {
            return 0.0;
        }
        // Lᵀp of finger and object alone, then with the memory's rows; and what those have of their own.
        let alone = self.whitened(slopes);
        let (mut shared, mut own) = (alone, [0.0; MEMORY_PARAMETERS]);
        let mut among = self.memory.among.iter();
        for (j, (others, part)) in self.memory.with_others.iter().zip(parts).enumerate() {
            let mut left = 1.0;
            let mut take = |into: &mut f32, entry: i8| {
                let entry = f32::from(entry) / WHOLE;
                left -= entry * entry;
                *into += entry * part;
            };
            for (into, &entry) in shared.iter_mut().zip(others) {
                take(into, entry);
            }
            for (into, &entry) in own.iter_mut().take(j).zip(&mut among) {
                take(into, entry);
            }
            if let Some(into) = own.get_mut(j) {
                *into += libm::sqrtf(left.max(0.0)) * part;
            }
        }
        let square = |list: &[f32]| list.iter().map(|x| x * x).sum::<f32>();
        square(&shared) - square(&alone) + square(&own)
    }

    /// Lᵀp of finger and object.
    fn whitened(&self, slopes: &Slopes) -> [f32; PARAMETERS] {
        let mut factor = [[0.0_f32; PARAMETERS]; PARAMETERS];
        let mut correlations = self.correlations.iter();
        for i in 0..PARAMETERS {
            let Some((above, [row, ..])) = factor.split_at_mut_checked(i) else { break };
            let mut left = 1.0;
            for (j, (other, &correlation)) in above.iter().zip(&mut correlations).enumerate() {
                let taken = row.iter().zip(other).take(j).fold(correlation, |sum, (x, y)| sum - x * y);
                let diagonal = other.get(j).copied().unwrap_or(0.0);
                // A parameter that others determine has nothing of its own.
                let entry = if diagonal > LEAST { taken / diagonal } else { 0.0 };
                left -= entry * entry;
                if let Some(place) = row.get_mut(j) {
                    *place = entry;
                }
            }
            if let Some(place) = row.get_mut(i) {
                *place = libm::sqrtf(left.max(0.0));
            }
        }
        let mut whitened = [0.0; PARAMETERS];
        for (row, part) in factor.iter().zip(self.parts(slopes)) {
            for (into, entry) in whitened.iter_mut().zip(row) {
                *into += entry * part;
            }
        }
        whitened
    }
}

impl Default for Uncertainty {
    fn default() -> Self {
        Self::DEFAULT
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_designs::Random;

    const SLOPES: Slopes = Slopes { angle: 50.0, youngs_modulus: 4.0, centre: [-0.6, 0.1], radius: 0.7 };

    /// The spread of forces drawn at random, linear in their causes.
    #[test]
    fn the_standard_deviation_is_that_of_random_draws() {
        let given = Uncertainty::DEFAULT;
        let mut random = Random::new(3);
        let normal = |random: &mut Random| (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
        let (mut sum, count) = (0.0, 200_000);
        for _ in 0..count {
            let rounding = f64::from(given.quantisation) * (random.unit() - 0.5);
            let lag = f64::from(given.backlash) * random.unit();
            let angle = rounding + lag + f64::from(given.zero_angle) * normal(&mut random);
            let mut force = f64::from(SLOPES.angle) * angle;
            for (slope, sigma) in [
                (SLOPES.youngs_modulus, given.youngs_modulus),
                (SLOPES.centre[0], given.centre[0]),
                (SLOPES.centre[1], given.centre[1]),
                (SLOPES.radius, given.radius),
            ] {
                force += f64::from(slope * sigma) * normal(&mut random);
            }
            sum += force * force;
        }
        let drawn = (sum / f64::from(count)).sqrt();
        let stated = f64::from(given.standard_deviation(&SLOPES));
        assert!((drawn / stated - 1.0).abs() < 0.01, "{drawn} {stated}");
    }

    #[test]
    fn errors_that_go_together_cancel_or_add() {
        let alone = Uncertainty { zero_angle: 0.01, centre: [0.5, 0.0], ..Uncertainty::NONE };
        let with = |correlation| {
            let mut given = alone;
            given.correlations[1] = correlation;
            given.standard_deviation(&SLOPES)
        };
        // Parts of 0.5 N and −0.3 N.
        for (correlation, expected) in [(0.0, 0.34_f32.sqrt()), (1.0, 0.2), (-1.0, 0.8)] {
            assert!((with(correlation) - expected).abs() < 1e-5, "{correlation}: {}", with(correlation));
        }
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        assert_eq!(Uncertainty::DEFAULT.validate(), Ok(()));
        let refused = |change: fn(&mut Uncertainty)| {
            let mut given = Uncertainty::DEFAULT;
            change(&mut given);
            match given.validate().expect_err("must be refused") {
                UncertaintyError::Value { name, .. } => name,
                UncertaintyError::Correlations { parameter } => parameter,
            }
        };
        assert_eq!(refused(|u| u.backlash = -0.1), "backlash");
        assert_eq!(refused(|u| u.centre[1] = f32::NAN), "centre y");
        assert_eq!(refused(|u| u.correlations[9] = 1.5), "correlation");
    }

    /// Thirteen parameters with random correlations, some of them determined by others: as |Lᵀp|² of the exact factor says.
    #[test]
    fn the_memorys_part_of_the_variance_is_that_of_the_whole_covariance() {
        let mut random = Random::new(5);
        for round in 0..200 {
            // Fewer causes than parameters: a matrix without full rank.
            let causes = if round % 2 == 0 { ALL } else { 6 };
            let mut mix = [[0.0_f64; ALL]; ALL];
            for row in &mut mix {
                row.iter_mut().take(causes).for_each(|entry| *entry = random.unit() - 0.5);
                let length = row.iter().map(|x| x * x).sum::<f64>().sqrt();
                row.iter_mut().for_each(|entry| *entry /= length);
            }
            let correlations: [[f64; ALL]; ALL] = core::array::from_fn(|i| {
                core::array::from_fn(|j| mix[i].iter().zip(&mix[j]).map(|(x, y)| x * y).sum::<f64>())
            });
            let memory = MemoryUncertainty::of([0.03, 0.02, 0.05, 0.01], [0.1, 0.4, 0.2, 0.3], &correlations);
            let mut given = Uncertainty { quantisation: 0.0, backlash: 0.0, memory, ..Uncertainty::DEFAULT };
            let lower = (0..PARAMETERS).flat_map(|i| (0..i).map(move |j| (i, j)));
            for (entry, (i, j)) in given.correlations.iter_mut().zip(lower) {
                *entry = correlations[i][j] as f32;
            }
            assert_eq!(given.validate(), Ok(()), "{round}");
            let slopes: [[f32; 2]; MOST_TERMS] =
                core::array::from_fn(|_| core::array::from_fn(|_| (20.0 * (random.unit() - 0.5)) as f32));
            let parts = given.parts(&SLOPES).into_iter().chain(
                slopes.as_flattened().iter().zip(given.memory.deviations()).map(|(slope, deviation)| slope * deviation),
            );
            let parts: std::vec::Vec<f64> = parts.map(f64::from).collect();
            let exact = |from: usize| -> f64 {
                let sums = (0..ALL).map(|k| (0..from).map(|i| mix[i][k] * parts[i]).sum::<f64>());
                sums.map(|sum| sum * sum).sum()
            };
            let alone = f64::from(given.standard_deviation(&SLOPES)).powi(2);
            assert!((alone - exact(PARAMETERS)).abs() < 1e-4, "{round}: {alone} {}", exact(PARAMETERS));
            let found = (alone + f64::from(given.memory_variance(&SLOPES, &slopes))).sqrt();
            let size = parts.iter().map(|x| x * x).sum::<f64>().sqrt();
            let off = (found - exact(ALL).sqrt()).abs() / size;
            assert!(off < 0.01, "{round}: {found} {} of {size}", exact(ALL).sqrt());
        }
        let memory = MemoryUncertainty { parts: [0.0, 2.0, 0.0, 0.0], ..MemoryUncertainty::NONE };
        let refused = Uncertainty { memory, ..Uncertainty::NONE }.validate();
        assert!(matches!(refused, Err(UncertaintyError::Value { name: "g2", .. })), "{refused:?}");
        let with_others = [[127, 80, 0, 0, 0]; MEMORY_PARAMETERS];
        let memory = MemoryUncertainty { with_others, ..MemoryUncertainty::NONE };
        let refused = Uncertainty { memory, ..Uncertainty::NONE }.validate();
        assert_eq!(refused, Err(UncertaintyError::Correlations { parameter: "g1" }));
    }

    /// Modulus against zero angle −1, x with either +1: no three errors can do that, and the variance would be negative.
    #[test]
    fn correlations_that_contradict_each_other_are_refused() {
        let with = |correlations: &[(usize, f32)]| {
            let mut given = Uncertainty::DEFAULT;
            for &(place, value) in correlations {
                given.correlations[place] = value;
            }
            given.validate()
        };
        let refused = |parameter| Err(UncertaintyError::Correlations { parameter });
        assert_eq!(with(&[(0, -1.0), (1, 1.0), (2, 1.0)]), refused("centre x"));
        assert_eq!(with(&[(6, 0.9), (7, 0.9), (0, -0.9)]), refused("radius"));
        assert_eq!(with(&[(9, 0.99), (8, -0.99), (5, 0.5)]), refused("radius"));
        // Errors with one cause, and those of a matrix at the edge: three of them with −1/2 each.
        assert_eq!(with(&[(0, -1.0), (1, 1.0), (2, -1.0)]), Ok(()));
        assert_eq!(with(&[(0, -0.5), (1, -0.5), (2, -0.5)]), Ok(()));
        let said = std::string::ToString::to_string(&with(&[(0, -1.0), (1, 1.0), (2, 1.0)]).unwrap_err());
        assert!(said.contains("centre x") && said.len() <= 104, "{said}");
    }

    /// Whatever is allowed has a variance that is not negative but for rounding: by random matrices, which are mostly refused.
    #[test]
    fn allowed_correlations_give_no_negative_variance() {
        let mut random = Random::new(8);
        let (mut allowed, mut refused) = (0, 0);
        for _ in 0..2_000 {
            let mut given = Uncertainty { quantisation: 0.0, backlash: 0.0, ..Uncertainty::DEFAULT };
            given.correlations = core::array::from_fn(|_| (2.0 * random.unit() - 1.0) as f32);
            // The least of the quadratic form over random directions.
            let matrix = given.matrix();
            let least = (0..400).map(|_| {
                let v: [f64; PARAMETERS] = core::array::from_fn(|_| random.unit() - 0.5);
                let form: f64 = (0..PARAMETERS)
                    .flat_map(|i| (0..=i).map(move |j| (i, j)))
                    .map(|(i, j)| if i == j { v[i] * v[i] } else { 2.0 * matrix[i][j] * v[i] * v[j] })
                    .sum();
                form / v.iter().map(|x| x * x).sum::<f64>()
            });
            let least = least.fold(f64::INFINITY, f64::min);
            if given.validate().is_ok() {
                allowed += 1;
                assert!(least > -ROUNDING, "{given:?}: {least}");
            } else {
                refused += 1;
            }
        }
        assert!(allowed > 20 && refused > 1_000, "{allowed} allowed, {refused} refused");
    }
}
