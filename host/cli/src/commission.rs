//! `fre gripper commission`: a person assigns a gripper its servos.

use std::process::ExitCode;

use dynamixel::{Model, name_of};
use fre_gripper::commission::{Device, commission, devices};
use fre_gripper::link::Link;

use crate::agreed::agreed;
use crate::output::put_out;

/// Find the servos on the bus, make the gripper their master, and store their settings
///
/// Before, a gripper is idle: it writes nothing to any servo. Afterwards it controls the servos named, and refuses to control one whose
/// settings have changed. Servos without torque are set to position control and to answer without delay, and then hold their position.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Servos of the fingers in turn [default: all that can be controlled]
    #[arg(long = "servo", value_name = "ID", value_delimiter = ',')]
    servos: Vec<u8>,
    /// Lets the servos limit their current by themselves, too
    ///
    /// They are set to current-based position control (Operating Mode 5), with a Goal Current from `force_limit_n` and `current_limit_ma`:
    /// a second, coarser limit, which holds if the object is not as described. XL430 and PM42 have no such mode.
    #[arg(long)]
    current_fence: bool,
    /// Writes without asking
    #[arg(long)]
    yes: bool,
}

/// Runs the command.
pub fn run(link: &Link, args: &Args) -> Result<ExitCode, Box<dyn std::error::Error>> {
    let found = devices(link)?;
    let mut text = String::new();
    for device in &found {
        text += &format!("{}\n", words(device));
    }
    put_out(&text)?;
    let servos = if args.servos.is_empty() {
        let mut servos: Vec<u8> = found.iter().filter(|device| leads(device)).map(|device| device.id).collect();
        servos.sort_unstable();
        servos
    } else {
        args.servos.clone()
    };
    if servos.is_empty() {
        return Err("no servo that the gripper can control answers on the bus: check power and wiring".into());
    }
    for (place, servo) in servos.iter().enumerate() {
        if !found.iter().any(|device| device.id == *servo) {
            return Err(format!("--servo {servo}: no such servo answers on the bus").into());
        }
        if servos[..place].contains(servo) {
            return Err(format!("--servo {servo}: named twice").into());
        }
        if found.iter().filter(|device| device.id == *servo).count() > 1 {
            return Err(format!("servo {servo} answers at several baud rates: two servos may share this id").into());
        }
    }
    let names: Vec<String> =
        servos.iter().enumerate().map(|(finger, id)| format!("finger {finger}: servo {id}")).collect();
    let control = if args.current_fence { "current-based position control" } else { "position control" };
    let question = format!(
        "{}\nServos without torque are set to {control} and Return Delay Time 0, and then hold their position.",
        names.join(", ")
    );
    if !args.yes && !agreed(&question, "--yes")? {
        return Err("nothing was written".into());
    }
    let setups = commission(link, &servos, args.current_fence)?;
    let mut text = String::new();
    for (finger, setup) in setups.iter().enumerate() {
        let [least, greatest] = setup.position_limits;
        text += &format!(
            "finger {finger} commissioned: model {}, Operating Mode {}, Drive Mode {}, Homing Offset {}, positions {least} to {greatest}\n",
            setup.model, setup.operating_mode, setup.drive_mode, setup.homing_offset
        );
    }
    put_out(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn leads(device: &Device) -> bool {
    Model::of(device.model).is_some()
}

fn words(device: &Device) -> String {
    let Device { id, model, firmware, baud } = device;
    let name = name_of(*model).unwrap_or("unknown");
    let cannot = if leads(device) { "" } else { ": cannot be controlled" };
    format!("id {id}: {name} (model {model}, firmware {firmware}) at {baud} baud{cannot}")
}
