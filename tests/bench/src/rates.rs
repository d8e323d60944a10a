//! What a tick of the target costs at most while everything goes wrong that can, in instructions and in cycles of the real chips, and the
//! rates that follow.

use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use fre_boards::Board;
use fre_cycles::chip;
use fre_cycles::report::{Cost, Measured, Window};
use fre_gripper::servo::{Config, Fault};
use messages::{Finger, GripTo, Mount, Report, Settings, Which};
use model_core::discretise::{Discretisation, Sampling};
use model_core::object::ObjectDesign;
use model_core::status::Status;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use serde_json::{Value, json};
use system_tests::{Cycles, Machine, OBJECT, Watch, finger};

const DEGREE: f32 = std::f32::consts::PI / 180.0;
const MOUNT: Mount =
    Mount { open_angle: -DEGREE, range: [-0.05, 0.3], force_limit: 100.0, current_limit: 2000.0, ..Mount::DEFAULT };
/// The other object, which is set and taken away while the finger is on it: the model begins anew.
const OTHER: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 56.0], radius: 40.0 };
/// Rounds of closing, gripping and opening.
const ROUNDS: u32 = 3;
/// Estimates of a round.
const ESTIMATES: u32 = 260;
/// Newton iterations of a tick at most.
const ITERATIONS: u16 = 8;
const BAUDS: [u32; 4] = [57_600, 1_000_000, 2_000_000, 4_000_000];
/// Part of a period that the link gets at least, where the bus takes as much.
const LINK_SHARE: f64 = 1.0 / gripper::LINK_SHARE as f64;
/// The bus of the wanted rate.
const WANTED_BAUD: u32 = 1_000_000;
/// Part of the estimates whose window must be found: a report may be lost where the link is busy.
const FOUND: f64 = 0.95;
/// Part of the instructions whose address in a board's image must be known by name: the others are followed anywhere.
const KNOWN: f64 = 0.9;
const PATIENCE: Duration = Duration::from_secs(600);

/// Campaigns for each board.
#[derive(Clone, Debug)]
pub struct Rates(Vec<Campaigns>);

/// A campaign with each number of samples, on the firmware for QEMU made as a board's is.
#[derive(Clone, Debug)]
struct Campaigns {
    board: String,
    by_samples: Vec<(u8, Campaign)>,
}

/// An estimate.
#[derive(Clone, Copy, Debug)]
struct Estimate {
    instructions: f64,
    iterations: u16,
    touching: bool,
}

/// An estimate with its cycles on each chip, by the lower and by the upper bound.
type Measure = (Estimate, Vec<[u64; 2]>);

/// What a campaign has cost.
#[derive(Clone, Debug)]
struct Campaign {
    estimates: Vec<Measure>,
    /// Estimates, those of which no window was found included.
    seen: usize,
    chips: Vec<Measured>,
    /// Addresses of the reads of the clock that an estimate lies between.
    between: Option<[u32; 2]>,
    /// For each chip, the share of the estimates' instructions whose address in its image is known by name.
    by_name: Vec<f64>,
}

/// Mean and largest.
fn mean_and_most(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let count = values.clone().count().max(1) as f64;
    [values.clone().sum::<f64>() / count, values.fold(0.0, f64::max)]
}

impl Estimate {
    fn of(report: &Report) -> Option<Self> {
        // A report without an answer of the servo has no estimate.
        if report.estimate.status == Status::Stale {
            return None;
        }
        Some(Self {
            instructions: f64::from(report.cost) * f64::from(Machine::INSTRUCTIONS_PER_TICK),
            iterations: report.estimate.iterations,
            touching: report.estimate.force != [0.0; 2] && report.estimate.age == 0,
        })
    }

    fn kind(self) -> (bool, u16) {
        (self.touching, self.iterations)
    }
}

impl Campaign {
    /// Mean in contact, and the largest of all.
    fn instructions(&self) -> [f64; 2] {
        let [mean, _] = mean_and_most(self.touching().map(|(estimate, _)| estimate.instructions));
        [mean, mean_and_most(self.estimates.iter().map(|(estimate, _)| estimate.instructions))[1]]
    }

    fn touching(&self) -> impl Iterator<Item = &Measure> + Clone {
        self.estimates.iter().filter(|(estimate, _)| estimate.touching)
    }

    /// The largest number of cycles of an estimate on a chip, by the lower and by the upper bound.
    fn most_cycles(&self, chip: usize) -> [f64; 2] {
        [0, 1].map(|bound| {
            let cycles = self.estimates.iter().filter_map(|(_, cycles)| Some(cycles.get(chip)?[bound] as f64));
            cycles.fold(0.0, f64::max)
        })
    }

