//! What is known of the way that a contact with friction has come, and between which values its forces lie while that is not enough.
//!
//! Friction's history follows the measured angle with a play: noise and the servo's counts, which move nothing, would otherwise pump the
//! contact from stick to slip. Single outliers do so as well in the long run, so that the play follows the median of the last angles, unless two in
//! a row show a motion that the median is too far behind of. The rest of the angle goes into the force by its derivative.
//!
//! | what is known | the forces lie |
//! |---|---|
//! | the way since the hand was open | where it leads |
//! | that it turned round by less than the backlash: the finger may have stayed | between there and where it turned |
//! | that it went back within the play: it may have turned round | between where the motion's front is and where what sticks would go back from there |
//! | nothing: the object was set while held, ticks were lost | between closing slip and opening slip |
//! | nothing, and a motion since | between slip that way and the past that it takes longest to forget, until that slips as well |

use crate::equilibrium::SlipWay;
use crate::solution::Reading;

impl Reading<f32> {
    /// This one and `part` of another.
    pub(super) fn plus(&self, part: f32, other: &Self) -> Self {
        Self {
            force: [0, 1].map(|i| self.force[i] + part * other.force[i]),
            normal: self.normal + part * other.normal,
            torque: self.torque + part * other.torque,
        }
    }

    /// This one, moved along by its slope; none where that would pull.
    pub(super) fn along(&self, way: f32, slope: &Self) -> Self {
        let moved = self.plus(way, slope);
        if moved.normal >= 0.0 { moved } else { Self::default() }
    }
}

/// A jump of the angle in one tick beyond which ticks must have been lost, rad: no servo of the family turns by that much in 2 ms.
const LEAP: f64 = core::f64::consts::PI / 180.0;

/// Angles of which the median is followed.
const LAST: usize = 5;
/// By how many plays the last angle is farther than noise from where the history was, or from the median, and the one before it from the median.
const NO_NOISE: f32 = 2.5;
const ON_THE_WAY: f32 = 1.25;

/// The way that the measured angles describe.
#[derive(Clone, Copy)]
pub(super) struct Path {
    /// There is a place, of the measured angle and of friction's history, rad.
    begun: bool,
    measured: [f64; LAST],
    at: f64,
    /// Where it was a tick ago.
    before: f64,
    /// It opens; otherwise it closes. It has moved at all, so that the measured angle was ahead of it.
    opens: bool,
    leads: bool,
    /// It has turned round since the hand was open: where, and what the forces were.
    turned: bool,
    turned_at: f64,
    turned_with: Reading<f32>,
    /// The past is unknown.
    pub unknown: bool,
    /// The follower supposes the past that the present motion takes longest to forget: of opening slip where it closes.
    pub supposed: bool,
    /// There was none that it could have begun with.
    pub gave_up: bool,
}

impl Path {
    /// None yet; all zeros.
    pub const EMPTY: Self = Self {
        begun: false,
        measured: [0.0; LAST],
        at: 0.0,
        before: 0.0,
        opens: false,
        leads: false,
        turned: false,
        turned_at: 0.0,
        turned_with: Reading { force: [0.0; 2], normal: 0.0, torque: 0.0 },
        unknown: false,
        supposed: false,
        gave_up: false,
    };

    /// Takes a measured angle; where friction's history then is, which follows with a play. All in rad. `now` are the forces where it was.
    pub fn follow(&mut self, measured: f64, play: f64, backlash: f64, now: &Reading<f32>) -> f64 {
        if !self.begun {
            (self.begun, self.measured, self.at, self.before) = (true, [measured; LAST], measured, measured);
            return measured;
        }
        let [.., last] = self.measured;
        if (measured - last).abs() > LEAP {
            self.forget();
            // Nobody knows which way.
            self.leads = false;
            (self.measured, self.at, self.before) = ([measured; LAST], measured, measured);
            return measured;
        }
        self.measured.rotate_left(1);
        if let Some(last) = self.measured.last_mut() {
            *last = measured;
        }
        self.before = self.at;
        let [low, high] = self.surely(play);
        let to = self.at.max(low - play).min(high + play);
        if to != self.at {
            let opens = to < self.at;
            if opens != self.opens {
                // A reversal within another one that is not certain yet leaves the place of that.
                if !self.is_short(backlash) {
                    (self.turned, self.turned_at, self.turned_with) = (true, self.at, *now);
                }
                (self.opens, self.supposed, self.gave_up) = (opens, false, false);
            }
            (self.at, self.leads) = (to, true);
        }
        to
    }

