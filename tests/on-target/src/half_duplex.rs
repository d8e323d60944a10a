//! The boards' half-duplex line on a simulated USART: the direction is turned exactly at the end of the last stop bit,
//! however late the interrupt comes, and nothing is lost or echoed.

use core::cell::RefCell;

use stm32::{Line, Status, Until, Usart};

/// What the gripper asks.
const WORDS: &[u8] = b"\xff\xff\xfd\x00\x01\x07\x00\x02";
/// What the servo answers.
const ANSWER: &[u8] = b"123456789";

/// What a USART and its transceiver do, by bit times; one step is one byte's time.
#[derive(Default)]
struct Wire {
    /// Byte in the data register, and in the shift register.
    data: Option<u8>,
    shift: Option<u8>,
    complete: bool,
    until: Option<Until>,
    driven: bool,
    received: Option<u8>,
    idle: bool,
    overrun: bool,
    /// What went out, and what went out while nobody drove the line.
    sent: heapless::Vec<u8, 64>,
    unheard: usize,
    /// How often the line was left before the last stop bit was out.
    cut: usize,
    /// What a servo answers, so many bytes' time after the last stop bit, and how many bytes of it met a line that was driven still.
    answer: heapless::Deque<u8, 64>,
    delay: usize,
    collisions: usize,
}

struct Simulated(RefCell<Wire>);

impl Simulated {
    fn new() -> Self {
        Self(RefCell::new(Wire { complete: true, ..Wire::default() }))
    }

    /// A byte's time passes; what is sent is heard as well.
    fn step(&self) {
        let mut wire = self.0.borrow_mut();
        if wire.sent.len() == WORDS.len() && wire.shift.is_none() {
            wire.reply();
        }
        if let Some(byte) = wire.shift.take() {
            if !wire.driven {
                wire.unheard += 1;
            }
            assert!(wire.sent.push(byte).is_ok());
            wire.hear(byte);
        }
        wire.shift = wire.data.take();
        if wire.shift.is_none() {
            wire.complete = true;
        }
    }

    /// A byte from somebody else.
    fn hear(&self, byte: u8) {
        self.0.borrow_mut().hear(byte);
    }

    /// Whether the USART raises its interrupt.
    fn raised(&self) -> bool {
        let wire = self.0.borrow();
        let transmit = match wire.until {
            Some(Until::Ready) => wire.data.is_none(),
            Some(Until::Complete) => wire.complete,
            _ => false,
        };
        transmit || wire.received.is_some() || wire.idle || wire.overrun
    }
}

impl Wire {
    /// A byte's time of the servo's.
    fn reply(&mut self) {
        if self.delay > 0 {
            self.delay -= 1;
        } else if let Some(byte) = self.answer.pop_front() {
            self.collisions += usize::from(self.driven);
            self.hear(byte);
        }
    }

    fn hear(&mut self, byte: u8) {
        self.overrun |= self.received.replace(byte).is_some();
    }
}

impl Usart for Simulated {
    fn status(&self) -> Status {
        let wire = self.0.borrow();
        Status {
            received: wire.received.is_some(),
            idle: wire.idle,
            damaged: wire.overrun,
            ready: wire.data.is_none(),
            complete: wire.complete,
        }
    }

    fn take(&self) -> u8 {
        self.0.borrow_mut().received.take().unwrap_or(0xEE)
    }

    fn clear(&self) {
        let mut wire = self.0.borrow_mut();
        (wire.idle, wire.overrun) = (false, false);
    }

    fn give(&self, byte: u8) {
        let mut wire = self.0.borrow_mut();
        wire.complete = false;
        if wire.shift.is_none() { wire.shift = Some(byte) } else { wire.data = Some(byte) }
    }

    fn interrupt(&self, until: Until) {
        self.0.borrow_mut().until = Some(until);
    }

    fn drive(&self, on: bool) {
        let mut wire = self.0.borrow_mut();
        if !on && !wire.complete {
            wire.cut += 1;
        }
        wire.driven = on;
    }

    fn is_half_duplex(&self) -> bool {
        true
    }
}

#[embedded_test::tests(executor = mps2::Executor::new())]
mod tests {
    use super::*;
    use mps2::Board;

    #[init]
    fn init() -> Board {
        mps2::init()
    }

    /// Sends while the interrupt is served only every `late`-th byte's time; returns how many byte times the line stayed
    /// driven after the last stop bit.
    fn send(line: &Line<64, 32>, usart: &Simulated, late: usize) -> usize {
        assert_eq!(line.give(WORDS), WORDS.len());
        line.service(usart, 7);
        assert!(usart.0.borrow().driven, "driven before the first start bit is over");
        let (mut after, mut time) = (0, 0_usize);
        while !line.is_done() {
            usart.step();
            time += 1;
            assert!(time < 1000, "the line is never left");
            if usart.0.borrow().complete && usart.0.borrow().sent.len() == WORDS.len() {
                after += 1;
            }
            if time.is_multiple_of(late) {
                // As long as it is raised, as hardware does.
                let mut entries = 0;
                while usart.raised() {
                    line.service(usart, 7);
                    entries += 1;
                    assert!(entries < 10, "the interrupt does not end");
                }
            }
        }
        assert_eq!(usart.0.borrow().sent.as_slice(), WORDS);
        after
    }

