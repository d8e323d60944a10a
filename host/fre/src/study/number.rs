//! Numbers in tables and messages.

/// A number of decimals; what rounds to zero has no sign.
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|letter| "0.".contains(letter)) => digits.to_owned(),
        _ => text,
    }
}

/// Rounded to three decimals, without a sign where that is zero.
pub fn short(value: f64) -> f64 {
    (1e3 * value).round() / 1e3 + 0.0
}

#[cfg(test)]
mod tests {
    use super::fixed;

    #[test]
    fn what_rounds_to_zero_has_no_sign() {
        assert_eq!(
            [fixed(-4e-5, 4), fixed(-6e-5, 4), fixed(0.0, 2), fixed(-12.3, 1)],
            ["0.0000", "-0.0001", "0.00", "-12.3"]
        );
    }
}
