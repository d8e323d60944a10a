//! A processor's pipeline: when an instruction issues, and when its result is there.
//!
//! | figure | Cortex-M4 | Cortex-M7 |
//! |---|---|---|
//! | source | Arm DDI 0439 (instruction timing, floating-point instruction set) | `ARMScheduleM7.td` of LLVM, which names its units and latencies; the ends of the ranges are set around them |
//! | issue | one | two, but for division, multiples, doubles, and two of the same single unit |
//! | load | 2 cycles, 1 behind another load or store | its result one or two cycles later |
//! | branch taken | 1 + 1 to 3 cycles to refill | predicted: none; wrongly: 4 to 8 |
//! | `vadd`, `vmul` | 1, another if the next one needs it | result after 3 |
//! | `vmla`, `vfma` | 3, another if the next one needs it | result after 6, its addend needed after 3 |
//! | `vdiv`, `vsqrt` | 14 | 14 to 16, the unit busy |
//! | the same of doubles: `vadd`, `vmul` | – | result after 4 to 7 |
//! | `vmla`, `vfma` | – | result after 11, its addend needed after 4 to 7 |
//! | `vdiv`, `vsqrt` | – | 28 to 32, the unit busy |
//! | `sdiv`, `udiv` | 2 to 12 | 7, bracketed by 2 and 12 |
//!
//! How often doubles may issue is not published: at best every cycle, at worst when the one before has its result.

use std::collections::HashMap;

use crate::instruction::{Instruction, Kind, REGISTERS, Registers};
use crate::{Bound, Range};

/// A processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Processor {
    /// In order, one at a time.
    CortexM4,
    /// In order, two at a time.
    CortexM7 {
        /// Bytes of its data cache.
        data_cache_bytes: u32,
    },
}

/// Cycles of a kind of instruction: how long it keeps the next from issuing, and when its result is there.
struct Cost {
    issue: Range,
    result: Range,
}

const fn cost(issue: Range, result: Range) -> Cost {
    Cost { issue, result }
}

const ONE: Range = Range::exactly(1);

impl Processor {
    fn cost(self, kind: Kind) -> Cost {
        match self {
            Self::CortexM4 => match kind {
                Kind::Nothing => cost(Range::between(0, 1), ONE),
                Kind::Simple | Kind::Transfer | Kind::Branch | Kind::Multiply => cost(ONE, ONE),
                Kind::IndirectBranch => cost(ONE, ONE),
                Kind::Divide => cost(Range::between(2, 12), Range::between(2, 12)),
                Kind::Load | Kind::Store => cost(Range::between(1, 2), Range::exactly(2)),
                Kind::Float => cost(ONE, Range::exactly(2)),
                Kind::FloatChain => cost(Range::exactly(3), Range::exactly(4)),
                Kind::FloatDivide | Kind::FloatRoot => cost(Range::exactly(14), Range::exactly(15)),
                Kind::System => cost(Range::between(1, 4), Range::between(1, 4)),
            },
            Self::CortexM7 { .. } => match kind {
                Kind::Nothing => cost(Range::between(0, 1), ONE),
                Kind::Simple | Kind::Branch | Kind::IndirectBranch => cost(ONE, Range::between(1, 2)),
                Kind::Multiply => cost(ONE, Range::exactly(2)),
                Kind::Divide => cost(Range::between(2, 12), Range::between(2, 12)),
                Kind::Load => cost(ONE, Range::between(1, 3)),
                Kind::Store => cost(ONE, ONE),
                Kind::Transfer => cost(ONE, Range::between(1, 3)),
                Kind::Float => cost(ONE, Range::exactly(3)),
                Kind::FloatChain => cost(ONE, Range::between(3, 6)),
                Kind::FloatDivide | Kind::FloatRoot => cost(ONE, Range::between(14, 16)),
                Kind::System => cost(Range::between(1, 12), Range::between(1, 12)),
            },
        }
    }

