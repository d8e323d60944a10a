//! A servo's control table: what the registers do to the motor, and what they show of it.

mod time;

use dynamixel::{
    Area, Backup, ControlTable, Effort, Id, Item, Layout, Part, Register, ResetScope, StatusError, StatusReturn, Value,
    writes, xm430,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::config::{Clock, Config, ConfigError};
use super::control::{Control, Gains};
use super::indirect::Stretch;
use super::motor::{Gear, Motor};
use super::profile::Profile;
use super::registers::Registers;
use super::surroundings::Surroundings;
use super::units::Units;

/// Distance to the trajectory beyond which the servo does not follow it, 1/4096 of a revolution. An assumption: about 2°.
const FOLLOWING: f64 = 24.0;
/// The servo says it has reached its goal within this distance, 1/4096 of a revolution. An assumption.
const IN_POSITION: f64 = 4.0;
/// Drive Mode: positions, speeds, currents and PWM count the other way round.
const REVERSE: u8 = 1;
/// Drive Mode: a goal turns the torque on.
const TORQUE_BY_GOAL: u8 = 1 << 3;
/// Startup Configuration: the torque comes on with the power.
const TORQUE_AT_START: u8 = 1;
/// Startup Configuration: the RAM is that of the backup.
const RESTORED_AT_START: u8 = 1 << 1;

/// Registers that do nothing here, by the XM430's addresses: only their factory values are taken. PWM Slope is the X330 series'.
const PWM_SLOPE: u16 = 62;
const NOT_SIMULATED: [u16; 4] = [
    xm430::PROTOCOL_TYPE.address(),
    xm430::FEEDFORWARD_1ST_GAIN.address(),
    xm430::FEEDFORWARD_2ND_GAIN.address(),
    PWM_SLOPE,
];
/// The P series' Acceleration Limit.
const ACCELERATION_LIMIT: Register<u32> = Register::write(40, false, Area::Eeprom, 0, 0, u32::MAX as i64);

/// Registers and motor.
#[derive(Clone, Debug)]
pub struct Table {
    registers: Registers,
    units: Units,
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
    /// Counts by which the position was moved when its turns were dropped: whole revolutions.
    turns: f64,
    /// Reads of Present Position.
    pub(super) position_reads: u64,
    /// A Reboot, or its like, has come since this was asked last.
    has_restarted: bool,
}

impl Table {
    pub(super) fn new(config: &Config) -> Result<Self, ConfigError> {
        config.check()?;
        let data = config.datasheet()?;
        let gear = Gear {
            data,
            zero: f64::from(config.zero_count),
            direction: if config.closing_up { 1.0 } else { -1.0 },
            pitch: config.counts_per_radian().recip(),
            half_play: config.backlash_deg.to_radians() * config.counts_per_radian() / 2.0,
        };
        let start = config.start();
        let mut table = Self {
            registers: Registers::new(config.model),
            units: Units::of(config.model),
            clock: config.clock,
            noise_ma: config.noise_ma,
            random: ChaCha8Rng::seed_from_u64(config.seed),
            motor: Motor::new(gear, config.load.clone(), start),
            control: Control::of(config.model),
            gains: config.gains,
            surroundings: Surroundings::of(&data),
            profile: Profile::at(start),
            began_us: 0,
            now_us: 0,
            touched_us: 0,
            turns: 0.0,
            position_reads: 0,
            has_restarted: false,
        };
        table.put(xm430::ID, config.id);
        table.put(xm430::FIRMWARE_VERSION, config.firmware);
        table.put(xm430::MODEL_NUMBER, config.model_number.unwrap_or(config.model.number));
        table.put(xm430::BAUD_RATE, config.model.baud_code(config.baud_rate).unwrap_or(1));
        table.put(xm430::RETURN_DELAY_TIME, (config.return_delay_us / xm430::RETURN_DELAY_US_PER_UNIT) as u8);
        table.power_on();
        Ok(table)
    }

    /// The value of a register as it was last refreshed.
    pub(super) fn get<T: Value>(&self, register: Register<T>) -> T {
        self.registers.get(register)
    }

    fn put<T: Value>(&mut self, register: Register<T>, value: T) {
        self.registers.put(register, value);
    }

    /// RAM as after power-on: the goal is where the servo is, the torque is off.
    fn power_on(&mut self) {
        self.registers.restore(Area::Ram);
        self.put(xm430::BACKUP_READY, u8::from(self.registers.is_stored()));
        self.reset_control();
        self.drop_turns();
        if self.get(xm430::STARTUP_CONFIGURATION) & RESTORED_AT_START != 0 {
            self.registers.restore_ram();
        }
        self.hold();
        if self.get(xm430::STARTUP_CONFIGURATION) & TORQUE_AT_START != 0 {
            self.put(xm430::TORQUE_ENABLE, 1);
        }
        self.refresh();
    }

    /// Gains, profile and goals are what they are after power-on. A change of Operating Mode resets them too (e-Manual, Operating Mode); that a
    /// mode has no gains of its own is an assumption.
    fn reset_control(&mut self) {
        self.registers.restore_control();
        self.put(xm430::GOAL_PWM, self.get(xm430::PWM_LIMIT) as i16);
        self.put(xm430::GOAL_CURRENT, self.get(xm430::CURRENT_LIMIT) as i16);
        self.put(xm430::GOAL_VELOCITY, 0);
        self.put(xm430::POSITION_P_GAIN, self.gains.p);
        self.put(xm430::POSITION_I_GAIN, self.gains.i);
        self.put(xm430::POSITION_D_GAIN, self.gains.d);
    }

    /// The position is one within a revolution: from 0 on, or of the P series to both sides of 0. Homing Offset comes on top.
    fn drop_turns(&mut self) {
        let revolution = self.units.revolution;
        let turned = self.turned(self.motor.position);
        self.turns = match self.registers.model.layout {
            Layout::X => (turned / revolution).floor(),
            Layout::P => (turned / revolution).round(),
        } * revolution;
    }

    /// Whether it has restarted since this was asked last.
    pub(super) fn take_restarted(&mut self) -> bool {
        std::mem::take(&mut self.has_restarted)
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
        (self.turned(position) + self.offset()).round() as i32
    }

    /// A position in the direction in which the servo counts; the same function turns it back.
    fn turned(&self, position: f64) -> f64 {
        if self.sign() < 0.0 { self.units.turned - position } else { position }
    }

    /// The encoder's position of a register's.
    fn position_of(&self, shown: i32) -> f64 {
        self.turned(f64::from(shown) - self.offset())
    }

    /// −1 if the servo counts the other way round.
    fn sign(&self) -> f64 {
        if self.get(xm430::DRIVE_MODE) & REVERSE != 0 { -1.0 } else { 1.0 }
    }

    /// Present Position, counts.
    pub(super) fn present_position(&self) -> i32 {
        self.shown(self.motor.position)
    }

    /// A hardware error; it turns the torque off if Shutdown says so.
    pub(super) fn fail(&mut self, bits: u8) {
        let errors = self.get(xm430::HARDWARE_ERROR_STATUS) | bits;
        self.put(xm430::HARDWARE_ERROR_STATUS, errors);
        if errors & self.get(xm430::SHUTDOWN) != 0 {
            self.put(xm430::TORQUE_ENABLE, 0);
        }
    }

    /// What the manual refuses beyond the ranges of the items.
    fn refuses(&self, part: &Part<'_>) -> Result<(), StatusError> {
        let within = |limit: i64| if part.value.abs() <= limit { Ok(()) } else { Err(StatusError::DataLimit) };
        let Some(address) = self.canonical(&part.item) else {
            return Ok(());
        };
        let is = |register: u16| address == register;
        if is(xm430::GOAL_POSITION.address()) && self.get(xm430::OPERATING_MODE) == xm430::POSITION_CONTROL {
            let least = self.registers.number(xm430::MIN_POSITION_LIMIT);
            let greatest = self.registers.number(xm430::MAX_POSITION_LIMIT);
            if !(least..=greatest).contains(&part.value) {
                return Err(StatusError::DataLimit);
            }
        }
        let goals = [
            xm430::GOAL_POSITION.address(),
            xm430::GOAL_PWM.address(),
            xm430::GOAL_CURRENT.address(),
            xm430::GOAL_VELOCITY.address(),
        ];
        if goals.contains(&address) && self.get(xm430::BUS_WATCHDOG) < 0 {
            return Err(StatusError::DataRange);
        }
        if is(xm430::GOAL_PWM.address()) {
            within(self.registers.number(xm430::PWM_LIMIT))
        } else if is(xm430::GOAL_CURRENT.address()) {
            within(self.registers.number(xm430::CURRENT_LIMIT))
        } else if is(xm430::GOAL_VELOCITY.address()) {
            within(self.registers.number(xm430::VELOCITY_LIMIT))
        } else if is(xm430::PROFILE_ACCELERATION.address()) && self.registers.item(ACCELERATION_LIMIT).is_some() {
            within(self.registers.number(ACCELERATION_LIMIT))
        } else if is(xm430::OPERATING_MODE.address()) {
            let known = u8::try_from(part.value).is_ok_and(|mode| self.registers.model.modes.contains(&mode));
            if known { Ok(()) } else { Err(StatusError::DataRange) }
        } else if NOT_SIMULATED.contains(&address) && part.value != part.item.default {
            Err(StatusError::DataRange)
        } else if is(xm430::TORQUE_ENABLE.address())
            && part.value != 0
            && self.get(xm430::HARDWARE_ERROR_STATUS) & self.get(xm430::SHUTDOWN) != 0
        {
            // After a shutdown only Reboot helps.
            Err(StatusError::ResultFail)
        } else {
            Ok(())
        }
    }

    /// The XM430's address of an item.
    fn canonical(&self, item: &Item) -> Option<u16> {
        self.registers.model.layout.canonical(item.address)
    }

    /// What a write does beyond being stored; before it, the torque was on or not, and Operating Mode was `mode_before`.
    fn act(&mut self, address: u16, torque_before: bool, mode_before: u8) {
        let mode = self.get(xm430::OPERATING_MODE);
        if address == xm430::TORQUE_ENABLE.address() {
            // Nothing jumps when the torque comes on: the goal is where the servo is.
            if self.torque_on() && !torque_before {
                // The e-Manual's (Present Position): on torque in position control, on a change to that, and at power-on.
                if mode == xm430::POSITION_CONTROL {
                    self.drop_turns();
                }
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
            if mode != mode_before {
                self.reset_control();
                if mode == xm430::POSITION_CONTROL {
                    self.drop_turns();
                }
            }
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
        let speed = (sign * self.motor.speed / self.units.speed).round() as i32;
        let moving = under_way || speed.unsigned_abs() > self.get(xm430::MOVING_THRESHOLD);
        let mut status = if under_way { self.profile.kind().bits() | 0x02 } else { 0 };
        if on && (self.profile.goal() - self.motor.position).abs() <= IN_POSITION * self.units.fineness {
            status |= 0x01;
        }
        if on && (trajectory - self.motor.position).abs() > FOLLOWING * self.units.fineness {
            status |= 0x08;
        }
        let torque = sign * self.driven();
        // The voltage that this torque at this speed takes.
        let Gear { data, .. } = &self.motor.gear;
        let duty = (self.motor.torque / data.stall_torque + self.motor.speed / self.motor.gear.free_speed())
            * data.volts
            / self.surroundings.volts;
        let duty = if on { sign * duty } else { 0.0 };
        self.put(xm430::REALTIME_TICK, (self.now_us / 1000 % 32_768) as u16);
        self.put(xm430::MOVING, u8::from(moving));
        self.put(xm430::MOVING_STATUS, status);
        self.put(xm430::PRESENT_PWM, (duty.clamp(-1.0, 1.0) * self.units.full_pwm).round() as i16);
        self.put(xm430::PRESENT_CURRENT, self.effort(torque, 0.0));
        self.put(xm430::PRESENT_VELOCITY, speed);
        self.put(xm430::PRESENT_POSITION, self.present_position());
        self.put(xm430::VELOCITY_TRAJECTORY, (sign * demanded / self.units.speed).round() as i32);
        self.put(xm430::POSITION_TRAJECTORY, self.shown(trajectory));
        self.put(xm430::PRESENT_INPUT_VOLTAGE, self.surroundings.voltage());
        self.put(xm430::PRESENT_TEMPERATURE, self.surroundings.temperature.round() as u8);
    }

    /// The motor's torque; the driver is off without torque.
    fn driven(&self) -> f64 {
        if self.torque_on() { self.motor.torque } else { 0.0 }
    }

    /// What shows a torque: a current, or a part of the stall torque.
    fn effort(&self, torque: f64, noise_ma: f64) -> i16 {
        let data = &self.motor.gear.data;
        let units = match self.registers.model.effort {
            Effort::Current(_) => (torque / data.torque_constant + noise_ma / 1000.0) / self.units.amperes,
            Effort::Load => torque / data.stall_torque * 1000.0,
        };
        units.round() as i16
    }

    /// A sample of the normal distribution (Box and Muller).
    fn normal(&mut self) -> f64 {
        let mut uniform = || (f64::from(self.random.next_u32()) + 0.5) / 4_294_967_296.0;
        let (a, b) = (uniform(), uniform());
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }
}

impl ControlTable for Table {
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

    fn secondary_id(&self) -> Option<Id> {
        Id::new(self.get(xm430::SECONDARY_ID))
    }

    fn is_shared(&self, address: u16, bytes: &[u8]) -> bool {
        let in_ram = |stretch: &Stretch| match stretch {
            Stretch::Items(address, bytes) => {
                writes(self.registers.items(), false, *address, bytes).flatten().all(|part| part.item.area == Area::Ram)
            }
            Stretch::Address(..) => !self.registers.keeps_indirect(),
            Stretch::Plain(..) => true,
        };
        self.registers.stretches(address, bytes).is_ok_and(|stretches| stretches.iter().all(in_ram))
    }

    fn read(&mut self, address: u16, bytes: &mut [u8]) -> Result<(), StatusError> {
        self.registers.check_read(address, bytes.len())?;
        if self.registers.shows(xm430::PRESENT_POSITION, address, bytes.len()) {
            self.position_reads += 1;
            if let Clock::Requests { period_us } = self.clock {
                self.advance(self.now_us + u64::from(period_us));
            }
        }
        self.touched_us = self.now_us;
        self.refresh();
        // Every reading has its own noise; the driver is off without torque.
        if self.registers.shows(xm430::PRESENT_CURRENT, address, bytes.len()) && self.noise_ma > 0.0 {
            let noise = self.normal() * self.noise_ma;
            let torque = self.sign() * self.driven();
            self.put(xm430::PRESENT_CURRENT, self.effort(torque, noise));
        }
        self.registers.read(address, bytes);
        Ok(())
    }

    fn write(&mut self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        self.touched_us = self.now_us;
        self.check(address, bytes)?;
        for stretch in self.registers.stretches(address, bytes)? {
            let (on, mode) = (self.torque_on(), self.get(xm430::OPERATING_MODE));
            self.registers.write(&stretch);
            if let Stretch::Items(address, bytes) = &stretch {
                let end = address + bytes.len() as u16;
                let written = self.registers.items().iter().filter(|item| (*address..end).contains(&item.address));
                let written: Vec<u16> = written.filter_map(|item| self.canonical(item)).collect();
                written.into_iter().for_each(|address| self.act(address, on, mode));
            }
        }
        Ok(())
    }

    fn check(&self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        self.registers.stretches(address, bytes)?.iter().try_for_each(|stretch| match stretch {
            Stretch::Items(address, bytes) => writes(self.registers.items(), self.torque_on(), *address, bytes)
                .try_for_each(|part| self.refuses(&part?)),
            Stretch::Address(..) if self.registers.keeps_indirect() && self.torque_on() => Err(StatusError::Access),
            Stretch::Address(..) | Stretch::Plain(..) => Ok(()),
        })
    }

    fn fast_reads(&self) -> bool {
        self.firmware_version() >= self.registers.model.fast_since
    }

    fn registered(&mut self, waiting: bool) {
        self.put(xm430::REGISTERED_INSTRUCTION, u8::from(waiting));
    }

    fn reboot(&mut self) -> Result<(), StatusError> {
        self.power_on();
        self.has_restarted = true;
        Ok(())
    }

    fn factory_reset(&mut self, scope: ResetScope) -> Result<(), StatusError> {
        let (id, baud_rate) = (self.get(xm430::ID), self.get(xm430::BAUD_RATE));
        let (firmware, model) = (self.get(xm430::FIRMWARE_VERSION), self.get(xm430::MODEL_NUMBER));
        self.registers.restore(Area::Eeprom);
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
        self.drop_turns();
        self.hold();
        Ok(())
    }

    fn backup(&mut self, what: Backup) -> Result<(), StatusError> {
        if self.firmware_version() < self.registers.model.fast_since {
            return Err(StatusError::Instruction);
        }
        if self.torque_on() {
            return Err(StatusError::ResultFail);
        }
        match what {
            Backup::Store => {
                self.registers.store();
                self.put(xm430::BACKUP_READY, 1);
                Ok(())
            }
            Backup::Restore if self.registers.restore_eeprom() => {
                self.reboot()?;
                self.registers.restore_ram();
                Ok(())
            }
            Backup::Restore => Err(StatusError::ResultFail),
        }
    }
}
