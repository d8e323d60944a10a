//! An hour of gripping and releasing on a bus that loses, damages and cuts answers; it takes a minute.

use std::sync::{Arc, OnceLock};

use fre_gripper::servo::{Config, Load};
use messages::{For, GetCounters, Grip, GripTo, Mount, Open, SetFinger, SetObject, SetSettings, Settings, Which};
use model_core::object::ObjectDesign;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use crate::judge::is_sound;
use crate::{Bench, Flash, Judge, OBJECT, finger, load_of};

const SECOND: u64 = 1_000_000;
const DEGREE: f32 = std::f32::consts::PI / 180.0;
const BACKLASH_DEG: f64 = 0.25;
/// Grips of the hour, 10 s each.
const ROUNDS: u32 = 360;

/// The mount of [`geared_servo`]: its play is known.
pub const GEARED_MOUNT: Mount = Mount {
    open_angle: -DEGREE,
    backlash: BACKLASH_DEG as f32 * DEGREE,
    range: [-0.05, 0.3],
    force_limit: 100.0,
    current_limit: 2000.0,
    ..Mount::DEFAULT
};

/// A servo with play at 1 Mbaud, on [`OBJECT`], which starts at −1°.
pub fn geared_servo() -> Config {
    static LOAD: OnceLock<Arc<Load>> = OnceLock::new();
    let load = LOAD.get_or_init(|| load_of(OBJECT, 13.0)).clone();
    Config { baud_rate: 1_000_000, backlash_deg: BACKLASH_DEG, start_deg: Some(-1.0), load, ..Config::default() }
}

/// Sets a gripper up and waits until its estimates are sound.
pub fn set_up(bench: &mut Bench, settings: &Settings, object: ObjectDesign) {
    bench.ask::<SetSettings>(settings).expect("settings");
    bench.ask::<SetFinger>(&For { finger: 0, what: finger() }).expect("a finger");
    bench.ask::<SetObject>(&For { finger: 0, what: object.into() }).expect("an object");
    bench.until("sound estimate", 5 * SECOND, is_sound);
}

/// A gripper with a [`geared_servo`], set up.
pub fn ready(settings: &Settings) -> Bench {
    let mut bench = Bench::new(geared_servo(), &Flash::new());
    set_up(&mut bench, settings, OBJECT);
    bench
}

/// What became of the hour.
#[derive(Debug)]
pub struct Hour {
    /// Of every report.
    pub judge: Judge,
    /// Grips whose true force came within 10 % or 1 N of what was asked.
    pub reached: u32,
    /// Grips.
    pub rounds: u32,
    /// Times the servo was lost.
    pub servo_losses: u32,
    /// Time that passed, µs.
    pub passed_us: u64,
    /// The longest time between two feeds of the watchdog, µs.
    pub fast_us: u64,
    /// When the watchdog bites, µs.
    pub bite_us: u64,
}

/// Runs the hour; the same one each time.
pub fn an_hour() -> Hour {
    let mut bench = ready(&Settings { rate_hz: 100, shape_every: 0, ..Settings::of(GEARED_MOUNT) });
    let mut random = ChaCha8Rng::seed_from_u64(6);
    bench.meddling = Box::new(move |_, mut bytes| {
        match random.next_u32() % 500 {
            0 => bytes.clear(),
            1 => bytes.iter_mut().for_each(|byte| *byte = byte.wrapping_add(1)),
            2 => bytes.truncate(5),
            _ => {}
        }
        bytes
    });
    let mut judge = Judge::default();
    bench.keeps = false;
    let mut reached = 0;
    for round in 0..ROUNDS {
        let force = 1.0 + (round % 10) as f32;
        let grip = GripTo { fingers: Which::All, force, speed: None, limit: None };
        bench.ask::<Grip>(&grip).expect("a grip");
        judge.run(&mut bench, 5 * SECOND);
        let [x, y] = bench.servo.truth().force;
        reached += u32::from((x.hypot(y) - f64::from(force)).abs() < f64::max(1.0, 0.1 * f64::from(force)));
        bench.ask::<Open>(&Which::All).expect("an opening");
        judge.run(&mut bench, 5 * SECOND);
    }
    let (fast_us, bite_us) = bench.longest_fast_us();
    let servo_losses = bench.ask::<GetCounters>(&()).servo_losses;
    Hour { judge, reached, rounds: ROUNDS, servo_losses, passed_us: bench.now_us(), fast_us, bite_us }
}

impl Hour {
    /// What was not as it has to be.
    pub fn faults(&self) -> Vec<&'static str> {
        let Self { judge, reached, rounds, servo_losses, passed_us, fast_us, bite_us } = self;
        [
            (*passed_us > 3_600 * SECOND, "less than an hour"),
            (judge.wrong == 0, "a wrong force was marked good"),
            (fast_us < bite_us, "the watchdog would have bitten"),
            (reached + 10 > *rounds, "grips did not reach their force"),
            // An answer in 167 is lost, damaged or cut, or its question.
            (judge.share() > 0.9 * (1.0 - 6.0 / 500.0), "too few sound estimates"),
            // By 30 ticks in a row without an answer: never by chance.
            (*servo_losses == 0, "the servo was lost"),
        ]
        .into_iter()
        .filter_map(|(holds, fault)| (!holds).then_some(fault))
        .collect()
    }
}
