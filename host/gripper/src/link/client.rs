//! The client: one thread hears, any thread asks.

use std::collections::HashMap;
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use messages::frame::{Decoder, FRAME, MESSAGE, encode, message};
use messages::{
    BootReport, Close, CloseTo, Counters, EstimateTopic, EventTopic, Finger, For, GetBoot, GetCounters, GetFinger,
    GetObject, GetServo, GetSettings, GetUncertainty, GetVersion, GraspTopic, Grip, GripTo, Heed, Heeds, Hold, Open,
    PlaceObject, Provocation, Provoke, Relax, Report, Scan, ServoSetup, SetFinger, SetObject, SetSettings,
    SetUncertainty, Settings, ShapeTopic, Version, Which,
};
use model_core::object::ObjectDesign;
use model_core::size::Lists;
use model_core::uncertainty::Uncertainty;
use postcard_rpc::header::{VarHeader, VarKey, VarSeq};
use postcard_rpc::standard_icd::{ERROR_KEY, WireError};
use postcard_rpc::{Endpoint, Topic, postcard};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::port::Port;
use super::{Address, LinkError, share};
use crate::source::{
    Listeners, Modelled, Order, OrderError, Origin, Sequence, Setup, Source, Statistics, Told, WAITING,
};

/// How long an answer is waited for by default.
const PATIENCE: Duration = Duration::from_secs(5);
/// How often the reading thread looks whether it is still wanted.
const GLANCE: Duration = Duration::from_millis(50);

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
        match share::way(address) {
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
            sequence: AtomicU32::new(1),
            reader: Some(thread),
            patience: PATIENCE,
            place,
        })
    }

    /// Changes how long answers are waited for; 5 s at first.
    pub fn set_patience(&mut self, patience: Duration) {
        self.patience = patience;
    }

    /// Everything that the gripper reports from now on. Ends with the link.
    pub fn listen(&self) -> Receiver<Told> {
        self.heard.listeners.add(WAITING)
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

    /// Sends a request's bytes, and waits for those of the answer.
    pub(super) fn pass(&self, key: VarKey, request: &[u8], path: &'static str) -> Result<Answer, LinkError> {
        let number = self.sequence.fetch_add(1, Ordering::Relaxed);
        let header = VarHeader { key, seq_no: VarSeq::Seq4(number) };
        let (mut scratch, mut frame) = (vec![0; MESSAGE], vec![0; FRAME]);
        let mut bytes = message(&header, &(), &mut scratch).map_err(|_| LinkError::TooLong)?.to_vec();
        bytes.extend(request);
        let frame = encode(&bytes, &mut frame).map_err(|_| LinkError::TooLong)?;
        let (sender, receiver) = channel();
        lock(&self.heard.pending).insert(number, sender);
        let sent = if self.is_closed() { Err(LinkError::Closed) } else { self.send_raw(frame) };
        let answer = sent.and_then(|()| {
            receiver.recv_timeout(self.patience).map_err(|error| match error {
                RecvTimeoutError::Timeout => LinkError::Timeout { path, waited: self.patience },
                RecvTimeoutError::Disconnected => LinkError::Closed,
            })
        });
        lock(&self.heard.pending).remove(&number);
        answer
    }

    /// Gives the gripper's messages, except for answers, to another program as they come.
    pub(super) fn tap(&self, mail: SyncSender<Vec<u8>>) {
        lock(&self.heard.taps).push(mail);
    }

    /// Another program has asked for this: a changed set-up goes to all listeners here.
    pub(super) fn was_set(&self, key: VarKey) {
        let set = [
            SetObject::REQ_KEY,
            PlaceObject::REQ_KEY,
            SetFinger::REQ_KEY,
            SetSettings::REQ_KEY,
            SetUncertainty::REQ_KEY,
        ];
        if set.into_iter().any(|of| key == VarKey::Key8(of))
            && let Ok(setup) = Source::setup(self)
        {
            self.heard.spread(&Told::Setup(Box::new(setup)));
        }
    }
}

/// The gripper's requests.
impl Link {
    /// Who answers.
    ///
    /// # Errors
    /// As [`Link::ask`], as with all that follow.
    pub fn version(&self) -> Result<Version, LinkError> {
        self.ask::<GetVersion>(&())
    }

