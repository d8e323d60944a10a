//! The part that runs on the target: instructions counted by QEMU, stack by painting, flash as the difference to an image without
//! a model.

use std::io::Read;
use std::path::Path;
use std::process::Stdio;
use std::thread;

use anyhow::{Context, Result, bail};
use fre_log::Log;
use fre_qemu::{Machine, Pace};
use model_core::discretise::Physics;
use object::{Object, ObjectSection, SectionFlags, SectionKind, elf};
use reference_tests::closing::CLOSINGS;

use crate::ladder::{PHYSICS, word};
use crate::pc::{Force, Forces, Model, PAPER, REDUCED, REMEMBERING, RIBS, RUBBING};
use crate::peer::number;
use crate::spread::Spread;

/// The rate of QEMU's clock: an instruction takes 64 ns and a tick of the 25 MHz counter 40 ns.
const PACE: Pace = Pace::CountedWithoutWaiting { shift: 6 };
const INSTRUCTIONS_PER_TICK: f64 = 0.625;
/// Image and what it measures.
const MODELS: [(&str, &str); 5] = [
    ("bench-reduced", REDUCED),
    ("bench-rubbing", RUBBING),
    ("bench-remembering", REMEMBERING),
    ("bench-ribs", RIBS),
    ("bench-paper", PAPER),
];
const EMPTY: &str = "bench-empty";

/// A line of the target's table.
pub struct Row {
    pub model: Model,
    pub mode: String,
    pub hessian: String,
    /// Ticks in contact.
    pub ticks: usize,
    pub failed_ticks: usize,
    pub per_count: Spread,
    pub per_degree: Spread,
    pub iterations_per_count: Spread,
    pub flash_bytes: u64,
    pub static_ram_bytes: u64,
    pub stack_peak_bytes: u64,
    /// Largest difference to the double-precision solution of the same discretisation over the ticks that did not fail, N.
    pub force_error_n: f64,
    /// Cost of derivatives. Known for the mode in which they were taken.
    pub derivatives: Option<Derivatives>,
    /// Ticks whose force is not, bit for bit, the PC's in single precision. Known for the mode the PC ran.
    pub differs_from_pc: Option<usize>,
}

/// What the derivatives with respect to angle, object and modulus cost, in instructions.
#[derive(Clone, Copy)]
pub struct Derivatives {
    /// Equilibria at which there was no room for them.
    pub refused: usize,
    /// One Newton step at the same equilibria, mean.
    pub newton_step: f64,
    pub cost: Spread,
}

/// Runs the images of a folder, side by side, and makes the table.
pub fn measure(images: &Path, forces: &[Forces]) -> Result<Vec<Row>> {
    let empty = flash(&images.join(EMPTY))?;
    let logs = thread::scope(|scope| {
        let runs = MODELS.map(|(image, _)| scope.spawn(move || run(&images.join(image))));
        runs.map(|run| run.join().unwrap_or_else(|_| bail!("the runner itself failed")))
    });
    let mut rows = Vec::new();
    for ((image, model), log) in MODELS.iter().zip(logs) {
        let log = log.with_context(|| format!("image {image}"))?;
        let flash = flash(&images.join(image))?.saturating_sub(empty);
        let (runs, derivatives) = runs(&log)?;
        rows.extend(table(model, flash, &runs, &derivatives, forces)?);
    }
    Ok(rows)
}

/// Runs an image to its end; the messages of its log.
fn run(elf: &Path) -> Result<Vec<String>> {
    let bytes = std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let log = Log::of(&bytes).with_context(|| elf.display().to_string())?;
    let mut machine = Machine::new(elf).pace(PACE).boot(Stdio::piped())?;
    let mut frames = Vec::new();
    machine.output().context("QEMU has no output")?.read_to_end(&mut frames)?;
    let messages: Vec<String> = log.lines(&frames).into_iter().map(|line| line.message).collect();
    match machine.end(None, || Ok(()))? {
        Some(status) if status.success() => Ok(messages),
        status => {
            let status = status.map_or_else(String::new, |status| status.to_string());
            let last = messages.last().map_or("", String::as_str);
            bail!("ended with {status}: {last}; QEMU said: {}", machine.words())
        }
    }
}

/// Bytes that an image takes in flash.
fn flash(elf: &Path) -> Result<u64> {
    let bytes = std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let file = object::File::parse(&*bytes).context("the image is not an ELF file")?;
    let in_flash = |section: &object::Section| {
        let SectionFlags::Elf { sh_flags } = section.flags() else { return false };
        sh_flags & u64::from(elf::SHF_ALLOC) != 0 && section.kind() != SectionKind::UninitializedData
    };
    Ok(file.sections().filter(in_flash).map(|section| section.size()).sum())
}

/// One sweep of the target.
struct Run {
    case: &'static str,
    samples: u8,
    physics: Physics,
    /// Coefficient of friction, in hundredths.
    friction: u32,
    hessian: String,
    mode: String,
    /// `count` or `degree`.
    step: String,
    ram: u64,
    stack: u64,
    ticks: Vec<Tick>,
}

