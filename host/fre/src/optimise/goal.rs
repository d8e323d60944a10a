//! Goals, limits and variables, in a designer's words.

use std::fmt;
use std::str::FromStr;

use super::measure::{MEASURES, Measure, finite};

/// A measure that shall be large or small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// The measure.
    pub measure: Measure,
    /// True if it shall be large.
    pub largest: bool,
}

impl Goal {
    /// The goal in words for people, with a place's unit: "largest stiffness at 8°".
    pub fn phrase(self, unit: &str) -> String {
        format!("{} {}", if self.largest { "largest" } else { "least" }, self.measure.phrase(unit))
    }

    /// The measure with the sign that makes less better.
    pub(super) fn sign(self) -> f64 {
        if self.largest { -1.0 } else { 1.0 }
    }
}

impl FromStr for Goal {
    type Err = String;

    /// `[largest|least] MEASURE`, or `constant-force over A:B`, which is the least `force-variation`.
    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if let Some(range) = text.strip_prefix("constant-force ") {
            return Ok(Self { measure: format!("force-variation {range}").parse()?, largest: false });
        }
        let (word, rest) = text.split_once(' ').unwrap_or((text, ""));
        match word {
            "largest" => Ok(Self { measure: rest.parse()?, largest: true }),
            "least" => Ok(Self { measure: rest.parse()?, largest: false }),
            _ => {
                let measure: Measure = text.parse().map_err(|error| format!("{error}, or constant-force over A:B"))?;
                Ok(Self { measure, largest: measure.is_better_large() })
            }
        }
    }
}

impl fmt::Display for Goal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", if self.largest { "largest" } else { "least" }, self.measure)
    }
}

/// Bounds of a measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// The measure.
    pub measure: Measure,
    /// Its least value.
    pub least: Option<f64>,
    /// Its largest.
    pub most: Option<f64>,
}

impl Limit {
    /// The limit in words for people, with a place's unit: "strain up to 8° ≤ 0.1".
    pub fn phrase(self, unit: &str) -> String {
        if let (Measure::Snap(at), Some(least), None) = (self.measure, self.least, self.most)
            && at == least
        {
            return format!("no snap-through before {at}{unit}");
        }
        let own = match self.measure {
            Measure::Snap(_) => unit.to_owned(),
            measure => format!(" {}", measure.unit()),
        };
        let bound = |sign: &str, bound: Option<f64>| {
            bound.map(|bound| format!(" {sign} {bound}{own}").trim_end().to_owned()).unwrap_or_default()
        };
        format!("{}{}{}", self.measure.phrase(unit), bound("≥", self.least), bound("≤", self.most))
    }

    /// How far each bound is kept by a value, as a share of the larger bound: 0 and more where it is kept.
    pub(super) fn margins(self, value: f64) -> impl Iterator<Item = f64> {
        self.scaled().map(move |(sign, bound)| sign * value - bound)
    }

    /// The bounds as sign · value ≥ bound, divided by the larger one.
    pub(super) fn scaled(self) -> impl Iterator<Item = (f64, f64)> {
        let size = [self.least, self.most].into_iter().flatten().map(f64::abs).fold(0.0, f64::max);
        let size = if size > 0.0 { size } else { 1.0 };
        let bound = move |sign: f64, bound: Option<f64>| bound.map(|bound| (sign / size, sign * bound / size));
        [bound(1.0, self.least), bound(-1.0, self.most)].into_iter().flatten()
    }
}

impl FromStr for Limit {
    type Err = String;

    /// `MEASURE <= NUMBER`, `MEASURE >= NUMBER` (a share also as `10%`), or `no-snap before A`.
    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(at) = text.trim().strip_prefix("no-snap before ") {
            let measure: Measure = format!("snap up to {at}").parse()?;
            return Ok(Self { least: measure.places().first().copied(), most: None, measure });
        }
        let refused = || {
            format!(
                "\"{text}\" is not a limit; allowed is MEASURE <= NUMBER, MEASURE >= NUMBER or no-snap before A, where MEASURE is {MEASURES}"
            )
        };
        let number = |word: &str| {
            let word = word.trim();
            let share = word.strip_suffix('%').map(|number| finite(number.trim()).map(|percent| 0.01 * percent));
            share.unwrap_or_else(|| finite(word)).ok_or_else(refused)
        };
        if let Some((measure, bound)) = text.split_once("<=") {
            return Ok(Self { measure: measure.parse()?, least: None, most: Some(number(bound)?) });
        }
        let (measure, bound) = text.split_once(">=").ok_or_else(refused)?;
        Ok(Self { measure: measure.parse()?, least: Some(number(bound)?), most: None })
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.measure)?;
        if let Some(least) = self.least {
            write!(f, " >= {least}")?;
        }
        if let Some(most) = self.most {
            write!(f, " <= {most}")?;
        }
        Ok(())
    }
}

