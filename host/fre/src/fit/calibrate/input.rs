//! Measurements with their cases, as a calibration needs them.

use std::path::PathBuf;

use model_core::drive::{Drive, DriveError};
use model_core::object::ObjectDesign;

use super::{Plan, Readings};
use crate::case::{Case, CaseError, Coordinate, Document, Finger};
use crate::drive::{OtherMotion, agrees};
use crate::fit::measured::{Measured, MeasuredError};

/// The runs of one finger, each on its object.
#[derive(Clone, Debug)]
pub struct Input {
    /// The first case, to be written with fitted values.
    pub document: Document,
    /// The finger of all runs.
    pub finger: Finger,
    /// The object of each run, world frame.
    pub objects: Vec<ObjectDesign>,
    /// The runs, one per file of measurements.
    pub runs: Vec<Readings>,
    /// How the motor moves the base.
    pub drive: Drive,
    /// What was left out of the files, a sentence each.
    pub remarks: Vec<String>,
}

/// Why measurements and cases do not make a calibration.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// Nothing was measured.
    #[error("at least one file of measurements is needed")]
    NoFiles,
    /// As many cases as files, or one for all, are needed.
    #[error("{files} files of measurements and {cases} cases; allowed is one case, or one per file")]
    Count {
        /// Files of measurements.
        files: usize,
        /// Cases.
        cases: usize,
    },
    /// A case cannot be used.
    #[error(transparent)]
    Case(#[from] Box<CaseError>),
    /// The cases have several fingers.
    #[error("{file}: its finger is not that of {first}")]
    Finger {
        /// The case.
        file: String,
        /// The first case.
        first: String,
    },
    /// The drive is not one.
    #[error("--drive: {0}")]
    Drive(#[from] DriveError),
    /// A case moves its base in another way than the drive.
    #[error("{file}: {error}")]
    Motion {
        /// The case.
        file: String,
        /// How they differ.
        error: OtherMotion,
    },
    /// A file of measurements cannot be used.
    #[error(transparent)]
    Measured(#[from] MeasuredError),
    /// A row has no time, or one that is not after that of the row before, and the material has memory.
    #[error("{file}:{line}: needed is time_s, later than in the row before: the case's material has memory")]
    Time {
        /// The file.
        file: String,
        /// The row's line.
        line: usize,
    },
    /// A file has motor torques alone, whose standard deviation is not given.
    #[error("{file}: has motor torques alone; needed is their standard deviation (--torque-sd-nmm), or forces")]
    TorquesAlone {
        /// The file.
        file: String,
    },
    /// A file has another coordinate than motor angles.
    #[error(
        "{file}: has {found}; needed is motor_angle_deg, for a finger that is moved along a line too (see --drive)"
    )]
    Coordinate {
        /// The file.
        file: String,
        /// Its column.
        found: &'static str,
    },
}

/// Readings of one place scatter by less, degrees: three counts of a servo.
const SCATTER_DEG: f64 = 3.0 * 360.0 / 4096.0;

impl Input {
    /// Reads files of measurements and their cases: one case for all files, or one for each in their order. Rows of an opening motion
    /// are left out unless `both_ways`; of a material with memory all rows count, along their times. `drive` is how the motor moves the base; the cases have to move it so, too.
    ///
    /// # Errors
    /// A file that cannot be used, or cases that do not fit.
    pub fn read(
        measurements: &[PathBuf],
        cases: &[PathBuf],
        both_ways: bool,
        drive: Drive,
    ) -> Result<Self, InputError> {
        drive.validate()?;
        // Before any file is read.
        fit_together(measurements.len(), cases.len())?;
        let named = |path: &PathBuf| Ok((path.display().to_string(), Document::read(path).map_err(Box::new)?));
        Self::of(measurements, cases.iter().map(named).collect::<Result<_, InputError>>()?, both_ways, drive)
    }

