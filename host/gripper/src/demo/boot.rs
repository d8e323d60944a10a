//! The gripper booted, with a servo on its bus, a finger and an object.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use messages::{Mount, Settings, Version};
use model_core::design::Design;
use model_core::discretise::{Discretisation, Physics, Scheme};
use model_core::drive::Drive;

use super::error::DemoError;
use super::heard::Heard;
use super::lead::{CLOSED_DEG, OPEN_DEG};
use super::machine::Machine;
use super::task::{OBJECT, PRESET};
use crate::link::Link;
use crate::servo::{Clock, Config, Gains, Load, OnBranch, Servo};
use fre::case::preset;
use fre::study::model;
use fre_qemu::Pace;

/// The servo's table reaches so far beyond the closed finger, degrees.
const MARGIN_DEG: f64 = 3.0;

/// A gripper that knows its finger and its object, and whose first estimate has come.
pub(super) struct Booted {
    pub(super) machine: Machine,
    pub(super) link: Link,
    pub(super) heard: Heard,
    pub(super) version: Version,
    pub(super) design: Design,
    pub(super) servo: Config,
    /// Force of the closed finger, N.
    pub(super) hardest: f64,
}

/// Boots the firmware with a servo on its bus; `log` takes its log.
pub(super) fn boot(
    firmware: &Path,
    log: File,
    pace: Pace,
    physics: Physics,
    shape_every: u16,
    stop: &AtomicBool,
) -> Result<Booted, DemoError> {
    let design = preset(PRESET).ok_or(DemoError::Preset(PRESET))??.design;
    let truth = model::Options { discretisation: Discretisation::full(Scheme::Paper, physics), ..Load::REFERENCE };
    let load = Arc::new(Load::of(&design, OBJECT, &Drive::Rotating, &truth, CLOSED_DEG + MARGIN_DEG)?);
    let [x, y] = load.at(CLOSED_DEG.to_radians(), &mut OnBranch::default()).force;
    let servo = Config {
        baud_rate: 1_000_000,
        return_delay_us: 0,
        clock: Clock::Wall,
        start_deg: Some(OPEN_DEG),
        noise_ma: 3.0,
        gains: Gains::GREATEST,
        load,
        ..Config::default()
    };
    let (mut machine, link) = Machine::boot(firmware, Servo::new(servo.clone())?, log, pace, stop)?;
    let mut heard = Heard::of(link.listen());
    let version = link.version().map_err(|error| machine.blame(error))?;
    let finger = messages::Finger::elastic(design.clone(), Discretisation::estimator(physics));
    // The demonstration goes further than a gripper does by default.
    let mount =
        Mount { open_angle: OPEN_DEG.to_radians() as f32, force_limit: 40.0, current_limit: 2000.0, ..Mount::DEFAULT };
    let settings = Settings { shape_every, ..Settings::of(mount) };
    let told = link
        .set_finger(0, &finger)
        .and_then(|()| link.set_object(0, OBJECT))
        .and_then(|()| link.set_settings(&settings));
    told.map_err(|error| machine.blame(error))?;
    heard.until_ready(&mut machine, stop)?;
    Ok(Booted { machine, link, heard, version, design, servo, hardest: x.hypot(y) })
}
