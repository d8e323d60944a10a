//! What is asked of the gripper while it runs: checked, carried out at a tick's beginning, answered.

use messages::{
    CloseTo, Event, FINGERS, GripTo, Heed, Heeds, Moved, Outcome, Refusal, Role, SPEEDS, SettingsField, Which,
};

use super::Core;
use crate::board::Board;
use crate::shared::{Command, Order};
use crate::unit::Unit;

impl<'a, B: Board> Core<'a, B> {
    /// Obeys one order, if there is one. The role changes between transactions only: after that nothing more is sent.
    pub(super) fn obey(&mut self, between: bool) {
        let Some(Order { ticket, command }) = self.waiting.take().or_else(|| self.shared.orders.try_receive().ok())
        else {
            return;
        };
        if !between && matches!(&command, Command::Settings(settings) if settings.role != self.settings.role) {
            self.waiting = Some(Order { ticket, command });
            return;
        }
        // One that was refused meanwhile, because nobody waits for it any more, is never done.
        if self.shared.claim(ticket) {
            let outcome = match command {
                Command::Open(which) => self.each(which, |unit, mount| {
                    unit.rise();
                    unit.grip.open(&mount.limits());
                }),
                // A finger without torque stays so.
                Command::Hold(which) => self.each(which, |unit, _| {
                    if unit.torque.is_on() {
                        unit.grip.hold();
                    }
                }),
                Command::Relax(which) => self.each(which, |unit, _| unit.relax()),
                command => self.execute(command).map(|()| Heeds::default()),
            };
            self.shared.answer(ticket, outcome);
        }
    }

    pub(crate) fn execute(&mut self, command: Command) -> Outcome {
        match command {
            // Each finger by itself.
            Command::Open(_) | Command::Hold(_) | Command::Relax(_) => Ok(()),
            Command::Finger(what) => {
                let unit = self.unit(what.finger)?;
                let start = B::cost_ticks();
                let made = unit.model.configure(&what.what.design, &what.what.how);
                let cost = B::cost_ticks().wrapping_sub(start);
                unit.has_design = made.is_ok();
                let refusal = made.map_err(|error| Refusal::Finger(Refusal::text(&error)));
                let finger = what.finger;
                self.shared.set_design(finger, refusal.is_ok().then_some(what.what));
                // It starts anew, on the object where it was set: so do the others.
                self.put_back();
                if refusal.is_ok() {
                    self.shared.tell(Event::ModelReady { finger, cost });
                }
                refusal
            }
            Command::Object(what) => {
                let support = self.settings.support;
                self.unit(what.finger)?.set_object(&what.what, support)?;
                self.put_back();
                self.shared.set_object(what.finger, what.what);
                self.setup_is_new = true;
                Ok(())
            }
            Command::Uncertainty(what) => {
                let refused = |error| Refusal::Uncertainty(Refusal::text(&error));
                self.unit(what.finger)?.set_uncertainty(what.what).map_err(refused)?;
                self.shared.set_uncertainty(what.finger, what.what);
                Ok(())
            }
            Command::Settings(settings) => {
                settings.validate(self.units.len())?;
                self.units.iter().try_for_each(|unit| unit.check_support(settings.support))?;
                for (unit, mount) in self.units.iter_mut().zip(settings.fingers) {
                    unit.set_mount(mount);
                }
                if settings.role != self.settings.role {
                    self.units.iter_mut().for_each(Unit::forget_servo);
                    self.scan = false;
                }
                if settings.fingers != self.settings.fingers {
                    self.put_back();
                }
                self.support(settings.support);
                self.settings = settings;
                (self.settings_changed, self.setup_is_new) = (true, true);
                self.shared.set(|setup| setup.settings = settings);
                Ok(())
            }
            Command::Hang => crate::provoke::hang(),
            Command::Close(CloseTo { fingers, angle, speed }) => self.lead(
                fingers,
                |_, mount| {
                    SettingsField::Angle.check(angle, mount.range[0], mount.range[1])?;
                    SettingsField::Speed.check(speed.unwrap_or(mount.speed), SPEEDS[0], SPEEDS[1])
                },
                |unit, mount| {
                    unit.rise();
                    unit.grip.head(f64::from(angle), f64::from(speed.unwrap_or(mount.speed)));
                },
            ),
            Command::Scan => {
                if !matches!(self.settings.role, Role::Master | Role::Idle) {
                    return Err(Refusal::NotMaster);
                }
                if self.units.iter().any(|unit| unit.grip.is_gripping()) {
                    return Err(Refusal::Gripping);
                }
                self.scan = true;
                Ok(())
            }
            // Nobody reads the servo meanwhile.
            Command::Grip(_) if self.scan || self.is_scanning => Err(Refusal::Scanning),
            Command::Grip(to) => self.lead(
                to.fingers,
                |unit, mount| grippable(&to, unit, mount),
                |unit, mount| {
                    unit.rise();
                    unit.grip.grip(&to.target(), &mount.limits());
                },
            ),
        }
    }

