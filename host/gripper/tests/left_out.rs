//! Says which tests of this crate this run leaves out.

use std::process::ExitCode;

use test_bus::{Feature, left_out};

fn main() -> ExitCode {
    let features = [
        Feature { name: "record", on: cfg!(feature = "record"), needs: "the library for recordings" },
        Feature { name: "web", on: cfg!(feature = "web"), needs: "the libraries for the live page" },
        Feature { name: "python", on: cfg!(feature = "python"), needs: "ROBOTIS' SDK for Python" },
    ];
    left_out(include_str!("../Cargo.toml"), &features)
}
