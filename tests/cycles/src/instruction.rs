//! An instruction of Armv7E-M, as far as its timing goes, read from QEMU's disassembly.

/// What a processor has to do for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Folded away or of no effect: `nop`, `it`.
    Nothing,
    /// One pass through the arithmetic unit.
    Simple,
    /// `mul`, `mla`, `smull` and their like.
    Multiply,
    /// `sdiv`, `udiv`.
    Divide,
    /// Reads memory.
    Load,
    /// Writes memory.
    Store,
    /// To an address in the instruction.
    Branch,
    /// To an address in a register or a table.
    IndirectBranch,
    /// One pass through the floating-point unit.
    Float,
    /// Multiply and accumulate, fused or not.
    FloatChain,
    /// `vdiv`.
    FloatDivide,
    /// `vsqrt`.
    FloatRoot,
    /// Between the processor's registers and those of the floating-point unit.
    Transfer,
    /// Barriers, status registers, waiting.
    System,
}

/// Registers as bits: 0 to 15 the processor's, 16 to 47 the single-precision ones, 48 the floating-point flags.
pub type Registers = u64;

/// Number of registers that [`Registers`] names.
pub const REGISTERS: usize = 49;
const PROGRAM_COUNTER: Registers = 1 << 15;
const STACK_POINTER: Registers = 1 << 13;
const FLOAT_FLAGS: Registers = 1 << 48;

/// An instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// What has to be done.
    pub kind: Kind,
    /// Registers that a load or store moves; 0 for others.
    pub words: u32,
    /// Registers that it needs.
    pub reads: Registers,
    /// Registers that it makes.
    pub writes: Registers,
    /// That it may or may not jump: a conditional branch.
    pub conditional: bool,
    /// That it computes in double precision.
    pub double: bool,
}

