//! One finger within the control task: its mount, its model, its grip, its last report.

use dynamixel::{Id, Model as ServoModel, xm430};
use grip::{
    Bounds, Budget, Calibration, Contact, Faults, Firmness, Grip, Health, Motor, Phase, StrainWatch, Told, Touch, Why,
};
use messages::{Difference, Direction, Finger, Mount, Object, Outcome, Refusal, Report, Support};
use model_core::estimator::{Estimate, EstimatorSettings};
use model_core::fading::Fading;
use model_core::size::Size;
use model_core::status::Status;
use model_core::uncertainty::{Uncertainty, UncertaintyError};

use crate::servo::{Fence, Reading, lever, reach};
use crate::shared::Shared;
use crate::{Model, Room};

/// Whether a finger's motor has torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Torque {
    /// It has.
    On,
    /// It is to be switched off.
    Falling,
    /// It has none, because somebody has asked for that.
    Off,
    /// It is to be switched on, where the motor is.
    Rising,
}

impl Torque {
    /// Whether it has torque, or is to have it.
    pub(crate) fn is_on(self) -> bool {
        matches!(self, Self::On | Self::Rising)
    }
}

/// A wait for the bus that passes within this time is only in the reports, not an event, µs.
const BRIEF_US: u64 = 100_000;

/// Ticks in a row without a position after which the way that the finger has come is unknown.
const UNSEEN: u8 = 5;

/// Whether a board with or without room for friction takes a coefficient.
fn check_friction(friction: f64, has_room: bool) -> Outcome {
    if friction == 0.0 || has_room {
        return Ok(());
    }
    let why = "on this board: its memory has no room for friction";
    Err(Refusal::Object(Refusal::text(&format_args!("friction is {friction}; allowed is 0 {why}"))))
}

/// Whether a material with or without memory goes with an object that is held so.
fn check_memory(fades: bool, support: Support) -> Outcome {
    match support {
        Support::Free { .. } if fades => {
            let why = "prony: allowed is an elastic material for a free object: its balance is without memory";
            Err(Refusal::Finger(Refusal::text(&why)))
        }
        _ => Ok(()),
    }
}

/// An estimate that waits for the other fingers on a free object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pending {
    pub(crate) reading: Reading,
    pub(crate) estimate: Estimate,
    pub(crate) cost: u32,
    /// Where it is to go with the object, rad or mm; nothing if it has gone there by itself.
    pub(crate) to: Option<f64>,
}

/// A finger.
pub(crate) struct Unit<'a> {
    pub(crate) model: &'a mut Model,
    /// Nothing: the gripper has no such finger.
    pub(crate) mount: Option<Mount>,
    pub(crate) calibration: Calibration,
    /// What its servo is.
    pub(crate) servo: &'static ServoModel,
    /// Proportional gain of that one's position control.
    pub(crate) gain: u16,
    pub(crate) grip: Grip,
    pub(crate) contact: Contact,
    pub(crate) budget: Budget,
    pub(crate) health: Health,
    pub(crate) torque: Torque,
    pub(crate) last: Report,
    /// The phase that an event last reported, and since when the finger has waited for the bus, µs.
    pub(crate) told: Phase,
    pub(crate) waits_since: Option<u64>,
    /// The last estimate had converged.
    pub(crate) is_settled: bool,
    /// Ticks since its position was heard, while another master leads.
    pub(crate) repeats: u32,
    /// Ticks in a row without a position, up to a few.
    pub(crate) unseen: u8,
    /// When the position behind the last estimate came, µs; nothing before the first.
    seen_us: Option<u64>,
    /// What waits for the other fingers on a free object.
    pub(crate) pending: Option<Pending>,
    pub(crate) alert: bool,
    pub(crate) alert_changed: bool,
    /// Whether the model has a design and an object: without, no force can be asked for.
    pub(crate) has_design: bool,
    /// How far from the motor's axis the design's front beam is at most, mm.
    reach: f32,
    pub(crate) has_object: bool,
    /// What a calibration has left uncertain, if there was one.
    uncertainty: Option<Uncertainty>,
    /// When the position behind the last estimate was heard, µs; nothing while the gripper leads the servo itself.
    pub(crate) heard_us: Option<u64>,
    /// The hardware errors last heard of.
    pub(crate) hardware_error: u8,
    /// How its servo is not what it should be, as it was last reported.
    pub(crate) difference: Option<Difference>,
    /// Where its servo shuts down, and how near it is to that.
    pub(crate) bounds: Option<Bounds>,
    pub(crate) watch: StrainWatch,
    /// Its servo is to be looked at, as it may hold no more.
    pub(crate) doubted: bool,
    /// Whether this tick's report is made.
    pub(crate) is_reported: bool,
}

