//! What the plugin writes, read again.

use std::fmt;

pub(crate) const WINDOW: &str = "window";
pub(crate) const CHIP: &str = "chip";
pub(crate) const ADDRESS: &str = "address";
pub(crate) const FUNCTION: &str = "function";
pub(crate) const UNKNOWN: &str = "unknown";
/// How many addresses and functions are listed for each chip and kind of window.
pub(crate) const COSTLIEST: usize = 12;

/// Reads of the clock between those of a measurement at most. The line's interrupt notes when each byte comes.
const INTERRUPTS: usize = 256;

/// What was measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// In the order in which they ended.
    pub windows: Vec<Window>,
    /// In the order of a window's cycles.
    pub chips: Vec<Measured>,
    /// Mnemonics that could not be read.
    pub unknown: Vec<String>,
}

/// What lay between two reads of the clock.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Window {
    /// Addresses of the reads, in the image that QEMU ran.
    pub between: [u32; 2],
    /// Instructions, the second read's included.
    pub instructions: u64,
    /// Cycles, lower and upper bound, of each chip.
    pub cycles: Vec<[u64; 2]>,
    /// For each chip, how many of the instructions have an address in its image that is known by name.
    pub by_name: Vec<u64>,
}

impl Window {
    /// What lay between the first read of this and the last one of what follows.
    fn append(&mut self, next: &Self) {
        self.between[1] = next.between[1];
        self.instructions += next.instructions;
        for (all, more) in self.cycles.iter_mut().flatten().zip(next.cycles.iter().flatten()) {
            *all += more;
        }
        for (all, more) in self.by_name.iter_mut().zip(&next.by_name) {
            *all += more;
        }
    }
}

/// A chip in a layout.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The board's name.
    pub board: String,
    /// The layout's.
    pub layout: String,
    /// Hertz.
    pub clock_hz: f64,
    /// The costliest addresses of each kind of window.
    pub addresses: Vec<Cost>,
    /// The costliest functions.
    pub functions: Vec<Cost>,
}

/// What an address or a function costs within the windows between two reads of the clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost {
    /// Addresses of the reads, in the image that QEMU ran.
    pub between: [u32; 2],
    /// Share of their cycles, by the upper bound.
    pub share: f64,
    /// A function; or an address in the board's image, and what lies there.
    pub name: String,
}

/// A line that is none of the plugin's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BadLine(pub String);

