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
    /// How instructions come; those that lie nowhere come as the first.
    pub code: Vec<Region<CodePath>>,
    /// How data come; addresses that lie nowhere are devices.
    pub data: Vec<Region<DataPath>>,
}

impl Chip {
    /// Whether this is the layout of the board's image, for any finger.
    pub fn is_image(&self) -> bool {
        [IMAGE, FAR].contains(&self.layout)
    }
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

/// The layout that a board's image has, for its first finger.
const IMAGE: &str = "as its image";
/// The layout of an image for the fingers whose models do not lie in memory without wait states.
pub const FAR: &str = "as its image, another finger than the first";

/// Memory for code that is coupled tightly to a Cortex-M7, as far as the smallest has it, and flash as every chip shows it.
const F746_ITCM: Region<()> = region(0, 16);
const H743_ITCM: Region<()> = region(0, 64);
const FLASH: Region<()> = region(0x0800_0000, 2048);
/// The F746's flash by the interface beside its tightly coupled memory.
const F746_BESIDE: Region<()> = region(0x0020_0000, 1024);
/// Tightly coupled memory for data, and the RAM that is reached through the data cache.
const F746_DTCM: Region<()> = region(0x2000_0000, 64);
const F746_RAM: Region<()> = region(0x2001_0000, 256);
/// The H743's stack lies in its tightly coupled memory, with the first finger's model behind it.
const H743_STACK: Region<()> = region(0x2000_0000, 42);
const H743_NEAR: Region<()> = region(0x2000_0000 + 42 * KB, 128 - 42);
const H743_RAM: Region<()> = region(0x2400_0000, 512);
const G474_CCM: Region<()> = region(0x1000_0000, 32);
const G474_RAM: Region<()> = region(0x2000_0000, 128);

const fn region(first: u32, kilobytes: u32) -> Region<()> {
    Region { first, last: first + kilobytes * KB - 1, path: () }
}

/// Every chip, in each layout that is of interest; first of each chip the one that its image has, for the first finger, then for the others
/// where their models lie elsewhere.
pub fn all() -> Vec<Chip> {
    let mut all = f746();
    all.extend(h743());
    all.extend(g474());
    all
}

fn f746() -> Vec<Chip> {
    let [flash, ram] = [F746_FLASH, F746_SRAM].map(DataPath::Cached);
    let over_axi = CodePath::Cached { bytes: 4 * KB, ways: 2, miss: F746_FLASH };
    let accelerated =
        CodePath::Accelerated { lines: 64, word: 32, line: 32, miss: Range::between(7, 9), prefetch: true };
    // Neither cache is in the way there; literals pass by the accelerator's lines.
    let beside = DataPath::Direct(Range::between(7, 9));
    let code = |itcm, beside| vec![FLASH.by(over_axi), F746_ITCM.by(itcm), F746_BESIDE.by(beside)];
    let data = |itcm, beside, dtcm| {
        vec![FLASH.by(flash), F746_ITCM.by(itcm), F746_BESIDE.by(beside), F746_DTCM.by(dtcm), F746_RAM.by(ram)]
    };
    let image = Chip {
        board: OPENCR.name,
        layout: IMAGE,
        clock_hz: f64::from(OPENCR.clock_hz),
        processor: Processor::CortexM7 { data_cache_bytes: 4 * KB },
        code: code(CodePath::Tight, accelerated),
        data: data(DataPath::Tight, beside, DataPath::Tight),
    };
    let far = Chip { layout: FAR, data: data(DataPath::Tight, beside, ram), ..image.clone() };
    let cool = Chip {
        layout: "the same, without hot functions",
        code: code(accelerated, accelerated),
        data: data(beside, beside, DataPath::Tight),
        ..image.clone()
    };
    let cached = Chip {
        layout: "the same, all other code through the cache",
        code: code(CodePath::Tight, over_axi),
        data: data(DataPath::Tight, flash, DataPath::Tight),
        ..image.clone()
    };
    let tight = Chip {
        layout: "as if all code and data lay in TCM",
        code: vec![FLASH.by(CodePath::Tight)],
        data: [FLASH, F746_ITCM, F746_BESIDE, F746_DTCM, F746_RAM].map(|region| region.by(DataPath::Tight)).to_vec(),
        ..image.clone()
    };
    vec![image, far, cool, cached, tight]
}

fn h743() -> Vec<Chip> {
    let [flash, ram] = [H743_FLASH, H743_SRAM].map(DataPath::Cached);
    let over_axi = CodePath::Cached { bytes: 16 * KB, ways: 2, miss: H743_FLASH };
    let data = |itcm, near| {
        vec![FLASH.by(flash), H743_ITCM.by(itcm), H743_STACK.by(DataPath::Tight), H743_NEAR.by(near), H743_RAM.by(ram)]
    };
    let image = Chip {
        board: NUCLEO_H743ZI.name,
        layout: IMAGE,
        clock_hz: f64::from(NUCLEO_H743ZI.clock_hz),
        processor: Processor::CortexM7 { data_cache_bytes: 16 * KB },
        code: vec![FLASH.by(over_axi), H743_ITCM.by(CodePath::Tight)],
        data: data(DataPath::Tight, DataPath::Tight),
    };
    let far = Chip { layout: FAR, data: data(DataPath::Tight, ram), ..image.clone() };
    let cool = Chip {
        layout: "the same, without hot functions",
        code: vec![FLASH.by(over_axi), H743_ITCM.by(over_axi)],
        data: data(flash, DataPath::Tight),
        ..image.clone()
    };
    let tight = Chip {
        layout: "as if all code and data lay in TCM",
        code: vec![FLASH.by(CodePath::Tight)],
        data: [FLASH, H743_ITCM, H743_STACK, H743_NEAR, H743_RAM].map(|region| region.by(DataPath::Tight)).to_vec(),
        ..image.clone()
    };
    vec![image, far, cool, tight]
}

fn g474() -> Vec<Chip> {
    let accelerated = CodePath::Accelerated { lines: 32, word: 8, line: 32, miss: Range::exactly(4), prefetch: false };
    let flash = DataPath::Accelerated { lines: 8, miss: Range::between(4, 5) };
    let image = Chip {
        board: NUCLEO_G474RE.name,
        layout: IMAGE,
        clock_hz: f64::from(NUCLEO_G474RE.clock_hz),
        processor: Processor::CortexM4,
        code: vec![FLASH.by(accelerated), G474_CCM.by(CodePath::Tight)],
        data: vec![FLASH.by(flash), G474_CCM.by(DataPath::Tight), G474_RAM.by(DataPath::Tight)],
    };
    let tight = Chip { layout: "as if all code lay in CCM", code: vec![FLASH.by(CodePath::Tight)], ..image.clone() };
    vec![image, tight]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn overlaps(regions: Vec<Region<()>>) -> bool {
        let follows = |pair: &[Region<()>]| pair[0].last < pair[1].first;
        let mut regions = regions;
        regions.sort_by_key(|region| region.first);
        regions.iter().any(|region| region.first >= region.last) || !regions.windows(2).all(follows)
    }

    #[test]
    fn no_region_overlaps_another_and_every_range_has_an_order() {
        for chip in all() {
            let code = chip.code.iter().map(|region| region.by(()));
            assert!(!overlaps(code.collect()), "code of {}, {}", chip.board, chip.layout);
            let data = chip.data.iter().map(|region| region.by(()));
            assert!(!overlaps(data.collect()), "data of {}, {}", chip.board, chip.layout);
        }
        for range in [F746_FLASH, F746_SRAM, H743_FLASH, H743_SRAM, DEVICE] {
            assert!(range.least <= range.most, "{range:?}");
        }
    }
}
