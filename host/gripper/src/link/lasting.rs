//! A link that comes back by itself: for views, which people leave open while a gripper is switched off or a cable is out.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use messages::Counters;

use super::{Address, Link, LinkError};
use crate::source::{Listeners, Order, OrderError, Setup, Source, Statistics, Told, WAITING};

/// How often a gripper that is gone is tried again, and how often the thread looks whether it is still wanted.
const AGAIN: Duration = Duration::from_millis(100);
/// How long a gripper may take to answer who it is after the link has come back. Until then it is tried again.
const PATIENCE: Duration = Duration::from_secs(2);

/// A link to a gripper that is opened again whenever it has closed. Listeners hear the gripper's setup each time.
#[derive(Debug)]
pub struct Lasting {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    address: Address,
    /// None while the gripper is gone.
    link: Mutex<Option<Arc<Link>>>,
    /// Of the links before this one.
    before: Mutex<Statistics>,
    listeners: Listeners,
    stop: AtomicBool,
}

impl Lasting {
    /// Connects.
    ///
    /// # Errors
    /// Nobody is there now.
    pub fn open(address: &Address) -> Result<Self, LinkError> {
        let link = Arc::new(Link::open(address)?);
        let shared = Arc::new(Shared {
            address: address.clone(),
            link: Mutex::new(Some(link.clone())),
            before: Mutex::default(),
            listeners: Listeners::default(),
            stop: AtomicBool::new(false),
        });
        let for_thread = shared.clone();
        let told = link.listen();
        let thread = std::thread::Builder::new().name("lasting link".into());
        let thread = thread.spawn(move || for_thread.last(link, told)).map_err(LinkError::Start)?;
        Ok(Self { shared, thread: Some(thread) })
    }
}

impl Shared {
    /// Passes on what the links report, one after the other.
    fn last(&self, first: Arc<Link>, told: Receiver<Told>) {
        self.pass_on(&told);
        self.put_away(&first);
        drop(first);
        while !self.stop.load(Ordering::Acquire) {
            if let Some(link) = self.again() {
                let told = link.listen();
                if let Ok(setup) = Source::setup(&*link) {
                    self.listeners.tell(&Told::Setup(Box::new(setup)));
                    *lock(&self.link) = Some(link.clone());
                    self.pass_on(&told);
                }
                self.put_away(&link);
            }
            std::thread::sleep(AGAIN);
        }
        self.listeners.close();
    }

    fn again(&self) -> Option<Arc<Link>> {
        let mut link = Link::open(&self.address).ok()?;
        link.set_patience(PATIENCE);
        Some(Arc::new(link))
    }

