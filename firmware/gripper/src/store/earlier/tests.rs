//! What earlier versions kept comes back.

use core::fmt::Debug;

use model_core::design::{LamellaKind, Ribs};
use model_core::size::Lists;
use serde::Serialize;

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

/// What was kept by these versions is read as what is expected, and as nothing when it is cut short.
fn comes_back<K: Serialize, V: PartialEq + Debug>(
    versions: impl IntoIterator<Item = u8>,
    kept: &K,
    read: impl Fn(u8, &[u8]) -> Option<V>,
    expected: &V,
) {
    let mut bytes = [0; super::super::RECORD];
    let used = postcard::to_slice(kept, &mut bytes).unwrap();
    let Some((_, short)) = used.split_last() else { panic!("nothing was kept") };
    for version in versions {
        assert_eq!(read(version, used).as_ref(), Some(expected), "version {version}");
        assert_eq!(read(version, short), None, "version {version}, cut short");
    }
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
    comes_back([3], &written(expected(), device, before), settings, &expected());
}

#[test]
fn settings_of_versions_5_and_6_come_back_as_they_were() {
    let expected = Settings { untrusted_ms: 70, on_silence: Silence::Hold, silence_ms: 900, ..expected() };
    let Settings { rate_hz, shape_every, on_fault, untrusted_ms, on_silence, silence_ms, support, role, .. } = expected;
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
    comes_back([5, 6], &before, settings, &expected);
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
        comes_back([4], &written(expected, kept, mount), settings, &expected);
    }
}

/// A finger with as much of everything as a microcontroller has room for, but for ribs with a gap, which none of those versions had.
fn longest() -> Finger {
    let mut finger = crate::store::tests::longest(Lists::TARGET);
    finger.design.lamellae.kind = LamellaKind::Rib(Ribs::WELDED);
    finger
}

/// One with as much of everything as the first of those versions had room for.
fn straight() -> Design {
    let mut design = longest().design;
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
    let kept = Some(Finger7 { design: kept(&design, |lamellae| lamellae), how });
    comes_back([6, 7], &kept, finger, &Some(Finger::elastic(design, how)));
}

#[test]
fn settings_of_versions_7_to_9_come_back_without_a_fence() {
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
    comes_back(7..=9, &before, settings, &kept);
}

#[test]
fn settings_of_version_10_come_back_as_they_were() {
    let mut kept = expected();
    kept.fingers[0] = kept.fingers[0].map(|mount| Mount { current_fence: true, ..mount });
    comes_back([10], &kept, settings, &kept);
}

#[test]
fn a_finger_of_versions_8_to_10_and_an_object_of_any_come_back() {
    let Finger { design, how, .. } = longest();
    comes_back(8..=10, &Some(Finger10 { design: design.clone(), how }), finger, &Some(Finger::elastic(design, how)));
    let design = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 30.0 };
    comes_back(3..=8, &Some(design), object, &Some(Object { design, friction: 0.0 }));
    let rough = Some(Object { design, friction: 0.5 });
    comes_back([9], &rough, object, &rough);
}

#[test]
fn a_finger_of_versions_4_and_5_comes_back_with_rigid_lamellae() {
    let (design, how) = (rigid(), Discretisation::estimator(Physics::Extended));
    let kept = Some(Finger7 { design: kept(&design, of_one_thickness), how });
    comes_back([4, 5], &kept, finger, &Some(Finger::elastic(design, how)));
}

#[test]
fn a_finger_of_version_3_comes_back_with_the_beams_own_softness() {
    let design = rigid();
    let Discretisation { scheme, elements, sampling, physics, .. } = Discretisation::estimator(Physics::Extended);
    for (softness, expected) in [(1e-3, Softness::Local), (0.0, Softness::Fixed(0.0))] {
        let kept =
            Some(Finger3 { design: kept(&design, of_one_thickness), scheme, elements, sampling, softness, physics });
        let how = Discretisation { scheme, elements, sampling, softness: expected, physics };
        comes_back([3], &kept, finger, &Some(Finger::elastic(design.clone(), how)));
    }
    comes_back([3], &None::<Finger3>, finger, &None);
}

#[test]
fn an_uncertainty_of_version_11_comes_back_with_the_usual_one_of_terms() {
    let given = Uncertainty { zero_angle: 0.01, correlations: [0.1; 10], ..Uncertainty::DEFAULT };
    let Uncertainty { quantisation, backlash, zero_angle, youngs_modulus, centre, radius, correlations, .. } = given;
    let before = Uncertainty11 { quantisation, backlash, zero_angle, youngs_modulus, centre, radius, correlations };
    comes_back([11], &Some(before), uncertainty, &Some(given));
}

#[test]
fn a_finger_of_version_11_comes_back_as_it_was() {
    let kept = Some(longest());
    comes_back([11], &kept, finger, &kept);
}
