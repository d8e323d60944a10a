//! How fast a recording is written and how large it becomes: so many minutes of four fingers at 500 Hz, each with 20 shapes a
//! second, as fast as the disk and this processor take them; then read back and counted.

use std::fmt::Write as _;
use std::time::Instant;

use anyhow::{Context, Result};
use fre::case::preset;
use fre::study::model::Precision;
use fre_gripper::estimator::estimator;
use fre_gripper::record::{Recorded, Recorder, Recording};
use fre_gripper::source::{Modelled, Origin, Setup, Told};
use messages::{FINGERS, Finger, Grasp, Mount, PROTOCOL_VERSION, Phase, Report, Settings, Shape, Side};
use model_core::discretise::{Discretisation, Physics};
use model_core::newton::Hessian;
use model_core::object::ObjectDesign;

/// Ticks per second, and ticks between two shapes of a finger.
const HZ: u64 = 500;
const SHAPE_EVERY: u64 = 25;

/// Writes and reads a recording of so many minutes; the figures as lines.
pub fn measure(minutes: u64) -> Result<String> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("rate.mcap");
    let design = preset("ladder-80").context("no such finger")??.design;
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    let how = Discretisation::estimator(Physics::Extended);
    let mut settings = Settings::DEFAULT;
    for (number, place) in settings.fingers.iter_mut().enumerate() {
        let side = if number % 2 == 0 { Side::Left } else { Side::Right };
        *place = Some(Mount { servo_id: number as u8 + 1, side, ..Mount::DEFAULT });
    }
    let model = Modelled {
        finger: Some(Finger::elastic(design.clone(), how)),
        object: Some(object),
        friction: 0.0,
        uncertainty: None,
    };
    let setup = Setup {
        origin: Origin::Gripper,
        place: "nowhere".to_owned(),
        board: "none".to_owned(),
        firmware: "none".to_owned(),
        protocol: PROTOCOL_VERSION,
        cost_hz: 1_000_000,
        settings,
        models: vec![model; FINGERS],
    };

    // A slow grip, count by count and back, as a real finger has it; the current is noisy as a real one.
    let mut model = estimator(Precision::F32, Hessian::default());
    model.configure(&design, &how)?;
    model.set_object(object)?;
    let phase = Phase::Gripping;
    let samples: Vec<(Report, Shape)> = (-100..130_i32)
        .chain((-100..130).rev())
        .map(|counts| {
            let angle = f64::from(counts) * std::f64::consts::TAU / 4096.0;
            let (estimate, position, goal) = (model.update(angle), 2048 + counts, angle as f32);
            let report = Report { phase, estimate, goal, position, ..Report::blank(0) };
            (report, model.shape(&report))
        })
        .collect();

    let start = Instant::now();
    let mut recorder = Recorder::create(&path, Some(setup))?;
    let (mut sequence, mut noise) = (0_u32, 1_u32);
    for tick in 0..minutes * 60 * HZ {
        let mut reports = [samples[0].0; FINGERS];
        for (finger, place) in reports.iter_mut().enumerate() {
            let (report, shape) = &samples[(tick as usize / 4 + 40 * finger) % samples.len()];
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            sequence = sequence.wrapping_add(1);
            let current = 2.69 * ((noise >> 27) as f32 - 16.0);
            let (finger, time_us, cost) = (finger as u8, tick * 1_000_000 / HZ, 400 + (noise >> 26));
            *place = Report { sequence, finger, time_us, current, cost, ..*report };
            recorder.take(&Told::Report(*place))?;
            if (tick + u64::from(finger)).is_multiple_of(SHAPE_EVERY) {
                recorder.take(&Told::Shape(Box::new(Shape { sequence, finger, ..shape.clone() })))?;
            }
        }
        let sides = settings.fingers.iter().flatten().map(|mount| mount.side);
        recorder.take(&Told::Grasp(Grasp::of(reports.iter().zip(sides))))?;
    }
    let counts = recorder.finish()?;
    let seconds = start.elapsed().as_secs_f64();
    let bytes = std::fs::metadata(&path)?.len() as f64;
    let mut out = format!("{minutes} min of {FINGERS} fingers at {HZ} Hz: {counts}\n");
    writeln!(out, "written in {seconds:.1} s: {:.0} times real time", minutes as f64 * 60.0 / seconds)?;
    writeln!(out, "{:.0} MB, {:.0} bytes a report", bytes * 1e-6, bytes / counts.reports as f64)?;

    let start = Instant::now();
    let mut reports = 0_u64;
    for recorded in Recording::open(&path)? {
        reports += u64::from(matches!(recorded?.1, Recorded::Told(Told::Report(_))));
    }
    writeln!(out, "read back in {:.1} s: {reports} reports", start.elapsed().as_secs_f64())?;
    Ok(out)
}
