//! Recordings: any bytes are read to an end, past what is damaged, or give an error in words that can be shown.

use std::collections::{BTreeMap, HashMap};
use std::io::Cursor;
use std::path::Path;

use fre::case::preset;
use fre_gripper::record::{Again, Changes, Recorded, Recorder, Recording};
use fre_gripper::source::{Modelled, Origin, Setup, Told};
use mcap::records::MessageHeader;
use mcap::{Compression, MessageStream, WriteOptions};
use messages::{
    Contact, Event, Finger, FreeObject, Grasp, GripMargin, Mount, Notice, PROTOCOL_VERSION, Phase, Report, Settings,
    Shape, Why,
};
use model_core::discretise::{Discretisation, Physics};
use model_core::estimator::{Estimate, Interval};
use model_core::object::ObjectDesign;
use model_core::solution::LoadedRib;
use model_core::status::Status;

use crate::{Target, is_shown};

pub(crate) const TARGET: Target = Target { name: "recording", run, seeds, words };

const NAME: &str = "fuzz.mcap";
/// Reports of an input that the estimator runs on again: each takes its time.
const AGAIN: usize = 4;

fn run(bytes: &[u8]) {
    let mut recording = match Recording::of(Cursor::new(bytes), Path::new(NAME)) {
        Ok(recording) => recording,
        Err(error) => return refused(&error.to_string()),
    };
    let mut end = 0;
    let (mut again, mut left) = (Again::new(Changes::default()), AGAIN);
    while let Some(recorded) = recording.next() {
        match recorded.map(|(_, recorded)| recorded) {
            Ok(Recorded::Damage(damage)) => {
                assert!(end <= damage.from && damage.from < damage.to && damage.to <= bytes.len() as u64, "{damage:?}");
                assert!(is_shown(&damage.to_string()));
                end = damage.to;
            }
            Ok(Recorded::Gap(gap)) => assert!(is_shown(&gap.to_string())),
            Ok(Recorded::Told(Told::Event(notice))) => assert!(is_shown(&notice.event.to_string())),
            Ok(Recorded::Told(Told::Setup(setup))) => {
                // A set-up that the estimator refuses leaves it without, or with the one before.
                let _ = again.set_up(&setup);
            }
            Ok(Recorded::Told(Told::Report(report))) if left > 0 => {
                left -= 1;
                let now = again.report(&report);
                assert_eq!((now.sequence, now.position), (report.sequence, report.position));
            }
            Ok(Recorded::Told(_)) => {}
            Err(error) => {
                refused(&error.to_string());
                assert!(recording.next().is_none(), "it goes on after an error");
            }
        }
    }
    let _ = recording.is_cut();
}

fn refused(message: &str) {
    assert!(message.starts_with(NAME) && is_shown(message), "{message:?}");
}

/// A recording with a message of every kind: as the recorder writes it; in plain text without checksums, whole, without chunks, and without
/// its end.
fn seeds() -> Vec<Vec<u8>> {
    let messages = recorded();
    let usual = || WriteOptions::new().compression(Some(Compression::Zstd)).compression_threads(0);
    let plain = || WriteOptions::new().compression(None).calculate_chunk_crcs(false).calculate_data_section_crc(false);
    let plain = || plain().calculate_summary_section_crc(false).emit_message_indexes(false);
    let whole = written(plain(), &messages);
    let cut = whole[..whole.len() / 2].to_vec();
    vec![written(usual(), &messages), whole, written(plain().use_chunks(false), &messages), cut]
}

/// Topics and messages of a recording.
fn recorded() -> Vec<(String, Vec<u8>)> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(NAME);
    let setup = setup();
    let mut recorder = Recorder::create(&path, Some(setup.clone())).expect("a recording");
    for told in told() {
        recorder.take(&told).expect("a message");
    }
    recorder.take(&Told::Setup(Box::new(setup))).expect("a message");
    recorder.finish().expect("a recording");
    let bytes = std::fs::read(&path).expect("a recording");
    let messages = MessageStream::new(&bytes).expect("a recording").map(|message| message.expect("a message"));
    // The others are pictures for other programs, which the reader passes.
    let is_read = |topic: &str| !["/events", "/scene", "/object"].iter().any(|end| topic.ends_with(end));
    let messages = messages.filter(|message| is_read(&message.channel.topic));
    messages.map(|message| (message.channel.topic.clone(), message.data.to_vec())).collect()
}

