//! A case solved by every variant of the model.

use super::series::Series;
use crate::case::Case;
use crate::metrics::{Deviation, deviation, force_error};
use crate::study::place::Place;
use crate::study::run::Run;

/// One model's measures against another's in one case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Agreement {
    /// Both are trustworthy and on the same branch.
    Same {
        /// Of the model's front nodes from the reference's front centreline.
        shape: Deviation,
        /// Of the net force's magnitude, percent of the reference's.
        force_percent: f64,
    },
    /// One of them has snapped through and the other has not.
    OtherBranch,
    /// One of them has no trustworthy solution.
    None,
}

/// A case solved by every variant of the model.
#[derive(Clone, Debug)]
pub struct Row {
    /// The series.
    pub series: Series,
    /// Which of its angles, from 0.
    pub angle: usize,
    /// Object and path.
    pub case: Case,
    /// One per variant, with this place only.
    pub runs: Vec<Run>,
    /// True for a variant that has snapped through at this angle or before.
    pub snapped: Vec<bool>,
}

impl Row {
    /// Name of the case.
    pub fn name(&self) -> String {
        self.series.name(self.angle)
    }

    /// The result of a variant.
    pub fn place(&self, variant: usize) -> Option<&Place> {
        self.runs.get(variant)?.places.first()
    }

    /// Measures of one variant against a reference.
    pub fn compare(&self, model: usize, reference: usize) -> Agreement {
        let (Some(a), Some(b)) = (self.place(model), self.place(reference)) else { return Agreement::None };
        let (Some(force), Some(expected)) = (a.force_magnitude_n(), b.force_magnitude_n()) else {
            return Agreement::None;
        };
        // The finer line is the one to be near to: a coarse one's chords lie beside the beam.
        let Some(shape) = deviation(b.front_mm(), a.front_mm()) else { return Agreement::None };
        let Some(force_percent) = force_error(force, expected).percent else { return Agreement::None };
        if self.snapped.get(model) != self.snapped.get(reference) {
            return Agreement::OtherBranch;
        }
        Agreement::Same { shape, force_percent }
    }
}
