//! The largest of every message fits a frame, and comes back as it was.

use heapless::Vec;
use messages::{CONTACTS, Contact, Finger, LAMELLAE, Mount, POINTS, Phase, Report, Role, Settings, Shape, Why, frame};
use model_core::design::{
    Attachments, Beam, Design, Hinge, HingeFrom, HingeKind, LamellaKind, Lamellae, Material, MaterialLaw, PlaneStrain,
    Profile, RibEnds, Ribs,
};
use model_core::discretise::{Discretisation, Physics};
use model_core::drive::{Drive, Knots, MAX_DRIVE_KNOTS, Travel};
use model_core::equilibrium::PRONY_TERMS;
use model_core::estimator::{Estimate, Interval};
use model_core::size::Lists;
use model_core::solution::LoadedRib;
use model_core::status::Status;
use postcard_rpc::header::{VarHeader, VarKey, VarSeq};
use postcard_rpc::{Endpoint, Key};
use serde::{Serialize, de::DeserializeOwned};

fn full<X: Clone, const N: usize>(value: X) -> Vec<X, N> {
    core::iter::repeat_n(value, N).collect()
}

/// A list of so many entries.
fn filled<X: Clone, const N: usize>(value: X, entries: u8) -> Vec<X, N> {
    core::iter::repeat_n(value, entries.into()).collect()
}

/// Sends a message through a frame; returns its length and what arrived.
fn through<T: Serialize + DeserializeOwned>(body: &T) -> (usize, T) {
    let key = VarKey::Key8(messages::GetFinger::RESP_KEY);
    let header = VarHeader { key, seq_no: VarSeq::Seq4(u32::MAX) };
    let (mut scratch, mut line) = ([0; frame::MESSAGE], [0; frame::FRAME]);
    let message = frame::message(&header, body, &mut scratch).unwrap();
    let mut bytes = frame::encode(message, &mut line).unwrap();
    let length = bytes.len();
    let mut decoder: frame::Decoder = frame::Decoder::new();
    let message = decoder.feed(&mut bytes).unwrap().unwrap();
    let (heard, body) = VarHeader::take_from_slice(message).unwrap();
    assert_eq!(heard, header);
    (length, postcard_rpc::postcard::from_bytes(body).unwrap())
}

/// A finger with as much of everything as there is room for in such lists.
fn largest(lists: Lists) -> Finger {
    let profile = || Profile { knots: filled([f64::MIN, f64::MAX], lists.knots) };
    let beam = || Beam {
        base: [1.5; 2],
        tip: [-2.5; 2],
        sagitta: 0.1,
        via: filled([1.5, -2.5], lists.points),
        thickness: profile(),
        stiffness_factor: 1.1,
        bending_factor: 1.2,
        stretch_factor: 0.9,
        clamp: 3.5,
    };
    let design = Design {
        width: profile(),
        plane_strain: PlaneStrain::Auto,
        material: Material { youngs_modulus: 49.5, poissons_ratio: 0.48, law: MaterialLaw::default() },
        front: beam(),
        back: beam(),
        lamellae: Lamellae {
            attachments: Attachments::Arcs { front: filled(0.1, lists.lamellae), back: filled(0.2, lists.lamellae) },
            thickness: filled([1.2, 1.1], lists.thicknesses),
            kind: LamellaKind::Rib(Ribs { ends: RibEnds::Gap(0.4), ..Ribs::WELDED }),
        },
        hinge: Hinge {
            kind: HingeKind::Welded,
            length: filled(2.5, lists.lamellae),
            thickness: 0.8,
            from: HingeFrom::Face,
        },
        rigid_above: Some(70.0),
        motor_axis: [-14.0, -20.0],
    };
    assert_eq!(design.fits(lists), Ok(()));
    Finger::elastic(design, Discretisation::estimator(Physics::Paper)).relaxing(&[[0.2, 1e5]; PRONY_TERMS])
}

