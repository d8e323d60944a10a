//! What a finger's position says: its estimate, the grip that goes by it, and the report.

use grip::{Faults, Health};
use messages::{Event, Grasp, Reaction, Report, Role, Shape, Support};
use model_core::estimator::Estimate;
use model_core::status::Status;

use crate::board::Board;
use crate::device_table::YOUNG_US;
use crate::free::Free;
use crate::hand::Hand;
use crate::margin::Margins;
use crate::scheduler::Scheduler;
use crate::servo::Reading;
use crate::shared::now_us;
use crate::steps;
use crate::unit::{Pending, Unit};

/// Age of a position from which its servo counts as gone, µs.
const LOST_US: u64 = 1_000_000;

/// Estimates of all fingers, and of what they hold.
pub(crate) struct Estimation {
    /// The object, if it is free.
    free: Option<Free>,
    /// What the grip bears.
    pub(crate) margins: Margins,
    /// Reports made.
    sequence: u32,
}

impl Estimation {
    /// Of an object that is held so.
    pub(crate) fn new(support: Support) -> Self {
        Self { free: Free::of(support), margins: Margins::new(), sequence: 0 }
    }

    /// A tick begins.
    pub(crate) fn begin(&mut self, hand: &mut Hand<'_>) {
        hand.units.iter_mut().for_each(|unit| unit.is_reported = false);
        self.free.iter_mut().for_each(|free| free.begin(&hand.units));
    }

    /// Takes what holds the object besides the fingers.
    pub(crate) fn support(&mut self, hand: &mut Hand<'_>, support: Support) {
        if support == hand.settings.support {
            return;
        }
        let new = Free::of(support);
        match (&mut self.free, new) {
            // Another load on the same object.
            (Some(free), Some(new)) => free.bear(&new),
            (_, new) => {
                self.put_back(hand);
                self.free = new;
                // What waited is stale.
                hand.units.iter_mut().for_each(|unit| unit.pending = None);
            }
        }
    }

    /// A free object is where it was set.
    pub(crate) fn put_back(&mut self, hand: &mut Hand<'_>) {
        if let Some(free) = &mut self.free {
            free.put_back(&mut hand.units);
        }
    }

    /// What a finger does on a fault. While an object comes to rest it waits.
    fn on_fault(&self, hand: &Hand<'_>) -> Reaction {
        if self.free.as_ref().is_some_and(Free::settles) { Reaction::Hold } else { hand.settings.on_fault }
    }

    /// This finger's share of what is left of the period: the fingers behind want theirs too, and a free object as much as all of them.
    fn share<B: Board>(&self, hand: &Hand<'_>, scheduler: &Scheduler, finger: usize) -> u32 {
        let behind = hand.units.iter().skip(finger).filter(|unit| unit.health.is_present() && !unit.is_reported);
        let shares = behind.count().max(1) * if self.free.is_some() { 2 } else { 1 };
        let own = scheduler.left::<B>().checked_div(shares as u64).unwrap_or(0);
        u32::try_from(own).unwrap_or(u32::MAX)
    }

    /// A position came: estimates and reports.
    pub(crate) fn fresh<B: Board>(
        &mut self,
        hand: &mut Hand<'_>,
        scheduler: &Scheduler,
        finger: usize,
        reading: &Reading,
    ) {
        let left = self.share::<B>(hand, scheduler, finger);
        let Some(unit) = hand.units.get_mut(finger) else {
            return;
        };
        unit.health.answered();
        unit.seen();
        unit.alert_changed |= reading.alert != unit.alert;
        unit.alert = reading.alert;
        let seconds = unit.passed(reading);
        let angle = unit.calibration.finger_angle(reading.position);
        if self.free.as_ref().is_some_and(Free::is_carried) {
            let start = B::cost_ticks();
            unit.model.set_budget(unit.budget.iterations(left));
            if let to @ Some(_) = unit.model.head_for(angle) {
                let cost = B::cost_ticks().wrapping_sub(start);
                let estimate = Estimate { motor_angle: angle as f32, ..unit.last.estimate };
                unit.pending = Some(Pending { reading: *reading, estimate, cost, to });
                hand.shared.add(|counters| &mut counters.estimates);
                self.balance::<B>(hand, scheduler);
                return;
            }
        }
        let (estimate, cost) = steps::estimate(unit.model, &unit.budget, angle, seconds, left, B::cost_ticks);
        // Without a finger, an object or a motion an estimate costs nothing, and tells nothing of what one costs.
        if estimate.status != Status::OutOfRange && !unit.model.has_rested() {
            unit.budget.spent(cost, u32::from(estimate.iterations));
        }
        hand.shared.add(|counters| &mut counters.estimates);
        let pending = Pending { reading: *reading, estimate, cost, to: None };
        if self.free.is_some() {
            unit.pending = Some(pending);
            self.balance::<B>(hand, scheduler);
        } else {
            self.conclude::<B>(hand, scheduler, finger, &pending);
        }
    }