const CONDITIONS: [&str; 16] =
    ["eq", "ne", "hs", "lo", "cs", "cc", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le"];
const SIMPLE: &str = "mov movw movt mvn add addw sub subw rsb adc sbc and orr orn eor bic lsl lsr asr ror rrx cmp cmn tst teq neg \
    uxtb uxth sxtb sxth uxtab uxtah sxtab sxtah uxtb16 sxtb16 uxtab16 sxtab16 ubfx sbfx bfi bfc clz rbit rev rev16 revsh adr sel \
    usat ssat usat16 ssat16 qadd qsub qdadd qdsub pkhbt pkhtb usad8 usada8 cpy sadd8 sadd16 ssub8 ssub16 sasx ssax uadd8 uadd16 \
    usub8 usub16 uasx usax qadd8 qadd16 qsub8 qsub16 qasx qsax uqadd8 uqadd16 uqsub8 uqsub16 uqasx uqsax shadd8 shadd16 shsub8 \
    shsub16 shasx shsax uhadd8 uhadd16 uhsub8 uhsub16 uhasx uhsax";
const MULTIPLY: &str = "mul mla mls smull umull smlal umlal umaal smulbb smulbt smultb smultt smlabb smlabt smlatb smlatt smulwb \
    smulwt smlawb smlawt smmul smmulr smmla smmlar smmls smuad smusd smlad smlsd smlald";
const LOAD: &str = "ldr ldrb ldrh ldrsb ldrsh ldrd ldm ldmia ldmdb ldmfd ldmea pop ldrex ldrexb ldrexh ldrt vldr vldm vldmia vldmdb vpop";
const STORE: &str =
    "str strb strh strd stm stmia stmdb stmfd stmea push strex strexb strexh strt vstr vstm vstmia vstmdb vpush";
const FLOAT: &str = "vadd vsub vmul vnmul vneg vabs vcmp vcmpe vcvt vcvtr vcvtb vcvtt vmov vsel vseleq vselge vselgt vselvs vmaxnm \
    vminnm vrintz vrintr vrintx vrinta vrintn vrintp vrintm vcvta vcvtn vcvtp vcvtm";
const FLOAT_CHAIN: &str = "vmla vmls vnmla vnmls vfma vfms vfnma vfnms";
const SYSTEM: &str = "mrs msr cpsid cpsie cps dsb dmb isb wfi wfe sev svc bkpt clrex udf yield";
const NOTHING: &str =
    "nop it ite itt itte itet ittt itee ittet itete iteet ittte itttt iteee ittee iteet itett ittee pld pli";
/// These do not read what they write, although they have two operands.
const ONE_WAY: &str = "mov movw mvn neg uxtb uxth sxtb sxth clz rbit rev rev16 revsh adr uxtb16 sxtb16 cpy vneg vabs vsqrt vcvt vcvtr \
    vcvtb vcvtt vmov vrintz vrintr vrintx vrinta vrintn vrintp vrintm vcvta vcvtn vcvtp vcvtm";
/// These keep part of what they write, or add to it.
const KEEPS: &str = "movt bfi bfc smlal umlal umaal smlald";
/// These write two registers.
const TWO_RESULTS: &str = "smull umull smlal umlal umaal smlald";
const COMPARES: &str = "cmp cmn tst teq";

fn among(list: &str, word: &str) -> bool {
    list.split_whitespace().any(|one| one == word)
}

/// The kind of a word without width, type, condition and `s`, and whether it is a conditional branch.
fn kind_of(word: &str) -> Option<(Kind, bool)> {
    let lists = [
        (NOTHING, Kind::Nothing),
        (SIMPLE, Kind::Simple),
        (MULTIPLY, Kind::Multiply),
        ("sdiv udiv", Kind::Divide),
        (LOAD, Kind::Load),
        (STORE, Kind::Store),
        ("b bl", Kind::Branch),
        ("bx blx tbb tbh", Kind::IndirectBranch),
        (FLOAT, Kind::Float),
        (FLOAT_CHAIN, Kind::FloatChain),
        ("vdiv", Kind::FloatDivide),
        ("vsqrt", Kind::FloatRoot),
        ("vmrs vmsr", Kind::Transfer),
        (SYSTEM, Kind::System),
    ];
    if ["cbz", "cbnz"].contains(&word) {
        return Some((Kind::Branch, true));
    }
    lists.iter().find(|(list, _)| among(list, word)).map(|&(_, kind)| (kind, false))
}

/// The word as the lists know it, with its kind, and whether it is a conditional branch.
fn known(word: &str) -> Option<(&str, Kind, bool)> {
    if let Some((kind, conditional)) = kind_of(word) {
        return Some((word, kind, conditional));
    }
    let without = |end: &str| word.strip_suffix(end).and_then(|rest| kind_of(rest).map(|found| (rest, found)));
    if let Some((rest, (kind, _))) = CONDITIONS.iter().find_map(|condition| without(condition)) {
        return Some((rest, kind, kind == Kind::Branch));
    }
    let sets_flags = |word: &str| word.len() - usize::from(word.ends_with('s'));
    let plain = |word: &'_ str| -> Option<usize> {
        let length = sets_flags(word);
        (length < word.len() && word.get(..length).and_then(kind_of).is_some()).then_some(length)
    };
    let length = plain(word)
        .or_else(|| CONDITIONS.iter().filter_map(|condition| word.strip_suffix(condition)).find_map(plain))?;
    let word = word.get(..length)?;
    kind_of(word).map(|(kind, conditional)| (word, kind, conditional))
}