    /// The same of an instruction. A Cortex-M4 has no unit for doubles.
    fn cost_of(self, instruction: &Instruction) -> Cost {
        match instruction.kind {
            Kind::Float if instruction.double => cost(Range::between(1, 7), Range::between(4, 7)),
            Kind::FloatChain if instruction.double => cost(Range::between(1, 11), Range::between(7, 11)),
            Kind::FloatDivide | Kind::FloatRoot if instruction.double => cost(ONE, Range::between(28, 32)),
            kind => self.cost(kind),
        }
    }

    /// Cycles that a jump adds: foreseen, and not.
    fn jump(self, foreseen: bool, indirect: bool) -> Range {
        match (self, foreseen, indirect) {
            (Self::CortexM4, ..) => Range::between(1, 3),
            (Self::CortexM7 { .. }, true, false) => Range::between(0, 1),
            (Self::CortexM7 { .. }, true, true) => Range::between(0, 8),
            (Self::CortexM7 { .. }, false, _) => Range::between(4, 8),
        }
    }

    /// That two instructions may issue in the same cycle.
    fn pairs(self, first: &Instruction, second: &Instruction) -> bool {
        if self == Self::CortexM4 {
            return false;
        }
        let alone = |it: &Instruction| {
            matches!(it.kind, Kind::Divide | Kind::System)
                || (matches!(it.kind, Kind::Load | Kind::Store) && it.words > 2)
        };
        let same_unit = (first.is_float() && second.is_float())
            || (first.kind == second.kind
                && matches!(
                    first.kind,
                    Kind::Multiply | Kind::Store | Kind::Branch | Kind::IndirectBranch | Kind::Transfer
                ));
        !(alone(first) || alone(second) || same_unit || first.may_jump())
    }
}

/// The state of a pipeline, as one bound sees it.
#[derive(Clone, Debug)]
pub struct Pipeline {
    processor: Processor,
    bound: Bound,
    /// The cycle in which the last instruction issued, or would have let the next one.
    now: u64,
    /// When each register's value is there.
    ready: [u64; REGISTERS],
    /// When the unit that divides is free.
    divider: u64,
    last: Option<Instruction>,
    /// That the last one issued beside the one before it.
    paired: bool,
    /// How each conditional branch went the last time, as far as a predictor knows.
    went: HashMap<u32, bool>,
}

impl Pipeline {
    /// An empty one.
    pub fn new(processor: Processor, bound: Bound) -> Self {
        Self {
            processor,
            bound,
            now: 0,
            ready: [0; REGISTERS],
            divider: 0,
            last: None,
            paired: false,
            went: HashMap::new(),
        }
    }

    /// Cycles so far.
    pub fn now(&self) -> u64 {
        self.now
    }

    /// Forgets how branches went.
    pub fn forget(&mut self) {
        self.went.clear();
    }

    /// The cycle in which the operands are there.
    fn operands(&self, instruction: &Instruction) -> u64 {
        // The addend of a multiply-accumulate is needed late: at best when the product is there.
        let late = if instruction.kind == Kind::FloatChain
            && self.bound == Bound::Lower
            && self.processor != Processor::CortexM4
        {
            instruction.writes
        } else {
            0
        };
        let ready = |(register, &cycle): (usize, &u64)| {
            let bit: Registers = 1 << register;
            if instruction.reads & bit == 0 {
                0
            } else if late & bit == 0 {
                cycle
            } else {
                cycle.saturating_sub(3)
            }
        };
        self.ready.iter().enumerate().map(ready).max().unwrap_or(0)
    }

