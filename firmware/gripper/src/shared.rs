//! What the tasks have in common: queues, what is set, what was counted.

use core::cell::{Cell, RefCell};
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use crate::alive::Alive;

use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex as Raw;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use heapless::Vec;
use messages::{
    CarryTo, CloseTo, Counters, Event, Finger, FingerFor, Grasp, GripTo, Moved, Notice, Object, ObjectFor, Report,
    ServoSetup, Settings, Shape, UncertaintyFor, Which, frame,
};
use model_core::uncertainty::Uncertainty;

use crate::quiet::Quiet;
use crate::setup::{Key, Place, Setup};

/// Reports that wait for the link: an eighth of a second at 500 Hz, a quarter of it where RAM is scarce.
const REPORTS: usize = if cfg!(feature = "little-ram") { 16 } else { 64 };
/// Grasps that wait for the link; there are none where RAM is scarce, which is where there is one finger.
const GRASPS: usize = if cfg!(feature = "little-ram") { 1 } else { 16 };
/// Shapes that wait for the link.
const SHAPES: usize = 2;
/// Events that wait for the link.
const NOTICES: usize = 16;
/// Requests that wait for the control task.
const COMMANDS: usize = 2;

/// A framed message.
pub(crate) type Frame = Vec<u8, { frame::FRAME }>;

/// What the control task is asked for.
#[derive(Clone, Debug)]
// One or two exist; a box would need a heap.
#[allow(clippy::large_enum_variant)]
pub(crate) enum Command {
    Finger(FingerFor),
    Object(ObjectFor),
    Uncertainty(UncertaintyFor),
    Settings(Settings),
    Open(Which),
    Close(CloseTo),
    Grip(GripTo),
    Carry(CarryTo),
    Hold(Which),
    Relax(Which),
    Scan,
    Hang,
}

/// A command and the number by which its outcome is known.
pub(crate) struct Order {
    pub(crate) ticket: u32,
    pub(crate) command: Command,
}

/// The one setup; nothing until it is first looked at, so that it is all zeros before.
#[derive(Debug)]
struct Kept(Vec<Setup, 1>);

impl Kept {
    fn get(&mut self) -> Option<&mut Setup> {
        if self.0.is_empty() {
            // There is room for one.
            let _ = self.0.push(Setup::DEFAULT);
        }
        self.0.first_mut()
    }
}

/// What the gripper's tasks have in common. One per gripper, in a static. All zeros at first: it takes no room in the image.
pub struct Shared {
    pub(crate) reports: Channel<Raw, Report, REPORTS>,
    pub(crate) grasps: Channel<Raw, Grasp, GRASPS>,
    pub(crate) shapes: Channel<Raw, Shape, SHAPES>,
    pub(crate) notices: Channel<Raw, Notice, NOTICES>,
    pub(crate) answers: Channel<Raw, Frame, 1>,
    pub(crate) orders: Channel<Raw, Order, COMMANDS>,
    /// The last outcome that nobody has taken. (An empty signal of outcomes is not all zeros.)
    outcome: Channel<Raw, (u32, Moved), 1>,
    /// The order that may still be taken up; 0: none.
    open_order: AtomicU32,
    /// Whether a transaction is under way on the bus.
    pub(crate) quiet: Quiet,
    /// When each task was last seen to run.
    pub(crate) alive: Alive,
    /// When the host was last heard, ms since the start; wraps after 49 days.
    heard_host: AtomicU32,
    /// Records to be kept in flash, and whether the last one was.
    pub(crate) keep: Channel<Raw, Key, 1>,
    pub(crate) kept: Signal<Raw, (Key, bool)>,
    /// Records that are to be kept and are not yet.
    unkept: AtomicU32,
    setup: Mutex<Raw, RefCell<Kept>>,
    restored: AtomicBool,
    counters: Mutex<Raw, Cell<Counters>>,
}

impl Default for Shared {
    fn default() -> Self {
        Self::new()
    }
}