impl Instruction {
    /// Reads a line such as `vmul.f32 s0, s0, s1`.
    ///
    /// # Errors
    /// The mnemonic, if it is not known.
    pub fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim().to_ascii_lowercase();
        let (mnemonic, operands) = text.split_once(char::is_whitespace).unwrap_or((&text, ""));
        let mut parts = mnemonic.split('.');
        let word = parts.next().unwrap_or_default();
        let double = parts.any(|part| part == "f64");
        let (word, mut kind, conditional) = known(word).ok_or_else(|| mnemonic.to_owned())?;
        let operands = split(operands);
        let registers: Vec<Registers> = operands.iter().map(|operand| named(operand)).collect();
        let all = |list: &[Registers]| list.iter().fold(0, |all, one| all | one);
        let first = registers.first().copied().unwrap_or(0);
        let rest = all(registers.get(1..).unwrap_or_default());
        let (mut reads, mut writes) = (rest, first);
        match kind {
            Kind::Load | Kind::Store => {
                let (moved, address) = moved_and_address(word, &operands, &registers);
                let back = operands.iter().any(|operand| operand.ends_with('!'))
                    || (operands.len() > 2 && operands.last().is_some_and(|last| last.starts_with('#')));
                let base = if back || matches!(word, "push" | "pop" | "vpush" | "vpop") { address } else { 0 };
                let words = moved.count_ones();
                let jumps = kind == Kind::Load && moved & PROGRAM_COUNTER != 0;
                (reads, writes) = if kind == Kind::Load { (address, moved | base) } else { (address | moved, base) };
                // `strex r0, r1, [r2]` writes its first operand.
                if word.starts_with("strex") {
                    (reads, writes) = (rest, first);
                }
                return Ok(Self { kind, words, reads, writes, conditional: jumps, double: false });
            }
            Kind::Branch | Kind::IndirectBranch => (reads, writes) = (first | rest, 0),
            Kind::Nothing | Kind::System => (reads, writes) = (0, if word == "mrs" { first } else { 0 }),
            _ if among(COMPARES, word) => (reads, writes) = (first | rest, 0),
            _ if word.starts_with("vcmp") => (reads, writes) = (first | rest, FLOAT_FLAGS),
            Kind::Transfer => (reads, writes) = (FLOAT_FLAGS, if first >> 16 == 0 { first } else { 0 }),
            _ => {
                let two = among(TWO_RESULTS, word) || (word == "vmov" && operands.len() > 2);
                if two && operands.len() > 2 {
                    // `vmov d0, r0, r1` has one result, `vmov r0, r1, d0` and `vmov s0, s1, r0, r1` have two.
                    let one = word == "vmov" && operands.len() == 3 && first >> 16 != 0;
                    let results = if one { 1 } else { 2 };
                    writes = all(registers.get(..results).unwrap_or_default());
                    reads = all(registers.get(results..).unwrap_or_default());
                }
                let in_place = operands.len() == 2 && !among(ONE_WAY, word);
                if in_place || among(KEEPS, word) || kind == Kind::FloatChain {
                    reads |= writes;
                }
                let core = |registers: Registers| registers & 0xffff != 0;
                if word == "vmov" && (core(reads) || core(writes)) {
                    kind = Kind::Transfer;
                }
                // A conditional instruction keeps its result where the condition fails; so does whoever waits for it.
                if writes & PROGRAM_COUNTER != 0 {
                    kind = Kind::IndirectBranch;
                }
            }
        }
        Ok(Self { kind, words: 0, reads, writes, conditional, double })
    }

    /// That the next instruction need not be the one behind it.
    pub fn may_jump(&self) -> bool {
        matches!(self.kind, Kind::Branch | Kind::IndirectBranch) || (self.kind == Kind::Load && self.conditional)
    }

    /// That it may stay although it is a branch.
    pub fn may_stay(&self) -> bool {
        self.kind == Kind::Branch && self.conditional
    }

    /// That it occupies the floating-point unit.
    pub fn is_float(&self) -> bool {
        matches!(self.kind, Kind::Float | Kind::FloatChain | Kind::FloatDivide | Kind::FloatRoot)
    }
}

/// Registers that a load or store moves, and those of its address.
fn moved_and_address(word: &str, operands: &[String], registers: &[Registers]) -> (Registers, Registers) {
    let first = registers.first().copied().unwrap_or(0);
    if matches!(word, "push" | "pop" | "vpush" | "vpop") {
        return (first, STACK_POINTER);
    }
    let list = operands.iter().zip(registers).find(|(operand, _)| operand.starts_with('{'));
    if let Some((_, &list)) = list {
        return (list, first);
    }
    let address = operands.iter().zip(registers).find(|(operand, _)| operand.starts_with('['));
    let address = address.map_or(0, |(_, &registers)| registers);
    let two = matches!(word, "ldrd" | "strd");
    let second = if two { registers.get(1).copied().unwrap_or(0) } else { 0 };
    (first | second, address)
}

