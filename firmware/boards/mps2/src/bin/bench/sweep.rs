//! The measured sweep: a finger that closes on an object from touch on and opens again, and a record of every tick.

use model_core::discretise::{Discretisation, DiscretiseError, Physics};
use model_core::equilibrium::{Follower, Settings, Target, Tracking};
use model_core::newton::Hessian;
use model_core::size::Size;
use mps2::{Exit, cycles, stack};
use reference_tests::closing::{Closing, LADDER, MOST_TICKS};
use reference_tests::{TERMS, TICK_S};
use static_cell::ConstStaticCell;

/// Newton iterations allowed per tick. Newton's method needs 2 or 3; Gauss–Newton, where it fails, would go on for ever.
const BUDGET: u32 = 100;

/// What one tick cost and gave.
#[derive(Clone, Copy)]
struct Tick {
    position: i32,
    clock: u32,
    iterations: u32,
    trusted: bool,
    touching: bool,
    force: [f32; 2],
}

const BLANK: Tick = Tick { position: 0, clock: 0, iterations: 0, trusted: false, touching: false, force: [0.0; 2] };

static RECORD: ConstStaticCell<[Tick; MOST_TICKS]> = ConstStaticCell::new([BLANK; MOST_TICKS]);

/// Samples per element, and the model with them.
pub type Model = (u8, fn(Physics) -> Discretisation);

/// What is measured of a size.
#[derive(Clone, Copy)]
pub struct Cases<'a> {
    pub closings: &'a [Closing],
    pub models: &'a [Model],
    pub physics: &'a [Physics],
    /// Coefficients of friction, in hundredths.
    pub frictions: &'a [u32],
}

impl Cases<'static> {
    /// Both physics, without friction.
    // Each image has a size of its own, and not every one these cases.
    #[allow(dead_code)]
    pub const fn without_friction(models: &'static [Model]) -> Self {
        Self { closings: &[LADDER], models, physics: &[Physics::Paper, Physics::Extended], frictions: &[0] }
    }
}

/// How a tick is followed.
#[derive(Clone, Copy)]
enum Mode {
    Converged,
    OneIteration,
}

impl Mode {
    fn word(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::OneIteration => "one-iteration",
        }
    }
}

const MODES: [(Hessian, &str, Mode); 3] = [
    (Hessian::Newton, "newton", Mode::Converged),
    (Hessian::GaussNewton, "gauss-newton", Mode::Converged),
    (Hessian::Newton, "newton", Mode::OneIteration),
];

/// Runs every case and ends QEMU.
pub fn run<S: Size>(follower: &mut Follower<f32, S>, cases: Cases<'_>) -> ! {
    let record = RECORD.take();
    let ram = Follower::<f32, S>::STATE_BYTES;
    for closing in cases.closings {
        defmt::println!("closing {=str}", closing.case);
        for (samples, discretisation) in cases.models {
            for physics in cases.physics {
                for friction in cases.frictions {
                    run_case(follower, closing, (*samples, *discretisation, *physics, *friction), ram, record);
                }
            }
        }
    }
    defmt::println!("end");
    mps2::exit(Exit::Success)
}

/// Runs a case in every mode: where the force depends on the path in one only, as every other is the same then.
fn run_case<S: Size>(
    follower: &mut Follower<f32, S>,
    closing: &Closing,
    (samples, discretisation, physics, friction): (u8, fn(Physics) -> Discretisation, Physics, u32),
    ram: usize,
    record: &mut [Tick; MOST_TICKS],
) {
    let physics_word = match physics {
        Physics::Paper => "paper",
        Physics::Extended => "extended",
    };
    let depends_on_the_path = S::RUBS || S::TERMS > 0;
    if follower.set_friction(f64::from(friction) * 0.01).is_err() {
        defmt::println!("refused: the size has no room for friction");
        mps2::exit(Exit::Failure)
    }
    if follower.set_prony(TERMS.get(..S::TERMS).unwrap_or_default()).is_err() {
        defmt::println!("refused: the size has no room for memory");
        mps2::exit(Exit::Failure)
    }
    if !depends_on_the_path {
        match derivatives(follower, closing, &discretisation(physics)) {
            Ok(found) => defmt::println!(
                "derivatives {=u8} {=str} {=u32} {=u32} {=u64} {=u64} {=u32}",
                samples,
                physics_word,
                found.taken,
                found.refused,
                found.step_clock,
                found.clock,
                found.most
            ),
            Err(_) => defmt::println!("the derivatives' model was refused"),
        }
    }
    for (hessian, hessian_word, mode) in MODES.into_iter().take(if depends_on_the_path { 1 } else { MODES.len() }) {
        let how = discretisation(physics);
        let settings = Settings { hessian, max_iterations: BUDGET, ..Settings::DEFAULT };
        if follower.set_settings(settings).is_err() {
            defmt::println!("refused: the settings are not allowed");
            mps2::exit(Exit::Failure)
        }
        for (steps, step_word) in [(closing.count, "count"), (closing.step, "degree")] {
            let (result, peak) = stack::peak_of(|| sweep(follower, closing, &how, mode, steps, record));
            let ticks = match result {
                Ok(ticks) => ticks,
                Err(_) => {
                    defmt::println!("refused: the model does not fit");
                    mps2::exit(Exit::Failure)
                }
            };
            defmt::println!(
                "run {=u8} {=str} {=u32} {=str} {=str} {=str} {=usize} {=usize}",
                samples,
                physics_word,
                friction,
                hessian_word,
                mode.word(),
                step_word,
                ram,
                peak
            );
            for tick in ticks {
                defmt::println!(
                    "tick {=i32} {=u32} {=u32} {=u8} {=u8} {=u32} {=u32}",
                    tick.position,
                    tick.clock,
                    tick.iterations,
                    tick.trusted as u8,
                    tick.touching as u8,
                    tick.force[0].to_bits(),
                    tick.force[1].to_bits()
                );
            }
        }
    }
}

