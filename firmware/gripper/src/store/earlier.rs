//! Records as version 3 of their layout has them: mounts without a drive, as every finger was turned by its motor, and models whose
//! contact softness is a number.

use messages::{Direction, FINGERS, Finger, Mount, Reaction, Role, Settings, Side, Support};
use model_core::design::Design;
use model_core::discretise::{Discretisation, Elements, Physics, Sampling, Scheme, Softness};
use model_core::drive::Drive;
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
struct Settings3 {
    rate_hz: u16,
    shape_every: u16,
    on_fault: Reaction,
    support: Support,
    role: Role,
    baud: Option<u32>,
    fingers: [Option<Mount3>; FINGERS],
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(serde::Serialize))]
struct Finger3 {
    design: Design,
    scheme: Scheme,
    elements: Elements,
    sampling: Sampling,
    softness: f64,
    physics: Physics,
}

/// A finger, if there was one, from the bytes of a record of version 3. The softness that every model had by default becomes the
/// beam's own.
pub(super) fn finger(bytes: &[u8]) -> Option<Option<Finger>> {
    let kept: Option<Finger3> = postcard::from_bytes(bytes).ok()?;
    Some(kept.map(|Finger3 { design, scheme, elements, sampling, softness, physics }| {
        let softness = if softness == 1e-3 { Softness::Local } else { Softness::Fixed(softness) };
        Finger { design, how: Discretisation { scheme, elements, sampling, softness, physics } }
    }))
}

/// Settings from the bytes of a record of version 3, if they are sound.
pub(super) fn settings(bytes: &[u8]) -> Option<Settings> {
    let Settings3 { rate_hz, shape_every, on_fault, support, role, baud, fingers } =
        postcard::from_bytes(bytes).ok()?;
    let fingers = fingers.map(|mount| mount.map(turning));
    Some(Settings { rate_hz, shape_every, on_fault, support, role, baud, fingers })
}

fn turning(mount: Mount3) -> Mount {
    Mount {
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
        drive: Drive::Rotating,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_of_version_3_come_back_as_they_were() {
        let mount = Mount { servo_id: 7, zero: -3.5, side: Side::Right, backlash: 0.004, ..Mount::DEFAULT };
        let expected = Settings {
            rate_hz: 250,
            on_fault: Reaction::Release,
            support: Support::Free { load: [0.5, -1.0], moment: 2.0 },
            role: Role::DEVICE,
            baud: Some(2_000_000),
            fingers: [Some(Mount::DEFAULT), Some(mount), None, None],
            ..Settings::DEFAULT
        };
        let before = |mount: Mount| Mount3 {
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
        };
        let Settings { rate_hz, shape_every, on_fault, support, role, baud, fingers } = expected;
        let fingers = fingers.map(|mount| mount.map(before));
        let written = Settings3 { rate_hz, shape_every, on_fault, support, role, baud, fingers };
        let mut bytes = [0; 512];
        let used = postcard::to_slice(&written, &mut bytes).unwrap();
        assert_eq!(settings(used), Some(expected));
        let length = used.len();
        assert_eq!(settings(&bytes[..length - 1]), None, "cut short");
    }

    #[test]
    fn a_finger_of_version_3_comes_back_with_the_beams_own_softness() {
        let design = crate::store::tests::longest().design;
        let Discretisation { scheme, elements, sampling, physics, .. } = Discretisation::estimator(Physics::Extended);
        let mut bytes = [0; 1024];
        for (softness, expected) in [(1e-3, Softness::Local), (0.0, Softness::Fixed(0.0))] {
            let kept = Some(Finger3 { design: design.clone(), scheme, elements, sampling, softness, physics });
            let used = postcard::to_slice(&kept, &mut bytes).unwrap();
            let how = Discretisation { scheme, elements, sampling, softness: expected, physics };
            assert_eq!(finger(used), Some(Some(Finger { design: design.clone(), how })));
        }
        let none = postcard::to_slice(&None::<Finger3>, &mut bytes).unwrap();
        assert_eq!(finger(none), Some(None));
    }
}
