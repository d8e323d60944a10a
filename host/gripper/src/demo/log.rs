//! What was reported, with what the references say to it, while it comes.

use messages::Report;
use model_core::status::Status;

use super::reference::{Answer, Reference};
use super::sample::{Sample, Way};
use crate::link::Told;
use crate::servo::Config;

/// What was reported, with what the references say to it.
pub(super) struct Log {
    pub(super) servo: Config,
    pub(super) samples: Vec<Sample>,
    /// The trustworthy shape with the greatest force, and that force.
    pub(super) shape: Option<(messages::Shape, f64)>,
    pub(super) shapes: u64,
    /// Samples up to here have both answers, or will have none.
    pub(super) answered: usize,
}

impl Log {
    pub(super) fn new(servo: Config) -> Self {
        Self { servo, samples: Vec::new(), shape: None, shapes: 0, answered: 0 }
    }

    pub(super) fn take(&mut self, told: Told, references: &mut [Reference; 2]) {
        match told {
            Told::Report(report) => self.report(report, references),
            Told::Shape(shape) => {
                self.shapes += 1;
                let (mut x, mut y) = (0.0, 0.0);
                shape.contacts.iter().for_each(|contact| (x, y) = (x + contact.force[0], y + contact.force[1]));
                let force = f64::from(x.hypot(y));
                if shape.status.is_trustworthy() && self.shape.as_ref().is_none_or(|(_, best)| force > *best) {
                    self.shape = Some((*shape, force));
                }
            }
            // They are in the firmware's log.
            Told::Event(_) | Told::Grasp(_) | Told::Setup(_) => {}
        }
    }

    fn report(&mut self, report: Report, references: &mut [Reference; 2]) {
        let angle = self.servo.angle(f64::from(report.position));
        let last = self.samples.last();
        let before = last.map_or((Way::Closing, 1), |last| (last.way, last.cycle));
        let moved = last.map_or(0, |last| report.position - last.report.position);
        let (way, cycle) = match before {
            (Way::Opening, cycle) if moved > 0 => (Way::Closing, cycle + 1),
            (Way::Closing, cycle) if moved < 0 => (Way::Opening, cycle),
            same => same,
        };
        let first_us = self.samples.first().map_or(report.time_us, |first| first.report.time_us);
        let index = self.samples.len();
        self.samples.push(Sample {
            report,
            time_s: report.time_us.saturating_sub(first_us) as f64 * 1e-6,
            angle_deg: angle.to_degrees(),
            way,
            cycle,
            references: [None; 2],
        });
        // A stale report has no angle of its own.
        if report.estimate.status != Status::Stale {
            references.iter_mut().for_each(|reference| reference.ask(index, report.position, angle));
        }
    }

    pub(super) fn answer(&mut self, which: usize, answer: Answer) {
        if let Some(sample) = self.samples.get_mut(answer.index) {
            sample.references[which] = answer.force;
        }
    }

    /// The latest sample with both answers; if there is none for a while, the latest one.
    pub(super) fn answered(&mut self, now: f64) -> Option<&Sample> {
        let both = |sample: &Sample| sample.references.iter().all(Option::is_some);
        let fresh = self.samples[self.answered..].iter().rposition(both);
        if let Some(fresh) = fresh {
            self.answered += fresh;
        }
        match fresh {
            Some(_) => self.samples.get(self.answered),
            // The references take a moment to begin.
            None => self.samples.last().filter(|_| now > 1.0),
        }
    }

    pub(super) fn unanswered(&self, which: usize) -> u64 {
        self.samples.iter().filter(|sample| sample.is_fresh() && sample.references[which].is_none()).count() as u64
    }
}