/// A file of these messages, the same every time: the recorder writes the time of day.
fn written(options: WriteOptions, messages: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut writer = options.library("fuzz").create(&mut file).expect("a file");
    let mut channels = HashMap::new();
    for (number, (topic, data)) in (0..).zip(messages) {
        let channel_id = *channels
            .entry(topic.as_str())
            .or_insert_with(|| writer.add_channel(0, topic, "json", &BTreeMap::new()).expect("a channel"));
        let time = 1_000_000 * u64::from(number);
        let header = MessageHeader { channel_id, sequence: number, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, data).expect("a message");
        // Several chunks.
        if number % 4 == 3 {
            writer.flush().expect("a chunk");
        }
    }
    writer.finish().expect("a file");
    drop(writer);
    file.into_inner()
}

fn setup() -> Setup {
    let design = preset("ladder-80").expect("a preset").expect("a sound one").design;
    let finger = Finger::elastic(design, Discretisation::estimator(Physics::Extended)).relaxing(&[[0.2, 5.0]]);
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    Setup {
        origin: Origin::Gripper,
        place: "a test".to_owned(),
        board: "bench".to_owned(),
        firmware: "1.2.3".to_owned(),
        protocol: PROTOCOL_VERSION,
        cost_hz: 1_000_000,
        settings: Settings::of(Mount::DEFAULT),
        models: vec![Modelled { finger: Some(finger), object: Some(object), friction: 0.6, uncertainty: None }],
    }
}

/// A message of every kind, and a gap.
fn told() -> Vec<Told> {
    let interval = Interval { normal: [1.0, 2.0], magnitude: [1.5, f32::INFINITY], torque: [-3.0, 4.0] };
    let estimate = Estimate {
        interval: Some(interval),
        loaded_rib: Some(LoadedRib { rib: 2, percent: 90 }),
        ..Estimate::blank(Status::Converged)
    };
    let report = |sequence: u32| {
        let (phase, time_us) = (Phase::Held(Why::Stall), 2000 * u64::from(sequence));
        Told::Report(Report {
            sequence,
            finger: 0,
            phase,
            time_us,
            estimate,
            goal: 0.1,
            position: 2113,
            current: 5.0,
            cost: 9,
        })
    };
    let free =
        FreeObject { status: Status::Folded, shift: [1.0, 2.0], turn: 0.1, residual: 1e-3, iterations: 7, cost: 1234 };
    let margin =
        GripMargin { least: 1.0, direction: 0.5, across: 2.0, couple: 3.0, slips: Some(1), carried: Some(4.0), age: 5 };
    let points = |count: u8| (0..count).map(|point| [f32::from(point), 10.0 * f32::from(point)]);
    let shape = Shape {
        sequence: 3,
        finger: 0,
        status: Status::Tracking,
        motor_angle: 0.1,
        shift: [0.0; 2],
        front: points(9).collect(),
        back: points(9).collect(),
        lamella_front: points(7).collect(),
        lamella_back: points(7).collect(),
        contacts: [Contact { position: [2.0, 45.0], force: [4.0, 1.0] }].into_iter().collect(),
    };
    vec![
        report(1),
        Told::Event(Notice { time_us: 2100, event: Event::ServoAlert { finger: 0, hardware_error: 32 } }),
        report(2),
        report(3),
        Told::Shape(Box::new(shape)),
        Told::Grasp(Grasp {
            sequence: 3,
            is_trustworthy: true,
            sum: [1.0, 2.0],
            squeeze: 3.0,
            balance: 0.5,
            free: Some(free),
            margin: Some(margin),
        }),
        Told::Event(Notice {
            time_us: 6100,
            event: Event::PhaseChanged { finger: 0, phase: Phase::Waiting(Why::ServoLost) },
        }),
        report(8),
        report(9),
    ]
}

/// What a message in plain text may be changed into.
fn words() -> Vec<String> {
    let words = [
        "\"NaN\"",
        "\"-inf\"",
        "null",
        "-1",
        "255",
        "256",
        "65536",
        "4294967295",
        "1e39",
        "1e-46",
        "[]",
        "{}",
        "\"\\u001b\"",
        "\"converged\"",
        "\"held: the motor does not reach its goal\"",
        "/finger_3/estimate",
        "/gaps",
    ];
    words.map(str::to_owned).into()
}