    /// The same with cases that are there already, and what they are called in messages.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn of(
        measurements: &[PathBuf],
        documents: Vec<(String, Document)>,
        both_ways: bool,
        drive: Drive,
    ) -> Result<Self, InputError> {
        drive.validate()?;
        fit_together(measurements.len(), documents.len())?;
        let measured = measurements.iter().map(|path| Ok((path.display().to_string(), Measured::read(path)?)));
        Self::of_measured(measured.collect::<Result<_, InputError>>()?, documents, both_ways, drive)
    }

    /// The same with measurements that are there already, too, and what they are called in messages.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn of_measured(
        measurements: Vec<(String, Measured)>,
        documents: Vec<(String, Document)>,
        both_ways: bool,
        drive: Drive,
    ) -> Result<Self, InputError> {
        drive.validate()?;
        fit_together(measurements.len(), documents.len())?;
        let Agreed { document, cases, finger } = Agreed::of(&documents, &drive)?;
        let (mut runs, mut objects, mut remarks) = (Vec::new(), Vec::new(), Vec::new());
        for (index, (name, measured)) in measurements.into_iter().enumerate() {
            if measured.coordinate != Coordinate::Angle {
                return Err(InputError::Coordinate { file: name, found: measured.coordinate.column() });
            }
            let Case { object, friction, .. } = cases[if cases.len() == 1 { 0 } else { index }];
            let (run, opening) = if !finger.prony.is_empty() {
                let run = Readings::in_time(&name, object, friction, &measured);
                (run.map_err(|line| InputError::Time { file: name.clone(), line })?, Vec::new())
            } else if both_ways {
                (Readings::all(&name, object, friction, &measured), Vec::new())
            } else {
                Readings::closing(&name, object, friction, &measured, SCATTER_DEG)
            };
            if !measured.aside.is_empty() {
                remarks.push(format!("left out: {name}: columns {}", measured.aside.join(", ")));
            }
            remarks.extend(measured.problems.iter().map(|problem| format!("left out: {name}:{problem}")));
            if let (Some(first), count @ 1..) = (opening.first(), opening.len()) {
                remarks.push(format!(
                    "left out: {count} rows of {name} that belong to an opening motion (from line {first} on; --both-ways uses them)"
                ));
            }
            objects.push(object);
            runs.push(run);
        }
        Ok(Self { document, finger, objects, runs, remarks, drive })
    }

    /// Leaves the motor torques out, as where their standard deviation is not given, and says so.
    ///
    /// # Errors
    /// A file has nothing else.
    pub fn without_torques(mut self) -> Result<Self, InputError> {
        for run in &mut self.runs {
            let torques = run.readings.iter_mut().filter_map(|reading| reading.torque_nmm.take()).count();
            if torques == 0 {
                continue;
            }
            run.readings.retain(|reading| reading.force_n.is_some() || !reading.front_mm.is_empty());
            if run.readings.is_empty() {
                return Err(InputError::TorquesAlone { file: run.name.clone() });
            }
            self.remarks.push(format!("left out: {}: {torques} motor torques (--torque-sd-nmm uses them)", run.name));
        }
        Ok(self)
    }

    /// The runs of a plan, one per case and without forces.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn planned(plan: &Plan, documents: &[(String, Document)], drive: Drive) -> Result<Self, InputError> {
        drive.validate()?;
        let Agreed { document, cases, finger } = Agreed::of(documents, &drive)?;
        let run = |((name, _), case): (&(String, Document), &Case)| Readings {
            name: name.clone(),
            object: case.object,
            friction: case.friction,
            readings: plan.readings(),
        };
        let runs = documents.iter().zip(&cases).map(run).collect();
        let objects = cases.iter().map(|case| case.object).collect();
        Ok(Self { document, finger, objects, runs, remarks: Vec::new(), drive })
    }
}

/// Cases of one finger, all moved by one drive.
struct Agreed {
    /// The first.
    document: Document,
    cases: Vec<Case>,
    finger: Finger,
}

impl Agreed {
    fn of(documents: &[(String, Document)], drive: &Drive) -> Result<Self, InputError> {
        let cases = documents.iter().map(|(_, document)| document.case());
        let cases = cases.map(|case| case.map_err(Box::new));
        let cases: Vec<Case> = cases.collect::<Result<_, _>>()?;
        let (Some((first_name, document)), Some(first)) = (documents.first(), cases.first()) else {
            return Err(InputError::Count { files: 0, cases: 0 });
        };
        let finger = first.finger.clone();
        for (case, (name, _)) in cases.iter().zip(documents) {
            if case.finger.design != finger.design || case.finger.prony != finger.prony {
                return Err(InputError::Finger { file: name.clone(), first: first_name.clone() });
            }
            agrees(&case.path.motion, drive).map_err(|error| InputError::Motion { file: name.clone(), error })?;
        }
        Ok(Self { document: document.clone(), cases, finger })
    }
}

/// Fails unless there are files, and one case, or one per file.
fn fit_together(files: usize, cases: usize) -> Result<(), InputError> {
    if files == 0 {
        return Err(InputError::NoFiles);
    }
    if cases != 1 && cases != files {
        return Err(InputError::Count { files, cases });
    }
    Ok(())
}
