//! A free object between the fingers: where it rests, found anew in every tick.
//!
//! An estimate is for an object at a place. Of a free object the place follows from all fingers at once: their estimates wait
//! until the last one is there, then the object goes to where the forces balance its load, in what is left of the period, and
//! the forces there are reported. Where the balance is not reached in time, or there is none, all reports say so and repeat
//! the last good numbers with their age; the next tick goes on from there.
//!
//! Until two fingers touch it the object stays where it is: something else holds it. Once no finger touches it any more, it counts
//! as standing where it was set.

use messages::{FreeObject, Reaction, Side, Support};
use model_core::estimator::Estimate;
use model_core::grasp::{Grasp, Held, Load, Place};
use model_core::status::Status;

use crate::board::Board;
use crate::control::Core;
use crate::servo::Reading;

/// An estimate that waits for the other fingers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pending {
    pub(crate) reading: Reading,
    pub(crate) estimate: Estimate,
    pub(crate) cost: u32,
}

/// Distance from where it was set beyond which the object is given up, mm.
const FARTHEST: f64 = 50.0;
/// Ticks in which a balance may be looked for before a gripping finger takes it for a fault: an object that is let go has
/// some way to go.
const SETTLING: u32 = 100;
/// A turn that counts as far as a shift by its arc, this far from the centre, mm.
const ARM: f64 = 50.0;

/// A free object.
pub(crate) struct Free {
    load: Load,
    place: Place,
    report: FreeObject,
    /// Ticks since the last balance.
    settling: u32,
    /// The report is of this tick.
    is_new: bool,
}

impl Free {
    /// What the settings say, if it is free.
    pub(crate) fn of(support: Support) -> Option<Self> {
        let Support::Free { load, moment } = support else {
            return None;
        };
        let load = Load { force: load.map(f64::from), moment: f64::from(moment) };
        let report =
            FreeObject { status: Status::Stale, shift: [0.0; 2], turn: 0.0, residual: 0.0, iterations: 0, cost: 0 };
        Some(Self { load, place: Place::default(), report, settling: 0, is_new: false })
    }

    /// A tick begins.
    pub(crate) fn begin(&mut self) {
        (self.report.iterations, self.report.cost, self.is_new) = (0, 0, false);
    }

    pub(crate) fn report(&self) -> FreeObject {
        self.report
    }

    /// How far it is from where it was set, mm, at most.
    fn distance(&self) -> f64 {
        let Place { shift: [x, y], turn } = self.place;
        x.abs() + y.abs() + ARM * turn.abs()
    }
}

