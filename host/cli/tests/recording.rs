//! Recordings: nothing is lost, others read them, a killed recorder loses at most its last second, and the estimator runs on them
//! once more.

mod said;

#[path = "../../gripper/tests/servo_case/mod.rs"]
mod servo_case;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use fre::case::preset;
use fre::study::model::Precision;
use fre_gripper::estimator::estimator;
use fre_gripper::record::{Counts, Recorded, Recorder, Recording};
use fre_gripper::servo::{Config, Gains, Hub, Running, Servo};
use fre_gripper::source::{Gap, Modelled, Origin, Setup, Told};
use messages::{
    Calibration, Event, Finger, FreeObject, Grasp, GripMargin, Mount, Notice, PROTOCOL_VERSION, Phase, Report,
    Settings, Side, Why,
};
use model_core::discretise::{Discretisation, Physics};
use model_core::estimator::{Estimate, Interval};
use model_core::newton::Hessian;
use model_core::object::ObjectDesign;
use model_core::solution::LoadedRib;
use model_core::status::Status;
use model_core::uncertainty::Uncertainty;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use serde_json::Value;
use servo_case::load;

const OBJECT: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("recording-{name}"))
}

fn fre(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fre")).args(args).output().unwrap()
}

/// What a command that succeeds prints.
fn printed(args: &[&str]) -> String {
    let output = fre(args);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{args:?}: {error}");
    String::from_utf8(output.stdout).unwrap()
}

/// What the MCAP library of PyPI finds, its last line as JSON.
fn read_by_others(how: &str, path: &Path) -> (String, Value) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recording.py");
    let output = Command::new(test_bus::python_with("mcap")).arg(script).arg(how).arg(path).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    let found = serde_json::from_str(text.lines().last().unwrap()).unwrap();
    (text, found)
}

/// What a calibration has left uncertain.
const LEFT: Uncertainty = Uncertainty { youngs_modulus: 0.01, centre: [0.1, 0.2], ..Uncertainty::DEFAULT };

fn setup(how: Discretisation) -> Setup {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let model = Modelled {
        finger: Some(Finger::elastic(design, how)),
        object: Some(OBJECT),
        friction: 0.6,
        uncertainty: Some(LEFT),
    };
    let mut settings = Settings::of(Mount::DEFAULT);
    settings.fingers[1] = Some(Mount { servo_id: 2, side: Side::Right, ..Mount::DEFAULT });
    Setup {
        origin: Origin::Gripper,
        place: "a test".to_owned(),
        board: "bench".to_owned(),
        firmware: "1.2.3".to_owned(),
        protocol: PROTOCOL_VERSION,
        cost_hz: 1_000_000,
        settings,
        models: vec![model.clone(), model],
    }
}

fn report(sequence: u32, finger: u8, time_us: u64) -> Report {
    let estimate = Estimate::blank(Status::Converged);
    let phase = Phase::Moving;
    Report { sequence, finger, phase, time_us, estimate, goal: 0.0, position: 2048, current: 0.0, cost: 0 }
}

/// Any number that is none of the kinds of NaN.
fn any(random: &mut ChaCha8Rng) -> f32 {
    loop {
        let number = f32::from_bits(random.next_u32());
        if !number.is_nan() {
            return number;
        }
    }
}

