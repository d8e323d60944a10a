//! The chips: clock, processor, and the ways from the processor to code and data, with where each figure comes from.
//!
//! | chip | figure | source |
//! |---|---|---|
//! | STM32F746 | 4 + 4 KB caches, lines of 32 bytes, 2 and 4 ways; TCM without wait states, 16 KB of it for code | ST RM0385 section 2, Arm DDI 0489 section 5 |
//! | | flash of 256 bits, 7 wait states at 216 MHz and 3.3 V; accelerator (ART) of 64 lines of 256 bits on the ITCM side | RM0385 section 3.3 |
//! | STM32H743 | 16 + 16 KB caches; 64 KB of TCM for code; flash words of 256 bits, 4 wait states at 240 MHz (the bus runs at half the processor's clock) | RM0433 sections 2 and 4.3 |
//! | STM32G474 | 32 KB of core-coupled memory; accelerator of 1 KB for code (32 lines of four 64-bit words) and 256 bytes for data; 4 wait states at 170 MHz; prefetch off unless it is switched on | RM0440 section 5.3 |
//!
//! The sections are cited from memory: check them before a figure is relied upon. Not published, and bracketed: the cycles that the bus matrix and the bridges add to a miss, whether a line's first word reaches the
//! processor before its last, and what a written line costs that makes room.

use fre_boards::{NUCLEO_G474RE, NUCLEO_H743ZI, OPENCR};

use crate::Range;
use crate::memory::{CodePath, DataPath, Region};
use crate::pipeline::Processor;

/// A chip, and one way of laying out a program in it.
#[derive(Clone, Debug)]
pub struct Chip {
    /// The board's name among the firmware's.
    pub board: &'static str,
    /// What is particular about this way.
    pub layout: &'static str,
    /// Hertz of the processor's clock.
    pub clock_hz: f64,
    /// Its pipeline.
    pub processor: Processor,
    /// How instructions come.
    pub code: CodePath,
    /// The memory from which they come without waiting: the first address, and the one behind the last. Data in it do not wait either.
    pub tight: [u32; 2],
    /// How data come; addresses that lie nowhere are devices.
    pub data: Vec<Region>,
}

/// A device register: a bus bridge and the device's own clock.
pub const DEVICE: Range = Range::between(2, 20);

/// A line of 32 bytes from the F746's flash over AXI: 8 cycles of flash, four beats of 64 bits, and a bridge that adds 2 to 8.
const F746_FLASH: Range = Range::between(8 + 2, 8 + 4 + 8);
/// From its SRAM, which AXI reaches over a bridge to a bus of 32 bits: eight beats.
const F746_SRAM: Range = Range::between(4, 8 + 8);
/// From the H743's flash: at half the processor's clock 5 cycles of flash, four beats, and a matrix that adds 1 to 4.
const H743_FLASH: Range = Range::between(2 * (5 + 1 + 1), 2 * (5 + 4 + 4));
/// From its AXI SRAM, without wait states.
const H743_SRAM: Range = Range::between(2 * 2, 2 * (1 + 4 + 4));

const KB: u32 = 1024;

