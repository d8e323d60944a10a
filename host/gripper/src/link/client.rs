//! The client: one thread hears, any thread asks.

use std::collections::HashMap;
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, TrySendError, channel};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use messages::frame::{Decoder, FRAME, MESSAGE, encode, message};
use messages::{EstimateTopic, EventTopic, GraspTopic, Report, ShapeTopic};
use model_core::size::Lists;
use postcard_rpc::header::{VarHeader, VarKey, VarSeq};
use postcard_rpc::standard_icd::{ERROR_KEY, WireError};
use postcard_rpc::{Endpoint, Topic, postcard};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::place::way;
use super::port::Port;
use super::{Address, LinkError};
use crate::source::{Listeners, Sequence, Statistics, Told, WAITING};

/// How long an answer is waited for by default.
const PATIENCE: Duration = Duration::from_secs(5);
/// How often the reading thread looks whether it is still wanted.
const GLANCE: Duration = Duration::from_millis(50);
/// Number of the requests whose answers nobody waits for. Those of the others begin behind it.
const IDLE: u32 = 0;

#[derive(Debug, Default)]
struct Counts {
    frames: AtomicU64,
    damaged: AtomicU64,
    unexpected: AtomicU64,
    missing_reports: AtomicU64,
    unheard: AtomicU64,
}

/// Answer of the gripper: its key and body.
type Answer = (VarKey, Vec<u8>);

#[derive(Debug, Default)]
struct Heard {
    pending: Mutex<HashMap<u32, Sender<Answer>>>,
    listeners: Listeners,
    /// Other programs that hear the gripper's messages as they come.
    taps: Mutex<Vec<SyncSender<Vec<u8>>>>,
    counts: Counts,
    stop: AtomicBool,
    closed: AtomicBool,
}

/// A connection to a gripper; closed when dropped.
#[derive(Debug)]
pub struct Link {
    writer: Mutex<Port>,
    heard: Arc<Heard>,
    sequence: AtomicU32,
    reader: Option<JoinHandle<()>>,
    patience: Duration,
    place: String,
    /// How long the lists of a description may be there, once it is known.
    pub(super) lists: OnceLock<Lists>,
}

