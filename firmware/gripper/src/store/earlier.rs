//! Records as earlier versions of their layout have them.
//!
//! Version 11: uncertainties without those of a material with memory.
//! Version 10: besides, fingers of an elastic material.
//! Version 9: besides, mounts without a choice of the servo's own current limit.
//! Version 8: besides, objects without friction.
//! Version 7: besides, beams without points between their ends, factors apart and clamps.
//! Version 6: besides, settings without heat and supply.
//! Version 5: besides, lamellae that are all rigid and of one thickness.
//! Version 4: besides, no role that leads nobody, mounts that do not say how their servo was set, and no time of closing without an estimate.
//! Version 3: besides, mounts without a drive, as every finger was turned by its motor, and models whose contact softness is a number.

#[cfg(test)]
mod tests;

use messages::{
    Direction, FINGERS, Finger, Mount, Object, Reaction, Role, ServoSetup, Settings, Side, Silence, Support,
};
use model_core::design::{Attachments, Beam, Design, Hinge, Lamellae, Material, PlaneStrain, Profile};
use model_core::discretise::{Discretisation, Elements, Physics, Sampling, Scheme, Softness};
use model_core::drive::Drive;
use model_core::object::ObjectDesign;
use model_core::uncertainty::{MemoryUncertainty, Uncertainty};
use postcard_rpc::postcard;
use serde::Deserialize;

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct Mount3 {
    servo_id: u8,
    zero: f32,
    direction: Direction,
    gear_ratio: f32,
    backlash: f32,
    side: Side,
    range: [f32; 2],
    open_angle: f32,
    speed: f32,
    force_limit: f32,
    current_limit: f32,
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct Uncertainty11 {
    quantisation: f32,
    backlash: f32,
    zero_angle: f32,
    youngs_modulus: f32,
    centre: [f32; 2],
    radius: f32,
    correlations: [f32; 10],
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct Mount9 {
    before: Mount4,
    servo: Option<ServoSetup>,
    calibration: u32,
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct Mount4 {
    before: Mount3,
    drive: Drive,
}

#[derive(Clone, Copy, Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
enum Role4 {
    Master,
    Tap,
    Device { id: u8, return_delay: u8 },
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct Settings4<Mount> {
    rate_hz: u16,
    shape_every: u16,
    on_fault: Reaction,
    support: Support,
    role: Role4,
    baud: Option<u32>,
    fingers: [Option<Mount>; FINGERS],
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct Settings6 {
    rate_hz: u16,
    shape_every: u16,
    on_fault: Reaction,
    untrusted_ms: u16,
    on_silence: Silence,
    silence_ms: u16,
    support: Support,
    role: Role,
    baud: Option<u32>,
    fingers: [Option<Mount9>; FINGERS],
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct Settings9 {
    rate_hz: u16,
    shape_every: u16,
    on_fault: Reaction,
    untrusted_ms: u16,
    on_silence: Silence,
    silence_ms: u16,
    heat_margin: u8,
    supply_margin: f32,
    on_strain: Reaction,
    support: Support,
    role: Role,
    baud: Option<u32>,
    fingers: [Option<Mount9>; FINGERS],
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct Lamellae5 {
    attachments: Attachments,
    thickness: f64,
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct Beam7 {
    base: [f64; 2],
    tip: [f64; 2],
    sagitta: f64,
    thickness: Profile,
    stiffness_factor: f64,
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct Design7<L> {
    width: Profile,
    plane_strain: PlaneStrain,
    material: Material,
    front: Beam7,
    back: Beam7,
    lamellae: L,
    hinge: Hinge,
    rigid_above: Option<f64>,
    motor_axis: [f64; 2],
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct Finger10 {
    design: Design,
    how: Discretisation,
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct Finger7<L> {
    design: Design7<L>,
    how: Discretisation,
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct Finger3 {
    design: Design7<Lamellae5>,
    scheme: Scheme,
    elements: Elements,
    sampling: Sampling,
    softness: f64,
    physics: Physics,
}

/// A finger, if there was one, from the bytes of a record of that version. The softness that every model of version 3 had by default
/// becomes the beam's own.
pub(super) fn finger(version: u8, bytes: &[u8]) -> Option<Option<Finger>> {
    if version >= 11 {
        return super::same(bytes);
    }
    if version >= 8 {
        let kept: Option<Finger10> = postcard::from_bytes(bytes).ok()?;
        return Some(kept.map(|Finger10 { design, how }| Finger::elastic(design, how)));
    }
    if version >= 6 {
        let kept: Option<Finger7<Lamellae>> = postcard::from_bytes(bytes).ok()?;
        return Some(kept.map(|Finger7 { design, how }| Finger::elastic(design.now(|lamellae| lamellae), how)));
    }
    if version >= 4 {
        let kept: Option<Finger7<Lamellae5>> = postcard::from_bytes(bytes).ok()?;
        return Some(kept.map(|Finger7 { design, how }| Finger::elastic(design.now(Lamellae5::now), how)));
    }
    let kept: Option<Finger3> = postcard::from_bytes(bytes).ok()?;
    Some(kept.map(|Finger3 { design, scheme, elements, sampling, softness, physics }| {
        let softness = if softness == 1e-3 { Softness::Local } else { Softness::Fixed(softness) };
        let how = Discretisation { scheme, elements, sampling, softness, physics };
        Finger::elastic(design.now(Lamellae5::now), how)
    }))
}

/// An object, if there was one, from the bytes of a record of that version: before version 9 without friction.
pub(super) fn object(version: u8, bytes: &[u8]) -> Option<Option<Object>> {
    if version >= 9 {
        return super::same(bytes);
    }
    let kept: Option<ObjectDesign> = postcard::from_bytes(bytes).ok()?;
    Some(kept.map(Object::from))
}

/// An uncertainty, if there was one, from the bytes of a record of any of these versions: that of the terms is what it is unless it was given.
pub(super) fn uncertainty(_: u8, bytes: &[u8]) -> Option<Option<Uncertainty>> {
    let kept: Option<Uncertainty11> = super::same(bytes)?;
    Some(kept.map(|kept| {
        let Uncertainty11 { quantisation, backlash, zero_angle, youngs_modulus, centre, radius, correlations } = kept;
        let memory = MemoryUncertainty::DEFAULT;
        Uncertainty { quantisation, backlash, zero_angle, youngs_modulus, centre, radius, correlations, memory }
    }))
}

/// Settings from the bytes of a record of that version, if they are sound. What was the servos' master stays it.
pub(super) fn settings(version: u8, bytes: &[u8]) -> Option<Settings> {
    if version >= 10 {
        return super::same(bytes);
    }
    if version >= 7 {
        let kept: Settings9 = super::same(bytes)?;
        return Some(kept.now());
    }
    if version >= 5 {
        let kept: Settings6 = super::same(bytes)?;
        return Some(kept.now());
    }
    if version == 4 {
        let kept: Settings4<Mount4> = postcard::from_bytes(bytes).ok()?;
        return Some(kept.now(Mount4::now));
    }
    let kept: Settings4<Mount3> = postcard::from_bytes(bytes).ok()?;
    Some(kept.now(Mount3::now))
}

impl Beam7 {
    fn now(self) -> Beam {
        let Self { base, tip, sagitta, thickness, stiffness_factor } = self;
        Beam { sagitta, stiffness_factor, ..Beam::straight(base, tip, thickness) }
    }
}

impl Lamellae5 {
    fn now(self) -> Lamellae {
        Lamellae::rigid(self.attachments, self.thickness)
    }
}

impl<L> Design7<L> {
    fn now(self, lamellae_now: impl Fn(L) -> Lamellae) -> Design {
        let Self { width, plane_strain, material, front, back, lamellae, hinge, rigid_above, motor_axis } = self;
        let lamellae = lamellae_now(lamellae);
        let [front, back] = [front, back].map(Beam7::now);
        Design { width, plane_strain, material, front, back, lamellae, hinge, rigid_above, motor_axis }
    }
}

impl Settings6 {
    fn now(self) -> Settings {
        Settings {
            rate_hz: self.rate_hz,
            shape_every: self.shape_every,
            on_fault: self.on_fault,
            untrusted_ms: self.untrusted_ms,
            on_silence: self.on_silence,
            silence_ms: self.silence_ms,
            support: self.support,
            role: self.role,
            baud: self.baud,
            fingers: self.fingers.map(|kept| kept.map(Mount9::now)),
            ..Settings::DEFAULT
        }
    }
}

impl Settings9 {
    fn now(self) -> Settings {
        Settings {
            rate_hz: self.rate_hz,
            shape_every: self.shape_every,
            on_fault: self.on_fault,
            untrusted_ms: self.untrusted_ms,
            on_silence: self.on_silence,
            silence_ms: self.silence_ms,
            heat_margin: self.heat_margin,
            supply_margin: self.supply_margin,
            on_strain: self.on_strain,
            support: self.support,
            role: self.role,
            baud: self.baud,
            fingers: self.fingers.map(|kept| kept.map(Mount9::now)),
        }
    }
}

impl<M> Settings4<M> {
    fn now(self, mount: impl Fn(M) -> Mount) -> Settings {
        Settings {
            rate_hz: self.rate_hz,
            shape_every: self.shape_every,
            on_fault: self.on_fault,
            support: self.support,
            role: match self.role {
                Role4::Master => Role::Master,
                Role4::Tap => Role::Tap,
                Role4::Device { id, return_delay } => Role::Device { id, return_delay },
            },
            baud: self.baud,
            fingers: self.fingers.map(|kept| kept.map(&mount)),
            ..Settings::DEFAULT
        }
    }
}

impl Mount9 {
    fn now(self) -> Mount {
        let Self { before, servo, calibration } = self;
        Mount { servo, calibration, ..before.now() }
    }
}

impl Mount4 {
    fn now(self) -> Mount {
        Mount { drive: self.drive, ..self.before.now() }
    }
}

impl Mount3 {
    fn now(self) -> Mount {
        Mount {
            servo_id: self.servo_id,
            zero: self.zero,
            direction: self.direction,
            gear_ratio: self.gear_ratio,
            backlash: self.backlash,
            side: self.side,
            range: self.range,
            open_angle: self.open_angle,
            speed: self.speed,
            force_limit: self.force_limit,
            current_limit: self.current_limit,
            current_fence: false,
            drive: Drive::Rotating,
            servo: None,
            calibration: 0,
        }
    }
}
