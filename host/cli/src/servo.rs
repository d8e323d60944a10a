//! `fre servo`: the simulated Dynamixel servo on a pseudo-terminal or socket.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::ValueEnum;
use dynamixel::Model;
use model_core::discretise::DiscretiseError;
use model_core::drive::Drive;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use crate::exit::{bad_input, tell};
use crate::options::{ModelArgs, refused};
use crate::standard;
use fre::case::Case;
use fre::drive::agrees;
use fre_gripper::servo::{Clock, Config, Gains, Handle, Hub, Load, LoadError, PortError, Servo, simulated};

/// Simulate a Dynamixel servo that moves the case's finger against its object.
///
/// Each --pty, --unix and --tcp is a party on the bus, and so is the servo; every party hears all others. Standard output has a
/// line for each port ("pty PATH", "unix PATH", "tcp ADDRESS"), then "ready". The servo runs until it is stopped.
///
/// Simulated: position, extended position, current-based position, velocity, current and PWM control with their gains, limits
/// and profiles, as far as the model has them; friction, play, sag under load, heat and shutdown, boot time; reversed Drive Mode, Homing
/// Offset, position limits, Bus Watchdog, torque at start-up, Status Return Level, Secondary ID, indirect registers, Clear,
/// Control Table Backup. Not simulated, and refused: feed-forward gains, PWM Slope, other protocols, external ports.
#[derive(Debug, clap::Args)]
#[command(
    mut_arg("scheme", |arg| arg.default_value("paper")),
    mut_arg("elements", |arg| arg.default_value("paper")),
    mut_arg("physics", |arg| arg.default_value("paper"))
)]
pub struct Args {
    #[command(flatten)]
    load: LoadArgs,
    /// Opens a raw pseudo-terminal; may be repeated
    ///
    /// It is the default if no port is named.
    #[arg(long, action = clap::ArgAction::Count)]
    pty: u8,
    /// Listens on a unix socket; may be repeated
    #[arg(long, value_name = "PATH")]
    unix: Vec<PathBuf>,
    /// Listens on a TCP address; may be repeated
    #[arg(long, value_name = "HOST:PORT")]
    tcp: Vec<String>,
    /// Connects to a unix socket on which another program listens; may be repeated
    #[arg(long, value_name = "PATH")]
    connect_unix: Vec<PathBuf>,
    /// Connects to a TCP address; may be repeated
    #[arg(long, value_name = "HOST:PORT")]
    connect_tcp: Vec<String>,
    /// Address on the bus, 0 to 252; several are several servos
    ///
    /// They are separated by commas and have the same settings.
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "1")]
    id: Vec<u8>,
    /// Which servo: its registers, units and motor
    ///
    /// XM430-W350, XL430-W250, XM540-W270, XL330-M288, XC330-T288 or PM42-010-S260-R.
    #[arg(long = "model", value_name = "NAME", default_value = "XM430-W350", value_parser = servo_model)]
    servo: &'static Model,
    /// What Model Number reads [default: the model's own]
    ///
    /// The registers and the motor stay those of --model.
    #[arg(long, value_name = "N")]
    model_number: Option<u16>,
    /// Version of the servo's firmware [default: the first with Fast Sync Read]
    ///
    /// That is 45, but 46 for XL330 and XC330, and 12 for PM42.
    #[arg(long, value_name = "N")]
    firmware: Option<u8>,
    /// Baud rate of the servo
    #[arg(long, value_name = "BITS_PER_S", default_value_t = 57_600)]
    baud: u32,
    /// Return delay, even, 0 to 508
    #[arg(long, value_name = "US", default_value_t = 500)]
    return_delay_us: u32,
    /// Delays answers by the time on the wire (wall clock only)
    ///
    /// The delay is the time that request and answer take at the servo's baud rate.
    #[arg(long)]
    wire_time: bool,
    /// The servo's clock: wall time, or one period per read of Present Position
    #[arg(long, value_enum, default_value = "wall")]
    clock: ClockWord,
    /// Period of the clock "requests"
    #[arg(long, value_name = "US", default_value_t = 2000)]
    period_us: u32,
    /// Position at motor angle 0 [default: 2048, mid revolution; 0 for PM42]
    #[arg(long, value_name = "COUNT")]
    zero_count: Option<u16>,
    /// Counts decrease as the finger closes
    #[arg(long)]
    reversed: bool,
    /// Motor angle at power-on [default: 2° before the first contact]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    start_deg: Option<f64>,
    /// Play between encoder and finger, 0 to 5; 0.25 for this servo family
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    backlash_deg: f64,
    /// Position gains after power-on [default: the factory's; XM430: 800,0,0]
    ///
    /// With these an XM430-W350 holds by its error, 29 N·mm per count; 16383,0,0 is twenty times as firm.
    #[arg(long, value_name = "P,I,D", value_parser = gains)]
    gains: Option<Gains>,
    /// Standard deviation of Present Current
    #[arg(long, value_name = "MA", default_value_t = 3.0)]
    noise_ma: f64,
    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    model: ModelArgs,
}

