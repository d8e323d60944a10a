//! How a case is solved, from the words of Python's `Options`.

use fre::study::choice::{Choice, elements};
use fre::study::model::{Options, Precision};
use model_core::discretise::{Physics, Scheme};
use model_core::newton::Hessian;
use pyo3::prelude::*;

use crate::error::case_error;

/// The fields of Python's `Options`, read as they are needed.
#[derive(FromPyObject)]
pub(crate) struct Words {
    scheme: String,
    elements: String,
    samples: Option<i64>,
    softness_mm_per_n: Option<f64>,
    physics: String,
    hessian: String,
    precision: String,
}

/// One of a few words, by its key.
pub(crate) fn word<X: Copy>(key: &str, found: &str, allowed: &[(&str, X)]) -> PyResult<X> {
    allowed.iter().find(|(word, _)| *word == found).map(|(_, value)| *value).ok_or_else(|| {
        let words: Vec<&str> = allowed.iter().map(|(word, _)| *word).collect();
        case_error(format!("{key} = \"{found}\": allowed is {}", words.join(", ")), Some(key), None)
    })
}

impl Words {
    /// The options as the library takes them.
    pub(crate) fn options(&self) -> PyResult<Options> {
        let schemes = [("paper", Scheme::Paper), ("trapezoid", Scheme::Trapezoid), ("simpson", Scheme::Simpson)];
        let physics = [("paper", Physics::Paper), ("extended", Physics::Extended)];
        let hessians = [("newton", Hessian::Newton), ("gauss-newton", Hessian::GaussNewton)];
        let precisions = [("f64", Precision::F64), ("f32", Precision::F32)];
        let samples = |count: i64| {
            let refused = || case_error(format!("samples = {count}: allowed is 1 to 16"), Some("samples"), None);
            u8::try_from(count).ok().filter(|count| (1..=16).contains(count)).ok_or_else(refused)
        };
        let refused =
            |reason| case_error(format!("elements = \"{}\": {reason}", self.elements), Some("elements"), None);
        let choice = Choice {
            scheme: word("scheme", &self.scheme, &schemes)?,
            elements: elements(&self.elements).map_err(refused)?,
            samples: self.samples.map(samples).transpose()?,
            softness: self.softness_mm_per_n,
            physics: word("physics", &self.physics, &physics)?,
            hessian: word("hessian", &self.hessian, &hessians)?,
            precision: word("precision", &self.precision, &precisions)?,
        };
        Ok(choice.options())
    }
}

/// Fails for options that nothing can be solved with.
#[pyfunction]
pub(crate) fn check_options(options: Words) -> PyResult<()> {
    options.options().map(drop)
}
