//! embassy's executors: one in thread mode, asleep when idle, one in an interrupt for the control task, and one in another interrupt for
//! the bus task. The latter goes before everything but the devices' interrupts.
//!
//! embassy's own thread executor sleeps by WFE, which QEMU treats as "go on": it would keep a PC core busy. WFI really sleeps.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::NVIC;
use embassy_executor::{SendSpawner, Spawner, raw};

use crate::registers::interrupt::{self, Number};

static WOKEN: AtomicBool = AtomicBool::new(false);

/// The control task's executor.
pub(crate) static CONTROL: Interrupting = Interrupting::new(interrupt::CONTROL);
/// The bus task's.
pub(crate) static SERVE: Interrupting = Interrupting::new(interrupt::SERVE);

/// The context by which [`pender`] knows the executor in thread mode; the others have their interrupt's number.
const THREAD: usize = 0;

/// Runs the tasks. Made by `#[embassy_executor::main(executor = "mps2::Executor", entry = "cortex_m_rt::entry")]`.
pub struct Executor {
    inner: raw::Executor,
}

impl Executor {
    /// An executor without tasks. There is one, made once.
    #[allow(clippy::new_without_default)]
    pub fn new() -> Self {
        Self { inner: raw::Executor::new(THREAD as *mut ()) }
    }

    /// Starts the first tasks by `init` and runs for ever.
    pub fn run(&'static mut self, init: impl FnOnce(Spawner)) -> ! {
        init(self.inner.spawner());
        loop {
            // SAFETY: the executor is 'static, was initialised by `spawner`, and `poll` is called from here only, never from
            // `__pender`.
            unsafe { self.inner.poll() };
            critical_section::with(|_| {
                // A wake-up from here on is an interrupt, which ends WFI even while masked.
                if !WOKEN.swap(false, Ordering::Relaxed) {
                    cortex_m::asm::wfi();
                }
            });
        }
    }
}

/// An executor that runs in an interrupt which software raises.
pub(crate) struct Interrupting {
    number: u16,
    started: AtomicBool,
    inner: UnsafeCell<MaybeUninit<raw::Executor>>,
}

// SAFETY: written once, in `start`, before its interrupt is let through; from then on shared references only.
unsafe impl Sync for Interrupting {}

impl Interrupting {
    const fn new(number: u16) -> Self {
        Self { number, started: AtomicBool::new(false), inner: UnsafeCell::new(MaybeUninit::uninit()) }
    }

    pub(crate) fn on_interrupt(&'static self) {
        if self.started.load(Ordering::Acquire) {
            // SAFETY: initialised before `started` was set; polled from this interrupt only, which does not interrupt itself.
            unsafe { (*self.inner.get()).assume_init_ref().poll() };
        }
    }

    fn start(&'static self) -> SendSpawner {
        assert!(!self.started.load(Ordering::Relaxed), "an executor is started once");
        // SAFETY: nobody else looks at it before `started` is set.
        let inner = unsafe { (*self.inner.get()).write(raw::Executor::new(usize::from(self.number) as *mut ())) };
        let spawner = inner.spawner().make_send();
        self.started.store(true, Ordering::Release);
        // SAFETY: its handler is `on_interrupt`; no critical section of ours works by masking single interrupts.
        unsafe { NVIC::unmask(Number(self.number)) };
        spawner
    }
}

/// Where the control task is started: it interrupts all other tasks but the bus task.
pub fn for_control() -> SendSpawner {
    CONTROL.start()
}

/// Where the bus task is started: it interrupts all other tasks.
pub fn for_serving() -> SendSpawner {
    SERVE.start()
}

// SAFETY: embassy declares this symbol with this signature.
#[unsafe(export_name = "__pender")]
fn pender(context: *mut ()) {
    match context as usize {
        THREAD => WOKEN.store(true, Ordering::Relaxed),
        // One of the two above.
        number => NVIC::pend(Number(number as u16)),
    }
}
