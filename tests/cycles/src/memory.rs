//! The way from the processor to code and data: caches, flash accelerators, tightly coupled memory.

use crate::chip::{Chip, DEVICE};
use crate::pipeline::Processor;
use crate::{Bound, Range};

/// Bytes of a line, in every cache and accelerator here.
const LINE: u32 = 32;
/// Ways of a Cortex-M7's data cache (Arm DDI 0489, section 5.1).
const DATA_WAYS: usize = 4;
/// What a written line that makes room may cost: it leaves through a buffer, at best beside everything else.
const WRITE_BACK: Range = Range::between(0, 8);

/// How instructions reach the processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CodePath {
    /// Without ever waiting.
    Tight,
    /// Through the processor's own cache.
    Cached {
        /// Its size.
        bytes: u32,
        /// Its ways.
        ways: usize,
        /// Cycles of a line that is not there.
        miss: Range,
    },
    /// Through the flash interface's own lines.
    Accelerated {
        /// How many, fully associative.
        lines: usize,
        /// Bytes that the flash gives at a time.
        word: u32,
        /// Bytes of a line, which fills word by word.
        line: u32,
        /// Cycles of a word that is not there.
        miss: Range,
        /// That the next word is read ahead.
        prefetch: bool,
    },
}

/// How data reach the processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataPath {
    /// Without ever waiting.
    Tight,
    /// Through the processor's data cache: cycles of a line that is not there.
    Cached(Range),
    /// Through lines of the flash interface.
    Accelerated {
        /// How many, fully associative.
        lines: usize,
        /// Cycles of a line that is not there.
        miss: Range,
    },
    /// Each access by itself.
    Direct(Range),
}

/// Addresses that are reached alike, as code or as data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region<P> {
    /// The first.
    pub first: u32,
    /// The last.
    pub last: u32,
    /// How they are reached.
    pub path: P,
}

impl<P> Region<P> {
    /// The same addresses, reached otherwise.
    pub fn by<Q>(&self, path: Q) -> Region<Q> {
        Region { first: self.first, last: self.last, path }
    }

    fn has(&self, address: u32) -> bool {
        (self.first..=self.last).contains(&address)
    }
}

/// A way for code from one region or several, with the lines that are there.
#[derive(Clone, Debug)]
struct Way {
    regions: Vec<Region<()>>,
    path: CodePath,
    lines: Lines,
    /// The word of flash that was fetched last, and when.
    last_word: Option<(u32, u64)>,
}

impl Way {
    /// The ways of these regions: those that are reached alike share their lines.
    fn all(regions: &[Region<CodePath>]) -> Vec<Self> {
        let mut ways: Vec<Self> = Vec::new();
        for region in regions {
            match ways.iter_mut().find(|way| way.path == region.path) {
                Some(way) => way.regions.push(region.by(())),
                None => ways.push(Self::new(region)),
            }
        }
        ways
    }

    fn new(region: &Region<CodePath>) -> Self {
        let lines = match region.path {
            CodePath::Tight => Lines::new(1, 1),
            CodePath::Cached { bytes, ways, .. } => Lines::new((bytes / LINE) as usize, ways),
            CodePath::Accelerated { lines, .. } => Lines::new(lines, lines),
        };
        Self { regions: vec![region.by(())], path: region.path, lines, last_word: None }
    }

    /// Cycles that a word is waited for.
    fn fetch(&mut self, address: u32, now: u64, bound: Bound) -> u32 {
        match self.path {
            CodePath::Tight => 0,
            CodePath::Cached { miss, .. } => match self.lines.access(address / LINE, 0, false) {
                Found::There => 0,
                Found::Missing { .. } => miss.at(bound),
            },
            CodePath::Accelerated { word, line, miss, prefetch, .. } => {
                let number = address / word;
                let found = self.lines.access(address / line, number % (line / word), false);
                let before = self.last_word.replace((number, now));
                match found {
                    Found::There => 0,
                    Found::Missing { .. } => {
                        let cycles = miss.at(bound);
                        match (before, bound) {
                            // Read ahead while the word before it was executed.
                            (Some((last, since)), Bound::Lower) if prefetch && number == last.wrapping_add(1) => {
                                cycles.saturating_sub(u32::try_from(now.saturating_sub(since)).unwrap_or(u32::MAX))
                            }
                            _ => cycles,
                        }
                    }
                }
            }
        }
    }
}

/// Lines that are there: sets of some ways, in each the least recently used makes room.
#[derive(Clone, Debug)]
struct Lines {
    ways: usize,
    /// Each set from the most recently used to the least: line number, its words that are there, and whether it was written.
    sets: Vec<Vec<(u32, u32, bool)>>,
}

/// What an access found.
enum Found {
    There,
    /// Not there; whether a written line had to make room.
    Missing {
        written: bool,
    },
}

