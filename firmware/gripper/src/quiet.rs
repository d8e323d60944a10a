//! Moments without a transaction on the bus, for what holds the processor.
//!
//! Where program and settings share a bank of flash nothing can be fetched while the settings are written. In the middle of a transaction
//! that would keep a servo's answer from its reader until it counts as lost. So a write waits for such a moment, one unit or sector at a
//! time, and holds the control task back for as long as it takes.

use core::cell::Cell;
use core::future::poll_fn;
use core::sync::atomic::{AtomicBool, Ordering};
use core::task::Poll;

use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex as Raw;
use embassy_sync::signal::Signal;
use embassy_sync::waitqueue::AtomicWaker;
use embassy_time::Instant;

/// For how long the processor may be held without further ado, µs: what comes meanwhile is stamped as late as port and scheduler may make it
/// anyway (`stm32::BUS_LATENCY_US`).
const UNNOTICED_US: u64 = 500;

/// Whether a transaction is under way. All zeros at first.
pub(crate) struct Quiet {
    asking: Mutex<Raw, Cell<bool>>,
    /// Somebody waits for a moment without one.
    wanted: AtomicBool,
    over: AtomicWaker,
    /// The processor was held for longer than [`UNNOTICED_US`].
    held: Signal<Raw, ()>,
}

/// A transaction, until it is dropped.
pub(crate) struct Asking<'a>(&'a Quiet);

impl Quiet {
    /// Nobody asks.
    pub(crate) const fn new() -> Self {
        Self {
            asking: Mutex::new(Cell::new(false)),
            wanted: AtomicBool::new(false),
            over: AtomicWaker::new(),
            held: Signal::new(),
        }
    }

    /// A transaction begins.
    pub(crate) fn ask(&self) -> Asking<'_> {
        self.asking.lock(|asking| asking.set(true));
        Asking(self)
    }

    /// Does something as soon as no transaction is under way; none begins before it is done.
    pub(crate) async fn when<R>(&self, mut act: impl FnMut() -> R) -> R {
        let _wanting = Wanting::begin(&self.wanted);
        poll_fn(|context| {
            self.over.register(context.waker());
            self.asking.lock(|asking| {
                if asking.get() {
                    return Poll::Pending;
                }
                let begun = Instant::now();
                let done = act();
                // Before anybody else runs: what has come meanwhile must not be taken for new.
                self.has_held(begun);
                Poll::Ready(done)
            })
        })
        .await
    }

    /// The processor was held since then.
    #[inline(never)]
    fn has_held(&self, begun: Instant) {
        if begun.elapsed().as_micros() > UNNOTICED_US {
            self.held.signal(());
        }
    }

    /// Waits until the processor was held for long enough that nobody knows when what waits has come.
    pub(crate) async fn held(&self) {
        self.held.wait().await;
    }

    /// Whether somebody waits for a moment without a transaction.
    pub(crate) fn is_wanted(&self) -> bool {
        self.wanted.load(Ordering::Relaxed)
    }
}

impl Drop for Asking<'_> {
    fn drop(&mut self) {
        self.0.asking.lock(|asking| asking.set(false));
        self.0.over.wake();
    }
}

/// Somebody waits, until this is dropped.
struct Wanting<'a>(&'a AtomicBool);

impl<'a> Wanting<'a> {
    fn begin(wanted: &'a AtomicBool) -> Self {
        wanted.store(true, Ordering::Relaxed);
        Self(wanted)
    }
}

