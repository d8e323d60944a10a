//! What the view knows of a source.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use messages::{Counters, Grasp, Report};

use crate::shown::Shown;
use crate::source::Statistics;
use crate::source::{Origin, Setup, Told};

/// Seconds of the chart.
pub const WINDOW_S: f64 = 20.0;
/// A point of the chart stands for so long, s; it is the greatest force of this time, so that no peak is lost.
const POINT_S: f64 = 0.05;
/// A source that has sent nothing for so long is silent: what it sent before is struck out.
const SILENT: Duration = Duration::from_millis(400);
/// Events that are kept.
const EVENTS: usize = 16;

/// What the view knows of a source.
#[derive(Debug)]
pub struct Seen {
    /// The source.
    pub setup: Setup,
    /// By number.
    pub fingers: Vec<Finger>,
    /// The whole grasp, if there are several fingers.
    pub grasp: Option<Grasp>,
    /// The last ones, in words, the newest last.
    pub events: VecDeque<String>,
    /// Reports that came.
    pub reports: u64,
    /// Reports a second, lately.
    pub per_second: f64,
    /// The source's.
    pub statistics: Statistics,
    /// The gripper's.
    pub counters: Option<Counters>,
    /// What came of the last stop: acknowledged, or why not yet; none before the first answer.
    pub stop: Option<Result<String, String>>,
    /// Since when a stop is under way that the gripper has not taken.
    pub stopping: Option<Instant>,
    pub(super) heard: Instant,
    second: (Instant, u64),
}

/// What is known of a finger.
#[derive(Debug, Default)]
pub struct Finger {
    /// The report to show.
    pub shown: Shown,
    /// Time (s) and force (N) of trustworthy estimates, at most a point for each [`POINT_S`].
    pub forces: VecDeque<(f64, f64)>,
}

impl Seen {
    /// Of a source from which nothing has come yet.
    pub fn new(setup: Setup) -> Self {
        let now = Instant::now();
        Self {
            setup,
            fingers: Vec::new(),
            grasp: None,
            events: VecDeque::new(),
            reports: 0,
            per_second: 0.0,
            statistics: Statistics::default(),
            counters: None,
            stop: None,
            stopping: None,
            heard: now,
            second: (now, 0),
        }
    }

    /// Takes what was reported.
    pub fn take(&mut self, told: Told) {
        let now = Instant::now();
        self.heard = self.heard.max(now);
        match told {
            Told::Report(report) => {
                self.reports += 1;
                let passed = (now - self.second.0).as_secs_f64();
                if passed >= 1.0 {
                    self.per_second = (self.reports - self.second.1) as f64 / passed;
                    self.second = (now, self.reports);
                }
                self.finger(report.finger).take(report);
            }
            Told::Grasp(grasp) => self.grasp = Some(grasp),
            Told::Event(notice) => {
                self.events.push_back(format!("{:9.3} s  {}", notice.time_us as f64 * 1e-6, notice.event));
                while self.events.len() > EVENTS {
                    self.events.pop_front();
                }
            }
            Told::Setup(setup) => self.setup = *setup,
            Told::Shape(_) => {}
        }
    }

    fn finger(&mut self, number: u8) -> &mut Finger {
        let index = usize::from(number).min(messages::FINGERS - 1);
        if self.fingers.len() <= index {
            self.fingers.resize_with(index + 1, Finger::default);
        }
        &mut self.fingers[index]
    }

    /// How long nothing has come.
    pub fn silence(&self) -> Duration {
        self.heard.elapsed()
    }

    /// How long a source that is live has sent nothing, if that is noteworthy: a slow one reports seldom.
    pub fn silent(&self) -> Option<Duration> {
        let period = Duration::from_secs(1) / u32::from(self.setup.settings.rate_hz.max(1));
        let silence = self.silence();
        (self.setup.origin != Origin::Recording && silence > SILENT.max(5 * period / 2)).then_some(silence)
    }

    /// Whether fingers can be stopped from here.
    pub fn moves(&self) -> bool {
        self.setup.origin == Origin::Gripper
    }

    /// A stop was asked for.
    pub fn asked(&mut self) {
        if self.stopping.is_none() {
            (self.stopping, self.stop) = (Some(Instant::now()), None);
        }
    }

    /// What came of switching the torque off. It does not take the place of a stop that is under way.
    pub fn relaxed(&mut self, words: Result<String, String>) {
        if self.stopping.is_none() {
            self.stop = Some(words);
        }
    }

    /// What came of it; one that was not taken is asked for again.
    pub fn answered(&mut self, words: Result<String, String>) {
        if words.is_ok() {
            self.stopping = None;
        }
        self.stop = Some(words);
    }
}

impl Finger {
    fn take(&mut self, report: Report) {
        let time = report.time_us as f64 * 1e-6;
        if self.shown.take(report) {
            self.forces.clear();
        }
        if report.estimate.status.is_trustworthy() {
            let force = f64::from(report.estimate.force_magnitude());
            match self.forces.back_mut() {
                Some((since, greatest)) if time - *since < POINT_S => *greatest = greatest.max(force),
                _ => self.forces.push_back((time, force)),
            }
        }
        while self.forces.front().is_some_and(|(then, _)| time - then > WINDOW_S) {
            self.forces.pop_front();
        }
    }
}