/// Operands, split at commas that are in no bracket.
fn split(text: &str) -> Vec<String> {
    let mut operands = vec![String::new()];
    let mut depth = 0;
    for letter in text.chars() {
        match letter {
            '[' | '{' => depth += 1,
            ']' | '}' => depth -= 1,
            ',' if depth == 0 => {
                operands.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(last) = operands.last_mut() {
            last.push(letter);
        }
    }
    operands.into_iter().map(|operand| operand.trim().to_owned()).filter(|operand| !operand.is_empty()).collect()
}

/// Registers that an operand names, ranges of a list included.
fn named(operand: &str) -> Registers {
    let mut all = 0;
    let mut from: Option<(char, u32)> = None;
    let words = operand.split_inclusive(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_');
    let mut ranged = false;
    for word in words {
        let end = word.chars().last().filter(|letter| !letter.is_ascii_alphanumeric());
        let name = word.trim_end_matches(|letter: char| !letter.is_ascii_alphanumeric());
        if let Some((bank, number)) = register(name) {
            let first = match from.filter(|_| ranged) {
                Some((same, first)) if same == bank => first,
                _ => number,
            };
            all |= (first..=number).fold(0, |all, number| all | bit(bank, number));
            from = Some((bank, number));
        }
        // A minus between two registers makes a range, one before a number does not matter.
        ranged = end == Some('-') || (name.is_empty() && ranged);
    }
    all
}

fn register(name: &str) -> Option<(char, u32)> {
    let number = match name {
        "sb" => 9,
        "sl" => 10,
        "fp" => 11,
        "ip" => 12,
        "sp" => 13,
        "lr" => 14,
        "pc" => 15,
        _ => {
            let bank = name.chars().next().filter(|bank| "rsd".contains(*bank))?;
            let number: u32 = name.get(1..)?.parse().ok()?;
            let count = if bank == 's' { 32 } else { 16 };
            return (number < count).then_some((bank, number));
        }
    };
    Some(('r', number))
}

fn bit(bank: char, number: u32) -> Registers {
    match bank {
        's' => 1 << (16 + number),
        'd' => 3 << (16 + 2 * number),
        _ => 1 << number,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Instruction {
        Instruction::parse(text).unwrap_or_else(|word| panic!("`{word}` is not known"))
    }

    fn set(names: &str) -> Registers {
        names.split_whitespace().fold(0, |all, name| {
            let (bank, number) = register(name).unwrap();
            all | bit(bank, number)
        })
    }

    #[test]
    fn what_is_read_and_what_is_written_is_known() {
        let cases = [
            ("movs r0, #1", Kind::Simple, "", "r0"),
            ("mov.w r1, #0xf00000", Kind::Simple, "", "r1"),
            ("add r0, r1", Kind::Simple, "r0 r1", "r0"),
            ("add.w r0, r1, r2, lsl #2", Kind::Simple, "r1 r2", "r0"),
            ("addlo r3, r3, #1", Kind::Simple, "r3", "r3"),
            ("cmp r3, r4", Kind::Simple, "r3 r4", ""),
            ("movt r2, #5", Kind::Simple, "r2", "r2"),
            ("lsls r0, r1, #3", Kind::Simple, "r1", "r0"),
            ("muls r0, r1, r0", Kind::Multiply, "r1 r0", "r0"),
            ("mls r0, r1, r2, r3", Kind::Multiply, "r1 r2 r3", "r0"),
            ("umull r0, r1, r2, r3", Kind::Multiply, "r2 r3", "r0 r1"),
            ("umlal r0, r1, r2, r3", Kind::Multiply, "r0 r1 r2 r3", "r0 r1"),
            ("udiv r0, r1, r2", Kind::Divide, "r1 r2", "r0"),
            ("vadd.f32 s0, s1, s2", Kind::Float, "s1 s2", "s0"),
            ("vmla.f32 s0, s1, s2", Kind::FloatChain, "s0 s1 s2", "s0"),
            ("vmls.f32 s0, s1, s2", Kind::FloatChain, "s0 s1 s2", "s0"),
            ("vdiv.f32 s0, s1, s2", Kind::FloatDivide, "s1 s2", "s0"),
            ("vsqrt.f32 s0, s1", Kind::FloatRoot, "s1", "s0"),
            ("vcvt.f32.s32 s0, s1", Kind::Float, "s1", "s0"),
            ("vmov.f32 s0, s1", Kind::Float, "s1", "s0"),
            ("vmov s0, r1", Kind::Transfer, "r1", "s0"),
            ("vmov r1, s0", Kind::Transfer, "s0", "r1"),
            ("vmov r0, r1, d2", Kind::Transfer, "d2", "r0 r1"),
            ("vmov d2, r0, r1", Kind::Transfer, "r0 r1", "d2"),
            ("bl #0x1234", Kind::Branch, "", ""),
            ("bx lr", Kind::IndirectBranch, "lr", ""),
        ];
        for (text, kind, reads, writes) in cases {
            let it = parsed(text);
            assert_eq!((it.kind, it.reads, it.writes), (kind, set(reads), set(writes)), "{text}");
        }
    }

    #[test]
    fn loads_and_stores_move_words() {
        let cases = [
            ("ldr r0, [r1, #4]", Kind::Load, 1, "r1", "r0"),
            ("ldr r0, [r1], #4", Kind::Load, 1, "r1", "r0 r1"),
            ("ldr r0, [r1, #4]!", Kind::Load, 1, "r1", "r0 r1"),
            ("ldrd r0, r1, [r2]", Kind::Load, 2, "r2", "r0 r1"),
            ("strd r0, r1, [r2, #8]", Kind::Store, 2, "r0 r1 r2", ""),
            ("str.w r0, [r1, r2, lsl #2]", Kind::Store, 1, "r0 r1 r2", ""),
            ("push {r4, r5, lr}", Kind::Store, 3, "r4 r5 lr sp", "sp"),
            ("push.w {r4-r7, lr}", Kind::Store, 5, "r4 r5 r6 r7 lr sp", "sp"),
            ("ldm.w r0, {r1, r2, r3}", Kind::Load, 3, "r0", "r1 r2 r3"),
            ("stm r0!, {r1, r2}", Kind::Store, 2, "r0 r1 r2", "r0"),
            ("vldr s0, [r1, #8]", Kind::Load, 1, "r1", "s0"),
            ("vpush {d8, d9}", Kind::Store, 4, "d8 d9 sp", "sp"),
            ("vldmia r0!, {s0, s1}", Kind::Load, 2, "r0", "s0 s1 r0"),
        ];
        for (text, kind, words, reads, writes) in cases {
            let it = parsed(text);
            assert_eq!((it.kind, it.words, it.reads, it.writes), (kind, words, set(reads), set(writes)), "{text}");
            assert!(!it.may_jump(), "{text}");
        }
        let it = parsed("pop.w {r4, r5, pc}");
        assert!(it.may_jump() && !it.may_stay() && it.words == 3);
    }

    #[test]
    fn conditions_are_told_from_names() {
        for text in ["beq #8", "bls #8", "blt #8", "ble.w #8", "bhs #8", "cbz r0, #8", "cbnz r0, #8"] {
            assert!(parsed(text).may_stay(), "{text}");
        }
        for text in ["b #8", "bl #8", "b.w #8", "tbb [pc, r0]"] {
            let it = parsed(text);
            assert!(it.may_jump() && !it.may_stay(), "{text}");
        }
        for (text, kind) in [
            ("bics r0, r1", Kind::Simple),
            ("movne r0, r1", Kind::Simple),
            ("vmovgt.f32 s0, s1", Kind::Float),
            ("vmrs apsr_nzcv, fpscr", Kind::Transfer),
            ("it ne", Kind::Nothing),
            ("sbcs r0, r1", Kind::Simple),
            ("adcs r0, r1", Kind::Simple),
        ] {
            assert_eq!(parsed(text).kind, kind, "{text}");
        }
        assert_eq!(Instruction::parse("frobnicate r0"), Err("frobnicate".to_owned()));
    }

    #[test]
    fn the_flags_of_a_comparison_are_waited_for() {
        let compare = parsed("vcmp.f32 s0, s1");
        let fetch = parsed("vmrs apsr_nzcv, fpscr");
        assert_ne!(compare.writes & fetch.reads, 0);
    }
}
