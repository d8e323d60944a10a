//! What a tick of the target costs at most while everything goes wrong that can, and the rates that follow.

use std::collections::BTreeMap;
use std::fmt;

use anyhow::{Context, Result};
use fre_boards::Board;
use fre_cycles::chip;
use fre_cycles::report::Cost;
use serde_json::{Value, json};

use crate::campaign::{self, Campaign, FRICTION, Measure, Pace, mean_and_most};

/// Samples per element: those of the campaigns at the wanted rate, and those of the slow one, which are the estimator's.
const SAMPLES: [u8; 3] = [2, 4, 5];
const SLOW_SAMPLES: u8 = 5;
/// The same with friction and two terms of memory, and the part of the wanted rate that is wanted then.
const RUBBING_SAMPLES: [u8; 2] = [2, 5];
const RUBBING_RATE: f64 = 0.6;
const BAUDS: [u32; 4] = [57_600, 1_000_000, 2_000_000, 4_000_000];
/// Part of a period that the link gets at least, where the bus takes as much.
const LINK_SHARE: f64 = 1.0 / gripper::LINK_SHARE as f64;
/// The bus of the wanted rate.
const WANTED_BAUD: u32 = 1_000_000;

/// Campaigns for each board.
#[derive(Clone, Debug)]
pub struct Rates(Vec<Campaigns>);

/// Campaigns on the firmware for QEMU made as a board's is.
#[derive(Clone, Debug)]
struct Campaigns {
    board: &'static Board,
    /// With time for everything.
    slow: Campaign,
    /// At the rate that is wanted of the board, with each number of samples, with friction and without.
    kept: Vec<Kept>,
}

/// A campaign at a wanted rate.
#[derive(Clone, Debug)]
struct Kept {
    samples: u8,
    rubs: bool,
    rate_hz: f64,
    campaign: Campaign,
}

impl Kept {
    /// Samples per element, as a table has them.
    fn case(&self) -> String {
        format!("{}{}", self.samples, if self.rubs { ", friction" } else { "" })
    }

    /// What an estimate of one finger may take, s.
    fn period_s(&self) -> f64 {
        1.0 / self.rate_hz - f64::min(bus_us(WANTED_BAUD, 1) * 1e-6, LINK_SHARE / self.rate_hz)
    }
}

/// Where the layout of the board's image is among a campaign's: for its first finger, and for the others.
fn image(campaign: &Campaign) -> [usize; 2] {
    let far = campaign.chips.iter().position(|chip| chip.layout == chip::FAR);
    [0, far.unwrap_or(0)]
}

/// Microseconds of the bus in a tick.
fn bus_us(baud: u32, fingers: usize) -> f64 {
    gripper::period_us(u16::MAX, baud, 0, fingers) as f64
}

/// Ticks per second: what the bus needs, or the estimates of all fingers meanwhile and the link, which gets what the bus takes or its share.
fn rate(estimates_us: f64, fingers: usize, baud: u32) -> f64 {
    let bus_us = bus_us(baud, fingers);
    let link_us = bus_us.min(estimates_us * LINK_SHARE / (1.0 - LINK_SHARE));
    1e6 / bus_us.max(estimates_us + link_us)
}

/// Runs the campaigns on the firmware in QEMU. `FRE_TWIN_IMAGES`, `FRE_CYCLES_PLUGIN` and `FRE_BOARD_IMAGES` name what is
/// needed.
pub fn measure() -> Result<Rates> {
    let mut names: Vec<&str> = chip::all().iter().map(|chip| chip.board).collect();
    names.dedup();
    let mut rates = Vec::new();
    for name in names {
        let board = fre_boards::named(name).with_context(|| format!("{name} is not in the list of boards"))?;
        let slow = campaign::run(name, SLOW_SAMPLES, &Pace::SLOW)?;
        let [chip, _] = image(&slow);
        // As fast as the processor is by the upper bound: then it is at least that fast.
        let cycles = slow.mean_cycles(chip)[1] / slow.instructions()[0];
        let wanted = f64::from(board.wanted_hz);
        let rubbing = RUBBING_SAMPLES.iter().filter(|_| board.has_friction).map(|&samples| (samples, true));
        let cases = SAMPLES.iter().map(|&samples| (samples, false)).chain(rubbing);
        let kept = cases.map(|(samples, rubs)| {
            let rate_hz = if rubs { RUBBING_RATE * wanted } else { wanted };
            let pace = Pace::kept(rate_hz, f64::from(board.clock_hz), cycles, rubs);
            Ok(Kept { samples, rubs, rate_hz, campaign: campaign::run(name, samples, &pace)? })
        });
        rates.push(Campaigns { board, slow, kept: kept.collect::<Result<_>>()? });
    }
    Ok(Rates(rates))
}

impl Campaigns {
    /// Microseconds of one estimate of each finger, by the cycles of the first one's and of another's.
    fn estimates_us(&self, fingers: usize, [first, far]: [f64; 2]) -> f64 {
        (first + (fingers - 1) as f64 * far) / f64::from(self.board.clock_hz) * 1e6
    }