    /// How its program started.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn boot(&self) -> Result<BootReport, LinkError> {
        self.ask::<GetBoot>(&())
    }

    /// A finger's object in its memory; fingers count from 0.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn object(&self, finger: u8) -> Result<Option<ObjectDesign>, LinkError> {
        self.ask::<GetObject>(&finger)
    }

    /// Gives a finger an object, in that finger's world frame; the estimate starts anew.
    ///
    /// # Errors
    /// As [`Link::ask`], and what is wrong with the object.
    pub fn set_object(&self, finger: u8, object: ObjectDesign) -> Result<(), LinkError> {
        object.fits(Lists::TARGET)?;
        Ok(self.ask::<SetObject>(&For { finger, what: object })??)
    }

    /// The same for now only: it is not stored, so that it may be done at any rate.
    ///
    /// # Errors
    /// As [`Link::set_object`].
    pub fn place_object(&self, finger: u8, object: ObjectDesign) -> Result<(), LinkError> {
        object.fits(Lists::TARGET)?;
        Ok(self.ask::<PlaceObject>(&For { finger, what: object })??)
    }

    /// A finger's design in its memory.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn finger(&self, finger: u8) -> Result<Option<Finger>, LinkError> {
        self.ask::<GetFinger>(&finger)
    }

    /// Gives a finger a design; the estimate starts anew.
    ///
    /// # Errors
    /// As [`Link::ask`], and what is wrong with the design or its discretisation.
    pub fn set_finger(&self, finger: u8, design: &Finger) -> Result<(), LinkError> {
        design.design.fits(Lists::TARGET)?;
        Ok(self.ask::<SetFinger>(&For { finger, what: design.clone() })??)
    }

    /// What a calibration has left uncertain of a finger, if one was sent.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn uncertainty(&self, finger: u8) -> Result<Option<Uncertainty>, LinkError> {
        self.ask::<GetUncertainty>(&finger)
    }

    /// Says how uncertain a finger's parameters are, which its forces' standard deviations then follow; none: what is usual.
    ///
    /// # Errors
    /// As [`Link::ask`], and the first value that is not allowed.
    pub fn set_uncertainty(&self, finger: u8, uncertainty: Option<Uncertainty>) -> Result<(), LinkError> {
        Ok(self.ask::<SetUncertainty>(&For { finger, what: uncertainty })??)
    }

    /// How a finger's servo was found set, if one was found since the start.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn servo(&self, finger: u8) -> Result<Option<ServoSetup>, LinkError> {
        self.ask::<GetServo>(&finger)
    }

    /// Its settings.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn settings(&self) -> Result<Settings, LinkError> {
        self.ask::<GetSettings>(&())
    }

    /// Changes its settings.
    ///
    /// # Errors
    /// As [`Link::ask`], and the first value that is not allowed.
    pub fn set_settings(&self, settings: &Settings) -> Result<(), LinkError> {
        Ok(self.ask::<SetSettings>(settings)??)
    }

    /// Opens each finger to the settings' open angle, those whose servo answers. Returns when it begins, as all that follow.
    ///
    /// # Errors
    /// As [`Link::ask`]; no servo.
    pub fn open_fingers(&self, fingers: Which) -> Result<Heeds, LinkError> {
        Ok(self.ask::<Open>(&fingers)??)
    }

    /// Closes to a motor angle (rad) with a speed (rad/s; `None`: the settings' own).
    ///
    /// # Errors
    /// As [`Link::ask`]; no servo; an angle or speed out of range.
    pub fn close(&self, fingers: Which, angle: f32, speed: Option<f32>) -> Result<(), LinkError> {
        Ok(self.ask::<Close>(&CloseTo { fingers, angle, speed })??)
    }

    /// Closes until a force is reached, and keeps it.
    ///
    /// # Errors
    /// As [`Link::ask`]; no servo; no design or object; a number out of range.
    pub fn grip(&self, to: &GripTo) -> Result<(), LinkError> {
        Ok(self.ask::<Grip>(to)??)
    }

    /// Stops each finger where it is, those whose servo answers.
    ///
    /// # Errors
    /// As [`Link::ask`]; no servo.
    pub fn hold(&self, fingers: Which) -> Result<Heeds, LinkError> {
        Ok(self.ask::<Hold>(&fingers)??)
    }

    /// Switches the torque off: each finger yields, and lets go of what it holds. The next motion switches it on.
    ///
    /// # Errors
    /// As [`Link::ask`]; no servo.
    pub fn relax(&self, fingers: Which) -> Result<Heeds, LinkError> {
        Ok(self.ask::<Relax>(&fingers)??)
    }

    /// Has it search its bus for devices at every rate, which takes some seconds: events tell what is found, and the end.
    ///
    /// # Errors
    /// As [`Link::ask`]; another master leads the servos, or a finger grips.
    pub fn scan(&self) -> Result<(), LinkError> {
        Ok(self.ask::<Scan>(&())??)
    }

    /// Has it start anew, or go wrong on purpose if it was built for that; the link may end before the answer.
    ///
    /// # Errors
    /// As [`Link::ask`]; a program that is not for tests.
    pub fn provoke(&self, what: Provocation) -> Result<(), LinkError> {
        Ok(self.ask::<Provoke>(&what)??)
    }

    /// What it has counted.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn counters(&self) -> Result<Counters, LinkError> {
        self.ask::<GetCounters>(&())
    }
}

