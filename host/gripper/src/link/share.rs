//! One gripper, several programs: whoever views it lets others in.
//!
//! A gripper's port has one user. The program that shows a gripper listens on a socket in a folder of this user's own, where
//! [`Link::open`] looks first. Requests are passed on under numbers of the first program's link, so that everybody gets the answers to
//! their own; what the gripper reports goes to all.

use std::io::{self, ErrorKind, Read, Write};
use std::net::Shutdown;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use messages::frame::{Decoder, FRAME, MESSAGE, encode, message};
use postcard_rpc::header::{VarHeader, VarKey, VarSeq};
use postcard_rpc::standard_icd::{ERROR_KEY, WireError};

use super::client::lock;
use super::place::place;
use super::{Address, Link};

/// How often is looked for a new program, and whether to stop.
const GLANCE: Duration = Duration::from_millis(50);
/// Messages that wait for a program that does not read; what comes then is lost to it.
const WAITING: usize = 4096;
/// How long a write may wait for a program that takes nothing.
const PATIENCE: Duration = Duration::from_secs(3);

/// A link that others may use, until this is dropped.
#[derive(Debug)]
pub(super) struct Share {
    path: PathBuf,
    stop: Arc<AtomicBool>,
    guests: Arc<Guests>,
    thread: Option<JoinHandle<()>>,
}

/// The programs that were let in, by their numbers.
type Guests = Mutex<Vec<(u64, UnixStream)>>;

impl Share {
    /// Lets others in.
    ///
    /// # Errors
    /// There is no folder for the socket, or somebody else shares this link already.
    pub(super) fn open(address: &Address, link: &Arc<Link>) -> io::Result<Self> {
        Self::at(&place(address)?, link)
    }

    fn at(path: &Path, link: &Arc<Link>) -> io::Result<Self> {
        // A socket that nobody listens on is what a program that was killed has left behind.
        if UnixStream::connect(path).is_err_and(|error| error.kind() == ErrorKind::ConnectionRefused) {
            std::fs::remove_file(path)?;
        }
        let listener = UnixListener::bind(path)?;
        listener.set_nonblocking(true)?;
        let (stop, guests) = (Arc::<AtomicBool>::default(), Arc::<Guests>::default());
        let (stopped, known, link) = (stop.clone(), guests.clone(), link.clone());
        let thread = std::thread::Builder::new().name("shared link".into()).spawn(move || {
            let mut number = 0;
            while !stopped.load(Ordering::Acquire) {
                match listener.accept() {
                    Ok((guest, _)) => {
                        number += 1;
                        // One that cannot be served is closed, and tries again.
                        let _ = receive(number, guest, &known, &link);
                    }
                    Err(_) => std::thread::sleep(GLANCE),
                }
            }
        })?;
        Ok(Self { path: path.to_owned(), stop, guests, thread: Some(thread) })
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        let _ = std::fs::remove_file(&self.path);
        for (_, guest) in lock(&self.guests).drain(..) {
            let _ = guest.shutdown(Shutdown::Both);
        }
    }
}

/// Serves another program in threads of its own, which end with its stream.
fn receive(number: u64, guest: UnixStream, known: &Arc<Guests>, link: &Arc<Link>) -> io::Result<()> {
    guest.set_nonblocking(false)?;
    guest.set_write_timeout(Some(PATIENCE))?;
    let (from, to) = (guest.try_clone()?, guest.try_clone()?);
    let (mail, messages) = sync_channel(WAITING);
    link.tap(mail.clone());
    let thread = || std::thread::Builder::new().name("guest of the link".into());
    thread().spawn(move || write(to, &messages))?;
    lock(known).push((number, guest));
    let (link, known) = (link.clone(), known.clone());
    thread().spawn(move || {
        read(from, &mail, &link);
        lock(&known).retain(|(guest, _)| *guest != number);
    })?;
    Ok(())
}

fn write(mut to: UnixStream, messages: &Receiver<Vec<u8>>) {
    let mut frame = vec![0; FRAME];
    for message in messages {
        let Ok(bytes) = encode(&message, &mut frame) else { continue };
        if to.write_all(bytes).is_err() {
            break;
        }
    }
    let _ = to.shutdown(Shutdown::Both);
}

