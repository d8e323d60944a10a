//! How hard fingers press to bear a weight: harder step by step, until what the grip bears is enough.

/// The first force, N: enough to be felt on every finger.
const FIRST: f64 = 0.2;
/// How much harder a step presses, at least and at most.
const HARDER: (f64, f64) = (1.05, 2.0);
/// What a step aims at beyond what is needed, as a part of that.
const BEYOND: f64 = 0.02;
/// Below this part of what is needed fingers that had enough press harder again: what they bear ripples by less.
const LEAST: f64 = 0.95;

/// A weight that fingers are to bear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carry {
    /// Load that the grip is to bear, N.
    needed: f64,
    /// Greatest force of each finger, N.
    most: f64,
    /// Force that each finger is asked for, N.
    force: f64,
    is_enough: bool,
}

/// What follows from what a grip bears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// It is enough.
    Enough,
    /// Each finger is to press so hard, N.
    Press(f64),
    /// It is not enough, and the fingers press as hard as they may.
    Most,
}

impl Carry {
    /// A load that is to be borne, each finger's greatest force, both positive, and what the fingers press with already, N: it is never less
    /// before the weight is borne.
    pub fn new(needed: f64, most: f64, present: f64) -> Self {
        Self { needed, most, force: FIRST.max(present).min(most), is_enough: false }
    }

    /// The force that each finger is asked for, N.
    pub fn force(&self) -> f64 {
        self.force
    }

    /// The last weighing was enough.
    pub fn is_enough(&self) -> bool {
        self.is_enough
    }

    /// Every finger rests at its force, and together they bear so much, N.
    pub fn weigh(&mut self, bears: f64) -> Step {
        let least = if self.is_enough { LEAST } else { 1.0 };
        self.is_enough = bears >= least * self.needed;
        if self.is_enough {
            return Step::Enough;
        }
        if self.force >= self.most {
            return Step::Most;
        }
        // What a grip bears grows with its forces; where nothing is borne yet, nobody knows how.
        let wanted = if bears > 0.0 { (1.0 + BEYOND) * self.needed / bears } else { f64::INFINITY };
        self.force = (self.force * wanted.max(HARDER.0).min(HARDER.1)).min(self.most);
        Step::Press(self.force)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Presses until it is enough, with what is borne at a force; the forces.
    fn press(mut carry: Carry, bears: impl Fn(f64) -> f64) -> (Vec<f64>, Step) {
        let mut forces = vec![carry.force()];
        loop {
            match carry.weigh(bears(carry.force())) {
                Step::Press(force) => forces.push(force),
                step => return (forces, step),
            }
        }
    }

    #[test]
    fn the_force_grows_until_it_is_enough_and_hardly_beyond() {
        let (forces, step) = press(Carry::new(6.0, 15.0, 0.0), |force| 1.2 * force);
        assert_eq!(step, Step::Enough);
        assert!(forces.windows(2).all(|pair| pair[1] >= 1.05 * pair[0] - 1e-12 && pair[1] <= 2.0 * pair[0] + 1e-12));
        let last = forces.last().unwrap();
        assert!(1.2 * last >= 6.0 && 1.2 * last <= 6.0 * 1.06 && forces.len() <= 7, "{forces:?}");
    }

    #[test]
    fn a_weight_that_is_too_heavy_ends_at_the_limit() {
        let (forces, step) = press(Carry::new(60.0, 15.0, 0.0), |force| 1.2 * force);
        assert_eq!((forces.last(), step), (Some(&15.0), Step::Most));
        // Nothing is borne without friction, and what is not a number is nothing.
        assert_eq!(press(Carry::new(1.0, 0.1, 0.0), |_| 0.0), (vec![0.1], Step::Most));
        assert_eq!(press(Carry::new(1.0, 2.0, 0.0), |_| f64::NAN).1, Step::Most);
    }

    #[test]
    fn what_is_held_already_is_not_let_go() {
        assert_eq!(Carry::new(6.0, 15.0, 4.0).force(), 4.0);
        assert_eq!(press(Carry::new(3.0, 15.0, 4.0), |force| 1.2 * force), (vec![4.0], Step::Enough));
        assert_eq!(Carry::new(6.0, 3.0, 4.0).force(), 3.0);
    }

    #[test]
    fn fingers_that_had_enough_press_harder_only_when_they_clearly_bear_less() {
        let mut carry = Carry::new(2.0, 15.0, 0.0);
        assert_eq!((carry.weigh(2.1), carry.weigh(1.95)), (Step::Enough, Step::Enough));
        assert!(matches!(carry.weigh(1.8), Step::Press(_)) && !carry.is_enough());
        // Then all of it again.
        assert!(matches!(carry.weigh(1.95), Step::Press(_)));
        assert_eq!(carry.weigh(2.0), Step::Enough);
    }
}
