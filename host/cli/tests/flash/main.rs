//! `fre flash` without a debug probe: what it says where one is missing, and updates of a simulated board by its boot loader.

mod simulated;
#[path = "../transcript/mod.rs"]
mod transcript;

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use fre_gripper::loader::{LoaderError, Patience, update};
use fre_gripper::probe::{Board, Image};
use simulated::{Faults, PLACE, Plugged, SECTOR, Simulated, plug};
use transcript::Transcript;

/// Waits that are long enough on a busy machine where something comes, and short where nothing does.
const PATIENCE: Patience =
    Patience { answer: Duration::from_secs(1), erase: Duration::from_secs(5), start: Duration::from_secs(5) };

/// Runs a command that fails, with an image for the OpenCR.
fn refused(said: &mut Transcript, words: &str) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.elf");
    std::fs::write(&path, test_bus::elf(40, &[(0x0804_0000, b"code")], Some(("opencr", "0.2.0")))).unwrap();
    let mut fre = Command::new(env!("CARGO_BIN_EXE_fre"));
    let output = fre.args(words.split(' ')).arg("--image").arg(&path).env("COLUMNS", "100").output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{words:?}: {text}");
    // Which devices this machine has.
    let devices = text.split_once(", among ").and_then(|(_, rest)| rest.split_once(". Needed")).map(|(names, _)| names);
    let text = devices.map_or_else(|| text.to_string(), |names| text.replace(names, "DEVICES"));
    said.add(&format!("fre {words}"), folder.path(), (output.status.code(), &text));
}

#[test]
fn bad_input_is_told_before_a_probe_or_a_port_is_looked_for() {
    let mut said = Transcript::default();
    for words in [
        "flash uno",
        "flash nucleo-g474re --probe dead:beef",
        "flash opencr --port /dev/a-port-that-is-not-there",
        "flash nucleo-h743zi --port /dev/null",
        "flash opencr --port p --probe dead:beef",
    ] {
        refused(&mut said, words);
    }
    snapbox::assert_data_eq!(said.text(), snapbox::file!["../words/flash.txt"].raw());
}

#[test]
fn without_a_probe_it_says_what_was_looked_for() {
    let mut said = Transcript::default();
    if cfg!(feature = "probe") {
        refused(&mut said, "flash opencr --probe here");
    }
    // A probe that nobody makes: a real one on this PC is left alone.
    refused(&mut said, "flash opencr --probe dead:beef");
    let expected = if cfg!(feature = "probe") {
        snapbox::file!["../words/flash_probe.txt"]
    } else {
        snapbox::file!["../words/flash_no_probe.txt"]
    };
    snapbox::assert_data_eq!(said.text(), expected.raw());
}

/// An image of an OpenCR's program, which does not end at a unit of anything.
fn image(board: &str, version: &str) -> Vec<u8> {
    let mut program: Vec<u8> = (0..300_001_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    program[PLACE..PLACE + version.len()].copy_from_slice(version.as_bytes());
    program[PLACE + version.len()] = 0;
    let (vectors, rest) = program.split_at(1000);
    test_bus::elf(40, &[(0x0804_0000, vectors), (0x0804_0000 + 1000, rest)], Some((board, version)))
}

fn run(board: &Plugged, image: Vec<u8>) -> (Result<(), LoaderError>, String) {
    let image = Image::parse(Path::new("image"), image).unwrap();
    let mut out = Vec::new();
    let opencr = Board::named("opencr").unwrap();
    let result = update(&opencr, &image, &board.port, PATIENCE, &mut out);
    (result, String::from_utf8(out).unwrap())
}

#[test]
fn a_running_board_is_updated_and_both_versions_are_shown() {
    let plugged = plug(Simulated::new(Some(("opencr", "0.1.9"))));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("image.elf");
    std::fs::write(&file, image("opencr", "0.2.0")).unwrap();
    let mut fre = Command::new(env!("CARGO_BIN_EXE_fre"));
    let output = fre.args(["flash", "opencr", "--port", &plugged.port]).arg("--image").arg(&file).output().unwrap();
    let out = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{out}{}", String::from_utf8_lossy(&output.stderr));
    let steps: Vec<&str> = out.lines().filter(|line| !line.ends_with('%')).collect();
    let expected = [
        "image: opencr, version 0.2.0, 300032 bytes",
        "before: gripper on opencr, version 0.1.9",
        "boot loader: OpenCR R1.0, version 17020800",
        "erasing",
        "writing",
        "the flash holds the image",
        "after: gripper on opencr, version 0.2.0",
    ];
    assert_eq!(steps, expected);
    let board = plugged.board.lock().unwrap();
    assert!(board.flash[300_001..SECTOR * 2].iter().all(|byte| *byte == 0xff), "the rest is erased");
}

#[test]
fn a_loader_that_waits_needs_no_call_and_lost_pieces_are_sent_again() {
    let mut board = Simulated::new(None);
    board.faults.lost_pieces = 2;
    let plugged = plug(board);
    let (result, out) = run(&plugged, image("opencr", "0.2.0"));
    result.unwrap();
    let [first, second, .., last] = out.lines().collect::<Vec<_>>()[..] else { panic!("{out}") };
    assert_eq!(first, "image: opencr, version 0.2.0, 300032 bytes");
    assert_eq!(second, "before: no gripper's program answers");
    assert_eq!(last, "after: gripper on opencr, version 0.2.0");
}

#[test]
fn nothing_is_written_to_another_board_or_of_another_board_s_image() {
    let untouched = |plugged: &Plugged| plugged.board.lock().unwrap().flash.iter().all(|byte| *byte == 0);
    let plugged = plug(Simulated::new(Some(("mps2", "0.2.0"))));
    let (result, _) = run(&plugged, image("opencr", "0.2.0"));
    assert!(matches!(&result, Err(LoaderError::OtherBoard { found, .. }) if found == "mps2"), "{result:?}");
    assert!(untouched(&plugged));

    let (result, out) = run(&plugged, image("nucleo-h743zi", "0.2.0"));
    assert_eq!(
        result.unwrap_err().to_string(),
        "image is an image for nucleo-h743zi, not for opencr; `cargo xtask firmware opencr` builds the right one"
    );
    assert_eq!(out, "");

    let mut other = Simulated::new(None);
    other.name = "OpenCM9.04";
    let plugged = plug(other);
    let error = run(&plugged, image("opencr", "0.2.0")).0.unwrap_err().to_string().replace(&plugged.port, "PORT");
    snapbox::assert_data_eq!(
        error,
        snapbox::str!["at PORT is the boot loader of `OpenCM9.04`, not opencr; nothing was written"]
    );
    assert!(untouched(&plugged));
}

#[test]
fn what_fails_is_named_with_what_helps() {
    let program = Some(("opencr", "0.1.9"));
    let mut said = Transcript::default();
    for (what, faults, program) in [
        ("the flash keeps what it had", Faults { stuck: true, ..Faults::default() }, None),
        ("the new program does not answer", Faults { mute: true, ..Faults::default() }, None),
        ("no boot loader after the call", Faults { deaf: true, ..Faults::default() }, program),
        ("pieces get lost", Faults { lost_pieces: 1_000, ..Faults::default() }, None),
    ] {
        let mut board = Simulated::new(program);
        board.faults = faults;
        let plugged = plug(board);
        let error = run(&plugged, image("opencr", "0.2.0")).0.unwrap_err().to_string();
        said.add(what, Path::new("."), (Some(1), &error.replace(&plugged.port, "PORT")));
    }
    snapbox::assert_data_eq!(said.text(), snapbox::file!["../words/loader.txt"].raw());
}
