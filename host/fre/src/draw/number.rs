//! Numbers in pictures: digits that say something, true minus signs.

/// So many decimals; of a small value as many as show three digits, below 1e−4 with a power of ten: what is not zero does
/// not read as zero.
pub fn significant(value: f64, decimals: usize) -> String {
    let size = value.abs();
    let text = if !(size > 0.0 && size.is_finite()) || size >= 10_f64.powi(1 - decimals as i32) {
        format!("{value:.decimals$}")
    } else if size >= 1e-4 {
        format!("{value:.*}", (2.0 - size.log10().floor()) as usize)
    } else {
        format!("{value:.2e}")
    };
    text.replace('-', "−")
}

/// At most so many decimals, without trailing zeros, with a true minus sign.
pub fn short(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    let text = if text == "-0" { "0" } else { text };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::significant;

    #[test]
    fn small_values_keep_their_digits() {
        let words = [6.034, 0.5, 0.0, 0.015_23, 1.5e-5, -0.02, 123.456].map(|value| significant(value, 2));
        assert_eq!(words, ["6.03", "0.50", "0.00", "0.0152", "1.50e−5", "−0.0200", "123.46"]);
        assert_eq!([0.012_34, 0.001_234].map(|value| significant(value, 3)), ["0.012", "0.00123"]);
    }
}
