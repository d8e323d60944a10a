//! Which source of estimates a command watches: a gripper's link, or a bus of this PC.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use messages::{Finger, Settings};
use model_core::uncertainty::Uncertainty;

use crate::environment::{self, BUS, LINK};
use crate::exit::tell;
use crate::options::ModelArgs;
use crate::output::{reads, reads_case};
use crate::standard;
use fre::files::{FileError, Files};
use fre_gripper::bus::{Bus, BusAddress, BusOptions};
use fre_gripper::link::{Address, Ends, Lasting, ports, set};
use fre_gripper::source::{Modelled, Source};

/// Where a source is.
enum Place {
    Link(Address),
    Bus(BusAddress),
}

/// Which source.
#[derive(Debug, clap::Args)]
pub struct SourceArgs {
    /// Where the gripper is [env: FRE_LINK]
    ///
    /// unix:PATH, tcp:HOST:PORT, or a serial port as PORT or PORT@BAUD.
    #[arg(short, long, value_name = "LINK", conflicts_with = "bus")]
    link: Option<Address>,
    /// Servos on this PC's own bus, through a USB adapter [env: FRE_BUS]
    ///
    /// A serial port (of a U2D2 or its like) as PORT or PORT@BAUD; without BAUD the usual rates are tried. Or unix:PATH, or
    /// tcp:HOST:PORT. The estimator runs on this PC; nothing is written to a servo, unless somebody has `fre ros2`
    /// relax it.
    #[arg(short, long, value_name = "PORT")]
    bus: Option<BusAddress>,
    /// With --bus: finger and object of a case file
    ///
    /// Repeated, there is one per finger, and the last one is for all behind it.
    #[arg(long, value_name = "CASE.toml")]
    case: Vec<PathBuf>,
    /// With --bus: settings as KEY = VALUE lines; - for standard input
    ///
    /// They are what `fre gripper get` prints: which servo each finger has, its zero, direction and gear ratio.
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// With --bus: one setting; may be repeated
    ///
    /// As finger.0.zero_counts=2048, finger.0.servo_id=3 or rate_hz=200. If no servo_id is named, the servos that answer are the
    /// fingers, in the order of their addresses.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// With --bus: what a calibration has left uncertain
    ///
    /// The file is what `fre calibrate --format json` writes; - is standard input. Repeated, there is one per finger, and the last one is for all
    /// behind it. The default is a finger that was measured and not calibrated.
    #[arg(long, value_name = "FIT.json", requires = "case")]
    uncertainty: Vec<PathBuf>,
    #[command(flatten)]
    model: ModelArgs,
}

impl SourceArgs {
    /// Takes note of the files that are read.
    ///
    /// # Errors
    /// One of them is an output.
    pub fn reads(&self, files: &mut Files) -> Result<(), FileError> {
        self.case.iter().try_for_each(|path| reads_case(files, path))?;
        self.settings.iter().try_for_each(|path| reads(files, path, "--settings"))?;
        self.uncertainty.iter().try_for_each(|path| reads(files, path, "--uncertainty"))
    }

    /// Opens it; a gripper's link ends as `ends` says, and other programs may use it meanwhile. What a person should know of it goes
    /// to standard error.
    ///
    /// # Errors
    /// For people.
    pub fn open(&self, ends: Ends) -> Result<Arc<dyn Source>, Box<dyn std::error::Error>> {
        match self.place()? {
            Place::Link(link) => {
                self.no_bus("a gripper (--link, or FRE_LINK in the environment)")?;
                Ok(Arc::new(Lasting::open(&link, ends)?))
            }
            Place::Bus(address) => {
                let bus = Bus::open(&address, &self.bus_options()?)?;
                for note in bus.notes() {
                    tell!("fre: {note}");
                }
                Ok(Arc::new(bus))
            }
        }
    }

