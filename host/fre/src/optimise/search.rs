//! The search: SLSQP from the case as it is and from further starts.

use std::cell::{Cell, RefCell};
use std::ops::ControlFlow;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use serde::{Deserialize, Serialize};
use slsqp::{StopTols, SuccessStatus, minimize};

use super::problem::{Functions, Problem};

/// How much of a limit may be missing, as a share of its bound: the rounding of a search.
pub const KEPT: f64 = 1e-6;
/// How a search ends that was stopped.
pub(super) const STOPPED: &str = "stopped";
/// Draws of a start until its finger can be made and reaches its goal.
const DRAWS: usize = 50;
/// Points that are remembered: goal, limits and their slopes are asked for one after the other.
const REMEMBERED: usize = 8;

/// How a search goes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Starts: the case as it is, and random ones.
    pub starts: usize,
    /// What the random ones depend on.
    pub seed: u64,
    /// Most evaluations of the goal per start.
    pub most: usize,
    /// Change of the goal, as a share of it, and of the variables, as a share of their range, at which a search ends.
    pub tolerance: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { starts: 4, seed: 0, most: 100, tolerance: 1e-5 }
    }
}

/// What came of a start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Try {
    /// Variables from 0 to 1 where it began.
    pub start: Vec<f64>,
    /// The best that it found: those that keep all limits come first.
    pub x: Vec<f64>,
    /// The goal there, its sign changed if it shall be large.
    pub value: f64,
    /// The smallest margin of a limit there; negative where one is broken.
    pub kept: f64,
    /// How it ended.
    pub ended: String,
}

impl Try {
    /// All limits are kept.
    pub fn keeps(&self) -> bool {
        self.kept >= -KEPT
    }

    /// Better than another one.
    fn beats(&self, other: &Self) -> bool {
        match (self.keeps(), other.keeps()) {
            (true, false) => true,
            (false, true) => false,
            (true, true) => self.value < other.value,
            // Nearer to what is allowed.
            (false, false) => self.kept > other.kept,
        }
    }
}

/// The best of several tries.
pub fn best(tries: &[Try]) -> Option<&Try> {
    tries.iter().reduce(|best, next| if next.beats(best) { next } else { best })
}

/// The variables at which a start begins; the same for the same seed and number.
pub fn start(problem: &Problem, seed: u64, number: usize) -> Vec<f64> {
    if number == 0 {
        return problem.own();
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(number as u64);
    let mut unit = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let mut drawn = Vec::new();
    for _ in 0..DRAWS {
        drawn = problem.variables().iter().map(|_| unit()).collect();
        if problem.values(&drawn).goal.is_some() {
            break;
        }
    }
    drawn
}

/// Searches from some variables on. `watch` is called after every evaluation with their number and the best so far; it ends the
/// search by [`ControlFlow::Break`].
pub fn search(
    problem: &Problem,
    start: &[f64],
    settings: &Settings,
    watch: &mut dyn FnMut(usize, &Try) -> ControlFlow<()>,
) -> Try {
    let first = problem.functions(start, false);
    let (goal, margins) = first.values.split_first().map_or((0.0, &[][..]), |(goal, margins)| (*goal, margins));
    let scale = goal.abs().max(1e-9);
    let count = margins.len();
    let kept = |values: &[f64]| values.iter().skip(1).copied().fold(f64::INFINITY, f64::min).min(1e9);
    let seen = |x: &[f64], values: &[f64]| Try {
        start: start.to_vec(),
        x: x.to_vec(),
        value: values.first().copied().unwrap_or(0.0),
        kept: kept(values),
        ended: String::new(),
    };
    let best = RefCell::new(seen(start, &first.values));
    let remembered: RefCell<Vec<(Vec<f64>, Functions)>> = RefCell::new(Vec::new());
    let (evaluations, stopped) = (Cell::new(0), Cell::new(false));
    // The optimiser must not leave the bounds, even by a rounding.
    let inside = |x: &[f64]| x.iter().map(|x| x.clamp(0.0, 1.0)).collect::<Vec<f64>>();
    let ask = |x: &[f64], slopes: bool| -> Functions {
        let x = inside(x);
        let mut known = remembered.borrow_mut();
        let fits = |(at, functions): &&(Vec<f64>, Functions)| *at == x && (!slopes || !functions.slopes.is_empty());
        if let Some((_, functions)) = known.iter().find(fits) {
            return functions.clone();
        }
        let functions = problem.functions(&x, slopes);
        let this = seen(&x, &functions.values);
        if this.beats(&best.borrow()) {
            *best.borrow_mut() = this;
        }
        if known.len() >= REMEMBERED {
            known.remove(0);
        }
        known.push((x, functions.clone()));
        functions
    };
    let function = |x: &[f64], slope: Option<&mut [f64]>, index: usize, factor: f64| -> f64 {
        if stopped.get() {
            // Flat: there is nothing more to find.
            if let Some(slope) = slope {
                slope.fill(0.0);
            }
            return 0.0;
        }
        let found = ask(x, slope.is_some());
        if let (Some(slope), Some(row)) = (slope, found.slopes.get(index)) {
            for (into, value) in slope.iter_mut().zip(row) {
                *into = factor * value;
            }
        }
        factor * found.values.get(index).copied().unwrap_or(0.0)
    };
    let watch = RefCell::new(watch);
    let objective = |x: &[f64], slope: Option<&mut [f64]>, (): &mut ()| {
        let value = function(x, slope, 0, 1.0 / scale);
        evaluations.set(evaluations.get() + 1);
        if !stopped.get() && (watch.borrow_mut())(evaluations.get(), &best.borrow()).is_break() {
            stopped.set(true);
        }
        value
    };
    let function = &function;
    let limits: Vec<_> = (1..=count)
        .map(|index| move |x: &[f64], slope: Option<&mut [f64]>, (): &mut ()| function(x, slope, index, -1.0))
        .collect();
    let bounds = vec![(0.0, 1.0); start.len()];
    let tolerances = StopTols {
        ftol_rel: settings.tolerance,
        xtol_abs: vec![settings.tolerance; start.len()],
        ..StopTols::default()
    };
    let ended = match minimize(objective, &inside(start), &bounds, &limits, (), settings.most, Some(tolerances)) {
        Ok((SuccessStatus::MaxEvalReached, ..)) => "most evaluations reached",
        Ok(_) => "converged",
        // No step that lowers the goal within the limits: the end, where goal or limits have a kink.
        Err(_) => "no better step",
    };
    let mut found = best.into_inner();
    found.ended = if stopped.get() { STOPPED } else { ended }.to_owned();
    found
}