struct Tick {
    position: i32,
    clock: u32,
    iterations: u32,
    trusted: bool,
    touching: bool,
    force: [u32; 2],
}

impl Tick {
    /// In contact. A failed tick is one: without contact nothing can fail.
    fn counts(&self) -> bool {
        self.touching || !self.trusted
    }

    fn instructions(&self) -> f64 {
        f64::from(self.clock) * INSTRUCTIONS_PER_TICK
    }
}

/// Derivatives by case, samples per element and physics.
type ByModel = Vec<((&'static str, u8, Physics), Derivatives)>;

/// A closing's name from a message's words.
fn case_of(words: &[&str]) -> Result<&'static str> {
    let text = words.join(" ");
    let known = CLOSINGS.iter().find(|closing| closing.case == text);
    known.map(|closing| closing.case).with_context(|| format!("`{text}` is not the name of a closing"))
}

/// The physics of a word of the target.
fn physics_of(text: &str) -> Result<Physics> {
    let physics = PHYSICS.into_iter().find(|&physics| word(physics) == text);
    physics.with_context(|| format!("`{text}` is no physics"))
}

/// Reads the target's log: `closing` lines, each followed by its `derivatives` lines and its `run` lines, each followed by its `tick`
/// lines; and `end`.
fn runs(log: &[String]) -> Result<(Vec<Run>, ByModel)> {
    let mut runs: Vec<Run> = Vec::new();
    let mut derivatives = ByModel::new();
    let mut case = None;
    for line in log {
        let words: Vec<&str> = line.split_whitespace().collect();
        match (words.as_slice(), runs.last_mut()) {
            (["closing", words @ ..], _) => case = Some(case_of(words)?),
            (["derivatives", samples, physics, taken, refused, step, clock, most], _) => {
                let mean = |clock: &str| -> Result<f64> {
                    Ok(number::<f64>(clock)? * INSTRUCTIONS_PER_TICK / number::<f64>(taken)?.max(1.0))
                };
                let max = number::<f64>(most)? * INSTRUCTIONS_PER_TICK;
                let found = Derivatives {
                    refused: number(refused)?,
                    newton_step: mean(step)?,
                    cost: Spread { mean: mean(clock)?, max },
                };
                let case = case.context("derivatives before a closing")?;
                derivatives.push(((case, number(samples)?, physics_of(physics)?), found));
            }
            (["run", samples, physics, friction, hessian, mode, step, ram, stack], _) => runs.push(Run {
                case: case.context("a run before a closing")?,
                samples: number(samples)?,
                physics: physics_of(physics)?,
                friction: number(friction)?,
                hessian: (*hessian).to_owned(),
                mode: (*mode).to_owned(),
                step: (*step).to_owned(),
                ram: number(ram)?,
                stack: number(stack)?,
                ticks: Vec::new(),
            }),
            (["tick", position, clock, iterations, trusted, touching, x, y], Some(run)) => run.ticks.push(Tick {
                position: number(position)?,
                clock: number(clock)?,
                iterations: number(iterations)?,
                trusted: number::<u8>(trusted)? != 0,
                touching: number::<u8>(touching)? != 0,
                force: [number(x)?, number(y)?],
            }),
            (["end"], _) => return Ok((runs, derivatives)),
            _ => bail!("the target printed `{line}`"),
        }
    }
    bail!("the target's log has no end")
}

/// Joins the sweeps by counts and by degrees.
fn table(
    name: &'static str,
    flash_bytes: u64,
    runs: &[Run],
    derivatives: &ByModel,
    forces: &[Forces],
) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for run in runs.iter().filter(|run| run.step == "count") {
        let same = |other: &&Run| {
            other.step == "degree"
                && (other.case, other.samples, other.physics, other.friction)
                    == (run.case, run.samples, run.physics, run.friction)
                && (&other.hessian, &other.mode) == (&run.hessian, &run.mode)
        };
        let degrees = runs.iter().find(same).context("a sweep by counts without one by degrees")?;
        let Run { case, samples, physics, friction, .. } = *run;
        let model = Model { case, name, samples, physics, friction };
        let forces = forces.iter().find(|forces| forces.model == model);
        let forces = &forces.with_context(|| format!("no forces from the PC for {model:?}"))?.ticks;
        let contact = || run.ticks.iter().filter(|tick| tick.counts());
        let newton = run.hessian == "newton" && run.mode == "converged";
        rows.push(Row {
            mode: run.mode.clone(),
            hessian: run.hessian.clone(),
            ticks: contact().count(),
            failed_ticks: contact().filter(|tick| !tick.trusted).count(),
            per_count: Spread::of(contact().map(Tick::instructions)),
            per_degree: Spread::of(degrees.ticks.iter().filter(|tick| tick.counts()).map(Tick::instructions)),
            iterations_per_count: Spread::of(contact().map(|tick| f64::from(tick.iterations))),
            flash_bytes,
            static_ram_bytes: run.ram,
            stack_peak_bytes: run.stack.max(degrees.stack),
            force_error_n: error(&run.ticks, forces)?,
            derivatives: derivatives
                .iter()
                .find(|(model, _)| newton && *model == (case, samples, physics))
                .map(|(_, derivatives)| *derivatives),
            differs_from_pc: newton
                .then(|| run.ticks.iter().zip(forces).filter(|(tick, pc)| tick.force != pc.single).count()),
            model,
        });
    }
    Ok(rows)
}

