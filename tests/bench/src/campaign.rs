//! Campaigns of the gripper in QEMU in which everything goes wrong that can, and what their estimates cost: instructions, and cycles of the
//! real chips.

use std::time::Duration;

use anyhow::{Context, Result, bail};
use fre_cycles::report::{Measured, Window};
use fre_gripper::servo::{Clock, Config, Fault};
use messages::{Finger, GripTo, Mount, Object, Report, Settings, Which};
use model_core::discretise::{Discretisation, Sampling};
use model_core::object::ObjectDesign;
use model_core::status::Status;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use system_tests::{Cycles, Machine, OBJECT, Watch, finger};

const DEGREE: f32 = std::f32::consts::PI / 180.0;
const MOUNT: Mount =
    Mount { open_angle: -DEGREE, range: [-0.05, 0.3], force_limit: 100.0, current_limit: 2000.0, ..Mount::DEFAULT };
/// The other object, which is set and taken away while the finger is on it: the model begins anew.
const OTHER: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 56.0], radius: 40.0 };
/// Newton iterations of a tick at most.
const ITERATIONS: u16 = 8;
/// Part of the estimates whose window must be found: a report may be lost where the link is busy.
const FOUND: f64 = 0.95;
/// Part of the instructions whose address in a board's image must be known by name: the others are followed anywhere.
const KNOWN: f64 = 0.9;
const PATIENCE: Duration = Duration::from_secs(600);

/// A closing: its speed, rad/s, and the estimates while the finger closes, gets another object, gets the first one again, grips, and opens.
type Round = (f32, [usize; 5]);

/// How fast the gripper's processor seems to be, and what it goes through.
#[derive(Clone, Debug)]
pub struct Pace {
    /// An instruction takes 2^`shift` ns.
    shift: u8,
    /// Ticks per second of its clock.
    rate_hz: u16,
    /// What passes for the servo from tick to tick, µs.
    servo_us: u32,
    rounds: &'static [Round],
    /// One of so many answers is spoiled. (Reports come in bursts while ticks are short, and so would faults: too many in a row lose the
    /// servo, and then there is nothing to be measured.)
    spoiled: u32,
    /// Whether layouts are measured that no image has.
    all_layouts: bool,
    /// The object rubs, and the finger relaxes.
    rubs: bool,
}

/// Coefficient of friction of an object that rubs, and terms of a finger that relaxes.
pub const FRICTION: f64 = 0.6;
const PRONY: &[[f64; 2]] = &[[0.15, 0.5], [0.1, 20.0]];

impl Pace {
    /// So slow that no tick is cut short for want of time.
    pub const SLOW: Self = Self {
        shift: Machine::SHIFT,
        rate_hz: 50,
        servo_us: 2_000,
        rounds: &[(0.05, [100, 30, 30, 60, 40]), (0.35, [100, 30, 30, 60, 40]), (1.0, [100, 30, 30, 60, 40])],
        spoiled: 20,
        all_layouts: true,
        rubs: false,
    };

    /// So many ticks per second on a processor with this clock that takes so many cycles for an instruction. QEMU's clock runs at another
    /// speed than that one's, with as many instructions in a period.
    pub fn kept(rate_hz: f64, clock_hz: f64, cycles: f64, rubs: bool) -> Self {
        let shift = 3;
        let period_s = clock_hz / rate_hz / cycles * f64::from(1_u32 << shift) * 1e-9;
        let rounds = &[(0.35, [310, 100, 100, 60, 250]), (1.0, [120, 100, 100, 60, 100])];
        Self {
            shift,
            rate_hz: (1.0 / period_s).round() as u16,
            servo_us: (1e6 / rate_hz).round() as u32,
            rounds,
            spoiled: 200,
            all_layouts: false,
            rubs,
        }
    }

    fn estimates(&self) -> usize {
        self.rounds.iter().flat_map(|(_, counts)| counts).sum()
    }
}

/// An estimate.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// What it took.
    pub instructions: f64,
    /// Newton iterations.
    pub iterations: u16,
    /// A trustworthy force that is not zero.
    pub touching: bool,
    /// The tick ended before its estimate.
    pub cut: bool,
}

/// An estimate with its cycles on each chip, by the lower and by the upper bound.
pub type Measure = (Estimate, Vec<[u64; 2]>);

/// What a campaign has cost.
#[derive(Clone, Debug)]
pub struct Campaign {
    /// Those whose cycles were found.
    pub estimates: Vec<Measure>,
    /// All of them.
    pub seen: usize,
    /// How many were to be seen.
    pub wanted: usize,
    /// What the most expensive of all of them took, instructions.
    pub most: f64,
    /// The chips, in the order of their cycles.
    pub chips: Vec<Measured>,
    /// Addresses of the reads of the clock that an estimate lies between.
    pub between: Option<[u32; 2]>,
    /// For each chip, the share of the estimates' instructions whose address in its image is known by name.
    pub by_name: Vec<f64>,
}

/// Mean and largest.
pub fn mean_and_most(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let count = values.clone().count().max(1) as f64;
    [values.clone().sum::<f64>() / count, values.fold(0.0, f64::max)]
}

