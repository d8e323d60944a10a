//! The answering task: what the host asks, and the answers.

use core::future::poll_fn;

use embassy_futures::select::{Either, select};
use embassy_futures::yield_now;
use embassy_time::{Duration, Instant, Timer, with_deadline};
use embedded_io_async::Read;
use embedded_storage::nor_flash::NorFlash;
use heapless::{String, Vec};
use messages::{
    BootReport, Carry, CarryTo, Close, CloseTo, Counters, ENDPOINTS, Event, FingerFor, GetBoot, GetCounters, GetFinger,
    GetObject, GetServo, GetSettings, GetUncertainty, GetVersion, Grip, GripTo, Hold, MaybeFinger, MaybeObject,
    MaybeServo, MaybeUncertainty, Moved, ObjectFor, Open, Outcome, PROTOCOL_VERSION, PlaceObject, Provocation, Provoke,
    Refusal, Relax, Scan, SetFinger, SetObject, SetSettings, SetUncertainty, Settings, TOPICS_IN, TOPICS_OUT,
    UncertaintyFor, Version, Which, frame,
};
use model_core::size::Lists;
use postcard_rpc::define_dispatch;
use postcard_rpc::header::{VarHeader, VarKeyKind};
use postcard_rpc::server::{Dispatch, Server, WireSpawn};

use super::wire::{Answers, Requests};
use crate::alive::Task;
use crate::board::{Board, Boot};
use crate::provoke::provoke;
use crate::setup::Key;
use crate::shared::{Command, Order, Shared};
use crate::store::{self, Store};

/// How long a record may take to be written: a sector's erasure, some seconds at most, and what waits before it.
const WRITING: Duration = Duration::from_secs(10);
/// How long the control task may take to obey.
const PATIENCE: Duration = Duration::from_secs(2);

/// Answers the host for ever.
pub async fn answer<B: Board, R: Read>(shared: &'static Shared, port: R, flash: B::Flash, boot: Boot) -> ! {
    match select(shared.alive.beat(Task::Link), restore_and_answer::<B, R>(shared, port, flash, boot)).await {
        Either::First(never) | Either::Second(never) => never,
    }
}

async fn restore_and_answer<B: Board, R: Read>(shared: &'static Shared, port: R, flash: B::Flash, boot: Boot) -> ! {
    shared.tell(Event::Started { cause: boot.cause });
    let mut place = Vec::new();
    let Some(store) = Store::begun(&mut place, flash) else { B::restart("no room to begin") };
    if B::FLASH_STALLS {
        store.wait_for(&shared.quiet);
    }
    let store::Found { records, damaged } = store.restore(&mut &*shared).await;
    shared.count(|counters| counters.flash_writes = store.writes());
    shared.tell(Event::Restored { records, damaged });
    shared.restored();
    match select(keep(shared, store), serve::<B, R>(shared, port, boot)).await {
        Either::First(never) | Either::Second(never) => never,
    }
}

/// Writes to flash what was set.
async fn keep<F: NorFlash>(shared: &Shared, store: &mut Store<F>) -> ! {
    loop {
        let key = shared.keep.receive().await;
        let is_kept = store.keep(key, &shared).await.is_ok();
        shared.count(|counters| counters.flash_writes = store.writes());
        shared.kept(key, is_kept);
        // Who waits for this hears of it before the next one is written.
        yield_now().await;
    }
}

async fn serve<B: Board, R: Read>(shared: &'static Shared, port: R, boot: Boot) -> ! {
    let boot = BootReport { cause: boot.cause, last_words: boot.last_words };
    let mut buffer = [0; frame::MESSAGE];
    let mut requests = Requests::new(shared, port);
    let version = Version {
        protocol: PROTOCOL_VERSION,
        firmware: short(crate::VERSION),
        fingers: B::FINGERS as u8,
        board: short(B::NAME),
        cost_hz: B::COST_HZ,
        lists: Lists::HERE,
    };
    let mut ticket = 0;
    loop {
        let app = Gripper::new(
            Context {
                shared,
                version: version.clone(),
                boot: boot.clone(),
                ticket,
                command: None,
                restart: B::restart,
            },
            NoTasks,
        );
        let key = app.min_key_len();
        let mut server = Server::new(Answers(shared), &mut requests, &mut buffer[..], app, key);
        // Ends when the port closes or fails; it may come back.
        let _ = server.run().await;
        ticket = u32::wrapping_add(ticket, 0x1_0000);
        Timer::after_millis(100).await;
    }
}

fn short(words: &str) -> String<16> {
    let mut short = String::new();
    for letter in words.chars() {
        if short.push(letter).is_err() {
            break;
        }
    }
    short
}