    /// Issues an instruction that was waited for so many cycles, and whose data are waited for so many.
    pub fn issue(&mut self, instruction: &Instruction, fetch: u32, data: u32) {
        let Cost { issue, result } = self.processor.cost_of(instruction);
        let (mut issue, result) = (issue.at(self.bound), result.at(self.bound));
        if matches!(instruction.kind, Kind::Load | Kind::Store) {
            let beside = self.last.is_some_and(|last| matches!(last.kind, Kind::Load | Kind::Store));
            let words = match self.processor {
                // Two loads a cycle, or one of 64 bits.
                Processor::CortexM7 { .. } => {
                    instruction.words.div_ceil(if self.bound == Bound::Lower { 2 } else { 1 })
                }
                Processor::CortexM4 => instruction.words,
            };
            issue = issue.max(1) + words.saturating_sub(1);
            if self.processor == Processor::CortexM4 && instruction.kind == Kind::Load && !beside {
                issue = issue.max(1 + words);
            }
        }
        if issue == 0 && fetch == 0 {
            return;
        }
        let operands = self.operands(instruction);
        let beside = self.bound == Bound::Lower
            && fetch == 0
            && !self.paired
            && operands <= self.now
            && self.last.is_some_and(|last| {
                self.processor.pairs(&last, instruction) && last.writes & instruction.reads & !instruction.writes == 0
            });
        let divides = matches!(instruction.kind, Kind::FloatDivide | Kind::FloatRoot);
        let mut start = if beside { self.now } else { (self.now + 1 + u64::from(fetch)).max(operands) };
        // A Cortex-M4 waits for the end of a division anyway.
        if divides && self.processor != Processor::CortexM4 {
            start = start.max(self.divider);
            self.divider = start + u64::from(result);
        }
        // At best the processor goes on until somebody needs the data; at worst it waits.
        let (stall, late) = match self.bound {
            Bound::Lower => (0, data),
            Bound::Upper => (data, 0),
        };
        self.now = start + u64::from(issue.saturating_sub(1)) + u64::from(stall);
        let there = start + u64::from(result.max(issue)) + u64::from(stall) + u64::from(late);
        for (register, cycle) in self.ready.iter_mut().enumerate() {
            if instruction.writes & (1 << register) != 0 {
                *cycle = there;
            }
        }
        self.paired = beside;
        self.last = Some(*instruction);
    }

