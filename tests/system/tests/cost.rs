//! What a tick of the target costs at most while everything goes wrong that can, and the rates that follow from it.
//! `cargo xtask bench rates` prints both.

use std::time::Duration;

use host::servo::{Config, Fault};
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
/// Cycles per instruction: an assumption, QEMU knows instructions only.
const CYCLES: f64 = 1.5;
/// Boards: clock, and for how many fingers they have room.
const BOARDS: [(&str, f64, usize); 3] =
    [("opencr", 216e6, 2), ("nucleo-h743zi", 480e6, 4), ("nucleo-g474re", 170e6, 1)];
const BAUDS: [u32; 4] = [57_600, 1_000_000, 2_000_000, 4_000_000];

/// What a campaign has cost, in instructions per estimate.
#[derive(Clone, Copy, Debug, Default)]
struct Cost {
    estimates: u32,
    contacts: u32,
    mean: f64,
    most: f64,
    iterations: u16,
    /// By the number of iterations: ticks in contact, and what they took on average.
    by_iterations: [(u32, f64); 9],
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
}

/// Fast and slow motions, grips, another object under way; every twentieth answer is lost, damaged, cut, or comes behind noise.
fn campaign(samples: u8) -> Cost {
    let machine = Machine::boot(Config { noise_ma: 5.0, ..Machine::servo() });
    let link = machine.link();
    let mut watch = Watch::new(&link);
    // Slow, so that no tick is cut short for want of time.
    link.set_settings(&Settings { rate_hz: 50, shape_every: 0, ..Settings::of(MOUNT) }).unwrap();
    let Finger { design, how } = finger();
    let how = Discretisation { sampling: Sampling::PerElement(samples), ..how };
    link.set_finger(0, &Finger { design, how }).unwrap();
    link.set_object(0, OBJECT).unwrap();
    let patience = Duration::from_secs(300);
    watch.until_report("trustworthy estimate", patience, |report| report.estimate.age == 0);
    let mut random = ChaCha8Rng::seed_from_u64(u64::from(samples));
    let mut cost = Cost::default();
    let mut pass = |watch: &mut Watch, estimates: u32| {
        let end = cost.estimates + estimates;
        watch.until_report("estimates", patience, |report| {
            cost.see(report);
            if random.next_u32().is_multiple_of(20) {
                let fault = match random.next_u32() % 4 {
                    0 => Fault::Drop,
                    1 => {
                        Fault::Corrupt { index: (random.next_u32() % 20) as usize, mask: 1 << (random.next_u32() % 8) }
                    }
                    2 => Fault::Truncate { bytes: (random.next_u32() % 20) as usize },
                    _ => Fault::Noise(vec![random.next_u32() as u8; 20]),
                };
                machine.servo.inject([fault]);
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
        link.set_object(0, OTHER).unwrap();
        pass(&mut watch, 30);
        link.set_object(0, OBJECT).unwrap();
        pass(&mut watch, 30);
        let _ = link.grip(&GripTo { fingers: all, force: 5.0, speed: Some(speed), limit: None });
        pass(&mut watch, 60);
        let _ = link.open_fingers(all);
        pass(&mut watch, 40);
    }
    cost
}

/// Ticks per second: what the bus needs, and the dearest estimate of every finger behind it.
fn rate(hz: f64, cost: f64, fingers: usize, baud: u32) -> f64 {
    let bus_us = gripper::period_us(u16::MAX, baud, 0, fingers) as f64;
    1e6 / (bus_us + fingers as f64 * cost * CYCLES / hz * 1e6)
}

#[test]
fn the_dearest_tick_and_the_rates() {
    let costs = [2, 4, 5].map(|samples| (samples, campaign(samples)));
    println!("| samples | estimates | in contact, mean | dearest, instructions | iterations at most |");
    println!("|---|---|---|---|---|");
    for (samples, cost) in &costs {
        println!("| {samples} | {} | {:.0} | {:.0} | {} |", cost.estimates, cost.mean, cost.most, cost.iterations);
        assert!(cost.contacts > cost.estimates / 4 && cost.estimates > ROUNDS * 200, "{cost:?}");
        assert!(cost.most > cost.mean && cost.iterations <= 8, "{cost:?}");
    }
    println!("\nin contact, by Newton iterations (ticks: instructions on average)");
    for (samples, cost) in &costs {
        let seen = cost.by_iterations.iter().enumerate().filter(|(_, (ticks, _))| *ticks > 0);
        let seen: Vec<String> = seen.map(|(count, (ticks, mean))| format!("{count} ({ticks}: {mean:.0})")).collect();
        println!("{samples} samples: {}", seen.join(", "));
    }
    println!("\n| board | fingers | samples | 57,600 baud | 1 Mbaud | 2 Mbaud | 4 Mbaud |");
    println!("|---|---|---|---|---|---|---|");
    for (board, hz, room) in BOARDS {
        for fingers in 1..=room {
            for (samples, cost) in &costs {
                let rates = BAUDS.map(|baud| {
                    format!("{:.0} ({:.0})", rate(hz, cost.most, fingers, baud), rate(hz, cost.mean, fingers, baud))
                });
                println!("| {board} | {fingers} | {samples} | {} |", rates.join(" | "));
            }
        }
    }
}