/// The lock, also if another thread stopped while it held it.
pub(super) fn lock<X>(mutex: &Mutex<X>) -> MutexGuard<'_, X> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Link {
    /// Connects: through the program that views this gripper, if there is one, because a gripper's port has one user.
    ///
    /// # Errors
    /// Nobody is there.
    pub fn open(address: &Address) -> Result<Self, LinkError> {
        match way(address) {
            Some(way) => Self::over(Port::unix(way).map_err(LinkError::Start)?, address.to_string()),
            None => Self::open_alone(address),
        }
    }

    /// Connects to the gripper itself.
    pub(super) fn open_alone(address: &Address) -> Result<Self, LinkError> {
        Self::over(Port::open(address)?, address.to_string())
    }

    /// Connects as soon as somebody is there.
    ///
    /// # Errors
    /// Nobody was there in time.
    pub fn open_within(address: &Address, longest: Duration) -> Result<Self, LinkError> {
        let end = Instant::now() + longest;
        loop {
            match Self::open(address) {
                Err(LinkError::Open { .. }) if Instant::now() < end => std::thread::sleep(GLANCE),
                result => return result,
            }
        }
    }

    /// Speaks over a socket that is connected already.
    ///
    /// # Errors
    /// The system has no more threads or sockets.
    pub fn over_stream(stream: UnixStream) -> Result<Self, LinkError> {
        Self::over(Port::unix(stream).map_err(LinkError::Start)?, "a socket".to_owned())
    }

    fn over(writer: Port, place: String) -> Result<Self, LinkError> {
        let mut reader = writer.try_clone().map_err(LinkError::Start)?;
        let heard = Arc::<Heard>::default();
        let for_thread = heard.clone();
        let thread = std::thread::Builder::new().name("link".into());
        let thread = thread.spawn(move || for_thread.hear(&mut reader)).map_err(LinkError::Start)?;
        Ok(Self {
            writer: Mutex::new(writer),
            heard,
            sequence: AtomicU32::new(IDLE + 1),
            reader: Some(thread),
            patience: PATIENCE,
            place,
            lists: OnceLock::new(),
        })
    }

    /// Changes how long answers are waited for; 5 s at first.
    pub fn set_patience(&mut self, patience: Duration) {
        self.patience = patience;
    }

    /// Everything that the gripper reports from now on. Ends with the link.
    pub fn listen(&self) -> Receiver<Told> {
        self.listen_with(WAITING)
    }

    /// What was heard so far.
    pub fn statistics(&self) -> Statistics {
        let Counts { frames, damaged, unexpected, missing_reports, unheard } = &self.heard.counts;
        let now = |count: &AtomicU64| count.load(Ordering::Relaxed);
        Statistics {
            frames: now(frames),
            damaged: now(damaged),
            unexpected: now(unexpected),
            missing_reports: now(missing_reports),
            unheard: now(unheard),
        }
    }

    /// Whether the other end is gone.
    pub fn is_closed(&self) -> bool {
        self.heard.closed.load(Ordering::Acquire)
    }

    /// Writes bytes as they are: noise, for tests.
    ///
    /// # Errors
    /// The port's.
    pub fn send_raw(&self, bytes: &[u8]) -> Result<(), LinkError> {
        lock(&self.writer).send(bytes).map_err(LinkError::Send)
    }

    /// Asks, and waits for the answer.
    ///
    /// # Errors
    /// No answer, or one that says that the request was not understood.
    pub fn ask<E: Endpoint>(&self, request: &E::Request) -> Result<E::Response, LinkError>
    where
        E::Request: Serialize,
        E::Response: DeserializeOwned,
    {
        let path = E::PATH;
        let mut body = vec![0; MESSAGE];
        let request = postcard::to_slice(request, &mut body).map_err(|_| LinkError::TooLong)?;
        let (key, body) = self.pass(VarKey::Key8(E::REQ_KEY), request, path)?;
        if key == VarKey::Key8(E::RESP_KEY) {
            return postcard::from_bytes(&body).map_err(|_| LinkError::Answer { path });
        }
        match postcard::from_bytes::<WireError>(&body) {
            Ok(error) if key == VarKey::Key8(ERROR_KEY) => Err(LinkError::Wire { path, error }),
            _ => Err(LinkError::Answer { path }),
        }
    }

    /// Asks, and waits for no answer.
    pub(super) fn ask_idly<E: Endpoint>(&self, request: &E::Request)
    where
        E::Request: Serialize,
    {
        let mut body = vec![0; MESSAGE];
        if let Ok(request) = postcard::to_slice(request, &mut body) {
            // Whether the gripper is there shows by its reports.
            let _ = self.write(VarKey::Key8(E::REQ_KEY), IDLE, request);
        }
    }

    /// Sends a request's bytes, and waits for those of the answer.
    pub(super) fn pass(&self, key: VarKey, request: &[u8], path: &'static str) -> Result<Answer, LinkError> {
        let number = self.sequence.fetch_add(1, Ordering::Relaxed);
        let (sender, receiver) = channel();
        lock(&self.heard.pending).insert(number, sender);
        let answer = self.write(key, number, request).and_then(|()| {
            receiver.recv_timeout(self.patience).map_err(|error| match error {
                RecvTimeoutError::Timeout => LinkError::Timeout { path, waited: self.patience },
                RecvTimeoutError::Disconnected => LinkError::Closed,
            })
        });
        lock(&self.heard.pending).remove(&number);
        answer
    }

    /// Sends a request's bytes under a number.
    fn write(&self, key: VarKey, number: u32, request: &[u8]) -> Result<(), LinkError> {
        let header = VarHeader { key, seq_no: VarSeq::Seq4(number) };
        let (mut scratch, mut frame) = (vec![0; MESSAGE], vec![0; FRAME]);
        let mut bytes = message(&header, &(), &mut scratch).map_err(|_| LinkError::TooLong)?.to_vec();
        bytes.extend(request);
        let frame = encode(&bytes, &mut frame).map_err(|_| LinkError::TooLong)?;
        if self.is_closed() { Err(LinkError::Closed) } else { self.send_raw(frame) }
    }

    /// Gives the gripper's messages, except for answers, to another program as they come.
    pub(super) fn tap(&self, mail: SyncSender<Vec<u8>>) {
        lock(&self.heard.taps).push(mail);
    }

    /// What the reports come from, as people call it.
    pub(super) fn place(&self) -> &str {
        &self.place
    }

    /// Everything that the gripper reports from now on, of which this much may wait.
    pub(super) fn listen_with(&self, waiting: usize) -> Receiver<Told> {
        self.heard.listeners.add(waiting)
    }

    /// Gives all listeners what is not a message of the gripper itself.
    pub(super) fn spread(&self, told: &Told) {
        self.heard.spread(told);
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.heard.stop.store(true, Ordering::Release);
        if let Some(reader) = self.reader.take() {
            let _ = reader.join();
        }
    }
}