    /// Until the link has closed or nobody wants it any more.
    fn pass_on(&self, told: &Receiver<Told>) {
        while !self.stop.load(Ordering::Acquire) {
            match told.recv_timeout(AGAIN) {
                Ok(told) => {
                    let unheard = self.listeners.tell(&told);
                    lock(&self.before).unheard += unheard;
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
        }
    }

    /// Keeps a link's counts.
    fn put_away(&self, link: &Link) {
        *lock(&self.link) = None;
        let mut before = lock(&self.before);
        *before = sum(*before, Link::statistics(link));
    }

    /// The link, if the gripper is there.
    fn link(&self) -> Result<Arc<Link>, OrderError> {
        lock(&self.link).clone().ok_or_else(|| LinkError::Closed.into())
    }
}

impl Source for Lasting {
    fn setup(&self) -> Result<Setup, OrderError> {
        self.shared.link()?.setup()
    }

    fn hear(&self, waiting: usize) -> Receiver<Told> {
        self.shared.listeners.add(waiting.max(WAITING))
    }

    fn statistics(&self) -> Statistics {
        let before = *lock(&self.shared.before);
        self.shared.link().map_or(before, |link| sum(before, Link::statistics(&link)))
    }

    fn counters(&self) -> Result<Option<Counters>, OrderError> {
        Source::counters(&*self.shared.link()?)
    }

    fn order(&self, order: &Order) -> Result<(), OrderError> {
        self.shared.link()?.order(order)
    }

    /// Never: the gripper may come back.
    fn is_closed(&self) -> bool {
        false
    }
}

impl Drop for Lasting {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn sum(a: Statistics, b: Statistics) -> Statistics {
    Statistics {
        frames: a.frames + b.frames,
        damaged: a.damaged + b.damaged,
        unexpected: a.unexpected + b.unexpected,
        missing_reports: a.missing_reports + b.missing_reports,
        unheard: a.unheard + b.unheard,
    }
}

/// The lock, also if another thread stopped while it held it.
fn lock<X>(mutex: &Mutex<X>) -> MutexGuard<'_, X> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};
    use std::os::unix::net::{UnixListener, UnixStream};

    use messages::frame::{Decoder, FRAME, MESSAGE, encode, message};
    use messages::{GetSettings, GetVersion, PROTOCOL_VERSION, Settings, Version};
    use postcard_rpc::Endpoint;
    use postcard_rpc::header::{VarHeader, VarKey};

    use super::*;

    /// How long anything may take, a busy PC included.
    const LONG: Duration = Duration::from_secs(30);

    /// Answers who it is, until the other end goes or this one is shut down.
    fn serve(mut peer: UnixStream) {
        let version = Version {
            protocol: PROTOCOL_VERSION,
            firmware: "1".try_into().unwrap(),
            fingers: 0,
            board: "peer".try_into().unwrap(),
            cost_hz: 1,
        };
        let (mut decoder, mut chunk) = (Decoder::<FRAME>::new(), [0; 256]);
        while let Ok(count @ 1..) = peer.read(&mut chunk) {
            let mut bytes = &chunk[..count];
            while let Some(event) = decoder.feed(&mut bytes) {
                let (asked, _) = VarHeader::take_from_slice(event.unwrap()).unwrap();
                let (mut scratch, mut line) = ([0; MESSAGE], [0; FRAME]);
                let header = |key| VarHeader { key: VarKey::Key8(key), seq_no: asked.seq_no };
                let answer = if asked.key == VarKey::Key8(GetVersion::REQ_KEY) {
                    message(&header(GetVersion::RESP_KEY), &version, &mut scratch)
                } else {
                    assert_eq!(asked.key, VarKey::Key8(GetSettings::REQ_KEY));
                    message(&header(GetSettings::RESP_KEY), &Settings::DEFAULT, &mut scratch)
                };
                let _ = peer.write_all(encode(answer.unwrap(), &mut line).unwrap());
            }
        }
    }

    #[test]
    fn a_gripper_that_comes_back_is_found_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("link");
        let address = Address::Unix(path.clone());
        assert!(Lasting::open(&address).is_err(), "nobody was ever there");
        let listener = UnixListener::bind(&path).unwrap();
        let lasting = Lasting::open(&address).unwrap();
        let told = lasting.hear(WAITING);
        for _ in 0..3 {
            let (peer, _) = listener.accept().unwrap();
            let ours = peer.try_clone().unwrap();
            let serving = std::thread::spawn(move || serve(peer));
            if lasting.setup().is_err() {
                // Not the first time: it says when it is back.
                assert!(matches!(told.recv_timeout(LONG), Ok(Told::Setup(setup)) if setup.board == "peer"));
                while lasting.setup().is_err() {
                    std::thread::sleep(AGAIN);
                }
            }
            ours.shutdown(std::net::Shutdown::Both).unwrap();
            serving.join().unwrap();
            while lasting.shared.link().is_ok() {
                std::thread::sleep(AGAIN / 10);
            }
            assert!(lasting.order(&Order::Hold(messages::Which::All)).is_err());
            assert!(!lasting.is_closed() && matches!(told.try_recv(), Err(std::sync::mpsc::TryRecvError::Empty)));
        }
        drop(lasting);
        assert!(told.recv().is_err(), "the channel ends with it");
    }
}