    /// The finger of this number, whether it is mounted or not.
    fn unit(&mut self, finger: u8) -> Result<&mut Unit<'a>, Refusal> {
        let last = self.units.len().saturating_sub(1) as f32;
        SettingsField::Finger.check(f32::from(finger), 0.0, last)?;
        self.units.get_mut(usize::from(finger)).ok_or(Refusal::NoServo)
    }

    /// Whether this gripper controls its servos, and has the finger.
    fn may_lead(&self, which: Which) -> Outcome {
        match self.settings.role {
            Role::Master => {}
            Role::Idle => return Err(Refusal::Idle),
            Role::Tap | Role::Device { .. } => return Err(Refusal::NotMaster),
        }
        match which {
            Which::One(finger) => {
                SettingsField::Finger.check(f32::from(finger), 0.0, self.settings.count().saturating_sub(1) as f32)
            }
            Which::All => Ok(()),
        }
    }

    /// Leads each of the fingers meant that can be: one without a servo does not keep the others from it.
    fn each(&mut self, which: Which, lead: impl Fn(&mut Unit<'a>, &messages::Mount)) -> Moved {
        self.may_lead(which)?;
        let mut heeds: Heeds = [None; FINGERS];
        for (number, (unit, heed)) in self.units.iter_mut().zip(&mut heeds).enumerate() {
            if let Some(mount) = unit.mount
                && which.is(number)
            {
                *heed = Some(if unit.health.is_present() { Heed::Done } else { Heed::NoServo });
                if unit.health.is_present() {
                    lead(unit, &mount);
                }
            }
        }
        if heeds.contains(&Some(Heed::Done)) { Ok(heeds) } else { Err(Refusal::NoServo) }
    }

    /// Leads all the fingers meant, or none if one of them cannot be.
    fn lead(
        &mut self,
        which: Which,
        check: impl Fn(&Unit<'a>, &messages::Mount) -> Outcome,
        lead: impl Fn(&mut Unit<'a>, &messages::Mount),
    ) -> Outcome {
        self.may_lead(which)?;
        let meant = |(number, unit): (usize, &Unit<'a>)| which.is(number) && unit.mount.is_some();
        for (number, unit) in self.units.iter().enumerate() {
            if let Some(mount) = &unit.mount
                && meant((number, unit))
            {
                check(unit, mount)?;
                if !unit.health.is_present() {
                    return Err(Refusal::NoServo);
                }
            }
        }
        for (number, unit) in self.units.iter_mut().enumerate() {
            if let Some(mount) = unit.mount
                && which.is(number)
            {
                lead(unit, &mount);
            }
        }
        Ok(())
    }
}

/// Whether a finger can be asked to grip so.
fn grippable(to: &GripTo, unit: &Unit<'_>, mount: &messages::Mount) -> Outcome {
    SettingsField::Force.check(to.force, 0.01, mount.force_limit)?;
    SettingsField::Speed.check(to.speed.unwrap_or(mount.speed), SPEEDS[0], SPEEDS[1])?;
    let [least, most] = mount.range;
    SettingsField::Limit.check(to.limit.unwrap_or(most), least, most)?;
    if unit.has_design && unit.has_object { Ok(()) } else { Err(Refusal::NoModel) }
}
