//! A design problem: goal, limits and variables as functions of numbers from 0 to 1, with their derivatives.

use std::sync::atomic::{AtomicUsize, Ordering};

use model_core::discretise::DiscretiseError;
use rayon::prelude::*;
use toml_edit::{DocumentMut, Table};

use super::goal::{Goal, Limit, Variable};
use super::grasp::{Grasp, Line, Wanted};
use super::measure::Measure;
use crate::case::{Case, CaseError, Coordinate, Document, KeyError, MAX_ANGLE, MAX_DISTANCE, dotted};
use crate::study::model::{Options, Precision};

/// What a case with friction is refused by.
const OPTIMISE: &str = "a search";
/// The key of the coefficient.
const FRICTION: &str = "object.friction";
/// What stands for a goal that has no number: the search turns back there. For a margin, with a minus sign.
const UNREACHED: f64 = 1e3;
/// Steps of the motion in a picture.
const DRAWN: u32 = 24;
/// Step of differences between solved cases, as a share of a variable's range: a snap-through is placed within a hundredth of what it
/// moves by.
const STEP: f64 = 1e-3;
/// Step of the differences beside an equilibrium, as a share of a variable's size, in double and in single precision: between rounding,
/// which stiff contacts magnify, and truncation.
const FINE: [f64; 2] = [5e-5, 5e-3];

/// Why there is no problem.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProblemError {
    /// Nothing may be changed.
    #[error("at least one key with its bounds is needed (--vary KEY=A:B)")]
    NoVariables,
    /// A key has two pairs of bounds.
    #[error("{key} is varied twice; allowed is once")]
    Twice {
        /// The key.
        key: String,
    },
    /// Friction is varied.
    #[error("{FRICTION}: {OPTIMISE} computes without friction")]
    Friction,
    /// Another object has two values of a key.
    #[error("{key} is given twice; allowed is once")]
    GivenTwice {
        /// The key.
        key: String,
    },
    /// Another object has a value of a key that is varied: every design would have that value.
    #[error("{key} is varied as well; allowed is a key that is not")]
    Varied {
        /// The key.
        key: String,
    },
    /// A goal or a limit is about a place that no case may have.
    #[error("\"{measure}\": {at}{unit} is beyond the motion; allowed is -{most} to {most}{unit}")]
    Beyond {
        /// The measure in its words.
        measure: String,
        /// The place, degrees or mm.
        at: f64,
        /// The unit of a place.
        unit: &'static str,
        /// The largest place.
        most: f64,
    },
    /// A key that cannot be set.
    #[error(transparent)]
    Key(#[from] KeyError),
    /// The finger cannot be discretised as asked.
    #[error(transparent)]
    Discretise(#[from] DiscretiseError),
    /// An object cannot be made.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The same of one of the other objects.
    #[error("object {}: {error}", .object + 1)]
    Object {
        /// Its index: 0 is the case's own.
        object: usize,
        /// What is wrong with it.
        error: Box<Self>,
    },
}

/// A problem. Several objects are grasped one after the other; a measure then counts by its worst object.
#[derive(Debug)]
pub struct Problem {
    /// The case with each object.
    documents: Vec<Document>,
    variables: Vec<Variable>,
    goal: Goal,
    limits: Vec<Limit>,
    options: Options,
    /// Places to solve at, closing.
    places: Vec<f64>,
    solved: AtomicUsize,
}

/// Goal and limits at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// The goal; `None` where it has no number.
    pub goal: Option<f64>,
    /// The measure of every limit.
    pub limits: Vec<Option<f64>>,
}

/// The functions that a search sees: the goal, to be made small, and the limits' margins, to be kept at 0 or more.
#[derive(Clone, Debug, PartialEq)]
pub struct Functions {
    /// The goal first.
    pub values: Vec<f64>,
    /// A row per function, a column per variable; empty unless asked for.
    pub slopes: Vec<Vec<f64>>,
    /// Whether each entry comes from the solver's derivatives rather than from differences between solved cases.
    pub exact: Vec<Vec<bool>>,
}

