//! A raw pseudo-terminal with servos behind it, for programs that want a serial port.

use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{JoinHandle, sleep, spawn};
use std::time::{Duration, Instant};

use dynamixel::{Device, StatusReturn, Timing};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

use crate::servo::Servo;

/// A PC may be busy: nobody loses patience.
const PATIENT: Timing = Timing { baud_rate: 1_000_000, latency_us: 1_000_000, status_return: StatusReturn::All };

/// Servos that answer on a pseudo-terminal until they are taken back.
pub struct Line {
    /// The serial port for the other program.
    pub path: PathBuf,
    /// Kept open, so that the terminal stays raw and the line does not hang up when the other program leaves.
    _peer: OwnedFd,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<(Vec<Servo>, Vec<u8>)>,
}

impl Line {
    pub fn new(servos: Vec<Servo>) -> Self {
        let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&controller).unwrap();
        unlockpt(&controller).unwrap();
        let path = PathBuf::from(ptsname(&controller, Vec::new()).unwrap().into_string().unwrap());
        let peer = open(&path, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty()).unwrap();
        // Raw before anyone else opens it: otherwise the line editor echoes, and swallows bytes such as 0x03 and 0x11.
        let mut settings = tcgetattr(&peer).unwrap();
        settings.make_raw();
        tcsetattr(&peer, OptionalActions::Now, &settings).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let thread = spawn({
            let stop = stop.clone();
            move || serve(File::from(controller), servos, &stop)
        });
        Line { path, _peer: peer, stop, thread }
    }

    /// Ends the service; gives the servos back and every byte that was heard.
    pub fn end(self) -> (Vec<Servo>, Vec<u8>) {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().unwrap()
    }
}

fn serve(mut port: File, servos: Vec<Servo>, stop: &AtomicBool) -> (Vec<Servo>, Vec<u8>) {
    let mut servos: Vec<(Device<256>, Servo)> = servos.into_iter().map(|servo| (Device::new(PATIENT), servo)).collect();
    let began = Instant::now();
    let mut heard = Vec::new();
    let mut chunk = [0; 256];
    while !stop.load(Ordering::Relaxed) {
        let wait = Timespec { tv_sec: 0, tv_nsec: 5_000_000 };
        if poll(&mut [PollFd::new(&port, PollFlags::IN)], Some(&wait)).unwrap() == 0 {
            continue;
        }
        let count = port.read(&mut chunk).unwrap();
        heard.extend_from_slice(&chunk[..count]);
        let mut spoken = vec![(0, None, chunk[..count].to_vec())];
        let mut now_us = 0;
        while let Some(first) = (0..spoken.len()).min_by_key(|&at| spoken[at].0) {
            let (at_us, by, bytes): (u64, Option<usize>, Vec<u8>) = spoken.remove(first);
            sleep(Duration::from_micros(at_us - now_us));
            now_us = at_us;
            if by.is_some() {
                port.write_all(&bytes).unwrap();
            }
            for (index, (device, servo)) in servos.iter_mut().enumerate().filter(|&(index, _)| Some(index) != by) {
                let mut rest = bytes.as_slice();
                while let Some(reply) = device.hear(began.elapsed().as_micros() as u64, &mut rest, servo) {
                    spoken.push((at_us + u64::from(reply.delay_us), Some(index), reply.bytes.to_vec()));
                }
            }
        }
    }
    (servos.into_iter().map(|(_, servo)| servo).collect(), heard)
}
