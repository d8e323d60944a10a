//! Runs of a program that takes the place of CalculiX: what ends them early, and what is kept then.

use std::ops::ControlFlow;

use fre::compare::{CompareError, with_elements_watched};
use fre::fea::{Plan, Progress, parse_sta};
use fre::study::model::Options;

use super::case;
#[cfg(unix)]
use super::program;
use super::said;

/// `fre compare --fea` with a program of ours in the place of CalculiX: exit status and standard error.
#[cfg(unix)]
fn with_another_program(name: &str, script: Option<&str>, options: &[&str]) -> (Option<i32>, String, String) {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("ccx-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.join("bin")).unwrap();
    if let Some(script) = script {
        program::write(&folder.join("bin/ccx"), script);
    }
    let text = "finger = \"preset:fea-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 45.0]\n\
                [motion]\nmotor_angles_deg = [1, 2]\n";
    std::fs::write(folder.join("case.toml"), text).unwrap();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_fre"))
        .args(["compare", "case.toml", "--fea", "--folder", "files"])
        .args(options)
        .env("PATH", folder.join("bin"))
        .current_dir(&folder)
        .output()
        .unwrap();
    let words = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), words(output.stdout), words(output.stderr))
}

#[cfg(unix)]
#[test]
fn without_calculix_or_with_one_that_fails_the_reason_is_told() {
    let error = "#!/bin/sh\necho ' *ERROR reading *STEP: card'; echo '  of line 7'; exit 201\n";
    let mut said = String::new();
    for (name, program) in [
        ("absent", None),
        ("broken", Some("no program")),
        ("error", Some(error)),
        ("killed", Some("#!/bin/sh\nkill -9 $$\n")),
    ] {
        let (status, _, words) = with_another_program(name, program, &[]);
        assert_eq!(status, Some(1), "{words}");
        let files = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("ccx-{name}/files"));
        assert_eq!(files.exists(), program.is_some(), "{name}: a run that does not begin leaves no files");
        said += &format!("{name}\n{words}\n");
    }
    snapbox::assert_data_eq!(said, snapbox::file!["../words/calculix.txt"].raw());
}

#[test]
fn a_watcher_stops_it_before_calculix_starts() {
    let folder = tempfile::tempdir().unwrap();
    let mut told = Vec::new();
    let case = case("fea-80", 40.0, 45.0, &[1.0, 2.0]);
    let stopped = with_elements_watched(&case, &Options::default(), 1, folder.path(), |progress| {
        told.push(progress);
        ControlFlow::Break(())
    });
    assert!(matches!(stopped, Err(CompareError::Stopped)), "{stopped:?}");
    let plan = Plan::of(&case, 1).unwrap();
    assert_eq!(told, [Progress { elements: plan.mesh.elements.len(), done: 0, total: plan.path.len() }]);
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
}

