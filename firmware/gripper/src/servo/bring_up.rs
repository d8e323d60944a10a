//! How a servo is found and taken over: what is read of it, what may be written to it, and when it is left alone.

use dynamixel::xm430;
use dynamixel::{Id, Identity, Layout, Model, Register, StatusReturn, Timing, Value};
use grip::Bounds;
use messages::{Difference, ServoField, ServoSetup};

use super::{BusError, Fence, Servos};
use crate::board::BusPort;

/// What outlives the servo's power, from Baud Rate to Startup Configuration, read at once.
const KEPT: u16 = xm430::BAUD_RATE.address();
const KEPT_BYTES: usize = (xm430::STARTUP_CONFIGURATION.address() + 1 - KEPT) as usize;
/// What does not, from Torque Enable to Position Trajectory: all of one instant. (The P series has it elsewhere, in the same order.)
const LIVE: u16 = xm430::TORQUE_ENABLE.address();
const LIVE_BYTES: usize = (xm430::POSITION_TRAJECTORY.address() + 4 - LIVE) as usize;

/// Answers in a row that are garbled, or do not come, each beside a sound one to a ping, that are not the bus's noise: with bit errors of
/// 1e-3 a short answer is damaged once in nine times.
const NOT_NOISE: u32 = 5;

/// A servo that was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Found {
    /// How it is set.
    pub(crate) setup: ServoSetup,
    pub(crate) firmware: u8,
    /// Bits per second.
    pub(crate) baud: u32,
    /// Where it is taken to, counts (4096 per revolution).
    pub(crate) goal: i32,
    /// Its control's proportional gain.
    pub(crate) gain: u16,
    /// Where it shuts down.
    pub(crate) bounds: Bounds,
    /// What is not as it should be: it is not controlled, and nothing but its mode was written to it.
    pub(crate) difference: Option<Difference>,
}

/// Rates of the bus, bits per second.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rates {
    /// At which a servo is looked for.
    pub(crate) look: u32,
    /// To which one without torque is set, unless others are controlled.
    pub(crate) wanted: Option<u32>,
    /// At which others are controlled.
    pub(crate) bus: Option<u32>,
}

/// What a servo is to be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    /// How it was set when it was commissioned.
    pub(crate) commissioned: Option<ServoSetup>,
    /// What it is to limit its current to, by current-based position control.
    pub(crate) fence: Option<Fence>,
    /// Whether it is to have torque.
    pub(crate) holds: bool,
}

impl Wanted {
    /// Its Operating Mode.
    fn mode(&self) -> u8 {
        match self.fence {
            Some(_) => xm430::CURRENT_BASED_POSITION_CONTROL,
            None => xm430::POSITION_CONTROL,
        }
    }
}

/// How a servo that answers pings answers reads: not at all, as with Status Return Level 0, or garbled, as two of one address do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Silent(bool);

impl<U: BusPort> Servos<U> {
    /// Looks for a finger's servo at one rate, makes it answer at once and, if it is to have torque, hold its position.
    ///
    /// One that is not set as it was commissioned, or of a model that is not known, is left as it is. One that already has torque keeps
    /// that, its settings and its goal: it may be holding something, and it holds with what its goal is ahead of its position. Its Bus
    /// Watchdog alone is switched off.
    pub(crate) async fn bring_up(
        &mut self,
        finger: usize,
        id: Id,
        rates: Rates,
        wanted: Wanted,
    ) -> Result<Found, BusError<U>> {
        self.wrote(finger, None);
        self.is_fenced_by(finger, None);
        // It is found anew, perhaps set anew: what it was counts no more, what the others are does.
        self.delays_by(finger, 0);
        let mut found = self.look_for(finger, id, rates, wanted).await;
        let mut rate = self.master.timing().baud_rate;
        if let Some(bus) = rates.bus.filter(|bus| *bus != rate) {
            // The other servos are led at theirs.
            rate = bus;
            self.master.port_mut().set_baud(bus);
            // It cannot be led with them: for this bus it is silent.
            found = found.and(Err(dynamixel::Error::Timeout { id, waited_us: 0 }));
        }
        self.listen_to_all_at(rate);
        if let Ok(found) = &found {
            self.wrote(finger, Some(found.goal));
            self.reads_fast(finger, Identity { model: found.setup.model, firmware: found.firmware }.reads_fast());
        }
        found
    }

