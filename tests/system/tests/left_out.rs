//! Says which system tests this run leaves out.

use std::process::ExitCode;

use test_bus::{Feature, left_out};

fn main() -> ExitCode {
    let features = [
        Feature { name: "qemu", on: cfg!(feature = "qemu"), needs: "QEMU and the firmware's image" },
        Feature { name: "browser", on: cfg!(feature = "browser"), needs: "Chromium" },
        Feature {
            name: "python",
            on: cfg!(feature = "python"),
            needs: "ROBOTIS' SDK and Eclipse Cyclone DDS for Python",
        },
        Feature { name: "ros2", on: cfg!(feature = "ros2"), needs: "the library for DDS" },
    ];
    left_out(include_str!("../Cargo.toml"), &features)
}