impl Shared {
    /// Empty queues, default settings, no finger, no object.
    pub const fn new() -> Self {
        Self {
            reports: Channel::new(),
            grasps: Channel::new(),
            shapes: Channel::new(),
            notices: Channel::new(),
            answers: Channel::new(),
            orders: Channel::new(),
            outcome: Channel::new(),
            open_order: AtomicU32::new(0),
            quiet: Quiet::new(),
            alive: Alive::new(),
            heard_host: AtomicU32::new(0),
            keep: Channel::new(),
            kept: Signal::new(),
            unkept: AtomicU32::new(0),
            setup: Mutex::new(RefCell::new(Kept(Vec::new()))),
            restored: AtomicBool::new(false),
            counters: Mutex::new(Cell::new(Counters {
                uptime_us: 0,
                ticks: 0,
                estimates: 0,
                late_ticks: 0,
                rate_hz: 0.0,
                chosen_hz: 0.0,
                dropped_reports: 0,
                dropped_grasps: 0,
                dropped_shapes: 0,
                dropped_events: 0,
                bus_timeouts: 0,
                bus_damaged: 0,
                bus_refused: 0,
                bus_other: 0,
                bus_foreign: 0,
                servo_losses: 0,
                flash_writes: 0,
                link_frames: 0,
                link_damaged: 0,
                link_oversize: 0,
                latency: 0,
                latency_most: 0,
                answer: 0,
                answer_most: 0,
                late_answers: 0,
            })),
        }
    }

    /// What was counted, up to now.
    pub fn counters(&self) -> Counters {
        Counters { uptime_us: now_us(), ..self.counters.lock(Cell::get) }
    }

    /// Counts something.
    pub(crate) fn count(&self, change: impl FnOnce(&mut Counters)) {
        self.counters.lock(|kept| {
            let mut counters = kept.get();
            change(&mut counters);
            kept.set(counters);
        });
    }

    /// Adds one.
    // Its code is in the image once, and not at each of some twenty callers.
    #[inline(never)]
    pub(crate) fn add(&self, which: fn(&mut Counters) -> &mut u32) {
        self.count(|counters| {
            let counter = which(counters);
            *counter = counter.wrapping_add(1);
        });
    }

    /// Looks at what is set.
    pub(crate) fn setup<R>(&self, look: impl FnOnce(&Setup) -> R) -> R {
        self.setup.lock(|setup| match setup.borrow_mut().get() {
            Some(setup) => look(setup),
            None => look(&Setup::DEFAULT),
        })
    }

    /// Remembers what is set.
    pub(crate) fn set(&self, change: impl FnOnce(&mut Setup)) {
        self.setup.lock(|setup| setup.borrow_mut().get().map(change));
    }

    /// Answers an order; an older answer that nobody waits for any more is forgotten.
    pub(crate) fn answer(&self, ticket: u32, outcome: Moved) {
        self.outcome.clear();
        // There is room for one.
        let _ = self.outcome.try_send((ticket, outcome));
    }

    /// The next answer to an order, and which order.
    pub(crate) async fn answered(&self) -> (u32, Moved) {
        self.outcome.receive().await
    }

    /// A sound request has come from the host.
    pub(crate) fn heard_host(&self) {
        self.heard_host.store((now_us() / 1000) as u32, Ordering::Relaxed);
    }

    /// For how long none has, ms.
    pub(crate) fn host_silence_ms(&self) -> u32 {
        ((now_us() / 1000) as u32).wrapping_sub(self.heard_host.load(Ordering::Relaxed))
    }

    /// An order may be taken up from now on, and no other one.
    pub(crate) fn offer(&self, ticket: u32) {
        self.open_order.store(ticket, Ordering::Release);
    }

    /// Takes an order up, or takes it back: whoever comes first has it, the other one gets false.
    pub(crate) fn claim(&self, ticket: u32) -> bool {
        self.open_order.compare_exchange(ticket, 0, Ordering::AcqRel, Ordering::Acquire).is_ok()
    }