    /// The same on average in contact.
    fn mean_cycles(&self, chip: usize) -> [f64; 2] {
        [0, 1].map(|bound| {
            mean_and_most(self.touching().filter_map(|(_, cycles)| Some(cycles.get(chip)?[bound] as f64)))[0]
        })
    }

    /// Estimates that would be late on a chip at a rate, by the upper bound.
    fn late(&self, chip: usize, clock_hz: f64, rate_hz: f64) -> usize {
        let left = 1.0 / rate_hz - f64::min(bus_us(WANTED_BAUD, 1) * 1e-6, LINK_SHARE / rate_hz);
        let cycles = self.estimates.iter().filter_map(|(_, cycles)| Some(cycles.get(chip)?[1] as f64));
        cycles.filter(|cycles| cycles / clock_hz > left).count()
    }

    /// That the campaign has seen what it is for.
    fn check(&self) -> Result<()> {
        let [mean, most] = self.instructions();
        let contacts = self.touching().count();
        if contacts <= self.seen / 4 || (self.seen as u32) < ROUNDS * ESTIMATES || most <= mean {
            bail!(
                "the campaign was not what it should be: {contacts} of {} in contact, mean {mean}, {most}",
                self.seen
            );
        }
        if let Some(known) = self.by_name.iter().find(|known| **known < KNOWN) {
            bail!("{:.0} % only of the instructions are known by name in the board's image", 100.0 * known);
        }
        if (self.estimates.len() as f64) < FOUND * self.seen as f64 {
            bail!("the cycles of {} of {} estimates only were found", self.estimates.len(), self.seen);
        }
        match self.estimates.iter().map(|(estimate, _)| estimate.iterations).max() {
            Some(iterations) if iterations > ITERATIONS => {
                bail!("a tick did {iterations} iterations; allowed are {ITERATIONS}")
            }
            _ => Ok(()),
        }
    }
}

/// Microseconds of the bus in a tick.
fn bus_us(baud: u32, fingers: usize) -> f64 {
    gripper::period_us(u16::MAX, baud, 0, fingers) as f64
}

/// Ticks per second: what the bus needs, or the estimates of all fingers meanwhile and the link, which gets what the bus takes or its share.
fn rate(cycles: f64, clock_hz: f64, fingers: usize, baud: u32) -> f64 {
    let (bus_us, estimates_us) = (bus_us(baud, fingers), fingers as f64 * cycles / clock_hz * 1e6);
    let link_us = bus_us.min(estimates_us * LINK_SHARE / (1.0 - LINK_SHARE));
    1e6 / bus_us.max(estimates_us + link_us)
}

/// Runs the campaigns on the firmware in QEMU. `FRE_TWIN_IMAGES`, `FRE_CYCLES_PLUGIN` and `FRE_BOARD_IMAGES` name what is
/// needed.
pub fn measure() -> Result<Rates> {
    let mut rates = Vec::new();
    let mut boards: Vec<&str> = chip::all().iter().map(|chip| chip.board).collect();
    boards.dedup();
    for board in boards {
        let mut by_samples = Vec::new();
        for samples in [2, 4, 5] {
            let campaign = campaign(board, samples)?;
            campaign.check().with_context(|| format!("{board}, {samples} samples"))?;
            by_samples.push((samples, campaign));
        }
        rates.push(Campaigns { board: board.to_owned(), by_samples });
    }
    Ok(Rates(rates))
}

