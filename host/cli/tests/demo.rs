//! `fre demo` without QEMU: its refusals, how it treats a QEMU that fails, and what its table and report make of a run.
//! (With QEMU: `cargo xtask demo`.)

mod said;

mod program;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use fre::case::preset;
use fre::files::Files;
use fre_gripper::demo::{FILES, Followed, Pace, REFERENCES, Reference, Sample, Seen, Summary, Way, write_report};
use fre_gripper::source::Statistics;
use messages::{Counters, Phase, Report, Version};
use model_core::discretise::{Discretisation, Physics, Scheme};
use model_core::estimator::Estimator;
use model_core::object::ObjectDesign;
use model_core::size::Lists;
use model_core::size::Reduced;
use model_core::status::Status;

/// A folder of a test's own, empty.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("demo-{name}"));
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

/// `fre demo` with a program of this text as its QEMU, or with none.
fn demo(name: &str, qemu: Option<&str>, arguments: &[&str]) -> Output {
    command(name, qemu, arguments).output().unwrap()
}

fn command(name: &str, qemu: Option<&str>, arguments: &[&str]) -> Command {
    let folder = folder(name);
    if let Some(text) = qemu {
        program::write(&folder.join("qemu-system-arm"), text);
    }
    let firmware = folder.join("firmware");
    fs::write(&firmware, "no firmware").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
    command.env("PATH", &folder).arg("demo").arg("--firmware").arg(firmware);
    command.arg("--report").arg(folder.join("report")).args(arguments);
    command
}

/// Exit status and words on standard error.
fn failed(output: &Output) -> (i32, String) {
    (output.status.code().unwrap(), String::from_utf8(output.stderr.clone()).unwrap())
}