    #[test]
    fn the_line_is_left_at_the_last_stop_bit(_board: Board) {
        let (line, usart) = (Line::new(), Simulated::new());
        // One look at the line after the last stop bit: it is left then, without another byte's time.
        assert_eq!(send(&line, &usart, 1), 1);
        let wire = usart.0.borrow();
        assert!(!wire.driven && wire.unheard == 0 && wire.cut == 0);
        assert_eq!(wire.until, Some(Until::Never));
    }

    /// A late interrupt stretches the packet; it never cuts a byte off, and the line is left when it is served.
    #[test]
    fn a_late_interrupt_cuts_nothing(_board: Board) {
        for late in 2..6 {
            let (line, usart) = (Line::new(), Simulated::new());
            assert!(send(&line, &usart, late) <= late);
            let wire = usart.0.borrow();
            assert!(!wire.driven && wire.unheard == 0 && wire.cut == 0, "late by {}", late);
        }
    }

    /// Asks a servo that answers after so many bytes' time, while the interrupt is served so many bytes' time late once, at the last stop bit.
    /// Gives what was heard of the answer, and how many of its bytes met a driven line.
    fn ask(delay: usize, late: usize) -> (heapless::Vec<u8, 32>, usize) {
        let (line, usart) = (Line::<64, 32>::new(), Simulated::new());
        {
            let mut wire = usart.0.borrow_mut();
            wire.delay = delay;
            ANSWER.iter().for_each(|byte| assert!(wire.answer.push_back(*byte).is_ok()));
        }
        assert_eq!(line.give(WORDS), WORDS.len());
        line.service(&usart, 0);
        let mut blocked = 0;
        for _ in 0..100 {
            usart.step();
            let is_out = usart.0.borrow().sent.len() == WORDS.len();
            if is_out && blocked < late {
                blocked += 1;
                continue;
            }
            let mut entries = 0;
            while usart.raised() {
                line.service(&usart, 0);
                entries += 1;
                assert!(entries < 10, "the interrupt does not end");
            }
        }
        assert!(line.is_done());
        let (mut buffer, mut heard) = ([0; 32], heapless::Vec::new());
        let taken = line.take(&mut buffer);
        assert!(heard.extend_from_slice(&buffer[..taken]).is_ok());
        let collisions = usart.0.borrow().collisions;
        (heard, collisions)
    }

    /// As long as the interrupt is not later than the servo's return delay, its answer is heard whole and meets nobody on the line. One
    /// that is later costs the first bytes: why the interrupt runs from RAM, which no writing of flash holds up.
    #[test]
    fn an_answer_is_heard_if_the_interrupt_is_no_later_than_it(_board: Board) {
        for delay in 0..5 {
            for late in 0..=delay {
                let (heard, collisions) = ask(delay, late);
                assert_eq!((heard.as_slice(), collisions), (ANSWER, 0));
            }
            for late in delay + 1..delay + 4 {
                let (heard, collisions) = ask(delay, late);
                assert_eq!((heard.as_slice(), collisions), (&ANSWER[late - delay..], late - delay));
            }
        }
    }

    /// The interrupt may be raised at any time, without a reason.
    #[test]
    fn a_groundless_interrupt_changes_nothing(_board: Board) {
        let (line, usart) = (Line::<64, 32>::new(), Simulated::new());
        for _ in 0..3 {
            assert!(!line.service(&usart, 0));
        }
        assert_eq!(line.give(WORDS), WORDS.len());
        let mut steps = 0;
        while !line.is_done() {
            for _ in 0..5 {
                line.service(&usart, 0);
            }
            usart.step();
            steps += 1;
            assert!(steps < 1000, "the line is never left");
        }
        let wire = usart.0.borrow();
        assert_eq!((wire.sent.as_slice(), wire.cut, wire.unheard), (WORDS, 0, 0));
    }

    /// One's own bytes are not taken for an answer; the answer that follows at once is.
    #[test]
    fn the_echo_is_dropped_and_the_answer_is_not(_board: Board) {
        let (line, usart) = (Line::<64, 32>::new(), Simulated::new());
        send(&line, &usart, 1);
        let mut buffer = [0; 16];
        assert_eq!((line.take(&mut buffer), line.heard()), (0, 0));
        // Across the wrap of its clock.
        let mut now = u32::MAX - 25;
        for byte in *b"answer" {
            usart.hear(byte);
            now = now.wrapping_add(10);
            assert!(!line.service(&usart, now), "nobody is woken for a part");
        }
        usart.0.borrow_mut().idle = true;
        assert!(line.service(&usart, now.wrapping_add(10)), "the pause wakes");
        assert_eq!((line.heard(), now), (now, 34), "the last byte's time, not the pause's");
        let taken = line.take(&mut buffer);
        assert_eq!(&buffer[..taken], b"answer");
    }

    /// Long answers wake before the queue is full, and what does not fit is lost, not what came before.
    #[test]
    fn a_full_queue_keeps_what_it_has(_board: Board) {
        let (line, usart) = (Line::<64, 32>::new(), Simulated::new());
        let mut woken = None;
        for byte in 0..100 {
            usart.hear(byte);
            if line.service(&usart, 0) {
                woken = woken.or(Some(byte));
            }
        }
        assert_eq!(woken, Some(31));
        let mut buffer = [0; 100];
        assert_eq!(line.take(&mut buffer), 63);
        assert!(buffer.iter().zip(0..63).all(|(byte, expected)| *byte == expected));
    }
}
