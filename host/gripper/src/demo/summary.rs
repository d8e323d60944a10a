//! What came of it: differences, rates, losses, costs, and whether it is what it should be.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use messages::Counters;
use model_core::status::Status;

use super::live::grouped;
use super::sample::{FLOOR_N, REFERENCES, Sample, Way};
use super::seen::Seen;
use fre::metrics::distance;

/// A trustworthy estimate may differ from `trapezoid` 170/20 by so much, percent (of at least [`FLOOR_N`]: 0.05 N).
pub const ALLOWED_PERCENT: f64 = 1.0;
/// Part of the estimates that may differ by more, and part that may be untrustworthy.
const EXCUSED: f64 = 0.01;
/// The chip that costs are given for, and how many of its cycles an instruction takes: an assumption.
const CHIP_HZ: f64 = 216e6;
const CYCLES_PER_INSTRUCTION: f64 = 1.5;

/// Differences of many estimates from a reference: lengths of the differences of the force vectors, in contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Difference {
    /// Estimates compared.
    pub count: usize,
    /// Root of the mean square: N, and percent of the reference's force (of at least [`FLOOR_N`]).
    pub rms: [f64; 2],
    /// Greatest, likewise, each on its own.
    pub max: [f64; 2],
    /// Motor angle of the greatest in percent, degrees.
    pub max_at_deg: f64,
}

impl Difference {
    /// Of some samples from a reference.
    pub fn of<'s>(samples: impl Iterator<Item = &'s Sample>, which: usize) -> Self {
        let mut all = Self::default();
        let mut squares = [0.0; 2];
        for (sample, off) in samples.filter_map(|sample| Some((sample, sample.difference(which)?))) {
            all.count += 1;
            if off[1] > all.max[1] {
                all.max_at_deg = sample.angle_deg;
            }
            for i in 0..2 {
                squares[i] += off[i] * off[i];
                all.max[i] = all.max[i].max(off[i]);
            }
        }
        let count = all.count.max(1) as f64;
        all.rms = squares.map(|sum| (sum / count).sqrt());
        all
    }
}

/// What ticks cost, in instructions if they are counted, else in µs of this PC.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Ticks.
    pub count: usize,
    /// Mean.
    pub mean: f64,
    /// Greatest.
    pub max: f64,
}

impl Cost {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut cost = Self::default();
        let mut sum = 0.0;
        for value in values {
            cost.count += 1;
            sum += value;
            cost.max = cost.max.max(value);
        }
        cost.mean = sum / cost.count.max(1) as f64;
        cost
    }
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct Summary {
    /// By reference ([`REFERENCES`]) and way ([`Way::BOTH`]).
    pub differences: [[Difference; 2]; 2],
    /// Ticks by status.
    pub statuses: BTreeMap<&'static str, usize>,
    /// Whole closings and openings.
    pub cycles: u32,
    /// Reports that came, and those of them with an estimate.
    pub reports: usize,
    /// See `reports`.
    pub estimates: usize,
    /// Seconds by this PC's clock and by the gripper's.
    pub seconds: [f64; 2],
    /// Reports missing between those that came.
    pub missing: u64,
    /// Damaged frames, and messages that this program had no room for.
    pub damaged: u64,
    /// See `damaged`.
    pub unheard: u64,
    /// What the gripper counted meanwhile.
    pub counted: Counters,
    /// Bytes lost on the bus.
    pub lost_on_bus: u64,
    /// Estimates that could not be compared for want of time.
    pub left_out: [u64; 2],
    /// Estimates at angles at which a reference has no trustworthy solution of its own.
    pub unknown: [u64; 2],
    /// Newton iterations per tick.
    pub iterations: Cost,
    /// All ticks, and those in contact with a new angle.
    pub costs: [Cost; 2],
    /// Whether costs are instructions.
    pub instructions: bool,
    /// Mean time of a reference for a new angle, ms.
    pub reference_ms: [f64; 2],
    /// Greatest force, N.
    pub greatest_force: f64,
    /// Greatest distance of the front beam from the trapezoid reference's in the shape with the greatest force, mm, and
    /// the motor angle there, degrees.
    pub shape_off: Option<[f64; 2]>,
    /// Estimates in contact that were compared with trapezoid, and those of them that are not within what is allowed.
    pub compared: usize,
    /// See `compared`.
    pub off: usize,
    /// What is not as it should be; empty if all is well.
    pub faults: Vec<String>,
}

