//! A gripper behind its link.

use fre_gripper::link::{Address, Link, pairs, set};
use fre_gripper::source::Source as _;
use messages::{Finger, GripTo, Object, Which};
use model_core::discretise::{Discretisation, Physics};
use pyo3::prelude::*;

use crate::case::Case;
use crate::error::{system, value};
use crate::options::word;
use crate::report::Heard;

/// Messages that wait for a listener: a minute of four fingers at 500 Hz.
const WAITING: usize = 1 << 17;

/// A connection to a gripper.
#[pyclass(frozen, module = "fre._core")]
pub(crate) struct Gripper {
    link: Link,
    heard: Heard,
}

fn which(finger: Option<u8>) -> Which {
    finger.map_or(Which::All, Which::One)
}

#[pymethods]
impl Gripper {
    /// Connects.
    #[new]
    fn new(py: Python<'_>, address: &str) -> PyResult<Self> {
        let address: Address = address.parse().map_err(|error| value(format!("address: {error}")))?;
        py.detach(|| {
            let link = Link::open(&address).map_err(|error| system(&error))?;
            let heard = Heard::new(link.hear(WAITING));
            Ok(Self { link, heard })
        })
    }

    /// Who answers, how it started and what it has counted, as JSON.
    fn info(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| {
            let version = self.link.version().map_err(|error| system(&error))?;
            let boot = self.link.boot().map_err(|error| system(&error))?;
            let counters = self.link.counters().map_err(|error| system(&error))?;
            let json = serde_json::json!({ "version": version, "boot": boot, "counters": counters });
            Ok(json.to_string())
        })
    }

    /// Settings by their keys.
    fn settings(&self, py: Python<'_>) -> PyResult<Vec<(String, String)>> {
        py.detach(|| Ok(pairs(&self.link.settings().map_err(|error| system(&error))?)))
    }

    /// Changes settings.
    fn set(&self, py: Python<'_>, changes: Vec<(String, String)>) -> PyResult<()> {
        py.detach(|| {
            let mut settings = self.link.settings().map_err(|error| system(&error))?;
            for (key, text) in changes {
                set(&mut settings, &format!("{key}={text}"))
                    .map_err(|error| crate::error::case_error(error.to_string(), Some(&key), None))?;
            }
            self.link.set_settings(&settings).map_err(|error| system(&error))
        })
    }

    /// Gives a finger the design and the object of a case.
    fn set_case(&self, py: Python<'_>, case: &Case, finger: u8, physics: &str) -> PyResult<()> {
        let physics = word("physics", physics, &[("paper", Physics::Paper), ("extended", Physics::Extended)])?;
        let finger_case = &case.case.finger;
        let design = Finger::elastic(finger_case.design.clone(), Discretisation::estimator(physics))
            .relaxing(&finger_case.prony);
        let object = Object { design: case.case.object, friction: case.case.friction };
        py.detach(|| {
            self.link.set_finger(finger, &design).map_err(|error| system(&error))?;
            self.link.set_object(finger, object).map_err(|error| system(&error))
        })
    }

    /// Closes until a force is reached, and keeps it.
    fn grip(
        &self,
        py: Python<'_>,
        force_n: f32,
        finger: Option<u8>,
        speed_deg_per_s: Option<f32>,
        limit_deg: Option<f32>,
    ) -> PyResult<()> {
        let to = GripTo {
            fingers: which(finger),
            force: force_n,
            speed: speed_deg_per_s.map(f32::to_radians),
            limit: limit_deg.map(f32::to_radians),
        };
        py.detach(|| self.link.grip(&to).map_err(|error| system(&error)))
    }

    /// Closes to a motor angle.
    fn close_to(
        &self,
        py: Python<'_>,
        angle_deg: f32,
        finger: Option<u8>,
        speed_deg_per_s: Option<f32>,
    ) -> PyResult<()> {
        let (angle, speed) = (angle_deg.to_radians(), speed_deg_per_s.map(f32::to_radians));
        py.detach(|| self.link.close(which(finger), angle, speed).map_err(|error| system(&error)))
    }

    /// Opens.
    fn release(&self, py: Python<'_>, finger: Option<u8>) -> PyResult<()> {
        py.detach(|| self.link.open_fingers(which(finger)).map(|_| ()).map_err(|error| system(&error)))
    }

    /// Stays where it is.
    fn hold(&self, py: Python<'_>, finger: Option<u8>) -> PyResult<()> {
        py.detach(|| self.link.hold(which(finger)).map(|_| ()).map_err(|error| system(&error)))
    }

    /// Switches the torque off.
    fn relax(&self, py: Python<'_>, finger: Option<u8>) -> PyResult<()> {
        py.detach(|| self.link.relax(which(finger)).map(|_| ()).map_err(|error| system(&error)))
    }

    /// The next report, event or grasp.
    fn next<'py>(&self, py: Python<'py>, timeout_s: f64) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.heard.next(py, timeout_s)
    }

    /// Whether the other end is gone.
    fn is_closed(&self) -> bool {
        self.link.is_closed()
    }
}
