//! How steeply the force grows with the motor angle, from the estimates themselves.
//!
//! The force of a finger that closes on an object is mostly convex in the angle, so that the chord from the first contact
//! and all secants over the last counts are at most the slope. The steepest one is the safe side for a motion towards a
//! force; a finger that judges whether it is there takes the chord and the longest secant, in which the estimate's ripple
//! (a contact that moves from sample to sample) averages out.

use heapless::Deque;

/// Points that the longest secant spans.
const POINTS: usize = 6;

/// Angles (rad) and forces (N) met on the way. The angles are counted from one of them, so that single precision resolves a small part of a
/// count wherever the motor has turned to.
#[derive(Clone, Debug)]
pub struct Slope {
    /// What the angles are counted from: the last one without contact, or else the first with it.
    origin: Option<f64>,
    /// There was no contact at the origin.
    is_free: bool,
    /// Distinct angles in contact, the oldest first.
    points: Deque<(f32, f32), POINTS>,
}

impl Slope {
    /// Nothing seen.
    pub const NONE: Self = Self { origin: None, is_free: false, points: Deque::new() };

    /// An estimate at an angle; `count` is the resolution of angles.
    pub fn see(&mut self, angle: f64, force: f64, count: f64) {
        if force <= 0.0 {
            *self = Self { origin: Some(angle), is_free: true, points: Deque::new() };
            return;
        }
        let origin = *self.origin.get_or_insert(angle);
        let (angle, force) = ((angle - origin) as f32, force as f32);
        if let Some(last) = self.points.back_mut()
            && (last.0 - angle).abs() < 0.5 * count as f32
        {
            *last = (angle, force);
            return;
        }
        if self.points.is_full() {
            self.points.pop_front();
        }
        // There is room now.
        let _ = self.points.push_back((angle, force));
    }

    /// The slope over the longest secant or the chord, N/rad, if one is positive.
    pub fn mean(&self) -> Option<f64> {
        self.steepest_to(1)
    }

    /// The steepest slope that the points show, N/rad, if one is positive.
    pub fn steepest(&self) -> Option<f64> {
        self.steepest_to(POINTS)
    }

    /// Over the chord and the secants to the first points.
    fn steepest_to(&self, points: usize) -> Option<f64> {
        let &(angle, force) = self.points.back()?;
        let chord = self.is_free.then_some((0.0, 0.0));
        let ends = self.points.iter().take(points).copied().chain(chord).filter(|(a, _)| *a != angle);
        let steepest = ends.map(|(a, f)| (force - f) / (angle - a)).fold(0.0, f32::max);
        (steepest > 0.0 && steepest.is_finite()).then_some(f64::from(steepest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_met_from_below() {
        let (count, mut slope) = (0.0015, Slope::NONE);
        for step in 0..100 {
            let angle = f64::from(step) * count;
            let way = (angle - 0.03).max(0.0);
            slope.see(angle, 100.0 * way * way, count);
            let Some(value) = slope.mean() else {
                assert!(way == 0.0);
                continue;
            };
            let true_slope = 200.0 * way;
            // The first chord has half of the slope.
            assert!(value <= true_slope * 1.001 && value >= 0.499 * true_slope, "{value} of {true_slope}");
            assert!(slope.steepest().unwrap() >= value && slope.steepest().unwrap() <= true_slope * 1.001);
            assert!(way < 15.0 * count || value > 0.8 * true_slope, "{value} of {true_slope}");
        }
    }

    /// A servo in its extended range has turned 256 times at most.
    #[test]
    fn it_is_the_same_after_many_revolutions() {
        let (count, mut slopes) = (1e-4, [Slope::NONE, Slope::NONE]);
        for step in 0..30 {
            let way = f64::from(step) * count;
            for (slope, turned) in slopes.iter_mut().zip([0.0, -1608.0]) {
                slope.see(turned + way, 1000.0 * (way - 5.0 * count).max(0.0), count);
            }
        }
        let [near, far] = slopes.map(|slope| slope.steepest().unwrap());
        assert!((near - 1000.0).abs() < 0.01 && (far - near).abs() < 0.01, "{near}, {far}");
    }

    #[test]
    fn standing_still_keeps_it_and_losing_contact_forgets_it() {
        let mut slope = Slope::NONE;
        slope.see(0.0, 0.0, 0.001);
        assert_eq!(slope.mean(), None);
        for _ in 0..20 {
            slope.see(0.1, 2.0, 0.001);
        }
        assert_eq!(slope.mean(), Some(20.0));
        slope.see(0.05, 0.0, 0.001);
        assert_eq!(slope.mean(), None);
    }
}
