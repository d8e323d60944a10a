//! Faults of every kind, drawn with a seed, on a gripper with four fingers that grips and opens: how many it gets over, whether a wrong
//! force is ever marked good, and what a grip loses by faults that need not cost it anything.

use std::fmt;

use fre_gripper::servo::{Config, Fault, Truth};
use messages::{
    Close, CloseTo, FINGERS, For, Grip, GripTo, Hold, Mount, Open, Phase, PlaceObject, Relax, Report, SetFinger,
    SetObject, SetSettings, Settings, Which,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use crate::hour::{GEARED_MOUNT, geared_servo};
use crate::judge::is_sound;
use crate::{Bench, Flash, Judge, OBJECT, finger};

const SECOND: u64 = 1_000_000;
/// How long a gripper may take until every finger has a sound estimate again, µs.
const PATIENCE: u64 = 10 * SECOND;
/// A force that has not changed by 1 % in this time is steady, µs.
const STEADY: u64 = 300_000;
/// A grip's force, N, below which its loss is not counted.
const LEAST: f64 = 1.0;

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Hazard {
    /// A servo does not answer for some ticks.
    Silence,
    /// Random bytes on the bus.
    Noise,
    /// Flipped bits on the bus.
    BitErrors,
    /// Answers of a servo come late, cut or damaged.
    Answers,
    /// Another master asks the servos.
    OtherMaster,
    /// Another program leaves a servo answering pings only.
    StatusReturn,
    /// Another program sets a servo to velocity control.
    OtherMode,
    /// A servo's Bus Watchdog trips.
    BusWatchdog,
    /// A servo's power fails.
    ServoPower,
    /// A servo has a hardware error until its power fails.
    HardwareError,
    /// A servo gets hot.
    Heat,
    /// A servo's supply gets poor.
    Supply,
    /// The microcontroller restarts.
    Restart,
    /// Its flash is damaged, and it restarts.
    Flash,
    /// Its processor is slow for a while.
    SlowProcessor,
    /// The host does not listen.
    Host,
    /// Random bytes on the link.
    LinkNoise,
    /// An object is placed again and again.
    Placing,
    /// Orders of every kind, faster than they can be done.
    Orders,
}

const HAZARDS: [(Hazard, &str); 19] = [
    (Hazard::Silence, "a servo is silent for 1 to 8 ticks"),
    (Hazard::Noise, "random bytes on the bus"),
    (Hazard::BitErrors, "bit errors of 1e-3 on the bus"),
    (Hazard::Answers, "answers that are late, cut or damaged"),
    (Hazard::OtherMaster, "another master on the bus"),
    (Hazard::StatusReturn, "a servo answers pings only"),
    (Hazard::OtherMode, "a servo is set to velocity control"),
    (Hazard::BusWatchdog, "a servo's Bus Watchdog trips"),
    (Hazard::ServoPower, "a servo's power fails"),
    (Hazard::HardwareError, "a servo shuts down"),
    (Hazard::Heat, "a servo gets hot"),
    (Hazard::Supply, "a servo's supply gets poor"),
    (Hazard::Restart, "the microcontroller restarts"),
    (Hazard::Flash, "its flash is damaged, and it restarts"),
    (Hazard::SlowProcessor, "an estimate takes half a period"),
    (Hazard::Host, "the host does not listen"),
    (Hazard::LinkNoise, "random bytes on the link"),
    (Hazard::Placing, "objects are placed at any rate"),
    (Hazard::Orders, "orders faster than they can be done"),
];

impl Hazard {
    /// Whether a grip may not lose by it: nothing takes the servo's torque, and nobody asks for another force.
    fn spares_grips(self) -> bool {
        matches!(
            self,
            Self::Silence
                | Self::Noise
                | Self::BitErrors
                | Self::Answers
                | Self::OtherMaster
                | Self::StatusReturn
                | Self::Restart
                | Self::SlowProcessor
                | Self::Host
                | Self::LinkNoise
        )
    }
}

/// What became of a campaign.
#[derive(Debug, Default)]
pub struct Campaign {
    /// Of every report.
    pub judge: Judge,
    /// By hazard: events, and the longest time until every finger was sound again, µs.
    rows: Vec<(u32, u64)>,
    /// Events.
    pub events: u32,
    /// Events after which every finger had a sound estimate again.
    pub recovered: u32,
    /// The first that was not got over.
    pub lasting: Option<String>,
    /// Grips that were under way when something happened that need not cost them anything.
    pub grips: u32,
    /// The greatest part of its force that one of them has lost.
    pub worst_loss: f64,
    /// By what.
    pub worst_by: String,
    /// Time that passed, µs.
    pub passed_us: u64,
    /// The longest time between two feeds of the watchdog, µs; after how long it bites.
    pub fast_us: (u64, u64),
}

/// A gripper under fire.
struct Range {
    bench: Bench,
    flash: Flash,
    random: ChaCha8Rng,
    outcome: Campaign,
    last: [Option<Report>; FINGERS],
}

/// Runs so many events; the same ones for the same seed.
pub fn campaign(seed: u64, events: u32) -> Campaign {
    let flash = Flash::new();
    let servo = |id| Config { id, ..geared_servo() };
    let mut bench = Bench::of(servo(1), vec![servo(2), servo(3), servo(4)], &flash);
    bench.keeps = false;
    let random = ChaCha8Rng::seed_from_u64(seed);
    let outcome = Campaign { rows: vec![(0, 0); HAZARDS.len()], ..Campaign::default() };
    let mut range = Range { bench, flash, random, outcome, last: [None; FINGERS] };
    range.set_up();
    range.recover();
    for _ in 0..events {
        range.event();
    }
    let Range { bench, mut outcome, .. } = range;
    (outcome.passed_us, outcome.fast_us) = (bench.now_us(), bench.longest_fast_us());
    outcome
}

fn force(truth: &Truth) -> f64 {
    truth.force[0].hypot(truth.force[1])
}

impl Range {
    fn below(&mut self, end: u32) -> u32 {
        self.random.next_u32() % end
    }

    fn set_up(&mut self) {
        let mount = |servo_id| Some(Mount { servo_id, ..GEARED_MOUNT });
        let fingers = [mount(1), mount(2), mount(3), mount(4)];
        let settings = Settings { rate_hz: 100, shape_every: 0, fingers, ..Settings::of(GEARED_MOUNT) };
        self.bench.ask::<SetSettings>(&settings).expect("settings");
        for number in 0..FINGERS as u8 {
            self.bench.ask::<SetFinger>(&For { finger: number, what: finger() }).expect("a finger");
            self.bench.ask::<SetObject>(&For { finger: number, what: OBJECT.into() }).expect("an object");
        }
    }

    /// Lets time pass, and judges every report; the least force of each finger meanwhile, N.
    fn run(&mut self, us: u64) -> [f64; FINGERS] {
        let mut least = [f64::INFINITY; FINGERS];
        let Self { bench, outcome, last, .. } = self;
        let mut passed = 0;
        while passed < us {
            // Every 2 ms: what a finger loses in between it has lost then, too.
            bench.run_with(2_000, |report, truth| {
                outcome.judge.look(report, truth);
                last[usize::from(report.finger)] = Some(*report);
            });
            passed += 2_000;
            for (finger, least) in least.iter_mut().enumerate() {
                *least = least.min(force(&bench.servo_of(finger).truth()));
            }
        }
        least
    }

    /// Whether every finger's last report is sound.
    fn is_well(&self) -> bool {
        self.last.iter().all(|report| report.is_some_and(|report| is_sound(&report)))
    }

    /// Lets time pass until every finger is sound, or patience ends; how long that took, µs, and the least forces meanwhile.
    fn recover(&mut self) -> (Option<u64>, [f64; FINGERS]) {
        let began = self.bench.now_us();
        let mut least = [f64::INFINITY; FINGERS];
        // What was reported before may be old.
        self.last = [None; FINGERS];
        while self.bench.now_us() - began < PATIENCE {
            let now = self.run(20_000);
            least.iter_mut().zip(now).for_each(|(least, now)| *least = least.min(now));
            if self.is_well() {
                return (Some(self.bench.now_us() - began), least);
            }
        }
        (None, least)
    }

    /// Grips or opens, now and then.
    fn order(&mut self) {
        let all = Which::All;
        match self.below(8) {
            0 => drop(self.bench.ask::<Open>(&all)),
            1..=3 => {
                let force = 2.0 + self.below(600) as f32 / 100.0;
                drop(self.bench.ask::<Grip>(&GripTo { fingers: all, force, speed: None, limit: None }));
            }
            _ => return,
        }
        self.run(3 * SECOND / 2);
    }

    /// The force of each finger that grips, or holds what it has gripped, and whose force nothing changes at the moment, N. (What heat and
    /// supply have changed before is made good meanwhile.)
    fn grips(&mut self) -> Vec<Option<f64>> {
        let forces = |range: &mut Self| -> Vec<f64> {
            (0..FINGERS).map(|finger| force(&range.bench.servo_of(finger).truth())).collect()
        };
        let earlier = forces(self);
        self.run(STEADY);
        let now = forces(self);
        let steady = |(finger, (earlier, now)): (usize, (f64, f64))| {
            let phase = self.last[finger].map(|report| report.phase);
            let grips = matches!(phase, Some(Phase::Gripped | Phase::Held(_)));
            (grips && now > LEAST && (earlier - now).abs() < 0.01 * now).then_some(now)
        };
        earlier.into_iter().zip(now).enumerate().map(steady).collect()
    }

    /// One event, and what became of it.
    fn event(&mut self) {
        self.order();
        let place = self.below(HAZARDS.len() as u32) as usize;
        let (hazard, words) = HAZARDS[place];
        let target = self.below(FINGERS as u32) as usize;
        let before = self.grips();
        let during = self.strike(hazard, target);
        let (took, after) = self.recover();
        self.outcome.events += 1;
        let (count, longest) = &mut self.outcome.rows[place];
        *count += 1;
        match took {
            Some(us) => {
                self.outcome.recovered += 1;
                *longest = (*longest).max(us);
            }
            None => {
                let number = self.outcome.events;
                let last = self.last;
                self.outcome
                    .lasting
                    .get_or_insert_with(|| format!("event {number}, {words}, finger {target}: {last:?}"));
                self.revive();
            }
        }
        if hazard.spares_grips() {
            for (finger, before) in before.into_iter().enumerate() {
                if let Some(before) = before {
                    self.outcome.grips += 1;
                    let loss = 1.0 - during[finger].min(after[finger]) / before;
                    if loss > self.outcome.worst_loss {
                        self.outcome.worst_loss = loss;
                        let phase = self.last[finger].map(|report| report.phase);
                        let number = self.outcome.events;
                        self.outcome.worst_by =
                            format!("{words}, event {number}, finger {finger}, {before:.2} N, {phase:?}");
                    }
                }
            }
        }
    }

    /// Lets one thing go wrong, and be right again; the least forces meanwhile, N.
    fn strike(&mut self, hazard: Hazard, target: usize) -> [f64; FINGERS] {
        use dynamixel::xm430;
        let seed = self.random.next_u64();
        match hazard {
            Hazard::Silence => {
                let us = u64::from(1 + self.below(8)) * 10_000;
                let until = self.bench.now_us() + us;
                self.bench.servo_of(target).silence(until);
                self.run(us)
            }
            Hazard::Noise => {
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                self.bench.meddling = Box::new(move |_, bytes| {
                    let mut noise = vec![0; (random.next_u32() % 48) as usize];
                    random.fill_bytes(&mut noise);
                    match random.next_u32() % 4 {
                        0 => [noise, bytes].concat(),
                        1 => [bytes, noise].concat(),
                        2 => noise,
                        _ => bytes,
                    }
                });
                let least = self.run(100_000);
                self.bench.meddling = Box::new(|_, bytes| bytes);
                least
            }
            Hazard::BitErrors => {
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                self.bench.meddling = Box::new(move |_, mut bytes| {
                    for byte in &mut bytes {
                        let flips = (0..8).filter(|_| random.next_u32() < u32::MAX / 1000);
                        *byte ^= flips.fold(0, |mask, bit| mask | 1 << bit);
                    }
                    bytes
                });
                let least = self.run(300_000);
                self.bench.meddling = Box::new(|_, bytes| bytes);
                least
            }
            Hazard::Answers => {
                let index = (seed >> 8) as usize % 16;
                let fault = match seed % 4 {
                    0 => Fault::Delay { us: 12_000 },
                    1 => Fault::Truncate { bytes: index },
                    2 => Fault::Corrupt { index, mask: 1 << (seed >> 16 & 7) },
                    _ => Fault::Noise(vec![(seed >> 16) as u8; index]),
                };
                let count = 1 + (seed >> 24) as usize % 3;
                self.bench.servo_of(target).inject(vec![fault; count]);
                self.run(50_000)
            }
            Hazard::OtherMaster => {
                let mut buffer = [0; 64];
                let id = dynamixel::Id::new(target as u8 + 1).expect("an address");
                for round in 0..4 {
                    let (instruction, parameters): (_, &[u8]) = match (seed >> (8 * round)) % 3 {
                        0 => (dynamixel::Instruction::Ping, &[]),
                        1 => (dynamixel::Instruction::Read, &[132, 0, 4, 0]),
                        _ => (dynamixel::Instruction::Read, &[126, 0, 10, 0]),
                    };
                    let words = dynamixel::encode(&mut buffer, id, instruction, parameters).expect("a packet").to_vec();
                    self.bench.interject(&words);
                    self.run(6_000);
                }
                self.run(20_000)
            }
            Hazard::StatusReturn => {
                self.bench.servo_of(target).write(xm430::STATUS_RETURN_LEVEL, 0);
                self.run(100_000)
            }
            Hazard::OtherMode => {
                // It is looked at anew once it counts as lost.
                let until = self.bench.now_us() + 400_000;
                let servo = self.bench.servo_of(target);
                servo.write(xm430::TORQUE_ENABLE, 0);
                servo.write(xm430::OPERATING_MODE, 1);
                servo.write(xm430::TORQUE_ENABLE, 1);
                servo.silence(until);
                let least = self.run(SECOND);
                let servo = self.bench.servo_of(target);
                servo.write(xm430::TORQUE_ENABLE, 0);
                servo.write(xm430::OPERATING_MODE, 3);
                least
            }
            Hazard::BusWatchdog => {
                let until = self.bench.now_us() + 200_000;
                let servo = self.bench.servo_of(target);
                servo.write(xm430::BUS_WATCHDOG, 1);
                servo.silence(until);
                self.run(300_000)
            }
            Hazard::ServoPower => {
                self.bench.servo_of(target).reset();
                self.run(50_000)
            }
            Hazard::HardwareError => {
                self.bench.servo_of(target).fail(0x20);
                let least = self.run(SECOND / 2);
                self.bench.servo_of(target).reset();
                least
            }
            Hazard::Heat => self.surround(target, 12.0, 58.0 + (seed % 24) as f64),
            Hazard::Supply => self.surround(target, 9.2 + (seed % 15) as f64 / 10.0, 35.0),
            Hazard::Restart => {
                let flash = self.flash.clone();
                self.bench.restart(&flash);
                self.run(50_000)
            }
            Hazard::Flash => {
                for _ in 0..1 + self.below(200) {
                    let (at, byte) = (self.random.next_u32() as usize, self.random.next_u32() as u8);
                    self.flash.damage(at, byte);
                }
                let flash = self.flash.clone();
                self.bench.restart(&flash);
                let least = self.run(SECOND / 2);
                // Whatever is left of it, a person sets it up again.
                self.set_up();
                least
            }
            Hazard::SlowProcessor => {
                self.bench.set_cost(5_000);
                let least = self.run(300_000);
                self.bench.set_cost(0);
                least
            }
            Hazard::Host => {
                self.bench.listens = false;
                let mut least = [f64::INFINITY; FINGERS];
                for _ in 0..1 + self.below(40) {
                    self.bench.run(50_000);
                    for (finger, least) in least.iter_mut().enumerate() {
                        *least = least.min(force(&self.bench.servo_of(finger).truth()));
                    }
                }
                self.bench.listens = true;
                // The oldest that have waited are of before: their truth was another.
                self.bench.run(200_000);
                least
            }
            Hazard::LinkNoise => {
                let mut noise = vec![0; 200];
                self.random.fill_bytes(&mut noise);
                self.bench.send_raw(&noise);
                self.run(50_000)
            }
            Hazard::Placing => {
                for _ in 0..20 {
                    let _ = self.bench.send::<PlaceObject>(&For { finger: target as u8, what: OBJECT.into() });
                }
                let least = self.run(100_000);
                self.bench.take_answered();
                least
            }
            Hazard::Orders => {
                for _ in 0..30 {
                    let fingers = if self.below(2) == 0 { Which::All } else { Which::One(self.below(4) as u8) };
                    let _ = match self.below(5) {
                        0 => self.bench.send::<Open>(&fingers),
                        1 => self.bench.send::<Hold>(&fingers),
                        2 => self.bench.send::<Relax>(&fingers),
                        3 => self.bench.send::<Close>(&CloseTo { fingers, angle: 0.12, speed: Some(0.5) }),
                        _ => self.bench.send::<Grip>(&GripTo { fingers, force: 6.0, speed: None, limit: None }),
                    };
                    self.run(4_000);
                }
                let least = self.run(100_000);
                self.bench.take_answered();
                least
            }
        }
    }

    /// Keeps a servo's supply and temperature so for some seconds. Where it has shut down, its power is switched off and on.
    fn surround(&mut self, target: usize, volts: f64, temperature: f64) -> [f64; FINGERS] {
        let mut least = [f64::INFINITY; FINGERS];
        for _ in 0..25 {
            self.bench.servo_of(target).surround(Some(volts), Some(temperature));
            let now = self.run(100_000);
            least.iter_mut().zip(now).for_each(|(least, now)| *least = least.min(now));
        }
        let servo = self.bench.servo_of(target);
        servo.surround(Some(12.0), Some(32.0));
        if servo.read(dynamixel::xm430::HARDWARE_ERROR_STATUS) != 0 {
            servo.reset();
        }
        least
    }

    /// Power off and on, and everything set up: so that what follows has its chance.
    fn revive(&mut self) {
        for finger in 0..FINGERS {
            self.bench.servo_of(finger).reset();
        }
        let flash = self.flash.clone();
        self.bench.restart(&flash);
        self.bench.run(SECOND / 2);
        self.set_up();
        self.recover();
    }
}

impl Campaign {
    /// What was not as it has to be.
    pub fn faults(&self) -> Vec<String> {
        let Self { judge, events, recovered, lasting, worst_loss, worst_by, fast_us: (fast, bite), .. } = self;
        let mut faults = Vec::new();
        if judge.wrong > 0 {
            faults.push(format!("{} wrong forces were marked good, first {:?}", judge.wrong, judge.first_wrong));
        }
        if recovered < events {
            faults.push(format!("{} events lasted, first {lasting:?}", events - recovered));
        }
        if *worst_loss > 0.05 {
            faults.push(format!("a grip lost {:.1} % of its force: {worst_by}", 100.0 * worst_loss));
        }
        if fast >= bite {
            faults.push(format!("the watchdog would have bitten after {fast} µs"));
        }
        faults
    }
}

impl fmt::Display for Campaign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "| what goes wrong | events | longest until all four are sound again, s |")?;
        writeln!(f, "|---|---:|---:|")?;
        for ((_, words), (count, longest)) in HAZARDS.iter().zip(&self.rows) {
            writeln!(f, "| {words} | {count} | {:.2} |", *longest as f64 * 1e-6)?;
        }
        let Self { judge, events, recovered, grips, worst_loss, worst_by, passed_us, fast_us: (fast, _), .. } = self;
        writeln!(f)?;
        writeln!(f, "{events} events in {:.0} min, {recovered} got over", *passed_us as f64 / 6e7)?;
        writeln!(f, "{judge}")?;
        writeln!(
            f,
            "{grips} grips that need not lose anything: {:.1} % lost at most ({worst_by})",
            100.0 * worst_loss
        )?;
        writeln!(f, "longest fast of the watchdog {fast} µs")
    }
}
