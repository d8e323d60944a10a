//! A bus on which every party hears all others: pseudo-terminals, sockets and simulated servos.
//!
//! One thread waits for all ports at once. It never waits for one of them: what a party has no room for is lost, and
//! counted. Pseudo-terminals and servos have a baud rate, and those of different rates do not understand each other.

use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::device::{Answer, Servo, Statistics, Truth};
use super::fault::Fault;
use super::port::{Listener, Port, PortError};

/// The longest wait without a look at the servos' clocks.
const IDLE: Duration = Duration::from_millis(50);

/// A bus that does not run yet.
#[derive(Debug)]
pub struct Hub {
    ports: Vec<(u64, Port)>,
    listeners: Vec<Listener>,
    servos: Vec<Arc<Mutex<Servo>>>,
    epoch: Instant,
    next: u64,
    lost: Arc<AtomicU64>,
}

/// A servo on a bus, from outside: the truth, the counters, and faults on purpose.
#[derive(Clone, Debug)]
pub struct Handle {
    servo: Arc<Mutex<Servo>>,
    epoch: Instant,
}

/// A bus that runs until this is dropped (or [`Running::stop`] is called).
#[derive(Debug)]
pub struct Running {
    wake: UnixStream,
    thread: Option<JoinHandle<()>>,
    lost: Arc<AtomicU64>,
}

/// Who speaks: a port by its number, or a servo by its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Speaker {
    Port(u64),
    Servo(usize),
}

/// An answer that waits for its time.
#[derive(Debug)]
struct Pending {
    due: Instant,
    by: usize,
    bytes: Vec<u8>,
}

impl Default for Hub {
    fn default() -> Self {
        Self::new()
    }
}

impl Hub {
    /// A bus without parties. The servos' time begins now.
    pub fn new() -> Self {
        Self {
            ports: Vec::new(),
            listeners: Vec::new(),
            servos: Vec::new(),
            epoch: Instant::now(),
            next: 0,
            lost: Arc::default(),
        }
    }

    /// Puts a servo on the bus.
    pub fn servo(&mut self, servo: Servo) -> Handle {
        let servo = Arc::new(Mutex::new(servo));
        self.servos.push(servo.clone());
        Handle { servo, epoch: self.epoch }
    }

    /// Opens a raw pseudo-terminal; gives the path for the program that wants a serial port.
    ///
    /// # Errors
    /// The system has none.
    pub fn pty(&mut self) -> Result<PathBuf, PortError> {
        let (port, path) = Port::pty()?;
        self.add(port);
        Ok(path)
    }

    /// Listens on a unix socket; everyone who connects is a party. A socket left behind is replaced, and removed at
    /// the end.
    ///
    /// # Errors
    /// The path cannot be used.
    pub fn listen_unix(&mut self, path: &Path) -> Result<(), PortError> {
        self.listeners.push(Listener::unix(path)?);
        Ok(())
    }

    /// Connects to a unix socket on which another program listens.
    ///
    /// # Errors
    /// Nobody listens there.
    pub fn connect_unix(&mut self, path: &Path) -> Result<(), PortError> {
        let failed = |source| PortError::Unix { path: path.to_owned(), action: "connected to", source };
        let stream = UnixStream::connect(path).map_err(failed)?;
        self.add(Port::unix(stream).map_err(failed)?);
        Ok(())
    }

    /// Listens on a TCP address; gives the address with its true port (0 asks for a free one).
    ///
    /// # Errors
    /// The address cannot be used.
    pub fn listen_tcp(&mut self, address: &str) -> Result<SocketAddr, PortError> {
        let failed = |source| PortError::Tcp { address: address.to_owned(), action: "listened on", source };
        let listener = TcpListener::bind(address).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let local = listener.local_addr().map_err(failed)?;
        self.listeners.push(Listener::Tcp(listener));
        Ok(local)
    }