impl Drop for Wanting<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use core::future::Future;
    use core::pin::pin;
    use core::task::{Context, Waker};

    use embassy_futures::{block_on, poll_once};
    use embassy_time::{Duration, MockDriver};
    use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};

    use super::*;
    use crate::setup::Key;
    use crate::setup::Setup;
    use crate::store::Store;

    #[test]
    fn what_holds_the_processor_waits_for_a_transaction_to_end() {
        let (quiet, done) = (Quiet::new(), Cell::new(0));
        let act = || {
            done.set(done.get() + 1);
            done.get()
        };
        let context = &mut Context::from_waker(Waker::noop());
        let asking = quiet.ask();
        let mut waiting = pin!(quiet.when(act));
        for _ in 0..3 {
            assert_eq!((waiting.as_mut().poll(context), done.get()), (Poll::Pending, 0));
        }
        drop(asking);
        assert!(quiet.is_wanted());
        assert_eq!((waiting.as_mut().poll(context), done.get()), (Poll::Ready(1), 1));
        assert!(!quiet.is_wanted());
        let mut at_once = pin!(quiet.when(act));
        assert_eq!(at_once.as_mut().poll(context), Poll::Ready(2));
    }

    /// Flash that counts its changes.
    struct Flash<'a>(Vec<u8>, &'a Cell<u32>);

    impl ErrorType for Flash<'_> {
        type Error = NorFlashErrorKind;
    }

    impl ReadNorFlash for Flash<'_> {
        const READ_SIZE: usize = 1;

        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
            bytes.copy_from_slice(&self.0[offset as usize..][..bytes.len()]);
            Ok(())
        }

        fn capacity(&self) -> usize {
            self.0.len()
        }
    }

    impl NorFlash for Flash<'_> {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = 4096;

        fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
            self.1.set(self.1.get() + 1);
            self.0[from as usize..to as usize].fill(0xFF);
            Ok(())
        }

        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
            self.1.set(self.1.get() + 1);
            self.0[offset as usize..][..bytes.len()].copy_from_slice(bytes);
            Ok(())
        }
    }

    #[test]
    fn settings_are_written_between_transactions() {
        static QUIET: Quiet = Quiet::new();
        let (changes, setup) = (Cell::new(0), Setup::DEFAULT);
        let mut place = heapless::Vec::new();
        let store = Store::begun(&mut place, Flash(std::vec![0xFF; 4 * 4096], &changes)).unwrap();
        store.wait_for(&QUIET);
        let context = &mut Context::from_waker(Waker::noop());
        {
            let asking = QUIET.ask();
            let mut keeping = pin!(store.keep(Key::Settings, &setup));
            for _ in 0..3 {
                assert!(keeping.as_mut().poll(context).is_pending());
            }
            assert_eq!(changes.get(), 0);
            drop(asking);
            assert_eq!(keeping.as_mut().poll(context), Poll::Ready(Ok(())));
        }
        assert!(changes.get() > 0);
        let mut back = Setup::DEFAULT;
        assert_eq!(block_on(store.restore(&mut back)).records, 1);
    }

    /// Only what holds the processor for a while is noticed: by then nobody knows when what waits on the bus has come.
    #[test]
    fn a_processor_that_was_held_is_noticed() {
        let quiet = Quiet::new();
        block_on(quiet.when(|| MockDriver::get().advance(Duration::from_micros(UNNOTICED_US + 1))));
        assert!(quiet.held.signaled());
        assert_eq!(poll_once(quiet.held()), Poll::Ready(()));
        assert!(!quiet.held.signaled(), "once");
    }

    #[test]
    fn the_end_of_a_transaction_wakes_who_waits() {
        use std::sync::Arc;
        use std::sync::atomic::{AtomicU32, Ordering};
        struct Count(AtomicU32);
        impl std::task::Wake for Count {
            fn wake(self: Arc<Self>) {
                self.0.fetch_add(1, Ordering::Relaxed);
            }
        }
        let (quiet, count) = (Quiet::new(), Arc::new(Count(AtomicU32::new(0))));
        let waker = Waker::from(count.clone());
        let asking = quiet.ask();
        let mut waiting = pin!(quiet.when(|| ()));
        assert!(waiting.as_mut().poll(&mut Context::from_waker(&waker)).is_pending());
        assert_eq!(count.0.load(Ordering::Relaxed), 0);
        drop(asking);
        assert_eq!(count.0.load(Ordering::Relaxed), 1);
    }
}
