//! What a tick of the target costs at most while everything goes wrong that can, and the rates that follow from it.

use std::fmt;
use std::time::Duration;

use anyhow::{Result, bail};
use fre_gripper::servo::{Config, Fault};
use messages::{Finger, GripTo, Mount, Report, Settings, Which};
use model_core::discretise::{Discretisation, Sampling};
use model_core::object::ObjectDesign;
use model_core::status::Status;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use system_tests::{Machine, OBJECT, Watch, finger};

const DEGREE: f32 = std::f32::consts::PI / 180.0;
const MOUNT: Mount = Mount { open_angle: -DEGREE, range: [-0.05, 0.3], ..Mount::DEFAULT };
/// The other object, which is set and taken away while the finger is on it: the model begins anew.
const OTHER: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 56.0], radius: 40.0 };
/// Rounds of closing, gripping and opening.
const ROUNDS: u32 = 3;
/// Estimates of a round.
const ESTIMATES: u32 = 260;
/// Newton iterations of a tick at most.
const ITERATIONS: usize = 8;
/// Cycles per instruction: an assumption, QEMU counts instructions only.
const CYCLES: f64 = 1.5;
/// Boards: clock, and for how many fingers they have room.
const BOARDS: [(&str, f64, usize); 3] =
    [("opencr", 216e6, 2), ("nucleo-h743zi", 480e6, 4), ("nucleo-g474re", 170e6, 1)];
const BAUDS: [u32; 4] = [57_600, 1_000_000, 2_000_000, 4_000_000];
const PATIENCE: Duration = Duration::from_secs(300);

/// The campaign with each number of samples.
#[derive(Clone, Debug)]
pub struct Rates(pub Vec<(u8, Cost)>);

/// What a campaign has cost, in instructions per estimate.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cost {
    pub estimates: u32,
    pub contacts: u32,
    /// In contact.
    pub mean: f64,
    pub most: f64,
    pub iterations: u16,
    /// By the number of iterations: ticks in contact, and what they took on average.
    by_iterations: [(u32, f64); ITERATIONS + 1],
}

impl Cost {
    fn see(&mut self, report: &Report) {
        // A report without an answer of the servo has no estimate.
        if report.estimate.status == Status::Stale {
            return;
        }
        let instructions = f64::from(report.cost) * f64::from(Machine::INSTRUCTIONS_PER_TICK);
        self.estimates += 1;
        self.most = self.most.max(instructions);
        self.iterations = self.iterations.max(report.estimate.iterations);
        if report.estimate.force != [0.0; 2] && report.estimate.age == 0 {
            self.contacts += 1;
            self.mean += (instructions - self.mean) / f64::from(self.contacts);
            if let Some((ticks, mean)) = self.by_iterations.get_mut(usize::from(report.estimate.iterations)) {
                *ticks += 1;
                *mean += (instructions - *mean) / f64::from(*ticks);
            }
        }
    }

    /// That the campaign has seen what it is for.
    fn check(&self) -> Result<()> {
        if self.contacts <= self.estimates / 4 || self.estimates < ROUNDS * ESTIMATES || self.most <= self.mean {
            bail!("the campaign was not what it should be: {self:?}");
        }
        if usize::from(self.iterations) > ITERATIONS {
            bail!("a tick did {} iterations; allowed are {ITERATIONS}", self.iterations);
        }
        Ok(())
    }

    /// Ticks per second: what the bus needs, and the estimate of every finger behind it, at a clock of so many hertz.
    fn rate(instructions: f64, hz: f64, fingers: usize, baud: u32) -> f64 {
        let bus_us = gripper::period_us(u16::MAX, baud, 0, fingers) as f64;
        1e6 / (bus_us + fingers as f64 * instructions * CYCLES / hz * 1e6)
    }
}

/// Runs the campaigns on the firmware in QEMU, which `FRE_FIRMWARE_ELF` names.
pub fn measure() -> Result<Rates> {
    let mut costs = Vec::new();
    for samples in [2, 4, 5] {
        let cost = campaign(samples)?;
        cost.check()?;
        costs.push((samples, cost));
    }
    Ok(Rates(costs))
}