impl Summary {
    /// Of all that was seen.
    pub fn of(seen: &Seen) -> Self {
        let samples = &seen.samples;
        let differences = [0, 1]
            .map(|which| Way::BOTH.map(|way| Difference::of(samples.iter().filter(|sample| sample.way == way), which)));
        let mut statuses = BTreeMap::new();
        for sample in samples {
            *statuses.entry(sample.report.estimate.status.word()).or_default() += 1;
        }
        let fresh = || samples.iter().filter(|sample| sample.is_fresh());
        let each = seen.pace.instructions_per_tick(seen.version.cost_hz);
        let unit = each.unwrap_or(1e6 / f64::from(seen.version.cost_hz.max(1)));
        let cost = |sample: &Sample| f64::from(sample.report.cost) * unit;
        let moved = samples.windows(2).filter_map(|pair| {
            let new = pair[1].report.position != pair[0].report.position;
            (new && pair[1].is_fresh() && pair[1].magnitude() > 0.0).then_some(&pair[1])
        });
        let [before, after] = seen.link;
        let left_out = seen.left_out;
        let summary = Self {
            differences,
            statuses,
            cycles: seen.cycles,
            reports: samples.len(),
            estimates: fresh().count(),
            seconds: [seen.wall_s, samples.last().map_or(0.0, |last| last.time_s)],
            missing: after.missing_reports - before.missing_reports,
            damaged: after.damaged - before.damaged,
            unheard: after.unheard - before.unheard,
            counted: meanwhile(&seen.counters),
            lost_on_bus: seen.lost_on_bus,
            left_out,
            unknown: [0, 1].map(|which| {
                let none = fresh().filter(|sample| sample.references[which].is_none()).count() as u64;
                none.saturating_sub(left_out[which])
            }),
            iterations: Cost::of(fresh().map(|sample| f64::from(sample.report.estimate.iterations))),
            costs: [Cost::of(fresh().map(cost)), Cost::of(moved.map(cost))],
            instructions: each.is_some(),
            reference_ms: [0, 1].map(|which| {
                let followed = &seen.followed[which];
                followed.spent.as_secs_f64() * 1e3 / f64::from(followed.steps.max(1))
            }),
            greatest_force: fresh().map(Sample::magnitude).fold(0.0, f64::max),
            shape_off: shape_off(seen),
            compared: differences[0].iter().map(|difference| difference.count).sum(),
            off: samples
                .iter()
                .filter_map(|sample| sample.difference(0))
                .filter(|[_, percent]| *percent > ALLOWED_PERCENT)
                .count(),
            faults: Vec::new(),
        };
        let faults = summary.judge(samples);
        Self { faults, ..summary }
    }

    /// What is not as it should be.
    fn judge(&self, samples: &[Sample]) -> Vec<String> {
        let mut faults = Vec::new();
        let Self { compared, off, .. } = *self;
        if compared == 0 {
            faults.push("no estimate in contact could be compared with trapezoid 170/20".to_owned());
        }
        if self.cycles == 0 {
            faults.push("the finger has not closed and opened once".to_owned());
        }
        if off as f64 > EXCUSED * compared as f64 {
            faults.push(format!(
                "{off} of {compared} estimates are more than {ALLOWED_PERCENT} % ({} N) off trapezoid 170/20",
                ALLOWED_PERCENT / 100.0 * FLOOR_N
            ));
        }
        let untrustworthy = samples.iter().filter(|sample| sample.is_fresh() && !sample.is_trustworthy()).count();
        if untrustworthy as f64 > EXCUSED * self.estimates as f64 {
            faults.push(format!("{untrustworthy} of {} estimates are untrustworthy", self.estimates));
        }
        if 2 * self.estimates < self.reports {
            faults.push(format!("{} of {} reports are stale", self.reports - self.estimates, self.reports));
        }
        faults
    }

