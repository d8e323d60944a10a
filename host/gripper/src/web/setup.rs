//! What the source has, for the page: fingers, objects, settings.

use messages::{Mount, Reaction, Settings, Side};
use model_core::design::Design;
use model_core::object::{Motion, ObjectDesign};
use serde::{Deserialize, Serialize};

use super::object::{ObjectFields, contour};
use crate::link::whole;
use crate::source::{self, Origin};
use fre::drive;
use fre::shape::Shape;

/// All that a page shows besides what changes all the time.
#[derive(Clone, Debug, Serialize)]
pub struct Setup {
    /// Board, program, protocol, in words.
    target: String,
    /// Its fingers can be moved.
    moves: bool,
    /// Objects and settings can be changed.
    takes: bool,
    /// Something leads the fingers by itself and can go on.
    demonstration: bool,
    fingers: Vec<Finger>,
}

#[derive(Clone, Debug, Serialize)]
struct Finger {
    name: String,
    /// It is on the right of the object: drawn as its mirror image.
    mirrored: bool,
    design: Option<Drawing>,
    object: Option<ObjectFields>,
    object_contour_mm: Option<Vec<[f64; 2]>>,
    /// About which a free object turns; none for a half-plane.
    object_centre_mm: Option<[f64; 2]>,
    limits: Limits,
    /// Base shifts, open and closed, of a finger that is not turned.
    way_mm: Option<[[f64; 2]; 2]>,
}

/// The undeformed finger, finger frame.
#[derive(Clone, Debug, Serialize)]
struct Drawing {
    axis_mm: [f64; 2],
    front_mm: [[f64; 2]; 2],
    back_mm: [[f64; 2]; 2],
    front_thickness_mm: f64,
    back_thickness_mm: f64,
    lamella_mm: f64,
}

/// Settings that the page changes, of one finger and of the gripper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    force_limit_n: f32,
    current_limit_ma: f32,
    speed_deg_s: f32,
    low_deg: f32,
    high_deg: f32,
    open_deg: f32,
    rate_hz: f64,
    on_fault: OnFault,
    /// As [`fre::drive`] words it.
    drive: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum OnFault {
    Hold,
    Release,
}

impl Limits {
    fn of(settings: &Settings, mount: &Mount) -> Self {
        Self {
            force_limit_n: mount.force_limit,
            current_limit_ma: mount.current_limit,
            speed_deg_s: mount.speed.to_degrees(),
            low_deg: mount.range[0].to_degrees(),
            high_deg: mount.range[1].to_degrees(),
            open_deg: mount.open_angle.to_degrees(),
            rate_hz: f64::from(settings.rate_hz),
            on_fault: match settings.on_fault {
                Reaction::Hold => OnFault::Hold,
                Reaction::Release => OnFault::Release,
            },
            drive: drive::words(&mount.drive),
        }
    }

    /// The settings with these values for a finger.
    ///
    /// # Errors
    /// The finger does not exist, the drive cannot be read, or the rate is not a whole number.
    pub fn change(&self, settings: &Settings, finger: u8) -> Result<Settings, String> {
        let mut changed = *settings;
        let mount = changed.fingers.get_mut(usize::from(finger)).and_then(Option::as_mut);
        let mount = mount.ok_or_else(|| format!("there is no finger {finger}"))?;
        // Words are rounded: a drive that was not edited stays as it is.
        if self.drive.trim() != drive::words(&mount.drive) {
            mount.drive =
                drive::read(&self.drive).ok_or_else(|| format!("drive: `{}` is not {}", self.drive, drive::ALLOWED))?;
        }
        mount.force_limit = self.force_limit_n;
        mount.current_limit = self.current_limit_ma;
        mount.speed = self.speed_deg_s.to_radians();
        mount.range = [self.low_deg.to_radians(), self.high_deg.to_radians()];
        mount.open_angle = self.open_deg.to_radians();
        changed.rate_hz = self.rate()?;
        changed.on_fault = match self.on_fault {
            OnFault::Hold => Reaction::Hold,
            OnFault::Release => Reaction::Release,
        };
        Ok(changed)
    }

    /// The rate, if settings can have it; the gripper checks its range.
    fn rate(&self) -> Result<u16, String> {
        whole(self.rate_hz)
            .ok_or_else(|| format!("rate_hz = {}; allowed is a whole number from 1 to 1000", self.rate_hz))
    }
}

impl Setup {
    /// Of a source; `demonstration`: something leads its fingers.
    pub fn of(told: &source::Setup, demonstration: bool) -> Self {
        let count = told.settings.count();
        let fingers = told.settings.fingers.iter().flatten().enumerate().map(|(number, mount)| {
            let model = told.models.get(number);
            let design = model.and_then(|model| model.finger.as_ref()).map(|finger| &finger.design);
            let object = model.and_then(|model| model.object.as_ref());
            let side = match mount.side {
                Side::Left => "left",
                Side::Right => "right",
            };
            Finger {
                name: if count > 1 { format!("Finger {number}, {side}") } else { "Finger".to_owned() },
                mirrored: mount.side == Side::Right,
                design: design.map(drawing),
                object: model.and_then(source::Modelled::grasped).as_ref().map(ObjectFields::from),
                object_contour_mm: object.map(contour),
                object_centre_mm: object.and_then(ObjectDesign::reference).map(|(point, _)| point),
                limits: Limits::of(&told.settings, mount),
                way_mm: way(mount),
            }
        });
        let other = if told.protocol == messages::PROTOCOL_VERSION {
            String::new()
        } else {
            format!("; this program speaks protocol {}", messages::PROTOCOL_VERSION)
        };
        let firmware = &told.firmware;
        let origin = match told.origin {
            Origin::Gripper => format!("{}, firmware {firmware}, protocol {}{other}", told.board, told.protocol),
            Origin::Bus => format!("{} on {}, estimated on this PC", told.board, told.place),
            Origin::Recording => format!("recording {} ({}, firmware {firmware})", told.place, told.board),
        };
        Self {
            target: origin,
            moves: told.origin == Origin::Gripper,
            takes: told.origin != Origin::Recording,
            demonstration,
            fingers: fingers.collect(),
        }
    }
}

/// How far a base that is moved along a line is moved when the finger is open, and when it is closed as far as it may be.
fn way(mount: &Mount) -> Option<[[f64; 2]; 2]> {
    let Motion::Translating { direction } = mount.drive.motion([0.0; 2]) else { return None };
    Some([mount.open_angle, mount.range[1]].map(|angle| {
        let [distance, _] = mount.drive.coordinate(f64::from(angle)).unwrap_or_default();
        direction.map(|part| distance * part)
    }))
}

fn drawing(design: &Design) -> Drawing {
    let shape = Shape::undeformed(design);
    let ends =
        |line: &[[f64; 2]]| [line.first().copied().unwrap_or_default(), line.last().copied().unwrap_or_default()];
    Drawing {
        axis_mm: design.motor_axis,
        front_mm: ends(&shape.front),
        back_mm: ends(&shape.back),
        front_thickness_mm: design.front.thickness.at(0.5 * design.front.length()),
        back_thickness_mm: design.back.thickness.at(0.5 * design.back.length()),
        lamella_mm: design.lamellae.thickest(),
    }
}
