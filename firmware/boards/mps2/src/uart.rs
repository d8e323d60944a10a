//! The CMSDK UARTs: rings filled and emptied by interrupt, read and written through embedded-io-async.
//!
//! Nothing received is lost in QEMU: with a full ring the byte stays in the UART, which makes QEMU hold back the next one.

use crate::cycles;
use crate::registers::{CLOCK_HZ, UART0, UART1, UartRegisters};
use core::cell::RefCell;
use core::convert::Infallible;
use core::future::poll_fn;
use core::task::Poll;
use critical_section::Mutex;
use embassy_sync::waitqueue::AtomicWaker;
use embedded_io_async::{ErrorType, Read, ReadReady, Write, WriteReady};
use heapless::Deque;

/// Bytes that wait for the program.
const RECEIVE_RING: usize = 1024;
/// Bytes that wait for the wire.
pub const TRANSMIT_RING: usize = 2048;
/// Bytes moved per critical section: keeps interrupts prompt.
const CHUNK: usize = 64;

const TX_FULL: u32 = 1;
const RX_FULL: u32 = 1 << 1;
const ALL_ON: u32 = 0b1111;
const BOTH_INTERRUPTS: u32 = 0b11;
/// The smallest the UART accepts.
const SMALLEST_DIVIDER: u32 = 16;

/// One UART and its rings.
pub(crate) struct Line {
    registers: UartRegisters,
    rings: &'static SharedRings,
    received: AtomicWaker,
    sent: AtomicWaker,
}

struct Rings {
    receive: Deque<u8, RECEIVE_RING>,
    transmit: Deque<u8, TRANSMIT_RING>,
    /// When the last byte came, in ticks of [`cycles::now`].
    heard: u32,
}

type SharedRings = Mutex<RefCell<Rings>>;

const fn empty() -> SharedRings {
    Mutex::new(RefCell::new(Rings { receive: Deque::new(), transmit: Deque::new(), heard: 0 }))
}

// Apart from the lines, so that they start as zeros and take no room in the image.
static BUS_RINGS: SharedRings = empty();
static LINK_RINGS: SharedRings = empty();

pub(crate) static BUS: Line = Line::new(UART0, &BUS_RINGS);
pub(crate) static LINK: Line = Line::new(UART1, &LINK_RINGS);

impl Line {
    const fn new(registers: UartRegisters, rings: &'static SharedRings) -> Self {
        Self { registers, rings, received: AtomicWaker::new(), sent: AtomicWaker::new() }
    }

    /// Switches the UART on and gives out its two halves.
    pub(crate) fn start(&'static self, baud: u32) -> Uart {
        let mut tx = UartTx { line: self };
        tx.set_baud(baud);
        self.registers.control.write(ALL_ON);
        Uart { tx, rx: UartRx { line: self } }
    }

    fn with_rings<R>(&self, work: impl FnOnce(&mut Rings) -> R) -> R {
        critical_section::with(|cs| work(&mut self.rings.borrow(cs).borrow_mut()))
    }

    /// From the UART into the ring, as far as it fits.
    fn pull(&self, rings: &mut Rings) {
        while !rings.receive.is_full() && self.registers.state.read() & RX_FULL != 0 {
            // Room was checked just above.
            let _ = rings.receive.push_back(self.registers.data.read() as u8);
        }
    }

    /// From the ring into the UART, as far as it takes it.
    fn push(&self, rings: &mut Rings) {
        // The ring first: reading a register costs QEMU more than looking at memory.
        while !rings.transmit.is_empty() && self.registers.state.read() & TX_FULL == 0 {
            if let Some(byte) = rings.transmit.pop_front() {
                self.registers.data.write(u32::from(byte));
            }
        }
    }

    pub(crate) fn on_interrupt(&self) {
        self.with_rings(|rings| {
            // Cleared first: a byte that arrives while the ring is filled must raise it again.
            self.registers.interrupt_clear.write(BOTH_INTERRUPTS);
            let before = rings.receive.len();
            self.pull(rings);
            if rings.receive.len() > before {
                rings.heard = cycles::now();
            }
            self.push(rings);
        });
        self.received.wake();
        self.sent.wake();
    }

