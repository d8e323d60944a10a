//! Mean and largest of a count.

/// Mean and largest of a count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    pub mean: f64,
    pub max: f64,
}

impl Spread {
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let (mut sum, mut max, mut count) = (0.0, 0.0_f64, 0);
        for value in values {
            sum += value;
            max = max.max(value);
            count += 1;
        }
        Self { mean: if count == 0 { 0.0 } else { sum / f64::from(count) }, max }
    }
}
