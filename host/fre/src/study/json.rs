//! A run as JSON: an array with one object per place.

use model_core::status::Status;
use serde::{Deserialize, Serialize};

use crate::case::Coordinate;
use crate::shape::Contact;
use crate::study::branch::FirstBranch;
use crate::study::buckling;
use crate::study::friction::{ForceInterval, Friction};
use crate::study::model::{self, Precision, physics_word, scheme_word};
use crate::study::place::{MaxStrain, Place};
use crate::study::pressure::Pressure;
use crate::study::run::Run;
use crate::study::self_contact;
use crate::study::sensitivity::Sensitivity;
use crate::study::strains::{self, Strains};

/// The object of a place. Without a trustworthy status numbers are `null` and lists empty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are those of `Place`, `State` and `Run`")]
pub struct Row {
    pub status: Status,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor_angle_deg: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance_mm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
    pub force_n: Option<[f64; 2]>,
    pub force_magnitude_n: Option<f64>,
    pub force_finger_frame_n: Option<[f64; 2]>,
    pub motor_torque_nmm: Option<f64>,
    pub energy_nmm: Option<f64>,
    pub gap_mm: Option<f64>,
    pub tip_mm: Option<[f64; 2]>,
    pub front_mm: Vec<[f64; 2]>,
    pub back_mm: Vec<[f64; 2]>,
    pub lamellae_mm: Vec<[[f64; 2]; 2]>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ribs_mm: Vec<Vec<[f64; 2]>>,
    pub contacts: Vec<Contact>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_interval_n: Option<ForceInterval>,
    pub max_strain: Option<MaxStrain>,
    pub sensitivity: Option<Sensitivity>,
    pub iterations: u32,
    pub steps: u32,
    pub elapsed_us: f64,
    pub model: Model,
    pub branch: Option<u32>,
    pub first_branch: Option<FirstBranch>,
    pub contact_pressure: Vec<Pressure>,
    pub strains: Option<Strains>,
    pub beyond_max_strain: Option<Vec<Beyond>>,
    pub overlap_mm: Option<f64>,
    #[serde(default)]
    pub self_contact: Option<self_contact::Written>,
    #[serde(default)]
    pub buckling: Option<buckling::Written>,
    /// About the finger, and about this place.
    pub warnings: Vec<String>,
}

/// The model; every place has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are those of the model")]
pub struct Model {
    pub scheme: String,
    pub elements_per_beam: u32,
    pub elements_per_hinge: u32,
    pub unknowns: usize,
    pub physics: String,
    pub precision: Precision,
    pub version: String,
}

impl From<&model::Model> for Model {
    fn from(model: &model::Model) -> Self {
        Self {
            scheme: scheme_word(model.scheme).to_owned(),
            elements_per_beam: model.elements_per_beam,
            elements_per_hinge: model.elements_per_hinge,
            unknowns: model.unknowns,
            physics: physics_word(model.physics).to_owned(),
            precision: model.precision,
            version: model.version.to_owned(),
        }
    }
}

/// A part that is strained beyond the material's limit, or beyond 30 % if that is not known.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are those of the library's type")]
pub struct Beyond {
    pub part: String,
    pub strain: f64,
    pub limit: f64,
}

impl From<&strains::Beyond> for Beyond {
    fn from(beyond: &strains::Beyond) -> Self {
        Self { part: beyond.part.to_string(), strain: beyond.strain, limit: beyond.limit.share() }
    }
}

impl Row {
    /// The object of one of a run's places.
    pub fn new(run: &Run, place: &Place) -> Self {
        let state = place.state.as_ref();
        let shape = state.map(|state| state.shape.clone()).unwrap_or_default();
        let at = |along: Coordinate| (place.at.along() == along).then_some(place.at.value());
        Self {
            status: place.status,
            motor_angle_deg: at(Coordinate::Angle),
            distance_mm: at(Coordinate::Distance),
            time_s: at(Coordinate::Time).or(place.time_s),
            force_n: place.force_n(),
            force_magnitude_n: place.force_magnitude_n(),
            force_finger_frame_n: state.map(|state| state.force_finger_frame_n),
            motor_torque_nmm: state.map(|state| state.motor_torque_nmm),
            energy_nmm: state.and_then(|state| state.energy_nmm),
            gap_mm: state.map(|state| state.gap_mm),
            tip_mm: state.map(|state| state.tip_mm),
            front_mm: shape.front,
            back_mm: shape.back,
            lamellae_mm: shape.lamellae,
            ribs_mm: shape.ribs,
            contacts: shape.contacts,
            friction: state.and_then(|state| state.friction),
            force_interval_n: state.and_then(|state| state.force_interval),
            max_strain: state.map(|state| state.max_strain),
            sensitivity: state.and_then(|state| state.sensitivity),
            iterations: place.effort.iterations,
            steps: place.effort.steps,
            elapsed_us: place.effort.elapsed_us,
            model: Model::from(&run.model),
            branch: place.branch,
            first_branch: run.first_branch,
            contact_pressure: state.map(|state| state.contact_pressure.clone()).unwrap_or_default(),
            strains: state.map(|state| state.strains.clone()),
            beyond_max_strain: state.map(|state| state.beyond_max_strain.iter().map(Beyond::from).collect()),
            overlap_mm: place.overlap_mm,
            self_contact: state.and_then(|state| state.self_contact).map(self_contact::Written::from),
            buckling: state.and_then(|state| state.buckling).map(buckling::Written::from),
            warnings: run.warnings_at(place.at).map(ToString::to_string).collect(),
        }
    }
}

/// The array, with a line's end behind it.
///
/// # Errors
/// None for results of the solver.
pub fn json(run: &Run) -> Result<String, serde_json::Error> {
    let rows: Vec<Row> = run.places.iter().map(|place| Row::new(run, place)).collect();
    text(&rows)
}

/// The same, of objects that are there already.
///
/// # Errors
/// As [`json`].
pub fn text(rows: &[Row]) -> Result<String, serde_json::Error> {
    let mut text = serde_json::to_string_pretty(rows)?;
    text.push('\n');
    Ok(text)
}
