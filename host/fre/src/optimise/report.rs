//! What came of a search: before and after, as text, JSON and a page with pictures.

use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde::Serialize;

use super::front::Front;
use super::goal::Goal;
use super::problem::{Problem, Values};
use super::search::{KEPT, Try, best};
use crate::draw::{self, Chart, Panel, Scene, Series, Style, short};
use crate::study::{pictures, run};

/// A goal before and after.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reached {
    /// Its words, as they can be given again.
    pub words: String,
    /// Its words for people, with units.
    #[serde(skip)]
    pub phrase: String,
    /// Its unit.
    pub unit: &'static str,
    /// Of the case as it was; `None` where it has no number.
    pub before: Option<f64>,
    /// Of the best design.
    pub after: Option<f64>,
    /// How much better, as a share of the number before, percent; `None` where that was 0.
    pub better_percent: Option<f64>,
}

/// A limit before and after.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "as `Reached`")]
pub struct Held {
    pub words: String,
    #[serde(skip)]
    pub phrase: String,
    pub unit: &'static str,
    pub before: Option<f64>,
    pub after: Option<f64>,
    pub kept_before: bool,
    pub kept: bool,
}

/// A variable before and after, in the file's unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "as `Variable` and `Reached`")]
pub struct Changed {
    pub key: String,
    pub before: Option<f64>,
    pub after: f64,
    pub least: f64,
    pub most: f64,
}

/// Before and after.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The goal.
    pub goal: Reached,
    /// The limits.
    pub limits: Vec<Held>,
    /// All limits are kept and the goal has a number.
    pub kept: bool,
    /// The variables.
    pub variables: Vec<Changed>,
    /// What came of every start.
    pub tries: Vec<Try>,
    /// Cases that were solved in this run.
    pub cases_solved: usize,
    /// Seconds of this run.
    pub seconds: f64,
    /// Variables of the best design, from 0 to 1.
    pub x: Vec<f64>,
}

impl Report {
    /// Of tries; `None` without any.
    pub fn of(problem: &Problem, tries: &[Try], seconds: f64) -> Option<Self> {
        let x = best(tries)?.x.clone();
        let cases_solved = problem.solved();
        let (before, after) = (problem.values_before(), problem.values(&x));
        let goal = problem.goal();
        let better = |before: f64, after: f64| 100.0 * goal.sign() * (before - after) / before.abs();
        let reached = Reached {
            words: goal.to_string(),
            phrase: goal.phrase(problem.unit()),
            unit: goal.measure.unit(),
            before: before.goal,
            after: after.goal,
            better_percent: before
                .goal
                .zip(after.goal)
                .map(|(before, after)| better(before, after))
                .filter(|percent| percent.is_finite()),
        };
        let limits: Vec<Held> = problem
            .limits()
            .iter()
            .enumerate()
            .map(|(index, limit)| {
                let at = |values: &Values| values.limits.get(index).copied().flatten();
                let keeps =
                    |value: Option<f64>| value.is_some_and(|value| limit.margins(value).all(|margin| margin >= -KEPT));
                Held {
                    words: limit.to_string(),
                    phrase: limit.phrase(problem.unit()),
                    unit: limit.measure.unit(),
                    before: at(&before),
                    after: at(&after),
                    kept_before: keeps(at(&before)),
                    kept: keeps(at(&after)),
                }
            })
            .collect();
        let numbers = problem.own_numbers().into_iter().zip(problem.numbers(&x));
        let variables = problem.variables().iter().zip(numbers).map(|(variable, (before, after))| Changed {
            key: variable.key.clone(),
            before,
            after,
            least: variable.least,
            most: variable.most,
        });
        Some(Self {
            kept: after.goal.is_some() && limits.iter().all(|limit| limit.kept),
            goal: reached,
            variables: variables.collect(),
            limits,
            tries: tries.to_vec(),
            cases_solved,
            seconds,
            x,
        })
    }

    /// Rows of a table: words, before, after, remark.
    fn rows(&self) -> Vec<[String; 4]> {
        let Reached { phrase, unit, before, after, better_percent, .. } = &self.goal;
        let better = better_percent.map_or_else(String::new, |percent| {
            format!("{:.1} % {}", percent.abs(), if percent < 0.0 { "worse" } else { "better" })
        });
        let mut rows = vec![[phrase.clone(), number(*before, unit), number(*after, unit), better]];
        for held in &self.limits {
            let state = match (held.kept_before, held.kept) {
                (_, false) => "not kept",
                (false, true) => "kept, not kept before",
                (true, true) => "kept",
            };
            let values = [held.before, held.after].map(|value| number(value, held.unit));
            let [before, after] = values;
            rows.push([held.phrase.clone(), before, after, state.to_owned()]);
        }
        for one in &self.variables {
            let bounds = format!("{} to {}", short(one.least, 6), short(one.most, 6));
            rows.push([one.key.clone(), number(one.before, ""), number(Some(one.after), ""), bounds]);
        }
        rows
    }