    /// Rows of the cycles in each layout.
    fn cycles(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, chip) in self.slow.chips.iter().enumerate() {
            let [mean, most] = [self.slow.mean_cycles(index), self.slow.most_cycles(index)]
                .map(|bounds| bounds.map(grouped).join(" to "));
            writeln!(f, "| {} | {} | {mean} | {most} |", chip.board, chip.layout)?;
        }
        Ok(())
    }

    /// Rows of the campaigns at the wanted rate.
    fn kept(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for kept in &self.kept {
            let (campaign, case) = (&kept.campaign, kept.case());
            let [first, _] = image(campaign);
            let [mean, most] = campaign.instructions().map(grouped);
            let cycles = campaign.most_cycles(first).map(grouped).join(" to ");
            let [low, high] = campaign.longer_than(first, kept.period_s());
            let (name, hz) = (self.board.name, kept.rate_hz);
            let (seen, cut) = (campaign.estimates.len(), campaign.cut());
            writeln!(f, "| {name} | {hz} | {case} | {seen} | {mean} | {most} | {cycles} | {low} to {high} | {cut} |")?;
        }
        Ok(())
    }

    /// Rows of the rates that the board keeps.
    fn rates(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for fingers in 1..=self.board.fingers {
            for kept in &self.kept {
                let campaign = &kept.campaign;
                let chips = image(campaign);
                let most = |bound: usize| chips.map(|chip| campaign.most_cycles(chip)[bound]);
                let [low, high] = [0, 1].map(|bound| self.estimates_us(fingers, most(bound)));
                let mean = self.estimates_us(fingers, chips.map(|chip| campaign.mean_cycles(chip)[1]));
                let rates = BAUDS.map(|baud| {
                    let [high, low, mean] = [high, low, mean].map(|us| rate(us, fingers, baud).floor());
                    format!("{high} to {low} ({mean})")
                });
                writeln!(f, "| {} | {fingers} | {} | {} |", self.board.name, kept.case(), rates.join(" | "))?;
            }
        }
        Ok(())
    }

    /// Kinds of the slow campaign's ticks on the board's chip, and where the time goes.
    fn kinds(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, _] = image(&self.slow);
        let mut kinds: BTreeMap<(bool, u16), Vec<&Measure>> = BTreeMap::new();
        for it in &self.slow.estimates {
            kinds.entry(it.0.kind()).or_default().push(it);
        }
        for ((touching, iterations), ticks) in &kinds {
            let [instructions, _] = mean_and_most(ticks.iter().map(|(estimate, _)| estimate.instructions));
            let mean = |bound: usize| {
                mean_and_most(ticks.iter().filter_map(|(_, cycles)| Some(cycles.get(first)?[bound] as f64)))[0]
            };
            let contact = if *touching { "yes" } else { "no" };
            let cycles = [mean(0), mean(1)].map(grouped).join(" to ");
            let (name, count, instructions) = (self.board.name, ticks.len(), grouped(instructions));
            writeln!(f, "| {name} | {contact} | {iterations} | {count} | {instructions} | {cycles} |")?;
        }
        Ok(())
    }

    /// The slow campaign's costliest functions and addresses on the board's chip.
    fn costliest(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, _] = image(&self.slow);
        let Some(chip) = self.slow.chips.get(first) else { return Ok(()) };
        let known = 100.0 * self.slow.by_name.get(first).copied().unwrap_or(0.0);
        for (what, costs) in [("functions", &chip.functions), ("addresses", &chip.addresses)] {
            let name = self.board.name;
            writeln!(
                f,
                "\nAn estimate's costliest {what} on {name}, by the upper bound ({known:.0} % known by name):\n"
            )?;
            for Cost { share, name, .. } in costs.iter().filter(|cost| self.slow.between == Some(cost.between)) {
                writeln!(f, "- {:.1} %: `{name}`", 100.0 * share)?;
            }
        }
        Ok(())
    }
}

