//! embassy's clock: microseconds from the FPGA's counter, alarms from CMSDK timer 0.

use crate::registers::{CLOCK_HZ, fpga, timer0};
use core::cell::{Cell, RefCell};
use core::task::Waker;
use critical_section::{CriticalSection, Mutex};
use embassy_time_driver::{Driver, TICK_HZ, time_driver_impl};
use embassy_time_queue_utils::Queue;

const CYCLES_PER_TICK: u32 = CLOCK_HZ / TICK_HZ as u32;
/// The longest alarm. It fits the timer (171 s at 25 MHz), and far within the counter's 71 minutes the clock is read again, so
/// that no wraparound is missed.
const LONGEST_ALARM_TICKS: u64 = 60 * TICK_HZ;

struct Clock {
    /// The counter when last read, and how often it had wrapped.
    last: Mutex<Cell<(u32, u32)>>,
    queue: Mutex<RefCell<Queue>>,
}

time_driver_impl!(static CLOCK: Clock = Clock {
    last: Mutex::new(Cell::new((0, 0))),
    queue: Mutex::new(RefCell::new(Queue::new())),
});

impl Clock {
    fn now_in(&self, cs: CriticalSection<'_>) -> u64 {
        let cell = self.last.borrow(cs);
        let (last, wraps) = cell.get();
        let count = fpga::COUNTER.read();
        let wraps = if count < last { wraps.wrapping_add(1) } else { wraps };
        cell.set((count, wraps));
        u64::from(wraps) << 32 | u64::from(count)
    }

    /// Wakes what is due and sets the alarm for what is next.
    fn serve(&self, cs: CriticalSection<'_>, queue: &mut Queue) {
        let now = self.now_in(cs);
        let next = queue.next_expiration(now);
        let wait = next.saturating_sub(now).clamp(1, LONGEST_ALARM_TICKS) as u32 * CYCLES_PER_TICK;
        timer0::CONTROL.write(0);
        timer0::INTERRUPT_CLEAR.write(1);
        timer0::RELOAD.write(wait);
        timer0::VALUE.write(wait);
        timer0::CONTROL.write(1 << 3 | 1);
    }
}

impl Driver for Clock {
    fn now(&self) -> u64 {
        critical_section::with(|cs| self.now_in(cs))
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        critical_section::with(|cs| {
            let mut queue = self.queue.borrow(cs).borrow_mut();
            if queue.schedule_wake(at, waker) {
                self.serve(cs, &mut queue);
            }
        });
    }
}

/// Starts the clock at zero.
pub(crate) fn start() {
    critical_section::with(|cs| {
        fpga::PRESCALE.write(CYCLES_PER_TICK - 1);
        fpga::COUNTER.write(0);
        CLOCK.last.borrow(cs).set((0, 0));
        CLOCK.serve(cs, &mut CLOCK.queue.borrow(cs).borrow_mut());
    });
}

pub(crate) fn on_interrupt() {
    critical_section::with(|cs| CLOCK.serve(cs, &mut CLOCK.queue.borrow(cs).borrow_mut()));
}

/// Moves the clock forward to `micros` before the counter's next wraparound (after 71 minutes), for tests of just that.
pub fn skip_to_wraparound(micros: u32) {
    critical_section::with(|cs| {
        CLOCK.now_in(cs);
        let (_, wraps) = CLOCK.last.borrow(cs).get();
        let count = u32::MAX - micros;
        fpga::COUNTER.write(count);
        CLOCK.last.borrow(cs).set((count, wraps));
        CLOCK.serve(cs, &mut CLOCK.queue.borrow(cs).borrow_mut());
    });
}
