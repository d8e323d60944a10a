//! The twenty cases solved with every variant of the model.

use std::ops::ControlFlow;

use model_core::status::Status;

use super::error::Table1Error;
use super::row::Row;
use super::series::{SERIES, Series};
use super::variant::{Variant, variants};
use crate::study::model::Options;
use crate::study::run::{self, Run, Unsolved};

/// Runs of each path; the fastest time counts, the others were held up by something else.
const RUNS: usize = 3;

/// How far the table is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Paths solved: each series is one for each variant, and is solved several times for its time.
    pub done: usize,
    /// All paths.
    pub total: usize,
    /// The series that is being solved.
    pub series: Series,
    /// The variant that is solving it.
    pub variant: Variant,
}

/// Solves the twenty cases with every variant, one after the other so that the times mean something.
///
/// # Errors
/// None with the fingers that come with the program.
pub fn solve() -> Result<Vec<Row>, Table1Error> {
    solve_watched(|_| ControlFlow::Continue(()))
}

/// As [`solve`], calling `watch` after every place of a path; it stops the work by [`ControlFlow::Break`].
///
/// # Errors
/// The work was stopped; none else with the fingers that come with the program.
pub fn solve_watched(mut watch: impl FnMut(Progress) -> ControlFlow<()>) -> Result<Vec<Row>, Table1Error> {
    let mut rows = Vec::new();
    let total = SERIES.len() * variants().len() * RUNS;
    let mut done = 0;
    for series in SERIES {
        let case = series.case()?;
        let mut runs = Vec::new();
        for variant in variants() {
            let options = Options { discretisation: variant.discretisation, ..Options::default() };
            let mut again = || {
                let solved = run::solve_watched(&case, &options, |_| watch(Progress { done, total, series, variant }));
                done += 1;
                solved.map_err(|error| match error {
                    Unsolved::Discretise(error) => Table1Error::Discretise(error),
                    Unsolved::Stopped(()) => Table1Error::Stopped,
                })
            };
            let mut run = again()?;
            for _ in 1..RUNS {
                for (kept, place) in run.places.iter_mut().zip(again()?.places) {
                    kept.effort.elapsed_us = kept.effort.elapsed_us.min(place.effort.elapsed_us);
                }
            }
            runs.push(run);
        }
        for angle in 0..series.angles_deg.len() {
            let upto = |run: &Run| run.places.iter().take(angle + 2).any(|place| place.status == Status::Snapped);
            rows.push(Row {
                series,
                angle,
                case: case.clone(),
                // The first place of the path is the start without contact.
                runs: runs.iter().filter_map(|run| run.only(angle + 1)).collect(),
                snapped: runs.iter().map(upto).collect(),
            });
        }
    }
    Ok(rows)
}
