//! `fre sim`: a whole gripper without hardware.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use messages::{Finger, Mount, Object, Settings};
use model_core::discretise::Discretisation;
use model_core::drive::Drive;

use crate::exit::bad_input;
use crate::options::ModelArgs;
use crate::output::put_out;
use crate::servo::{LoadArgs, gains};
use crate::signals::stop_flag;
use fre_gripper::demo::Pace;
use fre_gripper::servo::{Clock, Config, Gains};
use fre_gripper::sim::{Given, Sim};

/// Where `cargo xtask firmware mps2` leaves the image.
const FIRMWARE: &str = "target/boards/thumbv7em-none-eabihf/release/gripper-mps2";
/// How often is looked whether QEMU still runs.
const GLANCE: Duration = Duration::from_millis(200);

/// Run a gripper without hardware: its firmware in QEMU and a simulated servo
///
/// The servo feels the case's finger and object. The command prints the gripper's link, for `fre monitor`, `fre gripper` and everything
/// else that takes --link, then "ready". It runs until it is stopped. Several programs can use it at once while `fre monitor` is one of
/// them.
///
/// `cargo xtask firmware mps2` builds the firmware.
#[derive(Debug, clap::Args)]
#[command(
    mut_arg("scheme", |arg| arg.default_value("paper")),
    mut_arg("elements", |arg| arg.default_value("paper")),
    mut_arg("physics", |arg| arg.default_value("extended"))
)]
pub struct Args {
    #[command(flatten)]
    load: LoadArgs,
    /// The gripper's firmware for QEMU's mps2-an500
    #[arg(long, value_name = "ELF", default_value = FIRMWARE)]
    firmware: PathBuf,
    /// Leaves the gripper as new: idle, without finger and object
    ///
    /// `fre gripper commission` and `fre gripper set --case` set it up then.
    #[arg(long)]
    fresh: bool,
    /// QEMU's time per instruction: 2^N ns, N from 0 to 10, or off
    ///
    /// off is as fast as QEMU can.
    #[arg(long, value_name = "N|off", default_value = "2", value_parser = super::demo::pace)]
    icount: Pace,
    /// Motor angle at power-on [default: 2° before the first contact]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    start_deg: Option<f64>,
    /// Play between encoder and finger, 0 to 5
    #[arg(long, value_name = "DEG", default_value_t = 0.25)]
    backlash_deg: f64,
    /// The servo's position gains
    #[arg(long, value_name = "P,I,D", default_value = "800,0,0", value_parser = gains)]
    gains: Gains,
    /// Standard deviation of Present Current
    #[arg(long, value_name = "MA", default_value_t = 3.0)]
    noise_ma: f64,
    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    model: ModelArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    match serve(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => bad_input(&message),
    }
}

fn serve(args: &Args) -> Result<(), String> {
    let stop = stop_flag().map_err(|error| format!("no signals: {error}"))?;
    let case = args.load.case()?.ok_or("needed is a case: its finger and its object")?;
    let servo = Config {
        baud_rate: 1_000_000,
        return_delay_us: 0,
        clock: Clock::Wall,
        start_deg: args.start_deg,
        backlash_deg: args.backlash_deg,
        gains: args.gains,
        noise_ma: args.noise_ma,
        seed: args.seed,
        load: Arc::new(args.load.load(Some(&case), &args.model)?),
        ..Config::default()
    };
    let physics = args.model.options().discretisation.physics;
    let drive = *args.load.drive();
    let mount = Mount { backlash: args.backlash_deg.to_radians() as f32, drive, ..Mount::DEFAULT };
    // Where the simulated servo starts is where a person would call it open.
    let open = args.start_deg.filter(|_| drive == Drive::Rotating).unwrap_or(0.0).to_radians() as f32;
    let given = Given {
        settings: Settings::of(Mount { open_angle: open.max(mount.range[0]).min(mount.range[1]), ..mount }),
        finger: Finger::elastic(case.finger.design.clone(), Discretisation::estimator(physics))
            .relaxing(&case.finger.prony),
        object: Object { design: case.object, friction: case.friction },
    };
    let given = (!args.fresh).then_some(&given);
    let mut sim = Sim::boot(args.firmware.clone(), args.icount, servo, given).map_err(|error| error.to_string())?;
    let link = sim.address();
    put_out(&format!("link {link}\n\nfre monitor --link {link}\nfre gripper --link {link} info\nready\n"))?;
    while !stop.load(Ordering::Relaxed) {
        std::thread::sleep(GLANCE);
        sim.check().map_err(|error| error.to_string())?;
    }
    Ok(())
}