    /// Between which angles, rad, the finger is but for noise: where two in a row are far from where it was, or from the median on the way there,
    /// the last one; else from the median on as far as those two are.
    fn surely(&self, play: f64) -> [f64; 2] {
        let [.., before, last] = self.measured;
        let middle = median(self.measured);
        // How far each is from where the history was; single precision is enough for that.
        let [by_middle, by_before, by_last] = [middle, before, last].map(|angle| (angle - self.at) as f32);
        let plays = |count: f32| count * play as f32;
        let both = |[a, b]: [f32; 2], [least, less]: [f32; 2]| a > least && b > less || a < -least && b < -less;
        let leaves = both([by_last, by_before], [plays(NO_NOISE); 2]);
        let goes_on = both([by_last - by_middle, by_before - by_middle], [plays(NO_NOISE), plays(ON_THE_WAY)]);
        if leaves || goes_on {
            return [last; 2];
        }
        let mut ends = [(by_middle, middle); 2];
        for found in [(by_before, before), (by_last, last)] {
            if found.0 < ends[0].0 {
                ends[0] = found;
            } else if found.0 > ends[1].0 {
                ends[1] = found;
            }
        }
        ends.map(|(_, angle)| angle)
    }

    /// Takes the measured angle of an open hand, rad, which has no history and so no play: where it touches first is not found too late.
    pub fn follow_open(&mut self, measured: f64) -> Option<f64> {
        let [.., last] = self.measured;
        if !self.begun || (measured - last).abs() > LEAP {
            return None;
        }
        if measured != self.at {
            self.opens = measured < self.at;
        }
        (self.measured, self.before, self.at, self.leads) = ([measured; LAST], self.at, measured, false);
        Some(measured)
    }

    /// Where friction's history is, rad.
    pub fn at(&self) -> f64 {
        self.at
    }

    /// Friction's history has moved in this tick.
    pub fn moves(&self) -> bool {
        self.at != self.before
    }

    /// It is known which way it goes: it has moved since it began, or since ticks were lost.
    pub fn leads(&self) -> bool {
        self.leads
    }

    /// How far the motion has come, rad: ahead of friction's history by the play, up to which it may go back before that turns round. For a
    /// finger that moves with an object, whose force is not to be corrected for the play afterwards.
    pub fn front(&self, play: f64) -> f64 {
        if self.leads { self.at + self.way().sign() * play } else { self.at }
    }

    /// From the measured angle to the front of the motion, rad, where it has gone back from there.
    pub fn short_of_front(&self, play: f64) -> f64 {
        let short = -self.ahead_of(self.front(play));
        if self.leads && short * self.way().sign() > 0.0 { short } else { 0.0 }
    }

    /// The measured angle is farther behind the front than this, rad, and the one before it as well, or much farther.
    pub fn goes_back(&self, play: f64, [far, much]: [f32; 2]) -> bool {
        let [.., before, last] = self.measured;
        let behind = |angle: f64| ((self.front(play) - angle) * self.way().sign()) as f32;
        self.leads && (behind(last).min(behind(before)) > far || behind(last) > much)
    }

    /// How far the measured angle is from a place, rad.
    pub fn ahead_of(&self, place: f64) -> f64 {
        let [.., last] = self.measured;
        last - place
    }

    /// Which way it went last.
    pub fn way(&self) -> SlipWay {
        if self.opens { SlipWay::Opening } else { SlipWay::Closing }
    }

    /// It has turned round by less than so much, rad.
    fn is_short(&self, backlash: f64) -> bool {
        self.turned && (self.at - self.turned_at).abs() < backlash
    }

    /// The forces where it turned round, if the finger may not have followed yet.
    pub fn turned(&self, backlash: f64) -> Option<&Reading<f32>> {
        self.is_short(backlash).then_some(&self.turned_with)
    }

