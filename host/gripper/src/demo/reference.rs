//! A full-resolution model that follows the same path on this PC, in a thread of its own: the stream of estimates is
//! never held. What it has no room for is left out, and counted.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use model_core::design::Design;
use model_core::discretise::Discretisation;
use model_core::object::{Motion, ObjectDesign};

use super::error::DemoError;
use fre::shape::Shape;
use fre::study::follow::follower;
use fre::study::model::Options;

/// Angles that may wait: 16 s at 500 Hz.
const WAITING: usize = 8192;

/// An angle to follow to.
struct Job {
    index: usize,
    position: i32,
    angle: f64,
}

/// What the reference says.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// Number of the sample that was asked for.
    pub index: usize,
    /// Force on the object, world frame, N; none if the reference itself has no trustworthy solution there.
    pub force: Option<[f64; 2]>,
}

/// What is left when the thread has ended.
#[derive(Debug, Default)]
pub struct Followed {
    /// The last deformed finger at every position, counts.
    pub shapes: BTreeMap<i32, Shape>,
    /// Angles that differed from the one before.
    pub steps: u32,
    /// Time that they took.
    pub spent: Duration,
}

/// A reference at work.
pub struct Reference {
    jobs: SyncSender<Job>,
    answers: Receiver<Answer>,
    thread: JoinHandle<Followed>,
    /// Samples that had no room.
    pub left_out: u64,
}

impl Reference {
    /// Begins without contact, at an angle (rad) or before it.
    ///
    /// # Errors
    /// The model cannot be made or finds no place to begin; no thread.
    pub fn spawn(how: &Discretisation, design: &Design, object: ObjectDesign, from: f64) -> Result<Self, DemoError> {
        let options = Options { discretisation: *how, ..Options::default() };
        let motion = Motion::Rotating { axis: design.motor_axis };
        let mut follower = follower::<f64>(design, object, motion, &options).map_err(DemoError::Model)?;
        if !follower.start(from) {
            return Err(DemoError::NoRoom);
        }
        let (jobs, work) = sync_channel::<Job>(WAITING);
        let (done, answers) = channel();
        let follow = move || {
            let mut followed = Followed::default();
            let mut last: Option<(i32, Option<[f64; 2]>)> = None;
            for Job { index, position, angle } in work {
                let force = match last {
                    // The same equilibrium.
                    Some((at, force)) if at == position => force,
                    _ => {
                        let begin = Instant::now();
                        let known = follower.follow(angle).status.is_trustworthy();
                        followed.spent += begin.elapsed();
                        followed.steps += 1;
                        if known {
                            followed.shapes.insert(position, Shape::of(&follower));
                        }
                        known.then(|| follower.solution().force_world())
                    }
                };
                last = Some((position, force));
                if done.send(Answer { index, force }).is_err() {
                    break;
                }
            }
            followed
        };
        let thread = std::thread::Builder::new().name("reference".into()).spawn(follow).map_err(DemoError::System)?;
        Ok(Self { jobs, answers, thread, left_out: 0 })
    }

    /// Asks for the force at a position (counts), that is at an angle (rad).
    pub fn ask(&mut self, index: usize, position: i32, angle: f64) {
        if self.jobs.try_send(Job { index, position, angle }).is_err() {
            self.left_out += 1;
        }
    }

    /// Answers that are there.
    pub fn answers(&self) -> impl Iterator<Item = Answer> + '_ {
        self.answers.try_iter()
    }

    /// Waits for the answers that are missing, but not longer than so; the second is false if the time was up.
    pub fn finish(self, longest: Duration, mut take: impl FnMut(Answer)) -> (Followed, bool) {
        let end = Instant::now() + longest;
        drop(self.jobs);
        loop {
            match self.answers.recv_timeout(end.saturating_duration_since(Instant::now())) {
                Ok(answer) => take(answer),
                Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => break,
                // The thread ends with its next answer, which nobody hears.
                Err(std::sync::mpsc::RecvTimeoutError::Timeout) => return (Followed::default(), false),
            }
        }
        match self.thread.join() {
            Ok(followed) => (followed, true),
            Err(_) => (Followed::default(), false),
        }
    }
}
