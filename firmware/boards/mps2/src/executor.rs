//! embassy's executor in thread mode, asleep when idle.
//!
//! embassy's own one sleeps by WFE, which QEMU treats as "go on": it would keep a PC core busy. WFI really sleeps.

use core::sync::atomic::{AtomicBool, Ordering};
use embassy_executor::{Spawner, raw};

static WOKEN: AtomicBool = AtomicBool::new(false);

/// Runs the tasks. Made by `#[embassy_executor::main(executor = "mps2::Executor", entry = "cortex_m_rt::entry")]`.
pub struct Executor {
    inner: raw::Executor,
}

impl Executor {
    /// An executor without tasks. There is one, made once.
    #[allow(clippy::new_without_default)]
    pub fn new() -> Self {
        Self { inner: raw::Executor::new(core::ptr::null_mut()) }
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

// SAFETY: embassy declares this symbol with this signature.
#[unsafe(export_name = "__pender")]
fn pender(_context: *mut ()) {
    WOKEN.store(true, Ordering::Relaxed);
}