/// That all fingers obey, or which of them do not.
fn heeded(heeds: Heeds) -> Result<(), OrderError> {
    let silent: Vec<u8> =
        (0..).zip(heeds).filter(|(_, heed)| *heed == Some(Heed::NoServo)).map(|(number, _)| number).collect();
    if silent.is_empty() { Ok(()) } else { Err(OrderError::Silent(silent)) }
}

impl Source for Link {
    fn setup(&self) -> Result<Setup, OrderError> {
        let version = self.version()?;
        let settings = self.settings()?;
        let mut models = Vec::new();
        for number in 0..settings.count() as u8 {
            models.push(Modelled {
                finger: self.finger(number)?,
                object: self.object(number)?,
                uncertainty: self.uncertainty(number)?,
            });
        }
        Ok(Setup {
            origin: Origin::Gripper,
            place: self.place.clone(),
            board: version.board.as_str().to_owned(),
            firmware: version.firmware.as_str().to_owned(),
            protocol: version.protocol,
            cost_hz: version.cost_hz,
            settings,
            models,
        })
    }

    fn hear(&self, waiting: usize) -> Receiver<Told> {
        self.heard.listeners.add(waiting)
    }

    fn statistics(&self) -> Statistics {
        Self::statistics(self)
    }

    fn counters(&self) -> Result<Option<Counters>, OrderError> {
        Ok(Some(Self::counters(self)?))
    }

    fn order(&self, order: &Order) -> Result<(), OrderError> {
        match order {
            Order::Object(finger, object) => self.set_object(*finger, *object)?,
            Order::Finger(finger, design) => self.set_finger(*finger, design)?,
            Order::Settings(settings) => self.set_settings(settings)?,
            Order::Open(which) => return heeded(self.open_fingers(*which)?),
            Order::Close(to) => return Ok(self.close(to.fingers, to.angle, to.speed)?),
            Order::Grip(to) => return Ok(self.grip(to)?),
            Order::Hold(which) => return heeded(self.hold(*which)?),
            Order::Relax(which) => return heeded(self.relax(*which)?),
        }
        let setup = Source::setup(self)?;
        self.heard.spread(&Told::Setup(Box::new(setup)));
        Ok(())
    }

    fn is_closed(&self) -> bool {
        Self::is_closed(self)
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
                let sender = lock(&self.pending).remove(&header.seq_no.into())?;
                // Who asked may have given up.
                let _ = sender.send((header.key, body.to_vec()));
                return Some(());
            }
            share::spread(&self.taps, message);
            Some(())
        });
        if understood.is_none() {
            self.add(|counts| &counts.unexpected, 1);
        }
    }

    fn spread(&self, told: &Told) {
        self.add(|counts| &counts.unheard, self.listeners.tell(told));
    }
}