/// Passes requests on, each by itself: a stop does not wait behind what is still unanswered.
fn read(mut from: UnixStream, mail: &SyncSender<Vec<u8>>, link: &Arc<Link>) {
    let (mut decoder, mut chunk) = (Box::new(Decoder::<FRAME>::new()), [0; 1024]);
    while let Ok(count @ 1..) = from.read(&mut chunk) {
        let mut bytes = &chunk[..count];
        while let Some(event) = decoder.feed(&mut bytes) {
            let Some((header, body)) = event.ok().and_then(|message| VarHeader::take_from_slice(message)) else {
                continue;
            };
            let (body, mail, link) = (body.to_vec(), mail.clone(), link.clone());
            let thread = std::thread::Builder::new().name("request of a guest".into());
            let passed = thread.spawn(move || {
                // Without an answer there is none for the guest either: it has its own patience.
                let Ok((key, answer)) = link.pass(header.key, &body, "passed on") else { return };
                let _ = mail.send(answered(key, header.seq_no, &answer));
                link.was_set(header.key);
            });
            if passed.is_err() {
                return;
            }
        }
    }
    let _ = from.shutdown(Shutdown::Both);
}

/// A message: header, then body.
fn answered(key: VarKey, seq_no: VarSeq, body: &[u8]) -> Vec<u8> {
    let mut scratch = vec![0; MESSAGE];
    let mut bytes = |key| message(&VarHeader { key, seq_no }, &(), &mut scratch).map(<[u8]>::to_vec);
    match bytes(key) {
        Ok(mut answer) => {
            answer.extend(body);
            answer
        }
        // A header always fits.
        Err(_) => {
            let mut scratch = vec![0; MESSAGE];
            let header = VarHeader { key: VarKey::Key8(ERROR_KEY), seq_no };
            message(&header, &WireError::SerFailed, &mut scratch).map(<[u8]>::to_vec).unwrap_or_default()
        }
    }
}

#[cfg(test)]
mod tests {
    use messages::{Counters, GetCounters, GetVersion};
    use postcard_rpc::Endpoint;

    use super::super::tests::{report, with_peer};
    use super::*;
    use crate::link::Told;
    use crate::source::Source;

    const LONG: Duration = Duration::from_secs(30);

    /// Each of three programs gets the answers to its own requests, and all hear the reports.
    #[test]
    fn several_programs_share_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("shared");
        // The peer answers with the number under which it was asked: who gets another one's answer sees it.
        let link = Arc::new(with_peer(LONG, |number| {
            let asked: u32 = number.into();
            let counters = Counters { ticks: asked, ..Counters::default() };
            [super::super::tests::frame(GetCounters::RESP_KEY, number, &counters), report(asked)].concat()
        }));
        let share = Share::at(&path, &link).unwrap();
        assert!(Share::at(&path, &link).is_err(), "it is shared already");
        let guests: Vec<Link> =
            (0..2).map(|_| Link::over_stream(UnixStream::connect(&path).unwrap()).unwrap()).collect();
        let told: Vec<_> = guests.iter().map(Link::listen).collect();
        let mut numbers: Vec<u32> = Vec::new();
        for _ in 0..10 {
            numbers.push(link.counters().unwrap().ticks);
            numbers.extend(guests.iter().map(|guest| guest.counters().unwrap().ticks));
        }
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(numbers.len(), 30, "each request is asked once: {numbers:?}");
        for told in &told {
            assert!(matches!(told.recv_timeout(LONG), Ok(Told::Report(_))));
        }
        // What the gripper does not understand, it says to the one who asked.
        assert!(guests[0].ask::<GetVersion>(&()).is_err());
        assert!(guests[1].counters().is_ok() && !Source::is_closed(&guests[1]));

        drop(share);
        for told in told {
            while told.recv_timeout(LONG).is_ok() {}
        }
        assert!(guests.iter().all(|guest| guest.counters().is_err()) && link.counters().is_ok());
        assert!(!path.exists());
    }
}
