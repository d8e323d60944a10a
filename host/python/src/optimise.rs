//! Design problems: goals and limits by their words, their functions, searches and fronts. Tries and reports pass as JSON.

use std::ops::ControlFlow;
use std::path::PathBuf;

use fre::draw;
use fre::optimise::{
    self as library, Goal, Limit, Log, Measure, OptimiseError, ProblemError, Progress, Report, Settings, Try, Variable,
};
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::{PyFileExistsError, PyOSError};
use pyo3::prelude::*;

use crate::case::Case;
use crate::error::{case_error, of_case, of_discretise, value};
use crate::options::Words;

/// A design problem.
#[pyclass(frozen, module = "fre._core")]
pub(crate) struct Problem(library::Problem);

/// How a search goes, as Python has it: starts, seed, most evaluations, tolerance.
type Search = (usize, u64, usize, f64);

fn settings((starts, seed, most, tolerance): Search) -> Settings {
    Settings { starts, seed, most, tolerance }
}

fn refused(error: &ProblemError) -> PyErr {
    match error {
        ProblemError::NoVariables => case_error("vary: at least one key with its bounds is needed", Some("vary"), None),
        ProblemError::Key(error) => case_error(error.to_string(), Some(error.key()), None),
        ProblemError::Case(error) => of_case(error, false),
        ProblemError::Discretise(error) => of_discretise(error),
        ProblemError::Object { error, .. } => refused(error),
        ProblemError::Friction => case_error(format!("vary: {error}"), Some("object.friction"), None),
        ProblemError::Twice { key } => case_error(format!("vary: {error}"), Some(key), None),
        ProblemError::GivenTwice { key } | ProblemError::Varied { key } => {
            case_error(format!("objects: {error}"), Some(key), None)
        }
        ProblemError::Beyond { .. } => value(error.to_string()),
    }
}

fn failed(error: OptimiseError) -> PyErr {
    match error {
        OptimiseError::Problem(error) => refused(&error),
        OptimiseError::Log { .. } if error.to_string().contains("another problem") => {
            PyFileExistsError::new_err(error.to_string())
        }
        error => PyOSError::new_err(error.to_string()),
    }
}

fn json(data: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(data).map_err(|error| value(error.to_string()))
}

/// Reads tries.
fn tries(text: &str) -> PyResult<Vec<Try>> {
    serde_json::from_str(text).map_err(|error| value(error.to_string()))
}

/// Reports progress to Python, where an exception stops the search.
struct Listener {
    progress: Option<Py<PyAny>>,
    raised: Option<PyErr>,
}

impl Listener {
    fn tell(&mut self, now: Progress) -> ControlFlow<()> {
        let told = Python::attach(|py| {
            py.check_signals()?;
            match &self.progress {
                Some(progress) if now.evaluations == 0 => {
                    progress.call1(py, (now.done, now.starts, now.best.unwrap_or(f64::NAN))).map(drop)
                }
                _ => Ok(()),
            }
        });
        match told {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.raised = Some(error);
                ControlFlow::Break(())
            }
        }
    }

    fn end<X>(self, found: Result<X, OptimiseError>) -> PyResult<X> {
        match self.raised {
            Some(error) => Err(error),
            None => found.map_err(failed),
        }
    }
}

#[pymethods]
impl Problem {
    #[new]
    fn new(
        case: &Case,
        vary: Vec<(String, f64, f64)>,
        goal: &str,
        limits: Vec<(String, f64, f64)>,
        objects: Vec<Vec<(String, f64)>>,
        options: Words,
    ) -> PyResult<Self> {
        let variable = |(key, least, most): (String, f64, f64)| {
            Variable::new(&key, least, most).map_err(|error| case_error(format!("vary: {error}"), Some(&key), None))
        };
        let limit = |(words, least, most): (String, f64, f64)| -> PyResult<Limit> {
            let bound = |bound: f64| bound.is_finite().then_some(bound);
            Ok(Limit {
                measure: words.parse().map_err(|error: String| value(error))?,
                least: bound(least),
                most: bound(most),
            })
        };
        let vary = vary.into_iter().map(variable).collect::<PyResult<Vec<_>>>()?;
        let goal: Goal = goal.parse().map_err(|error: String| value(error))?;
        let limits = limits.into_iter().map(limit).collect::<PyResult<Vec<_>>>()?;
        let options = options.options()?;
        library::Problem::new((*case.document()).clone(), vary, (goal, limits), &objects, options)
            .map(Self)
            .map_err(|error| refused(&error))
    }

    /// Cases solved so far.
    fn solved(&self) -> usize {
        self.0.solved()
    }