impl Rates {
    /// Rows of the document's `worst_tick`: the most expensive estimate of each campaign on each board, in each layout.
    ///
    /// - `campaign`: `kept`, at the rate that is wanted of the board, or `slow`, with time for every iteration.
    /// - `friction`: the object's coefficient; with one the finger relaxes as well.
    /// - `late_ticks`: by the upper bound, the estimates that take longer than one finger has time for at `rate_hz` and 1 Mbaud.
    /// - `max_iterations`: the estimates that a tick was too short for.
    /// - `bounds_hz`: the rates at which the most expensive estimate fits, by the upper and by the lower bound.
    pub fn document(&self) -> Value {
        let Self(rates) = self;
        let mut rows = Vec::new();
        for campaigns in rates {
            let slow = Kept {
                samples: SLOW_SAMPLES,
                rubs: false,
                rate_hz: f64::from(campaigns.board.wanted_hz),
                campaign: campaigns.slow.clone(),
            };
            let kept = campaigns.kept.iter().map(|kept| ("kept", kept));
            for (kind, kept) in kept.chain([("slow", &slow)]) {
                let campaign = &kept.campaign;
                let [mean, max] = campaign.instructions();
                for (index, chip) in campaign.chips.iter().enumerate() {
                    let [low, high] = campaign.most_cycles(index);
                    let bounds = [high, low].map(|cycles| rate(cycles / chip.clock_hz * 1e6, 1, WANTED_BAUD).floor());
                    rows.push(json!({
                        "board": chip.board,
                        "layout": chip.layout,
                        "campaign": kind,
                        "fingers": 1,
                        "samples": kept.samples,
                        "friction": if kept.rubs { FRICTION } else { 0.0 },
                        "instructions": { "mean": mean.round(), "max": max },
                        "cycles": { "low": low, "high": high },
                        "late_ticks": campaign.longer_than(index, kept.period_s())[1],
                        "max_iterations": campaign.cut(),
                        "rate_hz": kept.rate_hz,
                        "bounds_hz": bounds,
                    }));
                }
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
        writeln!(f, "At the wanted rate of one finger; cycles by the lower and by the upper bound:\n")?;
        writeln!(
            f,
            "| board | Hz | samples | estimates | in contact, mean | worst, instructions | worst, cycles | late | `max-iterations` |"
        )?;
        writeln!(f, "|---|---|---|---|---|---|---|---|---|")?;
        rates.iter().try_for_each(|campaigns| campaigns.kept(f))?;
        writeln!(
            f,
            "\nRates that are kept with these, by the upper and by the lower bound (upper bound of the mean):\n"
        )?;
        writeln!(f, "| board | fingers | samples | 57,600 baud | 1 Mbaud | 2 Mbaud | 4 Mbaud |")?;
        writeln!(f, "|---|---|---|---|---|---|---|")?;
        rates.iter().try_for_each(|campaigns| campaigns.rates(f))?;
        writeln!(f, "\nWith time for every iteration, {SLOW_SAMPLES} samples:\n")?;
        writeln!(f, "| made as for | estimates | in contact, mean | worst, instructions | iterations at most |")?;
        writeln!(f, "|---|---|---|---|---|")?;
        for Campaigns { board, slow, .. } in rates {
            let [mean, most] = slow.instructions().map(grouped);
            writeln!(f, "| {} | {} | {mean} | {most} | {} |", board.name, slow.seen, slow.iterations())?;
        }
        writeln!(f, "\nCycles of an estimate:\n")?;
        writeln!(f, "| board | layout | in contact, mean | worst |\n|---|---|---|---|")?;
        rates.iter().try_for_each(|campaigns| campaigns.cycles(f))?;
        writeln!(f, "\nBy kind of tick, means:\n")?;
        writeln!(f, "| board | contact | iterations | ticks | instructions | cycles |")?;
        writeln!(f, "|---|---|---|---|---|---|")?;
        rates.iter().try_for_each(|campaigns| campaigns.kinds(f))?;
        rates.iter().try_for_each(|campaigns| campaigns.costliest(f))
    }
}

/// Figures such as campaigns have.
#[cfg(test)]
pub fn example() -> Rates {
    let campaign = || campaign::example(400, 380, 1e6, 6);
    let kept = |rubs| Kept { samples: 5, rubs, rate_hz: 500.0, campaign: campaign() };
    Rates(vec![Campaigns { board: &fre_boards::OPENCR, slow: campaign(), kept: vec![kept(false), kept(true)] }])
}

#[cfg(test)]
mod tests {
    use super::*;
    use fre_cycles::report::Measured;

    #[test]
    fn the_bus_or_the_estimates_make_the_period() {
        let bus_us = |baud| gripper::period_us(u16::MAX, baud, 0, 2) as f64;
        // 1 ms each, with a sixteenth of the period left to the link.
        let estimates_make_it = rate(2_000.0, 2, 1_000_000);
        assert!((estimates_make_it - 500.0 * 15.0 / 16.0).abs() < 1e-9, "{estimates_make_it}");
        // Ten times as long: what the bus takes is less than that.
        let long = rate(20_000.0, 2, 1_000_000);
        assert!((long - 1e6 / (20_000.0 + bus_us(1_000_000))).abs() < 1e-9, "{long}");
        let the_bus_does = rate(2_000.0, 2, 57_600);
        assert!((the_bus_does - 1e6 / bus_us(57_600)).abs() < 1e-9, "{the_bus_does}");
    }

    #[test]
    fn other_fingers_cost_what_they_cost_where_their_models_lie() {
        let Rates(rates) = example();
        let mut campaign = rates[0].slow.clone();
        assert_eq!(image(&campaign), [0, 0], "one memory for all");
        let far = Measured { layout: chip::FAR.to_owned(), ..campaign.chips[0].clone() };
        campaign.chips.extend([Measured { layout: "another".to_owned(), ..far.clone() }, far]);
        assert_eq!(image(&campaign), [0, 2]);
        let us = rates[0].estimates_us(3, [216e3, 432e3]);
        assert!((us - 5_000.0).abs() < 1e-9, "{us}");
    }

    #[test]
    fn digits_are_grouped() {
        assert_eq!(grouped(1_234_567.0), "1,234,567");
    }
}
