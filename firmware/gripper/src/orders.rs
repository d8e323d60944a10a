//! What is asked of the gripper while it runs: checked, carried out at a tick's beginning, answered.

use grip::Carry;
use messages::{
    CarryTo, CloseTo, Event, FINGERS, Gravity, GripTo, Heed, Heeds, Mount, Moved, Outcome, Refusal, Role, SPEEDS,
    SettingsField, Which,
};

use crate::board::Board;
use crate::estimation::Estimation;
use crate::hand::Hand;
use crate::return_delay;
use crate::shared::{Command, Order, Shared};
use crate::unit::Unit;

/// What was asked for, as far as it is still to be followed.
pub(crate) struct Orders {
    pub(crate) settings_changed: bool,
    /// Something was set that the control table has to show.
    pub(crate) setup_is_new: bool,
    /// The bus is to be searched, or is just being searched.
    pub(crate) scan: bool,
    pub(crate) is_scanning: bool,
}

impl Orders {
    /// Nothing yet; the control table shows nothing either.
    pub(crate) const NONE: Self = Self { settings_changed: false, setup_is_new: true, scan: false, is_scanning: false };

    /// Obeys one order, if there is one; `waiting` is for one that waits for a transaction's end. The role changes between transactions
    /// only: after that nothing more is sent. Nor does a search begin, or anything of a finger change, before the torque is off that is to be.
    pub(crate) fn obey<B: Board>(
        &mut self,
        waiting: &mut Option<Order>,
        hand: &mut Hand<'_>,
        estimation: &mut Estimation,
        between: bool,
    ) {
        receive(waiting, hand.shared);
        // It is obeyed where it lies: a finger's description takes kilobytes of the stack.
        let Some(Order { ticket, command }) = waiting else { return };
        let is_early = match command {
            Command::Settings(to) => (!between && to.role != hand.settings.role) || hand.is_any_falling(),
            Command::Scan => hand.is_any_falling(),
            _ => false,
        };
        if is_early {
            return;
        }
        // One that was refused meanwhile, because nobody waits for it any more, is never done.
        if hand.shared.claim(*ticket) {
            let outcome = match command {
                Command::Open(which) => each(hand, *which, |unit, mount| {
                    unit.rise();
                    unit.grip.open(&mount.limits());
                }),
                // A finger without torque stays so.
                Command::Hold(which) => each(hand, *which, |unit, _| {
                    if unit.torque.is_on() {
                        unit.grip.hold();
                    }
                }),
                Command::Relax(which) => each(hand, *which, |unit, _| unit.relax()),
                command => self.execute::<B>(hand, estimation, command).map(|()| Heeds::default()),
            };
            hand.shared.answer(*ticket, outcome);
        }
        *waiting = None;
    }

    /// Carries out what is asked for, or changes nothing.
    pub(crate) fn execute<B: Board>(
        &mut self,
        hand: &mut Hand<'_>,
        estimation: &mut Estimation,
        command: &Command,
    ) -> Outcome {
        match command {
            // Each finger by itself.
            Command::Open(_) | Command::Hold(_) | Command::Relax(_) => Ok(()),
            Command::Finger(what) => {
                let support = hand.settings.support;
                let unit = hand.unit(what.finger)?;
                unit.check_design(&what.what, support)?;
                let start = B::cost_ticks();
                let refusal = unit.set_design(&what.what);
                let cost = B::cost_ticks().wrapping_sub(start);
                let finger = what.finger;
                hand.shared.set_design(finger, refusal.is_ok().then_some(&what.what));
                // It starts anew, on the object where it was set: so do the others.
                estimation.put_back(hand);
                if refusal.is_ok() {
                    hand.shared.tell(Event::ModelReady { finger, cost });
                }
                refusal
            }
            Command::Object(what) => {
                hand.unit(what.finger)?.set_object(&what.what)?;
                estimation.put_back(hand);
                hand.shared.set_object(what.finger, what.what);
                self.setup_is_new = true;
                Ok(())
            }
            Command::Uncertainty(what) => {
                let refused = |error| Refusal::Uncertainty(Refusal::text(&error));
                hand.unit(what.finger)?.set_uncertainty(what.what).map_err(refused)?;
                hand.shared.set_uncertainty(what.finger, what.what);
                Ok(())
            }
            &Command::Settings(settings) => {
                settings.validate(hand.units.len())?;
                return_delay::check(&settings, B::ANSWER_US)?;
                hand.units.iter().try_for_each(|unit| unit.check_support(settings.support))?;
                let moves_like = |(mount, before): (&Option<Mount>, &Option<Mount>)| match (mount, before) {
                    (Some(mount), Some(before)) => mount.moves_like(before),
                    (mount, before) => mount == before,
                };
                let is_other_hand = !settings.fingers.iter().zip(&hand.settings.fingers).all(moves_like);
                for (unit, mount) in hand.units.iter_mut().zip(settings.fingers) {
                    unit.set_mount(mount);
                }
                if settings.role != hand.settings.role {
                    hand.units.iter_mut().for_each(Unit::forget_servo);
                    self.scan = false;
                }
                if is_other_hand {
                    estimation.put_back(hand);
                    estimation.margins.end_carry(hand);
                }
                estimation.support(hand, settings.support);
                hand.settings = settings;
                (self.settings_changed, self.setup_is_new) = (true, true);
                hand.shared.set(|setup| setup.settings = settings);
                Ok(())
            }
            Command::Hang => crate::provoke::hang(),
            &Command::Close(CloseTo { fingers, angle, speed }) => lead(
                hand,
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
                if !matches!(hand.settings.role, Role::Master | Role::Idle) {
                    return Err(Refusal::NotMaster);
                }
                if hand.is_any_gripping() {
                    return Err(Refusal::Gripping);
                }
                self.scan = true;
                Ok(())
            }
            // Nobody reads the servo meanwhile.
            Command::Grip(_) | Command::Carry(_) if self.scan || self.is_scanning => Err(Refusal::Scanning),
            Command::Grip(to) => lead(
                hand,
                to.fingers,
                |unit, mount| grippable(to, unit, mount),
                |unit, mount| {
                    unit.rise();
                    unit.grip.grip(&to.target(), &mount.limits());
                },
            ),
            Command::Carry(to) => {
                may_lead(hand, Which::All)?;
                let most = carriable(to, hand)?;
                let carry = Carry::new(f64::from(to.weight * to.safety), f64::from(most), present(hand));
                let first = to.target(carry.force());
                let grip = GripTo { fingers: Which::All, force: most, speed: to.speed, limit: to.limit };
                lead(
                    hand,
                    Which::All,
                    |unit, mount| grippable(&grip, unit, mount),
                    |unit, mount| {
                        unit.rise();
                        unit.grip.carry(&first, &mount.limits());
                    },
                )?;
                estimation.margins.carry(carry, to.pull());
                Ok(())
            }
        }
    }
}

