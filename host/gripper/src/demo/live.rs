//! What is seen while it runs: lines of text, a few a second, on any terminal or into a file.

use std::io::{self, Write};

use super::sample::Sample;
use fre_qemu::Pace;

/// Lines between two headings on a terminal.
const HEADING: u32 = 24;
/// Width of the force's bar, letters.
const BAR: usize = 10;

/// The table that grows.
pub struct Live {
    terminal: bool,
    pace: Pace,
    cost_hz: u32,
    /// Force of a full bar, N.
    full: f64,
    lines: u32,
}

impl Live {
    /// For a terminal or a file; `full` is the force of a full bar, N.
    pub fn new(terminal: bool, pace: Pace, cost_hz: u32, full: f64) -> Self {
        Self { terminal, pace, cost_hz, full, lines: 0 }
    }

    /// Lines per second.
    pub fn rate(&self) -> f64 {
        if self.terminal { 5.0 } else { 2.0 }
    }

    /// The latest sample to which both references have answered, at a time in s.
    ///
    /// # Errors
    /// The output's.
    pub fn show(&mut self, out: &mut dyn Write, time: f64, sample: &Sample) -> io::Result<()> {
        if self.lines == 0 || (self.terminal && self.lines.is_multiple_of(HEADING)) {
            let unit = if self.pace == Pace::Free { "µs" } else { "instr." };
            writeln!(out)?;
            writeln!(out, "  time   angle            target   trapezoid 170/20         paper 170/20")?;
            writeln!(
                out,
                "     s       °                 N       N    Δ N    Δ %       N    Δ N    Δ %  {unit:>7}  status"
            )?;
        }
        self.lines += 1;
        let number = |value: Option<f64>, width: usize, decimals: usize, sign: bool| match value {
            None => format!("{:>width$}", "–"),
            // No minus before a zero.
            Some(value) => {
                let scale = 10_f64.powi(decimals as i32);
                let value = (value * scale).round() / scale + 0.0;
                if sign { format!("{value:>+width$.decimals$}") } else { format!("{value:>width$.decimals$}") }
            }
        };
        let trustworthy = sample.is_trustworthy();
        let known = |value: f64| trustworthy.then_some(value);
        let [trapezoid, paper] = [0, 1].map(|which| {
            let difference = |value: Option<f64>| value.filter(|_| trustworthy);
            format!(
                "{} {} {}",
                number(sample.reference(which), 7, 2, false),
                number(difference(sample.excess(which)), 6, 2, true),
                number(difference(sample.excess_percent(which)), 6, 2, true)
            )
        });
        let force = number(known(sample.magnitude()), 7, 2, false);
        writeln!(
            out,
            "{time:>6.1} {:>7.2}  {} {force} {trapezoid} {paper}  {:>7}  {}",
            sample.angle_deg,
            bar(known(sample.magnitude()).unwrap_or(0.0) / self.full),
            self.cost(sample),
            sample.report.estimate.status
        )?;
        out.flush()
    }

    fn cost(&self, sample: &Sample) -> String {
        let cost = f64::from(sample.report.cost);
        match self.pace.instructions_per_tick(self.cost_hz) {
            Some(each) => grouped((cost * each).round() as u64),
            None => format!("{:.0}", 1e6 * cost / f64::from(self.cost_hz.max(1))),
        }
    }
}

/// A bar of eighths of letters, 0 to 1.
fn bar(part: f64) -> String {
    const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    let eighths = (part.clamp(0.0, 1.0) * 8.0 * BAR as f64).round() as usize;
    let text = "█".repeat(eighths / 8) + EIGHTHS[eighths % 8];
    format!("{text:<BAR$}")
}

/// A number with a comma between thousands.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_have_one_width() {
        for part in [-1.0, 0.0, 0.01, 0.5, 0.999, 1.0, 7.0, f64::NAN] {
            assert_eq!(bar(part).chars().count(), BAR, "{part}");
        }
        assert_eq!(bar(0.55).trim_end(), "█████▌");
    }

    #[test]
    fn thousands_are_told_apart() {
        for (number, words) in [(0, "0"), (999, "999"), (1000, "1,000"), (1_234_567, "1,234,567")] {
            assert_eq!(grouped(number), words);
        }
    }
}
