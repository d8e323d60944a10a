//! What a simulated servo is like.

use std::sync::Arc;

use dynamixel::{Id, Layout, Model, xm430};

use super::control::Gains;
use super::load::Load;
use crate::datasheet::Datasheet;

/// What makes the servo's time pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// The time of the caller, which for `fre servo` is the wall's. Answers obey the return delay.
    Wall,
    /// Every read of Present Position is one period later than the one before, at whatever speed the machine runs.
    /// Answers come at once.
    Requests {
        /// Microseconds between two such reads.
        period_us: u32,
    },
}

/// What a simulated servo is like. [`Config::default`] is a servo as it comes from the factory, without play and noise.
#[derive(Clone, Debug)]
pub struct Config {
    /// Address on the bus.
    pub id: u8,
    /// Registers and motor; default the XM430-W350.
    pub model: &'static Model,
    /// What Model Number reads, if not the model's own.
    pub model_number: Option<u16>,
    /// Version of its firmware; default 45, the first that knows Fast Sync Read.
    pub firmware: u8,
    /// Bits per second: one of [`Model::rates`]; factory 57,600.
    pub baud_rate: u32,
    /// Return delay, µs: an even number up to 508; factory 500.
    pub return_delay_us: u32,
    /// Whether answers also take the time that question and answer take on the wire at the baud rate. Wall clock only.
    pub wire_time: bool,
    /// What makes time pass.
    pub clock: Clock,
    /// Present Position at which the finger's motor angle α is 0; default 2048.
    pub zero_count: u16,
    /// Whether greater positions close the finger (greater α); default true.
    pub closing_up: bool,
    /// Motor angle at power-on, degrees; default 2° before the first contact, or 0 if there is none.
    pub start_deg: Option<f64>,
    /// Play between the encoder and the finger, degrees, 0 to 5. ROBOTIS gives 0.25° for this family.
    pub backlash_deg: f64,
    /// Position gains after power-on; factory 800, 0, 0, with which the servo holds by its error: 29 N·mm per count.
    pub gains: Gains,
    /// Standard deviation of Present Current, mA, 0 to 1000.
    pub noise_ma: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// What the finger asks of the servo.
    pub load: Arc<Load>,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            id: 1,
            model: Model::XM430,
            model_number: None,
            firmware: xm430::FAST_READ_FIRMWARE,
            baud_rate: 57_600,
            return_delay_us: 500,
            wire_time: false,
            clock: Clock::Wall,
            zero_count: 2048,
            closing_up: true,
            start_deg: None,
            backlash_deg: 0.0,
            gains: Gains::FACTORY,
            noise_ma: 0.0,
            seed: 0,
            load: Arc::new(Load::none()),
        }
    }
}

/// Why a servo cannot be like that.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConfigError {
    /// The address.
    #[error("the address is {0}; allowed is 0 to 252")]
    Id(u8),
    /// The baud rate.
    #[error("the baud rate is {rate}; the {model} knows {known}")]
    BaudRate {
        /// What was asked for.
        rate: u32,
        /// The servo.
        model: &'static str,
        /// What there is.
        known: String,
    },
    /// A model whose control table or motor is not known.
    #[error("the {0} is not simulated; simulated are {models}", models = simulated())]
    Model(&'static str),
    /// The return delay.
    #[error("the return delay is {0} µs; allowed are even numbers from 0 to 508")]
    ReturnDelay(u32),
    /// The period of the requests.
    #[error("the period of the requests is {0} µs; allowed is 1 to 1000000")]
    Period(u32),
    /// The position at which the motor angle is 0.
    #[error("the zero position is {count}; allowed is 0 to {most}")]
    Zero {
        /// What was asked for.
        count: u16,
        /// The last one.
        most: u32,
    },
    /// Another number.
    #[error("{what} is {value} {unit}; allowed is {min} to {max}")]
    OutOfRange {
        /// Which.
        what: &'static str,
        /// The number.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// Least.
        min: f64,
        /// Greatest.
        max: f64,
    },
}