impl Lines {
    fn new(lines: usize, ways: usize) -> Self {
        let sets = (lines / ways.max(1)).max(1);
        Self { ways: ways.max(1), sets: vec![Vec::new(); sets] }
    }

    fn empty(&mut self) {
        self.sets.iter_mut().for_each(Vec::clear);
    }

    /// Looks for a word of a line, and puts it there.
    fn access(&mut self, line: u32, word: u32, write: bool) -> Found {
        let index = line as usize % self.sets.len().max(1);
        let ways = self.ways;
        let Some(set) = self.sets.get_mut(index) else { return Found::Missing { written: false } };
        if let Some(place) = set.iter().position(|(one, ..)| *one == line) {
            let (line, words, written) = set.remove(place);
            set.insert(0, (line, words | 1 << word, written || write));
            return if words & 1 << word == 0 { Found::Missing { written: false } } else { Found::There };
        }
        let written = if set.len() >= ways { set.pop().is_some_and(|(.., written)| written) } else { false };
        set.insert(0, (line, 1 << word, write));
        Found::Missing { written }
    }
}

/// The memories of one chip, as one bound sees them.
#[derive(Clone, Debug)]
pub struct Memory {
    bound: Bound,
    /// Code that lies nowhere comes by the first.
    code: Vec<Way>,
    regions: Vec<Region<DataPath>>,
    data_lines: Lines,
    flash_lines: Lines,
    /// The word that the processor has fetched last: the next instruction of it costs nothing.
    at_hand: Option<u32>,
}

impl Memory {
    /// A chip's, with nothing in its caches.
    pub fn new(chip: &Chip, bound: Bound) -> Self {
        let data_bytes = match chip.processor {
            Processor::CortexM7 { data_cache_bytes } => data_cache_bytes,
            Processor::CortexM4 => LINE,
        };
        let flash = chip.data.iter().find_map(|region| match region.path {
            DataPath::Accelerated { lines, .. } => Some(lines),
            _ => None,
        });
        let flash = flash.unwrap_or(1);
        Self {
            bound,
            code: Way::all(&chip.code),
            regions: chip.data.clone(),
            data_lines: Lines::new((data_bytes / LINE) as usize, DATA_WAYS),
            flash_lines: Lines::new(flash, flash),
            at_hand: None,
        }
    }

    /// Empties everything: something else has run.
    pub fn empty(&mut self) {
        for way in &mut self.code {
            way.lines.empty();
            way.last_word = None;
        }
        self.data_lines.empty();
        self.flash_lines.empty();
        self.at_hand = None;
    }

    /// Cycles that the instruction at this address is waited for, fetched at this time.
    pub fn fetch(&mut self, address: u32, bytes: u32, now: u64) -> u32 {
        let first = self.fetch_word(address, now);
        // An instruction of 32 bits may begin in one line and end in the next.
        let last = address.wrapping_add(bytes.saturating_sub(1));
        if last / 8 == address / 8 { first } else { first + self.fetch_word(last, now) }
    }

    fn fetch_word(&mut self, address: u32, now: u64) -> u32 {
        // The processor fetches 64 bits at a time (a Cortex-M4 32, which costs nothing either while they are there).
        let fetched = address / 8;
        if self.at_hand == Some(fetched) {
            return 0;
        }
        self.at_hand = Some(fetched);
        let place = self.code.iter().position(|way| way.regions.iter().any(|region| region.has(address))).unwrap_or(0);
        self.code.get_mut(place).map_or(0, |way| way.fetch(address, now, self.bound))
    }