    /// As a table for people.
    pub fn text(&self) -> String {
        let rows = self.rows();
        let head = ["", "before", "after", ""].map(str::to_owned);
        let width =
            |column: usize| rows.iter().chain([&head]).map(|row| row[column].chars().count()).max().unwrap_or(0);
        let widths = [width(0), width(1), width(2)];
        let mut text = String::new();
        for row in core::iter::once(&head).chain(&rows) {
            let [words, before, after, remark] = row;
            let line = format!("{words:<0$}  {before:>1$}  {after:>2$}  {remark}", widths[0], widths[1], widths[2]);
            text += line.trim_end();
            text.push('\n');
        }
        let count = |count: usize, of: &str| format!("{count} {of}{}", if count == 1 { "" } else { "s" });
        let (starts, cases) = (count(self.tries.len(), "start"), count(self.cases_solved, "case"));
        text += &format!("{starts}, {cases} solved in {:.1} s\n", self.seconds);
        text
    }
}

/// A number with its unit, to five digits.
fn number(value: Option<f64>, unit: &str) -> String {
    let Some(value) = value else { return "–".to_owned() };
    let digits = if value == 0.0 { 0 } else { (4.0 - value.abs().log10().floor()).clamp(0.0, 12.0) as usize };
    format!("{} {unit}", short(value, digits)).trim_end().to_owned()
}

/// The front as a table.
pub fn front_text(problem: &Problem, front: &Front) -> String {
    let keys: Vec<&str> = problem.variables().iter().map(|variable| variable.key.as_str()).collect();
    let mut rows = vec![
        [
            front.goals.map(|goal| goal.phrase(problem.unit())).to_vec(),
            keys.iter().map(|&key| key.to_owned()).collect(),
        ]
        .concat(),
    ];
    let cells = |goals: [f64; 2], numbers: Vec<f64>| -> Vec<String> {
        let goals = [0, 1].map(|i| number(Some(goals[i]), front.goals[i].measure.unit()));
        goals.into_iter().chain(numbers.into_iter().map(|value| number(Some(value), ""))).collect()
    };
    rows.extend(front.points.iter().map(|point| cells(point.goals, problem.numbers(&point.x))));
    let widths: Vec<usize> = (0..rows[0].len())
        .map(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0))
        .collect();
    let mut text = String::new();
    for row in rows {
        let line: Vec<String> = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:>width$}")).collect();
        text += line.join("  ").trim_end();
        text.push('\n');
    }
    if let Some([first, second]) = front.before {
        let [a, b] = front.goals.map(|goal| goal.measure.unit());
        text += &format!("before: {}, {}\n", number(Some(first), a), number(Some(second), b));
    }
    text
}

/// The front as a picture.
pub fn front_picture(problem: &Problem, front: &Front) -> Scene {
    let axis = |goal: Goal| {
        let (unit, words) = (goal.measure.unit(), goal.phrase(problem.unit()));
        draw::literal(&if unit.is_empty() { words } else { format!("{words} ({unit})") })
    };
    let series = |name: &str, colour: u8, style: Style, points: Vec<[f64; 2]>| Series {
        name: name.to_owned(),
        colour,
        style,
        points,
    };
    let points = front.points.iter().map(|point| [point.goals[1], point.goals[0]]).collect();
    let mut all = vec![series("best designs", 0, Style::LineAndDots, points)];
    all.extend(front.before.map(|[first, second]| series("before", 1, Style::Dots, vec![[second, first]])));
    let mut chart = Chart::new("Front of two goals", "no design is better in both", axis(front.goals[1]));
    chart.panels.push(Panel { y_title: axis(front.goals[0]), series: all, ..Panel::default() });
    chart.scene()
}

/// Finger and force over the motion before and after, for one of the objects; `None` where nothing can be drawn.
pub fn pictures_of(problem: &Problem, x: &[f64], object: usize) -> [Option<Scene>; 2] {
    [problem.drawn(None, object), problem.drawn(Some(x), object)].map(|case| {
        let case = case?;
        let solved = run::solve(&case, problem.options()).ok()?;
        pictures::overview(&case, &solved)
    })
}

/// The report as one page that needs nothing else.
pub fn page(problem: &Problem, report: &Report, front: Option<&Front>) -> String {
    let title = format!("A finger with the {}", report.goal.phrase);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(crate::study::table1::STYLE)) }
            }
            body {
                main {
                    h1 { (title) }
                    p { @if report.kept { "All limits are kept." } @else { b.bad { "No start keeps all limits." } } }
                    div.wide { table {
                        thead { tr { th {} th { "before" } th { "after" } th {} } }
                        tbody { @for row in report.rows() { tr { @for cell in row { td { (cell) } } } } }
                    } }
                    @if let Some(front) = front {
                        h2 { "The front of two goals" }
                        figure { (PreEscaped(draw::svg_in_page(&front_picture(problem, front), "front-"))) }
                        pre.wide { (front_text(problem, front)) }
                    }
                    @for object in 0..problem.objects() { (objects(problem, &report.x, object)) }
                }
            }
        }
    }
    .into_string()
}

/// Pictures of an object, side by side where there is room.
fn objects(problem: &Problem, x: &[f64], object: usize) -> Markup {
    // The pictures name finger and object.
    html! {
        h2 { "Before and after" @if problem.objects() > 1 { ", object " (object + 1) } }
        div.fingers {
            @for (word, scene) in ["before", "after"].into_iter().zip(pictures_of(problem, x, object)) {
                figure {
                    @if let Some(scene) = scene { (PreEscaped(draw::svg_in_page(&scene, &format!("{word}{object}-")))) }
                    @else { p.bad { "There is no trustworthy solution to draw." } }
                    figcaption { (word) }
                }
            }
        }
    }
}
