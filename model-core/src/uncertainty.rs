//! The standard deviation of an estimated force: what the angle's reading and the parameters leave uncertain.
//!
//! To first order σ² = Σᵢⱼ gᵢ gⱼ Cov(pᵢ, pⱼ), g the derivatives of the force's magnitude. The reading of the angle adds two
//! independent errors: rounding to a count q, uniform in ±q/2, σ = q/√12; and backlash b. The contact presses the gears
//! against one flank, so that the finger may lag the reading by anything from 0 to b, uniform and one-sided; as the estimate is made
//! for the reading itself, what counts is the root mean square of that lag, b/√3 (its standard deviation about its
//! mean b/2, which no one subtracts, would be b/√12). A zero angle that was calibrated in contact, approached from one side, holds
//! the mean lag: b is then what remains.

use crate::linear::cholesky::cholesky;

/// Parameters whose uncertainty has a covariance, in its order.
pub const PARAMETERS: usize = 5;
/// Their names.
const NAMES: [&str; PARAMETERS] = ["zero_angle", "youngs_modulus", "centre x", "centre y", "radius"];
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
        let parts: [f32; PARAMETERS] = [
            slopes.angle * self.zero_angle,
            slopes.youngs_modulus * self.youngs_modulus,
            slopes.centre[0] * self.centre[0],
            slopes.centre[1] * self.centre[1],
            slopes.radius * self.radius,
        ];
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