#[test]
fn nothing_is_lost_and_others_read_it_bit_for_bit() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let phases = [Phase::Moving, Phase::Gripped, Phase::Held(Why::Stall), Phase::Waiting(Why::ServoLost)];
    let statuses = [Status::Converged, Status::NoContact, Status::Stale, Status::MaxIterations, Status::Snapped];
    let setup = setup(Discretisation::estimator(Physics::Extended));
    let design = &setup.models[0].finger.as_ref().unwrap().design;
    let mut model = estimator(Precision::F32, Hessian::default());
    model.configure(design, &Discretisation::estimator(Physics::Extended)).unwrap();
    model.set_object(OBJECT).unwrap();

    let mut told = Vec::new();
    let mut sequence = 100;
    for tick in 0..5000_u64 {
        for finger in 0..2 {
            sequence += 1;
            // Three of them never came.
            if tick == 40 || (tick == 41 && finger == 0) {
                continue;
            }
            let mut report = report(sequence, finger, 2000 * tick);
            let mut number = || any(&mut random);
            report.estimate = Estimate {
                status: statuses[tick as usize % statuses.len()],
                motor_angle: number(),
                force: [number(), number()],
                contact_centre: [number(), number()],
                contact_extent: number(),
                torque: number(),
                distance: number(),
                iterations: tick as u16,
                residual: number(),
                age: sequence,
                force_per_angle: [number(), number()],
                standard_deviation: if tick % 7 == 0 { f32::INFINITY } else { number() },
                sensitivity_age: u16::MAX,
                interval: None,
                loaded_rib: None,
            };
            if tick % 5 == 0 {
                let rib = tick as u8 % 16;
                report.estimate.loaded_rib = Some(LoadedRib { rib, percent: 80 + rib });
            }
            if tick % 3 == 0 {
                let mut ends = || [number(), number()];
                report.estimate.interval = Some(Interval { normal: ends(), magnitude: ends(), torque: ends() });
            }
            (report.goal, report.current) = (number(), number());
            (report.position, report.cost) = (-(tick as i32), u32::MAX);
            report.phase = phases[tick as usize % phases.len()];
            told.push(Told::Report(report));
            if tick % 500 == 0 {
                model.update(tick as f64 * 4e-5);
                told.push(Told::Shape(Box::new(model.shape(&report))));
            }
        }
        if tick % 3 == 0 {
            let (sum, squeeze, balance) = ([any(&mut random), any(&mut random)], any(&mut random), any(&mut random));
            let free = (tick % 2 > 0).then(|| FreeObject {
                status: Status::Folded,
                shift: [any(&mut random), any(&mut random)],
                turn: any(&mut random),
                residual: any(&mut random),
                iterations: 7,
                cost: 1234,
            });
            let margin = (tick % 4 < 2).then(|| GripMargin {
                least: any(&mut random),
                direction: any(&mut random),
                across: any(&mut random),
                couple: any(&mut random),
                slips: (tick % 8 == 0).then_some((tick % 5) as u8),
                carried: (tick % 8 == 1).then(|| any(&mut random)),
                age: (tick % 500) as u16,
            });
            told.push(Told::Grasp(Grasp {
                sequence,
                is_trustworthy: tick % 2 == 0,
                sum,
                squeeze,
                balance,
                free,
                margin,
            }));
        }
    }
    let alert = Event::ServoAlert { finger: 1, hardware_error: 32 };
    let rate = Event::RateReached { hz: 123.456, chosen_hz: 500.0 };
    let phase = Event::PhaseChanged { finger: 0, phase: Phase::Held(Why::Alert) };
    told.extend([alert, rate, phase].map(|event| Told::Event(Notice { time_us: 10_000_001, event })));
    let mut other = setup.clone();
    other.models[1].object = Some(ObjectDesign::HalfPlane { point: [0.0, 1.0 / 3.0], normal: [-1.0, 0.0] });
    told.push(Told::Setup(Box::new(other)));

    let path = file("all.mcap");
    let mut recorder = Recorder::create(&path, Some(setup.clone())).unwrap();
    told.iter().for_each(|told| recorder.take(told).unwrap());
    let counts = recorder.finish().unwrap();
    assert_eq!(counts, Counts { reports: 9997, events: 3, gaps: 1, missing: 3 });
    assert_eq!(counts.to_string(), "9997 reports and 3 events, 3 reports missing in one gap");

    let mut recording = Recording::open(&path).unwrap();
    let read: Vec<(u64, Recorded)> = recording.by_ref().map(Result::unwrap).collect();
    assert!(!recording.is_cut());
    let gaps: Vec<Gap> =
        read.iter().filter_map(|(_, it)| if let Recorded::Gap(gap) = it { Some(*gap) } else { None }).collect();
    assert_eq!(gaps, [Gap { first: 181, missing: 3 }]);
    let back: Vec<&Told> =
        read.iter().filter_map(|(_, it)| if let Recorded::Told(told) = it { Some(told) } else { None }).collect();
    assert_eq!(*back[0], Told::Setup(Box::new(setup)));
    assert_eq!(back.len(), 1 + told.len());
    for (before, after) in told.iter().zip(&back[1..]) {
        assert_eq!(before, *after);
    }

    let (_, found) = read_by_others("whole", &path);
    let count = |topic: &str| found["counts"][topic].as_u64().unwrap_or(0);
    assert_eq!(count("/finger_0/estimate") + count("/finger_1/estimate"), 9997);
    let counts =
        ["/gaps", "/setup", "/event_data", "/events", "/grasp", "/finger_1/object", "/finger_0/scene"].map(count);
    assert_eq!(counts, [1, 2, 3, 4, 1667, 2, 10]);
    assert_eq!(count("/finger_0/shape"), 10);
    let schema = |topic: &str| found["schemas"][topic].as_str().unwrap().to_owned();
    assert_eq!([schema("/events"), schema("/finger_0/scene")], ["foxglove.Log", "foxglove.SceneUpdate"]);
    // Evenly spaced by the gripper's own clock.
    let times: Vec<u64> = serde_json::from_value(found["times"].clone()).unwrap();
    assert_eq!(times[1], times[0]);
    let reports =
        told.iter().filter_map(|told| if let Told::Report(report) = told { Some(report.estimate) } else { None });
    let numbers = reports.flat_map(|estimate| [estimate.force[0], estimate.force[1], estimate.standard_deviation]);
    assert_eq!(found["bits"].as_u64().unwrap(), u64::from(crc(numbers.flat_map(f32::to_le_bytes))));
}

