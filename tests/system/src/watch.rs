//! Waiting for what a gripper tells, never for ever.

use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use fre_gripper::link::{Link, Told};
use messages::{Event, Grasp, Report, Shape};

/// Listens to a gripper and keeps all it tells.
pub struct Watch {
    told: Receiver<Told>,
    /// Every report so far.
    pub reports: Vec<Report>,
    /// Every grasp so far.
    pub grasps: Vec<Grasp>,
    /// Every shape so far.
    pub shapes: Vec<Shape>,
    /// Every event so far.
    pub events: Vec<Event>,
}

impl Watch {
    /// Listens from now on.
    pub fn new(link: &Link) -> Self {
        Self { told: link.listen(), reports: Vec::new(), grasps: Vec::new(), shapes: Vec::new(), events: Vec::new() }
    }

    /// Listens until something is so; panics with `what` after a time.
    pub fn until(&mut self, what: &str, longest: Duration, mut so: impl FnMut(&Told) -> bool) {
        let end = Instant::now() + longest;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let Ok(told) = self.told.recv_timeout(left) else {
                let (events, last) = (&self.events[self.events.len().saturating_sub(20)..], self.reports.last());
                panic!("no {what} within {longest:?}; last events: {events:?}; last report: {last:?}");
            };
            let done = so(&told);
            match told {
                Told::Report(report) => self.reports.push(report),
                Told::Grasp(grasp) => self.grasps.push(grasp),
                Told::Shape(shape) => self.shapes.push(*shape),
                Told::Event(notice) => self.events.push(notice.event),
                Told::Setup(_) => {}
            }
            if done {
                return;
            }
        }
    }

    /// Listens until a report is so.
    pub fn until_report(&mut self, what: &str, longest: Duration, mut so: impl FnMut(&Report) -> bool) {
        self.until(what, longest, |told| matches!(told, Told::Report(report) if so(report)));
    }

    /// Listens until an event is so.
    pub fn until_event(&mut self, what: &str, longest: Duration, mut so: impl FnMut(&Event) -> bool) {
        self.until(what, longest, |told| matches!(told, Told::Event(notice) if so(&notice.event)));
    }

    /// Listens for a while.
    pub fn pass(&mut self, time: Duration) {
        let end = Instant::now() + time;
        self.until("report", time + Duration::from_secs(5), |_| Instant::now() >= end);
    }
}