    /// Connects to a TCP address.
    ///
    /// # Errors
    /// Nobody listens there.
    pub fn connect_tcp(&mut self, address: impl ToSocketAddrs + std::fmt::Display) -> Result<(), PortError> {
        let failed = |source| PortError::Tcp { address: address.to_string(), action: "connected to", source };
        let stream = TcpStream::connect(&address).map_err(failed)?;
        self.add(Port::tcp(stream).map_err(failed)?);
        Ok(())
    }

    /// A party inside this process.
    ///
    /// # Errors
    /// The system has no more sockets.
    pub fn stream(&mut self) -> Result<UnixStream, PortError> {
        let (ours, theirs) = UnixStream::pair().map_err(PortError::Start)?;
        self.add(Port::unix(ours).map_err(PortError::Start)?);
        Ok(theirs)
    }

    fn add(&mut self, port: Port) {
        self.ports.push((self.next, port));
        self.next += 1;
    }

    /// Starts the bus in a thread of its own.
    ///
    /// # Errors
    /// The system has no more threads or sockets.
    pub fn spawn(mut self) -> Result<Running, PortError> {
        let (wake, woken) = UnixStream::pair().map_err(PortError::Start)?;
        let lost = self.lost.clone();
        let thread =
            std::thread::Builder::new().name("bus".into()).spawn(move || self.run(&woken)).map_err(PortError::Start)?;
        Ok(Running { wake, thread: Some(thread), lost })
    }

    /// Runs until the other end of `woken` is closed.
    fn run(&mut self, woken: &UnixStream) {
        let mut pending: Vec<Pending> = Vec::new();
        let mut chunk = [0; 4096];
        loop {
            let now = Instant::now();
            // In the order of their times; those of one time in the order in which they were given.
            while let Some(first) = (0..pending.len()).min_by_key(|&at| pending[at].due)
                && pending[first].due <= now
            {
                let Pending { by, bytes, .. } = pending.remove(first);
                self.pass_on(Speaker::Servo(by), &bytes, &mut pending);
            }
            let now_us = self.now_us();
            for (by, servo) in self.servos.iter().enumerate() {
                let mut servo = lock(servo);
                if servo.deadline().is_some_and(|deadline| deadline <= now_us)
                    && let Some(Answer { bytes, delay_us }) = servo.poll(now_us)
                {
                    pending.push(Pending { due: now + Duration::from_micros(u64::from(delay_us)), by, bytes });
                }
            }
            let wait = pending.iter().map(|answer| answer.due.saturating_duration_since(now)).min();
            let Some(ready) = self.wait(wait.unwrap_or(IDLE).min(IDLE), woken) else {
                return;
            };
            if ready.is_empty() {
                let now_us = self.now_us();
                for servo in &self.servos {
                    lock(servo).advance(now_us);
                }
            }
            for number in ready {
                let Some(place) = self.ports.iter().position(|(known, _)| *known == number) else {
                    continue;
                };
                match self.ports[place].1.receive(&mut chunk) {
                    None => {}
                    Some(0) => {
                        self.ports.remove(place);
                    }
                    Some(count) => self.pass_on(Speaker::Port(number), &chunk[..count], &mut pending),
                }
            }
            while let Some(port) = self.listeners.iter().find_map(Listener::accept) {
                self.add(port);
            }
        }
    }

    /// Waits for bytes; gives the numbers of the ports that have some, or nothing if the bus is to end.
    fn wait(&self, longest: Duration, woken: &UnixStream) -> Option<Vec<u64>> {
        let mut watched: Vec<PollFd<'_>> = vec![PollFd::new(woken, PollFlags::IN)];
        watched.extend(self.listeners.iter().map(|listener| PollFd::new(listener, PollFlags::IN)));
        watched.extend(self.ports.iter().map(|(_, port)| PollFd::new(port, PollFlags::IN)));
        let longest = Timespec { tv_sec: longest.as_secs() as i64, tv_nsec: i64::from(longest.subsec_nanos()) };
        // An interrupted wait is a short one.
        let _ = poll(&mut watched, Some(&longest));
        let ready = |watched: &PollFd<'_>| !watched.revents().is_empty();
        if ready(&watched[0]) {
            return None;
        }
        let ports = &watched[1 + self.listeners.len()..];
        Some(
            self.ports
                .iter()
                .zip(ports)
                .filter(|(_, watched)| ready(watched))
                .map(|((number, _), _)| *number)
                .collect(),
        )
    }