/// What the answers are made of.
pub struct Context {
    shared: &'static Shared,
    version: Version,
    boot: BootReport,
    ticket: u32,
    /// What the host wants done, until the control task has it. (Were it a part of the futures below, it would be on the stack once per
    /// future and request.)
    command: Option<Command>,
    restart: fn(&'static str) -> !,
}

impl Context {
    /// Takes what the host wants done.
    #[inline(never)]
    fn asked<T>(&mut self, what: T, command: fn(T) -> Command) -> &mut Self {
        self.command = Some(command(what));
        self
    }

    /// Sends it to the control task. What is refused as [`Refusal::Busy`] is never done.
    async fn order(&mut self) -> Outcome {
        self.move_fingers().await.map(|_| ())
    }

    /// The same of an order that each finger obeys by itself.
    async fn move_fingers(&mut self) -> Moved {
        self.ticket = self.ticket.wrapping_add(1).max(1);
        let ticket = self.ticket;
        self.shared.offer(ticket);
        let offered = with_deadline(Instant::now() + PATIENCE, async {
            while !self.hand_over(ticket) {
                poll_fn(|context| self.shared.orders.poll_ready_to_send(context)).await;
            }
            self.outcome(ticket).await
        });
        if let Ok(outcome) = offered.await {
            return outcome;
        }
        if self.shared.claim(ticket) {
            return Err(Refusal::Busy);
        }
        // It was taken up at the last moment: its outcome is as good as there.
        with_deadline(Instant::now() + PATIENCE, self.outcome(ticket)).await.unwrap_or(Err(Refusal::Busy))
    }

    /// Hands the order over, if there is room for it.
    #[inline(never)]
    fn hand_over(&mut self, ticket: u32) -> bool {
        let room = !self.shared.orders.is_full();
        if room && let Some(command) = self.command.take() {
            // Nobody else sends orders.
            let _ = self.shared.orders.try_send(Order { ticket, command });
        }
        room
    }

