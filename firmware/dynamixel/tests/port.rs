//! The master on ports that fail: noise, closed lines, transmitters that never finish.

use std::collections::VecDeque;
use std::future::{pending, poll_fn};
use std::task::Poll;

use dynamixel::{Answer, Encoder, Error, Id, Master, StatusReturn, Timing, xm430};
use embassy_futures::block_on;
use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{ErrorKind, ErrorType, Read, Write};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Noise;

impl std::fmt::Display for Noise {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("noise")
    }
}

impl std::error::Error for Noise {}

impl embedded_io_async::Error for Noise {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// What a read gives; [`Step::Silence`] ends a discard.
#[derive(Clone)]
enum Step {
    Bytes(Vec<u8>),
    Noise,
    Closed,
    Silence,
}

#[derive(Default)]
struct Port {
    steps: VecDeque<Step>,
    /// Given for ever once the steps are used up; nothing means silence.
    then: Option<Step>,
    /// Bytes the transmitter takes at once; nothing means that it never does.
    takes: Option<usize>,
    sent: Vec<u8>,
}

impl ErrorType for Port {
    type Error = Noise;
}

impl Read for Port {
    async fn read(&mut self, into: &mut [u8]) -> Result<usize, Noise> {
        match self.steps.pop_front().or_else(|| self.then.clone()) {
            Some(Step::Bytes(mut bytes)) => {
                let rest = bytes.split_off(into.len().min(bytes.len()));
                if !rest.is_empty() {
                    self.steps.push_front(Step::Bytes(rest));
                }
                into[..bytes.len()].copy_from_slice(&bytes);
                Ok(bytes.len())
            }
            Some(Step::Noise) => Err(Noise),
            Some(Step::Closed) => Ok(0),
            Some(Step::Silence) | None => pending().await,
        }
    }
}

impl Write for Port {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Noise> {
        let Some(most) = self.takes else { return pending().await };
        let count = bytes.len().min(most);
        self.sent.extend_from_slice(&bytes[..count]);
        Ok(count)
    }

    async fn flush(&mut self) -> Result<(), Noise> {
        Ok(())
    }
}

/// Over after it has been looked at so often.
struct Looks(u32);

impl DelayNs for Looks {
    async fn delay_ns(&mut self, _: u32) {
        let mut left = self.0;
        poll_fn(|_| {
            left -= 1;
            if left == 0 { Poll::Ready(()) } else { Poll::Pending }
        })
        .await
    }
}

fn one() -> Id {
    Id::new(1).unwrap()
}

fn answer() -> Vec<u8> {
    Encoder::status(&mut [0; 32], one(), false, None).bytes(&[1, 2, 0, 0]).finish().unwrap().to_vec()
}

/// Asks for the present position on this port.
fn ask(port: Port) -> (Result<Answer<i32>, Error<Noise>>, Port) {
    let mut master = Master::<_, _, 64>::new(port, Looks(3), Timing::at(1_000_000));
    let result = block_on(master.get(one(), xm430::PRESENT_POSITION));
    (result, master.into_port())
}

fn port(steps: impl IntoIterator<Item = Step>, then: Option<Step>) -> Port {
    Port { steps: steps.into_iter().collect(), then, takes: Some(5), ..Port::default() }
}

#[test]
fn noise_before_the_question_and_before_the_answer_is_passed_over() {
    let steps = [
        Step::Noise,
        Step::Bytes(vec![0xFF; 40]),
        Step::Silence,
        Step::Noise,
        Step::Bytes(vec![0xFF]),
        Step::Bytes(answer()),
    ];
    let (result, port) = ask(port(steps, None));
    assert_eq!(result, Ok(Answer { value: 513, alert: false }));
    assert_eq!(port.sent, [0xFF, 0xFF, 0xFD, 0x00, 1, 7, 0, 0x02, 0x84, 0, 4, 0, 0x1D, 0x15]);
}

#[test]
fn noise_and_no_answer() {
    let (result, _) = ask(port([Step::Silence, Step::Noise], None));
    assert_eq!(result, Err(Error::Port(Noise)));
}

#[test]
fn a_port_that_only_fails() {
    let (result, _) = ask(port([Step::Silence], Some(Step::Noise)));
    assert_eq!(result, Err(Error::Port(Noise)));
    let (result, port) = ask(port([], Some(Step::Noise)));
    assert_eq!(result, Err(Error::Port(Noise)));
    assert_eq!(port.sent, []);
}

#[test]
fn a_closed_port() {
    assert_eq!(ask(port([], Some(Step::Closed))).0, Err(Error::Closed));
    assert_eq!(ask(port([Step::Silence], Some(Step::Closed))).0, Err(Error::Closed));
    assert_eq!(ask(Port { takes: Some(0), ..port([], None) }).0, Err(Error::Closed));
}

#[test]
fn a_transmitter_that_never_finishes() {
    assert_eq!(ask(Port { takes: None, ..port([], None) }).0, Err(Error::Closed));
}

#[test]
fn deadlines_follow_the_baud_rate() {
    let timing = |baud_rate| Timing { baud_rate, latency_us: 0, status_return: StatusReturn::All };
    assert_eq!(timing(1_000_000).wire_us(15), 150);
    assert_eq!(timing(57_600).wire_us(14), 2_431);
    assert_eq!(timing(0).wire_us(usize::MAX), u32::MAX);
    assert_eq!(timing(1).wire_us(1), 10_000_000);
}