impl fmt::Display for BadLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` is no line of the cycles' report", self.0)
    }
}

impl std::error::Error for BadLine {}

fn address(word: &str) -> Option<u32> {
    u32::from_str_radix(word.strip_prefix("0x")?, 16).ok()
}

impl Report {
    /// Reads the lines of the windows and of the summary. A last line without its end is left out: QEMU was ended while it was written.
    ///
    /// # Errors
    /// A line is none of the plugin's.
    pub fn parse(windows: &str, summary: &str) -> Result<Self, BadLine> {
        let mut report = Self::default();
        let whole = windows.rsplit_once('\n').map_or("", |(whole, _)| whole);
        for line in whole.lines().chain(summary.lines()) {
            report.line(line).ok_or_else(|| BadLine(line.to_owned()))?;
        }
        Ok(report)
    }

    /// What the firmware has measured itself, in its order, by what it says that each took, instructions; none where nothing fits, as when its
    /// report was lost. The firmware's clock counts `step` instructions at a time. They all lie between the same two reads of the clock:
    /// those between which most of them fit. An interrupt may have read it meanwhile: then a measurement is several windows.
    pub fn measured_as(&self, costs: &[f64], step: f64) -> Vec<Option<Window>> {
        let mut places: Vec<[u32; 2]> = self.windows.iter().map(|window| window.between).collect();
        places.sort_unstable();
        places.dedup();
        let fitted = places.into_iter().map(|between| self.fitted(between, costs, step));
        fitted.max_by_key(|found| found.iter().flatten().count()).unwrap_or_else(|| vec![None; costs.len()])
    }

    /// The longest common sequence of the costs and of what lies between two reads.
    fn fitted(&self, between: [u32; 2], costs: &[f64], step: f64) -> Vec<Option<Window>> {
        let candidates = self.candidates(between);
        let fits = |cost: f64, window: &Window| (window.instructions as f64 - cost).abs() <= 2.0 * step;
        // How many of the costs from one on fit with candidates from one on.
        let width = candidates.len() + 1;
        let mut counts = vec![0_u32; (costs.len() + 1) * width];
        for (row, &cost) in costs.iter().enumerate().rev() {
            for (column, window) in candidates.iter().enumerate().rev() {
                let at = |row: usize, column: usize| counts[row * width + column];
                let both = if fits(cost, window) { at(row + 1, column + 1) + 1 } else { 0 };
                counts[row * width + column] = both.max(at(row + 1, column)).max(at(row, column + 1));
            }
        }
        let mut column = 0;
        let mut find = |(row, &cost): (usize, &f64)| {
            let at = |row: usize, column: usize| counts[row * width + column];
            while let Some(window) = candidates.get(column) {
                if fits(cost, window) && at(row, column) == at(row + 1, column + 1) + 1 {
                    column += 1;
                    return Some(window.clone());
                }
                // Nothing here is for this cost, or this candidate is for none.
                if at(row, column) == at(row + 1, column) {
                    return None;
                }
                column += 1;
            }
            None
        };
        costs.iter().enumerate().map(&mut find).collect()
    }

    /// Everything from one read to the last time that the other is reached before the first comes again, in their order.
    fn candidates(&self, between: [u32; 2]) -> Vec<Window> {
        let mut candidates = Vec::new();
        for (index, first) in self.windows.iter().enumerate().filter(|(_, window)| window.between[0] == between[0]) {
            let mut whole = first.clone();
            let mut found = None;
            for next in self.windows.iter().skip(index + 1).take(INTERRUPTS) {
                let [_, last] = whole.between;
                if last == between[1] {
                    found = Some(whole.clone());
                }
                if last == between[0] || next.between[0] != last {
                    break;
                }
                whole.append(next);
            }
            candidates.extend(if whole.between == between { Some(whole) } else { found });
        }
        candidates
    }

    fn line(&mut self, line: &str) -> Option<()> {
        let mut words = line.split(' ');
        match words.next()? {
            WINDOW => {
                let between = [address(words.next()?)?, address(words.next()?)?];
                let instructions = words.next()?.parse().ok()?;
                let numbers: Option<Vec<u64>> = words.map(|word| word.parse().ok()).collect();
                let numbers = numbers?;
                let (chips, []) = numbers.as_chunks::<3>() else { return None };
                let (cycles, by_name) = chips.iter().map(|&[lower, upper, named]| ([lower, upper], named)).unzip();
                self.windows.push(Window { between, instructions, cycles, by_name });
            }
            CHIP => {
                let (_, board) = (words.next()?, words.next()?.to_owned());
                let clock_hz = words.next()?.parse().ok()?;
                let layout = words.collect::<Vec<_>>().join(" ");
                self.chips.push(Measured { board, layout, clock_hz, addresses: Vec::new(), functions: Vec::new() });
            }
            kind @ (ADDRESS | FUNCTION) => {
                let chip: usize = words.next()?.parse().ok()?;
                let between = [address(words.next()?)?, address(words.next()?)?];
                let share = words.next()?.parse().ok()?;
                let name = words.collect::<Vec<_>>().join(" ");
                let Measured { addresses, functions, .. } = self.chips.get_mut(chip)?;
                let costs = if kind == ADDRESS { addresses } else { functions };
                costs.push(Cost { between, share, name });
            }
            UNKNOWN => self.unknown.push(words.next()?.to_owned()),
            _ => return None,
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read() {
        let windows = "window 0x10 0x20 7 8 9 6 10 11 7\nwindow 0x10 0x20 7 8";
        let summary = "unknown vrsqrte.f32\nchip 0 opencr 216000000 flash, caches\naddress 0 0x10 0x20 0.25000 0x8000100 solve + 0x4\n\
            function 0 0x10 0x20 0.75000 solve\n";
        let report = Report::parse(windows, summary).unwrap();
        assert_eq!(report.windows.len(), 1, "the second was cut");
        assert_eq!(
            (&report.windows[0].cycles[..], &report.windows[0].by_name[..]),
            (&[[8, 9], [10, 11]][..], &[6, 7][..])
        );
        assert_eq!(report.unknown, ["vrsqrte.f32"]);
        let [chip] = report.chips.as_slice() else { panic!("{report:?}") };
        assert_eq!((chip.board.as_str(), chip.layout.as_str()), ("opencr", "flash, caches"));
        let cost = |share, name: &str| Cost { between: [0x10, 0x20], share, name: name.to_owned() };
        assert_eq!(chip.addresses, [cost(0.25, "0x8000100 solve + 0x4")]);
        assert_eq!(chip.functions, [cost(0.75, "solve")]);
        assert!(Report::parse("nonsense\n", "").is_err());
    }

    #[test]
    fn windows_are_found_by_their_cost_in_order() {
        let window = |(place, count)| format!("window {place:#x} 0x2 {count}\n");
        // Between other reads of the clock there may be as many instructions.
        let lines: String = [(1, 5), (3, 1000), (1, 1000), (3, 7), (1, 2003), (3, 6), (1, 1000)].map(window).concat();
        let report = Report::parse(&lines, "").unwrap();
        let found = report.measured_as(&[1000.0, 2000.0, 5000.0, 1000.0], 10.0);
        assert!(found.iter().flatten().all(|window| window.between == [1, 2]));
        let instructions = |window: &Option<Window>| window.as_ref().map(|window| window.instructions);
        let found: Vec<Option<u64>> = found.iter().map(instructions).collect();
        assert_eq!(found, [Some(1000), Some(2003), None, Some(1000)]);
    }

    #[test]
    fn one_that_is_lost_takes_no_other_with_it() {
        let lines: String = [500, 300, 400, 600, 700].map(|count| format!("window 0x1 0x2 {count}\n")).concat();
        let report = Report::parse(&lines, "").unwrap();
        // Of the first no window was written; one much later is as long.
        let found = report.measured_as(&[700.0, 500.0, 300.0, 400.0], 1.0);
        let found: Vec<_> = found.iter().map(|window| window.as_ref().map(|window| window.instructions)).collect();
        assert_eq!(found, [None, Some(500), Some(300), Some(400)]);
    }

    /// What looks at the clock on its way, at the same place where it ends.
    #[test]
    fn a_measurement_in_steps_is_whole() {
        let reads = [
            (1, 2, 500),
            (2, 9, 80),
            (9, 1, 40),
            (1, 2, 300),
            (2, 2, 250),
            (2, 2, 150),
            (2, 9, 90),
            (9, 1, 30),
            (1, 2, 400),
        ];
        let line = |(from, to, count): (u32, u32, u64)| format!("window {from:#x} {to:#x} {count}\n");
        let report = Report::parse(&reads.map(line).concat(), "").unwrap();
        let found = report.measured_as(&[500.0, 700.0, 400.0], 5.0);
        let instructions: Vec<_> = found.iter().flatten().map(|window| window.instructions).collect();
        assert_eq!(instructions, [500, 700, 400]);
    }

    #[test]
    fn a_measurement_that_is_interrupted_is_whole() {
        let reads = [(1, 2, 1000), (2, 1, 50), (1, 7, 300), (7, 7, 20), (7, 2, 400), (2, 1, 60), (1, 2, 900)];
        let line =
            |(from, to, count): (u32, u32, u64)| format!("window {from:#x} {to:#x} {count} {count} {} 1\n", 2 * count);
        let report = Report::parse(&reads.map(line).concat(), "").unwrap();
        let found = report.measured_as(&[1000.0, 720.0, 900.0], 1.0);
        let cycles: Vec<_> = found.iter().flatten().map(|window| (window.cycles[0], window.by_name[0])).collect();
        assert_eq!(cycles, [([1000, 2000], 1), ([720, 1440], 3), ([900, 1800], 1)]);
    }
}
