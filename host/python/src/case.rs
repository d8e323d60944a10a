//! A case: its text with the finger written out, and what it says.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use fre::case::{Document, PRESETS};
use pyo3::prelude::*;

use crate::error::{UNNAMED, of_case, value};

/// A case. Never changes: a case with other values is another one.
#[derive(Clone)]
#[pyclass(frozen, module = "fre._core")]
pub(crate) struct Case {
    written: Arc<Document>,
    /// Numbers that differ from what is written: a batch makes no document of its own for each of its cases.
    changes: Option<Changes>,
    pub(crate) case: Arc<fre::case::Case>,
}

/// Keys, and the number of each.
#[derive(Clone)]
pub(crate) struct Changes {
    pub(crate) keys: Arc<[String]>,
    pub(crate) numbers: Arc<[f64]>,
}

impl Changes {
    /// Sets the numbers in a document that has the keys.
    pub(crate) fn set(&self, document: &mut Document) {
        for (key, &number) in self.keys.iter().zip(&*self.numbers) {
            document.set_known(key, number);
        }
    }
}

impl Case {
    pub(crate) fn of(document: Document, in_file: bool) -> PyResult<Self> {
        let case = document.case().map_err(|error| of_case(&error, in_file))?;
        Ok(Self { written: Arc::new(document), changes: None, case: Arc::new(case) })
    }

    /// A case of a batch.
    pub(crate) fn changed(written: Arc<Document>, changes: Changes, case: fre::case::Case) -> Self {
        Self { written, changes: Some(changes), case: Arc::new(case) }
    }

    /// The case's document.
    pub(crate) fn document(&self) -> Arc<Document> {
        let Some(changes) = &self.changes else { return self.written.clone() };
        let mut document = (*self.written).clone();
        changes.set(&mut document);
        Arc::new(document)
    }
}

#[pymethods]
impl Case {
    /// Reads a case file.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        Self::of(Document::read(&path).map_err(|error| of_case(&error, true))?, true)
    }

    /// Reads a case from a text; finger files that it names are looked for in a folder.
    #[staticmethod]
    #[pyo3(signature = (text, folder = None))]
    fn parse(text: &str, folder: Option<PathBuf>) -> PyResult<Self> {
        let folder = folder.unwrap_or_default();
        // A finger that is named is written out first: its own errors name its file.
        let document = Document::resolve(UNNAMED, text, &folder).map_err(|error| of_case(&error, false))?;
        Self::of(document, false)
    }

    /// The text, finger included.
    fn toml(&self) -> String {
        self.document().text()
    }

    /// Keys of the numbers that can be set.
    fn keys(&self) -> Vec<String> {
        self.document().keys()
    }

    /// Whether both say the same, however it is written.
    fn __eq__(&self, other: &Self) -> bool {
        self.case == other.case
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        // Where its file has what does not count for equality. Without signs: 0 is equal to −0.
        let case = fre::case::Case { written: Default::default(), ..(*self.case).clone() };
        format!("{case:?}").replace('-', "").hash(&mut hasher);
        hasher.finish()
    }

    /// The case with other numbers.
    fn with_values(&self, values: Vec<(String, f64)>) -> PyResult<Self> {
        let mut document = (*self.document()).clone();
        for (key, number) in values {
            document
                .set(&key, number)
                .map_err(|error| crate::error::case_error(error.to_string(), Some(&key), None))?;
        }
        Self::of(document, false)
    }
}

/// Names of the fingers that come with the program.
#[pyfunction]
pub(crate) fn presets() -> Vec<&'static str> {
    PRESETS.to_vec()
}

/// The text of a finger that comes with the program.
#[pyfunction]
pub(crate) fn preset(name: &str) -> PyResult<String> {
    if !PRESETS.contains(&name) {
        return Err(value(format!("\"{name}\" is not a preset; allowed is {}", PRESETS.join(", "))));
    }
    let text = format!("finger = \"preset:{name}\"\n");
    let document = Document::resolve(UNNAMED, &text, Path::new("")).map_err(|error| of_case(&error, false))?;
    Ok(document.finger_text(&[]))
}
