//! `fre flash` and `fre log` where there is no debug probe: an error that says what was looked for, or how to build `fre` with
//! probes.

use std::process::Command;

/// An image for the OpenCR's flash: an ELF file for ARM with one segment of four bytes and no symbols.
fn image() -> Vec<u8> {
    let mut file = b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0".to_vec();
    let mut put = |bytes: &[u8]| file.extend(bytes);
    // Executable, ARM, version 1; header sizes; one program header behind the file header.
    [2_u16, 40].iter().for_each(|half| put(&half.to_le_bytes()));
    [1_u32, 0, 52, 0, 0].iter().for_each(|word| put(&word.to_le_bytes()));
    [52_u16, 32, 1, 40, 0, 0].iter().for_each(|half| put(&half.to_le_bytes()));
    [1_u32, 84, 0x0804_0000, 0x0804_0000, 4, 4, 5, 4].iter().for_each(|word| put(&word.to_le_bytes()));
    put(b"code");
    file
}

fn error(words: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.elf");
    std::fs::write(&path, image()).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_fre")).args(words).arg("--image").arg(&path).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{words:?}: {text}");
    text
}

#[test]
fn without_a_probe_it_says_what_was_looked_for() {
    // A probe that nobody makes: a real one on this PC is left alone.
    let text = error(&["flash", "opencr", "--probe", "dead:beef"]);
    if cfg!(feature = "probe") {
        let said =
            ["no debug probe was found", "ST-LINK, CMSIS-DAP (v2), J-Link", "USB devices", "Needed: a debug probe"];
        assert!(said.iter().all(|words| text.contains(words)), "{text}");
    } else {
        assert!(text.contains("built without debug probes") && text.contains("--features probe"), "{text}");
    }
}

#[test]
fn bad_input_is_told_before_a_probe_is_looked_for() {
    assert!(error(&["flash", "uno"]).contains("allowed are opencr, nucleo-h743zi, nucleo-g474re"));
    let elsewhere = error(&["flash", "nucleo-g474re", "--probe", "dead:beef"]);
    assert!(!elsewhere.contains("does not belong"), "inside its flash: {elsewhere}");
    if cfg!(feature = "probe") {
        assert!(error(&["flash", "opencr", "--probe", "here"]).contains("allowed is VID:PID"));
    }
}