    /// How the branch that was issued last went.
    pub fn went(&mut self, instruction: &Instruction, address: u32, jumped: bool) {
        let foreseen = if instruction.may_stay() {
            // A branch that was never seen is taken to stay.
            self.went.insert(address, jumped).unwrap_or(false) == jumped || self.bound == Bound::Lower
        } else {
            true
        };
        let indirect = !matches!(instruction.kind, Kind::Branch);
        let cycles = match (jumped, foreseen) {
            (false, true) => 0,
            (true, true) => self.processor.jump(true, indirect).at(self.bound),
            (_, false) if self.processor == Processor::CortexM4 && !jumped => 0,
            (_, false) => self.processor.jump(false, indirect).at(self.bound),
        };
        self.now += u64::from(cycles);
        if jumped {
            self.paired = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const M4: Processor = Processor::CortexM4;
    const M7: Processor = Processor::CortexM7 { data_cache_bytes: 4096 };

    /// Cycles of a piece of code, repeated so often that its beginning does not count, per piece.
    fn cycles(processor: Processor, bound: Bound, code: &[&str]) -> f64 {
        let code: Vec<Instruction> = code.iter().map(|line| Instruction::parse(line).unwrap()).collect();
        let mut pipeline = Pipeline::new(processor, bound);
        for _ in 0..1000 {
            code.iter().for_each(|instruction| pipeline.issue(instruction, 0, 0));
        }
        pipeline.now() as f64 / 1000.0
    }

    fn both(processor: Processor, code: &[&str]) -> [f64; 2] {
        [Bound::Lower, Bound::Upper].map(|bound| cycles(processor, bound, code).round())
    }

    #[test]
    fn a_cortex_m4_takes_what_its_manual_says() {
        assert_eq!(both(M4, &["add r0, r1, r2"; 4]), [4.0, 4.0]);
        assert_eq!(both(M4, &["vadd.f32 s0, s1, s2", "vadd.f32 s3, s4, s5"]), [2.0, 2.0]);
        assert_eq!(
            both(M4, &["vadd.f32 s0, s0, s1", "vmul.f32 s0, s0, s2"]),
            [4.0, 4.0],
            "each waits for the one before"
        );
        assert_eq!(both(M4, &["vmla.f32 s0, s1, s2", "vmla.f32 s3, s1, s2"]), [6.0, 6.0]);
        assert_eq!(both(M4, &["vdiv.f32 s0, s1, s2"]), [14.0, 14.0]);
        assert_eq!(both(M4, &["ldr r0, [r4]", "ldr r1, [r4, #4]", "add r2, r3, r3"]), [4.0, 5.0]);
        assert_eq!(both(M4, &["ldm r4, {r0, r1, r2, r3}", "add r5, r6, r6"])[0], 6.0, "1 + N, and the sum");
    }

    #[test]
    fn a_cortex_m7_pairs_what_it_can() {
        assert_eq!(both(M7, &["add r0, r1, r2", "add r3, r4, r5"]), [1.0, 2.0]);
        assert_eq!(both(M7, &["add r0, r0, r2", "add r0, r0, r5"])[0], 2.0, "the second needs the first");
        assert_eq!(both(M7, &["vadd.f32 s0, s1, s2", "vmul.f32 s3, s4, s5"])[0], 2.0, "one floating-point unit");
        assert_eq!(both(M7, &["vadd.f32 s0, s1, s2", "ldr r0, [r1]"])[0], 1.0);
        assert_eq!(both(M7, &["vadd.f32 s0, s0, s1"]), [3.0, 3.0], "a chain goes by the latency");
        assert_eq!(both(M7, &["vmla.f32 s0, s1, s2"]), [1.0, 6.0], "an addend may come late");
        assert_eq!(both(M7, &["vdiv.f32 s0, s1, s2"]), [14.0, 16.0]);
        assert_eq!(both(M7, &["vdiv.f32 s0, s1, s2", "vadd.f32 s3, s4, s5"])[0], 14.0, "beside the division");
        assert_eq!(both(M7, &["vadd.f64 d0, d1, d2"]), [1.0, 7.0]);
        assert_eq!(both(M7, &["vadd.f64 d0, d0, d1"]), [4.0, 7.0], "a chain of doubles");
        assert_eq!(both(M7, &["vdiv.f64 d0, d1, d2"]), [28.0, 32.0]);
    }

    #[test]
    fn what_is_missing_delays_at_worst_at_once_and_at_best_whoever_needs_it() {
        let load = Instruction::parse("ldr r0, [r1]").unwrap();
        let other = Instruction::parse("add r2, r3, r4").unwrap();
        let user = Instruction::parse("add r2, r0, r4").unwrap();
        let run = |bound, last: &Instruction| {
            let mut pipeline = Pipeline::new(M7, bound);
            pipeline.issue(&load, 0, 20);
            pipeline.issue(last, 0, 0);
            pipeline.now()
        };
        assert_eq!(run(Bound::Lower, &other), 1);
        assert!(run(Bound::Lower, &user) > 20 && run(Bound::Upper, &other) > 20);
    }

    #[test]
    fn a_branch_that_was_foreseen_costs_less() {
        let branch = Instruction::parse("bne #8").unwrap();
        let mut pipeline = Pipeline::new(M7, Bound::Upper);
        let mut went = |jumped| {
            pipeline.issue(&branch, 0, 0);
            let before = pipeline.now();
            pipeline.went(&branch, 64, jumped);
            pipeline.now() - before
        };
        assert_eq!([went(true), went(true), went(false), went(false)], [8, 1, 8, 0]);
    }

    #[test]
    fn the_lower_bound_is_never_above_the_upper() {
        let pieces: [&[&str]; 4] = [
            &["vldr s0, [r1]", "vldr s1, [r1, #4]", "vmla.f32 s2, s0, s1", "vstr s2, [r1]"],
            &["push {r4, r5, lr}", "mul r4, r5, r4", "sdiv r4, r4, r5", "pop {r4, r5, r6}"],
            &["it ne", "movne r0, r1", "vmov s0, r0", "vcmp.f32 s0, s1", "vmrs apsr_nzcv, fpscr"],
            &["ldrd r0, r1, [r2]", "strd r0, r1, [r3]", "umull r0, r1, r2, r3"],
        ];
        for piece in pieces {
            for processor in [M4, M7] {
                let [lower, upper] = both(processor, piece);
                assert!(lower <= upper, "{piece:?} {processor:?}: {lower} {upper}");
            }
        }
    }
}