    /// Remembers a finger's design.
    // A copy is on the stack in here only.
    #[inline(never)]
    pub(crate) fn set_design(&self, finger: u8, design: Option<&Finger>) {
        self.set(|setup| {
            if let Some(place) = setup.fingers.get_mut(usize::from(finger)) {
                *place = design.cloned();
            }
        });
    }

    /// Remembers a finger's object.
    pub(crate) fn set_object(&self, finger: u8, object: Object) {
        self.set(|setup| {
            if let Some(place) = setup.objects.get_mut(usize::from(finger)) {
                *place = Some(object);
            }
        });
    }

    /// Remembers what is uncertain of a finger.
    pub(crate) fn set_uncertainty(&self, finger: u8, uncertainty: Option<Uncertainty>) {
        self.set(|setup| {
            if let Some(place) = setup.uncertainties.get_mut(usize::from(finger)) {
                *place = uncertainty;
            }
        });
    }

    /// Remembers how a finger's servo was found set.
    pub(crate) fn set_servo(&self, finger: u8, servo: Option<ServoSetup>) {
        self.set(|setup| {
            if let Some(place) = setup.servos.get_mut(usize::from(finger)) {
                *place = servo;
            }
        });
    }

    /// Whether what is kept in flash was read.
    pub(crate) fn is_restored(&self) -> bool {
        self.restored.load(Ordering::Acquire)
    }

    /// What is kept in flash was read, or there is nothing: the servos may be looked for.
    pub(crate) fn restored(&self) {
        self.restored.store(true, Ordering::Release);
    }

    /// Orders a record to be written to flash.
    pub(crate) async fn keep(&self, key: Key) {
        self.unkept.fetch_add(1, Ordering::AcqRel);
        self.keep.send(key).await;
    }

    /// The same without waiting; false if others wait already.
    pub(crate) fn keep_soon(&self, key: Key) -> bool {
        self.unkept.fetch_add(1, Ordering::AcqRel);
        let taken = self.keep.try_send(key).is_ok();
        if !taken {
            self.unkept.fetch_sub(1, Ordering::AcqRel);
        }
        taken
    }

    /// A record was written, or cannot be.
    pub(crate) fn kept(&self, key: Key, is_kept: bool) {
        self.unkept.fetch_sub(1, Ordering::AcqRel);
        self.kept.signal((key, is_kept));
    }

    /// Whether nothing waits to be written.
    pub(crate) fn is_all_kept(&self) -> bool {
        self.unkept.load(Ordering::Acquire) == 0
    }

    /// Reports the whole grasp to the host, if the link keeps up.
    pub(crate) fn grasp(&self, grasp: Grasp) {
        if self.grasps.try_send(grasp).is_err() {
            self.add(|counters| &mut counters.dropped_grasps);
        }
    }

    /// Reports to the host, if the link keeps up.
    pub(crate) fn report(&self, report: Report) {
        if self.reports.try_send(report).is_err() {
            self.add(|counters| &mut counters.dropped_reports);
        }
    }

    /// Shows the host the finger, if the link keeps up; the shape is made only then.
    pub(crate) fn show(&self, shape: impl FnOnce() -> Shape) {
        if self.shapes.is_full() || self.shapes.try_send(shape()).is_err() {
            self.add(|counters| &mut counters.dropped_shapes);
        }
    }

    /// Reports to host and log that something happened.
    pub(crate) fn tell(&self, event: Event) {
        log!(info, "{}", event);
        if self.notices.try_send(Notice { time_us: now_us(), event }).is_err() {
            self.add(|counters| &mut counters.dropped_events);
        }
    }
}

impl Place for &Shared {
    fn look<R>(&self, look: impl FnOnce(&Setup) -> R) -> R {
        self.setup(look)
    }

    fn change(&mut self, change: impl FnOnce(&mut Setup)) {
        self.set(change);
    }
}

/// Time since the start, µs.
pub(crate) fn now_us() -> u64 {
    embassy_time::Instant::now().as_micros()
}
