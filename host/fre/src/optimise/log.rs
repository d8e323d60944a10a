//! Finished starts in a file, so that a search which was stopped goes on where it was.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::error::OptimiseError;
use super::problem::Problem;
use super::search::{Settings, Try};
use crate::files::Files;

/// The file's content.
#[derive(Debug, Serialize, Deserialize)]
struct Content {
    problem: Value,
    /// Tries in the order of the starts, by the search's name.
    searches: BTreeMap<String, Vec<Try>>,
}

/// Tries that are done.
#[derive(Debug)]
pub struct Log {
    /// Where they are kept; `None` for this program only.
    path: Option<PathBuf>,
    content: Content,
}

/// What says which problem it is.
fn identity(problem: &Problem, settings: &Settings) -> Value {
    let cases: Vec<String> = (0..problem.objects())
        .filter_map(|object| problem.document(&problem.own(), object))
        .map(|document| document.text())
        .collect();
    let variables: Vec<Value> = problem.variables().iter().map(|one| json!([one.key, one.least, one.most])).collect();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "cases": cases,
        "variables": variables,
        "goal": problem.goal().to_string(),
        "limits": problem.limits().iter().map(ToString::to_string).collect::<Vec<_>>(),
        "options": format!("{:?}", problem.options()),
        "seed": settings.seed,
        "most": settings.most,
        "tolerance": settings.tolerance,
    })
}

impl Log {
    /// Opens a file, or begins a log without one.
    ///
    /// # Errors
    /// The file cannot be read, or is another problem's.
    pub fn open(path: Option<&Path>, problem: &Problem, settings: &Settings) -> Result<Self, OptimiseError> {
        let fresh = Content { problem: identity(problem, settings), searches: BTreeMap::new() };
        let Some(file) = path.filter(|path| path.exists()) else {
            return Ok(Self { path: path.map(Path::to_owned), content: fresh });
        };
        let unreadable = |reason: String| OptimiseError::Log { file: file.display().to_string(), reason };
        let text = std::fs::read_to_string(file).map_err(|error| unreadable(error.to_string()))?;
        let content: Content = serde_json::from_str(&text).map_err(|error| unreadable(error.to_string()))?;
        if content.problem != fresh.problem {
            return Err(unreadable("it is of another problem; remove it, or give another name".to_owned()));
        }
        Ok(Self { path: path.map(Path::to_owned), content })
    }

    /// The tries of a search.
    pub(super) fn tries(&self, search: &str) -> &[Try] {
        self.content.searches.get(search).map_or(&[], Vec::as_slice)
    }

    /// Keeps one more.
    pub(super) fn add(&mut self, search: &str, one: Try) -> Result<(), OptimiseError> {
        self.content.searches.entry(search.to_owned()).or_default().push(one);
        let Some(path) = &self.path else { return Ok(()) };
        let unwritable = |reason: String| OptimiseError::Log { file: path.display().to_string(), reason };
        let bytes = serde_json::to_vec_pretty(&self.content).map_err(|error| unwritable(error.to_string()))?;
        // Written beside its place and renamed: whole, or as it was.
        let output = Files::new(true).output(path, "the search").map_err(|error| unwritable(error.to_string()))?;
        output.write(&bytes).map_err(|error| unwritable(error.to_string()))
    }
}