/// From touch to the last position and back, a step at a time; nothing is logged meanwhile.
// Not inlined: its own frame belongs to the stack that is measured.
#[inline(never)]
fn sweep<'a, S: Size>(
    follower: &mut Follower<f32, S>,
    closing: &Closing,
    how: &Discretisation,
    mode: Mode,
    steps: (f64, i32),
    record: &'a mut [Tick],
) -> Result<&'a [Tick], DiscretiseError> {
    configure(follower, closing, how)?;
    let mut used = 0;
    for (entry, position) in record.iter_mut().zip(Closing::ticks(steps)) {
        let coordinate = f64::from(position) * steps.0;
        let (outcome, clock) = cycles::of(|| match mode {
            Mode::Converged => follower.follow_within(Target { coordinate, time_step_s: TICK_S }, BUDGET),
            Mode::OneIteration => follower.track(coordinate, Tracking::DEFAULT, BUDGET),
        });
        *entry = Tick {
            position,
            clock,
            iterations: outcome.iterations,
            trusted: outcome.status.is_trustworthy(),
            touching: follower.solution().touching() > 0,
            force: follower.solution().force_world(),
        };
        used += 1;
    }
    Ok(record.get(..used).unwrap_or_default())
}

/// The finger at touch.
fn configure<S: Size>(
    follower: &mut Follower<f32, S>,
    closing: &Closing,
    how: &Discretisation,
) -> Result<(), DiscretiseError> {
    let design = (closing.design)();
    follower.configure(&design, how)?;
    follower.set_object((closing.object)(), closing.motion(&design));
    follower.start(0.0);
    Ok(())
}

/// Cost of derivatives beside that of a Newton step, in ticks of the clock.
struct Derivatives {
    /// Equilibria in contact at which they were taken, and at which there was no room.
    taken: u32,
    refused: u32,
    /// Sums over those of one Newton step, and of the derivatives; the most expensive.
    step_clock: u64,
    clock: u64,
    most: u32,
}

/// Derivatives with respect to angle, object and modulus at every count on the way to the last position. A Newton step is what a
/// tick costs beyond an evaluation at its result, over its iterations.
#[inline(never)]
fn derivatives<S: Size>(
    follower: &mut Follower<f32, S>,
    closing: &Closing,
    how: &Discretisation,
) -> Result<Derivatives, DiscretiseError> {
    configure(follower, closing, how)?;
    follower.set_hessian(Hessian::Newton);
    let mut sums = Derivatives { taken: 0, refused: 0, step_clock: 0, clock: 0, most: 0 };
    let (count, last) = closing.count;
    for position in 0..=last {
        let coordinate = f64::from(position) * count;
        let (outcome, tick) = cycles::of(|| follower.follow_within(coordinate, BUDGET));
        let (_, evaluation) = cycles::of(|| follower.follow_within(coordinate, BUDGET));
        let (found, clock) = cycles::of(|| follower.sensitivity());
        if follower.solution().touching() == 0 || outcome.iterations == 0 {
            continue;
        }
        if found.is_none() {
            sums.refused += 1;
            continue;
        }
        sums.taken += 1;
        sums.step_clock += u64::from(tick.saturating_sub(evaluation) / outcome.iterations);
        sums.clock += u64::from(clock);
        sums.most = sums.most.max(clock);
    }
    Ok(sums)
}
