//! What the grip bears before the object slips, found in what is left of the ticks.
//!
//! A round takes the contact forces of one tick and looks at one load after another ([`Survey`]), in short steps: a tick takes as many as end
//! within half of what is left of its period, and the next tick goes on. If no time is left, it waits, and the numbers get older.
//! While the fingers rest the numbers stay what they are, and nothing is searched.

use grip::{Carry, Step};
use heapless::Vec;
use messages::{CONTACTS, FINGERS, GripMargin, Side};
use model_core::grasp::{Bears, Place, Pull, Survey, touches};

use crate::board::Board;
use crate::hand::Hand;
use crate::scheduler::Scheduler;
use crate::unit::Unit;

/// Surveys that there is room for: none where RAM is scarce, which is where there is one finger.
const ROOM: usize = if cfg!(feature = "little-ram") { 0 } else { 1 };
/// Places of contact.
const PLACES: usize = ROOM * FINGERS * CONTACTS;
/// What the first step is given, part of a second; each shows what the next one takes.
const FIRST: u32 = 4000;

/// The search, and the weight that the fingers carry.
pub(crate) struct Margins {
    survey: Vec<Survey<PLACES>, ROOM>,
    /// What was found last, and the ticks in which the places behind it, and those of the round under way, were taken.
    bears: Option<(Bears, u32)>,
    begun: u32,
    /// A finger, or a free object, has moved since then.
    has_moved: bool,
    place: Place,
    /// What a step takes at most, ticks of the cost clock.
    step: u32,
    carried: Option<Carried>,
}

/// A weight that the fingers carry, or close for.
struct Carried {
    carry: Carry,
    pull: Pull,
    /// The round under way began with all fingers at rest at their force, and ends with what follows.
    is_weighed: bool,
    /// What is borne in the weight's direction, N.
    bears: Option<f32>,
}

impl Margins {
    pub(crate) fn new() -> Self {
        Self {
            survey: Vec::new(),
            bears: None,
            begun: 0,
            has_moved: true,
            place: Place::default(),
            step: 0,
            carried: None,
        }
    }

    /// The fingers close from now on for a weight that pulls so.
    pub(crate) fn carry(&mut self, carry: Carry, pull: Pull) {
        self.carried = Some(Carried { carry, pull, is_weighed: false, bears: None });
    }

    /// What the grip bears, if that is known.
    pub(crate) fn report(&self, ticks: u32) -> Option<GripMargin> {
        let (bears, taken) = self.bears?;
        let Bears { least, direction, across, couple, slips } = bears;
        let carried = self.carried.as_ref().and_then(|carried| carried.bears);
        let age = ticks.wrapping_sub(taken).min(u32::from(u16::MAX)) as u16;
        Some(GripMargin { least, direction, across, couple, slips, carried, age })
    }

    /// A tick ends with estimates that can be trusted, or not; `place`: where a free object has come to.
    pub(crate) fn go_on<B: Board>(&mut self, hand: &mut Hand<'_>, scheduler: &Scheduler, is_sound: bool, place: Place) {
        // A board with room for one finger holds nothing between two.
        if B::FINGERS < 2 {
            return;
        }
        if !is_sound {
            self.bears = None;
            self.survey.clear();
        }
        let rests = self.mind_fingers(hand);
        let moves = |unit: &Unit<'_>| unit.mount.is_some() && !unit.has_rested();
        self.has_moved |= place != self.place || hand.units.iter().any(moves);
        self.place = place;
        if !is_sound {
            return;
        }
        if self.survey.is_empty() {
            // There is room for one.
            let _ = self.survey.push(Survey::new());
        }
        let Some(survey) = self.survey.first_mut() else { return };
        let weighs = match &mut self.carried {
            // A round under way is given up only while the fingers wait for what follows.
            Some(carried) => {
                let is_due = !carried.carry.is_enough() || (survey.is_idle() && self.has_moved);
                let begins = rests && !carried.is_weighed && is_due;
                carried.is_weighed &= rests;
                begins
            }
            None => false,
        };
        if !weighs
            && survey.is_idle()
            && !self.has_moved
            && let Some((_, taken)) = &mut self.bears
        {
            *taken = scheduler.ticks;
            return;
        }
        if weighs || survey.is_idle() {
            let asked = self.carried.as_ref().map(|carried| carried.pull);
            if !begin(survey, &hand.units, asked, place) {
                self.bears = None;
                self.survey.clear();
                return;
            }
            (self.begun, self.has_moved) = (scheduler.ticks, false);
            if let Some(carried) = &mut self.carried {
                carried.is_weighed = weighs;
            }
        }
        self.steps(scheduler.left::<B>() / 2, B::COST_HZ / FIRST, B::cost_ticks);
        self.weigh(hand);
    }

    /// Ends what one of the fingers does not take part in any more. Whether all that carry a weight rest at their force.
    fn mind_fingers(&mut self, hand: &mut Hand<'_>) -> bool {
        if self.carried.is_none() {
            return false;
        }
        let mut fingers = hand.units.iter().filter(|unit| unit.mount.is_some());
        if fingers.clone().all(|unit| unit.grip.carries()) {
            return fingers.all(|unit| unit.grip.is_there());
        }
        self.end_carry(hand);
        false
    }

    /// The fingers close for no weight any more: those that still grip keep what they have.
    pub(crate) fn end_carry(&mut self, hand: &mut Hand<'_>) {
        hand.units.iter_mut().for_each(|unit| unit.grip.keep());
        self.carried = None;
    }

