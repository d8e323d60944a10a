//! The gripper's own program on this PC, in a time of its own: its tasks over a bus with a simulated servo, a link,
//! and flash, all in one thread. Nothing depends on how fast this PC is, an hour takes a minute, and every run is the same.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::future::Future;
use std::pin::Pin;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Wake, Waker};

use embassy_time::{Duration, MockDriver};
use fre_gripper::servo::{Clock, Config, Servo, Truth};
use gripper::{Board, Boot, LastWords, Model, ResetCause, Shared};
use messages::frame::{Decoder, FRAME, MESSAGE, encode, message};
use messages::{EstimateTopic, Event, EventTopic, Notice, Report};
use postcard_rpc::header::{VarHeader, VarKey, VarSeq};
use postcard_rpc::{Endpoint, Topic, postcard};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::flash::Flash;
use crate::line::{Line, Port, Shelf, give};

/// Time passes in steps of this, µs.
pub const STEP_US: u64 = 100;
/// Polls at one instant after which the program counts as hanging.
const HANGS: u32 = 100_000;
/// Bytes that the link holds on its way to the host.
const LINK: usize = 2048;

/// What an estimate costs, µs, and the clock that tells it: every look at it is that much later than the last one.
static COST: AtomicU32 = AtomicU32::new(0);
static CLOCK: AtomicU32 = AtomicU32::new(0);

/// There is one clock.
static TURN: Mutex<()> = Mutex::new(());

/// What stands for a board.
struct OnPc;

impl Board for OnPc {
    type Bus = Port;
    type Flash = Flash;
    type Watchdog = Dog;
    const NAME: &'static str = "bench";
    const FINGERS: usize = 4;
    const BUS_LATENCY_US: u32 = 300;
    const ANSWER_US: u32 = 0;
    const COST_HZ: u32 = 1_000_000;
    const WATCHDOG_MS: u32 = 1_000;
    // The virtual board's does: both ways are tested.
    const FLASH_STALLS: bool = false;

    fn cost_ticks() -> u32 {
        CLOCK.fetch_add(COST.load(Ordering::Relaxed), Ordering::Relaxed)
    }

    fn restart(last_words: &'static str) -> ! {
        panic!("the program restarts itself: {last_words}");
    }
}

/// A watchdog that remembers its longest fast.
struct Dog {
    fed: Rc<RefCell<Fed>>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Fed {
    last_us: u64,
    longest_us: u64,
}

impl gripper::Watchdog for Dog {
    fn feed(&mut self) {
        let mut fed = self.fed.borrow_mut();
        let now = embassy_time::Instant::now().as_micros();
        fed.longest_us = fed.longest_us.max(now - fed.last_us);
        fed.last_us = now;
    }
}

struct Flag(AtomicBool);

impl Wake for Flag {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Release);
    }
}

struct Task {
    future: Pin<Box<dyn Future<Output = ()>>>,
    woken: Arc<Flag>,
    waker: Waker,
}

impl Task {
    fn new(future: impl Future<Output = ()> + 'static) -> Self {
        let woken = Arc::new(Flag(AtomicBool::new(true)));
        let waker = Waker::from(woken.clone());
        Self { future: Box::pin(future), woken, waker }
    }
}

/// What becomes of bytes on the bus; the flag says whether they go to the servo.
pub type Meddling = Box<dyn FnMut(bool, Vec<u8>) -> Vec<u8>>;

/// A gripper with its servo.
pub struct Bench {
    /// The first finger's servo on the bus.
    pub servo: Servo,
    /// Those of the other fingers.
    pub others: Vec<Servo>,
    /// Every report the host has heard, with what was true of its finger when the servo's answer began.
    pub reports: Vec<(Report, Truth)>,
    /// Every event the host has heard.
    pub events: Vec<Event>,
    /// What becomes of bytes on the bus.
    pub meddling: Meddling,
    /// Whether the host listens.
    pub listens: bool,
    /// Whether the reports are kept, or only looked at by [`Bench::run_with`].
    pub keeps: bool,
    tasks: Vec<Task>,
    now_us: u64,
    /// When the microcontroller started.
    started_us: u64,
    bus: [Shelf; 2],
    link: [Shelf; 2],
    /// Answers on their way: when, whose and what.
    coming: Vec<(u64, usize, Vec<u8>)>,
    said: Vec<Truth>,
    decoder: Box<Decoder>,
    answers: VecDeque<(VarHeader, Vec<u8>)>,
    sequence: u32,
    fed: Rc<RefCell<Fed>>,
    _turn: MutexGuard<'static, ()>,
}