    async fn look_for(&mut self, finger: usize, id: Id, rates: Rates, wanted: Wanted) -> Result<Found, BusError<U>> {
        let baud_rate = self.master.port_mut().set_baud(rates.look);
        self.listen_at(baud_rate, xm430::RETURN_DELAY_TIME.item.max as u32);
        let Identity { model: number, firmware } = self.master.ping(id).await?.value;
        let unread = |field, found, expected| Found {
            setup: ServoSetup { model: number, ..ServoSetup::UNREAD },
            firmware,
            baud: baud_rate,
            goal: 0,
            gain: 0,
            bounds: Bounds { temperature: 0, voltage: 0 },
            difference: Some(Difference { field, found, expected }),
        };
        let Some(model) = Model::of(number) else {
            // Its registers may mean something else.
            return Ok(unread(ServoField::Model, i32::from(number), 0));
        };
        let mode = wanted.mode();
        if !model.modes.contains(&mode) {
            return Ok(unread(ServoField::GoalCurrent, 0, i32::from(mode)));
        }
        self.is_a(finger, model);
        let live_at = model.at(xm430::TORQUE_ENABLE).address();
        let mut live = [0; LIVE_BYTES];
        let level = match self.master.read(id, live_at, &mut live).await {
            Ok(_) => of(xm430::STATUS_RETURN_LEVEL, LIVE, &live),
            Err(error) => match self.answers_pings_only(id, model).await {
                Some(Silent(true)) => 0,
                Some(Silent(false)) => {
                    let address = i32::from(id.get());
                    return Ok(unread(ServoField::Id, address, address));
                }
                None => return Err(error),
            },
        };
        if level != 2 {
            // The servo forgets this with its power, and without it nothing could be verified: it is found so the next time.
            self.tell(id, model.at(xm430::STATUS_RETURN_LEVEL), 2).await?;
            self.master.read(id, live_at, &mut live).await?;
            return Ok(unread(ServoField::StatusReturnLevel, i32::from(level), 2));
        }
        let mut kept = [0; KEPT_BYTES];
        let there = kept.get_mut(..kept_bytes(model.layout)).unwrap_or_default();
        self.master.read(id, KEPT, there).await?;
        // The servo knows its rate better than the board's divider.
        let mut baud = model.bits_per_second(of(xm430::BAUD_RATE, KEPT, &kept)).unwrap_or(baud_rate);
        let torque = of(xm430::TORQUE_ENABLE, LIVE, &live) != 0;
        let mut setup = setup(number, &kept);
        let bounds = Bounds {
            temperature: of(xm430::TEMPERATURE_LIMIT, KEPT, &kept),
            voltage: of(xm430::MIN_VOLTAGE_LIMIT, KEPT, &kept),
        };
        let watchdog = of(xm430::BUS_WATCHDOG, LIVE, &live);
        let mut difference = differs(&setup, &wanted, torque, watchdog);
        if difference.is_none() && !torque && setup.operating_mode != mode {
            self.master.set(id, xm430::OPERATING_MODE, mode).await?;
            // That has given the gains and the goals their defaults, and taken the position back to one revolution.
            self.master.read(id, live_at, &mut live).await?;
            setup.operating_mode = mode;
        }
        let position = of(xm430::PRESENT_POSITION, LIVE, &live);
        difference = difference.or_else(|| beyond(&setup, mode, position, torque));
        if difference.is_some() {
            if watchdog < 0 {
                // It holds where it stopped; cleared, it takes goals again, and is found so the next time.
                self.master.set(id, model.at(xm430::BUS_WATCHDOG), 0).await?;
            }
            return Ok(Found { setup, firmware, baud, goal: 0, gain: 0, bounds, difference });
        }
        if watchdog > 0 {
            // Another program has armed it: in any pause of the bus, that of a restart too, the servo would stop where it is, without the
            // torque that it holds with.
            self.master.set(id, model.at(xm430::BUS_WATCHDOG), 0).await?;
        }
        let mut delay: u8 = of(xm430::RETURN_DELAY_TIME, KEPT, &kept);
        if !torque {
            // Only what is otherwise is written: the EEPROM wears.
            if delay != 0 {
                self.master.set(id, xm430::RETURN_DELAY_TIME, 0).await?;
            }
            delay = 0;
            // Others that have torque are still where they were: it goes on with them.
            let wanted = rates.wanted.map(|wanted| rates.bus.unwrap_or(wanted));
            if let Some(wanted) = wanted.filter(|wanted| *wanted != baud)
                && let Some(code) = model.baud_code(wanted)
                && self.reaches(wanted, rates.look)
            {
                // It answers at the old rate.
                self.master.set(id, xm430::BAUD_RATE, code).await?;
                self.master.port_mut().set_baud(wanted);
                self.listen_at(wanted, xm430::RETURN_DELAY_TIME.item.max as u32);
                self.master.ping(id).await?;
                baud = wanted;
            }
        }
        self.delays_by(finger, delay);
        self.listen_at(baud, u32::from(delay));
        if let Some(fence) = wanted.fence {
            // Before the torque: its current may be anything else.
            let most = i16::try_from(of(xm430::CURRENT_LIMIT, KEPT, &kept)).unwrap_or(i16::MAX);
            self.is_fenced_by(finger, Some(most));
            self.fence(finger, id, fence.goal_current(model, most)).await?;
        }
        let goal = if torque { kept_goal(model, &live) } else { position };
        if goal != of(xm430::GOAL_POSITION, LIVE, &live) {
            self.master.set(id, model.at(xm430::GOAL_POSITION), goal).await?;
        }
        if !torque && wanted.holds {
            match self.master.set(id, model.at(xm430::TORQUE_ENABLE), 1).await {
                // After a shutdown the servo can be read, not led, until it is restarted; its alert tells.
                Ok(_) | Err(dynamixel::Error::Refused { alert: true, .. }) => {}
                Err(error) => return Err(error),
            }
        }
        let (goal, gain) = (model.to_4096ths(goal), of(xm430::POSITION_P_GAIN, LIVE, &live));
        Ok(Found { setup, firmware, baud, goal, gain, bounds, difference: None })
    }

