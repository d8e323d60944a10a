//! A recording as a source: played in its own time, faster, or at once.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use messages::Counters;

use super::again::{Again, AgainError};
use super::pace::{Pace, Speed};
use super::{Damage, RecordError, Recorded, Recording};
use crate::source::Statistics;
use crate::source::{Listeners, Order, OrderError, Origin, Setup, Source, Told};

/// How often is looked whether somebody listens.
const GLANCE: Duration = Duration::from_millis(20);

/// A recording that is played as soon as somebody listens.
pub struct Playback {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    listeners: Listeners,
    setup: Mutex<Setup>,
    messages: AtomicU64,
    missing: AtomicU64,
    damages: Mutex<Vec<Damage>>,
    stop: AtomicBool,
    closed: AtomicBool,
    /// Why it ended before its end.
    failed: Mutex<Option<String>>,
}

/// Why a recording cannot be played.
#[derive(Debug, thiserror::Error)]
pub enum PlayError {
    /// The file.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The estimator.
    #[error(transparent)]
    Again(#[from] AgainError),
    /// Its first message is not a set-up.
    #[error("{0}: it does not begin with a set-up; was it recorded by fre?")]
    NoSetup(String),
    /// The part with the set-up is damaged.
    #[error("{file}: {damage}, and the set-up was there")]
    Damaged {
        /// Which file.
        file: String,
        /// Where.
        damage: Damage,
    },
    /// No thread.
    #[error("the recording cannot be played: {0}")]
    Start(#[source] std::io::Error),
}

/// The set-up with which a recording begins.
///
/// # Errors
/// The file's, or it begins with something else.
pub fn beginning(path: &Path, recording: &mut Recording) -> Result<Setup, PlayError> {
    match recording.next().transpose()? {
        Some((_, Recorded::Told(Told::Setup(setup)))) => Ok(*setup),
        Some((_, Recorded::Damage(damage))) => Err(PlayError::Damaged { file: path.display().to_string(), damage }),
        _ => Err(PlayError::NoSetup(path.display().to_string())),
    }
}

impl Playback {
    /// Opens a recording; with `again`, its estimates are made anew.
    ///
    /// # Errors
    /// The file's, or what the estimator refuses.
    pub fn open(path: &Path, speed: Speed, mut again: Option<Again>) -> Result<Self, PlayError> {
        let mut recording = Recording::open(path)?;
        let mut setup = beginning(path, &mut recording)?;
        if let Some(again) = &mut again {
            setup = again.set_up(&setup)?;
        }
        setup.origin = Origin::Recording;
        setup.place = format!("{} of {}", path.display(), setup.place);
        let shared = Arc::new(Shared::new(setup));
        let for_thread = shared.clone();
        let thread = std::thread::Builder::new().name("playback".into());
        let thread = thread.spawn(move || for_thread.play(recording, speed, again)).map_err(PlayError::Start)?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Parts of the file that could not be read so far.
    pub fn damages(&self) -> Vec<Damage> {
        lock(&self.shared.damages).clone()
    }

    /// Why it ended before the recording's end, if it did.
    pub fn failed(&self) -> Option<String> {
        lock(&self.shared.failed).clone()
    }
}

fn lock<X>(mutex: &Mutex<X>) -> MutexGuard<'_, X> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    fn new(setup: Setup) -> Self {
        Self {
            listeners: Listeners::default(),
            setup: Mutex::new(setup),
            messages: AtomicU64::new(0),
            missing: AtomicU64::new(0),
            damages: Mutex::default(),
            stop: AtomicBool::new(false),
            closed: AtomicBool::new(false),
            failed: Mutex::new(None),
        }
    }

    fn play(&self, recording: Recording, speed: Speed, again: Option<Again>) {
        let _end = End(self);
        while self.listeners.is_empty() && !self.stop.load(Ordering::Acquire) {
            std::thread::sleep(GLANCE);
        }
        if let Err(why) = self.tell_all(recording, speed, again) {
            *lock(&self.failed) = Some(why);
        }
    }

    fn tell_all(&self, recording: Recording, speed: Speed, mut again: Option<Again>) -> Result<(), String> {
        let mut pace = Pace::new(speed);
        let mut last = [None; messages::FINGERS];
        for recorded in recording {
            let (ns, recorded) = recorded.map_err(|error| error.to_string())?;
            pace.wait(ns, &self.stop);
            if self.stop.load(Ordering::Acquire) {
                return Ok(());
            }
            let mut told = match recorded {
                Recorded::Told(told) => told,
                Recorded::Gap(gap) => {
                    self.missing.fetch_add(u64::from(gap.missing), Ordering::Relaxed);
                    continue;
                }
                Recorded::Damage(damage) => {
                    lock(&self.damages).push(damage);
                    continue;
                }
            };
            if let Some(again) = &mut again {
                match &mut told {
                    Told::Report(report) => {
                        *report = again.report(report);
                        if let Some(place) = last.get_mut(usize::from(report.finger)) {
                            *place = Some(*report);
                        }
                    }
                    Told::Shape(shape) => {
                        let report = last.get(usize::from(shape.finger)).copied().flatten();
                        if let Some(new) = report.and_then(|report| again.shape(&report)) {
                            **shape = new;
                        }
                    }
                    Told::Setup(setup) => **setup = again.set_up(setup).map_err(|error| error.to_string())?,
                    // The sum of forces that are others now.
                    Told::Grasp(_) => continue,
                    Told::Event(_) => {}
                }
            }
            if let Told::Setup(new) = &mut told {
                let mut setup = lock(&self.setup);
                (new.origin, new.place) = (setup.origin, setup.place.clone());
                *setup = (**new).clone();
            }
            self.messages.fetch_add(1, Ordering::Relaxed);
            self.listeners.tell_patiently(&told, &self.stop);
        }
        Ok(())
    }
}

/// Ends the recording for all listeners when its thread ends, also by a panic: they would wait for ever.
struct End<'a>(&'a Shared);

