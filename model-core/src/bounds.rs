//! Ranges that settings and other inputs are checked against.

/// A value outside its allowed range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfBounds {
    /// Name of the value.
    pub name: &'static str,
    /// The value.
    pub value: f64,
    /// Least and greatest allowed.
    pub allowed: [f64; 2],
}

impl core::fmt::Display for OutOfBounds {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} is {}; allowed is {} to {}", self.name, self.value, self.allowed[0], self.allowed[1])
    }
}

impl core::error::Error for OutOfBounds {}

/// Refuses a value outside its range, NaN included.
pub(crate) fn check(name: &'static str, value: f64, allowed: [f64; 2]) -> Result<(), OutOfBounds> {
    let is_within = (allowed[0]..=allowed[1]).contains(&value);
    if is_within { Ok(()) } else { Err(OutOfBounds { name, value, allowed }) }
}
