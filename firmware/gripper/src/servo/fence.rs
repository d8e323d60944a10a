//! The second fence: what a servo's own current control lets its motor give, behind the limits that the gripper keeps by its estimate and
//! by the currents that it reads.
//!
//! In current-based position control (Operating Mode 5) the motor gets no more than Goal Current. It is set to what the force limit needs at
//! the point of the finger that is farthest from the motor's axis, and the friction of the gears on top: the motor has to overcome that
//! before the finger moves. So it never keeps a finger from its force, and it is coarse: docs/hardware.md says how coarse.

use dynamixel::{Id, Model, xm430};
use model_core::design::{Beam, Design};
use model_core::drive::Drive;
use model_core::real::Real;

use super::{BusError, Servos};
use crate::board::BusPort;

/// What a finger's motor needs at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fence {
    /// Torque of the servo behind its friction, N·mm; infinite if no finger is known.
    pub(crate) torque: f32,
    /// Current, mA.
    pub(crate) current: f32,
}

/// Angles at which the slope of a drive is looked at.
const LOOKS: u8 = 32;

impl Fence {
    /// What the model's Goal Current has to be for it, at most `most`.
    pub(crate) fn goal_current(&self, model: &Model, most: i16) -> i16 {
        let needed = (self.torque + model.motor.friction) / model.motor.torque_constant;
        let units = needed.min(self.current) / model.effort_milliamperes();
        // Rounded up: a finger that may use its force can. Casts saturate.
        (units as i16).saturating_add(1).min(most)
    }
}

/// How far from the motor's axis a finger's front beam is at most, mm, bent or not.
pub(crate) fn reach(design: &Design) -> f32 {
    let Design { front: Beam { base, tip, via, .. }, motor_axis: [x, y], .. } = design;
    let squared = |[u, v]: &[f64; 2]| (u - x) * (u - x) + (v - y) * (v - y);
    Real::sqrt([base, tip].into_iter().chain(via).map(squared).fold(0.0, f64::max)) as f32
}

/// Torque of the finger's motor per N at the finger, N·mm: at most over a range of its angle, rad.
pub(crate) fn lever(drive: &Drive, range: [f32; 2], reach: f32) -> f32 {
    if *drive == Drive::Rotating {
        return reach;
    }
    let [least, most] = range.map(f64::from);
    let slope = |look| {
        let angle = least + (most - least) * f64::from(look) / f64::from(LOOKS);
        drive.coordinate(angle).map_or(0.0, |[_, slope]| slope)
    };
    (0..=LOOKS).map(slope).fold(0.0, f64::max) as f32
}

impl<U: BusPort> Servos<U> {
    /// The Goal Current that a finger's servo is to have, if it has another one.
    pub(crate) fn unfenced(&self, finger: usize, fence: Fence) -> Option<i16> {
        let most = self.most_current.get(finger).copied().flatten()?;
        let wanted = fence.goal_current(self.model(finger), most);
        (self.fences.get(finger).copied().flatten() != Some(wanted)).then_some(wanted)
    }

    /// Sets it.
    pub(crate) async fn fence(&mut self, finger: usize, id: Id, goal_current: i16) -> Result<(), BusError<U>> {
        let register = self.model(finger).at(xm430::GOAL_CURRENT);
        let written = self.master.set(id, register, goal_current).await;
        if written.is_ok()
            && let Some(fence) = self.fences.get_mut(finger)
        {
            *fence = Some(goal_current);
        }
        written.map(|_| ())
    }

    /// A servo was found: its Current Limit if it is in current-based position control, and nothing is known of its Goal Current.
    pub(super) fn is_fenced_by(&mut self, finger: usize, most: Option<i16>) {
        if let (Some(fence), Some(known)) = (self.fences.get_mut(finger), self.most_current.get_mut(finger)) {
            (*fence, *known) = (None, most);
        }
    }
}
