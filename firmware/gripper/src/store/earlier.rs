//! Records as earlier versions of their layout have them.
//!
//! Version 10: fingers of an elastic material.
//! Version 9: besides, mounts without a choice of the servo's own current limit.
//! Version 8: besides, objects without friction.
//! Version 7: besides, beams without points between their ends, factors apart and clamps.
//! Version 6: besides, settings without heat and supply.
//! Version 5: besides, lamellae that are all rigid and of one thickness.
//! Version 4: besides, no role that leads nobody, mounts that do not say how their servo was set, and no time of closing without an estimate.
//! Version 3: besides, mounts without a drive, as every finger was turned by its motor, and models whose contact softness is a number.

use messages::{
    Direction, FINGERS, Finger, Mount, Object, Reaction, Role, ServoSetup, Settings, Side, Silence, Support,
};
use model_core::design::{Attachments, Beam, Design, Hinge, Lamellae, Material, PlaneStrain, Profile};
use model_core::discretise::{Discretisation, Elements, Physics, Sampling, Scheme, Softness};
use model_core::drive::Drive;
use model_core::object::ObjectDesign;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn before(mount: Mount) -> Mount3 {
        Mount3 {
            servo_id: mount.servo_id,
            zero: mount.zero,
            direction: mount.direction,
            gear_ratio: mount.gear_ratio,
            backlash: mount.backlash,
            side: mount.side,
            range: mount.range,
            open_angle: mount.open_angle,
            speed: mount.speed,
            force_limit: mount.force_limit,
            current_limit: mount.current_limit,
        }
    }

    fn before_10(mount: Mount) -> Mount9 {
        let Mount { drive, servo, calibration, .. } = mount;
        Mount9 { before: Mount4 { before: before(mount), drive }, servo, calibration }
    }

    fn written<M>(settings: Settings, role: Role4, mount: impl Fn(Mount) -> M) -> Settings4<M> {
        let Settings { rate_hz, shape_every, on_fault, support, baud, fingers, .. } = settings;
        Settings4 { rate_hz, shape_every, on_fault, support, role, baud, fingers: fingers.map(|kept| kept.map(&mount)) }
    }

    fn expected() -> Settings {
        let mount = Mount { servo_id: 7, zero: -3.5, side: Side::Right, backlash: 0.004, ..Mount::DEFAULT };
        Settings {
            rate_hz: 250,
            on_fault: Reaction::Release,
            support: Support::Free { load: [0.5, -1.0], moment: 2.0 },
            role: Role::DEVICE,
            baud: Some(2_000_000),
            fingers: [Some(Mount::DEFAULT), Some(mount), None, None],
            ..Settings::DEFAULT
        }
    }

    #[test]
    fn settings_of_version_3_come_back_as_they_were() {
        let device = Role4::Device { id: 100, return_delay: 0 };
        let mut bytes = [0; 512];
        let used = postcard::to_slice(&written(expected(), device, before), &mut bytes).unwrap();
        assert_eq!(settings(3, used), Some(expected()));
        let length = used.len();
        assert_eq!(settings(3, &bytes[..length - 1]), None, "cut short");
    }

    #[test]
    fn settings_of_versions_5_and_6_come_back_as_they_were() {
        let expected = Settings { untrusted_ms: 70, on_silence: Silence::Hold, silence_ms: 900, ..expected() };
        let Settings { rate_hz, shape_every, on_fault, untrusted_ms, on_silence, silence_ms, support, role, .. } =
            expected;
        let Settings { baud, fingers, .. } = expected;
        let before = Settings6 {
            rate_hz,
            shape_every,
            on_fault,
            untrusted_ms,
            on_silence,
            silence_ms,
            support,
            role,
            baud,
            fingers: fingers.map(|kept| kept.map(before_10)),
        };
        let mut bytes = [0; 512];
        let used = postcard::to_slice(&before, &mut bytes).unwrap();
        for version in [5, 6] {
            assert_eq!(settings(version, used), Some(expected));
        }
        let length = used.len();
        assert_eq!(settings(6, &bytes[..length - 1]), None, "cut short");
    }

    #[test]
    fn settings_of_version_4_come_back_as_they_were() {
        let drive = Drive::linear([0.6, 0.8], 12.5);
        let roles = [
            (Role4::Master, Role::Master),
            (Role4::Tap, Role::Tap),
            (Role4::Device { id: 100, return_delay: 0 }, Role::DEVICE),
        ];
        for (kept, role) in roles {
            let mut expected = Settings { role, ..expected() };
            expected.fingers[1].as_mut().unwrap().drive = drive;
            let mount = |mount: Mount| Mount4 { before: before(mount), drive: mount.drive };
            let mut bytes = [0; 512];
            let used = postcard::to_slice(&written(expected, kept, mount), &mut bytes).unwrap();
            assert_eq!(settings(4, used), Some(expected));
            let length = used.len();
            assert_eq!(settings(4, &bytes[..length - 1]), None, "cut short");
        }
    }

    /// A finger with as much of everything as one of those versions had room for.
    fn straight() -> Design {
        let mut design = crate::store::tests::longest().design;
        for beam in [&mut design.front, &mut design.back] {
            let Beam { base, tip, sagitta, stiffness_factor, .. } = *beam;
            *beam = Beam { sagitta, stiffness_factor, ..Beam::straight(base, tip, beam.thickness.clone()) };
        }
        design
    }

    /// One with lamellae that are all rigid.
    fn rigid() -> Design {
        let mut design = straight();
        design.lamellae = Lamellae::rigid(design.lamellae.attachments, 3.0);
        design
    }

    fn kept<L>(design: &Design, lamellae_before: impl Fn(Lamellae) -> L) -> Design7<L> {
        let Design { width, plane_strain, material, front, back, lamellae, hinge, rigid_above, motor_axis } =
            design.clone();
        let [front, back] = [front, back].map(|beam| {
            let Beam { base, tip, sagitta, thickness, stiffness_factor, .. } = beam;
            Beam7 { base, tip, sagitta, thickness, stiffness_factor }
        });
        let lamellae = lamellae_before(lamellae);
        Design7 { width, plane_strain, material, front, back, lamellae, hinge, rigid_above, motor_axis }
    }

    fn of_one_thickness(lamellae: Lamellae) -> Lamellae5 {
        Lamellae5 { thickness: lamellae.thickness_of(0)[0], attachments: lamellae.attachments }
    }

    #[test]
    fn a_finger_of_versions_6_and_7_comes_back_with_beams_as_they_were() {
        let (design, how) = (straight(), Discretisation::estimator(Physics::Extended));
        let mut bytes = [0; super::super::RECORD];
        let kept = Some(Finger7 { design: kept(&design, |lamellae| lamellae), how });
        let used = postcard::to_slice(&kept, &mut bytes).unwrap();
        for version in [6, 7] {
            assert_eq!(finger(version, used), Some(Some(Finger::elastic(design.clone(), how))));
        }
        let length = used.len();
        assert_eq!(finger(7, &bytes[..length - 1]), None, "cut short");
    }

    #[test]
    fn settings_of_versions_7_to_9_come_back_without_a_fence() {
        let mut bytes = [0; super::super::RECORD];
        let mut kept = Settings { untrusted_ms: 70, heat_margin: 11, supply_margin: 0.5, ..expected() };
        let servo = ServoSetup { model: 1020, operating_mode: 3, position_limits: [5, 4000], ..ServoSetup::UNREAD };
        kept.fingers[1] = kept.fingers[1].map(|mount| Mount { servo: Some(servo), calibration: 77, ..mount });
        let Settings { rate_hz, shape_every, on_fault, untrusted_ms, on_silence, silence_ms, heat_margin, .. } = kept;
        let Settings { supply_margin, on_strain, support, role, baud, fingers, .. } = kept;
        let before = Settings9 {
            rate_hz,
            shape_every,
            on_fault,
            untrusted_ms,
            on_silence,
            silence_ms,
            heat_margin,
            supply_margin,
            on_strain,
            support,
            role,
            baud,
            fingers: fingers.map(|kept| kept.map(before_10)),
        };
        let used = postcard::to_slice(&before, &mut bytes).unwrap();
        for version in 7..=9 {
            assert_eq!(settings(version, used), Some(kept));
        }
        let length = used.len();
        assert_eq!(settings(9, &bytes[..length - 1]), None, "cut short");
    }

    #[test]
    fn settings_of_version_10_come_back_as_they_were() {
        let mut bytes = [0; super::super::RECORD];
        let mut kept = expected();
        kept.fingers[0] = kept.fingers[0].map(|mount| Mount { current_fence: true, ..mount });
        let used = postcard::to_slice(&kept, &mut bytes).unwrap();
        assert_eq!(settings(10, used), Some(kept));
        let length = used.len();
        assert_eq!(settings(10, &bytes[..length - 1]), None, "cut short");
    }

    #[test]
    fn a_finger_of_versions_8_to_10_and_an_object_of_any_come_back() {
        let mut bytes = [0; super::super::RECORD];
        let Finger { design, how, .. } = crate::store::tests::longest();
        let used = postcard::to_slice(&Some(Finger10 { design: design.clone(), how }), &mut bytes).unwrap();
        for version in 8..=10 {
            assert_eq!(finger(version, used), Some(Some(Finger::elastic(design.clone(), how))));
        }
        let length = used.len();
        assert_eq!(finger(10, &bytes[..length - 1]), None, "cut short");
        let design = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 30.0 };
        let used = postcard::to_slice(&Some(design), &mut bytes).unwrap();
        for version in 3..=8 {
            assert_eq!(object(version, used), Some(Some(Object { design, friction: 0.0 })));
        }
        let length = used.len();
        assert_eq!(object(8, &bytes[..length - 1]), None, "cut short");
        let rough = Some(Object { design, friction: 0.5 });
        let used = postcard::to_slice(&rough, &mut bytes).unwrap();
        assert_eq!(object(9, used), Some(rough));
    }

    #[test]
    fn a_finger_of_versions_4_and_5_comes_back_with_rigid_lamellae() {
        let (design, how) = (rigid(), Discretisation::estimator(Physics::Extended));
        let mut bytes = [0; super::super::RECORD];
        let used =
            postcard::to_slice(&Some(Finger7 { design: kept(&design, of_one_thickness), how }), &mut bytes).unwrap();
        for version in [4, 5] {
            assert_eq!(finger(version, used), Some(Some(Finger::elastic(design.clone(), how))));
        }
        let length = used.len();
        assert_eq!(finger(5, &bytes[..length - 1]), None, "cut short");
    }

    #[test]
    fn a_finger_of_version_3_comes_back_with_the_beams_own_softness() {
        let design = rigid();
        let Discretisation { scheme, elements, sampling, physics, .. } = Discretisation::estimator(Physics::Extended);
        let mut bytes = [0; super::super::RECORD];
        for (softness, expected) in [(1e-3, Softness::Local), (0.0, Softness::Fixed(0.0))] {
            let kept = Some(Finger3 {
                design: kept(&design, of_one_thickness),
                scheme,
                elements,
                sampling,
                softness,
                physics,
            });
            let used = postcard::to_slice(&kept, &mut bytes).unwrap();
            let how = Discretisation { scheme, elements, sampling, softness: expected, physics };
            let expected = Some(Some(Finger::elastic(design.clone(), how)));
            assert_eq!(finger(3, used), expected);
        }
        let none = postcard::to_slice(&None::<Finger3>, &mut bytes).unwrap();
        assert_eq!(finger(3, none), Some(None));
    }
}
