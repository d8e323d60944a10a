//! What the gripper reports, in words for people.

use core::fmt::{self, Display};

use dynamixel::{StatusError, name_of};

use crate::{Derating, Difference, Event, ResetCause, ServoField, Strain};

impl ResetCause {
    /// The cause, for use after "because".
    pub fn words(self) -> &'static str {
        match self {
            Self::PowerOn => "power came",
            Self::Pin => "it was reset from outside",
            Self::Watchdog => "the control loop had stopped",
            Self::Software => "the program restarted itself",
            Self::Brownout => "the supply voltage was too low",
            Self::Unknown => "of something the processor does not tell",
        }
    }
}

/// What a servo of this model number is called, if it is known.
fn named(model: i32) -> Option<&'static str> {
    u16::try_from(model).ok().and_then(name_of)
}

impl Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { field, found, expected } = self;
        match field {
            ServoField::Model if *expected == 0 => match named(*found) {
                Some(name) => write!(f, "its servo is an {name} (model {found}), which the gripper cannot control"),
                None => write!(f, "its servo is of the unknown model {found}, which the gripper cannot control"),
            },
            ServoField::StartupConfiguration if *expected == 0 => {
                f.write_str("its servo's Startup Configuration switches the torque on with the power: set it to 0")
            }
            ServoField::PresentPosition => write!(
                f,
                "its servo is at {found}, outside its position limits: turn it to {expected}, or change the limits"
            ),
            ServoField::Id => {
                write!(f, "what id {found} answers is garbled, pings are not: two servos seem to have this id")
            }
            ServoField::GoalCurrent => f.write_str(
                "its servo has no current-based position control (Operating Mode 5), which current_fence needs",
            ),
            ServoField::StatusReturnLevel => {
                write!(
                    f,
                    "its servo's Status Return Level was {found}, so that it did not answer everything; it is set to {expected}"
                )
            }
            ServoField::BusWatchdog => f.write_str("its servo's Bus Watchdog had tripped; it is cleared"),
            _ => write!(f, "its servo's {} is {found}, and {expected} was commissioned", field.name()),
        }
    }
}

/// A servo's model number, behind its name if that is known.
struct Named(u16);

impl Display for Named {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(model) = *self;
        match name_of(model) {
            Some(name) => write!(f, "{name}, model {model}"),
            None => write!(f, "model {model}"),
        }
    }
}

impl Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Started { cause } => write!(f, "the gripper started because {}", cause.words()),
            Self::Restored { records, damaged: 0 } => write!(f, "{records} settings were found in flash"),
            Self::Restored { records, damaged } => {
                write!(f, "{records} settings were found in flash, and {damaged} that are damaged and gone")
            }
            Self::ServoReady { finger, model, firmware, baud } => {
                write!(f, "finger {finger}: the servo ({}, firmware {firmware}) answers at {baud} baud", Named(model))
            }
            Self::ServoDiffers { finger, difference } => write!(f, "finger {finger} is not controlled: {difference}"),
            Self::DeviceFound { id, model, firmware, baud, alert } => {
                let error = if alert { ", with a hardware error" } else { "" };
                write!(f, "id {id}: {}, firmware {firmware}, answers at {baud} baud{error}", Named(model))
            }
            Self::ScanDone { found: 1, rates } => write!(f, "the bus was searched at {rates} rates: 1 device"),
            Self::ScanDone { found, rates } => write!(f, "the bus was searched at {rates} rates: {found} devices"),
            Self::ServoHeard { finger } => write!(f, "finger {finger}: another master reads the servo's position"),
            Self::Rate { hz, wanted_hz } if hz < wanted_hz => {
                write!(f, "{hz:.1} ticks a second: the bus is too slow for {wanted_hz:.0}")
            }
            Self::Rate { hz, .. } => write!(f, "{hz:.1} ticks a second"),
            Self::RateReached { hz, chosen_hz } if hz < 0.95 * chosen_hz => {
                write!(f, "only {hz:.1} ticks a second are reached, {chosen_hz:.1} were meant")
            }
            Self::RateReached { hz, .. } => write!(f, "{hz:.1} ticks a second are reached again"),
            Self::ServoLost { finger, other_master } => {
                write!(f, "finger {finger}: the servo is lost; estimates are stale")?;
                f.write_str(if other_master { "; another master speaks on the bus" } else { "" })
            }
            Self::OtherMaster { packets } => {
                write!(f, "another master speaks on the bus ({packets} instructions so far): only one may")
            }
            Self::ServoAlert { finger, hardware_error: 0 } => {
                write!(f, "finger {finger}: the servo has no hardware error any more")
            }
            Self::ServoAlert { finger, hardware_error } => {
                write!(f, "finger {finger}: the servo reports hardware errors {hardware_error:#010b}")
            }
            Self::Derated { finger, derating, strain, temperature, volts } => {
                let limit = match strain {
                    Strain::Heat => "its Temperature Limit",
                    Strain::Supply => "its Min Voltage Limit",
                };
                write!(f, "finger {finger}: the servo has {temperature} °C and {volts:.1} V, ")?;
                match derating {
                    Derating::Free => f.write_str("as it should: it may do everything again"),
                    Derating::Warned => write!(f, "near {limit}"),
                    Derating::Limited => write!(f, "nearer to {limit}: its force is limited"),
                    Derating::Stopped => write!(f, "very near {limit}: it neither closes nor grips"),
                }
            }
            Self::GoalRefused { finger, position, error } => {
                write!(f, "finger {finger}: the servo refused the goal {position}: ")?;
                match StatusError::from_code(error) {
                    Some(StatusError::DataLimit) => f.write_str("it is outside its Min and Max Position Limit"),
                    Some(error) => write!(f, "{error}"),
                    None => write!(f, "error {error}"),
                }
            }
            Self::ModelReady { finger, .. } => write!(f, "finger {finger}: the model was set up anew"),
            Self::Touched { finger, angle } => {
                write!(f, "finger {finger} met something at {:.2}°", angle.to_degrees())
            }
            Self::TorquesDisagree { finger, disagree: true, demanded, current } => write!(
                f,
                "finger {finger}: {demanded:.0} N·mm are demanded of the motor, which {current:.0} mA do not show: the object is not as described"
            ),
            Self::TorquesDisagree { finger, .. } => {
                write!(f, "finger {finger}: current and demanded torque agree again")
            }
            Self::PhaseChanged { finger, phase } => write!(f, "finger {finger} {phase}"),
        }
    }
}