impl Problem {
    /// A problem over numbers of a case. `objects` are the numbers, by their keys, that make the other objects.
    ///
    /// # Errors
    /// There is nothing to vary, a key is unknown or there twice, a place is beyond what a case may have, or an object cannot be made.
    pub fn new(
        document: Document,
        variables: Vec<Variable>,
        (goal, limits): (Goal, Vec<Limit>),
        objects: &[Vec<(String, f64)>],
        options: Options,
    ) -> Result<Self, ProblemError> {
        if variables.is_empty() {
            return Err(ProblemError::NoVariables);
        }
        for (index, variable) in variables.iter().enumerate() {
            let key = dotted(&variable.key);
            if variables[..index].iter().any(|other| dotted(&other.key) == key) {
                return Err(ProblemError::Twice { key: variable.key.clone() });
            }
            document.need(&variable.key)?;
            if key == FRICTION {
                // A search needs derivatives, which there are none of.
                return Err(ProblemError::Friction);
            }
        }
        document.case()?.frictionless(OPTIMISE)?.elastic(OPTIMISE)?;
        let mut documents = vec![document];
        for (index, numbers) in objects.iter().enumerate() {
            let other = with_numbers(&documents[0], &variables, numbers)
                .map_err(|error| ProblemError::Object { object: index + 1, error: Box::new(error) })?;
            documents.push(other);
        }
        let mut problem =
            Self { documents, variables, goal, limits, options, places: Vec::new(), solved: AtomicUsize::new(0) };
        problem.measures().try_for_each(|measure| problem.reaches(measure))?;
        problem.places = places(problem.measures());
        Ok(problem)
    }

    /// Whether the places of a measure are such as a case may have.
    ///
    /// # Errors
    /// One of them is not.
    pub fn reaches(&self, measure: Measure) -> Result<(), ProblemError> {
        reaches(measure, self.coordinate())
    }

    /// The same variables and objects with another goal and other limits.
    pub(super) fn with(&self, goal: Goal, limits: Vec<Limit>) -> Self {
        let Self { documents, variables, options, .. } = self;
        let (documents, variables, options) = (documents.clone(), variables.clone(), *options);
        let mut problem =
            Self { documents, variables, goal, limits, options, places: Vec::new(), solved: AtomicUsize::new(0) };
        problem.places = places(problem.measures());
        problem
    }

    /// The goal.
    pub fn goal(&self) -> Goal {
        self.goal
    }

    /// The limits.
    pub fn limits(&self) -> &[Limit] {
        &self.limits
    }

    /// The variables.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// How cases are solved.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Number of objects.
    pub fn objects(&self) -> usize {
        self.documents.len()
    }

    /// Cases solved so far.
    pub fn solved(&self) -> usize {
        self.solved.load(Ordering::Relaxed)
    }

    fn measures(&self) -> impl Iterator<Item = Measure> {
        core::iter::once(self.goal.measure).chain(self.limits.iter().map(|limit| limit.measure))
    }

    /// The numbers at variables from 0 to 1.
    pub fn numbers(&self, x: &[f64]) -> Vec<f64> {
        let of = |(variable, &x): (&Variable, &f64)| variable.least + x.clamp(0.0, 1.0) * variable.range();
        self.variables.iter().zip(x).map(of).collect()
    }

    /// The case's own numbers; `None` for one that it leaves to its default.
    pub fn own_numbers(&self) -> Vec<Option<f64>> {
        let table = self.documents[0].text().parse::<DocumentMut>().ok();
        self.variables.iter().map(|variable| number(table.as_ref()?.as_table(), &variable.key)).collect()
    }

    /// The variables of the case as it is, as near as the bounds allow; the middle for a number that the case leaves to its default.
    pub fn own(&self) -> Vec<f64> {
        let of = |(variable, own): (&Variable, Option<f64>)| {
            own.map_or(0.5, |own| ((own - variable.least) / variable.range()).clamp(0.0, 1.0))
        };
        self.variables.iter().zip(self.own_numbers()).map(of).collect()
    }

    /// The case's document at variables, with one of the objects; its motion is the case's own.
    pub fn document(&self, x: &[f64], object: usize) -> Option<Document> {
        let mut document = self.documents.get(object)?.clone();
        for (variable, number) in self.variables.iter().zip(self.numbers(x)) {
            document.set_known(&variable.key, number);
        }
        Some(document)
    }

    /// The case at variables, closing through the places that the measures need.
    pub fn case(&self, x: &[f64], object: usize) -> Option<Case> {
        self.closing(&self.document(x, object)?)
    }

    /// The case as it is, within the bounds or not, closing through the same places.
    pub fn case_before(&self, object: usize) -> Option<Case> {
        self.closing(self.documents.get(object)?)
    }

