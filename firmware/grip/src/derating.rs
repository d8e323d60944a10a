//! Heat and a poor supply: how near a servo is to what shuts it down, and what its finger may still do.
//!
//! The reserve is what is left of a margin below the Temperature Limit or above the Min Voltage Limit: 1 at the margin's beginning, 0 at
//! the limit. Below 1 the finger is warned, below ½ its force is limited, down to half of it, and below 0.15 it is stopped. The servo
//! itself shuts down at 0, and drops what it holds.

use crate::Why;

/// What a finger's servo comes near: what shuts it down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Strain {
    /// Its Temperature Limit.
    Heat,
    /// Its Min Voltage Limit.
    Supply,
}

/// What a finger may do while its servo is under strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Derating {
    /// Everything.
    Free,
    /// Everything still: a warning.
    Warned,
    /// Less force, the less the nearer it comes.
    Limited,
    /// It neither closes nor grips: it holds, or it opens, as [`crate::Faults::strain`] says.
    Stopped,
}

/// Reserves below which a finger is warned, limited and stopped.
const WARN: f64 = 1.0;
const LIMIT: f64 = 0.5;
const STOP: f64 = 0.15;
/// The part of the force that is left just before it is stopped.
const LEAST: f64 = 0.5;
/// By how much more the reserve has to be before the finger may do more again.
const AGAIN: f64 = 0.1;

/// What a servo says of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Vitals {
    /// Temperature inside, °C.
    pub temperature: u8,
    /// Supply, 0.1 V.
    pub voltage: u16,
}

/// Where it shuts down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Temperature Limit, °C.
    pub temperature: u8,
    /// Min Voltage Limit, 0.1 V.
    pub voltage: u16,
}

/// How far from where a servo shuts down its finger is warned; 0: that is not minded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Below the Temperature Limit, K.
    pub heat: f64,
    /// Above the Min Voltage Limit, V.
    pub supply: f64,
}

/// Watches a servo's heat and supply.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrainWatch {
    derating: Derating,
    strain: Strain,
    /// Part of the force that is left.
    part: f64,
    /// The last look asked for less than the finger may do: a single one may be a dip.
    is_doubted: bool,
}

impl StrainWatch {
    /// Nothing is wrong.
    pub const FREE: Self = Self { derating: Derating::Free, strain: Strain::Heat, part: 1.0, is_doubted: false };

    /// Takes what the servo says; what the finger may do, and because of what, if that has changed.
    pub fn see(&mut self, vitals: Vitals, bounds: Bounds, margins: Margins) -> Option<(Derating, Strain)> {
        let heat = reserve(f64::from(bounds.temperature) - f64::from(vitals.temperature), margins.heat);
        let supply = reserve((f64::from(vitals.voltage) - f64::from(bounds.voltage)) / 10.0, margins.supply);
        let (reserve, strain) = if supply < heat { (supply, Strain::Supply) } else { (heat, Strain::Heat) };
        let before = self.derating;
        // More only with some way to the threshold, so that it does not change to and fro.
        let (now, later) = (of(reserve), of(reserve - AGAIN));
        let next = if now > before { now } else { later.min(before) };
        let is_worse = next > before || (next == Derating::Limited && left(reserve) < self.part);
        if is_worse && !core::mem::replace(&mut self.is_doubted, true) {
            return None;
        }
        self.is_doubted = false;
        self.part = match next {
            Derating::Free | Derating::Warned => 1.0,
            Derating::Limited | Derating::Stopped => left(reserve),
        };
        if next > Derating::Free {
            self.strain = strain;
        }
        self.derating = next;
        (next != before).then_some((next, self.strain))
    }

    /// The part of its force that a finger may use.
    pub fn part(&self) -> f64 {
        self.part
    }

    /// Why it may neither close nor grip, if so.
    pub fn stops(&self) -> Option<Why> {
        (self.derating == Derating::Stopped).then_some(match self.strain {
            Strain::Heat => Why::Heat,
            Strain::Supply => Why::Supply,
        })
    }
}

