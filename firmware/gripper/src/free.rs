//! A free object between the fingers: where it rests, found anew in every tick.
//!
//! An estimate is for an object at a place. Of a free object the place follows from all fingers at once: their estimates wait
//! until the last one is there, then the object goes to where the forces balance its load, in what is left of the period, and
//! the forces there are reported. Where the balance is not reached in time, or there is none, all reports say so and repeat
//! the last good numbers with their age; the next tick goes on from there.
//!
//! Until two fingers touch it the object stays where it is: something else holds it. Once no finger touches it any more, it counts
//! as standing where it was set.

use messages::{FreeObject, Side, Support};
use model_core::grasp::{Grasp, Held, Load, Place};
use model_core::status::Status;

use crate::unit::{Pending, Unit};

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

    /// How far it has come from where it was set.
    pub(crate) fn place(&self) -> Place {
        self.place
    }

    /// How far it is from where it was set, mm, at most.
    fn distance(&self) -> f64 {
        let Place { shift: [x, y], turn } = self.place;
        x.abs() + y.abs() + ARM * turn.abs()
    }

    /// Bears another load.
    pub(crate) fn bear(&mut self, other: &Self) {
        self.load = other.load;
    }

    /// The object is where it was set.
    pub(crate) fn put_back(&mut self, units: &mut [Unit<'_>]) {
        if self.place == Place::default() {
            return;
        }
        self.place = Place::default();
        (self.report.shift, self.report.turn) = ([0.0; 2], 0.0);
        for unit in units {
            if let Some(object) = unit.model.object().copied() {
                // It was good before.
                let _ = unit.model.set_object(object);
            }
        }
    }

    /// Whether it is still coming to rest.
    pub(crate) fn settles(&self) -> bool {
        self.report.status == Status::MaxIterations && self.settling <= SETTLING
    }

    /// Its balance is of this tick, and has cost so much.
    pub(crate) fn is_balanced_now(&mut self, cost: u32) {
        (self.report.cost, self.is_new) = (cost, true);
    }

    /// What its balance is worth at a tick's end: stale if it was not looked for though a finger waits for it or has no estimate.
    pub(crate) fn status(&mut self, units: &[Unit<'_>]) -> Status {
        let waits = units.iter().any(|unit| unit.pending.is_some());
        let is_old = units.iter().any(|unit| unit.mount.is_some() && unit.last.estimate.status == Status::Stale);
        if !self.is_new && (waits || is_old) {
            self.report.status = Status::Stale;
        }
        self.report.status
    }

    /// Returns whether the object counts as standing where it was set from now on: nothing touches it, or it is too far off.
    ///
    /// Inlined, so that it is compiled where the loop is, in the board's own crate: the solver is then in the image once, and as that
    /// image is optimised.
    #[inline]
    pub(crate) fn find(&mut self, units: &mut [Unit<'_>], left: u64) -> bool {
        self.settling = self.settling.saturating_add(1);
        let (mut count, mut touching, mut each) = (0_u32, 0, u32::MAX);
        let fingers = units.iter().filter(|unit| unit.mount.is_some()).count().max(1);
        let share = u32::try_from(left / fingers as u64).unwrap_or(u32::MAX);
        for unit in &*units {
            let Some(Pending { estimate, .. }) = unit.pending else {
                continue;
            };
            if !estimate.status.is_trustworthy() || estimate.age > 0 {
                self.report.status = estimate.status;
                return false;
            }
            count += 1;
            touching += u32::from(unit.model.follower().solution().touching() > 0);
            each = each.min(unit.budget.iterations(share));
        }
        if touching < 2 {
            (self.report.status, self.settling) = (Status::NoContact, 0);
            return touching == 0;
        }
        let held = units.iter_mut().filter_map(|unit| {
            let mirrored = unit.mount?.side == Side::Right;
            let object = *unit.model.object()?;
            Some(Held { follower: unit.model.follower_mut(), mirrored, object })
        });
        let Ok(mut grasp) = Grasp::resume(held, self.load, self.place) else {
            self.report.status = Status::OutOfRange;
            return false;
        };
        // With no time left nothing is begun.
        let balance = grasp.release_within(if left == 0 { 0 } else { each.saturating_mul(count) });
        self.place = grasp.place();
        let is_far = self.distance() > FARTHEST;
        let status = match balance.status {
            _ if is_far => Status::OutOfRange,
            // Two fingers touched it, and now nothing holds it.
            Status::NoContact => Status::Folded,
            status => status,
        };
        if status.is_trustworthy() {
            self.settling = 0;
        }
        self.report = FreeObject {
            status,
            shift: self.place.shift.map(|x| x as f32),
            turn: self.place.turn as f32,
            residual: balance.residual as f32,
            iterations: balance.iterations.min(u32::from(u16::MAX)) as u16,
            cost: 0,
        };
        is_far
    }
}
