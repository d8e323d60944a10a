//! A case against finite elements.

use std::ops::ControlFlow;
use std::path::Path;

use super::comparison::{Comparison, Elements, Reference, Row};
use super::error::CompareError;
use super::notes::differences;
use super::pictures::overlay;
use crate::case::Case;
use crate::fea::{Analysis, FeaError, Plan, Pose, Progress};
use crate::study::model::Options;
use crate::study::run;

/// Compares a case with finite elements: meshes the finger, presses it on the object with CalculiX in a folder, and compares at
/// every place of the case's motion. `refinement` makes every element so many by so many.
///
/// # Errors
/// The case cannot be meshed or discretised, or CalculiX fails.
pub fn with_elements(
    case: &Case,
    options: &Options,
    refinement: usize,
    folder: &Path,
) -> Result<Comparison, CompareError> {
    with_elements_watched(case, options, refinement, folder, |_| ControlFlow::Continue(()))
}

/// As [`with_elements`], calling `watch` before CalculiX starts and many times a second; it stops the work by
/// [`ControlFlow::Break`].
///
/// # Errors
/// As those of [`with_elements`], or the work was stopped.
pub fn with_elements_watched(
    case: &Case,
    options: &Options,
    refinement: usize,
    folder: &Path,
    watch: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<Comparison, CompareError> {
    case.refuse_memory("a comparison with finite elements").map_err(CompareError::Memory)?;
    let plan = Plan::of(case, refinement).map_err(CompareError::Mesh)?;
    let run = run::solve(case, options)?;
    let model_seconds = run.seconds();
    let analysis = plan.run(case, folder, watch).map_err(|error| match error {
        FeaError::Stopped => CompareError::Stopped,
        error => CompareError::Fea(error),
    })?;
    let rows = run.places.iter().zip(&analysis.poses).map(|(place, pose)| {
        let front = pose.as_ref().map_or(&[][..], |pose| &pose.front);
        Row::new(place, pose.as_ref().map(Pose::magnitude), front)
    });
    let rows: Vec<Row> = rows.collect();
    let Analysis { elements, nodes, effort, seconds, unread, doubts, .. } = analysis;
    let figures = Elements {
        seconds,
        speed_ratio: seconds / model_seconds.max(1e-9),
        elements,
        nodes,
        increments: effort.increments,
        failed_attempts: effort.failed_attempts,
        iterations: effort.iterations,
        folder: folder.display().to_string(),
    };
    let both = run.places.iter().zip(&analysis.poses).rev();
    let last = both.filter_map(|(place, pose)| place.state.as_ref().zip(pose.as_ref())).next();
    let picture = last.map(|(state, pose)| overlay(case, state, pose)).transpose().map_err(CompareError::Fea)?;
    let mut notes = differences(case, options.discretisation.physics, &run.places);
    notes.extend(run.warnings.iter().map(ToString::to_string));
    notes.extend(doubts);
    notes.extend(unread.map(|error| format!("{error}: the deformed mesh is not drawn")));
    Ok(Comparison {
        reference: Reference::Fea,
        rows,
        model_seconds,
        fea: Some(figures),
        notes,
        left_out: Vec::new(),
        picture,
    })
}