impl Bench {
    /// Switches it on. Its servo's clock is the bench's.
    pub fn new(servo: Config, flash: &Flash) -> Self {
        Self::of(servo, Vec::new(), flash)
    }

    /// The same with several servos: the first finger's, and the others'.
    pub fn of(servo: Config, others: Vec<Config>, flash: &Flash) -> Self {
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        COST.store(0, Ordering::Relaxed);
        let made = |servo| {
            let servo = Config { clock: Clock::Wall, wire_time: true, return_delay_us: 0, ..servo };
            Servo::new(servo).expect("a servo")
        };
        let (servo, others) = (made(servo), Vec::from_iter(others.into_iter().map(made)));
        let said = [&servo].into_iter().chain(&others).map(Servo::truth).collect();
        let [bus, link] = [0; 2].map(|_| [0; 2].map(|_| Shelf::default()));
        let fed = Rc::new(RefCell::new(Fed::default()));
        let tasks = start(&bus, &link, &fed, flash, ResetCause::PowerOn);
        Self {
            servo,
            others,
            reports: Vec::new(),
            events: Vec::new(),
            meddling: Box::new(|_, bytes| bytes),
            listens: true,
            keeps: true,
            tasks,
            now_us: 0,
            started_us: 0,
            bus,
            link,
            coming: Vec::new(),
            said,
            decoder: Box::new(Decoder::new()),
            answers: VecDeque::new(),
            sequence: 0,
            fed,
            _turn: turn,
        }
    }

    /// Restarts the microcontroller; the servo does not notice. What the host heard before stays.
    pub fn restart(&mut self, flash: &Flash) {
        self.tasks.clear();
        for line in self.bus.iter().chain(&self.link) {
            *line.borrow_mut() = Line::default();
        }
        self.coming.clear();
        self.answers.clear();
        *self.decoder = Decoder::new();
        *self.fed.borrow_mut() = Fed::default();
        self.started_us = self.now_us;
        self.tasks = start(&self.bus, &self.link, &self.fed, flash, ResetCause::Software);
    }

    /// Time since it was switched on, µs.
    pub fn now_us(&self) -> u64 {
        self.now_us
    }

    /// The longest time for which the watchdog was not fed, µs; and after how long it would have bitten.
    pub fn longest_fast_us(&self) -> (u64, u64) {
        let fed = *self.fed.borrow();
        (fed.longest_us.max(self.now_us - self.started_us - fed.last_us), u64::from(OnPc::WATCHDOG_MS) * 1000)
    }

    /// What an estimate seems to cost the processor from now on, µs.
    pub fn set_cost(&mut self, us: u32) {
        COST.store(us, Ordering::Relaxed);
    }

    /// Lets time pass, µs.
    pub fn run(&mut self, us: u64) {
        self.run_with(us, |_, _| {});
    }

    /// Lets time pass, and shows every report as it comes.
    pub fn run_with(&mut self, us: u64, mut look: impl FnMut(&Report, &Truth)) {
        let end = self.now_us + us;
        while self.now_us < end {
            self.step(&mut look);
        }
    }

    /// Lets time pass until a report is so; panics after `us`.
    pub fn until(&mut self, what: &str, us: u64, mut so: impl FnMut(&Report) -> bool) {
        let end = self.now_us + us;
        let mut done = false;
        while !done {
            assert!(self.now_us < end, "no {what} within {us} µs; last report: {:?}", self.reports.last());
            self.step(&mut |report, _| done |= so(report));
        }
    }