/// A free object is drawn anew where it has come to rest, and where it was set once it is fixed again.
#[test]
fn a_free_object_is_drawn_where_it_is() {
    let setup = setup(Discretisation::estimator(Physics::Extended));
    let path = file("free.mcap");
    let mut recorder = Recorder::create(&path, Some(setup.clone())).unwrap();
    let free = |status, shift, turn| FreeObject { status, shift, turn, residual: 0.0, iterations: 3, cost: 9 };
    let still = free(Status::NoContact, [0.0; 2], 0.0);
    let rests = free(Status::Converged, [1.5, -0.25], 0.0);
    let on_the_way = free(Status::MaxIterations, [9.0, 9.0], 0.0);
    for free in [None, Some(still), Some(rests), Some(on_the_way), Some(rests), Some(still), None] {
        let grasp =
            Grasp { sequence: 1, is_trustworthy: true, sum: [0.0; 2], squeeze: 1.0, balance: 1.0, free, margin: None };
        recorder.take(&Told::Grasp(grasp)).unwrap();
    }
    recorder.finish().unwrap();
    let (_, found) = read_by_others("free", &path);
    assert_eq!(found["counts"]["/grasp"], 7);
    // As set, at rest, and as set again.
    assert_eq!([&found["counts"]["/finger_0/object"], &found["counts"]["/finger_1/object"]], [3, 3]);

    // In each finger's own frame.
    let shift = [1.5, -0.25];
    for (finger, sense) in [(0, 1.0), (1, -1.0)] {
        let [Some(set), Some(now)] = [None, Some(&rests)].map(|free| setup.object(finger, free)) else { panic!() };
        let [ObjectDesign::Circle { centre: set, .. }, ObjectDesign::Circle { centre: now, .. }] = [set, now] else {
            panic!("circles")
        };
        assert!((now[0] - set[0] - sense * shift[0]).abs() < 1e-6 && (now[1] - set[1] - shift[1]).abs() < 1e-6);
    }
}

/// CRC-32 as Python's `zlib`.
fn crc(bytes: impl Iterator<Item = u8>) -> u32 {
    !bytes.fold(!0_u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 })
    })
}

/// A bus with a servo that presses a finger on an object, its port, and the case with both.
fn gripping(test: &str) -> (Running, PathBuf, PathBuf) {
    let mut hub = Hub::new();
    let load = load([41.0, 45.0], 13.0);
    let config =
        Config { start_deg: Some(9.0), load, baud_rate: 1_000_000, gains: Gains::GREATEST, ..Config::default() };
    hub.servo(Servo::new(config).unwrap());
    let (port, case) = (hub.pty().unwrap(), file(&format!("{test}.toml")));
    let object = "[object]\nshape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 45.0]\n";
    std::fs::write(&case, format!("finger = \"preset:ladder-80\"\n{object}[motion]\nmotor_angles_deg = [6.0]\n"))
        .unwrap();
    (hub.spawn().unwrap(), port, case)
}

