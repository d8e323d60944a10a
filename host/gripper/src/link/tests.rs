//! The client against a peer that does what it is told.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::thread;
use std::time::Duration;

use messages::frame::{Decoder, FRAME, MESSAGE, encode, message};
use messages::{
    Counters, EstimateTopic, Finger, GetCounters, GetObject, GetVersion, Object, PROTOCOL_VERSION, Phase, Report,
    SetObject, Version,
};
use model_core::design::{Profile, ladder_80};
use model_core::discretise::{Discretisation, Physics};
use model_core::estimator::Estimate;
use model_core::object::{Corners, ObjectDesign};
use model_core::size::Lists;
use model_core::status::Status;
use postcard_rpc::header::{VarHeader, VarKey, VarKeyKind, VarSeq};
use postcard_rpc::standard_icd::{ERROR_KEY, WireError};
use postcard_rpc::{Endpoint, Key, Topic};
use serde::Serialize;

use super::{Link, LinkError, Told};
use crate::source::Source as _;

/// How long an answer that comes is waited for: a PC may be busy.
const PATIENT: Duration = Duration::from_secs(30);
/// How long one that does not.
const HASTY: Duration = Duration::from_secs(2);
const OBJECT: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };

/// Frame of a message; keys are shortened as a gripper does.
pub(super) fn frame(key: Key, seq_no: VarSeq, body: &impl Serialize) -> Vec<u8> {
    let mut key = VarKey::Key8(key);
    key.shrink_to(VarKeyKind::Key2);
    let (mut scratch, mut line) = ([0; MESSAGE], [0; FRAME]);
    let message = message(&VarHeader { key, seq_no }, body, &mut scratch).unwrap();
    encode(message, &mut line).unwrap().to_vec()
}

pub(super) fn report(sequence: u32) -> Vec<u8> {
    let estimate = Estimate {
        status: Status::Converged,
        motor_angle: 0.1,
        force: [3.0, -4.0],
        contact_centre: [1.0, 45.0],
        contact_extent: 2.0,
        torque: 200.0,
        distance: 0.0,
        iterations: 2,
        residual: 1e-5,
        age: 0,
        force_per_angle: [40.0, -50.0],
        standard_deviation: 0.1,
        sensitivity_age: 3,
        interval: None,
        loaded_rib: None,
    };
    let phase = Phase::Moving;
    let report =
        Report { sequence, finger: 0, phase, time_us: 7, estimate, goal: 0.1, position: 2113, current: 5.0, cost: 9 };
    frame(EstimateTopic::TOPIC_KEY, VarSeq::Seq2(sequence as u16), &report)
}

/// A link that waits this long for answers; its peer hears each request and writes what `answer` makes of its sequence number.
pub(super) fn with_peer(patience: Duration, answer: impl Fn(VarSeq) -> Vec<u8> + Send + 'static) -> Link {
    let (ours, mut theirs) = UnixStream::pair().unwrap();
    thread::spawn(move || {
        let mut decoder: Decoder = Decoder::new();
        let mut chunk = [0; 256];
        while let Ok(count @ 1..) = theirs.read(&mut chunk) {
            let mut bytes = &chunk[..count];
            while let Some(event) = decoder.feed(&mut bytes) {
                let (header, _) = VarHeader::take_from_slice(event.unwrap()).unwrap();
                let _ = theirs.write_all(&answer(header.seq_no));
            }
        }
    });
    let mut link = Link::over_stream(ours).unwrap();
    link.set_patience(patience);
    link
}

#[test]
fn answers_find_their_questions_among_noise_and_reports() {
    let counters = Counters { ticks: 77, ..Counters::default() };
    let link = with_peer(PATIENT, move |number| {
        let mut damaged = report(1);
        damaged[20] ^= 0x10;
        [report(0), damaged, vec![0x33; 40], frame(GetCounters::RESP_KEY, number, &counters), report(5)].concat()
    });
    let told = link.listen();
    assert_eq!(link.counters().unwrap().ticks, 77);
    let heard = || match told.recv_timeout(PATIENT).unwrap() {
        Told::Report(report) => (report.sequence, report.estimate.force_magnitude()),
        other => panic!("{other:?}"),
    };
    assert_eq!((heard(), heard()), ((0, 5.0), (5, 5.0)));
    let statistics = link.statistics();
    assert_eq!((statistics.damaged, statistics.missing_reports, statistics.unexpected), (2, 4, 0));
}

