//! Servos on a bus of this PC, estimated here; they are only read.

use fre_gripper::bus::{Bus as Core, BusAddress, BusOptions};
use fre_gripper::link::set;
use fre_gripper::source::{Modelled, Source as _, WAITING};
use messages::{FINGERS, Finger, Settings};
use pyo3::prelude::*;

use crate::case::Case;
use crate::error::{case_error, system, value};
use crate::heard::Heard;
use crate::options::Words;

/// A bus.
#[pyclass(frozen, module = "fre._core")]
pub(crate) struct Bus {
    bus: Core,
    heard: Heard,
}

#[pymethods]
impl Bus {
    /// Opens the port, finds the servos, and begins to estimate.
    #[new]
    fn new(
        py: Python<'_>,
        port: &str,
        cases: Vec<PyRef<'_, Case>>,
        settings: Vec<(String, String)>,
        options: Words,
    ) -> PyResult<Self> {
        let address: BusAddress = port.parse().map_err(|error| value(format!("port: {error}")))?;
        let options = options.options()?;
        let mut all = Settings::DEFAULT;
        for (key, text) in &settings {
            set(&mut all, &format!("{key}={text}")).map_err(|error| case_error(error.to_string(), Some(key), None))?;
        }
        // Before the port is opened and searched.
        all.validate(FINGERS).map_err(|refusal| case_error(format!("settings: {refusal}"), Some("settings"), None))?;
        let names_servos = settings.iter().any(|(key, _)| key.ends_with(".servo_id"));
        let motions: Vec<_> = cases.iter().map(|case| case.case.path.motion).collect();
        BusOptions::check_motions(&all, names_servos, &motions).map_err(|(_, why)| value(why))?;
        let model = |case: &PyRef<'_, Case>| Modelled {
            finger: Some(
                Finger::elastic(case.case.finger.design.clone(), options.discretisation)
                    .relaxing(&case.case.finger.prony),
            ),
            object: Some(case.case.object),
            friction: case.case.friction,
            uncertainty: None,
        };
        let options = BusOptions {
            settings: all,
            names_servos,
            models: cases.iter().map(model).collect(),
            precision: options.precision,
            hessian: options.hessian,
        };
        py.detach(|| {
            let bus = Core::open(&address, &options).map_err(|error| system(&error))?;
            let heard = Heard::new(bus.hear(WAITING)).map_err(|error| system(&error))?;
            Ok(Self { bus, heard })
        })
    }

    /// What makes this bus slower than it could be.
    fn notes(&self) -> Vec<String> {
        self.bus.notes().to_vec()
    }

    /// The next report, event or grasp.
    fn next<'py>(&self, py: Python<'py>, timeout_s: f64) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.heard.next(py, timeout_s)
    }

    /// Messages that came and that nobody has read or will read.
    fn unheard(&self) -> u64 {
        self.heard.unread() + self.bus.statistics().unheard
    }

    /// Whether nothing more comes.
    fn is_closed(&self) -> bool {
        self.bus.is_closed()
    }
}
