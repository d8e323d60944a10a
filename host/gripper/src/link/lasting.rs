//! A view's link: other programs may use it too, and it comes back by itself, because people leave views open while a gripper is
//! switched off or a cable is out.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use messages::Counters;

use super::client::lock;
use super::place::way;
use super::share::Share;
use super::{Address, Link, LinkError};
use crate::source::{Listeners, Order, OrderError, Setup, Source, Statistics, Told, WAITING};

/// How often a gripper that is gone is tried again, and how often the thread looks whether it is still wanted.
const AGAIN: Duration = Duration::from_millis(100);
/// When a [`Lasting`] link ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// As soon as the gripper is gone.
    WithTheGripper,
    /// When it is dropped. It is opened again whenever it has closed, and listeners hear the gripper's setup each time.
    WithItsUser,
}

/// A link to a gripper that other programs of this user may use as well: [`Link::open`] finds it.
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
    ends: Ends,
    stop: AtomicBool,
    closed: AtomicBool,
}

impl Lasting {
    /// Connects.
    ///
    /// # Errors
    /// Nobody is there now.
    pub fn open(address: &Address, ends: Ends) -> Result<Self, LinkError> {
        let (link, share) = connect(address)?;
        let shared = Arc::new(Shared {
            address: address.clone(),
            link: Mutex::new(Some(link.clone())),
            before: Mutex::default(),
            listeners: Listeners::default(),
            ends,
            stop: AtomicBool::new(false),
            closed: AtomicBool::new(false),
        });
        let for_thread = shared.clone();
        let told = link.listen();
        let thread = std::thread::Builder::new().name("lasting link".into());
        let thread = thread.spawn(move || for_thread.last(link, share, &told)).map_err(LinkError::Start)?;
        Ok(Self { shared, thread: Some(thread) })
    }
}

impl Shared {
    /// Passes on what the links report, one after the other.
    fn last(&self, link: Arc<Link>, share: Option<Share>, told: &Receiver<Told>) {
        self.pass_on(told);
        drop(share);
        self.put_away(&link);
        drop(link);
        while self.ends == Ends::WithItsUser && !self.stop.load(Ordering::Acquire) {
            if let Ok((link, share)) = connect(&self.address) {
                let told = link.listen();
                if let Ok(setup) = Source::setup(&*link) {
                    self.listeners.tell(&Told::Setup(Box::new(setup)));
                    *lock(&self.link) = Some(link.clone());
                    self.pass_on(&told);
                }
                drop(share);
                self.put_away(&link);
            }
            std::thread::sleep(AGAIN);
        }
        self.closed.store(true, Ordering::Release);
        self.listeners.close();
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

    fn sign(&self) {
        if let Ok(link) = self.shared.link() {
            link.sign();
        }
    }

    fn order(&self, order: &Order) -> Result<(), OrderError> {
        self.shared.link()?.order(order)
    }

    fn is_closed(&self) -> bool {
        self.shared.closed.load(Ordering::Acquire)
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

/// Connects to the gripper and lets others in; or, if another program has done so, through that.
fn connect(address: &Address) -> Result<(Arc<Link>, Option<Share>), LinkError> {
    if way(address).is_some() {
        return Ok((Arc::new(Link::open(address)?), None));
    }
    let link = Arc::new(Link::open_alone(address)?);
    // Without a place for the socket, nobody else is let in.
    let share = Share::open(address, &link).ok();
    Ok((link, share))
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

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};
    use std::os::unix::net::{UnixListener, UnixStream};

    use messages::frame::{Decoder, FRAME, MESSAGE, encode, message};
    use messages::{GetSettings, GetVersion, PROTOCOL_VERSION, Settings, Version};
    use model_core::size::Lists;
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
            lists: Lists::TARGET,
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
                    message(
                        &header(GetSettings::RESP_KEY),
                        &Settings { fingers: [None; messages::FINGERS], ..Settings::DEFAULT },
                        &mut scratch,
                    )
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
        assert!(Lasting::open(&address, Ends::WithItsUser).is_err(), "nobody was ever there");
        let listener = UnixListener::bind(&path).unwrap();
        let lasting = Lasting::open(&address, Ends::WithItsUser).unwrap();
        let told = lasting.hear(WAITING);
        for round in 0..3 {
            let (peer, _) = listener.accept().unwrap();
            let ours = peer.try_clone().unwrap();
            let serving = std::thread::spawn(move || serve(peer));
            let other = loop {
                // Let in by the first one: this listener has one connection at a time.
                match way(&address) {
                    Some(way) => break Link::over_stream(way).unwrap(),
                    None => std::thread::sleep(AGAIN / 10),
                }
            };
            assert_eq!(other.version().unwrap().board.as_str(), "peer");
            if round > 0 {
                // It says when it is back.
                assert!(matches!(told.recv_timeout(LONG), Ok(Told::Setup(setup)) if setup.board == "peer"));
            }
            while lasting.setup().is_err() {
                std::thread::sleep(AGAIN / 10);
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
