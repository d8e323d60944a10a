//! What is varied: a key or the resolution, with its values.

use model_core::discretise::Elements;

use super::error::SweepError;

/// The most values of one list.
const MOST_VALUES: usize = 100_000;

/// Values along one direction of the grid.
#[derive(Clone, Debug, PartialEq)]
pub enum Axis {
    /// A number of the case.
    Key {
        /// Its dotted key.
        key: String,
        /// Its values, in the file's unit.
        values: Vec<f64>,
    },
    /// The resolution.
    Elements(Vec<(String, Elements)>),
}

impl Axis {
    /// Reads `KEY=VALUES`; `elements` reads one resolution.
    ///
    /// # Errors
    /// What is wrong with it and what is allowed.
    pub fn parse(text: &str, elements: impl Fn(&str) -> Result<Elements, String>) -> Result<Self, SweepError> {
        let wrong = |reason: String| SweepError::Vary { text: text.to_owned(), reason };
        let Some((key, values)) = text.split_once('=') else {
            return Err(wrong("allowed is KEY=A:B:STEP or KEY=v1,v2,…".to_owned()));
        };
        let key = key.trim();
        if key == "elements" {
            let one = |word: &str| elements(word.trim()).map(|found| (word.trim().to_owned(), found));
            let found: Result<Vec<_>, _> = values.split(',').map(one).collect();
            return Ok(Self::Elements(found.map_err(wrong)?));
        }
        Ok(Self::Key { key: key.to_owned(), values: numbers(values).map_err(wrong)? })
    }

    /// Its column in the results, which is its key.
    pub fn name(&self) -> &str {
        match self {
            Self::Key { key, .. } => key,
            Self::Elements(_) => "elements",
        }
    }

    /// Number of its values.
    pub fn len(&self) -> usize {
        match self {
            Self::Key { values, .. } => values.len(),
            Self::Elements(values) => values.len(),
        }
    }

    /// True without values; [`Axis::parse`] makes none such.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A value as written in the results.
    pub fn words(&self, index: usize) -> String {
        match self {
            Self::Key { values, .. } => values.get(index).map_or_else(String::new, f64::to_string),
            Self::Elements(values) => values.get(index).map_or_else(String::new, |(word, _)| word.clone()),
        }
    }
}

/// Reads numbers and ranges `A:B:STEP` (both ends included where the step meets them), separated by commas.
///
/// # Errors
/// What is wrong and what is allowed.
pub fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |text: &str| match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("\"{text}\" is not a finite number; allowed is A:B:STEP or v1,v2,…")),
    };
    let mut values = Vec::new();
    for part in text.split(',') {
        let ends: Vec<f64> = part.split(':').map(number).collect::<Result<_, _>>()?;
        match ends[..] {
            [value] => values.push(value),
            [from, to, step] => {
                let count = (to - from) / step;
                if step == 0.0 || count < 0.0 {
                    return Err(format!("{part} never reaches its end; needed is a step towards it, not 0"));
                }
                if count >= MOST_VALUES as f64 {
                    return Err(format!("{part} has too many values; allowed are {MOST_VALUES}"));
                }
                // A ten-millionth of a step is rounding, not meaning.
                let last = (count + 1e-7).floor() as usize;
                values.extend((0..=last).map(|i| rounded(from + step * i as f64, from.abs().max(to.abs()))));
            }
            _ => return Err(format!("{part} is not a range; allowed is A:B:STEP")),
        }
        if values.len() > MOST_VALUES {
            return Err(format!("has too many values; allowed are {MOST_VALUES}"));
        }
    }
    Ok(values)
}

/// Takes away the rounding of a product: 0.3 instead of 0.30000000000000004. `size` is the range's.
fn rounded(value: f64, size: f64) -> f64 {
    if value.abs() < 1e-12 * size {
        return 0.0;
    }
    format!("{value:.12e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use model_core::discretise::Elements;

    use super::{Axis, numbers};

    #[test]
    fn ranges_include_their_ends_and_print_short() {
        assert_eq!(numbers("20:60:20").unwrap(), [20.0, 40.0, 60.0]);
        assert_eq!(numbers("0:1:0.4").unwrap(), [0.0, 0.4, 0.8]);
        let words: Vec<String> = numbers("-0.3:0.3:0.1").unwrap().iter().map(f64::to_string).collect();
        assert_eq!(words, ["-0.3", "-0.2", "-0.1", "0", "0.1", "0.2", "0.3"]);
        assert_eq!(numbers("0:2:1,2:0:-1").unwrap(), [0.0, 1.0, 2.0, 2.0, 1.0, 0.0]);
        assert_eq!(numbers("3, 1e-3").unwrap(), [3.0, 1e-3]);
        assert_eq!(numbers("5:5:1").unwrap(), [5.0]);
    }

    #[test]
    fn nonsense_is_refused_with_a_reason() {
        let bad =
            ["", "1,,2", "a", "nan", "1:inf:1", "1:2", "1:2:3:4", "1:2:0", "1:2:-1", "0:1:1e-9", "0:1e300:1e-300"];
        let said: String = bad.iter().map(|text| format!("{}\n", numbers(text).unwrap_err())).collect();
        snapbox::assert_data_eq!(
            said,
            snapbox::str![[r#"
"" is not a finite number; allowed is A:B:STEP or v1,v2,…
"" is not a finite number; allowed is A:B:STEP or v1,v2,…
"a" is not a finite number; allowed is A:B:STEP or v1,v2,…
"nan" is not a finite number; allowed is A:B:STEP or v1,v2,…
"inf" is not a finite number; allowed is A:B:STEP or v1,v2,…
1:2 is not a range; allowed is A:B:STEP
1:2:3:4 is not a range; allowed is A:B:STEP
1:2:0 never reaches its end; needed is a step towards it, not 0
1:2:-1 never reaches its end; needed is a step towards it, not 0
0:1:1e-9 has too many values; allowed are 100000
0:1e300:1e-300 has too many values; allowed are 100000

"#]]
        );
    }

    #[test]
    fn an_axis_is_a_key_or_the_resolution() {
        let elements = |word: &str| match word {
            "paper" => Ok(Elements::PAPER),
            _ => Err("allowed is paper".to_owned()),
        };
        let axis = Axis::parse("elements=paper, paper", elements).unwrap();
        assert_eq!((axis.name(), axis.len(), axis.words(1).as_str()), ("elements", 2, "paper"));
        let error = Axis::parse("elements=48", elements).unwrap_err().to_string();
        assert_eq!(error, "--vary elements=48: allowed is paper");
        let axis = Axis::parse("object.radius_mm=1.50,2", elements).unwrap();
        assert_eq!((axis.name(), axis.words(0).as_str()), ("object.radius_mm", "1.5"));
        snapbox::assert_data_eq!(
            Axis::parse("radius", elements).unwrap_err().to_string(),
            snapbox::str!["--vary radius: allowed is KEY=A:B:STEP or KEY=v1,v2,…"]
        );
    }
}
