//! The real firmware's log, as `fre log --qemu` shows it.

use std::ops::ControlFlow;
use std::time::Duration;

use fre_gripper::probe::{Board, Image, ProbeError, emulated};
use fre_log::Line;
use system_tests::firmware;

/// Only so that a firmware that logs nothing does not hold the tests for ever.
const PATIENCE: Duration = Duration::from_secs(60);

/// The log of a start, up to its first lines: bytes as they came, and lines.
fn recorded() -> (Vec<u8>, Vec<Line>) {
    let (mut bytes, mut lines) = (Vec::new(), Vec::new());
    emulated::log(&firmware(), Some(PATIENCE), |more, complete| {
        bytes.extend_from_slice(more);
        lines.extend_from_slice(complete);
        Ok(if lines.is_empty() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) })
    })
    .unwrap();
    (bytes, lines)
}

#[test]
fn a_line_has_time_level_words_and_its_place() {
    let (_, lines) = recorded();
    let line = lines[0].to_string();
    assert!(
        line.contains(" INFO ") && line.contains(concat!("gripper on mps2-an500, version ", env!("CARGO_PKG_VERSION"))),
        "{line}"
    );
    assert!(line.contains("gripper.rs:"), "no place in the source: {line}");
    assert!(line.trim_start().starts_with("0."), "no time: {line}");
}

/// Bytes come in pieces of any size, and some are damaged on the way.
#[test]
fn a_recorded_log_is_decoded_in_any_pieces() {
    let (bytes, lines) = recorded();
    let image = Image::read(&firmware(), "mps2").unwrap();
    let log = image.log().unwrap();
    for size in [1, 2, 3, 7, bytes.len()] {
        let mut decoder = log.decoder();
        let again: Vec<Line> = bytes.chunks(size).flat_map(|piece| decoder.feed(piece)).collect();
        assert_eq!(again, lines, "in pieces of {size}");
    }
    let mut decoder = log.decoder();
    // The end of a line that was cut off before the connection.
    let noise = [0x55, 0xAA, 0x11, 0x00];
    let after: Vec<Line> = noise.chunks(1).chain([bytes.as_slice()]).flat_map(|piece| decoder.feed(piece)).collect();
    assert_eq!(after.last(), lines.last(), "a damaged line takes the next ones with it");
}

/// The image for QEMU is refused on every board, by its label: it would overwrite what lies at address 0.
#[test]
fn the_image_for_qemu_belongs_on_no_board() {
    let image = Image::read(&firmware(), "mps2").unwrap();
    assert!(image.pieces().iter().map(|piece| piece.bytes.len()).sum::<usize>() > 100_000);
    for board in Board::all() {
        let fits = image.fits(&board);
        assert!(
            matches!(&fits, Err(ProbeError::OtherBoard { label, .. }) if label == "mps2"),
            "{}: {fits:?}",
            board.name
        );
    }
    assert_eq!(image.rtt(), None, "its log comes by semihosting");
    assert!(Board::named("mps2").is_err());
}