    fn step(&mut self, look: &mut impl FnMut(&Report, &Truth)) {
        self.settle();
        self.serve_bus();
        self.hear_link(look);
        self.now_us += STEP_US;
        MockDriver::get().advance(Duration::from_micros(STEP_US));
        let now_us = self.now_us;
        for (index, servo) in [&mut self.servo].into_iter().chain(&mut self.others).enumerate() {
            servo.advance(now_us);
            if let Some(answer) = servo.poll(now_us) {
                self.coming.push((now_us + u64::from(answer.delay_us), index, answer.bytes));
            }
        }
        while let Some(due) = self.coming.iter().position(|(due, ..)| *due <= now_us) {
            let (at, by, mut bytes) = self.coming.remove(due);
            // Who speaks at the same time pulls the line low where either does.
            while let Some(other) = self.coming.iter().position(|(due, ..)| *due == at) {
                let (_, _, others) = self.coming.remove(other);
                let longest = bytes.len().max(others.len());
                bytes =
                    (0..longest).map(|at| bytes.get(at).unwrap_or(&0xFF) & others.get(at).unwrap_or(&0xFF)).collect();
            }
            let bytes = (self.meddling)(false, bytes);
            give(&self.bus[1], &bytes);
            self.heard_by_servos(Some(by), &bytes);
        }
    }

    /// The servo of a finger.
    pub fn servo_of(&mut self, finger: usize) -> &mut Servo {
        match finger.checked_sub(1) {
            None => &mut self.servo,
            Some(other) => &mut self.others[other],
        }
    }

    /// What another device says on the bus: the gripper and the servos hear it.
    pub fn interject(&mut self, bytes: &[u8]) {
        give(&self.bus[1], bytes);
        self.heard_by_servos(None, bytes);
    }

    /// What is said on the bus, for every servo but the one that says it.
    fn heard_by_servos(&mut self, by: Option<usize>, bytes: &[u8]) {
        let now_us = self.now_us;
        for (index, servo) in [&mut self.servo].into_iter().chain(&mut self.others).enumerate() {
            if by == Some(index) {
                continue;
            }
            let reads = servo.statistics().position_reads;
            for answer in servo.hear(now_us, bytes) {
                self.coming.push((now_us + u64::from(answer.delay_us), index, answer.bytes));
            }
            if servo.statistics().position_reads > reads {
                self.said[index] = servo.truth();
            }
        }
    }

    /// Runs the tasks until all of them wait, the control task first.
    fn settle(&mut self) {
        let mut polls = 0;
        while let Some(task) = self.tasks.iter_mut().find(|task| task.woken.0.swap(false, Ordering::AcqRel)) {
            let poll = task.future.as_mut().poll(&mut Context::from_waker(&task.waker));
            assert!(poll.is_pending(), "a task has ended");
            polls += 1;
            assert!(polls < HANGS, "the program hangs at {} µs", self.now_us);
        }
    }

    fn serve_bus(&mut self) {
        let bytes: Vec<u8> = self.bus[0].borrow_mut().bytes.drain(..).collect();
        if bytes.is_empty() {
            return;
        }
        let bytes = (self.meddling)(true, bytes);
        self.heard_by_servos(None, &bytes);
    }

    fn hear_link(&mut self, look: &mut impl FnMut(&Report, &Truth)) {
        if !self.listens {
            return;
        }
        let bytes: Vec<u8> = {
            let mut line = self.link[0].borrow_mut();
            line.writer.take().into_iter().for_each(Waker::wake);
            line.bytes.drain(..).collect()
        };
        let mut bytes = bytes.as_slice();
        while let Some(message) = self.decoder.feed(&mut bytes) {
            let message = message.expect("what the gripper sends is sound");
            let (header, body) = VarHeader::take_from_slice(message).expect("a header");
            if is::<EstimateTopic>(&header) {
                let report: Report = postcard::from_bytes(body).expect("a report");
                let said = self.said.get(usize::from(report.finger)).copied().unwrap_or(self.said[0]);
                look(&report, &said);
                if self.keeps {
                    self.reports.push((report, said));
                }
            } else if is::<EventTopic>(&header) {
                let notice: Notice = postcard::from_bytes(body).expect("a notice");
                self.events.push(notice.event);
            } else if let VarSeq::Seq4(_) = header.seq_no {
                let body = body.to_vec();
                self.answers.push_back((header, body));
            }
        }
    }