    /// The numbers at variables from 0 to 1.
    fn numbers(&self, x: Vec<f64>) -> Vec<f64> {
        self.0.numbers(&x)
    }

    /// The variables of the case as it is.
    fn own(&self) -> Vec<f64> {
        self.0.own()
    }

    /// The case at variables, with one of the objects.
    fn case(&self, x: Vec<f64>, object: usize) -> PyResult<Case> {
        let document = self.0.document(&x, object).ok_or_else(|| value("no such object"))?;
        Case::of(document, false)
    }

    /// Goal and margins at variables.
    fn values<'py>(&self, py: Python<'py>, x: Vec<f64>) -> Bound<'py, PyArray1<f64>> {
        let found = py.detach(|| self.0.functions(&x, false));
        PyArray1::from_vec(py, found.values)
    }

    /// Their derivatives, a row per function, and which of them are exact.
    #[expect(clippy::type_complexity, reason = "two arrays of one shape")]
    fn slopes<'py>(
        &self,
        py: Python<'py>,
        x: Vec<f64>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<bool>>)> {
        let found = py.detach(|| self.0.functions(&x, true));
        let odd = |error: numpy::FromVecError| value(error.to_string());
        Ok((PyArray2::from_vec2(py, &found.slopes).map_err(odd)?, PyArray2::from_vec2(py, &found.exact).map_err(odd)?))
    }

    /// One start of a search: its try. The same whoever runs it.
    fn search(&self, py: Python<'_>, number: usize, search: Search) -> PyResult<String> {
        let settings = settings(search);
        let mut listener = Listener { progress: None, raised: None };
        let found = py.detach(|| {
            let start = library::start(&self.0, settings.seed, number);
            library::search(&self.0, &start, &settings, &mut |evaluations, _| {
                listener.tell(Progress { done: 0, starts: 1, evaluations, best: None })
            })
        });
        listener.end(Ok(()))?;
        json(&found)
    }

    /// Searches from all starts: their tries.
    fn optimise(
        &self,
        py: Python<'_>,
        search: Search,
        log: Option<PathBuf>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let settings = settings(search);
        let mut listener = Listener { progress, raised: None };
        let found = py.detach(|| {
            let mut log = Log::open(log.as_deref(), &self.0, &settings)?;
            library::optimise(&self.0, &settings, &mut log, |now| listener.tell(now))
        });
        json(&listener.end(found)?)
    }

    /// The front of the goal and another one: its points, its table and its picture.
    fn front(
        &self,
        py: Python<'_>,
        second: &str,
        points: usize,
        search: Search,
        log: Option<PathBuf>,
    ) -> PyResult<(String, String, String)> {
        let (settings, second) = (settings(search), second.parse().map_err(|error: String| value(error))?);
        let mut listener = Listener { progress: None, raised: None };
        let found = py.detach(|| {
            let mut log = Log::open(log.as_deref(), &self.0, &settings)?;
            library::front(&self.0, second, points, &settings, &mut log, |_, now| listener.tell(now))
        });
        let front = listener.end(found)?;
        let text = library::front_text(&self.0, &front);
        Ok((json(&front.points)?, text, draw::svg(&library::front_picture(&self.0, &front))))
    }

    /// Before and after, of tries: JSON, text and a page.
    fn report(&self, py: Python<'_>, found: &str, seconds: f64) -> PyResult<(String, String, String)> {
        let tries = tries(found)?;
        py.detach(|| {
            let report = Report::of(&self.0, &tries, seconds).ok_or_else(|| value("no start was searched"))?;
            Ok((json(&report)?, report.text(), library::page(&self.0, &report, None)))
        })
    }

    /// Finger and force before and after, as SVG, with one of the objects.
    fn pictures(&self, py: Python<'_>, x: Vec<f64>, object: usize) -> (Option<String>, Option<String>) {
        let [before, after] =
            py.detach(|| library::pictures_of(&self.0, &x, object).map(|scene| scene.as_ref().map(draw::svg)));
        (before, after)
    }
}

/// A measure of a case by its words, and its unit; none where it has no number.
#[pyfunction]
pub(crate) fn measure(
    py: Python<'_>,
    case: &Case,
    words: &str,
    options: Words,
) -> PyResult<(Option<f64>, &'static str)> {
    let (measure, options) = (words.parse::<Measure>().map_err(|error: String| value(error))?, options.options()?);
    let case = case.case.clone();
    let found = py.detach(|| library::value(&case, measure, &options)).map_err(|error| refused(&error))?;
    Ok((found, measure.unit()))
}
