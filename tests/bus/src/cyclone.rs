//! Eclipse Cyclone DDS, which hears a node of ROS 2 and calls its services: an implementation that is not ours.

use std::io::Write as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::Value;

use crate::python::python_with;

/// A running program of Cyclone's Python package.
#[derive(Debug)]
pub struct Cyclone {
    child: Child,
}

impl Cyclone {
    /// Subscribes to everything that a node (`/namespace/name`) with one finger says in a domain, with the quality of service "reliable"
    /// or "best-effort", until it has heard so many forces or the node has gone.
    pub fn subscribe(node: &str, domain: u16, qos: &str, reports: usize) -> Self {
        Self::start(node, domain, "subscribe", &["1", qos, &reports.to_string()])
    }

    /// Calls a node's services one after the other, each call an object of JSON; `mapping` is "basic", "enhanced" or "cyclone".
    ///
    /// # Panics
    /// The program has ended before it had read the calls.
    pub fn call(node: &str, domain: u16, mapping: &str, calls: &[Value]) -> Self {
        let mut caller = Self::start(node, domain, "call", &[mapping]);
        // Closed at the end: there are no more calls.
        let mut stdin = caller.child.stdin.take().expect("a pipe");
        calls.iter().for_each(|call| writeln!(stdin, "{call}").expect("Cyclone reads its calls"));
        caller
    }

    fn start(node: &str, domain: u16, what: &str, rest: &[&str]) -> Self {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("cyclone.py");
        let mut command = Command::new(python_with("cyclonedds"));
        command.arg(script).arg(what).arg(node).args(rest).env("ROS_DOMAIN_ID", domain.to_string());
        let child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("Python starts");
        Self { child }
    }

    /// What it has printed once it has ended: messages or answers.
    ///
    /// # Panics
    /// It has failed.
    pub fn lines(self) -> Vec<Value> {
        let output = self.child.wait_with_output().expect("Python ends");
        assert!(output.status.success(), "Cyclone ended with {}", output.status);
        let text = String::from_utf8(output.stdout).expect("text");
        text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
    }
}