impl<'a> Unit<'a> {
    pub(crate) fn new(finger: u8, model: &'a mut Model, mount: Option<Mount>) -> Self {
        let of = mount.unwrap_or(Mount::DEFAULT);
        // A mount's drive was checked with the settings.
        let _ = model.set_drive(of.drive);
        Self {
            model,
            mount,
            calibration: Calibration::new(&of.gear()),
            servo: ServoModel::ASSUMED,
            gain: 0,
            grip: Grip::REST,
            contact: Contact::NONE,
            budget: Budget::new(EstimatorSettings::DEFAULT.budget),
            health: Health::Absent,
            torque: Torque::On,
            is_settled: false,
            repeats: 0,
            unseen: 0,
            seen_us: None,
            last: Report::blank(finger),
            told: Report::blank(finger).phase,
            waits_since: None,
            pending: None,
            alert: false,
            alert_changed: false,
            has_design: false,
            reach: 0.0,
            has_object: false,
            uncertainty: None,
            heard_us: None,
            hardware_error: 0,
            difference: None,
            bounds: None,
            watch: StrainWatch::FREE,
            doubted: false,
            is_reported: false,
        }
    }

    /// Whether an event is to report this phase. A wait for the bus is noise until it has lasted for [`BRIEF_US`].
    pub(crate) fn is_news(&mut self, phase: Phase, now_us: u64) -> bool {
        self.waits_since = match phase {
            Phase::Waiting(Why::Bus) => self.waits_since.or(Some(now_us)),
            _ => None,
        };
        let is_brief = self.waits_since.is_some_and(|since| now_us.saturating_sub(since) < BRIEF_US);
        !is_brief && core::mem::replace(&mut self.told, phase) != phase
    }

    /// Nothing more is to be done for it in this tick but to wait for the others.
    pub(crate) fn is_done(&self) -> bool {
        self.is_reported || self.pending.is_some()
    }

    /// Says how uncertain its parameters are.
    pub(crate) fn set_uncertainty(&mut self, given: Option<Uncertainty>) -> Result<(), UncertaintyError> {
        self.model.set_uncertainty(self.mount.unwrap_or(Mount::DEFAULT).uncertainty(given))?;
        self.uncertainty = given;
        Ok(())
    }

    /// Takes design, object and uncertainty that were kept in flash.
    pub(crate) fn restore(&mut self, shared: &Shared) {
        let finger = self.last.finger;
        let number = usize::from(finger);
        let (design, object, uncertainty, support) = shared.setup(|setup| {
            (
                setup.fingers.get(number).cloned().flatten(),
                setup.objects.get(number).copied().flatten(),
                setup.uncertainties.get(number).copied().flatten(),
                setup.settings.support,
            )
        });
        if self.set_uncertainty(uncertainty).is_err() {
            shared.set_uncertainty(finger, None);
        }
        if let Some(design) = design
            && self.check_design(&design, support).and_then(|()| self.set_design(&design)).is_err()
        {
            shared.set_design(finger, None);
        }
        self.has_object = object.is_some_and(|object| self.set_object(&object).is_ok());
    }

    /// Refuses a finger whose material has memory where that does not go, or is none.
    pub(crate) fn check_design(&self, finger: &Finger, support: Support) -> Outcome {
        check_memory(!finger.prony.is_empty(), support)?;
        let mut fading = Fading::<f32>::ELASTIC;
        fading.set(&finger.terms()).map_err(|error| Refusal::Finger(Refusal::text(&error)))
    }

    /// Takes a finger that has passed [`Self::check_design`]; after one that is refused there is none.
    pub(crate) fn set_design(&mut self, finger: &Finger) -> Outcome {
        // Checked.
        let _ = self.model.set_prony(&finger.terms());
        let made = self.model.configure(&finger.design, &finger.how);
        self.has_design = made.is_ok();
        self.reach = reach(&finger.design);
        made.map_err(|error| Refusal::Finger(Refusal::text(&error)))
    }

    /// What its servo's own current control is to let it give, if that was chosen.
    pub(crate) fn fence(&self) -> Option<Fence> {
        let mount = self.mount.as_ref().filter(|mount| mount.current_fence)?;
        let torque = if self.has_design {
            mount.force_limit * lever(&mount.drive, mount.range, self.reach) / mount.gear_ratio
        } else {
            f32::INFINITY
        };
        Some(Fence { torque, current: mount.current_limit })
    }