/// Fast and slow motions, grips, another object under way; every twentieth answer is lost, damaged, cut, or comes behind noise.
fn campaign(board: &str, samples: u8) -> Result<Campaign> {
    let cycles = Cycles::twin(board);
    let machine = Machine::boot_measured(Config { noise_ma: 5.0, ..Machine::servo() }, &cycles);
    let link = machine.link();
    let mut watch = Watch::new(&link);
    // Slow, so that no tick is cut short for want of time.
    link.set_settings(&Settings { rate_hz: 50, shape_every: 0, ..Settings::of(MOUNT) })?;
    let Finger { design, how, .. } = finger();
    let how = Discretisation { sampling: Sampling::PerElement(samples), ..how };
    link.set_finger(0, &Finger::elastic(design, how))?;
    link.set_object(0, OBJECT)?;
    watch.until_report("trustworthy estimate", PATIENCE, |report| report.estimate.age == 0);
    let mut random = ChaCha8Rng::seed_from_u64(u64::from(samples));
    let mut estimates: Vec<Estimate> = Vec::new();
    let mut pass = |watch: &mut Watch, count: usize| {
        let end = estimates.len() + count;
        watch.until_report("estimates", PATIENCE, |report| {
            estimates.extend(Estimate::of(report));
            if random.next_u32().is_multiple_of(20) {
                machine.servo.inject([fault(&mut random)]);
            }
            estimates.len() >= end
        });
        watch.reports.clear();
    };
    for round in 0..ROUNDS {
        let speed = [0.05, 0.35, 1.0][(round % 3) as usize];
        let all = Which::All;
        // A servo that was lost refuses; it is found again.
        let _ = link.close(all, 11.0 * DEGREE, Some(speed));
        pass(&mut watch, 100);
        link.set_object(0, OTHER)?;
        pass(&mut watch, 30);
        link.set_object(0, OBJECT)?;
        pass(&mut watch, 30);
        let _ = link.grip(&GripTo { fingers: all, force: 5.0, speed: Some(speed), limit: None });
        pass(&mut watch, 60);
        let _ = link.open_fingers(all);
        pass(&mut watch, 40);
    }
    drop((watch, link));
    drop(machine);
    let report = cycles.report().context("the cycles' report")?;
    if !report.unknown.is_empty() {
        bail!("instructions that were not understood: {}", report.unknown.join(", "));
    }
    let costs: Vec<f64> = estimates.iter().map(|estimate| estimate.instructions).collect();
    let windows = report.measured_as(&costs, f64::from(Machine::INSTRUCTIONS_PER_TICK));
    let seen = estimates.len();
    let by_name = (0..report.chips.len()).map(|chip| share_by_name(&windows, chip)).collect();
    let between = windows.iter().flatten().next().map(|window| window.between);
    let found = |(estimate, window): (Estimate, Option<&Window>)| Some((estimate, window?.cycles.clone()));
    let estimates = estimates.into_iter().zip(windows).filter_map(found).collect();
    Ok(Campaign { estimates, seen, chips: report.chips, between, by_name })
}

/// The share of the windows' instructions whose address in a chip's image is known by name.
fn share_by_name(windows: &[Option<&Window>], chip: usize) -> f64 {
    let windows = || windows.iter().flatten();
    let named: u64 = windows().filter_map(|window| window.by_name.get(chip)).sum();
    let all: u64 = windows().map(|window| window.instructions).sum();
    named as f64 / all.max(1) as f64
}

/// What happens to an answer of the servo.
fn fault(random: &mut ChaCha8Rng) -> Fault {
    match random.next_u32() % 4 {
        0 => Fault::Drop,
        1 => Fault::Corrupt { index: (random.next_u32() % 20) as usize, mask: 1 << (random.next_u32() % 8) },
        2 => Fault::Truncate { bytes: (random.next_u32() % 20) as usize },
        _ => Fault::Noise(vec![random.next_u32() as u8; 20]),
    }
}

impl Rates {
    /// Rows of the document's `worst_tick`: the dearest estimate of each campaign on each board. `late_ticks` are the estimates that
    /// would be late at the wanted `rate_hz` of one finger at 1 Mbaud by the upper bound, `bounds_hz` what the dearest one allows.
    pub fn document(&self) -> Value {
        let Self(rates) = self;
        let mut rows = Vec::new();
        for (samples, campaign) in rates.iter().flat_map(|campaigns| &campaigns.by_samples) {
            let [mean, max] = campaign.instructions();
            for (index, chip) in campaign.chips.iter().enumerate() {
                let Some(board) = fre_boards::named(&chip.board) else { continue };
                let wanted = f64::from(board.wanted_hz);
                let [low, high] = campaign.most_cycles(index);
                let bounds = [high, low].map(|cycles| rate(cycles, chip.clock_hz, 1, WANTED_BAUD).floor());
                rows.push(json!({
                    "board": board.name,
                    "layout": chip.layout,
                    "fingers": 1,
                    "samples": samples,
                    "instructions": { "mean": mean.round(), "max": max },
                    "cycles": { "low": low, "high": high },
                    "late_ticks": campaign.late(index, chip.clock_hz, wanted),
                    "rate_hz": wanted,
                    "bounds_hz": bounds,
                }));
            }
        }
        rows.into()
    }
}