/// What the servo moves, and how.
#[derive(Debug, clap::Args)]
pub struct LoadArgs {
    /// The case: finger, object and motor axis; without one the servo has no load
    #[arg(value_name = "CASE.toml")]
    case: Option<PathBuf>,
    /// How the servo moves the finger
    ///
    /// rotating, "linear X,Y MM_PER_RAD" (parallel jaws; X,Y: the direction of closing), or "table X,Y DEG:MM DEG:MM …" (crank
    /// linkages). The case's motion must be of the same kind.
    #[arg(long, value_name = "DRIVE", default_value = "rotating", value_parser = super::options::drive)]
    drive: Drive,
    /// Highest motor angle of the load's table
    ///
    /// The default is 5° above the case's highest angle, and 180° with a drive along a line.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    highest_deg: Option<f64>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ClockWord {
    /// The wall's.
    Wall,
    /// One period per read of Present Position.
    Requests,
}

/// Gains from an argument.
pub fn gains(words: &str) -> Result<Gains, String> {
    let gains: Option<Vec<u16>> = words.split(',').map(|word| word.trim().parse().ok()).collect();
    match gains.as_deref() {
        Some(&[p, i, d]) if p.max(i).max(d) <= 16_383 => Ok(Gains { p, i, d }),
        _ => Err("allowed are three numbers from 0 to 16383, as 800,0,0".to_owned()),
    }
}

/// A servo from an argument.
fn servo_model(words: &str) -> Result<&'static Model, String> {
    let model = Model::named(words).or_else(|| words.parse().ok().and_then(Model::of));
    let known = model.filter(|model| Config::of(model).is_simulated());
    known.ok_or_else(|| format!("{words} is not simulated; simulated are {}", simulated()))
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    match serve(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => bad_input(&message),
    }
}