    /// Whether an address answers pings soundly and never a short read that differs from servo to servo, and if so, how.
    async fn answers_pings_only(&mut self, id: Id, model: &Model) -> Option<Silent> {
        let mut all = None;
        for _ in 0..NOT_NOISE {
            let mut position = [0; 4];
            let answer = self.master.read(id, model.at(xm430::PRESENT_POSITION).address(), &mut position).await;
            let silent = Silent(match answer {
                Ok(_) | Err(dynamixel::Error::Port(_)) => return None,
                Err(error) => matches!(error, dynamixel::Error::Timeout { .. }),
            });
            if all.replace(silent).is_some_and(|before| before != silent) || self.master.ping(id).await.is_err() {
                return None;
            }
        }
        all
    }

    /// Writes without waiting for an answer, which may not come.
    async fn tell<T: Value>(&mut self, id: Id, register: Register<T>, value: T) -> Result<(), BusError<U>> {
        let timing = self.master.timing();
        self.master.set_timing(Timing { status_return: StatusReturn::Ping, ..timing });
        let told = self.master.set(id, register, value).await;
        self.master.set_timing(timing);
        // An answer that came all the same is not the next one's.
        let _ = self.master.ping(id).await;
        told.map(|_| ())
    }
}

/// A register's value within what was read from an address on.
fn of<T: Value>(register: Register<T>, from: u16, bytes: &[u8]) -> T {
    let from = usize::from(register.address().saturating_sub(from));
    let mut value = [0; 4];
    let read = bytes.get(from..from + usize::from(T::LENGTH)).unwrap_or_default();
    value.iter_mut().zip(read).for_each(|(to, byte)| *to = *byte);
    T::from_bytes(value)
}