/// What is left of a margin; plenty if there is none.
fn reserve(left: f64, margin: f64) -> f64 {
    if margin > 0.0 { left / margin } else { f64::INFINITY }
}

/// What a finger may do with a reserve.
fn of(reserve: f64) -> Derating {
    if reserve <= STOP {
        Derating::Stopped
    } else if reserve <= LIMIT {
        Derating::Limited
    } else if reserve <= WARN {
        Derating::Warned
    } else {
        Derating::Free
    }
}

/// The part of the force that is left with a reserve.
fn left(reserve: f64) -> f64 {
    let way = ((reserve - STOP) / (LIMIT - STOP)).clamp(0.0, 1.0);
    LEAST + (1.0 - LEAST) * way
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Bounds = Bounds { temperature: 80, voltage: 95 };

    fn look(watch: &mut StrainWatch, temperature: u8, voltage: u16) -> Option<(Derating, Strain)> {
        watch.see(Vitals { temperature, voltage }, BOUNDS, Margins { heat: 20.0, supply: 1.0 })
    }

    /// Two looks: the first may be a dip.
    fn twice(watch: &mut StrainWatch, temperature: u8, voltage: u16) -> Option<(Derating, Strain)> {
        look(watch, temperature, voltage).or_else(|| look(watch, temperature, voltage))
    }

    #[test]
    fn heat_warns_limits_and_stops() {
        let mut watch = StrainWatch::FREE;
        assert_eq!(twice(&mut watch, 59, 120), None);
        assert_eq!(twice(&mut watch, 60, 120), Some((Derating::Warned, Strain::Heat)));
        assert_eq!((watch.part(), watch.stops()), (1.0, None));
        assert_eq!(twice(&mut watch, 70, 120), Some((Derating::Limited, Strain::Heat)));
        assert_eq!(watch.part(), 1.0);
        assert_eq!(twice(&mut watch, 74, 120), None);
        assert!((watch.part() - (0.5 + 0.5 * 3.0 / 7.0)).abs() < 1e-12, "{}", watch.part());
        assert_eq!(twice(&mut watch, 77, 120), Some((Derating::Stopped, Strain::Heat)));
        assert_eq!((watch.part(), watch.stops()), (0.5, Some(Why::Heat)));
        // Back, with some way to each threshold.
        assert_eq!(look(&mut watch, 76, 120), None);
        assert_eq!(look(&mut watch, 74, 120), Some((Derating::Limited, Strain::Heat)));
        assert_eq!(look(&mut watch, 69, 120), None);
        assert_eq!(look(&mut watch, 67, 120), Some((Derating::Warned, Strain::Heat)));
        assert_eq!(look(&mut watch, 58, 120), None);
        assert_eq!(look(&mut watch, 57, 120), Some((Derating::Free, Strain::Heat)));
    }

    #[test]
    fn a_poor_supply_does_too_and_a_dip_does_not() {
        let mut watch = StrainWatch::FREE;
        assert_eq!(look(&mut watch, 30, 80), None);
        assert_eq!(look(&mut watch, 30, 120), None);
        assert_eq!((watch.part(), watch.stops()), (1.0, None));
        assert_eq!(twice(&mut watch, 30, 96), Some((Derating::Stopped, Strain::Supply)));
        assert_eq!(watch.stops(), Some(Why::Supply));
        assert_eq!(look(&mut watch, 30, 120), Some((Derating::Free, Strain::Supply)));
    }

    #[test]
    fn what_has_no_margin_is_not_minded() {
        let none = Margins { heat: 0.0, supply: 0.0 };
        let mut watch = StrainWatch::FREE;
        for _ in 0..3 {
            assert_eq!(watch.see(Vitals { temperature: 99, voltage: 50 }, BOUNDS, none), None);
        }
        assert_eq!((watch.part(), watch.stops()), (1.0, None));
    }
}