    /// A case as it is to be drawn: at least 24 steps from 0 to the last place that the measures need, and those places. Where
    /// they need none, the case's own.
    pub fn drawn(&self, x: Option<&[f64]>, object: usize) -> Option<Case> {
        let document = x.map_or_else(|| self.documents.get(object).cloned(), |x| self.document(x, object))?;
        let mut case = document.case().ok()?;
        if let Some(last) = self.places.last().copied().filter(|last| *last != 0.0) {
            let mut places = self.places.clone();
            places.extend((0..=DRAWN).map(|step| last * f64::from(step) / f64::from(DRAWN)));
            places.sort_by(f64::total_cmp);
            places.dedup();
            case.path.set_places(places);
        }
        Some(case)
    }

    /// The unit of a place: "°", or " mm" of a parallel gripper.
    pub fn unit(&self) -> &'static str {
        self.coordinate().unit()
    }

    fn coordinate(&self) -> Coordinate {
        self.case_before(0).map_or(Coordinate::Angle, |case| case.path.along())
    }

    fn closing(&self, document: &Document) -> Option<Case> {
        let mut case = document.case().ok()?;
        case.path.set_places(self.places.clone());
        Some(case)
    }

    /// Goal and limits of the case as it is.
    pub fn values_before(&self) -> Values {
        self.values_of(self.grasps_of(|object| self.case_before(object), &[]))
    }

    /// Goal and limits at variables.
    pub fn values(&self, x: &[f64]) -> Values {
        self.values_of(self.grasps(x, &[]))
    }

    fn values_of(&self, grasps: Option<Vec<Grasp>>) -> Values {
        let limits = self.limits.iter().map(|limit| {
            let bounds: Vec<(f64, f64)> = limit.scaled().collect();
            // Of several objects, the one that keeps the limit worst.
            let margin =
                |value: &f64| bounds.iter().map(|(sign, bound)| sign * value - bound).fold(f64::INFINITY, f64::min);
            let values = read(limit.measure, grasps.as_deref())?;
            values.into_iter().min_by(|a, b| margin(a).total_cmp(&margin(b)))
        });
        Values { limits: limits.collect(), goal: worst(self.goal, grasps.as_deref()) }
    }

    /// The functions at variables, with their slopes if `slopes`.
    pub fn functions(&self, x: &[f64], slopes: bool) -> Functions {
        if !slopes {
            return Functions {
                values: self.read(self.grasps(x, &[]).as_deref()),
                slopes: Vec::new(),
                exact: Vec::new(),
            };
        }
        let here = self.grasps(x, &self.lines(x));
        let values = self.read(here.as_deref());
        let exact: Vec<Vec<Option<f64>>> =
            (0..self.variables.len()).map(|variable| self.exact(here.as_deref(), x, variable)).collect();
        // Where a single function needs differences, the variable's two neighbours are solved.
        let points: Vec<(usize, [Vec<f64>; 2])> = exact
            .iter()
            .enumerate()
            .filter(|(_, column)| column.iter().any(Option::is_none))
            .map(|(variable, _)| (variable, [-STEP, STEP].map(|step| self.moved(x, variable, step))))
            .collect();
        let solved: Vec<(usize, [f64; 2], [Vec<f64>; 2])> = points
            .par_iter()
            .map(|(variable, sides)| {
                let at = [0, 1].map(|side| sides[side][*variable]);
                let found = [0, 1].map(|side| self.read(self.grasps(&sides[side], &[]).as_deref()));
                (*variable, at, found)
            })
            .collect();
        let mut slopes = vec![vec![0.0; self.variables.len()]; values.len()];
        for (function, row) in slopes.iter_mut().enumerate() {
            for (variable, column) in exact.iter().enumerate() {
                row[variable] = column.get(function).copied().flatten().unwrap_or_else(|| {
                    let found = solved.iter().find(|(of, ..)| *of == variable);
                    found.map_or(0.0, |(_, at, found)| {
                        difference(
                            [at[0], x[variable], at[1]],
                            [found[0][function], values[function], found[1][function]],
                        )
                    })
                });
            }
        }
        let exact = (0..values.len())
            .map(|function| exact.iter().map(|column| column.get(function).is_some_and(Option::is_some)).collect());
        Functions { exact: exact.collect(), values, slopes }
    }

    /// Variables with one of them moved, within the bounds.
    fn moved(&self, x: &[f64], variable: usize, step: f64) -> Vec<f64> {
        let mut moved = x.to_vec();
        moved[variable] = (moved[variable] + step).clamp(0.0, 1.0);
        moved
    }

    /// The cases on both sides of each variable, one list per object; empty if no measure takes the solver's derivatives.
    fn lines(&self, x: &[f64]) -> Vec<Vec<Option<Line>>> {
        if !self.measures().any(Measure::needs_slopes) {
            return Vec::new();
        }
        let numbers = self.numbers(x);
        let [double, single] = FINE;
        let fine = if self.options.precision == Precision::F64 { double } else { single };
        let line = |object: usize, variable: usize| {
            let Variable { key, .. } = &self.variables[variable];
            let step = fine * numbers[variable].abs().max(self.variables[variable].range());
            let side = |step: f64| {
                let mut document = self.document(x, object)?;
                document.set_known(key, numbers[variable] + step);
                self.closing(&document)
            };
            Some(Line { cases: [side(-step)?, side(step)?], step })
        };
        let count = self.variables.len();
        (0..self.documents.len()).map(|object| (0..count).map(|variable| line(object, variable)).collect()).collect()
    }

    /// Every object grasped; `None` if a finger cannot be made.
    fn grasps(&self, x: &[f64], lines: &[Vec<Option<Line>>]) -> Option<Vec<Grasp>> {
        self.grasps_of(|object| self.case(x, object), lines)
    }

    fn grasps_of(
        &self,
        case: impl Fn(usize) -> Option<Case> + Sync,
        lines: &[Vec<Option<Line>>],
    ) -> Option<Vec<Grasp>> {
        let stiffness = stiffness_places(self.measures());
        let slopes: Vec<f64> = if lines.is_empty() { Vec::new() } else { slope_places(&self.places, self.measures()) };
        let snap = self.measures().any(|measure| matches!(measure, Measure::Snap(_)));
        (0..self.documents.len())
            .into_par_iter()
            .map(|object| {
                let case = case(object)?;
                self.solved.fetch_add(1, Ordering::Relaxed);
                let variables = lines.get(object).map_or(&[][..], Vec::as_slice);
                let wanted = Wanted { stiffness: &stiffness, slopes: &slopes, variables, snap };
                Grasp::solve(&case, &self.options, wanted).ok()
            })
            .collect()
    }

    /// The functions' values.
    fn read(&self, grasps: Option<&[Grasp]>) -> Vec<f64> {
        let goal = worst(self.goal, grasps).map_or(UNREACHED, |value| self.goal.sign() * value);
        let margins = self.limits.iter().flat_map(|limit| {
            let values = read(limit.measure, grasps);
            limit.scaled().map(move |(sign, bound)| {
                let margins = values.iter().flatten().map(|value| sign * value - bound);
                if values.is_some() { margins.fold(f64::INFINITY, f64::min) } else { -UNREACHED }
            })
        });
        core::iter::once(goal).chain(margins).collect()
    }

    /// The functions' exact slopes with a variable from 0 to 1.
    fn exact(&self, grasps: Option<&[Grasp]>, x: &[f64], variable: usize) -> Vec<Option<f64>> {
        let range = self.variables[variable].range();
        let slope = |measure: Measure, sign: f64| {
            // The worst object's, as its value.
            let worst =
                grasps?.iter().enumerate().filter_map(|(object, grasp)| Some((object, grasp, measure.value(grasp)?)));
            let (object, grasp, _) = worst.max_by(|a, b| (sign * a.2).total_cmp(&(sign * b.2)))?;
            if let Measure::Mass(_) = measure {
                return self.slope_of_mass(measure, x, variable, object).map(|slope| sign * slope);
            }
            Some(sign * range * measure.slope(grasp, variable)?)
        };
        let margins = self.limits.iter().flat_map(|limit| {
            limit.scaled().map(|(sign, _)| slope(limit.measure, -sign).map(|slope| -slope)).collect::<Vec<_>>()
        });
        core::iter::once(slope(self.goal.measure, self.goal.sign())).chain(margins).collect()
    }

    /// A mass needs no solver: its difference between designs is as exact as its own numbers.
    fn slope_of_mass(&self, measure: Measure, x: &[f64], variable: usize, object: usize) -> Option<f64> {
        let sides = [-STEP, STEP].map(|step| self.moved(x, variable, step));
        let mass = |x: &[f64]| {
            let design = self.case(x, object)?.finger.design;
            measure.value(&Grasp { design, places: Vec::new(), snap: None })
        };
        Some((mass(&sides[1])? - mass(&sides[0])?) / (sides[1][variable] - sides[0][variable]))
    }
}