    /// The forces where it has turned round.
    pub fn turn_with(&mut self, with: &Reading<f32>) {
        self.turned_with = *with;
    }

    /// The present motion has begun at a place, rad, with the past that it takes longest to forget, and with its forces.
    pub fn suppose(&mut self, with: &Reading<f32>, at: f64) {
        (self.supposed, self.turned, self.turned_at, self.turned_with) = (true, true, at, *with);
    }

    /// The past is known, but for the finger that may not have followed yet.
    pub fn know(&mut self) {
        (self.unknown, self.supposed, self.gave_up) = (false, false, false);
    }

    /// The hand is open: the history begins anew.
    pub fn open(&mut self) {
        (self.turned, self.unknown, self.supposed, self.gave_up) = (false, false, false, false);
    }

    /// The past is unknown from here on.
    pub fn forget(&mut self) {
        (self.turned, self.unknown, self.supposed, self.gave_up) = (false, true, false, false);
    }
}

/// The middle one of some numbers.
fn median(mut of: [f64; LAST]) -> f64 {
    of.sort_unstable_by(f64::total_cmp);
    of.get(LAST / 2).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Reading<f32> = Reading { force: [3.0, 4.0], normal: 4.5, torque: 200.0 };

    #[test]
    fn noise_within_the_play_moves_nothing_and_the_rest_is_known() {
        let mut path = Path::EMPTY;
        assert_eq!(path.follow(0.1, 0.001, 0.004, &NOW), 0.1);
        for noise in [0.0009, -0.0009, 0.0005, -0.001] {
            assert_eq!((path.follow(0.1 + noise, 0.001, 0.004, &NOW), path.moves()), (0.1, false));
            assert!((path.ahead_of(path.at()) - noise).abs() < 1e-15);
        }
        path.follow(0.11, 0.001, 0.004, &NOW);
        let outlier = path.follow(0.1, 0.001, 0.004, &NOW);
        assert!((outlier - 0.1).abs() < 1e-3, "{outlier}");
        let moved = (0..5).filter(|_| path.follow(0.1025, 0.001, 0.004, &NOW) > 0.1014 && path.moves()).count();
        assert_eq!((moved, path.way()), (1, SlipWay::Closing));
    }

    /// In a motion one way the front is where the measured angle is; it goes back only after twice the play, and then by all of it.
    #[test]
    fn the_front_of_a_motion_does_not_lag() {
        let mut path = Path::EMPTY;
        let mut go = |to: f64| {
            (0..5).for_each(|_| assert!(path.follow(to, 0.001, 0.004, &NOW) > 0.0));
            path.front(0.001)
        };
        assert_eq!(go(0.1), 0.1, "nothing is known of a motion");
        assert!((go(0.105) - 0.105).abs() < 1e-12);
        assert!((go(0.104) - 0.105).abs() < 1e-12 && (go(0.1031) - 0.105).abs() < 1e-12);
        assert!((go(0.102) - 0.102).abs() < 1e-12);
    }

    #[test]
    fn a_reversal_is_short_until_it_is_longer_than_the_backlash() {
        let mut path = Path::EMPTY;
        path.follow(0.1, 0.0, 0.004, &NOW);
        let go = |path: &mut Path, to: f64, now: &Reading<f32>| {
            (0..3).for_each(|_| assert!(path.follow(to, 0.0, 0.004, now) > 0.0))
        };
        go(&mut path, 0.11, &NOW);
        assert!(path.turned(0.004).is_none(), "it has not turned round");
        go(&mut path, 0.109, &NOW);
        assert_eq!((path.turned(0.004), path.way()), (Some(&NOW), SlipWay::Opening));
        go(&mut path, 0.105, &Reading::default());
        assert_eq!(path.turned(0.004), None);
    }

    #[test]
    fn a_leap_and_a_beginning_in_the_middle_forget_the_past_and_an_open_hand_knows_it() {
        let mut path = Path::EMPTY;
        path.follow(0.1, 0.0, 0.004, &NOW);
        assert!(!path.unknown);
        path.follow(0.13, 0.0, 0.004, &NOW);
        assert!(path.unknown);
        path.open();
        assert!(!path.unknown);
    }
}
