//! The private module of the Python package `fre`: cases and results as they are in Rust. What a person calls is Python, beside
//! this crate in `fre/`.
//!
//! Results pass as JSON, the text of `fre solve --format json`, and are read when they are looked at; numbers of a whole motion
//! also pass as arrays. Work of more than a few microseconds is done with the interpreter released.

mod batch;
mod bus;
mod calibrate;
mod case;
mod compare;
mod error;
mod estimator;
mod follower;
mod gripper;
mod heard;
mod optimise;
mod options;
mod recording;
mod report;
mod signals;
mod solved;
mod sweep;
mod text;

#[pyo3::pymodule]
mod _core {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::batch::{Made, solve_many};
    #[pymodule_export]
    use super::bus::Bus;
    #[pymodule_export]
    use super::calibrate::{calibrate, count_readings};
    #[pymodule_export]
    use super::case::{Case, preset, presets};
    #[pymodule_export]
    use super::compare::{compare_elements, compare_measured};
    #[pymodule_export]
    use super::error::CaseError;
    #[pymodule_export]
    use super::estimator::Estimator;
    #[pymodule_export]
    use super::follower::Follower;
    #[pymodule_export]
    use super::gripper::Gripper;
    #[pymodule_export]
    use super::optimise::{Problem, measure};
    #[pymodule_export]
    use super::options::check_options;
    #[pymodule_export]
    use super::recording::read_recording;
    #[pymodule_export]
    use super::solved::{Solved, solve};
    #[pymodule_export]
    use super::sweep::{column_kind, merge, sweep, sweep_identity};
    #[pymodule_export]
    use super::text::{from_toml, to_toml};

    /// Version of the package.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        super::error::set_defaults(module.py())
    }
}
