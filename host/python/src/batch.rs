//! Many cases at once: one case with many values of its numbers.

use std::sync::Arc;
use std::time::Instant;

use fre::case::Document;
use fre::study::model::Options;
use fre::study::run;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::case::Case;
use crate::error::{case_error, of_case, of_discretise, value};
use crate::options::Words;
use crate::solved::Solved;

/// Most threads.
const MOST_THREADS: usize = 1024;

/// Threads of a batch, 0 for one per core.
pub(crate) fn pool(threads: usize) -> PyResult<rayon::ThreadPool> {
    if threads > MOST_THREADS {
        return Err(case_error(format!("threads = {threads}: allowed is 0 to {MOST_THREADS}"), Some("threads"), None));
    }
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| value(error.to_string()))
}

/// The cases of a batch: one per row of values, the columns being keys.
struct Batch {
    document: Arc<Document>,
    keys: Vec<String>,
    rows: Vec<Vec<f64>>,
    options: Options,
    pool: rayon::ThreadPool,
}

impl Batch {
    fn new(
        case: &Case,
        keys: Vec<String>,
        values: &PyReadonlyArray2<'_, f64>,
        options: &Words,
        threads: usize,
    ) -> PyResult<Self> {
        for key in &keys {
            case.document.need(key).map_err(|error| case_error(error.to_string(), Some(key), None))?;
        }
        let rows = values.as_array().rows().into_iter().map(|row| row.to_vec()).collect();
        let document = case.document.clone();
        Ok(Self { document, keys, rows, options: options.options()?, pool: pool(threads)? })
    }

    /// The case of a row.
    fn case(&self, index: usize) -> PyResult<Case> {
        let mut document = (*self.document).clone();
        for (key, &number) in self.keys.iter().zip(self.rows.get(index).into_iter().flatten()) {
            document.set(key, number).map_err(|error| case_error(error.to_string(), Some(key), None))?;
        }
        let case = document.case().map_err(|error| {
            let words = Python::attach(|py| of_case(&error, false).value(py).to_string());
            case_error(format!("at index {index}: {words}"), error.key(), None)
        })?;
        Ok(Case { document: Arc::new(document), case: Arc::new(case) })
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
    threads: usize,
) -> PyResult<Vec<Solved>> {
    let batch = Batch::new(case, keys, &values, &options, threads)?;
    py.detach(|| {
        batch.pool.install(|| {
            let solve = |index| Solved::of(batch.case(index)?, &batch.options);
            (0..batch.rows.len()).into_par_iter().with_max_len(1).map(solve).collect()
        })
    })
}

/// Seconds that the solver alone takes for a batch, its cases being there already: what [`solve_many`] is held against.
#[pyfunction]
pub(crate) fn time_many(
    py: Python<'_>,
    case: &Case,
    keys: Vec<String>,
    values: PyReadonlyArray2<'_, f64>,
    options: Words,
    threads: usize,
) -> PyResult<f64> {
    let batch = Batch::new(case, keys, &values, &options, threads)?;
    py.detach(|| {
        let cases = (0..batch.rows.len()).map(|index| batch.case(index)).collect::<PyResult<Vec<Case>>>()?;
        let begin = Instant::now();
        batch.pool.install(|| {
            let solve = |case: &Case| run::solve(&case.case, &batch.options).map_err(|error| of_discretise(&error));
            cases.par_iter().with_max_len(1).try_for_each(|case| solve(case).map(drop))
        })?;
        Ok(begin.elapsed().as_secs_f64())
    })
}