fn serve(args: &Args) -> Result<(), String> {
    if args.wire_time && matches!(args.clock, ClockWord::Requests) {
        return Err("--wire-time: means nothing with --clock requests; allowed is --clock wall".to_owned());
    }
    let load = Arc::new(args.load.load(args.load.case()?.as_ref(), &args.model)?);
    let factory = Config::of(args.servo);
    let config = Config {
        id: 0,
        model_number: args.model_number,
        firmware: args.firmware.unwrap_or(factory.firmware),
        baud_rate: args.baud,
        return_delay_us: args.return_delay_us,
        wire_time: args.wire_time,
        clock: match args.clock {
            ClockWord::Wall => Clock::Wall,
            ClockWord::Requests => Clock::Requests { period_us: args.period_us },
        },
        zero_count: args.zero_count.unwrap_or(factory.zero_count),
        closing_up: !args.reversed,
        start_deg: args.start_deg,
        backlash_deg: args.backlash_deg,
        gains: args.gains.unwrap_or(factory.gains),
        noise_ma: args.noise_ma,
        seed: args.seed,
        load,
        ..factory
    };
    let mut servos = Vec::new();
    for (place, &id) in args.id.iter().enumerate() {
        if args.id[..place].contains(&id) {
            return Err(format!("--id: {id} is named twice; two servos with one address would speak at once"));
        }
        servos.push(Servo::new(Config { id, ..config.clone() }).map_err(|error| error.to_string())?);
    }
    // Before the first line says that there is something to stop.
    let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(|error| format!("no signals: {error}"))?;
    let mut hub = Hub::new();
    let places = ports(args, &mut hub).map_err(|error| error.to_string())?;
    let handles: Vec<Handle> = servos.into_iter().map(|servo| hub.servo(servo)).collect();
    let bus = hub.spawn().map_err(|error| error.to_string())?;
    let mut out = std::io::stdout().lock();
    // A reader that has gone does not stop the servo.
    let _ = places.iter().try_for_each(|place| writeln!(out, "{place}"));
    let _ = writeln!(out, "ready").and_then(|()| out.flush());
    signals.forever().next();
    let lost = bus.lost();
    bus.stop();
    for (id, statistics) in args.id.iter().zip(handles.iter().map(Handle::statistics)) {
        tell!(
            "fre: servo {id}: {} bytes heard, {} answers, {} reads of Present Position",
            statistics.heard,
            statistics.answers,
            statistics.position_reads
        );
    }
    tell!("fre: {lost} bytes lost");
    Ok(())
}

impl LoadArgs {
    /// The case, if one is named.
    pub fn case(&self) -> Result<Option<Case>, String> {
        let read = |file: &PathBuf| standard::case(file).map_err(|error| error.to_string());
        self.case.as_ref().map(read).transpose()
    }

    /// How the servo moves the finger.
    pub fn drive(&self) -> &Drive {
        &self.drive
    }

    /// What the case asks of the servo.
    pub fn load(&self, case: Option<&Case>, model: &ModelArgs) -> Result<Load, String> {
        let (Some(file), Some(case)) = (&self.case, case) else {
            return Ok(Load::none());
        };
        let drive = &self.drive;
        agrees(&case.path.motion, drive).map_err(|error| format!("{}: {error}", file.display()))?;
        let highest = match (self.highest_deg, drive) {
            (Some(given), _) => given,
            (None, Drive::Rotating) => case.path.places.iter().copied().fold(0.0, f64::max) + 5.0,
            // Places are distances: as far as a servo turns.
            (None, Drive::Translating { .. }) => 180.0,
        };
        let (design, options) = (&case.finger.design, model.options());
        let prony = &case.finger.prony;
        let load = Load::remembering(design, prony, case.object, case.friction, drive, &options, highest);
        load.map_err(|error| match error {
            LoadError::Range { .. } => format!("--highest-deg: {error}"),
            LoadError::Discretise(DiscretiseError::Design(error)) => format!("{}: finger.{error}", file.display()),
            LoadError::Discretise(error) => refused(&error),
            _ => format!("{}: {error}", file.display()),
        })
    }
}

/// Opens the ports; gives a line for each that others open.
fn ports(args: &Args, hub: &mut Hub) -> Result<Vec<String>, PortError> {
    let mut places = Vec::new();
    let named = args.unix.len() + args.tcp.len() + args.connect_unix.len() + args.connect_tcp.len();
    let terminals = if named == 0 { args.pty.max(1) } else { args.pty };
    for _ in 0..terminals {
        places.push(format!("pty {}", hub.pty()?.display()));
    }
    for path in &args.unix {
        hub.listen_unix(path)?;
        places.push(format!("unix {}", path.display()));
    }
    for address in &args.tcp {
        places.push(format!("tcp {}", hub.listen_tcp(address)?));
    }
    for path in &args.connect_unix {
        hub.connect_unix(path)?;
    }
    for address in &args.connect_tcp {
        hub.connect_tcp(address)?;
    }
    Ok(places)
}
