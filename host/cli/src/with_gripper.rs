//! The commands of a gripper and its servos.

use std::process::ExitCode;

use clap::Subcommand;

use super::{demo, flash, gripper, log, monitor, replay, ros2, servo, sim};

/// The commands of a gripper and its servos.
#[derive(Debug, Subcommand)]
pub enum Hardware {
    Demo(demo::Args),
    Flash(flash::Args),
    Gripper(gripper::Args),
    Log(log::Args),
    Monitor(monitor::Args),
    Replay(replay::Args),
    Ros2(ros2::Args),
    Servo(servo::Args),
    Sim(sim::Args),
}

impl Hardware {
    /// Runs the command.
    pub fn run(self) -> ExitCode {
        match self {
            Self::Demo(args) => demo::run(args),
            Self::Flash(args) => flash::run(&args),
            Self::Gripper(args) => gripper::run(&args),
            Self::Log(args) => log::run(&args),
            Self::Monitor(args) => monitor::run(&args),
            Self::Replay(args) => replay::run(&args),
            Self::Ros2(args) => ros2::run(&args),
            Self::Servo(args) => servo::run(&args),
            Self::Sim(args) => sim::run(&args),
        }
    }
}