impl<B: Board> Core<'_, B> {
    /// Takes what holds the object besides the fingers.
    pub(crate) fn support(&mut self, support: Support) {
        if support == self.settings.support {
            return;
        }
        let new = Free::of(support);
        match (&mut self.free, new) {
            // Another load on the same object.
            (Some(free), Some(new)) => free.load = new.load,
            (_, new) => {
                self.put_back();
                self.free = new;
                // What waited is stale.
                self.units.iter_mut().for_each(|unit| unit.pending = None);
            }
        }
    }

    /// The object is where it was set.
    pub(crate) fn put_back(&mut self) {
        let Some(free) = &mut self.free else {
            return;
        };
        if free.place == Place::default() {
            return;
        }
        free.place = Place::default();
        (free.report.shift, free.report.turn) = ([0.0; 2], 0.0);
        for unit in &mut self.units {
            if let Some(object) = unit.model.object().copied() {
                // It was good before.
                let _ = unit.model.set_object(object);
            }
        }
    }

    /// What a finger does on a fault. While an object comes to rest it waits.
    pub(crate) fn on_fault(&self) -> Reaction {
        let settles = |free: &Free| free.report.status == Status::MaxIterations && free.settling <= SETTLING;
        if self.free.as_ref().is_some_and(settles) { Reaction::Hold } else { self.settings.on_fault }
    }

    /// Once every finger has its estimate, finds where the object rests, and reports the forces there.
    pub(crate) fn balance(&mut self) {
        // A board with room for one finger holds nothing between two, and has no room for what finds it.
        if B::FINGERS < 2 {
            return;
        }
        let mut fingers = self.units.iter().filter(|unit| unit.mount.is_some());
        if !fingers.all(|unit| unit.pending.is_some()) {
            return;
        }
        let start = B::cost_ticks();
        let is_gone = self.find_balance();
        let cost = B::cost_ticks().wrapping_sub(start);
        if let Some(free) = &mut self.free {
            (free.report.cost, free.is_new) = (cost, true);
        }
        self.leave_unbalanced();
        if is_gone {
            self.put_back();
        }
    }

    /// Reports what waits: by the balance of this tick, or as stale where a finger has no estimate.
    pub(crate) fn leave_unbalanced(&mut self) {
        let waits = self.units.iter().any(|unit| unit.pending.is_some());
        let is_old = self.units.iter().any(|unit| unit.mount.is_some() && unit.last.estimate.status == Status::Stale);
        let Some(free) = &mut self.free else {
            return;
        };
        if !free.is_new && (waits || is_old) {
            free.report.status = Status::Stale;
        }
        let status = free.report.status;
        for finger in 0..self.units.len() {
            let Some(unit) = self.units.get_mut(finger) else {
                return;
            };
            let Some(Pending { reading, estimate, cost }) = unit.pending.take() else {
                continue;
            };
            let told = if status.is_trustworthy() {
                unit.model.reread()
            } else {
                let Estimate { motor_angle, iterations, residual, age, .. } = estimate;
                let age = age.max(1);
                Estimate { status, motor_angle, iterations, residual, age, ..unit.last.estimate }
            };
            self.conclude(finger, &reading, told, cost);
        }
    }

    /// Returns whether the object counts as standing where it was set from now on: nothing touches it, or it is too far off.
    fn find_balance(&mut self) -> bool {
        let left = self.left();
        let Some(free) = &mut self.free else {
            return false;
        };
        free.settling = free.settling.saturating_add(1);
        let (mut count, mut touching, mut each) = (0_u32, 0, u32::MAX);
        let fingers = self.units.iter().filter(|unit| unit.mount.is_some()).count().max(1);
        let share = u32::try_from(left / fingers as u64).unwrap_or(u32::MAX);
        for unit in &self.units {
            let Some(Pending { estimate, .. }) = unit.pending else {
                continue;
            };
            if !estimate.status.is_trustworthy() || estimate.age > 0 {
                free.report.status = estimate.status;
                return false;
            }
            count += 1;
            touching += u32::from(unit.model.follower().touching() > 0);
            each = each.min(unit.budget.iterations(share));
        }
        if touching < 2 {
            (free.report.status, free.settling) = (Status::NoContact, 0);
            return touching == 0;
        }
        let held = self.units.iter_mut().filter_map(|unit| {
            let mirrored = unit.mount?.side == Side::Right;
            let object = *unit.model.object()?;
            Some(Held { follower: unit.model.follower_mut(), mirrored, object })
        });
        let Ok(mut grasp) = Grasp::resume(held, free.load, free.place) else {
            free.report.status = Status::OutOfRange;
            return false;
        };
        // With no time left nothing is begun.
        let balance = grasp.release_within(if left == 0 { 0 } else { each.saturating_mul(count) });
        free.place = grasp.place();
        let is_far = free.distance() > FARTHEST;
        let status = match balance.status {
            _ if is_far => Status::OutOfRange,
            // Two fingers touched it, and now nothing holds it.
            Status::NoContact => Status::Folded,
            status => status,
        };
        if status.is_trustworthy() {
            free.settling = 0;
        }
        free.report = FreeObject {
            status,
            shift: free.place.shift.map(|x| x as f32),
            turn: free.place.turn as f32,
            residual: balance.residual as f32,
            iterations: balance.iterations.min(u32::from(u16::MAX)) as u16,
            cost: 0,
        };
        is_far
    }
}