    /// Puts bytes on the link as they are.
    pub fn send_raw(&mut self, bytes: &[u8]) {
        give(&self.link[1], bytes);
    }

    /// Frames a request and puts it on the link; gives its number.
    pub fn send<E: Endpoint>(&mut self, request: &E::Request) -> u32
    where
        E::Request: Serialize,
    {
        let mut body = vec![0; MESSAGE];
        let length = postcard::to_slice(request, &mut body).expect("a request").len();
        self.send_body(VarKey::Key8(E::REQ_KEY), &body[..length])
    }

    /// The same with any body.
    pub fn send_body(&mut self, key: VarKey, body: &[u8]) -> u32 {
        self.sequence += 1;
        let header = VarHeader { key, seq_no: VarSeq::Seq4(self.sequence) };
        let (mut scratch, mut frame) = (vec![0; MESSAGE], vec![0; FRAME]);
        let mut head = message(&header, &(), &mut scratch).expect("a header").to_vec();
        head.extend(body);
        let frame = encode(&head, &mut frame).expect("a frame").to_vec();
        self.send_raw(&frame);
        self.sequence
    }

    /// Asks, and lets time pass until the answer.
    pub fn ask<E: Endpoint>(&mut self, request: &E::Request) -> E::Response
    where
        E::Request: Serialize,
        E::Response: DeserializeOwned,
    {
        let number = self.send::<E>(request);
        let end = self.now_us + 5_000_000;
        loop {
            assert!(self.now_us < end, "no answer to {}", E::PATH);
            self.step(&mut |_, _| {});
            while let Some((header, body)) = self.answers.pop_front() {
                if header.seq_no == VarSeq::Seq4(number) {
                    return postcard::from_bytes(&body).expect("an answer");
                }
            }
        }
    }

    /// Bytes from the host that the gripper has not read yet.
    pub fn unread(&self) -> usize {
        self.link[1].borrow().bytes.len()
    }

    /// Numbers of the requests whose answers nobody has waited for, in the order of the answers.
    pub fn take_answered(&mut self) -> Vec<u32> {
        let number = |(header, _): (VarHeader, Vec<u8>)| match header.seq_no {
            VarSeq::Seq4(number) => Some(number),
            _ => None,
        };
        self.answers.drain(..).filter_map(number).collect()
    }
}

/// Starts the program's tasks, at time 0 of its clock.
fn start(bus: &[Shelf; 2], link: &[Shelf; 2], fed: &Rc<RefCell<Fed>>, flash: &Flash, cause: ResetCause) -> Vec<Task> {
    MockDriver::get().reset();
    let port = |[to, from]: &[Shelf; 2], room| Port { from: from.clone(), to: to.clone(), room };
    // Bytes to the host and bytes from it are two tasks'.
    let (bus_port, send_port, answer_port) = (port(bus, usize::MAX), port(link, LINK), port(link, LINK));
    let dog = Dog { fed: fed.clone() };
    // Tasks live as long as the program: so does what they share.
    let shared: &'static Shared = Box::leak(Box::new(Shared::new()));
    let models: &'static mut [Model] = Box::leak(Box::new([const { Model::EMPTY }; OnPc::FINGERS]));
    let boot = Boot::new(cause, &mut LastWords::EMPTY.clone());
    let flash = flash.clone();
    let bus: &'static gripper::Bus<Port> = Box::leak(Box::new(gripper::Bus::new(bus_port, OnPc::BUS_LATENCY_US)));
    vec![
        Task::new(async move { gripper::serve::<OnPc>(shared, bus).await }),
        Task::new(async move { gripper::control::<OnPc>(shared, models, bus, dog).await }),
        Task::new(async move { gripper::send(shared, send_port).await }),
        Task::new(async move { gripper::answer::<OnPc, _>(shared, answer_port, flash, boot).await }),
    ]
}

fn is<T: Topic>(header: &VarHeader) -> bool {
    // A shortened key equals the whole one.
    header.key == VarKey::Key8(T::TOPIC_KEY)
}
