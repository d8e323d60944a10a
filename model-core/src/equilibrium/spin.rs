//! An object that turns in the world while the finger moves: a cylinder about its axis.

use super::moved::Moved;
use crate::real::Real;

/// How an object turns.
#[derive(Clone, Copy)]
pub(super) struct Spin<T> {
    /// About which point, world frame, mm.
    pub about: [T; 2],
    /// By how much per unit of the motion's coordinate, rad, counter-clockwise.
    pub rate: T,
}

impl<T: Real> Spin<T> {
    /// It does not turn.
    pub const NONE: Self = Self { about: [T::ZERO; 2], rate: T::ZERO };

    pub fn is_none(&self) -> bool {
        self.rate == T::ZERO
    }

    /// How it moves along a way.
    pub fn moved(&self, way: T) -> Moved<T> {
        Moved { about: self.about, turn: self.rate * way, shift: [T::ZERO; 2] }
    }
}

#[cfg(test)]
mod tests {
    use std::boxed::Box;

    use crate::discretise::{Discretisation, Physics};
    use crate::equilibrium::{Follower, SlipWay};
    use crate::object::{Motion, ObjectDesign};
    use crate::size::Rubbing;

    const CENTRE: [f64; 2] = [41.0, 45.0];
    const DEGREE: f64 = core::f64::consts::PI / 180.0;

    fn finger(motion: Motion) -> Box<Follower<f64, Rubbing>> {
        let mut follower: Box<Follower<f64, Rubbing>> = Box::new(Follower::EMPTY);
        let design = crate::design::ladder_80();
        follower.configure(&design, &Discretisation::estimator(Physics::Extended)).expect("a valid finger");
        follower.set_object(ObjectDesign::Circle { centre: CENTRE, radius: 40.0 }, motion);
        follower.set_friction(0.6).expect("in range");
        follower
    }

    /// Force and torque at the end of a way in small steps, with the object turning at a rate.
    fn closed(motion: Motion, last: f64, rate: f64) -> [f64; 3] {
        let mut follower = finger(motion);
        follower.spin_object(CENTRE, rate).expect("allowed");
        follower.start(0.0);
        for k in 0..=80 {
            assert!(follower.follow(last * f64::from(k) / 80.0).status.is_trustworthy());
        }
        let [x, y] = follower.solution().force_world();
        [x, y, follower.solution().motor_torque()]
    }

    /// The same where everything slips one way.
    fn slipping(motion: Motion, last: f64, way: SlipWay) -> [f64; 3] {
        let mut follower = finger(motion);
        follower.force_slip(Some(way));
        follower.start(0.0);
        assert!(follower.follow(last).status.is_trustworthy());
        let [x, y] = follower.solution().force_world();
        [x, y, follower.solution().motor_torque()]
    }

    /// A cylinder that turns fast one way drags everything along one way, whatever the finger does: closing slip and opening slip, of bases that
    /// turn and that are moved along a line.
    #[test]
    fn a_cylinder_that_turns_decides_which_way_everything_slips() {
        let axis = crate::design::ladder_80().motor_axis;
        for (motion, last, fast) in
            [(Motion::Rotating { axis }, 8.0 * DEGREE, 30.0), (Motion::Translating { direction: [1.0, 0.0] }, 6.0, 0.3)]
        {
            let [closing, opening] = [SlipWay::Closing, SlipWay::Opening].map(|way| slipping(motion, last, way));
            // Clockwise, the side at the finger goes towards its tip.
            for (rate, expected) in [(-fast, closing), (fast, opening)] {
                let found = closed(motion, last, rate);
                for (found, expected) in found.iter().zip(expected) {
                    assert!(
                        (found - expected).abs() < 2e-3 * expected.abs().max(1.0),
                        "{motion:?} {rate}: {found} {expected}"
                    );
                }
            }
            assert!(opening[1] - closing[1] > 1.0 || closing[1] - opening[1] > 1.0, "{closing:?} {opening:?}");
        }
    }

    #[test]
    fn a_rate_out_of_range_is_refused() {
        let mut follower = finger(Motion::Translating { direction: [1.0, 0.0] });
        assert!(follower.spin_object(CENTRE, f64::NAN).is_err() && follower.spin_object([1e4, 0.0], 0.0).is_err());
    }
}