    async fn outcome(&self, ticket: u32) -> Moved {
        loop {
            // An outcome that comes after its deadline is not the next one's.
            let (about, outcome) = self.shared.answered().await;
            if about == ticket {
                return outcome;
            }
        }
    }
}

impl Context {
    /// Sends an order to the control task, and keeps what it has made of it: a design that was refused has cost the old one.
    async fn order_and_keep(&mut self, key: Key) -> Outcome {
        let outcome = self.order().await;
        if matches!(outcome, Ok(()) | Err(Refusal::Finger(_))) {
            self.shared.kept.reset();
            let writing = async {
                self.shared.keep(key).await;
                loop {
                    // The bus's master has things kept too.
                    let (what, kept) = self.shared.kept.wait().await;
                    if what == key {
                        break kept;
                    }
                }
            };
            let kept = with_deadline(Instant::now() + WRITING, writing).await.unwrap_or(false);
            if outcome.is_ok() && !kept {
                return Err(Refusal::NotKept);
            }
        }
        outcome
    }
}

fn get_version(context: &mut Context, _: VarHeader, (): ()) -> Version {
    context.version.clone()
}

fn get_boot(context: &mut Context, _: VarHeader, (): ()) -> BootReport {
    context.boot.clone()
}

fn get_object(context: &mut Context, _: VarHeader, finger: u8) -> MaybeObject {
    context.shared.setup(|setup| setup.objects.get(usize::from(finger)).copied().flatten())
}

/// Any number of times: nothing is written to flash.
async fn place_object(context: &mut Context, _: VarHeader, object: ObjectFor) -> Outcome {
    context.asked(object, Command::Object).order().await
}

async fn set_object(context: &mut Context, _: VarHeader, object: ObjectFor) -> Outcome {
    let key = Key::Object(object.finger);
    context.asked(object, Command::Object).order_and_keep(key).await
}

fn get_finger(context: &mut Context, _: VarHeader, finger: u8) -> MaybeFinger {
    context.shared.setup(|setup| setup.fingers.get(usize::from(finger)).cloned().flatten())
}

async fn set_finger(context: &mut Context, _: VarHeader, finger: FingerFor) -> Outcome {
    let key = Key::Finger(finger.finger);
    context.asked(finger, Command::Finger).order_and_keep(key).await
}

fn get_uncertainty(context: &mut Context, _: VarHeader, finger: u8) -> MaybeUncertainty {
    context.shared.setup(|setup| setup.uncertainties.get(usize::from(finger)).copied().flatten())
}

async fn set_uncertainty(context: &mut Context, _: VarHeader, uncertainty: UncertaintyFor) -> Outcome {
    let key = Key::Uncertainty(uncertainty.finger);
    context.asked(uncertainty, Command::Uncertainty).order_and_keep(key).await
}

fn get_servo(context: &mut Context, _: VarHeader, finger: u8) -> MaybeServo {
    context.shared.setup(|setup| setup.servos.get(usize::from(finger)).copied().flatten())
}

fn get_settings(context: &mut Context, _: VarHeader, (): ()) -> Settings {
    context.shared.setup(|setup| setup.settings)
}

async fn set_settings(context: &mut Context, _: VarHeader, settings: Settings) -> Outcome {
    context.asked(settings, Command::Settings).order_and_keep(Key::Settings).await
}

async fn open(context: &mut Context, _: VarHeader, which: Which) -> Moved {
    context.asked(which, Command::Open).move_fingers().await
}

async fn close(context: &mut Context, _: VarHeader, to: CloseTo) -> Outcome {
    context.asked(to, Command::Close).order().await
}

async fn grip(context: &mut Context, _: VarHeader, to: GripTo) -> Outcome {
    context.asked(to, Command::Grip).order().await
}

async fn carry(context: &mut Context, _: VarHeader, to: CarryTo) -> Outcome {
    context.asked(to, Command::Carry).order().await
}

async fn hold(context: &mut Context, _: VarHeader, which: Which) -> Moved {
    context.asked(which, Command::Hold).move_fingers().await
}

async fn relax(context: &mut Context, _: VarHeader, which: Which) -> Moved {
    context.asked(which, Command::Relax).move_fingers().await
}

async fn provoke_it(context: &mut Context, _: VarHeader, what: Provocation) -> Outcome {
    match provoke(context.restart, what)? {
        Some(command) => context.asked(command, |command| command).order().await,
        None => Ok(()),
    }
}

async fn scan(context: &mut Context, _: VarHeader, (): ()) -> Outcome {
    context.asked((), |()| Command::Scan).order().await
}

fn get_counters(context: &mut Context, _: VarHeader, (): ()) -> Counters {
    context.shared.counters()
}

/// No request needs a task of its own.
#[derive(Clone)]
pub struct NoTasks;

impl WireSpawn for NoTasks {
    type Error = core::convert::Infallible;
    type Info = ();
    fn info(&self) -> &() {
        &()
    }
}

// The macro below asks for it by name and calls it for requests of kind `spawn` only, of which there are none.
#[allow(dead_code)]
fn spawn(_: &NoTasks, _: ()) -> Result<(), core::convert::Infallible> {
    Ok(())
}

define_dispatch! {
    app: Gripper;
    spawn_fn: spawn;
    tx_impl: Answers;
    spawn_impl: NoTasks;
    context: Context;

    endpoints: {
        list: ENDPOINTS;

        | EndpointTy     | kind     | handler         |
        | ----------     | ----     | -------         |
        | GetVersion     | blocking | get_version     |
        | GetBoot        | blocking | get_boot        |
        | GetObject      | blocking | get_object      |
        | SetObject      | async    | set_object      |
        | PlaceObject    | async    | place_object    |
        | GetFinger      | blocking | get_finger      |
        | SetFinger      | async    | set_finger      |
        | GetUncertainty | blocking | get_uncertainty |
        | SetUncertainty | async    | set_uncertainty |
        | GetSettings    | blocking | get_settings    |
        | GetServo       | blocking | get_servo       |
        | SetSettings    | async    | set_settings    |
        | Open           | async    | open            |
        | Close          | async    | close           |
        | Grip           | async    | grip            |
        | Carry          | async    | carry           |
        | Hold           | async    | hold            |
        | Relax          | async    | relax           |
        | Scan           | async    | scan            |
        | GetCounters    | blocking | get_counters    |
        | Provoke        | async    | provoke_it      |
    };
    topics_in: {
        list: TOPICS_IN;

        | TopicTy | kind | handler |
        | ------- | ---- | ------- |
    };
    topics_out: {
        list: TOPICS_OUT;
    };
}

/// Bytes of a key that tell all messages apart.
pub(super) const KEY: VarKeyKind = match sizer::NEEDED_SZ {
    1 => VarKeyKind::Key1,
    2 => VarKeyKind::Key2,
    4 => VarKeyKind::Key4,
    _ => VarKeyKind::Key8,
};

#[cfg(test)]
mod tests {
    use core::future::Future;
    use core::pin::pin;
    use core::task::{Context as Polled, Poll, Waker};
    use embassy_time::MockDriver;
    use embedded_storage::nor_flash::{ErrorType, NorFlashErrorKind, ReadNorFlash};
    use messages::ResetCause;

    use super::*;