/// 1,234,567.
fn grouped(number: f64) -> String {
    let digits = format!("{number:.0}");
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

impl fmt::Display for Rates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(rates) = self;
        writeln!(
            f,
            "| made as for | samples | estimates | in contact, mean | worst, instructions | iterations at most |"
        )?;
        writeln!(f, "|---|---|---|---|---|---|")?;
        for Campaigns { board, by_samples } in rates {
            for (samples, campaign) in by_samples {
                let [mean, most] = campaign.instructions().map(grouped);
                let iterations = campaign.estimates.iter().map(|(estimate, _)| estimate.iterations).max().unwrap_or(0);
                writeln!(f, "| {board} | {samples} | {} | {mean} | {most} | {iterations} |", campaign.seen)?;
            }
        }
        writeln!(f, "\nCycles of an estimate, by the lower and by the upper bound:\n")?;
        writeln!(f, "| board | layout | samples | in contact, mean | worst |\n|---|---|---|---|---|")?;
        rates.iter().try_for_each(|campaigns| campaigns.cycles(f))?;
        for campaigns in rates {
            if let Some((samples, campaign)) = campaigns.by_samples.last() {
                kinds(f, *samples, campaign)?;
            }
        }
        writeln!(f, "\n| board | fingers | samples | 57,600 baud | 1 Mbaud | 2 Mbaud | 4 Mbaud |")?;
        writeln!(f, "|---|---|---|---|---|---|---|")?;
        for board in fre_boards::ALL {
            rates.iter().try_for_each(|campaigns| campaigns.rates(f, board))?;
        }
        Ok(())
    }
}

impl Campaigns {
    fn chips(&self) -> &[Measured] {
        self.by_samples.first().map_or(&[], |(_, campaign)| &campaign.chips)
    }

    /// Rows of each chip's cycles.
    fn cycles(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, chip) in self.chips().iter().enumerate() {
            for (samples, campaign) in &self.by_samples {
                let [mean, most] = [campaign.mean_cycles(index), campaign.most_cycles(index)]
                    .map(|bounds| bounds.map(grouped).join(" to "));
                writeln!(f, "| {} | {} | {samples} | {mean} | {most} |", chip.board, chip.layout)?;
            }
        }
        Ok(())
    }

    /// Rows of the rates that a board reaches, if this is the image that it has.
    fn rates(&self, f: &mut fmt::Formatter<'_>, board: &Board) -> fmt::Result {
        // The first layout of a board is the one that its image has.
        let Some(index) = self.chips().iter().position(|chip| chip.board == board.name) else { return Ok(()) };
        for fingers in 1..=board.fingers {
            for (samples, campaign) in &self.by_samples {
                let clock = campaign.chips.get(index).map_or(1.0, |chip| chip.clock_hz);
                let [low, high] = campaign.most_cycles(index);
                let [_, mean] = campaign.mean_cycles(index);
                let rates = BAUDS.map(|baud| {
                    let [high, low, mean] = [high, low, mean].map(|cycles| rate(cycles, clock, fingers, baud).floor());
                    format!("{high} to {low} ({mean})")
                });
                writeln!(f, "| {} | {fingers} | {samples} | {} |", board.name, rates.join(" | "))?;
            }
        }
        Ok(())
    }
}

/// Kinds of ticks on the first chip of every board, and where the time goes.
fn kinds(f: &mut fmt::Formatter<'_>, samples: u8, campaign: &Campaign) -> fmt::Result {
    let mut kinds: BTreeMap<(bool, u16), Vec<&Measure>> = BTreeMap::new();
    for it in &campaign.estimates {
        kinds.entry(it.0.kind()).or_default().push(it);
    }
    let mut boards: Vec<(usize, &str)> = Vec::new();
    for (index, chip) in campaign.chips.iter().enumerate() {
        if boards.iter().all(|(_, board)| *board != chip.board) {
            boards.push((index, &chip.board));
        }
    }
    writeln!(f, "\nBy kind of tick, {samples} samples, means:\n")?;
    let names: Vec<&str> = boards.iter().map(|(_, board)| *board).collect();
    writeln!(f, "| contact | iterations | ticks | instructions | {} |", names.join(" | "))?;
    writeln!(f, "|---|---|---|---|{}", "---|".repeat(names.len()))?;
    for ((touching, iterations), ticks) in &kinds {
        let [instructions, _] = mean_and_most(ticks.iter().map(|(estimate, _)| estimate.instructions));
        let of = |index: usize| {
            let mean = |bound: usize| {
                mean_and_most(ticks.iter().filter_map(|(_, cycles)| Some(cycles.get(index)?[bound] as f64)))[0]
            };
            format!("{} to {}", grouped(mean(0)), grouped(mean(1)))
        };
        let cycles: Vec<String> = boards.iter().map(|(index, _)| of(*index)).collect();
        let contact = if *touching { "yes" } else { "no" };
        let instructions = grouped(instructions);
        writeln!(f, "| {contact} | {iterations} | {} | {instructions} | {} |", ticks.len(), cycles.join(" | "))?;
    }
    for (index, board) in boards {
        let Some(chip) = campaign.chips.get(index) else { continue };
        let known = 100.0 * campaign.by_name.get(index).copied().unwrap_or(0.0);
        for (what, costs) in [("functions", &chip.functions), ("addresses", &chip.addresses)] {
            writeln!(
                f,
                "\nAn estimate's costliest {what} on {board}, by the upper bound ({known:.0} % known by name):\n"
            )?;
            for Cost { share, name, .. } in costs.iter().filter(|cost| campaign.between == Some(cost.between)) {
                writeln!(f, "- {:.1} %: `{name}`", 100.0 * share)?;
            }
        }
    }
    Ok(())
}