    /// Cycles that an access to data is waited for.
    pub fn access(&mut self, address: u32, write: bool) -> u32 {
        let region = self.regions.iter().find(|region| region.has(address));
        let Some(Region { path, .. }) = region else { return DEVICE.at(self.bound) };
        match *path {
            DataPath::Tight => 0,
            DataPath::Direct(cycles) => cycles.at(self.bound),
            DataPath::Accelerated { miss, .. } => match self.flash_lines.access(address / LINE, 0, false) {
                Found::There => 0,
                Found::Missing { .. } => miss.at(self.bound),
            },
            DataPath::Cached(miss) => match self.data_lines.access(address / LINE, 0, write) {
                Found::There => 0,
                // At best a store leaves through the store buffer, and its line comes beside everything else.
                Found::Missing { .. } if write && self.bound == Bound::Lower => 0,
                Found::Missing { written } => miss.at(self.bound) + if written { WRITE_BACK.at(self.bound) } else { 0 },
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chip(code: CodePath, data: DataPath) -> Chip {
        Chip {
            board: "none",
            layout: "",
            clock_hz: 1.0,
            processor: Processor::CortexM7 { data_cache_bytes: 256 },
            code: vec![Region { first: 0, last: 0xfff, path: code }, TIGHT.by(CodePath::Tight)],
            data: vec![Region { first: 0x2000_0000, last: 0x2000_ffff, path: data }, TIGHT.by(DataPath::Tight)],
        }
    }

    const MISS: Range = Range::between(10, 20);
    const TIGHT: Region<()> = Region { first: 0x1000, last: 0x1fff, path: () };

    #[test]
    fn a_loop_that_fits_misses_once_and_one_that_does_not_always() {
        let mut memory =
            Memory::new(&chip(CodePath::Cached { bytes: 128, ways: 2, miss: MISS }, DataPath::Tight), Bound::Upper);
        let pass = |memory: &mut Memory, bytes: u32| -> u32 {
            (0..bytes / 4).map(|index| memory.fetch(index * 4, 4, 0)).sum()
        };
        assert_eq!(pass(&mut memory, 128), 4 * 20);
        assert_eq!(pass(&mut memory, 128), 0, "four lines fit");
        // Six lines in two sets of two ways: the least recently used is always the one that is needed next.
        memory.empty();
        assert_eq!(pass(&mut memory, 192), 6 * 20);
        assert_eq!(pass(&mut memory, 192), 6 * 20);
    }

    #[test]
    fn a_written_line_costs_more_to_replace() {
        let mut memory = Memory::new(&chip(CodePath::Tight, DataPath::Cached(MISS)), Bound::Upper);
        // 256 bytes in four ways: two sets. Five lines of one set.
        let line = |index: u32| 0x2000_0000 + index * 64;
        assert_eq!(memory.access(line(0), true), 20);
        assert_eq!(memory.access(line(0) + 28, false), 0, "the same line");
        assert_eq!((1..4).map(|index| memory.access(line(index), false)).sum::<u32>(), 3 * 20);
        assert_eq!(memory.access(line(4), false), 28, "the first was written");
        assert_eq!(memory.access(line(5), false), 20, "the second was only read");
    }

    #[test]
    fn words_of_an_accelerators_line_come_one_by_one_and_ahead_of_time() {
        let code = |prefetch| CodePath::Accelerated { lines: 2, word: 8, line: 32, miss: Range::exactly(4), prefetch };
        let walk = |memory: &mut Memory| -> Vec<u32> {
            (0..8).map(|index| memory.fetch(index * 4, 4, u64::from(index))).collect()
        };
        let mut memory = Memory::new(&chip(code(false), DataPath::Tight), Bound::Lower);
        assert_eq!(walk(&mut memory), [4, 0, 4, 0, 4, 0, 4, 0]);
        assert_eq!(walk(&mut memory), [0; 8]);
        let mut memory = Memory::new(&chip(code(true), DataPath::Tight), Bound::Lower);
        assert_eq!(walk(&mut memory), [4, 0, 2, 0, 2, 0, 2, 0], "two cycles pass from word to word");
    }

    #[test]
    fn an_instruction_across_two_lines_waits_for_both() {
        let mut memory =
            Memory::new(&chip(CodePath::Cached { bytes: 128, ways: 2, miss: MISS }, DataPath::Tight), Bound::Lower);
        assert_eq!(memory.fetch(30, 4, 0), 20);
        assert_eq!(memory.fetch(34, 2, 0), 0);
    }

    #[test]
    fn code_in_tightly_coupled_memory_never_waits_and_takes_nobody_s_line() {
        let code = CodePath::Cached { bytes: 64, ways: 1, miss: MISS };
        let mut memory = Memory::new(&chip(code, DataPath::Cached(MISS)), Bound::Upper);
        assert_eq!(memory.fetch(0x2000, 4, 0), 20);
        assert_eq!((memory.fetch(0x1000, 4, 0), memory.access(0x1ffc, false)), (0, 0));
        assert_eq!(memory.fetch(0x2000, 4, 0), 0, "its line is still there");
    }

    #[test]
    fn regions_that_are_reached_alike_share_their_lines() {
        let cached = CodePath::Cached { bytes: 64, ways: 1, miss: MISS };
        let mut chip = chip(cached, DataPath::Tight);
        chip.code.push(Region { first: 0x4000, last: 0x4fff, path: cached });
        let mut memory = Memory::new(&chip, Bound::Upper);
        // Line 0 of either region is the same set's.
        assert_eq!((memory.fetch(0, 4, 0), memory.fetch(0x4000, 4, 0), memory.fetch(0, 4, 0)), (20, 20, 20));
        assert_eq!(memory.fetch(0x4020, 4, 0), 20, "another set");
        assert_eq!(memory.fetch(0, 4, 0), 0);
    }

    #[test]
    fn what_lies_nowhere_is_a_device() {
        let mut memory = Memory::new(&chip(CodePath::Tight, DataPath::Tight), Bound::Lower);
        assert_eq!((memory.access(0x4000_0000, false), memory.access(0x2000_0000, false)), (DEVICE.least, 0));
    }
}