    /// Takes an object; what is wrong with it changes nothing.
    pub(crate) fn set_object(&mut self, object: &Object) -> Outcome {
        let Object { design, friction } = object;
        design.validate().map_err(|error| Refusal::Object(Refusal::text(&error)))?;
        check_friction(*friction, Room::RUBS)?;
        self.model.set_friction(*friction).map_err(|error| Refusal::Object(Refusal::text(&error)))?;
        // Validated above.
        self.model.set_object(*design).map_err(|error| Refusal::Object(Refusal::text(&error)))?;
        self.has_object = true;
        Ok(())
    }

    /// Refuses a support that does not go with the finger's memory.
    pub(crate) fn check_support(&self, support: Support) -> Outcome {
        check_memory(self.model.fades(), support)
    }

    /// Time since the position before this one, s.
    pub(crate) fn passed(&mut self, reading: &Reading) -> f64 {
        let before = self.seen_us.replace(reading.at_us).unwrap_or(reading.at_us);
        f64::from(1e-6 * reading.at_us.saturating_sub(before) as f32)
    }

    /// The last estimate can be trusted, and is that of the last position heard.
    pub(crate) fn is_sound(&self) -> bool {
        let estimate = &self.last.estimate;
        estimate.status.is_trustworthy() && estimate.age == self.repeats
    }

    /// Neither the motor nor the force has changed in the last estimate.
    pub(crate) fn has_rested(&self) -> bool {
        self.model.has_rested() && !self.model.fades()
    }

    /// The position was not seen in this tick.
    pub(crate) fn not_seen(&mut self) {
        self.unseen = self.unseen.saturating_add(1);
    }

    /// The position is seen again. After several ticks nobody knows which way the finger has come, and whether its servo had its power.
    pub(crate) fn seen(&mut self) {
        if core::mem::take(&mut self.unseen) >= UNSEEN {
            self.model.forget_path();
            self.doubted = true;
        }
    }

    /// Its servo's address, if the gripper has this finger.
    pub(crate) fn id(&self) -> Option<Id> {
        self.mount.and_then(|mount| Id::new(mount.servo_id))
    }

    /// Takes a mount, or none.
    pub(crate) fn set_mount(&mut self, mount: Option<Mount>) {
        if mount == self.mount {
            return;
        }
        let (id, fence) = (self.id(), self.fence().is_some());
        if let (Some(mount), Some(before)) = (&mount, &self.mount)
            && mount.moves_like(before)
        {
            // What it does goes on.
            (self.mount, self.difference) = (Some(*mount), None);
            return self.restrict();
        }
        let at = self.calibration.position(self.grip.goal());
        self.mount = mount;
        let of = mount.unwrap_or(Mount::DEFAULT);
        self.calibration = Calibration::new(&of.gear());
        // Checked with the settings.
        let _ = self.model.set_drive(of.drive);
        // Of another gear: a value that was taken before is taken again.
        let _ = self.set_uncertainty(self.uncertainty);
        // The motor stays where it is, at the angle it now is called.
        self.grip.renamed(self.calibration.angle(at));
        if self.id() != id || self.fence().is_some() != fence {
            // It is set up anew.
            (self.health, self.torque) = (Health::Absent, Torque::On);
        } else if !self.torque.is_on() {
            self.grip.relax();
        }
        self.difference = None;
    }

    /// Keeps what it does within its limits.
    pub(crate) fn restrict(&mut self) {
        if let Some(mount) = &self.mount {
            self.grip.restrict(&mount.limits());
        }
    }

    /// Somebody else leads the servo from now on, or does so no more.
    pub(crate) fn forget_servo(&mut self) {
        (self.health, self.torque) = (Health::Absent, Torque::On);
        (self.heard_us, self.repeats) = (None, 0);
        (self.bounds, self.watch) = (None, StrainWatch::FREE);
        self.hardware_error = 0;
        self.difference = None;
        self.grip.renamed(self.grip.goal());
    }

    /// Switches the torque off.
    pub(crate) fn relax(&mut self) {
        self.torque = Torque::Falling;
        self.grip.relax();
    }

    /// Switches the torque on if it is off: somebody wants the finger to move.
    pub(crate) fn rise(&mut self) {
        if !self.torque.is_on() {
            self.torque = Torque::Rising;
        }
    }

