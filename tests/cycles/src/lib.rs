//! Cycles of the firmware's ticks on the chips it is made for, bounded from below and above.
//!
//! QEMU runs the image of its own board and counts instructions; it knows neither pipelines nor memories. Its plugin (`cycles-plugin`)
//! hands every executed instruction and every data address to a [`Meter`]. That carries each address over to the images of the real
//! boards by their link maps ([`image`]), follows it through each chip's caches and flash ([`memory`]), and follows the instruction
//! through each processor's pipeline ([`pipeline`]), twice: once with everything that is not known for certain at its best, once at
//! its worst. What lies between is not known without the chip.
//!
//! | bound | caches at the start of a window | issue | latencies, misses, mispredictions |
//! |---|---|---|---|
//! | lower | as the window before left them | two at once where the processor can | the least that was published |
//! | upper | empty, as after an interrupt that used all of them | one at a time | the most |
//!
//! A window is what lies between two reads of the board's clock, by which the firmware measures itself.
//!
//! Not modelled: contention with a second bus master (nothing here uses DMA), refresh and error correction of memories, and interrupts
//! that QEMU raises at other instants than the chip does.

pub mod chip;
pub mod image;
pub mod instruction;
pub mod memory;
pub mod meter;
pub mod pipeline;
pub mod report;

pub use meter::Meter;

/// Which of the two bounds is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// Never more cycles than the chip takes.
    Lower,
    /// Never fewer.
    Upper,
}

/// A number of cycles of which only bounds are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Range {
    /// At best.
    pub least: u32,
    /// At worst.
    pub most: u32,
}

impl Range {
    /// Known exactly.
    pub const fn exactly(cycles: u32) -> Self {
        Self { least: cycles, most: cycles }
    }

    /// From the one to the other.
    pub const fn between(least: u32, most: u32) -> Self {
        Self { least, most }
    }

    /// The end that belongs to a bound.
    pub const fn at(self, bound: Bound) -> u32 {
        match bound {
            Bound::Lower => self.least,
            Bound::Upper => self.most,
        }
    }
}
