//! Signs of life. A gripper may stop the motions of a host that is gone (`on_silence`), and knows a host by its requests only.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Thread;
use std::time::Duration;

use super::Source;

/// How often a program that is there asks the gripper something. One sign may be lost in the shortest silence that can be set
/// (`silence_ms`).
pub const SIGN_OF_LIFE: Duration = Duration::from_millis(200);

/// Gives a source signs of life while `work` is done.
pub fn alive<T>(source: &dyn Source, work: impl FnOnce() -> T) -> T {
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let signing = scope.spawn(|| {
            while !over.load(Ordering::Acquire) {
                source.sign();
                std::thread::park_timeout(SIGN_OF_LIFE);
            }
        });
        let _end = End { over: &over, signing: signing.thread().clone() };
        work()
    })
}

/// Ends the signs when it is dropped, also where the work panics.
struct End<'a> {
    over: &'a AtomicBool,
    signing: Thread,
}

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Release);
        self.signing.unpark();
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::atomic::AtomicU32;
    use std::sync::mpsc::Receiver;

    use messages::{Counters, Mount, Settings};

    use super::*;
    use crate::source::{Listeners, Order, OrderError, Setup, Statistics, Told};

    /// A source that counts the signs.
    #[derive(Default)]
    struct Signed(AtomicU32);

    impl Source for Signed {
        fn setup(&self) -> Result<Setup, OrderError> {
            Err(OrderError::Never("a test"))
        }

        fn hear(&self, waiting: usize) -> Receiver<Told> {
            Listeners::default().add(waiting)
        }

        fn statistics(&self) -> Statistics {
            Statistics::default()
        }

        fn counters(&self) -> Result<Option<Counters>, OrderError> {
            Ok(None)
        }

        fn order(&self, _: &Order) -> Result<(), OrderError> {
            Ok(())
        }

        fn is_closed(&self) -> bool {
            false
        }

        fn sign(&self) {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }

    #[test]
    fn signs_are_given_while_something_is_done() {
        let source = Signed::default();
        let signs = || source.0.load(Ordering::Relaxed);
        let done = alive(&source, || {
            while signs() < 4 {
                std::thread::sleep(SIGN_OF_LIFE / 10);
            }
            "done"
        });
        let until_then = signs();
        std::thread::sleep(3 * SIGN_OF_LIFE);
        assert_eq!((done, signs()), ("done", until_then), "none afterwards");
        // A work that panics ends, too.
        assert!(catch_unwind(AssertUnwindSafe(|| alive(&source, || panic!("the work")))).is_err());
    }

    #[test]
    fn one_sign_may_be_lost_in_the_shortest_silence() {
        let settings = |silence_ms| Settings { silence_ms, ..Settings::of(Mount::DEFAULT) };
        let two_signs = 2 * SIGN_OF_LIFE.as_millis() as u16;
        assert!(settings(Settings::DEFAULT.silence_ms).validate(1).is_ok());
        assert!(settings(two_signs).validate(1).is_err(), "{two_signs} ms of silence can be set");
    }
}