/// A case with other numbers by their keys: another object.
fn with_numbers(
    document: &Document,
    variables: &[Variable],
    numbers: &[(String, f64)],
) -> Result<Document, ProblemError> {
    let mut other = document.clone();
    for (index, (key, number)) in numbers.iter().enumerate() {
        other.set(key, *number)?;
        let same = |found: &str| dotted(found) == dotted(key);
        if numbers[..index].iter().any(|(found, _)| same(found)) {
            return Err(ProblemError::GivenTwice { key: key.clone() });
        }
        if variables.iter().any(|variable| same(&variable.key)) {
            return Err(ProblemError::Varied { key: key.clone() });
        }
    }
    other.case()?.frictionless(OPTIMISE)?.elastic(OPTIMISE)?;
    Ok(other)
}

/// Whether the places of a measure, along this coordinate, are such as a case may have.
fn reaches(measure: Measure, along: Coordinate) -> Result<(), ProblemError> {
    let (unit, most) = (along.unit(), if along == Coordinate::Angle { MAX_ANGLE } else { MAX_DISTANCE });
    match measure.places().into_iter().find(|at| at.is_nan() || at.abs() > most) {
        Some(at) => Err(ProblemError::Beyond { measure: measure.to_string(), at, unit, most }),
        None => Ok(()),
    }
}