#[test]
fn what_is_not_there_is_named() {
    let (code, words) = failed(&demo("no-qemu", None, &[]));
    assert_eq!(code, 1);
    snapbox::assert_data_eq!(
        words,
        snapbox::str![[r#"
fre: qemu-system-arm cannot be started (No such file or directory (os error 2)); `cargo xtask setup` installs it

"#]]
    );

    let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
    command.args(["demo", "--firmware", "no/such/file", "--report"]).arg(folder("no-firmware").join("report"));
    let (code, words) = failed(&command.output().unwrap());
    assert_eq!(code, 1);
    snapbox::assert_data_eq!(
        words,
        snapbox::str![[r#"
fre: no/such/file is not a file; `cargo xtask firmware mps2` builds it

"#]]
    );
}

#[test]
fn a_length_out_of_range_is_refused() {
    let said = ["3.9", "601", "NaN"].map(|seconds| {
        let (code, words) = failed(&demo("seconds", None, &["--seconds", seconds]));
        assert_eq!(code, 1);
        words
    });
    snapbox::assert_data_eq!(
        said.concat(),
        snapbox::str![[r#"
fre: --seconds is 3.9; allowed is 4 to 600
fre: --seconds is 601; allowed is 4 to 600
fre: --seconds is NaN; allowed is 4 to 600

"#]]
    );
}

#[test]
fn a_qemu_that_ends_is_quoted() {
    let begin = Instant::now();
    let (code, words) = failed(&demo("dies", Some("#!/bin/sh\necho 'rom: no room' >&2\nexit 3\n"), &[]));
    assert_eq!(code, 1);
    snapbox::assert_data_eq!(
        words,
        snapbox::str![[r#"
fre: QEMU has ended by itself (exit status: 3); it said:
rom: no room

"#]]
    );
    assert!(begin.elapsed() < Duration::from_secs(15));
}

/// Ended while it waits for QEMU, with a signal: exit status (none if killed) and words; QEMU must be gone with it.
fn ended(name: &str, signal: &str) -> (Option<i32>, String) {
    let script = "#!/bin/sh\necho $$ > \"${0%/*}/pid\"\nexec /bin/sleep 100\n";
    let mut fre = command(name, Some(script), &["--seconds", "4"]);
    // A socket's path is short, a checkout's may be long.
    let sockets = std::env::temp_dir().join(format!("fre-{}-{name}", std::process::id()));
    fs::create_dir_all(&sockets).unwrap();
    let mut fre = fre.env("TMPDIR", &sockets).stderr(std::process::Stdio::piped()).spawn().unwrap();
    let pid = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("demo-{name}/pid"));
    let end = Instant::now() + Duration::from_secs(30);
    let wait = |what: &str| {
        assert!(Instant::now() < end, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    };
    let number = loop {
        match fs::read_to_string(&pid) {
            Ok(text) if text.ends_with('\n') => break text.trim().to_owned(),
            _ => wait("QEMU was not started"),
        }
    };
    // A process that nobody has asked for its end yet is a zombie, and gone.
    let is_there = || {
        let stat = fs::read_to_string(Path::new("/proc").join(&number).join("stat")).unwrap_or_default();
        stat.rsplit(')').next().is_some_and(|rest| !rest.trim().is_empty() && !rest.trim().starts_with('Z'))
    };
    assert!(is_there());
    // What ends QEMU after a kill is started a moment after QEMU.
    std::thread::sleep(Duration::from_millis(300));
    assert!(Command::new("/bin/kill").args([signal, &fre.id().to_string()]).status().unwrap().success());
    while fre.try_wait().unwrap().is_none() {
        wait("it does not end");
    }
    while is_there() {
        wait("QEMU is still there");
    }
    while fs::read_dir(&sockets).unwrap().next().is_some() {
        wait("the sockets' folder is still there");
    }
    fs::remove_dir(&sockets).unwrap();
    let output = fre.wait_with_output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn nothing_is_left_running() {
    for signal in ["-TERM", "-INT", "-HUP"] {
        let (code, words) = ended("stopped", signal);
        assert_eq!(code, Some(1), "{signal}: {words}");
        snapbox::assert_data_eq!(
            words,
            snapbox::str![[r#"
fre: stopped before the first estimate

"#]]
        );
    }
    assert_eq!(ended("killed", "-KILL").0, None);
}

const OBJECT: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
const COUNT: f64 = std::f64::consts::TAU / 4096.0;

/// A run as it would be on the target: three ticks at each of the positions, closing and opening.
fn seen(physics: Physics) -> Seen {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let mut estimator: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
    estimator.configure(&design, &Discretisation::estimator(physics)).unwrap();
    estimator.set_object(OBJECT).unwrap();
    let begin = |scheme| {
        let how = Discretisation::full(scheme, physics);
        Reference::spawn(&how, &design, OBJECT, -4.0 * COUNT).unwrap()
    };
    let mut references = [begin(Scheme::Trapezoid), begin(Scheme::Paper)];
    let mut samples = Vec::new();
    let mut shape = None;
    let positions = (-4..=125).chain((-4..125).rev()).flat_map(|count| [count; 3]);
    for (index, count) in positions.enumerate() {
        let angle = f64::from(count) * COUNT;
        let estimate = estimator.update(angle);
        let report = Report {
            sequence: index as u32,
            finger: 0,
            phase: Phase::Moving,
            time_us: 2000 * index as u64,
            estimate,
            goal: angle as f32,
            position: 2048 + count,
            current: 0.0,
            cost: 10_000,
        };
        samples.push(Sample {
            report,
            time_s: report.time_us as f64 * 1e-6,
            angle_deg: angle.to_degrees(),
            way: if index < 390 { Way::Closing } else { Way::Opening },
            cycle: 1,
            references: [None; 2],
        });
        references.iter_mut().for_each(|reference| reference.ask(index, report.position, angle));
        if count == 125 {
            shape = Some(shape_of(&estimator, report.sequence));
        }
    }
    let mut which = 0;
    let followed: [Followed; 2] = references.map(|reference| {
        assert_eq!(reference.left_out, 0);
        let (followed, whole) = reference.finish(Duration::from_secs(120), |answer| {
            samples[answer.index].references[which] = answer.force;
        });
        assert!(whole);
        which += 1;
        followed
    });
    let counters = Counters { chosen_hz: 500.0, ..Counters::default() };
    Seen {
        design,
        physics,
        version: Version {
            protocol: 2,
            fingers: 1,
            firmware: "0.0.0".parse().unwrap(),
            board: "test".parse().unwrap(),
            cost_hz: 25_000_000,
            lists: Lists::RIBS,
        },
        pace: Pace::Counted { shift: 2 },
        samples,
        shape,
        shapes: 1,
        wall_s: 2.0,
        cycles: 1,
        counters: [counters; 2],
        link: [Statistics::default(); 2],
        lost_on_bus: 0,
        followed,
        left_out: [0; 2],
    }
}

/// The shape as the gripper tells it.
fn shape_of(estimator: &Estimator<f32, Reduced>, sequence: u32) -> messages::Shape {
    let follower = estimator.follower();
    let contact = |contact: model_core::contact::Contact<f32>| messages::Contact {
        position: contact.position,
        force: contact.normal.map(|n| -contact.force * n),
    };
    messages::Shape {
        sequence,
        finger: 0,
        status: Status::Converged,
        shift: [0.0; 2],
        motor_angle: follower.solution().coordinate() as f32,
        front: follower.solution().front().collect(),
        back: follower.solution().back().collect(),
        lamella_front: follower.solution().lamellae().map(|bar| bar[0]).collect(),
        lamella_back: follower.solution().lamellae().map(|bar| bar[1]).collect(),
        contacts: follower.solution().contacts().map(contact).collect(),
    }
}

#[test]
fn the_schemes_differences_are_those_of_the_physics() {
    for (physics, [least, most]) in [(Physics::Paper, [1.5, 4.0]), (Physics::Extended, [0.3, 1.0])] {
        let summary = Summary::of(&seen(physics));
        let [trapezoid, paper] = summary.differences.map(|ways| ways[0].max[1]);
        assert!(trapezoid < 1.0 && paper > least && paper < most, "{physics:?}: {trapezoid} % and {paper} %");
        assert!(paper > 1.5 * trapezoid, "{physics:?}: {trapezoid} % and {paper} %");
        assert_eq!(summary.faults, [""; 0], "{physics:?}: {}", summary.text());
    }
}

#[test]
fn table_and_report_tell_what_was_seen() {
    let mut seen = seen(Physics::Extended);
    let summary = Summary::of(&seen);
    assert_eq!(summary.faults, [""; 0], "{}", summary.text());
    assert_eq!((summary.estimates, summary.reports), (seen.samples.len(), seen.samples.len()));
    for (which, name) in REFERENCES.into_iter().enumerate() {
        for difference in summary.differences[which] {
            // Every position above 0 is in contact, three ticks each.
            assert!((374..=378).contains(&difference.count), "{name}: {difference:?}");
            assert!(difference.rms[0] > 0.0 && difference.rms[0] < difference.max[0], "{name}: {difference:?}");
        }
    }
    let [off, angle] = summary.shape_off.unwrap();
    assert!(off < 0.1 && (angle - 10.986).abs() < 0.01, "{off} mm at {angle}°");
    // 10,000 ticks of 40 ns in instructions of 4 ns.
    assert_eq!((summary.costs[0].mean, summary.costs[0].max), (100_000.0, 100_000.0));

    let folder = folder("report");
    let mut outputs = Files::new(false).folder(&folder, &FILES, "the report").unwrap();
    let files = write_report(&mut outputs, &seen, &summary).unwrap();
    assert!(files.iter().all(|file| fs::metadata(file).unwrap().len() > 1000), "{files:?}");
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(page.contains("Physics: extended"));
    assert!(page.contains(&summary.verdict()) && page.matches("<svg").count() == 3);
    // It needs nothing from elsewhere, and no identifier stands twice.
    assert!(!page.contains("src=") && !page.contains("@import"));
    let ids: Vec<&str> = page.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    for (index, id) in ids.iter().enumerate() {
        assert!(!ids[..index].contains(id), "{id} stands twice");
    }
    assert!(!ids.is_empty() && ids.iter().all(|id| page.contains(&format!("url(#{id})"))));
    let data = fs::read_to_string(folder.join("estimates.csv")).unwrap();
    let mut lines = data.lines();
    let columns = lines.next().unwrap().split(',').count();
    assert!(lines.clone().all(|line| line.split(',').count() == columns));
    assert_eq!(lines.count(), seen.samples.len());

    // Two in a hundred estimates 2 % off: reported, and a failure.
    for sample in seen.samples.iter_mut().step_by(50) {
        sample.report.estimate.force = sample.report.estimate.force.map(|part| 1.02 * part);
    }
    let summary = Summary::of(&seen);
    snapbox::assert_data_eq!(
        said::words(&summary.verdict()),
        snapbox::str!["failed: # of # estimates are more than # % (# N) off trapezoid #/#"]
    );
}

#[test]
fn what_is_not_trustworthy_counts_against_it() {
    let mut seen = seen(Physics::Extended);
    for sample in &mut seen.samples {
        sample.report.estimate.status = Status::Stale;
    }
    let summary = Summary::of(&seen);
    assert_eq!(summary.estimates, 0);
    snapbox::assert_data_eq!(
        summary.faults.join("\n"),
        snapbox::str![[r#"
no estimate in contact could be compared with trapezoid 170/20
777 of 777 reports are stale
"#]]
    );

    for sample in seen.samples.iter_mut().skip(400).take(20) {
        sample.report.estimate.status = Status::MaxIterations;
    }
    seen.cycles = 0;
    let faults = Summary::of(&seen).faults;
    snapbox::assert_data_eq!(
        faults.join("\n"),
        snapbox::str![[r#"
no estimate in contact could be compared with trapezoid 170/20
the finger has not closed and opened once
20 of 20 estimates are untrustworthy
757 of 777 reports are stale
"#]]
    );
}