/// A long measurement does not go on without its file: the command ends as soon as it cannot be written.
#[test]
fn a_full_disk_ends_a_measurement_at_once() {
    let (_bus, port, case) = gripping("full");
    let (whole, seconds) = (file("whole.mcap"), 600);
    let [port, case, whole_] = [&port, &case, &whole].map(|path| path.to_str().unwrap());
    let words = ["monitor", "--bus", port, "--case", case, "--force", "--seconds", &seconds.to_string()];
    for options in [&["--record", "/dev/full"][..], &["--log", "/dev/full", "--record", whole_]] {
        let start = Instant::now();
        let output = fre(&[&words, options].concat());
        assert!(start.elapsed() < Duration::from_secs(seconds / 2), "{options:?}: {:?}", start.elapsed());
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{options:?}: {errors}");
        assert!(errors.contains("/dev/full: ") && errors.contains("No space left on device"), "{options:?}: {errors}");
    }
    // The other file has its end.
    let mut recording = Recording::open(&whole).unwrap();
    assert!(recording.by_ref().all(|recorded| recorded.is_ok()) && !recording.is_cut());
}

#[test]
fn a_killed_recorder_loses_at_most_its_last_second() {
    let (path, (_bus, port, case)) = (file("killed.mcap"), gripping("killed"));
    let [path_, case, port] = [&path, &case, &port].map(|path| path.to_str().unwrap());
    let mut child = Command::new(env!("CARGO_BIN_EXE_fre"))
        .args([
            "monitor",
            "--bus",
            port,
            "--case",
            case,
            "--set",
            "rate_hz=200",
            "--every",
            "1",
            "--force",
            "--record",
            path_,
        ])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let seconds = |line: &str| line.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
    let mut last = 0.0;
    for line in BufReader::new(child.stdout.take().unwrap()).lines() {
        last = seconds(&line.unwrap()).unwrap_or(last);
        if last > 6.0 {
            break;
        }
    }
    // SIGKILL: nothing can be put in order any more.
    child.kill().unwrap();
    child.wait().unwrap();

    let mut recording = Recording::open(&path).unwrap();
    let reports: Vec<Report> = recording
        .by_ref()
        .filter_map(|it| if let (_, Recorded::Told(Told::Report(report))) = it.unwrap() { Some(report) } else { None })
        .collect();
    let end = reports.last().unwrap().time_us as f64 * 1e-6;
    assert!(recording.is_cut(), "it was killed");
    // It writes twice a second; a busy PC may leave it waiting meanwhile.
    assert!(end > last - 3.0, "recorded up to {end} s, shown up to {last} s");
    assert!(reports.windows(2).all(|pair| pair[1].sequence == pair[0].sequence + 1), "whole up to there");

    let (text, found) = read_by_others("cut", &path);
    assert!(text.contains("\"end\""), "{text}");
    assert_eq!(found["counts"]["/finger_0/estimate"], reports.len());
    assert_eq!(found["last"], reports.last().unwrap().sequence);
    let csv = file("killed.csv");
    let out = printed(&["replay", path_, "--force", "--csv", csv.to_str().unwrap()]);
    snapbox::assert_data_eq!(
        said::words(&out.replace(path_, "killed.mcap")),
        snapbox::str![[r#"
killed.mcap (firmware # on this PC, /dev/pts/# at # baud): # reports, # events; # reports missing in # gaps
the end of the file is missing: its recorder was stopped by force, what came before it is whole
"#]]
    );
    assert_eq!(std::fs::read_to_string(&csv).unwrap().lines().count(), 1 + reports.len());
}

/// A finger that closes on its object and opens again, as a gripper of single precision would tell it.
fn closing(path: &Path) -> Vec<Report> {
    let how = Discretisation::estimator(Physics::Extended);
    let mut setup = setup(how);
    setup.models.iter_mut().for_each(|model| model.friction = 0.0);
    let mut model = estimator(Precision::F32, Hessian::default());
    model.configure(&setup.models[0].finger.as_ref().unwrap().design, &how).unwrap();
    model.set_object(OBJECT).unwrap();
    let calibration = Calibration::new(&Mount::DEFAULT.gear());
    model.set_uncertainty(Mount::DEFAULT.uncertainty(Some(LEFT))).unwrap();
    let mut recorder = Recorder::create(path, Some(setup)).unwrap();
    let mut reports = Vec::new();
    for (tick, counts) in (-20..110).chain((-20..110).rev()).enumerate() {
        let mut report = report(tick as u32, 0, 2000 * tick as u64);
        report.position = 2048 + counts;
        report.estimate = model.update(calibration.finger_angle(report.position));
        report.goal = report.estimate.motor_angle;
        recorder.take(&Told::Report(report)).unwrap();
        if tick % 25 == 0 {
            recorder.take(&Told::Shape(Box::new(model.shape(&report)))).unwrap();
        }
        reports.push(report);
    }
    recorder.finish().unwrap();
    reports
}

#[test]
fn the_estimator_runs_on_a_recording_once_more() {
    let path = file("again.mcap");
    let reports = closing(&path);
    let path = path.to_str().unwrap();
    // Means before and now, rms and greatest difference.
    let compared = |options: &[&str]| {
        let out = printed(&[&["replay", path, "--again"], options].concat());
        let line = out.lines().last().unwrap();
        let numbers: Vec<f64> = line.split_whitespace().map(|word| word.parse().unwrap()).collect();
        let [0.0, 260.0, 260.0, _, _, before, now, rms, most, _] = numbers[..] else { panic!("{out}") };
        [before, now, rms, most]
    };
    let [before, now, rms, most] = compared(&["--precision", "f32"]);
    assert!(before > 3.0 && [now, rms, most] == [before, 0.0, 0.0], "the same estimator says the same");
    // Means are over the ticks in contact in both, which the first touch may be in one and not in the other.
    let [alike, now, _, most] = compared(&[]);
    assert!((now - alike).abs() < 2e-3 && most < 0.01, "double precision: {now} N, {most} N");
    let [_, twice, ..] = compared(&["--youngs-modulus-pa", "9.9e7"]);
    assert!((twice / before - 2.0).abs() < 0.02, "twice the modulus, twice the force: {twice} N of {before} N");
    let [_, fine, _, most] = compared(&["--elements", "fine"]);
    assert!(fine != now && most > 1e-4 && most < 0.5, "{fine} N, {most} N");
    let [_, smaller, ..] = compared(&["--set", "finger.0.zero_counts=2060"]);
    assert!(smaller < before - 0.3, "a later zero is a smaller angle: {smaller} N");
    let case = file("again.toml");
    let object = "[object]\nshape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [42.0, 45.0]\n";
    std::fs::write(&case, format!("finger = \"preset:ladder-80\"\n{object}[motion]\nmotor_angles_deg = [6.0]\n"))
        .unwrap();
    let [_, farther, ..] = compared(&["--case", case.to_str().unwrap()]);
    assert!(farther < before - 0.3, "an object a millimetre away: {farther} N");
    // A jaw's case: the recorded finger is turned.
    let jaw = format!("finger = \"preset:ladder-80\"\n{object}[motion]\ndirection = [1, 0]\ndistances_mm = [2]\n");
    std::fs::write(&case, jaw).unwrap();
    let refused = fre(&["replay", path, "--again", "--case", case.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(1) && said.contains("and finger.0.drive is rotating"), "{said}");

    let csv = file("again.csv");
    printed(&["replay", path, "--again", "--precision", "f32", "--force", "--csv", csv.to_str().unwrap()]);
    let text = std::fs::read_to_string(&csv).unwrap();
    assert_eq!(text.lines().count(), 1 + reports.len());
    for (row, report) in text.lines().skip(1).zip(&reports) {
        let words: Vec<&str> = row.split(',').collect();
        assert_eq!(words[4..8], words[8..12], "{row}");
        assert_eq!(words[6].parse::<f32>().unwrap(), report.estimate.force[0]);
        assert_eq!(
            words[12].parse::<f32>().unwrap(),
            report.estimate.standard_deviation,
            "with what was left uncertain"
        );
    }
}

#[test]
fn a_recording_is_shown_as_it_was() {
    let path = file("shown.mcap");
    let reports = closing(&path);
    let path = path.to_str().unwrap();
    // The force's column, in the order of the reports.
    let forces = |out: &str| -> Vec<String> {
        let lines = out.lines().filter(|line| line.ends_with("converged") || line.ends_with("no-contact"));
        lines.map(|line| line.split_whitespace().nth(3).unwrap_or_default().to_owned()).collect()
    };
    let out = printed(&["replay", path, "--at-once", "--every", "1"]);
    let expected: Vec<String> =
        reports.iter().map(|report| format!("{:.3}", report.estimate.force_magnitude())).collect();
    assert_eq!(forces(&out), expected);
    let lines: Vec<&str> = out.lines().collect();
    let words = [&lines[..3], &lines[lines.len() - 1..]].concat().join("\n").replace(path, "shown.mcap");
    snapbox::assert_data_eq!(
        said::words(&words),
        snapbox::str![[r#"
recording shown.mcap of a test
time_s angle_deg goal_deg force_n fx_n fy_n torque_nmm current_ma status
# # # # # # # # no-contact
# reports, # a second; # missing, # frames damaged; the recording is over
"#]]
    );
    // Half a second, ten times as fast; with twice the modulus.
    let options = ["--again", "--show", "--youngs-modulus-pa", "9.9e7", "--speed", "10", "--every", "1"];
    let out = printed(&[&["replay", path][..], &options].concat());
    let stiffer = forces(&out);
    let softer = expected.iter().filter(|force| *force != "0.000").count();
    assert_eq!(stiffer.iter().zip(&expected).filter(|(now, before)| now != before).count(), softer, "{out}");
    let csv = file("shown.csv");
    printed(&["replay", path, "--force", "--csv", csv.to_str().unwrap()]);
    let text = std::fs::read_to_string(csv).unwrap();
    let force = |row: &str| row.split(',').nth(8).unwrap().parse::<f32>().unwrap();
    assert!(text.lines().skip(1).zip(&reports).all(|(row, report)| force(row) == report.estimate.force[0]));
}

#[test]
fn what_is_no_recording_is_told() {
    let mut said = String::new();
    let mut refused = |what: &str, args: &[&str]| {
        let output = fre(&[&["replay"], args].concat());
        let words = String::from_utf8_lossy(&output.stderr).replace(env!("CARGO_TARGET_TMPDIR"), "FOLDER");
        assert_eq!(output.status.code(), Some(1), "{args:?}: {words}");
        said += &format!("{what}\n{words}\n");
    };
    refused("no file", &["nowhere.mcap"]);
    let path = file("bad.mcap");
    let name = path.to_str().unwrap();
    for (what, bytes) in
        [("empty", &b""[..]), ("the beginning of one", b"\x89MCA"), ("a table", b"sequence,time_us\n1,2\n")]
    {
        std::fs::write(&path, bytes).unwrap();
        refused(what, &[name]);
    }
    std::fs::write(&path, b"\x89MCAP0\r\n").unwrap();
    refused("a beginning without more", &[name]);

    let good = file("good.mcap");
    closing(&good);
    let good_name = good.to_str().unwrap();
    refused("no speed", &[good_name, "--speed", "0"]);
    refused("no gear ratio", &[good_name, "--again", "--set", "finger.0.gear_ratio=0"]);
    refused("a negative modulus", &[good_name, "--again", "--youngs-modulus-pa=-1"]);
    refused("a modulus that nothing uses", &[good_name, "--youngs-modulus-pa", "1e6"]);
    snapbox::assert_data_eq!(said, snapbox::file!["words/replay.txt"].raw());
    // Damage anywhere is told or harmless, and never more than an error.
    let whole = std::fs::read(&good).unwrap();
    let mut told = 0;
    for at in (8..whole.len()).step_by(whole.len() / 60) {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x41;
        std::fs::write(&path, damaged).unwrap();
        let output = fre(&["replay", name, "--force", "--csv", file("bad.csv").to_str().unwrap()]);
        let code = output.status.code();
        assert!(matches!(code, Some(0 | 1)), "{at}: {}", String::from_utf8_lossy(&output.stderr));
        told += u32::from(code == Some(1));
    }
    assert!(told > 20, "{told}");
}