/// A number of a case that the search may change.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Its dotted key.
    pub key: String,
    /// Lower bound, in the file's unit.
    pub least: f64,
    /// Upper bound.
    pub most: f64,
}

impl Variable {
    /// A variable between two bounds.
    ///
    /// # Errors
    /// The first bound is not less than the second.
    pub fn new(key: &str, least: f64, most: f64) -> Result<Self, String> {
        if !(least < most && least.is_finite() && most.is_finite()) {
            return Err(format!("{key} = {least}:{most}: the first bound must be less than the second"));
        }
        Ok(Self { key: key.replace('[', ".").replace(']', ""), least, most })
    }

    /// Distance of the bounds.
    pub(super) fn range(&self) -> f64 {
        self.most - self.least
    }
}

impl FromStr for Variable {
    type Err = String;

    /// `KEY=A:B`.
    fn from_str(text: &str) -> Result<Self, String> {
        let refused = || format!("\"{text}\" is not a variable; allowed is KEY=A:B");
        let (key, bounds) = text.split_once('=').ok_or_else(refused)?;
        let (least, most) = bounds.split_once(':').ok_or_else(refused)?;
        let bound = |word: &str| finite(word.trim()).ok_or_else(refused);
        Self::new(key.trim(), bound(least)?, bound(most)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_read_units() {
        let limit = |words: &str, unit: &str| words.parse::<Limit>().map(|limit| limit.phrase(unit));
        assert_eq!(limit("strain up to 8 <= 10%", "°"), Ok("strain up to 8° ≤ 0.1".to_owned()));
        assert_eq!(limit("mean-force over 4:10:1 >= 3", " mm"), Ok("mean force over 4 to 10 mm ≥ 3 N".to_owned()));
        assert_eq!(limit("no-snap before 9", "°"), Ok("no snap-through before 9°".to_owned()));
        assert_eq!(limit("snap up to 9 >= 8", "°"), Ok("place of a snap-through up to 9° ≥ 8°".to_owned()));
        let goal = |words: &str| words.parse::<Goal>().map(|goal| goal.phrase("°"));
        assert_eq!(goal("stiffness at 8"), Ok("largest stiffness at 8°".to_owned()));
        assert_eq!(goal("constant-force over 4:10"), Ok("least variation of the force over 4 to 10°".to_owned()));
        assert_eq!(goal("mass"), Ok("least mass at 1200 kg/m³".to_owned()));
    }

    #[test]
    fn goals_limits_and_variables_are_read() {
        let goal = |text: &str| text.parse::<Goal>().map(|goal| goal.to_string());
        assert_eq!(goal("constant-force over 4:10:1"), Ok("least force-variation over 4:10:1".to_owned()));
        assert_eq!(goal("stiffness at 8"), Ok("largest stiffness at 8".to_owned()));
        assert_eq!(goal("mass"), Ok("least mass of 1200".to_owned()));
        assert_eq!(goal("least force at 8"), Ok("least force at 8".to_owned()));
        assert!(goal("prettiest finger").is_err() && goal("").is_err());
        let limit = |text: &str| text.parse::<Limit>().map(|limit| limit.to_string());
        assert_eq!(limit("strain up to 8 <= 10%"), Ok("strain up to 8 <= 0.1".to_owned()));
        assert_eq!(limit("force at 8>=3"), Ok("force at 8 >= 3".to_owned()));
        assert_eq!(limit("no-snap before 12"), Ok("snap up to 12 >= 12".to_owned()));
        assert!(limit("strain up to 8").is_err() && limit("strain up to 8 <= x").is_err());
        let both = Limit { measure: Measure::Force(8.0), least: Some(2.0), most: Some(4.0) };
        assert_eq!(both.margins(3.0).collect::<Vec<_>>(), [0.25, 0.25]);
        assert_eq!(both.margins(5.0).collect::<Vec<_>>(), [0.75, -0.25]);
        let variable = "finger.back.base_mm[0]=-36:-24".parse::<Variable>().expect("a variable");
        assert_eq!((variable.key.as_str(), variable.least, variable.most), ("finger.back.base_mm.0", -36.0, -24.0));
        assert!("a=2:1".parse::<Variable>().is_err() && "a=1".parse::<Variable>().is_err());
    }
}