/// Figures such as a campaign has.
#[cfg(test)]
pub fn example() -> Rates {
    let by_samples = vec![(5, tests::campaign(400, 380, 1e6, 6))];
    Rates(vec![Campaigns { board: "opencr".to_owned(), by_samples }])
}

#[cfg(test)]
mod tests {
    use super::*;

    pub fn campaign(contacts: usize, others: usize, most: f64, iterations: u16) -> Campaign {
        let estimate = |touching, instructions| Estimate { instructions, iterations, touching };
        let cycles = |instructions: f64| vec![[instructions as u64, 2 * instructions as u64]];
        let mut estimates: Vec<_> = (0..contacts).map(|_| (estimate(true, 1e5), cycles(1e5))).collect();
        estimates.extend((0..others).map(|_| (estimate(false, most), cycles(most))));
        let (board, layout) = ("opencr".to_owned(), "flash over AXI, caches".to_owned());
        let chip = Measured { board, layout, clock_hz: 216e6, addresses: vec![], functions: vec![] };
        Campaign { seen: estimates.len(), estimates, chips: vec![chip], between: None, by_name: vec![1.0] }
    }

    #[test]
    fn a_campaign_that_saw_too_little_is_an_error() {
        assert!(campaign(400, 380, 1e6, 6).check().is_ok());
        assert!(campaign(100, 680, 1e6, 6).check().is_err());
        assert!(campaign(90, 10, 1e6, 6).check().is_err());
        assert!(campaign(400, 380, 1e6, 9).check().is_err());
        assert!(Campaign { seen: 1000, ..campaign(400, 380, 1e6, 6) }.check().is_err(), "windows are missing");
        assert!(Campaign { by_name: vec![0.3], ..campaign(400, 380, 1e6, 6) }.check().is_err(), "another image");
    }

    #[test]
    fn the_bus_or_the_estimates_make_the_period() {
        let bus_us = |baud| gripper::period_us(u16::MAX, baud, 0, 2) as f64;
        // 216,000 cycles at 216 MHz: 1 ms each, with a sixteenth of the period left to the link.
        let estimates_make_it = rate(216_000.0, 216e6, 2, 1_000_000);
        assert!((estimates_make_it - 500.0 * 15.0 / 16.0).abs() < 1e-9, "{estimates_make_it}");
        // Ten times as long: what the bus takes is less than that.
        let long = rate(2_160_000.0, 216e6, 2, 1_000_000);
        assert!((long - 1e6 / (20_000.0 + bus_us(1_000_000))).abs() < 1e-9, "{long}");
        let the_bus_does = rate(216_000.0, 216e6, 2, 57_600);
        assert!((the_bus_does - 1e6 / bus_us(57_600)).abs() < 1e-9, "{the_bus_does}");
    }

    #[test]
    fn what_is_late_is_counted_by_the_upper_bound() {
        let campaign = campaign(10, 5, 1e6, 6);
        assert_eq!((campaign.most_cycles(0), campaign.mean_cycles(0)), ([1e6, 2e6], [1e5, 2e5]));
        // At 1 GHz 2 ms and 0.2 ms; the link takes its part of 2 ms.
        assert_eq!(campaign.late(0, 1e9, 500.0), 5);
        assert_eq!(campaign.late(0, 1e9, 100.0), 0);
        assert_eq!(grouped(1_234_567.0), "1,234,567");
    }
}
