//! defmt's log, sent to the host through semihosting: one host call per frame.

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, Ordering};
use critical_section::RestoreState;
use semihosting::io::{Stdout, Write, stdout};

#[defmt::global_logger]
struct Log;

defmt::timestamp!("{=u64:us}", embassy_time::Instant::now().as_micros());

/// Holds most frames whole; longer ones go out in parts.
const BUFFER: usize = 512;

struct Frame {
    taken: AtomicBool,
    inner: UnsafeCell<Inner>,
}

struct Inner {
    restore: RestoreState,
    encoder: defmt::Encoder,
    buffer: [u8; BUFFER],
    used: usize,
    output: Option<Stdout>,
}

// SAFETY: `inner` is touched only between `acquire` and `release`, which span a critical section.
unsafe impl Sync for Frame {}

static FRAME: Frame = Frame {
    taken: AtomicBool::new(false),
    inner: UnsafeCell::new(Inner {
        restore: RestoreState::invalid(),
        encoder: defmt::Encoder::new(),
        buffer: [0; BUFFER],
        used: 0,
        output: None,
    }),
};

/// Whether a frame is being written: a panic inside of one cannot be logged.
pub(crate) fn is_busy() -> bool {
    FRAME.taken.load(Ordering::Relaxed)
}

impl Inner {
    fn frame(&mut self, work: impl FnOnce(&mut defmt::Encoder, &mut dyn FnMut(&[u8]))) {
        let Self { encoder, buffer, used, output, .. } = self;
        work(encoder, &mut |bytes| {
            for byte in bytes {
                if *used == BUFFER {
                    send(output, buffer);
                    *used = 0;
                }
                buffer[*used] = *byte;
                *used += 1;
            }
        });
    }
}

/// A host that does not take the log must not stop the program.
fn send(output: &mut Option<Stdout>, bytes: &[u8]) {
    if output.is_none() {
        *output = stdout().ok();
    }
    if let Some(output) = output {
        let _ = output.write_all(bytes);
    }
}

// SAFETY: `acquire` enters a critical section and `release` leaves it, so there is one writer; a second `acquire` inside of it panics.
unsafe impl defmt::Logger for Log {
    fn acquire() {
        // SAFETY: left in `release`, which defmt calls once for each `acquire`.
        let restore = unsafe { critical_section::acquire() };
        assert!(!FRAME.taken.swap(true, Ordering::Relaxed), "a log frame inside of a log frame");
        // SAFETY: in the critical section, and `taken` was not set.
        let inner = unsafe { &mut *FRAME.inner.get() };
        inner.restore = restore;
        inner.frame(|encoder, write| encoder.start_frame(write));
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: called between `acquire` and the end of this function only.
        let inner = unsafe { &mut *FRAME.inner.get() };
        inner.frame(|encoder, write| encoder.end_frame(write));
        send(&mut inner.output, &inner.buffer[..inner.used]);
        inner.used = 0;
        let restore = inner.restore;
        FRAME.taken.store(false, Ordering::Relaxed);
        // SAFETY: paired with the one in `acquire`.
        unsafe { critical_section::release(restore) };
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: called between `acquire` and `release` only.
        let inner = unsafe { &mut *FRAME.inner.get() };
        inner.frame(|encoder, write| encoder.write(bytes, write));
    }
}
