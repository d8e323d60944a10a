//! The front of two goals: the best of the first for every bound of the second.

use std::ops::ControlFlow;

use serde::Serialize;

use super::error::OptimiseError;
use super::goal::{Goal, Limit};
use super::log::Log;
use super::problem::{Problem, Values};
use super::search::{Settings, Try, best, start};
use super::starts::{Progress, named};

/// A point of a front.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrontPoint {
    /// Both goals, as measures.
    pub goals: [f64; 2],
    /// Variables from 0 to 1.
    pub x: Vec<f64>,
    /// All limits are kept.
    pub kept: bool,
}

/// A front.
#[derive(Clone, Debug, PartialEq)]
pub struct Front {
    /// Both goals.
    pub goals: [Goal; 2],
    /// The case as it was; `None` where a goal has no number.
    pub before: Option<[f64; 2]>,
    /// From the best of the first goal to the best of the second; none is worse than another one in both goals.
    pub points: Vec<FrontPoint>,
}

/// Searches the front: both ends first, then the first goal with the second held at values between the ends', each from its neighbour's
/// design and from the starts of the settings.
///
/// # Errors
/// As [`super::optimise`].
pub fn front(
    problem: &Problem,
    second: Goal,
    points: usize,
    settings: &Settings,
    log: &mut Log,
    mut watch: impl FnMut(usize, Progress) -> ControlFlow<()>,
) -> Result<Front, OptimiseError> {
    problem.reaches(second.measure)?;
    let goals = [problem.goal(), second];
    // A limit that every value keeps makes both goals known at every point.
    let open = |goal: Goal| Limit { measure: goal.measure, least: None, most: None };
    let with = |goal: Goal, limits: &[Limit]| problem.with(goal, [problem.limits(), limits].concat());
    let known = with(goals[0], &[open(second)]);
    let pair = |values: Values| Some([values.goal?, values.limits.last().copied().flatten()?]);
    let both = |x: &[f64]| pair(known.values(x));
    let mut run =
        |index: usize, problem: &Problem, from: &[Vec<f64>], log: &mut Log| -> Result<Option<Try>, OptimiseError> {
            let given = from.iter().cloned().map(Ok);
            let drawn = (0..settings.starts.max(1)).map(Err);
            let starts: Vec<_> = given
                .chain(drawn)
                .map(|one: Result<Vec<f64>, usize>| {
                    move || one.clone().unwrap_or_else(|number| start(problem, settings.seed, number))
                })
                .collect();
            let tries = named(&format!("front {index:03}"), problem, &starts, settings, log, |progress| {
                watch(index, progress)
            })?;
            Ok(best(&tries).cloned())
        };
    let count = points.max(2);
    let ends =
        [(0, goals[0]), (count - 1, second)].map(|(index, goal)| (index, with(goal, &[open(goals[0]), open(second)])));
    let mut found: Vec<(usize, Try)> = Vec::new();
    for (index, problem) in &ends {
        found.extend(run(*index, problem, &[], log)?.map(|one| (*index, one)));
    }
    let values: Vec<Option<[f64; 2]>> = found.iter().map(|(_, one)| both(&one.x)).collect();
    if let [Some([_, from]), Some([_, to])] = values.as_slice() {
        for index in 1..count - 1 {
            let bound = from + (to - from) * index as f64 / (count - 1) as f64;
            let held = if second.largest {
                Limit { least: Some(bound), ..open(second) }
            } else {
                Limit { most: Some(bound), ..open(second) }
            };
            let neighbour: Vec<Vec<f64>> = found
                .iter()
                .filter(|(at, _)| *at + 1 == index || *at == count - 1)
                .map(|(_, one)| one.x.clone())
                .collect();
            found.extend(run(index, &with(goals[0], &[held]), &neighbour, log)?.map(|one| (index, one)));
        }
    }
    found.sort_by_key(|(index, _)| *index);
    let points: Vec<FrontPoint> = found
        .into_iter()
        .filter_map(|(_, one)| Some(FrontPoint { goals: both(&one.x)?, kept: one.keeps(), x: one.x }))
        .collect();
    let points = points.iter().filter(|point| point.kept && !points.iter().any(|other| beats(goals, other, point)));
    Ok(Front { goals, before: pair(known.values_before()), points: points.cloned().collect() })
}

/// Better in one goal and no worse in the other.
fn beats(goals: [Goal; 2], one: &FrontPoint, other: &FrontPoint) -> bool {
    let order = [0, 1].map(|i| (goals[i].sign() * one.goals[i]).total_cmp(&(goals[i].sign() * other.goals[i])));
    one.kept && order.iter().all(|order| order.is_le()) && order.iter().any(|order| order.is_lt())
}