    /// Moves up to `buffer.len()` received bytes; returns how many.
    fn take(&self, buffer: &mut [u8]) -> usize {
        let mut taken = 0;
        for chunk in buffer.chunks_mut(CHUNK) {
            let moved = self.with_rings(|rings| {
                let mut moved = 0;
                for slot in &mut *chunk {
                    let Some(byte) = rings.receive.pop_front() else {
                        break;
                    };
                    *slot = byte;
                    moved += 1;
                }
                // There is room now: a byte that was left in the UART raises no further interrupt.
                self.pull(rings);
                moved
            });
            taken += moved;
            if moved < chunk.len() {
                break;
            }
        }
        taken
    }

    /// Queues what fits; returns how much.
    fn give(&self, bytes: &[u8]) -> usize {
        let mut given = 0;
        for chunk in bytes.chunks(CHUNK) {
            let moved = self.with_rings(|rings| {
                let moved = chunk.iter().take_while(|byte| rings.transmit.push_back(**byte).is_ok()).count();
                self.push(rings);
                moved
            });
            given += moved;
            if moved < chunk.len() {
                break;
            }
        }
        given
    }
}

/// A UART: two halves, which may go to different tasks.
pub struct Uart {
    /// The sending half.
    pub tx: UartTx,
    /// The receiving half.
    pub rx: UartRx,
}

impl Uart {
    /// The halves.
    pub fn split(self) -> (UartTx, UartRx) {
        (self.tx, self.rx)
    }
}

/// The receiving half of a UART.
pub struct UartRx {
    line: &'static Line,
}

/// The sending half of a UART.
pub struct UartTx {
    line: &'static Line,
}

impl UartTx {
    /// Sets the rate and returns the one reached, in bits per second: the nearest the divider of 25 MHz gives, 1,562,500 at most.
    /// QEMU takes no time to send a byte, whatever the rate.
    pub fn set_baud(&mut self, baud: u32) -> u32 {
        let divider = ((CLOCK_HZ + baud / 2) / baud.max(1)).max(SMALLEST_DIVIDER);
        self.line.registers.baud_divider.write(divider);
        CLOCK_HZ / divider
    }

    /// Bytes that [`Write::write`] would take at once.
    pub fn space(&self) -> usize {
        self.line.with_rings(|rings| TRANSMIT_RING - rings.transmit.len())
    }

    /// Queues the whole of `bytes`, or nothing if they do not fit now; returns whether it did. Never waits.
    pub fn try_write_all(&mut self, bytes: &[u8]) -> bool {
        // Between the two only the interrupt acts, and that makes more room.
        self.space() >= bytes.len() && self.line.give(bytes) == bytes.len()
    }
}

impl ErrorType for UartRx {
    type Error = Infallible;
}

impl Read for UartRx {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        if buffer.is_empty() {
            return Ok(0);
        }
        poll_fn(|context| {
            self.line.received.register(context.waker());
            match self.line.take(buffer) {
                0 => Poll::Pending,
                taken => Poll::Ready(Ok(taken)),
            }
        })
        .await
    }
}

impl UartRx {
    /// When the last byte came, in ticks of [`cycles::now`].
    pub fn heard_ticks(&self) -> u32 {
        self.line.with_rings(|rings| rings.heard)
    }
}

impl ReadReady for UartRx {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.line.with_rings(|rings| !rings.receive.is_empty()))
    }
}

impl ErrorType for UartTx {
    type Error = Infallible;
}

impl Write for UartTx {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        if bytes.is_empty() {
            return Ok(0);
        }
        poll_fn(|context| {
            self.line.sent.register(context.waker());
            match self.line.give(bytes) {
                0 => Poll::Pending,
                given => Poll::Ready(Ok(given)),
            }
        })
        .await
    }

    /// Waits until the last byte has left the UART.
    async fn flush(&mut self) -> Result<(), Infallible> {
        poll_fn(|context| {
            self.line.sent.register(context.waker());
            let empty = self
                .line
                .with_rings(|rings| rings.transmit.is_empty() && self.line.registers.state.read() & TX_FULL == 0);
            if empty { Poll::Ready(Ok(())) } else { Poll::Pending }
        })
        .await
    }
}

impl WriteReady for UartTx {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.space() > 0)
    }
}

impl ErrorType for Uart {
    type Error = Infallible;
}

impl Read for Uart {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        self.rx.read(buffer).await
    }
}

impl Write for Uart {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        self.tx.write(bytes).await
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        self.tx.flush().await
    }
}
