//! Single-precision numbers in JSON without loss: read back, each is the same bit for bit (NaN stays NaN).

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::value::RawValue;

/// A number. What JSON has no number for is a text: "NaN", "inf", "-inf".
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Exact(pub(super) f32);

/// An angle in rad, written in degrees.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Degrees(pub(super) f32);

/// A slope per rad, written per degree.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PerDegree(pub(super) f32);

impl Exact {
    pub(super) fn is_nan(&self) -> bool {
        self.0.is_nan()
    }
}

impl Serialize for Exact {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        if self.0.is_finite() { to.serialize_f32(self.0) } else { to.collect_str(&self.0) }
    }
}

impl<'de> Deserialize<'de> for Exact {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        // From the digits to single precision at once: by way of double precision, a number may be rounded twice.
        digits(from)?.parse().map(Self).map_err(D::Error::custom)
    }
}

fn digits<'de, D: Deserializer<'de>>(from: D) -> Result<&'de str, D::Error> {
    Ok(<&RawValue>::deserialize(from)?.get().trim_matches('"'))
}

/// Writes a number in another unit: in single precision if that leads back to the same number, in double otherwise.
fn write<S: Serializer>(to: S, number: f32, there: fn(f64) -> f64, back: fn(f64) -> f64) -> Result<S::Ok, S::Error> {
    if !number.is_finite() {
        return to.collect_str(&number);
    }
    let exact = there(f64::from(number));
    let short = exact as f32;
    // The digits that are written stand for another double than the short number itself: they are what is tried.
    let digits = serde_json::to_string(&short).unwrap_or_default();
    let leads_back = || digits.parse::<f64>().is_ok_and(|read| (back(read) as f32).to_bits() == number.to_bits());
    if short.is_finite() && leads_back() { to.serialize_f32(short) } else { to.serialize_f64(exact) }
}

fn read<'de, D: Deserializer<'de>>(from: D, back: fn(f64) -> f64) -> Result<f32, D::Error> {
    let number: f64 = digits(from)?.parse().map_err(D::Error::custom)?;
    Ok(back(number) as f32)
}

impl Serialize for Degrees {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        write(to, self.0, f64::to_degrees, f64::to_radians)
    }
}

impl<'de> Deserialize<'de> for Degrees {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        read(from, f64::to_radians).map(Self)
    }
}

impl Serialize for PerDegree {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        write(to, self.0, f64::to_radians, f64::to_degrees)
    }
}

impl<'de> Deserialize<'de> for PerDegree {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        read(from, f64::to_degrees).map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{RngCore, SeedableRng};

    fn same(before: f32, after: f32) -> bool {
        before.to_bits() == after.to_bits() || (before.is_nan() && after.is_nan())
    }

    #[test]
    fn every_number_comes_back_bit_for_bit() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let special = [0.0, -0.0, f32::MAX, f32::MIN_POSITIVE, 1e-40, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
        let any = (0..300_000).map(|_| f32::from_bits(random.next_u32()));
        for number in special.into_iter().chain(any) {
            let text = serde_json::to_string(&(Exact(number), Degrees(number), PerDegree(number))).unwrap();
            let (Exact(plain), Degrees(angle), PerDegree(slope)) = serde_json::from_str(&text).unwrap();
            assert!(same(number, plain) && same(number, angle) && same(number, slope), "{number:e}: {text}");
        }
    }

    #[test]
    fn angles_are_short_in_degrees() {
        let count = 107.0 * std::f32::consts::TAU / 4096.0;
        let text = serde_json::to_string(&Degrees(count)).unwrap();
        assert!(text.len() <= 11 && text.starts_with("9.404"), "{text}");
    }
}