/// How many bytes of it a servo has: the P series has no Startup Configuration, which then is 0 here.
fn kept_bytes(layout: Layout) -> usize {
    match layout {
        Layout::X => KEPT_BYTES,
        Layout::P => usize::from(xm430::MIN_POSITION_LIMIT.item.end() - KEPT),
    }
}

/// How a servo is set.
fn setup(model: u16, kept: &[u8; KEPT_BYTES]) -> ServoSetup {
    // Signed where the P series has them; the X series' are below 4096.
    let limits = [xm430::MIN_POSITION_LIMIT, xm430::MAX_POSITION_LIMIT].map(|register| of(register, KEPT, kept));
    ServoSetup {
        model,
        operating_mode: of(xm430::OPERATING_MODE, KEPT, kept),
        drive_mode: of(xm430::DRIVE_MODE, KEPT, kept),
        homing_offset: of(xm430::HOMING_OFFSET, KEPT, kept),
        position_limits: limits.map(|limit| limit.cast_signed()),
        startup: of(xm430::STARTUP_CONFIGURATION, KEPT, kept),
    }
}

/// The goal of a servo with torque. One that its profile is still moving stops where the profile is, with the torque that it has there.
/// One that is further from its goal than its torque can grow is held where it is.
fn kept_goal(model: &Model, live: &[u8; LIVE_BYTES]) -> i32 {
    let trajectory: i32 = of(xm430::POSITION_TRAJECTORY, LIVE, live);
    let position = of(xm430::PRESENT_POSITION, LIVE, live);
    let gain = of(xm430::POSITION_P_GAIN, LIVE, live);
    // Beyond it the output is the whole voltage. (Without a gain no torque depends on the goal.)
    let reach = (128 * u32::from(model.full_pwm)).checked_div(u32::from(gain)).unwrap_or(0);
    if trajectory.abs_diff(position) <= reach { trajectory } else { position }
}

/// Why a servo is not controlled, if it is not.
fn differs(found: &ServoSetup, wanted: &Wanted, torque: bool, watchdog: i8) -> Option<Difference> {
    let is = |field, found, expected| Some(Difference { field, found, expected });
    let difference = match wanted.commissioned {
        Some(commissioned) => commissioned.difference(found),
        // One without torque is set to it.
        // Its torque is on before anything can be set.
        None if found.startup != 0 => is(ServoField::StartupConfiguration, i32::from(found.startup), 0),
        None if torque && found.operating_mode != wanted.mode() => {
            is(ServoField::OperatingMode, i32::from(found.operating_mode), i32::from(wanted.mode()))
        }
        None => None,
    };
    difference.or_else(|| if watchdog < 0 { is(ServoField::BusWatchdog, i32::from(watchdog), 0) } else { None })
}

/// A servo without torque that is where it takes no goal: to hold it there is not possible. Current-based position control takes goals of
/// several revolutions, whatever the limits are.
fn beyond(setup: &ServoSetup, mode: u8, position: i32, torque: bool) -> Option<Difference> {
    let [least, most] = setup.position_limits;
    let nearest = position.max(least).min(most);
    let is_limited = mode == xm430::POSITION_CONTROL;
    (is_limited && !torque && nearest != position).then_some(Difference {
        field: ServoField::PresentPosition,
        found: position,
        expected: nearest,
    })
}
