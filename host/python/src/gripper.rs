//! A gripper behind its link.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;

use fre::drive::fits_finger;
use fre_gripper::link::{Address, Link, SIGN_OF_LIFE, pairs, set};
use fre_gripper::source::{Order, OrderError, Source as _, WAITING};
use messages::{CloseTo, Finger, GripTo, Object, Which};
use model_core::discretise::{Discretisation, Physics};
use pyo3::prelude::*;

use crate::case::Case;
use crate::error::{system, value};
use crate::heard::Heard;
use crate::options::word;

/// A connection to a gripper.
#[pyclass(frozen, module = "fre._core")]
pub(crate) struct Gripper {
    link: Arc<Link>,
    heard: Heard,
    /// Dropped last: its thread has a share in the link.
    _signs: Signs,
}

/// Signs of life, given until this is dropped: a gripper may stop the motions of a host that is gone (`on_silence`), and a program that waits
/// for a motion asks nothing. The thread never needs the interpreter.
struct Signs {
    stop: Option<SyncSender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Signs {
    fn of(link: Arc<Link>) -> io::Result<Self> {
        let (stop, stopped) = sync_channel(0);
        let thread = std::thread::Builder::new().name("signs of life".into()).spawn(move || {
            // Nothing is sent: the wait is cut short when the sender is dropped.
            let wait = || stopped.recv_timeout(SIGN_OF_LIFE) == Err(RecvTimeoutError::Timeout);
            link.sign();
            while wait() && !link.is_closed() {
                link.sign();
            }
        })?;
        Ok(Self { stop: Some(stop), thread: Some(thread) })
    }
}

impl Drop for Signs {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn which(finger: Option<u8>) -> Which {
    finger.map_or(Which::All, Which::One)
}

impl Gripper {
    /// Gives an order. Reports of before it are not read any more: they say nothing about it.
    fn order(&self, py: Python<'_>, order: &Order) -> PyResult<()> {
        py.detach(|| {
            let obeyed = self.link.order(order);
            // Where a finger has not obeyed, the others have.
            if let Ok(()) | Err(OrderError::Silent(_)) = obeyed {
                self.heard.forget(self.link.counters().map_err(|error| system(&error))?.uptime_us);
            }
            obeyed.map_err(|error| system(&error))
        })
    }
}

#[pymethods]
impl Gripper {
    /// Connects.
    #[new]
    fn new(py: Python<'_>, address: &str) -> PyResult<Self> {
        let address: Address = address.parse().map_err(|error| value(format!("address: {error}")))?;
        py.detach(|| {
            let link = Arc::new(Link::open(&address).map_err(|error| system(&error))?);
            let heard = Heard::new(link.hear(WAITING)).map_err(|error| system(&error))?;
            let signs = Signs::of(link.clone()).map_err(|error| system(&error))?;
            Ok(Self { link, heard, _signs: signs })
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
        let motion = case.case.path.motion;
        py.detach(|| {
            let number = usize::from(finger);
            let settings = self.link.settings().map_err(|error| system(&error))?;
            if let Some(mount) = settings.fingers.get(number).copied().flatten() {
                fits_finger(&motion, &mount.drive, number).map_err(value)?;
            }
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
        self.order(py, &Order::Grip(to))
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
        self.order(py, &Order::Close(CloseTo { fingers: which(finger), angle, speed }))
    }

    /// Opens.
    fn release(&self, py: Python<'_>, finger: Option<u8>) -> PyResult<()> {
        self.order(py, &Order::Open(which(finger)))
    }

    /// Stays where it is.
    fn hold(&self, py: Python<'_>, finger: Option<u8>) -> PyResult<()> {
        self.order(py, &Order::Hold(which(finger)))
    }

    /// Switches the torque off.
    fn relax(&self, py: Python<'_>, finger: Option<u8>) -> PyResult<()> {
        self.order(py, &Order::Relax(which(finger)))
    }

    /// The next report, event or grasp.
    fn next<'py>(&self, py: Python<'py>, timeout_s: f64) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.heard.next(py, timeout_s)
    }

    /// Messages that came and that nobody has read or will read.
    fn unheard(&self) -> u64 {
        self.heard.unread() + self.link.statistics().unheard
    }

    /// Whether the other end is gone.
    fn is_closed(&self) -> bool {
        self.link.is_closed()
    }
}
