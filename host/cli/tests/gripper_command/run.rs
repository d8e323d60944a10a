//! `fre gripper run`: a planned motion, and what is kept of one that ends in the middle.

use std::process::{Command, Stdio};
use std::time::Duration;

use fre::fit::calibrate::Plan;
use test_bus::Tries;

use super::{CASE, Gripper};

/// A finger follows a planned motion by the gripper's own clock, and the table says where its motor was at the plan's times.
#[test]
fn a_planned_motion_is_made_and_recorded() {
    let gripper = Gripper::boot();
    let folder = gripper.sockets.folder().to_owned();
    let [case, plan, table] = ["case.toml", "plan.csv", "table.csv"].map(|name| folder.join(name));
    std::fs::write(&case, CASE).unwrap();
    gripper.done(&["gripper", "set", "--case", case.to_str().unwrap()]);
    let mut planned = Plan::new(0.0, 6.0, 12.0, &[[0.2, 0.8]], true);
    // The servo's time passes with the answers that it gives: on a busy PC the motor is behind the plan. It gets there while it is held, for
    // two seconds more than the plan wants, and at the end.
    let closed = planned.places.iter().position(|[_, angle_deg]| *angle_deg == 6.0).unwrap();
    planned.places.iter_mut().skip(closed + 1).for_each(|[time_s, _]| *time_s += 2.0);
    planned.places.push([planned.length_s() + 10.0, 6.0]);
    std::fs::write(&plan, planned.csv()).unwrap();
    let words =
        ["gripper", "run", plan.to_str().unwrap(), "--csv", table.to_str().unwrap(), "--after", "0.5", "--force"];
    let mut tries = Tries::of("a planned motion");
    loop {
        let (code, out, errors) = gripper.fre(&words);
        if code == Some(0) {
            break;
        }
        assert!(errors.contains("held") || errors.contains("servo"), "{code:?}: {out}{errors}");
        tries.spoilt();
    }
    let mut reader = csv::Reader::from_path(&table).unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), planned.places.len());
    let (mut rests, mut last) = (0, 0.0);
    for (row, [time_s, angle_deg]) in rows.iter().zip(&planned.places) {
        let number = |at: usize| row[at].parse::<f64>().unwrap();
        // The next fresh report after its time; there are 500 a second, in the board's time, unless a busy PC answers late.
        assert!((-0.001..0.2).contains(&(number(0) - time_s)), "{row:?}, planned {time_s}");
        let rests_now = (3.9..4.9).contains(time_s);
        let allowed = if rests_now { *angle_deg - 0.3..*angle_deg + 0.3 } else { -0.5..6.5 };
        assert!(allowed.contains(&number(1)), "{row:?}, planned {angle_deg} at {time_s}");
        rests += usize::from(rests_now);
        last = number(1);
        if rests_now {
            assert!(number(3) > 1.0 && ["converged", "tracking"].contains(&&row[5]), "{row:?}");
        }
    }
    assert!(rests > 1, "{rests} readings at rest");
    // It has opened in between, and closed again.
    let rested = planned.places.iter().rposition(|[_, angle_deg]| *angle_deg == 0.0).unwrap();
    let open: f64 = rows[rested][1].parse().unwrap();
    assert!(open.abs() < 0.3 && last > 3.0, "{open}° open, {last}° at last");
    // What cannot be is named before anything moves.
    for (text, name) in [
        ("time_s,motor_angle_deg\n0,0\n1,500\n", "far.csv"),
        ("time_s,motor_angle_deg\n0,0\n0,5\n", "late.csv"),
        ("time_s,angle\n0,0\n1,5\n", "angle.csv"),
    ] {
        std::fs::write(folder.join(name), text).unwrap();
        gripper.keep(&["gripper", "run", folder.join(name).to_str().unwrap()], 1);
    }
    gripper.keep(&["gripper", "run", plan.to_str().unwrap(), "--finger", "3"], 1);
    gripper.keep(&["gripper", "run", plan.to_str().unwrap(), "--csv", plan.to_str().unwrap(), "--force"], 1);
    gripper.compare(snapbox::file!["../words/run.txt"]);
}

/// Ctrl-C stops the finger, and keeps what was read.
#[test]
fn a_motion_that_is_stopped_holds_the_finger_and_keeps_its_readings() {
    let gripper = Gripper::boot();
    let folder = tempfile::tempdir().unwrap();
    let [plan, table] = ["plan.csv", "table.csv"].map(|name| folder.path().join(name));
    std::fs::write(&plan, Plan::new(0.0, 3.0, 0.1, &[], false).csv()).unwrap();
    let link = gripper.link();
    let words = ["gripper", "run", plan.to_str().unwrap(), "--after", "0.1", "--force", "--link", &link];
    let mut tries = Tries::of("a motion that is stopped");
    let (rows, errors) = loop {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
        command.args(words).args(["--csv", table.to_str().unwrap()]).stderr(Stdio::piped());
        let running = command.spawn().unwrap();
        std::thread::sleep(Duration::from_secs(5));
        assert!(Command::new("kill").args(["-INT", &running.id().to_string()]).status().unwrap().success());
        let output = running.wait_with_output().unwrap();
        let errors = String::from_utf8(output.stderr).unwrap();
        if output.status.code() == Some(130) && table.exists() {
            break (csv::Reader::from_path(&table).unwrap().into_records().count(), errors);
        }
        eprintln!("{:?}: {errors}", output.status.code());
        tries.spoilt();
    };
    assert!(rows > 0 && errors.contains(&format!("finger 0 holds: {rows} of 49 readings")), "{rows} rows: {errors}");
    assert!(super::lines_until(&gripper, ",held").contains(",held"));
}

/// A gripper that goes away in the middle of a motion does not take the readings with it.
#[test]
fn what_was_read_of_a_motion_is_kept() {
    let gripper = Gripper::boot();
    let folder = tempfile::tempdir().unwrap();
    let [plan, table] = ["plan.csv", "table.csv"].map(|name| folder.path().join(name));
    std::fs::write(&plan, Plan::new(0.0, 3.0, 0.1, &[], false).csv()).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
    command.args(["gripper", "run", plan.to_str().unwrap(), "--after", "0.1", "--csv", table.to_str().unwrap()]);
    command.args(["--link", &gripper.link()]).stderr(Stdio::piped());
    let running = command.spawn().unwrap();
    std::thread::sleep(Duration::from_secs(5));
    drop(gripper);
    let output = running.wait_with_output().unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{errors}");
    let rows = csv::Reader::from_path(&table).unwrap().into_records().count();
    assert!(rows > 0 && errors.contains(&format!("{rows} of 49 readings")), "{rows} rows: {errors}");
}