/// Largest distance between the target's forces and the double-precision ones, N.
fn error(ticks: &[Tick], forces: &[Force]) -> Result<f64> {
    let mut most = 0.0_f64;
    if ticks.len() != forces.len() {
        bail!("{} ticks on the target, {} on the PC", ticks.len(), forces.len());
    }
    for (tick, exact) in ticks.iter().zip(forces) {
        if tick.position != exact.position {
            bail!("the sweeps of target and PC differ");
        }
        if tick.trusted {
            let [x, y] = tick.force.map(|bits| f64::from(f32::from_bits(bits)));
            let distance = (x - exact.double[0]).hypot(y - exact.double[1]);
            // `max` would drop a NaN.
            if !distance.is_finite() {
                bail!("the target's force at count {} is not finite", tick.position);
            }
            most = most.max(distance);
        }
    }
    Ok(most)
}

#[cfg(test)]
mod tests {
    use reference_tests::closing::LADDER;

    use super::*;

    fn log(lines: &[&str]) -> Vec<String> {
        lines.iter().map(|line| (*line).to_owned()).collect()
    }

    fn forces() -> Vec<Forces> {
        let model = Model { case: LADDER.case, name: REDUCED, samples: 4, physics: Physics::Paper, friction: 0 };
        let force =
            |position, double: [f64; 2]| Force { position, double, single: double.map(|x| (x as f32).to_bits()) };
        vec![Forces { model, ticks: vec![force(0, [0.0, 0.0]), force(1, [1.0, 0.0]), force(0, [0.5, 0.0])] }]
    }

    /// Forces 0, 1.25 (bits 1067450368) and, failed, 8 (1090519040).
    const LINES: [&str; 9] = [
        "closing ladder-80 R40-Mid",
        "run 4 paper 0 newton converged count 1000 200",
        "tick 0 1000 0 1 0 0 0",
        "tick 1 1600 2 1 1 1067450368 0",
        "tick 0 3200 8 0 0 1090519040 0",
        "run 4 paper 0 newton converged degree 1000 300",
        "tick 0 8000 4 1 1 0 0",
        "derivatives 4 paper 2 1 3200 1600 1000",
        "end",
    ];

    #[test]
    fn sweeps_become_a_row() {
        let (runs, derivatives) = runs(&log(&LINES)).unwrap();
        let rows = table(REDUCED, 7, &runs, &derivatives, &forces()).unwrap();
        let [row] = rows.as_slice() else { panic!("{} rows", rows.len()) };
        assert_eq!(
            (row.ticks, row.failed_ticks),
            (2, 1),
            "the tick without contact does not count, the failed one does"
        );
        assert_eq!((row.per_count.mean, row.per_count.max), (1500.0, 2000.0));
        assert_eq!(row.per_degree.mean, 5000.0);
        assert_eq!((row.iterations_per_count.mean, row.iterations_per_count.max), (5.0, 8.0));
        assert_eq!((row.flash_bytes, row.static_ram_bytes, row.stack_peak_bytes), (7, 1000, 300));
        assert_eq!(row.force_error_n, 0.25, "the failed tick's force is not judged");
        assert_eq!(row.differs_from_pc, Some(2));
        let derivatives = row.derivatives.unwrap();
        assert_eq!((derivatives.refused, derivatives.newton_step), (1, 1000.0));
        assert_eq!((derivatives.cost.mean, derivatives.cost.max), (500.0, 625.0));
    }

    #[test]
    fn a_log_that_breaks_off_is_an_error() {
        assert!(runs(&log(&LINES[..8])).is_err());
        assert!(runs(&log(&LINES[1..])).is_err(), "a run before its closing");
        assert!(runs(&log(&["closing ladder-90"])).is_err());
        assert!(runs(&log(&["tick 0 1 0 1 0 0 0"])).is_err(), "a tick before its run");
        assert!(runs(&log(&["(a damaged line)"])).is_err());
    }

    #[test]
    fn another_sweep_or_no_number_is_an_error() {
        let mut lines = LINES;
        lines[3] = "tick 2 1600 2 1 1 1067450368 0";
        let refused = |lines: &[&str]| {
            let (runs, derivatives) = runs(&log(lines)).unwrap();
            table(REDUCED, 7, &runs, &derivatives, &forces()).is_err()
        };
        assert!(refused(&lines));
        lines[3] = "tick 1 1600 2 1 1 2143289344 0"; // NaN
        assert!(refused(&lines));
    }
}