#[cfg(unix)]
#[test]
fn a_run_that_ends_early_keeps_what_it_reached() {
    // As many displacements as the deck asks for at its first stop (two increments of moving, two of holding), then the end
    // in the middle of a line.
    let lines = Plan::of(&case("fea-80", 40.0, 45.0, &[1.0, 2.0]), 1).unwrap();
    let count = lines.mesh.front_line.len() + lines.mesh.back_line.len();
    let stop = lines.stops[0];
    let script = format!(
        "#!/bin/sh\n{{ echo ' displacements (vx,vy,vz) for set NLINES and time  {stop}.0'; echo; i=0; \
         while [ $i -lt {count} ]; do echo '  3  -4.0 0.0 0.0'; i=$((i+1)); done; \
         echo; echo ' total force (fx,fy,fz) for set NRING and time  {stop}.0'; echo; echo '  -0.5 0.0 0.0'; \
         echo ' displacements (vx,vy,vz) for set NLINES and time  {}.0'; echo; printf '  3  0.0 0.'; }} > finger.dat\n\
         printf '  100CL  101 {stop}.000000000  1\n -4  DISP        4    1\n -1         1 oops\n -3\n' > finger.frd\n",
        lines.stops[1]
    );
    let (status, told, error) = with_another_program("early", Some(&script), &["--format", "csv"]);
    assert_eq!(status, Some(2), "{error}");
    let rows: Vec<Vec<&str>> = told.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert_eq!((rows.len(), rows[0][3], rows[1][3]), (2, "0.5", ""), "{told}");
    snapbox::assert_data_eq!(
        error,
        snapbox::str![[r#"
fre: CalculiX: [..] elements, 8 increments …
fre: note: CalculiX's .frd, line 3: unexpected "-1         1 oops": the deformed mesh is not drawn

"#]]
    );
    // Both have the model's force.
    assert!(rows.iter().all(|row| row[1] == "converged" && row[2].parse::<f64>().is_ok()), "{told}");
}

/// A program in CalculiX's place that prints the same at every stop of `with_another_program`'s case: how far every point has moved
/// along x, and the force's x. Then it ends with a status.
#[cfg(unix)]
fn that_prints(moved: &str, force: &str, status: i32) -> String {
    let plan = Plan::of(&case("fea-80", 40.0, 45.0, &[1.0, 2.0]), 1).unwrap();
    let count = plan.mesh.front_line.len() + plan.mesh.back_line.len();
    let mut script = "#!/bin/sh\n: > finger.dat\n".to_owned();
    for stop in &plan.stops {
        script += &format!(
            "{{ echo ' displacements (vx,vy,vz) for set NLINES and time  {stop}.0'; echo; i=0; while [ $i -lt {count} ]; do \
             echo '  3  {moved} 0.0 0.0'; i=$((i+1)); done; echo; echo ' total force (fx,fy,fz) for set NRING and time  {stop}.0'; \
             echo; echo '  {force} 0.0 0.0'; }} >> finger.dat\n"
        );
    }
    script + &format!("echo ' *ERROR: too many cutbacks'\nexit {status}\n")
}

#[cfg(unix)]
#[test]
fn a_place_whose_contact_was_missed_or_whose_result_is_no_number_has_no_force() {
    // The finger has not moved at all, and the circle stands in it: at 1° by 0.9 to 1.1 mm.
    let (status, told, error) =
        with_another_program("missed", Some(&that_prints("0.0", "0.0", 0)), &["--format", "csv"]);
    assert_eq!(status, Some(2), "{error}");
    assert!(told.lines().skip(1).all(|line| line.split(',').nth(3) == Some("")), "{told}");
    snapbox::assert_data_eq!(
        error,
        snapbox::str![[r#"
fre: CalculiX: [..] elements, 8 increments …
fre: note: at 1° the object reaches [..] mm into the deformed mesh, where only the front beam's outer face and the tip's end have contact: no FEA force is reported
fre: note: at 2° the object reaches [..] mm into the deformed mesh, where only the front beam's outer face and the tip's end have contact: no FEA force is reported

"#]]
    );
    // It has moved beyond the object, whose other side it now faces.
    let (status, _, error) = with_another_program("beyond", Some(&that_prints("90.0", "0.0", 0)), &["--format", "csv"]);
    assert_eq!(status, Some(2), "{error}");
    snapbox::assert_data_eq!(
        error,
        snapbox::str![[r#"
fre: CalculiX: [..] elements, 8 increments …
fre: note: at 1° the object has passed the front beam without touching it: no FEA force is reported
fre: note: at 2° the object has passed the front beam without touching it: no FEA force is reported

"#]]
    );
    let (status, told, error) = with_another_program("nan", Some(&that_prints("-4.0", "NaN", 0)), &["--format", "csv"]);
    assert_eq!(status, Some(2), "{error}");
    assert!(!told.contains("NaN"), "{told}");
    snapbox::assert_data_eq!(
        error,
        snapbox::str![[r#"
fre: CalculiX: [..] elements, 8 increments …
fre: note: at 1° CalculiX's result is not a number: no FEA force is reported
fre: note: at 2° CalculiX's result is not a number: no FEA force is reported

"#]]
    );
}

#[cfg(unix)]
#[test]
fn rounding_errors_have_no_percentages_and_a_bad_end_is_told() {
    let (status, told, error) = with_another_program("noise", Some(&that_prints("-4.0", "1e-26", 201)), &[]);
    assert_eq!(status, Some(0), "{error}");
    let last = "note: CalculiX did not end well (exit status: 201); it says: *ERROR: too many cutbacks: only what it reached before is reported";
    assert_eq!(told.lines().last(), Some(last));
    snapbox::assert_data_eq!(
        said::words(&told),
        snapbox::str![[r#"
at ° force N FEA N diff. N error % shape mean mm shape max mm status
# # # # – # # converged
force difference: mean # N, max # N (at #°)
shape deviation (nearest distance): mean # mm, max # mm (at #° near (-#, #) mm, finger frame)
CalculiX: # elements, # nodes, # increments (# attempts failed), # iterations; files in files
time: CalculiX # s, model # ms: # times faster
note: CalculiX did not end well (exit status: #); it says: *ERROR: too many cutbacks: only what it reached before is reported
"#]]
    );
}

#[cfg(unix)]
#[test]
fn a_folder_has_one_run_at_a_time_even_if_the_first_was_killed() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("ccx-locked");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.join("bin")).unwrap();
    // It says that it runs, and ends when a file `end` is there.
    let script = "#!/bin/sh\necho > running\nwhile [ ! -e end ]; do /bin/sleep 0.05; done\necho > ended\n";
    program::write(&folder.join("bin/ccx"), script);
    let text = "finger = \"preset:fea-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 45.0]\n\
                [motion]\nmotor_angles_deg = [1]\n";
    std::fs::write(folder.join("case.toml"), text).unwrap();
    let command = || {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_fre"));
        command.args(["compare", "case.toml", "--fea", "--force", "--folder", "files"]);
        command.env("PATH", folder.join("bin")).current_dir(&folder).stderr(std::process::Stdio::piped());
        command
    };
    let wait_for = |file: &str| {
        let begin = std::time::Instant::now();
        while !folder.join("files").join(file).exists() {
            assert!(begin.elapsed().as_secs() < 60, "no {file}");
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
    };
    let mut first = command().spawn().unwrap();
    wait_for("running");
    first.kill().unwrap();
    first.wait().unwrap();
    // The program goes on without its parent, and keeps the folder.
    let second = command().output().unwrap();
    assert_eq!(second.status.code(), Some(1), "{second:?}");
    snapbox::assert_data_eq!(
        second.stderr,
        snapbox::str![[r#"
fre: CalculiX: [..] elements, 4 increments …
fre: files: another `fre compare --fea` works here, or a CalculiX (`ccx`) that outlived its own; wait for it, end it, or name another folder (--folder)

"#]]
    );
    std::fs::write(folder.join("files/end"), "").unwrap();
    wait_for("ended");
    // Free again: this run's program ends at once, and has reached nothing.
    snapbox::assert_data_eq!(
        command().output().unwrap().stderr,
        snapbox::str![[r#"
fre: CalculiX: [..] elements, 4 increments …
fre: CalculiX reached no place (exit status: 0); its files are in files

"#]]
    );
}

#[test]
fn failed_attempts_are_counted_apart() {
    let text = "SUMMARY OF JOB INFORMATION\n  STEP      INC     ATT  ITRS     TOT TIME     STEP TIME      INC TIME\n     \
        1          1     1U   25  0.100000E+01  0.100000E+01  0.100000E+01\n     \
        1          1     2     8  0.250000E+00  0.250000E+00  0.250000E+00\n     \
        1          2     1     6  0.500000E+00  0.500000E+00  0.250000E+00\n";
    let effort = parse_sta(text);
    assert_eq!((effort.increments, effort.failed_attempts, effort.iterations, effort.steps), (2, 1, 39, 0));
    let ended = format!("{text}          1          3     1     4  0.100000E+01  0.100000E+01  0.500000E+00\n");
    assert_eq!(parse_sta(&ended).steps, 1);
}
