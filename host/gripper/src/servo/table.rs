//! The XM430's control table: what the registers do to the motor, and what they show of it.

use dynamixel::{
    ControlTable, Id, Part, Register, ResetScope, StatusError, StatusReturn, Value, check_read, writes, xm430,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::config::{COUNTS_PER_RADIAN, Clock, Config, ConfigError};
use super::control::{Ceiling, Control, FULL_PWM, Gains};
use super::mode::Mode;
use super::motor::{Gear, Motor, Supply};
use super::profile::{ACCELERATION_UNIT, Limits, Profile, SPEED_UNIT};
use super::surroundings::Surroundings;
use crate::datasheet::{FREE_SPEED, NOMINAL_VOLTAGE, STALL_TORQUE, TORQUE_CONSTANT};

/// Bytes of the table: to the end of Present Temperature.
const LENGTH: usize = 147;
/// The longest step in time, s.
const STEP: f64 = 5e-4;
/// Distance to the trajectory beyond which the servo does not follow it, counts. An assumption: about 2°.
const FOLLOWING: f64 = 24.0;
/// The servo says it has reached its goal within this distance, counts. An assumption.
const IN_POSITION: f64 = 4.0;
/// Overload is an error after so many seconds. An assumption; the manual says "persistent".
const OVERLOAD_AFTER: f64 = 1.0;
/// Bits of Hardware Error Status and Shutdown.
const INPUT_VOLTAGE: u8 = 1;
const OVERHEATING: u8 = 1 << 2;
const OVERLOAD: u8 = 1 << 5;
/// Drive Mode: positions, speeds, currents and PWM count the other way round.
const REVERSE: u8 = 1;
/// Drive Mode: profiles are given as times.
const TIME_BASED: u8 = 1 << 2;
/// Drive Mode: a goal turns the torque on.
const TORQUE_BY_GOAL: u8 = 1 << 3;
/// Startup Configuration: the torque comes on with the power.
const TORQUE_AT_START: u8 = 1;
/// Microseconds of one unit of Bus Watchdog.
const WATCHDOG_US: u64 = 20_000;

/// Registers that do nothing here: only their defaults are taken.
const NOT_SIMULATED: [dynamixel::Item; 4] = [
    xm430::SECONDARY_ID.item,
    xm430::PROTOCOL_TYPE.item,
    xm430::FEEDFORWARD_1ST_GAIN.item,
    xm430::FEEDFORWARD_2ND_GAIN.item,
];

/// Registers and motor.
#[derive(Clone, Debug)]
pub struct Xm430 {
    memory: [u8; LENGTH],
    clock: Clock,
    noise_ma: f64,
    random: ChaCha8Rng,
    /// Motor and finger.
    pub(super) motor: Motor,
    control: Control,
    /// Position gains that the RAM has after power-on.
    gains: Gains,
    pub(super) surroundings: Surroundings,
    profile: Profile,
    /// When the profile began, µs.
    began_us: u64,
    /// The servo's time, µs since power-on.
    pub(super) now_us: u64,
    /// Last instruction that touched the table, µs.
    touched_us: u64,
    /// Counts by which Clear has moved the position: whole turns.
    turns: f64,
    /// Reads of Present Position.
    pub(super) position_reads: u64,
}

impl Xm430 {
    pub(super) fn new(config: &Config) -> Result<Self, ConfigError> {
        config.check()?;
        let gear = Gear {
            zero: f64::from(config.zero_count),
            direction: if config.closing_up { 1.0 } else { -1.0 },
            pitch: COUNTS_PER_RADIAN.recip(),
            half_play: config.backlash_deg.to_radians() * COUNTS_PER_RADIAN / 2.0,
        };
        let start = config.start();
        let mut table = Self {
            memory: [0; LENGTH],
            clock: config.clock,
            noise_ma: config.noise_ma,
            random: ChaCha8Rng::seed_from_u64(config.seed),
            motor: Motor::new(gear, config.load.clone(), start),
            control: Control::default(),
            gains: config.gains,
            surroundings: Surroundings::default(),
            profile: Profile::at(start),
            began_us: 0,
            now_us: 0,
            touched_us: 0,
            turns: 0.0,
            position_reads: 0,
        };
        for item in &xm430::ITEMS {
            table.restore(item);
        }
        table.put(xm430::ID, config.id);
        table.put(xm430::FIRMWARE_VERSION, config.firmware);
        table.put(xm430::MODEL_NUMBER, config.model);
        table.put(xm430::BAUD_RATE, xm430::baud_code(config.baud_rate).unwrap_or(1));
        table.put(xm430::RETURN_DELAY_TIME, (config.return_delay_us / xm430::RETURN_DELAY_US_PER_UNIT) as u8);
        table.power_on();
        Ok(table)
    }

    /// The value of a register as it was last refreshed.
    pub(super) fn get<T: Value>(&self, register: Register<T>) -> T {
        let from = usize::from(register.address());
        let mut bytes = [0; 4];
        for (to, byte) in bytes.iter_mut().zip(&self.memory[from..from + usize::from(T::LENGTH)]) {
            *to = *byte;
        }
        T::from_bytes(bytes)
    }

    fn put<T: Value>(&mut self, register: Register<T>, value: T) {
        let from = usize::from(register.address());
        let length = usize::from(T::LENGTH);
        self.memory[from..from + length].copy_from_slice(&value.to_bytes()[..length]);
    }

    fn restore(&mut self, item: &dynamixel::Item) {
        let from = usize::from(item.address);
        let length = usize::from(item.length);
        self.memory[from..from + length].copy_from_slice(&item.default.to_le_bytes()[..length]);
    }

    /// RAM as after power-on: the goal is where the servo is, the torque is off.
    fn power_on(&mut self) {
        for item in xm430::ITEMS.iter().filter(|item| item.area == dynamixel::Area::Ram) {
            self.restore(item);
        }
        self.put(xm430::GOAL_PWM, self.get(xm430::PWM_LIMIT) as i16);
        self.put(xm430::GOAL_CURRENT, self.get(xm430::CURRENT_LIMIT) as i16);
        self.put(xm430::GOAL_VELOCITY, 0);
        self.put(xm430::POSITION_P_GAIN, self.gains.p);
        self.put(xm430::POSITION_I_GAIN, self.gains.i);
        self.put(xm430::POSITION_D_GAIN, self.gains.d);
        self.hold();
        if self.get(xm430::STARTUP_CONFIGURATION) & TORQUE_AT_START != 0 {
            self.put(xm430::TORQUE_ENABLE, 1);
        }
        self.refresh();
    }

    /// Makes the present position the goal.
    fn hold(&mut self) {
        self.put(xm430::GOAL_POSITION, self.shown(self.motor.position));
        self.profile = Profile::at(self.motor.position);
        self.began_us = self.now_us;
        self.control.clear();
    }

    fn torque_on(&self) -> bool {
        self.get(xm430::TORQUE_ENABLE) != 0
    }

    /// What is added to the encoder's position.
    fn offset(&self) -> f64 {
        f64::from(self.get(xm430::HOMING_OFFSET)) - self.turns
    }

    /// A position as the registers show it: a whole count. (The manual does not say about which one Reverse turns it: about the middle of the
    /// revolution is assumed.)
    fn shown(&self, position: f64) -> i32 {
        let turned = if self.sign() < 0.0 { f64::from(xm430::COUNTS_PER_REVOLUTION) - position } else { position };
        (turned + self.offset()).round() as i32
    }

    /// The encoder's position of a register's.
    fn position_of(&self, shown: i32) -> f64 {
        let turned = f64::from(shown) - self.offset();
        if self.sign() < 0.0 { f64::from(xm430::COUNTS_PER_REVOLUTION) - turned } else { turned }
    }

    /// −1 if the servo counts the other way round.
    fn sign(&self) -> f64 {
        if self.get(xm430::DRIVE_MODE) & REVERSE != 0 { -1.0 } else { 1.0 }
    }

    /// Present Position, counts.
    pub(super) fn present_position(&self) -> i32 {
        self.shown(self.motor.position)
    }

    fn since_us(&self) -> f64 {
        (self.now_us - self.began_us) as f64 * 1e-6
    }

    /// Lets time pass, up to `until_us` after power-on.
    pub(super) fn advance(&mut self, until_us: u64) {
        let watchdog = self.get(xm430::BUS_WATCHDOG);
        if self.torque_on() && watchdog > 0 {
            let bark_us = self.touched_us + watchdog as u64 * WATCHDOG_US;
            if bark_us < until_us {
                self.go_on(bark_us);
                self.put(xm430::BUS_WATCHDOG, -1);
                self.hold();
            }
        }
        self.go_on(until_us);
    }

    fn go_on(&mut self, until_us: u64) {
        if until_us <= self.now_us {
            return;
        }
        let (since, seconds) = (self.since_us(), (until_us - self.now_us) as f64 * 1e-6);
        // Equal steps: a remainder of rounding would be a step of no time.
        let steps = (seconds / STEP).ceil().max(1.0);
        let step = seconds / steps;
        let volts = self.surroundings.volts;
        for passed in 0..steps as u64 {
            let now = since + (passed + 1) as f64 * step;
            let supply = self.supply(now, step);
            self.motor.step(supply, volts, step);
            if self.motor.speed == 0.0 && self.is_settled(now) {
                // Nothing changes any more.
                self.motor.step(supply, volts, (steps - 1.0 - passed as f64) * step);
                break;
            }
        }
        self.now_us = until_us;
        self.surroundings.warm(self.motor.torque, seconds);
        if self.motor.overloaded > OVERLOAD_AFTER {
            self.fail(OVERLOAD);
        }
        if self.surroundings.temperature >= f64::from(self.get(xm430::TEMPERATURE_LIMIT)) {
            self.fail(OVERHEATING);
        }
        let voltage = self.surroundings.voltage();
        if voltage < self.get(xm430::MIN_VOLTAGE_LIMIT) || voltage > self.get(xm430::MAX_VOLTAGE_LIMIT) {
            self.fail(INPUT_VOLTAGE);
        }
    }

    /// Whether a motor at rest gets the same from now on.
    fn is_settled(&self, since: f64) -> bool {
        let position = Mode::of(self.get(xm430::OPERATING_MODE)).is_some_and(Mode::is_position);
        !self.torque_on()
            || (position && since >= self.profile.duration() && self.get(xm430::POSITION_I_GAIN) == 0)
            || matches!(Mode::of(self.get(xm430::OPERATING_MODE)), Some(Mode::Current | Mode::Pwm))
    }

    /// What drives the motor, so many seconds into its profile.
    fn supply(&mut self, since: f64, step: f64) -> Supply {
        if !self.torque_on() {
            return Supply::Off;
        }
        let sign = self.sign();
        let amperes = |units: i16| f64::from(units) * f64::from(xm430::MILLIAMPERES_PER_UNIT) / 1000.0;
        let duty = f64::from(self.get(xm430::GOAL_PWM)).abs() / FULL_PWM;
        let mode = Mode::of(self.get(xm430::OPERATING_MODE)).unwrap_or(Mode::Position);
        let torque = match mode {
            Mode::CurrentBasedPosition => amperes(self.get(xm430::GOAL_CURRENT)).abs() * TORQUE_CONSTANT,
            _ => f64::INFINITY,
        };
        let ceiling = Ceiling { duty, torque };
        match mode {
            Mode::Current => Supply::Torque(sign * amperes(self.get(xm430::GOAL_CURRENT)) * TORQUE_CONSTANT),
            Mode::Pwm => {
                let at_rest = sign * f64::from(self.get(xm430::GOAL_PWM)) / FULL_PWM;
                Supply::Duty { at_rest, per_speed: 0.0, most: 1.0, torque }
            }
            Mode::Velocity => {
                let gains = Gains { p: self.get(xm430::VELOCITY_P_GAIN), i: self.get(xm430::VELOCITY_I_GAIN), d: 0 };
                let to = sign * f64::from(self.get(xm430::GOAL_VELOCITY)) * SPEED_UNIT;
                self.control.velocity(gains, to, SPEED_UNIT, &self.motor, ceiling, step)
            }
            Mode::Position | Mode::ExtendedPosition | Mode::CurrentBasedPosition => {
                let gains = Gains {
                    p: self.get(xm430::POSITION_P_GAIN),
                    i: self.get(xm430::POSITION_I_GAIN),
                    d: self.get(xm430::POSITION_D_GAIN),
                };
                self.control.position(gains, self.profile.after(since), &self.motor, ceiling, step)
            }
        }
    }

    /// A hardware error; it turns the torque off if Shutdown says so.
    pub(super) fn fail(&mut self, bits: u8) {
        let errors = self.get(xm430::HARDWARE_ERROR_STATUS) | bits;
        self.put(xm430::HARDWARE_ERROR_STATUS, errors);
        if errors & self.get(xm430::SHUTDOWN) != 0 {
            self.put(xm430::TORQUE_ENABLE, 0);
        }
    }

    /// Starts the way to Goal Position from where the trajectory is.
    fn set_out(&mut self) {
        let (position, speed) = self.profile.after(self.since_us());
        let goal = self.position_of(self.get(xm430::GOAL_POSITION));
        let (first, second) = (self.get(xm430::PROFILE_VELOCITY), self.get(xm430::PROFILE_ACCELERATION));
        let (first, second) = (f64::from(first), f64::from(second));
        let limits = if self.get(xm430::DRIVE_MODE) & TIME_BASED != 0 {
            Limits::timed(goal - position, first, second)
        } else {
            Limits { speed: first * SPEED_UNIT, acceleration: second * ACCELERATION_UNIT }
        };
        self.profile = Profile::new(position, speed, goal, limits);
        self.began_us = self.now_us;
    }

    /// What the manual refuses beyond the ranges of the items.
    fn refuses(&self, part: &Part<'_>) -> Result<(), StatusError> {
        let within = |limit: i64| if part.value.abs() <= limit { Ok(()) } else { Err(StatusError::DataLimit) };
        let item = part.item;
        if item == xm430::GOAL_POSITION.item && self.get(xm430::OPERATING_MODE) == xm430::POSITION_CONTROL {
            let least = i64::from(self.get(xm430::MIN_POSITION_LIMIT));
            let greatest = i64::from(self.get(xm430::MAX_POSITION_LIMIT));
            if !(least..=greatest).contains(&part.value) {
                return Err(StatusError::DataLimit);
            }
        }
        let goals =
            [xm430::GOAL_POSITION.item, xm430::GOAL_PWM.item, xm430::GOAL_CURRENT.item, xm430::GOAL_VELOCITY.item];
        if goals.contains(&item) && self.get(xm430::BUS_WATCHDOG) < 0 {
            return Err(StatusError::DataRange);
        }
        if item == xm430::GOAL_PWM.item {
            within(i64::from(self.get(xm430::PWM_LIMIT)))
        } else if item == xm430::GOAL_CURRENT.item {
            within(i64::from(self.get(xm430::CURRENT_LIMIT)))
        } else if item == xm430::GOAL_VELOCITY.item {
            within(i64::from(self.get(xm430::VELOCITY_LIMIT)))
        } else if item == xm430::OPERATING_MODE.item {
            let known = u8::try_from(part.value).ok().and_then(Mode::of);
            if known.is_some() { Ok(()) } else { Err(StatusError::DataRange) }
        } else if NOT_SIMULATED.contains(&item) && part.value != item.default {
            Err(StatusError::DataRange)
        } else if item == xm430::STARTUP_CONFIGURATION.item && part.value > i64::from(TORQUE_AT_START) {
            // Nor is a backup of the RAM.
            Err(StatusError::DataRange)
        } else if item == xm430::TORQUE_ENABLE.item
            && part.value != 0
            && self.get(xm430::HARDWARE_ERROR_STATUS) & self.get(xm430::SHUTDOWN) != 0
        {
            // After a shutdown only Reboot helps.
            Err(StatusError::ResultFail)
        } else {
            Ok(())
        }
    }

    /// What a write does beyond being stored.
    fn act(&mut self, address: u16, torque_before: bool) {
        if address == xm430::TORQUE_ENABLE.address() {
            // Nothing jumps when the torque comes on: the goal is where the servo is.
            if self.torque_on() && !torque_before {
                self.hold();
            }
        } else if address == xm430::GOAL_POSITION.address() {
            let shut = self.get(xm430::HARDWARE_ERROR_STATUS) & self.get(xm430::SHUTDOWN) != 0;
            if !self.torque_on() && !shut && self.get(xm430::DRIVE_MODE) & TORQUE_BY_GOAL != 0 {
                self.put(xm430::TORQUE_ENABLE, 1);
                self.profile = Profile::at(self.motor.position);
                self.began_us = self.now_us;
            }
            if self.torque_on() {
                self.set_out();
            }
        } else if [xm430::OPERATING_MODE.address(), xm430::HOMING_OFFSET.address(), xm430::DRIVE_MODE.address()]
            .contains(&address)
        {
            self.hold();
        }
    }

    /// Shows the present state in the registers.
    fn refresh(&mut self) {
        let on = self.torque_on();
        let since = self.since_us();
        let (trajectory, demanded) = if on { self.profile.after(since) } else { (self.motor.position, 0.0) };
        let under_way = on && since < self.profile.duration();
        let sign = self.sign();
        let speed = (sign * self.motor.speed / SPEED_UNIT).round() as i32;
        let moving = under_way || speed.unsigned_abs() > self.get(xm430::MOVING_THRESHOLD);
        let mut status = if under_way { self.profile.kind().bits() | 0x02 } else { 0 };
        if on && (self.profile.goal() - self.motor.position).abs() <= IN_POSITION {
            status |= 0x01;
        }
        if on && (trajectory - self.motor.position).abs() > FOLLOWING {
            status |= 0x08;
        }
        let torque = sign * self.driven();
        // The voltage that this torque at this speed takes.
        let duty = (self.motor.torque / STALL_TORQUE + self.motor.speed / FREE_SPEED) * NOMINAL_VOLTAGE
            / self.surroundings.volts;
        let duty = if on { sign * duty } else { 0.0 };
        self.put(xm430::REALTIME_TICK, (self.now_us / 1000 % 32_768) as u16);
        self.put(xm430::MOVING, u8::from(moving));
        self.put(xm430::MOVING_STATUS, status);
        self.put(xm430::PRESENT_PWM, (duty.clamp(-1.0, 1.0) * FULL_PWM).round() as i16);
        self.put(xm430::PRESENT_CURRENT, self.current_units(torque, 0.0));
        self.put(xm430::PRESENT_VELOCITY, speed);
        self.put(xm430::PRESENT_POSITION, self.present_position());
        self.put(xm430::VELOCITY_TRAJECTORY, (sign * demanded / SPEED_UNIT).round() as i32);
        self.put(xm430::POSITION_TRAJECTORY, self.shown(trajectory));
        self.put(xm430::PRESENT_INPUT_VOLTAGE, self.surroundings.voltage());
        self.put(xm430::PRESENT_TEMPERATURE, self.surroundings.temperature.round() as u8);
    }

    /// The motor's torque; the driver is off without torque.
    fn driven(&self) -> f64 {
        if self.torque_on() { self.motor.torque } else { 0.0 }
    }

    fn current_units(&self, torque: f64, noise_ma: f64) -> i16 {
        let milliamperes = torque / TORQUE_CONSTANT * 1000.0 + noise_ma;
        (milliamperes / f64::from(xm430::MILLIAMPERES_PER_UNIT)).round() as i16
    }

    /// A sample of the normal distribution (Box and Muller).
    fn normal(&mut self) -> f64 {
        let mut uniform = || (f64::from(self.random.next_u32()) + 0.5) / 4_294_967_296.0;
        let (a, b) = (uniform(), uniform());
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }
}

impl ControlTable for Xm430 {
    fn id(&self) -> Id {
        Id::new(self.get(xm430::ID)).unwrap_or(Id::MAX)
    }

    fn model_number(&self) -> u16 {
        self.get(xm430::MODEL_NUMBER)
    }

    fn firmware_version(&self) -> u8 {
        self.get(xm430::FIRMWARE_VERSION)
    }

    fn alert(&self) -> bool {
        self.get(xm430::HARDWARE_ERROR_STATUS) != 0
    }

    fn status_return(&self) -> StatusReturn {
        StatusReturn::from_value(self.get(xm430::STATUS_RETURN_LEVEL)).unwrap_or_default()
    }

    fn return_delay_us(&self) -> u32 {
        u32::from(self.get(xm430::RETURN_DELAY_TIME)) * xm430::RETURN_DELAY_US_PER_UNIT
    }

    fn read(&mut self, address: u16, bytes: &mut [u8]) -> Result<(), StatusError> {
        check_read(&xm430::ITEMS, address, bytes.len())?;
        let from = usize::from(address);
        let covers =
            |item: dynamixel::Item| from < usize::from(item.end()) && usize::from(item.address) < from + bytes.len();
        if covers(xm430::PRESENT_POSITION.item) {
            self.position_reads += 1;
            if let Clock::Requests { period_us } = self.clock {
                self.advance(self.now_us + u64::from(period_us));
            }
        }
        self.touched_us = self.now_us;
        self.refresh();
        // Every reading has its own noise; the driver is off without torque.
        if covers(xm430::PRESENT_CURRENT.item) && self.noise_ma > 0.0 {
            let noise = self.normal() * self.noise_ma;
            let torque = self.sign() * self.driven();
            self.put(xm430::PRESENT_CURRENT, self.current_units(torque, noise));
        }
        bytes.copy_from_slice(&self.memory[from..from + bytes.len()]);
        Ok(())
    }

    fn write(&mut self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        self.touched_us = self.now_us;
        self.check(address, bytes)?;
        let on = self.torque_on();
        let from = usize::from(address);
        self.memory[from..from + bytes.len()].copy_from_slice(bytes);
        let end = address + bytes.len() as u16;
        for item in xm430::ITEMS.iter().filter(|item| (address..end).contains(&item.address)) {
            self.act(item.address, on);
        }
        Ok(())
    }

    fn check(&self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        writes(&xm430::ITEMS, self.torque_on(), address, bytes).try_for_each(|part| self.refuses(&part?))
    }

    fn fast_reads(&self) -> bool {
        self.firmware_version() >= xm430::FAST_READ_FIRMWARE
    }

    fn registered(&mut self, waiting: bool) {
        self.put(xm430::REGISTERED_INSTRUCTION, u8::from(waiting));
    }

    fn reboot(&mut self) -> Result<(), StatusError> {
        self.turns = 0.0;
        self.power_on();
        Ok(())
    }

    fn factory_reset(&mut self, scope: ResetScope) -> Result<(), StatusError> {
        let (id, baud_rate) = (self.get(xm430::ID), self.get(xm430::BAUD_RATE));
        let (firmware, model) = (self.get(xm430::FIRMWARE_VERSION), self.get(xm430::MODEL_NUMBER));
        for item in xm430::ITEMS.iter().filter(|item| item.area == dynamixel::Area::Eeprom) {
            self.restore(item);
        }
        self.put(xm430::FIRMWARE_VERSION, firmware);
        self.put(xm430::MODEL_NUMBER, model);
        if scope != ResetScope::All {
            self.put(xm430::ID, id);
        }
        if scope == ResetScope::ExceptIdAndBaudRate {
            self.put(xm430::BAUD_RATE, baud_rate);
        }
        self.reboot()
    }

    fn clear_turns(&mut self) -> Result<(), StatusError> {
        if self.torque_on() && self.since_us() < self.profile.duration() {
            return Err(StatusError::ResultFail);
        }
        self.turns = (self.motor.position / 4096.0).floor() * 4096.0;
        self.hold();
        Ok(())
    }
}