/// Every chip, in each layout that is of interest.
pub fn all() -> Vec<Chip> {
    let flash = |first, path| Region { first, last: first + 2048 * KB - 1, path };
    let f746_data = |flash_path| {
        vec![
            flash(0x0800_0000, flash_path),
            Region { first: 0x2000_0000, last: 0x2000_0000 + 64 * KB - 1, path: DataPath::Tight },
            Region { first: 0x2001_0000, last: 0x2001_0000 + 256 * KB - 1, path: DataPath::Cached(F746_SRAM) },
        ]
    };
    let f746 = Chip {
        board: OPENCR.name,
        layout: "flash over AXI, caches; hot functions in ITCM",
        clock_hz: f64::from(OPENCR.clock_hz),
        processor: Processor::CortexM7 { data_cache_bytes: 4 * KB },
        code: CodePath::Cached { bytes: 4 * KB, ways: 2, miss: F746_FLASH },
        tight: [0, 16 * KB],
        data: f746_data(DataPath::Cached(F746_FLASH)),
    };
    let f746_cool = cool(&f746, F746_FLASH);
    // Over the tightly coupled interface neither cache is in the way; literals pass by the accelerator's lines.
    let over_itcm = Chip {
        layout: "flash over ITCM, ART; hot functions in ITCM",
        code: CodePath::Accelerated { lines: 64, word: 32, line: 32, miss: Range::between(7, 9), prefetch: true },
        data: f746_data(DataPath::Direct(Range::between(7, 9))),
        ..f746.clone()
    };
    let f746_tight = Chip { layout: "as if all code lay in ITCM", code: CodePath::Tight, ..f746.clone() };
    let h743_tail = |ram| {
        vec![
            flash(0x0800_0000, DataPath::Cached(H743_FLASH)),
            Region { first: 0x2000_0000, last: 0x2000_0000 + 128 * KB - 1, path: DataPath::Tight },
            Region { first: 0x2400_0000, last: 0x2400_0000 + 512 * KB - 1, path: ram },
        ]
    };
    let h743 = Chip {
        board: NUCLEO_H743ZI.name,
        layout: "flash over AXI, caches; hot functions in ITCM",
        clock_hz: f64::from(NUCLEO_H743ZI.clock_hz),
        processor: Processor::CortexM7 { data_cache_bytes: 16 * KB },
        code: CodePath::Cached { bytes: 16 * KB, ways: 2, miss: H743_FLASH },
        tight: [0, 64 * KB],
        data: h743_tail(DataPath::Cached(H743_SRAM)),
    };
    let h743_cool = cool(&h743, H743_FLASH);
    let h743_tight = Chip {
        layout: "as if all code and data lay in TCM",
        code: CodePath::Tight,
        data: h743_tail(DataPath::Tight),
        ..h743.clone()
    };
    let g474 = Chip {
        board: NUCLEO_G474RE.name,
        layout: "flash, ART",
        clock_hz: f64::from(NUCLEO_G474RE.clock_hz),
        processor: Processor::CortexM4,
        code: CodePath::Accelerated { lines: 32, word: 8, line: 32, miss: Range::exactly(4), prefetch: false },
        tight: [0x1000_0000, 0x1000_0000 + 32 * KB],
        data: vec![
            flash(0x0800_0000, DataPath::Accelerated { lines: 8, miss: Range::between(4, 5) }),
            Region { first: 0x2000_0000, last: 0x2000_0000 + 128 * KB - 1, path: DataPath::Tight },
        ],
    };
    let g474_tight = Chip { layout: "as if all code lay in CCM", code: CodePath::Tight, ..g474.clone() };
    vec![f746, f746_cool, over_itcm, f746_tight, h743, h743_cool, h743_tight, g474, g474_tight]
}

/// As if the hot functions came over AXI as well: what their place is worth.
fn cool(chip: &Chip, flash: Range) -> Chip {
    let [first, end] = chip.tight;
    let mut data = chip.data.clone();
    data.push(Region { first, last: end - 1, path: DataPath::Cached(flash) });
    Chip { layout: "flash over AXI, caches", tight: [0, 0], data, ..chip.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_region_overlaps_another_and_every_range_has_an_order() {
        for chip in all() {
            for (index, region) in chip.data.iter().enumerate() {
                assert!(region.first < region.last, "{} {}", chip.board, chip.layout);
                let others = chip.data.iter().skip(index + 1);
                let apart = |other: &Region| region.last < other.first || other.last < region.first;
                assert!(others.clone().all(apart), "{} {}", chip.board, chip.layout);
                let [first, end] = chip.tight;
                assert!(region.last < first || end <= region.first, "{} {}", chip.board, chip.layout);
            }
        }
        for range in [F746_FLASH, F746_SRAM, H743_FLASH, H743_SRAM, DEVICE] {
            assert!(range.least <= range.most, "{range:?}");
        }
    }
}
