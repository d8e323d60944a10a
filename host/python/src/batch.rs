//! Many cases at once: one case with many values of its numbers.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use fre::case::Document;
use fre::study::model::Options;
use fre::study::run;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::case::{Case, Changes};
use crate::error::{case_error, of_case, of_discretise, value};
use crate::options::Words;
use crate::signals::in_pool;
use crate::solved::Solved;

/// Most threads.
const MOST_THREADS: usize = 1024;

/// A number of threads as Python has given it, 0 for one per core.
pub(crate) fn checked_threads(threads: i64) -> PyResult<usize> {
    let allowed = usize::try_from(threads).ok().filter(|threads| *threads <= MOST_THREADS);
    let why = || format!("threads = {threads}: allowed is 0 to {MOST_THREADS}");
    allowed.ok_or_else(|| case_error(why(), Some("threads"), None))
}

/// Threads of a batch.
fn pool(threads: i64) -> PyResult<rayon::ThreadPool> {
    let threads = checked_threads(threads)?;
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| value(error.to_string()))
}

/// The cases of a batch: one per row of values, the columns being keys.
struct Batch {
    document: Arc<Document>,
    keys: Arc<[String]>,
    rows: Vec<Arc<[f64]>>,
    options: Options,
    pool: rayon::ThreadPool,
}

impl Batch {
    fn new(
        case: &Case,
        keys: Vec<String>,
        values: &PyReadonlyArray2<'_, f64>,
        options: &Words,
        threads: i64,
    ) -> PyResult<Self> {
        let document = case.document();
        for key in &keys {
            document.need(key).map_err(|error| case_error(error.to_string(), Some(key), None))?;
        }
        let rows = values.as_array().rows().into_iter().map(|row| row.to_vec().into()).collect();
        Ok(Self { document, keys: keys.into(), rows, options: options.options()?, pool: pool(threads)? })
    }

    /// The case of a row, by a document that the rows of a thread are written into one after the other.
    fn case(&self, document: &mut Document, index: usize) -> PyResult<Case> {
        let numbers = self.rows.get(index).cloned().unwrap_or_default();
        let changes = Changes { keys: self.keys.clone(), numbers };
        changes.set(document);
        let case = document.case().map_err(|error| {
            let words = Python::attach(|py| of_case(&error, false).value(py).to_string());
            case_error(format!("at index {index}: {words}"), error.key(), None)
        })?;
        Ok(Case::changed(self.document.clone(), changes, case))
    }
}

/// Solves a case once per row of values, in parallel; the columns are its keys. A result's status is never an error, a value that
/// the case refuses is.
#[pyfunction]
pub(crate) fn solve_many(
    py: Python<'_>,
    case: &Case,
    keys: Vec<String>,
    values: PyReadonlyArray2<'_, f64>,
    options: Words,
    threads: i64,
) -> PyResult<Vec<Solved>> {
    let batch = Batch::new(case, keys, &values, &options, threads)?;
    py.detach(|| {
        in_pool(&batch.pool, |stop| {
            let look = || if stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
            let solve = |document: &mut Document, index| Solved::of(batch.case(document, index)?, &batch.options, look);
            let rows = (0..batch.rows.len()).into_par_iter();
            rows.with_max_len(4).map_init(|| (*batch.document).clone(), solve).collect()
        })
    })
}

/// The cases of a batch, made already: what [`solve_many`] is held against.
#[pyclass(frozen, module = "fre._core")]
pub(crate) struct Made {
    cases: Vec<Case>,
    options: Options,
    pool: rayon::ThreadPool,
}

#[pymethods]
impl Made {
    /// Makes them; the arguments are those of [`solve_many`].
    #[new]
    fn new(
        case: &Case,
        keys: Vec<String>,
        values: PyReadonlyArray2<'_, f64>,
        options: Words,
        threads: i64,
    ) -> PyResult<Self> {
        let batch = Batch::new(case, keys, &values, &options, threads)?;
        let mut document = (*batch.document).clone();
        let cases = (0..batch.rows.len()).map(|index| batch.case(&mut document, index)).collect::<PyResult<_>>()?;
        Ok(Self { cases, options: batch.options, pool: batch.pool })
    }

    /// Solves them and keeps nothing: the solver alone.
    fn solve(&self, py: Python<'_>) -> PyResult<()> {
        let solve = |case: &Case| run::solve(&case.case, &self.options).map_err(|error| of_discretise(&error));
        py.detach(|| {
            self.pool.install(|| self.cases.par_iter().with_max_len(1).try_for_each(|case| solve(case).map(drop)))
        })
    }
}
