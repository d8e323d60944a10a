//! The search from every start that a log does not have yet.

use std::ops::ControlFlow;

use super::error::OptimiseError;
use super::log::Log;
use super::problem::Problem;
use super::search::{STOPPED, Settings, Try, search, start};

/// How far a search is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Starts that are done.
    pub done: usize,
    /// All starts.
    pub starts: usize,
    /// Evaluations of this start.
    pub evaluations: usize,
    /// The best goal so far that keeps all limits, as a measure.
    pub best: Option<f64>,
}

/// Searches from all starts that the log does not have yet; gives the tries in the order of the starts.
///
/// # Errors
/// The log cannot be written, or `watch` has stopped the search: finished starts are kept.
pub fn optimise(
    problem: &Problem,
    settings: &Settings,
    log: &mut Log,
    watch: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<Vec<Try>, OptimiseError> {
    let starts: Vec<_> =
        (0..settings.starts.max(1)).map(|number| move || start(problem, settings.seed, number)).collect();
    named("", problem, &starts, settings, log, watch)
}

/// The same from given starts, under a name in the log.
pub(super) fn named(
    name: &str,
    problem: &Problem,
    starts: &[impl Fn() -> Vec<f64>],
    settings: &Settings,
    log: &mut Log,
    mut watch: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<Vec<Try>, OptimiseError> {
    for (done, start) in starts.iter().enumerate().skip(log.tries(name).len()) {
        let known: Vec<Try> = log.tries(name).to_vec();
        let mut tell = |done: usize, evaluations: usize, this: Option<&Try>| {
            let all = known.iter().chain(this).filter(|one| one.keeps());
            let best = all.map(|one| one.value).min_by(f64::total_cmp).map(|value| problem.goal().sign() * value);
            watch(Progress { done, starts: starts.len(), evaluations, best })
        };
        let found = search(problem, &start(), settings, &mut |evaluations, this| tell(done, evaluations, Some(this)));
        if found.ended == STOPPED {
            return Err(OptimiseError::Stopped);
        }
        let told = tell(done + 1, 0, Some(&found));
        log.add(name, found)?;
        if told.is_break() {
            return Err(OptimiseError::Stopped);
        }
    }
    Ok(log.tries(name).iter().take(starts.len()).cloned().collect())
}
