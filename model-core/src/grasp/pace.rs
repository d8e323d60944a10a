//! How the object moves with the fingers, with friction: its step per unit of each finger's way.

use super::MAX_FINGERS;
use super::slope::{dot, learn};

/// What the last steps say of the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pace {
    /// The object's step (rows: mm, mm, and the turn times the size) per rad or mm of each finger's way (columns).
    rates: [[f64; MAX_FINGERS]; 3],
    /// The ways of the last step.
    ways: [f64; MAX_FINGERS],
}

impl Pace {
    /// No step has been made yet.
    pub const UNKNOWN: Self = Self { rates: [[0.0; MAX_FINGERS]; 3], ways: [0.0; MAX_FINGERS] };

    /// The step that goes with these ways, unless the fingers turn round: then what slipped begins to stick.
    pub fn expects(&self, ways: &[f64; MAX_FINGERS]) -> Option<[f64; 3]> {
        (dot(&self.ways, ways) > 0.0).then(|| self.rates.map(|rates| dot(&rates, ways)))
    }

    /// Takes into the rates what the object's step was with these ways; without any it says nothing of them.
    pub fn learn(&mut self, ways: &[f64; MAX_FINGERS], object: &[f64; 3]) {
        learn(&mut self.rates, ways, object);
        if dot(ways, ways) > 0.0 {
            self.ways = *ways;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn two_steps_in_which_the_fingers_go_differently_tell_what_each_of_them_does() {
        let (one, other) = ([20.0, -3.0, 5.0], [-18.0, 4.0, 2.0]);
        let step = |ways: &[f64; 4]| [0, 1, 2].map(|i| ways[0] * one[i] + ways[1] * other[i]);
        let mut pace = Pace::UNKNOWN;
        let both = [1.5e-3, 1.5e-3, 0.0, 0.0];
        assert_eq!(pace.expects(&both), None);
        pace.learn(&both, &step(&both));
        assert!(near(pace.expects(&both).expect("it goes on"), step(&both)));
        let apart = [1.5e-3, -1.5e-3, 0.0, 0.0];
        pace.learn(&apart, &step(&apart));
        for ways in [[3e-3, 0.0, 0.0, 0.0], [1.5e-3, -3e-3, 0.0, 0.0]] {
            assert!(near(pace.expects(&ways).expect("it goes on"), step(&ways)), "{ways:?}");
        }
    }

    #[test]
    fn nothing_is_expected_where_the_fingers_turn_round_or_stay() {
        let mut pace = Pace::UNKNOWN;
        let ways = [1.5e-3, 0.0, 0.0, 0.0];
        pace.learn(&ways, &[0.1, 0.0, 0.0]);
        let known = pace;
        assert_eq!((pace.expects(&ways.map(|way| -way)), pace.expects(&[0.0; 4])), (None, None));
        pace.learn(&[0.0; 4], &[1.0, 0.0, 0.0]);
        assert_eq!(pace, known);
    }
}