/// A measure of a case, at the places that it needs; `None` where it has no number.
///
/// # Errors
/// A place is beyond what a case may have, or the finger cannot be discretised as asked.
pub fn value(case: &Case, measure: Measure, options: &Options) -> Result<Option<f64>, ProblemError> {
    reaches(measure, case.path.along())?;
    let mut case = case.clone();
    case.path.set_places(places(core::iter::once(measure)));
    let stiffness = stiffness_places(core::iter::once(measure));
    let wanted = Wanted { stiffness: &stiffness, snap: matches!(measure, Measure::Snap(_)), ..Wanted::default() };
    Ok(measure.value(&Grasp::solve(&case, options, wanted)?))
}

/// Places where measures need the object's stiffness.
fn stiffness_places(measures: impl Iterator<Item = Measure>) -> Vec<f64> {
    measures.filter(|measure| matches!(measure, Measure::Stiffness(_))).flat_map(Measure::places).collect()
}

/// Places where measures need derivatives, of those that are solved.
fn slope_places(places: &[f64], measures: impl Iterator<Item = Measure>) -> Vec<f64> {
    let needs = |measure: Measure| {
        let own = measure.places();
        let last = own.last().copied().filter(|_| measure.counts_before());
        places.iter().copied().filter(move |&at| own.contains(&at) || last.is_some_and(|last| at <= last))
    };
    measures.filter(|measure| measure.needs_slopes()).flat_map(needs).collect()
}

/// Slope from the values at three points, of which those without a number are left out.
fn difference(at: [f64; 3], values: [f64; 3]) -> f64 {
    let known: Vec<(f64, f64)> = at.into_iter().zip(values).filter(|(_, value)| value.abs() < UNREACHED).collect();
    match (known.first(), known.last()) {
        (Some(first), Some(last)) if last.0 > first.0 => (last.1 - first.1) / (last.0 - first.0),
        _ => 0.0,
    }
}

/// A measure of every object.
fn read(measure: Measure, grasps: Option<&[Grasp]>) -> Option<Vec<f64>> {
    grasps?.iter().map(|grasp| measure.value(grasp)).collect()
}

/// A goal's value for the worst object.
fn worst(goal: Goal, grasps: Option<&[Grasp]>) -> Option<f64> {
    let order = |a: &f64, b: &f64| (goal.sign() * a).total_cmp(&(goal.sign() * b));
    read(goal.measure, grasps)?.into_iter().max_by(order)
}

/// Places from the open finger through all that measures need.
fn places(measures: impl Iterator<Item = Measure>) -> Vec<f64> {
    let mut places: Vec<f64> = core::iter::once(0.0).chain(measures.flat_map(Measure::places)).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    places
}

/// The number at a dotted key.
fn number(root: &Table, key: &str) -> Option<f64> {
    let mut parts = key.split('.');
    let mut item = root.get(parts.next()?)?;
    // Tables first, then lists in lists.
    while let Some(table) = item.as_table_like() {
        item = table.get(parts.next()?)?;
    }
    let value = parts.try_fold(item.as_value()?, |value, part| value.as_array()?.get(part.parse().ok()?))?;
    value.as_float().or_else(|| Some(value.as_integer()? as f64))
}
