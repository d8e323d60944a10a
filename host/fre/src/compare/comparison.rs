//! A comparison, place by place.

use model_core::status::Status;
use serde::Serialize;

use crate::draw::Scene;
use crate::fit::measured::Measurement;
use crate::metrics::{Point, deviation, deviation_of_outlines, force_error};
use crate::study::place::Place;

/// A place at which both sides were asked.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Motor angle, degrees, or distance, mm.
    pub place: f64,
    /// Status of the model's solution.
    pub status: Status,
    /// Magnitude of the model's net force, N.
    pub force_n: Option<f64>,
    /// The reference's, N.
    pub reference_force_n: Option<f64>,
    /// Model less reference, N.
    pub difference_n: Option<f64>,
    /// The same over the reference, percent.
    pub error_percent: Option<f64>,
    /// Mean distance of the reference's front centreline from the model's, mm.
    pub shape_mean_mm: Option<f64>,
    /// Largest such distance, mm.
    pub shape_max_mm: Option<f64>,
    /// Point of the reference's centreline where it is largest, finger frame, mm.
    pub shape_max_at_mm: Option<Point>,
    /// Measurements: a reading's residual lies far from the others'.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub outlier: bool,
    /// Measurements: line of the file, the place's first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<usize>,
    /// Measurements: the forces that `reference_force_n` is the mean of.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub readings: Vec<Reading>,
    /// Measurements: points of the outline that lie far from the model, compared with the others.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub outlying_points: Vec<OutlyingPoint>,
    /// Measurements: the same place without its outlying readings and points, if it has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub without_outliers: Option<Box<Row>>,
}

/// A measured force.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reading {
    /// Line of the file.
    pub line: usize,
    /// Measured force, N.
    pub force_n: f64,
    /// Model less reading, N.
    pub difference_n: Option<f64>,
    /// Its residual lies far from the others'.
    pub outlier: bool,
}

/// A point of a measured outline.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutlyingPoint {
    /// Which of the place's points it is.
    #[serde(skip)]
    pub index: usize,
    /// Line of the file.
    pub line: usize,
    /// The point, finger frame, mm.
    pub point_mm: Point,
    /// Distance to the model's line, mm.
    pub distance_mm: f64,
}

impl Row {
    pub(super) fn new(place: &Place, reference_force: Option<f64>, reference_front: &[Point]) -> Self {
        let force = place.force_magnitude_n();
        let error = force.zip(reference_force).map(|(force, reference)| force_error(force, reference));
        let shape = deviation(place.front_mm(), reference_front);
        Self {
            place: place.at.value(),
            status: place.status,
            force_n: force,
            reference_force_n: reference_force,
            difference_n: error.map(|e| e.difference),
            error_percent: error.and_then(|e| e.percent),
            shape_mean_mm: shape.map(|s| s.mean),
            shape_max_mm: shape.map(|s| s.max),
            shape_max_at_mm: shape.map(|s| s.at),
            outlier: false,
            line: None,
            readings: Vec::new(),
            outlying_points: Vec::new(),
            without_outliers: None,
        }
    }

    /// A measured place.
    pub(super) fn measured(place: &Place, measurement: &Measurement) -> Self {
        let force = place.force_magnitude_n();
        let reading = |&(line, force_n): &(usize, f64)| {
            let difference_n = force.map(|force| force_error(force, force_n).difference);
            Reading { line, force_n, difference_n, outlier: false }
        };
        let outlines = measurement.outlines();
        let outlines = outlines.into_iter().map(|part| &measurement.front[part]);
        let shape = deviation_of_outlines(place.front_mm(), outlines);
        Self {
            line: Some(measurement.line),
            readings: measurement.forces.iter().map(reading).collect(),
            shape_mean_mm: shape.map(|s| s.mean),
            shape_max_mm: shape.map(|s| s.max),
            shape_max_at_mm: shape.map(|s| s.at),
            ..Self::new(place, measurement.force, &[])
        }
    }

    /// Computes the place once more without its outliers, if it has any.
    pub(super) fn leave_outliers_out(&mut self, place: &Place, measurement: &Measurement) {
        let readings = self.readings.iter().enumerate().filter(|(_, reading)| reading.outlier);
        let readings: Vec<usize> = readings.map(|(index, _)| index).collect();
        let points: Vec<usize> = self.outlying_points.iter().map(|point| point.index).collect();
        if !readings.is_empty() || !points.is_empty() {
            let rest = measurement.without(&readings, &points);
            self.without_outliers = Some(Box::new(Self::measured(place, &rest)));
        }
    }

    /// Lines of the readings that are outliers.
    pub fn outlier_lines(&self) -> Vec<String> {
        self.readings.iter().filter(|reading| reading.outlier).map(|reading| reading.line.to_string()).collect()
    }
}

/// A comparison, place by place; its serde form is the JSON of `fre compare`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// What the model is compared with.
    pub reference: Reference,
    /// One per place.
    pub rows: Vec<Row>,
    /// Time that the model took, s.
    pub model_seconds: f64,
    /// What the finite elements took.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fea: Option<Elements>,
    /// What the two sides do not have in common.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Rows of the file that were left out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
    /// Both shapes at the last place (finite elements), or forces and residuals (measurements); none if no place has both results.
    #[serde(skip)]
    pub picture: Option<Scene>,
}

/// Size and effort of the finite elements.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Elements {
    /// CalculiX's time, s.
    pub seconds: f64,
    /// CalculiX's time over the model's.
    pub speed_ratio: f64,
    /// Elements of the mesh.
    pub elements: usize,
    /// Nodes of the mesh.
    pub nodes: usize,
    /// Increments of the load that converged.
    pub increments: usize,
    /// Increments tried in vain.
    pub failed_attempts: usize,
    /// Newton iterations.
    pub iterations: usize,
    /// Folder of the files.
    pub folder: String,
}

/// What a model is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Reference {
    /// Finite elements.
    Fea,
    /// Measurements.
    Measured,
}

impl Comparison {
    /// Whether every place has both results that it can have.
    pub fn is_complete(&self) -> bool {
        self.rows.iter().all(|row| row.force_n.is_some() && (self.fea.is_none() || row.reference_force_n.is_some()))
    }

    /// One object.
    ///
    /// # Errors
    /// None for results of the solver.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}