    /// Refuses options that are about a bus, where `source` is none.
    ///
    /// # Errors
    /// One is given.
    pub fn no_bus(&self, source: &str) -> Result<(), String> {
        let given = [
            ("--case", !self.case.is_empty()),
            ("--settings", self.settings.is_some()),
            ("--set", !self.set.is_empty()),
            ("--uncertainty", !self.uncertainty.is_empty()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(format!("{option} is for --bus only; here the source is {source}")),
            None => Ok(()),
        }
    }

    /// Where the source is: as the command line says, or else the environment.
    fn place(&self) -> Result<Place, String> {
        let place = match (&self.link, &self.bus) {
            (Some(link), _) => Some(Place::Link(link.clone())),
            (None, Some(bus)) => Some(Place::Bus(bus.clone())),
            (None, None) => match (environment::value(LINK), environment::value(BUS)) {
                (Some(_), Some(_)) => {
                    return Err(format!("{LINK} and {BUS} are both set; --link or --bus says which of them is meant"));
                }
                (_, None) => environment::or_else(None, LINK)?.map(Place::Link),
                (None, _) => environment::or_else(None, BUS)?.map(Place::Bus),
            },
        };
        place.ok_or_else(nowhere)
    }

    fn bus_options(&self) -> Result<BusOptions, Box<dyn std::error::Error>> {
        let mut settings = Settings::DEFAULT;
        let mut names_servos = false;
        let mut take = |words: &str| {
            names_servos |= words.contains(".servo_id");
            set(&mut settings, words)
        };
        if let Some(path) = &self.settings {
            let (text, name) = (standard::words(path)?, standard::name(path));
            for (number, line) in text.lines().enumerate() {
                if !line.trim().is_empty() && !line.trim_start().starts_with('#') {
                    take(line).map_err(|error| format!("{name}:{}: {error}", number + 1))?;
                }
            }
        }
        for words in &self.set {
            take(words).map_err(|error| format!("--set {error}"))?;
        }
        let options = self.model.options();
        let left = self.uncertainty.iter().map(|path| uncertainty(path)).collect::<Result<Vec<_>, _>>()?;
        let cases = self.case.iter().map(|path| standard::case(path));
        let cases = cases.collect::<Result<Vec<_>, _>>()?;
        let motions: Vec<_> = cases.iter().map(|case| case.path.motion).collect();
        BusOptions::check_motions(&settings, names_servos, &motions)
            .map_err(|(place, why)| format!("{}: {why}", standard::name(&self.case[place])))?;
        // The last of either stands for those behind it.
        let model = |number: usize| {
            let case = cases.get(number).or(cases.last())?;
            let finger =
                Finger::elastic(case.finger.design.clone(), options.discretisation).relaxing(&case.finger.prony);
            let uncertainty = left.get(number).or(left.last()).copied();
            Some(Modelled { finger: Some(finger), object: Some(case.object), friction: case.friction, uncertainty })
        };
        let models = (0..cases.len().max(left.len())).map_while(model).collect();
        Ok(BusOptions { settings, names_servos, models, precision: options.precision, hessian: options.hessian })
    }
}

/// What is needed, and which serial ports there are.
fn nowhere() -> String {
    let ports = ports();
    let here = if ports.is_empty() {
        "this machine has no serial port".to_owned()
    } else {
        format!("serial ports of this machine: {}", ports.join(", "))
    };
    format!("needed is --link LINK (a gripper) or --bus PORT (servos on a USB adapter); {here}")
}

/// What `fre calibrate --format json` says of a gripper's uncertainty.
fn uncertainty(path: &Path) -> Result<Uncertainty, String> {
    let (text, name) = (standard::words(path)?, standard::name(path));
    let fit: serde_json::Value = serde_json::from_str(&text).map_err(|error| format!("{name}: {error}"))?;
    let needed = "needed is what `fre calibrate --format json` writes";
    let found =
        fit.pointer("/gripper/uncertainty").ok_or_else(|| format!("{name}: has no gripper.uncertainty; {needed}"))?;
    let found: Uncertainty = serde::Deserialize::deserialize(found)
        .map_err(|error| format!("{name}: gripper.uncertainty: {error}; {needed}"))?;
    found.validate().map_err(|error| format!("{name}: gripper.uncertainty: {error}"))?;
    Ok(found)
}