    /// Heads of the table of differences, with units.
    pub const COLUMNS: [[&'static str; 2]; 8] = [
        ["reference", "170/20"],
        ["direction", ""],
        ["estimates", "in contact"],
        ["rms", "N"],
        ["max", "N"],
        ["rms", "%"],
        ["max", "%"],
        ["max at", "°"],
    ];

    /// Rows of the table of differences.
    pub fn rows(&self) -> Vec<[String; 8]> {
        let mut rows = Vec::new();
        for (which, name) in REFERENCES.into_iter().enumerate() {
            for (way, difference) in Way::BOTH.into_iter().zip(&self.differences[which]) {
                let Difference { count, rms, max, max_at_deg } = difference;
                rows.push([
                    name.to_owned(),
                    way.word().to_owned(),
                    grouped(*count as u64),
                    format!("{:.4}", rms[0]),
                    format!("{:.4}", max[0]),
                    format!("{:.3}", rms[1]),
                    format!("{:.3}", max[1]),
                    format!("{max_at_deg:.2}"),
                ]);
            }
        }
        rows
    }

    /// What the numbers of the table are.
    pub fn note() -> String {
        format!(
            "Differences here are the lengths of the differences of the force vectors, in the lines and charts those of \
             the magnitudes. Percentages are of the reference's force, below {FLOOR_N} N of {FLOOR_N} N. The scheme paper is of first order: at 170/20 it is itself up \
             to 4 % off (physics paper) or 1 % (extended); trapezoid is what the target is judged by (at most {ALLOWED_PERCENT} %)."
        )
    }

    /// Everything else, a line each: what, and the words.
    pub fn facts(&self) -> Vec<(&'static str, String)> {
        let Counters { late_ticks, dropped_reports, dropped_shapes, dropped_events, .. } = self.counted;
        let Counters { bus_timeouts, bus_damaged, bus_refused, bus_other, servo_losses, .. } = self.counted;
        let n = |number: usize| grouped(number as u64);
        let mut facts = Vec::new();
        let rate = |count: usize, seconds: f64| count as f64 / seconds.max(1e-9);
        facts.push((
            "estimates",
            format!(
                "{} in {:.1} s: {:.0} per second by this PC's clock, {:.0} by the target's ({:.0} wanted)",
                n(self.estimates),
                self.seconds[0],
                rate(self.estimates, self.seconds[0]),
                rate(self.estimates, self.seconds[1]),
                self.counted.chosen_hz
            ),
        ));
        let share = 100.0 * self.seconds[1] / self.seconds[0].max(1e-9);
        facts.push(("target's time", format!("{:.1} s: QEMU ran at {share:.0} % of real time", self.seconds[1])));
        let trustworthy = |word: &str| {
            use Status::{Converged, NoContact, Snapped, Tracking};
            [Converged, NoContact, Snapped, Tracking].iter().any(|status| status.word() == word)
        };
        let list = |wanted: bool| {
            let some = self.statuses.iter().filter(|(word, _)| trustworthy(word) == wanted);
            let some: Vec<String> = some.map(|(word, count)| format!("{} {word}", n(*count))).collect();
            if some.is_empty() { "none".to_owned() } else { some.join(", ") }
        };
        facts.push(("trustworthy", list(true)));
        facts.push(("untrustworthy", list(false)));
        facts.push((
            "dropped",
            format!(
                "{} reports missing by their numbers; the target dropped {dropped_reports} reports, {dropped_shapes} \
                 shapes, {dropped_events} events; {} frames damaged, {} messages without room here",
                self.missing, self.damaged, self.unheard
            ),
        ));
        facts.push((
            "bus",
            format!(
                "{bus_timeouts} timeouts, {bus_damaged} damaged, {bus_refused} refused, {bus_other} other faults, \
                 {servo_losses} losses of the servo, {} bytes lost; {late_ticks} ticks late",
                self.lost_on_bus
            ),
        ));
        for (which, name) in REFERENCES.into_iter().enumerate() {
            if self.left_out[which] > 0 || self.unknown[which] > 0 {
                facts.push((
                    "not compared",
                    format!(
                        "{} with {name} because this PC did not keep up, {} because {name} itself has no trustworthy \
                         solution",
                        self.left_out[which], self.unknown[which]
                    ),
                ));
            }
        }
        let iterations = format!("mean {:.2}, max {:.0} per tick", self.iterations.mean, self.iterations.max);
        facts.push(("iterations", iterations));
        let [all, moved] = self.costs;
        if self.instructions {
            let words = |cost: Cost| {
                let [mean, max] = [cost.mean, cost.max].map(|count| grouped(count.round() as u64));
                format!("mean {mean}, max {max} instructions")
            };
            let [mean, max] = [moved.mean, moved.max].map(|count| 1e3 * count * CYCLES_PER_INSTRUCTION / CHIP_HZ);
            facts.push(("cost per tick", words(all)));
            facts.push(("  new angle", format!("{}, of {} such ticks in contact", words(moved), n(moved.count))));
            facts.push((
                "  on a chip",
                format!(
                    "new angle mean {mean:.1} ms, max {max:.1} ms at {:.0} MHz and {CYCLES_PER_INSTRUCTION} cycles per \
                     instruction (an assumption); the period is {:.1} ms",
                    CHIP_HZ / 1e6,
                    1e3 / self.counted.chosen_hz.max(1e-3)
                ),
            ));
        } else {
            let words = |cost: Cost| format!("mean {:.0}, max {:.0} µs", cost.mean, cost.max);
            facts.push(("cost per tick", format!("{} of this PC's time in QEMU: nothing about a chip", words(all))));
            facts.push(("  new angle", format!("{}, of {} such ticks in contact", words(moved), n(moved.count))));
        }
        let [trapezoid, paper] = self.reference_ms;
        facts
            .push(("references", format!("trapezoid {trapezoid:.2} ms, paper {paper:.2} ms per new angle on this PC")));
        if let Some([off, angle]) = self.shape_off {
            facts.push(("shape", format!("front beam within {off:.3} mm of trapezoid's at {angle:.2}°")));
        }
        facts
    }

    /// The last words: whether all is well.
    pub fn verdict(&self) -> String {
        if !self.faults.is_empty() {
            return format!("failed: {}", self.faults.join("; "));
        }
        format!(
            "passed: {} of {} estimates in contact are within {ALLOWED_PERCENT} % of trapezoid 170/20 ({} N below {FLOOR_N} N)",
            grouped((self.compared - self.off) as u64),
            grouped(self.compared as u64),
            ALLOWED_PERCENT / 100.0 * FLOOR_N
        )
    }

    /// Table, facts and verdict for a terminal.
    pub fn text(&self) -> String {
        let mut out = String::new();
        let cycles = match self.cycles {
            1 => "one closing and opening".to_owned(),
            more => format!("{more} closings and openings"),
        };
        let _ =
            writeln!(out, "Force on the target and of the full-resolution references at the same angle, {cycles}\n");
        let rows = self.rows();
        let width = |column: usize| {
            let heads = Self::COLUMNS[column].iter().map(|word| word.chars().count());
            rows.iter().map(|row| row[column].chars().count()).chain(heads).max().unwrap_or(0)
        };
        let mut line = |cells: [&str; 8]| {
            let mut text = String::new();
            for (column, cell) in cells.into_iter().enumerate() {
                let width = width(column);
                let _ = if column < 2 { write!(text, "{cell:<width$}   ") } else { write!(text, "{cell:>width$}   ") };
            }
            let _ = writeln!(out, "{}", text.trim_end());
        };
        for i in 0..2 {
            line(Self::COLUMNS.map(|head| head[i]));
        }
        for row in &rows {
            line(std::array::from_fn(|column| row[column].as_str()));
        }
        let _ = writeln!(out, "{}\n", wrapped(&Self::note(), 100));
        for (name, words) in self.facts() {
            let words = wrapped(&words, 84).replace('\n', "\n                ");
            let _ = writeln!(out, "{name:<15} {words}");
        }
        let _ = writeln!(out, "\n{}", self.verdict());
        out
    }
}

/// The text with line breaks at spaces.
fn wrapped(text: &str, width: usize) -> String {
    let mut out = String::new();
    let mut used = 0;
    for word in text.split(' ') {
        let length = word.chars().count();
        if used > 0 && used + 1 + length > width {
            out.push('\n');
            used = 0;
        } else if used > 0 {
            out.push(' ');
            used += 1;
        }
        out.push_str(word);
        used += length;
    }
    out
}

/// What was counted between two looks; levels as they were at the second.
fn meanwhile([before, after]: &[Counters; 2]) -> Counters {
    let d = |pick: fn(&Counters) -> u32| pick(after).wrapping_sub(pick(before));
    Counters {
        uptime_us: after.uptime_us.saturating_sub(before.uptime_us),
        ticks: d(|c| c.ticks),
        estimates: d(|c| c.estimates),
        late_ticks: d(|c| c.late_ticks),
        dropped_reports: d(|c| c.dropped_reports),
        dropped_shapes: d(|c| c.dropped_shapes),
        dropped_events: d(|c| c.dropped_events),
        bus_timeouts: d(|c| c.bus_timeouts),
        bus_damaged: d(|c| c.bus_damaged),
        bus_refused: d(|c| c.bus_refused),
        bus_other: d(|c| c.bus_other),
        bus_foreign: d(|c| c.bus_foreign),
        flash_writes: d(|c| c.flash_writes),
        servo_losses: d(|c| c.servo_losses),
        link_frames: d(|c| c.link_frames),
        link_damaged: d(|c| c.link_damaged),
        link_oversize: d(|c| c.link_oversize),
        late_answers: d(|c| c.late_answers),
        ..*after
    }
}

/// Greatest distance of the target's front beam from the trapezoid's in the shape with the greatest force, and the angle.
fn shape_off(seen: &Seen) -> Option<[f64; 2]> {
    let (shape, reference, angle) = seen.shape_beside_reference()?;
    let off = shape.front.iter().filter_map(|&point| distance(point, &reference.front)).fold(0.0, f64::max);
    Some([off, angle.to_degrees()])
}