impl Drop for End<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            *lock(&self.0.failed) = Some("the recording was not played to its end: a fault of this program".to_owned());
        }
        self.0.closed.store(true, Ordering::Release);
        self.0.listeners.close();
    }
}

impl Source for Playback {
    fn setup(&self) -> Result<Setup, OrderError> {
        Ok(lock(&self.shared.setup).clone())
    }

    fn hear(&self, waiting: usize) -> Receiver<Told> {
        self.shared.listeners.add(waiting)
    }

    fn statistics(&self) -> Statistics {
        let now = |count: &AtomicU64| count.load(Ordering::Relaxed);
        Statistics {
            frames: now(&self.shared.messages),
            missing_reports: now(&self.shared.missing),
            ..Statistics::default()
        }
    }

    fn counters(&self) -> Result<Option<Counters>, OrderError> {
        Ok(None)
    }

    fn order(&self, _: &Order) -> Result<(), OrderError> {
        Err(OrderError::Never("this is a recording: nothing of it can be changed"))
    }

    fn is_closed(&self) -> bool {
        self.shared.closed.load(Ordering::Acquire)
    }
}

impl Drop for Playback {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{PROTOCOL_VERSION, Settings};

    #[test]
    fn a_panic_ends_the_recording_for_its_listeners() {
        let setup = Setup {
            origin: Origin::Recording,
            place: "a test".to_owned(),
            board: "bench".to_owned(),
            firmware: "1.2.3".to_owned(),
            protocol: PROTOCOL_VERSION,
            cost_hz: 1,
            settings: Settings::DEFAULT,
            models: Vec::new(),
        };
        let shared = Arc::new(Shared::new(setup));
        let heard = shared.listeners.add(1);
        let for_thread = shared.clone();
        let thread = std::thread::spawn(move || {
            let _end = End(&for_thread);
            panic!("on purpose");
        });
        assert!(thread.join().is_err());
        assert_eq!(heard.iter().count(), 0, "the channel has ended");
        assert!(shared.closed.load(Ordering::Acquire));
        assert!(lock(&shared.failed).as_ref().is_some_and(|why| why.contains("not played to its end")));
    }
}
