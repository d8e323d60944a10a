//! Says which tests of the command this run leaves out.

use std::process::ExitCode;

use test_bus::{Feature, left_out};

fn main() -> ExitCode {
    let features = [
        Feature { name: "gripper", on: cfg!(feature = "gripper"), needs: "the libraries of a gripper and its servos" },
        Feature { name: "cad", on: cfg!(feature = "cad"), needs: "the libraries for drawings and solids" },
        Feature { name: "outline", on: cfg!(feature = "outline"), needs: "the libraries for photographs" },
        Feature { name: "parquet", on: cfg!(feature = "parquet"), needs: "the library for Parquet" },
        Feature { name: "log", on: cfg!(feature = "log"), needs: "the decoder of a firmware's log" },
        Feature { name: "terminal", on: cfg!(feature = "terminal"), needs: "the library for a terminal's picture" },
        Feature { name: "probe", on: cfg!(feature = "probe"), needs: "the library for debug probes" },
        Feature { name: "web", on: cfg!(feature = "web"), needs: "the libraries of the live page" },
        Feature { name: "record", on: cfg!(feature = "record"), needs: "the library for recordings" },
        Feature { name: "ros2", on: cfg!(feature = "ros2"), needs: "the library for DDS" },
        Feature {
            name: "python",
            on: cfg!(feature = "python"),
            needs: "the MCAP reader, Eclipse Cyclone DDS, a URDF parser and trimesh for Python",
        },
        Feature { name: "qemu", on: cfg!(feature = "qemu"), needs: "QEMU and the firmware's image" },
        Feature { name: "fea", on: cfg!(feature = "fea"), needs: "CalculiX" },
    ];
    left_out(include_str!("../Cargo.toml"), &features)
}