#[test]
fn the_largest_finger_fits() {
    for lists in [Lists::TARGET, Lists::RIBS, Lists::HOSTED] {
        let finger = Some(largest(lists));
        let (message, back) = through(&finger);
        assert_eq!(back, finger);
        let bare = postcard_rpc::postcard::to_vec::<_, { frame::MESSAGE }>(&finger).unwrap().len();
        let most = Finger::bytes(lists);
        assert!((most - 64..=most).contains(&bare), "{bare} bytes with {lists:?}, {most} at most");
        assert!(message <= frame::bytes(lists), "{message} bytes with {lists:?}");
    }
}

#[test]
fn the_largest_shape_fits() {
    let contact = Contact { position: [1.0, 2.0], force: [-3.0, 0.5] };
    let shape = Shape {
        sequence: u32::MAX,
        finger: 3,
        status: Status::Stale,
        motor_angle: 0.2,
        shift: [1.5, -2.5],
        front: full::<_, POINTS>([1.0; 2]),
        back: full::<_, POINTS>([2.0; 2]),
        lamella_front: full::<_, LAMELLAE>([3.0; 2]),
        lamella_back: full::<_, LAMELLAE>([4.0; 2]),
        contacts: full::<_, CONTACTS>(contact),
    };
    assert_eq!(through(&shape).1, shape);
}

#[test]
fn a_report_is_small() {
    let estimate = Estimate {
        status: Status::Tracking,
        motor_angle: 0.2,
        force: [12.5, -3.25],
        contact_centre: [1.0, 60.0],
        contact_extent: 4.0,
        torque: 900.0,
        distance: -0.001,
        iterations: 65_535,
        residual: 1e-4,
        age: u32::MAX,
        force_per_angle: [60.0, -20.0],
        standard_deviation: 0.25,
        sensitivity_age: u16::MAX,
        interval: None,
        loaded_rib: None,
    };
    let report = Report {
        sequence: u32::MAX,
        finger: 3,
        phase: Phase::Waiting(Why::Angle),
        time_us: u64::MAX,
        estimate,
        goal: 0.3,
        position: i32::MIN,
        current: -12.0,
        cost: u32::MAX,
    };
    let (length, back) = through(&report);
    assert_eq!(back, report);
    // 500 of them a second, every count at its greatest, leave two fifths of a 1-Mbaud line.
    assert!(length <= 120, "{length} bytes");
    // With friction a quarter of it.
    let interval = Some(Interval { normal: [11.0, 12.0], magnitude: [12.0, 13.0], torque: [850.0, 910.0] });
    let loaded_rib = Some(LoadedRib { rib: 63, percent: 200 });
    let rough = Report { estimate: Estimate { interval, loaded_rib, ..estimate }, ..report };
    let (length, back) = through(&rough);
    assert_eq!(back, rough);
    assert!(length <= 150, "{length} bytes");
}

#[test]
fn settings_of_four_fingers_are_small() {
    let knots = Knots::new(&[[0.5, -3.0]; MAX_DRIVE_KNOTS]).expect("as many as there is room for");
    let table = Drive::Translating { direction: [0.8, -0.6], travel: Travel::Table(knots) };
    for (drive, most) in [(Drive::Rotating, 260), (table, 512)] {
        let fingers = [Some(Mount { zero: -1.5, drive, ..Mount::DEFAULT }); 4];
        let settings = Settings { fingers, role: Role::DEVICE, baud: Some(4_000_000), ..Settings::DEFAULT };
        let (length, back) = through(&settings);
        assert_eq!(back, settings);
        assert!(length <= most, "{length} bytes");
    }
}

/// Requests, answers and topics are told apart by four bytes.
#[test]
fn keys_do_not_collide() {
    let endpoints = messages::ENDPOINTS.endpoints;
    let questions: std::vec::Vec<Key> = endpoints.iter().map(|(_, question, _)| *question).collect();
    let told = endpoints.iter().map(|(_, _, answer)| *answer);
    let told: std::vec::Vec<Key> = told.chain(messages::TOPICS_OUT.topics.iter().map(|(_, key)| *key)).collect();
    assert!(postcard_rpc::server::min_key_needed(&[&questions]) <= 4);
    assert!(postcard_rpc::server::min_key_needed(&[&told]) <= 4);
}