    /// An estimate is ready: the grip goes by it, and it is reported.
    fn conclude<B: Board>(&mut self, hand: &mut Hand<'_>, scheduler: &Scheduler, finger: usize, pending: &Pending) {
        let Pending { reading, estimate, cost, .. } = *pending;
        let seconds = scheduler.seconds();
        let given = hand.settings.faults();
        let patience = f64::from(self.free.as_ref().map_or(0, Free::patience)) * seconds;
        let faults = Faults { reaction: self.on_fault(hand), untrusted_s: given.untrusted_s.max(patience), ..given };
        let Some(unit) = hand.units.get_mut(finger) else {
            return;
        };
        let time_us = reading.at_us;
        // The age counts every tick since the last trustworthy estimate, those without a position too; and it is never less than
        // that of the position.
        unit.is_settled = estimate.age == 0;
        let age = if unit.is_settled { unit.repeats } else { unit.last.estimate.age.saturating_add(1) };
        let (position, current) = (reading.position, reading.current);
        unit.last = Report { time_us, position, current, cost, estimate: Estimate { age, ..estimate }, ..unit.last };
        if hand.settings.role == Role::Master {
            unit.feel(&reading, seconds, &faults);
            let told = unit.witness(&reading, seconds);
            if let Some(angle) = told.touched {
                hand.shared.tell(Event::Touched { finger: finger as u8, angle: angle as f32 });
            }
            if let Some(disagree) = told.disagree {
                let (finger, demanded) = (finger as u8, unit.last.estimate.torque);
                hand.shared.tell(Event::TorquesDisagree { finger, disagree, demanded, current });
            }
        }
        self.publish(hand, finger);
        if let Some(heard) = reading.heard_ticks {
            let latency = B::cost_ticks().wrapping_sub(heard);
            hand.shared.count(|counters| {
                counters.latency = latency;
                counters.latency_most = counters.latency_most.max(latency);
            });
        }
        let every = u32::from(hand.settings.shape_every);
        // In turn, so that the shapes of several fingers do not wait for one another.
        if every > 0
            && scheduler.ticks.wrapping_add(finger as u32).is_multiple_of(every)
            && let Some(unit) = hand.units.get(finger)
        {
            hand.shared.show(|| Shape::of(unit.model.follower(), &unit.last));
        }
    }

    /// Once every finger has its estimate, finds where the object rests, and reports the forces there.
    fn balance<B: Board>(&mut self, hand: &mut Hand<'_>, scheduler: &Scheduler) {
        // A board with room for one finger holds nothing between two, and has no room for what finds it.
        if B::FINGERS < 2 {
            return;
        }
        let mut fingers = hand.units.iter().filter(|unit| unit.mount.is_some());
        if !fingers.all(|unit| unit.pending.is_some()) {
            return;
        }
        let start = B::cost_ticks();
        let left = scheduler.left::<B>();
        let is_gone = self.free.as_mut().is_some_and(|free| free.find(&mut hand.units, left));
        let cost = B::cost_ticks().wrapping_sub(start);
        if let Some(free) = &mut self.free {
            free.is_balanced_now(cost, &mut hand.units);
        }
        self.leave_unbalanced::<B>(hand, scheduler);
        if is_gone {
            self.put_back(hand);
        }
    }

    /// Reports what waits: by the balance of this tick, or as stale where a finger has no estimate.
    fn leave_unbalanced<B: Board>(&mut self, hand: &mut Hand<'_>, scheduler: &Scheduler) {
        let Some(free) = &mut self.free else {
            return;
        };
        let status = free.status(&hand.units);
        for finger in 0..hand.units.len() {
            let Some(unit) = hand.units.get_mut(finger) else {
                return;
            };
            let Some(pending) = unit.pending.take() else {
                continue;
            };
            let estimate = if status.is_trustworthy() {
                unit.model.reread()
            } else {
                let Estimate { motor_angle, iterations, residual, age, .. } = pending.estimate;
                let age = age.max(1);
                Estimate { status, motor_angle, iterations, residual, age, ..unit.last.estimate }
            };
            self.conclude::<B>(hand, scheduler, finger, &Pending { estimate, ..pending });
        }
    }

