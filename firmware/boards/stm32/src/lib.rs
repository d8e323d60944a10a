//! What the STM32 boards share.
//!
//! - [`Line`]: the half-duplex bus, served by one interrupt that also turns its direction round ([`port`] reads and
//!   writes it).
//! - [`critical`]: critical sections that let this one interrupt through. [`fast`]: what runs from RAM.
//! - [`usart`]: a chip's USART under a line. [`Settings`]: a stretch of flash; [`torn`]: words
//!   of it that cannot be read. [`mod@reset`]: last words, why the
//!   program started, how it ends. [`cycles`]: the processor's cycle counter. [`Dog`]: its watchdog.
//! - [`missed`]: time that embassy's clock misses while flash is erased.
//! - [`interrupts!`]: which interrupt does what. [`guard`]: what a stack that overflows comes into.
//!
//! The log goes out over RTT (defmt-rtt). Without the feature `chip` there is only what needs no chip: the tests drive the line's logic with a simulated USART.
#![no_std]

#[cfg(feature = "chip")]
use defmt_rtt as _;

#[cfg(feature = "chip")]
defmt::timestamp!("{=u64:us}", embassy_time::Instant::now().as_micros());

#[cfg(feature = "chip")]
mod bus;
#[cfg(feature = "chip")]
pub mod critical;
#[cfg(feature = "chip")]
pub mod cycles;
#[cfg(feature = "chip")]
pub mod fast;
#[cfg(feature = "chip")]
mod flash;
#[cfg(feature = "guard")]
pub mod guard;
#[cfg(feature = "chip")]
mod interrupts;
mod line;
pub mod missed;
#[cfg(feature = "chip")]
pub mod near;
pub mod port;
#[cfg(feature = "chip")]
pub mod reset;
mod ring;
#[cfg(any(feature = "flash-f7", feature = "flash-g4"))]
pub mod stalling;
#[cfg(feature = "chip")]
pub mod torn;
#[cfg(feature = "chip")]
pub mod usart;
#[cfg(feature = "chip")]
mod watchdog;

#[cfg(feature = "chip")]
pub use bus::Bus;
#[cfg(feature = "chip")]
pub use flash::{Care, Settings, forget_cached};
pub use line::{Line, Status, Until, Usart};
pub use ring::Ring;
#[cfg(feature = "chip")]
pub use watchdog::Dog;

/// What port and scheduler add to a servo's answer, µs, at most: a byte's time until the line counts as idle, two wake-ups, and
/// the estimate of another finger before it.
pub const BUS_LATENCY_US: u32 = 500;