impl Heard {
    /// Reads until the other end is gone or nobody wants it any more.
    fn hear(&self, port: &mut Port) {
        let mut decoder = Box::new(Decoder::<FRAME>::new());
        let mut chunk = [0; 4096];
        let mut sequence = Sequence::default();
        while !self.stop.load(Ordering::Acquire) {
            let count = match port.receive(&mut chunk, GLANCE) {
                Ok(None) => continue,
                Ok(Some(0)) | Err(_) => break,
                Ok(Some(count)) => count,
            };
            let mut bytes = &chunk[..count];
            while let Some(event) = decoder.feed(&mut bytes) {
                match event {
                    Ok(message) => self.message(message, &mut sequence),
                    Err(_) => self.add(|counts| &counts.damaged, 1),
                }
            }
        }
        self.closed.store(true, Ordering::Release);
        // Whoever still waits is told by the end of the channel.
        self.listeners.close();
        lock(&self.taps).clear();
        lock(&self.pending).clear();
    }

    fn add(&self, which: impl Fn(&Counts) -> &AtomicU64, number: u64) {
        which(&self.counts).fetch_add(number, Ordering::Relaxed);
    }

    fn message(&self, message: &[u8], sequence: &mut Sequence) {
        self.add(|counts| &counts.frames, 1);
        let understood = VarHeader::take_from_slice(message).and_then(|(header, body)| {
            let is = |key| header.key == VarKey::Key8(key);
            if is(EstimateTopic::TOPIC_KEY) {
                let report: Report = postcard::from_bytes(body).ok()?;
                let missing = sequence.take(report.sequence).map_or(0, |gap| u64::from(gap.missing));
                self.add(|counts| &counts.missing_reports, missing);
                self.spread(&Told::Report(report));
            } else if is(GraspTopic::TOPIC_KEY) {
                self.spread(&Told::Grasp(postcard::from_bytes(body).ok()?));
            } else if is(ShapeTopic::TOPIC_KEY) {
                self.spread(&Told::Shape(Box::new(postcard::from_bytes(body).ok()?)));
            } else if is(EventTopic::TOPIC_KEY) {
                self.spread(&Told::Event(postcard::from_bytes(body).ok()?));
            } else {
                let number: u32 = header.seq_no.into();
                if number == IDLE {
                    return Some(());
                }
                let sender = lock(&self.pending).remove(&number)?;
                // Who asked may have given up.
                let _ = sender.send((header.key, body.to_vec()));
                return Some(());
            }
            self.pass_on(message);
            Some(())
        });
        if understood.is_none() {
            self.add(|counts| &counts.unexpected, 1);
        }
    }

    fn spread(&self, told: &Told) {
        self.add(|counts| &counts.unheard, self.listeners.tell(told));
    }

    /// Gives a message to all who listen to the bytes of this link.
    fn pass_on(&self, message: &[u8]) {
        let gone =
            |tap: &SyncSender<Vec<u8>>| matches!(tap.try_send(message.to_vec()), Err(TrySendError::Disconnected(_)));
        lock(&self.taps).retain(|tap| !gone(tap));
    }
}
