//! No option is ignored for want of another. clap waives `requires = "x"` where an argument is present that conflicts with `x`: whatever
//! requires `x` must then conflict with that argument as well.

use std::collections::BTreeSet;

use clap::{Arg, Command};

use crate::command;

/// What an argument requires. clap shows it in its debug format only.
fn required(arg: &Arg) -> Vec<String> {
    let shown = format!("{arg:?}");
    let list = shown.split("requires: [").nth(1).and_then(|rest| rest.split(']').next()).unwrap_or_default();
    list.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

/// What conflicts with an argument: by its own word, by the other's, and by a group of which one only is allowed.
fn conflicting(command: &Command, id: &str) -> BTreeSet<String> {
    let says = |arg: &Arg| -> Vec<String> {
        command.get_arg_conflicts_with(arg).iter().map(|other| other.get_id().to_string()).collect()
    };
    let mut found = BTreeSet::new();
    for arg in command.get_arguments() {
        if arg.get_id() == id {
            found.extend(says(arg));
        } else if says(arg).iter().any(|other| other == id) {
            found.insert(arg.get_id().to_string());
        }
    }
    for group in command.get_groups().filter(|group| !(*group).clone().is_multiple()) {
        let ids: Vec<_> = group.get_args().map(ToString::to_string).collect();
        if ids.iter().any(|other| other == id) {
            found.extend(ids.into_iter().filter(|other| other != id));
        }
    }
    found
}

/// Pairs of arguments that are accepted although one of them is ignored then; how many requirements were looked at.
fn ignored(command: &Command, faults: &mut Vec<String>) -> usize {
    let mut count = 0;
    for arg in command.get_arguments() {
        let refused = conflicting(command, arg.get_id().as_str());
        for needed in required(arg) {
            count += 1;
            for other in conflicting(command, &needed).difference(&refused) {
                let name = command.get_name();
                faults.push(format!("{name}: {} requires {needed}, and is accepted with {other}", arg.get_id()));
            }
        }
    }
    count + command.get_subcommands().map(|below| ignored(below, faults)).sum::<usize>()
}

#[test]
fn no_requirement_is_waived() {
    let (mut command, mut faults) = (command(), Vec::new());
    command.build();
    let count = ignored(&command, &mut faults);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(count > 5, "only {count} requirements were found");
}

#[test]
fn a_waived_requirement_is_found() {
    let flag = |name: &'static str| Arg::new(name).long(name).num_args(0);
    let command = Command::new("a").args([flag("x"), flag("y").conflicts_with("x"), flag("o").requires("x")]);
    let accepted = command.clone().try_get_matches_from(["a", "--o", "--y"]);
    assert!(accepted.is_ok(), "clap waives it");
    let mut faults = Vec::new();
    assert_eq!(ignored(&command, &mut faults), 1);
    assert_eq!(faults, ["a: o requires x, and is accepted with y"]);
}

/// Refused with the option that is ignored.
#[cfg(all(feature = "gripper", feature = "outline"))]
#[test]
fn what_would_be_ignored_is_refused() {
    for line in [
        "replay r.mcap --parquet p --youngs-modulus-pa 2e7",
        "replay r.mcap --parquet p --case c.toml",
        "replay r.mcap --parquet p --set rate_hz=2",
        "replay r.mcap --parquet p --elements fine",
        "replay r.mcap --parquet p --physics paper",
        "replay r.mcap --parquet p --precision f32",
        "replay r.mcap --parquet p --show",
        "replay r.mcap --lines --open",
        "calibrate m.csv -c c.toml --to-deg 4",
        "calibrate m.csv -c c.toml --speed-deg-per-s 7",
        "calibrate -c c.toml --plan - --on-top",
        "calibrate -c c.toml --plan - --finger 3",
        "calibrate -c c.toml --plan - --plot-theme dark",
        "monitor --link unix:a --lines --listen 127.0.0.1",
        "monitor --link unix:a --lines --open",
        "demo --firmware e --seconds 5 --listen 127.0.0.1",
        "ros2 --link unix:a --speed 3",
        "ros2 --bus unix:a --linger 3",
        "ros2 --link unix:a --wait-for-subscribers",
        "gripper --link unix:a grip --force-n 5 --finger 0 --safety 3",
        "gripper --link unix:a grip --force-n 5 --finger 0 --gravity-deg 3",
        "outline i.png --case c.toml --angle-deg 3 --marks-file m.toml --camera c --save-camera d",
    ] {
        let refused = command().try_get_matches_from(std::iter::once("fre").chain(line.split(' ')));
        let kind = refused.map(|_| "accepted").map_err(|error| error.kind());
        assert_eq!(kind, Err(clap::error::ErrorKind::ArgumentConflict), "{line}");
    }
}