/// The gripper hears a sign of life as a request; nobody waits for its answer, which spoils no other one.
#[test]
fn a_sign_of_life_is_a_request_without_a_wait() {
    let asked = Arc::new(AtomicU32::new(0));
    let count = asked.clone();
    let link = with_peer(PATIENT, move |number| {
        let asked: u32 = number.into();
        if asked == 0 {
            count.fetch_add(1, Ordering::Relaxed);
            return frame(GetObject::RESP_KEY, number, &None::<Object>);
        }
        frame(GetCounters::RESP_KEY, number, &Counters { ticks: asked, ..Counters::default() })
    });
    for ticks in 1..4 {
        link.sign();
        link.sign();
        assert_eq!(link.counters().unwrap().ticks, ticks);
    }
    assert_eq!((asked.load(Ordering::Relaxed), link.statistics().unexpected), (6, 0));
    // Where nobody takes it, it is given all the same.
    let (ours, theirs) = UnixStream::pair().unwrap();
    drop(theirs);
    Link::over_stream(ours).unwrap().sign();
}

#[test]
fn every_way_to_fail_is_told_apart() {
    let silent = with_peer(HASTY, |_| Vec::new());
    assert!(matches!(silent.version(), Err(LinkError::Timeout { path: "version", .. })));

    let known = |link: Link| {
        link.lists.set(Lists::TARGET).unwrap();
        link
    };
    let strange = known(with_peer(PATIENT, |number| frame(ERROR_KEY, number, &WireError::UnknownKey)));
    let error = strange.set_object(0, OBJECT).unwrap_err();
    assert!(matches!(error, LinkError::Wire { error: WireError::UnknownKey, .. }), "{error}");

    let confused = known(with_peer(PATIENT, |number| frame(SetObject::RESP_KEY, number, &[9_u8; 3])));
    assert!(matches!(confused.set_object(0, OBJECT), Err(LinkError::Answer { path: "object/set" })));

    // An answer to another question does not count.
    let other = known(with_peer(HASTY, |number| {
        let number: u32 = number.into();
        frame(SetObject::RESP_KEY, VarSeq::Seq4(number + 1), &messages::Outcome::Ok(()))
    }));
    assert!(matches!(other.set_object(0, OBJECT), Err(LinkError::Timeout { .. })));
    assert_eq!(other.statistics().unexpected, 1);
}

/// Of a gripper that answers every request with how long its lists are.
fn with_lists(lists: Lists) -> Link {
    let version = Version {
        protocol: PROTOCOL_VERSION,
        firmware: "1".try_into().unwrap(),
        fingers: 1,
        board: "peer".try_into().unwrap(),
        cost_hz: 1,
        lists,
    };
    with_peer(PATIENT, move |number| frame(GetVersion::RESP_KEY, number, &version))
}

/// The gripper says how much room it has; what fits is sent.
#[test]
fn what_the_gripper_has_no_room_for_is_not_sent() {
    let link = with_lists(Lists::TARGET);
    let corners: Vec<[f64; 2]> = (0..9)
        .map(|k| f64::from(k) * 0.6)
        .map(|angle| [60.0 + 20.0 * angle.cos(), 45.0 + 20.0 * angle.sin()])
        .collect();
    let object = ObjectDesign::Polygon { corners: Corners::new(&corners).unwrap(), rounding: 2.0 };
    object.validate().unwrap();
    let error = link.set_object(0, object).unwrap_err();
    assert_eq!(error.to_string(), "corners_mm has 9 entries; the microcontroller has room for 8");

    let mut design = ladder_80();
    design.front.thickness =
        Profile { knots: (0..9).map(|knot| [10.0 * f64::from(knot), 2.0 - 0.05 * f64::from(knot)]).collect() };
    let finger = Finger::elastic(design, Discretisation::estimator(Physics::Extended));
    let error = link.set_finger(0, &finger).unwrap_err();
    assert_eq!(error.to_string(), "front.thickness_mm has 9 entries; the microcontroller has room for 8");
    let error = with_lists(Lists::RIBS).set_finger(0, &finger).unwrap_err();
    assert!(matches!(error, LinkError::Answer { path: "finger/set" }), "it was sent: {error}");
}

#[test]
fn the_end_of_the_link_ends_every_wait() {
    let (ours, theirs) = UnixStream::pair().unwrap();
    let link = Link::over_stream(ours).unwrap();
    let told = link.listen();
    let peer = thread::spawn(move || {
        thread::sleep(Duration::from_millis(100));
        drop(theirs);
    });
    assert!(matches!(link.counters(), Err(LinkError::Closed)));
    assert!(matches!(told.recv_timeout(PATIENT), Err(RecvTimeoutError::Disconnected)));
    assert!(link.is_closed() && matches!(link.counters(), Err(LinkError::Closed | LinkError::Send(_))));
    assert!(link.listen().recv().is_err());
    peer.join().unwrap();
}