    /// One step of a round under way, if it ends within what is left of the period: for a gripper that waits for another master. Whether it took
    /// one.
    pub(crate) fn search<B: Board>(&mut self, scheduler: &Scheduler) -> bool {
        // As in `go_on`. Without this the image of a board with room for one finger has all of the search in it.
        if B::FINGERS < 2 {
            return false;
        }
        let mut now = B::cost_ticks();
        self.step(scheduler.left::<B>(), B::COST_HZ / FIRST, &mut now, B::cost_ticks)
    }

    /// As many steps as end within so many ticks of a clock; the first of all steps takes `first` at most.
    fn steps(&mut self, allowed: u64, first: u32, clock: impl Fn() -> u32) {
        let begin = clock();
        let mut now = begin;
        while self.step(allowed.saturating_sub(u64::from(now.wrapping_sub(begin))), first, &mut now, &clock) {}
    }

    /// One step, if there is one and it ends within so many ticks of a clock. `now` is the clock's last reading.
    fn step(&mut self, allowed: u64, first: u32, now: &mut u32, clock: impl Fn() -> u32) -> bool {
        let Some(survey) = self.survey.first_mut().filter(|survey| !survey.is_idle()) else { return false };
        let next = if self.step == 0 { first } else { self.step };
        if u64::from(next) > allowed {
            return false;
        }
        if let Some(bears) = survey.step() {
            self.bears = Some((bears, self.begun));
        }
        let after = clock();
        // One that was interrupted is forgotten after a while.
        self.step = (self.step - self.step / 64).max(after.wrapping_sub(*now));
        *now = after;
        true
    }

    /// Gives the fingers the force that follows from what they bear.
    fn weigh(&mut self, hand: &mut Hand<'_>) {
        let load = self.survey.first().and_then(Survey::load);
        let Some((carried, load)) = self.carried.as_mut().zip(load) else { return };
        carried.bears = Some(load);
        if !core::mem::take(&mut carried.is_weighed) {
            return;
        }
        let step = carried.carry.weigh(f64::from(load));
        for unit in hand.units.iter_mut().filter(|unit| unit.mount.is_some()) {
            match step {
                Step::Enough => unit.grip.keep(),
                Step::Press(force) => {
                    unit.grip.press(force);
                    unit.restrict();
                }
                Step::Most => unit.grip.give_up(),
            }
        }
        if step == Step::Most {
            self.carried = None;
        }
    }
}

/// Begins a round with the places where the fingers touch now. Returns false if the object has no reference point, or if the places are
/// too many.
fn begin(survey: &mut Survey<PLACES>, units: &[Unit<'_>], asked: Option<Pull>, place: Place) -> bool {
    let reference = |unit: &Unit<'_>| {
        let mirrored = unit.mount?.side == Side::Right;
        let (middle, reach) = place.seen(unit.model.object()?, mirrored).reference()?;
        Some((mirrored, middle, reach))
    };
    let mut is_begun = false;
    for (finger, unit) in units.iter().enumerate().filter(|(_, unit)| unit.mount.is_some()) {
        let Some((mirrored, middle, reach)) = reference(unit) else { return false };
        if !core::mem::replace(&mut is_begun, true) {
            // The object is the same for all.
            survey.begin(reach, asked);
        }
        let force = unit.last.estimate.force_magnitude();
        if !survey.take_places(touches(unit.model.follower(), finger, mirrored, middle, force)) {
            return false;
        }
    }
    is_begun
}

#[cfg(test)]
mod tests {
    use core::cell::Cell;

    use model_core::grasp::Touch;

    use super::*;

    /// Whatever is left of the ticks, a round ends over them, and none takes more than it is allowed.
    #[test]
    fn a_search_takes_no_more_than_it_is_allowed_and_goes_on() {
        let mut margins = Margins::new();
        let place =
            |finger, x: f32| Touch { finger, point: [x, 0.0], normal: [-x / 20.0, 0.0], force: 5.0, friction: 0.6 };
        let mut survey = Survey::new();
        survey.begin(20.0, None);
        assert!(survey.take_places([place(0, -20.0), place(1, 20.0)].into_iter()));
        assert!(margins.survey.push(survey).is_ok());
        // A clock that wraps meanwhile; a step takes 60 to 100 of its ticks.
        let now = Cell::new(u32::MAX - 5000);
        let clock = || {
            now.set(now.get().wrapping_add(60 + now.get() % 41));
            now.get()
        };
        let mut ticks = 0;
        while margins.bears.is_none() {
            ticks += 1;
            let allowed = [0, 90, 350, 1000][ticks % 4];
            let before = now.get();
            margins.steps(allowed, 100, clock);
            // The first reading of the clock belongs to no step.
            let spent = u64::from(now.get().wrapping_sub(before)).saturating_sub(100);
            assert!(spent <= allowed, "{spent} of {allowed} in tick {ticks}");
            assert!(ticks < 10_000, "it never ends");
        }
        let (bears, taken) = margins.bears.expect("found");
        assert!(taken == 0 && (bears.across - 6.0).abs() < 1e-2 && ticks > 10, "{bears:?} after {ticks} ticks");
        assert_eq!(margins.report(ticks as u32).map(|margin| margin.age), Some(ticks as u16));
    }
}
