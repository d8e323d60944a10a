//! A free object between the fingers: where it rests, found anew in every tick.
//!
//! An estimate is for an object at a place. Of a free object the place follows from all fingers at once: their estimates wait
//! until the last one is there, then the object goes to where the forces balance its load, in what is left of the period, and
//! the forces there are reported. Where the balance is not reached in time, or there is none, all reports say so and repeat
//! the last good numbers with their age; the next tick goes on from there.
//!
//! With friction the way matters, and a finger that goes on alone would rub: once two fingers touch the object, they wait for one another
//! before they move, and all go together with it. Where no balance is found for some ticks, as when the hand lets go of it, the fingers are
//! followed to their angles alone, and it goes to where it then rests.
//!
//! Until two fingers touch it the object stays where it is: something else holds it. Once no finger touches it any more, it counts
//! as standing where it was set.

use messages::{FreeObject, Side, Support};
use model_core::grasp::{Course, Grasp, Held, Load, MAX_FINGERS, Place};
use model_core::status::Status;

use crate::unit::{Pending, Unit};

/// Distance from where it was set beyond which the object is given up, mm.
const FARTHEST: f64 = 50.0;
/// Ticks in which a balance may be looked for before a gripping finger takes it for a fault: an object that is let go has
/// some way to go.
const SETTLING: u32 = 100;
/// Iterations of a motion with the object, in those that an estimate takes at most.
const CARRYING: u32 = 3;
/// Ticks in a row without a balance after which the fingers are followed without the object. Where it comes to rest then depends on that.
const PATIENCE: u32 = 25;
/// Ticks in a row without a balance for which a finger goes on moving.
const BLIND: u32 = 8;
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
    /// The fingers move with it in this tick, and what is known of the last motion.
    is_carried: bool,
    course: Course,
    /// Ticks in a row without a balance.
    late: u32,
    /// The fingers have gone on alone with friction: the next balance does not follow from the last one.
    has_leapt: bool,
}

impl Free {
    /// What the settings say, if it is free.
    #[inline(never)]
    pub(crate) fn of(support: Support) -> Option<Self> {
        let Support::Free { load, moment } = support else {
            return None;
        };
        let load = Load { force: load.map(f64::from), moment: f64::from(moment) };
        let report =
            FreeObject { status: Status::Stale, shift: [0.0; 2], turn: 0.0, residual: 0.0, iterations: 0, cost: 0 };
        let (place, course) = (Place::default(), Course::default());
        Some(Self {
            load,
            place,
            report,
            settling: 0,
            is_new: false,
            is_carried: false,
            course,
            late: 0,
            has_leapt: false,
        })
    }

    /// A tick begins.
    #[inline(never)]
    pub(crate) fn begin(&mut self, units: &[Unit<'_>]) {
        (self.report.iterations, self.report.cost, self.is_new) = (0, 0, false);
        let mounted = || units.iter().filter(|unit| unit.mount.is_some());
        let touching = mounted().filter(|unit| unit.model.follower().solution().touching() > 0).count();
        self.is_carried = touching >= 2 && self.late < PATIENCE && mounted().any(|unit| unit.model.rubs());
        if !self.is_carried {
            self.has_leapt |= self.late >= PATIENCE;
            (self.late, self.course) = (0, Course::default());
        }
    }

    /// Whether the fingers wait for one another, to move with it.
    pub(crate) fn is_carried(&self) -> bool {
        self.is_carried
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
    #[inline(never)]
    pub(crate) fn put_back(&mut self, units: &mut [Unit<'_>]) {
        if self.place == Place::default() {
            return;
        }
        (self.place, self.course) = (Place::default(), Course::default());
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

    /// Ticks without a balance for which a motion goes on.
    pub(crate) fn patience(&self) -> u32 {
        if self.is_carried { BLIND } else { 0 }
    }

    /// Its balance is of this tick, and has cost so much; where the fingers went with it, the cost of their iterations is learnt.
    #[inline(never)]
    pub(crate) fn is_balanced_now(&mut self, cost: u32, units: &mut [Unit<'_>]) {
        (self.report.cost, self.is_new) = (cost, true);
        let goes = |unit: &Unit<'_>| unit.pending.is_some_and(|pending| pending.to.is_some());
        let count = units.iter().filter(|unit| goes(unit)).count().max(1) as u32;
        let iterations = u32::from(self.report.iterations) / count;
        // Where nothing moves, there is nothing to learn.
        for unit in units.iter_mut().filter(|unit| iterations > 0 && goes(unit)) {
            unit.budget.spent(cost / count, iterations);
        }
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
            let Some(Pending { estimate, to, .. }) = unit.pending else {
                continue;
            };
            if to.is_none() && (!estimate.status.is_trustworthy() || estimate.age > 0) {
                self.report.status = estimate.status;
                return false;
            }
            count += 1;
            touching += u32::from(unit.model.follower().solution().touching() > 0);
            // Where what stuck begins to slip, a motion takes several times as many as an estimate.
            each = each.min(unit.budget.iterations_of(share, if self.is_carried { CARRYING } else { 1 }));
        }
        if touching < 2 {
            (self.report.status, self.settling, self.has_leapt) = (Status::NoContact, 0, false);
            return touching == 0;
        }
        let mut to: heapless::Vec<f64, MAX_FINGERS> = heapless::Vec::new();
        let held = units.iter_mut().filter_map(|unit| {
            let mirrored = unit.mount?.side == Side::Right;
            let object = *unit.model.object()?;
            let there = unit.pending.and_then(|pending| pending.to);
            // As much room as for fingers.
            let _ = to.push(there.unwrap_or_else(|| unit.model.follower().solution().coordinate()));
            Some(Held { follower: unit.model.follower_mut(), mirrored, object })
        });
        let Ok(grasp) = Grasp::resume(held, self.load, self.place) else {
            self.report.status = Status::OutOfRange;
            return false;
        };
        let mut grasp = grasp.with_course(self.course);
        // With no time left nothing is begun.
        let allowed = if left == 0 { 0 } else { each.saturating_mul(count) };
        // There are as many coordinates as fingers.
        let carried = if self.is_carried { grasp.advance_within(&to, allowed).ok() } else { None };
        let balance = carried.unwrap_or_else(|| grasp.release_within(allowed));
        (self.place, self.course) = (grasp.place(), grasp.course());
        let is_far = self.distance() > FARTHEST;
        let status = match balance.status {
            _ if is_far => Status::OutOfRange,
            // Two fingers touched it, and now nothing holds it.
            Status::NoContact => Status::Folded,
            Status::Converged if self.has_leapt => Status::Snapped,
            status => status,
        };
        if status.is_trustworthy() {
            (self.settling, self.has_leapt) = (0, false);
        }
        self.late = if self.is_carried && !status.is_trustworthy() { self.late + 1 } else { 0 };
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