    /// Ends a tick: fingers without a report are stale, and the grasp is summed up. `is_missed`: an answer that has not come is missing,
    /// and not only late.
    pub(crate) fn finish<B: Board>(&mut self, hand: &mut Hand<'_>, scheduler: &Scheduler, is_missed: bool) {
        for finger in 0..hand.units.len() {
            if hand.units.get(finger).is_some_and(|unit| unit.mount.is_some() && !unit.is_done())
                && !self.repeat::<B>(hand, scheduler, finger)
            {
                self.stale(hand, scheduler, finger, is_missed);
            }
        }
        self.leave_unbalanced::<B>(hand, scheduler);
        if hand.settings.count() > 1 {
            let fingers = hand.units.iter().filter_map(|unit| Some((&unit.last, unit.mount?.side)));
            let grasp = Grasp::of(fingers);
            let place = self.free.as_ref().map(Free::place).unwrap_or_default();
            // Numbers that are repeated because nothing newer was heard are as sound as they were.
            let is_sound = hand.units.iter().filter(|unit| unit.mount.is_some()).all(Unit::is_sound);
            self.margins.go_on::<B>(hand, scheduler, is_sound, place);
            let (free, margin) = (self.free.as_ref().map(Free::report), self.margins.report(scheduler.ticks));
            hand.shared.grasp(Grasp { free, margin, ..grasp });
        }
    }

    /// No position came in this period: the old numbers, marked as such.
    fn stale(&mut self, hand: &mut Hand<'_>, scheduler: &Scheduler, finger: usize, is_missed: bool) {
        let reaction = hand.settings.on_fault;
        let Some(unit) = hand.units.get_mut(finger) else {
            return;
        };
        unit.not_seen();
        let estimate = &mut unit.last.estimate;
        estimate.status = Status::Stale;
        estimate.age = estimate.age.saturating_add(1);
        estimate.iterations = 0;
        // A position that comes while this is done is a later one.
        (unit.last.time_us, unit.last.cost) = (now_us().min(scheduler.end.as_micros()), 0);
        if is_missed && let Some(mount) = &unit.mount {
            unit.grip.miss(&mount.limits(), reaction);
        }
        self.publish(hand, finger);
    }

    /// A period without a new position: the last one counts, as long as it is young. Returns whether it does.
    fn repeat<B: Board>(&mut self, hand: &mut Hand<'_>, scheduler: &Scheduler, finger: usize) -> bool {
        let Some(unit) = hand.units.get_mut(finger) else {
            return false;
        };
        let Some(at_us) = unit.heard_us else {
            return false;
        };
        let age_us = now_us().saturating_sub(at_us);
        if age_us > LOST_US && unit.health.is_present() {
            unit.health = Health::Absent;
            hand.shared.add(|counters| &mut counters.servo_losses);
            hand.shared.tell(Event::ServoLost { finger: finger as u8, other_master: false });
            return false;
        }
        if age_us > YOUNG_US {
            return false;
        }
        unit.repeats = unit.repeats.saturating_add(1);
        if !unit.is_settled {
            // It is not there yet: a further tick at the same position.
            let (position, current, alert) = (unit.last.position, unit.last.current, unit.alert);
            let reading = Reading { at_us, heard_ticks: None, position, current, alert, refused: None };
            self.fresh::<B>(hand, scheduler, finger, &reading);
        } else {
            unit.last.estimate.age = unit.repeats;
            self.publish(hand, finger);
        }
        true
    }

    fn publish(&mut self, hand: &mut Hand<'_>, finger: usize) {
        let Some(unit) = hand.units.get_mut(finger) else {
            return;
        };
        self.sequence = self.sequence.wrapping_add(1);
        let phase = unit.grip.phase();
        let changed = unit.is_news(phase, now_us());
        unit.last = Report { sequence: self.sequence, phase, goal: unit.grip.goal() as f32, ..unit.last };
        unit.is_reported = true;
        hand.shared.report(unit.last);
        if changed {
            hand.shared.tell(Event::PhaseChanged { finger: finger as u8, phase });
        }
    }
}
