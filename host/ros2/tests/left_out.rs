//! Says which tests of the node this run leaves out.

use std::process::ExitCode;

use test_bus::{Feature, left_out};

fn main() -> ExitCode {
    let features = [
        Feature { name: "dds", on: cfg!(feature = "dds"), needs: "the library for DDS" },
        Feature { name: "python", on: cfg!(feature = "python"), needs: "Eclipse Cyclone DDS for Python" },
    ];
    left_out(include_str!("../Cargo.toml"), &features)
}