impl Estimate {
    fn of(report: &Report, per_tick: u32) -> Option<Self> {
        // A report without an answer of the servo has no estimate.
        if report.estimate.status == Status::Stale {
            return None;
        }
        Some(Self {
            instructions: f64::from(report.cost) * f64::from(per_tick),
            iterations: report.estimate.iterations,
            touching: report.estimate.force != [0.0; 2] && report.estimate.age == 0,
            cut: report.estimate.status == Status::MaxIterations,
        })
    }

    /// What tells the kinds of estimates apart: contact, and iterations.
    pub fn kind(self) -> (bool, u16) {
        (self.touching, self.iterations)
    }
}

impl Campaign {
    /// Mean in contact, and the largest of all.
    pub fn instructions(&self) -> [f64; 2] {
        let [mean, _] = mean_and_most(self.touching().map(|(estimate, _)| estimate.instructions));
        [mean, mean_and_most(self.estimates.iter().map(|(estimate, _)| estimate.instructions))[1]]
    }

    fn touching(&self) -> impl Iterator<Item = &Measure> + Clone {
        self.estimates.iter().filter(|(estimate, _)| estimate.touching)
    }

    /// The most iterations of an estimate.
    pub fn iterations(&self) -> u16 {
        self.estimates.iter().map(|(estimate, _)| estimate.iterations).max().unwrap_or(0)
    }

    /// Estimates that their ticks were too short for.
    pub fn cut(&self) -> usize {
        self.estimates.iter().filter(|(estimate, _)| estimate.cut).count()
    }

    /// The largest number of cycles of an estimate on a chip, by the lower and by the upper bound.
    pub fn most_cycles(&self, chip: usize) -> [f64; 2] {
        [0, 1].map(|bound| {
            let cycles = self.estimates.iter().filter_map(|(_, cycles)| Some(cycles.get(chip)?[bound] as f64));
            cycles.fold(0.0, f64::max)
        })
    }

    /// The same on average in contact.
    pub fn mean_cycles(&self, chip: usize) -> [f64; 2] {
        [0, 1].map(|bound| {
            mean_and_most(self.touching().filter_map(|(_, cycles)| Some(cycles.get(chip)?[bound] as f64)))[0]
        })
    }

    /// Estimates that take longer than so many seconds on a chip, by the lower and by the upper bound.
    pub fn longer_than(&self, chip: usize, seconds: f64) -> [usize; 2] {
        let clock_hz = self.chips.get(chip).map_or(1.0, |chip| chip.clock_hz);
        [0, 1].map(|bound| {
            let cycles = self.estimates.iter().filter_map(|(_, cycles)| Some(cycles.get(chip)?[bound] as f64));
            cycles.filter(|cycles| cycles / clock_hz > seconds).count()
        })
    }

