//! The commands of a gripper and its servos in a program that was built without them: each says how to build it with them.

use std::process::ExitCode;
use std::str::FromStr;

use clap::Subcommand;
use fre::fit::calibrate::{Fit, Input};
use model_core::discretise::Discretisation;

use crate::exit::bad_input;

/// The commands of a gripper and its servos.
#[derive(Debug, Subcommand)]
pub enum Hardware {
    /// Show the firmware in QEMU beside the references (needs a build with `--features gripper`)
    Demo(Rest),
    /// Write a board's firmware through a debug probe (needs a build with `--features probe`)
    Flash(Rest),
    /// Query a gripper, change its settings, make it grip (needs `--features gripper`)
    Gripper(Rest),
    /// Show a board's log (needs a build with `--features probe`; --qemu with `--features log`)
    Log(Rest),
    /// Watch a gripper or servos live (needs a build with `--features gripper`)
    Monitor(Rest),
    /// Show a recording, or estimate on it once more (needs a build with `--features record`)
    Replay(Rest),
    /// Be a node of ROS 2 (needs a build with `--features ros2`)
    Ros2(Rest),
    /// Simulate Dynamixel servos on a bus (needs a build with `--features gripper`)
    Servo(Rest),
    /// Run a gripper without hardware (needs a build with `--features gripper`)
    Sim(Rest),
}

/// Arguments that this program does not know.
#[derive(Debug, clap::Args)]
pub struct Rest {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    words: Vec<String>,
}

impl Hardware {
    /// Says how to build the program with the command.
    pub fn run(self) -> ExitCode {
        let (command, rest, feature) = match self {
            Self::Demo(rest) => ("demo", rest, "gripper"),
            Self::Flash(rest) => ("flash", rest, "probe"),
            Self::Gripper(rest) => ("gripper", rest, "gripper"),
            Self::Log(rest) => ("log", rest, "probe"),
            Self::Monitor(rest) => ("monitor", rest, "gripper"),
            Self::Replay(rest) => ("replay", rest, "record"),
            Self::Ros2(rest) => ("ros2", rest, "ros2"),
            Self::Servo(rest) => ("servo", rest, "gripper"),
            Self::Sim(rest) => ("sim", rest, "gripper"),
        };
        let words = [vec![command.to_owned()], rest.words].concat().join(" ");
        bad_input(&not_built(command, feature, &words))
    }
}

/// The message of a command or option that needs the feature.
fn not_built(what: &str, feature: &str, words: &str) -> String {
    format!(
        "this `fre` was built without `{what}`; build it with: cargo run --release -p fre-cli --features {feature} -- {words}"
    )
}

/// Where a gripper is, of which there is none here.
#[derive(Clone, Debug)]
pub enum Address {}

impl FromStr for Address {
    type Err = String;

    fn from_str(_: &str) -> Result<Self, String> {
        Err(not_built("--send", "gripper", "calibrate …"))
    }
}

/// Sends a calibration to a gripper, of which there is none here.
pub fn transmit(address: &Address, _: u8, _: Discretisation, _: &Input, _: &Fit, _: bool) -> Result<(), String> {
    match *address {}
}
