//! What the plugin feeds: executed instructions and accesses in, cycles of every window out.

use std::collections::HashMap;
use std::fmt::Write;

use crate::chip::{self, Chip};
use crate::image::{Image, LinkMap, NotAnImage};
use crate::instruction::{Instruction, Kind};
use crate::memory::Memory;
use crate::pipeline::Pipeline;
use crate::{Bound, report};

/// An instruction of the image that QEMU runs.
struct Place {
    address: u32,
    bytes: u32,
    instruction: Instruction,
}

/// One chip in one layout, with both bounds.
struct Track {
    chip: Chip,
    map: LinkMap,
    sides: [Side; 2],
    /// For each place its address in this chip's image.
    places: Vec<u32>,
    /// For each place the cycles of the upper bound in this window.
    cycles: Vec<u64>,
    /// The window's instructions whose address in this chip's image is known by name.
    named: u64,
    by_name: Vec<bool>,
}

struct Side {
    bound: Bound,
    memory: Memory,
    pipeline: Pipeline,
    began: u64,
}

/// What the linker puts between a branch and a goal that is too far away for it.
const DETOUR: [(u32, &str); 3] = [(0, "movw r12, #0"), (4, "movt r12, #0"), (8, "bx r12")];

/// Follows a program on every chip.
pub struct Meter {
    clock: u32,
    places: Vec<Place>,
    tracks: Vec<Track>,
    /// The instruction that runs, with the data that it has moved.
    running: Option<usize>,
    moved: Vec<(u32, bool)>,
    /// Where the window began, and its instructions so far.
    window: Option<(u32, u64)>,
    /// The places that were executed in it, each once.
    seen: Vec<usize>,
    /// Between which reads of the clock a place has cost how much on each chip, by the upper bound.
    costs: HashMap<[u32; 2], HashMap<usize, Vec<u64>>>,
    ends_window: bool,
    /// The linker's own code by which far branches go: where each instruction lies, and what it is.
    detour: Vec<(u32, Instruction)>,
    unknown: Vec<String>,
    /// Windows that have ended, as lines.
    told: String,
}

impl Meter {
    /// For a program whose image this is, on the boards whose images are at hand, with windows between reads of this address. Layouts that
    /// no image has are followed as well, if that is wanted: each takes as long as another.
    ///
    /// # Errors
    /// An image is none.
    pub fn new(image: &[u8], boards: &[(String, Vec<u8>)], clock: u32, all: bool) -> Result<Self, NotAnImage> {
        let from = Image::parse(image)?;
        let mut tracks = Vec::new();
        for chip in chip::all().into_iter().filter(|chip| all || chip.is_image()) {
            let Some((_, elf)) = boards.iter().find(|(board, _)| board == chip.board) else { continue };
            let map = LinkMap::new(from.clone(), Image::parse(elf)?);
            let side = |bound| Side {
                bound,
                memory: Memory::new(&chip, bound),
                pipeline: Pipeline::new(chip.processor, bound),
                began: 0,
            };
            let sides = [side(Bound::Lower), side(Bound::Upper)];
            tracks.push(Track { chip, map, sides, places: vec![], cycles: vec![], named: 0, by_name: vec![] });
        }
        Ok(Self {
            clock,
            places: Vec::new(),
            tracks,
            running: None,
            moved: Vec::new(),
            window: None,
            seen: Vec::new(),
            costs: HashMap::new(),
            ends_window: false,
            detour: DETOUR.iter().filter_map(|(at, text)| Some((*at, Instruction::parse(text).ok()?))).collect(),
            unknown: Vec::new(),
            told: String::new(),
        })
    }

    /// An instruction was translated: its number for [`Self::execute`].
    pub fn translate(&mut self, address: u32, bytes: u32, text: &str) -> usize {
        let instruction = Instruction::parse(text).unwrap_or_else(|mnemonic| {
            if !self.unknown.contains(&mnemonic) {
                self.unknown.push(mnemonic);
            }
            // What is not known costs at worst as much as anything does.
            Instruction { kind: Kind::System, words: 0, reads: 0, writes: 0, conditional: false, double: false }
        });
        self.places.push(Place { address, bytes, instruction });
        for track in &mut self.tracks {
            let carried = track.map.carry(address);
            track.places.push(carried.address);
            track.by_name.push(carried.by_name);
            track.cycles.push(0);
        }
        self.places.len() - 1
    }

    /// An instruction begins.
    pub fn execute(&mut self, number: usize) {
        self.finish(number);
        self.running = Some(number);
    }

    /// The instruction that runs moves data.
    pub fn access(&mut self, address: u32, write: bool) {
        self.ends_window |= address == self.clock && !write;
        self.moved.push((address, write));
    }