/// Fast and slow motions, grips, another object under way; every twentieth answer is lost, damaged, cut, or comes behind noise.
fn campaign(samples: u8) -> Result<Cost> {
    let machine = Machine::boot(Config { noise_ma: 5.0, ..Machine::servo() });
    let link = machine.link();
    let mut watch = Watch::new(&link);
    // Slow, so that no tick is cut short for want of time.
    link.set_settings(&Settings { rate_hz: 50, shape_every: 0, ..Settings::of(MOUNT) })?;
    let Finger { design, how } = finger();
    let how = Discretisation { sampling: Sampling::PerElement(samples), ..how };
    link.set_finger(0, &Finger { design, how })?;
    link.set_object(0, OBJECT)?;
    watch.until_report("trustworthy estimate", PATIENCE, |report| report.estimate.age == 0);
    let mut random = ChaCha8Rng::seed_from_u64(u64::from(samples));
    let mut cost = Cost::default();
    let mut pass = |watch: &mut Watch, estimates: u32| {
        let end = cost.estimates + estimates;
        watch.until_report("estimates", PATIENCE, |report| {
            cost.see(report);
            if random.next_u32().is_multiple_of(20) {
                machine.servo.inject([fault(&mut random)]);
            }
            cost.estimates >= end
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
    Ok(cost)
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

impl fmt::Display for Rates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(costs) = self;
        writeln!(f, "| samples | estimates | in contact, mean | worst, instructions | iterations at most |")?;
        writeln!(f, "|---|---|---|---|---|")?;
        for (samples, cost) in costs {
            let Cost { estimates, mean, most, iterations, .. } = cost;
            writeln!(f, "| {samples} | {estimates} | {mean:.0} | {most:.0} | {iterations} |")?;
        }
        writeln!(f, "\nin contact, by Newton iterations (ticks: instructions on average)")?;
        for (samples, cost) in costs {
            let seen = cost.by_iterations.iter().enumerate().filter(|(_, (ticks, _))| *ticks > 0);
            let seen: Vec<String> =
                seen.map(|(count, (ticks, mean))| format!("{count} ({ticks}: {mean:.0})")).collect();
            writeln!(f, "{samples} samples: {}", seen.join(", "))?;
        }
        writeln!(f, "\n| board | fingers | samples | 57,600 baud | 1 Mbaud | 2 Mbaud | 4 Mbaud |")?;
        writeln!(f, "|---|---|---|---|---|---|---|")?;
        for (board, hz, room) in BOARDS {
            for fingers in 1..=room {
                for (samples, cost) in costs {
                    let rate = |instructions, baud| Cost::rate(instructions, hz, fingers, baud);
                    let rates =
                        BAUDS.map(|baud| format!("{:.0} ({:.0})", rate(cost.most, baud), rate(cost.mean, baud)));
                    writeln!(f, "| {board} | {fingers} | {samples} | {} |", rates.join(" | "))?;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_campaign_that_saw_too_little_is_an_error() {
        let sound = Cost {
            estimates: ROUNDS * ESTIMATES,
            contacts: 400,
            mean: 1e5,
            most: 1e6,
            iterations: 6,
            ..Cost::default()
        };
        assert!(sound.check().is_ok());
        assert!(Cost { contacts: 100, ..sound }.check().is_err());
        assert!(Cost { estimates: 100, contacts: 90, ..sound }.check().is_err());
        assert!(Cost { iterations: 9, ..sound }.check().is_err());
    }

    #[test]
    fn the_bus_and_the_estimates_make_the_period() {
        let bus_us = gripper::period_us(u16::MAX, 1_000_000, 0, 2) as f64;
        // 144,000 instructions at 1.5 cycles on 216 MHz: 1 ms each.
        let rate = Cost::rate(144_000.0, 216e6, 2, 1_000_000);
        assert!((rate - 1e6 / (bus_us + 2_000.0)).abs() < 1e-9, "{rate}");
    }
}