    /// Lets all but the speaker hear bytes.
    fn pass_on(&mut self, by: Speaker, bytes: &[u8], pending: &mut Vec<Pending>) {
        let now_us = self.now_us();
        let now = Instant::now();
        let rate = match by {
            Speaker::Port(number) => {
                self.ports.iter().find(|(known, _)| *known == number).and_then(|(_, port)| port.rate())
            }
            Speaker::Servo(index) => self.servos.get(index).and_then(|servo| lock(servo).rate()),
        };
        for (index, servo) in self.servos.iter().enumerate().filter(|&(index, _)| by != Speaker::Servo(index)) {
            let mut servo = lock(servo);
            if !understand(rate, servo.rate()) {
                servo.noise(now_us);
                continue;
            }
            for answer in servo.hear(now_us, bytes) {
                let due = now + Duration::from_micros(u64::from(answer.delay_us));
                pending.push(Pending { due, by: index, bytes: answer.bytes });
            }
        }
        for (_, port) in self.ports.iter_mut().filter(|(number, _)| by != Speaker::Port(*number)) {
            if !understand(rate, port.rate()) {
                continue;
            }
            let lost = port.send(bytes);
            self.lost.fetch_add(lost as u64, Ordering::Relaxed);
        }
    }

    fn now_us(&self) -> u64 {
        self.epoch.elapsed().as_micros() as u64
    }
}

/// Whether bytes sent at one rate are read at another: a receiver samples a byte's last bit at 95 % of its time.
fn understand(sent: Option<u32>, read: Option<u32>) -> bool {
    sent.zip(read).is_none_or(|(sent, read)| u64::from(sent.abs_diff(read)) * 20 <= u64::from(read))
}

impl Running {
    /// Bytes that a party had no room for.
    pub fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }

    /// Ends the bus.
    pub fn stop(self) {}
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.wake.shutdown(std::net::Shutdown::Both);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Handle {
    /// What is true of the servo now.
    pub fn truth(&self) -> Truth {
        let mut servo = lock(&self.servo);
        servo.advance(self.now_us());
        servo.truth()
    }

    /// The servo's counters.
    pub fn statistics(&self) -> Statistics {
        lock(&self.servo).statistics()
    }

    /// What becomes of the answers to come, one each, behind those said before.
    pub fn inject(&self, faults: impl IntoIterator<Item = Fault>) {
        lock(&self.servo).inject(faults);
    }

    /// Makes the servo deaf and dumb for a while of wall time; [`Duration::MAX`] until [`Handle::speak`].
    pub fn silence(&self, duration: Duration) {
        let us = u64::try_from(duration.as_micros()).unwrap_or(u64::MAX);
        lock(&self.servo).silence(self.now_us().saturating_add(us));
    }

    /// Ends the silence.
    pub fn speak(&self) {
        lock(&self.servo).silence(0);
    }

    /// Sets bits of Hardware Error Status; those that Shutdown names turn the torque off.
    pub fn fail(&self, bits: u8) {
        lock(&self.servo).fail(bits);
    }

    /// Cuts the power for a moment: RAM is lost, the torque is off.
    pub fn reset(&self) {
        lock(&self.servo).reset();
    }

    /// Anything else that a servo can be asked.
    pub fn with<R>(&self, ask: impl FnOnce(&mut Servo) -> R) -> R {
        ask(&mut lock(&self.servo))
    }

    fn now_us(&self) -> u64 {
        self.epoch.elapsed().as_micros() as u64
    }
}

/// A servo is sound even if another thread stopped while it held it.
fn lock(servo: &Mutex<Servo>) -> MutexGuard<'_, Servo> {
    servo.lock().unwrap_or_else(PoisonError::into_inner)
}