    /// The instruction that ran is over; the next one is this.
    fn finish(&mut self, next: usize) {
        let Some(number) = self.running.take() else { return };
        let Some(Place { address, bytes, instruction }) = self.places.get(number) else { return };
        let follows = address.wrapping_add(*bytes);
        let jumped = self.places.get(next).is_some_and(|next| next.address != follows);
        let in_window = self.window.is_some();
        let is_first = in_window && self.tracks.iter().all(|track| track.cycles.get(number) == Some(&0));
        if is_first {
            self.seen.push(number);
        }
        for Track { sides, places, cycles, map, named, by_name, .. } in &mut self.tracks {
            let Some(&at) = places.get(number) else { continue };
            *named += u64::from(by_name.get(number).copied().unwrap_or(false));
            // The boards' memories for code lie further apart than a branch reaches; the simulated board has one.
            let goal = if jumped && instruction.kind == Kind::Branch { places.get(next) } else { None };
            let detour = goal.and_then(|&goal| map.target().detour(at, goal));
            for Side { bound, memory, pipeline, .. } in sides {
                let before = pipeline.now();
                let fetch = memory.fetch(at, *bytes, before);
                let mut data = 0;
                for &(address, write) in &self.moved {
                    data += memory.access(map.carry(address).address, write);
                }
                pipeline.issue(instruction, fetch, data);
                if instruction.may_jump() {
                    pipeline.went(instruction, *address, jumped);
                }
                if let Some(start) = detour {
                    for (offset, instruction) in &self.detour {
                        let fetch = memory.fetch(start + offset, 4, pipeline.now());
                        pipeline.issue(instruction, fetch, 0);
                        if instruction.may_jump() {
                            pipeline.went(instruction, start, true);
                        }
                    }
                }
                if *bound == Bound::Upper
                    && in_window
                    && let Some(cycles) = cycles.get_mut(number)
                {
                    *cycles += pipeline.now() - before;
                }
            }
        }
        self.moved.clear();
        if let Some((_, instructions)) = &mut self.window {
            *instructions += 1;
        }
        if std::mem::take(&mut self.ends_window) {
            self.turn(*address);
        }
    }

    /// A window ends where the next one begins.
    fn turn(&mut self, address: u32) {
        if let Some((began, instructions)) = self.window.replace((address, 0)) {
            let _ = write!(self.told, "{} {began:#x} {address:#x} {instructions}", report::WINDOW);
            let costs = self.costs.entry([began, address]).or_default();
            for number in self.seen.drain(..) {
                let of_chips = costs.entry(number).or_insert_with(|| vec![0; self.tracks.len()]);
                for (sum, track) in of_chips.iter_mut().zip(&mut self.tracks) {
                    *sum += track.cycles.get_mut(number).map_or(0, std::mem::take);
                }
            }
            for track in &self.tracks {
                let [lower, upper] = track.sides.each_ref().map(|side| side.pipeline.now() - side.began);
                let _ = write!(self.told, " {lower} {upper} {}", track.named);
            }
            self.told.push('\n');
        }
        for track in &mut self.tracks {
            track.named = 0;
        }
        for side in self.tracks.iter_mut().flat_map(|track| &mut track.sides) {
            if side.bound == Bound::Upper {
                side.memory.empty();
                side.pipeline.forget();
            }
            side.began = side.pipeline.now();
        }
    }

    /// What has been measured since this was asked last: lines for [`report::Report::parse`].
    pub fn lines(&mut self) -> String {
        std::mem::take(&mut self.told)
    }

    /// The state of things that are not told window by window, in lines; those of later calls replace them.
    pub fn summary(&self) -> String {
        let mut told = String::new();
        for mnemonic in &self.unknown {
            let _ = writeln!(told, "{} {mnemonic}", report::UNKNOWN);
        }
        for (index, track) in self.tracks.iter().enumerate() {
            let Chip { board, layout, clock_hz, .. } = track.chip;
            let _ = writeln!(told, "{} {index} {board} {clock_hz} {layout}", report::CHIP);
            for ([from, to], costs) in &self.costs {
                let of_this = |(&number, costs): (&usize, &Vec<u64>)| Some((costs.get(index).copied()?, number));
                let places: Vec<(u64, usize)> = costs.iter().filter_map(of_this).collect();
                let all = places.iter().map(|(cycles, _)| cycles).sum::<u64>().max(1) as f64;
                let mut functions: HashMap<&str, u64> = HashMap::new();
                for &(cycles, number) in &places {
                    let function = track.places.get(number).and_then(|&address| track.map.target().function(address));
                    *functions.entry(function.unwrap_or("?")).or_default() += cycles;
                }
                for (cycles, number) in costliest(places) {
                    let Some(&address) = track.places.get(number) else { continue };
                    let (share, name) = (cycles as f64 / all, track.map.target().name(address));
                    let _ =
                        writeln!(told, "{} {index} {from:#x} {to:#x} {share:.5} {address:#x} {name}", report::ADDRESS);
                }
                for (cycles, name) in costliest(functions.into_iter().map(|(name, cycles)| (cycles, name)).collect()) {
                    let share = cycles as f64 / all;
                    let _ = writeln!(told, "{} {index} {from:#x} {to:#x} {share:.5} {name}", report::FUNCTION);
                }
            }
        }
        told
    }
}

/// The costliest entries, in descending order.
fn costliest<P: Ord>(mut of: Vec<(u64, P)>) -> Vec<(u64, P)> {
    of.sort_unstable_by(|a, b| b.cmp(a));
    of.truncate(report::COSTLIEST);
    of
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_linker_puts_between_is_known_and_ends_with_a_branch() {
        let kinds: Vec<_> = DETOUR.iter().map(|(_, text)| Instruction::parse(text).map(|it| it.kind)).collect();
        assert_eq!(kinds, [Ok(Kind::Simple), Ok(Kind::Simple), Ok(Kind::IndirectBranch)]);
    }
}