    /// The next goal, counts; none while the motor has no torque.
    pub(crate) fn advance(&mut self, seconds: f64) -> Option<i32> {
        if self.torque != Torque::On {
            return None;
        }
        let goal = match &self.mount {
            Some(mount) => self.grip.advance(seconds, &mount.limits()),
            None => self.grip.goal(),
        };
        Some(self.calibration.position(goal))
    }

    /// Its servo's motor.
    fn motor(&self) -> Motor {
        let dynamixel::Motor { torque_constant, friction, .. } = self.servo.motor;
        Motor { torque_constant, friction }
    }

    /// How firmly its servo holds: the whole voltage, which makes the torque at stall, is 128 units of PWM per unit of gain and count (ROBOTIS
    /// e-Manual). Without a gain no torque depends on the goal: that counts as the least.
    fn firmness(&self) -> Firmness {
        let ServoModel { full_pwm, counts, motor, .. } = *self.servo;
        let all = 128.0 * f32::from(full_pwm) / f32::from(self.gain.max(1));
        let all = all * xm430::COUNTS_PER_REVOLUTION as f32 / counts as f32;
        let per_milliampere = all / motor.stall_current;
        let friction = motor.friction / motor.torque_constant * per_milliampere;
        let [all, per_milliampere, friction] = [all, per_milliampere, friction].map(f64::from);
        Firmness { all, per_milliampere, friction }
    }

    /// What the current shows.
    pub(crate) fn witness(&mut self, reading: &Reading, seconds: f64) -> Told {
        let estimate = &self.last.estimate;
        let trust = estimate.status.is_trustworthy() && estimate.age == 0;
        // In the finger's direction, and through its gear.
        let mount = self.mount.unwrap_or(Mount::DEFAULT);
        let current = match mount.direction {
            Direction::Same => reading.current,
            Direction::Reversed => -reading.current,
        };
        let motor = self.motor().through(mount.gear_ratio);
        let demanded = trust.then_some(estimate.torque);
        let angle = self.calibration.angle(reading.position);
        self.contact.feel(&motor, angle, current, self.calibration.count(), demanded, seconds as f32)
    }

    /// Leads by what the servo and the model say.
    pub(crate) fn feel(&mut self, reading: &Reading, seconds: f64, faults: &Faults) {
        let Some(mount) = &self.mount else {
            return;
        };
        let estimate = &self.last.estimate;
        // A force within 1 % or 0.05 N is near enough to grip by.
        let is_present = estimate.status.is_trustworthy() && estimate.age == 0 || estimate.status == Status::Updating;
        let touch = Touch {
            angle: self.calibration.angle(reading.position),
            force: is_present.then(|| f64::from(estimate.force_magnitude())),
            slope: force_slope(estimate),
            has_model: self.has_design && self.has_object,
            current: match mount.direction {
                Direction::Same => reading.current,
                Direction::Reversed => -reading.current,
            },
            firmness: self.firmness(),
            alert: reading.alert,
            part: self.watch.part(),
            stop: self.watch.stops(),
            relaxes: self.model.fades(),
        };
        let before = self.grip.phase();
        self.grip.feel(&touch, self.calibration.count(), seconds, &mount.limits(), faults);
        // A motor without torque goes nowhere either.
        let phase = self.grip.phase();
        self.doubted |= phase != before && phase.why() == Some(Why::Stall);
    }
}

/// Slope of the force's magnitude over the motor angle, N/rad, if the estimate knows it.
fn force_slope(estimate: &Estimate) -> Option<f64> {
    let ([x, y], [u, v], force) = (estimate.force, estimate.force_per_angle, estimate.force_magnitude());
    let slope = f64::from((x * u + y * v) / force);
    slope.is_finite().then_some(slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_is_refused_by_name_where_it_has_no_room() {
        let words = |friction, has_room| check_friction(friction, has_room).map_err(|why| why.to_string());
        assert_eq!((words(0.0, false), words(0.6, true)), (Ok(()), Ok(())));
        let board = "friction is 0.6; allowed is 0 on this board: its memory has no room for friction";
        assert_eq!(words(0.6, false), Err(board.to_owned()));
    }

    #[test]
    fn memory_is_refused_for_a_free_object() {
        let free = Support::Free { load: [0.0; 2], moment: 0.0 };
        let words = |fades, support| check_memory(fades, support).map_err(|why| why.to_string());
        assert_eq!((words(false, free), words(true, Support::Fixed)), (Ok(()), Ok(())));
        let refused = words(true, free).unwrap_err();
        assert!(refused.contains("prony") && refused.contains("a free object"), "{refused}");
    }
}
