//! What a source reports, as messages of ROS 2.

use fre_gripper::source::{Sequence, Setup, Told};
use messages::{FINGERS, Report, Shape};

use crate::certainty::certainty;
use crate::diagnostics::{self, Circumstances, SILENCE_S};
use crate::finger::Finger;
use crate::joint::joint_state;
use crate::marker::markers;
use crate::message::{
    DiagnosticArray, DiagnosticStatus, DynamicJointState, Header, JointState, MarkerArray, Time, WrenchStamped,
};
use crate::wrench::{is_trusted, wrench};

/// Diagnostics are repeated this often; a change is published at once.
const DIAGNOSTICS_NS: u64 = 100_000_000;
/// A finger is drawn at most 30 times a second.
const MARKERS_NS: u64 = 1_000_000_000 / 30;
/// A margin that is older than this does not count any more.
const MARGIN_NS: u64 = 500_000_000;

/// A message on its way out.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// A finger's force.
    Wrench(u8, WrenchStamped),
    /// How far it can be trusted.
    Certainty(u8, DynamicJointState),
    /// A finger's motor.
    Joint(JointState),
    /// A finger's shape.
    Markers(MarkerArray),
    /// Statuses and ages of all fingers.
    Diagnostics(DiagnosticArray),
}

/// Turns what a source reports into messages.
#[derive(Debug)]
pub struct Telling {
    place: String,
    fingers: Vec<Finger>,
    states: [State; FINGERS],
    sequence: Sequence,
    missing: u64,
    event: String,
    /// From one tick to the next, ns.
    tick_ns: u64,
    /// The load that the grip bears in its weakest direction, N, and of what time its contact forces are, ns.
    margin: Option<(f64, u64)>,
    /// When diagnostics were sent last, ns.
    diagnosed_ns: u64,
}

/// What has been reported of a finger.
#[derive(Clone, Copy, Debug, Default)]
struct State {
    report: Option<Report>,
    /// When that report was made, ns.
    ns: u64,
    /// The newest trustworthy one.
    trusted_ns: Option<u64>,
    /// When it was drawn last.
    drawn_ns: Option<u64>,
}

impl State {
    fn age(&self, ns: u64) -> f64 {
        self.trusted_ns.map_or(f64::INFINITY, |then| seconds(then, ns))
    }
}

/// From a time to another one, both in ns, as s; 0 if it is not later.
fn seconds(from: u64, to: u64) -> f64 {
    to.saturating_sub(from) as f64 * 1e-9
}

/// Whether what is done once in a period is due again; so it is where the clock was set back meanwhile.
fn is_due(ns: u64, then: u64, period: u64) -> bool {
    ns.abs_diff(then) >= period
}

fn tick_ns(setup: &Setup) -> u64 {
    1_000_000_000 / u64::from(setup.settings.rate_hz.max(1))
}

impl Telling {
    /// Of a source with this set-up.
    pub fn new(setup: &Setup) -> Self {
        Self {
            place: setup.place.clone(),
            fingers: Finger::all(setup),
            states: Default::default(),
            sequence: Sequence::default(),
            missing: 0,
            event: "none".to_owned(),
            tick_ns: tick_ns(setup),
            margin: None,
            diagnosed_ns: 0,
        }
    }

    /// How many fingers there are.
    pub fn fingers(&self) -> usize {
        self.fingers.len()
    }

    /// Messages of something that was reported; `ns`: its time, since 1970.
    pub fn tell(&mut self, ns: u64, told: &Told) -> Vec<Message> {
        match told {
            Told::Report(report) => self.report(ns, report),
            Told::Shape(shape) => self.shape(ns, shape).into_iter().collect(),
            Told::Event(notice) => {
                self.event = notice.event.to_string();
                Vec::new()
            }
            Told::Setup(setup) => {
                self.place.clone_from(&setup.place);
                self.fingers = Finger::all(setup);
                (self.tick_ns, self.margin) = (tick_ns(setup), None);
                Vec::new()
            }
            Told::Grasp(grasp) => {
                self.margin = grasp.margin.map(|margin| {
                    let then = ns.saturating_sub(u64::from(margin.age) * self.tick_ns);
                    (f64::from(margin.least.min(margin.across)), then)
                });
                Vec::new()
            }
        }
    }

    /// Diagnostics of fingers that have fallen silent, if they are due.
    pub fn silence(&mut self, ns: u64) -> Option<Message> {
        let is_silent = self.states.iter().take(self.fingers.len()).any(|state| seconds(state.ns, ns) > SILENCE_S);
        (is_silent && self.is_diagnosis_due(ns)).then(|| self.diagnostics(ns))
    }

    fn report(&mut self, ns: u64, report: &Report) -> Vec<Message> {
        let number = report.finger;
        self.missing += self.sequence.take(report.sequence).map_or(0, |gap| u64::from(gap.missing));
        let Some(state) = self.states.get_mut(usize::from(number)) else { return Vec::new() };
        let key = |report: &Report| (report.estimate.status, report.phase);
        let changed = state.report.as_ref().map(key) != Some(key(report));
        (state.report, state.ns) = (Some(*report), ns);
        if is_trusted(report) {
            state.trusted_ns = Some(ns);
        }
        let age = state.age(ns);
        let mut messages = Vec::with_capacity(4);
        if let Some(finger) = self.fingers.get(usize::from(number)) {
            let header = |frame_id| Header { stamp: Time::of_ns(ns), frame_id };
            messages.push(Message::Wrench(number, wrench(finger, report, header(finger.frame()))));
            let margin = self.margin.filter(|(_, then)| ns.saturating_sub(*then) < MARGIN_NS).map(|(margin, _)| margin);
            messages.push(Message::Certainty(number, certainty(finger, report, age, margin, header(finger.frame()))));
            messages.extend(joint_state(finger, report, header(String::new())).map(Message::Joint));
        }
        if changed || self.is_diagnosis_due(ns) {
            messages.push(self.diagnostics(ns));
        }
        messages
    }

    fn shape(&mut self, ns: u64, shape: &Shape) -> Option<Message> {
        let number = usize::from(shape.finger);
        let (finger, state) = (self.fingers.get(number)?, self.states.get_mut(number)?);
        if state.drawn_ns.is_some_and(|then| !is_due(ns, then, MARKERS_NS)) {
            return None;
        }
        state.drawn_ns = Some(ns);
        let header = Header { stamp: Time::of_ns(ns), frame_id: finger.frame() };
        Some(Message::Markers(markers(shape, finger.axis?, &header)))
    }

    fn is_diagnosis_due(&self, ns: u64) -> bool {
        is_due(ns, self.diagnosed_ns, DIAGNOSTICS_NS)
    }

    fn diagnostics(&mut self, ns: u64) -> Message {
        self.diagnosed_ns = ns;
        let of = |(finger, state): (&Finger, &State)| -> DiagnosticStatus {
            let about = Circumstances {
                finger: finger.number,
                hardware: &self.place,
                age: state.age(ns),
                silence: state.report.map_or(f64::INFINITY, |_| seconds(state.ns, ns)),
                missing: self.missing,
                event: &self.event,
            };
            diagnostics::status(state.report.as_ref(), &about)
        };
        let status = self.fingers.iter().zip(&self.states).map(of).collect();
        Message::Diagnostics(DiagnosticArray {
            header: Header { stamp: Time::of_ns(ns), frame_id: String::new() },
            status,
        })
    }
}
