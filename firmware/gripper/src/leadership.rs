//! The gripper as its servos' master: whom it looks for, whom it asks, and what it makes of their answers.

use dynamixel::{Id, Model as ServoModel, StatusError, xm430};
use embassy_time::{Duration, Instant};
use grip::{Health, StrainWatch, Vitals};
use heapless::Vec;
use messages::{Event, FINGERS, Reaction, Silence};

use crate::board::BusPort;
use crate::hand::Hand;
use crate::servo::{BusError, Fence, Found, Goals, Look, Servos, Turn};
use crate::shared::Shared;
use crate::unit::{Torque, Unit};

/// How often a servo that is gone is looked for while others are there: the search takes ticks from them.
const SEARCH: Duration = Duration::from_millis(250);

/// How often while a finger grips: at the others' rate only, so that it costs a gripping finger a tick or two.
const SEARCH_GRIPPING: Duration = Duration::from_secs(1);

/// How often another master on the bus is reported.
const OTHER_AGAIN: Duration = Duration::from_secs(10);
/// How long another master's last word counts as a reason for what goes wrong.
const OTHER_ABOUT: Duration = Duration::from_secs(1);

/// How often each servo is asked how warm it is, what supplies it, and whether it still holds.
const LOOK: Duration = Duration::from_secs(1);

/// What a master remembers from tick to tick.
pub(crate) struct Leadership {
    /// When a servo is looked for next, and where the search goes on.
    search: Instant,
    next_sought: usize,
    /// Whose torque is switched next, if it is to be.
    next_switched: usize,
    /// When a servo is looked at next, and which comes after that.
    look: Instant,
    next_looked: usize,
    /// When another master was last heard, and last reported.
    heard_other: Option<Instant>,
    told_other: Option<Instant>,
}

impl Leadership {
    /// Every servo is looked for at once.
    pub(crate) fn new() -> Self {
        let now = Instant::now();
        Self {
            search: now,
            next_sought: 0,
            next_switched: 0,
            look: now,
            next_looked: 0,
            heard_other: None,
            told_other: None,
        }
    }

    /// A servo that is to be looked for now, the fingers in turn. Less often while a finger grips: that costs it ticks.
    pub(crate) fn sought(&mut self, hand: &Hand<'_>) -> Option<(usize, Id)> {
        let now = Instant::now();
        let (finger, id) = self.missing(hand, now)?;
        self.search = now + if hand.is_any_gripping() { SEARCH_GRIPPING } else { SEARCH };
        self.next_sought = finger + 1;
        Some((finger, id))
    }