/// Takes the next order, if none waits.
#[inline(never)]
fn receive(waiting: &mut Option<Order>, shared: &Shared) {
    if waiting.is_none() {
        *waiting = shared.orders.try_receive().ok();
    }
}

/// Whether this gripper controls its servos, and has the finger.
fn may_lead(hand: &Hand<'_>, which: Which) -> Outcome {
    match hand.settings.role {
        Role::Master => {}
        Role::Idle => return Err(Refusal::Idle),
        Role::Tap | Role::Device { .. } => return Err(Refusal::NotMaster),
    }
    match which {
        Which::One(finger) => {
            SettingsField::Finger.check(f32::from(finger), 0.0, hand.settings.count().saturating_sub(1) as f32)
        }
        Which::All => Ok(()),
    }
}

/// Leads each of the fingers meant that can be: one without a servo does not keep the others from it.
fn each(hand: &mut Hand<'_>, which: Which, lead: impl Fn(&mut Unit<'_>, &messages::Mount)) -> Moved {
    may_lead(hand, which)?;
    let mut heeds: Heeds = [None; FINGERS];
    for (number, (unit, heed)) in hand.units.iter_mut().zip(&mut heeds).enumerate() {
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
    hand: &mut Hand<'_>,
    which: Which,
    check: impl Fn(&Unit<'_>, &messages::Mount) -> Outcome,
    lead: impl Fn(&mut Unit<'_>, &messages::Mount),
) -> Outcome {
    may_lead(hand, which)?;
    let meant = |(number, unit): (usize, &Unit<'_>)| which.is(number) && unit.mount.is_some();
    for (number, unit) in hand.units.iter().enumerate() {
        if let Some(mount) = &unit.mount
            && meant((number, unit))
        {
            check(unit, mount)?;
            if !unit.health.is_present() {
                return Err(Refusal::NoServo);
            }
        }
    }
    for (number, unit) in hand.units.iter_mut().enumerate() {
        if let Some(mount) = unit.mount
            && which.is(number)
        {
            lead(unit, &mount);
        }
    }
    Ok(())
}

/// The greatest force with which a finger presses, as far as is known, N.
fn present(hand: &Hand<'_>) -> f64 {
    let fingers = hand.units.iter().filter(|unit| unit.mount.is_some());
    let known = fingers.map(|unit| &unit.last.estimate).filter(|estimate| estimate.status.is_trustworthy());
    known.map(|estimate| f64::from(estimate.force_magnitude())).fold(0.0, f64::max)
}

/// Whether fingers can be asked to carry so, and the greatest force of each, N.
fn carriable(to: &CarryTo, hand: &Hand<'_>) -> Result<f32, Refusal> {
    // One finger holds nothing.
    SettingsField::Fingers.check(hand.settings.count() as f32, 2.0, FINGERS as f32)?;
    SettingsField::Weight.check(to.weight, 1e-3, 1000.0)?;
    SettingsField::Safety.check(to.safety, 1.0, 10.0)?;
    if let Gravity::Along(angle) = to.gravity {
        SettingsField::Gravity.check(angle, -core::f32::consts::TAU, core::f32::consts::TAU)?;
    }
    let limits = hand.settings.fingers.iter().flatten().map(|mount| mount.force_limit);
    Ok(to.force.unwrap_or(limits.fold(f32::INFINITY, f32::min)))
}

/// Whether a finger can be asked to grip so.
fn grippable(to: &GripTo, unit: &Unit<'_>, mount: &messages::Mount) -> Outcome {
    SettingsField::Force.check(to.force, 0.01, mount.force_limit)?;
    SettingsField::Speed.check(to.speed.unwrap_or(mount.speed), SPEEDS[0], SPEEDS[1])?;
    let [least, most] = mount.range;
    SettingsField::Limit.check(to.limit.unwrap_or(most), least, most)?;
    if unit.has_design && unit.has_object { Ok(()) } else { Err(Refusal::NoModel) }
}