    /// That the campaign has seen what it is for.
    fn check(&self) -> Result<()> {
        let [mean, most] = self.instructions();
        let contacts = self.touching().count();
        if contacts <= self.seen / 4 || self.seen < self.wanted || most <= mean {
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
        if most < self.most {
            bail!("the cycles of the most expensive estimate ({} instructions) were not found", self.most);
        }
        let iterations = self.iterations();
        if iterations > ITERATIONS {
            bail!("a tick did {iterations} iterations; allowed are {ITERATIONS}");
        }
        Ok(())
    }
}

/// Motions, grips, another object under way; answers are lost, damaged, cut, or come behind noise.
pub fn run(board: &str, samples: u8, pace: &Pace) -> Result<Campaign> {
    let campaign = measured(board, samples, pace)?;
    campaign.check().with_context(|| format!("{board}, {samples} samples"))?;
    Ok(campaign)
}

fn measured(board: &str, samples: u8, pace: &Pace) -> Result<Campaign> {
    let cycles = Cycles::twin(board);
    let cycles = if pace.all_layouts { cycles } else { cycles.as_image() };
    let clock = Clock::Requests { period_us: pace.servo_us };
    let servo = Config { noise_ma: 5.0, clock, ..Machine::servo() };
    let machine = Machine::boot_measured(servo, &cycles, pace.shift);
    let per_tick = Machine::instructions_per_tick(pace.shift);
    let link = machine.link();
    let mut watch = Watch::new(&link);
    link.set_settings(&Settings { rate_hz: pace.rate_hz, shape_every: 0, ..Settings::of(MOUNT) })?;
    let Finger { design, how, .. } = finger();
    let how = Discretisation { sampling: Sampling::PerElement(samples), ..how };
    let object = |design: ObjectDesign| Object { design, friction: if pace.rubs { FRICTION } else { 0.0 } };
    link.set_finger(0, &Finger::elastic(design, how).relaxing(if pace.rubs { PRONY } else { &[] }))?;
    link.set_object(0, object(OBJECT))?;
    watch.until_report("trustworthy estimate", PATIENCE, |report| report.estimate.age == 0);
    let mut random = ChaCha8Rng::seed_from_u64(u64::from(samples));
    let mut estimates: Vec<Estimate> = Vec::new();
    let mut pass = |watch: &mut Watch, count: usize| {
        let end = estimates.len() + count;
        watch.until_report("estimates", PATIENCE, |report| {
            // No faults for a servo that is lost already: they would be waiting for it when it is found.
            if let Some(estimate) = Estimate::of(report, per_tick) {
                estimates.push(estimate);
                if random.next_u32().is_multiple_of(pace.spoiled) {
                    machine.servo.inject([fault(&mut random)]);
                }
            }
            estimates.len() >= end
        });
        watch.reports.clear();
    };
    for &(speed, [closes, has_other, has_first, grips, opens]) in pace.rounds {
        let all = Which::All;
        // A servo that was lost refuses; it is found again.
        let _ = link.close(all, 11.0 * DEGREE, Some(speed));
        pass(&mut watch, closes);
        link.set_object(0, object(OTHER))?;
        pass(&mut watch, has_other);
        link.set_object(0, object(OBJECT))?;
        pass(&mut watch, has_first);
        let _ = link.grip(&GripTo { fingers: all, force: 5.0, speed: Some(speed), limit: None });
        pass(&mut watch, grips);
        let _ = link.open_fingers(all);
        pass(&mut watch, opens);
    }
    drop((watch, link));
    drop(machine);
    let report = cycles.report().context("the cycles' report")?;
    if !report.unknown.is_empty() {
        bail!("instructions that were not understood: {}", report.unknown.join(", "));
    }
    let costs: Vec<f64> = estimates.iter().map(|estimate| estimate.instructions).collect();
    let windows = report.measured_as(&costs, f64::from(per_tick));
    let (seen, [_, most]) = (estimates.len(), mean_and_most(costs.iter().copied()));
    let by_name = (0..report.chips.len()).map(|chip| share_by_name(&windows, chip)).collect();
    let between = windows.iter().flatten().next().map(|window| window.between);
    let found = |(estimate, window): (Estimate, Option<Window>)| Some((estimate, window?.cycles));
    let estimates = estimates.into_iter().zip(windows).filter_map(found).collect();
    Ok(Campaign { estimates, seen, wanted: pace.estimates(), most, chips: report.chips, between, by_name })
}

/// The share of the windows' instructions whose address in a chip's image is known by name.
fn share_by_name(windows: &[Option<Window>], chip: usize) -> f64 {
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

/// Figures such as a campaign has.
#[cfg(test)]
pub fn example(contacts: usize, others: usize, most: f64, iterations: u16) -> Campaign {
    let estimate = |touching, instructions| Estimate { instructions, iterations, touching, cut: !touching };
    let cycles = |instructions: f64| vec![[instructions as u64, 2 * instructions as u64]];
    let mut estimates: Vec<_> = (0..contacts).map(|_| (estimate(true, 1e5), cycles(1e5))).collect();
    estimates.extend((0..others).map(|_| (estimate(false, most), cycles(most))));
    let (board, layout) = ("opencr".to_owned(), "as its image".to_owned());
    let chip = Measured { board, layout, clock_hz: 1e9, addresses: vec![], functions: vec![] };
    let seen = estimates.len();
    Campaign { seen, wanted: 780, most, estimates, chips: vec![chip], between: None, by_name: vec![1.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_campaign_that_saw_too_little_is_an_error() {
        assert!(example(400, 380, 1e6, 6).check().is_ok());
        assert!(example(100, 680, 1e6, 6).check().is_err());
        assert!(example(90, 10, 1e6, 6).check().is_err());
        assert!(example(400, 380, 1e6, 9).check().is_err());
        assert!(Campaign { seen: 1000, ..example(400, 380, 1e6, 6) }.check().is_err(), "windows are missing");
        assert!(
            Campaign { most: 1.1e6, ..example(400, 380, 1e6, 6) }.check().is_err(),
            "the one that counts is missing"
        );
        assert!(Campaign { by_name: vec![0.3], ..example(400, 380, 1e6, 6) }.check().is_err(), "another image");
    }

    #[test]
    fn what_is_longer_is_counted_by_both_bounds() {
        let campaign = example(10, 5, 1e6, 6);
        assert_eq!((campaign.most_cycles(0), campaign.mean_cycles(0)), ([1e6, 2e6], [1e5, 2e5]));
        // At 1 GHz 1 to 2 ms, and 0.1 to 0.2 ms.
        assert_eq!(campaign.longer_than(0, 1.5e-3), [0, 5]);
        assert_eq!(campaign.longer_than(0, 0.5e-3), [5, 5]);
        assert_eq!(campaign.longer_than(0, 3e-3), [0, 0]);
        assert_eq!((campaign.cut(), campaign.iterations()), (5, 6));
    }

    #[test]
    fn a_period_has_as_many_instructions_as_on_the_board() {
        // 432,000 cycles, 216,000 instructions: 1.728 ms of 8 ns each.
        let pace = Pace::kept(500.0, 216e6, 2.0, false);
        assert_eq!((pace.rate_hz, pace.servo_us), (579, 2_000));
        assert_eq!(Pace::SLOW.estimates(), 780);
    }
}