    #[inline(never)]
    fn missing(&self, hand: &Hand<'_>, now: Instant) -> Option<(usize, Id)> {
        if hand.is_any_present() && now < self.search {
            return None;
        }
        let missing = |(_, unit): &(usize, &Unit<'_>)| unit.mount.is_some() && !unit.health.is_present();
        let fingers = hand.units.iter().enumerate();
        let (finger, unit) = fingers.clone().skip(self.next_sought).chain(fingers).find(missing)?;
        Some((finger, unit.id()?))
    }

    /// A servo whose torque is to be changed: off, or on with this goal (counts). Those that are to be switched off come first, and each comes
    /// in its turn: one that does not obey keeps no other waiting.
    pub(crate) fn torque(&mut self, hand: &Hand<'_>) -> Option<(usize, Id, Option<i32>)> {
        let (finger, id, goal) = self.switching(hand)?;
        self.next_switched = finger + 1;
        Some((finger, id, goal))
    }

    #[inline(never)]
    fn switching(&self, hand: &Hand<'_>) -> Option<(usize, Id, Option<i32>)> {
        let fingers = hand.units.iter().enumerate();
        let turned = fingers.clone().skip(self.next_switched).chain(fingers);
        let next = |torque| turned.clone().find(|(_, unit)| unit.health.is_present() && unit.torque == torque);
        let (finger, unit) = next(Torque::Falling).or_else(|| next(Torque::Rising))?;
        Some((finger, unit.id()?, (unit.torque == Torque::Rising).then_some(unit.last.position)))
    }

    /// A servo whose own current limit is to be another one, which `unfenced` says.
    pub(crate) fn unfenced(
        hand: &Hand<'_>,
        unfenced: impl Fn(usize, Fence) -> Option<i16>,
    ) -> Option<(usize, Id, i16)> {
        hand.units.iter().enumerate().filter(|(_, unit)| unit.health.is_present()).find_map(|(finger, unit)| {
            let goal_current = unfenced(finger, unit.fence()?)?;
            Some((finger, unit.id()?, goal_current))
        })
    }

    /// A servo has or has no torque any more.
    pub(crate) fn has_torque(hand: &mut Hand<'_>, finger: usize, is_on: bool) {
        if let Some(unit) = hand.units.get_mut(finger) {
            // Meanwhile it may have been asked for the opposite.
            unit.torque = match (unit.torque, is_on) {
                (Torque::Rising, true) => Torque::On,
                (Torque::Falling, false) => Torque::Off,
                (other, _) => other,
            };
        }
    }

    /// A servo refuses to hold this goal: what it was to do is over, and the finger stays without torque.
    pub(crate) fn stays_relaxed(hand: &mut Hand<'_>, finger: usize, position: i32, error: StatusError) {
        let Some(unit) = hand.units.get_mut(finger) else { return };
        if unit.torque == Torque::Rising {
            unit.torque = Torque::Off;
            unit.grip.relax();
            hand.shared.tell(Event::GoalRefused { finger: finger as u8, position, error: error.code() });
        }
    }

    /// So many instructions of another master were heard: an event, and again when it still speaks a while later.
    pub(crate) fn overheard_others(&mut self, hand: &Hand<'_>, packets: u32) {
        if packets == 0 {
            return;
        }
        hand.shared.count(|counters| counters.bus_foreign = counters.bus_foreign.wrapping_add(packets));
        let now = Instant::now();
        self.heard_other = Some(now);
        if self.told_other.is_none_or(|told| now.saturating_duration_since(told) >= OTHER_AGAIN) {
            self.told_other = Some(now);
            hand.shared.tell(Event::OtherMaster { packets: hand.shared.counters().bus_foreign });
        }
    }

    /// Whether another master has spoken just now.
    fn is_other_about(&self) -> bool {
        self.heard_other.is_some_and(|heard| Instant::now().saturating_duration_since(heard) <= OTHER_ABOUT)
    }

    /// Ends motions whose host has gone away, if that is set.
    fn mind_host(hand: &mut Hand<'_>) {
        let reaction = match hand.settings.on_silence {
            Silence::GoOn => return,
            Silence::Hold => Reaction::Hold,
            Silence::Release => Reaction::Release,
        };
        if hand.shared.host_silence_ms() > u32::from(hand.settings.silence_ms) {
            for unit in &mut hand.units {
                if let Some(mount) = &unit.mount {
                    unit.grip.leave(&mount.limits(), reaction);
                }
            }
        }
    }

    /// Whom the tick asks.
    #[inline(never)]
    pub(crate) fn turns<U: BusPort>(hand: &Hand<'_>) -> Vec<Turn<U>, FINGERS> {
        let present = |(finger, unit): (usize, &Unit<'_>)| {
            unit.id().filter(|_| unit.health.is_present()).map(|id| Turn::new(finger, id))
        };
        // There are as many as fingers at most.
        hand.units.iter().enumerate().filter_map(present).collect()
    }

    /// Where the servos that are there go next.
    #[inline(never)]
    pub(crate) fn goals(hand: &mut Hand<'_>, seconds: f64) -> Goals {
        Self::mind_host(hand);
        let mut goals = [None; FINGERS];
        for (goal, unit) in goals.iter_mut().zip(&mut hand.units).filter(|(_, unit)| unit.health.is_present()) {
            *goal = unit.advance(seconds);
        }
        goals
    }

    /// Whether something else than a tick's question is to be done on the bus.
    #[inline(never)]
    pub(crate) fn has_more_to_do<U: BusPort>(&self, hand: &Hand<'_>, servos: &Servos<U>) -> bool {
        let now = Instant::now();
        self.missing(hand, now).is_some()
            || self.unseen(hand, now).is_some()
            || self.switching(hand).is_some()
            || Self::alerting(hand).is_some()
            || Self::unfenced(hand, |finger, fence| servos.unfenced(finger, fence)).is_some()
    }

    /// A finger's tick of so many seconds without an answer.
    #[inline(never)]
    pub(crate) fn failed<U: BusPort>(&self, hand: &mut Hand<'_>, finger: usize, error: &BusError<U>, seconds: f64) {
        count::<U>(hand.shared, error);
        if hand.units.get_mut(finger).is_some_and(|unit| unit.health.failed(seconds as f32)) {
            self.lost(hand, finger);
        }
    }

    /// A finger's servo is lost: it is looked for, and set up anew.
    #[inline(never)]
    fn lost(&self, hand: &mut Hand<'_>, finger: usize) {
        if let Some(unit) = hand.units.get_mut(finger) {
            unit.health = Health::Absent;
        }
        hand.shared.add(|counters| &mut counters.servo_losses);
        hand.shared.tell(Event::ServoLost { finger: finger as u8, other_master: self.is_other_about() });
    }

    pub(crate) fn found(hand: &mut Hand<'_>, finger: usize, id: Id, found: &Found) {
        let Found { setup, firmware, baud, goal, .. } = *found;
        let model = setup.model;
        hand.shared.set_servo(finger as u8, Some(setup));
        // Meanwhile the settings may have named another servo, or another mode: that one is looked for next.
        let is_wanted = |unit: &&mut Unit<'_>| unit.id() == Some(id) && unit.fence().is_some() == setup.is_fenced();
        let unit = hand.units.get_mut(finger).filter(is_wanted);
        if let Some(unit) = unit {
            unit.health = Health::READY;
            (unit.difference, unit.doubted) = (None, false);
            (unit.bounds, unit.watch) = (Some(found.bounds), StrainWatch::FREE);
            unit.servo = ServoModel::of(model).unwrap_or(ServoModel::ASSUMED);
            unit.gain = found.gain;
            // Its torque may be switched on before it is read.
            unit.last.position = goal;
            unit.grip.found(unit.calibration.angle(goal));
            if !unit.torque.is_on() {
                unit.relax();
            }
            hand.shared.tell(Event::ServoReady { finger: finger as u8, model, firmware, baud });
        }
    }

    /// A servo that is not what it should be: reported once.
    pub(crate) fn differs(hand: &mut Hand<'_>, finger: usize, found: &Found) {
        hand.shared.set_servo(finger as u8, Some(found.setup));
        if let (Some(unit), Some(difference)) = (hand.units.get_mut(finger), found.difference)
            && unit.difference.replace(difference) != Some(difference)
        {
            hand.shared.tell(Event::ServoDiffers { finger: finger as u8, difference });
        }
    }

    /// A servo that is to be looked at: the fingers in turn, and those in doubt at once.
    pub(crate) fn looks_at(&mut self, hand: &Hand<'_>) -> Option<(usize, Id)> {
        let now = Instant::now();
        let (finger, id) = self.unseen(hand, now)?;
        if now >= self.look {
            let count = hand.units.iter().filter(|unit| Self::can_be_seen(unit)).count().max(1);
            self.look = now + LOOK / count as u32;
            self.next_looked = finger + 1;
        }
        Some((finger, id))
    }

    fn can_be_seen(unit: &Unit<'_>) -> bool {
        unit.health.is_present() && unit.bounds.is_some()
    }

    #[inline(never)]
    fn unseen(&self, hand: &Hand<'_>, now: Instant) -> Option<(usize, Id)> {
        let is_due = now >= self.look;
        let fingers = hand.units.iter().enumerate();
        let mut turned = fingers.clone().skip(self.next_looked).chain(fingers);
        let (finger, unit) = turned.find(|(_, unit)| Self::can_be_seen(unit) && (is_due || unit.doubted))?;
        Some((finger, unit.id()?))
    }

    /// A servo was looked at. One that does not hold any more, though nobody asked for that, was without power for a moment, or another
    /// program has written to it.
    pub(crate) fn looked<U: BusPort>(&self, hand: &mut Hand<'_>, finger: usize, look: &Result<Look, BusError<U>>) {
        let Some(unit) = hand.units.get_mut(finger) else { return };
        unit.doubted &= look.is_err();
        match look {
            Ok(Look { holds, is_changed, .. })
                if unit.health.is_present() && (*is_changed || (unit.torque == Torque::On && !holds)) =>
            {
                self.lost(hand, finger);
            }
            Ok(Look { vitals, .. }) => {
                let Some(bounds) = unit.bounds else { return };
                if let Some((derating, strain)) = unit.watch.see(*vitals, bounds, hand.settings.margins()) {
                    let Vitals { temperature, voltage } = *vitals;
                    let volts = f32::from(voltage) * xm430::VOLTS_PER_UNIT;
                    hand.shared.tell(Event::Derated { finger: finger as u8, derating, strain, temperature, volts });
                }
            }
            Err(error) => count::<U>(hand.shared, error),
        }
    }

    /// A servo whose hardware errors have changed.
    #[inline(never)]
    pub(crate) fn alerting(hand: &Hand<'_>) -> Option<(usize, Id)> {
        let alerting = |(_, unit): &(usize, &Unit<'_>)| unit.health.is_present() && unit.alert_changed;
        let (finger, unit) = hand.units.iter().enumerate().find(alerting)?;
        Some((finger, unit.id()?))
    }

    pub(crate) fn alerted<U: BusPort>(hand: &mut Hand<'_>, finger: usize, status: &Result<u8, BusError<U>>) {
        let Ok(hardware_error) = *status else {
            if let Err(error) = status {
                count::<U>(hand.shared, error);
            }
            return;
        };
        if let Some(unit) = hand.units.get_mut(finger) {
            unit.alert_changed = false;
            if hardware_error == 0 {
                // Only a restart clears an error, and it leaves the torque off: the servo is set up anew.
                unit.health = Health::Absent;
            }
        }
        hand.shared.tell(Event::ServoAlert { finger: finger as u8, hardware_error });
    }
}

/// Counts an error of the bus.
pub(crate) fn count<U: BusPort>(shared: &Shared, error: &BusError<U>) {
    use dynamixel::Error;
    shared.count(|counters| {
        let counter = match error {
            Error::Timeout { .. } | Error::Truncated { .. } => &mut counters.bus_timeouts,
            Error::Damaged(_) | Error::Babble { .. } | Error::Block { .. } => &mut counters.bus_damaged,
            Error::Refused { .. } => &mut counters.bus_refused,
            _ => &mut counters.bus_other,
        };
        *counter = counter.wrapping_add(1);
    });
}

#[cfg(test)]
mod tests {
    use messages::{Mount, ServoSetup};

    use super::*;

    const FOUND: Found = Found {
        setup: ServoSetup { model: xm430::MODEL, operating_mode: xm430::POSITION_CONTROL, ..ServoSetup::UNREAD },
        firmware: 45,
        baud: 1_000_000,
        goal: 3000,
        gain: 800,
        bounds: grip::Bounds { temperature: 80, voltage: 95 },
        difference: None,
    };

    /// A hand with one finger, whose servo is gone.
    fn hand(mount: Mount) -> Hand<'static> {
        let mut hand = Hand::new(std::boxed::Box::leak(std::boxed::Box::default()));
        let model = std::boxed::Box::leak(std::boxed::Box::new(crate::Model::EMPTY));
        assert!(hand.units.push(Unit::new(0, model, Some(mount))).is_ok());
        hand
    }

    /// Unseen and without torque it may have been moved by hand. Switched on before its position is read again, it holds where it was found.
    #[test]
    fn a_servo_that_is_found_holds_where_it_was_found() {
        let id = Id::new(1).unwrap();
        for torque in [Torque::Off, Torque::Rising] {
            let mut hand = hand(Mount::DEFAULT);
            (hand.units[0].torque, hand.units[0].last.position) = (torque, 1000);
            Leadership::found(&mut hand, 0, id, &FOUND);
            hand.units[0].rise();
            assert_eq!(Leadership::new().torque(&hand), Some((0, id, Some(FOUND.goal))), "{torque:?}");
        }
    }

    /// The servo's own limit is chosen while it is just being set up without: it is looked for again.
    #[test]
    fn a_servo_that_was_found_in_another_mode_is_looked_for_again() {
        let id = Id::new(1).unwrap();
        for (current_fence, is_present) in [(false, true), (true, false)] {
            let mut hand = hand(Mount { current_fence, ..Mount::DEFAULT });
            Leadership::found(&mut hand, 0, id, &FOUND);
            assert_eq!(hand.units[0].health.is_present(), is_present);
        }
    }
}