    fn context(shared: &'static Shared) -> Context {
        let (firmware, board) = (String::new(), String::new());
        let version = Version { protocol: 0, firmware, fingers: 1, board, cost_hz: 1_000_000, lists: Lists::TARGET };
        let boot = BootReport { cause: ResetCause::PowerOn, last_words: None };
        Context { shared, version, boot, ticket: 0, command: None, restart: |_| panic!("a restart") }
    }

    /// Refused as busy, an order is not done later, when the control task comes to it; one that was taken up has its outcome. (One
    /// test: the time is everybody's.)
    #[test]
    fn a_refused_order_is_never_done() {
        static SHARED: Shared = Shared::new();
        let polled = &mut Polled::from_waker(Waker::noop());
        let mut context = context(&SHARED);
        {
            let mut order = pin!(context.asked((), |()| Command::Scan).order());
            assert_eq!(order.as_mut().poll(polled), Poll::Pending);
            MockDriver::get().advance(PATIENCE + Duration::from_millis(1));
            assert_eq!(order.as_mut().poll(polled), Poll::Ready(Err(Refusal::Busy)));
        }
        let late = SHARED.orders.try_receive().expect("it waits still").ticket;
        assert!(!SHARED.claim(late), "it would be done after all");

        {
            let mut order = pin!(context.asked((), |()| Command::Scan).order());
            assert_eq!(order.as_mut().poll(polled), Poll::Pending);
            let ticket = SHARED.orders.try_receive().expect("another one").ticket;
            assert!(!SHARED.claim(late) && SHARED.claim(ticket));
            MockDriver::get().advance(PATIENCE + Duration::from_millis(1));
            assert_eq!(order.as_mut().poll(polled), Poll::Pending, "it is being done: it cannot be refused any more");
            SHARED.answer(late, Err(Refusal::Scanning));
            assert_eq!(order.as_mut().poll(polled), Poll::Pending, "another order's outcome");
            SHARED.answer(ticket, Err(Refusal::NoServo));
            assert_eq!(order.as_mut().poll(polled), Poll::Ready(Err(Refusal::NoServo)));
        }
        // A write of whose end nobody hears does not hang the link.
        let mut order = pin!(context.asked((), |()| Command::Scan).order_and_keep(Key::Settings));
        assert_eq!(order.as_mut().poll(polled), Poll::Pending);
        let ticket = SHARED.orders.try_receive().expect("an order").ticket;
        assert!(SHARED.claim(ticket));
        SHARED.answer(ticket, Ok(Default::default()));
        assert_eq!(order.as_mut().poll(polled), Poll::Pending);
        MockDriver::get().advance(WRITING + Duration::from_millis(1));
        assert_eq!(order.as_mut().poll(polled), Poll::Ready(Err(Refusal::NotKept)));
        one_record_is_kept_right_behind_another();
    }

    /// Flash while which is read the bus's master has something kept, once.
    struct Flash([u8; 0x8000], Option<&'static Shared>);

    impl ErrorType for Flash {
        type Error = NorFlashErrorKind;
    }

    impl ReadNorFlash for Flash {
        const READ_SIZE: usize = 1;

        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
            bytes.copy_from_slice(&self.0[offset as usize..][..bytes.len()]);
            assert!(self.1.take().is_none_or(|shared| shared.keep_soon(Key::Object(0))));
            Ok(())
        }

        fn capacity(&self) -> usize {
            self.0.len()
        }
    }

    impl NorFlash for Flash {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = 0x1000;

        fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
            self.0[from as usize..to as usize].fill(0xFF);
            Ok(())
        }

        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
            self.0[offset as usize..][..bytes.len()].copy_from_slice(bytes);
            Ok(())
        }
    }

    /// The host hears that its record is kept though that of the bus's master is written right behind it.
    fn one_record_is_kept_right_behind_another() {
        static SHARED: Shared = Shared::new();
        let polled = &mut Polled::from_waker(Waker::noop());
        let mut place = Vec::new();
        let store = Store::begun(&mut place, Flash([0xFF; 0x8000], Some(&SHARED))).unwrap();
        let mut context = context(&SHARED);
        let order = context.asked((), |()| Command::Scan).order_and_keep(Key::Settings);
        let mut both = pin!(select(keep(&SHARED, store), order));
        assert!(both.as_mut().poll(polled).is_pending());
        let ticket = SHARED.orders.try_receive().expect("an order").ticket;
        assert!(SHARED.claim(ticket));
        SHARED.answer(ticket, Ok(Default::default()));
        assert!(both.as_mut().poll(polled).is_pending());
        assert!(matches!(both.as_mut().poll(polled), Poll::Ready(Either::Second(Ok(())))));
    }
}