/// The names of the models that are simulated.
pub fn simulated() -> String {
    let known = |model: &&'static Model| Config::of(model).is_simulated();
    let names: Vec<&str> = dynamixel::MODELS.iter().filter(known).map(|model| model.name).collect();
    names.join(", ")
}

impl Config {
    /// A servo of this model as it comes from the factory: its gains, and its zero in the middle of its revolution.
    pub fn of(model: &'static Model) -> Self {
        let zero_count = match model.layout {
            Layout::X => 2048,
            Layout::P => 0,
        };
        Self { model, firmware: model.fast_since, gains: Gains::of(model), zero_count, ..Self::default() }
    }

    /// Counts per radian.
    pub(super) fn counts_per_radian(&self) -> f64 {
        f64::from(self.model.counts) / std::f64::consts::TAU
    }

    /// Whether the model's control table and motor are known.
    pub fn is_simulated(&self) -> bool {
        self.datasheet().is_ok()
    }

    /// Motor and gears.
    pub(super) fn datasheet(&self) -> Result<Datasheet, ConfigError> {
        let known = Datasheet::of(self.model).filter(|_| self.model.items().is_some());
        known.ok_or(ConfigError::Model(self.model.name))
    }

    /// The position (counts, not rounded) at a motor angle α, rad.
    pub fn counts(&self, angle: f64) -> f64 {
        let counts = angle * self.counts_per_radian();
        f64::from(self.zero_count) + if self.closing_up { counts } else { -counts }
    }

    /// The motor angle α (rad) at a position in counts.
    pub fn angle(&self, counts: f64) -> f64 {
        let angle = (counts - f64::from(self.zero_count)) / self.counts_per_radian();
        if self.closing_up { angle } else { -angle }
    }

    /// The position at power-on, counts: a whole number.
    pub(super) fn start(&self) -> f64 {
        let angle = match self.start_deg {
            Some(degrees) => degrees.to_radians(),
            None => self.load.first_contact().map_or(0.0, |angle| angle - 2f64.to_radians()),
        };
        self.counts(angle).round()
    }

    pub(super) fn check(&self) -> Result<(), ConfigError> {
        Id::new(self.id).ok_or(ConfigError::Id(self.id))?;
        self.datasheet()?;
        if self.model.baud_code(self.baud_rate).is_none() {
            let known: Vec<String> = self.model.rates.iter().map(u32::to_string).collect();
            let known = known.join(", ");
            return Err(ConfigError::BaudRate { rate: self.baud_rate, model: self.model.name, known });
        }
        let delay = self.return_delay_us;
        if !delay.is_multiple_of(xm430::RETURN_DELAY_US_PER_UNIT) || delay > 254 * xm430::RETURN_DELAY_US_PER_UNIT {
            return Err(ConfigError::ReturnDelay(delay));
        }
        if let Clock::Requests { period_us } = self.clock
            && !(1..=1_000_000).contains(&period_us)
        {
            return Err(ConfigError::Period(period_us));
        }
        // Positions of a revolution: from 0 on, or to both sides of it.
        let [least, most] = match self.model.layout {
            Layout::X => [0.0, f64::from(self.model.counts) - 1.0],
            Layout::P => [-f64::from(self.model.counts) / 2.0, f64::from(self.model.counts) / 2.0],
        };
        if f64::from(self.zero_count) > most {
            return Err(ConfigError::Zero { count: self.zero_count, most: most as u32 });
        }
        let within = |what, value: f64, unit, min, max| {
            if (min..=max).contains(&value) {
                Ok(())
            } else {
                Err(ConfigError::OutOfRange { what, value, unit, min, max })
            }
        };
        within("the backlash", self.backlash_deg, "°", 0.0, 5.0)?;
        within("the noise", self.noise_ma, "mA", 0.0, 1000.0)?;
        within("the angle at power-on", self.start_deg.unwrap_or(0.0), "°", -180.0, 180.0)?;
        within("the position at power-on", self.start(), "counts", least, most)
    }
}
